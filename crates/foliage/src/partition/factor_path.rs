//! Level-of-detail factors over a path of frames.

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::Cells;

/// A camera on an orbit that recedes and returns: cells that face it keep their leaves, those
/// behind lose them all. It stands in for the visibility tables of the whole technique.
///
/// Frame 0 keeps everything and the frame in the middle nothing, exactly; all others change
/// smoothly, between them and from the last frame back to frame 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FactorPath {
    /// Where the cells lie around the crown.
    pub seed: u64,
    /// Frames in the path; may be 0.
    pub frames: u32,
}

impl FactorPath {
    /// One factor in `0..=1` for each cell at `frame`, which wraps around the path.
    #[must_use]
    pub fn factors(&self, cells: &Cells, frame: u32) -> Vec<f32> {
        let mut out = Vec::new();
        self.factors_into(cells, frame, &mut out);
        out
    }

    /// As [`FactorPath::factors`], into a vector that keeps its capacity.
    pub fn factors_into(&self, cells: &Cells, frame: u32, out: &mut Vec<f32>) {
        let frames = self.frames.max(1);
        let frame = frame % frames;
        out.clear();
        if frame == 0 || (frames > 1 && frame == frames / 2) {
            out.resize(cells.len(), if frame == 0 { 1.0 } else { 0.0 });
            return;
        }
        let turn = std::f64::consts::TAU * f64::from(frame) / f64::from(frames);
        let (sin, cos) = turn.sin_cos();
        let (height, ground) = (0.4 * sin, (1.0 - 0.16 * sin * sin).sqrt());
        let towards_camera = [ground * cos, height, ground * sin];
        // 1 at the start of the orbit, 0.3 at its far end.
        let near = 0.65 + 0.35 * cos;
        let mut rng = Pcg64Mcg::seed_from_u64(self.seed);
        out.extend((0..cells.len()).map(|_| {
            let direction = unit_vector(&mut rng);
            let facing: f64 = direction.iter().zip(towards_camera).map(|(a, b)| a * b).sum();
            // Saturates, so that exact 0 and 1 stand among the others.
            (near * (0.5 + facing).clamp(0.0, 1.0) * 1.05).min(1.0) as f32
        }));
    }
}

/// Uniform on the sphere: uniform height, uniform angle (Archimedes).
fn unit_vector(rng: &mut Pcg64Mcg) -> [f64; 3] {
    let y = 2.0 * rng.random::<f64>() - 1.0;
    let (sin, cos) = (std::f64::consts::TAU * rng.random::<f64>()).sin_cos();
    let r = (1.0 - y * y).sqrt();
    [r * cos, y, r * sin]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_path_is_full_then_smooth_then_empty_then_smooth() {
        let cells = Cells::generate(1, 1_000, 400).unwrap();
        let path = FactorPath { seed: 4, frames: 120 };
        assert!(path.factors(&cells, 0).iter().all(|&f| f == 1.0));
        assert!(path.factors(&cells, 60).iter().all(|&f| f == 0.0));
        assert_eq!(path.factors(&cells, 7), path.factors(&cells, 127));
        assert_ne!(path.factors(&cells, 7), path.factors(&cells, 8));
        let mut previous = path.factors(&cells, 119);
        for frame in (1..60).chain(61..120) {
            let now = path.factors(&cells, frame);
            let (mut zeros, mut between) = (0, 0);
            for (a, b) in now.iter().zip(&previous) {
                assert!((0.0..=1.0).contains(a));
                // Neighbours on the path: a step of 2 pi / 120 moves a factor by at most 0.1,
                // two steps (the empty frame is left out) by 0.2.
                assert!((a - b).abs() < 0.25, "frame {frame}: {b} to {a}");
                zeros += usize::from(*a == 0.0);
                between += usize::from(*a > 0.0 && *a < 1.0);
            }
            assert!(zeros > 20 && between > 100, "frame {frame}: {zeros} zeros");
            previous = now;
        }
        assert!(path.factors(&cells, 1).contains(&1.0));
    }

    #[test]
    fn short_paths_and_no_cells() {
        let cells = Cells::generate(1, 10, 5).unwrap();
        for frames in [0, 1] {
            let path = FactorPath { seed: 4, frames };
            assert_eq!(path.factors(&cells, 3), [1.0; 5]);
        }
        let two = FactorPath { seed: 4, frames: 2 };
        assert_eq!(two.factors(&cells, 1), [0.0; 5]);
        let none = Cells { starts: vec![0], leaf_ids: vec![] };
        assert!(FactorPath { seed: 4, frames: 9 }.factors(&none, 2).is_empty());
    }
}
