//! The graphics device's form: its maps against closed forms, its shading against the reference.

use dapple_gpu::Gpu;
use dapple_gpu::light_space::{AlphaTexture, LightSpaceMesh, LightSpaceVertex, TriangleGroup};
use dapple_shadows::cascades::gpu::{DEPTH_PASSES, GpuCascadeError, Shadows};
use dapple_shadows::cascades::reference::port_bounds;
use dapple_shadows::cascades::{Cascade, CascadeReceiver, Settings, Taps, cpu};
use dapple_shadows::filtering::DepthMap;
use dapple_shadows::filtering::gpu_depth::{DepthRaster, DepthRasterError};
use rand::RngExt;

use crate::gpu_support::{exclusive_gpu, rng};
use crate::ports::{mixed, open, outside};
use crate::scene::{LEAF, all_settings, cascades, floor, nearest, rim};

/// Interpolation in f32 over a floor that spans a region many times.
const INTERPOLATION: f64 = 5e-6;

fn vertex(u: f64, v: f64, z: f64, uv: [f64; 2]) -> LightSpaceVertex {
    LightSpaceVertex { position: [u as f32, v as f32, 1.0], z: z as f32, uv: uv.map(|x| x as f32) }
}

fn add(mesh: &mut LightSpaceMesh, vertices: Vec<LightSpaceVertex>, alpha: Option<(u32, f32)>) {
    let (first, count) = (mesh.indices.len() as u32, vertices.len() as u32);
    let start = mesh.vertices.len() as u32;
    mesh.vertices.extend(vertices);
    mesh.indices.extend(start..start + count);
    mesh.groups.push(TriangleGroup { first, count, alpha, opacity: 1.0 });
}

/// The scene's floor, and its leaves cut out of one square by their texture.
fn leaves() -> LightSpaceMesh {
    let mut mesh = LightSpaceMesh::default();
    let corner = |u, v| vertex(u, v, floor(u, v), [0.0; 2]);
    add(&mut mesh, vec![corner(-1.0, -1.0), corner(4.0, -1.0), corner(-1.0, 4.0)], None);
    let size = 1200u32;
    let centre = |i: u32| (f64::from(i) + 0.5) / f64::from(size);
    let texels = (0..size * size).map(|i| (centre(i % size), centre(i / size)));
    let alpha = texels.map(|(u, v)| f32::from(u8::from(rim(u, v) <= 0.0))).collect();
    mesh.textures.push(AlphaTexture { width: size, height: size, alpha });
    let leaf = |u, v| vertex(u, v, LEAF, [u, v]);
    let square = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
    add(&mut mesh, square.map(|(u, v)| leaf(u, v)).into(), Some((0, 0.5)));
    mesh
}

fn draw(gpu: &Gpu, shadows: &Shadows, count: usize) {
    let mut frame = gpu.frame();
    shadows.record(&mut frame);
    let times = frame.finish().unwrap();
    gpu.check().unwrap();
    if gpu.abilities.timestamps {
        let names: Vec<_> = times.passes.iter().map(|p| p.0).collect();
        let mut want = DEPTH_PASSES[..count].to_vec();
        want.push("shade");
        assert_eq!(names, want);
    }
}

fn maps_of(gpu: &Gpu, mesh: &LightSpaceMesh, cascades: &[Cascade], side: u32) -> Vec<DepthMap> {
    let settings = Settings::new(Taps::One);
    let shadows = Shadows::new(gpu, mesh, cascades, side, &[], &settings).unwrap();
    draw(gpu, &shadows, cascades.len());
    assert_eq!(shadows.read(gpu).unwrap(), []);
    shadows.read_maps(gpu).unwrap()
}

/// Texels whose depth differs from a function of base map coordinates.
fn off(map: &DepthMap, cascade: &Cascade, shift: f64, want: impl Fn(f64, f64) -> f64) -> usize {
    let side = f64::from(map.width);
    let differs = |(i, z): (usize, &f32)| {
        let (x, y) = (i as u32 % map.width, i as u32 / map.width);
        let [u, v] =
            cascade.base([(f64::from(x) + 0.5 + shift) / side, (f64::from(y) + 0.5) / side]);
        (f64::from(*z) - want(u, v)).abs() > INTERPOLATION
    };
    map.depths.iter().enumerate().filter(|texel| differs(*texel)).count()
}

#[test]
fn each_map_holds_its_region_of_the_floor() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    let mut mesh = leaves();
    mesh.groups.truncate(1);
    for (count, side) in [(1, 64), (4, 64), (3, 77)] {
        let cascades = cascades(count, 0.5, side, 1);
        for (map, cascade) in maps_of(gpu, &mesh, &cascades, side).iter().zip(&cascades) {
            assert_eq!(off(map, cascade, 0.0, floor), 0);
            // The control: off by a texel, the slope shows everywhere.
            let texels = (side * side) as usize;
            assert!(off(map, cascade, 1.0, floor) > texels * 9 / 10);
        }
    }
}

#[test]
fn cut_out_leaves_stand_in_their_places_in_every_region() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    let side = 128;
    let cascades = cascades(3, 0.5, side, 1);
    for (map, cascade) in maps_of(gpu, &leaves(), &cascades, side).iter().zip(&cascades) {
        // Away from rims by a texel of the leaves' texture; regions may reach past the square.
        let near_rim = |u: f64, v: f64| {
            rim(u, v).abs() < 1.5 / 1200.0 || !(0.0..1.0).contains(&u) || !(0.0..1.0).contains(&v)
        };
        let mut judged = 0;
        let mut covered = 0;
        let mut shifted = 0;
        for (i, z) in map.depths.iter().enumerate() {
            let centre = |i: u32| (f64::from(i) + 0.5) / f64::from(side);
            let [u, v] = cascade.base([centre(i as u32 % side), centre(i as u32 / side)]);
            if near_rim(u, v) {
                continue;
            }
            judged += 1;
            covered += usize::from(f64::from(*z) < 0.5);
            assert!((f64::from(*z) - nearest(u, v)).abs() < INTERPOLATION, "({u}, {v})");
            let texel = cascade.scale / f64::from(side);
            let differs = (f64::from(*z) - nearest(u + texel, v)).abs() > 0.1;
            shifted += usize::from(differs);
        }
        assert!(judged > 9000 && covered > 1000, "{judged} {covered}");
        assert!(shifted > 40, "a texel off is not seen: {shifted}");
    }
}

#[test]
fn a_perspective_light_is_cropped_alike() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    // Light at the origin looking along +d, half angle of tangent 1, near 1, far 9. The plane
    // d = 4 + 0.8 x + 0.5 y; a ray through (u, v) has x = (2 u - 1) d.
    let z =
        |u: f64, v: f64| (4.0 / (1.0 - 0.8 * (2.0 * u - 1.0) - 0.5 * (2.0 * v - 1.0)) - 1.0) / 8.0;
    let corner = |x: f64, y: f64| {
        let d = 4.0 + 0.8 * x + 0.5 * y;
        let position = [0.5 * (d + x), 0.5 * (d + y), d].map(|x| x as f32);
        LightSpaceVertex { position, z: ((d - 1.0) / 8.0) as f32, uv: [0.0; 2] }
    };
    let mut mesh = LightSpaceMesh::default();
    // The first corner lies behind the light.
    let corners = [(-9.0, -9.0), (60.0, -9.0), (-9.0, 60.0)].map(|(x, y)| corner(x, y));
    assert!(corners[0].position[2] < 0.0);
    add(&mut mesh, corners.into(), None);
    let half = Cascade { near: 1.0, far: 2.0, offset: [0.1, 0.2], scale: 0.5 };
    let tenth = Cascade { near: 2.0, far: 4.0, offset: [0.45, 0.55], scale: 0.1 };
    let cascades = [half, tenth];
    for (map, cascade) in maps_of(gpu, &mesh, &cascades, 64).iter().zip(&cascades) {
        assert_eq!(off(map, cascade, 0.0, z), 0);
        assert!(off(map, cascade, 1.0, z) > 4000, "a texel off is not seen");
    }
}

#[test]
fn the_whole_map_as_one_cascade_is_the_plain_depth_map_to_the_bit() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    let mut rng = rng(6);
    let mut mesh = leaves();
    for _ in 0..100 {
        let (u, v) = (rng.random_range(-0.1..1.1), rng.random_range(-0.1..1.1));
        let mut corner = || {
            let (du, dv) = (rng.random_range(-0.2..0.2), rng.random_range(-0.2..0.2));
            vertex(u + du, v + dv, rng.random_range(0.05..0.95), [0.0; 2])
        };
        let triangle = vec![corner(), corner(), corner()];
        add(&mut mesh, triangle, None);
    }
    let side = 97;
    let whole = maps_of(gpu, &mesh, &[Cascade::whole(1.0, 2.0)], side);
    let raster = DepthRaster::new(gpu, &mesh, side, side).unwrap();
    let mut frame = gpu.frame();
    raster.record(&mut frame);
    frame.finish().unwrap();
    let plain = raster.read(gpu).unwrap();
    assert_eq!(whole[0].depths, plain);
    // The control: a region a millionth smaller differs somewhere.
    let smaller = Cascade { scale: 1.0 - 1e-6, ..Cascade::whole(1.0, 2.0) };
    assert_ne!(maps_of(gpu, &mesh, &[smaller], side)[0].depths, plain);
}

#[test]
fn shading_is_the_reference_within_rounding() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    let mesh = leaves();
    let side = 96;
    let all = mixed(3000, 7);
    for count in [1, 2, 4, 8] {
        let cascades = cascades(count, 0.6, side, 2);
        for settings in all_settings() {
            let shadows = Shadows::new(gpu, &mesh, &cascades, side, &all, &settings).unwrap();
            draw(gpu, &shadows, count);
            let found = shadows.read(gpu).unwrap();
            let maps = shadows.read_maps(gpu).unwrap();
            let bounds = port_bounds(&maps, &cascades, &all, &settings).unwrap();
            assert_eq!(outside(&found, &bounds), 0, "{count} {settings:?}");
            assert!(open(&bounds) < 0.02, "{count} {settings:?}: {}", open(&bounds));
            assert!(found.iter().filter(|v| **v < 0.5).count() > 300);
            assert!(found.iter().filter(|v| **v == 1.0).count() > 300);
            // The control: another's settings, or maps in another order, are seen.
            let other = Settings { bias: settings.bias + 0.01, ..settings };
            let bounds = port_bounds(&maps, &cascades, &all, &other).unwrap();
            assert!(outside(&found, &bounds) > 20);
            if count > 1 {
                let mut turned = maps.clone();
                turned.rotate_left(1);
                let bounds = port_bounds(&turned, &cascades, &all, &settings).unwrap();
                assert!(outside(&found, &bounds) > 20);
            }
            let counters = cpu::Shadows::new(side, &cascades, &settings).unwrap().counters(&all);
            assert_eq!(shadows.counters(), counters);
        }
    }
}

#[test]
fn tiny_and_outlying_regions_agree_too() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    let (mesh, side) = (leaves(), 64);
    let ends = [1.0, 2.0, 3.0, 4.0, 5.0];
    let places = [
        // A thousandth of the map across a rim; beyond the map's corner; many maps wide; less
        // than two hundred steps of f32 wide.
        ([0.5416, 0.5411], 1e-3),
        ([-0.7, -0.8], 1.0),
        ([-40.0, -30.0], 90.0),
        ([0.999, 0.999], 1e-5),
    ];
    let cascades: Vec<Cascade> = ends
        .windows(2)
        .zip(places)
        .map(|(ends, (offset, scale))| Cascade { near: ends[0], far: ends[1], offset, scale })
        .collect();
    let mut rng = rng(9);
    let all: Vec<CascadeReceiver> = (0..4000)
        .map(|i| {
            let cascade = &cascades[i % 4];
            let local = [rng.random_range(-0.1..1.1), rng.random_range(-0.1..1.1)];
            let [u, v] = cascade.base(local);
            let depth = nearest(u, v) + rng.random_range(-0.2..0.2);
            CascadeReceiver::at(u as f32, v as f32, depth as f32, cascade.far as f32)
                .with_slope(0.2, 0.1)
        })
        .collect();
    for settings in all_settings() {
        let shadows = Shadows::new(gpu, &mesh, &cascades, side, &all, &settings).unwrap();
        draw(gpu, &shadows, 4);
        let (found, maps) = (shadows.read(gpu).unwrap(), shadows.read_maps(gpu).unwrap());
        let bounds = port_bounds(&maps, &cascades, &all, &settings).unwrap();
        assert_eq!(outside(&found, &bounds), 0, "{settings:?}");
        for cascade in 0..4 {
            let of = found.iter().skip(cascade).step_by(4);
            let dark = of.filter(|v| **v < 1.0).count();
            assert!((50..900).contains(&dark), "cascade {cascade}, {settings:?}: {dark}");
        }
    }
}

#[test]
fn empty_cascades_are_cleared_and_light_their_receivers() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    let mut two = cascades(2, 0.5, 32, 0);
    two[0].scale = 0.0;
    let all = mixed(500, 8);
    let settings = Settings::new(Taps::Box4);
    let shadows = Shadows::new(gpu, &leaves(), &two, 32, &all, &settings).unwrap();
    draw(gpu, &shadows, 2);
    let maps = shadows.read_maps(gpu).unwrap();
    assert!(maps[0].depths.iter().all(|z| *z == 1.0));
    assert!(maps[1].depths.iter().any(|z| *z < 1.0));
    let found = shadows.read(gpu).unwrap();
    let bounds = port_bounds(&maps, &two, &all, &settings).unwrap();
    assert_eq!(outside(&found, &bounds), 0);
    let near = |r: &CascadeReceiver| r.view_depth <= two[0].far as f32;
    let lit: Vec<_> = all.iter().zip(&found).filter(|(r, _)| near(r)).map(|(_, v)| *v).collect();
    assert!(lit.len() > 50 && lit.iter().all(|v| *v == 1.0));
    // Without triangles every map is empty.
    let none = maps_of(gpu, &LightSpaceMesh::default(), &cascades(2, 0.5, 8, 0), 8);
    assert!(none.iter().all(|map| map.depths.iter().all(|z| *z == 1.0)));
}

#[test]
fn bad_input_is_refused_by_name() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    let (good, settings) = (cascades(2, 0.5, 8, 0), Settings::new(Taps::One));
    let mut mesh = leaves();
    let refused = Shadows::new(gpu, &mesh, &good, 0, &[], &settings).unwrap_err();
    assert!(matches!(refused, GpuCascadeError::Cascade(_)), "{refused}");
    let refused = Shadows::new(gpu, &mesh, &[], 8, &[], &settings).unwrap_err();
    assert!(matches!(refused, GpuCascadeError::Cascade(_)), "{refused}");
    let max = gpu.limits().max_texture_dimension_2d;
    if max < 1 << 15 {
        let refused = Shadows::new(gpu, &mesh, &good, 1 << 15, &[], &settings).unwrap_err();
        assert!(refused.to_string().contains("max_texture_dimension_2d"), "{refused}");
    }
    mesh.vertices[1].z = f32::NAN;
    let refused = Shadows::new(gpu, &mesh, &good, 8, &[], &settings).unwrap_err();
    let named = matches!(refused, GpuCascadeError::Depth(DepthRasterError::Mesh(_)));
    assert!(named, "{refused}");
}
