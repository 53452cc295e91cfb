//! Properties P3.5 to P3.8 of the extraction on random cells and factors (CPU forms; the device
//! forms are in `tests/`).

use std::collections::HashSet;

use proptest::prelude::*;

use super::cpu::{Extractor, Threads};
use super::{Cells, FULL, MAX_CELL, Ranges, kept, reference, validate};

fn config() -> ProptestConfig {
    let cases = std::env::var("PROPTEST_CASES").ok().and_then(|v| v.parse().ok()).unwrap_or(32);
    ProptestConfig { cases, ..ProptestConfig::default() }
}

/// A few cells, many of them empty or of one leaf, with factors that are often 0 or 1.
fn crown() -> impl Strategy<Value = (Cells, Vec<u32>)> {
    let size = prop_oneof![Just(0_u32), Just(1), 2..40_u32, 100..3_000_u32];
    let factor = prop_oneof![Just(0), Just(FULL), Just(1), 0..=FULL];
    (any::<u64>(), prop::collection::vec((size, factor), 0..80)).prop_map(|(seed, cells)| {
        let (sizes, q): (Vec<u32>, Vec<u32>) = cells.into_iter().unzip();
        (Cells::with_sizes(seed, &sizes).unwrap(), q)
    })
}

fn set(ranges: &Ranges) -> HashSet<u32> {
    ranges.indices.iter().copied().collect()
}

proptest! {
    #![proptest_config(config())]

    /// P3.5, one cell of any size: monotone, 0 at 0, n at 1, never past n.
    #[test]
    fn kept_is_monotone(n in 0..=MAX_CELL, a in 0..=FULL, b in 0..=FULL) {
        let (low, high) = (a.min(b), a.max(b));
        prop_assert!(kept(n, low) <= kept(n, high));
        prop_assert!(kept(n, high) <= n);
        prop_assert_eq!((kept(n, 0), kept(n, FULL)), (0, n));
    }

    /// P3.5, sets: what is kept at lower factors is kept at higher ones.
    #[test]
    fn kept_sets_nest((cells, q) in crown(), scale in 0.0..=1.0_f64) {
        let lower: Vec<u32> = q.iter().map(|&q| (f64::from(q) * scale) as u32).collect();
        let small = set(&reference::extract(&cells, &lower).unwrap());
        let large = set(&reference::extract(&cells, &q).unwrap());
        prop_assert!(small.is_subset(&large));
        let none = reference::extract(&cells, &vec![0; q.len()]).unwrap();
        prop_assert!(none.indices.is_empty());
        let all = reference::extract(&cells, &vec![FULL; q.len()]).unwrap();
        prop_assert_eq!(set(&all).len(), 4 * cells.leaf_ids.len());
    }

    /// P3.6 and P3.7: the ranges tile, and hold the prefixes.
    #[test]
    fn ranges_tile_and_hold_the_prefixes((cells, q) in crown()) {
        let ranges = reference::extract(&cells, &q).unwrap();
        let stats = validate(&ranges, &cells, &q).unwrap();
        let sum: u32 = cells.sizes().zip(&q).map(|(n, &q)| kept(n, q)).sum();
        prop_assert_eq!(stats.leaves_kept, sum as usize);
    }

    /// P3.8 on the CPU, with what an earlier frame left in the buffers.
    #[test]
    fn cpu_forms_are_bit_equal((cells, q) in crown()) {
        let expected = reference::extract(&cells, &q).unwrap();
        for threads in [Threads::Single, Threads::Pool] {
            let mut extractor = Extractor::new(&cells, threads).unwrap();
            extractor.extract(&cells, &vec![FULL; q.len()]).unwrap();
            let view = extractor.extract(&cells, &q).unwrap();
            validate(view, &cells, &q).unwrap();
            prop_assert_eq!(view.offsets, &expected.offsets[..]);
            prop_assert_eq!(view.indices, &expected.indices[..]);
        }
    }

    /// Changing any one word of a result is noticed.
    #[test]
    fn any_single_wrong_word_is_refused((cells, q) in crown(), at in any::<usize>(), bit in 0..32) {
        let mut ranges = reference::extract(&cells, &q).unwrap();
        let words = ranges.offsets.len() + ranges.indices.len();
        let at = at % words;
        let word = match at.checked_sub(ranges.offsets.len()) {
            None => &mut ranges.offsets[at],
            Some(at) => &mut ranges.indices[at],
        };
        *word ^= 1_u32 << bit;
        prop_assert!(validate(&ranges, &cells, &q).is_err());
    }
}
