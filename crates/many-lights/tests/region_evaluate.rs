//! Which lights a face may see: nothing that is seen is left out, and what is counted adds up.
#![allow(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

mod region_evaluate_support;

use dapple_many_lights::region::{Direction, FacadeCluster, Precuts, Turn};
use proptest::prelude::*;
use region_evaluate_support::{is_antichain, precut, random, settings};

proptest! {
    #![proptest_config(ProptestConfig::with_cases(600))]

    /// P1, P8 and P11, and row 26: what is culled for its potential gives less than the threshold.
    #[test]
    fn no_light_that_is_seen_is_left_out(
        seed in any::<u32>(),
        degrees in prop_oneof![3 => Just(0_u32), 1 => 0_u32..90],
        scale in prop_oneof![6 => Just(1.0), 1 => Just(1e-4), 1 => Just(1e4)],
        settings in settings(),
    ) {
        let case = random(seed, scale, Turn::degrees(degrees));
        let mut evaluator = case.evaluator(settings);
        let mut output = 0;
        for direction in Direction::ALL {
            let nodes = precut(&mut evaluator, &case.cell, direction);
            output += nodes.len() as u64;
            prop_assert!(is_antichain(&case.tree, &nodes));
            let found = case.false_culls(&settings, direction, &nodes, (16, seed));
            prop_assert_eq!(&found.found, &vec![], "{:?} of {} culled", direction, found.culled);
        }
        let steps = *evaluator.steps();
        prop_assert!(steps.is_consistent());
        prop_assert_eq!(steps.output, output);
        prop_assert_eq!(steps.evaluations, 4);
    }
}

/// P1 by at least 10^5 rays, over worlds that hide a good share of their lights; and the same rays
/// find lights that are left out wrongly.
#[test]
fn many_rays_find_no_false_cull_and_would() {
    let settings = FacadeCluster { threshold: 0.0, ..FacadeCluster::default() };
    let (mut rays, mut culled, mut caught, mut kept) = (0, 0, 0, 0);
    for seed in 0..400 {
        let case = random(seed, 1.0, Turn::degrees([0, 0, 30][seed as usize % 3]));
        let mut evaluator = case.evaluator(settings);
        for direction in Direction::ALL {
            let nodes = precut(&mut evaluator, &case.cell, direction);
            let found = case.false_culls(&settings, direction, &nodes, (64, seed));
            assert_eq!(found.found, [], "seed {seed} {direction:?}");
            rays += found.rays;
            culled += found.culled;
            // Without its first node, a precut leaves out what may be seen.
            if let [_, rest @ ..] = nodes.as_slice() {
                kept += 1;
                let found = case.false_culls(&settings, direction, rest, (64, seed));
                caught += u32::from(!found.found.is_empty());
            }
        }
    }
    assert!(rays > 100_000, "{rays}");
    assert!(culled > 2_000, "{culled}");
    assert!(caught > kept / 2, "{caught} of {kept}");
}
