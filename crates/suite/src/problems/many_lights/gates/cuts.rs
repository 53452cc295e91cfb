//! Cuts of the techniques that make them: what they cover, how wrong they can be, how they begin.

use super::{
    hard::{self, CLAMP_M, Case},
    input,
};
use crate::{
    SuiteError,
    problem::{Form, Technique},
    problems::many_lights::{SPEC, settings},
    verify::{About, Gate, GateContext, Tally, gate},
};
use dapple_many_lights::{
    LightTree, Lightcuts, Node,
    bound::{self, Region},
    cut::{self, Given, Member, Method, Open, Receiver, Starts, children, walk},
};
use glam::DVec3;
use rand::RngExt;
use rand_pcg::Pcg64;

/// Trees for each case that is asked for.
const TIMES: u32 = 12;

/// Lights of a tree.
const LIGHTS: usize = 40;

/// Share by which sums of some numbers in another order may differ.
const ROUNDING: f64 = 1e-12;

pub fn gates() -> Vec<Gate> {
    let mut gates = Vec::new();
    for technique in SPEC.techniques.iter().filter(|technique| cuts(technique)) {
        let about =
            |name, statement, fault| About { technique: technique.id, name, statement, fault };
        gates.push(gate(
            about(
                "P15 cover",
                "no node of a cut lies below another, and every light is below or in exactly one",
                "subtrees are skipped by one node less than they have",
            ),
            |context, faulty| covered(technique, context, faulty),
        ));
        gates.push(gate(
            about(
                "P16 error",
                "estimates lie within 0 and their bounds, and the error is at most the sum of the \
                 bounds of the cut's clusters",
                "estimates are three times as high",
            ),
            |context, faulty| bounded(technique, context, faulty),
        ));
        gates.push(gate(
            about(
                "P16 sum of bounds",
                "the error is at most the sum of the bounds of the cut's clusters",
                "clusters count as exact",
            ),
            |context, faulty| summed(technique, context, faulty),
        ));
        gates.push(gate(
            about(
                "P19 siblings",
                "the order of siblings changes the sum by rounding alone",
                "a node's last child is lost as they are reversed",
            ),
            |context, faulty| siblings(technique, context, faulty),
        ));
        gates.push(gate(
            about(
                "P18 roots",
                "a list of starts that holds the roots gives the same bits as none, and an empty one \
                 nothing",
                "the list lacks the roots' first children",
            ),
            |context, faulty| roots(technique, context, faulty),
        ));
    }
    gates
}

fn cuts(technique: &Technique) -> bool {
    let setting = input::default_setting(technique, Form::Cpu, &[]);
    // A technique whose defaults are refused gets all gates, and they say so.
    setting.and_then(|s| settings::technique(&s)).map_or(true, |t| Method::of(&t).is_some())
}

/// How a technique of any variant and settings cuts.
pub fn method(rng: &mut Pcg64, technique: &Technique) -> Result<Method, SuiteError> {
    let variant = technique.variants[rng.random_range(0..technique.variants.len())].id;
    let mut setting = input::setting(rng, technique, variant, Form::Reference);
    // All and nothing too.
    if rng.random_bool(0.2)
        && let Some(value) = setting.knobs.get_mut("threshold")
    {
        *value = [0.0, 1e9][rng.random_range(0..2)].into();
    }
    let drawn = settings::technique(&setting)?;
    Method::of(&drawn).ok_or_else(|| SuiteError::Internal(format!("{setting} makes no cuts")))
}

fn member(case: &Case, form: dapple_many_lights::BoundForm, index: u32) -> Member {
    let node = &case.tree.nodes[index as usize];
    let estimate = bound::estimate(node, &case.point, CLAMP_M);
    let bound = match node.is_leaf() {
        true => 0.0,
        false => bound::point(form, node, &case.point, CLAMP_M),
    };
    Member { node: index, estimate, bound }
}

/// The cut by a tree whose sizes may be wrong: its members as the case's own tree has them, in order.
pub fn cut_by(case: &Case, tree: &LightTree, method: Method) -> Vec<Member> {
    let mut members = Vec::new();
    match method {
        Method::Rule(rule, form) => {
            let receiver = Receiver { point: &case.point, form, clamp_m: CLAMP_M };
            walk(tree, &tree.roots, |index, node| {
                let look = rule.look(node, &receiver);
                if look.taken {
                    members.push(member(case, form, index));
                }
                look.taken
            });
        }
        Method::Tile { threshold, form } => {
            // A tile of this point and one beside it.
            let mut beside = case.point;
            beside.position += beside.normal.any_orthonormal_vector();
            let points = [case.point, beside];
            let Some(region) = Region::of(points.iter()) else { return members };
            walk(tree, &tree.roots, |index, node| {
                let bound = bound::region(form, node, &region, CLAMP_M);
                let taken = node.is_leaf() || bound <= threshold;
                if taken {
                    let own = member(case, form, index);
                    let bound = if node.is_leaf() { 0.0 } else { bound };
                    members.push(Member { bound, ..own });
                }
                taken
            });
        }
        Method::Worst(settings) => return worst_first(case, tree, &settings).1,
    }
    members
}

/// The cut of the worst node first, and what it came out as.
pub fn worst_first(
    case: &Case,
    tree: &LightTree,
    settings: &Lightcuts,
) -> (cut::Found, Vec<Member>) {
    let mut members = Vec::new();
    let mut open = Open::new(settings.selection, 0);
    let size = |node: u32| tree.nodes[node as usize].size;
    let found = cut::cut(
        settings,
        &tree.roots,
        size,
        |index| member(case, settings.bound, index),
        |leaf| members.push(*leaf),
        &mut open,
    );
    members.extend(open.members());
    members.sort_by_key(|member| member.node);
    (found, members)
}

/// Runs `check` on random cases and cuts of a technique.
fn over_cuts(
    technique: &Technique,
    name: &str,
    context: &GateContext<'_>,
    mut check: impl FnMut(&Case, Method, &mut Tally),
) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for number in 0..context.cases * TIMES {
        let case = hard::case(context.seed, name, number, LIGHTS)?;
        let method = method(&mut input::rng(context.seed, technique.id, number), technique)?;
        check(&case, method, &mut tally);
    }
    Ok(tally)
}

fn covered(
    technique: &Technique,
    context: &GateContext<'_>,
    faulty: bool,
) -> Result<Tally, SuiteError> {
    over_cuts(technique, "P15", context, |case, method, tally| {
        let mut tree = case.tree.clone();
        if faulty {
            tree.nodes.iter_mut().filter(|n| n.size > 2).for_each(|node| node.size -= 1);
        }
        let mut times = vec![0; case.tree.nodes.len()];
        for Member { node, .. } in cut_by(case, &tree, method) {
            let below = node..node + case.tree.nodes[node as usize].size;
            below.for_each(|node| times[node as usize] += 1);
        }
        for (node, times) in times.iter().enumerate().filter(|(n, _)| case.tree.nodes[*n].is_leaf())
        {
            tally
                .check(*times == 1, || format!("{method:?}: leaf {node} is covered {times} times"));
        }
    })
}

/// Whether a cut's sum is as near to the truth as its bounds say.
fn holds(case: &Case, members: &[Member], tally: &mut Tally) {
    let truth = case.truth();
    let sum: DVec3 = members.iter().map(|member| member.estimate).sum();
    let bounds: f64 = members.iter().map(|member| member.bound).sum();
    let error = (sum - truth).abs().max_element();
    let rounding = ROUNDING * truth.max_element().max(sum.max_element());
    tally.check(error <= bounds + rounding, || format!("off by {error}, bounded by {bounds}"));
}

fn bounded(
    technique: &Technique,
    context: &GateContext<'_>,
    faulty: bool,
) -> Result<Tally, SuiteError> {
    over_cuts(technique, "P16", context, |case, method, tally| {
        let mut members = cut_by(case, &case.tree, method);
        for member in &mut members {
            member.estimate *= if faulty { 3.0 } else { 1.0 };
            if !case.tree.nodes[member.node as usize].is_leaf() {
                let Member { node, estimate, bound } = *member;
                let within = estimate.min_element() >= 0.0 && estimate.max_element() <= bound;
                tally.check(within, || format!("node {node}: {estimate} is not in 0..={bound}"));
            }
        }
        holds(case, &members, tally);
    })
}

fn summed(
    technique: &Technique,
    context: &GateContext<'_>,
    faulty: bool,
) -> Result<Tally, SuiteError> {
    over_cuts(technique, "P16 sum", context, |case, method, tally| {
        let mut members = cut_by(case, &case.tree, method);
        if faulty {
            members.iter_mut().for_each(|member| member.bound = 0.0);
        }
        holds(case, &members, tally);
    })
}

/// The tree with the children of every node in the opposite order, or with the last of them lost.
fn mirrored(tree: &LightTree, losing: bool) -> LightTree {
    fn put(tree: &LightTree, losing: bool, node: u32, nodes: &mut Vec<Node>) {
        let place = nodes.len();
        nodes.push(tree.nodes[node as usize]);
        let below: Vec<u32> = children(node, |n| tree.nodes[n as usize].size).collect();
        let lost = usize::from(losing && below.len() > 1);
        for &child in below.iter().rev().skip(lost) {
            put(tree, losing, child, nodes);
        }
        nodes[place].size = (nodes.len() - place) as u32;
    }
    let (mut nodes, mut roots) = (Vec::new(), Vec::new());
    for &root in &tree.roots {
        roots.push(nodes.len() as u32);
        put(tree, losing, root, &mut nodes);
    }
    LightTree { nodes, roots, leaves: tree.leaves.clone() }
}

fn siblings(
    technique: &Technique,
    context: &GateContext<'_>,
    faulty: bool,
) -> Result<Tally, SuiteError> {
    over_cuts(technique, "P19", context, |case, method, tally| {
        // Of nodes with equal bounds the first is split first, another one where they are mirrored:
        // cuts of the worst node agree where nothing is left to split.
        let method = match method {
            Method::Worst(settings) => {
                Method::Worst(Lightcuts { epsilon: 0.0, most: u32::MAX, ..settings })
            }
            other => other,
        };
        let tree = mirrored(&case.tree, faulty);
        let other = Case { lights: case.lights.clone(), tree, point: case.point };
        let sum = |case: &Case| -> DVec3 {
            cut_by(case, &case.tree, method).iter().map(|member| member.estimate).sum()
        };
        let (ours, theirs) = (sum(case), sum(&other));
        let off = (ours - theirs).abs().max_element();
        tally.check(off <= ROUNDING * ours.max_element().max(theirs.max_element()), || {
            format!("{method:?}: {ours}, mirrored: {theirs}")
        });
    })
}

fn roots(
    technique: &Technique,
    context: &GateContext<'_>,
    faulty: bool,
) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for number in 0..input::cases(context, 4, faulty) {
        let given =
            input::Given::new(input::world_in_shadow(context.seed, number)?, context.seed, None)?;
        let mut rng = input::rng(context.seed, technique.id, number);
        let setting = input::setting(&mut rng, technique, technique.variants[0].id, Form::Cpu);
        let tree = given.tree(&setting)?;
        let by_default = Given::new(&settings::technique(&setting)?, &given.world, &tree)?;
        let list: Vec<u32> = match faulty {
            // Sizes of leaves are 1: the next node is a root's neighbour.
            true => tree
                .roots
                .iter()
                .flat_map(|&root| children(root, |n| tree.nodes[n as usize].size).skip(1))
                .collect(),
            false => tree.roots.clone(),
        };
        let starts = |list: &[u32]| {
            Starts::new(&tree.roots, &vec![Some(list.to_vec()); 4], tree.nodes.len())
        };
        let (mut listed, mut empty) = (by_default.clone(), by_default.clone());
        (listed.starts, empty.starts) = (starts(&list)?, starts(&[])?);
        let lit = |given: &Given| -> Result<_, SuiteError> {
            let mut reference = cut::Reference::new(given.clone());
            let mut cpu = cut::Cpu::new(given.clone());
            let mut frames = input::frames(&mut reference, 0..1, 0, true)?;
            frames.extend(input::frames(&mut cpu, 0..1, 0, true)?);
            Ok(frames)
        };
        for ((plain, listed), empty) in
            lit(&by_default)?.iter().zip(lit(&listed)?).zip(lit(&empty)?)
        {
            tally.check(plain.radiance == listed.radiance, || format!("{setting}: other bits"));
            tally.check(plain.work == listed.work, || format!("{setting}: other work"));
            let dark = empty.radiance.iter().all(|radiance| *radiance == glam::Vec3::ZERO);
            tally.check(dark && empty.work.visits == 0, || format!("{setting}: not empty"));
        }
    }
    Ok(tally)
}
