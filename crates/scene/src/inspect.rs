//! What a scene requires of a renderer, and why; what it does not require can be left out.

use crate::{Aabb, Light, LightView, Scene};
use std::collections::BTreeSet;

/// One option, and whether this scene needs it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Need {
    /// One of [`OPTIONS`].
    pub option: &'static str,
    /// Whether leaving it out changes a result.
    pub needed: bool,
    /// One sentence with the figures that decide.
    pub because: String,
}

/// Needs and sizes of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Inspection {
    /// One for each of [`OPTIONS`], in that order.
    pub needs: Vec<Need>,
    /// Placed triangles.
    pub triangles: usize,
    /// Placed triangles without area.
    pub degenerate_triangles: usize,
    /// Placements.
    pub instances: usize,
    /// Meshes.
    pub meshes: usize,
    /// Meshes and textures as stored once, bytes.
    pub memory_bytes: u64,
    /// World bounds, metres.
    pub bounds: Aabb,
    /// Median length of the placed triangles' edges, metres; of a sample above 2^20 edges.
    pub median_edge_m: f64,
}

/// Every option that [`inspect`] judges.
pub const OPTIONS: [&str; 8] = [
    "alpha-test",
    "translucency",
    "area-light",
    "perspective-map",
    "f64-offset",
    "instancing",
    "depth-above-f16",
    "depth-above-u16",
];

/// A vertex may move by this share of the median edge before it counts as a change.
const EDGE_SHARE: f64 = 1e-3;

impl Inspection {
    /// Whether `option` is needed; `None` for an unknown one.
    pub fn needs(&self, option: &str) -> Option<bool> {
        self.needs.iter().find(|n| n.option == option).map(|n| n.needed)
    }
}

/// Inspects a scene. It must be valid ([`Scene::validate`]).
pub fn inspect(scene: &Scene) -> Inspection {
    let bounds = scene.bounds();
    let median_edge_m = median_edge(scene);
    let range = depth_range(scene, &bounds);
    let [f16, u16] = depth_needs(range, median_edge_m);
    let need = |option, (needed, because)| Need { option, needed, because };
    let needs = vec![
        need(OPTIONS[0], alpha_test(scene)),
        need(OPTIONS[1], translucency(scene)),
        need(OPTIONS[2], area_light(scene)),
        need(OPTIONS[3], perspective_map(scene)),
        need(OPTIONS[4], f64_offset(&bounds, median_edge_m)),
        need(OPTIONS[5], instancing(scene)),
        need(OPTIONS[6], f16),
        need(OPTIONS[7], u16),
    ];
    Inspection {
        needs,
        triangles: scene.triangle_count(),
        degenerate_triangles: scene.degenerate_triangles(),
        instances: scene.instances.len(),
        meshes: scene.meshes.len(),
        memory_bytes: memory_bytes(scene),
        bounds,
        median_edge_m,
    }
}

/// Materials of at least one placed triangle.
fn used_materials(scene: &Scene) -> BTreeSet<usize> {
    let placed = scene.instances.iter().map(|i| &scene.meshes[i.mesh as usize]);
    placed.filter(|m| !m.triangles.is_empty()).map(|m| m.material as usize).collect()
}

fn alpha_test(scene: &Scene) -> (bool, String) {
    let mut declared = 0;
    for m in used_materials(scene).into_iter().map(|m| &scene.materials[m]) {
        let Some(test) = m.alpha_test else { continue };
        declared += 1;
        let texture = &scene.textures[test.texture as usize];
        let below = |t: &&[u8; 4]| f32::from(t[3]) / 255.0 < test.cutoff;
        let cut = texture.texels.iter().filter(below).count();
        if cut > 0 {
            let share = 100.0 * cut as f64 / texture.texels.len() as f64;
            let (material, name, cutoff) = (&m.name, &texture.name, test.cutoff);
            return (
                true,
                format!(
                    "material \"{material}\" cuts out {share:.1} % of texture \"{name}\" \
                     (alpha below {cutoff})"
                ),
            );
        }
    }
    let because = match declared {
        0 => "no placed material has a cut-out texture".into(),
        n => {
            format!("{n} placed materials have a cut-out texture, but no texel is below its cutoff")
        }
    };
    (false, because)
}

fn translucency(scene: &Scene) -> (bool, String) {
    let used = used_materials(scene);
    match used.iter().map(|&m| &scene.materials[m]).find(|m| m.opacity < 1.0) {
        Some(m) => (true, format!("material \"{}\" has opacity {}", m.name, m.opacity)),
        None => (false, format!("all {} placed materials have opacity 1", used.len())),
    }
}

fn area_light(scene: &Scene) -> (bool, String) {
    let areas = scene.lights.iter().enumerate().filter_map(|(i, l)| match l {
        Light::Area { half_u, half_v, .. } => Some((i, 4.0 * half_u.cross(*half_v).length())),
        _ => None,
    });
    match areas.into_iter().next() {
        Some((i, area)) => (true, format!("light {i} is an area light of {area:.3e} m^2")),
        None => (false, format!("none of {} lights has an area", scene.lights.len())),
    }
}

fn perspective_map(scene: &Scene) -> (bool, String) {
    match scene.lights.iter().position(|l| matches!(l, Light::Spot { .. })) {
        Some(i) => (true, format!("light {i} is a spot light")),
        None => (false, format!("none of {} lights is a spot light", scene.lights.len())),
    }
}

/// Distance from `x` to the next larger `f32`, for finite `x` >= 0.
fn ulp_f32(x: f64) -> f64 {
    let x = x as f32;
    f64::from(f32::from_bits(x.to_bits() + 1)) - f64::from(x)
}

fn f64_offset(bounds: &Aabb, edge: f64) -> (bool, String) {
    let farthest = bounds.min.abs().max(bounds.max.abs()).max_element();
    let step = ulp_f32(farthest);
    let figures = format!(
        "at {farthest:.3e} m from the origin f32 steps by {step:.1e} m, and the median edge is \
         {edge:.1e} m long"
    );
    (0.5 * step > EDGE_SHARE * edge, figures)
}

fn instancing(scene: &Scene) -> (bool, String) {
    let mut placed = vec![0usize; scene.meshes.len()];
    for instance in &scene.instances {
        placed[instance.mesh as usize] += 1;
    }
    let shared = placed.iter().filter(|&&n| n > 1).count();
    let stored: usize = scene
        .meshes
        .iter()
        .zip(&placed)
        .filter(|(_, n)| **n > 0)
        .map(|(m, _)| m.triangles.len())
        .sum();
    let total = scene.triangle_count();
    let figures = format!(
        "{shared} of {} meshes are placed more than once: {stored} triangles stored, {total} placed",
        scene.meshes.len()
    );
    (shared > 0, figures)
}

/// The largest depth range of the scene's shadow maps, metres.
fn depth_range(scene: &Scene, bounds: &Aabb) -> Option<f64> {
    let ranges = scene.lights.iter().filter_map(|light| {
        let view = match *light {
            Light::Directional { direction } => LightView::fit_directional(direction, bounds),
            Light::Spot { position, direction, half_angle_rad } => {
                LightView::fit_spot(position, direction, half_angle_rad, bounds)
            }
            Light::Area { .. } => return None,
        };
        view.ok().map(|v| v.far_m - v.near_m)
    });
    ranges.reduce(f64::max)
}

/// Whether a 16-bit step of depth is coarser than half the median edge: then surfaces an edge
/// apart share a depth. Half floats are coarsest in [1/2, 1), at 2^-11; unorm steps are even.
fn depth_needs(range: Option<f64>, edge: f64) -> [(bool, String); 2] {
    [(2.0_f64.powi(-11), "16-bit float"), (1.0 / 65535.0, "16-bit unorm")].map(|(step, what)| {
        let Some(range) = range else { return (false, "no light casts through a depth map".into()) };
        let step = step * range;
        let because = format!(
            "over a depth range of {range:.3e} m a {what} steps by {step:.1e} m, and the median edge \
             is {edge:.1e} m long"
        );
        (step > 0.5 * edge, because)
    })
}

fn median_edge(scene: &Scene) -> f64 {
    const SAMPLE: usize = 1 << 20;
    let stride = (scene.triangle_count() * 3).div_ceil(SAMPLE).max(1);
    let edges = scene.world_triangles().flat_map(|(_, [a, b, c])| [(a, b), (b, c), (c, a)]);
    let mut lengths: Vec<f64> = edges.step_by(stride).map(|(a, b)| a.distance(b)).collect();
    if lengths.is_empty() {
        return 0.0;
    }
    let middle = lengths.len() / 2;
    *lengths.select_nth_unstable_by(middle, f64::total_cmp).1
}

pub(crate) fn memory_bytes(scene: &Scene) -> u64 {
    let bytes = |count: usize, each: usize| (count * each) as u64;
    let meshes: u64 = scene
        .meshes
        .iter()
        .map(|m| {
            bytes(m.positions.len() + m.normals.len() + m.triangles.len(), 12)
                + bytes(m.uvs.len(), 8)
        })
        .sum();
    meshes + scene.textures.iter().map(|t| bytes(t.texels.len(), 4)).sum::<u64>()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{AlphaTest, Texture};
    use glam::DVec3;

    fn needed(scene: &Scene, option: &str) -> bool {
        scene.validate().unwrap();
        inspect(scene).needs(option).unwrap()
    }

    fn cube() -> Scene {
        crate::generate::by_name("cube", 1).unwrap()
    }

    #[test]
    fn a_plain_cube_needs_nothing() {
        let i = inspect(&cube());
        assert_eq!(i.needs.iter().map(|n| n.option).collect::<Vec<_>>(), OPTIONS);
        let wanted: Vec<_> = i.needs.iter().filter(|n| n.needed).collect();
        assert!(wanted.is_empty(), "{wanted:?}");
        assert!(i.needs.iter().all(|n| !n.because.is_empty()));
        assert_eq!((i.triangles, i.degenerate_triangles, i.instances, i.meshes), (14, 0, 2, 2));
        // 4 + 24 vertices with normals, 14 triangles.
        assert_eq!(i.memory_bytes, 28 * 24 + 14 * 12);
        assert_eq!(i.needs("no such option"), None);
    }

    #[test]
    fn alpha_test_needs_texels_below_the_cutoff_on_a_placed_mesh() {
        let mut s = cube();
        let mut add = |alpha| {
            let texels = vec![[255; 4], [255, 255, 255, alpha]];
            s.textures.push(Texture { name: "leaf".into(), width: 2, height: 1, texels });
            s.clone()
        };
        let (mut opaque, mut holes) = (add(128), add(127));
        opaque.materials[1].alpha_test = Some(AlphaTest { texture: 0, cutoff: 0.5 });
        holes.materials[1].alpha_test = Some(AlphaTest { texture: 1, cutoff: 0.5 });
        assert!(!needed(&opaque, "alpha-test"));
        assert!(needed(&holes, "alpha-test"));
        assert!(inspect(&holes).needs[0].because.contains("50.0 %"));
        // The same material on a mesh that no instance places.
        holes.instances.retain(|i| holes.meshes[i.mesh as usize].material != 1);
        assert!(!needed(&holes, "alpha-test"));
    }

    #[test]
    fn lights_opacity_and_sharing_are_found() {
        let mut s = cube();
        s.materials[1].opacity = 0.3;
        let up = DVec3::Y * 5.0;
        s.lights.push(Light::Area { centre: up, half_u: DVec3::X, half_v: DVec3::Z });
        s.lights.push(Light::Spot { position: up, direction: -DVec3::Y, half_angle_rad: 0.5 });
        s.instances.push(s.instances[1]);
        for option in ["translucency", "area-light", "perspective-map", "instancing"] {
            assert!(needed(&s, option), "{option}");
        }
        assert!(inspect(&s).needs[2].because.contains("4.000e0 m^2"));
    }

    #[test]
    fn f64_offset_is_needed_far_out_and_not_at_any_scale_near_the_origin() {
        // Edges of about 1 m; f32 steps by 2^-10 m in 8192..16384, and half of that is 4.9e-4.
        let moved = |metres: f64, scale: f64| {
            let mut s = cube();
            for i in &mut s.instances {
                i.transform.matrix3 *= scale;
                i.transform.translation = i.transform.translation * scale + DVec3::X * metres;
            }
            needed(&s, "f64-offset")
        };
        assert!(!moved(0.0, 1.0) && !moved(0.0, 1e-6) && !moved(0.0, 1e6));
        assert!(!moved(1e3, 1.0) && moved(1e6, 1.0) && moved(1e3, 1e-2));
    }

    #[test]
    fn deep_scenes_need_more_than_16_bits() {
        let [f16, u16] = depth_needs(Some(100.0), 0.05);
        // Steps are 0.0488 m and 0.0015 m, half an edge is 0.025 m.
        assert!(f16.0 && !u16.0);
        assert!(depth_needs(Some(1e4), 0.05)[1].0);
        assert!(!depth_needs(None, 0.05)[0].0);
    }

    #[test]
    fn the_f32_step_is_exact() {
        assert_eq!(ulp_f32(1.0), 2.0_f64.powi(-23));
        assert_eq!(ulp_f32(1e6), 0.0625);
    }
}
