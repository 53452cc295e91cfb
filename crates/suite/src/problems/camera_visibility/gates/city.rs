//! The generated city: counts, laws of heights, lights, and boxes within its buildings.

use super::{ALL, input, play};
use crate::{
    SuiteError,
    verify::{About, Gate, GateContext, Tally, gate},
};
use dapple_scene::city::{
    self, City, Footprint, Heights, InnerKnobs, Knobs, Part, covered_share, inner_boxes,
};
use glam::{DVec2, DVec3};
use rand::RngExt;
use rand_pcg::Pcg64;

/// Lights of a block in the thesis.
const LIGHTS: f64 = 1089.0;

pub fn gates() -> Vec<Gate> {
    let about = |name, statement, fault| About { technique: ALL, name, statement, fault };
    vec![
        gate(
            about(
                "row 1 counts",
                "lights are within 5 % of 1,089 a block, and grow with the blocks within 1 %; a \
                 storey has 8 quads",
                "four windows a storey",
            ),
            counts,
        ),
        gate(
            about(
                "P24 seed",
                "one seed gives one city, bit for bit, whatever was generated before",
                "another seed",
            ),
            seed,
        ),
        gate(
            about(
                "row 3 heights",
                "heights have the mean and variance of their law, and lots are empty as asked",
                "all buildings have four storeys",
            ),
            heights,
        ),
        gate(
            about(
                "row 4 falloff",
                "a window's light falls linearly with the angle, from 1 ahead to 0 at 45 degrees",
                "linear in the cosine",
            ),
            falloff,
        ),
        gate(
            about(
                "P24 lights",
                "lights stand outside all buildings, on no party wall, facing along an axis",
                "lights stand 2 mm further back",
            ),
            |context, faulty| lights(context, faulty, false),
        ),
        gate(
            about(
                "P24 party walls",
                "of two walls that touch, neither has lights",
                "party walls are taken for free ones, and the others for party walls",
            ),
            |context, faulty| lights(context, faulty, true),
        ),
        gate(
            about(
                "inner boxes",
                "boxes within a building lie inside its footprint, whatever its shape and turn, \
                 and between base and eaves",
                "the box around the building",
            ),
            inner,
        ),
    ]
}

fn counts(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    let lights_per_storey = if faulty { 4 } else { 3 };
    let mut a_block = Vec::new();
    for blocks in [1, 3, 6] {
        let knobs =
            Knobs { blocks_x: blocks, blocks_z: blocks, lights_per_storey, ..Knobs::default() };
        let city = city::generate(&knobs, context.seed)?;
        let lights = city.lights.len() as f64 / f64::from(blocks * blocks);
        tally.within((lights / LIGHTS - 1.0).abs(), 0.05, || {
            format!("{blocks} x {blocks} blocks: {lights} lights a block")
        });
        a_block.push(lights);
        let made = city.scene();
        for (instance, part) in made.scene.instances.iter().zip(&made.parts) {
            if matches!(part, Part::Storey { .. }) {
                let triangles = made.scene.meshes[instance.mesh as usize].triangles.len();
                tally.check(triangles == 16, || format!("{part:?}: {triangles} triangles"));
            }
        }
    }
    let [_, some, many] = a_block[..] else { return Ok(tally) };
    tally.within((some / many - 1.0).abs(), 0.01, || format!("{some} and {many} lights a block"));
    Ok(tally)
}

fn seed(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for number in 0..play::cases(context, 4, faulty) {
        let knobs = Knobs { blocks_x: 2, blocks_z: 1, trees_per_block: 4, ..Knobs::default() };
        let seed = context.seed + u64::from(number);
        let first = city::generate(&knobs, seed)?;
        let again = city::generate(&knobs, seed + u64::from(faulty))?;
        let hash = |city: &City| city.scene().scene.hash();
        tally.check(hash(&first) == hash(&again), || format!("scenes of seed {seed}"));
        tally.check(first.lights == again.lights, || format!("lights of seed {seed}"));
    }
    Ok(tally)
}

/// Mean and variance of the storeys.
fn moments(city: &City) -> [f64; 2] {
    let storeys: Vec<f64> = city.buildings.iter().map(|b| f64::from(b.storeys)).collect();
    let count = storeys.len() as f64;
    let mean = storeys.iter().sum::<f64>() / count;
    [mean, storeys.iter().map(|s| (s - mean).powi(2)).sum::<f64>() / count]
}

fn heights(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    let blocks = 12;
    let city = |heights, empty_lots| {
        let heights = if faulty { Heights::Fixed(4) } else { heights };
        let knobs =
            Knobs { blocks_x: blocks, blocks_z: blocks, heights, empty_lots, ..Knobs::default() };
        city::generate(&knobs, context.seed)
    };
    let lots = f64::from(blocks * blocks * 44);
    // Of n independent uniform heights 1 to 7: mean 4 ± 2 / √n, variance 4 ± 3.46 / √n. Five of each.
    let chance = 5.0 / lots.sqrt();
    for (law, mean, variance, slack) in [
        (Heights::Fixed(7), 7.0, 0.0, [0.0; 2]),
        (Heights::Stratified { least: 1, most: 7 }, 4.0, 4.0, [0.0, 0.1]),
        (Heights::Independent { least: 1, most: 7 }, 4.0, 4.0, [2.0 * chance, 3.47 * chance]),
    ] {
        let [found, spread] = moments(&city(law, 0.0)?);
        tally.within((found - mean).abs(), slack[0], || format!("{law:?}: mean {found}"));
        tally.within((spread - variance).abs(), slack[1], || format!("{law:?}: variance {spread}"));
    }
    for empty in [0.0, 0.1, 0.25, 0.5] {
        let built = city(Heights::Fixed(7), empty)?.buildings.len() as f64;
        let off = (1.0 - built / lots - empty).abs();
        tally.within(off, 0.5 / lots + 1e-12, || format!("{empty} empty lots: {built} built"));
    }
    Ok(tally)
}

fn falloff(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    let knobs = Knobs { blocks_x: 1, blocks_z: 1, ..Knobs::default() };
    let city = city::generate(&knobs, context.seed)?;
    for light in city.lights.iter().step_by(50) {
        for (degrees, share) in [(0.0, 1.0), (11.25, 0.75), (22.5, 0.5), (45.0, 0.0), (80.0, 0.0)] {
            let angle: f64 = f64::to_radians(degrees);
            let edge = std::f64::consts::FRAC_PI_4.cos();
            let found = match faulty {
                true => ((angle.cos() - edge) / (1.0 - edge)).max(0.0),
                false => light.falloff(angle),
            };
            tally.within((found - share).abs(), 1e-12, || format!("{degrees} degrees: {found}"));
        }
    }
    Ok(tally)
}

fn lights(context: &GateContext<'_>, faulty: bool, party: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for number in 0..play::cases(context, 4, faulty) {
        let knobs = Knobs { blocks_x: 1, blocks_z: 2, empty_lots: 0.2, ..Knobs::default() };
        let mut city = city::generate(&knobs, context.seed + u64::from(number))?;
        if faulty && party {
            city.buildings.iter_mut().flat_map(|b| &mut b.facades).for_each(|f| f.party ^= true);
            city::windows::light(&mut city, 3, context.seed)?;
        }
        for light in &city.lights {
            let back = if faulty && !party { 2e-3 } else { 0.0 };
            let at = light.position - light.direction * back;
            let ahead = at + light.direction * 0.01;
            let within = |p: DVec3| {
                let holds =
                    |b: &&city::Building| p.cmpgt(b.outer.min).all() && p.cmplt(b.outer.max).all();
                city.buildings.iter().find(holds).map(|b| b.id.clone())
            };
            let in_building = if party { within(ahead) } else { within(at) };
            tally.check(in_building.is_none(), || {
                format!("{} m: the light of {:?} is within {in_building:?}", at, light.building)
            });
            let axes = light.direction.abs().to_array().iter().filter(|c| **c == 1.0).count();
            let upright = light.direction.y == 0.0;
            tally.check(axes == 1 && upright, || format!("it faces {}", light.direction));
        }
    }
    Ok(tally)
}

/// A simple polygon around a point: corners at rising angles and random distances.
fn star(rng: &mut Pcg64) -> Vec<DVec2> {
    let corners = rng.random_range(4..14);
    let middle = DVec2::new(rng.random_range(-500.0..500.0), rng.random_range(-500.0..500.0));
    (0..corners)
        .map(|i| {
            let angle = (f64::from(i) + rng.random_range(0.0..0.8)) / f64::from(corners)
                * std::f64::consts::TAU;
            middle + DVec2::from_angle(angle) * rng.random_range(4.0..15.0)
        })
        .collect()
}

/// An L, turned.
fn l_shape(rng: &mut Pcg64) -> Vec<DVec2> {
    let (a, b) = (rng.random_range(4.0..10.0), rng.random_range(4.0..10.0));
    let turn = DVec2::from_angle(rng.random_range(0.0..6.3));
    [(0.0, 0.0), (2.0 * a, 0.0), (2.0 * a, b), (a, b), (a, 2.0 * b), (0.0, 2.0 * b)]
        .map(|(x, z)| turn.rotate(DVec2::new(x, z)))
        .to_vec()
}

/// Whether a point is inside a ring, by the angles at which its edges are seen.
fn winds(ring: &[DVec2], p: DVec2) -> bool {
    let edges = ring.iter().zip(ring.iter().cycle().skip(1));
    let angles: f64 = edges.map(|(a, b)| (*a - p).angle_to(*b - p)).sum();
    angles.abs() > std::f64::consts::PI
}

fn inner(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for number in 0..play::cases(context, 24, faulty) {
        let mut rng = input::rng(context.seed, "inner boxes", number);
        let ring = if number % 2 == 0 { star(&mut rng) } else { l_shape(&mut rng) };
        let Ok(footprint) = Footprint::new(&ring, &[], 0.0) else { continue };
        let (base_m, eaves_m) = (rng.random_range(-5.0..5.0), rng.random_range(6.0..30.0));
        let mut boxes = inner_boxes(&footprint, base_m, eaves_m, &InnerKnobs::default());
        let [min, max] = footprint.bounds();
        if faulty {
            let (middle, half) = (0.5 * (min + max), 0.5 * (max - min));
            boxes = vec![city::OrientedBox {
                centre: DVec3::new(middle.x, 0.5 * (base_m + eaves_m), middle.y),
                axis: DVec2::X,
                half: DVec3::new(half.x, 0.5 * (eaves_m - base_m), half.y),
            }];
        }
        let share = covered_share(&footprint, &boxes);
        tally.check(number % 2 == 0 || share > 0.5, || format!("{share} of {ring:?} is covered"));
        for inner in &boxes {
            let corners = inner.corners();
            let upright = corners.iter().all(|c| (base_m..=eaves_m).contains(&c.y));
            tally.check(upright, || format!("{inner:?} from {base_m} to {eaves_m}"));
            let plan = [0, 1, 5, 4].map(|i: usize| DVec2::new(corners[i].x, corners[i].z));
            for (a, b) in plan.iter().zip(plan.iter().cycle().skip(1)) {
                for step in 0..20 {
                    let p = a.lerp(*b, f64::from(step) / 20.0);
                    tally.check(winds(&ring, p), || format!("{p} of {inner:?} leaves {ring:?}"));
                }
            }
        }
    }
    Ok(tally)
}
