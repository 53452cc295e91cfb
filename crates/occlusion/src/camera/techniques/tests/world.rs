//! Small worlds, paths through them, and what techniques make of both.

use crate::OcclusionError;
use crate::camera::software::Reference;
use crate::camera::techniques;
use crate::camera::{
    Bounds, Frame, Image, Mask, Object, Objects, Query, Readiness, Renderer, Settings, State,
    Technique, Template, Tree, View,
};
use dapple_scene::{Camera, Projection};
use glam::{DVec3, Mat3, Vec2, Vec3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg32;
use std::sync::Arc;

pub const WIDTH: u32 = 48;
pub const HEIGHT: u32 = 32;

pub struct World {
    pub objects: Arc<Objects>,
    pub tree: Tree,
    scale: f64,
}

/// A frame as it was played.
#[derive(Debug, PartialEq)]
pub struct Played {
    pub frame: Frame,
    pub image: Image,
}

/// The unit cube, and a square on its floor with holes in it.
fn templates() -> Vec<Template> {
    let unit = Bounds { min: Vec3::ZERO, max: Vec3::ONE };
    let square = [Vec3::ZERO, Vec3::X, Vec3::X + Vec3::Y, Vec3::Y];
    let sides =
        [[0, 2, 6, 4], [1, 5, 7, 3], [0, 4, 5, 1], [2, 3, 7, 6], [0, 1, 3, 2], [4, 6, 7, 5]];
    vec![
        Template {
            positions: unit.corners().to_vec(),
            triangles: sides.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect(),
            ..Template::default()
        },
        Template {
            positions: square.to_vec(),
            uvs: square.iter().map(|c| Vec2::new(c.x, c.y) * 3.0).collect(),
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            mask: Some(0),
            ..Template::default()
        },
    ]
}

/// An object of size `size` whose lower corner is `at`.
fn place(templates: &[Template], template: u32, at: Vec3, size: Vec3, turn_rad: f32) -> Object {
    let linear = Mat3::from_rotation_y(turn_rad) * Mat3::from_diagonal(size);
    let mut object = Object { template, linear, translation: at, bounds: Bounds::EMPTY };
    for &p in &templates[template as usize].positions {
        let placed = object.place(p);
        object.bounds = object.bounds.union(Bounds { min: placed, max: placed });
    }
    object
}

impl World {
    /// Cubes given by lower corner and size.
    pub fn boxes(boxes: &[(Vec3, Vec3)]) -> Self {
        let templates = templates();
        let object = |&(at, size): &(Vec3, Vec3)| place(&templates, 0, at, size, 0.0);
        let objects = boxes.iter().map(object).collect();
        Self::of(templates, objects)
    }

    fn of(templates: Vec<Template>, objects: Vec<Object>) -> Self {
        let masks = vec![Mask { width: 2, height: 2, words: vec![0b1001] }];
        let objects = Objects { origin: DVec3::ZERO, templates, objects, masks };
        let tree = Tree::bottom_up(&objects).unwrap();
        Self { objects: Arc::new(objects), tree, scale: 1.0 }
    }

    /// The same, so many times as large.
    pub fn scaled(&self, scale: f32) -> Self {
        let mut objects = Objects::clone(&self.objects);
        for object in &mut objects.objects {
            object.linear *= scale;
            object.translation *= scale;
            object.bounds.min *= scale;
            object.bounds.max *= scale;
        }
        let tree = Tree::bottom_up(&objects).unwrap();
        Self { objects: Arc::new(objects), tree, scale: self.scale * f64::from(scale) }
    }

    /// The same, elsewhere.
    pub fn moved(&self, by: DVec3) -> Self {
        let mut objects = Objects::clone(&self.objects);
        objects.origin += by;
        Self { objects: Arc::new(objects), tree: self.tree.clone(), scale: self.scale }
    }

    /// A town of `count` things around the origin, 40 m wide: houses of all sizes, some of them
    /// turned, and fences with holes.
    pub fn town(seed: u64, count: u32) -> Self {
        let templates = templates();
        let mut random = Pcg32::seed_from_u64(seed);
        let mut thing = |_| {
            let mut between = |a: f32, b: f32| random.random_range(a..b);
            let at = Vec3::new(between(-20.0, 20.0), between(-0.1, 0.1), between(-20.0, 20.0));
            let kind = between(0.0, 1.0);
            let size = match kind {
                k if k < 0.2 => Vec3::new(between(4.0, 12.0), between(3.0, 8.0), between(0.3, 2.0)),
                k if k < 0.7 => Vec3::new(between(1.0, 4.0), between(1.0, 8.0), between(1.0, 4.0)),
                _ => Vec3::new(between(0.1, 1.0), between(0.1, 1.0), between(0.1, 1.0)),
            };
            let turn = if kind < 0.5 { 0.0 } else { between(0.0, 6.0) };
            place(&templates, u32::from(kind > 0.93), at, size, turn)
        };
        let objects = (0..count).map(&mut thing).collect();
        Self::of(templates.clone(), objects)
    }

    pub fn view(&self, position: DVec3, heading_rad: f64, pitch_rad: f64) -> View {
        let (sin, cos) = heading_rad.sin_cos();
        let ahead = DVec3::new(cos * pitch_rad.cos(), pitch_rad.sin(), sin * pitch_rad.cos());
        // Directions and places that stay the same far from the origin.
        let round = |v: DVec3| (v * 1024.0).round() / 1024.0;
        let position = self.objects.origin + round(position) * self.scale;
        let camera = Camera {
            name: "path".into(),
            position,
            target: position + round(ahead) * self.scale,
            up: DVec3::Y,
            projection: Projection::Perspective { fov_y_rad: 1.0 },
        };
        View::new(&camera, &self.objects, WIDTH, HEIGHT, 0.125 * self.scale).unwrap()
    }

    /// Straight through the town at eye height.
    pub fn walk(&self, frames: u32) -> Vec<View> {
        let at = |frame: u32| {
            let t = f64::from(frame);
            self.view(DVec3::new(-22.0 + 0.3 * t, 1.7, 0.4 - 0.02 * t), 0.01 * t, 0.02)
        };
        (0..frames).map(at).collect()
    }

    /// Now here, now there.
    pub fn jumps(&self, seed: u64, frames: u32) -> Vec<View> {
        let mut random = Pcg32::seed_from_u64(seed ^ 0x5eed);
        let mut view = None;
        let at = |_| {
            if view.is_none() || random.random_bool(0.5) {
                let mut between = |a: f64, b: f64| random.random_range(a..b);
                let position =
                    DVec3::new(between(-25.0, 25.0), between(0.5, 12.0), between(-25.0, 25.0));
                view = Some(self.view(position, between(0.0, 6.3), between(-0.6, 0.2)));
            }
            view.clone().unwrap()
        };
        (0..frames).map(at).collect()
    }

    pub fn renderer(&self, latency: u32) -> Reference {
        Reference::new(self.objects.clone(), Readiness::Modelled(latency)).unwrap()
    }

    /// What one technique draws along a path.
    pub fn play(&self, settings: &Settings, latency: u32, views: &[View]) -> Vec<Played> {
        let mut renderer = self.renderer(latency);
        let mut state = State::new(&self.tree);
        self.play_on(settings, &mut state, &mut renderer, views)
    }

    pub fn play_on(
        &self,
        settings: &Settings,
        state: &mut State,
        renderer: &mut Reference,
        views: &[View],
    ) -> Vec<Played> {
        let play = |view| {
            let mut frame = Frame::default();
            self.frame(settings, view, state, renderer, &mut frame).unwrap();
            Played { frame, image: renderer.image().clone() }
        };
        views.iter().map(play).collect()
    }

    pub fn frame(
        &self,
        settings: &Settings,
        view: &View,
        state: &mut State,
        renderer: &mut dyn Renderer,
        out: &mut Frame,
    ) -> Result<(), OcclusionError> {
        techniques::frame(settings, &self.objects, &self.tree, view, state, renderer, out)
    }

    /// The image of everything.
    pub fn truth(&self, view: &View) -> Image {
        let all = Settings::new(Technique::None);
        self.play(&all, 0, std::slice::from_ref(view)).remove(0).image
    }

    /// What is wrong with frames that have to be exact; empty for nothing.
    pub fn faults(&self, settings: &Settings, views: &[View], played: &[Played]) -> Vec<String> {
        let mut faults = Vec::new();
        for (i, (view, played)) in views.iter().zip(played).enumerate() {
            let wrong = differences(&self.truth(view), &played.image);
            if wrong > 0 {
                faults.push(format!("frame {i}: {wrong} pixels differ"));
            }
            let mut drawn = played.frame.drawn.clone();
            drawn.sort_unstable();
            drawn.dedup();
            if drawn.len() != played.frame.drawn.len() {
                faults.push(format!("frame {i}: something is drawn twice"));
            }
            let inside = |o: &u32| view.sees(&self.objects.objects[*o as usize].bounds);
            if settings.technique != Technique::None && !drawn.iter().all(inside) {
                faults.push(format!("frame {i}: something outside the frustum is drawn"));
            }
        }
        faults
    }
}

/// Pixels that differ in depth. At equal depth either of two objects may own a pixel, by the order of
/// drawing.
pub fn differences(a: &Image, b: &Image) -> usize {
    assert_eq!((a.width, a.height), (b.width, b.height));
    a.depth.iter().zip(&b.depth).filter(|(a, b)| a.to_bits() != b.to_bits()).count()
}

/// Asks each box of a query by itself as well, and counts what does not agree.
pub struct OneByOne {
    pub inner: Reference,
    pub groups: usize,
    pub wrong: usize,
    pub first_box_only: bool,
    pending: std::collections::VecDeque<(usize, Vec<u32>)>,
}

impl OneByOne {
    pub fn new(inner: Reference) -> Self {
        Self { inner, groups: 0, wrong: 0, first_box_only: false, pending: Default::default() }
    }
}

impl Renderer for OneByOne {
    fn begin(&mut self, view: &View) -> Result<(), OcclusionError> {
        self.inner.begin(view)
    }

    fn draw(&mut self, objects: &[u32]) -> Result<(), OcclusionError> {
        self.inner.draw(objects)
    }

    fn ask(&mut self, boxes: &[Bounds], queries: &[Query]) -> Result<(), OcclusionError> {
        // One query each box, so that the counts of a query's boxes add up to its own.
        let single = |i: usize| Query { boxes: i as u32..i as u32 + 1 };
        let each: Vec<Query> = (0..boxes.len()).map(single).collect();
        let mut all = queries.to_vec();
        if self.first_box_only {
            all.iter_mut().for_each(|q| q.boxes.end = q.boxes.start + 1);
        }
        all.extend(each);
        let sizes = queries.iter().map(|q| q.boxes.len() as u32).collect();
        self.pending.push_back((queries.len(), sizes));
        self.inner.ask(boxes, &all)
    }

    fn ready(&mut self) -> Result<bool, OcclusionError> {
        self.inner.ready()
    }

    fn collect(&mut self, counts: &mut Vec<u32>) -> Result<(), OcclusionError> {
        let mut all = Vec::new();
        self.inner.collect(&mut all)?;
        let (queries, sizes) = self.pending.pop_front().unwrap();
        let (grouped, mut each) = all.split_at(queries);
        for (&count, size) in grouped.iter().zip(sizes) {
            let (members, rest) = each.split_at(size as usize);
            each = rest;
            self.groups += usize::from(size > 1 && count == 0);
            self.wrong += usize::from(count == 0 && members.iter().any(|&m| m > 0));
        }
        counts.extend(grouped);
        Ok(())
    }

    fn end(&mut self) -> Result<(), OcclusionError> {
        self.inner.end()
    }
}
