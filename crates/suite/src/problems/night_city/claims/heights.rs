//! Buildings of different heights: table 5.VIII.

use super::{
    super::NightCase,
    support::{COARSE, PAIRS, about_times, front, mean, night, pipeline, prepared, standing},
    verdict::{all_of, figure, judged, paired},
};
use crate::{
    SuiteError,
    claims::{Claim, Figure, Judged, Verdict},
};
use dapple_night_city::Night;
use serde_json::{Value, json};

pub fn claims() -> Vec<Claim> {
    vec![Claim {
        id: "conte-H5.11",
        statement: "Heights of 1 to 7 storeys instead of 7 raise the time of a frame, by about 1.8 at \
                    as many evaluations and 2.0 at more; fewer buildings act alike",
        place: "Conte 2018, table 5.VIII: 178.8, 365.2 and 317.9 ms",
        method: "the 6 x 6 city's long street, 96 x 72, R4 at T = 1/1020, nothing kept: time of whole \
                 frames (stages summed) by heights by chance over 7 storeys everywhere, in turn; once \
                 with the same tau, once with the tau at which evaluations come nearest to as many, \
                 from 1/64 to 64 times. Met by 1.78 and 2.04 within a factor of 1.5 or more, \
                 contradicted where frames get no slower. A third of all lots empty is met by any more \
                 time. The source's figure for 7 storeys appears in table 5.II of another view, too: it \
                 may be a mistake in copying",
        judge: Box::new(|_| heights()),
    }]
}

fn case_of(name: &str, value: Value) -> Result<std::rc::Rc<NightCase<'static>>, SuiteError> {
    prepared("city", "street", &[(name, value)])
}

fn settings(tau: f64) -> Result<Night, SuiteError> {
    let night = night(&[("validity", json!(1)), ("cut", json!(COARSE))])?;
    Ok(Night { tau_px: tau, ..night })
}

fn evaluations(case: &NightCase<'_>, tau: f64) -> Result<f64, SuiteError> {
    let mut front = front(case, &settings(tau)?)?;
    Ok(mean(&standing(&mut front, 1)?, |p| p.counts.evaluations))
}

/// The tau at which a case's evaluations come nearest to `wanted`, in octaves.
fn tau_for(case: &NightCase<'_>, wanted: f64, usual: f64) -> Result<f64, SuiteError> {
    let off = |tau| evaluations(case, tau).map(|found| (found - wanted).abs());
    let (mut best, mut least) = (usual, off(usual)?);
    for step in (-6..=6).map(|step| 2_f64.powi(step)) {
        let found = off(usual * step)?;
        if found < least {
            (best, least) = (usual * step, found);
        }
    }
    Ok(best)
}

/// Time of a case's frame over that of another, each with its tau.
fn slower(
    (a, tau_a): (&NightCase<'_>, f64),
    (b, tau_b): (&NightCase<'_>, f64),
    name: &str,
    figures: &mut Vec<Figure>,
) -> Result<f64, SuiteError> {
    let mut pipelines = [pipeline(a, &settings(tau_a)?)?, pipeline(b, &settings(tau_b)?)?];
    let mut steps = [[0.0; 2]; 2];
    for (pipeline, steps) in pipelines.iter_mut().zip(&mut steps) {
        let times = pipeline.frame(0, true)?;
        let mut shaded = dapple_many_lights::Shaded::default();
        pipeline.read(&mut shaded)?;
        *steps = [times.counts.evaluations as f64, shaded.work.visits as f64];
    }
    let [x, y] = &mut pipelines;
    let time = paired(
        PAIRS,
        || Ok(x.frame(0, false)?.stages_ns() as f64),
        || Ok(y.frame(0, false)?.stages_ns() as f64),
    )?;
    figures.extend([
        figure(format!("{name}: evaluations"), steps[0][0], ""),
        figure(format!("{name}: evaluations of 7 storeys"), steps[1][0], ""),
        figure(format!("{name}: nodes visited"), steps[0][1] / steps[1][1].max(1.0), "times"),
        figure(format!("{name}: time of a frame"), time.median, "times"),
        figure(format!("{name}: the same, MAD"), time.mad, ""),
    ]);
    Ok(time.median)
}

/// Times at as many evaluations, at more, and with fewer buildings.
fn raises(equal: f64, more: f64, sparse: f64) -> Verdict {
    let any = if sparse > 1.0 { Verdict::Reproduced } else { Verdict::Refuted };
    all_of(&[about_times(equal, 317.9 / 178.8), about_times(more, 365.2 / 178.8), any])
}

fn heights() -> Result<Judged, SuiteError> {
    let seven = case_of("heights", json!("seven"))?;
    let varied = case_of("heights", json!("independent"))?;
    let sparse = [("heights", json!("seven")), ("empty", json!(1.0 / 3.0))];
    let sparse = prepared("city", "street", &sparse)?;
    let usual = Night::default().tau_px;
    let tau = tau_for(&varied, evaluations(&seven, usual)?, usual)?;
    let mut figures = vec![figure("tau at as many evaluations", tau, "px")];
    let more = slower((&varied, usual), (&seven, usual), "same tau", &mut figures)?;
    let equal = slower((&varied, tau), (&seven, usual), "as many evaluations", &mut figures)?;
    let fewer = slower((&sparse, usual), (&seven, usual), "a third empty", &mut figures)?;
    let because = format!(
        "{equal:.2} times at as many evaluations, {more:.2} with the same tau, {fewer:.2} where a third \
         of the lots is empty"
    );
    Ok(judged(raises(equal, more, fewer), because, figures))
}

#[cfg(test)]
mod tests {
    use super::*;
    use Verdict::{Open, Refuted, Reproduced};

    #[test]
    fn heights_raise_times_or_not() {
        assert_eq!(raises(1.8, 2.0, 1.1), Reproduced);
        assert_eq!(raises(1.1, 2.0, 1.1), Open);
        assert_eq!(raises(1.8, 0.9, 1.1), Refuted);
        assert_eq!(raises(1.8, 2.0, 1.0), Refuted);
        assert_eq!(raises(f64::NAN, 2.0, 1.1), Refuted);
    }
}
