//! From a scene to objects.
//!
//! A template's corners are those of its mesh less the middle of the mesh's box, so that a mesh
//! whose own coordinates are far from 0 keeps its detail where it is placed. All clusters of a mesh
//! are relative to the same middle: their common corners stay equal.

use super::check::check;
use super::clusters::clusters;
use super::{Bounds, Mask, Object, Objects, Template};
use crate::OcclusionError;
use dapple_scene::{Aabb, AlphaTest, Instance, Mesh, Scene};
use glam::{DVec3, Mat3, Vec2, Vec3};
use rayon::prelude::*;
use std::{collections::BTreeMap, ops::Range};

/// What the list of triangles says of one that is not drawn: its material lets everything through.
pub const NOT_DRAWN: [u32; 2] = [u32::MAX; 2];

/// Farthest of anything from the origin, metres: areas and their sums stay finite in f32.
const MAX_LOCAL_M: f64 = 1e12;
/// Steps of f32 that a placed corner may be off, in units of 2^-24 of the terms that are summed:
/// three products, three sums, the rounded matrix and translation, in whatever order and fusing.
const PLACEMENT_UNITS: f64 = 8.0 / 16_777_216.0;

/// A mesh's share of the templates.
struct Cut {
    templates: Range<u32>,
    /// Middle of the mesh, which its templates are relative to.
    middle: Vec3,
    /// Cluster and index within it of each triangle; empty where there is but one cluster.
    homes: Vec<[u32; 2]>,
    /// Whether the material lets everything through.
    invisible: bool,
}

impl Objects {
    /// One object an instance, in order; instances of more than `most` triangles are cut into
    /// clusters of at most so many, halved at the median of the longest side of their centres: these
    /// follow each other. Instances of a material of opacity 0 become objects without triangles;
    /// any other opacity counts as 1. Also gives the object of every placed triangle, in the order
    /// of `Scene::world_triangles`, and its index within that object ([`NOT_DRAWN`] if none).
    ///
    /// # Errors
    /// A scene of no triangles, `most` of 0, an index or a length that does not fit, numbers that
    /// are not finite, anything farther than 1e12 m from the middle.
    pub fn from_scene(scene: &Scene, most: u32) -> Result<(Self, Vec<[u32; 2]>), OcclusionError> {
        if most == 0 {
            return Err(OcclusionError::value("triangles an object", "0, at least 1 is needed"));
        }
        check(scene)?;
        let mut objects = Self::default();
        let mut masks = Masks::default();
        // The mesh's vertex that each corner of a template is.
        let mut sources: Vec<Vec<u32>> = Vec::new();
        let mut cuts = Vec::with_capacity(scene.meshes.len());
        for mesh in &scene.meshes {
            cuts.push(cut(scene, mesh, most, &mut objects.templates, &mut sources, &mut masks));
        }
        objects.masks = masks.masks;

        let parts = |(instance, placed): (usize, &Instance)| {
            let templates = cuts[placed.mesh as usize].templates.clone();
            templates.map(move |template| (instance, template))
        };
        let parts: Vec<(usize, u32)> = scene.instances.iter().enumerate().flat_map(parts).collect();
        let boxes: Vec<Aabb> = parts
            .par_iter()
            .map(|&(instance, template)| world_box(scene, instance, &sources[template as usize]))
            .collect();
        let mut world = Aabb::EMPTY;
        for bounds in &boxes {
            world = world.grow(bounds.min).grow(bounds.max);
        }
        let origin = world.centre();
        let made: Result<Vec<Object>, OcclusionError> = parts
            .par_iter()
            .zip(&boxes)
            .map(|(&(instance, template), bounds)| {
                let placed = &scene.instances[instance];
                let middle = cuts[placed.mesh as usize].middle;
                let positions = &objects.templates[template as usize].positions;
                place(placed, middle, template, positions, bounds, origin).ok_or_else(|| {
                    let element = format!("scene \"{}\", instance {instance}", scene.name);
                    let limit = format!(
                        "{bounds:?} m, at most {MAX_LOCAL_M:e} m from the scene's middle {origin} is allowed"
                    );
                    OcclusionError::value(element, limit)
                })
            })
            .collect();
        objects.objects = made?;
        objects.origin = origin;
        Ok((objects, homes(scene, &cuts)))
    }
}

/// Masks by texture and cut-off.
#[derive(Default)]
struct Masks {
    masks: Vec<Mask>,
    known: BTreeMap<(u32, u32), Option<u32>>,
}

impl Masks {
    /// The mask of `test`; none where it cuts nothing away.
    fn of(&mut self, scene: &Scene, test: AlphaTest) -> Option<u32> {
        let Self { masks, known } = self;
        *known.entry((test.texture, test.cutoff.to_bits())).or_insert_with(|| {
            let texture = &scene.textures[test.texture as usize];
            let passes = |alpha: f32| alpha >= test.cutoff;
            let mut mask = Mask { width: 1, height: 1, words: vec![u32::from(passes(1.0))] };
            if !texture.texels.is_empty() {
                let words = texture.texels.chunks(32).map(|texels| {
                    let bit = |(i, texel): (usize, &[u8; 4])| {
                        u32::from(passes(f32::from(texel[3]) / 255.0)) << i
                    };
                    texels.iter().enumerate().map(bit).sum()
                });
                mask =
                    Mask { width: texture.width, height: texture.height, words: words.collect() };
            }
            let there: u64 = mask.words.iter().map(|w| u64::from(w.count_ones())).sum();
            if there == u64::from(mask.width) * u64::from(mask.height) {
                return None;
            }
            masks.push(mask);
            Some(masks.len() as u32 - 1)
        })
    }
}

fn cut(
    scene: &Scene,
    mesh: &Mesh,
    most: u32,
    templates: &mut Vec<Template>,
    sources: &mut Vec<Vec<u32>>,
    masks: &mut Masks,
) -> Cut {
    let material = &scene.materials[mesh.material as usize];
    let first = templates.len() as u32;
    let mask = material.alpha_test.and_then(|test| masks.of(scene, test));
    let blank = Template { mask, albedo: material.albedo, ..Template::default() };
    let invisible = material.opacity <= 0.0;
    if invisible || mesh.triangles.is_empty() {
        templates.push(blank);
        sources.push(Vec::new());
        let templates = first..first + 1;
        return Cut { templates, middle: Vec3::ZERO, homes: Vec::new(), invisible };
    }
    let used = || mesh.triangles.iter().flatten().map(|&c| mesh.positions[c as usize]);
    let low = used().fold(Vec3::INFINITY, Vec3::min);
    let high = used().fold(Vec3::NEG_INFINITY, Vec3::max);
    // Halved before they are added: the sum may be beyond f32.
    let middle = 0.5 * low + 0.5 * high;
    let parts = clusters(&mesh.positions, &mesh.triangles, most);
    let mut homes = Vec::new();
    if parts.len() > 1 {
        homes = vec![[0; 2]; mesh.triangles.len()];
    }
    let mut slots = vec![u32::MAX; mesh.positions.len()];
    for (cluster, part) in parts.iter().enumerate() {
        let mut template = blank.clone();
        let mut taken = Vec::new();
        for (index, &t) in part.iter().enumerate() {
            if let Some(home) = homes.get_mut(t as usize) {
                *home = [cluster as u32, index as u32];
            }
            template.triangles.push(mesh.triangles[t as usize].map(|corner| {
                let slot = &mut slots[corner as usize];
                if *slot == u32::MAX {
                    *slot = taken.len() as u32;
                    taken.push(corner);
                }
                *slot
            }));
        }
        for &corner in &taken {
            slots[corner as usize] = u32::MAX;
            template.positions.push(mesh.positions[corner as usize] - middle);
            if mask.is_some() {
                template.uvs.push(mesh.uvs.get(corner as usize).copied().unwrap_or(Vec2::ZERO));
            }
        }
        templates.push(template);
        sources.push(taken);
    }
    Cut { templates: first..first + parts.len() as u32, middle, homes, invisible }
}

/// Holds the corners in world space; the placed origin of the mesh where there are none.
fn world_box(scene: &Scene, instance: usize, source: &[u32]) -> Aabb {
    let Instance { mesh, transform } = &scene.instances[instance];
    let positions = &scene.meshes[*mesh as usize].positions;
    if source.is_empty() {
        return Aabb::EMPTY.grow(transform.translation);
    }
    let corner = |&c: &u32| transform.transform_point3(positions[c as usize].as_dvec3());
    source.iter().map(corner).fold(Aabb::EMPTY, Aabb::grow)
}

/// One object; none where it is too far from the origin.
fn place(
    instance: &Instance,
    middle: Vec3,
    template: u32,
    positions: &[Vec3],
    world: &Aabb,
    origin: DVec3,
) -> Option<Object> {
    let linear: Mat3 = instance.transform.matrix3.as_mat3();
    let anchor = instance.transform.transform_point3(middle.as_dvec3()) - origin;
    let translation = anchor.as_vec3();
    let bounds = Bounds::around(world.min - origin, world.max - origin);
    let mut object = Object { template, linear, translation, bounds };
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let mut reach = DVec3::ZERO;
    for &p in positions {
        let placed = object.place(p).as_dvec3();
        (low, high) = (low.min(placed), high.max(placed));
        reach = reach.max(p.abs().as_dvec3());
    }
    if !positions.is_empty() {
        let terms = instance.transform.matrix3.abs() * reach + anchor.abs();
        let slack = PLACEMENT_UNITS * terms;
        object.bounds = object.bounds.union(Bounds::around(low - slack, high + slack));
    }
    let Bounds { min, max } = object.bounds;
    let far = f64::from(min.abs().max(max.abs()).max_element());
    let finite =
        linear.is_finite() && translation.is_finite() && min.is_finite() && max.is_finite();
    (finite && far <= MAX_LOCAL_M).then_some(object)
}

/// Object and index within it of every placed triangle.
fn homes(scene: &Scene, cuts: &[Cut]) -> Vec<[u32; 2]> {
    let mut homes = Vec::with_capacity(scene.triangle_count());
    let mut first = 0_u32;
    for instance in &scene.instances {
        let cut = &cuts[instance.mesh as usize];
        let count = scene.meshes[instance.mesh as usize].triangles.len() as u32;
        homes.extend((0..count).map(|t| match cut.homes.get(t as usize) {
            _ if cut.invisible => NOT_DRAWN,
            Some(&[cluster, index]) => [first + cluster, index],
            None => [first, t],
        }));
        first += cut.templates.len() as u32;
    }
    homes
}
