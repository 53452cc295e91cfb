//! The scene's data, plain and public.

use glam::{DAffine3, DVec3, Vec2, Vec3};

/// Everything a case is rendered from. Indices refer to the vectors of the same scene.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// Name shown in tables: a generator's name or a file stem.
    pub name: String,
    /// Triangle meshes, each of one material.
    pub meshes: Vec<Mesh>,
    /// Materials.
    pub materials: Vec<Material>,
    /// RGBA textures.
    pub textures: Vec<Texture>,
    /// Placements of meshes in the world.
    pub instances: Vec<Instance>,
    /// Light sources.
    pub lights: Vec<Light>,
    /// Named still views.
    pub cameras: Vec<Camera>,
    /// Camera paths.
    pub paths: Vec<CameraPath>,
}

/// Indexed triangles of one material, in mesh space.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// Name from the file, or the generator's.
    pub name: String,
    /// Vertex positions, metres, mesh space.
    pub positions: Vec<Vec3>,
    /// Vertex normals, unit length; empty or one a vertex.
    pub normals: Vec<Vec3>,
    /// Texture coordinates, origin top left; empty or one a vertex.
    pub uvs: Vec<Vec2>,
    /// Vertex indices, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Index into [`Scene::materials`].
    pub material: u32,
}

/// How a surface looks and what it lets through.
#[derive(Clone, Debug)]
pub struct Material {
    /// Name from the file.
    pub name: String,
    /// Diffuse reflectance, linear RGB in 0..=1.
    pub albedo: Vec3,
    /// 1 = opaque, 0 = invisible.
    pub opacity: f32,
    /// Cut-out by a texture's alpha channel, or none.
    pub alpha_test: Option<AlphaTest>,
    /// Index of the colour texture, or none.
    pub albedo_texture: Option<u32>,
}

impl Default for Material {
    fn default() -> Self {
        Self {
            name: "default".into(),
            albedo: Vec3::splat(0.7),
            opacity: 1.0,
            alpha_test: None,
            albedo_texture: None,
        }
    }
}

/// A point of a surface is there when the texture's alpha at its uv is at least `cutoff`.
/// The texture is sampled at the nearest texel and repeats outside 0..1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AlphaTest {
    /// Index into [`Scene::textures`]; its alpha channel is used.
    pub texture: u32,
    /// Threshold in 0..=1.
    pub cutoff: f32,
}

/// An RGBA image, 8 bits a channel, sRGB colour and linear alpha, rows top to bottom.
#[derive(Clone, Debug, Default)]
pub struct Texture {
    /// Name from the file.
    pub name: String,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// `width * height` texels.
    pub texels: Vec<[u8; 4]>,
}

impl Texture {
    /// Alpha in 0..=1 of the texel nearest to `uv` (repeating). 1 for an empty texture.
    pub fn alpha_nearest(&self, uv: Vec2) -> f32 {
        if self.texels.is_empty() {
            return 1.0;
        }
        let wrap = |t: f32, n: u32| (((t - t.floor()) * n as f32) as u32).min(n - 1) as usize;
        let (x, y) = (wrap(uv.x, self.width), wrap(uv.y, self.height));
        f32::from(self.texels[y * self.width as usize + x][3]) / 255.0
    }
}

/// One placement of a mesh.
#[derive(Clone, Copy, Debug)]
pub struct Instance {
    /// Index into [`Scene::meshes`].
    pub mesh: u32,
    /// Mesh space to world space, `f64` so that far origins keep their detail.
    pub transform: DAffine3,
}

/// A light source. Directions need not be unit length.
#[derive(Clone, Copy, Debug)]
pub enum Light {
    /// Parallel light travelling along `direction`.
    Directional {
        /// Direction of travel, world space.
        direction: DVec3,
    },
    /// A point that lights a cone.
    Spot {
        /// World space, metres.
        position: DVec3,
        /// Axis of the cone.
        direction: DVec3,
        /// Half the opening angle, radians, in (0, π/2).
        half_angle_rad: f64,
    },
    /// A parallelogram, lit on both sides.
    Area {
        /// Centre, world space, metres.
        centre: DVec3,
        /// From the centre to the middle of one side.
        half_u: DVec3,
        /// From the centre to the middle of the next side.
        half_v: DVec3,
    },
}

/// A still view.
#[derive(Clone, Debug)]
pub struct Camera {
    /// Name shown in tables.
    pub name: String,
    /// World space, metres.
    pub position: DVec3,
    /// A point on the view axis.
    pub target: DVec3,
    /// Up, not parallel to the view axis.
    pub up: DVec3,
    /// How directions meet the image.
    pub projection: Projection,
}

/// How a camera's rays leave it.
#[derive(Clone, Copy, Debug)]
pub enum Projection {
    /// Rays through one point.
    Perspective {
        /// Full vertical opening, radians.
        fov_y_rad: f64,
    },
    /// Parallel rays.
    Orthographic {
        /// Height of the image in metres.
        height_m: f64,
    },
}

impl Camera {
    /// Origin and unit direction of the ray through image point (`x`, `y`), each in 0..=1 with
    /// the origin top left. `aspect` is width over height.
    pub fn ray(&self, x: f64, y: f64, aspect: f64) -> (DVec3, DVec3) {
        let forward = (self.target - self.position).normalize();
        let right = forward.cross(self.up).normalize();
        let up = right.cross(forward);
        let (sx, sy) = (2.0 * x - 1.0, 1.0 - 2.0 * y);
        match self.projection {
            Projection::Perspective { fov_y_rad } => {
                let t = (0.5 * fov_y_rad).tan();
                let d = forward + right * (sx * t * aspect) + up * (sy * t);
                (self.position, d.normalize())
            }
            Projection::Orthographic { height_m } => {
                let h = 0.5 * height_m;
                (self.position + right * (sx * h * aspect) + up * (sy * h), forward)
            }
        }
    }
}

/// Cameras in order; frames lie evenly along the sequence, interpolated linearly between keys.
#[derive(Clone, Debug)]
pub struct CameraPath {
    /// Name shown in tables.
    pub name: String,
    /// At least one key.
    pub keys: Vec<Camera>,
    /// Number of frames, at least one.
    pub frames: u32,
}

/// An axis-aligned box in `f64`; empty when `min > max`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    /// Lower corner.
    pub min: DVec3,
    /// Upper corner.
    pub max: DVec3,
}

impl Aabb {
    /// The box of nothing.
    pub const EMPTY: Self = Self { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY };

    /// The smallest box holding this one and `p`.
    #[must_use]
    pub fn grow(self, p: DVec3) -> Self {
        Self { min: self.min.min(p), max: self.max.max(p) }
    }

    /// Whether nothing is inside.
    pub fn is_empty(&self) -> bool {
        self.min.x > self.max.x
    }

    /// Middle of the box.
    pub fn centre(&self) -> DVec3 {
        0.5 * (self.min + self.max)
    }

    /// Half the diagonal, metres.
    pub fn radius(&self) -> f64 {
        0.5 * (self.max - self.min).length()
    }

    /// The eight corners.
    pub fn corners(&self) -> [DVec3; 8] {
        std::array::from_fn(|i| {
            let pick = |bit: usize, lo: f64, hi: f64| if i >> bit & 1 == 0 { lo } else { hi };
            DVec3::new(
                pick(0, self.min.x, self.max.x),
                pick(1, self.min.y, self.max.y),
                pick(2, self.min.z, self.max.z),
            )
        })
    }
}

impl Scene {
    /// World-space bounds of everything placed.
    pub fn bounds(&self) -> Aabb {
        let mut bounds = Aabb::EMPTY;
        for [a, b, c] in self.world_triangles().map(|t| t.1) {
            bounds = bounds.grow(a).grow(b).grow(c);
        }
        bounds
    }

    /// Placed triangles.
    pub fn triangle_count(&self) -> usize {
        self.instances.iter().map(|i| self.meshes[i.mesh as usize].triangles.len()).sum()
    }

    /// Every placed triangle in world space: ((instance, triangle of its mesh), corners), instance
    /// by instance. Equal vertices of one instance give bit-equal corners.
    pub fn world_triangles(&self) -> impl Iterator<Item = ((u32, u32), [DVec3; 3])> + '_ {
        self.instances.iter().enumerate().flat_map(move |(i, instance)| {
            let mesh = &self.meshes[instance.mesh as usize];
            mesh.triangles.iter().enumerate().map(move |(t, tri)| {
                let corner = |k: usize| {
                    instance.transform.transform_point3(mesh.positions[tri[k] as usize].as_dvec3())
                };
                ((i as u32, t as u32), [corner(0), corner(1), corner(2)])
            })
        })
    }
}
