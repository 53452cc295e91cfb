//! Split depths against the formula, and where it loses its digits.

use dapple_shadows::cascades::{
    CascadeError, MAX_CASCADES, logarithmic_split, splits, uniform_split,
};
use proptest::prelude::*;

#[test]
fn splits_by_hand() {
    // Logarithmic 10 and uniform 50.5, half of each.
    assert_eq!(splits(1.0, 100.0, 1, 0.5).unwrap(), [1.0, 100.0]);
    let two = splits(1.0, 100.0, 2, 0.5).unwrap();
    assert_eq!((two[0], two[2]), (1.0, 100.0));
    assert!((two[1] - 30.25).abs() < 1e-12, "{two:?}");
    assert_eq!(splits(2.0, 10.0, 4, 0.0).unwrap(), [2.0, 4.0, 6.0, 8.0, 10.0]);
    let log = splits(1.0, 1000.0, 3, 1.0).unwrap();
    for (got, want) in log.iter().zip([1.0, 10.0, 100.0, 1000.0]) {
        assert!((got / want - 1.0).abs() < 1e-14, "{log:?}");
    }
}

#[test]
fn lambda_0_and_1_are_the_two_schemes_to_the_bit() {
    let mut different = 0;
    for (near, far) in [(0.1, 500.0), (1.0, 3.0), (1e-3, 1e3), (7.0, 7.1)] {
        for count in 1..=MAX_CASCADES {
            let uniform = splits(near, far, count, 0.0).unwrap();
            let logarithmic = splits(near, far, count, 1.0).unwrap();
            for i in 1..count {
                assert_eq!(uniform[i].to_bits(), uniform_split(near, far, i, count).to_bits());
                let log = logarithmic_split(near, far, i, count);
                assert_eq!(logarithmic[i].to_bits(), log.to_bits());
                // Against the formula as it is printed.
                let share = i as f64 / count as f64;
                assert!((log / (near * (far / near).powf(share)) - 1.0).abs() < 1e-13);
                different += usize::from(uniform[i] != logarithmic[i]);
            }
        }
    }
    assert!(different > 50, "{different}");
}

#[test]
fn logarithmic_becomes_uniform_as_far_comes_to_near() {
    let near = 3.0f64;
    for exponent in [2, 4, 6, 9, 12] {
        let width = 10f64.powi(-exponent);
        let far = near * (1.0 + width);
        let spacing = far - near;
        for i in 1..4 {
            // In shares of the range, so that the digits left are seen.
            let share = |depth: f64| (depth - near) / spacing;
            let (log, uniform) =
                (logarithmic_split(near, far, i, 4), uniform_split(near, far, i, 4));
            // The series: the two differ by less than width / 8, and by what f64 cannot hold.
            let rounding = 4.0 * f64::EPSILON * near / spacing;
            assert!((share(log) - share(uniform)).abs() < width / 8.0 + rounding, "{width}");
        }
    }
}

#[test]
fn ranges_without_room_are_refused_and_never_collapse() {
    let near = 1.0f64;
    let next = near.next_up();
    assert_eq!(splits(near, next, 1, 0.5).unwrap(), [near, next]);
    for lambda in [0.0, 0.5, 1.0] {
        let refused = splits(near, next, 2, lambda);
        assert_eq!(refused, Err(CascadeError::Narrow { near, far: next, count: 2 }));
    }
}

#[test]
fn bad_input_is_refused_by_name() {
    for count in [0, MAX_CASCADES + 1] {
        assert_eq!(splits(1.0, 2.0, count, 0.5), Err(CascadeError::Count { count }));
    }
    let (nan, infinite) = (f64::NAN, f64::INFINITY);
    for (near, far) in [
        (0.0, 1.0),
        (-1.0, 1.0),
        (1.0, 1.0),
        (2.0, 1.0),
        (nan, 1.0),
        (1.0, nan),
        (1.0, infinite),
        (infinite, infinite),
        (1e-300, 1e300),
    ] {
        let refused = splits(near, far, 2, 0.5);
        assert!(matches!(refused, Err(CascadeError::Range { .. })), "{near} {far}");
    }
    for lambda in [-1e-9, 1.0 + 1e-9, nan, infinite] {
        let refused = splits(1.0, 2.0, 2, lambda);
        assert!(matches!(refused, Err(CascadeError::Knob { name: "lambda", .. })), "{lambda}");
    }
    let text = splits(0.0, 1.0, 2, 0.5).unwrap_err().to_string();
    assert_eq!(text, "near 0 and far 1 must be finite, with 0 < near < far and a finite ratio");
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(256) })]

    #[test]
    fn splits_increase_between_exact_ends(
        near in 1e-3..1e3f64,
        ratio in prop_oneof![1.0 + 1e-9..1.001f64, 1.001..10.0f64, 10.0..1e6f64],
        count in 1..=MAX_CASCADES,
        lambda in 0.0..=1.0f64,
    ) {
        let far = near * ratio;
        let depths = splits(near, far, count, lambda).unwrap();
        prop_assert_eq!(depths.len(), count + 1);
        prop_assert_eq!((depths[0], depths[count]), (near, far));
        prop_assert!(depths.windows(2).all(|pair| pair[0] < pair[1]));
        // A larger lambda cuts nearer.
        let nearer = splits(near, far, count, 0.5 * (1.0 + lambda)).unwrap();
        let step = 4.0 * f64::EPSILON * far;
        prop_assert!(depths.iter().zip(&nearer).all(|(a, b)| *b <= a + step));
    }
}
