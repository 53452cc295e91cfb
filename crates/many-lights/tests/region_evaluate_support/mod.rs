//! Worlds of boxes and lights for tests of from-region visibility.
#![allow(dead_code, reason = "each test uses some of these")]
#![allow(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

use dapple_many_lights::{
    Emission, Light, LightTree, World,
    bound::Region,
    region::{
        Direction, Edge, FacadeCluster, Face, Fusion, Occluders, Planes, Precuts, Split, Turn,
        ViewCell,
        evaluate::Evaluator,
        truth::{self, FalseCulls, Obstacles, Sight},
    },
    sample::Random,
    worlds::{CLAMP_M, WINDOW},
};
use dapple_scene::city::OrientedBox;
use glam::{DVec2, DVec3};
use proptest::prelude::*;
use std::f64::consts::PI;
use std::sync::Arc;

/// Boxes and lights, and one cell.
pub struct Case {
    pub world: World,
    pub tree: Arc<LightTree>,
    pub occluders: Arc<Occluders>,
    pub cell: ViewCell,
}

/// A draw between two numbers.
pub fn between(draws: &mut Random, low: f64, high: f64) -> f64 {
    low + (high - low) * f64::from(draws.unit())
}

/// A draw from 0 to below a number.
pub fn below(draws: &mut Random, end: u32) -> u32 {
    draws.bits() % end
}

/// A box between two corners.
pub fn upright(min: DVec3, max: DVec3) -> OrientedBox {
    OrientedBox { centre: 0.5 * (min + max), axis: DVec2::X, half: 0.5 * (max - min) }
}

/// Shines to all sides.
pub fn omni(position: DVec3) -> Light {
    Light { position, axis: DVec3::Y, intensity: DVec3::ONE, emission: Emission::Omni }
}

/// A window in a wall that faces `axis`.
pub fn window(position: DVec3, axis: DVec3) -> Light {
    Light { position, axis, intensity: DVec3::splat(20.0), emission: WINDOW }
}

/// Lights and nothing to be seen.
pub fn world(lights: Vec<Light>) -> World {
    World { origin: DVec3::ZERO, lights, frames: Vec::new(), clamp_m: CLAMP_M, occluders: None }
}

/// A cell that may be lit from all four sides, between turned corners.
pub fn cell(turn: Turn, min: DVec3, max: DVec3) -> ViewCell {
    let (local_min, local_max) = turn.local_around(min, max);
    let region = Region {
        min: local_min,
        max: local_max,
        normal_axis: DVec3::Y,
        normal_spread_rad: PI,
        albedo: DVec3::splat(0.5),
    };
    ViewCell { turn, faces: [Some(Face { min, max, region }); 4] }
}

/// A cell like [`cell`] whose surfaces all have one normal and face one direction.
pub fn facing(turn: Turn, min: DVec3, max: DVec3, direction: Direction) -> ViewCell {
    let mut cell = cell(turn, min, max);
    for other in Direction::ALL {
        let face = &mut cell.faces[other.index()];
        if other == direction {
            let region = &mut face.as_mut().unwrap().region;
            region.normal_axis = turn.from(direction.vector());
            region.normal_spread_rad = 0.0;
        } else {
            *face = None;
        }
    }
    cell
}

impl Case {
    pub fn new(lights: Vec<Light>, boxes: Vec<OrientedBox>, cell: ViewCell) -> Self {
        let tree = Arc::new(LightTree::median(&lights).unwrap());
        let occluders = Arc::new(Occluders::of_boxes(boxes));
        Self { world: world(lights), tree, occluders, cell }
    }

    pub fn evaluator(&self, settings: FacadeCluster) -> Evaluator {
        Evaluator::new(self.tree.clone(), self.occluders.clone(), self.world.clamp_m, settings)
    }

    /// Lights that a precut leaves out although the face sees them, with as many random rays a light
    /// besides those at silhouettes.
    pub fn false_culls(
        &self,
        settings: &FacadeCluster,
        direction: Direction,
        precut: &[u32],
        (random, seed): (u32, u32),
    ) -> FalseCulls {
        let turned = self.occluders.turned(self.cell.turn, settings.occluders);
        let boxes = Obstacles::Boxes;
        let sight = Sight::new(&self.world, &self.cell, direction, &turned.solids, boxes).unwrap();
        truth::false_culls(&sight, &self.tree, precut, settings.threshold, (random, seed))
    }
}

/// The precut of a technique.
pub fn precut(of: &mut dyn Precuts, cell: &ViewCell, direction: Direction) -> Vec<u32> {
    let mut nodes = vec![u32::MAX];
    of.precut(cell, direction, &mut nodes);
    nodes
}

/// Increasing, and none inside another (P8).
pub fn is_antichain(tree: &LightTree, nodes: &[u32]) -> bool {
    nodes.windows(2).all(|pair| pair[0] + tree.nodes[pair[0] as usize].size <= pair[1])
}

/// Random boxes on the ground and lights between them, around a cell that may touch them, overlap them
/// or lie inside one. Corners are multiples of an eighth of `scale`: many walls touch.
pub fn random(seed: u32, scale: f64, turn: Turn) -> Case {
    let mut draws = Random::new(seed, 0, 0);
    let spot = |draws: &mut Random, spread: u32| {
        let side = |draws: &mut Random| f64::from(below(draws, spread)) - f64::from(spread / 2);
        DVec3::new(side(draws), 0.0, side(draws)) * 0.5
    };
    let floating = below(&mut draws, 4) == 0;
    let boxes = (0..below(&mut draws, 40)).map(|_| {
        let corner = spot(&mut draws, 80);
        let [x, y, z] = [16, 12, 6].map(|most| 0.5 * f64::from(below(&mut draws, most)));
        let foot = if floating { 0.5 * f64::from(below(&mut draws, 6)) } else { -1.0 };
        let min = corner.with_y(foot);
        turned_back(turn, &upright(min * scale, (min + DVec3::new(x, y + 0.5, z)) * scale))
    });
    let boxes = boxes.collect();
    let lights = (0..1 + below(&mut draws, 60)).map(|at| {
        let [x, z] = [0, 0].map(|_| between(&mut draws, -25.0, 25.0));
        let mut position = DVec3::new(x, between(&mut draws, 0.0, 7.0), z);
        if at % 3 == 0 {
            position = (2.0 * position).round() * 0.5;
        }
        let axis = Direction::ALL[below(&mut draws, 4) as usize].vector();
        let place = turn.from(position * scale);
        if at % 2 == 0 { omni(place) } else { window(place, axis) }
    });
    let lights = lights.collect();
    let min = spot(&mut draws, 24).with_y(0.25 * f64::from(below(&mut draws, 12)));
    let [x, y, z] = [9, 8, 9].map(|most| 0.5 * f64::from(below(&mut draws, most)));
    let cell = cell(turn, min * scale, (min + DVec3::new(x, y, z)) * scale);
    Case::new(lights, boxes, cell)
}

/// A box of turned space in local space.
fn turned_back(turn: Turn, b: &OrientedBox) -> OrientedBox {
    OrientedBox { centre: turn.from(b.centre), axis: turn.axis(), half: b.half }
}

/// Sound settings of every kind.
pub fn settings() -> impl Strategy<Value = FacadeCluster> {
    let fusion =
        prop_oneof![Just(Fusion::None), Just(Fusion::Insertion), Just(Fusion::HeightOrdered),];
    let edge = prop_oneof![Just(Edge::Flat), Just(Edge::Sloped), Just(Edge::Hull)];
    let planes = prop_oneof![
        3 => Just(Planes::FarFaces),
        1 => (0.0..3.0).prop_map(Planes::Behind),
        1 => (0.5..9.0).prop_map(Planes::Every),
    ];
    let split = prop_oneof![Just(Split::All), (0_u32..4).prop_map(Split::Levels)];
    let threshold = prop_oneof![Just(0.0), Just(1e-3), Just(1e-2)];
    let step = prop_oneof![Just(0.0), Just(2.0)];
    (fusion, edge, planes, split, threshold, step).prop_map(
        |(fusion, edge, planes, split, threshold, least_step_m)| FacadeCluster {
            fusion,
            edge,
            planes,
            split,
            threshold,
            least_step_m,
            ..FacadeCluster::default()
        },
    )
}
