//! How wrong and how wasteful drawn sets are.

use super::{case::VisibilityCase, truth::Owned};
use std::collections::BTreeMap;

/// Sums over the frames of a path.
#[derive(Clone, Debug, Default)]
pub struct Score {
    sure: u64,
    missed: u64,
    samples: u64,
    missed_samples: u64,
    owning: u64,
    owning_drawn: u64,
    owners: u64,
    owners_drawn: u64,
    triangles: u64,
    objects: u64,
    pixels: u64,
    wrong_pixels: u64,
}

impl Score {
    /// Adds a frame: the objects that were drawn (each once, in any order), and how many pixels of
    /// the image lie deeper than when everything is drawn.
    pub fn add(&mut self, case: &VisibilityCase<'_>, frame: usize, drawn: &[u32], wrong: u64) {
        let mut is_drawn = vec![false; case.objects().objects.len()];
        for object in drawn {
            is_drawn[*object as usize] = true;
            self.triangles += u64::from(case.objects().triangle_count(*object));
        }
        self.objects += drawn.len() as u64;
        for Owned { object, sure, samples, triangles } in &case.truth().frames[frame] {
            let (sure, samples) = (u64::from(*sure), u64::from(*samples));
            let seen = is_drawn[*object as usize];
            self.sure += sure;
            self.samples += samples;
            self.owning += u64::from(*triangles);
            self.owners += 1;
            if seen {
                self.owning_drawn += u64::from(*triangles);
                self.owners_drawn += 1;
            } else {
                self.missed += sure;
                self.missed_samples += samples;
            }
        }
        let [width, height] = case.size();
        self.pixels += u64::from(width) * u64::from(height);
        self.wrong_pixels += wrong;
    }

    /// Pixels, over all frames, that lie deeper than when everything is drawn.
    pub fn wrong_pixels(&self) -> u64 {
        self.wrong_pixels
    }

    /// The metrics. Frames that show nothing have no shares of what they show.
    pub fn errors(&self) -> BTreeMap<String, f64> {
        let share = |part: u64, of: u64| (of > 0).then(|| part as f64 / of as f64);
        let metrics = [
            ("missed", share(self.missed, self.sure)),
            ("missed_samples", share(self.missed_samples, self.samples)),
            ("wrong_pixels", share(self.wrong_pixels, self.pixels)),
            ("overdraw", share(self.triangles - self.owning_drawn, self.owning)),
            ("overdraw_objects", share(self.objects - self.owners_drawn, self.owners)),
        ];
        metrics.into_iter().filter_map(|(name, v)| Some((name.to_string(), v?))).collect()
    }
}
