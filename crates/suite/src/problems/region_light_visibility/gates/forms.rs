//! Facade-cluster visibility by its settings: P6, P9, and what variants owe each other.

use super::{
    model::{self, Fault},
    precuts::{ANY, OMNI, WORLDS, precuts, settings_of},
    worlds::{self, Drawn, Wanted, World, nodes_of},
};
use crate::{
    SuiteError,
    problem::Form,
    verify::{About, Gate, GateContext, Tally, gate, rng},
};
use dapple_many_lights::region::{
    Direction, Edge, FacadeCluster, Fusion, OccluderMode, Planes, RegionTechnique, Split, Turn,
    truth::kept,
};
use glam::DVec3;
use rand::RngExt;
use std::f64::consts::FRAC_PI_2;

pub fn gates() -> Vec<Gate> {
    let fcv =
        |name, statement, fault| About { technique: "facade-cluster", name, statement, fault };
    vec![
        gate(
            fcv(
                "P1 model",
                "the technique spelled out once more, of which faults are made, is the technique",
                "clusters are tested by their near face alone",
            ),
            modelled,
        ),
        gate(
            fcv(
                "P6 monotone",
                "without fusion, a smaller cell or more occluders never bring a light back",
                "the cell is larger",
            ),
            monotone,
        ),
        gate(
            fcv(
                "P9 symmetries",
                "without fusion, worlds that are mirrored, turned by a quarter or twice as large keep the \
             same lights",
                "the mirrored world is asked for the direction of the other",
            ),
            symmetric,
        ),
        gate(
            fcv(
                "fusion",
                "what is hidden without fusion is hidden with it, and in order of height shadows hide no \
             less on the whole than as they come",
                "without fusion and with it change places",
            ),
            fused,
        ),
        gate(
            fcv(
                "weak",
                "clusters that are left out for being weak give less than the threshold to any white \
             point of the face",
                "the threshold is ten times as high",
            ),
            weak,
        ),
        gate(
            fcv(
                "cached",
                "projections that are kept change no node, and there are fewer of them",
                "they are not kept",
            ),
            cached,
        ),
    ]
}

/// Flat shadows, each on its own, down to single lights.
const ALONE: FacadeCluster = FacadeCluster {
    fusion: Fusion::None,
    edge: Edge::Flat,
    occluders: OccluderMode::Leaf,
    planes: Planes::FarFaces,
    least_step_m: 0.0,
    threshold: 0.0,
    split: Split::All,
    cached: false,
};

fn modelled(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for number in 0..context.cases.max(WORLDS) {
        let world = worlds::random(context.seed, number, ANY)?;
        let settings = settings_of(context, "model", number);
        let fault = if faulty { Fault::NearFace } else { Fault::None };
        for (direction, nodes) in Direction::ALL.iter().zip(precuts(&world, settings)?) {
            let model = model::precut(&world, (&world.cell, *direction), &settings, fault, 1.0);
            tally.check(model.nodes == nodes, || {
                format!("world {number}, {settings:?}: {:?} for {nodes:?}", model.nodes)
            });
        }
    }
    Ok(tally)
}

fn lights(world: &World, settings: FacadeCluster) -> Result<[Vec<bool>; 4], SuiteError> {
    Ok(precuts(world, settings)?.map(|nodes| kept(&world.tree, &nodes)))
}

fn monotone(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for number in 0..context.cases.max(WORLDS) {
        let mut rng = rng(context.seed, "P6", number);
        let drawn = worlds::drawn(&mut rng, OMNI);
        let [min, max] = drawn.cell;
        // Not flat unless it was: of what a flat cell touches only the far face counts.
        let mut share = || f64::from(rng.random_range(0..3)) / 4.0;
        let low = min + (max - min) * DVec3::new(share(), share(), share());
        let high = max - (max - min) * DVec3::new(share(), share(), share()) / 4.0;
        let small = match faulty {
            true => [min - 2.0, max + 2.0],
            false => [low, high],
        };
        let smaller = Drawn { cell: small, ..drawn.clone() };
        let mut more = drawn.clone();
        let others = worlds::drawn(&mut rng, OMNI).boxes;
        more.boxes.extend(others.into_iter().take(5));
        let whole = drawn.world(Turn::NONE, 1.0)?;
        let kept = lights(&whole, ALONE)?;
        for (what, other) in [("smaller", &smaller), ("more", &more)] {
            let other = other.world(Turn::NONE, 1.0)?;
            for (at, now) in lights(&other, ALONE)?.iter().enumerate() {
                let direction = Direction::ALL[at];
                let Some(face) = whole.face(direction) else { continue };
                for (light, now) in now.iter().enumerate() {
                    // A smaller cell has more lights in front of it.
                    let place = whole.world.lights[light].position;
                    let in_front = direction.cuboid(place, place).w[0] > face.w[0];
                    let right = !now || kept[at][light] || !in_front;
                    tally.check(right, || format!("world {number}, {what}: light {light}"));
                }
            }
        }
    }
    Ok(tally)
}

fn symmetric(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    let mirror = |v: DVec3| DVec3::new(-v.x, v.y, v.z);
    let quarter = |v: DVec3| DVec3::new(-v.z, v.y, v.x);
    for number in 0..context.cases.max(WORLDS) {
        let mut rng = rng(context.seed, "P9", number);
        let drawn = worlds::drawn(&mut rng, OMNI);
        let by = |f: &dyn Fn(DVec3) -> DVec3| {
            let corners = |[a, b]: [DVec3; 2]| {
                let (a, b) = (f(a), f(b));
                [a.min(b), a.max(b)]
            };
            let mut other = drawn.clone();
            other.boxes = drawn.boxes.iter().map(|b| corners(*b)).collect();
            other.cell = corners(drawn.cell);
            for light in &mut other.lights {
                (light.position, light.axis) = (f(light.position), f(light.axis));
            }
            other
        };
        use Direction::{MinusX, MinusZ, PlusX, PlusZ};
        let mirrored = if faulty { Direction::ALL } else { [MinusX, PlusX, PlusZ, MinusZ] };
        let world = drawn.world(Turn::NONE, 1.0)?;
        let kept = lights(&world, ALONE)?;
        let scale = [2.0, 0.25, 1024.0][rng.random_range(0..3)];
        for (what, other, scale, directions) in [
            ("mirrored", by(&mirror), 1.0, mirrored),
            // What lay towards +x lies towards +z.
            ("turned", by(&quarter), 1.0, [PlusZ, MinusZ, MinusX, PlusX]),
            ("scaled", drawn.clone(), scale, Direction::ALL),
        ] {
            let others = lights(&other.world(Turn::NONE, scale)?, ALONE)?;
            for (at, direction) in directions.into_iter().enumerate() {
                // Of what lies behind, clusters are put out as the tree has them.
                let from = Direction::ALL[at];
                let rear = world.face(from).map_or(f64::INFINITY, |face| face.w[0]);
                for (light, of) in world.world.lights.iter().enumerate() {
                    let in_front = from.cuboid(of.position, of.position).w[0] > rear;
                    let same = others[direction.index()][light] == kept[at][light];
                    tally.check(same || !in_front, || {
                        format!("world {number}, {what}: {direction:?}, light {light}")
                    });
                }
            }
        }
    }
    Ok(tally)
}

fn fused(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    let mut culled = [0_usize; 3];
    for number in 0..context.cases.max(WORLDS) {
        let mut rng = rng(context.seed, "fusion", number);
        let world = worlds::drawn(&mut rng, Wanted { omni: true, floating: false });
        let world = world.world(Turn::NONE, 1.0)?;
        let of = |fusion| lights(&world, FacadeCluster { fusion, ..ALONE });
        let mut all = [of(Fusion::None)?, of(Fusion::Insertion)?, of(Fusion::HeightOrdered)?];
        if faulty {
            all.swap(0, 1);
        }
        for (sum, kept) in culled.iter_mut().zip(&all) {
            *sum += kept.iter().flatten().filter(|kept| !**kept).count();
        }
        for direction in 0..4 {
            for light in 0..world.world.lights.len() {
                let [alone, insertion, ordered] = all.each_ref().map(|k| k[direction][light]);
                let right = alone || !(insertion || ordered);
                tally.check(right, || format!("world {number}: light {light} comes back"));
            }
        }
    }
    let [_, insertion, ordered] = culled;
    tally.check(ordered >= insertion, || {
        format!("culled: {ordered} in order, {insertion} as they come")
    });
    Ok(tally)
}

fn weak(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    let thresholds = if faulty { 10.0 } else { 1.0 };
    for number in 0..context.cases.max(WORLDS) {
        let mut rng = rng(context.seed, "weak", number);
        let world = worlds::drawn(&mut rng, ANY).world(Turn::NONE, 1.0)?;
        let settings = FacadeCluster { threshold: 0.02, ..ALONE };
        for direction in Direction::ALL {
            let asked = (&world.cell, direction);
            let found = model::precut(&world, asked, &settings, Fault::None, thresholds);
            let Some(face) = world.cell.face(direction) else { continue };
            for _ in 0..8 {
                let share = DVec3::new(rng.random(), rng.random(), rng.random());
                let at = face.min + share * (face.max - face.min);
                let (around, up) =
                    (rng.random_range(0.0..4.0 * FRAC_PI_2), rng.random_range(-1.0..1.0));
                let flat = f64::sqrt(1.0_f64 - up * up);
                let normal = DVec3::new(flat * f64::cos(around), up, flat * f64::sin(around));
                let point = dapple_many_lights::Point {
                    position: at.as_vec3(),
                    normal: normal.as_vec3(),
                    albedo: glam::Vec3::ONE,
                    ..Default::default()
                };
                for &node in &found.weak {
                    let end = node + world.tree.nodes[node as usize].size;
                    let leaves = world.tree.nodes[node as usize..end as usize].iter();
                    let gives = leaves.filter(|n| n.is_leaf()).map(|n| {
                        let light = &world.world.lights[n.light as usize];
                        dapple_many_lights::radiance(&point, light, world.world.clamp_m)
                    });
                    let most = gives.sum::<DVec3>().max_element();
                    tally.within(most, settings.threshold, || {
                        format!("world {number}: node {node}")
                    });
                }
            }
        }
    }
    Ok(tally)
}

fn cached(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    let (mut anew, mut again) = (0, 0);
    for number in 0..context.cases.max(WORLDS) {
        let world = worlds::random(context.seed, number, ANY)?;
        let settings = settings_of(context, "cached", number);
        let of = |cached: bool| -> Result<_, SuiteError> {
            let settings = FacadeCluster { cached, ..settings };
            let mut made = world.make(&RegionTechnique::FacadeCluster(settings), Form::Cpu)?;
            let nodes = Direction::ALL.map(|d| nodes_of(&mut *made, &world.cell, d));
            let steps = *made.steps();
            Ok((nodes, steps.last_projected + steps.early_projected))
        };
        let ((nodes, more), (same, fewer)) = (of(false)?, of(!faulty)?);
        tally.check(nodes == same, || format!("world {number}: other nodes"));
        tally.check(fewer <= more, || format!("world {number}: {fewer} projections, not {more}"));
        (anew, again) = (anew + more, again + fewer);
    }
    tally.check(again < anew, || format!("{again} projections for {anew}"));
    Ok(tally)
}
