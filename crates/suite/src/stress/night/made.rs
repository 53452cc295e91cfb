//! Small cities of upright boxes.

use crate::SuiteError;
use dapple_scene::{
    Aabb, Camera, CameraPath, Projection,
    city::{
        Building, City, Facade, Footprint, Ground, GroundKind, OrientedBox, StreetLamp, windows,
    },
};
use glam::{DVec2, DVec3, Vec3};

/// A city that buildings are put into one by one.
pub struct Made(City);

/// Height of a storey, about.
const STOREY_M: f64 = 3.0;

impl Made {
    /// An empty one, seen from each place in turn towards the other.
    pub fn seen(name: &str, path: &[[DVec3; 2]]) -> Self {
        let key = |[position, target]: &[DVec3; 2]| Camera {
            name: "made".into(),
            position: *position,
            target: *target,
            up: DVec3::Y,
            projection: Projection::Perspective { fov_y_rad: std::f64::consts::FRAC_PI_3 },
        };
        let keys: Vec<Camera> = path.iter().map(key).collect();
        Self(City {
            name: name.into(),
            paths: vec![CameraPath { name: "made".into(), frames: keys.len() as u32, keys }],
            ..City::default()
        })
    }

    /// A square of land, `half_m` to each side of the origin.
    pub fn ground(mut self, half_m: f64) -> Self {
        let corner = |x: f64, z: f64| DVec3::new(x * half_m, 0.0, z * half_m);
        let [a, b, c, d] =
            [corner(-1.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0), corner(-1.0, -1.0)];
        let triangles = vec![[a, b, c], [a, c, d]];
        self.0.grounds.push(Ground { kind: GroundKind::Land, triangles });
        self
    }

    /// A building whose walls are lit but those that it shares: towards +z, +x, -z, -x.
    pub fn building(&mut self, min: DVec3, max: DVec3, party: [bool; 4]) {
        let plan = |x: f64, z: f64| DVec2::new(x, z);
        let ring = [plan(min.x, max.z), plan(max.x, max.z), plan(max.x, min.z), plan(min.x, min.z)];
        let facade = |i: usize| Facade { from: ring[i], to: ring[(i + 1) % 4], party: party[i] };
        let [a, b, c, d] = ring.map(|p| DVec3::new(p.x, max.y, p.y));
        self.0.buildings.push(Building {
            id: format!("building {}", self.0.buildings.len()),
            footprint: Footprint { outer: ring.into(), holes: Vec::new() },
            base_m: min.y,
            eaves_m: max.y,
            storeys: ((max.y - min.y) / STOREY_M).round().clamp(1.0, 20.0) as u32,
            facades: (0..4).map(facade).collect(),
            roof: vec![[a, b, c], [a, c, d]],
            gables: Vec::new(),
            outer: Aabb { min, max },
            inner: vec![OrientedBox {
                centre: 0.5 * (min + max),
                axis: DVec2::X,
                half: 0.5 * (max - min),
            }],
        });
    }

    /// A building without any lit window.
    pub fn wall(&mut self, min: DVec3, max: DVec3) {
        self.building(min, max, [true; 4]);
    }

    /// Houses along x from a corner: all as wide and deep, each of its own height and moved towards -z
    /// by its own length, with gaps between them. Those that touch share a wall.
    pub fn row(&mut self, from: DVec3, [width, depth, gap]: [f64; 3], houses: &[[f64; 2]]) {
        let last = houses.len().saturating_sub(1);
        for (i, &[height, back]) in houses.iter().enumerate() {
            let min = from + DVec3::new(i as f64 * (width + gap), 0.0, -back);
            let max = min + DVec3::new(width, height, depth);
            let touches = gap == 0.0;
            self.building(min, max, [false, touches && i < last, false, touches && i > 0]);
        }
    }

    /// A street lamp.
    pub fn lamp(&mut self, position: DVec3, intensity: Vec3) {
        self.0.lamps.push(StreetLamp { position, intensity });
    }

    /// What was made, with three lights a storey of each wall that is not shared.
    pub fn city(self, seed: u64) -> Result<City, SuiteError> {
        let mut city = self.0;
        let all = 0..city.buildings.len() as u32;
        city.blocks.push(all);
        windows::light(&mut city, windows::LIGHTS_PER_STOREY, seed)?;
        Ok(city)
    }
}

/// A walk along a street, its row of houses ahead and to one side.
pub const WALK: [[DVec3; 2]; 2] = [
    [DVec3::new(-12.0, 1.7, 8.0), DVec3::new(4.0, 4.0, 0.0)],
    [DVec3::new(-11.0, 1.7, 8.0), DVec3::new(5.0, 4.0, 0.0)],
];

/// Heights of a row of houses, all in one plane.
pub const HOUSES: [[f64; 2]; 4] = [[9.0, 0.0], [6.0, 0.0], [12.0, 0.0], [9.0, 0.0]];

/// Width and depth of houses, which touch.
pub const LOT: [f64; 3] = [10.0, 10.0, 0.0];

/// Four rows of houses, with a street between the second and the third: the second faces it at z = 0.
pub fn street(path: &[[DVec3; 2]]) -> Made {
    let mut made = others(path);
    made.row(DVec3::new(-20.0, 0.0, -10.0), LOT, &HOUSES);
    made
}

/// The same without the row that is looked at.
pub fn others(path: &[[DVec3; 2]]) -> Made {
    let mut made = Made::seen("street", path).ground(60.0);
    for z in [-32.0, 12.0, 34.0] {
        // The farther one is higher: some of its lights are seen over the roofs.
        let higher = |[height, back]: [f64; 2]| [height + if z > 30.0 { 9.0 } else { 0.0 }, back];
        made.row(DVec3::new(-20.0, 0.0, z), LOT, &HOUSES.map(higher));
    }
    made
}
