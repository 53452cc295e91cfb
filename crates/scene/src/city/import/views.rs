//! Views and paths of a real city, by rule: nothing is typed in for a file.
//!
//! `street` looks down the longest free line with houses beside it, and the path of that name walks
//! it; `close_ended` looks down a short one that a wall closes; `facade` stands before the largest
//! wall with room in front; `birds_eye` looks down at 45 degrees, and `flyover` crosses the city
//! above its roofs. Where there is no room for a view it is left out.

use super::free_space::FreeSpace;
use crate::city::City;
use crate::{Camera, CameraPath, Projection};
use glam::{DVec2, DVec3};

/// Height of a walker's eyes, metres.
const EYE_M: f64 = 1.7;
/// What a walker keeps clear, metres.
const CLEAR_M: f64 = 2.0;
/// Walls nearer than this are beside a street, metres.
const BESIDE_M: f64 = 15.0;
/// Longest street that counts, metres.
const LONGEST_M: f64 = 400.0;
/// Lines are tried from points this far apart, metres, in so many directions of a half turn.
const GRID_M: f64 = 6.0;
const DIRECTIONS: u32 = 24;
/// Length of a street that a wall closes, metres.
const CLOSED_M: [f64; 2] = [20.0, 80.0];
/// Distance from the facade looked at, metres.
const FACADE_M: f64 = 10.0;
/// Frames of a path, and the longest step between two on foot and in flight, metres.
const FRAMES: u32 = 60;
const STEP_M: f64 = 2.0;
const FLIGHT_M: f64 = 8.0;
/// Keys of a walk, which follows the ground.
const KEYS: u32 = 13;
/// Height of a flight above the highest roof, metres.
const ABOVE_M: f64 = 30.0;
/// Vertical opening, degrees.
const FOV_DEG: f64 = 45.0;

/// A stretch of free ground.
#[derive(Clone, Copy)]
struct Line {
    from: DVec2,
    direction: DVec2,
    length_m: f64,
    score: f64,
}

/// Adds cameras and paths.
pub fn add(city: &mut City) {
    let (mut cameras, mut paths) = (vec![], vec![]);
    if let Some(space) = FreeSpace::new(city) {
        let (street, closed) = lines(&space);
        if let Some(line) = street {
            let walk = walk(city, &line);
            cameras.extend(walk.keys.first().cloned());
            paths.push(walk);
        }
        if let Some(line) = closed {
            cameras.push(standing(city, "close_ended", line.from, line.direction));
        }
        cameras.extend(facade(city, &space));
        let [lo, hi] = space.bounds();
        cameras.push(birds_eye(city, lo, hi));
        paths.push(flyover(city, lo, hi));
    }
    city.cameras = cameras;
    city.paths = paths;
}

/// The best long line, and the best short one that ends at a wall.
fn lines(space: &FreeSpace) -> (Option<Line>, Option<Line>) {
    let [lo, hi] = space.bounds();
    let (mut street, mut closed) = (None::<Line>, None::<Line>);
    let keep = |best: &mut Option<Line>, line: Line| {
        if line.score > best.map_or(0.0, |b| b.score) {
            *best = Some(line);
        }
    };
    let counts = ((hi - lo) / GRID_M).ceil();
    for j in 0..counts.y as u32 {
        for i in 0..counts.x as u32 {
            let p = lo + (DVec2::new(f64::from(i), f64::from(j)) + 0.5) * GRID_M;
            // Open ground is no street.
            if !(CLEAR_M..BESIDE_M).contains(&space.clearance(p)) {
                continue;
            }
            for k in 0..2 * DIRECTIONS {
                let turn = std::f64::consts::PI * f64::from(k) / f64::from(DIRECTIONS);
                let direction = DVec2::from_angle(turn);
                let length_m = space.free_m(p, direction, CLEAR_M, LONGEST_M);
                let score = lined(space, p, direction, length_m);
                let line = Line { from: p, direction, length_m, score };
                let beyond = p + direction * (length_m + CLEAR_M + 1.0);
                let at_wall = beyond.cmpgt(lo).all() && beyond.cmplt(hi).all();
                if at_wall && (CLOSED_M[0]..CLOSED_M[1]).contains(&length_m) {
                    keep(&mut closed, Line { score: score / (1.0 + space.clearance(p)), ..line });
                }
                keep(&mut street, line);
            }
        }
    }
    (street, closed)
}

/// Metres of the line that have walls beside them.
fn lined(space: &FreeSpace, from: DVec2, direction: DVec2, length_m: f64) -> f64 {
    const SAMPLE_M: f64 = 4.0;
    let samples = (length_m / SAMPLE_M) as u32;
    let beside =
        |i: &u32| space.clearance(from + direction * (SAMPLE_M * f64::from(*i))) < BESIDE_M;
    SAMPLE_M * (0..samples).filter(beside).count() as f64
}

/// A walk along the line, at the height of eyes above the ground.
fn walk(city: &City, line: &Line) -> CameraPath {
    // Ends a little before the wall.
    let length = (line.length_m - CLEAR_M).min(STEP_M * f64::from(FRAMES - 1)).max(0.0);
    let keys = (0..KEYS)
        .map(|i| {
            let along = length * f64::from(i) / f64::from(KEYS - 1);
            standing(city, "street", line.from + line.direction * along, line.direction)
        })
        .collect();
    CameraPath { name: "street".into(), keys, frames: FRAMES }
}

/// A camera at a walker's eyes.
fn standing(city: &City, name: &str, at: DVec2, direction: DVec2) -> Camera {
    let position = DVec3::new(at.x, ground_m(city, at) + EYE_M, at.y);
    let ahead = DVec3::new(direction.x, 0.0, direction.y) * 10.0;
    camera(name, position, position + ahead)
}

/// The highest ground at a place, or the base of the nearest building.
fn ground_m(city: &City, p: DVec2) -> f64 {
    let triangles = city.grounds.iter().flat_map(|g| &g.triangles);
    let here = triangles.filter_map(|t| height_at(t, p)).fold(f64::NEG_INFINITY, f64::max);
    if here.is_finite() {
        return here;
    }
    let away = |b: &crate::city::Building| {
        let [lo, hi] = b.footprint.bounds();
        p.clamp(lo, hi).distance_squared(p)
    };
    let nearest = city.buildings.iter().min_by(|a, b| away(a).total_cmp(&away(b)));
    nearest.map_or(0.0, |b| b.base_m)
}

/// Height of a triangle at a place within it.
fn height_at([a, b, c]: &[DVec3; 3], p: DVec2) -> Option<f64> {
    let plan = |q: &DVec3| DVec2::new(q.x, q.z) - p;
    let (pa, pb, pc) = (plan(a), plan(b), plan(c));
    let weights = DVec3::new(pb.perp_dot(pc), pc.perp_dot(pa), pa.perp_dot(pb));
    let sum = weights.element_sum();
    if sum == 0.0 || (weights / sum).min_element() < 0.0 {
        return None;
    }
    Some((weights / sum).dot(DVec3::new(a.y, b.y, c.y)))
}

/// Before the middle of the largest wall with room in front.
fn facade(city: &City, space: &FreeSpace) -> Option<Camera> {
    let mut best: Option<(f64, Camera)> = None;
    for building in &city.buildings {
        for facade in building.facades.iter().filter(|f| !f.party) {
            let along = facade.to - facade.from;
            let width = along.length();
            let area = width * (building.eaves_m - building.base_m);
            if best.as_ref().is_some_and(|(most, _)| area <= *most) {
                continue;
            }
            // (x, z) to (-z, x) points outwards.
            let normal = DVec2::new(-along.y, along.x) / width;
            let middle = 0.5 * (facade.from + facade.to);
            let start = middle + normal * (CLEAR_M + 2.0);
            let room = space.free_m(start, normal, CLEAR_M, FACADE_M);
            if room + CLEAR_M + 2.0 < FACADE_M {
                continue;
            }
            let mut view = standing(city, "facade", middle + normal * FACADE_M, -normal);
            let above = 0.5 * (building.base_m + building.eaves_m) - view.position.y;
            view.target.y += above.clamp(0.0, 0.5 * FACADE_M);
            best = Some((area, view));
        }
    }
    best.map(|(_, view)| view)
}

fn roofs_m(city: &City) -> f64 {
    city.buildings.iter().map(|b| b.outer.max.y).fold(0.0, f64::max)
}

/// From the south, down at 45 degrees at the middle.
fn birds_eye(city: &City, lo: DVec2, hi: DVec2) -> Camera {
    let middle = 0.5 * (lo + hi);
    let target = DVec3::new(middle.x, 0.0, middle.y);
    let high = (0.5 * (hi - lo).max_element()).max(roofs_m(city) + ABOVE_M);
    camera("birds_eye", target + DVec3::new(0.0, high, high), target)
}

/// Across the window along its longer side, above all roofs, looking ahead and down.
fn flyover(city: &City, lo: DVec2, hi: DVec2) -> CameraPath {
    let (middle, size) = (0.5 * (lo + hi), hi - lo);
    let along = if size.x >= size.y { DVec2::X } else { DVec2::NEG_Y };
    let length = size.max_element().min(FLIGHT_M * f64::from(FRAMES - 1));
    let high = roofs_m(city) + ABOVE_M;
    let key = |t: f64| {
        let p = middle + along * (length * t);
        let position = DVec3::new(p.x, high, p.y);
        camera("flyover", position, position + DVec3::new(along.x, -0.6, along.y) * 10.0)
    };
    CameraPath { name: "flyover".into(), keys: vec![key(-0.5), key(0.5)], frames: FRAMES }
}

fn camera(name: &str, position: DVec3, target: DVec3) -> Camera {
    let projection = Projection::Perspective { fov_y_rad: FOV_DEG.to_radians() };
    Camera { name: name.into(), position, target, up: DVec3::Y, projection }
}
