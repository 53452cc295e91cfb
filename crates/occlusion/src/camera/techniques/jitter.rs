//! Random spans of assumed visibility.

/// A number of frames in `0..=most`, each as likely: the same for the same seed, node and frame.
pub(super) fn span(seed: u64, node: u32, frame: u32, most: u32) -> u32 {
    let hash = finalise(finalise(seed) ^ (u64::from(node) << 32 | u64::from(frame)));
    ((u128::from(hash) * (u128::from(most) + 1)) >> 64) as u32
}

/// The finaliser of SplitMix64, one to one.
fn finalise(seed: u64) -> u64 {
    let mut z = seed.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ z >> 31
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_span_is_as_likely_whatever_the_node_frame_or_seed() {
        for vary in 0..3 {
            let mut counts = [0u32; 6];
            for i in 0..60_000u32 {
                let of = |this: usize| if this == vary { i } else { 5 };
                counts[span(u64::from(of(0)), of(1), of(2), 5) as usize] += 1;
            }
            // 10,000 each, standard deviation 91.
            assert!(counts.iter().all(|c| c.abs_diff(10_000) < 500), "{counts:?}");
        }
    }

    #[test]
    fn spans_keep_to_their_range() {
        for most in [0, 1, 60, u32::MAX] {
            assert!((0..1000).all(|i| span(1, i, i, most) <= most));
        }
        assert!((0..1000).any(|i| span(1, i, 0, u32::MAX) > u32::MAX / 2));
    }
}
