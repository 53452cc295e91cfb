//! How work grows with lights.

use super::{
    cuts::{TABLE, TREES},
    support::{FINE, VIEWS, cut, prepared, run, setting},
    verdict::{all_of, exponent, figure, judged},
};
use crate::{
    SuiteError,
    claims::{Claim, ClaimContext, Judged, Verdict},
    problem::Form,
};
use serde_json::json;

/// Generated cities, smallest first, all by one layout.
const CITIES: [&str; 4] = ["city_small", "city", "city_9", "city_15"];

/// Exponents below which growth is sublinear by more than the fit's own doubt.
const SUBLINEAR: f64 = 0.9;

/// How many times fewer evaluations count as a significant speedup.
const SIGNIFICANT: f64 = 2.0;

pub fn claims() -> Vec<Claim> {
    vec![
        Claim {
            id: "conte-H3.12",
            statement: "Work of all lights at every pixel grows linearly with lights, work of cuts \
                        more slowly",
            place: "Conte 2018, sections 1 and 2.4.2",
            method: "cities of four sizes (of three but for the close-ended street), three views, \
                     64 x 36: evaluations a pixel of brute force, and visits a pixel of R4 (revised \
                     tree, T = 1/25500), as powers of the lights by a straight line through \
                     logarithms. Met if brute force's is 1 to 1e-3 and each view's is below 0.9; \
                     contradicted if brute force's is not, or one is 1 or more",
            judge: Box::new(growth),
        },
        Claim {
            id: "conte-3.2-speedup",
            statement: "Comparing each cluster's bound with a threshold gives a significant speedup \
                        over all lights",
            place: "Conte 2018, section 3.2",
            method: "light evaluations of brute force over node visits of R4 at T = 1/25500 from the \
                     root, four views of the city, by the revised tree: more than twice in every view \
                     is met, fewer than visits in any contradicts. A visit costs about as much as an \
                     evaluation; both trees and the coarser thresholds stand beside",
            judge: Box::new(speedup),
        },
    ]
}

/// Exponents of brute force, and of cuts view by view.
fn grows(brute_force: f64, cuts: &[f64]) -> Verdict {
    // Written so that a NaN contradicts.
    let is_linear = (brute_force - 1.0).abs() <= 1e-3;
    if !is_linear || !cuts.iter().all(|e| *e < 1.0) {
        Verdict::Refuted
    } else if cuts.iter().all(|e| *e < SUBLINEAR) {
        Verdict::Reproduced
    } else {
        Verdict::Open
    }
}

fn growth(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let (mut figures, mut cuts, mut all) = (Vec::new(), Vec::new(), Vec::new());
    for view in ["close_ended", "street", "birds_eye"] {
        let mut visits = Vec::new();
        // The largest takes long to load: it is looked at once.
        let cities = if view == TABLE.1 { &CITIES[..] } else { &CITIES[..CITIES.len() - 1] };
        for city in cities {
            let case = prepared(city, view, &[("width", json!(64)), ("truth_pixels", json!(1))])?;
            let lights = case.world().lights.len() as f64;
            let run_ = run(&case, &cut("city", FINE)?)?;
            visits.push((lights, run_.a_pixel(|w| w.visits)));
            figures.push(figure(
                format!("{view}, {lights} lights: visits"),
                visits[visits.len() - 1].1,
                "",
            ));
            if view == TABLE.1 {
                let brute = run(&case, &setting("brute-force", Form::Cpu, &[])?)?;
                all.push((lights, brute.a_pixel(|w| w.lights)));
            }
        }
        cuts.push(exponent(&visits));
        figures.push(figure(format!("{view}: exponent of visits"), exponent(&visits), ""));
    }
    let brute_force = exponent(&all);
    figures.push(figure("exponent of evaluations by brute force", brute_force, ""));
    let told: Vec<String> = cuts.iter().map(|e| format!("{e:.2}")).collect();
    let because = format!(
        "visits grow as lights to the power of {}; evaluations to {brute_force:.3}",
        told.join(", ")
    );
    Ok(judged(grows(brute_force, &cuts), because, figures))
}

/// How many times fewer, view by view.
fn is_significant(fewer: &[f64]) -> Verdict {
    let one = |f: &f64| {
        if *f > SIGNIFICANT {
            Verdict::Reproduced
        } else if *f >= 1.0 {
            Verdict::Open
        } else {
            Verdict::Refuted
        }
    };
    all_of(&fewer.iter().map(one).collect::<Vec<_>>())
}

fn speedup(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let (mut figures, mut fewer) = (Vec::new(), Vec::new());
    for view in VIEWS {
        let case = prepared(TABLE.0, view, &[])?;
        let lights = case.world().lights.len() as f64;
        for tree in TREES {
            for threshold in [FINE, super::support::COARSE] {
                let ratio = lights / run(&case, &cut(tree, threshold)?)?.a_pixel(|w| w.visits);
                let at = format!("{view}, {tree}, T = 1/{:.0}", 1.0 / threshold);
                figures.push(figure(format!("{at}: evaluations over visits"), ratio, ""));
                if tree == TREES[0] && threshold == FINE {
                    fewer.push(ratio);
                }
            }
        }
    }
    let told: Vec<String> = fewer.iter().map(|f| format!("{f:.1}")).collect();
    let because = format!("brute force evaluates {} times what is visited", told.join(", "));
    Ok(judged(is_significant(&fewer), because, figures))
}

#[cfg(test)]
mod tests {
    use super::*;
    use Verdict::{Open, Refuted, Reproduced};

    #[test]
    fn growth_is_as_said_or_not() {
        assert_eq!(grows(1.0, &[0.4, 0.6]), Reproduced);
        assert_eq!(grows(1.0, &[0.4, 0.95]), Open);
        assert_eq!(grows(1.0, &[0.4, 1.1]), Refuted);
        assert_eq!(grows(0.9, &[0.4]), Refuted);
        assert_eq!(grows(1.0, &[f64::NAN]), Refuted);
    }

    #[test]
    fn speedups_are_significant_or_not() {
        assert_eq!(is_significant(&[3.0, 30.0]), Reproduced);
        assert_eq!(is_significant(&[1.5, 30.0]), Open);
        assert_eq!(is_significant(&[0.5, 30.0]), Refuted);
        assert_eq!(is_significant(&[f64::NAN]), Refuted);
    }
}
