//! Stratified points of the unit square.

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg32;

/// One random point in each cell of an n × n grid over 0..1 x 0..1, row by row.
pub fn stratified(n: u32, seed: u64) -> impl Iterator<Item = (f64, f64)> {
    let mut rng = Pcg32::seed_from_u64(seed);
    let step = 1.0 / f64::from(n);
    (0..n).flat_map(move |y| (0..n).map(move |x| (x, y))).map(move |(x, y)| {
        let (jitter_x, jitter_y) = (rng.random::<f64>(), rng.random::<f64>());
        ((f64::from(x) + jitter_x) * step, (f64::from(y) + jitter_y) * step)
    })
}

/// A seed of its own for element `index` of a batch, so that results do not depend on the order in
/// which elements are worked on.
pub fn seed_of(seed: u64, index: usize) -> u64 {
    // SplitMix64's finaliser.
    let mut z = seed ^ (index as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_cell_has_one_point() {
        let points: Vec<_> = stratified(7, 3).collect();
        assert_eq!(points.len(), 49);
        for (i, (x, y)) in points.into_iter().enumerate() {
            assert_eq!(((x * 7.0) as usize, (y * 7.0) as usize), (i % 7, i / 7));
        }
        assert!(stratified(4, 1).ne(stratified(4, 2)));
    }
}
