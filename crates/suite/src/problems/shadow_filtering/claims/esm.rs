//! D7.7: where exponential shadow maps fail.

use super::{
    still::{ESM, STILLS, Still},
    verdict::{GREY_LEVEL, all_of, count, figure, judged, vote},
};
use crate::{
    SuiteError,
    claims::{Claim, ClaimContext, Judged, Verdict},
};
use dapple_shadows::filtering::{Lookup, Receiver, Settings, estimators::exponential, lookup};

/// No exponent is given: the half floats' limit, three in use, and the floats' limit.
const EXPONENTS: [f64; 4] = [11.0, 40.0, 80.0, 88.0];

pub fn claims() -> Vec<Claim> {
    vec![Claim {
        id: "gumbau-D7.7",
        statement: "Exponential shadow maps are too light near contact and in windows that reach \
                    behind the receiver, not where the occluder is far as the text has it",
        place: "Against Gumbau 2011, section 2.4.2 (L680); follows from exp(-c (z_r - z_o))",
        method: "one occluder, f64, at each exponent of 11, 40, 80 and 88: at a distance of 0.01 \
                 of the depth range at least 0.1 of the light must pass (25 grey levels), at 0.5 \
                 less than 1/64 (4 of 255, as 11 is the floor for half floats), falling all the \
                 way. And on the scenes of H7.1 (c = 80, bias 1e-3, f32, nearest lookup) the light \
                 that exceeds both truth and the exact share of the stored texels (so that neither \
                 undersampling nor a slanted receiver's own plane counts) is sorted by the \
                 receiver's window, once over all receivers and once over those in full shadow: \
                 `behind` \
                 where a texel lies behind the receiver, `contact` where none does and the farthest \
                 texel is within 3/c (where one occluder passes 5 %), else `far`; far must hold \
                 less than 10 % of it (5 % is the most one window of it can pass). Each voted \
                 over the scenes; where the mean is below a tenth of a grey level none is sorted",
        judge: Box::new(where_it_fails),
    }]
}

/// Visibilities at growing distances of one occluder.
fn fades(near: f64, far: f64, falling: bool) -> bool {
    near >= 0.1 && far < 1.0 / 64.0 && falling
}

/// Light made up, by kind of window, summed over receivers.
#[derive(Clone, Copy, Debug, Default)]
struct Excess {
    contact: f64,
    behind: f64,
    far: f64,
}

impl Excess {
    fn total(&self) -> f64 {
        self.contact + self.behind + self.far
    }

    /// Whether far occluders hold little of it.
    fn not_far(&self) -> bool {
        self.far < 0.1 * self.total()
    }
}

/// Farthest depth of a receiver's window, nearest lookup.
fn farthest(still: &Still, receiver: &Receiver, s: &Settings) -> f32 {
    let (width, height) = (still.map.width, still.map.height);
    let at = lookup::Footprint::new(receiver, Lookup::Nearest, width, height);
    let radius = i64::from(s.width_texels / 2);
    let along = |centre: u32, side: u32| {
        let last = i64::from(side) - 1;
        (-radius..=radius).map(move |d| (i64::from(centre) + d).clamp(0, last) as usize)
    };
    let mut most = 0.0_f32;
    for y in along(at.y0, height) {
        for x in along(at.x0, width) {
            most = most.max(still.map.depths[y * width as usize + x]);
        }
    }
    most
}

/// Over all receivers that `counts` picks by their truth: the sums, and how many there are.
fn excess(
    still: &Still,
    s: &Settings,
    counts: impl Fn(f32) -> bool,
) -> Result<(Excess, usize), SuiteError> {
    let (result, exact) = (still.shade(s)?, still.exact(s)?);
    let (mut sum, mut receivers) = (Excess::default(), 0);
    let taking_part = |i: &usize| still.mask[*i] && counts(still.truth[*i]);
    for i in (0..still.mask.len()).filter(taking_part) {
        let receiver = &still.receivers[i];
        receivers += 1;
        let light = f64::from((result[i] - exact[i].max(still.truth[i])).max(0.0));
        let z = lookup::biased_depth(receiver, s, still.map.width, still.map.height);
        let behind = farthest(still, receiver, s) - z;
        if behind >= 0.0 {
            sum.behind += light;
        } else if -behind < 3.0 / s.exponent {
            sum.contact += light;
        } else {
            sum.far += light;
        }
    }
    Ok((sum, receivers))
}

fn where_it_fails(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let mut figures = Vec::new();
    let mut single = Vec::new();
    for c in EXPONENTS {
        let at = |distance: f64| exponential::visibility_log(0.4, 0.4 + distance, c);
        let all: Vec<f64> = (1..=50).map(|i| at(0.01 * f64::from(i))).collect();
        let falling = all.windows(2).all(|w| w[1] < w[0]);
        figures.push(figure(format!("one occluder at 0.01, c = {c}"), at(0.01), ""));
        figures.push(figure(format!("one occluder at 0.5, c = {c}"), at(0.5), ""));
        single.push(fades(at(0.01), at(0.5), falling));
    }
    let (mut all, mut dark) = (Vec::new(), Vec::new());
    for recipe in STILLS {
        let still = recipe.still()?;
        let s = Settings { lookup: Lookup::Nearest, ..still.settings(ESM, 1e-3) };
        for (place, holds, most) in
            [("all receivers", &mut all, 1.0), ("full shadow", &mut dark, 0.0)]
        {
            let (sum, receivers) = excess(&still, &s, |truth| truth <= most)?;
            let mean = sum.total() / receivers.max(1) as f64;
            let mut add = |what: &str, value: f64| {
                figures.push(figure(format!("{}, {place}: {what}", still.name), value, ""));
            };
            add("mean light made up", mean);
            // Shares of next to nothing say nothing.
            if mean > 0.1 * GREY_LEVEL {
                add("of that near contact", sum.contact / sum.total());
                add("of that windows reaching behind", sum.behind / sum.total());
                add("of that far occluders", sum.far / sum.total());
                holds.push(sum.not_far());
            }
        }
    }
    let because = format!(
        "one occluder passes less the farther it is at {} exponents; far occluders hold less than \
         a tenth of the light made up on {} scenes, in full shadow on {}",
        count(&single),
        count(&all),
        count(&dark)
    );
    Ok(judged(decide(&single, &all, &dark), because, figures))
}

fn decide(single: &[bool], all: &[bool], dark: &[bool]) -> Verdict {
    all_of(&[vote(single), vote(all), vote(dark)])
}

#[cfg(test)]
mod tests {
    use super::*;
    use Verdict::{Open, Refuted, Reproduced};

    #[test]
    fn light_must_fade_with_distance() {
        assert!(fades(0.4, 0.0, true));
        assert!(!fades(0.05, 0.0, true));
        assert!(!fades(0.4, 0.1, true));
        assert!(!fades(0.4, 0.0, false));
    }

    #[test]
    fn far_light_counts_against_it() {
        assert!(Excess { contact: 5.0, behind: 4.5, far: 0.5 }.not_far());
        assert!(!Excess { contact: 5.0, behind: 4.0, far: 1.0 }.not_far());
        assert_eq!(decide(&[true], &[true, true], &[true]), Reproduced);
        assert_eq!(decide(&[true], &[false], &[true]), Refuted);
        assert_eq!(decide(&[true], &[true, false], &[true]), Open);
        assert_eq!(decide(&[true], &[true], &[false]), Refuted);
        assert_eq!(decide(&[false], &[true], &[true]), Refuted);
    }
}
