//! Random numbers that every form draws alike.
//!
//! Based on: Mark Jarzynski and Marc Olano, "Hash functions for GPU rendering", 2020 (PCG), as in
//! `common/hash.wgsl`: a hash of seed, frame and pixel starts a stream, and each number is the hash of
//! the one before it.

/// One step of PCG with its output permutation.
pub fn hash(value: u32) -> u32 {
    let state = value.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    (word >> 22) ^ word
}

/// A stream of random numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Random {
    state: u32,
}

impl Random {
    /// The stream of a pixel in a frame under a seed.
    pub fn new(seed: u32, frame: u32, pixel: u32) -> Self {
        Self { state: hash(pixel ^ hash(frame ^ hash(seed))) }
    }

    /// The next 32 bits.
    pub fn bits(&mut self) -> u32 {
        self.state = hash(self.state);
        self.state
    }

    /// The next number in 0..1, a multiple of 2^-24: the same in f32 and f64.
    pub fn unit(&mut self) -> f32 {
        (self.bits() >> 8) as f32 * (1.0 / 16_777_216.0)
    }
}
