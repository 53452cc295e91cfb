//! D7.3 and D7.5: windows of two depths, whose answers are known.

use super::{
    still::{Recipe, VSM},
    verdict::{all_of, figure, judged, near},
};
use crate::{
    SuiteError,
    claims::{Claim, ClaimContext, Judged, Verdict},
};
use dapple_shadows::filtering::{
    Estimator, Settings,
    estimators::{chebyshev, gaussian, power},
};

pub fn claims() -> Vec<Claim> {
    vec![
        Claim {
            id: "gumbau-D7.3",
            statement: "Behind two occluders in line Chebyshev and the Gaussian leak (0.100 and \
                        0.0027, 0.308 and 0.134, 0.410 and 0.230 where the second gap is 1, 1/4 \
                        and 1/10 of the first) and the power CDF not at all",
            place: "Follows from Gumbau 2011, figure 2.9, eqs. 2.2, 7.4 and 7.7",
            method: "A at 0 and B at 1, half the window each, receiver at 1 + gap: f64, within 1e-3 \
                     of the figures (half their last digit, 5e-4, and the approximate erf, 3.4e-4; \
                     exact erf gives 0.1336 where the approximation gives 0.1334) and 1e-4 of \
                     0.0027, the power CDF exactly 0. On the scene three_planes \
                     (256 px, map 512, window 7, bias 1e-3, f32, cpu form) its bleed over the \
                     exact share must be exactly 0 too while the others' is not",
            judge: Box::new(in_line),
        },
        Claim {
            id: "gumbau-D7.5",
            statement: "On a planar edge Chebyshev is exact, the Gaussian too dark by up to a \
                        quarter and the power CDF dark for any cover: the table of 15 figures",
            place: "Follows from Gumbau 2011, eqs. 2.2, 7.4, 7.6 and 7.7, for two depths",
            method: "shares p = 0.1, 0.25, 0.5, 0.75, 0.9 at depth 0, the rest and the receiver at \
                     1; the power's receiver at 0.95. f64, within 1e-3 of the table (three digits \
                     and the approximate erf of 3.4e-4)",
            judge: Box::new(table),
        },
    ]
}

/// p; truth, which is Chebyshev; Gaussian; power at a bias of 0.05.
const TABLE: [[f64; 4]; 5] = [
    [0.10, 0.900, 0.739, 0.604],
    [0.25, 0.750, 0.564, 0.247],
    [0.50, 0.500, 0.317, 0.100],
    [0.75, 0.250, 0.083, 0.046],
    [0.90, 0.100, 0.003, 0.025],
];

/// Chebyshev, Gaussian and power for a share `p` at 0, the rest at 1 and a receiver at `z`.
fn of_two(p: f64, z: f64) -> [f64; 3] {
    let (mean, square) = (1.0 - p, 1.0 - p);
    [
        chebyshev::visibility(mean, square, z, 0.0),
        gaussian::visibility(mean, square, z, 0.0),
        power::visibility(0.0, 1.0, mean, z, 0.0),
    ]
}

fn table(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let (mut figures, mut values) = (Vec::new(), Vec::new());
    for [p, chebyshev, gaussian, power] in TABLE {
        let [c, g, _] = of_two(p, 1.0);
        let [_, _, w] = of_two(p, 0.95);
        for (name, got, expected) in
            [("Chebyshev", c, chebyshev), ("Gaussian", g, gaussian), ("power, bias 0.05", w, power)]
        {
            figures.push(figure(format!("p = {p}: {name} (table: {expected:.3})"), got, ""));
            values.push((got, expected, 1e-3));
        }
    }
    let worst = values.iter().map(|(a, b, _)| (a - b).abs()).fold(0.0, f64::max);
    let because = format!("{} figures, largest deviation {worst:.1e}", values.len());
    Ok(judged(near(&values), because, figures))
}

/// Exactly 0 for one and above 0 for the others.
fn alone_is_zero(power: &[f64], others: &[f64]) -> Verdict {
    let stated = power.iter().all(|p| *p == 0.0) && others.iter().all(|o| *o > 0.0);
    if stated { Verdict::Reproduced } else { Verdict::Refuted }
}

fn in_line(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let (mut figures, mut values) = (Vec::new(), Vec::new());
    let (mut powers, mut others) = (Vec::new(), Vec::new());
    for (gap, chebyshev, gaussian) in
        [(1.0, 0.100, 0.0027), (0.25, 0.308, 0.134), (0.1, 0.410, 0.230)]
    {
        let [c, g, w] = of_two(0.5, 1.0 + gap);
        values.push((c, chebyshev, 1e-3));
        values.push((g, gaussian, if gaussian < 0.01 { 1e-4 } else { 1e-3 }));
        figures.push(figure(format!("gap {gap}: Chebyshev (predicted {chebyshev})"), c, ""));
        figures.push(figure(format!("gap {gap}: Gaussian (predicted {gaussian})"), g, ""));
        figures.push(figure(format!("gap {gap}: power"), w, ""));
        powers.push(w);
    }
    let still = Recipe::of("three_planes", "", 0).still()?;
    for (name, estimator) in
        [("Chebyshev", VSM), ("Gaussian", Estimator::GaussianCdf), ("power", Estimator::PowerCdf)]
    {
        let s: Settings = still.settings(estimator, 1e-3);
        let score = still.score(&s)?;
        figures.push(figure(format!("three_planes: bleed, {name}"), score.bleed, ""));
        let (result, dark) = (still.shade(&s)?, still.truth.iter().zip(&still.mask));
        let most = result.iter().zip(dark).filter(|(_, (t, m))| **m && **t == 0.0);
        let most = most.map(|(v, _)| f64::from(*v)).fold(0.0, f64::max);
        figures.push(figure(format!("three_planes: brightest full shadow, {name}"), most, ""));
        if estimator == Estimator::PowerCdf {
            powers.push(score.bleed);
        } else {
            others.push(score.bleed);
        }
    }
    let parts = [near(&values), alone_is_zero(&powers, &others)];
    let worst = values.iter().map(|(a, b, _)| (a - b).abs()).fold(0.0, f64::max);
    let because = format!(
        "largest deviation from the predicted leaks {worst:.1e}; the power CDF bleeds {} in every \
         case at most",
        powers.iter().copied().fold(0.0, f64::max)
    );
    Ok(judged(all_of(&parts), because, figures))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_depths_by_hand() {
        // Half at 0, half at 1, receiver at 2: variance 1/4, distance 3/2, 0.25 / 2.5.
        let [c, _, w] = of_two(0.5, 2.0);
        assert!((c - 0.1).abs() < 1e-15);
        assert_eq!(w, 0.0);
        // Chebyshev is exact at the farther depth.
        assert!((of_two(0.25, 1.0)[0] - 0.75).abs() < 1e-15);
    }

    #[test]
    fn a_trace_of_light_refutes() {
        assert_eq!(alone_is_zero(&[0.0, 0.0], &[0.1]), Verdict::Reproduced);
        assert_eq!(alone_is_zero(&[0.0, 1e-9], &[0.1]), Verdict::Refuted);
        assert_eq!(alone_is_zero(&[0.0], &[0.1, 0.0]), Verdict::Refuted);
    }
}
