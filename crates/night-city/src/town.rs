//! What frames are made from, found once.

use crate::{NightError, Part, Surfaces};
use dapple_many_lights::{Eye, Frame, LightTree, Point, World, region::Occluders};
use dapple_occlusion::camera::{Objects, Tree, View};
use dapple_scene::{Camera, Scene, city};
use dapple_trace::{Ray, Tracer};
use glam::Vec3;
use rayon::prelude::*;
use std::sync::{Arc, OnceLock};

/// A city with its lights, as frames of it are made from. Everything local is relative to
/// [`Objects::origin`], which is [`World::origin`] too.
pub struct Town {
    /// What is drawn.
    pub objects: Arc<Objects>,
    /// The hierarchy over it.
    pub tree: Arc<Tree>,
    /// Surfaces of every object.
    pub surfaces: Surfaces,
    /// One a frame.
    pub views: Vec<View>,
    /// Of the world's lights.
    pub lights: Arc<LightTree>,
    /// What hides them from regions.
    pub occluders: Arc<Occluders>,
    /// What casts shadows.
    pub tracer: Arc<Tracer>,
    /// Keys that all objects below a node of the tree share.
    levels: Vec<u32>,
    /// Keys down to a building, a facade and a storey.
    lengths: [u32; 3],
    world: Arc<World>,
    shadowed: OnceLock<Arc<World>>,
}

/// What a town is made from.
pub struct Given<'a> {
    /// What is drawn.
    pub objects: Arc<Objects>,
    /// Path of each object through the city, as `city_keys` of `dapple-occlusion` gives it.
    pub keys: &'a [Vec<u32>],
    /// What its instances are.
    pub parts: &'a [city::Part],
    /// The scene that they are objects of.
    pub scene: &'a Scene,
    /// Object of each placed triangle.
    pub owners: &'a [[u32; 2]],
    /// One a frame of the world.
    pub views: Vec<View>,
    /// Lights, and what every frame shows: its points' objects are those of `objects`.
    pub world: World,
    /// Of the world's lights.
    pub lights: Arc<LightTree>,
    /// What hides them from regions.
    pub occluders: Arc<Occluders>,
    /// What casts shadows.
    pub tracer: Arc<Tracer>,
}

impl Town {
    /// Builds the hierarchy and finds the surfaces. Points that show the back of a surface are given
    /// to no object.
    ///
    /// # Errors
    /// Another number of views than frames, another origin than the objects', keys that are not one an
    /// object, a tree of other lights, or a world that is refused.
    pub fn new(given: Given<'_>) -> Result<Self, NightError> {
        let Given { objects, keys, parts, scene, owners, views, mut world, lights, .. } = given;
        let Given { occluders, tracer, .. } = given;
        world.check()?;
        if views.len() != world.frames.len() {
            let limit = format!("{}, where there are {} frames", views.len(), world.frames.len());
            return Err(NightError::value("views", limit));
        }
        if world.origin != objects.origin {
            let limit = format!("{} m, where the objects' is {}", world.origin, objects.origin);
            return Err(NightError::value("origin of the world", limit));
        }
        if lights.leaves.len() != world.lights.len() {
            let limit =
                format!("of {}, where there are {}", lights.leaves.len(), world.lights.len());
            return Err(NightError::value("tree of lights", limit));
        }
        let tree = Tree::by_keys(&objects, keys)?;
        let surfaces = Surfaces::of(scene, &objects, owners);
        for frame in &mut world.frames {
            surfaces.release_backs(frame);
        }
        world.occluders = None;
        Ok(Self {
            levels: tree.path_lengths(keys)?,
            lengths: lengths(keys, parts, scene, owners),
            tree: Arc::new(tree),
            objects,
            surfaces,
            views,
            lights,
            occluders,
            tracer,
            world: Arc::new(world),
            shadowed: OnceLock::new(),
        })
    }

    /// Lights and frames, with what casts shadows or without.
    pub fn world(&self, shadows: bool) -> &Arc<World> {
        if !shadows {
            return &self.world;
        }
        self.shadowed.get_or_init(|| {
            let occluders = Some(Arc::clone(&self.tracer));
            Arc::new(World { occluders, ..(*self.world).clone() })
        })
    }

    /// The same with what casts shadows, and without frames: for single points.
    pub fn lit(&self) -> World {
        let World { origin, ref lights, clamp_m, .. } = *self.world;
        let occluders = Some(Arc::clone(&self.tracer));
        World { origin, lights: lights.clone(), frames: Vec::new(), clamp_m, occluders }
    }

    /// Columns and rows of a frame; none of one that there is not.
    pub fn size(&self, frame: usize) -> [u32; 2] {
        self.world.frames.get(frame).map_or([0; 2], |frame| [frame.width, frame.height])
    }

    /// As `view_cells` of `dapple-occlusion` takes them.
    pub fn levels(&self) -> &[u32] {
        &self.levels
    }

    /// The level at which cells are no longer divided.
    pub fn most_level(&self, split: Part) -> u32 {
        let [building, facade, storey] = self.lengths;
        match split {
            Part::Building => building,
            Part::Facade => facade,
            Part::Storey => storey,
            Part::Any => u32::MAX,
        }
    }

    /// Bytes of hierarchy and surfaces.
    pub fn bytes(&self) -> u64 {
        let tree = size_of_val(&self.tree.nodes[..]) + size_of_val(&self.tree.objects[..]);
        (tree + size_of_val(&self.levels[..])) as u64 + self.surfaces.bytes()
    }
}

/// Keys down to a building, a facade and a storey: those of a storey end with what is below it. No
/// level at all where there is none.
fn lengths(
    keys: &[Vec<u32>],
    parts: &[city::Part],
    scene: &Scene,
    owners: &[[u32; 2]],
) -> [u32; 3] {
    let is_storey = |part: Option<&city::Part>| matches!(part, Some(city::Part::Storey { .. }));
    let mut placed = scene.world_triangles().map(|((instance, _), _)| instance).zip(owners);
    let storey = placed.find(|(instance, _)| is_storey(parts.get(*instance as usize)));
    let length = storey.and_then(|(_, [object, _])| keys.get(*object as usize)).map(Vec::len);
    // Building, which kind of part, facade, storey, object.
    match length {
        Some(length) => [4, 2, 1].map(|below| (length as u32).saturating_sub(below)),
        None => [u32::MAX; 3],
    }
}

/// What every pixel's centre shows, by rays; objects are the owners of the triangles that they meet.
pub fn frame(
    scene: &Scene,
    tracer: &Tracer,
    objects: &Objects,
    owners: &[[u32; 2]],
    camera: &Camera,
    [width, height]: [u32; 2],
) -> Frame {
    let aspect = f64::from(width) / f64::from(height.max(1));
    let point = |pixel: u32| {
        let x = (f64::from(pixel % width) + 0.5) / f64::from(width);
        let y = (f64::from(pixel / width) + 0.5) / f64::from(height);
        let (from, direction) = camera.ray(x, y, aspect);
        let ray = Ray::new(from, direction);
        let Some(hit) = tracer.closest(&ray) else { return Point::nothing() };
        let surface = tracer.surface(&ray, &hit);
        let albedo = scene.materials.get(surface.material as usize).map_or(Vec3::ONE, |m| m.albedo);
        Point {
            position: (surface.position - objects.origin).as_vec3(),
            object: owners.get(hit.triangle as usize).map_or(u32::MAX - 1, |owner| owner[0]),
            normal: surface.normal.as_vec3(),
            albedo,
            ..Point::default()
        }
    };
    let points = (0..width * height).into_par_iter().map(point).collect();
    Frame { width, height, eye: Eye::new(camera, objects.origin, aspect), points }
}
