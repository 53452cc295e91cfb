//! Window lights on the facades of any city.
//!
//! Based on: E. Conte, "Real-time Rendering of Cities at Night", MSc thesis, Université de
//! Montréal, 2018, section 5.1: a spot light at every window, along the facade's normal, 45 degrees
//! to each side, falling linearly to 0 at the cone's edge, and none between adjacent buildings.
//! Deviations: linear in the angle, which the thesis leaves open; lights stand 1 mm outside the
//! glass rather than on it, so that the facade does not hide its own.

use super::{City, CityError, Facade, WindowLight};
use glam::{DVec2, DVec3, Vec3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

/// Lights a storey of a facade, as in the thesis.
pub const LIGHTS_PER_STOREY: u32 = 3;

/// Half the opening of a window's cone, radians.
pub const HALF_ANGLE_RAD: f64 = std::f64::consts::FRAC_PI_4;

/// How far outside its facade a light stands, metres.
pub const OUTSIDE_M: f64 = 1e-3;

/// Narrower facades have no windows, metres.
pub const NARROWEST_M: f64 = 2.0;

/// Intensity along the normal of a light of colour 1.
const INTENSITY: f32 = 20.0;

/// Warm and cool lamps, linear RGB.
const PALETTE: [[f32; 3]; 5] =
    [[1.0, 0.58, 0.27], [1.0, 0.68, 0.4], [1.0, 0.78, 0.56], [0.95, 0.95, 1.0], [0.72, 0.85, 1.0]];

/// Gives every facade of `city` its lights, `per_storey` a storey and no others: none on party
/// walls and on walls narrower than [`NARROWEST_M`]. They stand at equal distances along the wall,
/// half a storey up. Colours and strengths (half to whole) follow `seed`.
///
/// # Errors
/// [`CityError::Value`] for `per_storey` outside 1..=8.
pub fn light(city: &mut City, per_storey: u32, seed: u64) -> Result<(), CityError> {
    if !(1..=8).contains(&per_storey) {
        let limit = "1..=8".into();
        return Err(CityError::Value {
            name: "lights_per_storey",
            value: per_storey.into(),
            limit,
        });
    }
    // A stream of its own: the lights of two cities of one seed begin alike.
    let mut rng = Pcg64::seed_from_u64(seed ^ 0x5157_494e_444f_5753);
    let mut lights = vec![];
    for (b, building) in city.buildings.iter().enumerate() {
        let storey_m = (building.eaves_m - building.base_m) / f64::from(building.storeys.max(1));
        for (f, facade) in building.facades.iter().enumerate().filter(|(_, f)| is_lit(f)) {
            let normal = outward(facade);
            for storey in 0..building.storeys {
                let y = building.base_m + (f64::from(storey) + 0.5) * storey_m;
                for window in 0..per_storey {
                    let along = (f64::from(window) + 0.5) / f64::from(per_storey);
                    let at = facade.from.lerp(facade.to, along) + normal * OUTSIDE_M;
                    let colour = Vec3::from_array(PALETTE[rng.random_range(0..PALETTE.len())]);
                    lights.push(WindowLight {
                        position: DVec3::new(at.x, y, at.y),
                        direction: DVec3::new(normal.x, 0.0, normal.y),
                        half_angle_rad: HALF_ANGLE_RAD,
                        intensity: colour * (INTENSITY * rng.random_range(0.5f32..1.0)),
                        building: b as u32,
                        facade: f as u32,
                        storey,
                    });
                }
            }
        }
    }
    lights.shrink_to_fit();
    city.lights = lights;
    Ok(())
}

/// Whether a facade has windows that are lit.
fn is_lit(facade: &Facade) -> bool {
    !facade.party && facade.from.distance(facade.to) >= NARROWEST_M
}

/// The outward normal of a facade in (x, z), unit length; 0 for a facade without length.
pub fn outward(facade: &Facade) -> DVec2 {
    let along = facade.to - facade.from;
    // 0 is added so that no -0 remains, which files do not keep.
    DVec2::new(-along.y, along.x).normalize_or_zero() + DVec2::ZERO
}
