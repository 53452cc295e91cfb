//! Where errors of pixels come from.

use super::{case::NightCase, settings};
use crate::{SuiteError, problem::Setting};
use dapple_many_lights::{World, cut::Starts, region::RegionTechnique};
use dapple_night_city::{
    Drawer, Front, Night,
    decompose::{Parts, PointStarts, at_height, decompose},
};
use glam::DVec3;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Most pixels of a frame whose errors are taken apart: each asks a ray for every light that could
/// give it anything.
const MOST_PIXELS: usize = 24;

/// Errors by their causes, collected over the frames of a path.
#[derive(Clone, Copy, Debug, Default)]
pub struct Causes {
    most: [f64; 4],
    leak: f64,
    truth: f64,
    lost: u64,
    pixels: u64,
}

impl Causes {
    /// Adds a pixel.
    pub fn add(&mut self, parts: &Parts) {
        let greatest = |v: DVec3| v.abs().max_element();
        let of = [parts.cull, parts.irradiance, parts.cut, parts.leak].map(greatest);
        for (most, of) in self.most.iter_mut().zip(of) {
            *most = most.max(of);
        }
        self.leak += parts.leak.element_sum();
        self.truth += parts.truth.element_sum();
        self.lost += u64::from(parts.culled);
        self.pixels += 1;
    }

    /// The metrics.
    pub fn errors(&self) -> BTreeMap<String, f64> {
        let [cull, irradiance, cut, leak] = self.most;
        let mut errors: BTreeMap<String, f64> = [
            ("e_cull", cull),
            ("e_irr", irradiance),
            ("e_cut", cut),
            ("e_leak", leak),
            ("lost_lights", self.lost as f64 / self.pixels.max(1) as f64),
        ]
        .map(|(name, value)| (name.to_string(), value))
        .into();
        // Where nothing is lit and something leaks, it is no share of anything.
        if self.leak == 0.0 || self.truth > 0.0 {
            let share = if self.leak == 0.0 { 0.0 } else { self.leak / self.truth };
            errors.insert("leak".into(), share);
        }
        errors
    }
}

/// Takes errors apart frame by frame, beside a technique with the same settings.
pub struct Apart<'g> {
    night: Night,
    lit: World,
    /// Leaves out what is hidden, and nothing for being weak.
    hides: Front<'g>,
}

impl<'g> Apart<'g> {
    /// For a setting; `None` where it adds up no clusters.
    ///
    /// # Errors
    /// Settings that are refused.
    pub fn of(case: &NightCase<'g>, setting: &Setting) -> Result<Option<Self>, SuiteError> {
        if setting.technique == "reservoirs" {
            return Ok(None);
        }
        let night = settings::night(setting, case.seed())?;
        let region = match night.region {
            RegionTechnique::FacadeCluster(region) => {
                RegionTechnique::FacadeCluster(dapple_many_lights::region::FacadeCluster {
                    threshold: 0.0,
                    ..region
                })
            }
            other => other,
        };
        let town = &case.night().town;
        let drawer = Drawer::new(&town.objects, None)?;
        let hides = Front::new(town, &Night { region, heights: 0, ..night }, drawer)?;
        Ok(Some(Self { night, lit: town.lit(), hides }))
    }

    /// Adds some pixels of a frame that was lit from `starts`; the parts of each, for ports.
    ///
    /// # Errors
    /// None of a frame that there is.
    pub fn add(
        &mut self,
        case: &NightCase<'g>,
        frame: usize,
        starts: &Starts,
        causes: &mut Causes,
    ) -> Result<Vec<(u32, DVec3)>, SuiteError> {
        self.hides.prepare(frame)?;
        let town = &case.night().town;
        let points = &town.world(false).frames[frame].points;
        let pixels: Vec<u32> = case.truth().frame(frame).map(|(pixel, _)| pixel).collect();
        // Evenly through the image, as the truth's pixels come in its order.
        let step = pixels.len().div_ceil(MOST_PIXELS).max(1);
        let chosen: Vec<u32> = pixels.into_iter().step_by(step).collect();
        let seen = self.hides.starts();
        let apart = |pixel: &u32| {
            let point = &points[*pixel as usize];
            let [used, hidden] = at_height(starts, point);
            let seen = seen.of(point.object);
            let of = PointStarts { used: &used, seen, hidden: &hidden };
            let Night { cut, shadow_rays, .. } = &self.night;
            (*pixel, decompose(&self.lit, &town.lights, cut, *shadow_rays, point, of))
        };
        let parts: Vec<(u32, Parts)> = chosen.par_iter().map(apart).collect();
        parts.iter().for_each(|(_, parts)| causes.add(parts));
        Ok(parts.into_iter().map(|(pixel, parts)| (pixel, parts.result)).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn causes_are_the_greatest_and_the_leak_is_a_share() {
        let mut causes = Causes::default();
        assert!(causes.errors().values().all(|e| *e == 0.0));
        let one = Parts {
            truth: DVec3::splat(0.5),
            cut: DVec3::new(-0.25, 0.0, 0.1),
            leak: DVec3::splat(0.25),
            ..Parts::default()
        };
        causes.add(&one);
        causes.add(&Parts { truth: DVec3::splat(0.5), culled: 3, ..Parts::default() });
        let errors = causes.errors();
        assert_eq!((errors["e_cut"], errors["e_leak"]), (0.25, 0.25));
        assert_eq!((errors["leak"], errors["lost_lights"], errors["e_cull"]), (0.25, 1.5, 0.0));
    }
    #[test]
    fn what_leaks_where_nothing_is_lit_is_no_share() {
        let mut causes = Causes::default();
        causes.add(&Parts { leak: DVec3::splat(0.25), ..Parts::default() });
        let errors = causes.errors();
        assert_eq!(errors["e_leak"], 0.25);
        assert!(!errors.contains_key("leak") && errors.values().all(|e| e.is_finite()));
    }
}
