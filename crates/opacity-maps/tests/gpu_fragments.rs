//! What the device rasterises: fragments against a point-in-triangle test at texel centres.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

mod gpu_support;

use dapple_gpu::light_space::{LightSpaceMesh, LightSpaceVertex};
use dapple_opacity_maps::gpu::{OpacityGpuError, fragments};
use dapple_opacity_maps::{Fragment, NO_OPAQUE};
use gpu_support::{MODEL, add, exclusive_gpu, foliage, sheet, vertex};

/// Rasterisers snap vertices to 1/256 texel; centres nearer to an edge may go either way.
const SNAP_TEXELS: f64 = 1.0 / 64.0;
/// Depth of a triangle as steep as any here times the snapping.
const STEEP: f64 = 2e-2;

/// (depth, group) of every triangle over a texel's centre, by barycentric coordinates, and whether
/// an edge passes near.
fn crossed(mesh: &LightSpaceMesh, u: f64, v: f64, w: f64, h: f64) -> (Vec<(f64, usize)>, bool) {
    let (mut found, mut close) = (Vec::new(), false);
    for (g, group) in mesh.groups.iter().enumerate() {
        let range = group.first as usize..(group.first + group.count) as usize;
        for t in mesh.indices[range].chunks(3) {
            let corners: Vec<&LightSpaceVertex> =
                t.iter().map(|&i| &mesh.vertices[i as usize]).collect();
            let p: Vec<[f64; 2]> = corners
                .iter()
                .map(|c| [f64::from(c.position[0]) * w, f64::from(c.position[1]) * h])
                .collect();
            let q = [u * w, v * h];
            let cross = |a: [f64; 2], b: [f64; 2], c: [f64; 2]| {
                (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
            };
            let area = cross(p[0], p[1], p[2]);
            let (mut z, mut nearest) = (0.0, f64::INFINITY);
            for (k, corner) in corners.iter().enumerate() {
                let (i, j) = ((k + 1) % 3, (k + 2) % 3);
                let share = cross(p[i], p[j], q) / area;
                let length = (p[j][0] - p[i][0]).hypot(p[j][1] - p[i][1]);
                z += share * f64::from(corner.z);
                nearest = nearest.min(share * area.abs() / length);
            }
            close |= nearest.abs() < SNAP_TEXELS;
            if nearest >= 0.0 {
                found.push((z, g));
            }
        }
    }
    (found, close)
}

#[test]
fn fragments_are_the_triangles_over_texel_centres_in_front_of_the_nearest_opaque_one() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    // Without holes: their borders are checked below.
    let mut mesh = foliage(1, 150);
    mesh.groups.iter_mut().for_each(|g| g.alpha = None);
    for [w, h] in [[64, 64], [129, 33]] {
        let all = fragments(gpu, &mesh, MODEL, [w, h]).unwrap();
        let (mut near, mut wrong, mut differ) = (0, 0, 0);
        for texel in 0..all.texels() {
            let (x, y) = (texel % w as usize, texel / w as usize);
            let (u, v) = ((x as f64 + 0.5) / f64::from(w), (y as f64 + 0.5) / f64::from(h));
            let (crossed, close) = crossed(&mesh, u, v, f64::from(w), f64::from(h));
            let opaque = crossed.iter().filter(|c| mesh.groups[c.1].opacity >= 1.0);
            let opaque = opaque.map(|c| c.0).fold(f64::from(NO_OPAQUE), f64::min);
            let mut expected: Vec<(f64, usize)> =
                crossed.into_iter().filter(|c| c.0 < opaque).collect();
            expected.sort_by(|a, b| a.0.total_cmp(&b.0));
            let got = all.texel(texel);
            let same = got.len() == expected.len()
                && (f64::from(all.opaque[texel]) - opaque).abs() < STEEP
                && got
                    .iter()
                    .zip(&expected)
                    .all(|(got, want)| (f64::from(got.depth) - want.0).abs() < STEEP);
            let thickness = |i: usize| MODEL.omega(f64::from(mesh.groups[i].opacity));
            let sums = (
                got.iter().map(|f| f64::from(f.omega)).sum::<f64>(),
                expected.iter().map(|e| thickness(e.1)).sum::<f64>(),
            );
            let right = same && (sums.0 - sums.1).abs() < 1e-5;
            // An opaque edge may also lie just behind a leaf.
            let tie = expected.iter().any(|e| (e.0 - opaque).abs() < STEEP);
            if close || tie {
                near += 1
            } else {
                wrong += usize::from(!right)
            }
            differ += usize::from(!right);
        }
        let texels = all.texels() as f64;
        eprintln!(
            "{w}x{h}: {} fragments, {:.2} % of texels differ, {:.1} % near edges",
            all.items.len(),
            100.0 * f64::from(differ as u32) / texels,
            100.0 * f64::from(near as u32) / texels
        );
        assert!(all.items.len() > 2 * all.texels(), "{}", all.items.len());
        assert_eq!(wrong, 0);
        assert!(f64::from(near as u32) < 0.6 * texels && differ < near);
    }
}

#[test]
fn holes_follow_the_nearest_texel_and_hide_nothing() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    let mut mesh = foliage(1, 0);
    mesh.groups.clear();
    add(&mut mesh, sheet([0.0, 1.0], [0.0, 1.0], 0.25), 0.5, Some((0, 0.5)));
    add(&mut mesh, sheet([0.0, 1.0], [0.0, 1.0], 0.5), 0.25, None);
    // The floor has holes too; what is behind it is only there where they are.
    add(&mut mesh, sheet([0.0, 1.0], [0.0, 1.0], 0.75), 1.0, Some((0, 0.95)));
    add(&mut mesh, sheet([0.0, 1.0], [0.0, 1.0], 0.875), 0.75, None);
    let size = 50;
    let all = fragments(gpu, &mesh, MODEL, [size, size]).unwrap();
    let mut kinds = [0; 3];
    for texel in 0..all.texels() {
        let at = |i: usize| {
            let x = 3.0 * (i as f64 + 0.5) / f64::from(size);
            (2.0 * x.rem_euclid(1.0)) as usize
        };
        let alpha = [1.0, 0.2, 0.6, 0.9][2 * at(texel / 50) + at(texel % 50)];
        let one = |depth, alpha| Fragment { depth, omega: MODEL.omega(alpha) as f32 };
        let mut expected = vec![one(0.5, 0.25)];
        if alpha >= 0.5 {
            expected.insert(0, one(0.25, 0.5));
        }
        let floor = alpha >= 0.95;
        if !floor {
            expected.push(one(0.875, 0.75));
        }
        assert_eq!(all.texel(texel), expected, "{texel}");
        assert_eq!(all.opaque[texel], if floor { 0.75 } else { NO_OPAQUE });
        kinds[expected.len() - 1] += 1;
    }
    assert!(kinds[0] == 0 && kinds[1] > 500 && kinds[2] > 500, "{kinds:?}");
}

#[test]
fn empty_meshes_crowded_texels_and_bad_sizes() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    let all = fragments(gpu, &LightSpaceMesh::default(), MODEL, [3, 2]).unwrap();
    assert_eq!((all.items.len(), all.opaque.as_slice()), (0, [NO_OPAQUE; 6].as_slice()));
    let mut mesh = LightSpaceMesh::default();
    let mut crowd = Vec::new();
    for i in 0..50_000 {
        let z = 0.1 + 0.8 * f64::from(i * 7919 % 50_000) / 50_000.0;
        crowd.extend([
            vertex(0.3, 0.3, 1.0, z),
            vertex(0.4, 0.3, 1.0, z),
            vertex(0.3, 0.4, 1.0, z),
        ]);
    }
    add(&mut mesh, crowd, 0.01, None);
    let all = fragments(gpu, &mesh, MODEL, [3, 3]).unwrap();
    assert_eq!(all.items.len(), 0, "no texel's centre is inside");
    mesh.vertices.iter_mut().for_each(|v| v.position[0] += 0.18);
    mesh.vertices.iter_mut().for_each(|v| v.position[1] += 0.18);
    let all = fragments(gpu, &mesh, MODEL, [3, 3]).unwrap();
    assert_eq!((all.items.len(), all.texel(4).len()), (50_000, 50_000));
    assert!(all.texel(4).windows(2).all(|w| w[0].depth <= w[1].depth));
    let refused = fragments(gpu, &mesh, MODEL, [0, 4]).unwrap_err();
    assert!(refused.to_string().contains("0 x 4"), "{refused}");
    let refused = fragments(gpu, &mesh, MODEL, [1 << 17, 1]).unwrap_err();
    assert!(matches!(refused, OpacityGpuError::Gpu(_)), "{refused}");
    assert!(refused.to_string().contains("max_texture_dimension_2d"), "{refused}");
    mesh.groups[0].count = 4;
    assert!(matches!(fragments(gpu, &mesh, MODEL, [3, 3]), Err(OpacityGpuError::Mesh(_))));
}
