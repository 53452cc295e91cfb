//! Scenes of squares and cubes, seen from the origin along -z.

use dapple_scene::{
    AlphaTest, Camera, CameraPath, Instance, Light, Material, Mesh, Projection, Scene, Texture,
};
use glam::{DAffine3, DQuat, DVec3, Vec2, Vec3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

/// Vertical opening of the cameras, radians.
const OPENING_RAD: f64 = std::f64::consts::FRAC_PI_3;

/// A scene that instances are put into one by one.
pub struct Made(Scene);

const SQUARE: u32 = 0;
/// Mesh of the cubes.
pub const CUBE: u32 = 1;
const SCREEN: u32 = 2;

impl Made {
    /// An empty one, seen from each of the positions in turn, along -z.
    pub fn seen_from(name: &str, positions: &[DVec3]) -> Self {
        let key = |position: &DVec3| Camera {
            name: "ahead".into(),
            position: *position,
            target: *position - DVec3::Z,
            up: DVec3::Y,
            projection: Projection::Perspective { fov_y_rad: OPENING_RAD },
        };
        let keys: Vec<Camera> = positions.iter().map(key).collect();
        let cut = AlphaTest { texture: 0, cutoff: 0.5 };
        let screen =
            Material { name: "screen".into(), alpha_test: Some(cut), ..Material::default() };
        Self(Scene {
            name: name.into(),
            meshes: vec![square(0), cube(), square(1)],
            materials: vec![Material::default(), screen],
            textures: vec![Texture {
                name: "holes".into(),
                width: 1,
                height: 1,
                texels: vec![[255; 4]],
            }],
            lights: vec![Light::Directional { direction: DVec3::NEG_Y }],
            cameras: keys.first().cloned().into_iter().collect(),
            paths: vec![CameraPath { name: "made".into(), frames: keys.len() as u32, keys }],
            ..Scene::default()
        })
    }

    /// A square that faces z, `half` to each side of its middle, turned about its middle by `turn`.
    pub fn square(&mut self, middle: DVec3, half: DVec3, turn: DQuat) {
        self.place(SQUARE, middle, half, turn);
    }

    /// A cube, `half` to each side of its middle.
    pub fn cube(&mut self, middle: DVec3, half: DVec3) {
        self.place(CUBE, middle, half, DQuat::IDENTITY);
    }

    /// An alpha-tested square that faces z, with random holes: of its `side` x `side` texels that
    /// share is not there.
    pub fn screen(&mut self, middle: DVec3, half: f64, side: u32, holes: f64, seed: u64) {
        let mut rng = Pcg64::seed_from_u64(seed);
        let texel = |_| [200, 200, 200, if rng.random::<f64>() < holes { 0 } else { 255 }];
        let texels = (0..side * side).map(texel).collect();
        self.0.textures = vec![Texture { name: "holes".into(), width: side, height: side, texels }];
        self.place(SCREEN, middle, DVec3::splat(half), DQuat::IDENTITY);
    }

    fn place(&mut self, mesh: u32, middle: DVec3, half: DVec3, turn: DQuat) {
        let transform = DAffine3::from_scale_rotation_translation(half, turn, middle);
        self.0.instances.push(Instance { mesh, transform });
    }

    /// Cubes strewn over a box before a wall that ends the view, as large as their number leaves room
    /// for.
    pub fn cubes(&mut self, count: u32, seed: u64) {
        let mut rng = Pcg64::seed_from_u64(seed);
        let (low, high) = (DVec3::new(-8.0, -5.0, -16.0), DVec3::new(8.0, 5.0, -2.0));
        let room = (high - low).element_product() / f64::from(count.max(1));
        let half = DVec3::splat(0.2 * room.cbrt());
        for _ in 0..count {
            let share = DVec3::new(rng.random(), rng.random(), rng.random());
            self.cube(low + (high - low) * share, half);
        }
        self.square(DVec3::new(0.0, 0.0, -17.0), DVec3::splat(40.0), DQuat::IDENTITY);
    }

    /// What was made.
    pub fn scene(self) -> Scene {
        self.0
    }
}

/// Cubes before a wall, seen by a camera that walks sideways and turns back.
pub fn field(count: u32, seed: u64) -> Scene {
    let walk = [0.0, 0.1, 0.2, 0.6, 0.0].map(|x| DVec3::new(x, 0.0, 0.0));
    let mut made = Made::seen_from("field", &walk);
    made.cubes(count, seed);
    made.scene()
}

/// Side of a pixel at distance 1 before the cameras of [`Made`].
pub fn pixel(width: u32) -> f64 {
    let height = (width * 9 / 16).max(1);
    2.0 * (0.5 * OPENING_RAD).tan() / f64::from(height)
}

fn square(material: u32) -> Mesh {
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    Mesh {
        name: "square".into(),
        positions: corners.map(|(x, y)| Vec3::new(x, y, 0.0)).to_vec(),
        uvs: corners.map(|(x, y)| Vec2::new(0.5 + 0.5 * x, 0.5 - 0.5 * y)).to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        material,
        ..Mesh::default()
    }
}

fn cube() -> Mesh {
    let corner = |i: u32| {
        let side = |bit: u32| if i >> bit & 1 == 0 { -1.0 } else { 1.0 };
        Vec3::new(side(0), side(1), side(2))
    };
    let sides =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    Mesh {
        name: "cube".into(),
        positions: (0..8).map(corner).collect(),
        triangles: sides.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect(),
        ..Mesh::default()
    }
}
