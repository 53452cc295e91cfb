//! H7.1 to H7.4 and H7.7: what the search for a split finds.

use super::{
    bench_times::{self, above_one},
    search_tables::{self as thesis, LAYERS, LAYERS_A11, SCENES, TABLE_A11},
    search_trials::{CORRELATION, CRITERIA, FORMS, Form, SAD, VIEWS, View, name, trials},
    verdict::{all_of, count, figure, judged, near, vote, vote_open},
};
use crate::{
    SuiteError,
    claims::{Claim, ClaimContext, Figure, Judged, Verdict},
};

/// An adopted split is near the best if it errs at most this many times as much.
const NEAR: f64 = 1.1;

/// 1 - C is in proportion to 1 / K if its slope over K, both by their logarithms, is -1 to within
/// this: the thesis's own values give -1.04 and -0.93.
const SLOPE: f64 = 0.25;

pub fn claims() -> Vec<Claim> {
    vec![
        Claim {
            id: "voicu-H7.1",
            statement: "The split of least correlation gets more even as layers are added",
            place: "Voicu 2011, section 5.2.3, figure 5.2.3.6, table A.11",
            method: "the six views of table A.11 at 4, 16 and 32 layers (its first column must be \
                     one target, hence 4), maps of 256, eleven values; as printed (the listing's \
                     table, K - 1 bins, thickness alpha, bytes) and repaired. A row agrees if \
                     lambda never rises and is less at 32 than at 4. Voted over the twelve rows, \
                     the thesis's values beside",
            judge: Box::new(by_layers),
        },
        Claim {
            id: "voicu-H7.2",
            statement: "The split of least correlation gets more logarithmic as objects get \
                        denser, and on grass as light turns from above to the side",
            place: "Voicu 2011, section 5.2.3, figure 5.2.3.5, table A.11",
            method: "4, 16 and 32 layers, both forms as in H7.1. Sparse grass to grass and grass \
                     to dense grass lit from above, grass to dense grass lit from the side; above \
                     to side on grass and on dense grass. A comparison agrees if lambda never falls \
                     at equal layers and rises at one at least (table A.11 does not rise \
                     everywhere either). Voted over ten comparisons",
            judge: Box::new(by_density),
        },
        Claim {
            id: "voicu-H7.3",
            statement: "Absolute differences and correlation move alike; correlation covers a \
                        wider range of splits",
            place: "Voicu 2011, section 5.2.3",
            method: "the rows of H7.1. Alike: of the twelve steps from 4 to 16 and from 16 to 32 \
                     layers, both adopted splits move the same way (up, down or not) in more than \
                     half. Wider: greatest less least adopted split of all rows. Both forms, each \
                     part voted over the two; the thesis's own table is counted the same way. \
                     Absolute differences of sums that never fall telescope to last less first",
            judge: Box::new(alike),
        },
        Claim {
            id: "voicu-H7.4",
            statement: "With more layers the mean correlation rises, its distance to 1 like 1/K, \
                        and frames get slower",
            place: "Voicu 2011, section 5.2.3, table 5.2.3.1",
            method: "trees, grass and dense grass at 4, 8, 16 and 32 layers, both forms, at the \
                     split of least correlation: mean C of neighbours rises strictly (voted over \
                     six rows); slope of log(1 - C) over log K is -1 within 0.25 (all rows); time \
                     of a frame of twice the layers exceeds, by more than 1.5 median absolute \
                     deviations of nine rounds, that of half (nine steps, voted; on graphics \
                     hardware where there is any, else on the processor)",
            judge: Box::new(by_number),
        },
        Claim {
            id: "voicu-H7.7",
            statement: "At the split of least correlation bounding opacity maps are no worse than \
                        the worse pure split, and near the best of all splits",
            place: "Voicu 2011, section 5.2.3 (the thesis measures no error)",
            method: "the six views of table A.11 at 4, 8, 16 and 32 layers, both forms; rms \
                     against the deep shadow map of the same texels. No worse than the worse of \
                     even and logarithmic, and at most 1.1 times the least of all eleven values; \
                     each part voted over 48 cases. The other criteria beside",
            judge: Box::new(near_best),
        },
    ]
}

/// Adopted splits of a view by a criterion at some layers.
fn adopted<const N: usize>(
    view: View,
    layers: [u32; N],
    form: Form,
    criterion: usize,
) -> Result<[f64; N], SuiteError> {
    let mut all = [0.0; N];
    for (lambda, layers) in all.iter_mut().zip(layers) {
        *lambda = f64::from(trials(view, layers, form)?.adopted(criterion).lambda);
    }
    Ok(all)
}

/// Never rises and ends lower.
fn falls(row: &[f64]) -> bool {
    let ends = row.first().zip(row.last());
    row.windows(2).all(|w| w[1] <= w[0]) && ends.is_some_and(|(first, last)| last < first)
}

fn by_layers(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let (mut figures, mut told, mut holds) = (Vec::new(), Vec::new(), Vec::new());
    for form in FORMS {
        let from = holds.len();
        for (view, theirs) in VIEWS.into_iter().zip(TABLE_A11) {
            let row = adopted(view, LAYERS_A11, form, CORRELATION)?;
            for ((layers, ours), theirs) in LAYERS_A11.iter().zip(row).zip(theirs[1]) {
                let what = format!("{}, {layers} layers", name(view));
                figures.push(figure(format!("{what}, {}: lambda", form.name()), ours, ""));
                if form == Form::Printed {
                    figures.push(figure(format!("{what}, thesis: lambda"), theirs, ""));
                }
            }
            holds.push(falls(&row));
        }
        told.push(format!("{} in {} rows", form.name(), count(&holds[from..])));
    }
    let because = format!("lambda falls with K {}", told.join(", "));
    Ok(judged(vote(&holds), because, figures))
}

/// Never below at equal layers, and above at one.
fn rises(from: &[f64], to: &[f64]) -> bool {
    from.iter().zip(to).all(|(a, b)| b >= a) && from.iter().zip(to).any(|(a, b)| b > a)
}

fn by_density(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    const STEPS: [[View; 2]; 5] = [
        [("grass_sparse", "above"), ("grass", "above")],
        [("grass", "above"), ("grass_dense", "above")],
        [("grass", "side"), ("grass_dense", "side")],
        [("grass", "above"), ("grass", "side")],
        [("grass_dense", "above"), ("grass_dense", "side")],
    ];
    let (mut figures, mut told, mut holds) = (Vec::new(), Vec::new(), Vec::new());
    for form in FORMS {
        let from = holds.len();
        for [a, b] in STEPS {
            let rows = [
                adopted(a, LAYERS_A11, form, CORRELATION)?,
                adopted(b, LAYERS_A11, form, CORRELATION)?,
            ];
            for (k, layers) in LAYERS_A11.iter().enumerate() {
                let what = format!("{} to {}, {layers} layers, {}", name(a), name(b), form.name());
                figures.push(figure(
                    format!("{what}: lambda moves by"),
                    rows[1][k] - rows[0][k],
                    "",
                ));
            }
            holds.push(rises(&rows[0], &rows[1]));
        }
        told.push(format!("{} in {} comparisons", form.name(), count(&holds[from..])));
    }
    let because = format!("lambda rises {}", told.join(", "));
    Ok(judged(vote(&holds), because, figures))
}

/// Of rows of splits by two criteria: share of steps that go the same way, and the range of each.
fn movements(rows: &[[[f64; 3]; 2]]) -> (f64, [f64; 2]) {
    let (mut same, mut steps) = (0.0, 0.0);
    let way = |w: &[f64]| w[1].total_cmp(&w[0]);
    for [a, b] in rows {
        for (a, b) in a.windows(2).zip(b.windows(2)) {
            steps += 1.0;
            same += f64::from(u8::from(way(a) == way(b)));
        }
    }
    let range = |at: usize| {
        let all = || rows.iter().flat_map(|row| row[at]);
        all().fold(f64::NEG_INFINITY, f64::max) - all().fold(f64::INFINITY, f64::min)
    };
    (same / f64::max(steps, 1.0), [range(0), range(1)])
}

fn alike(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let (mut figures, mut same, mut wider) = (Vec::new(), Vec::new(), Vec::new());
    let mut tell = |what: &str, (share, [sad, correlation]): (f64, [f64; 2])| {
        figures.push(figure(format!("{what}: steps that go the same way"), share, ""));
        figures.push(figure(format!("{what}: range by absolute differences"), sad, ""));
        figures.push(figure(format!("{what}: range by correlation"), correlation, ""));
        (share > 0.5, correlation > sad)
    };
    let theirs = tell("thesis", movements(&TABLE_A11));
    let mut at_one = 0;
    for form in FORMS {
        let mut rows = Vec::new();
        for view in VIEWS {
            let sad = adopted(view, LAYERS_A11, form, SAD)?;
            at_one += sad.iter().filter(|l| **l == 1.0).count();
            rows.push([sad, adopted(view, LAYERS_A11, form, CORRELATION)?]);
        }
        let (alike, wide) = tell(form.name(), movements(&rows));
        same.push(alike);
        wider.push(wide);
    }
    figures.push(figure("absolute differences: lambda of 1, of 36", at_one as f64, ""));
    let because = format!(
        "they move alike in {} forms and correlation covers more in {}; by the thesis's own table \
         they {} alike; absolute differences adopt 1 in {at_one} of 36",
        count(&same),
        count(&wider),
        if theirs.0 { "move" } else { "do not move" },
    );
    Ok(judged(all_of(&[vote(&same), vote(&wider)]), because, figures))
}

/// Slope of log(1 - C) over log K by least squares.
fn slope(correlations: &[f64; 4]) -> f64 {
    let x = LAYERS.map(|k| f64::from(k).ln());
    let y = correlations.map(|c| (1.0 - c).ln());
    let mean = |v: &[f64; 4]| v.iter().sum::<f64>() / 4.0;
    let (mean_x, mean_y) = (mean(&x), mean(&y));
    let rise: f64 = x.iter().zip(&y).map(|(x, y)| (x - mean_x) * (y - mean_y)).sum();
    rise / x.iter().map(|x| (x - mean_x) * (x - mean_x)).sum::<f64>()
}

/// Rows of mean correlations, and whether each step to more layers takes longer.
fn grows(rows: &[[f64; 4]], longer: &[Option<bool>]) -> Verdict {
    let rises: Vec<bool> = rows.iter().map(|r| r.windows(2).all(|w| w[1] > w[0])).collect();
    let slopes: Vec<_> = rows.iter().map(|row| (slope(row), -1.0, SLOPE)).collect();
    all_of(&[vote(&rises), near(&slopes), vote_open(longer)])
}

fn by_number(context: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let (mut figures, mut rows, mut longer) = (Vec::new(), Vec::new(), Vec::new());
    let times = bench_times::judged(context)?;
    for (at, scene) in SCENES.into_iter().enumerate() {
        figures.push(figure(
            format!("{scene}, thesis: slope"),
            slope(&thesis::CORRELATION[at]),
            "",
        ));
        for form in FORMS {
            let mut row = [0.0; 4];
            for (mean, layers) in row.iter_mut().zip(LAYERS) {
                let trials = trials((scene, "above"), layers, form)?;
                let sum = trials.adopted(CORRELATION).scores[CORRELATION];
                *mean = sum / f64::from(layers - 1);
                let what = format!("{scene}, {layers} layers, {}: mean C", form.name());
                figures.push(figure(what, *mean, ""));
            }
            figures.push(figure(format!("{scene}, {}: slope", form.name()), slope(&row), ""));
            rows.push(row);
        }
        for (k, theirs) in thesis::CORRELATION[at].iter().enumerate() {
            let what = format!("{scene}, {} layers, thesis: mean C", LAYERS[k]);
            figures.push(figure(what, *theirs, ""));
        }
        longer.extend(steps_of_time(&mut figures, &times, at)?);
    }
    let verdict = grows(&rows, &longer);
    let worst = rows.iter().map(|r| (slope(r) + 1.0).abs()).fold(0.0, f64::max);
    let slower = longer.iter().filter(|l| **l == Some(true)).count();
    let because = format!(
        "mean C rises in {} rows, its slope is at most {worst:.2} off -1; {slower} of {} steps to \
         more layers are slower ({})",
        count(&rows.iter().map(|r| r.windows(2).all(|w| w[1] > w[0])).collect::<Vec<_>>()),
        longer.len(),
        times.device,
    );
    Ok(judged(verdict, because, figures))
}

fn steps_of_time(
    figures: &mut Vec<Figure>,
    times: &bench_times::Times,
    scene: usize,
) -> Result<Vec<Option<bool>>, SuiteError> {
    let mut longer = Vec::new();
    for k in 1..LAYERS.len() {
        let ratio = times.ratio(scene, (2, k), (2, k - 1))?;
        let steps = format!("{} over {} layers", LAYERS[k], LAYERS[k - 1]);
        let what = format!("{}, {}: time of {steps}", SCENES[scene], times.device);
        figures.push(figure(what, ratio.median, ""));
        let rates = &thesis::FRAME_RATES[2][scene];
        let theirs = rates[k - 1] / rates[k];
        figures.push(figure(format!("{}, thesis: time of {steps}", SCENES[scene]), theirs, ""));
        longer.push(above_one(ratio));
    }
    Ok(longer)
}

/// Errors at the adopted split, at the two ends, and the least of all.
fn no_worse_and_near(cases: &[(f64, [f64; 2], f64)]) -> (Verdict, [Vec<bool>; 2]) {
    let no_worse: Vec<bool> = cases.iter().map(|(e, ends, _)| *e <= ends[0].max(ends[1])).collect();
    let close: Vec<bool> = cases.iter().map(|(e, _, least)| *e <= NEAR * least).collect();
    (all_of(&[vote(&no_worse), vote(&close)]), [no_worse, close])
}

fn near_best(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let (mut figures, mut all, mut because) = (Vec::new(), Vec::new(), String::new());
    for (criterion, (criterion_name, _)) in CRITERIA.iter().enumerate() {
        for form in FORMS {
            let mut cases = Vec::new();
            for view in VIEWS {
                for layers in LAYERS {
                    let trials = trials(view, layers, form)?;
                    let error = trials.adopted(criterion).error;
                    if criterion == CORRELATION {
                        let what = format!("{}, {layers} layers, {}", name(view), form.name());
                        let over = error / trials.least();
                        figures.push(figure(format!("{what}: error over the least"), over, ""));
                    }
                    cases.push((error, trials.ends(), trials.least()));
                }
            }
            let [no_worse, close] = no_worse_and_near(&cases).1;
            let mean = cases.iter().map(|(e, _, least)| (e / least).ln()).sum::<f64>();
            let mean = (mean / cases.len() as f64).exp();
            let what = format!("{criterion_name}, {}", form.name());
            figures.push(figure(format!("{what}: error over the least, mean"), mean, ""));
            let near = close.iter().filter(|c| **c).count();
            figures.push(figure(format!("{what}: near the best, of 24"), near as f64, ""));
            if criterion == CORRELATION {
                because.push_str(&format!(
                    "{}: no worse than the worse end in {} cases, near the best in {}; ",
                    form.name(),
                    count(&no_worse),
                    count(&close)
                ));
                all.extend(cases);
            }
        }
    }
    let because = because.trim_end_matches("; ").to_string();
    Ok(judged(no_worse_and_near(&all).0, because, figures))
}

#[cfg(test)]
mod tests {
    use super::*;
    use Verdict::{Open, Refuted, Reproduced};

    #[test]
    fn rows_fall_and_rise() {
        assert!(falls(&[0.7, 0.2, 0.2]) && !falls(&[0.7, 0.8, 0.2]) && !falls(&[0.7, 0.7]));
        assert!(rises(&[0.7, 0.3], &[0.7, 0.4]));
        assert!(!rises(&[0.7, 0.3], &[0.7, 0.3]) && !rises(&[0.7, 0.3], &[0.6, 0.4]));
        // The thesis's own table falls with K in every row.
        assert!(TABLE_A11.iter().all(|row| falls(&row[1])));
    }

    #[test]
    fn the_thesis_s_own_measures_do_not_move_alike() {
        let (share, [sad, correlation]) = movements(&TABLE_A11);
        assert_eq!(share, 4.0 / 12.0);
        assert!((sad - 0.8).abs() < 1e-12 && (correlation - 0.9).abs() < 1e-12);
        let rows = [[[1.0, 0.5, 0.5], [0.8, 0.2, 0.2]]];
        assert_eq!(movements(&rows).0, 1.0);
    }

    #[test]
    fn correlation_must_rise_like_one_over_k_and_frames_slow_down() {
        let good = LAYERS.map(|k| 1.0 - 1.2 / f64::from(k));
        assert!((slope(&good) + 1.0).abs() < 1e-12);
        assert_eq!(grows(&[good], &[Some(true)]), Reproduced);
        assert_eq!(grows(&[good], &[None]), Open);
        assert_eq!(grows(&[good], &[Some(false)]), Refuted);
        let root = LAYERS.map(|k| 1.0 - 1.2 / f64::from(k).sqrt());
        assert_eq!(grows(&[root], &[Some(true)]), Refuted);
        for theirs in thesis::CORRELATION {
            assert!((slope(&theirs) + 1.0).abs() < 0.08);
        }
    }

    #[test]
    fn an_adopted_split_must_be_near_the_best() {
        let good = (1.05, [2.0, 3.0], 1.0);
        let far = (1.5, [2.0, 3.0], 1.0);
        let worse = (3.5, [2.0, 3.0], 1.0);
        assert_eq!(no_worse_and_near(&[good, good]).0, Reproduced);
        assert_eq!(no_worse_and_near(&[good, far]).0, Open);
        assert_eq!(no_worse_and_near(&[far]).0, Refuted);
        assert_eq!(no_worse_and_near(&[worse]).0, Refuted);
    }
}
