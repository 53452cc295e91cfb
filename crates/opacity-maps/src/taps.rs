//! Which texels a receiver reads.

use crate::{Receiver, Taps};

/// A texel read, and where its centre lies from the receiver, in map coordinates: what the texel
/// stores was found there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tap {
    /// Index of the texel, row-major.
    pub texel: usize,
    /// Map coordinates to the right of the receiver.
    pub du: f32,
    /// Map coordinates below the receiver.
    pub dv: f32,
}

/// Most taps of any kind.
pub const MOST: usize = 16;

/// The taps of a receiver inside the map, all of weight 1 / n: their number n is returned. Beyond
/// the border the border's texel is read.
pub fn taps(
    kind: Taps,
    receiver: &Receiver,
    width: u32,
    height: u32,
    out: &mut [Tap; MOST],
) -> usize {
    let mut n = 0;
    let mut push = |dx: f32, dy: f32| {
        let texel = texel_at(receiver, dx, dy, width, height);
        let (row, column) = (texel / width as usize, texel % width as usize);
        let centre = |place: usize, size: u32| (place as f32 + 0.5) / size as f32;
        let (du, dv) = (centre(column, width) - receiver.u, centre(row, height) - receiver.v);
        out[n] = Tap { texel, du, dv };
        n += 1;
    };
    match kind {
        Taps::One => push(0.0, 0.0),
        Taps::Box3 => grid(3).for_each(|(dx, dy)| push(dx, dy)),
        Taps::Box4 => grid(4).for_each(|(dx, dy)| push(dx, dy)),
        Taps::Stochastic16 => {
            let mut state = hash(receiver.u.to_bits() ^ hash(receiver.v.to_bits()));
            for (dx, dy) in grid(4) {
                state = hash(state);
                let jitter = |bits: u32| (bits & 0xffff) as f32 / 65536.0 - 0.5;
                push(dx + jitter(state), dy + jitter(state >> 16));
            }
        }
    }
    n
}

/// The texel a receiver inside the map lies in.
pub fn own(receiver: &Receiver, width: u32, height: u32) -> usize {
    texel_at(receiver, 0.0, 0.0, width, height)
}

/// The texel `dx`, `dy` texels from a receiver, the border's beyond the border.
fn texel_at(receiver: &Receiver, dx: f32, dy: f32, width: u32, height: u32) -> usize {
    let place = |t: f32, d: f32, size: u32| {
        (t * size as f32 + d).floor().clamp(0.0, (size - 1) as f32) as usize
    };
    place(receiver.v, dy, height) * width as usize + place(receiver.u, dx, width)
}

/// Offsets of an n x n box, centred, row by row.
fn grid(n: usize) -> impl Iterator<Item = (f32, f32)> {
    let middle = 0.5 * (n - 1) as f32;
    (0..n * n).map(move |i| ((i % n) as f32 - middle, (i / n) as f32 - middle))
}

/// A 32-bit integer hash (Jarzynski and Olano, Hash Functions for GPU Rendering, JCGT 2020: PCG).
pub fn hash(value: u32) -> u32 {
    let state = value.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    (word >> 22) ^ word
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn taps_surround_the_receiver_and_stay_in_the_map() {
        let mut out = [Tap { texel: 0, du: 0.0, dv: 0.0 }; MOST];
        let middle = Receiver::at(0.5 + 1.0 / 32.0, 0.5 + 1.0 / 32.0, 0.5);
        assert_eq!(taps(Taps::One, &middle, 16, 16, &mut out), 1);
        assert_eq!(out[0].texel, 8 * 16 + 8);
        assert_eq!(own(&middle, 16, 16), 8 * 16 + 8);
        assert_eq!(taps(Taps::Box3, &middle, 16, 16, &mut out), 9);
        assert_eq!(out[4].texel, 8 * 16 + 8);
        let mut rows: Vec<usize> = out[..9].iter().map(|t| t.texel / 16).collect();
        rows.sort_unstable();
        assert_eq!(rows, [7, 7, 7, 8, 8, 8, 9, 9, 9]);
        for kind in [Taps::Box4, Taps::Stochastic16] {
            assert_eq!(taps(kind, &middle, 16, 16, &mut out), 16);
            let mean: f32 = out.iter().map(|t| t.du).sum::<f32>() / 16.0;
            assert!(mean.abs() <= 0.5 / 16.0 + 1e-6, "{kind:?} {mean}");
        }
        // Distances are to the texel's centre, wherever in the texel the receiver lies.
        let aside = Receiver::at(0.51, 0.53, 0.5);
        taps(Taps::One, &aside, 16, 16, &mut out);
        assert_eq!((out[0].du, out[0].dv), (8.5 / 16.0 - 0.51, 8.5 / 16.0 - 0.53));
        for (u, v) in [(0.0, 0.0), (1.0, 1.0), (1.0, 0.0)] {
            let n = taps(Taps::Box4, &Receiver::at(u, v, 0.5), 5, 7, &mut out);
            assert!(out[..n].iter().all(|t| t.texel < 35));
        }
    }
}
