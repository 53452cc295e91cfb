//! Small worlds that reservoirs are judged by.
#![allow(dead_code, clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

use dapple_many_lights::{
    Emission, Light, World,
    worlds::{Cloud, Rectangle, WINDOW, cloud, made},
};
use dapple_scene::{Camera, Projection};
use glam::{DVec3, Vec3};
use std::sync::Arc;

/// All kinds of light.
pub const EMISSIONS: [Emission; 4] =
    [Emission::Omni, WINDOW, Emission::Oriented, Emission::Directional];

fn mixed_cloud() -> Cloud {
    Cloud {
        lights: 40,
        emissions: EMISSIONS.to_vec(),
        size: [14, 11],
        frames: 3,
        ..Cloud::default()
    }
}

/// Four kinds of lights, edges, sky; the eye moves.
pub fn mixed() -> Arc<World> {
    Arc::new(cloud(&mixed_cloud()).world)
}

/// The same where surfaces cast shadows.
pub fn mixed_with_shadows() -> Arc<World> {
    Arc::new(cloud(&mixed_cloud()).with_shadows().unwrap())
}

/// A roof bent by 20 degrees: its halves count as alike, and half of the lights stand behind one
/// half or the other. Seen from above by an eye that stands still for two frames.
pub fn bent() -> Arc<World> {
    let slope = 10.0_f64.to_radians();
    let half = |side: f64| Rectangle {
        corner: DVec3::new(0.0, 0.0, 4.0 * side),
        along: DVec3::new(side * slope.cos(), -slope.sin(), 0.0) * 5.0,
        up: DVec3::NEG_Z * (8.0 * side),
        albedo: Vec3::splat(0.8),
    };
    let light = |index: u32| {
        // 5 degrees above the horizon, to the left and to the right.
        let side = if index.is_multiple_of(2) { 1.0 } else { -1.0 };
        let place = f64::from(index / 2) - 2.0;
        Light {
            position: DVec3::new(side * 12.0, 0.5, place),
            axis: DVec3::Z,
            intensity: DVec3::new(30.0, 25.0, 15.0),
            emission: Emission::Omni,
        }
    };
    let camera = Camera {
        name: "above".into(),
        position: DVec3::Y * 20.0,
        target: DVec3::ZERO,
        up: DVec3::NEG_Z,
        projection: Projection::Orthographic { height_m: 8.0 },
    };
    let lights = (0..10).map(light).collect();
    let cameras = [camera.clone(), camera];
    Arc::new(made(lights, &[half(1.0), half(-1.0)], &cameras, [12, 10], DVec3::ZERO).world)
}
