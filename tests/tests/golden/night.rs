//! A city at night, whole frames: a street by what is kept of its lights, where light leaks through
//! walls, and how long the lists of its cells are.

use dapple_many_lights::{
    Form, LightTree, Shaded, Technique, World, make, radiance, region::truth::kept,
};
use dapple_suite::{
    case::Case,
    knob::{self, Knobs},
    problem::{self, Setting},
    problems::{
        many_lights::picture::grey,
        night_city::{NightCase, SPEC},
    },
};
use dapple_tests::golden::{LSB, Picture, Tolerance, assert_golden};
use glam::Vec3;
use std::sync::Arc;

/// No multiple of a tile's 8 rows.
const SIZE: [u32; 2] = [160, 120];

/// Pixels that are held against the sum in f64.
const TRUTH_PIXELS: u32 = 256;

/// Weaker lights may be left out of lists: radiance of a white surface, the default.
const THRESHOLD: f64 = 1.0 / 1020.0;

/// Two steps of 255.
const STEPS: f32 = 2.0 / 255.0;

/// Leaks are shown so many times as bright.
const AMPLIFIED: f32 = 8.0;

/// Nodes of a list that is white.
const WHITE_NODES: f32 = 512.0;

const TECHNIQUES: [&str; 3] = ["facade-cluster", "full-tree", "traced-cut"];

/// Names and tolerances of this file's goldens.
pub fn goldens() -> Vec<(String, Tolerance)> {
    let mut names: Vec<String> =
        TECHNIQUES.iter().map(|name| format!("night-city-{name}")).collect();
    names.extend(["leak", "leak-full-tree", "lists"].map(|name| format!("night-city-{name}")));
    names.into_iter().map(|name| (name, LSB)).collect()
}

fn case() -> NightCase<'static> {
    let given: [(String, _); 3] = [
        ("width".into(), SIZE[0].into()),
        ("frames".into(), 1.into()),
        ("truth_pixels".into(), TRUTH_PIXELS.into()),
    ];
    let case = Case {
        problem: SPEC.id.into(),
        scene: "city_small".into(),
        view: "street".into(),
        seed: 0,
        parameters: knob::complete("parameter", SPEC.parameters, &Knobs::from(given)).unwrap(),
    };
    let case = NightCase::prepare(&case, None).unwrap();
    assert_eq!(case.night().size, SIZE);
    case
}

/// The first frame as a technique lights it, and how many nodes each pixel's list has.
struct Lit {
    radiance: Vec<Vec3>,
    lists: Vec<Vec<u32>>,
}

fn lit(case: &NightCase<'_>, technique: &str) -> Lit {
    let technique = SPEC.technique(technique).unwrap();
    let setting = Setting {
        technique: technique.id.into(),
        variant: technique.variants[0].id.into(),
        form: problem::Form::Cpu,
        knobs: knob::complete("knob", technique.knobs, &Knobs::new()).unwrap(),
    };
    let mut method = case.method(&setting).unwrap();
    let mut shaded = Shaded::default();
    method.reset(0).unwrap();
    method.frame(0, false).unwrap();
    method.read(&mut shaded).unwrap();
    let starts = method.starts().unwrap();
    let points = &case.night().town.world(true).frames[0].points;
    let list = |object: u32| starts.of(object).to_vec();
    let lists = points.iter().map(|p| if p.is_there() { list(p.object) } else { vec![] }).collect();
    Lit { radiance: shaded.radiance, lists }
}

/// Every light with its shadow ray at every pixel, held against the sum in f64 at some of them.
fn everything(case: &NightCase<'_>, world: &Arc<World>) -> Vec<Vec3> {
    let none = Arc::new(LightTree::default());
    let mut all = make(Form::Cpu, &Technique::BruteForce, world, &none, None).unwrap();
    let mut shaded = Shaded::default();
    all.reset(0).unwrap();
    all.shade(0, false).unwrap();
    all.read(&mut shaded).unwrap();
    let (mut held, mut bright) = (0, 0.0);
    for (pixel, exact) in case.truth().frame(0) {
        let off = (shaded.radiance[pixel as usize].as_dvec3() - exact).abs().max_element();
        assert!(off <= 1e-5 * exact.max_element().max(0.1), "pixel {pixel}: {off} of {exact}");
        held += 1;
        bright += exact.max_element();
    }
    assert!(held == TRUTH_PIXELS && bright > 1.0, "{held} pixels held, {bright} in all");
    shaded.radiance
}

fn shown(radiance: &[Vec3]) -> Picture {
    let values: Vec<f32> = radiance.iter().copied().map(grey).collect();
    Picture::from_values(SIZE[0], SIZE[1], &values)
}

fn scaled(values: impl Iterator<Item = f32>, by: f32) -> Picture {
    let values: Vec<f32> = values.map(|v| (v * by).min(1.0)).collect();
    Picture::from_values(SIZE[0], SIZE[1], &values)
}

/// By pixel: what the worst channel has too much, and the mean of all channels' over that of the truth.
fn leaks(lit: &Lit, all: &[Vec3]) -> (Vec<f32>, f64) {
    let pairs = || lit.radiance.iter().zip(all);
    let leaks = pairs().map(|(a, b)| (*a - *b).max_element().max(0.0)).collect();
    let [more, whole] = pairs().fold([0.0; 2], |[more, whole], (a, b)| {
        [more + f64::from((*a - *b).element_sum()), whole + f64::from(b.element_sum())]
    });
    (leaks, more / whole)
}

/// What is missing at the pixel that misses most.
fn most_missing(lit: &Lit, all: &[Vec3]) -> f32 {
    lit.radiance.iter().zip(all).map(|(a, b)| (*b - *a).max_element()).fold(0.0, f32::max)
}

/// Lights that reach a pixel of the truth, by a ray, strong enough to matter, and are in no node of its
/// list; and how many do reach one.
fn lost(case: &NightCase<'_>, world: &World, lit: &Lit) -> [u64; 2] {
    let tree = &case.night().town.lights;
    let mut count = [0; 2];
    for (pixel, _) in case.truth().frame(0) {
        let point = &world.frames[0].points[pixel as usize];
        let kept = kept(tree, &lit.lists[pixel as usize]);
        for (light, kept) in world.lights.iter().zip(kept) {
            let strong = radiance(point, light, world.clamp_m).max_element() >= THRESHOLD;
            if strong && world.sees(point, light) {
                count[0] += u64::from(!kept);
                count[1] += 1;
            }
        }
    }
    count
}

/// A street: facade-cluster visibility loses no light, and leaks less than if nothing hid anything; a
/// shadow ray for each cluster leaks least.
#[test]
fn a_street_and_where_light_leaks() {
    let case = case();
    let world = case.night().town.world(true);
    let all = everything(&case, world);
    let [ours, whole, traced] = TECHNIQUES.map(|name| lit(&case, name));
    let [leak, leak_whole, leak_traced] = [&ours, &whole, &traced].map(|lit| leaks(lit, &all));
    let missing = [&ours, &whole, &traced].map(|lit| most_missing(lit, &all));
    println!("leak {} {} {} of the truth", leak.1, leak_whole.1, leak_traced.1);
    println!("most missing {missing:?}");
    assert!(leak.1 < 0.5 * leak_whole.1 && leak_traced.1.abs() < 0.1 * leak.1);
    // Nothing but clusters in place of their lights, and lights too weak, takes any light away.
    assert!(missing[0] <= STEPS && missing[1] <= STEPS, "{missing:?}");
    // Hiding only takes away.
    let added = ours.radiance.iter().zip(&whole.radiance).map(|(a, b)| (*a - *b).max_element());
    assert!(added.fold(0.0, f32::max) <= STEPS);

    let [lost_here, reach] = lost(&case, world, &ours);
    assert!(lost_here == 0 && reach > 1000, "{lost_here} of {reach} lights");
    // Control: with the lists of other pixels, lights are lost.
    let mut turned = lit(&case, "facade-cluster");
    turned.lists.reverse();
    assert!(lost(&case, world, &turned)[0] > 0);

    for (name, lit) in TECHNIQUES.iter().zip([&ours, &whole, &traced]) {
        assert_golden(&format!("night-city-{name}"), &shown(&lit.radiance), LSB);
    }
    assert_golden("night-city-leak", &scaled(leak.0.into_iter(), AMPLIFIED), LSB);
    assert_golden("night-city-leak-full-tree", &scaled(leak_whole.0.into_iter(), AMPLIFIED), LSB);
    let nodes = ours.lists.iter().map(|list| list.len() as f32);
    let most = nodes.clone().fold(0.0, f32::max);
    println!("most nodes of a list: {most}");
    assert!(most > 0.1 * WHITE_NODES && most <= WHITE_NODES, "{most}");
    assert_golden("night-city-lists", &scaled(nodes, 1.0 / WHITE_NODES), LSB);
}
