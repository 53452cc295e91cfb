//! Lights, trees and points where cuts are hard to make, and what any cut has to be.

use dapple_many_lights::{
    BoundForm, Emission, Light, LightTree, Point,
    cut::{Look, Receiver, Rule, children, walk},
};
use glam::{DVec3, Vec3};
use proptest::prelude::*;
use std::f64::consts::{FRAC_PI_4, PI};

pub const CLAMP_M: f64 = 0.1;

/// Lights, a tree over them, and who is lit.
#[derive(Clone, Debug)]
pub struct Case {
    pub lights: Vec<Light>,
    pub tree: LightTree,
    pub point: Point,
    pub form: BoundForm,
}

impl Case {
    pub fn receiver(&self) -> Receiver<'_> {
        Receiver { point: &self.point, form: self.form, clamp_m: CLAMP_M }
    }

    /// What all lights give.
    pub fn truth(&self) -> DVec3 {
        let one = |light| dapple_many_lights::radiance(&self.point, light, CLAMP_M);
        self.lights.iter().map(one).sum()
    }

    /// The cut of a rule from the roots: its nodes, and what was found there.
    pub fn cut(&self, rule: Rule) -> Vec<(u32, Look)> {
        self.cut_of(&self.tree, rule)
    }

    /// The same, walked through another tree.
    pub fn cut_of(&self, tree: &LightTree, rule: Rule) -> Vec<(u32, Look)> {
        let mut cut = Vec::new();
        walk(tree, &tree.roots, |index, node| {
            let look = rule.look(node, &self.receiver());
            if look.taken {
                cut.push((index, look));
            }
            look.taken
        });
        cut
    }
}

/// Whether no node of a cut lies below another, and each leaf below or in exactly one.
pub fn covers(tree: &LightTree, cut: impl Iterator<Item = u32>) -> Result<(), String> {
    let mut times = vec![0; tree.nodes.len()];
    for node in cut {
        let below = node as usize..node as usize + tree.nodes[node as usize].size as usize;
        times[below].iter_mut().for_each(|times| *times += 1);
    }
    let leaves = tree.nodes.iter().enumerate().filter(|(_, node)| node.is_leaf());
    match leaves.map(|(leaf, _)| (leaf, times[leaf])).find(|&(_, times)| times != 1) {
        Some((leaf, times)) => Err(format!("leaf {leaf} is covered {times} times")),
        None => Ok(()),
    }
}

/// The tree with the children of every node in the opposite order, and the old index of each node.
pub fn mirrored(tree: &LightTree) -> (LightTree, Vec<u32>) {
    fn put(tree: &LightTree, node: u32, order: &mut Vec<u32>) {
        order.push(node);
        let below: Vec<u32> = children(node, |n| tree.nodes[n as usize].size).collect();
        below.iter().rev().for_each(|&child| put(tree, child, order));
    }
    let mut order = Vec::new();
    tree.roots.iter().for_each(|&root| put(tree, root, &mut order));
    let nodes: Vec<_> = order.iter().map(|&old| tree.nodes[old as usize]).collect();
    let mut leaves = tree.leaves.clone();
    for (index, node) in nodes.iter().enumerate().filter(|(_, node)| node.is_leaf()) {
        leaves[node.light as usize] = index as u32;
    }
    (LightTree { nodes, roots: tree.roots.clone(), leaves }, order)
}

fn unit() -> impl Strategy<Value = DVec3> {
    let any = (-1.0..1.0, 0.0..2.0 * PI).prop_map(|(z, turn): (f64, f64)| {
        let across = (1.0 - z * z).sqrt();
        DVec3::new(across * turn.cos(), across * turn.sin(), z).normalize()
    });
    // Opposite axes cancel; straight ones lie on the faces of boxes.
    prop_oneof![2 => any, 1 => Just(DVec3::X), 1 => Just(DVec3::NEG_X), 1 => Just(DVec3::Y)]
}

fn within() -> impl Strategy<Value = DVec3> {
    // On a coarse grid too, so that lights coincide and share coordinates.
    let coarse = prop::array::uniform3(-2..3_i32).prop_map(|c| DVec3::from(c.map(f64::from)) * 0.5);
    let any = prop::array::uniform3(-1.0..1.0_f64).prop_map(DVec3::from);
    prop_oneof![any, coarse]
}

fn light() -> impl Strategy<Value = Light> {
    let emission = prop::sample::select(vec![
        Emission::Omni,
        Emission::Oriented,
        Emission::Spot { half_angle_rad: FRAC_PI_4 },
        Emission::Spot { half_angle_rad: PI },
        Emission::Spot { half_angle_rad: 1e-3 },
        Emission::Directional,
    ]);
    let intensity = prop_oneof![
        4 => prop::array::uniform3(0.0..10.0_f64).prop_map(DVec3::from),
        1 => Just(DVec3::ZERO),
        1 => Just(DVec3::new(0.0, 1e6, 0.0)),
    ];
    (within(), unit(), intensity, emission).prop_map(|(position, axis, intensity, emission)| {
        Light { position, axis, intensity, emission }
    })
}

/// Cases of up to `most` lights.
pub fn case(most: usize) -> impl Strategy<Value = Case> {
    let scale = prop::sample::select(vec![1e-4, 1.0, 30.0, 1e3, 1e6]);
    let form = prop::sample::select(vec![BoundForm::Cheap, BoundForm::Walter]);
    let lights = prop::collection::vec(light(), 0..=most);
    let keys = prop::collection::vec(0..3_u32, 2 * most);
    (lights, scale, within(), unit(), 0..4_usize, keys, 0..8_usize, form).prop_map(
        |(mut lights, scale, at, normal, build, keys, place, form)| {
            lights.iter_mut().for_each(|light| light.position *= scale);
            let paths = keys.chunks(2).map(<[u32]>::to_vec).take(lights.len());
            let tree = match build {
                0 => LightTree::by_keys(&lights, &vec![vec![]; lights.len()]),
                1 => LightTree::by_keys(&lights, &paths.collect::<Vec<_>>()),
                _ => LightTree::median(&lights),
            };
            // In a light as often as anywhere.
            let position = lights.get(place).map_or(at * scale, |light| light.position);
            let point = Point {
                position: position.as_vec3(),
                normal: normal.as_vec3(),
                albedo: Vec3::new(0.9, 0.5, 1.0),
                ..Point::default()
            };
            Case { tree: tree.unwrap(), lights, point, form }
        },
    )
}

/// Thresholds, none and endless among them.
pub fn threshold() -> impl Strategy<Value = f64> {
    prop::sample::select(vec![
        0.0,
        1.0 / 25500.0,
        1.0 / 1020.0,
        1.0 / 255.0,
        1.0,
        1e3,
        f64::INFINITY,
    ])
}

/// The rules that look at one node.
pub fn rule() -> impl Strategy<Value = Rule> {
    let relative = prop::sample::select(vec![0.0, 0.02, 1.0, f64::INFINITY]);
    prop_oneof![threshold().prop_map(Rule::Absolute), relative.prop_map(Rule::Relative)]
}
