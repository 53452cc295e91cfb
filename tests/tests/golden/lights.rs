//! Many lights: a wall lit by a facade, the city at night from its four points of view, what
//! each technique leaves out or adds there, and how many nodes its pixels visit.

use dapple_many_lights::Shaded;
use dapple_suite::{
    case::Case,
    knob::{self, Knobs},
    problem::{Form, Setting},
    problems::many_lights::{LightsCase, SPEC, picture::grey},
};
use dapple_tests::golden::{LSB, Picture, Tolerance, assert_golden};
use glam::Vec3;

/// Of all pictures; no multiple of a tile's 8 rows.
const SIZE: [u32; 2] = [160, 90];

/// The thesis's points of view. Before the facade alone light is so even that a picture moved by a
/// pixel would pass for itself: it is held to the sum, and no golden.
const VIEWS: [&str; 4] = ["facade", "close_ended", "street", "birds_eye"];
const EVEN: &str = "facade";

/// Pixels of a picture that are held against the sum in f64.
const TRUTH_PIXELS: u32 = 256;

/// The thesis's thresholds, a hundredth and a quarter of a step of 255, and the error that it reports.
const THRESHOLD: f64 = 1.0 / 25_500.0;
const COARSE: f64 = 1.0 / 1020.0;
const STEPS: f32 = 2.0 / 255.0;

/// The thesis's figure 5.5 shows errors so many times as bright.
const AMPLIFIED: f32 = 128.0;

/// Nodes a pixel that are white in pictures of visits.
const WHITE_VISITS: f32 = 6000.0;

/// Names and tolerances of this file's goldens.
pub fn goldens() -> Vec<(String, Tolerance)> {
    let seen = VIEWS.iter().filter(|view| **view != EVEN);
    let mut names: Vec<String> = seen.map(|view| format!("night-{view}")).collect();
    names.extend(
        ["disks-relative", "disks-absolute", "disks-city", "error", "light-bvh", "reservoirs"]
            .map(|name| format!("night-{name}")),
    );
    names.extend(
        ["clustered", "capped", "visits-pixel", "visits-tile"].map(|name| format!("night-{name}")),
    );
    names.into_iter().map(|name| (name, LSB)).collect()
}

fn case(scene: &str, view: &str, frames: u32) -> LightsCase<'static> {
    let given: [(String, _); 3] = [
        ("width".into(), SIZE[0].into()),
        ("frames".into(), frames.into()),
        ("truth_pixels".into(), TRUTH_PIXELS.into()),
    ];
    let case = Case {
        problem: SPEC.id.into(),
        scene: scene.into(),
        view: view.into(),
        seed: 0,
        parameters: knob::complete("parameter", SPEC.parameters, &Knobs::from(given)).unwrap(),
    };
    let case = LightsCase::prepare(&case, None).unwrap();
    let frame = &case.world().frames[0];
    assert_eq!([frame.width, frame.height], SIZE);
    case
}

fn setting(technique: &str, given: &[(&str, serde_json::Value)]) -> Setting {
    let (id, variant) = technique.split_once('/').unwrap_or((technique, ""));
    let technique = SPEC.technique(id).unwrap();
    let variant = technique.variants.iter().find(|v| v.id == variant || variant.is_empty());
    let given = given.iter().map(|(name, value)| ((*name).into(), value.clone())).collect();
    Setting {
        technique: id.into(),
        variant: variant.unwrap().id.into(),
        form: Form::Cpu,
        knobs: knob::complete("knob", technique.knobs, &given).unwrap(),
    }
}

/// The last frame of a path, lit by a technique from the start.
fn lit(case: &LightsCase<'_>, setting: &Setting) -> Shaded {
    let mut lighting = case.lighting(setting).unwrap();
    let mut shaded = Shaded::default();
    lighting.reset(case.seed()).unwrap();
    for frame in 0..case.world().frames.len() {
        lighting.shade(frame, true).unwrap();
        lighting.read(&mut shaded).unwrap();
    }
    shaded
}

/// Every light at every pixel of the last frame, held against the sum in f64 at some of them.
fn everything(case: &LightsCase<'_>) -> Vec<Vec3> {
    let all = lit(case, &setting("brute-force", &[])).radiance;
    let last = case.world().frames.len() - 1;
    let (mut held, mut bright) = (0, 0.0_f64);
    for (pixel, exact) in case.truth().frame(last) {
        let off = (all[pixel as usize].as_dvec3() - exact).abs().max_element();
        assert!(off <= 1e-5 * exact.max_element().max(0.1), "pixel {pixel}: {off} of {exact}");
        held += 1;
        bright += exact.max_element();
    }
    assert!(held == TRUTH_PIXELS && bright > 1.0, "{held} pixels held, {bright} in all");
    all
}

/// By pixel: the error of the worst channel.
fn errors(shaded: &Shaded, all: &[Vec3]) -> Vec<f32> {
    let pairs = shaded.radiance.iter().zip(all);
    pairs.map(|(a, b)| (*a - *b).abs().max_element()).collect()
}

fn most(errors: &[f32]) -> f32 {
    errors.iter().copied().fold(0.0, f32::max)
}

fn mean(values: impl ExactSizeIterator<Item = f32>) -> f32 {
    let count = values.len() as f32;
    values.sum::<f32>() / count
}

/// Mean of the luminance-free sum of channels, to compare brightness as a whole.
fn brightness(radiance: &[Vec3]) -> f32 {
    mean(radiance.iter().map(|r| r.element_sum()))
}

/// What a display shows: luminance, encoded.
fn shown(radiance: &[Vec3]) -> Picture {
    let values: Vec<f32> = radiance.iter().copied().map(grey).collect();
    Picture::from_values(SIZE[0], SIZE[1], &values)
}

fn scaled(values: impl Iterator<Item = f32>, by: f32) -> Picture {
    let values: Vec<f32> = values.map(|v| (v * by).min(1.0)).collect();
    Picture::from_values(SIZE[0], SIZE[1], &values)
}

fn absolute(threshold: f64) -> Setting {
    setting("absolute-cut", &[("threshold", threshold.into())])
}

/// The city's windows and lamps, each pixel by its own cut.
#[test]
fn four_points_of_view_at_night() {
    for view in VIEWS {
        let case = case("city", view, 1);
        let all = everything(&case);
        let cut = lit(&case, &absolute(THRESHOLD));
        let most = most(&errors(&cut, &all));
        let lights = case.world().lights.len() as u64;
        let visits = cut.work.visits / cut.work.pixels;
        println!("{view}: most off {most}, {visits} nodes a pixel for {lights} lights");
        assert!(most <= STEPS, "{view}: {most}");
        assert!(visits < lights, "{view}: {visits} nodes a pixel");
        if view != EVEN {
            assert_golden(&format!("night-{view}"), &shown(&cut.radiance), LSB);
        }
    }
}

/// Figure 5.5 (d): where a cut errs, 128 times as bright. At the thesis's threshold for it nothing
/// would show, so this is the coarser one.
#[test]
fn errors_of_the_cut() {
    let case = case("city", "close_ended", 1);
    let all = everything(&case);
    let fine = most(&errors(&lit(&case, &absolute(THRESHOLD)), &all));
    let errors = errors(&lit(&case, &absolute(COARSE)), &all);
    println!("worst: {} steps, at the fine threshold {}", 255.0 * most(&errors), 255.0 * fine);
    assert!(fine < most(&errors) && most(&errors) <= STEPS);
    assert_golden("night-error", &scaled(errors.into_iter(), AMPLIFIED), LSB);
}

/// Figure 3.2: at as many nodes a cut, the relative rule leaves disks. Where all of a facade's
/// storeys have their middles above each other, they make a line.
#[test]
fn disks_of_the_relative_rule() {
    for (scene, view, epsilon) in [("light_facade", "", 0.5), ("city", "close_ended", 2.0)] {
        let case = case(scene, view, 1);
        let all = everything(&case);
        let relative = lit(&case, &setting("relative-cut", &[("own_epsilon", epsilon.into())]));
        let thresholds = (0..60).map(|step| 0.8_f64.powi(step));
        let kept = thresholds
            .map(|threshold| lit(&case, &absolute(threshold)))
            .take_while(|cut| cut.work.cut <= relative.work.cut)
            .last()
            .unwrap();
        let [disks, none] = [&relative, &kept].map(|cut| most(&errors(cut, &all)));
        let nodes = [&relative, &kept].map(|cut| cut.work.cut as f64 / cut.work.pixels as f64);
        println!("{scene}: most off {disks} and {none} with {nodes:.1?} nodes a cut");
        assert!(disks > 5.0 * none && disks > STEPS, "{scene}: {disks} and {none}");
        if scene == "city" {
            assert_golden("night-disks-city", &shown(&relative.radiance), LSB);
        } else {
            assert_golden("night-disks-relative", &shown(&relative.radiance), LSB);
            assert_golden("night-disks-absolute", &shown(&kept.radiance), LSB);
        }
    }
}

/// Lights drawn by chance: noise about the right brightness.
#[test]
fn noise_of_what_is_drawn() {
    for (name, technique, frames) in
        [("light-bvh", "light-bvh", 1), ("reservoirs", "reservoirs/unbiased", 8)]
    {
        let case = case("city", "street", frames);
        let all = everything(&case);
        let drawn = lit(&case, &setting(technique, &[]));
        let (ours, theirs) = (brightness(&drawn.radiance), brightness(&all));
        let noise = mean(errors(&drawn, &all).into_iter()) / (theirs / 3.0);
        println!("{name}: brightness {ours} of {theirs}, mean error {noise} of it");
        assert!((ours / theirs - 1.0).abs() < 0.1, "{name}: {ours} of {theirs}");
        assert!(noise > 0.01 && noise < 2.0, "{name}: {noise}");
        assert_golden(&format!("night-{name}"), &shown(&drawn.radiance), LSB);
    }
}

/// What lists leave out: lights beyond their reach, and beyond a cap.
#[test]
fn what_lists_leave_out() {
    let case = case("city", "street", 1);
    let all = everything(&case);
    let reach = setting("clustered/cut", &[("cutoff", 0.01.into())]);
    let cap = setting("capped", &[("most", 64.into())]);
    for (name, setting) in [("clustered", reach), ("capped", cap)] {
        let listed = lit(&case, &setting);
        // Nothing is added, and something is missing.
        let more = listed.radiance.iter().zip(&all).filter(|(a, b)| a.cmpgt(**b * 1.0001).any());
        assert_eq!(more.count(), 0, "{name}");
        let (ours, theirs) = (brightness(&listed.radiance), brightness(&all));
        println!("{name}: brightness {ours} of {theirs}, {:?}", listed.work);
        assert!(ours < 0.98 * theirs && ours > 0.2 * theirs, "{name}: {ours} of {theirs}");
        assert_golden(&format!("night-{name}"), &shown(&listed.radiance), LSB);
    }
}

/// Nodes that pixels visit: by their own cuts, and by their tiles', which are the same for all 64.
#[test]
fn visits_of_pixels_and_tiles() {
    let case = case("city", "street", 1);
    let frame = &case.world().frames[0];
    let mut visits = Vec::new();
    for per in ["pixel", "tile"] {
        let name = format!("absolute-cut/{per}");
        let cut = lit(&case, &setting(&name, &[("threshold", THRESHOLD.into())]));
        println!(
            "{per}: {} nodes a pixel, divergence {:.3}, most {:?}",
            cut.work.visits / cut.work.pixels,
            cut.work.divergence(),
            cut.visits.iter().max()
        );
        visits.push(cut.visits);
    }
    for (pixel, point) in frame.points.iter().enumerate().filter(|(_, p)| p.is_there()) {
        let (own, tiles) = (visits[0][pixel], visits[1][pixel]);
        assert!(own > 0 && own <= tiles, "pixel {pixel} on {}: {own} {tiles}", point.object);
    }
    for (per, visits) in ["pixel", "tile"].iter().zip(visits) {
        let picture = scaled(visits.into_iter().map(|v| v as f32), 1.0 / WHITE_VISITS);
        assert_golden(&format!("night-visits-{per}"), &picture, LSB);
    }
}
