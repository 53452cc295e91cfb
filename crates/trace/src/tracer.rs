//! Rays against a scene.
//!
//! Traversal is obvhs' own (`Bvh2::ray_traverse_dynamic`) over padded boxes; distances are compared
//! in f64 here, and only a bound above the best one is handed back to it (`space.rs` has the
//! argument why nothing is lost). Its fixed-size stack drops entries without a word when full, so
//! it is sized by the tree's measured depth.

use crate::sheets::Sheets;
use crate::space::{PreparedRay, Space, above};
use crate::watertight::{Corners, Crossing};
use dapple_scene::{Aabb, Texture};
use glam::{DVec2, DVec3, Vec2};
use obvhs::bvh2::Bvh2;
use obvhs::fast_stack;
use obvhs::ray::RayHit;
use std::{ops::ControlFlow, sync::OnceLock};

/// A half line or part of one, in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Metres.
    pub origin: DVec3,
    /// Of any length but zero.
    pub direction: DVec3,
    /// Nearest distance that counts, in units of `direction`; may be negative.
    pub t_min: f64,
    /// Farthest distance that counts, in units of `direction`; both ends are part of the range.
    pub t_max: f64,
}

impl Ray {
    /// From `origin` without an end.
    pub fn new(origin: DVec3, direction: DVec3) -> Self {
        Self { origin, direction, t_min: 0.0, t_max: f64::INFINITY }
    }

    /// The point at distance `t`.
    pub fn at(&self, t: f64) -> DVec3 {
        self.origin + self.direction * t
    }
}

/// Where a ray meets a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance in units of the ray's direction.
    pub t: f64,
    /// Index of the placed triangle, in the order of `Scene::world_triangles`.
    pub triangle: u32,
    /// Weight of the triangle's second corner, 0..=1.
    pub u: f64,
    /// Weight of its third corner, 0..=1; the first one has `1 - u - v`.
    pub v: f64,
}

pub(crate) const OPAQUE: u32 = u32::MAX;
pub(crate) const UNTRACED: u32 = u32::MAX;

/// One triangle as traversal reads it, in normalised space.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Leaf {
    pub corners: Corners,
    pub id: u32,
    /// Index into `cut_outs`, or [`OPAQUE`].
    pub cut_out: u32,
}

#[derive(Clone, Debug)]
pub(crate) struct CutOut {
    pub uvs: [DVec2; 3],
    pub texture: u32,
    pub cutoff: f32,
}

#[derive(Clone, Debug)]
pub(crate) struct MeshUvs {
    pub triangles: Vec<[u32; 3]>,
    pub uvs: Vec<Vec2>,
    pub material: u32,
}

/// A scene made ready for rays. Owns what it needs of the scene.
///
/// Every query applies alpha tests (nearest texel of the interpolated uv; a mesh without texture
/// coordinates is tested at uv 0) and sees triangles from both sides. A ray that is not finite, has
/// no direction or an empty range hits nothing. Distances are good to a few units in the last place
/// of f64 relative to the scene's size, plus the rounding of a far origin.
pub struct Tracer {
    pub(crate) bvh: Bvh2,
    pub(crate) stack_size: usize,
    /// In the order the tree's leaves refer to them.
    pub(crate) leaves: Vec<Leaf>,
    pub(crate) slot_of_triangle: Vec<u32>,
    pub(crate) cut_outs: Vec<CutOut>,
    pub(crate) textures: Vec<Texture>,
    pub(crate) instance_starts: Vec<u32>,
    pub(crate) instance_meshes: Vec<u32>,
    pub(crate) mesh_uvs: Vec<MeshUvs>,
    pub(crate) bounds: Aabb,
    pub(crate) space: Space,
    /// Made when first asked for.
    pub(crate) sheets: OnceLock<Sheets>,
}

#[derive(Clone, Copy)]
struct Best {
    t: f64,
    id: u32,
    u: f64,
    v: f64,
}

impl Best {
    // An id no triangle has: the end of the range itself still counts.
    fn none(t_max: f64) -> Self {
        Self { t: t_max, id: u32::MAX, u: 0.0, v: 0.0 }
    }

    #[inline(always)]
    fn is_beaten_by(&self, crossing: &Crossing, id: u32) -> bool {
        crossing.t < self.t || (crossing.t == self.t && id < self.id)
    }

    fn hit(&self, ray: &PreparedRay) -> Option<Hit> {
        (self.id != u32::MAX).then(|| Hit {
            t: ray.caller_t(self.t),
            triangle: self.id,
            u: self.u,
            v: self.v,
        })
    }
}

impl Tracer {
    /// The nearest hit; of several at the same distance the one of the lowest triangle index.
    /// Distances are compared before they are rounded to units of the ray's direction.
    pub fn closest(&self, ray: &Ray) -> Option<Hit> {
        let prepared = PreparedRay::new(ray, &self.space)?;
        let mut best = Best::none(prepared.t_max);
        self.traverse(&prepared, |leaves, t_max| {
            for leaf in leaves {
                self.improve(&prepared, leaf, &mut best, t_max);
            }
            ControlFlow::Continue(())
        });
        best.hit(&prepared)
    }

    /// Whether anything is hit.
    pub fn any(&self, ray: &Ray) -> bool {
        self.any_except(ray, None)
    }

    /// Whether anything but triangle `skip` is hit: a ray that starts on a triangle need not guess
    /// how far away from it it is.
    pub fn any_except(&self, ray: &Ray, skip: Option<u32>) -> bool {
        let Some(prepared) = PreparedRay::new(ray, &self.space) else {
            return false;
        };
        let skip = skip.unwrap_or(u32::MAX);
        let mut found = false;
        self.traverse(&prepared, |leaves, _| {
            for leaf in leaves {
                if leaf.id != skip
                    && let Some(crossing) = prepared.meet::<false>(&leaf.corners)
                    && crossing.t >= prepared.t_min
                    && crossing.t <= prepared.t_max
                    && self.is_there(leaf, &crossing)
                {
                    found = true;
                    return ControlFlow::Break(());
                }
            }
            ControlFlow::Continue(())
        });
        found
    }

    /// Every hit along the ray, by distance, then by triangle index; `hits` is overwritten. A ray
    /// through a shared edge or vertex hits every triangle that meets there.
    pub fn all(&self, ray: &Ray, hits: &mut Vec<Hit>) {
        hits.clear();
        let Some(prepared) = PreparedRay::new(ray, &self.space) else {
            return;
        };
        self.traverse(&prepared, |leaves, _| {
            hits.extend(
                leaves.iter().filter_map(|leaf| self.hit_in_range::<false>(&prepared, leaf)),
            );
            ControlFlow::Continue(())
        });
        finish(&prepared, hits);
    }

    /// [`Tracer::all`], but a ray through an edge that two triangles share hits one of them: where a
    /// surface lets light through, it must not count twice. (Of two triangles that fold back at
    /// the edge it hits both or none.)
    pub fn all_once(&self, ray: &Ray, hits: &mut Vec<Hit>) {
        hits.clear();
        let Some(prepared) = PreparedRay::new(ray, &self.space) else {
            return;
        };
        self.traverse(&prepared, |leaves, _| {
            hits.extend(leaves.iter().filter_map(|l| self.hit_in_range::<true>(&prepared, l)));
            ControlFlow::Continue(())
        });
        finish(&prepared, hits);
    }

    /// The hits of [`Tracer::all_once`] in no particular order, until `visit` breaks.
    pub(crate) fn visit_once(&self, ray: &Ray, mut visit: impl FnMut(Hit) -> ControlFlow<()>) {
        let Some(prepared) = PreparedRay::new(ray, &self.space) else {
            return;
        };
        self.traverse(&prepared, |leaves, _| {
            for leaf in leaves {
                if let Some(hit) = self.hit_in_range::<true>(&prepared, leaf) {
                    visit(Hit { t: prepared.caller_t(hit.t), ..hit })?;
                }
            }
            ControlFlow::Continue(())
        });
    }

    /// [`Tracer::closest`] by asking every triangle: slow, and right if the triangle test is.
    pub fn closest_brute_force(&self, ray: &Ray) -> Option<Hit> {
        let prepared = PreparedRay::new(ray, &self.space)?;
        let mut best = Best::none(prepared.t_max);
        for leaf in &self.leaves {
            self.improve(&prepared, leaf, &mut best, &mut 0.0);
        }
        best.hit(&prepared)
    }

    /// [`Tracer::all`] by asking every triangle.
    pub fn all_brute_force(&self, ray: &Ray, hits: &mut Vec<Hit>) {
        hits.clear();
        if let Some(prepared) = PreparedRay::new(ray, &self.space) {
            hits.extend(
                self.leaves.iter().filter_map(|leaf| self.hit_in_range::<false>(&prepared, leaf)),
            );
            finish(&prepared, hits);
        }
    }

    /// World-space bounds of everything placed, also of what is not traced.
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// Triangles that rays can meet.
    pub fn traced_triangles(&self) -> usize {
        self.leaves.len()
    }

    /// A distance in metres that is nothing beside the scene, yet beyond the rounding of points on
    /// its surfaces: where shadow rays start.
    pub fn epsilon_m(&self) -> f64 {
        if self.bounds.is_empty() {
            return 0.0;
        }
        let farthest = self.bounds.min.abs().max(self.bounds.max.abs()).max_element();
        (1e-9 / self.space.scale).max(16.0 * f64::EPSILON * farthest)
    }

    #[inline(always)]
    fn improve(&self, ray: &PreparedRay, leaf: &Leaf, best: &mut Best, t_max: &mut f32) {
        if let Some(crossing) = ray.meet::<false>(&leaf.corners)
            && crossing.t >= ray.t_min
            && best.is_beaten_by(&crossing, leaf.id)
            && self.is_there(leaf, &crossing)
        {
            *best = Best { t: crossing.t, id: leaf.id, u: crossing.u, v: crossing.v };
            *t_max = above(crossing.t);
        }
    }

    // With the distance still from the prepared ray's origin: see `finish`.
    fn hit_in_range<const ONCE: bool>(&self, ray: &PreparedRay, leaf: &Leaf) -> Option<Hit> {
        let crossing = ray.meet::<ONCE>(&leaf.corners)?;
        let in_range = crossing.t >= ray.t_min && crossing.t <= ray.t_max;
        (in_range && self.is_there(leaf, &crossing)).then_some(Hit {
            t: crossing.t,
            triangle: leaf.id,
            u: crossing.u,
            v: crossing.v,
        })
    }

    #[inline(always)]
    pub(crate) fn is_there(&self, leaf: &Leaf, crossing: &Crossing) -> bool {
        leaf.cut_out == OPAQUE || self.passes_alpha_test(leaf, crossing)
    }

    #[inline(never)]
    fn passes_alpha_test(&self, leaf: &Leaf, crossing: &Crossing) -> bool {
        let cut_out = &self.cut_outs[leaf.cut_out as usize];
        let [a, b, c] = cut_out.uvs;
        let uv = a + (b - a) * crossing.u + (c - a) * crossing.v;
        self.textures[cut_out.texture as usize].alpha_nearest(uv.as_vec2()) >= cut_out.cutoff
    }

    #[inline(always)]
    fn traverse(
        &self,
        ray: &PreparedRay,
        mut visit: impl FnMut(&[Leaf], &mut f32) -> ControlFlow<()>,
    ) {
        let mut unused = RayHit::none();
        fast_stack!(u32, (96, 192), self.stack_size, stack, {
            self.bvh.ray_traverse_dynamic(
                &mut stack,
                ray.coarse,
                &mut unused,
                |node, coarse, _| {
                    let first = node.first_index as usize;
                    let leaves = &self.leaves[first..first + node.prim_count as usize];
                    visit(leaves, &mut coarse.tmax).is_continue()
                },
            );
        });
    }
}

// Sorted before the distances are rounded to the caller's units: several may become equal there,
// and the first has to be the one that `closest` chooses.
fn finish(ray: &PreparedRay, hits: &mut [Hit]) {
    hits.sort_unstable_by(|a, b| a.t.total_cmp(&b.t).then(a.triangle.cmp(&b.triangle)));
    for hit in hits {
        hit.t = ray.caller_t(hit.t);
    }
}
