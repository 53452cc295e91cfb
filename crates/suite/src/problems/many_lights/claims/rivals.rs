//! Lights drawn by chance down trees: what their sources say, by noise at equal numbers of lights.

use super::{
    super::{LightsCase, errors::Score, replicas, settings::technique},
    support::{VIEWS, prepared, run, setting, time_ratio},
    verdict::{figure, judged, vote, vote_open},
};
use crate::{
    SuiteError,
    claims::{Claim, ClaimContext, Figure, Judged, Verdict},
    problem::{Form, Setting},
};
use dapple_many_lights::{Form as LightsForm, Light, Shaded, radiance, sample::expected};
use glam::DVec3;
use rayon::prelude::*;
use serde_json::{Value, json};
use std::rc::Rc;

/// Columns, and truth at every pixel: neighbours are compared, and images are lit 16 times.
const SMALL: [(&str, u32); 2] = [("width", 64), ("truth_pixels", 10_000)];

/// The same where every light's chance is looked at.
const TINY: [(&str, u32); 2] = [("width", 24), ("truth_pixels", 10_000)];

/// Lights drawn a pixel.
const DRAWN: [u32; 3] = [1, 8, 32];

/// Lights drawn a pixel where one number has to do.
const SOME: u32 = 16;

/// Errors that neighbours share by more than this are seen as bands and edges rather than as noise;
/// by less than [`APART`], as noise.
const TOGETHER: f64 = 0.5;
const APART: f64 = 0.1;

/// Noise that a quarter more is "nearly as good": it takes half as many samples again to make up.
const NEARLY: f64 = 1.25;

pub fn claims() -> Vec<Claim> {
    vec![
        Claim {
            id: "conty-1",
            statement: "Lights drawn down a tree by importance scatter less than as many lights drawn \
                        alike or by power",
            place: "Conty Estevez and Kulla 2018; not in Conte 2018",
            method: "the generated city from the four points of view and a cloud of lights, 24 \
                     columns, no shadows. Variance of one light of the light hierarchy, exactly, from \
                     the chances of all lights at all pixels, against that of a draw with equal \
                     chances and with chances by luminance; its root, over the mean truth. Met in a \
                     view if it is less than both. Independent draws keep the ratio at any number",
            judge: Box::new(by_importance),
        },
        Claim {
            id: "yuksel-1",
            statement: "Stochastic lightcuts entirely replace the correlation of lightcuts' errors by \
                        noise: no bands where a cut changes",
            place: "Yuksel 2019; not in Conte 2018",
            method: "relative errors of one frame at 16 clusters a pixel, correlated between each \
                     pixel and those to the right and below on the same object (about zero: a \
                     constant error is shared, too). Met in a view if lightcuts' exceeds 0.5 and \
                     the stochastic one is within 0.1 of none; contradicted if the stochastic one is \
                     more than half of lightcuts'; a view where lightcuts' does not exceed 0.5 has \
                     no bands to replace and decides nothing",
            judge: Box::new(correlation),
        },
        Claim {
            id: "yuksel-2",
            statement: "On the mean, stochastic lightcuts are right: the error of a cut becomes noise \
                        that more samples cure",
            place: "Yuksel 2019; not in Conte 2018",
            method: "mean of 16 repetitions over all pixels against the truth, at cuts of 1, 8 and 32 \
                     nodes, both variants: every view must be within 8 standard errors (estimated \
                     from the 16; Student's tails). Beside it the error of the mean of lightcuts with \
                     as many clusters, which repeats exactly",
            judge: Box::new(no_bias),
        },
        Claim {
            id: "yuksel-3",
            statement: "A light drawn in every node of a cut scatters less than as many lights drawn \
                        from a light tree's root",
            place: "Yuksel 2019; not in Conte 2018",
            method: "exact noise at 8 and 32 lights a pixel in the same cases, against the light \
                     hierarchy's independent samples. Met in a case if less at both. (One light is \
                     no cut.) The rival's samples are not stratified, nor split as its paper also \
                     offers",
            judge: Box::new(by_cuts),
        },
        Claim {
            id: "lin-1",
            statement: "A cut shared by 8 x 8 pixels is nearly as good as one a pixel, and costs less",
            place: "Lin and Yuksel 2020; not in Conte 2018",
            method: "noise of both variants at 8 lights a pixel by 16 repetitions, and node visits, 192 \
                     columns, and 48 to see the trend. Met in a view if noise is at most a quarter \
                     more at fewer visits; contradicted if visits are no fewer. More noise does not \
                     contradict: 8 pixels of 192 see ten times the angle of the published ones of \
                     1,920. Squared noise times visits, the price of equal noise, and time are told, \
                     for this processor",
            judge: Box::new(shared_cuts),
        },
    ]
}

/// Knobs or parameters of whole numbers.
pub(super) fn ints(given: &[(&'static str, u32)]) -> Vec<(&'static str, Value)> {
    given.iter().map(|(name, value)| (*name, json!(value))).collect()
}

/// The city from a point of view, small, with truth everywhere.
fn small(view: &str) -> Result<Rc<LightsCase<'static>>, SuiteError> {
    prepared("city", view, &ints(&SMALL))
}

/// What repetitions of a technique show.
pub(super) fn spread(
    case: &LightsCase<'_>,
    setting: &Setting,
) -> Result<replicas::Spread, SuiteError> {
    replicas::spread(case, &mut *case.lighting(setting)?, case.seed())
}

fn hierarchy(samples: u32) -> Result<Setting, SuiteError> {
    setting("light-bvh", Form::Cpu, &[("samples", json!(samples))])
}

fn stochastic(variant: &str, cut: u32) -> Result<Setting, SuiteError> {
    setting(&format!("stochastic-lightcuts/{variant}"), Form::Cpu, &[("cut", json!(cut))])
}

/// Noise of one light drawn with chances in proportion to `weight`, exactly: as repetitions would
/// find it, over the mean truth.
fn independent(case: &LightsCase<'_>, weight: impl Fn(&Light) -> f64 + Sync) -> f64 {
    let world = case.world();
    let total: f64 = world.lights.iter().map(&weight).sum();
    let (mut variance, mut mean, mut count) = (0.0, 0.0, 0);
    for (frame, shown) in world.frames.iter().enumerate() {
        let pixels: Vec<(u32, DVec3)> = case.truth().frame(frame).collect();
        let of = |(pixel, exact): &(u32, DVec3)| {
            let point = &shown.points[*pixel as usize];
            let one = |light: &Light| {
                let given = radiance(point, light, world.clamp_m);
                let chance = weight(light) / total;
                if chance > 0.0 { given * given / chance } else { DVec3::ZERO }
            };
            let squares: DVec3 = world.lights.iter().map(one).sum();
            (squares - exact * exact).max(DVec3::ZERO).element_sum()
        };
        variance += pixels.par_iter().map(of).collect::<Vec<f64>>().iter().sum::<f64>();
        mean += pixels.iter().map(|(_, exact)| exact.element_sum()).sum::<f64>();
        count += 3 * pixels.len();
    }
    let count = f64::from(count as u32).max(1.0);
    (variance / count).sqrt() / (mean / count).max(f64::MIN_POSITIVE)
}

/// Noise of a technique and of its rivals at one number of lights after the other.
fn always_less(cases: &[Vec<[f64; 2]>]) -> Verdict {
    let less =
        |case: &Vec<[f64; 2]>| !case.is_empty() && case.iter().all(|[ours, rival]| ours < rival);
    vote(&cases.iter().map(less).collect::<Vec<_>>())
}

/// Quotients of the last pair of each case, for people.
fn last_quotients(cases: &[Vec<[f64; 2]>]) -> Vec<f64> {
    cases.iter().filter_map(|case| case.last()).map(|[a, b]| a / b).collect()
}

/// The four views and a cloud.
fn everywhere() -> Result<Vec<(String, Rc<LightsCase<'static>>)>, SuiteError> {
    let mut all = Vec::new();
    for view in VIEWS {
        all.push((view.to_string(), prepared("city", view, &ints(&TINY))?));
    }
    all.push(("light_cloud".to_string(), prepared("light_cloud", "", &ints(&TINY))?));
    Ok(all)
}

/// Noise of a sampler exactly, over the mean truth: from the chances of all lights at all pixels.
fn exact(case: &LightsCase<'_>, setting: &Setting) -> Result<f64, SuiteError> {
    let technique = technique(setting)?;
    let (world, tree) = (case.world(), case.tree(&technique, setting)?);
    let found = expected(LightsForm::Cpu, &technique, world, &tree, 0)?;
    let sum = |values: &[DVec3]| values.iter().map(|v| v.element_sum()).sum::<f64>();
    let channels = 3 * world.frames[0].points.iter().filter(|p| p.is_there()).count();
    let count = channels.max(1) as f64;
    let mean = sum(&found.mean) / count;
    Ok((sum(&found.variance) / count).sqrt() / mean.max(f64::MIN_POSITIVE))
}

fn by_importance(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let (mut figures, mut cases): (Vec<Figure>, Vec<Vec<[f64; 2]>>) = (Vec::new(), Vec::new());
    for (view, case) in everywhere()? {
        let (alike, power) = (independent(&case, |_| 1.0), independent(&case, Light::luminance));
        let ours = exact(&case, &hierarchy(1)?)?;
        figures.extend([
            figure(format!("{view}: noise of one light, drawn alike"), alike, ""),
            figure(format!("{view}: noise of one light, by power"), power, ""),
            figure(format!("{view}: noise of one light, by importance"), ours, ""),
        ]);
        cases.push(vec![[ours, alike.min(power)]]);
    }
    let because = format!(
        "{:.3?} of the noise of the better of the two, view by view",
        last_quotients(&cases)
    );
    Ok(judged(always_less(&cases), because, figures))
}

/// Correlation of relative errors between neighbours on the same object.
fn neighbours_share(case: &LightsCase<'_>, shaded: &Shaded) -> f64 {
    let frame = &case.world().frames[0];
    let mut errors = vec![None; frame.points.len()];
    for (pixel, exact) in case.truth().frame(0) {
        let exact = exact.element_sum();
        if exact > 0.0 {
            let given = shaded.radiance[pixel as usize].as_dvec3().element_sum();
            errors[pixel as usize] = Some((given - exact) / exact);
        }
    }
    let width = frame.width as usize;
    let (mut products, mut here, mut there) = (0.0, 0.0, 0.0);
    for (pixel, error) in errors.iter().enumerate() {
        let right = Some(pixel + 1).filter(|next| next % width > 0);
        for next in right.into_iter().chain([pixel + width]) {
            let Some((a, b)) = error.zip(errors.get(next).copied().flatten()) else { continue };
            if frame.points[pixel].object == frame.points[next].object {
                products += a * b;
                here += a * a;
                there += b * b;
            }
        }
    }
    let both: f64 = here * there;
    if both > 0.0 { products / both.sqrt() } else { 0.0 }
}

/// Correlations of lightcuts and of the stochastic form in one view.
fn is_noise([cut, chance]: [f64; 2]) -> Option<bool> {
    // Where lightcuts have no bands there is nothing to replace.
    if cut <= TOGETHER {
        return None;
    }
    if chance.abs() < APART {
        return Some(true);
    }
    // Written so that what is not a number is refused.
    if chance.abs() <= 0.5 * cut { None } else { Some(false) }
}

fn correlation(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let (mut figures, mut pairs) = (Vec::new(), Vec::new());
    for view in VIEWS {
        let case = small(view)?;
        let mut share = |name: &str, setting: &Setting| -> Result<f64, SuiteError> {
            let run = run(&case, setting)?;
            let share = neighbours_share(&case, &run.frames[0]);
            figures.push(figure(
                format!("{view}, {name}: errors that neighbours share"),
                share,
                "",
            ));
            figures.push(figure(format!("{view}, {name}: rmse"), run.error("rmse"), ""));
            Ok(share)
        };
        let knobs = [("most", json!(SOME)), ("epsilon", json!(0.0)), ("tree", json!("original"))];
        let cut = share("lightcuts", &setting("lightcuts", Form::Cpu, &knobs)?)?;
        let own = share("a cut a pixel", &stochastic("offline", SOME)?)?;
        share("shared cuts", &stochastic("real-time", SOME)?)?;
        pairs.push([cut, own]);
    }
    let because = format!("shared by neighbours, lightcuts and stochastic: {pairs:.2?}");
    let seen: Vec<_> = pairs.iter().map(|pair| is_noise(*pair)).collect();
    Ok(judged(vote_open(&seen), because, figures))
}

/// How many standard errors the means miss the truth by.
fn unbiased(misses: &[f64]) -> Verdict {
    if misses.is_empty() {
        return Verdict::Open;
    }
    let within = misses.iter().all(|z| *z <= replicas::MOST_Z);
    if within { Verdict::Reproduced } else { Verdict::Refuted }
}

fn no_bias(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let (mut figures, mut misses) = (Vec::new(), Vec::new());
    let (mut ours, mut theirs) = (0.0_f64, 0.0_f64);
    for view in VIEWS {
        let case = small(view)?;
        for cut in DRAWN {
            for variant in ["offline", "real-time"] {
                let found = spread(&case, &stochastic(variant, cut)?)?;
                let what = format!("{view}, {variant}, {cut} nodes");
                figures.push(figure(format!("{what}: error of the mean"), found.bias, ""));
                figures.push(figure(format!("{what}: the same in standard errors"), found.z, ""));
                misses.push(found.z);
                ours = ours.max(found.bias);
            }
            let knobs =
                [("most", json!(cut)), ("epsilon", json!(0.0)), ("tree", json!("original"))];
            let bias = run(&case, &setting("lightcuts", Form::Cpu, &knobs)?)?.bias;
            figures.push(figure(
                format!("{view}, lightcuts, {cut} nodes: error of the mean"),
                bias,
                "",
            ));
            theirs = theirs.max(bias.abs());
        }
    }
    let worst = misses.iter().copied().fold(0.0, f64::max);
    let because = format!(
        "means miss by {worst:.1} standard errors at most ({ours:.1e} of the truth); lightcuts by up \
         to {theirs:.2} of it"
    );
    Ok(judged(unbiased(&misses), because, figures))
}

fn by_cuts(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let (mut figures, mut cases) = (Vec::new(), Vec::new());
    for (view, case) in everywhere()? {
        let mut list = Vec::new();
        for drawn in &DRAWN[1..] {
            let mut noise = |name: &str, setting: Setting| -> Result<f64, SuiteError> {
                let noise = exact(&case, &setting)?;
                figures.push(figure(format!("{view}, {drawn} lights, {name}: noise"), noise, ""));
                Ok(noise)
            };
            let ours = noise("nodes of a cut", stochastic("offline", *drawn)?)?;
            list.push([ours, noise("from the root", hierarchy(*drawn)?)?]);
        }
        cases.push(list);
    }
    let because = format!(
        "at 32 lights {:.2?} of the light hierarchy's noise, view by view",
        last_quotients(&cases)
    );
    Ok(judged(always_less(&cases), because, figures))
}

/// Noise and visits of shared cuts over those of cuts a pixel.
fn nearly(noise: f64, visits: f64) -> Option<bool> {
    if noise <= NEARLY && visits < 1.0 {
        return Some(true);
    }
    // Written so that what is not a number is refused.
    if visits < 1.0 && noise > 0.0 { None } else { Some(false) }
}

fn shared_cuts(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let (mut figures, mut seen, mut told) = (Vec::new(), Vec::new(), Vec::new());
    let (own, shared) = (stochastic("offline", 8)?, stochastic("real-time", 8)?);
    for view in VIEWS {
        for width in [48, 192] {
            let case = prepared("city", view, &ints(&[("width", width)]))?;
            let noise = spread(&case, &shared)?.noise / spread(&case, &own)?.noise;
            let visits = |setting| Ok::<_, SuiteError>(run(&case, setting)?.a_pixel(|w| w.visits));
            let visits = visits(&shared)? / visits(&own)?;
            let what = format!("{view}, {width} columns");
            figures.extend([
                figure(format!("{what}: noise, shared over a pixel's own"), noise, ""),
                figure(format!("{what}: node visits, likewise"), visits, ""),
                figure(format!("{what}: visits at equal noise"), noise * noise * visits, ""),
            ]);
            if width == 192 {
                let time = time_ratio(&case, &shared, &own, 3)?.median;
                figures.push(figure(format!("{what}: time, likewise"), time, ""));
                told.push(format!("{noise:.2} at {visits:.2} ({time:.2} of the time)"));
                seen.push(nearly(noise, visits));
            }
        }
    }
    let because = format!("noise at visits, shared over own: {}", told.join(", "));
    Ok(judged(vote_open(&seen), because, figures))
}

/// Root mean squared error of a path's last frame over some seeds.
pub(super) fn rmse_of_last(
    case: &LightsCase<'_>,
    setting: &Setting,
    seeds: u32,
) -> Result<f64, SuiteError> {
    let mut lighting = case.lighting(setting)?;
    let (mut shaded, mut squares) = (Shaded::default(), 0.0);
    let frames = case.world().frames.len();
    for seed in 0..seeds {
        lighting.reset(case.seed().wrapping_add(1 + seed))?;
        for index in 0..frames {
            lighting.shade(index, false)?;
        }
        lighting.read(&mut shaded)?;
        let mut score = Score::default();
        score.add(case.truth(), frames - 1, &shaded.radiance);
        squares += score.errors()?.get("rmse").map_or(f64::NAN, |rmse| rmse * rmse);
    }
    Ok((squares / f64::from(seeds.max(1))).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use Verdict::{Open, Refuted, Reproduced};

    #[test]
    fn noise_is_less_at_every_number_or_not() {
        assert_eq!(always_less(&[vec![[1.0, 2.0], [0.5, 1.0]], vec![[1.0, 2.0]]]), Reproduced);
        assert_eq!(always_less(&[vec![[1.0, 2.0], [1.5, 1.0]], vec![[1.0, 2.0]]]), Open);
        assert_eq!(always_less(&[vec![[1.0, 2.0], [f64::NAN, 1.0]]]), Refuted);
        assert_eq!(always_less(&[vec![]]), Refuted);
    }

    #[test]
    fn neighbours_share_errors_or_not() {
        assert_eq!(is_noise([0.9, 0.02]), Some(true));
        assert_eq!(is_noise([0.9, 0.3]), None);
        assert_eq!(is_noise([0.4, 0.02]), None);
        assert_eq!(is_noise([-0.1, -0.2]), None);
        assert_eq!(is_noise([0.9, 0.6]), Some(false));
        assert_eq!(is_noise([0.9, f64::NAN]), Some(false));
    }

    #[test]
    fn means_are_right_or_not() {
        assert_eq!(unbiased(&[0.5, 3.0]), Reproduced);
        assert_eq!(unbiased(&[0.5, 9.0]), Refuted);
        assert_eq!(unbiased(&[f64::NAN]), Refuted);
        assert_eq!(unbiased(&[]), Open);
    }

    #[test]
    fn a_shared_cut_is_nearly_as_good_or_not() {
        assert_eq!(nearly(1.2, 0.7), Some(true));
        assert_eq!(nearly(1.5, 0.3), None);
        assert_eq!(nearly(9.0, 0.6), None);
        assert_eq!(nearly(1.0, 1.1), Some(false));
        assert_eq!(nearly(f64::NAN, 0.5), Some(false));
    }

    #[test]
    fn exact_noise_is_that_of_repetitions() {
        // Equal distances: no rare light that repetitions miss.
        let case = prepared("light_facade", "", &ints(&TINY)).unwrap();
        // One candidate without reuse is a light drawn by power.
        let knobs =
            [("candidates", json!(1)), ("temporal", json!("off")), ("neighbours", json!(0))];
        let drawn = setting("reservoirs", Form::Cpu, &knobs).unwrap();
        let (found, said) =
            (spread(&case, &drawn).unwrap().noise, independent(&case, Light::luminance));
        assert!((found / said - 1.0).abs() < 0.05, "{found} where {said} is expected");
        for setting in [hierarchy(4).unwrap(), stochastic("offline", 8).unwrap()] {
            let (found, said) =
                (spread(&case, &setting).unwrap().noise, exact(&case, &setting).unwrap());
            assert!((found / said - 1.0).abs() < 0.05, "{setting}: {found}, not {said}");
        }
    }

    #[test]
    fn a_constant_error_is_shared_and_a_chequered_one_is_not() {
        let case = prepared("light_cloud", "", &ints(&SMALL)).unwrap();
        let frame = &case.world().frames[0];
        let given = |error: &dyn Fn(u32) -> f64| {
            let mut shaded = Shaded::default();
            shaded.clear(frame.points.len(), false);
            for (pixel, exact) in case.truth().frame(0) {
                shaded.radiance[pixel as usize] = (exact * (1.0 + error(pixel))).as_vec3();
            }
            neighbours_share(&case, &shaded)
        };
        assert!(given(&|_| 0.1) > 0.999);
        let chequered = |pixel: u32| [0.1, -0.1][(pixel % 64 + pixel / 64) as usize % 2];
        assert!(given(&chequered) < -0.999);
        assert!(given(&|_| 0.0).abs() <= 1.0);
    }
}
