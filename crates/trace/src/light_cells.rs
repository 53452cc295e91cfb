//! Parallel light rays by the thousand: the triangles of a light's map sorted into cells, so that a
//! ray asks only those above its cell instead of searching a tree.
//!
//! Hits are those of [`Tracer::visit_once`], decided in the map's plane as in `light_raster.rs`, and
//! differ as little.

use crate::light_raster::Raster;
use crate::lists::{self, gather};
use crate::tracer::{Hit, Ray, Tracer};
use dapple_scene::LightView;
use std::ops::{ControlFlow, Range};

/// The most entries of all cells: 512 MiB of them.
const MAX_ENTRIES: usize = 1 << 27;

/// The longest side in cells.
const MAX_SIDE: u32 = 1 << 12;

/// The rays of a light's view.
pub(crate) struct LightRays<'a> {
    tracer: &'a Tracer,
    view: &'a LightView,
    cells: Option<Cells>,
}

struct Cells {
    raster: Raster,
    starts: Vec<u32>,
    /// Of leaves.
    slots: Vec<u32>,
}

impl<'a> LightRays<'a> {
    /// Rays that search the tree.
    pub fn by_tree(tracer: &'a Tracer, view: &'a LightView) -> Self {
        Self { tracer, view, cells: None }
    }

    /// Rays that look into cells where the light is parallel: worth it for many.
    pub fn by_cells(tracer: &'a Tracer, view: &'a LightView) -> Self {
        // About four cells a triangle: thin ones cover few, and lists stay short.
        let wanted = 2.0 * (tracer.traced_triangles() as f64).sqrt();
        let mut side = (wanted as u32).clamp(1, MAX_SIDE);
        let mut cells = None;
        // Large triangles lie in many cells; without any success the tree is left.
        while cells.is_none() && side >= 16 {
            cells = Cells::of(tracer, view, side);
            side /= 4;
        }
        Self { tracer, view, cells }
    }

    /// Hits above map point (u, v) at depths of a range, both ends included, in no particular order,
    /// until `visit` breaks.
    pub fn visit(
        &self,
        [u, v]: [f64; 2],
        [t_min, t_max]: [f64; 2],
        mut visit: impl FnMut(Hit) -> ControlFlow<()>,
    ) {
        let inside = (0.0..=1.0).contains(&u) && (0.0..=1.0).contains(&v);
        let Some(cells) = self.cells.as_ref().filter(|_| inside) else {
            let (origin, direction) = self.view.ray(u, v);
            return self.tracer.visit_once(&Ray { origin, direction, t_min, t_max }, visit);
        };
        let place = cells.raster.place(u, v);
        for &slot in cells.above(u, v) {
            let leaf = &self.tracer.leaves[slot as usize];
            if let Some(found) = cells.raster.project(&leaf.corners).cover(place)
                && (t_min..=t_max).contains(&found.t)
                && self.tracer.is_there(leaf, &found)
            {
                let hit = Hit { t: found.t, triangle: leaf.id, u: found.u, v: found.v };
                if visit(hit).is_break() {
                    return;
                }
            }
        }
    }
}

impl Cells {
    fn of(tracer: &Tracer, view: &LightView, side: u32) -> Option<Self> {
        let raster = Raster::of(tracer, view, [side; 2])?;
        // Half a cell, and more than rounding may move a ray.
        let reach = 0.5 + 1e-6;
        // In the tree's order neighbours lie side by side.
        let slots: Vec<u32> = (0..tracer.leaves.len() as u32).collect();
        let rows = raster.rows(tracer, &slots, reach);
        let fill = |band: Range<u32>, emit: &mut dyn FnMut(u32, u32) -> bool| {
            let top = band.start;
            raster.each_row(tracer, &slots, &rows, band, |slot, projected, y| {
                let row = (y - top) * side;
                projected.columns(f64::from(y), reach, side).all(|x| emit(row + x, slot))
            });
        };
        let (starts, slots) = gather([side; 2], MAX_ENTRIES, fill)?;
        Some(Self { raster, starts, slots })
    }

    /// The triangles that may lie above a map point in 0..=1.
    fn above(&self, u: f64, v: f64) -> &[u32] {
        let side = self.raster.size[0];
        let cell = |t: f64| ((t * f64::from(side)) as u32).min(side - 1) as usize;
        &self.slots[lists::range(&self.starts, cell(v) * side as usize + cell(u))]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dapple_scene::{AlphaTest, Instance, Material, Mesh, Scene, Texture};
    use glam::{DAffine3, DVec3, Vec2, Vec3};
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64;

    /// Triangles of all sizes, half of them cut out by a checkered texture.
    fn soup(count: u32, rng: &mut Pcg64) -> Scene {
        let mut mesh = |material| {
            let (mut positions, mut uvs) = (Vec::new(), Vec::new());
            for _ in 0..count {
                let size = 10.0_f32.powf(rng.random_range(-2.5..0.3));
                let mut point = |size: f32| {
                    Vec3::from_array(std::array::from_fn(|_| rng.random_range(-size..size)))
                };
                let centre = point(1.0);
                positions.extend((0..3).map(|_| centre + point(size)));
                uvs.extend([Vec2::ZERO, Vec2::X * 5.0, Vec2::Y * 5.0]);
            }
            let triangles = (0..count).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
            Mesh { positions, uvs, triangles, material, ..Mesh::default() }
        };
        let texels = (0..16).map(|i| [0, 0, 0, if (i + i / 4) % 2 == 0 { 255 } else { 0 }]);
        let texture =
            Texture { name: String::new(), width: 4, height: 4, texels: texels.collect() };
        let cut = Some(AlphaTest { texture: 0, cutoff: 0.5 });
        Scene {
            meshes: vec![mesh(0), mesh(1)],
            materials: vec![
                Material::default(),
                Material { alpha_test: cut, ..Material::default() },
            ],
            textures: vec![texture],
            instances: [0, 1].map(|mesh| Instance { mesh, transform: DAffine3::IDENTITY }).to_vec(),
            ..Scene::default()
        }
    }

    fn hits(rays: &LightRays, at: [f64; 2], range: [f64; 2]) -> Vec<Hit> {
        let mut hits = Vec::new();
        rays.visit(at, range, |hit| {
            hits.push(hit);
            ControlFlow::Continue(())
        });
        hits.sort_by_key(|hit| hit.triangle);
        hits
    }

    #[test]
    fn cells_find_what_the_tree_finds() {
        let mut rng = Pcg64::seed_from_u64(3);
        for count in [100, 20_000] {
            let scene = soup(count, &mut rng);
            let tracer = Tracer::build(&scene).unwrap();
            for direction in [DVec3::NEG_Y, DVec3::new(0.3, -1.0, 0.2)] {
                let mut view = LightView::fit_directional(direction, &scene.bounds()).unwrap();
                // Off the map as well.
                view.half_extent *= 0.8;
                let (tree, cells) =
                    (LightRays::by_tree(&tracer, &view), LightRays::by_cells(&tracer, &view));
                assert!(cells.cells.as_ref().is_some_and(|c| c.raster.size[0] >= 20));
                let mut met = 0;
                for i in 0..1000 {
                    let mut at = [0, 1].map(|_| rng.random_range(-0.1..1.1));
                    if i % 10 == 0 {
                        // On borders of cells and of the map.
                        at = at.map(|u: f64| (u * 20.0).round() / 20.0);
                    }
                    let range = [rng.random_range(-0.1..0.5), rng.random_range(0.4..1.1)];
                    let (a, b) = (hits(&cells, at, range), hits(&tree, at, range));
                    let ids = |hits: &[Hit]| hits.iter().map(|h| h.triangle).collect::<Vec<_>>();
                    assert_eq!(ids(&a), ids(&b), "{at:?} {range:?}");
                    for (a, b) in a.iter().zip(&b) {
                        let apart = (a.t - b.t).abs().max((a.u - b.u).abs()).max((a.v - b.v).abs());
                        assert!(apart < 1e-9, "{a:?} {b:?}");
                    }
                    met += a.len();
                }
                assert!(met > 2 * count.min(2000) as usize, "{met}");
            }
        }
    }

    #[test]
    fn what_has_no_cells_is_left_to_the_tree() {
        let mut rng = Pcg64::seed_from_u64(4);
        let scene = soup(500, &mut rng);
        let tracer = Tracer::build(&scene).unwrap();
        let bounds = scene.bounds();
        let spot = LightView::fit_spot(DVec3::Y * 9.0, DVec3::NEG_Y, 0.2, &bounds).unwrap();
        let rays = LightRays::by_cells(&tracer, &spot);
        assert!(rays.cells.is_none());
        assert!(!hits(&rays, [0.5, 0.5], [0.0, 1.0]).is_empty());
        for at in [[f64::NAN, 0.5], [0.5, f64::INFINITY]] {
            let view = LightView::fit_directional(DVec3::X, &bounds).unwrap();
            assert!(hits(&LightRays::by_cells(&tracer, &view), at, [0.0, 1.0]).is_empty());
        }
        let nothing = Tracer::build(&Scene::default()).unwrap();
        assert!(hits(&LightRays::by_cells(&nothing, &spot), [0.5, 0.5], [0.0, 1.0]).is_empty());
    }
}
