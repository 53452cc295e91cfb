//! H6.1 to H6.3 and H6.6: which split tells more.

use super::{
    search_trials::{FORMS, Form, Trials, VIEWS, View, name, trials},
    verdict::{all_of, count, figure, judged, vote},
};
use crate::{
    SuiteError,
    claims::{Claim, ClaimContext, Figure, Judged},
};

/// Of the change that each map would add if all added the same: a map that adds less nearly
/// repeats the one before.
const LITTLE: f64 = 0.25;

/// Layers that pictures of all maps are shown of.
const SHOWN: [u32; 2] = [8, 16];

const DENSE: [View; 2] = [("grass_dense", "above"), ("grass_dense", "side")];
const SCATTERED: [View; 2] = [("tree", "above"), ("tree", "side")];

pub fn claims() -> Vec<Claim> {
    vec![
        Claim {
            id: "voicu-H6.1",
            statement: "In dense grass an even split leaves the last four maps nearly equal",
            place: "Voicu 2011, section 5.2, figure 5.2.2",
            method: "grass_dense lit from above and from the side, 8 and 16 maps of 256, as \
                     printed (thickness alpha, sums clipped at 1 as they are read back, K - 1 \
                     bins) and repaired (light lost, K bins). A map nearly equals the one before \
                     if the mean change between them is below a quarter of what it would be were \
                     all changes equal. Holds where that is so of the last three changes; voted \
                     over the eight cases",
            judge: Box::new(even_in_grass),
        },
        Claim {
            id: "voicu-H6.2",
            statement: "In dense grass a logarithmic split lets each map add something, and errs \
                        less than an even one",
            place: "Voicu 2011, section 5.2.1, figures 5.2.4 and 5.2.5",
            method: "as H6.1 with lambda 1 (as printed: the listing's table, which ends half way). \
                     Each map adds something where no change is below a quarter of an equal \
                     share; the error is the rms against the deep shadow map of the same texels. \
                     Both parts are voted over the eight cases",
            judge: Box::new(logarithm_in_grass),
        },
        Claim {
            id: "voicu-H6.3",
            statement: "In a scattered tree each map of an even split differs; of a logarithmic \
                        one the first four are nearly equal, and it errs more",
            place: "Voicu 2011, section 5.2.3, figures 5.2.3.2 to 5.2.3.4",
            method: "tree under the same lights, layers and forms, judged as in H6.1 and H6.2; \
                     three parts, each voted over the eight cases",
            judge: Box::new(tree),
        },
        Claim {
            id: "voicu-H6.6",
            statement: "The best mixture is never worse than the better of even and logarithmic",
            place: "Voicu 2011, section 5.2.3",
            method: "the six views of table A.11, 4, 8, 16 and 32 layers, both forms. The best of \
                     eleven includes both ends, so that it could not fail where it is chosen: it \
                     is chosen on every other receiver and judged on the rest, against the end \
                     that is better there. Voted over the 48 cases; where an end is best, that \
                     counts as no worse",
            judge: Box::new(mixture),
        },
    ]
}

/// What each map adds to the one before, over an equal share of all that is added.
fn changes(means: &[f64]) -> Vec<f64> {
    let (Some(first), Some(last)) = (means.first(), means.last()) else { return Vec::new() };
    let share = (last - first) / means.len().saturating_sub(1).max(1) as f64;
    let relative = |w: &[f64]| if share > 0.0 { (w[1] - w[0]) / share } else { 0.0 };
    means.windows(2).map(relative).collect()
}

/// Whether all of some changes are small.
fn nearly_equal(changes: &[f64]) -> bool {
    changes.iter().all(|c| *c < LITTLE)
}

/// Whether none is.
fn each_differs(changes: &[f64]) -> bool {
    changes.iter().all(|c| *c >= LITTLE)
}

/// Calls `each` for every view, number of layers and form.
fn every(
    views: &[View],
    layers: &[u32],
    mut each: impl FnMut(String, Form, &Trials),
) -> Result<(), SuiteError> {
    for form in FORMS {
        for &view in views {
            for &layers in layers {
                let what = format!("{}, {layers} layers, {}", name(view), form.name());
                each(what, form, &*trials(view, layers, form)?);
            }
        }
    }
    Ok(())
}

/// The largest of some changes.
fn most(changes: &[f64]) -> f64 {
    changes.iter().copied().fold(0.0, f64::max)
}

/// The smallest.
fn least(changes: &[f64]) -> f64 {
    changes.iter().copied().fold(f64::INFINITY, f64::min)
}

fn even_in_grass(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let (mut figures, mut holds) = (Vec::new(), Vec::new());
    every(&DENSE, &SHOWN, |what, _, trials| {
        let changes = changes(&trials.0[0].means);
        let last = &changes[changes.len() - 3..];
        figures.push(figure(format!("{what}: largest of the last 3 changes"), most(last), ""));
        holds.push(nearly_equal(last));
    })?;
    let because = format!("the last four maps are nearly equal in {} cases", count(&holds));
    Ok(judged(vote(&holds), because, figures))
}

/// Errors of an even and of a logarithmic split in figures.
fn told(figures: &mut Vec<Figure>, what: &str, [even, logarithmic]: [f64; 2]) {
    figures.push(figure(format!("{what}: error, even"), even, ""));
    figures.push(figure(format!("{what}: error, logarithmic"), logarithmic, ""));
}

fn logarithm_in_grass(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let (mut figures, mut adds, mut errs) = (Vec::new(), Vec::new(), Vec::new());
    every(&DENSE, &SHOWN, |what, _, trials| {
        let changes = changes(&trials.0[10].means);
        figures.push(figure(format!("{what}: least change"), least(&changes), ""));
        told(&mut figures, &what, trials.ends());
        adds.push(each_differs(&changes));
        errs.push(trials.ends()[1] < trials.ends()[0]);
    })?;
    let because = format!(
        "with a logarithmic split every map adds something in {} cases, and it errs less in {}",
        count(&adds),
        count(&errs)
    );
    Ok(judged(all_of(&[vote(&adds), vote(&errs)]), because, figures))
}

fn tree(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let (mut figures, mut parts) = (Vec::new(), [Vec::new(), Vec::new(), Vec::new()]);
    every(&SCATTERED, &SHOWN, |what, _, trials| {
        let (even, log) = (changes(&trials.0[0].means), changes(&trials.0[10].means));
        let first = &log[..3];
        figures.push(figure(format!("{what}: least change, even"), least(&even), ""));
        let largest = most(first);
        figures.push(figure(format!("{what}: largest of first 3, logarithmic"), largest, ""));
        told(&mut figures, &what, trials.ends());
        let holds = [each_differs(&even), nearly_equal(first), trials.ends()[1] > trials.ends()[0]];
        parts.iter_mut().zip(holds).for_each(|(part, holds)| part.push(holds));
    })?;
    let because = format!(
        "even maps all differ in {} cases, the first four logarithmic ones are nearly equal in \
         {}, the logarithmic split errs more in {}",
        count(&parts[0]),
        count(&parts[1]),
        count(&parts[2])
    );
    Ok(judged(all_of(&parts.map(|p| vote(&p))), because, figures))
}

/// Errors by split of one half of the receivers and of the other: whether the split that is best on
/// the first is no worse on the second than the better end is there.
fn carries_over(halves: &[[f64; 2]]) -> Option<(bool, usize)> {
    let (first, last) = (halves.first()?, halves.last()?);
    let better = |best: usize, at: usize| halves[at][0] < halves[best][0];
    let best = (0..halves.len()).fold(0, |best, at| if better(best, at) { at } else { best });
    Some((halves[best][1] <= first[1].min(last[1]), best))
}

fn mixture(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let (mut figures, mut holds, mut inside) = (Vec::new(), Vec::new(), 0);
    every(&VIEWS, &[4, 8, 16, 32], |what, _, trials| {
        let halves: Vec<[f64; 2]> = trials.0.iter().map(|t| t.halves).collect();
        let Some((carries, best)) = carries_over(&halves) else { return };
        holds.push(carries);
        inside += u32::from(best > 0 && best + 1 < halves.len());
        let gain = halves[best][1] / halves[0][1].min(halves[halves.len() - 1][1]);
        let lambda = f64::from(trials.0[best].lambda);
        figures.push(figure(format!("{what}: best lambda"), lambda, ""));
        figures.push(figure(format!("{what}: its error over the better end's"), gain, ""));
    })?;
    let verdict = vote(&holds);
    let because = format!(
        "the best mixture is no worse in {} cases; in {inside} it lies between the ends",
        count(&holds)
    );
    Ok(judged(verdict, because, figures))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::claims::Verdict;

    #[test]
    fn changes_are_shares_of_an_equal_one() {
        assert_eq!(changes(&[0.0, 1.0, 2.0, 3.0]), [1.0, 1.0, 1.0]);
        let late = changes(&[0.0, 2.0, 2.9, 3.0, 3.0]);
        assert!(nearly_equal(&late[2..]) && !nearly_equal(&late) && !each_differs(&late));
        assert!(each_differs(&changes(&[0.0, 1.0, 2.0, 3.0])));
        // Maps that are all the same add nothing.
        assert!(nearly_equal(&changes(&[1.0, 1.0, 1.0])));
        assert_eq!((most(&[0.5, 2.0]), least(&[0.5, 2.0])), (2.0, 0.5));
    }

    #[test]
    fn a_mixture_must_carry_over_to_the_other_half() {
        let good = [[3.0, 3.0], [1.0, 1.0], [2.0, 2.0]];
        assert_eq!(carries_over(&good), Some((true, 1)));
        let bad = [[3.0, 3.0], [1.0, 2.5], [2.0, 2.0]];
        assert_eq!(carries_over(&bad), Some((false, 1)));
        assert_eq!(carries_over(&[[1.0, 1.0], [2.0, 2.0]]), Some((true, 0)));
        assert_eq!(carries_over(&[]), None);
    }

    #[test]
    fn an_open_part_leaves_the_statement_open() {
        let parts = [vote(&[true, true]), vote(&[true, false])];
        assert_eq!(all_of(&parts), Verdict::Open);
        assert_eq!(all_of(&[vote(&[true]), vote(&[false])]), Verdict::Refuted);
    }
}
