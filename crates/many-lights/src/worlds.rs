//! Small worlds made from a few numbers: for tests, benches and sweeps.
//!
//! Receivers are rectangles, so that what a pixel shows is found without a tracer; the same
//! rectangles come as a scene, so that shadow rays can be traced against them.

use crate::{Emission, Eye, Frame, Light, LightsError, Point, World, sample::Random};
use dapple_scene::{Camera, CameraPath, Instance, Material, Mesh, Projection, Scene};
use dapple_trace::Tracer;
use glam::{DAffine3, DVec3, Vec3};
use std::sync::Arc;

/// Distances below this count as this in all worlds made here, metres.
pub const CLAMP_M: f64 = 0.1;

/// A window's cone: linear, 45 degrees to each side.
pub const WINDOW: Emission = Emission::Spot { half_angle_rad: std::f64::consts::FRAC_PI_4 };

/// Every kind of emission, alone and all together.
pub fn emissions() -> Vec<Vec<Emission>> {
    let wide = Emission::Spot { half_angle_rad: std::f64::consts::PI };
    vec![
        vec![Emission::Omni],
        vec![Emission::Oriented],
        vec![WINDOW],
        vec![Emission::Directional],
        vec![Emission::Omni, Emission::Oriented, WINDOW, Emission::Directional, wide],
    ]
}

/// A flat receiver, seen and lit from both sides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rectangle {
    /// One corner, metres, local space.
    pub corner: DVec3,
    /// From that corner along one side.
    pub along: DVec3,
    /// From that corner along the next side, at a right angle to `along`.
    pub up: DVec3,
    /// Diffuse reflectance, linear RGB, each in 0..=1.
    pub albedo: Vec3,
}

/// A world without shadows, and what would cast them.
#[derive(Clone)]
pub struct Made {
    /// Lights and frames; nothing casts shadows.
    pub world: World,
    /// The receivers in world space, with the first camera, and a path where there are more.
    pub scene: Scene,
}

/// Random lights above ground and between walls.
#[derive(Clone, Debug)]
pub struct Cloud {
    /// How many.
    pub lights: u32,
    /// How they emit, in turn; omni where there is none.
    pub emissions: Vec<Emission>,
    /// Of all random numbers.
    pub seed: u32,
    /// Pixels of a frame: columns, rows.
    pub size: [u32; 2],
    /// Frames of a slow walk to the right, at least 1.
    pub frames: u32,
    /// Where it lies in the world.
    pub origin: DVec3,
}

/// A wall lit by the windows of a facade opposite.
#[derive(Clone, Copy, Debug)]
pub struct Facade {
    /// Rows of windows, 3 m each.
    pub storeys: u32,
    /// Windows of a row, 2 m each.
    pub windows: u32,
    /// From the wall to the facade, metres.
    pub distance_m: f64,
    /// How windows emit, towards the wall.
    pub emission: Emission,
    /// Pixels of a frame: columns, rows.
    pub size: [u32; 2],
}

impl Default for Cloud {
    fn default() -> Self {
        Self {
            lights: 100,
            emissions: vec![WINDOW],
            seed: 1,
            size: [40, 30],
            frames: 1,
            origin: DVec3::ZERO,
        }
    }
}

impl Default for Facade {
    /// The wall is as large as the facade, and as far as it is high: the storeys' middles give too
    /// much light by far where a whole storey is replaced by one of them.
    fn default() -> Self {
        Self { storeys: 8, windows: 24, distance_m: 12.0, emission: WINDOW, size: [96, 48] }
    }
}

impl Rectangle {
    fn normal(&self) -> DVec3 {
        self.along.cross(self.up).normalize()
    }

    /// Distance along a ray to the rectangle, where it is met in front of the origin.
    fn meet(&self, origin: DVec3, direction: DVec3) -> Option<f64> {
        let normal = self.normal();
        let t = (self.corner - origin).dot(normal) / direction.dot(normal);
        // Also refuses the infinity and the NaN of a ray along the plane.
        if !(t > 0.0 && t.is_finite()) {
            return None;
        }
        let from_corner = origin + direction * t - self.corner;
        let inside = |side: DVec3| (0.0..=side.length_squared()).contains(&from_corner.dot(side));
        (inside(self.along) && inside(self.up)).then_some(t)
    }
}

/// What a camera sees of rectangles; the camera is in local space.
pub fn frame(rectangles: &[Rectangle], camera: &Camera, [width, height]: [u32; 2]) -> Frame {
    let aspect = f64::from(width) / f64::from(height.max(1));
    let seen = |column: u32, row: u32| {
        let x = (f64::from(column) + 0.5) / f64::from(width);
        let y = (f64::from(row) + 0.5) / f64::from(height);
        let (origin, direction) = camera.ray(x, y, aspect);
        let met = rectangles.iter().enumerate();
        let met = met.filter_map(|(i, r)| Some((r.meet(origin, direction)?, i as u32, r)));
        let Some((t, object, rectangle)) = met.min_by(|a, b| a.0.total_cmp(&b.0)) else {
            return Point::nothing();
        };
        let normal = rectangle.normal();
        let towards_eye = if normal.dot(direction) > 0.0 { -normal } else { normal };
        Point {
            position: (origin + direction * t).as_vec3(),
            object,
            normal: towards_eye.as_vec3(),
            albedo: rectangle.albedo,
            ..Point::default()
        }
    };
    let points = (0..height).flat_map(|row| (0..width).map(move |column| (column, row)));
    let points = points.map(|(column, row)| seen(column, row)).collect();
    Frame { width, height, eye: Eye::new(camera, DVec3::ZERO, aspect), points }
}

/// A world of rectangles and lights, all in local space, as cameras see it.
pub fn made(
    lights: Vec<Light>,
    rectangles: &[Rectangle],
    cameras: &[Camera],
    size: [u32; 2],
    origin: DVec3,
) -> Made {
    let frames = cameras.iter().map(|camera| frame(rectangles, camera, size)).collect();
    let world = World { origin, lights, frames, clamp_m: CLAMP_M, occluders: None };
    let mut scene = Scene { name: "rectangles".into(), ..Scene::default() };
    let mut placed = cameras.iter().map(|camera| Camera {
        position: origin + camera.position,
        target: origin + camera.target,
        ..camera.clone()
    });
    let (first, last) = (placed.next(), placed.next_back());
    scene.cameras.extend(first.clone());
    if let (Some(first), Some(last)) = (first, last) {
        let frames = cameras.len() as u32;
        scene.paths.push(CameraPath { name: "walk".into(), keys: vec![first, last], frames });
    }
    for (index, r) in rectangles.iter().enumerate() {
        let corners = [DVec3::ZERO, r.along, r.along + r.up, r.up];
        scene.materials.push(Material { albedo: r.albedo, ..Material::default() });
        scene.meshes.push(Mesh {
            name: format!("rectangle {index}"),
            positions: corners.map(|c| c.as_vec3()).to_vec(),
            normals: vec![r.normal().as_vec3(); 4],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            material: index as u32,
            ..Mesh::default()
        });
        let transform = DAffine3::from_translation(origin + r.corner);
        scene.instances.push(Instance { mesh: index as u32, transform });
    }
    Made { world, scene }
}

impl Made {
    /// The world with its receivers casting shadows.
    ///
    /// # Errors
    /// Receivers that the tracer refuses.
    pub fn with_shadows(self) -> Result<World, LightsError> {
        let tracer = Tracer::build(&self.scene)
            .map_err(|error| LightsError::value("occluders", error.to_string()))?;
        Ok(World { occluders: Some(Arc::new(tracer)), ..self.world })
    }
}

/// A direction by chance, all alike.
fn direction(random: &mut Random) -> DVec3 {
    let z = 2.0 * f64::from(random.unit()) - 1.0;
    let turn = std::f64::consts::TAU * f64::from(random.unit());
    let r = (1.0 - z * z).max(0.0).sqrt();
    DVec3::new(r * turn.cos(), r * turn.sin(), z).normalize()
}

fn perspective(position: DVec3, target: DVec3) -> Camera {
    Camera {
        name: "eye".into(),
        position,
        target,
        up: DVec3::Y,
        projection: Projection::Perspective { fov_y_rad: 50.0_f64.to_radians() },
    }
}

/// Random lights of unequal strength within 20 m of the middle of a square of ground with a wall
/// behind and two within it; some sky shows. The sum of all intensities does not depend on how many
/// there are, and lights most of what shows to 0.1 - 1.
pub fn cloud(cloud: &Cloud) -> Made {
    let half = 20.0;
    let count = f64::from(cloud.lights.max(1));
    let light = |index: u32| {
        let mut random = Random::new(cloud.seed, 0, index);
        let mut within = |from: f64, to: f64| from + (to - from) * f64::from(random.unit());
        let position = DVec3::new(within(-half, half), within(0.2, 8.0), within(-half, half));
        // Two decades of strength; their mean is 0.99 / ln 100.
        let strength = 10.0_f64.powf(within(-2.0, 0.0)) * (100.0_f64.ln() / 0.99) / count;
        let colour = DVec3::new(within(0.3, 1.0), within(0.3, 1.0), within(0.3, 1.0));
        let turn = index as usize % cloud.emissions.len().max(1);
        let emission = cloud.emissions.get(turn).copied().unwrap_or(Emission::Omni);
        let total = if emission == Emission::Directional { 2.0 } else { 400.0 };
        let intensity = colour * (strength * total);
        Light { position, axis: direction(&mut random), intensity, emission }
    };
    let wall = |x: f64, z: f64, along: DVec3, albedo: [f32; 3]| Rectangle {
        corner: DVec3::new(x, 0.0, z),
        along,
        up: DVec3::Y * 6.0,
        albedo: Vec3::from_array(albedo),
    };
    let rectangles = [
        Rectangle {
            corner: DVec3::new(-half, 0.0, half),
            along: DVec3::X * (2.0 * half),
            up: DVec3::NEG_Z * (2.0 * half),
            albedo: Vec3::splat(0.7),
        },
        wall(-half, -half, DVec3::X * (2.0 * half), [0.6, 0.6, 0.8]),
        wall(-9.0, 2.0, DVec3::new(4.0, 0.0, -8.0), [0.8, 0.3, 0.3]),
        wall(6.0, -8.0, DVec3::new(5.0, 0.0, 4.0), [0.3, 0.7, 0.3]),
    ];
    let cameras: Vec<_> = (0..cloud.frames.max(1))
        .map(|f| DVec3::X * (0.25 * f64::from(f)))
        .map(|step| {
            perspective(DVec3::new(0.0, 7.0, 22.0) + step, DVec3::new(0.0, 2.5, 0.0) + step)
        })
        .collect();
    let lights = (0..cloud.lights).map(light).collect();
    made(lights, &rectangles, &cameras, cloud.size, cloud.origin)
}

/// A wall as large as the facade opposite, seen straight on in parallel, and the path of each window
/// through the facade's hierarchy: its storey, then its place there. All windows are alike, so a
/// storey's representative is its middle, and a point of the wall just opposite has its bound there
/// too: bound and estimate agree, whatever the storey's other windows give.
pub fn facade(facade: &Facade) -> (Made, Vec<Vec<u32>>) {
    let (width, height) = (2.0 * f64::from(facade.windows), 3.0 * f64::from(facade.storeys));
    let window = |storey: u32, place: u32| Light {
        position: DVec3::new(
            2.0 * (f64::from(place) + 0.5) - 0.5 * width,
            3.0 * (f64::from(storey) + 0.5),
            facade.distance_m,
        ),
        axis: DVec3::NEG_Z,
        intensity: DVec3::new(1.0, 0.8, 0.5) * facade.distance_m,
        emission: facade.emission,
    };
    let places = (0..facade.storeys).flat_map(|s| (0..facade.windows).map(move |w| (s, w)));
    let (lights, keys) = places.map(|(s, w)| (window(s, w), vec![s, w])).unzip();
    let standing = |z: f64| Rectangle {
        corner: DVec3::new(-0.5 * width, 0.0, z),
        along: DVec3::X * width,
        up: DVec3::Y * height,
        albedo: Vec3::splat(0.8),
    };
    // The windows stand out a little: what they are in hides none of them.
    let rectangles = [standing(0.0), standing(facade.distance_m + 0.05)];
    let camera = Camera {
        projection: Projection::Orthographic { height_m: height },
        ..perspective(
            DVec3::new(0.0, 0.5 * height, 0.5 * facade.distance_m),
            DVec3::new(0.0, 0.5 * height, 0.0),
        )
    };
    (made(lights, &rectangles, &[camera], facade.size, DVec3::ZERO), keys)
}

/// Lights above a white square of ground, `half_m` from its middle to each side, seen from straight
/// above in parallel: what closed forms are held against.
pub fn plane(lights: Vec<Light>, half_m: f64, size: [u32; 2]) -> Made {
    let ground = Rectangle {
        corner: DVec3::new(-half_m, 0.0, half_m),
        along: DVec3::X * (2.0 * half_m),
        up: DVec3::NEG_Z * (2.0 * half_m),
        albedo: Vec3::ONE,
    };
    let camera = Camera {
        name: "above".into(),
        position: DVec3::Y,
        target: DVec3::ZERO,
        up: DVec3::NEG_Z,
        projection: Projection::Orthographic { height_m: 2.0 * half_m },
    };
    made(lights, &[ground], &[camera], size, DVec3::ZERO)
}
