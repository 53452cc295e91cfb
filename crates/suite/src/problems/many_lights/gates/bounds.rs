//! Estimates and bounds of clusters, at points and over regions, in f64 and f32.

use super::{
    ALL,
    hard::{self, CLAMP_M, Case, FORMS},
    input,
};
use crate::{
    SuiteError,
    verify::{About, Gate, GateContext, Tally, gate},
};
use dapple_many_lights::bound::{
    self, Region,
    packed::{self, PackedRegion},
};
use glam::DVec3;
use rand::RngExt;

/// Cases for each that is asked for: one is a matter of microseconds.
const TIMES: u32 = 30;

/// Lights of a case.
const LIGHTS: usize = 12;

/// Share by which a sum of f64 may exceed a bound that it reaches.
const ROUNDING: f64 = 1e-12;

/// Radiance that counts as none.
const NOTHING: f64 = 1e-30;

pub fn gates() -> Vec<Gate> {
    let about = |name, statement, fault| About { technique: ALL, name, statement, fault };
    vec![
        gate(
            about(
                "P14 estimates",
                "a cluster's estimate is at least 0 and at most its bound, a single light's is \
                 exact",
                "the distance is clamped in the estimate alone",
            ),
            |context, faulty| {
                over_cases(context, "P14 estimates", |case, tally| estimates(case, tally, faulty))
            },
        ),
        gate(
            about(
                "P14 sums",
                "what a cluster's lights give together is at most its bound, by either form of \
                 bounds",
                "cones are made without the children's axes",
            ),
            |context, faulty| {
                over_cases(context, "P14 sums", |case, tally| sums(case, tally, faulty))
            },
        ),
        gate(
            about(
                "P14 f32",
                "in f32, estimates and sums of f64 stay below the bound, which lies in the band \
                 stated for it",
                "boxes hold but the first of a cluster's lights",
            ),
            |context, faulty| {
                over_cases(context, "P14 f32", |case, tally| in_f32(case, tally, faulty))
            },
        ),
        gate(
            about(
                "P14 forms",
                "Walter's bound is nowhere above the cheap one",
                "the two are exchanged",
            ),
            |context, faulty| {
                over_cases(context, "P14 forms", |case, tally| forms(case, tally, faulty))
            },
        ),
        gate(
            about(
                "P14 regions",
                "a region's bound is at least what any of its points gets, and any of their bounds \
                 where they face one way, in f64 and in f32",
                "the region is that of its first point",
            ),
            regions,
        ),
    ]
}

fn over_cases(
    context: &GateContext<'_>,
    name: &str,
    mut check: impl FnMut(&mut Case, &mut Tally),
) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for number in 0..context.cases * TIMES {
        check(&mut hard::case(context.seed, name, number, LIGHTS)?, &mut tally);
    }
    Ok(tally)
}

fn estimates(case: &mut Case, tally: &mut Tally, faulty: bool) {
    let clamp_of_estimate = if faulty { 100.0 * CLAMP_M } else { CLAMP_M };
    let each = case.each(CLAMP_M);
    for (index, node) in case.tree.nodes.iter().enumerate() {
        let estimate = bound::estimate(node, &case.point, clamp_of_estimate);
        for form in FORMS {
            let bound = bound::point(form, node, &case.point, CLAMP_M);
            let within = estimate.min_element() >= 0.0 && estimate.max_element() <= bound;
            tally.check(within, || {
                format!("node {index}: {estimate} is not in 0..={bound} ({form:?})")
            });
        }
        if node.is_leaf() {
            let exact = each[node.light as usize];
            tally.check(estimate == exact, || {
                format!("light {}: {estimate} rather than {exact}", node.light)
            });
        }
    }
}

/// The sum over a node's lights, largest channel.
fn sum(case: &Case, node: usize, each: &[DVec3]) -> f64 {
    case.below(node).map(|light| each[light]).sum::<DVec3>().max_element()
}

fn sums(case: &mut Case, tally: &mut Tally, faulty: bool) {
    if faulty {
        case.tree.nodes.iter_mut().for_each(|node| node.cone_rad = 0.0);
    }
    let each = case.each(CLAMP_M);
    for (index, node) in case.tree.nodes.iter().enumerate() {
        let sum = sum(case, index, &each);
        for form in FORMS {
            let bound = bound::point(form, node, &case.point, CLAMP_M);
            tally.check(sum <= bound * (1.0 + ROUNDING) + NOTHING, || {
                format!("node {index}: {sum} above {bound} ({form:?})")
            });
        }
    }
}

fn in_f32(case: &mut Case, tally: &mut Tally, faulty: bool) {
    let (each, clamp) = (case.each(CLAMP_M), packed::clamp_squared(CLAMP_M));
    let mut tree = case.tree.pack();
    if faulty {
        for (index, node) in tree.nodes.iter_mut().enumerate() {
            let first = case.below(index).next().map(|light| case.lights[light].position.as_vec3());
            (node.min, node.max) = (first.unwrap_or(node.min), first.unwrap_or(node.max));
        }
    }
    for (index, packed) in tree.nodes.iter().enumerate() {
        let estimate = packed::estimate(packed, &case.point, clamp);
        let sum = sum(case, index, &each);
        for form in FORMS {
            let bound = packed::point(form, packed, &case.point, clamp);
            let within = estimate.min_element() >= 0.0 && estimate.max_element() <= bound;
            tally.check(within, || format!("node {index}: {estimate} not in 0..={bound}"));
            tally.check(sum <= f64::from(bound) * (1.0 + f64::EPSILON) + NOTHING, || {
                format!("node {index}: {sum} above {bound} ({form:?})")
            });
            let region = Region::at(&case.point);
            let (least, most) =
                bound::band(form, &case.tree.nodes[index], packed, &region, CLAMP_M);
            let bound = f64::from(bound);
            let in_band = least * (1.0 - ROUNDING) <= bound + NOTHING
                && bound <= most * (1.0 + ROUNDING) + NOTHING;
            tally.check(in_band, || format!("node {index}: {bound} not in {least}..={most}"));
        }
    }
}

fn forms(case: &mut Case, tally: &mut Tally, faulty: bool) {
    let [mut cheap, mut walter] = FORMS;
    if faulty {
        std::mem::swap(&mut cheap, &mut walter);
    }
    for (index, node) in case.tree.nodes.iter().enumerate() {
        let [cheap, walter] =
            [cheap, walter].map(|form| bound::point(form, node, &case.point, CLAMP_M));
        tally.check(walter <= cheap * (1.0 + ROUNDING), || {
            format!("node {index}: {walter} above {cheap}")
        });
    }
}

fn regions(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for number in 0..context.cases * TIMES / 2 {
        let mut case = hard::case(context.seed, "P14 regions", number, LIGHTS)?;
        let mut rng = input::rng(context.seed, "regions", number);
        let flat = rng.random_bool(0.5);
        let mut points = vec![case.point];
        for _ in 0..rng.random_range(1..4) {
            let mut point = hard::point(&mut rng, &case.lights, &case.tree);
            if flat {
                point.normal = case.point.normal;
            }
            points.push(point);
        }
        let over = if faulty { &points[..1] } else { &points[..] };
        let (Some(region), Some(packed_region)) =
            (Region::of(over.iter()), PackedRegion::of(over.iter()))
        else {
            continue;
        };
        let (tree, clamp) = (case.tree.pack(), packed::clamp_squared(CLAMP_M));
        for point in points {
            case.point = point;
            let each = case.each(CLAMP_M);
            for (index, node) in case.tree.nodes.iter().enumerate() {
                let sum = sum(&case, index, &each);
                for form in FORMS {
                    let all = bound::region(form, node, &region, CLAMP_M);
                    let own = bound::point(form, node, &case.point, CLAMP_M);
                    let in_f32 = packed::region(form, &tree.nodes[index], &packed_region, clamp);
                    for (what, bound) in [("f64", all), ("f32", f64::from(in_f32))] {
                        tally.check(sum <= bound * (1.0 + ROUNDING) + NOTHING, || {
                            format!("node {index}, {what}: {sum} above {bound} ({form:?})")
                        });
                    }
                    tally.check(!flat || own <= all * (1.0 + 1e-5) + NOTHING, || {
                        format!("node {index}: {own} at a point above {all} ({form:?})")
                    });
                }
            }
        }
    }
    Ok(tally)
}
