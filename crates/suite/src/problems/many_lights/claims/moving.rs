//! Lights that move: a second, small tree.

use super::{
    cuts::{TABLE, tree},
    precuts::lighting,
    support::{FINE, PAIRS, RGB, ns, prepared},
    verdict::{all_of, figure, judged, paired},
};
use crate::{
    SuiteError,
    claims::{Claim, ClaimContext, Judged, Verdict},
    problem::Form,
};
use dapple_many_lights::{
    BoundForm, Emission, Light, LightTree, Shaded, World,
    cut::{Method, Rule},
    tree::{Build, Representative},
};
use glam::DVec3;
use std::{sync::Arc, time::Instant};

/// Lights that move.
const MOVING: u32 = 1000;

/// Metres between two frames: a car's at 50 km/h and 60 frames a second is 0.23.
const STEP_M: f64 = 0.25;

/// Frames that they have moved for where an old tree is looked at.
const LATE: f64 = 60.0;

/// Share of a frame's time that building may take.
const SHARE: f64 = 0.1;

pub fn claims() -> Vec<Claim> {
    vec![Claim {
        id: "conte-H6.5",
        statement: "Moving lights can have a small tree of their own that is rebuilt every frame",
        place: "Conte 2018, section 6.1: future work",
        method: "1,000 omni lights along the city's close-ended street, moving 0.25 m a frame: time \
                 to build and pack their tree (halves; among neighbours) over time to light 128 x 72 \
                 pixels from the root of the city's own tree by R4 at T = 1/25500, in turn, on the \
                 processor. A tenth is met by either, as larger images take longer and building does \
                 not; a whole frame or more by both contradicts. The rebuilt tree's image must be \
                 within 2/255 of all moving lights, and a tree 60 frames old must not, or nothing is \
                 said by it",
        judge: Box::new(moving),
    }]
}

/// Lights on the ground of what a frame shows, so many frames on.
fn lights(world: &World, frames: f64) -> Vec<Light> {
    let shown: Vec<DVec3> = world.frames[0]
        .points
        .iter()
        .filter(|point| point.is_there())
        .map(|point| point.position.as_dvec3() + 0.7 * point.normal.as_dvec3())
        .collect();
    let at = |index: u32| {
        let place = shown.get(index as usize * shown.len() / MOVING as usize);
        let way = DVec3::new(f64::from(index).cos(), 0.0, f64::from(index).sin());
        place.copied().unwrap_or_default() + way * (STEP_M * frames)
    };
    let light = |index| Light {
        position: at(index),
        axis: DVec3::NEG_Y,
        intensity: DVec3::splat(0.05),
        emission: Emission::Omni,
    };
    (0..MOVING).map(light).collect()
}

/// Least share of a frame that building takes, and greatest errors of the image by the tree rebuilt
/// and by the old one.
fn every_frame(share: f64, rebuilt: f64, old: f64) -> Verdict {
    let time = if share <= SHARE {
        Verdict::Reproduced
    } else if share < 1.0 {
        Verdict::Open
    } else {
        Verdict::Refuted
    };
    let image = if rebuilt <= 2.0 * RGB { Verdict::Reproduced } else { Verdict::Refuted };
    let control = if old > 2.0 * RGB { Verdict::Reproduced } else { Verdict::Open };
    all_of(&[time, image, control])
}

/// An image of moving lights by R4 over a tree.
fn image(world: &Arc<World>, tree: LightTree, threshold: f64) -> Result<Shaded, SuiteError> {
    let method = Method::Rule(Rule::Absolute(threshold), BoundForm::Cheap);
    let mut cut = lighting(Form::Cpu, world, &Arc::new(tree), None, method, None)?;
    let mut shaded = Shaded::default();
    cut.reset(0)?;
    cut.shade(0, false)?;
    cut.read(&mut shaded)?;
    Ok(shaded)
}

fn most(a: &Shaded, b: &Shaded) -> f64 {
    let pairs = a.radiance.iter().zip(&b.radiance);
    pairs.map(|(a, b)| f64::from((*a - *b).abs().max_element())).fold(0.0, f64::max)
}

fn moving(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let case = prepared(TABLE.0, TABLE.1, &[])?;
    let method = Method::Rule(Rule::Absolute(FINE), BoundForm::Cheap);
    let tree = tree(&case, "city")?;
    let mut whole = lighting(Form::Cpu, case.world(), &tree, None, method, None)?;
    let (mut figures, mut shares) = (Vec::new(), Vec::new());
    let builds = [
        ("halves", Build::Median),
        ("neighbours", Build::LocallyOrdered { spread: 1.0 }),
        ("all pairs", Build::Greedy { spread: 1.0 }),
    ];
    for (name, build) in builds {
        let mut frame = 0.0;
        let build = || {
            frame += 1.0;
            let now = lights(case.world(), frame);
            let start = Instant::now();
            let packed = LightTree::build(&now, build, Representative::Weighted)?.pack();
            let took = start.elapsed().as_nanos() as f64;
            // Used, or it need not be built.
            Ok(took + (packed.nodes.len() as f64 - f64::from(2 * MOVING - 1)))
        };
        let share = paired(PAIRS, build, || ns(&case, &mut *whole))?;
        figures.push(figure(format!("{name}: build over a frame"), share.median, ""));
        figures.push(figure(format!("{name}: the same, MAD"), share.mad, ""));
        if name != "all pairs" {
            shares.push(share.median);
        }
    }
    let world = |frames| {
        let lights = lights(case.world(), frames);
        Arc::new(World { lights, ..(**case.world()).clone() })
    };
    let (now, before) = (world(LATE), world(0.0));
    let exact = image(&now, LightTree::median(&now.lights)?, 0.0)?;
    let rebuilt = most(&image(&now, LightTree::median(&now.lights)?, FINE)?, &exact);
    let old = most(&image(&before, LightTree::median(&before.lights)?, FINE)?, &exact);
    figures.push(figure("greatest error, rebuilt", rebuilt / RGB, "1/255"));
    figures.push(figure("greatest error, 60 frames old", old / RGB, "1/255"));
    let least = shares.iter().copied().fold(f64::INFINITY, f64::min);
    let because = format!(
        "building a tree of 1,000 lights takes {:.1} % of a frame; its image is within {:.2} / 255",
        100.0 * least,
        rebuilt / RGB
    );
    Ok(judged(every_frame(least, rebuilt, old), because, figures))
}

#[cfg(test)]
mod tests {
    use super::*;
    use Verdict::{Open, Refuted, Reproduced};

    #[test]
    fn trees_are_built_every_frame_or_not() {
        assert_eq!(every_frame(0.01, 0.0, 0.5), Reproduced);
        assert_eq!(every_frame(0.5, 0.0, 0.5), Open);
        assert_eq!(every_frame(2.0, 0.0, 0.5), Refuted);
        assert_eq!(every_frame(0.01, 0.1, 0.5), Refuted);
        assert_eq!(every_frame(0.01, 0.0, 0.0), Open);
        assert_eq!(every_frame(f64::NAN, 0.0, 0.5), Refuted);
    }
}
