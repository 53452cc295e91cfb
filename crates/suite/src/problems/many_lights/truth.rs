//! The exact sums, at a seeded subset of each frame's pixels.

use crate::truth_cache::TruthCache;
use dapple_many_lights::{World, sample::hash};
use glam::DVec3;
use rayon::prelude::*;

/// Changes with whatever changes the truth's values.
const TRUTH_VERSION: u32 = 2;

/// What some pixels of every frame should show.
#[derive(Clone, Debug, Default)]
pub struct Truth {
    /// By frame: pixels in increasing order, and their radiance.
    frames: Vec<Vec<(u32, DVec3)>>,
}

impl Truth {
    /// Sums up all lights at no more than `most` pixels of each frame, or reads what was summed
    /// before under `key`, which names everything that the world depends on.
    pub fn of(key: &str, world: &World, most: usize, seed: u64) -> Self {
        let key = format!("many-lights v{TRUTH_VERSION} {key} most {most} seed {seed}");
        let chosen: Vec<_> =
            (0..world.frames.len()).map(|frame| chosen(world, frame, most, seed)).collect();
        let compute = || {
            let sums = chosen.iter().zip(&world.frames).flat_map(|(pixels, frame)| {
                let sum = |pixel: &u32| world.truth(&frame.points[*pixel as usize]);
                pixels.par_iter().map(sum).collect::<Vec<_>>()
            });
            sums.flat_map(|sum| sum.to_array()).flat_map(words).collect()
        };
        let count = 6 * chosen.iter().map(Vec::len).sum::<usize>();
        let mut stored = TruthCache::from_environment().words(&key, compute);
        if stored.len() != count {
            // Damaged: not used.
            stored = compute();
        }
        let mut values = stored.as_chunks::<6>().0.iter().map(|w| {
            let value = |at: usize| f64::from_bits(u64::from(w[at]) << 32 | u64::from(w[at + 1]));
            DVec3::new(value(0), value(2), value(4))
        });
        let frame = |pixels: Vec<u32>| pixels.into_iter().zip(values.by_ref()).collect();
        Self { frames: chosen.into_iter().map(frame).collect() }
    }

    /// Pixels of a frame, and what they should show.
    pub fn frame(&self, frame: usize) -> impl Iterator<Item = (u32, DVec3)> + '_ {
        self.frames[frame].iter().copied()
    }

    /// Truth that is known.
    #[cfg(test)]
    pub fn given(frames: Vec<Vec<(u32, DVec3)>>) -> Self {
        Self { frames }
    }

    /// Pixels over all frames.
    pub fn pixels(&self) -> usize {
        self.frames.iter().map(Vec::len).sum()
    }
}

fn words(value: f64) -> [u32; 2] {
    let bits = value.to_bits();
    [(bits >> 32) as u32, bits as u32]
}

/// Pixels of a frame that show anything: all of them, or those of the least hashes.
fn chosen(world: &World, frame: usize, most: usize, seed: u64) -> Vec<u32> {
    let points = &world.frames[frame].points;
    let there = (0..points.len() as u32).filter(|pixel| points[*pixel as usize].is_there());
    let of_seed = hash(seed as u32 ^ hash((seed >> 32) as u32 ^ hash(frame as u32)));
    let mut pixels: Vec<(u32, u32)> = there.map(|pixel| (hash(pixel ^ of_seed), pixel)).collect();
    pixels.sort_unstable();
    pixels.truncate(most);
    let mut pixels: Vec<u32> = pixels.into_iter().map(|(_, pixel)| pixel).collect();
    pixels.sort_unstable();
    pixels
}

#[cfg(test)]
mod tests {
    use super::*;
    use dapple_many_lights::{
        Emission,
        worlds::{Cloud, cloud},
    };

    fn world() -> World {
        let emissions = vec![Emission::Omni];
        let size = [24, 18];
        let origin = DVec3::ZERO;
        cloud(&Cloud { lights: 5, emissions, seed: 3, size, frames: 2, origin }).world
    }

    #[test]
    fn a_subset_is_the_same_for_a_seed_and_holds_no_sky() {
        let world = world();
        let some = chosen(&world, 1, 50, 7);
        assert_eq!(some.len(), 50);
        assert_eq!(some, chosen(&world, 1, 50, 7));
        assert_ne!(some, chosen(&world, 1, 50, 8));
        assert!(some.is_sorted());
        assert!(some.iter().all(|p| world.frames[1].points[*p as usize].is_there()));
        let all = chosen(&world, 1, usize::MAX, 7);
        assert!(all.len() > 50 && some.iter().all(|p| all.contains(p)));
    }

    #[test]
    fn what_was_summed_is_what_is_read_again() {
        let world = world();
        let key = format!("test of the truth {}", std::process::id());
        let truth = Truth::of(&key, &world, 20, 0);
        assert_eq!(truth.pixels(), 40);
        for frame in 0..2 {
            for (pixel, sum) in truth.frame(frame) {
                assert_eq!(sum, world.truth(&world.frames[frame].points[pixel as usize]));
            }
        }
    }
}
