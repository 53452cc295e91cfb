//! From degrees to metres: the plane that touches the WGS 84 ellipsoid at a point.
//!
//! Places are projected onto it at right angles (x east, z south), so lengths shrink by the cosine of
//! the angle between the normals: 1e-8 at a kilometre.

use glam::{DVec2, DVec3};

/// Semi-major axis, metres, and squared eccentricity of WGS 84.
const A_M: f64 = 6_378_137.0;
const E2: f64 = 6.694_379_990_141_316e-3;

/// A tangent plane.
pub struct Projection {
    origin: DVec3,
    east: DVec3,
    north: DVec3,
    up: DVec3,
}

impl Projection {
    /// Touching at a latitude and longitude in degrees.
    pub fn new(place_deg: DVec2) -> Self {
        let up = normal(place_deg);
        let longitude = place_deg.y.to_radians();
        let east = DVec3::new(-longitude.sin(), longitude.cos(), 0.0);
        Self { origin: on_ellipsoid(place_deg), east, north: up.cross(east), up }
    }

    /// (x, z) of a latitude and longitude in degrees.
    pub fn place(&self, place_deg: DVec2) -> DVec2 {
        let d = on_ellipsoid(place_deg) - self.origin;
        DVec2::new(d.dot(self.east), -d.dot(self.north))
    }

    /// By which share lengths at a place are too short at worst.
    pub fn scale_error(&self, place_deg: DVec2) -> f64 {
        // 1 - cos, without its cancellation.
        0.5 * (normal(place_deg) - self.up).length_squared()
    }
}

fn normal(place_deg: DVec2) -> DVec3 {
    let (latitude, longitude) = (place_deg.x.to_radians(), place_deg.y.to_radians());
    DVec3::new(latitude.cos() * longitude.cos(), latitude.cos() * longitude.sin(), latitude.sin())
}

fn on_ellipsoid(place_deg: DVec2) -> DVec3 {
    let n = normal(place_deg);
    let radius = A_M / (1.0 - E2 * n.z * n.z).sqrt();
    DVec3::new(n.x * radius, n.y * radius, n.z * radius * (1.0 - E2))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Lengths of a degree on WGS 84: 111,412.24 m of latitude and 55,800.00 m of longitude at 60 N
    /// (Snyder, "Map Projections: A Working Manual", 1987: 111,412 and 55,800).
    #[test]
    fn a_degree_has_its_tabled_length() {
        let projection = Projection::new(DVec2::new(60.0, 25.0));
        let step = 1e-3;
        let north = projection.place(DVec2::new(60.0 + step, 25.0)) / step;
        let east = projection.place(DVec2::new(60.0, 25.0 + step)) / step;
        assert!((north.y + 111_412.24).abs() < 2.0 && north.x.abs() < 1e-6, "{north}");
        assert!((east.x - 55_800.0).abs() < 2.0, "{east}");
        assert_eq!(projection.place(DVec2::new(60.0, 25.0)), DVec2::ZERO);
    }

    #[test]
    fn the_scale_error_is_what_lengths_lose() {
        let projection = Projection::new(DVec2::new(10.0, 179.9));
        let step = 1e-5;
        for place in [DVec2::new(10.5, 179.9), DVec2::new(10.0, -179.6), DVec2::new(9.4, 179.7)] {
            let error = projection.scale_error(place);
            let measured = |d: DVec2| {
                projection.place(place + d).distance(projection.place(place - d))
                    / on_ellipsoid(place + d).distance(on_ellipsoid(place - d))
            };
            for d in [DVec2::X, DVec2::Y].map(|d| d * step) {
                let lost = 1.0 - measured(d);
                assert!(lost > -1e-7 && lost < error + 1e-7, "{lost} of {error}");
            }
            assert!(error > 0.0 && error < 1e-4);
        }
    }
}
