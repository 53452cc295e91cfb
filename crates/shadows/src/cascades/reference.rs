//! The oracle for ports: comparisons in f64, one receiver at a time.

use rayon::prelude::*;

use super::faults::Fault;
use super::lookup::{Place, Region, select, slopes, texel};
use super::{Cascade, CascadeError, CascadeReceiver, Settings, check_input};
use crate::filtering::DepthMap;

/// Visibility in 0..=1 of every receiver, in order; 1 outside.
///
/// `maps[i]` is the map of `cascades[i]`, cropped to its region: square, all of one size.
///
/// # Errors
/// What [`Settings::check`] and [`DepthMap::check`] refuse; [`CascadeError::Count`],
/// [`CascadeError::Cascade`] and [`CascadeError::Length`] for cascades that do not fit together.
pub fn visibility(
    maps: &[DepthMap],
    cascades: &[Cascade],
    receivers: &[CascadeReceiver],
    settings: &Settings,
) -> Result<Vec<f64>, CascadeError> {
    evaluate(maps, cascades, receivers, settings, None)
}

/// The interval within which a port's visibility of each receiver may lie: comparisons closer
/// than the rounding of f32 may go either way.
///
/// # Errors
/// As [`visibility`].
pub fn port_bounds(
    maps: &[DepthMap],
    cascades: &[Cascade],
    receivers: &[CascadeReceiver],
    settings: &Settings,
) -> Result<Vec<(f64, f64)>, CascadeError> {
    let oracle = Oracle::new(maps, cascades, settings, None)?;
    let bounds =
        |receiver: &CascadeReceiver| (oracle.shade(receiver, 1.0), oracle.shade(receiver, -1.0));
    Ok(receivers.par_iter().map(bounds).collect())
}

pub(super) fn evaluate(
    maps: &[DepthMap],
    cascades: &[Cascade],
    receivers: &[CascadeReceiver],
    settings: &Settings,
    fault: Option<Fault>,
) -> Result<Vec<f64>, CascadeError> {
    let oracle = Oracle::new(maps, cascades, settings, fault)?;
    Ok(receivers.par_iter().map(|receiver| oracle.shade(receiver, 0.0)).collect())
}

struct Oracle<'a> {
    maps: &'a [DepthMap],
    regions: Vec<Region>,
    settings: Settings,
    side: u32,
    fault: Option<Fault>,
}

impl<'a> Oracle<'a> {
    fn new(
        maps: &'a [DepthMap],
        cascades: &[Cascade],
        settings: &Settings,
        fault: Option<Fault>,
    ) -> Result<Self, CascadeError> {
        let side = check_input(maps, cascades, settings)?;
        let regions = cascades.iter().map(|cascade| Region::new(cascade, side)).collect();
        let mut settings = *settings;
        if fault == Some(Fault::Unbiased) {
            settings = Settings { bias: 0.0, slope_bias: 0.0, plane_bias: false, ..settings };
        }
        Ok(Self { maps, regions, settings, side, fault })
    }

    /// Mean of the comparisons with the receiver moved away from the light by `nudge` times what
    /// a port may round.
    fn shade(&self, receiver: &CascadeReceiver, nudge: f64) -> f64 {
        if !receiver.is_valid() {
            return 1.0;
        }
        let mut cascade = select(&self.regions, receiver.view_depth);
        if self.fault == Some(Fault::NextCascade) {
            cascade = (cascade + 1) % self.regions.len();
        }
        let mut region = self.regions[cascade];
        if self.fault == Some(Fault::CropOneTexel) {
            region.offset[0] -= region.texel;
        }
        let (settings, side) = (&self.settings, self.side);
        let Some(place) = Place::new(receiver, &region, side, settings.taps) else { return 1.0 };
        let [su, sv] = slopes(receiver).map(f64::from);
        let unit = f64::from(region.texel);
        // Place in texels without the rounding of `Place::at`.
        let at = [(receiver.u, region.offset[0]), (receiver.v, region.offset[1])]
            .map(|(x, offset)| (f64::from(x) - f64::from(offset)) / unit);
        let steep = (su.abs() + sv.abs()) * unit;
        let z = f64::from(receiver.depth)
            - f64::from(settings.bias)
            - f64::from(settings.slope_bias) * steep;
        let n = settings.taps.side();
        let mut lit = 0u32;
        for j in 0..n {
            for i in 0..n {
                let x = texel(place.first[0], i, side);
                let y = texel(place.first[1], j, side);
                let du = (f64::from(x) + 0.5 - at[0]) * unit;
                let dv = (f64::from(y) + 0.5 - at[1]) * unit;
                let plane = if settings.plane_bias { su * du + sv * dv } else { 0.0 };
                let slack = nudge * rounding(receiver, settings, [su * du, sv * dv], steep, side);
                // The plane may run past the far plane; an empty texel, of depth 1, hides
                // nothing all the same.
                let limit = (z + plane + slack).min((z + slack).max(1.0));
                let stored = self.maps[cascade].depths[(y * side + x) as usize];
                lit += u32::from(f64::from(stored) >= limit);
            }
        }
        f64::from(lit) / f64::from(n * n)
    }
}

/// How far a compared depth in f32 may be from the exact one: a few roundings of each term, and
/// the place in the map, which f32 knows to `side` times its step.
fn rounding(
    receiver: &CascadeReceiver,
    settings: &Settings,
    plane: [f64; 2],
    steep: f64,
    side: u32,
) -> f64 {
    let step = f64::from(f32::EPSILON);
    let mut size = f64::from(receiver.depth).abs() + f64::from(settings.bias);
    size += f64::from(settings.slope_bias) * steep;
    if settings.plane_bias {
        size += plane[0].abs() + plane[1].abs() + f64::from(side) * steep;
    }
    2.0 * step * size
}
