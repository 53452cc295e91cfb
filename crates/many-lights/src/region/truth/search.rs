//! Rays from a face to lights.

use super::obstacles::arrives;
use super::points::Points;
use super::{Obstacles, kept};
use crate::bound::Region;
use crate::light::angle;
use crate::region::potential::{is_weak, potential, white};
use crate::region::{Cuboid, Direction, Face, Solid, ViewCell};
use crate::{Emission, Light, LightTree, PackedNode, Point, World, radiance, sample::Random};
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// Share of the coordinates by which turning may move a place.
const ROUNDED: f64 = 1e-12;

/// A face, and what there is to see from it.
pub struct Sight<'a> {
    world: &'a World,
    face: &'a Face,
    cell: &'a ViewCell,
    direction: Direction,
    obstacles: Obstacles<'a>,
    /// In the space of the direction.
    cuboid: Cuboid,
    occluders: Vec<Cuboid>,
}

/// A light and a point of the face that sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sighting {
    /// Index of the light.
    pub light: u32,
    /// Local space.
    pub from: DVec3,
}

/// What rays found.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Seen {
    /// One of each light asked for, in that order: the first point that sees it, if any does.
    pub sightings: Vec<Option<Sighting>>,
    /// Rays.
    pub rays: u64,
}

/// Culled lights that are seen.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FalseCulls {
    /// They and from where, in order of the lights.
    pub found: Vec<Sighting>,
    /// Lights in front of the face that were left out.
    pub culled: u64,
    /// Rays.
    pub rays: u64,
}

impl<'a> Sight<'a> {
    /// From a cell's face; `None` where it has none towards `direction`. `solids` are in the space of
    /// the cell's turn: rays are drawn close to their silhouettes, and [`Obstacles::Boxes`] are they.
    pub fn new(
        world: &'a World,
        cell: &'a ViewCell,
        direction: Direction,
        solids: &[Solid],
        obstacles: Obstacles<'a>,
    ) -> Option<Self> {
        let face = cell.face(direction)?;
        let cuboid = face.cuboid(direction);
        let occluders = solids.iter().map(|s| direction.cuboid(s.min, s.max));
        // What lies behind the face is met by no ray that leads forward.
        let occluders = occluders.filter(|o| o.w[1] >= cuboid.w[0]).collect();
        Some(Self { world, face, cell, direction, obstacles, cuboid, occluders })
    }

    /// Whether a light lies in front of the face's rearmost points. Parallel light has no place.
    pub fn is_in_front(&self, light: u32) -> bool {
        let Some(of) = self.world.lights.get(light as usize) else { return false };
        of.emission != Emission::Directional && self.placed(of)[1] > self.cuboid.w[0]
    }

    /// Whether a light lies in front of the face and any white surface of it may get more than nothing,
    /// and at least `threshold`, from it if nothing lies between: what is left for occluders to hide.
    pub fn may_be_lit_by(&self, light: u32, threshold: f64) -> bool {
        self.is_in_front(light) && {
            let leaf = PackedNode::of(&self.world.lights[light as usize], light).unpack();
            let most = potential(&leaf, &white(&self.face.region), self.world.clamp_m);
            !is_weak(most, threshold)
        }
    }

    fn placed(&self, light: &Light) -> [f64; 3] {
        let at = self.cell.turn.to(light.position);
        let Cuboid { u, w, h } = self.direction.cuboid(at, at);
        [u[0], w[0], h[0]]
    }

    /// The first point that sees a light and may get more than `threshold` from it, and the rays.
    fn search(
        &self,
        light: u32,
        threshold: Option<f64>,
        (random, seed): (u32, u32),
        points: &mut Points,
    ) -> (Option<Sighting>, u64) {
        if !self.is_in_front(light) {
            return (None, 0);
        }
        let of = &self.world.lights[light as usize];
        let to = self.placed(of);
        let mut draws = Random::new(seed, self.direction.index() as u32, light);
        points.fill(&self.cuboid, to, &self.occluders, (random, &mut draws));
        let mut rays = 0;
        for from in &points.found {
            let turned = self.direction.turned(from[0], from[1], from[2]);
            let local = self.cell.turn.from(turned);
            if !self.may_hold(local) {
                continue;
            }
            if threshold.is_some_and(|t| !self.gives(of, local, t)) {
                continue;
            }
            rays += 1;
            if arrives(&self.obstacles, of, local, (*from, to), &self.occluders) {
                return (Some(Sighting { light, from: local }), rays);
            }
        }
        (None, rays)
    }

    /// Whether any surface of the face may be at a place of its box: surfaces lie within their box in
    /// local space too, and the corners of one that is turned reach beyond.
    fn may_hold(&self, local: DVec3) -> bool {
        let Region { min, max, .. } = self.face.region;
        let rounded = ROUNDED * min.abs().max(max.abs()).max_element();
        local.cmpge(min - rounded).all() && local.cmple(max + rounded).all()
    }

    /// Whether a white surface there gives more than nothing, and at least the threshold, because of a
    /// light: one that faces it as far as the face's normals let it.
    fn gives(&self, light: &Light, at: DVec3, threshold: f64) -> bool {
        let region = &self.face.region;
        let to_light = (light.position - at).normalize_or_zero();
        let between = angle(region.normal_axis, to_light);
        let turned_by = between.min(region.normal_spread_rad);
        let side =
            (to_light - region.normal_axis * region.normal_axis.dot(to_light)).normalize_or_zero();
        let normal = region.normal_axis * turned_by.cos() + side * turned_by.sin();
        // Relative to the point, so that it need not be rounded to f32.
        let point =
            Point { normal: normal.as_vec3(), albedo: Vec3::ONE, object: 0, ..Point::default() };
        let light = Light { position: light.position - at, ..*light };
        let most = radiance(&point, &light, self.world.clamp_m).max_element();
        // Less what the normal was rounded by.
        most > 0.0 && most * (1.0 - 1e-5) >= threshold
    }

    fn all(&self, lights: &[u32], threshold: Option<f64>, random: u32, seed: u32) -> Seen {
        let found: Vec<(Option<Sighting>, u64)> = lights
            .par_iter()
            .map_init(Points::default, |points, &light| {
                self.search(light, threshold, (random, seed), points)
            })
            .collect();
        let rays = found.iter().map(|(_, rays)| rays).sum();
        Seen { sightings: found.into_iter().map(|(sighting, _)| sighting).collect(), rays }
    }
}

/// Which of the lights any point of the face sees: those in front of it, whatever they give. `random`
/// points a light are tried after those at silhouettes. The same for any number of threads.
pub fn seen(sight: &Sight<'_>, lights: &[u32], random: u32, seed: u32) -> Seen {
    sight.all(lights, None, random, seed)
}

/// Which of the lights any point of the face sees that gets `threshold` or more from them, and more
/// than nothing.
pub fn seen_strongly(
    sight: &Sight<'_>,
    lights: &[u32],
    threshold: f64,
    random: u32,
    seed: u32,
) -> Seen {
    sight.all(lights, Some(threshold), random, seed)
}

/// Lights in front of the face that a precut leaves out although a point of the face sees them and
/// gets `threshold` or more from them (and more than nothing).
pub fn false_culls(
    sight: &Sight<'_>,
    tree: &LightTree,
    precut: &[u32],
    threshold: f64,
    (random, seed): (u32, u32),
) -> FalseCulls {
    let kept = kept(tree, precut);
    let culled: Vec<u32> = (0..kept.len() as u32)
        .filter(|&light| !kept[light as usize] && sight.is_in_front(light))
        .collect();
    let Seen { sightings, rays } = sight.all(&culled, Some(threshold), random, seed);
    FalseCulls {
        found: sightings.into_iter().flatten().collect(),
        culled: culled.len() as u64,
        rays,
    }
}
