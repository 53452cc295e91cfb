//! D7.6: the error function as it is printed.

use super::verdict::{figure, judged};
use crate::{
    SuiteError,
    claims::{Claim, ClaimContext, Judged, Verdict},
};
use dapple_shadows::filtering::estimators::{erf, gaussian};

pub fn claims() -> Vec<Claim> {
    vec![Claim {
        id: "gumbau-D7.6",
        statement: "The printed approximation of erf lacks the sign: it is not odd, but eq. 7.4, \
                    which sees no negative argument, is unaffected",
        place: "Gumbau 2011, section 7.2.1, below eq. 7.3",
        method: "literal against repaired formula at 20,001 arguments from -5 to 5, f64: they must \
                 be equal to the bit from 0 up, and below 0 differ by exactly twice the repaired \
                 magnitude; eq. 7.4 with either must agree to 1e-12 (its forms round differently) \
                 beyond the mean, at 2,000 depths and deviations of 0.001, 0.1 and 1",
        judge: Box::new(printed),
    }]
}

/// Largest differences.
struct Differences {
    /// For arguments from 0 up.
    positive: f64,
    /// Below 0.
    negative: f64,
    /// Below 0, from twice the repaired magnitude.
    unexplained: f64,
    /// Of eq. 7.4 with its guard.
    visibility: f64,
}

fn decide(d: &Differences) -> Verdict {
    let stated =
        d.positive == 0.0 && d.negative > 1.0 && d.unexplained == 0.0 && d.visibility <= 1e-12;
    if stated { Verdict::Reproduced } else { Verdict::Refuted }
}

fn printed(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let mut d = Differences { positive: 0.0, negative: 0.0, unexplained: 0.0, visibility: 0.0 };
    for i in -10_000..=10_000 {
        let x = f64::from(i) * 5e-4;
        let (literal, repaired) = (literal(x), erf::erf(x));
        let difference = (literal - repaired).abs();
        if x < 0.0 {
            d.negative = d.negative.max(difference);
            d.unexplained = d.unexplained.max((difference - 2.0 * repaired.abs()).abs());
        } else {
            d.positive = d.positive.max(difference);
        }
    }
    for deviation in [0.001_f64, 0.1, 1.0] {
        for i in 1..=2000 {
            let distance = f64::from(i) * 2.5e-3 * deviation;
            let square = 0.5 * 0.5 + deviation * deviation;
            let z = 0.5 + distance;
            let repaired = gaussian::visibility(0.5, square, z, 0.0);
            // What the estimator works on: the variance of the stored moments.
            let variance = square - 0.5 * 0.5;
            let literal = 1.0 - literal((z - 0.5) / (2.0 * variance).sqrt());
            d.visibility = d.visibility.max((literal - repaired).abs());
        }
    }
    // Eq. 7.3 a deviation before the mean: the share that is nearer.
    let share = |erf: fn(f64) -> f64| 0.5 * (1.0 + erf(-std::f64::consts::FRAC_1_SQRT_2));
    let figures = vec![
        figure("largest difference, arguments from 0 up", d.positive, ""),
        figure("largest difference, arguments below 0", d.negative, ""),
        figure("of that not twice the magnitude", d.unexplained, ""),
        figure("largest difference of eq. 7.4 beyond the mean", d.visibility, ""),
        figure("eq. 7.3 one deviation before the mean, printed", share(literal), ""),
        figure("the same, repaired", share(erf::erf), ""),
    ];
    let because = format!(
        "equal from 0 up, apart by up to {:.2} below; eq. 7.4 differs by {:.0e}",
        d.negative, d.visibility
    );
    Ok(judged(decide(&d), because, figures))
}

/// The formula as it is printed.
fn literal(x: f64) -> f64 {
    erf::erf_printed(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_missing_sign_is_accepted() {
        let missing =
            || Differences { positive: 0.0, negative: 2.0, unexplained: 0.0, visibility: 1e-15 };
        assert_eq!(decide(&missing()), Verdict::Reproduced);
        assert_eq!(decide(&Differences { negative: 0.0, ..missing() }), Verdict::Refuted);
        assert_eq!(decide(&Differences { positive: 1e-9, ..missing() }), Verdict::Refuted);
        assert_eq!(decide(&Differences { unexplained: 0.1, ..missing() }), Verdict::Refuted);
        assert_eq!(decide(&Differences { visibility: 1e-6, ..missing() }), Verdict::Refuted);
    }

    #[test]
    fn the_literal_formula_is_the_printed_one() {
        // sqrt(1 - exp(-x^2 (4/pi + a x^2) / (1 + a x^2))), whatever the sign of x.
        for x in [-2.0_f64, -0.3, 0.3, 2.0] {
            let (square, a) = (x * x, 0.140_012_288_686_666);
            let by_hand = (1.0
                - (-square * (4.0 / std::f64::consts::PI + a * square) / (1.0 + a * square)).exp())
            .sqrt();
            assert!((literal(x) - by_hand).abs() < 1e-9, "{x}");
        }
    }
}
