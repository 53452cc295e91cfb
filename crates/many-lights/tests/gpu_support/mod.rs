//! What tests of cuts on a device share: worlds, frames of any form, and where f32 may cut otherwise.
#![allow(dead_code, clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

use dapple_gpu::Gpu;
use dapple_many_lights::{
    BoundForm, Emission, Form, Frame, LightTree, Node, Point, Shaded, Technique, World,
    bound::{self, Region},
    cut::{Given, Method, Receiver, Rule, tile, walk},
    gpu::Scene,
    make,
    worlds::{Cloud, cloud},
};
use glam::Vec3;
use std::sync::Arc;

/// Share of the radiance by which f32 may differ from f64: lights are rounded to 1e-6 m, and the
/// nearest are some 0.1 m away, so that squared distances keep 4 to 5 digits.
pub const TOLERANCE: f32 = 5e-5;

/// Radiance that no display shows: differences below it do not count.
pub const BLACK: f32 = 1e-7;

/// A cloud with its tree.
pub fn lit(lights: u32, emissions: &[Emission], size: [u32; 2]) -> (Arc<World>, Arc<LightTree>) {
    let made = cloud(&Cloud { lights, emissions: emissions.to_vec(), size, ..Cloud::default() });
    with_tree(made.world)
}

/// A world with its tree of halves.
pub fn with_tree(world: World) -> (Arc<World>, Arc<LightTree>) {
    let tree = LightTree::median(&world.lights).unwrap();
    (Arc::new(world), Arc::new(tree))
}

/// A frame in a form, counted.
pub fn shade(
    gpu: &Gpu,
    form: Form,
    technique: &Technique,
    (world, tree): &(Arc<World>, Arc<LightTree>),
) -> Shaded {
    let scene = Arc::new(Scene::new(gpu, world).unwrap());
    let scene = (form == Form::Gpu).then_some(&scene);
    let mut lighting = make(form, technique, world, tree, scene).unwrap();
    lighting.reset(1).unwrap();
    let mut shaded = Shaded::default();
    lighting.shade(0, true).unwrap();
    lighting.read(&mut shaded).unwrap();
    // Counting changes nothing else.
    let mut plain = Shaded::default();
    lighting.shade(0, false).unwrap();
    lighting.read(&mut plain).unwrap();
    assert_eq!(plain.radiance, shaded.radiance, "{technique:?}");
    assert_eq!((plain.work.visits, plain.visits.len()), (0, 0));
    assert!(lighting.shade(world.frames.len(), false).is_err());
    shaded
}

/// Whether two colours agree but for rounding.
pub fn agree(found: Vec3, expected: Vec3) -> bool {
    let allowed = TOLERANCE * expected.max_element() + BLACK;
    (found - expected).abs().max_element() <= allowed
}

/// Pixels at which rounding may make another cut, since a threshold lies in the band around a bound
/// that the f64 walk looks at; and how much radiance that may cost: what such nodes give by their
/// estimates, and by nodes below, is no more than their bound, and that a channel.
pub fn undecided(
    technique: &Technique,
    world: &Arc<World>,
    tree: &Arc<LightTree>,
) -> Vec<Option<f64>> {
    let given = Given::new(technique, world, tree).unwrap();
    let packed = tree.pack();
    let frame = &world.frames[0];
    let clamp = world.clamp_m;
    let lies_between = |form: BoundForm, index: u32, node: &Node, region: &Region, limit: f64| {
        let (low, high) = bound::band(form, node, &packed.nodes[index as usize], region, clamp);
        (low <= limit && limit < high).then_some(3.0 * high)
    };
    let mut found = vec![None; frame.points.len()];
    match given.method {
        Method::Worst(_) => {}
        Method::Rule(rule, form) => {
            for (pixel, point) in frame.points.iter().enumerate().filter(|(_, p)| p.is_there()) {
                let region = Region::at(point);
                let receiver = Receiver { point, form, clamp_m: clamp };
                walk(tree, given.starts.of(point.object), |index, node| {
                    if !node.is_leaf() {
                        let estimate = bound::estimate(node, point, clamp).max_element();
                        let limit = rule.limit(estimate);
                        let near = lies_between(form, index, node, &region, limit);
                        // The estimate of R3 is rounded too.
                        let bound = bound::point(form, node, point, clamp);
                        let close = matches!(rule, Rule::Relative(_))
                            && (bound - limit).abs() < 1e-4 * bound;
                        add(&mut found[pixel], near.or(close.then_some(3.0 * bound)));
                    }
                    rule.look(node, &receiver).taken
                });
            }
        }
        Method::Tile { threshold, form } => {
            for (pixels, region) in tiles(frame) {
                let mut near = None;
                walk(tree, &tree.roots, |index, node| {
                    if !node.is_leaf() {
                        add(&mut near, lies_between(form, index, node, &region, threshold));
                    }
                    node.is_leaf() || bound::region(form, node, &region, clamp) <= threshold
                });
                pixels.iter().for_each(|&pixel| found[pixel] = near);
            }
        }
    }
    found
}

fn add(sum: &mut Option<f64>, one: Option<f64>) {
    if let Some(one) = one {
        *sum = Some(sum.unwrap_or(0.0) + one);
    }
}

/// Pixels of each tile that shows anything, and their region.
fn tiles(frame: &Frame) -> Vec<(Vec<usize>, Region)> {
    let (columns, rows) = tile::tiles(frame.width, frame.height);
    let all = (0..rows).flat_map(|row| (0..columns).map(move |column| (column, row)));
    let one = |(column, row)| {
        let pixels = tile::pixels(frame.width, frame.height, column, row);
        let pixels: Vec<_> = pixels.filter(|&pixel| frame.points[pixel].is_there()).collect();
        let region = Region::of(pixels.iter().map(|&pixel| &frame.points[pixel]))?;
        Some((pixels, region))
    };
    all.filter_map(one).collect()
}

/// The points that show anything.
pub fn there(world: &World) -> impl Iterator<Item = &Point> {
    world.frames[0].points.iter().filter(|point| point.is_there())
}
