//! What precuts are, by techniques and settings: P6, P8 to P11, and what they owe each other.

use super::{
    ALL,
    model::{self, Fault},
    rays::proves,
    worlds::{self, Drawn, Wanted, World, nodes_of},
};
use crate::{
    SuiteError,
    problem::{Form, Technique},
    problems::region_light_visibility::{SPEC, settings},
    verify::{About, Gate, GateContext, Tally, gate, rng},
};
use dapple_many_lights::{
    LightTree,
    region::{
        Direction, Edge, FacadeCluster, Fusion, Many, Occluders, RegionTechnique, Split, Steps,
        Turn, make, truth::kept, union,
    },
};
use glam::DVec3;
use rand::RngExt;
use std::{f64::consts::FRAC_PI_2, sync::Arc};

/// Worlds of a gate, at most: each is asked for by every variant.
const WORLDS: u32 = 24;

pub fn gates() -> Vec<Gate> {
    let mut gates = Vec::new();
    for technique in SPEC.techniques {
        let about =
            |name, statement, fault| About { technique: technique.id, name, statement, fault };
        gates.push(gate(
            about(
                "P8 precut",
                "nodes of a precut increase and none lies below another: no light counts twice",
                "the last node's children are put out too",
            ),
            |context, faulty| antichain(technique, context, faulty),
        ));
        gates.push(gate(
            about(
                "P11 steps",
                "every cluster that is strong enough has exactly one test between two planes, and \
                 what tests let pass is what is put out",
                "a cluster's bound is asked for twice",
            ),
            |context, faulty| counted(technique, context, faulty),
        ));
        gates.push(gate(
            about(
                "P10 nothing hides",
                "with nothing to hide them and no threshold, every light in front of a face is kept, \
                 by the roots alone where all are in front",
                "one box hides",
            ),
            |context, faulty| unhidden(technique, context, faulty),
        ));
        gates.push(gate(
            about(
                "threads",
                "precuts and steps are the same bits on 1, 2, 3 and 7 threads, and again",
                "one face less is asked for on several threads",
            ),
            |context, faulty| threads(technique, context, faulty),
        ));
        if technique.variants.iter().any(|v| technique.has(v.id, Form::Reference)) {
            gates.push(gate(
                about(
                    "port",
                    "the fast form finds the very nodes of the reference",
                    "a box is a little larger for the reference",
                ),
                |context, faulty| ported(technique, context, faulty),
            ));
        }
        if proves(technique) {
            gates.push(gate(
                about(
                    "P10 closed wall",
                    "a wall wider than all, taller than cell and lights, hides everything behind it",
                    "there is a slit in it",
                ),
                |context, faulty| walled(technique, context, faulty),
            ));
        }
    }
    let fcv =
        |name, statement, fault| About { technique: "facade-cluster", name, statement, fault };
    gates.push(gate(
        fcv(
            "P1 model",
            "the technique spelled out once more, of which faults are made, is the technique",
            "clusters are tested by their near face alone",
        ),
        modelled,
    ));
    gates.push(gate(
        fcv(
            "P6 monotone",
            "without fusion, a smaller cell or more occluders never bring a light back",
            "the cell is larger",
        ),
        monotone,
    ));
    gates.push(gate(
        fcv(
            "P9 symmetries",
            "without fusion, worlds that are mirrored, turned by a quarter or twice as large keep the \
             same lights",
            "the mirrored world is asked for the direction of the other",
        ),
        symmetric,
    ));
    gates.push(gate(
        fcv(
            "fusion",
            "what is hidden without fusion is hidden with it, and in order of height shadows hide no \
             less on the whole than as they come",
            "without fusion and with it change places",
        ),
        fused,
    ));
    gates.push(gate(
        fcv(
            "weak",
            "clusters that are left out for being weak give less than the threshold to any white \
             point of the face",
            "the threshold is ten times as high",
        ),
        weak,
    ));
    gates.push(gate(
        fcv(
            "cached",
            "projections that are kept change no node, and there are fewer of them",
            "they are not kept",
        ),
        cached,
    ));
    gates.push(gate(
        About {
            technique: ALL,
            name: "P8 union",
            statement: "the union of several directions' precuts holds no node below another, and just \
                        the lights that any of them holds",
            fault: "nodes below others are left in",
        },
        united,
    ));
    gates
}

const OMNI: Wanted = Wanted { omni: true, floating: true };
const ANY: Wanted = Wanted { omni: false, floating: true };

/// Number of worlds: a control's fewer.
fn cases(context: &GateContext<'_>, faulty: bool) -> u32 {
    context.cases.min(WORLDS).min(if faulty { 6 } else { WORLDS })
}

/// A technique at any setting of each variant in some worlds.
fn each(
    technique: &Technique,
    (context, faulty): (&GateContext<'_>, bool),
    gate: &str,
    mut with: impl FnMut(&World, &RegionTechnique, &str) -> Result<(), SuiteError>,
) -> Result<(), SuiteError> {
    for number in 0..cases(context, faulty) {
        let world = worlds::random(context.seed, number, ANY)?;
        for variant in technique.variants {
            let mut rng = rng(context.seed, gate, number);
            let setting = worlds::setting(&mut rng, technique, variant.id, Form::Cpu);
            let of = settings::technique(&setting, [0.0, 1e-3][number as usize % 2], number)?;
            with(&world, &of, &format!("world {number}, {setting} {:?}", setting.knobs))?;
        }
    }
    Ok(())
}

fn is_antichain(tree: &LightTree, nodes: &[u32]) -> bool {
    let end = |node: u32| node + tree.nodes[node as usize].size;
    nodes.array_windows().all(|[a, b]| end(*a) <= *b)
        && nodes.iter().all(|node| (*node as usize) < tree.nodes.len())
}

fn antichain(
    technique: &Technique,
    context: &GateContext<'_>,
    faulty: bool,
) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    each(technique, (context, faulty), "P8", |world, of, what| {
        let mut made = world.make(of, Form::Cpu)?;
        for direction in Direction::ALL {
            let mut nodes = nodes_of(&mut *made, &world.cell, direction);
            let inner = |node: &u32| world.tree.nodes[*node as usize].size > 1;
            if faulty && nodes.last().is_some_and(inner) {
                nodes.extend(nodes.last().map(|node| node + 1));
            }
            tally.check(is_antichain(&world.tree, &nodes), || format!("{what}: {nodes:?}"));
        }
        Ok(())
    })?;
    Ok(tally)
}

fn counted(
    technique: &Technique,
    context: &GateContext<'_>,
    faulty: bool,
) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    each(technique, (context, faulty), "P11", |world, of, what| {
        let mut made = world.make(of, Form::Cpu)?;
        let mut output = 0;
        for direction in Direction::ALL {
            output += nodes_of(&mut *made, &world.cell, direction).len() as u64;
        }
        let mut steps: Steps = *made.steps();
        steps.potential += u64::from(faulty);
        tally.check(steps.is_consistent(), || format!("{what}: {steps:?}"));
        let counts = steps.output == output && steps.evaluations == 4;
        tally.check(counts, || format!("{what}: {output} nodes, {steps:?}"));
        if let RegionTechnique::FacadeCluster(_) = of {
            let passed = steps.last - steps.last_culled - steps.last_divided;
            let put_out = steps.last_output == passed && passed == output;
            tally.check(put_out, || format!("{what}: {output} nodes, {steps:?}"));
        }
        Ok(())
    })?;
    Ok(tally)
}

fn unhidden(
    technique: &Technique,
    context: &GateContext<'_>,
    faulty: bool,
) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for number in 0..cases(context, faulty) {
        let mut rng = rng(context.seed, "P10", number);
        let mut drawn = worlds::drawn(&mut rng, OMNI);
        drawn.boxes.clear();
        if number % 2 == 0 {
            // All in front of one side.
            let front = drawn.cell[1].x;
            drawn.lights.iter_mut().for_each(|l| l.position.x = front + 1.0 + l.position.x.abs());
        }
        let mut world = drawn.world(Turn::NONE, 1.0)?;
        if faulty {
            hide(&mut world, technique);
        }
        for variant in technique.variants {
            let setting = worlds::setting(&mut rng, technique, variant.id, Form::Cpu);
            let of = settings::technique(&setting, 0.0, number)?;
            let mut made = world.make(&of, Form::Cpu)?;
            for direction in Direction::ALL {
                let nodes = nodes_of(&mut *made, &world.cell, direction);
                let kept = kept(&world.tree, &nodes);
                let Some(face) = world.face(direction) else { continue };
                let in_front = |light: usize| {
                    let at = world.world.lights[light].position;
                    direction.cuboid(at, at).w[0] > face.w[0]
                };
                for (light, kept) in kept.iter().enumerate() {
                    let right = *kept || !in_front(light);
                    tally.check(right, || format!("world {number}, {setting}: light {light}"));
                }
                if (0..kept.len()).all(in_front) {
                    tally.check(nodes == world.tree.roots, || {
                        format!("world {number}, {setting}: {nodes:?} for the roots")
                    });
                }
            }
        }
    }
    Ok(tally)
}

/// Puts something before all lights: boxes for those that prove, fewer lights for the others.
fn hide(world: &mut World, technique: &Technique) {
    match proves(technique) {
        true => {
            let at = world.cell.faces[0].map_or(0.0, |face| face.max.x);
            let min = DVec3::new(at + 0.25, -1e3, -1e3);
            let wall = worlds::upright([min, DVec3::new(at + 0.5, 1e3, 1e3)]);
            world.occluders = Arc::new(Occluders::of_boxes(vec![wall]));
        }
        false => {
            world.tree = {
                let mut tree = (*world.tree).clone();
                tree.roots.clear();
                for node in &mut tree.nodes {
                    node.min.x = f64::NEG_INFINITY;
                    node.max.x = f64::NEG_INFINITY;
                }
                Arc::new(tree)
            }
        }
    }
}

fn threads(
    technique: &Technique,
    context: &GateContext<'_>,
    faulty: bool,
) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    each(technique, (context, faulty), "threads", |world, of, what| {
        let asked = Direction::ALL.map(|direction| (&world.cell, direction));
        let on = |threads: usize, wrong: bool| -> Result<(Vec<Vec<u32>>, Steps), SuiteError> {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            let pool = pool.map_err(|error| SuiteError::Internal(error.to_string()))?;
            pool.install(|| {
                let mut many =
                    Many::new(|| make(of, false, &world.world, &world.tree, &world.occluders))?;
                let mut precuts = Vec::new();
                let mut asked = asked.to_vec();
                if wrong {
                    asked.pop();
                }
                many.all(&asked, &mut precuts);
                let steps = many.steps();
                let first = precuts.clone();
                many.all(&asked, &mut precuts);
                match first == precuts {
                    true => Ok((precuts, steps)),
                    false => Err(SuiteError::Internal(format!("{what}: not the same again"))),
                }
            })
        };
        let alone = on(1, false)?;
        for threads in [2, 3, 7] {
            let same = on(threads, faulty)? == alone;
            tally.check(same, || format!("{what}: {threads} threads"));
        }
        Ok(())
    })?;
    Ok(tally)
}

/// The same with every box larger by a twentieth.
fn larger(drawn: &Drawn) -> Drawn {
    let grown = |[min, max]: &[DVec3; 2]| [*min, *max + 0.05 * (*max - *min) + 0.01];
    Drawn { boxes: drawn.boxes.iter().map(grown).collect(), ..drawn.clone() }
}

fn ported(
    technique: &Technique,
    context: &GateContext<'_>,
    faulty: bool,
) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for number in 0..context.cases.min(if faulty { 6 } else { 4 * WORLDS }) {
        let mut rng = rng(context.seed, "port", number);
        let drawn = worlds::drawn(&mut rng, ANY);
        let turn = Turn::degrees(if number % 3 == 0 { 31 } else { 0 });
        let world = drawn.world(turn, 1.0)?;
        let theirs =
            if faulty { larger(&drawn).world(turn, 1.0)? } else { drawn.world(turn, 1.0)? };
        for variant in technique.variants.iter().filter(|v| technique.has(v.id, Form::Reference)) {
            let setting = worlds::setting(&mut rng, technique, variant.id, Form::Cpu);
            let of = settings::technique(&setting, [0.0, 1e-3][number as usize % 2], number)?;
            let (mut fast, mut clear) =
                (world.make(&of, Form::Cpu)?, theirs.make(&of, Form::Reference)?);
            for direction in Direction::ALL {
                let ours = nodes_of(&mut *fast, &world.cell, direction);
                let nodes = nodes_of(&mut *clear, &theirs.cell, direction);
                tally.check(ours == nodes, || {
                    format!(
                        "world {number}, {setting} {:?}: {ours:?}, not {nodes:?}",
                        setting.knobs
                    )
                });
            }
        }
    }
    Ok(tally)
}

fn walled(
    technique: &Technique,
    context: &GateContext<'_>,
    faulty: bool,
) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for number in 0..cases(context, faulty) {
        let mut rng = rng(context.seed, "wall", number);
        let mut drawn = worlds::drawn(&mut rng, OMNI);
        let [_, max] = drawn.cell;
        // Behind it, and lower.
        let behind = max.x + rng.random_range(0.5..4.0);
        let thick = rng.random_range(0.0..2.0);
        for light in &mut drawn.lights {
            light.position.x = behind + thick + light.position.x.abs() + 0.1;
        }
        let wall = |z: [f64; 2]| {
            let low = DVec3::new(behind, -100.0, z[0]);
            [low, DVec3::new(behind + thick, 50.0, z[1])]
        };
        match faulty {
            true => drawn.boxes.extend([wall([-1e4, max.z]), wall([max.z + 1.0, 1e4])]),
            false => drawn.boxes.push(wall([-1e4, 1e4])),
        }
        let world = drawn.world(Turn::NONE, 1.0)?;
        for variant in technique.variants {
            let mut setting = worlds::setting(&mut rng, technique, variant.id, Form::Cpu);
            if let Some(planes) = setting.knobs.get_mut("planes") {
                *planes = "far-faces".into();
            }
            if let Some(step) = setting.knobs.get_mut("least_step") {
                *step = 0.0.into();
            }
            let mut made = world.make(&settings::technique(&setting, 0.0, number)?, Form::Cpu)?;
            let nodes = nodes_of(&mut *made, &world.cell, Direction::PlusX);
            tally.check(nodes.is_empty(), || format!("world {number}, {setting}: {nodes:?}"));
        }
    }
    Ok(tally)
}

fn facade_cluster(context: &GateContext<'_>, gate: &str, number: u32) -> FacadeCluster {
    let mut rng = rng(context.seed, gate, number);
    FacadeCluster {
        fusion: [Fusion::None, Fusion::Insertion, Fusion::HeightOrdered][rng.random_range(0..3)],
        edge: [Edge::Flat, Edge::Sloped, Edge::Hull][rng.random_range(0..3)],
        split: [Split::All, Split::Levels(rng.random_range(0..4))][rng.random_range(0..2)],
        threshold: [0.0, 1e-3, 1e-2][rng.random_range(0..3)],
        least_step_m: [0.0, 2.0][rng.random_range(0..2)],
        cached: rng.random_bool(0.5),
        ..FacadeCluster::default()
    }
}

fn precuts(world: &World, settings: FacadeCluster) -> Result<[Vec<u32>; 4], SuiteError> {
    let mut made = world.make(&RegionTechnique::FacadeCluster(settings), Form::Cpu)?;
    Ok(Direction::ALL.map(|direction| nodes_of(&mut *made, &world.cell, direction)))
}

fn modelled(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for number in 0..context.cases.max(WORLDS) {
        let world = worlds::random(context.seed, number, ANY)?;
        let settings = facade_cluster(context, "model", number);
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

/// Flat shadows, each on its own, down to single lights.
const ALONE: FacadeCluster = FacadeCluster {
    fusion: Fusion::None,
    edge: Edge::Flat,
    occluders: dapple_many_lights::region::OccluderMode::Leaf,
    planes: dapple_many_lights::region::Planes::FarFaces,
    least_step_m: 0.0,
    threshold: 0.0,
    split: Split::All,
    cached: false,
};

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
        let settings = facade_cluster(context, "cached", number);
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

fn united(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for number in 0..context.cases.max(WORLDS) {
        let world = worlds::random(context.seed, number, ANY)?;
        let precuts = precuts(&world, facade_cluster(context, "union", number))?;
        let lists = precuts.each_ref().map(|nodes| &nodes[..]);
        let mut nodes = Vec::new();
        union(&lists, |node| world.tree.nodes[node as usize].size, &mut nodes);
        if faulty {
            nodes = lists.concat();
            nodes.sort_unstable();
        }
        tally.check(is_antichain(&world.tree, &nodes), || format!("world {number}: {nodes:?}"));
        let of_all = kept(&world.tree, &nodes);
        let each = precuts.each_ref().map(|nodes| kept(&world.tree, nodes));
        for (light, found) in of_all.iter().enumerate() {
            let any = each.iter().any(|kept| kept[light]);
            tally.check(*found == any, || format!("world {number}: light {light}"));
        }
    }
    Ok(tally)
}
