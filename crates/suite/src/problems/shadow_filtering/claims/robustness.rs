//! H7.5: two statements about the Gaussian and the power CDF that seem to exclude each other.

use super::{
    scores::{Scores, gather, median_of},
    still::{BIASES, Score},
    verdict::{all_of, count, figure, judged, vote},
};
use crate::{
    SuiteError,
    claims::{Claim, ClaimContext, Figure, Judged},
};

pub fn claims() -> Vec<Claim> {
    vec![
        Claim {
            id: "gumbau-H7.5",
            statement: "`The Gaussian is more robust than the power CDF` and `the power CDF is \
                        better against leaks` are both true, of total error and of leaks",
            place: "Gumbau 2011, section 7.3 (L1917) against section 7.4 (L1986)",
            method: "H7.5a and H7.5b together: reproduced if both are, refuted if either is, else \
                     open. Read of one and the same figure the two statements exclude each other",
            judge: Box::new(both_statements),
        },
        Claim {
            id: "gumbau-H7.5a",
            statement: "The Gaussian CDF is more robust than the power CDF",
            place: "Gumbau 2011, section 7.3 (L1917)",
            method: "robust is read as total error: Gaussian's rmse against ray-traced truth is \
                     below the power's at every bias of 5e-4 to 5e-3 (the knob that robustness \
                     must not depend on); voted over the scenes of H7.1: all reproduced, none \
                     refuted, else open",
            judge: Box::new(|_| Ok(gaussian_robust(&gather(&[])?))),
        },
        Claim {
            id: "gumbau-H7.5b",
            statement: "The power CDF is better against light leaks than the Gaussian",
            place: "Gumbau 2011, section 7.4 (L1986)",
            method: "the power's leak energy (mean visibility where truth is 0) is below the \
                     Gaussian's at every bias of 5e-4 to 5e-3; voted over the scenes of H7.1: all \
                     reproduced, none refuted, else open",
            judge: Box::new(|_| Ok(power_leaks_less(&gather(&[])?))),
        },
    ]
}

fn gaussian_robust(all: &[Scores]) -> Judged {
    let below = |(g, p): (&Score, &Score)| g.rmse < p.rmse;
    let holds: Vec<bool> = all.iter().map(|s| s.gaussian.iter().zip(&s.power).all(below)).collect();
    let figures = compared(all, "rmse", |s| s.rmse);
    let because =
        format!("the Gaussian's rmse is the smaller at every bias on {} scenes", count(&holds));
    judged(vote(&holds), because, figures)
}

fn power_leaks_less(all: &[Scores]) -> Judged {
    let below = |(g, p): (&Score, &Score)| p.leak < g.leak;
    let holds: Vec<bool> = all.iter().map(|s| s.gaussian.iter().zip(&s.power).all(below)).collect();
    let mut figures = compared(all, "leak", |s| s.leak);
    for scene in all {
        for (bias, floor) in BIASES.iter().zip(&scene.floor) {
            let what = format!("{}: leak of the exact share, bias {bias}", scene.name);
            figures.push(figure(what, *floor, ""));
        }
    }
    let because = format!("the power CDF leaks less at every bias on {} scenes", count(&holds));
    judged(vote(&holds), because, figures)
}

fn compared(all: &[Scores], what: &str, of: impl Fn(&Score) -> f64) -> Vec<Figure> {
    let mut figures = Vec::new();
    for scene in all {
        for (i, bias) in BIASES.iter().enumerate() {
            for (name, scores) in [("Gaussian", &scene.gaussian), ("power", &scene.power)] {
                let what = format!("{}: {what}, {name}, bias {bias}", scene.name);
                figures.push(figure(what, of(&scores[i]), ""));
            }
        }
    }
    figures
}

fn both_statements(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let all = gather(&[])?;
    let (robust, leaks) = (gaussian_robust(&all), power_leaks_less(&all));
    let because = format!(
        "more robust: {} ({}); better against leaks: {} ({})",
        robust.verdict, robust.because, leaks.verdict, leaks.because
    );
    let mut figures = Vec::new();
    for scene in &all {
        let mut median = |what: &str, g: f64, p: f64| {
            figures.push(figure(format!("{}: {what}, power/Gaussian", scene.name), p / g, ""));
        };
        let (g, p) = (&scene.gaussian, &scene.power);
        median("median rmse", median_of(g, |s| s.rmse)?, median_of(p, |s| s.rmse)?);
        // A scene without any leak has no ratio.
        let leak = median_of(g, |s| s.leak)?;
        if leak > 0.0 {
            median("median leak", leak, median_of(p, |s| s.leak)?);
        }
    }
    Ok(judged(all_of(&[robust.verdict, leaks.verdict]), because, figures))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::claims::Verdict;
    use Verdict::{Open, Refuted, Reproduced};

    fn scene(gaussian: [f64; 2], power: [f64; 2]) -> Scores {
        let scores = |[leak, rmse]: [f64; 2]| {
            vec![Score { leak, bleed: leak, spots: 0.0, rmse }; BIASES.len()]
        };
        Scores {
            name: "made up".into(),
            vsm: scores(gaussian),
            vsm_max: scores(gaussian),
            gaussian: scores(gaussian),
            power: scores(power),
            floor: vec![0.0; BIASES.len()],
        }
    }

    #[test]
    fn robustness_goes_by_error_and_leaks_by_leak() {
        let both = [scene([0.2, 0.1], [0.1, 0.2])];
        assert_eq!(gaussian_robust(&both).verdict, Reproduced);
        assert_eq!(power_leaks_less(&both).verdict, Reproduced);
        let neither = [scene([0.1, 0.2], [0.2, 0.1])];
        assert_eq!(gaussian_robust(&neither).verdict, Refuted);
        assert_eq!(power_leaks_less(&neither).verdict, Refuted);
        let mixed = [scene([0.2, 0.1], [0.1, 0.2]), scene([0.1, 0.2], [0.2, 0.1])];
        assert_eq!(gaussian_robust(&mixed).verdict, Open);
        assert_eq!(power_leaks_less(&mixed).verdict, Open);
        // One bias against it is enough.
        let mut once = scene([0.2, 0.1], [0.1, 0.2]);
        once.power[3].rmse = 0.05;
        once.power[3].leak = 0.3;
        assert_eq!(gaussian_robust(&[once]).verdict, Refuted);
    }
}
