//! Which part of the light's map each slice needs.
//!
//! Based on: Voicu 2011 (`voicu2011`), section 3.1.1: the crop to where casters and receivers
//! overlap, here for each slice of the camera's view. Deviation: the rectangle is grown to a
//! square around its middle.

use super::{CascadeError, MAX_CASCADES};

/// A slice of view depths and the square of the base map that its own map covers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cascade {
    /// View depth at which it begins; receivers nearer than the first cascade are in that one.
    pub near: f64,
    /// View depth at which it ends, itself included; what lies beyond the last is in the last.
    pub far: f64,
    /// Base map coordinates (u, v) of the region's corner of least u and v.
    pub offset: [f64; 2],
    /// Side of the region in base map coordinates; 0 for a cascade whose receivers no caster can
    /// shadow, which stays empty.
    pub scale: f64,
}

impl Cascade {
    /// A cascade that covers the whole base map.
    #[must_use]
    pub fn whole(near: f64, far: f64) -> Self {
        Self { near, far, offset: [0.0; 2], scale: 1.0 }
    }

    /// Whether no caster overlaps it.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.scale == 0.0
    }

    /// Base map coordinates as coordinates of the region, 0..=1 inside; not finite where the
    /// cascade is empty.
    #[must_use]
    pub fn local(&self, base: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|axis| (base[axis] - self.offset[axis]) / self.scale)
    }

    /// Coordinates of the region as base map coordinates.
    #[must_use]
    pub fn base(&self, local: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|axis| self.offset[axis] + local[axis] * self.scale)
    }
}

/// The casters' extent in base map coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CasterBox {
    /// Least u and v.
    pub least: [f64; 2],
    /// Largest u and v.
    pub most: [f64; 2],
}

impl CasterBox {
    /// Casters all over the base map.
    pub const WHOLE: Self = Self { least: [0.0; 2], most: [1.0; 2] };

    fn check(&self) -> Result<(), CascadeError> {
        let Self { least, most } = *self;
        let sound = |axis: usize| {
            least[axis].is_finite() && most[axis].is_finite() && least[axis] <= most[axis]
        };
        if sound(0) && sound(1) { Ok(()) } else { Err(CascadeError::Casters { least, most }) }
    }
}

/// How regions are laid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fit {
    /// Side of a cascade's map, texels.
    pub side: u32,
    /// Texels around the overlap that are kept for the taps of receivers at its border:
    /// [`Taps::reach`](super::Taps::reach).
    pub margin_texels: u32,
}

/// The cascades of slices between neighbouring `splits`.
///
/// `slices[i]` holds the eight corners of the camera's frustum between `splits[i]` and
/// `splits[i + 1]` in base map coordinates (beyond 0..=1 where they leave the map); under a
/// perspective light all of them must lie in front of it. A region covers the overlap of the
/// slice's box and the casters', no narrower than a texel of a base map of the same side.
///
/// # Errors
/// [`CascadeError::Count`] and [`CascadeError::Length`] for lists that do not belong together;
/// [`CascadeError::Cascade`] for splits that do not increase; [`CascadeError::Corner`];
/// [`CascadeError::Casters`]; [`CascadeError::Margin`].
pub fn fit(
    splits: &[f64],
    slices: &[[[f64; 2]; 8]],
    casters: &CasterBox,
    how: Fit,
) -> Result<Vec<Cascade>, CascadeError> {
    let expected = splits.len().saturating_sub(1);
    if slices.len() != expected {
        return Err(CascadeError::Length { what: "slices", expected, actual: slices.len() });
    }
    casters.check()?;
    let Fit { side, margin_texels } = how;
    let used = u64::from(side).saturating_sub(2 * u64::from(margin_texels));
    if used == 0 {
        return Err(CascadeError::Margin { margin_texels, side });
    }
    let growth = f64::from(side) / used as f64;
    let mut cascades = Vec::with_capacity(slices.len());
    for (slice, (range, corners)) in splits.windows(2).zip(slices).enumerate() {
        let sound = |corner: &[f64; 2]| corner.iter().all(|x| x.is_finite());
        if let Some(corner) = corners.iter().position(|corner| !sound(corner)) {
            return Err(CascadeError::Corner { slice, corner });
        }
        let edge = |axis: usize| {
            let along = corners.iter().map(|corner| corner[axis]);
            let least = along.clone().fold(f64::INFINITY, f64::min);
            let most = along.fold(f64::NEG_INFINITY, f64::max);
            [least.max(casters.least[axis]), most.min(casters.most[axis])]
        };
        let edges = [edge(0), edge(1)];
        let (near, far) = (range[0], range[1]);
        if edges.iter().any(|[least, most]| least > most) {
            cascades.push(Cascade { near, far, offset: [0.0; 2], scale: 0.0 });
            continue;
        }
        let extent = edges.iter().fold(1.0 / f64::from(side), |w: f64, [a, b]| w.max(b - a));
        let scale = extent * growth;
        let offset = edges.map(|[least, most]| least - 0.5 * (scale - (most - least)));
        cascades.push(Cascade { near, far, offset, scale });
    }
    check(&cascades)?;
    Ok(cascades)
}

/// Checks number, order and regions.
pub(super) fn check(cascades: &[Cascade]) -> Result<(), CascadeError> {
    if !(1..=MAX_CASCADES).contains(&cascades.len()) {
        return Err(CascadeError::Count { count: cascades.len() });
    }
    for (cascade, c) in cascades.iter().enumerate() {
        let before = if cascade == 0 { c.near } else { cascades[cascade - 1].far };
        let why = if !(c.near.is_finite() && c.far.is_finite() && c.near < c.far) {
            "its near and far must be finite and increase"
        } else if c.near != before {
            "it does not begin where the one before ends"
        } else if !c.offset.iter().all(|x| x.abs() <= 1e6) {
            "its region lies further than 1e6 base maps away"
        } else if c.scale != 0.0 && !(1e-6..=1e6).contains(&c.scale) {
            "its region's side is neither 0 nor within 1e-6..=1e6 of the base map's"
        } else {
            continue;
        };
        return Err(CascadeError::Cascade { cascade, why });
    }
    Ok(())
}
