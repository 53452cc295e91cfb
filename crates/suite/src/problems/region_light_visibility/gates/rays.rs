//! P1, the hard one: whatever is left out is seen by no ray from any point of the face.

use super::{
    model::{self, Fault},
    worlds::{self, Wanted, World, nodes_of},
};
use crate::{
    SuiteError,
    problem::{Form, Technique, Variant},
    problems::region_light_visibility::{RegionCase, SPEC, settings},
    verify::{About, Gate, GateContext, Tally, gate, rng},
};
use dapple_many_lights::{
    LightTree,
    region::{
        Direction, OccluderMode, RegionTechnique, combined,
        truth::{Obstacles, Sight, false_culls},
    },
};
use rand::RngExt;
use rand_pcg::Pcg64;
use serde_json::json;

/// Rays of a gate, and how many times as many the deep ones are.
const RAYS: u64 = 120_000;
const DEEP: u64 = 100;

/// Worlds that may be looked at for them, and those of a control.
const WORLDS: u32 = 4000;
const CONTROLS: u32 = 200;

/// Random points of a face for each light, beside those at silhouettes.
const POINTS: u32 = 24;

/// Radiances below which lights do not matter.
const THRESHOLDS: [f64; 3] = [0.0, 1.0 / 1020.0, 1e-2];

/// Whether a technique leaves out what it has proved to be hidden.
pub fn proves(technique: &Technique) -> bool {
    !["all-lights", "sampled"].contains(&technique.id)
}

pub fn gates() -> Vec<Gate> {
    let mut gates = Vec::new();
    for technique in SPEC.techniques.iter().filter(|technique| proves(technique)) {
        let about =
            |name, statement, fault| About { technique: technique.id, name, statement, fault };
        gates.push(gate(
            about(
                "P1 rays",
                "no light that is left out is seen by a ray from a corner, from anywhere, or from \
                 beside a silhouette, at any setting that is sound; counted are rays",
                "a light of each precut is left out",
            ),
            |context, faulty| boxes(technique, None, context, faulty),
        ));
        gates.push(gate(
            about(
                "P1 city",
                "the same in a generated city, and in real ones where the data are at hand, by rays \
                 to its triangles",
                "a light of each precut is left out",
            ),
            |context, faulty| cities(technique, context, faulty),
        ));
    }
    let about =
        |name, statement, fault| About { technique: "facade-cluster", name, statement, fault };
    let statement = "no light that is left out is seen by any ray";
    gates.push(gate(
        about(
            "P1 all corners",
            statement,
            "shadows are those of any corner of the cell, not of all",
        ),
        |context, faulty| faulted(Fault::AnyCorner, context, faulty),
    ));
    gates.push(gate(
        about("P1 highest point", statement, "shadows are as high as for the cell's lowest point"),
        |context, faulty| faulted(Fault::LowestPoint, context, faulty),
    ));
    gates.push(gate(
        about("P1 whole clusters", statement, "clusters are tested by their near face alone"),
        |context, faulty| faulted(Fault::NearFace, context, faulty),
    ));
    gates.push(gate(
        about(
            "P1 boxes inside",
            "boxes inside buildings and gap-free runs of them hide nothing that is seen",
            "boxes are around clusters of buildings (the thesis)",
        ),
        |context, faulty| match faulty {
            false => boxes_of_city(context),
            true => around(context),
        },
    ));
    gates.push(gate(
        about(
            "P1 combined",
            "what surfaces that face all four directions start at holds every light that any ray from \
             them reaches",
            "lights have to be in all precuts, those behind a face too",
        ),
        all_directions,
    ));
    gates
}

fn facade_cluster() -> Result<&'static Technique, SuiteError> {
    SPEC.technique("facade-cluster")
}

/// How many rays, and how many worlds at most.
fn budget(context: &GateContext<'_>, faulty: bool) -> (u64, u32) {
    match (faulty, context.deep) {
        (true, _) => (RAYS, CONTROLS),
        (false, false) => (RAYS, WORLDS),
        (false, true) => (RAYS * DEEP, WORLDS * DEEP as u32),
    }
}

/// Adds a face's rays, and what they found.
fn look(
    tally: &mut Tally,
    sight: &Sight<'_>,
    tree: &LightTree,
    nodes: &[u32],
    (threshold, seed): (f64, u32),
    describe: &dyn Fn() -> String,
) {
    let found = false_culls(sight, tree, nodes, threshold, (POINTS, seed));
    tally.checked += found.rays;
    tally.failed += found.found.len() as u64;
    if let Some(first) = found.found.first()
        && tally.failures.len() < 3
    {
        tally.failures.push(format!(
            "{}: light {} is seen from {}",
            describe(),
            first.light,
            first.from
        ));
    }
}

/// Without one light, if there is any that is lone.
fn without_one(tree: &LightTree, nodes: &mut Vec<u32>) {
    let strongest = |node: &u32| tree.nodes[*node as usize].intensity.element_sum();
    let most =
        (0..nodes.len()).max_by(|a, b| strongest(&nodes[*a]).total_cmp(&strongest(&nodes[*b])));
    most.map(|place| nodes.remove(place));
}

fn variant<'a>(rng: &mut Pcg64, technique: &'a Technique) -> &'a Variant {
    &technique.variants[rng.random_range(0..technique.variants.len())]
}

/// Random worlds of boxes by the technique, or by what has a fault.
fn boxes(
    technique: &Technique,
    fault: Option<Fault>,
    context: &GateContext<'_>,
    faulty: bool,
) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    let (rays, most) = budget(context, faulty);
    for number in 0..most {
        if tally.checked >= rays || faulty && tally.failed > 0 {
            break;
        }
        let mut rng = rng(context.seed, technique.id, number);
        let world = worlds::random(context.seed, number, Wanted { omni: false, floating: true })?;
        let variant = variant(&mut rng, technique).id;
        let setting = worlds::setting(&mut rng, technique, variant, Form::Cpu);
        let threshold = THRESHOLDS[rng.random_range(0..THRESHOLDS.len())];
        let of = settings::technique(&setting, threshold, number)?;
        let mut made = world.make(&of, Form::Cpu)?;
        let boxes = world.occluders.turned(world.cell.turn, OccluderMode::Leaf);
        for direction in Direction::ALL {
            let mut nodes = match (&of, fault.filter(|_| faulty)) {
                (RegionTechnique::FacadeCluster(settings), Some(fault)) => {
                    let asked = (&world.cell, direction);
                    model::precut(&world, asked, settings, fault, 1.0).nodes
                }
                _ => nodes_of(&mut *made, &world.cell, direction),
            };
            if faulty && fault.is_none() {
                without_one(&world.tree, &mut nodes);
            }
            let Some(sight) = world.sight(direction, &boxes.solids) else { continue };
            let describe =
                || format!("world {number}, {direction:?}, {setting} {:?}", setting.knobs);
            look(&mut tally, &sight, &world.tree, &nodes, (threshold, number), &describe);
        }
    }
    Ok(tally)
}

fn faulted(fault: Fault, context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    // A world of its own for each.
    let context = GateContext { seed: context.seed ^ (fault as u64 + 1) << 32, ..*context };
    boxes(facade_cluster()?, Some(fault), &context, faulty)
}

/// Faces of a city by a technique at settings of all variants.
fn city(
    tally: &mut Tally,
    case: &RegionCase,
    technique: &Technique,
    (given, most): (&[(&str, serde_json::Value)], usize),
    (context, faulty): (&GateContext<'_>, bool),
) -> Result<(), SuiteError> {
    let town = &case.night().town;
    let world = town.world(true);
    let mut rng = rng(context.seed, technique.id, 0);
    for variant in technique.variants {
        let mut setting = worlds::setting(&mut rng, technique, variant.id, Form::Cpu);
        for (name, value) in given {
            if let Some(knob) = setting.knobs.get_mut(*name) {
                *knob = value.clone();
            }
        }
        let of = settings::technique(&setting, case.threshold(), 0)?;
        let occluders = case.occluders(&setting)?;
        let lights = dapple_many_lights::region::make(&of, false, world, &town.lights, &occluders);
        let mut made = lights?;
        let questions = &case.frames()[0];
        let step = questions.len().div_ceil(most).max(1);
        for (index, question) in questions.iter().enumerate().step_by(step) {
            let (cell, direction) = question.asked();
            let boxes = town.occluders.turned(cell.turn, OccluderMode::Leaf);
            let obstacles = Obstacles::Triangles(world);
            let sight = Sight::new(world, cell, direction, &boxes.solids, obstacles);
            let Some(sight) = sight else { continue };
            let mut nodes = nodes_of(&mut *made, cell, direction);
            if faulty {
                without_one(&town.lights, &mut nodes);
            }
            let describe = || {
                let scene = &case.night().scene;
                format!("{scene}, face {index}, {setting} {:?}", setting.knobs)
            };
            let threshold = case.threshold();
            look(tally, &sight, &town.lights, &nodes, (threshold, index as u32), &describe);
        }
    }
    Ok(())
}

fn cities(
    technique: &Technique,
    context: &GateContext<'_>,
    faulty: bool,
) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    let faces = match (faulty, context.deep) {
        (true, _) => 4,
        (false, false) => 6,
        (false, true) => 200,
    };
    let with = (context, faulty);
    city(&mut tally, &worlds::generated(context.seed)?, technique, (&[], faces), with)?;
    if !faulty {
        // Real ones have hundreds of planes.
        let given = [("least_step", json!(5.0)), ("planes", json!("far-faces"))];
        let faces = if context.deep { 24 } else { 2 };
        for case in worlds::real()? {
            city(&mut tally, &case, technique, (&given, faces), with)?;
        }
    }
    Ok(tally)
}

/// Buildings of a city, by boxes inside them and by runs.
fn boxes_of_city(context: &GateContext<'_>) -> Result<Tally, SuiteError> {
    occluders(context, &["boxes", "runs", "objects"], 8)
}

/// The same by boxes around clusters.
fn around(context: &GateContext<'_>) -> Result<Tally, SuiteError> {
    occluders(context, &["bounding-boxes"], 40)
}

fn occluders(context: &GateContext<'_>, modes: &[&str], faces: usize) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    let (case, technique) = (worlds::generated(context.seed)?, facade_cluster()?);
    for mode in modes {
        let given = [("occluders", json!(mode)), ("least_step", json!(0.0))];
        city(&mut tally, &case, technique, (&given, faces), (context, false))?;
    }
    Ok(tally)
}

fn all_directions(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    let (rays, most) = budget(context, faulty);
    let technique = facade_cluster()?;
    for number in 0..most {
        if tally.checked >= rays || faulty && tally.failed > 0 {
            break;
        }
        let mut rng = rng(context.seed, "combined", number);
        let world = worlds::random(context.seed, number, Wanted { omni: false, floating: true })?;
        let variant = variant(&mut rng, technique).id;
        let setting = worlds::setting(&mut rng, technique, variant, Form::Cpu);
        let mut made = world.make(&settings::technique(&setting, 0.0, 0)?, Form::Cpu)?;
        let precuts = Direction::ALL.map(|d| nodes_of(&mut *made, &world.cell, d));
        let (mut nodes, mut open) = (Vec::new(), Vec::new());
        match faulty {
            false => {
                let precuts = precuts.each_ref().map(|nodes| &nodes[..]);
                let all = Direction::ALL;
                combined(&world.tree, &world.cell, &all, precuts, &mut nodes, &mut open);
            }
            true => nodes = in_all(&world, &precuts),
        }
        let boxes = world.occluders.turned(world.cell.turn, OccluderMode::Leaf);
        for direction in Direction::ALL {
            let Some(sight) = world.sight(direction, &boxes.solids) else { continue };
            let describe =
                || format!("world {number}, {direction:?}, {setting} {:?}", setting.knobs);
            look(&mut tally, &sight, &world.tree, &nodes, (0.0, number), &describe);
        }
    }
    Ok(tally)
}

/// Leaves that all of some precuts hold.
fn in_all(world: &World, precuts: &[Vec<u32>; 4]) -> Vec<u32> {
    let kept =
        precuts.each_ref().map(|nodes| dapple_many_lights::region::truth::kept(&world.tree, nodes));
    let leaves = world.tree.leaves.iter().enumerate();
    let in_all = leaves.filter(|(light, _)| kept.iter().all(|kept| kept[*light]));
    let mut leaves: Vec<u32> = in_all.map(|(_, leaf)| *leaf).collect();
    leaves.sort_unstable();
    leaves
}
