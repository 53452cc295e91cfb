//! Cells and lists (rows 14, 16, 28 and 47).

use super::cities::{SMALL, Seen, city};
use crate::{
    SuiteError,
    problems::night_city::NightCase,
    verify::{About, Gate, GateContext, Tally, gate},
};
use dapple_many_lights::{
    self as lights, Point, Technique,
    bound::Region,
    cut::{self, Given},
    region::{Direction, levels_of_detail::brightest, specular::Mirror},
};
use dapple_night_city::{
    Device, Drawer, Front, Night, Pipeline,
    cells::{WholeCells, each},
};
use glam::{DVec3, Vec3};
use rand::RngExt;

/// Cells whose faces are looked at.
const FACES: usize = 12;

/// Half the opening of a lobe, radians.
const LOBE_RAD: f64 = 0.1;

pub fn gates() -> Vec<Gate> {
    let about =
        |name, statement, fault| About { technique: "facade-cluster", name, statement, fault };
    let on_device = gate(
        about(
            "gpu lists",
            "every object starts on the device at the nodes that it does on the processor",
            "the device holds the frame before",
        ),
        on_device,
    );
    vec![
        gate(
            about(
                "cells",
                "every visible object that faces anything lies in exactly one cell and has its list, \
                 and there are no more cells where they may cover more",
                "cells may cover less",
            ),
            cells,
        ),
        gate(
            about(
                "directions",
                "what faces up or down needs all four directions, and a wall along the axes one",
                "one direction is left out",
            ),
            directions,
        ),
        gate(
            about(
                "lists",
                "no list holds a node below another, so that no light counts twice",
                "precuts of the directions are put one behind the other",
            ),
            lists,
        ),
        Gate { needs_gpu: true, ..on_device },
        gate(
            about(
                "brightest",
                "no white point of a cell's face gets more than the bound of what its cell starts at",
                "the bound is a tenth",
            ),
            bright,
        ),
        gate(
            about(
                "mirrored",
                "every light that a point of a face mirrors towards the eye is among those that the \
                 face may mirror",
                "a corner stands for the face, with a lobe a hundredth as wide",
            ),
            mirrored,
        ),
    ]
}

fn cells(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    let case = city(Seen { width: 48, ..SMALL }, context.seed, None)?;
    let mut taus = [256.0, 4096.0, 65_536.0, 524_288.0];
    if faulty {
        taus.reverse();
    }
    let mut before: Option<Vec<u64>> = None;
    for tau_px in taus {
        let night = Night { tau_px, ..Night::default() };
        let mut pipeline = Pipeline::new(&case.night().town, &night, None)?;
        let mut now = Vec::new();
        for index in 0..case.night().town.views.len() {
            let counts = pipeline.frame(index, false)?.counts;
            tally.check(counts.listed == counts.drawn && counts.cells > 0, || {
                format!("tau {tau_px}, frame {index}: {counts:?}")
            });
            now.push(counts.cells);
        }
        for (before, now) in before.iter().flatten().zip(&now) {
            tally.check(now <= before, || format!("tau {tau_px}: {now} cells, {before} before"));
        }
        before = Some(now);
    }
    Ok(tally)
}

fn directions(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    let case = city(SMALL, context.seed, None)?;
    let town = &case.night().town;
    let mut whole = WholeCells::default();
    let (mut flat, mut walls) = (0, 0);
    for node in 0..town.tree.nodes.len() as u32 {
        let cell = whole.of(town, node);
        for object in town.tree.objects_of(node) {
            let surfaces = town.surfaces.of_object(*object);
            let mut count = each(cell.directions(*object)).count();
            if faulty {
                count = count.saturating_sub(1);
            }
            let is_level = |n: DVec3| n.y.abs() == 1.0;
            let is_wall = |n: DVec3| n.y == 0.0 && n.x.abs().max(n.z.abs()) > 1.0 - 1e-12;
            if surfaces.iter().any(|s| is_level(s.normal_axis)) {
                flat += 1;
                tally.check(count == 4, || format!("object {object}: {count} directions"));
            } else if let [wall] = surfaces
                && is_wall(wall.normal_axis)
                && wall.normal_spread_rad == 0.0
            {
                walls += 1;
                tally.check(count == 1, || format!("object {object}: {count} directions"));
            }
        }
    }
    tally.check(flat > 0 && walls > 0, || format!("{flat} level objects, {walls} walls"));
    Ok(tally)
}

fn lists(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    let case = city(SMALL, context.seed, None)?;
    let town = &case.night().town;
    let mut front = front(&case, &Night::default())?;
    for index in 0..town.views.len() {
        front.prepare(index)?;
        for &object in front.drawn() {
            let mut nodes = front.starts().of(object).to_vec();
            if faulty {
                nodes = [&nodes[..], &nodes[..]].concat();
            }
            let end = |node: u32| node + town.lights.nodes[node as usize].size;
            let apart = nodes.windows(2).all(|pair| end(pair[0]) <= pair[1]);
            tally.check(apart, || format!("frame {index}, object {object}"));
        }
    }
    Ok(tally)
}

fn front<'g>(case: &NightCase<'g>, night: &Night) -> Result<Front<'g>, SuiteError> {
    let town = &case.night().town;
    Ok(Front::new(town, night, Drawer::new(&town.objects, None)?)?)
}

fn on_device(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    let gpu = context.gpu.ok_or_else(|| SuiteError::Internal("no graphics device".into()))?;
    let case = city(SMALL, context.seed, None)?;
    let (town, night) = (&case.night().town, Night::default());
    let device = Device::new(gpu, town.world(false))?;
    let given = Given::new(&Technique::Absolute(night.cut), town.world(false), &town.lights)?;
    let mut shading = cut::starting(lights::Form::Gpu, &given, Some(&device.lights))?;
    let mut front = front(&case, &night)?;
    for index in 0..town.views.len() {
        front.prepare(index)?;
        if !faulty || index == 0 {
            shading.start(front.starts())?;
        }
        let held = shading.starts()?;
        for object in 0..town.objects.objects.len() as u32 {
            let same = held.of(object) == front.starts().of(object);
            tally.check(same, || format!("frame {index}: object {object}"));
        }
    }
    Ok(tally)
}

/// Faces of cells of all sizes with their precuts.
fn faces(
    context: &GateContext<'_>,
    mut with: impl FnMut(&NightCase<'_>, &Region, &[u32]) -> Result<(), SuiteError>,
) -> Result<(), SuiteError> {
    let case = city(SMALL, context.seed, None)?;
    let town = &case.night().town;
    let (world, region) = (town.world(false), Night::default().region);
    let mut made = lights::region::make(&region, false, world, &town.lights, &town.occluders)?;
    let (mut whole, mut nodes) = (WholeCells::default(), Vec::new());
    let count = town.tree.nodes.len();
    for node in (0..count as u32).step_by(count.div_ceil(FACES)) {
        let cell = whole.of(town, node);
        for direction in Direction::ALL {
            if let Some(face) = cell.cell.face(direction) {
                made.precut(&cell.cell, direction, &mut nodes);
                with(&case, &face.region, &nodes)?;
            }
        }
    }
    Ok(())
}

fn anywhere(rng: &mut rand_pcg::Pcg64, region: &Region) -> (DVec3, DVec3) {
    let share = DVec3::new(rng.random(), rng.random(), rng.random());
    let place = region.min + share * (region.max - region.min);
    let (u, v) = region.normal_axis.any_orthonormal_pair();
    let side: f64 = rng.random_range(0.0..std::f64::consts::TAU);
    let lean = region.normal_spread_rad * rng.random_range(0.0..1.0);
    let across = u * side.cos() + v * side.sin();
    let normal = region.normal_axis * f64::cos(lean) + across * f64::sin(lean);
    (place.clamp(region.min, region.max), normal.normalize())
}

fn bright(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    let mut rng = crate::verify::rng(context.seed, "brightest", 0);
    faces(context, |case, region, nodes| {
        let town = &case.night().town;
        let world = town.world(false);
        let found = brightest(&town.lights, nodes, region, world.clamp_m, 1e-4);
        let most = if faulty { 0.1 * found.radiance } else { found.radiance };
        for _ in 0..16 {
            let (place, normal) = anywhere(&mut rng, region);
            let (position, normal) = (place.as_vec3(), normal.as_vec3());
            let point = Point { position, normal, albedo: Vec3::ONE, ..Point::default() };
            let mut sum = DVec3::ZERO;
            for &node in nodes {
                let end = node + town.lights.nodes[node as usize].size;
                let below = town.lights.nodes[node as usize..end as usize].iter();
                for leaf in below.filter(|n| n.is_leaf()) {
                    let light = &world.lights[leaf.light as usize];
                    sum += dapple_many_lights::radiance(&point, light, world.clamp_m);
                }
            }
            // Points are rounded to f32.
            let bound = most * (1.0 + 1e-4) + 1e-9;
            tally.within(sum.max_element(), bound, || format!("a face at {}", region.min));
        }
        Ok(())
    })?;
    Ok(tally)
}

fn mirrored(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    let mut rng = crate::verify::rng(context.seed, "mirrored", 0);
    faces(context, |case, region, nodes| {
        let town = &case.night().town;
        let world = town.world(false);
        let eye = world.frames[0].eye.position;
        let corner = Region { max: region.min, ..*region };
        let mirror = match faulty {
            false => Mirror::new(region, [eye; 2], LOBE_RAD, 3)?,
            true => Mirror::new(&corner, [eye; 2], 0.01 * LOBE_RAD, 0)?,
        };
        let mut found = Vec::new();
        mirror.reflected(&town.lights, nodes, &mut found);
        for &node in nodes {
            let end = node + town.lights.nodes[node as usize].size;
            for index in node..end {
                let leaf = &town.lights.nodes[index as usize];
                if !leaf.is_leaf() {
                    continue;
                }
                for _ in 0..4 {
                    let (place, normal) = anywhere(&mut rng, region);
                    let to_eye = (eye - place).normalize_or_zero();
                    let to_light = (leaf.position - place).normalize_or_zero();
                    if to_eye.dot(normal) <= 0.0 || to_light.dot(normal) <= 0.0 {
                        continue;
                    }
                    let mirrored = 2.0 * normal.dot(to_eye) * normal - to_eye;
                    if mirrored.angle_between(to_light) > 0.999 * LOBE_RAD {
                        continue;
                    }
                    let held = found.binary_search(&index).is_ok();
                    tally.check(held, || format!("node {index} from {place}"));
                }
            }
        }
        Ok(())
    })?;
    Ok(tally)
}
