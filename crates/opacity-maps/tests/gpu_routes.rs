//! Ways of the device that must not change results: routes to the bounds, packings, storages; what
//! they cost; and what is refused.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]
#![allow(clippy::print_stderr, reason = "tests say what they measured")]

mod gpu_support;

use dapple_gpu::light_space::LightSpaceMesh;
use dapple_gpu::testing::live_objects;
use dapple_opacity_maps::gpu::{Fault, Renderer, fragments};
use dapple_opacity_maps::layered::{bytes_per_texel, geometry_passes};
use dapple_opacity_maps::{
    Blend, Code, EndMap, Format, Layered, Layout, Opaque, Packing, Receiver, Settings, Slicing,
    Storage, Taps, reference,
};
use gpu_support::{
    MODEL, add, bounded, draw, exclusive_gpu, foliage, frame, plain, receivers, sheet, vertex,
};

const SIZE: [u32; 2] = [67, 45];
const ROUTES: [EndMap; 5] =
    [EndMap::MaxBlend, EndMap::Atomic, EndMap::Greater, EndMap::Swapped, EndMap::RangeFlip];

fn largest(a: &[f32], b: &[f32]) -> f32 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

#[test]
fn five_routes_find_the_same_bounds() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    let mesh = foliage(5, 60);
    let own = fragments(gpu, &mesh, MODEL, SIZE).unwrap();
    for (opaque, stretches) in [
        (Opaque::Separate, false),
        (Opaque::Weight { weight: 3.0, in_bounds: false }, false),
        (Opaque::Weight { weight: 3.0, in_bounds: true }, true),
    ] {
        let expected: Vec<[f32; 2]> = (0..own.texels())
            .map(|texel| {
                let depths = own.texel(texel).iter().map(|f| f.depth);
                let opaque = Some(own.opaque[texel]).filter(|&z| stretches && z < 1.0);
                let all = || depths.clone().chain(opaque);
                [all().fold(1.0, f32::min), all().fold(0.0, f32::max)]
            })
            .collect();
        let empty = expected.iter().filter(|e| e[0] > e[1]).count();
        assert!(stretches || empty > 10, "no texel is empty");
        for end_map in ROUTES {
            let settings = Settings { opaque, ..plain(Layered { end_map, ..bounded(4) }) };
            let drawn = frame(gpu, &mesh, &[], SIZE, &settings);
            let first = largest(&firsts(&drawn.bounds), &firsts(&expected));
            let last = largest(&lasts(&drawn.bounds), &lasts(&expected));
            eprintln!("{end_map:?} {opaque:?}: first {first:e}, last {last:e}");
            // A depth mirrored and back is off by half a unit in the last place of 1.
            let mirrored = match end_map {
                EndMap::MaxBlend | EndMap::Atomic | EndMap::Greater => 0.0,
                EndMap::RangeFlip | EndMap::Swapped => 6e-8,
            };
            assert_eq!(first, 0.0, "{end_map:?}");
            assert!(last <= mirrored, "{end_map:?}: {last:e}");
        }
        // The control: the bounds of the texel next to it differ.
        let mut shifted = expected.clone();
        shifted.rotate_left(1);
        assert!(largest(&lasts(&shifted), &lasts(&expected)) > 0.1);
    }
}

fn firsts(bounds: &[[f32; 2]]) -> Vec<f32> {
    bounds.iter().map(|b| b[0]).collect()
}

fn lasts(bounds: &[[f32; 2]]) -> Vec<f32> {
    bounds.iter().map(|b| b[1]).collect()
}

#[test]
fn packings_and_storages_change_passes_and_nothing_else() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    let mesh = foliage(6, 120);
    let receivers = receivers(3, 2000);
    for layers in [1, 2, 3, 5, 32, 33] {
        for layout in [
            Layout::Planes(Slicing::Growing),
            Layout::Deep { span: 0.5, growth: 1.0, listing: false },
            bounded(1).layout,
        ] {
            let base = Layered { layout, ..bounded(layers) };
            let of = |layered: &Layered| {
                let drawn = frame(gpu, &mesh, &receivers, SIZE, &plain(layered.clone()));
                let c = drawn.counters;
                assert_eq!(c.geometry_passes, geometry_passes(layered), "{layered:?}");
                let texels = u64::from(SIZE[0] * SIZE[1]);
                assert_eq!(c.map_bytes, texels * (bytes_per_texel(layered) + 4), "{layered:?}");
                if gpu.abilities.timestamps {
                    let geometry =
                        |name: &&&str| ["bounds", "bounds-far", "opacity"].contains(*name);
                    let drawn_passes = drawn.passes.iter().filter(geometry).count() as u64;
                    assert_eq!(drawn_passes, c.geometry_passes, "{:?}", drawn.passes);
                }
                drawn
            };
            let all = of(&base);
            assert_eq!(all.counters.bytes_per_fragment, 16 * u64::from(layers.div_ceil(4)));
            for packing in [Packing::Targets(1), Packing::Targets(4), Packing::Single] {
                let other = of(&Layered { packing, ..base.clone() });
                assert_eq!(other.maps, all.maps, "{packing:?} {base:?}");
                assert_eq!(other.transmittances, all.transmittances, "{packing:?} {base:?}");
            }
            let slabs = of(&Layered { packing: Packing::Slabs, ..base.clone() });
            assert!(largest(&slabs.transmittances, &all.transmittances) < 1e-6, "{base:?}");
            assert_eq!(slabs.counters.bytes_per_fragment, 16);
            let atomic =
                Layered { storage: Storage::Atomic, format: Format::Fixed, ..base.clone() };
            let atomic = of(&atomic);
            assert!(largest(&atomic.transmittances, &all.transmittances) < 1e-5, "{base:?}");
            assert_eq!(atomic.counters.bytes_per_fragment, 4);
            for (a, b) in atomic.maps.iter().zip(&all.maps) {
                assert!(largest(a, b) < 1e-4);
            }
            // Maps never fall from layer to layer.
            for pair in all.maps.windows(2) {
                assert!(pair[0].iter().zip(&pair[1]).all(|(a, b)| a <= b));
            }
        }
    }
    // The control: another number of layers is another result.
    let of = |layers| frame(gpu, &mesh, &receivers, SIZE, &plain(bounded(layers))).transmittances;
    assert!(largest(&of(2), &of(5)) > 0.05);
}

#[test]
fn a_pass_for_each_of_256_layers_and_nothing_made_in_a_frame() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    let mesh = foliage(6, 20);
    let receivers = receivers(3, 200);
    let of = |packing| {
        let s = plain(Layered { packing, ..bounded(256) });
        Renderer::new(gpu, &mesh, MODEL, &receivers, [16, 16], &s).unwrap()
    };
    let (single, targets) = (of(Packing::Single), of(Packing::Targets(8)));
    let (a, b) = (draw(gpu, &single), draw(gpu, &targets));
    assert_eq!((a.counters.geometry_passes, b.counters.geometry_passes), (257, 9));
    assert_eq!(a.transmittances, b.transmittances);
    // The frames above have filled the pool of queries.
    let before = live_objects().unwrap();
    for _ in 0..3 {
        let mut frame = gpu.frame();
        targets.record(&mut frame);
        single.record(&mut frame);
        frame.finish().unwrap();
    }
    assert_eq!(live_objects().unwrap(), before);
    // The control: a renderer more is seen.
    let _one_more = of(Packing::Slabs);
    assert_ne!(live_objects().unwrap(), before);
}

#[test]
fn bins_give_the_same_bits_in_any_order_of_drawing() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    let mesh = foliage(8, 300);
    let receivers = receivers(4, 1000);
    let layered = Layered { storage: Storage::Atomic, format: Format::Fixed, ..bounded(16) };
    let s = plain(layered);
    let first = frame(gpu, &mesh, &receivers, SIZE, &s);
    let mut reversed = mesh.clone();
    reversed.groups.reverse();
    for group in &reversed.groups {
        let range = group.first as usize..(group.first + group.count) as usize;
        let triangles: Vec<[u32; 3]> = reversed.indices[range.clone()]
            .chunks_exact(3)
            .rev()
            .map(|t| [t[0], t[1], t[2]])
            .collect();
        reversed.indices[range].copy_from_slice(triangles.as_flattened());
    }
    for mesh in [&mesh, &reversed, &mesh] {
        let again = frame(gpu, mesh, &receivers, SIZE, &s);
        assert_eq!(again.maps, first.maps);
        assert_eq!(again.transmittances, first.transmittances);
    }
    // The control: floats that are added the other way round differ in their last digits.
    let floats = plain(bounded(16));
    let (a, b) = (frame(gpu, &mesh, &[], SIZE, &floats), frame(gpu, &reversed, &[], SIZE, &floats));
    assert_ne!(a.maps, b.maps);
}

#[test]
fn a_depth_test_in_the_opacity_pass_makes_the_order_of_drawing_matter() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    let mut mesh = LightSpaceMesh::default();
    for i in 0..10 {
        add(&mut mesh, sheet([0.0, 1.0], [0.0, 1.0], 0.2 + 0.05 * f64::from(i)), 0.3, None);
    }
    let mut reversed = mesh.clone();
    reversed.groups.reverse();
    let behind = [Receiver::at(0.5, 0.5, 0.9)];
    let s = plain(bounded(8));
    let faulty = |mesh: &LightSpaceMesh| {
        let renderer =
            Renderer::with_fault(gpu, mesh, MODEL, &behind, SIZE, &s, Fault::DepthTested).unwrap();
        draw(gpu, &renderer).transmittances[0]
    };
    let good = |mesh: &LightSpaceMesh| frame(gpu, mesh, &behind, SIZE, &s).transmittances[0];
    let all = 0.7f32.powi(10);
    assert!((good(&mesh) - all).abs() < 1e-6 && (good(&reversed) - all).abs() < 1e-6);
    // From the front only the first sheet passes the test; from the back all do.
    assert!((faulty(&mesh) - 0.7).abs() < 1e-6, "{}", faulty(&mesh));
    assert!((faulty(&reversed) - all).abs() < 1e-6);
}

#[test]
fn empty_meshes_lit_receivers_and_opaque_casters_alone() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    let receivers = receivers(5, 200);
    let weight = Opaque::Weight { weight: 3.0, in_bounds: false };
    let mut trunk = LightSpaceMesh::default();
    add(&mut trunk, sheet([0.25, 0.75], [0.25, 0.75], 0.5), 1.0, None);
    let points =
        [Receiver::at(0.5, 0.5, 0.6), Receiver::at(0.5, 0.5, 0.4), Receiver::at(0.1, 0.5, 0.9)];
    for layout in [
        Layout::Planes(Slicing::Uniform),
        Layout::Planes(Slicing::Density),
        Layout::Deep { span: 0.5, growth: 2.0, listing: false },
        bounded(1).layout,
    ] {
        for storage in [Storage::Blend, Storage::Atomic] {
            let s = plain(Layered { layout: layout.clone(), storage, ..bounded(8) });
            let empty = frame(gpu, &LightSpaceMesh::default(), &receivers, SIZE, &s);
            assert!(empty.transmittances.iter().all(|&t| t == 1.0), "{s:?}");
            let none = frame(gpu, &LightSpaceMesh::default(), &[], [1, 1], &s);
            assert!(none.transmittances.is_empty());
            let separate = frame(gpu, &trunk, &points, SIZE, &s).transmittances;
            assert_eq!(separate, [0.0, 1.0, 1.0], "{s:?}");
            let weighted = Settings { opaque: weight, ..s };
            let leak = frame(gpu, &trunk, &points, SIZE, &weighted).transmittances;
            assert!((leak[0] - (-3.0f32).exp()).abs() < 1e-5, "{leak:?} {weighted:?}");
            assert_eq!(leak[1..], [1.0, 1.0]);
        }
    }
    let lit = Settings::plain(Code::Unshadowed);
    let t = frame(gpu, &trunk, &points, SIZE, &lit).transmittances;
    assert_eq!(t, [0.0, 1.0, 1.0]);
    let leaves = foliage(2, 50);
    let none = Settings { opaque: weight, ..lit };
    assert!(frame(gpu, &leaves, &receivers, SIZE, &none).transmittances.iter().all(|&t| t == 1.0));
}

#[test]
fn fifty_thousand_fragments_on_one_texel() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    let count = 50_000;
    let mut crowd = Vec::new();
    for i in 0..count {
        let z = 0.1 + 0.8 * f64::from(i * 7919 % count) / f64::from(count);
        let corner = |u, v| vertex(u, v, 1.0, z);
        crowd.extend([corner(0.45, 0.45), corner(0.6, 0.45), corner(0.45, 0.6)]);
    }
    let mut mesh = LightSpaceMesh::default();
    add(&mut mesh, crowd, 1e-4, None);
    let own = fragments(gpu, &mesh, MODEL, [3, 3]).unwrap();
    let points: Vec<Receiver> =
        (0..100).map(|i| Receiver::at(0.5, 0.5, 0.05 + 0.009 * i as f32)).collect();
    for storage in [Storage::Blend, Storage::Atomic] {
        let s = plain(Layered { storage, ..bounded(32) });
        let drawn = frame(gpu, &mesh, &points, [3, 3], &s);
        for (point, &got) in points.iter().zip(&drawn.transmittances) {
            let want = reference::exact(own.texel(4), point.depth - s.bias);
            // Depths are spread evenly: lines between layers are exact but for the last fragment.
            // In fixed point, each thickness of 1e-4 is off by up to 0.5 %.
            assert!((f64::from(got) - want).abs() < 3e-3, "{storage:?} {point:?}: {got} {want}");
        }
        assert!(drawn.transmittances[99] < 0.01 && drawn.transmittances[0] == 1.0);
    }
}

#[test]
fn fixed_point_clips_where_it_would_wrap() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    let mut mesh = LightSpaceMesh::default();
    // Thickness ln 1024 = 6.93 each: 600 of them exceed 4096.
    let sheets = (0..600).flat_map(|i| sheet([0.0, 1.0], [0.0, 1.0], 0.3 + 1e-3 * f64::from(i)));
    add(&mut mesh, sheets.collect(), 0.9999, None);
    let fixed = Layered { storage: Storage::Atomic, format: Format::Fixed, ..bounded(1) };
    for layers in [1, 4, 16] {
        let s = plain(Layered { layers, ..fixed.clone() });
        let drawn = frame(gpu, &mesh, &[Receiver::at(0.5, 0.5, 0.95)], [4, 4], &s);
        assert!(drawn.maps[layers as usize - 1].iter().all(|&sum| sum == 4096.0));
        for pair in drawn.maps.windows(2) {
            assert!(pair[0].iter().zip(&pair[1]).all(|(a, b)| a <= b));
        }
        assert_eq!(drawn.transmittances, [0.0]);
    }
}

#[test]
fn what_cannot_be_done_is_refused_by_name() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    let mesh = foliage(1, 5);
    let refusal = |size: [u32; 2], s: &Settings| {
        Renderer::new(gpu, &mesh, MODEL, &[], size, s).unwrap_err().to_string()
    };
    let with = |change: &dyn Fn(&mut Layered)| {
        let mut layered = bounded(8);
        change(&mut layered);
        plain(layered)
    };
    for (s, words) in [
        (with(&|l| l.layers = 0), "layers = 0"),
        (with(&|l| l.format = Format::Fixed), "the blending unit adds no integers"),
        (with(&|l| l.packing = Packing::Sorted), "triangles are not sorted"),
        (
            with(&|l| (l.storage, l.blend) = (Storage::Atomic, Blend::Over)),
            "atomic blending other than by addition",
        ),
        (with(&|l| (l.storage, l.format) = (Storage::Atomic, Format::F16)), "F16"),
        (
            with(&|l| {
                l.storage = Storage::Atomic;
                l.layout = Layout::Deep { span: 0.5, growth: 1.0, listing: true };
            }),
            "listing's masks",
        ),
    ] {
        let got = refusal([8, 8], &s);
        assert!(got.contains(words), "{got}");
    }
    assert!(refusal([0, 8], &plain(bounded(4))).contains("0 x 8"));
    let limits = gpu.limits();
    let wide = limits.max_texture_dimension_2d + 1;
    assert!(refusal([wide, 1], &plain(bounded(4))).contains("max_texture_dimension_2d"));
    // As many bins as exceed a storage binding: the device's limit is named, nothing is drawn.
    let side = limits.max_texture_dimension_2d;
    let texels = limits.max_storage_buffer_binding_size / (4 * 256) + 1;
    let high = u32::try_from(texels.div_ceil(u64::from(side))).unwrap();
    if high < side {
        let s = with(&|l| (l.storage, l.layers) = (Storage::Atomic, 256));
        let got = refusal([side, high], &s);
        assert!(got.contains("max_storage_buffer_binding_size"), "{got}");
    }
    let other = Renderer::with_fault(
        gpu,
        &mesh,
        MODEL,
        &[],
        [8, 8],
        &with(&|l| l.storage = Storage::Atomic),
        Fault::DepthTested,
    );
    assert!(other.unwrap_err().to_string().contains("depth test"));
}

#[test]
fn counters_follow_from_taps_and_settings() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    let mesh = foliage(1, 5);
    let points = [Receiver::at(0.5, 0.5, 0.5), Receiver::at(2.0, 0.5, 0.5)];
    let count = |s: &Settings| {
        Renderer::new(gpu, &mesh, MODEL, &points, [8, 8], s).unwrap().counters().texture_fetches
    };
    // One receiver is in the map: opaque map, bounds, two layers.
    assert_eq!(count(&plain(bounded(8))), 4);
    let box3 = Settings { taps: Taps::Box3, ..plain(bounded(8)) };
    assert_eq!(count(&box3), 36);
    let planes = Layered { layout: Layout::Planes(Slicing::Uniform), ..bounded(8) };
    assert_eq!(count(&plain(planes)), 3);
    assert_eq!(count(&Settings::plain(Code::Unshadowed)), 1);
}
