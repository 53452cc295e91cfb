//! What precuts of every technique are: P8, P10, P11, ports, threads.

use super::{
    ALL,
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
use std::sync::Arc;

/// Worlds of a gate, at most: each is asked for by every variant.
pub const WORLDS: u32 = 24;

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

/// Lights that all count.
pub const OMNI: Wanted = Wanted { omni: true, floating: true };
/// Lights of any kind.
pub const ANY: Wanted = Wanted { omni: false, floating: true };

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
        // A raster has so many planes and no more.
        drawn.boxes.truncate(3);
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

fn united(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for number in 0..context.cases.max(WORLDS) {
        let world = worlds::random(context.seed, number, ANY)?;
        let precuts = precuts(&world, settings_of(context, "union", number))?;
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

/// Any sound settings.
pub fn settings_of(context: &GateContext<'_>, gate: &str, number: u32) -> FacadeCluster {
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

/// By direction.
pub fn precuts(world: &World, settings: FacadeCluster) -> Result<[Vec<u32>; 4], SuiteError> {
    let mut made = world.make(&RegionTechnique::FacadeCluster(settings), Form::Cpu)?;
    Ok(Direction::ALL.map(|direction| nodes_of(&mut *made, &world.cell, direction)))
}
