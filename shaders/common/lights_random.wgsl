// Random numbers that every form draws alike: crates/many-lights/src/sample/random.rs.
#import common/hash.wgsl

var<private> random_state: u32;

// Starts the stream of a pixel in a frame under a seed.
fn start_random(seed: u32, frame_index: u32, pixel: u32) {
    random_state = hash(pixel ^ hash(frame_index ^ hash(seed)));
}

// The next 32 bits.
fn random_bits() -> u32 {
    random_state = hash(random_state);
    return random_state;
}

// The next number in 0..1, a multiple of 2^-24.
fn random_unit() -> f32 {
    return f32(random_bits() >> 8u) * (1.0 / 16777216.0);
}
