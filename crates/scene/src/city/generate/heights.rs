//! How many storeys the buildings of a block have.

use super::Heights;
use rand::RngExt;
use rand::seq::SliceRandom;
use rand_pcg::Pcg64;

/// Storeys of every lot of a block; 0 for `empty` of them.
pub fn storeys(law: Heights, lots: usize, empty: usize, rng: &mut Pcg64) -> Vec<u32> {
    let built = lots.saturating_sub(empty);
    let mut storeys: Vec<u32> = match law {
        Heights::Fixed(storeys) => vec![storeys; built],
        Heights::Stratified { least, most } => stratified(least, most, built),
        Heights::Independent { least, most } => {
            (0..built).map(|_| rng.random_range(least..=most)).collect()
        }
    };
    storeys.resize(lots, 0);
    storeys.shuffle(rng);
    storeys
}

/// Every number equally often; the remainder at the middles of equal parts of the range, so that
/// it leaves the mean alone.
fn stratified(least: u32, most: u32, count: usize) -> Vec<u32> {
    let range = (most - least + 1) as usize;
    let (each, rest) = (count / range, count % range);
    let all = (0..each).flat_map(|_| least..=most);
    all.chain((0..rest).map(|i| least + ((2 * i + 1) * range / (2 * rest)) as u32)).collect()
}

/// Empty lots of block `index` when `share` of all lots are empty: rounded over all blocks so far,
/// so that the city's share is right to one lot.
pub fn empty_lots(share: f64, lots: usize, index: usize) -> usize {
    let until = |blocks: usize| (share * (blocks * lots) as f64).round() as usize;
    until(index + 1) - until(index)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stratified_block_has_the_mean_and_variance_of_the_law() {
        let block = stratified(1, 7, 44);
        let mean = block.iter().sum::<u32>() as f64 / 44.0;
        let variance = block.iter().map(|&h| (f64::from(h) - mean).powi(2)).sum::<f64>() / 44.0;
        assert_eq!((mean, variance), (4.0, 4.0));
        for count in 0..50 {
            let block = stratified(3, 8, count);
            assert_eq!(block.len(), count);
            assert!(block.iter().all(|h| (3..=8).contains(h)));
            let mean = block.iter().sum::<u32>() as f64 / count.max(1) as f64;
            assert!(count == 0 || (mean - 5.5).abs() <= 0.5 + 1e-12, "{count}: {mean}");
        }
    }

    #[test]
    fn empty_lots_add_up() {
        for share in [0.0, 0.01, 0.25, 0.3, 0.5] {
            let total: usize = (0..36).map(|i| empty_lots(share, 44, i)).sum();
            assert!((total as f64 - share * 1584.0).abs() <= 0.5, "{share}: {total}");
        }
    }
}
