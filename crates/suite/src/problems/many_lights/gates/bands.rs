//! Cuts over tiles, and cuts in f32: where they may part from a pixel's own in f64.

use super::{
    hard::{self, FORMS},
    input, on_device,
};
use crate::{
    SuiteError,
    problem::{Form, Setting},
    problems::many_lights::{SPEC, settings},
    verify::{About, Gate, GateContext, Tally, gate},
};
use dapple_many_lights::{
    Frame, Technique,
    bound::{self, Region},
    cut::{Receiver, Rule, band, tile, walk},
};
use glam::DVec3;
use rand::RngExt;
use rand_pcg::Pcg64;

const ABSOLUTE: &str = "absolute-cut";

pub fn gates() -> Vec<Gate> {
    let about = |technique, name, statement, fault| About { technique, name, statement, fault };
    vec![
        gate(
            about(
                ABSOLUTE,
                "tile bounds",
                "what a tile's bound says of a cluster holds for all its pixels, and where they face \
                 one way it is at least each one's bound",
                "the bound is that of the tile's first pixel",
            ),
            tiles,
        ),
        gate(
            about(
                ABSOLUTE,
                "guard band",
                "where cuts in f32 and f64 part, the bound is within rounding of the threshold",
                "the threshold in f32 is 1 % off",
            ),
            guard,
        ),
        on_device(
            about(
                ABSOLUTE,
                "gpu guard band",
                "pixels whose bounds are clear of the threshold make the same cut on the device as \
                 in f64",
                "the device's threshold is a tenth off",
            ),
            device_guard,
        ),
    ]
}

/// Pixels of each of a frame's tiles that show anything.
fn tiles_of(frame: &Frame) -> Vec<Vec<usize>> {
    let (columns, rows) = tile::tiles(frame.width, frame.height);
    let all = (0..rows).flat_map(|row| (0..columns).map(move |column| (column, row)));
    let pixels = all.map(|(column, row)| {
        let pixels = tile::pixels(frame.width, frame.height, column, row);
        pixels.filter(|&pixel| frame.points[pixel].is_there()).collect::<Vec<_>>()
    });
    pixels.filter(|pixels| !pixels.is_empty()).collect()
}

fn tiles(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for number in 0..input::cases(context, 4, faulty) {
        let world = input::world(context.seed, number);
        let tree = hard::tree(&mut input::rng(context.seed, "tile", number), &world.lights)?;
        let frame = &world.frames[0];
        for pixels in tiles_of(frame) {
            let points = || pixels.iter().map(|&pixel| &frame.points[pixel]);
            let over = if faulty { 1 } else { pixels.len() };
            let Some(region) = Region::of(points().take(over)) else { continue };
            let flat = points().all(|point| point.normal == frame.points[pixels[0]].normal);
            for (pixel, point) in points().enumerate() {
                let each: Vec<DVec3> = world
                    .lights
                    .iter()
                    .map(|light| dapple_many_lights::radiance(point, light, world.clamp_m))
                    .collect();
                for (index, node) in tree.nodes.iter().enumerate() {
                    let sum: DVec3 = hard::below(&tree, index).map(|light| each[light]).sum();
                    let form = FORMS[(pixel + index) % 2];
                    let all = bound::region(form, node, &region, world.clamp_m);
                    tally.check(sum.max_element() <= all * (1.0 + 1e-12), || {
                        format!("node {index}, pixel {pixel}: {sum} above {all}")
                    });
                    let own = bound::point(form, node, point, world.clamp_m);
                    tally.check(!flat || own <= all * (1.0 + 1e-5), || {
                        format!("node {index}, pixel {pixel}: {own} above {all}")
                    });
                }
            }
        }
    }
    Ok(tally)
}

fn guard(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for number in 0..input::cases(context, 6, faulty) {
        let world = input::world(context.seed, number);
        let mut rng = input::rng(context.seed, "guard", number);
        let packed = hard::tree(&mut rng, &world.lights)?.pack();
        // What f32 walks has had its boxes moved outwards already.
        let tree = band::unpacked(&packed);
        for (pixel, point) in
            world.frames[0].points.iter().enumerate().filter(|(_, p)| p.is_there())
        {
            let threshold = 10.0_f64.powf(rng.random_range(-5.0..-1.0));
            let rule = Rule::Absolute(threshold);
            let other = Rule::Absolute(if faulty { 1.01 * threshold } else { threshold });
            let form = FORMS[pixel % 2];
            let receiver = Receiver { point, form, clamp_m: world.clamp_m };
            let takes = |node: u32| other.takes(&packed.nodes[node as usize], &receiver);
            let parted = band::differences(&tree, &tree.roots, rule, &receiver, takes);
            let unexplained = parted.iter().find(|difference| !difference.is_explained());
            tally.check(unexplained.is_none(), || format!("pixel {pixel}: {unexplained:?}"));
        }
    }
    Ok(tally)
}

fn device_guard(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    let technique = SPEC.technique(ABSOLUTE)?;
    let mut decided = 0;
    for (number, variant) in (0..).zip(technique.variants) {
        let given =
            input::Given::new(input::world(context.seed, 3 * number), context.seed, context.gpu)?;
        let mut rng = input::rng(context.seed, "gpu guard", number);
        let threshold = 1.0 / 1020.0;
        let with = |form, threshold: f64, rng: &mut Pcg64| {
            let knobs = [("threshold", threshold.into()), ("tree", "median".into())];
            input::setting_with(rng, technique, variant.id, form, &knobs)
        };
        let reference = with(Form::Reference, threshold, &mut rng)?;
        let off = if faulty { 1.1 * threshold } else { threshold };
        let mut knobs = reference.knobs.clone();
        knobs.insert("threshold".into(), off.into());
        let device = Setting { form: Form::Gpu, knobs, ..reference.clone() };
        let (ours, theirs) = (given.frames(&device, 0)?, given.frames(&reference, 0)?);
        let Technique::Absolute(cut) = settings::technique(&reference)? else { continue };
        let (tree, frame) = (given.tree(&reference)?, &given.world.frames[0]);
        let (packed, clamp_m) = (tree.pack(), given.world.clamp_m);
        for pixels in tiles_of(frame) {
            for &pixel in &pixels {
                let own = [pixel];
                let over = if variant.id == "tile" { &pixels[..] } else { &own[..] };
                let points = over.iter().map(|&pixel| &frame.points[pixel]);
                let Some(region) = Region::of(points) else { continue };
                let mut near = false;
                walk(&tree, &tree.roots, |index, node| {
                    let packed = &packed.nodes[index as usize];
                    let (low, high) = bound::band(cut.bound, node, packed, &region, clamp_m);
                    near |= !node.is_leaf() && low <= threshold && threshold < high;
                    let bound = bound::region(cut.bound, node, &region, clamp_m);
                    node.is_leaf() || bound <= threshold
                });
                if !near {
                    decided += 1;
                    let (a, b) = (ours[0].visits[pixel], theirs[0].visits[pixel]);
                    tally.check(a == b, || {
                        format!("{device}: pixel {pixel} visits {a} nodes, reference {b}")
                    });
                }
            }
        }
    }
    tally.check(decided > 50, || format!("{decided} pixels are clear of the threshold"));
    Ok(tally)
}
