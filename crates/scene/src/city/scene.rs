//! A city as a scene: one instance an object, and where in the city each object belongs.

use super::{Building, City, GroundKind, rim, templates, windows};
use crate::{AlphaTest, Instance, Light, Material, Mesh, Scene};
use glam::{DAffine3, DMat3, DVec2, DVec3, Vec3};
use std::collections::HashMap;

/// Where an instance belongs: the path that a hierarchy over the city follows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Part {
    /// One storey of one facade.
    Storey {
        /// Index into `City::blocks`.
        block: u32,
        /// Index into `City::buildings`.
        building: u32,
        /// Index into its facades.
        facade: u32,
        /// From 0 at the ground.
        storey: u32,
    },
    /// Roof and gables.
    Roof {
        /// Index into `City::blocks`.
        block: u32,
        /// Index into `City::buildings`.
        building: u32,
    },
    /// What lies flat.
    Ground {
        /// Index into `City::grounds`.
        ground: u32,
    },
    /// A tree: its crown is alpha-tested.
    Tree {
        /// Index into `City::trees`.
        tree: u32,
    },
}

/// A scene and the part that each of its instances is.
#[derive(Clone, Debug)]
pub struct CityScene {
    /// One instance an object. Every storey of every facade is the same mesh, scaled.
    pub scene: Scene,
    /// One an instance.
    pub parts: Vec<Part>,
}

/// What the parts are made of: name and diffuse reflectance, linear RGB.
const MATERIALS: [(&str, [f32; 3]); 7] = [
    ("facade", [0.58, 0.52, 0.46]),
    ("roof", [0.42, 0.36, 0.34]),
    ("street", [0.3, 0.3, 0.31]),
    ("sidewalk", [0.48, 0.47, 0.45]),
    ("land", [0.34, 0.4, 0.3]),
    ("water", [0.3, 0.36, 0.42]),
    ("tree", [0.32, 0.4, 0.3]),
];
const FACADE: u32 = 0;
const ROOF: u32 = 1;
const TREE: u32 = 6;

/// Direction of travel of the moon's light: onto roofs, streets and facades towards +z and -x.
const MOON: DVec3 = DVec3::new(0.45, -1.0, -0.6);

impl CityScene {
    /// Bytes that meshes, textures, instances and parts take.
    pub fn bytes(&self) -> u64 {
        crate::inspect::memory_bytes(&self.scene)
            + (size_of_val(&self.scene.instances[..]) + size_of_val(&self.parts[..])) as u64
    }
}

impl City {
    /// Everything that is drawn: buildings in order, of each its facades storey by storey and its
    /// roof, then grounds and trees. The one light of the scene is a moon; window lights stay with
    /// the city. A city without any triangle gives a scene that does not validate.
    pub fn scene(&self) -> CityScene {
        let mut b = Builder::new(self);
        for (block, range) in self.blocks.iter().enumerate() {
            for building in range.clone() {
                b.building(&self.buildings[building as usize], block as u32, building);
            }
        }
        for (ground, flat) in self.grounds.iter().enumerate() {
            let anchor = flat.triangles.iter().flatten().fold(DVec3::INFINITY, |m, &p| m.min(p));
            let material = match flat.kind {
                GroundKind::Street => 2,
                GroundKind::Sidewalk => 3,
                GroundKind::Land => 4,
                GroundKind::Water => 5,
            };
            b.soup(
                "ground",
                &flat.triangles,
                anchor,
                material,
                Part::Ground { ground: ground as u32 },
            );
        }
        if !self.trees.is_empty() {
            b.trees(self);
        }
        CityScene { scene: b.scene, parts: b.parts }
    }
}

struct Builder {
    scene: Scene,
    parts: Vec<Part>,
    /// Meshes by material and coordinates, so that equal ones are stored once. Only looked up.
    known: HashMap<Vec<u32>, u32>,
}

impl Builder {
    fn new(city: &City) -> Self {
        let material = |(name, albedo): (&str, [f32; 3])| Material {
            name: name.into(),
            albedo: Vec3::from_array(albedo),
            ..Material::default()
        };
        let scene = Scene {
            name: city.name.clone(),
            meshes: vec![Mesh { material: FACADE, ..templates::storey() }],
            materials: MATERIALS.map(material).into(),
            lights: vec![Light::Directional { direction: MOON.normalize() }],
            cameras: city.cameras.clone(),
            paths: city.paths.clone(),
            ..Scene::default()
        };
        Self { scene, parts: vec![], known: HashMap::new() }
    }

    fn place(&mut self, mesh: u32, transform: DAffine3, part: Part) {
        self.scene.instances.push(Instance { mesh, transform });
        self.parts.push(part);
    }

    fn building(&mut self, building: &Building, block: u32, index: u32) {
        let storeys = building.storeys.max(1);
        let storey_m = (building.eaves_m - building.base_m) / f64::from(storeys);
        let [width, height] = templates::STOREY.map(f64::from);
        for (f, facade) in building.facades.iter().enumerate() {
            let normal = windows::outward(facade);
            let along = (facade.to - facade.from) / width + DVec2::ZERO;
            let matrix3 = DMat3::from_cols(
                DVec3::new(along.x, 0.0, along.y),
                DVec3::new(0.0, storey_m / height, 0.0),
                DVec3::new(normal.x, 0.0, normal.y),
            );
            // A wall without an area shows nothing and could not be placed.
            if matrix3.determinant() <= 0.0 {
                continue;
            }
            for storey in 0..storeys {
                let y = building.base_m + f64::from(storey) * storey_m;
                let translation = DVec3::new(facade.from.x, y, facade.from.y);
                let part = Part::Storey { block, building: index, facade: f as u32, storey };
                self.place(0, DAffine3 { matrix3, translation }, part);
            }
        }
        let mut roof = rim::cut(&building.roof, &building.facades, building.eaves_m);
        roof.extend(rim::cut(&building.gables, &building.facades, building.eaves_m));
        let anchor = DVec3::new(building.outer.min.x, building.eaves_m, building.outer.min.z);
        self.soup("roof", &roof, anchor, ROOF, Part::Roof { block, building: index });
    }

    /// Places triangles, relative to `anchor`; nothing for none. Coordinates near the anchor keep
    /// their detail, and shapes that differ in their place alone are one mesh.
    fn soup(
        &mut self,
        name: &str,
        triangles: &[[DVec3; 3]],
        anchor: DVec3,
        material: u32,
        part: Part,
    ) {
        if triangles.is_empty() {
            return;
        }
        let mut mesh = Mesh { name: name.into(), material, ..Mesh::default() };
        let mut corners: HashMap<[u32; 6], u32> = HashMap::new();
        for &[a, b, c] in triangles {
            let normal = (b - a).cross(c - a).normalize_or(DVec3::Y).as_vec3();
            mesh.triangles.push([a, b, c].map(|p| {
                let p = (p - anchor).as_vec3();
                let bits = [p, normal].map(|v| v.to_array().map(f32::to_bits));
                let key = std::array::from_fn(|i| bits[i / 3][i % 3]);
                *corners.entry(key).or_insert_with(|| {
                    mesh.positions.push(p);
                    mesh.normals.push(normal);
                    mesh.positions.len() as u32 - 1
                })
            }));
        }
        let numbers = mesh.positions.iter().flat_map(|p| p.to_array().map(f32::to_bits));
        let key = [material, mesh.positions.len() as u32]
            .into_iter()
            .chain(numbers)
            .chain(mesh.triangles.iter().flatten().copied())
            .collect();
        let next = self.scene.meshes.len() as u32;
        let index = *self.known.entry(key).or_insert(next);
        if index == next {
            self.scene.meshes.push(mesh);
        }
        self.place(index, DAffine3::from_translation(anchor), part);
    }

    fn trees(&mut self, city: &City) {
        let texture = self.scene.textures.len() as u32;
        self.scene.textures.push(templates::foliage());
        let material = &mut self.scene.materials[TREE as usize];
        material.alpha_test = Some(AlphaTest { texture, cutoff: 0.5 });
        material.albedo_texture = Some(texture);
        let mesh = self.scene.meshes.len() as u32;
        self.scene.meshes.push(Mesh { material: TREE, ..templates::tree() });
        for (index, tree) in city.trees.iter().enumerate() {
            let scale = DVec3::new(tree.crown_radius_m, tree.height_m, tree.crown_radius_m);
            if scale.min_element() <= 0.0 {
                continue;
            }
            let transform =
                DAffine3 { matrix3: DMat3::from_diagonal(scale), translation: tree.position };
            self.place(mesh, transform, Part::Tree { tree: index as u32 });
        }
    }
}
