//! The four points of view, and coherent paths through them.
//!
//! Based on: E. Conte, "Real-time Rendering of Cities at Night", MSc thesis, Université de
//! Montréal, 2018, table 5.I: a single facade, a close-ended street, a long linear street, a bird's
//! eye view, each showing several times as much as the one before.

use super::layout::{ALLEY_M, Layout, SIDEWALK_M};
use crate::city::City;
use crate::{Camera, CameraPath, Projection};
use glam::DVec3;

/// Height of a walker's eyes, metres.
const EYE_M: f64 = 1.7;

/// From a single facade's wall to the eye, metres: less than an alley, and the wall fills images up
/// to twice as wide as high.
const FACADE_M: f64 = ALLEY_M - 0.2;

/// How far above the highest roof a flight crosses the city, metres.
const ABOVE_M: f64 = 10.0;

/// Where things are that views refer to.
struct Places {
    /// Row of blocks whose street across is looked through.
    row: u32,
    /// Middle of the street across, between the first two blocks of that row, x.
    across_x: f64,
    /// Where that street leaves the row on its south side, z.
    mouth_z: f64,
    /// Middle of the street along the north side of the row, z.
    along_z: f64,
    /// Where both rows beside that street have begun, x.
    begin_x: f64,
    /// Whether the next row's facades close the street across.
    closed: bool,
}

impl Places {
    fn of(layout: &Layout) -> Self {
        let row = layout.rows / 2;
        let [min, max] = layout.slab(row, 0);
        let beside = row.checked_sub(1).map_or(min.x, |r| layout.slab(r, 0)[0].x);
        Self {
            row,
            across_x: max.x + 0.5 * layout.street_m,
            mouth_z: max.y,
            along_z: min.y - 0.5 * layout.street_m,
            begin_x: min.x.max(beside),
            closed: layout.shift_m > 0.0 && layout.columns > 1,
        }
    }
}

/// `street`: down an unbroken street, from its end. `close_ended`: into a street that the facades
/// of the next row close; where no row is offset, from the far kerb straight at a row of facades.
/// `facade`: one facade and nothing else. `birds_eye`: down at 45 degrees.
pub fn cameras(city: &City, layout: &Layout) -> Vec<Camera> {
    let places = Places::of(layout);
    let street = DVec3::new(places.begin_x, EYE_M, places.along_z);
    let close_ended = if places.closed {
        DVec3::new(places.across_x, EYE_M, places.mouth_z)
    } else {
        let [min, max] = layout.slab(places.row, 0);
        DVec3::new(0.5 * (min.x + max.x), EYE_M, max.y + layout.street_m)
    };
    let high = (0.35 * (layout.max - layout.min).max_element()).max(2.0 * above_roofs(city));
    vec![
        camera("street", street, DVec3::X),
        camera("close_ended", close_ended, DVec3::NEG_Z),
        camera("facade", facade(city, &places), DVec3::NEG_Z),
        camera("birds_eye", DVec3::new(0.0, high, high), DVec3::new(0.0, -1.0, -1.0)),
    ]
}

/// Whether a wall at `z` stands on the street south of the row.
fn on_street(z: f64, places: &Places) -> bool {
    (z + SIDEWALK_M - places.mouth_z).abs() < 1e-6
}

/// A height above all roofs, metres.
fn above_roofs(city: &City) -> f64 {
    city.buildings.iter().map(|b| b.eaves_m).fold(0.0, f64::max) + ABOVE_M
}

/// Before the middle of a facade towards +z: on the street south of the row if there is one, then
/// the highest, then the nearest to the street across.
fn facade(city: &City, places: &Places) -> DVec3 {
    let free = city.buildings.iter().filter(|b| !b.facades[0].party);
    let best = free.max_by(|a, b| {
        let away = |x: f64| (x - places.across_x).abs();
        on_street(a.outer.max.z, places)
            .cmp(&on_street(b.outer.max.z, places))
            .then(a.storeys.cmp(&b.storeys))
            .then(away(b.outer.centre().x).total_cmp(&away(a.outer.centre().x)))
    });
    let Some(best) = best else { return DVec3::new(places.across_x, EYE_M, places.mouth_z) };
    let centre = best.outer.centre();
    DVec3::new(centre.x, centre.y, best.outer.max.z + FACADE_M)
}

/// `street`: 60 frames of a walk down the long street. `turn`: along that street and round a corner
/// into the street across. `tour`: about 130 frames through all four views, walking, then flying.
pub fn paths(city: &City, layout: &Layout, cameras: &[Camera]) -> Vec<CameraPath> {
    let places = Places::of(layout);
    let [street, close_ended, facade, birds_eye] = cameras else { return vec![] };
    let ahead = (0.8 * (layout.max.x - places.begin_x)).min(59.0 * 1.5);
    let walk = [
        Stop::at(street, 0),
        Stop { position: street.position + DVec3::X * ahead, forward: DVec3::X, frames: 59 },
    ];
    let roofs = above_roofs(city);
    let junction = DVec3::new(places.across_x, EYE_M, places.along_z);
    let mouth = DVec3::new(places.across_x, EYE_M, places.mouth_z.max(close_ended.position.z));
    // Along the street where the facade stands on it, else over the roofs.
    let first = if on_street(facade.position.z - FACADE_M, &places) {
        vec![Stop::at(facade, 0), Stop::at(close_ended, 24)]
    } else {
        let over =
            |c: &Camera, frames| Stop { position: c.position.with_y(roofs), ..Stop::at(c, frames) };
        vec![Stop::at(facade, 0), over(facade, 8), over(close_ended, 12), Stop::at(close_ended, 8)]
    };
    let mut tour = first;
    tour.extend([
        Stop { position: mouth, forward: DVec3::NEG_Z, frames: if places.closed { 1 } else { 18 } },
        Stop { position: junction, forward: DVec3::NEG_Z, frames: 20 },
        Stop::at(street, 34),
        Stop { position: street.position.with_y(roofs), forward: DVec3::X, frames: 10 },
        Stop::at(birds_eye, 40),
    ]);
    vec![
        path("street", keys("street", &walk)),
        path("turn", turn(layout, junction)),
        path("tour", keys("tour", &tour)),
    ]
}

/// 60 frames: 20 towards the junction, 22 round its corner, 17 into the street across.
fn turn(layout: &Layout, junction: DVec3) -> Vec<Camera> {
    // The circle about the corner of the buildings.
    let radius = 0.5 * layout.street_m + SIDEWALK_M;
    let centre = junction + DVec3::new(-radius, 0.0, radius);
    let before = (0..20).map(|i| {
        let back = DVec3::X * (1.5 * f64::from(20 - i));
        (centre + DVec3::NEG_Z * radius - back, DVec3::X)
    });
    let round = (0..=22).map(|i| {
        // The half-angle's tangent instead of sines, which differ between platforms.
        let t = f64::from(i) / 22.0;
        let (sine, cosine) = (2.0 * t / (1.0 + t * t), (1.0 - t * t) / (1.0 + t * t));
        (centre + DVec3::new(sine, 0.0, -cosine) * radius, DVec3::new(cosine, 0.0, sine))
    });
    let after = (1..=17).map(|i| (centre + DVec3::new(radius, 0.0, f64::from(i)), DVec3::Z));
    before.chain(round).chain(after).map(|(at, forward)| camera("turn", at, forward)).collect()
}

/// Where a path passes.
struct Stop {
    position: DVec3,
    forward: DVec3,
    /// From the stop before.
    frames: u32,
}

impl Stop {
    fn at(camera: &Camera, frames: u32) -> Self {
        let forward = camera.target - camera.position;
        Self { position: camera.position, forward: forward.normalize_or(DVec3::NEG_Z), frames }
    }
}

/// One key a frame, straight from stop to stop.
fn keys(name: &str, stops: &[Stop]) -> Vec<Camera> {
    let mut keys = vec![];
    for pair in stops.windows(2) {
        let [a, b] = pair else { continue };
        keys.extend((0..b.frames).map(|i| {
            let t = f64::from(i) / f64::from(b.frames);
            camera(name, a.position.lerp(b.position, t), a.forward.lerp(b.forward, t))
        }));
    }
    keys.extend(stops.last().map(|s| camera(name, s.position, s.forward)));
    keys
}

fn path(name: &str, keys: Vec<Camera>) -> CameraPath {
    CameraPath { name: name.into(), frames: keys.len() as u32, keys }
}

fn camera(name: &str, position: DVec3, forward: DVec3) -> Camera {
    Camera {
        name: name.into(),
        position,
        target: position + forward.normalize_or(DVec3::NEG_Z) * 10.0,
        up: DVec3::Y,
        projection: Projection::Perspective { fov_y_rad: std::f64::consts::FRAC_PI_4 },
    }
}
