//! Visibility precuts by rays: which lights reach a facade, as the largest subtrees of a tree.
//!
//! A light is in a facade's precut if it gives any light to, and is seen from, at least one of the
//! facade's pixels in the frame at hand: as tight as precuts for that frame can be.

use super::support::prepared;
use crate::{SuiteError, city, problem::Form};
use dapple_many_lights::{
    LightTree, Lighting, LightsError, NOTHING, Point, World,
    cut::{Cpu, Given, Method, Starts},
    gpu, radiance,
};
use dapple_scene::city::Part;
use rayon::prelude::*;
use serde_json::json;
use std::{cell::RefCell, collections::BTreeMap, rc::Rc, sync::Arc};

/// What of a city shares a precut: a facade, a roof, a piece of ground, a tree.
pub type Group = (u8, u32, u32);

/// Lights that reach what a frame shows.
#[derive(Clone, Debug, Default)]
pub struct Reached {
    /// Number of the group of each object; objects that do not show have none.
    group: BTreeMap<u32, usize>,
    /// By group: whether each light reaches it.
    lights: Vec<Vec<bool>>,
}

fn group(part: &Part) -> Group {
    match *part {
        Part::Storey { building, facade, .. } => (0, building, facade),
        Part::Roof { building, .. } => (1, building, 0),
        Part::Ground { ground } => (2, ground, 0),
        Part::Tree { tree } => (3, tree, 0),
    }
}

impl Reached {
    /// Traces rays from every pixel of a frame to the lights that may light it; `group` is what an
    /// object belongs to.
    pub fn trace(world: &World, frame: usize, group: impl Fn(u32) -> Group) -> Self {
        let mut points: BTreeMap<Group, Vec<Point>> = BTreeMap::new();
        let mut objects = BTreeMap::new();
        for point in world.frames[frame].points.iter().filter(|point| point.is_there()) {
            let group = group(point.object);
            points.entry(group).or_default().push(*point);
            objects.insert(point.object, group);
        }
        let order: BTreeMap<Group, usize> = points.keys().copied().zip(0..).collect();
        let reach = |light, points: &[Point]| {
            points.iter().any(|point| {
                radiance(point, light, world.clamp_m).max_element() > 0.0
                    && world.sees(point, light)
            })
        };
        let lights = points
            .values()
            .map(|points| world.lights.par_iter().map(|light| reach(light, points)).collect())
            .collect();
        let group = objects.into_iter().map(|(object, group)| (object, order[&group])).collect();
        Self { group, lights }
    }

    /// Lights of a precut, by group.
    pub fn counts(&self) -> impl Iterator<Item = usize> + '_ {
        self.lights.iter().map(|lights| lights.iter().filter(|reaches| **reaches).count())
    }

    /// Where walks of a tree begin: the largest subtrees all of whose lights reach an object.
    ///
    /// # Errors
    /// None where the tree is of the same lights.
    pub fn starts(&self, tree: &LightTree) -> Result<Starts, LightsError> {
        let of_group: Vec<Vec<u32>> = self.lights.iter().map(|l| subtrees(tree, l)).collect();
        let objects = self.group.keys().next_back().map_or(0, |last| last + 1);
        let list = |object| self.group.get(&object).map(|group| of_group[*group].clone());
        let lists: Vec<Option<Vec<u32>>> = (0..objects).map(list).collect();
        Starts::new(&tree.roots, &lists, tree.nodes.len())
    }
}

/// The largest subtrees all of whose lights are `wanted`; together they hold all that are.
pub fn subtrees(tree: &LightTree, wanted: &[bool]) -> Vec<u32> {
    // By node: leaves, and wanted ones, before it.
    let (mut before, mut sum) = (vec![[0_u32; 2]], [0; 2]);
    for node in &tree.nodes {
        if node.is_leaf() {
            sum[0] += 1;
            sum[1] += u32::from(wanted.get(node.light as usize).is_some_and(|w| *w));
        }
        before.push(sum);
    }
    let (mut found, mut index) = (Vec::new(), 0);
    while index < tree.nodes.len() {
        let end = index + tree.nodes[index].size as usize;
        let [leaves, of_them] = [0, 1].map(|i| before[end][i] - before[index][i]);
        if leaves == of_them {
            found.push(index as u32);
        }
        index = if of_them == 0 || leaves == of_them { end } else { index + 1 };
    }
    found
}

/// Lights that reach what a generated city's view shows, traced once.
///
/// # Errors
/// A scene that is no city.
pub fn reached(scene: &str, view: &str) -> Result<Rc<Reached>, SuiteError> {
    thread_local! {
        static MADE: RefCell<BTreeMap<String, Rc<Reached>>> = const { RefCell::new(BTreeMap::new()) };
    }
    let key = format!("{scene} {view}");
    if let Some(made) = MADE.with_borrow(|made| made.get(&key).map(Rc::clone)) {
        return Ok(made);
    }
    // A truth with shadow rays is of no use here.
    let given = [("visibility", json!("on")), ("truth_pixels", json!(1))];
    let shadowed = prepared(scene, view, &given)?;
    let parameters = super::support::case_of(scene, view, &given)?.parameters;
    let Some((_, parts)) = city::load(scene, 0, &parameters)?.city else {
        return Err(SuiteError::Internal(format!("scene {scene} is no city")));
    };
    let of = |object: u32| parts.get(object as usize).map_or((u8::MAX, NOTHING, 0), group);
    let reached = Rc::new(Reached::trace(shadowed.world(), 0, of));
    MADE.with_borrow_mut(|made| made.insert(key, Rc::clone(&reached)));
    Ok(reached)
}

/// Cuts made ready that begin at `starts`, or at the roots.
///
/// # Errors
/// The device's.
pub fn lighting<'g>(
    form: Form,
    world: &Arc<World>,
    tree: &Arc<LightTree>,
    starts: Option<Starts>,
    method: Method,
    device: Option<&Arc<gpu::Scene<'g>>>,
) -> Result<Box<dyn Lighting + 'g>, SuiteError> {
    let mut given = Given::of(method, world, tree)?;
    given.starts = starts.unwrap_or(given.starts);
    match (form, device) {
        (Form::Gpu, Some(scene)) => Ok(gpu::cut(scene, &given)?),
        (Form::Gpu, None) => Err(SuiteError::Internal("no graphics device".into())),
        _ => Ok(Box::new(Cpu::new(given))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dapple_many_lights::{
        BoundForm, Shaded,
        cut::{Rule, children},
        worlds::{Facade, facade},
    };

    fn leaves(tree: &LightTree, nodes: &[u32]) -> Vec<u32> {
        let within = |&node: &u32| node..node + tree.nodes[node as usize].size;
        let all = nodes.iter().flat_map(within).map(|node| &tree.nodes[node as usize]);
        let mut lights: Vec<u32> = all.filter(|n| n.is_leaf()).map(|n| n.light).collect();
        lights.sort_unstable();
        lights
    }

    #[test]
    fn subtrees_hold_what_is_wanted_once_and_cannot_grow() {
        let (made, paths) = facade(&Facade::default());
        let lights = &made.world.lights;
        for tree in [LightTree::by_keys(lights, &paths), LightTree::median(lights)] {
            let tree = tree.unwrap();
            for modulus in [1, 2, 7, lights.len()] {
                let wanted: Vec<bool> = (0..lights.len()).map(|l| l % modulus < 3).collect();
                let found = subtrees(&tree, &wanted);
                let all: Vec<u32> =
                    (0..lights.len() as u32).filter(|l| wanted[*l as usize]).collect();
                assert_eq!(leaves(&tree, &found), all);
                for node in 0..tree.nodes.len() as u32 {
                    let inside = children(node, |n| tree.nodes[n as usize].size);
                    let all = inside.filter(|child| found.contains(child)).count();
                    let number = children(node, |n| tree.nodes[n as usize].size).count();
                    assert!(number == 0 || all < number, "node {node} could be taken whole");
                }
            }
            assert!(subtrees(&tree, &vec![false; lights.len()]).is_empty());
        }
    }

    #[test]
    fn lights_that_reach_nothing_are_left_out_and_change_nothing() {
        let (made, paths) = facade(&Facade::default());
        let mut world = made.world;
        // Behind the wall that it would have to light.
        let behind = world.lights[0];
        let wall = world.frames[0].points[0].position.as_dvec3();
        let away = dapple_many_lights::Light {
            position: wall - 5.0 * world.frames[0].points[0].normal.as_dvec3(),
            ..behind
        };
        world.lights.push(away);
        let mut paths = paths;
        paths.push(vec![u32::MAX]);
        let world = Arc::new(world);
        let reached = Reached::trace(&world, 0, |object| (0, object, 0));
        let last = world.lights.len() - 1;
        assert!(reached.lights.iter().all(|lights| !lights[last] && lights[0]));
        let tree = Arc::new(LightTree::by_keys(&world.lights, &paths).unwrap());
        let method = Method::Rule(Rule::Absolute(0.0), BoundForm::Cheap);
        let mut images = [None, Some(reached.starts(&tree).unwrap())].map(|starts| {
            let mut cut = lighting(Form::Cpu, &world, &tree, starts, method, None).unwrap();
            let mut shaded = Shaded::default();
            cut.reset(0).unwrap();
            cut.shade(0, true).unwrap();
            cut.read(&mut shaded).unwrap();
            shaded
        });
        let [full, culled] = &mut images;
        assert!(culled.work.visits < full.work.visits);
        let differ = |(a, b): (&glam::Vec3, &glam::Vec3)| (*a - *b).abs().max_element();
        let most = full.radiance.iter().zip(&culled.radiance).map(differ).fold(0.0, f32::max);
        assert!(most < 1e-5, "{most}");
    }
}
