//! The item buffer by rays, against closed form: rectangles behind rectangles.

use super::{ALL, input, play};
use crate::{
    SuiteError,
    verify::{About, Gate, GateContext, Tally, gate},
};
use dapple_scene::{CameraPath, Scene};
use glam::{DVec2, DVec3};
use rand::RngExt;
use rand_pcg::Pcg64;
use std::collections::BTreeMap;

/// Worlds of a gate.
const CASES: u32 = 16;

/// Rays of the finer grid a side of a pixel.
const SAMPLES: u32 = 2;

pub fn gates() -> Vec<Gate> {
    let about = |name, statement, fault| About { technique: ALL, name, statement, fault };
    vec![
        gate(
            about(
                "truth: owners",
                "of rectangles that face the camera, each owns the pixels and rays that no nearer \
                 one covers",
                "the camera stands a metre further back",
            ),
            |context, faulty| rectangles(context, faulty, 1.0, 1.0),
        ),
        gate(
            about(
                "truth: order",
                "the nearer of two rectangles owns what both cover",
                "the farthest is taken for the nearest",
            ),
            |context, faulty| rectangles(context, faulty, 0.0, -1.0),
        ),
        gate(
            about(
                "truth: sure",
                "a pixel is sure where no edge passes within 1/64 of its centre, and not where one \
                 passes within a quarter of that",
                "edges lie twice as far from the centres",
            ),
            sure,
        ),
    ]
}

/// Rectangles in pixels, x and y from the top left, and a distance.
struct Rectangle {
    min: DVec2,
    max: DVec2,
    distance: f64,
}

/// Edges pass between rays: those of pixels' centres and of the finer grid.
fn edge(rng: &mut Pcg64, most: u32) -> f64 {
    f64::from(rng.random_range(0..=most)) + [0.1, 0.4, 0.65, 0.9][rng.random_range(0..4_usize)]
}

fn rectangle(rng: &mut Pcg64, number: u32) -> Rectangle {
    let (width, height) = (input::WIDTH, input::WIDTH * 9 / 16);
    let x = [edge(rng, width - 1), edge(rng, width - 1)];
    let y = [edge(rng, height - 1), edge(rng, height - 1)];
    Rectangle {
        min: DVec2::new(x[0].min(x[1]), y[0].min(y[1])),
        max: DVec2::new(x[0].max(x[1]), y[0].max(y[1])),
        // In no order of the list.
        distance: 10.0 + f64::from((7 * number) % 12) + rng.random_range(0.0..0.5),
    }
}

/// The scene of rectangles, each a flat box, looked at along -z from so far behind where they were
/// measured.
fn scene(rectangles: &[Rectangle], back_m: f64) -> Scene {
    let (width, height) = (f64::from(input::WIDTH), f64::from(input::WIDTH * 9 / 16));
    let half = DVec2::new((0.5_f64).tan() * width / height, (0.5_f64).tan());
    let boxes: Vec<(DVec3, DVec3)> = rectangles
        .iter()
        .map(|r| {
            let world = |p: DVec2| {
                let ndc = DVec2::new(2.0 * p.x / width - 1.0, 1.0 - 2.0 * p.y / height);
                (ndc * half * r.distance).extend(-r.distance)
            };
            let (a, b) = (world(r.min), world(r.max));
            (a.min(b), (b - a).abs())
        })
        .collect();
    let mut scene = input::boxes("rectangles", &boxes);
    let eye = DVec3::Z * back_m;
    let ahead = input::camera(eye, eye + DVec3::NEG_Z);
    scene.paths = vec![CameraPath { name: "path".into(), keys: vec![ahead], frames: 1 }];
    scene
}

/// The rectangle that owns a ray through a point of the image; nearest first by `sign`.
fn owner(rectangles: &[Rectangle], p: DVec2, sign: f64) -> Option<u32> {
    let covers = |r: &Rectangle| p.cmpgt(r.min).all() && p.cmplt(r.max).all();
    let covering = (0..).zip(rectangles).filter(|(_, r)| covers(r));
    let order = |r: &Rectangle| sign * r.distance;
    covering.min_by(|a, b| order(a.1).total_cmp(&order(b.1))).map(|(index, _)| index)
}

fn rectangles(
    context: &GateContext<'_>,
    faulty: bool,
    back_m: f64,
    sign: f64,
) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    let (back_m, sign) = if faulty { (back_m, sign) } else { (0.0, 1.0) };
    for number in 0..play::cases(context, CASES, faulty) {
        let mut rng = input::rng(context.seed, "rectangles", number);
        let given: Vec<Rectangle> =
            (0..rng.random_range(2..12)).map(|i| rectangle(&mut rng, i)).collect();
        let samples = ("truth_samples", i64::from(SAMPLES));
        let case = input::of(scene(&given, back_m), None, 0, &[samples], None)?;
        let mut expected: BTreeMap<u32, [u32; 2]> = BTreeMap::new();
        for y in 0..input::WIDTH * 9 / 16 {
            for x in 0..input::WIDTH {
                let corner = DVec2::new(f64::from(x), f64::from(y));
                if let Some(owner) = owner(&given, corner + 0.5, sign) {
                    expected.entry(owner).or_default()[0] += 1;
                }
                for s in 0..SAMPLES * SAMPLES {
                    let at = |i: u32| (f64::from(i) + 0.5) / f64::from(SAMPLES);
                    let ray = corner + DVec2::new(at(s % SAMPLES), at(s / SAMPLES));
                    if let Some(owner) = owner(&given, ray, sign) {
                        expected.entry(owner).or_default()[1] += 1;
                    }
                }
            }
        }
        let found = case.truth().frames[0].iter().map(|o| (o.object, [o.sure, o.samples]));
        let found: BTreeMap<u32, [u32; 2]> = found.collect();
        tally.check(found == expected, || {
            format!("scene {number}: pixels and rays {found:?}, expected {expected:?}")
        });
    }
    Ok(tally)
}

fn sure(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    let far = if faulty { 8.0 } else { 1.0 };
    for number in 0..play::cases(context, CASES, faulty) {
        let mut rng = input::rng(context.seed, "sure", number);
        let (x, y) = (rng.random_range(5..20_u32), rng.random_range(4..12_u32));
        let size = DVec2::new(f64::from(rng.random_range(5..12)), 6.0);
        let corner = DVec2::new(f64::from(x), f64::from(y)) + 0.5;
        for (off, all) in [(far / 256.0, false), (1.0 / 32.0, true)] {
            // All four edges pass just outside the centres of the outermost pixels.
            let given = Rectangle { min: corner - off, max: corner + size + off, distance: 10.0 };
            let case = input::of(scene(&[given], 0.0), None, 0, &[], None)?;
            let rows = size + if all { 1.0 } else { -1.0 };
            let expected = rows.x * rows.y;
            let found = case.truth().frames[0].iter().map(|o| f64::from(o.sure)).sum::<f64>();
            tally.within((found - expected).abs(), 0.0, || {
                format!("scene {number}, edges {off} px off: {found} sure, expected {expected}")
            });
        }
    }
    Ok(tally)
}
