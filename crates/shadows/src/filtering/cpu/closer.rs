//! Based on: William T. Reeves, David H. Salesin, Robert L. Cook, "Rendering antialiased shadows
//! with depth maps", SIGGRAPH 1987, section 3.
//!
//! Deviations: every texel of the window, or one in the middle of each stratum, instead of random
//! samples; the four windows of a bilinear lookup are read as one window a texel wider.

use super::super::kernel::Kernel;
use super::super::lookup::{Footprint, biased_depth, slopes};
use super::super::{Lookup, Receiver};
use super::Filter;

/// Taps along one axis.
#[derive(Debug)]
pub struct CloserTaps {
    nearest: Vec<Tap>,
    bilinear: Vec<Tap>,
}

/// Offset from the first texel of the footprint, weight in the first texel's window and in the
/// second's.
#[derive(Clone, Copy, Debug)]
struct Tap {
    offset: i32,
    first: f32,
    second: f32,
}

impl CloserTaps {
    pub fn new(kernel: &Kernel, taps: u32) -> Self {
        let taps = kernel.taps(taps);
        let single =
            |&(offset, weight): &(i32, f64)| Tap { offset, first: weight as f32, second: 0.0 };
        let nearest: Vec<Tap> = taps.iter().map(single).collect();
        let mut bilinear: Vec<Tap> = Vec::with_capacity(2 * taps.len());
        for tap in &nearest {
            // Offsets ascend: the second window's tap can only meet the last one pushed.
            match bilinear.last_mut() {
                Some(last) if last.offset == tap.offset => last.first = tap.first,
                _ => bilinear.push(*tap),
            }
            bilinear.push(Tap { offset: tap.offset + 1, first: 0.0, second: tap.first });
        }
        Self { nearest, bilinear }
    }

    /// How many texels are read along one axis.
    pub fn along_one_axis(&self, bilinear: bool) -> usize {
        if bilinear { self.bilinear.len() } else { self.nearest.len() }
    }
}

impl Filter {
    /// Weighted mean of the comparisons around a receiver that is in the map.
    pub(super) fn closer_filtered(
        &self,
        depths: &[f32],
        receiver: &Receiver,
        footprint: &Footprint,
    ) -> f32 {
        let (width, height) = (self.width as i32, self.height as i32);
        let z = biased_depth(receiver, &self.settings, width as u32, height as u32);
        let (du, dv) = if self.settings.plane_bias { slopes(receiver) } else { (0.0, 0.0) };
        let taps = match self.settings.lookup {
            Lookup::Nearest => &self.taps.nearest,
            Lookup::Bilinear => &self.taps.bilinear,
        };
        // An empty texel hides nothing, also where the plane runs past the far plane.
        let farthest = z.max(1.0);
        let mut sum = 0.0;
        for row in taps {
            let y = (footprint.y0 as i32 + row.offset).clamp(0, height - 1);
            let line = &depths[(y * width) as usize..((y + 1) * width) as usize];
            let z_row = z + dv * ((y as f32 + 0.5) / height as f32 - receiver.v);
            let mut row_sum = 0.0;
            for tap in taps {
                let x = (footprint.x0 as i32 + tap.offset).clamp(0, width - 1);
                let plane = z_row + du * ((x as f32 + 0.5) / width as f32 - receiver.u);
                let plane = plane.min(farthest);
                let weight = tap.first + footprint.fx * (tap.second - tap.first);
                row_sum += if line[x as usize] < plane { 0.0 } else { weight };
            }
            sum += row_sum * (row.first + footprint.fy * (row.second - row.first));
        }
        sum.clamp(0.0, 1.0)
    }
}
