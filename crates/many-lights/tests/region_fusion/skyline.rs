//! How much joining finds of what can be found: shadows without feet make a skyline, and whatever lies
//! below it is hidden.

use dapple_many_lights::region::Fusion;
use dapple_many_lights::region::fusion::{Horizon, Verdict};
use dapple_many_lights::region::horizon::{Projection, Umbra};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// Whether every place of a projection lies in some shadow: right where shadows begin and end, and
/// halfway between.
fn is_below(shadows: &[Umbra], p: &Projection) -> bool {
    let within = |u: f64| {
        let top = shadows.iter().filter(|s| s.u[0] <= u && u <= s.u[1]).map(|s| s.top[0]);
        top.fold(f64::NEG_INFINITY, f64::max) >= p.h[1]
    };
    let mut ends: Vec<f64> = shadows.iter().flat_map(|s| s.u).chain(p.u).collect();
    ends.retain(|u| p.u[0] <= *u && *u <= p.u[1]);
    ends.sort_by(f64::total_cmp);
    ends.iter().all(|u| within(*u)) && ends.windows(2).all(|w| within(0.5 * (w[0] + w[1])))
}

#[test]
fn the_tallest_first_finds_everything_below_a_skyline_and_other_orders_do_not() {
    let mut random = Pcg64Mcg::seed_from_u64(5);
    let mut found = [0; 3];
    let mut below = 0;
    for _ in 0..300 {
        let mut horizons = crate::streams::FUSIONS.map(Horizon::new);
        let mut shadows = Vec::new();
        for _ in 0..4 {
            let some: Vec<Umbra> = (0..random.random_range(0..8))
                .map(|_| {
                    let left = f64::from(random.random_range(0..30));
                    let width = f64::from(random.random_range(1..8));
                    let top = f64::from(random.random_range(1..12));
                    Umbra::flat([left, left + width], f64::NEG_INFINITY, top)
                })
                .collect();
            horizons.iter_mut().for_each(|horizon| horizon.add(&some));
            shadows.extend(some);
            for _ in 0..40 {
                let left = 0.5 * f64::from(random.random_range(0..64));
                let width = 0.5 * f64::from(random.random_range(0..24));
                let h = f64::from(random.random_range(0..12));
                let p = Projection { u: [left, left + width], h: [h, h] };
                let is_hidden = is_below(&shadows, &p);
                below += u32::from(is_hidden);
                for (horizon, found) in horizons.iter().zip(&mut found) {
                    let finds = horizon.test(&p, &mut 0) == Verdict::Hidden;
                    assert!(is_hidden || !finds, "{p:?} of {shadows:?}");
                    *found += u32::from(finds);
                }
            }
        }
    }
    let [none, insertion, ordered] = found;
    assert_eq!(ordered, below);
    assert!(none > 1000 && none < insertion && insertion < ordered, "{found:?} of {below}");
    assert_eq!(crate::streams::FUSIONS[2], Fusion::HeightOrdered);
}
