//! What building a light tree and following a light cost.

use super::verdict::{all_of, figure, judged, paired, vote};
use crate::{
    SuiteError,
    claims::{Claim, ClaimContext, Judged, Verdict},
};
use dapple_many_lights::{Emission, Light};
use dapple_many_lights::{
    LightTree, Node, PackedNode,
    tree::{Build, Representative},
    worlds::{Cloud, cloud},
};
use glam::{DVec3, Vec3A};
use obvhs::{BvhBuildParams, aabb::Aabb, bvh2::builder::build_bvh2};
use std::{
    hint::black_box,
    time::{Duration, Instant},
};

/// Lights of the trees that are timed, and pairs of builds.
const LIGHTS: u32 = 1_000_000;
const PAIRS: usize = 3;

/// Times a build over boxes: cones, intensities and representatives are three more things to keep
/// of a node.
const AT_MOST: f64 = 3.0;

/// Lights of the trees in which one moves.
const MOVED_IN: [u32; 4] = [1000, 10_000, 100_000, 1_000_000];

pub fn claims() -> Vec<Claim> {
    vec![
        Claim {
            id: "tree-build",
            statement: "A tree over a million lights is built in at most three times the time of a \
                        bounding volume hierarchy over as many boxes, and is no larger a light than \
                        its packed nodes are",
            place: "goal of this project; Conte 2018, section 3.1, calls the build very expensive",
            method: "a million lights of a random cloud, all of one kind; locally ordered, in halves \
                     and by surface area, against the fast build of obvhs over boxes of 0.1 m around \
                     them, 3 builds each in turn, on the same threads: met for a tree if the median \
                     ratio is at most 3. Bytes are nodes as they are walked",
            judge: Box::new(build),
        },
        Claim {
            id: "tree-refit",
            statement: "A tree follows one light by visits of the order of its depth",
            place: "goal of this project",
            method: "trees in halves over 10^3 to 10^6 lights, 64 lights moved in each: met if no \
                     move takes more than four visits a level (both children on the way down and \
                     both on the way up) and the root, and a thousand times the lights take less \
                     than three times the visits",
            judge: Box::new(refit),
        },
    ]
}

fn lights(count: u32) -> Vec<Light> {
    let emissions = vec![Emission::Oriented];
    let origin = DVec3::ZERO;
    let size = [1, 1];
    cloud(&Cloud { lights: count, emissions, seed: 1, size, frames: 1, origin }).world.lights
}

fn ns<T>(build: impl FnOnce() -> Result<T, SuiteError>) -> Result<f64, SuiteError> {
    let start = Instant::now();
    black_box(build()?);
    Ok(start.elapsed().as_nanos() as f64)
}

/// Times of trees over that of the hierarchy.
fn fast_enough(ratios: &[f64]) -> Verdict {
    vote(&ratios.iter().map(|ratio| *ratio <= AT_MOST).collect::<Vec<_>>())
}

fn build(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let lights = lights(LIGHTS);
    let boxes: Vec<Aabb> = lights
        .iter()
        .map(|light| {
            let at = light.position.as_vec3();
            let [min, max] = [at - 0.05, at + 0.05].map(Vec3A::from);
            Aabb { min, max }
        })
        .collect();
    let (mut figures, mut ratios) = (Vec::new(), Vec::new());
    let ways = [
        ("locally ordered", Build::LocallyOrdered { spread: 1.0 }),
        ("halves", Build::Median),
        ("surface area", Build::SurfaceArea),
    ];
    let params = BvhBuildParams::fast_build();
    let mut rival_ns = f64::NAN;
    for (name, build) in ways {
        let mut nodes = 0;
        let tree = || {
            ns(|| {
                let tree = LightTree::build(&lights, build, Representative::Weighted)?;
                nodes = tree.nodes.len();
                Ok(tree)
            })
        };
        let hierarchy = || {
            rival_ns = ns(|| Ok(build_bvh2(&boxes, params, &mut Duration::default())))?;
            Ok(rival_ns)
        };
        let ratio = paired(PAIRS, tree, hierarchy)?.median;
        let bytes = |size: usize| (nodes * size) as f64 / f64::from(LIGHTS);
        figures.extend([
            figure(format!("{name}: time over obvhs's"), ratio, ""),
            figure(format!("{name}: packed"), bytes(size_of::<PackedNode>()), "bytes a light"),
            figure(format!("{name}: as built"), bytes(size_of::<Node>()), "bytes a light"),
        ]);
        ratios.push(ratio);
    }
    let bvh = build_bvh2(&boxes, params, &mut Duration::default());
    let bytes = size_of_val(&bvh.nodes[..]) as f64 / f64::from(LIGHTS);
    figures.push(figure("obvhs: its last build", rival_ns / 1e6, "ms"));
    figures.push(figure("obvhs: nodes", bytes, "bytes a box"));
    let because = format!(
        "{:.1}, {:.1} and {:.1} times the hierarchy's time",
        ratios[0], ratios[1], ratios[2]
    );
    Ok(judged(fast_enough(&ratios), because, figures))
}

/// Most visits of a move and depth of its tree, smallest tree first.
fn of_the_depth(trees: &[[f64; 2]]) -> Verdict {
    let within = vote(&trees.iter().map(|[v, depth]| *v <= 4.0 * depth + 1.0).collect::<Vec<_>>());
    let grows = match (trees.first(), trees.last()) {
        (Some([first, _]), Some([last, _])) if last < &(3.0 * first) => Verdict::Reproduced,
        (Some(_), Some(_)) => Verdict::Refuted,
        _ => Verdict::Open,
    };
    // One tree beyond its depth is one too many.
    let within =
        if within == Verdict::Open && !trees.is_empty() { Verdict::Refuted } else { within };
    all_of(&[within, grows])
}

fn refit(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let (mut figures, mut trees) = (Vec::new(), Vec::new());
    for count in MOVED_IN {
        let mut lights = lights(count);
        let mut tree = LightTree::median(&lights)?;
        let depth = f64::from(count.next_power_of_two().ilog2());
        let mut most = 0;
        for step in 0..64 {
            let light = step * (count / 64);
            lights[light as usize].position.x += 0.1;
            most = most.max(tree.moved(&lights, light, Representative::Weighted)?);
        }
        figures.push(figure(format!("{count} lights: depth"), depth, "edges"));
        figures.push(figure(
            format!("{count} lights: most visits of a move"),
            most as f64,
            "nodes",
        ));
        trees.push([most as f64, depth]);
    }
    let told: Vec<f64> = trees.iter().map(|[visits, _]| *visits).collect();
    let because = format!("at most {told:.0?} visits over 10^3 to 10^6 lights");
    Ok(judged(of_the_depth(&trees), because, figures))
}

#[cfg(test)]
mod tests {
    use super::*;
    use Verdict::{Open, Refuted, Reproduced};

    #[test]
    fn builds_are_fast_enough_or_not() {
        assert_eq!(fast_enough(&[2.0, 3.0]), Reproduced);
        assert_eq!(fast_enough(&[2.0, 3.5]), Open);
        assert_eq!(fast_enough(&[f64::NAN]), Refuted);
    }

    #[test]
    fn visits_are_of_the_depth_or_not() {
        assert_eq!(of_the_depth(&[[41.0, 10.0], [81.0, 20.0]]), Reproduced);
        assert_eq!(of_the_depth(&[[41.0, 10.0], [82.0, 20.0]]), Refuted);
        assert_eq!(of_the_depth(&[[20.0, 10.0], [80.0, 20.0]]), Refuted);
        assert_eq!(of_the_depth(&[]), Open);
    }
}
