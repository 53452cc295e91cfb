//! Encoding and shading of layered opacity maps on the processor, by layout and number of layers.
//!
//! What is timed is checked before: the last layer of every texel holds all that lies in it.
#![allow(missing_docs, reason = "criterion_group! writes an undocumented function")]

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use dapple_opacity_maps::{
    Bins, Blend, Code, EndMap, Format, Fragment, Fragments, Layered, Layout, Lookup, NO_OPAQUE,
    Packing, Receiver, Settings, Slicing, Split, SplitKind, Storage, Taps, cpu::Maps, exact::Exact,
};
use std::{hint::black_box, time::Duration};

/// Texels a side.
const SIDE: u32 = 128;

/// Most fragments of a texel; there are 0 to this many of them, as in foliage.
const MOST: u32 = 16;

const LAYERS: [u32; 4] = [4, 8, 16, 32];

/// The places of Weyl's sequence: fixed, even, and without visible order.
fn weyl(index: u32) -> f32 {
    (f64::from(index) * 0.754_877_666_246_692_8).fract() as f32
}

fn fragments() -> Fragments {
    let texels = SIDE * SIDE;
    let (mut starts, mut items) = (vec![0], Vec::new());
    for texel in 0..texels {
        let first = 0.2 + 0.5 * weyl(texel);
        let count = (weyl(texel ^ 0x5555) * (MOST + 1) as f32) as u32;
        for i in 0..count {
            let depth = first + 0.25 * weyl(texel.wrapping_mul(31).wrapping_add(i));
            items.push(Fragment { depth, omega: 0.1 + weyl(i) });
        }
        starts.push(items.len() as u32);
    }
    let opaque = vec![NO_OPAQUE; texels as usize];
    Fragments { width: SIDE, height: SIDE, starts, items, opaque }
}

/// As many as a small picture has, at all depths.
fn receivers() -> Vec<Receiver> {
    let one = |i| Receiver::at(weyl(i), weyl(i.wrapping_mul(7)), weyl(i.wrapping_mul(3)));
    (0..1 << 16).map(one).collect()
}

fn layouts(exact: &Exact) -> [(&'static str, Layout); 4] {
    let split = |lambda| Split { lambda, kind: SplitKind::Normalised, width: 512 };
    let bounded = |lambda| Layout::Bounded { split: split(lambda), bins: Bins::Full };
    let deep = Layout::Deep { span: exact.deepest_span(), growth: 1.0, listing: false };
    [
        ("planes", Layout::Planes(Slicing::Uniform)),
        ("deep", deep),
        ("bounded", bounded(0.0)),
        ("bounded split at 0.5", bounded(0.5)),
    ]
}

fn settings(layout: Layout, layers: u32) -> Settings {
    let layered = Layered {
        layout,
        layers,
        lookup: Lookup::Lerp,
        write_bias: 0.0,
        soft_start: false,
        blend: Blend::Add,
        format: Format::F32,
        packing: Packing::Targets(8),
        storage: Storage::Blend,
        end_map: EndMap::MaxBlend,
    };
    Settings { taps: Taps::Box3, ..Settings::plain(Code::Layered(layered)) }
}

/// The last layer of every texel holds all that lies in it.
fn check(maps: &Maps, exact: &Exact, name: &str) {
    let mut checked = 0;
    for texel in 0..maps.texels() {
        let total = exact.omega(texel, NO_OPAQUE);
        let sum = maps.texel(texel).last().map_or(f64::NAN, |s| f64::from(*s));
        assert!((sum - total).abs() <= 1e-4 * total.max(1.0), "{name}: {sum} of {total}");
        checked += usize::from(total > 0.0);
    }
    assert!(checked > maps.texels() / 2, "{name}: only {checked} texels hold anything");
}

#[expect(clippy::panic, reason = "a bench must not time what is wrong")]
fn layers(criterion: &mut Criterion) {
    let (fragments, receivers) = (fragments(), receivers());
    let exact = Exact::of(&fragments);
    let mut result = vec![0.0; receivers.len()];
    for (name, layout) in layouts(&exact) {
        let ready = LAYERS.map(|layers| {
            let settings = settings(layout.clone(), layers);
            let mut maps = Maps::new(SIDE, SIDE, &settings).unwrap_or_else(|e| panic!("{e}"));
            maps.build(&fragments).unwrap_or_else(|e| panic!("{e}"));
            check(&maps, &exact, name);
            (layers, maps)
        });
        let short = (Duration::from_millis(500), Duration::from_secs(1));
        let mut group = criterion.benchmark_group(format!("layers/encode/{name}"));
        group.throughput(Throughput::Elements(fragments.items.len() as u64)).sample_size(15);
        group.warm_up_time(short.0).measurement_time(short.1);
        let mut built = Vec::new();
        for (layers, mut maps) in ready {
            group.bench_function(BenchmarkId::from_parameter(layers), |bencher| {
                bencher.iter(|| maps.build(black_box(&fragments)));
            });
            built.push((layers, maps));
        }
        group.finish();
        let mut group = criterion.benchmark_group(format!("layers/shade/{name}"));
        group.throughput(Throughput::Elements(receivers.len() as u64)).sample_size(15);
        group.warm_up_time(short.0).measurement_time(short.1);
        for (layers, maps) in &built {
            group.bench_function(BenchmarkId::from_parameter(layers), |bencher| {
                bencher.iter(|| maps.shade(black_box(&receivers), &mut result));
            });
        }
        group.finish();
    }
}

criterion_group!(benches, layers);
criterion_main!(benches);
