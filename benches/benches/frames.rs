//! Frame times of every technique, on checked cases.

use criterion::{Criterion, criterion_group, criterion_main};

const SHADOWS: &str = r#"
about = "shadow filters on one chapter scene"
[[measure]]
problem = "shadow-filtering"
scenes = ["spheres"]
parameters = { width = [192] }
knobs = { resolution = [512] }
"#;

const PARTITION: &str = r#"
about = "partition offsets of the thesis's largest crown"
[[measure]]
problem = "partition-offsets"
parameters = { leaves = [131042], frames = [24] }
"#;

const TRANSLUCENT: &str = r#"
about = "every way to store light inside foliage, at its defaults"
[[measure]]
problem = "translucent-shadow"
parameters = { width = [192] }
"#;

const VISIBILITY: &str = r#"
about = "every way to find what a camera sees, along a street of the small city"
[[measure]]
problem = "camera-visibility"
parameters = { width = [192], frames = [4] }
"#;

const LIGHTS: &str = r#"
about = "every way to light a street of the small city by its windows and lamps"
[[measure]]
problem = "many-lights"
parameters = { width = [64], frames = [2], truth_pixels = [256] }
"#;

const REGIONS: &str = r#"
about = "every way to find which lights of the small city reach a street's facades"
[[measure]]
problem = "region-light-visibility"
parameters = { width = [64], truth_faces = [4], truth_lights = [128], truth_points = [32] }
"#;

const NIGHT: &str = r#"
about = "whole frames of a street of the small city"
[[measure]]
problem = "night-city"
parameters = { width = [64], frames = [2], truth_pixels = [48] }
"#;

fn regions(criterion: &mut Criterion) {
    dapple_benches::sweep(criterion, "regions", REGIONS);
}

fn night(criterion: &mut Criterion) {
    dapple_benches::sweep(criterion, "night", NIGHT);
}

fn lights(criterion: &mut Criterion) {
    dapple_benches::sweep(criterion, "lights", LIGHTS);
}

fn visibility(criterion: &mut Criterion) {
    dapple_benches::sweep(criterion, "visibility", VISIBILITY);
}

fn shadows(criterion: &mut Criterion) {
    dapple_benches::sweep(criterion, "shadows", SHADOWS);
}

fn translucent(criterion: &mut Criterion) {
    dapple_benches::sweep(criterion, "translucent", TRANSLUCENT);
}

fn partition(criterion: &mut Criterion) {
    dapple_benches::sweep(criterion, "partition", PARTITION);
}

criterion_group!(frames, shadows, translucent, partition, visibility, lights, regions, night);
criterion_main!(frames);
