//! How work grows with the city.

use super::{
    support::{
        CITIES, OURS, Run, THESIS, VIEW, asked, evaluator, is_about, least_ns, prepared, run,
    },
    verdict::{count, exponent, figure, judged, vote},
};
use crate::{
    SuiteError,
    claims::{Claim, ClaimContext, Figure, Judged, Verdict},
};
use dapple_many_lights::region::{FacadeCluster, Steps};

/// Times that each city's faces are timed; the least counts.
const TIMES: usize = 2;

/// The range of exponents that the source's tables give, with some room.
const EXPONENTS: [f64; 2] = [0.3, 0.6];

/// A step and its calls a cell in table 5.VII, by city.
type Row = (&'static str, [f64; 3], fn(&Steps) -> u64);

const TABLE: [Row; 5] = [
    ("6: iterations", [22.0, 28.0, 41.0], |s| s.iterations),
    ("7: potential tests", [3332.0, 4940.0, 8719.0], |s| s.potential),
    ("9: last tests", [642.0, 685.0, 641.0], |s| s.last),
    ("11: early tests", [1926.0, 2936.0, 5669.0], |s| s.early),
    ("13: reprojections", [19.0, 25.0, 38.0], |s| s.reprojections),
];

/// Lights of the source's cities, and times of visibility a cell there.
const LIGHTS: [f64; 3] = [39_202.0, 88_278.0, 245_106.0];
const CELL_MS: [f64; 3] = [8.2, 11.4, 18.1];

pub fn claims() -> Vec<Claim> {
    vec![
        Claim {
            id: "conte-H5.7",
            statement: "The cost of an evaluation grows sublinearly with the city: as lights to the 0.3 \
                        to 0.6",
            place: "Conte 2018, section 5.4 and table 5.VII",
            method: "cities of 6 x 6, 9 x 9 and 15 x 15 blocks, close-ended street, all faces of one \
                     frame: tests of clusters (steps 7, 9 and 11) an evaluation as a power of lights, \
                     by a straight line through logarithms; as the source says it and by our settings. \
                     Both within the range is met, either 1 or more contradicts. Exponents of the \
                     printed table, and of time on this machine, stand beside",
            judge: Box::new(cost),
        },
        Claim {
            id: "conte-H5.7-last",
            statement: "The number of last tests stays about the same in larger cities",
            place: "Conte 2018, section 5.4 and table 5.VII",
            method: "last tests an evaluation in the three cities, as the source says it: within 10 % \
                     of their mean is met, one beyond a factor of 1.5 of it contradicts",
            judge: Box::new(last),
        },
        Claim {
            id: "conte-T5.VII",
            statement: "From 6 x 6 blocks to 9 x 9 and 15 x 15, calls a cell grow by 1.27 and 1.86 \
                        (iterations), 1.48 and 2.62 (potential), 1.07 and 1.00 (last), 1.52 and 2.94 \
                        (early), 1.32 and 2.0 (reprojection)",
            place: "Conte 2018, table 5.VII",
            method: "the same ratios of calls an evaluation here: within a factor of 1.5 for all ten is \
                     met, for none contradicts",
            judge: Box::new(table),
        },
    ]
}

/// One run a city.
fn runs(settings: FacadeCluster) -> Result<Vec<(f64, Run)>, SuiteError> {
    let of = |city| -> Result<(f64, Run), SuiteError> {
        let case = prepared(city, VIEW, 1)?;
        Ok((case.night().town.lights.leaves.len() as f64, run(&case, settings)?))
    };
    CITIES.into_iter().map(of).collect()
}

fn tests(steps: &Steps) -> u64 {
    steps.potential + steps.last + steps.early
}

/// Exponents of tests.
fn grows(exponents: &[f64]) -> Verdict {
    let [low, high] = EXPONENTS;
    // Written so that a NaN contradicts.
    if exponents.is_empty() || !exponents.iter().all(|e| *e < 1.0) {
        Verdict::Refuted
    } else if exponents.iter().all(|e| (low..=high).contains(e)) {
        Verdict::Reproduced
    } else {
        Verdict::Open
    }
}

fn cost(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let (mut figures, mut exponents) = (Vec::new(), Vec::new());
    for (name, settings) in [("as the source says it", THESIS), ("our settings", OURS)] {
        let runs = runs(settings)?;
        let of = |count: fn(&Steps) -> u64| -> Vec<(f64, f64)> {
            runs.iter().map(|(lights, run)| (*lights, run.each(count))).collect()
        };
        let all = of(tests);
        for ((lights, tests), city) in all.iter().zip(CITIES) {
            figures.push(figure(
                format!("{city}, {lights} lights, {name}: tests"),
                *tests,
                "an evaluation",
            ));
        }
        exponents.push(exponent(&all));
        figures.push(figure(format!("{name}: exponent of tests"), exponent(&all), ""));
        for (step, _, count) in TABLE {
            figures.push(figure(format!("{name}: exponent, {step}"), exponent(&of(count)), ""));
        }
        let output = exponent(&of(|s| s.output));
        figures.push(figure(format!("{name}: exponent of nodes put out"), output, ""));
        figures.extend(times(name, settings)?);
    }
    let printed = |values: [f64; 3]| exponent(&LIGHTS.into_iter().zip(values).collect::<Vec<_>>());
    figures.push(figure("exponent of time, table", printed(CELL_MS), ""));
    for (step, calls, _) in TABLE {
        figures.push(figure(format!("exponent, {step}, table"), printed(calls), ""));
    }
    let told: Vec<String> = exponents.iter().map(|e| format!("{e:.2}")).collect();
    let because = format!("tests grow as lights to the {}", told.join(" and the "));
    Ok(judged(grows(&exponents), because, figures))
}

/// Times of an evaluation on one thread, and their exponent.
fn times(name: &str, settings: FacadeCluster) -> Result<Vec<Figure>, SuiteError> {
    let (mut figures, mut all) = (Vec::new(), Vec::new());
    for city in CITIES {
        let case = prepared(city, VIEW, 1)?;
        let asked = asked(&case);
        let ns = least_ns(&mut evaluator(&case, settings), &asked, TIMES) / asked.len() as f64;
        all.push((case.night().town.lights.leaves.len() as f64, ns));
        figures.push(figure(format!("{city}, {name}: time"), ns / 1e3, "us an evaluation"));
    }
    figures.push(figure(format!("{name}: exponent of time"), exponent(&all), ""));
    Ok(figures)
}

/// Last tests by city.
fn flat(tests: &[f64]) -> Verdict {
    let mean = tests.iter().sum::<f64>() / tests.len() as f64;
    if tests.is_empty() || !tests.iter().all(|t| is_about(*t, mean)) {
        Verdict::Refuted
    } else if tests.iter().all(|t| (t / mean - 1.0).abs() <= 0.1) {
        Verdict::Reproduced
    } else {
        Verdict::Open
    }
}

fn last(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let of = |settings| -> Result<Vec<f64>, SuiteError> {
        Ok(runs(settings)?.iter().map(|(_, run)| run.each(|s| s.last)).collect())
    };
    let (thesis, ours) = (of(THESIS)?, of(OURS)?);
    let mut figures = Vec::new();
    for (i, city) in CITIES.into_iter().enumerate() {
        figures.push(figure(
            format!("{city}: last tests, as the source says it"),
            thesis[i],
            "an evaluation",
        ));
        figures.push(figure(format!("{city}: last tests, our settings"), ours[i], "an evaluation"));
        let faces = prepared(city, VIEW, 1)?.frames()[0].len();
        figures.push(figure(format!("{city}: faces"), faces as f64, ""));
    }
    let told: Vec<String> = thesis.iter().map(|t| format!("{t:.0}")).collect();
    Ok(judged(flat(&thesis), format!("{} last tests an evaluation", told.join(", ")), figures))
}

/// Ratios here and there.
fn alike(ratios: &[(f64, f64)]) -> Vec<bool> {
    ratios.iter().map(|(ours, theirs)| is_about(*ours, *theirs)).collect()
}

fn table(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let runs = runs(THESIS)?;
    let (mut figures, mut ratios) = (Vec::new(), Vec::new());
    for (name, printed, of) in TABLE {
        let calls: Vec<f64> = runs.iter().map(|(_, run)| run.each(of)).collect();
        for i in 1..CITIES.len() {
            let pair = (calls[i] / calls[0], printed[i] / printed[0]);
            let what = format!("{name}, {} over {}", CITIES[i], CITIES[0]);
            figures.push(figure(format!("{what}, table"), pair.1, ""));
            figures.push(figure(format!("{what}, ours"), pair.0, ""));
            ratios.push(pair);
        }
    }
    let holds = alike(&ratios);
    Ok(judged(vote(&holds), format!("{} ratios are about the table's", count(&holds)), figures))
}

#[cfg(test)]
mod tests {
    use super::*;
    use Verdict::{Open, Refuted, Reproduced};

    #[test]
    fn growth_is_in_the_range_or_not() {
        assert_eq!(grows(&[0.4, 0.5]), Reproduced);
        assert_eq!(grows(&[0.4, 0.8]), Open);
        assert_eq!(grows(&[0.4, 1.1]), Refuted);
        assert_eq!([grows(&[f64::NAN]), grows(&[])], [Refuted, Refuted]);
    }

    #[test]
    fn last_tests_are_flat_or_not() {
        assert_eq!(flat(&[642.0, 685.0, 641.0]), Reproduced);
        assert_eq!(flat(&[642.0, 900.0, 641.0]), Open);
        assert_eq!(flat(&[100.0, 685.0, 641.0]), Refuted);
        assert_eq!([flat(&[f64::NAN]), flat(&[])], [Refuted, Refuted]);
    }

    #[test]
    fn ratios_are_alike_within_a_factor() {
        assert_eq!(vote(&alike(&[(1.2, 1.3), (2.0, 2.6)])), Reproduced);
        assert_eq!(vote(&alike(&[(1.2, 1.3), (5.0, 2.6)])), Open);
        assert_eq!(vote(&alike(&[(9.0, 1.3), (f64::NAN, 2.6)])), Refuted);
    }
}
