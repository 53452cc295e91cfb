//! Techniques that are compared with: a raster of shadows, and rays.

use super::worlds::{self, Wanted, nodes_of};
use crate::{
    SuiteError,
    problem::Form,
    verify::{About, Gate, GateContext, Tally, gate},
};
use dapple_many_lights::region::{
    Direction, FacadeCluster, Many, RegionTechnique, Sampled, make, truth::kept,
};

/// Share of what shadows without texels hide that the finest map may keep.
const LOST: f64 = 0.1;

/// Worlds of a gate, at most.
const WORLDS: u32 = 12;

pub fn gates() -> Vec<Gate> {
    let about = |technique, name, statement, fault| About { technique, name, statement, fault };
    vec![
        gate(
            about(
                "extended-projection",
                "converges",
                "of the lights that shadows without texels hide, a map keeps the fewer the finer it \
                 is, and few at last",
                "the coarsest map comes last",
            ),
            converges,
        ),
        gate(
            about(
                "sampled",
                "more rays",
                "with more rays of the same draws no light is lost that fewer have found, and some \
                 are found",
                "the more rays are drawn anew, and there are no more",
            ),
            more_rays,
        ),
        gate(
            about(
                "all-lights",
                "roots",
                "every face starts at the roots",
                "it starts at a facade's precut",
            ),
            roots,
        ),
    ]
}

fn converges(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    let mut texels = vec![16, 64, 256];
    if context.deep {
        texels.push(1024);
    }
    if faulty {
        texels.reverse();
    }
    let mut lost = vec![0_u64; texels.len()];
    let mut culled = 0_u64;
    for number in 0..context.cases.min(WORLDS) {
        let wanted = Wanted { omni: true, floating: false };
        let world = worlds::random(context.seed, number, wanted)?;
        let settings = FacadeCluster { threshold: 0.0, ..FacadeCluster::default() };
        let mut exact = world.make(&RegionTechnique::FacadeCluster(settings), Form::Cpu)?;
        let exact = Direction::ALL
            .map(|direction| kept(&world.tree, &nodes_of(&mut *exact, &world.cell, direction)));
        culled += exact.iter().flatten().filter(|kept| !**kept).count() as u64;
        for (texels, lost) in texels.iter().zip(&mut lost) {
            let of = RegionTechnique::ExtendedProjection { texels: *texels };
            let mut raster = world.make(&of, Form::Cpu)?;
            for (direction, exact) in Direction::ALL.into_iter().zip(&exact) {
                let nodes = nodes_of(&mut *raster, &world.cell, direction);
                let pairs = exact.iter().zip(kept(&world.tree, &nodes));
                *lost += pairs.filter(|(exact, kept)| !**exact && *kept).count() as u64;
            }
        }
    }
    tally.check(culled > 0, || "nothing is hidden".into());
    for (lost, texels) in lost.array_windows().zip(texels.array_windows()) {
        let ([coarse, fine], [before, after]): (&[u64; 2], &[u32; 2]) = (lost, texels);
        tally.check(fine <= coarse, || {
            format!("{fine} kept at {after} texels, {coarse} at {before}")
        });
    }
    let last = lost.last().map_or(f64::NAN, |lost| *lost as f64 / culled as f64);
    tally.within(last, LOST, || format!("share kept at {:?} texels", texels.last()));
    Ok(tally)
}

fn more_rays(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    let case = worlds::generated(context.seed)?;
    let town = &case.night().town;
    let asked: Vec<_> = case.frames()[0].iter().map(|question| question.asked()).collect();
    let asked = &asked[..asked.len().min(24)];
    let mut before: Option<Vec<Vec<bool>>> = None;
    let (mut found, mut gained) = (0, 0);
    for rays in [1, 4, 16] {
        let seed = if faulty { rays } else { 3 };
        let of = Sampled { rays: if faulty { 1 } else { rays }, seed };
        let of = RegionTechnique::Sampled(of);
        let world = town.world(true);
        let mut many = Many::new(|| make(&of, false, world, &town.lights, &town.occluders))?;
        let mut precuts = Vec::new();
        many.all(asked, &mut precuts);
        let now: Vec<Vec<bool>> = precuts.iter().map(|p| kept(&town.lights, p)).collect();
        for (face, (before, now)) in before.iter().flatten().zip(&now).enumerate() {
            for (light, (before, now)) in before.iter().zip(now).enumerate() {
                tally.check(*now || !before, || format!("{rays} rays, face {face}: light {light}"));
                found += u64::from(*before);
                gained += u64::from(*now && !before);
            }
        }
        before = Some(now);
    }
    tally.check(found > 0 && gained > 0, || format!("{found} found, {gained} gained"));
    Ok(tally)
}

fn roots(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for number in 0..context.cases {
        let wanted = Wanted { omni: false, floating: true };
        let world = worlds::random(context.seed, number, wanted)?;
        let of = match faulty {
            true => RegionTechnique::FacadeCluster(FacadeCluster::default()),
            false => RegionTechnique::Everything,
        };
        let mut made = world.make(&of, Form::Cpu)?;
        for direction in Direction::ALL {
            let nodes = nodes_of(&mut *made, &world.cell, direction);
            tally.check(nodes == world.tree.roots, || format!("world {number}: {nodes:?}"));
        }
    }
    Ok(tally)
}
