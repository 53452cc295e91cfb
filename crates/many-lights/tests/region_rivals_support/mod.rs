//! Rows of houses, the lights among them, and a facade that looks at them.

#![allow(dead_code, reason = "each test file uses a part")]

use dapple_many_lights::bound::Region;
use dapple_many_lights::region::{Direction, Face, Occluders, Solid, Turn, ViewCell};
use dapple_many_lights::sample::Random;
use dapple_many_lights::worlds::Rectangle;
use dapple_many_lights::{Emission, Light, LightTree, World, worlds};
use dapple_scene::city::OrientedBox;
use glam::{DVec2, DVec3, Vec3};
use std::sync::Arc;

/// Everything about a street.
pub struct Street {
    pub world: World,
    pub tree: Arc<LightTree>,
    pub boxes: Vec<OrientedBox>,
    pub occluders: Arc<Occluders>,
    pub cell: ViewCell,
    pub direction: Direction,
}

/// A draw between two numbers.
pub fn between(random: &mut Random, low: f64, high: f64) -> f64 {
    low + (high - low) * f64::from(random.unit())
}

/// An upright box of local space.
pub fn upright(min: DVec3, max: DVec3) -> OrientedBox {
    OrientedBox { centre: (min + max) * 0.5, axis: DVec2::X, half: (max - min) * 0.5 }
}

/// A cell of one face, lit from everywhere in front of it.
pub fn cell(min: DVec3, max: DVec3, direction: Direction) -> ViewCell {
    let normal_axis = direction.vector();
    let spread = std::f64::consts::PI;
    let region = Region { min, max, normal_axis, normal_spread_rad: spread, albedo: DVec3::ONE };
    let mut faces = [None; 4];
    faces[direction.index()] = Some(Face { min, max, region });
    ViewCell { turn: Turn::NONE, faces }
}

/// Solids of boxes that are not turned.
pub fn solids(boxes: &[OrientedBox]) -> Vec<Solid> {
    let solid = |b: &OrientedBox| Solid { min: b.centre - b.half, max: b.centre + b.half };
    boxes.iter().map(solid).collect()
}

/// An omni light.
pub fn lamp(position: DVec3) -> Light {
    Light { position, axis: DVec3::Y, intensity: DVec3::splat(20.0), emission: Emission::Omni }
}

/// Lights seen from a facade past boxes.
pub fn street(
    lights: Vec<Light>,
    boxes: Vec<OrientedBox>,
    cell: ViewCell,
    direction: Direction,
) -> Street {
    let tree = Arc::new(LightTree::median(&lights).unwrap());
    let mut world = worlds::cloud(&worlds::Cloud { lights: 1, ..worlds::Cloud::default() }).world;
    world.lights = lights;
    let occluders = Arc::new(Occluders::of_boxes(boxes.clone()));
    Street { world, tree, boxes, occluders, cell, direction }
}

/// Five rows of twelve lots of 8 x 8 m, an eighth of them empty, 1 to 7 storeys of 3 m; lights before the
/// houses' fronts and in the streets; a facade `depth_m` deep that looks along +x.
pub fn rows(seed: u32, depth_m: f64) -> Street {
    let mut random = Random::new(seed, 5, 12);
    let (mut boxes, mut lights) = (vec![], vec![]);
    for row in 0..5 {
        let near = 12.0 + 20.0 * f64::from(row);
        for lot in 0..12 {
            let left = -48.0 + 8.0 * f64::from(lot);
            for _ in 0..4 {
                let x = near + between(&mut random, -6.0, -0.001);
                let z = left + between(&mut random, 0.0, 8.0);
                lights.push(lamp(DVec3::new(x, between(&mut random, 0.5, 24.0), z)));
            }
            if random.unit() < 0.125 {
                continue;
            }
            let height = 3.0 * between(&mut random, 1.0, 7.999).floor();
            let max = DVec3::new(near + 8.0, height, left + 8.0);
            boxes.push(upright(DVec3::new(near, 0.0, left), max));
        }
    }
    let width = between(&mut random, 5.0, 20.0);
    let centre = between(&mut random, -10.0, 10.0);
    let min = DVec3::new(-depth_m, 0.0, centre - 0.5 * width);
    let max = DVec3::new(0.0, 6.0, centre + 0.5 * width);
    street(lights, boxes, cell(min, max, Direction::PlusX), Direction::PlusX)
}

/// The same world in which the boxes' walls and roofs cast shadows.
pub fn with_triangles(street: &Street) -> World {
    let rectangles: Vec<Rectangle> = solids(&street.boxes).iter().flat_map(sides).collect();
    let camera = worlds::cloud(&worlds::Cloud::default()).scene.cameras[0].clone();
    let lights = street.world.lights.clone();
    worlds::made(lights, &rectangles, &[camera], [1, 1], DVec3::ZERO).with_shadows().unwrap()
}

fn sides(solid: &Solid) -> [Rectangle; 5] {
    let Solid { min, max } = *solid;
    let (x, y, z) = (DVec3::X * (max - min), DVec3::Y * (max - min), DVec3::Z * (max - min));
    let side =
        |corner: DVec3, along: DVec3, up: DVec3| Rectangle { corner, along, up, albedo: Vec3::ONE };
    [
        side(min, x, y),
        side(min + z, x, y),
        side(min, z, y),
        side(min + x, z, y),
        side(min + y, x, z),
    ]
}
