//! What techniques are given, where it is not simply what the truth is traced in.

use dapple_scene::{LightView, Scene};
use dapple_shadows::filtering::Receiver;
use dapple_trace::Surface;

/// Receivers that the light grazes at this cosine or less take no part: their footprint on the
/// surface grows without bound, and shading by n·l hides them.
pub const LEAST_N_DOT_L: f64 = 0.05;

/// How the techniques' input differs from what the truth is traced in. By default: not at all.
#[derive(Clone, Debug)]
pub struct Given {
    /// Cosine between normal and light up to which receivers take no part.
    pub least_n_dot_l: f64,
    /// The map's depth range over that which fits the scene. Parallel light: the near plane
    /// moves, as towards a distant occluder; a spot: the far plane does.
    pub depth_range: f64,
    /// What the maps see in place of the scene, with receivers rounded to `f32` in world space.
    pub single_precision: Option<Scene>,
}

impl Default for Given {
    fn default() -> Self {
        Self { least_n_dot_l: LEAST_N_DOT_L, depth_range: 1.0, single_precision: None }
    }
}

impl Given {
    /// The map's projection, from the one that fits the scene.
    pub fn view(&self, fitted: LightView) -> LightView {
        let range = (fitted.far_m - fitted.near_m) * self.depth_range;
        if self.depth_range == 1.0 {
            // To the bit: near and far would be rounded below.
            fitted
        } else if fitted.perspective {
            LightView { far_m: fitted.near_m + range, ..fitted }
        } else {
            LightView { near_m: fitted.far_m - range, ..fitted }
        }
    }

    /// The point that a technique is asked about; one that the map does not hold is not valid.
    pub fn receiver(&self, view: &LightView, surface: &Surface) -> Receiver {
        let mut surface = *surface;
        if self.single_precision.is_some() {
            surface.position = surface.position.as_vec3().as_dvec3();
        }
        receiver(view, &surface, 0.0).unwrap_or(NOT_VALID)
    }
}

/// Stands where no receiver is.
pub const NOT_VALID: Receiver =
    Receiver { u: 0.0, v: 0.0, z: 0.0, valid: 0.0, dz_du: 0.0, dz_dv: 0.0, _pad: [0.0; 2] };

/// The receiver at a surface, or none where it faces away, is grazed (n·l up to `least`), or lies
/// outside the map.
pub fn receiver(view: &LightView, surface: &Surface, least: f64) -> Option<Receiver> {
    let p = dapple_trace::receiver(view, surface).filter(|p| p.n_dot_l > least)?;
    let flat = Receiver::new(p.u as f32, p.v as f32, p.z as f32);
    Some(flat.with_slope(p.dz_du as f32, p.dz_dv as f32)).filter(Receiver::in_map)
}
