//! Cuts whose starts, heights of starts and moving lights are others from frame to frame: in every
//! form the same as if it had been made so.
#![allow(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

mod gpu_support;

use dapple_gpu::testing::test_gpu;
use dapple_many_lights::{
    Absolute, BoundForm, Emission, Form, Light, LightTree, Lightcuts, Per, Point, Relative,
    Selection, Shaded, Technique, World,
    cut::{Given, Starting, Starts, children, starting},
    gpu::Scene,
    radiance,
    worlds::{Cloud, WINDOW, cloud},
};
use glam::{DVec3, Vec3};
use gpu_support::{agree, lit, with_tree};
use std::sync::Arc;

const BOUND: BoundForm = BoundForm::Cheap;

fn absolute(threshold: f64, per: Per) -> Technique {
    Technique::Absolute(Absolute { threshold, bound: BOUND, per })
}

fn worst(epsilon: f64) -> Technique {
    let selection = Selection::Heap;
    Technique::Lightcuts(Lightcuts { epsilon, most: 4000, selection, bound: BOUND })
}

/// Rules of every kind, with errors that pictures show.
fn techniques() -> [Technique; 4] {
    [
        absolute(1.0 / 1020.0, Per::Pixel),
        absolute(1.0 / 1020.0, Per::Tile),
        Technique::Relative(Relative { epsilon: 0.5, bound: BOUND }),
        worst(0.02),
    ]
}

/// The same without any error.
fn exact() -> [Technique; 3] {
    [absolute(0.0, Per::Pixel), absolute(0.0, Per::Tile), worst(0.0)]
}

/// Forms of a technique, on a device where there is one.
fn forms(
    technique: &Technique,
    (world, tree): &(Arc<World>, Arc<LightTree>),
    starts: Option<&Starts>,
) -> Vec<Box<dyn Starting>> {
    let mut given = Given::new(technique, world, tree).unwrap();
    if let Some(starts) = starts {
        given.starts = starts.clone();
    }
    let mut forms: Vec<Box<dyn Starting>> =
        [Form::Reference, Form::Cpu].map(|form| starting(form, &given, None).unwrap()).into();
    if let Some(gpu) = test_gpu() {
        let scene = Arc::new(Scene::new(gpu, world).unwrap());
        forms.push(starting(Form::Gpu, &given, Some(&scene)).unwrap());
    }
    forms
}

fn shade(form: &mut dyn Starting) -> Shaded {
    let mut shaded = Shaded::default();
    form.shade(0, true).unwrap();
    form.read(&mut shaded).unwrap();
    shaded
}

fn same(a: &Shaded, b: &Shaded, what: &str) {
    assert_eq!(a.radiance, b.radiance, "{what}: radiance");
    assert_eq!(a.visits, b.visits, "{what}: visits");
    assert_eq!(a.work, b.work, "{what}: work");
}

/// All nodes some levels below the roots.
fn level(tree: &LightTree, levels: u32) -> Vec<u32> {
    let size = |node: u32| tree.nodes[node as usize].size;
    let mut nodes = tree.roots.clone();
    for _ in 0..levels {
        let below = |&node: &u32| match size(node) {
            1 => vec![node],
            _ => children(node, size).collect(),
        };
        nodes = nodes.iter().flat_map(below).collect();
    }
    nodes
}

/// Starts of four objects and more from few lists to many, shared, empty and missing.
fn several(tree: &LightTree) -> Vec<Starts> {
    let mut all = Vec::new();
    for levels in [0, 5, 1, 3] {
        let mut starts = Starts::roots(&tree.roots);
        starts.restart(&tree.roots, 4);
        let whole = starts.add(&level(tree, levels));
        let half = starts.add(&level(tree, levels + 1)[..1 << levels]);
        let none = starts.add(&[]);
        starts.set(0, whole).unwrap();
        starts.set(1, [half, none][levels as usize % 2]).unwrap();
        starts.set(2, whole).unwrap();
        all.push(starts);
    }
    // Another number of objects: the last one falls back to the roots.
    all.push(
        Starts::new(&tree.roots, &[Some(level(tree, 2)[1..].to_vec())], tree.nodes.len()).unwrap(),
    );
    all.push(Starts::roots(&tree.roots));
    all
}

#[test]
fn every_start_is_as_if_made_so() {
    let given = lit(300, &[Emission::Omni, WINDOW], [43, 30]);
    let mut compared = 0;
    for technique in techniques() {
        for (index, mut changed) in forms(&technique, &given, None).into_iter().enumerate() {
            let mut before: Option<Shaded> = None;
            for starts in several(&given.1) {
                let sent = changed.start(&starts).unwrap();
                let (ranges, nodes) = starts.lists();
                let most = (ranges.len().max(2) * 8 + nodes.len() * 4) as u64;
                assert_eq!(sent, if index == 2 { most } else { 0 });
                let found = shade(&mut *changed);
                let made = shade(&mut *forms(&technique, &given, Some(&starts))[index]);
                same(&found, &made, &format!("{technique:?}, form {index}"));
                // Negative control: what came before was another picture.
                if let Some(before) = &before {
                    assert!(before.visits != found.visits, "{technique:?}, form {index}");
                }
                before = Some(found);
                compared += 1;
            }
        }
    }
    assert!(compared >= 4 * 2 * 6, "{compared}");
}

#[test]
fn what_forms_hold_is_what_they_were_given_for_every_object() {
    let given = lit(300, &[WINDOW], [16, 16]);
    for mut form in forms(&techniques()[0], &given, None) {
        for starts in several(&given.1) {
            form.start(&starts).unwrap();
            let held = form.starts().unwrap();
            assert_eq!(held, starts);
            for object in (0..9).chain([u32::MAX]) {
                assert_eq!(held.of(object), starts.of(object));
            }
        }
    }
}

#[test]
fn a_start_beyond_the_tree_is_refused_and_changes_nothing() {
    let given = lit(50, &[WINDOW], [16, 16]);
    let nodes = given.1.nodes.len() as u32;
    for mut form in forms(&techniques()[0], &given, None) {
        let before = shade(&mut *form);
        let mut wrong = Starts::roots(&given.1.roots);
        wrong.restart(&given.1.roots, 2);
        let list = wrong.add(&[0, nodes]);
        wrong.set(1, list).unwrap();
        let error = form.start(&wrong).unwrap_err().to_string();
        assert_eq!(error, format!("object 1: starts at node {nodes} of a tree of {nodes}"));
        same(&shade(&mut *form), &before, "after a refusal");
    }
}

/// A world in which every pixel is an object of its own.
fn pixel_by_pixel(lights: u32, size: [u32; 2]) -> (Arc<World>, Arc<LightTree>) {
    let (world, _) = lit(lights, &[Emission::Omni, WINDOW], size);
    let mut world = (*world).clone();
    let points = world.frames[0].points.iter_mut().enumerate();
    points.filter(|(_, p)| p.is_there()).for_each(|(pixel, p)| p.object = pixel as u32);
    with_tree(world)
}

/// Heights of some nodes: heights of points themselves, where ties lie, and never.
fn heights(world: &World, nodes: &[u32]) -> Vec<f32> {
    let ys: Vec<f32> =
        gpu_support::there(world).map(|point| point.position.y).step_by(29).collect();
    let one = |place: usize| match place % 3 {
        0 => f32::NEG_INFINITY,
        1 => ys[place * 7 % ys.len()],
        _ => ys[place * 5 % ys.len()].next_down(),
    };
    (0..nodes.len()).map(one).collect()
}

fn with_heights(tree: &LightTree, nodes: &[u32], heights: &[f32], objects: usize) -> Starts {
    let mut starts = Starts::roots(&tree.roots);
    starts.restart(&tree.roots, objects);
    let list = starts.add_below(nodes, heights).unwrap();
    (0..objects as u32).for_each(|object| starts.set(object, list).unwrap());
    starts
}

#[test]
fn a_start_with_a_height_is_left_out_by_points_at_it_and_below() {
    let given = pixel_by_pixel(200, [29, 21]);
    let (world, tree) = &given;
    let points = &world.frames[0].points;
    let nodes = level(tree, 4);
    let heights = heights(world, &nodes);
    let high = with_heights(tree, &nodes, &heights, points.len());
    // Each pixel's own list without what is hidden from it.
    let of_pixel = |point: &Point| {
        let all = nodes.iter().zip(&heights);
        all.filter(|(_, height)| point.position.y > **height).map(|(&node, _)| node).collect()
    };
    let lists: Vec<Option<Vec<u32>>> = points.iter().map(|p| Some(of_pixel(p))).collect();
    let fewer = lists.iter().flatten().filter(|list| list.len() < nodes.len()).count();
    assert!(fewer > 300, "{fewer}");
    let filtered = Starts::new(&tree.roots, &lists, tree.nodes.len()).unwrap();
    for technique in techniques() {
        let is_tile = matches!(technique, Technique::Absolute(a) if a.per == Per::Tile);
        for (index, mut form) in forms(&technique, &given, None).into_iter().enumerate() {
            form.start(&high).unwrap();
            assert_eq!(form.starts().unwrap(), high);
            let found = shade(&mut *form);
            form.start(&filtered).unwrap();
            let expected = shade(&mut *form);
            if !is_tile {
                same(&found, &expected, &format!("{technique:?}, form {index}"));
            }
        }
    }
    // Cuts of tiles go into what any of their pixels is lit by: without an error, the sums are the same.
    let below = |node: u32| node..node + tree.nodes[node as usize].size;
    let mut hidden = 0;
    for technique in exact() {
        for mut form in forms(&technique, &given, Some(&high)) {
            let found = shade(&mut *form);
            let there = points.iter().enumerate().filter(|(_, point)| point.is_there());
            for (pixel, point) in there {
                let lights = lists[pixel].iter().flatten().flat_map(|&node| below(node));
                let leaves = lights.map(|node| &tree.nodes[node as usize]).filter(|n| n.is_leaf());
                let one =
                    |light: u32| radiance(point, &world.lights[light as usize], world.clamp_m);
                let expected = leaves.map(|leaf| one(leaf.light)).sum::<DVec3>().as_vec3();
                let lit = found.radiance[pixel];
                assert!(agree(lit, expected), "{technique:?}: {pixel}: {lit}, not {expected}");
                hidden += usize::from(!agree(lit, world.truth(point).as_vec3()));
            }
        }
    }
    // Negative control: heights take light away.
    assert!(hidden > 500, "{hidden}");
}

#[test]
fn pixels_of_a_tile_that_share_a_list_are_hidden_one_by_one() {
    // Ordinary objects: tiles hold pixels of one list on both sides of a height.
    let given = lit(200, &[Emission::Omni, WINDOW], [37, 30]);
    let (world, tree) = &given;
    let nodes = level(tree, 3);
    let heights = heights(world, &nodes);
    let starts = with_heights(tree, &nodes, &heights, 4);
    for technique in techniques().into_iter().chain(exact()) {
        let mut forms = forms(&technique, &given, Some(&starts));
        let all: Vec<Shaded> = forms.iter_mut().map(|form| shade(&mut **form)).collect();
        for other in &all[1..] {
            let differ = (0..all[0].radiance.len())
                .filter(|&pixel| !agree(other.radiance[pixel], all[0].radiance[pixel]))
                .count();
            // Where a threshold lies within rounding of a bound: as among plain cuts.
            assert!(differ * 50 < all[0].radiance.len(), "{technique:?}: {differ}");
            if differ == 0 && other.visits == all[0].visits {
                assert_eq!(other.work, all[0].work, "{technique:?}");
            }
        }
    }
}

#[test]
fn heights_that_hide_nothing_change_nothing_and_those_above_all_leave_darkness() {
    let given = lit(200, &[WINDOW], [37, 30]);
    let (world, tree) = &given;
    let nodes = level(tree, 3);
    let never = vec![f32::NEG_INFINITY; nodes.len()];
    let above = vec![f32::INFINITY; nodes.len()];
    for technique in techniques() {
        let plain = Starts::new(&tree.roots, &vec![Some(nodes.clone()); 4], tree.nodes.len());
        // Shared lists as in the others: tiles group pixels by them.
        let mut shared = plain.unwrap();
        shared.restart(&tree.roots, 4);
        let list = shared.add(&nodes);
        (0..4).for_each(|object| shared.set(object, list).unwrap());
        for mut form in forms(&technique, &given, Some(&shared)) {
            let expected = shade(&mut *form);
            form.start(&with_heights(tree, &nodes, &never, 4)).unwrap();
            same(&shade(&mut *form), &expected, "never hidden");
            form.start(&with_heights(tree, &nodes, &above, 4)).unwrap();
            let dark = shade(&mut *form);
            assert!(dark.radiance.iter().all(|radiance| *radiance == Vec3::ZERO));
            assert_eq!((dark.work.visits, dark.work.cut), (0, 0), "{technique:?}");
            // And back.
            form.start(&shared).unwrap();
            same(&shade(&mut *form), &expected, "without heights again");
        }
    }
    assert!(world.lights.len() == 200);
}

/// Lights near the first things that are seen, at another place each step.
fn moving(step: u32, number: u32) -> Vec<Light> {
    let one = |index: u32| {
        let along = f64::from(index) * 1.7 + f64::from(step) * 3.0;
        Light {
            position: DVec3::new(along - 8.0, 1.5 + 0.1 * f64::from(index), 0.3 * along),
            axis: DVec3::NEG_Y,
            intensity: DVec3::new(6.0, 4.0, 2.0),
            emission: if index.is_multiple_of(2) { Emission::Omni } else { Emission::Oriented },
        }
    };
    (0..number).map(one).collect()
}

fn joined(world: &World, lights: &[Light]) -> World {
    let mut joined = world.clone();
    joined.lights.extend_from_slice(lights);
    joined
}

/// Moves lights through some frames, and holds each against all lights one by one.
fn held_to_all_lights(world: World, starts_nowhere: bool) -> usize {
    let given = with_tree(world);
    let (world, tree) = &given;
    let mut starts = Starts::roots(&tree.roots);
    starts.restart(&tree.roots, 6);
    if starts_nowhere {
        let none = starts.add(&[]);
        (0..6).for_each(|object| starts.set(object, none).unwrap());
    }
    let mut lit_anew = 0;
    for technique in exact() {
        for mut form in forms(&technique, &given, Some(&starts)) {
            let still = shade(&mut *form);
            // More, fewer, none, and far more than there was room for.
            for (step, number) in [(0, 2), (1, 2), (2, 9), (3, 1), (4, 0), (5, 70)] {
                let lights = moving(step, number);
                let sent = form.replace_moving(&lights, &LightTree::median(&lights).unwrap());
                assert!(sent.unwrap() <= u64::from(number) * (2 * 80 + 48));
                let found = shade(&mut *form);
                let all = match starts_nowhere {
                    true => World { lights: lights.clone(), ..(**world).clone() },
                    false => joined(world, &lights),
                };
                for (pixel, point) in all.frames[0].points.iter().enumerate() {
                    let expected =
                        if point.is_there() { all.truth(point) } else { DVec3::ZERO }.as_vec3();
                    let lit = found.radiance[pixel];
                    assert!(agree(lit, expected), "{technique:?}: {pixel}: {lit}, not {expected}");
                    lit_anew += usize::from(!agree(lit, still.radiance[pixel]));
                }
                if number == 0 {
                    same(&found, &still, "no light moves");
                }
            }
        }
    }
    lit_anew
}

#[test]
fn moving_lights_are_lit_in_the_next_frame_and_the_trees_sum() {
    let world = |lights| lit(lights, &[Emission::Omni, WINDOW], [23, 17]).0;
    assert!(held_to_all_lights((*world(60)).clone(), false) > 2000);
    // Objects that nothing of the world lights.
    assert!(held_to_all_lights((*world(60)).clone(), true) > 2000);
    // No other light at all.
    assert!(held_to_all_lights((*world(0)).clone(), false) > 2000);
}

#[test]
fn shadow_rays_go_to_moving_lights() {
    let made = cloud(&Cloud { lights: 20, size: [15, 11], ..Cloud::default() });
    let shadowed = made.with_shadows().unwrap();
    assert!(held_to_all_lights(shadowed, false) > 500);
}

#[test]
fn moving_lights_that_are_wrong_are_refused_by_name() {
    let given = lit(5, &[WINDOW], [8, 8]);
    for mut form in forms(&techniques()[0], &given, None) {
        let before = shade(&mut *form);
        let lights = moving(0, 3);
        let tree = LightTree::median(&lights).unwrap();
        let error = form.replace_moving(&lights[1..], &tree).unwrap_err().to_string();
        assert_eq!(error, "light tree: has 3 leaves for 2 lights");
        let mut wrong = lights.clone();
        wrong[2].intensity.x = -1.0;
        let error = form.replace_moving(&wrong, &tree).unwrap_err().to_string();
        assert_eq!(error, "light 7: the intensity is negative");
        same(&shade(&mut *form), &before, "after a refusal");
    }
}
