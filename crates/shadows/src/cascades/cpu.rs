//! The processor's form: f32, receivers in parallel.
//!
//! A frame starts from the cascades' depth maps: rasterising them is the graphics device's
//! business and is not in the processor's time.

use rayon::prelude::*;

use super::lookup::{Place, Region, select, slopes, texel};
use super::{
    Cascade, CascadeError, CascadeReceiver, Counters, Settings, check_maps, check_settings,
};
use crate::filtering::DepthMap;

/// Receivers that one task shades.
const SHADED: usize = 4096;

/// Cascades of fixed settings.
#[derive(Clone, Debug)]
pub struct Shadows {
    regions: Vec<Region>,
    settings: Settings,
    side: u32,
}

impl Shadows {
    /// Shadows from maps of `side` x `side` texels.
    ///
    /// # Errors
    /// What [`Settings::check`] refuses; a side of 0; [`CascadeError::Count`] and
    /// [`CascadeError::Cascade`].
    pub fn new(side: u32, cascades: &[Cascade], settings: &Settings) -> Result<Self, CascadeError> {
        check_settings(side, cascades, settings)?;
        let regions = cascades.iter().map(|cascade| Region::new(cascade, side)).collect();
        Ok(Self { regions, settings: *settings, side })
    }

    /// Visibility in 0..=1 of every receiver, in order, into `out`; 1 outside.
    ///
    /// # Errors
    /// Maps or results of another number or size. Depths are not looked at: see
    /// [`DepthMap::check`].
    pub fn shade(
        &self,
        maps: &[DepthMap],
        receivers: &[CascadeReceiver],
        out: &mut [f32],
    ) -> Result<(), CascadeError> {
        check_maps(maps, self.regions.len(), self.side)?;
        let (expected, actual) = (receivers.len(), out.len());
        if expected != actual {
            return Err(CascadeError::Length { what: "results", expected, actual });
        }
        out.par_chunks_mut(SHADED).zip(receivers.par_chunks(SHADED)).for_each(
            |(out, receivers)| {
                for (visibility, receiver) in out.iter_mut().zip(receivers) {
                    *visibility = self.visibility(maps, receiver);
                }
            },
        );
        Ok(())
    }

    fn visibility(&self, maps: &[DepthMap], receiver: &CascadeReceiver) -> f32 {
        if !receiver.is_valid() {
            return 1.0;
        }
        let cascade = select(&self.regions, receiver.view_depth);
        let (region, depths) = (&self.regions[cascade], &maps[cascade].depths);
        let (settings, side) = (&self.settings, self.side);
        let Some(place) = Place::new(receiver, region, side, settings.taps) else { return 1.0 };
        let [su, sv] = slopes(receiver);
        let slope_bias = settings.slope_bias * (su.abs() + sv.abs()) * region.texel;
        let z = receiver.depth - settings.bias - slope_bias;
        let most = z.max(1.0);
        let n = settings.taps.side();
        let mut lit = 0u32;
        for j in 0..n {
            let y = texel(place.first[1], j, side);
            let row = &depths[y as usize * side as usize..][..side as usize];
            for i in 0..n {
                let x = texel(place.first[0], i, side);
                let mut limit = z;
                if settings.plane_bias {
                    let du = (x as f32 + 0.5 - place.at[0]) * region.texel;
                    let dv = (y as f32 + 0.5 - place.at[1]) * region.texel;
                    limit = (z + su * du + sv * dv).min(most);
                }
                lit += u32::from(row[x as usize] >= limit);
            }
        }
        lit as f32 / (n * n) as f32
    }

    /// Work of a frame with these receivers, the drawing of the maps included.
    #[must_use]
    pub fn counters(&self, receivers: &[CascadeReceiver]) -> Counters {
        Counters::of(&self.regions, self.side, &self.settings, receivers)
    }
}
