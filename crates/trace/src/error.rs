//! Why a scene cannot be traced.

/// What is wrong with a scene, naming the element and the limit.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TraceError {
    /// An instance places a mesh that is not there.
    #[error("instance {instance} places mesh {mesh}, but the scene has {meshes} meshes")]
    InstanceMesh {
        /// Index of the instance.
        instance: usize,
        /// The index it holds.
        mesh: u32,
        /// Number of meshes.
        meshes: usize,
    },
    /// A mesh names a material that is not there.
    #[error("mesh {mesh} has material {material}, but the scene has {materials} materials")]
    MeshMaterial {
        /// Index of the mesh.
        mesh: usize,
        /// The index it holds.
        material: u32,
        /// Number of materials.
        materials: usize,
    },
    /// A triangle names a vertex that is not there.
    #[error("mesh {mesh}, triangle {triangle}: vertex {vertex} of {vertices}")]
    VertexIndex {
        /// Index of the mesh.
        mesh: usize,
        /// Index of the triangle in it.
        triangle: usize,
        /// The index it holds.
        vertex: u32,
        /// Number of positions.
        vertices: usize,
    },
    /// Texture coordinates are neither absent nor one a vertex.
    #[error("mesh {mesh} has {uvs} texture coordinates for {vertices} vertices")]
    UvCount {
        /// Index of the mesh.
        mesh: usize,
        /// Number of texture coordinates.
        uvs: usize,
        /// Number of positions.
        vertices: usize,
    },
    /// An alpha test names a texture that is not there.
    #[error("material {material} tests texture {texture}, but the scene has {textures} textures")]
    AlphaTexture {
        /// Index of the material.
        material: usize,
        /// The index it holds.
        texture: u32,
        /// Number of textures.
        textures: usize,
    },
    /// A texture's texels do not fill its size.
    #[error("texture {texture} has {texels} texels for {width} x {height}")]
    TexelCount {
        /// Index of the texture.
        texture: usize,
        /// Number of texels.
        texels: usize,
        /// Columns.
        width: u32,
        /// Rows.
        height: u32,
    },
    /// A corner in world space is infinite or not a number.
    #[error("instance {instance}, triangle {triangle}: a corner is not finite")]
    NonFinite {
        /// Index of the instance.
        instance: u32,
        /// Index of the triangle in its mesh.
        triangle: u32,
    },
    /// The scene is wider than `f64` arithmetic on it allows.
    #[error("the scene is {extent_m:e} m wide; the limit is 1e300 m")]
    TooLarge {
        /// Longest side of the bounds, metres.
        extent_m: f64,
    },
    /// More triangles than the tree can index.
    #[error("{count} placed triangles; the limit is {limit}")]
    TooMany {
        /// Placed triangles.
        count: usize,
        /// The limit.
        limit: usize,
    },
    /// An opacity that is none.
    #[error("material {material}: opacity {opacity} is outside 0..=1")]
    Opacity {
        /// Index of the material.
        material: usize,
        /// The number it holds.
        opacity: f32,
    },
    /// A map or an image that is too large.
    #[error("{width} x {height} texels; the limit is {limit} a side")]
    MapSize {
        /// Columns.
        width: u32,
        /// Rows.
        height: u32,
        /// The limit.
        limit: u32,
    },
    /// A light that meets more than there is room for.
    #[error("the light's map has more than {limit} fragments; take a smaller map")]
    Fragments {
        /// The limit.
        limit: usize,
    },
    /// A ball that is no volume.
    #[error(
        "ball {ball}: centre {centre}, radius {radius} m, extinction {extinction} per m; all must \
         be finite, the radius positive, the extinction not negative"
    )]
    Ball {
        /// Index of the ball.
        ball: usize,
        /// World space, metres.
        centre: glam::DVec3,
        /// Metres.
        radius: f64,
        /// Per metre.
        extinction: f64,
    },
    /// A grid without voxels or with too many.
    #[error("{along} voxels along the longest side make {count}; 1 to {limit} are possible")]
    Voxels {
        /// Voxels along the longest side.
        along: u32,
        /// All voxels.
        count: u64,
        /// The limit.
        limit: u64,
    },
    /// Alpha tests where there is no place for them.
    #[error("{triangles} triangles have an alpha test, which the tree in f32 has no place for")]
    CutOut {
        /// How many.
        triangles: usize,
    },
    /// A corner so far away that f32 arithmetic on it overflows.
    #[error("a corner lies {farthest_m:e} m from the origin; the limit in f32 is 1e12 m")]
    Flat {
        /// The farthest found, metres along an axis.
        farthest_m: f64,
    },
}
