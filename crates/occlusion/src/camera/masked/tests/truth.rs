//! A depth for each pixel, by rays: what masked culling must never exceed.

use glam::{DMat3, DVec3, DVec4, Mat4, Vec3};

/// Indexed triangles in front of a camera.
#[derive(Clone, Debug)]
pub struct Case {
    pub size: [u32; 2],
    pub clip: Mat4,
    pub positions: Vec<Vec3>,
    pub triangles: Vec<[u32; 3]>,
}

/// Depth at each pixel's centre in `f64`: no snapping, no clipping. A pixel's ray is a sum of the
/// corners; where no weight is negative it meets the triangle, and the weighted sum of their depths
/// is its own. Corners are moved on the image by `moved` pixels first.
pub fn depths(case: &Case, moved: impl Fn(usize) -> [f64; 2]) -> Vec<f64> {
    let size = case.size.map(f64::from);
    let placed = |i: u32| -> DVec4 {
        case.clip.as_dmat4() * case.positions[i as usize].as_dvec3().extend(1.0)
    };
    let corner = |i: u32, clipped: bool| {
        let p = placed(i);
        let [dx, dy] = if clipped { [0.0; 2] } else { moved(i as usize) };
        // To pixels, times w.
        let x = 0.5 * (p.x + p.w) * size[0] + dx * p.w;
        let y = 0.5 * (p.w - p.y) * size[1] + dy * p.w;
        (DVec3::new(x, y, p.w), p.z)
    };
    let mut out = vec![0.0f64; (case.size[0] * case.size[1]) as usize];
    for t in &case.triangles {
        let clipped = t.iter().any(|&i| placed(i).z > placed(i).w);
        let [(a, za), (b, zb), (c, zc)] = t.map(|i| corner(i, clipped));
        let matrix = DMat3::from_cols(a, b, c);
        if matrix.determinant() == 0.0 {
            continue;
        }
        let inverse = matrix.inverse();
        for (i, depth) in out.iter_mut().enumerate() {
            let (x, y) = (i as u32 % case.size[0], i as u32 / case.size[0]);
            let ray = DVec3::new(f64::from(x) + 0.5, f64::from(y) + 0.5, 1.0);
            let weights = inverse * ray;
            let z = weights.dot(DVec3::new(za, zb, zc));
            if weights.min_element() >= 0.0 && z <= 1.0 && z > *depth {
                *depth = z;
            }
        }
    }
    out
}
