//! Streets and points of view of the generated city.

use super::{ALL, input};
use crate::{
    SuiteError,
    verify::{About, Gate, GateContext, Tally, gate},
};
use dapple_occlusion::camera::{Objects, Readiness, Renderer, View, software::Fast};
use dapple_scene::{
    Camera,
    city::{self, Knobs},
};
use dapple_trace::{Ray, Tracer};
use glam::DVec3;
use rand::RngExt;
use std::{collections::BTreeSet, sync::Arc};

/// The four points of view, as the thesis orders them.
const VIEWS: [&str; 4] = ["facade", "close_ended", "street", "birds_eye"];

/// Reference cities of different heights: in one of ten or so a closed street shows enough to leave
/// less than a fourfold step to the long one.
const CITIES: u64 = 3;

/// Image of the thesis.
const SIZE: [u32; 2] = [1200, 900];

pub fn gates() -> Vec<Gate> {
    let about = |name, statement, fault| About { technique: ALL, name, statement, fault };
    vec![
        gate(
            about(
                "row 2 vistas",
                "a ray along an offset street meets a facade within two blocks; along an unbroken \
                 street it leaves the city",
                "blocks are not offset, and rays go across the unbroken street",
            ),
            vistas,
        ),
        gate(
            about(
                "row 5 views",
                "the triangles that own pixels grow from each of the four points of view to the \
                 next: in each of three reference cities, and fourfold at least in their mean",
                "the long street before the closed one",
            ),
            views,
        ),
    ]
}

fn camera<'a>(scene: &'a dapple_scene::Scene, name: &str) -> Result<&'a Camera, SuiteError> {
    let known = scene.cameras.iter().map(|c| &*c.name);
    let found = scene.cameras.iter().find(|c| c.name == name);
    found.ok_or_else(|| SuiteError::unknown("view", name, known))
}

fn vistas(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    let knobs = Knobs { blocks_x: 4, blocks_z: 4, brick_offset: true, ..Knobs::default() };
    let city = city::generate(&knobs, context.seed)?;
    let closed = city.scene().scene;
    let open = city::generate(&Knobs { brick_offset: !faulty, ..knobs }, context.seed)?.scene();
    let tracer = Tracer::build(if faulty { &open.scene } else { &closed })?;
    let bounds = closed.bounds();
    let two_blocks = 2.0 * (bounds.max.z - bounds.min.z) / f64::from(knobs.blocks_z);
    let mut rng = input::rng(context.seed, "vistas", 0);
    let (across, along) = (camera(&closed, "close_ended")?, camera(&closed, "street")?);
    for ray in 0..64 {
        // Anywhere on the carriageway, below the lowest roofs.
        let side = 0.4 * knobs.street_m * rng.random_range(-1.0..1.0);
        let height = rng.random_range(0.1..2.9);
        let origin = (across.position + DVec3::X * side).with_y(height);
        let met = tracer.closest(&Ray::new(origin, DVec3::NEG_Z)).map_or(f64::INFINITY, |h| h.t);
        tally.within(met, two_blocks, || format!("ray {ray} across from {origin}"));
        let origin = (along.position + DVec3::Z * side).with_y(height);
        let direction = if faulty { DVec3::Z } else { DVec3::X };
        let met = tracer.closest(&Ray::new(origin, direction));
        tally.check(met.is_none(), || format!("ray {ray} along from {origin} meets {met:?}"));
    }
    Ok(tally)
}

/// Triangles that own pixels of each of the four points of view.
fn owners(seed: u64) -> Result<Vec<usize>, SuiteError> {
    let scene = city::generate(&Knobs::default(), seed)?.scene().scene;
    let (objects, _) = Objects::from_scene(&scene, 1024)?;
    let near_m = 1e-4 * scene.bounds().radius();
    let all: Vec<u32> = (0..objects.objects.len() as u32).collect();
    let view = |name| Ok(View::new(camera(&scene, name)?, &objects, SIZE[0], SIZE[1], near_m)?);
    let views = VIEWS.into_iter().map(view).collect::<Result<Vec<View>, SuiteError>>()?;
    let mut renderer = Fast::new(Arc::new(objects), Readiness::Modelled(0))?;
    let mut counts = Vec::new();
    for view in &views {
        renderer.begin(view)?;
        renderer.draw(&all)?;
        renderer.end()?;
        let owners: BTreeSet<_> = renderer.image().ids.iter().filter(|id| id[0] > 0).collect();
        counts.push(owners.len());
    }
    Ok(counts)
}

fn views(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    let cities = if faulty { 1 } else { CITIES };
    let mut growth = [0.0; 3];
    for city in 0..cities {
        let mut counts = owners(context.seed.wrapping_mul(CITIES) + city)?;
        if faulty {
            counts.swap(1, 2);
        }
        for (step, pair) in counts.windows(2).enumerate() {
            let [less, more] = pair else { continue };
            tally.check(0 < *less && less < more, || format!("city {city}: {counts:?}"));
            growth[step] += (*more as f64 / *less as f64).ln() / cities as f64;
        }
    }
    for (growth, names) in growth.iter().zip(VIEWS.windows(2)) {
        let times = growth.exp();
        tally.check(times >= 4.0, || format!("{times} times from {} to {}", names[0], names[1]));
    }
    Ok(tally)
}
