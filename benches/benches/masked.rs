//! Clear and rasterise of the masked depth buffer on one core: the recording that comes with the
//! published kernel, 14 894 triangles at 1920 x 1080. Needs `DAPPLE_DATA`.
//!
//! The published kernel takes .38 ms with SSE4.1, .25 with AVX2 and .20 with AVX-512.
#![allow(missing_docs, reason = "criterion_group! writes an undocumented function")]
#![allow(clippy::print_stderr, reason = "a bench says what it leaves out")]
#![allow(clippy::expect_used, reason = "a bench must not time what is wrong")]

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use dapple_occlusion::camera::masked::{Buffer, Edges, Facing, Form, Occluder};

#[allow(dead_code, reason = "tests read more of a recording than the bench")]
#[path = "../../crates/occlusion/tests/recording/mod.rs"]
mod recording;

use recording::Recording;

fn load() -> Option<Recording> {
    let Some(root) = std::env::var_os("DAPPLE_DATA") else {
        eprintln!("skipped: masked culling: DAPPLE_DATA is not set");
        return None;
    };
    let path = std::path::Path::new(&root).join("occlusion/OcclusionCulling_0.mocrec");
    let bytes = std::fs::read(&path).expect("the recording");
    Some(recording::read(&bytes).expect("a recording"))
}

fn draw(recording: &Recording, buffer: &mut Buffer) {
    for mesh in &recording.meshes {
        let facing = match mesh.back {
            0 => Facing::Both,
            1 => Facing::CounterClockwise,
            _ => Facing::Clockwise,
        };
        let (positions, triangles) = (&mesh.positions[..], &mesh.triangles[..]);
        let occluder = Occluder { positions, triangles, facing, edges: Edges::Exact };
        buffer.rasterise(&occluder, &mesh.clip).expect("a good mesh");
    }
}

fn benches(criterion: &mut Criterion) {
    let Some(recording) = load() else { return };
    let mut group = criterion.benchmark_group("masked");
    group.throughput(Throughput::Elements(recording.triangles() as u64));
    let size = [recording.width, recording.height];
    for form in [Form::Fast, Form::Reference] {
        let mut buffer = Buffer::new(form, size[0], size[1]).expect("a buffer");
        group.bench_function(format!("clear + rasterise, {form:?}"), |b| {
            b.iter(|| {
                buffer.clear();
                draw(&recording, &mut buffer);
            });
        });
    }
    let mut buffer = Buffer::new(Form::Fast, size[0], size[1]).expect("a buffer");
    group.bench_function("clear", |b| b.iter(|| buffer.clear()));
    group.finish();
}

criterion_group!(masked, benches);
criterion_main!(masked);
