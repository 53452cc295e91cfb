//! Maps of eleven splits, scored by every criterion and held against the deep shadow map: made
//! once, shared by what is said of splits and of the search for them.

use super::support::{Method, Still, bom_split, still, still_with, thesis_bins, thesis_reading};
use crate::SuiteError;
use dapple_opacity_maps::{
    Blur, Criterion, Lookup, SplitKind,
    cpu::Maps,
    search::{Layers, Scorer, Scoring, Steps, criteria::is_better},
};
use std::{cell::RefCell, collections::BTreeMap, rc::Rc};

/// A scene and its light.
pub type View = (&'static str, &'static str);

/// The views of table A.11, in its order.
pub const VIEWS: [View; 6] = [
    ("tree", "above"),
    ("tree", "side"),
    ("grass", "above"),
    ("grass", "side"),
    ("grass_dense", "above"),
    ("grass_dense", "side"),
];

/// Criteria that see maps alone, in the order of [`Trial::scores`].
pub const CRITERIA: [(&str, Criterion); 5] = [
    ("correlation", Criterion::Correlation),
    ("absolute differences", Criterion::Sad),
    ("mutual information", Criterion::MutualInformation),
    ("equal opacity", Criterion::EqualOpacity),
    ("equal transmittance", Criterion::EqualTransmittance),
];

/// Place of a criterion in [`CRITERIA`].
pub const CORRELATION: usize = 0;
/// The same of the sum of absolute differences.
pub const SAD: usize = 1;

/// How maps are made and scored.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Form {
    /// The listing's table, K - 1 bins, thickness alpha, casters of weight 3, scored in bytes. Read
    /// like the other: the layer's own sum errs so much by itself that no split would show.
    Printed,
    /// The normalised logarithm, K bins, interpolated, scored in floats.
    Repaired,
}

/// Both.
pub const FORMS: [Form; 2] = [Form::Printed, Form::Repaired];

impl Form {
    /// In figures.
    pub fn name(self) -> &'static str {
        match self {
            Self::Printed => "as printed",
            Self::Repaired => "repaired",
        }
    }

    /// Bounding opacity maps of this form.
    pub fn method(self, layers: u32, lambda: f32) -> Method {
        match self {
            Self::Printed => {
                let printed = thesis_bins(bom_split(layers, lambda, SplitKind::Listing));
                let mut method = thesis_reading(printed).lookup(Lookup::Lerp);
                method.settings.blur = Blur::Transmittance;
                method
            }
            Self::Repaired => bom_split(layers, lambda, SplitKind::Normalised),
        }
    }

    /// How a criterion sees these maps.
    pub fn scoring(self, criterion: Criterion) -> Scoring {
        match self {
            Self::Printed => Scoring::thesis(criterion),
            Self::Repaired => Scoring::plain(criterion),
        }
    }

    /// What a map shows of a sum: clipped at 1 as it is read back, or light that is lost.
    fn shown(self, sum: f32) -> f64 {
        match self {
            Self::Printed => f64::from(sum.clamp(0.0, 1.0)),
            Self::Repaired => -(-f64::from(sum)).exp_m1(),
        }
    }
}

/// The maps of one split.
#[derive(Clone, Debug)]
pub struct Trial {
    /// The split.
    pub lambda: f32,
    /// By the criteria of [`CRITERIA`].
    pub scores: [f64; 5],
    /// Against the deep shadow map of the same texels, all receivers.
    pub error: f64,
    /// The same of every other receiver, and of the rest.
    pub halves: [f64; 2],
    /// Mean of what each map shows.
    pub means: Vec<f64>,
}

/// The maps of splits 0, 0.1, .. 1.
pub struct Trials(pub Vec<Trial>);

impl Trials {
    /// The trial that a criterion of [`CRITERIA`] adopts: the first of the best.
    pub fn adopted(&self, criterion: usize) -> &Trial {
        let better = |best: usize, at: usize| {
            is_better(
                CRITERIA[criterion].1,
                self.0[at].scores[criterion],
                self.score(best, criterion),
            )
        };
        let best = (0..self.0.len()).fold(0, |best, at| if better(best, at) { at } else { best });
        &self.0[best]
    }

    fn score(&self, at: usize, criterion: usize) -> f64 {
        self.0[at].scores[criterion]
    }

    /// The least error of all.
    pub fn least(&self) -> f64 {
        self.0.iter().map(|t| t.error).fold(f64::INFINITY, f64::min)
    }

    /// Errors of the even and of the logarithmic split.
    pub fn ends(&self) -> [f64; 2] {
        [self.0[0].error, self.0[self.0.len() - 1].error]
    }
}

/// A view's still.
///
/// # Errors
/// Those of [`still`].
pub fn still_of((scene, light): View) -> Result<Rc<Still>, SuiteError> {
    match light {
        // The generated scenes' own.
        "above" => still(scene),
        _ => still_with(scene, 0, &[("light", light.into())]),
    }
}

/// Trials of a view at some layers in a form, made at the first call.
///
/// # Errors
/// Those of [`still`].
pub fn trials(view: View, layers: u32, form: Form) -> Result<Rc<Trials>, SuiteError> {
    type Made = BTreeMap<(View, u32, Form), Rc<Trials>>;
    thread_local! {
        static MADE: RefCell<Made> = const { RefCell::new(BTreeMap::new()) };
    }
    let key = (view, layers, form);
    if let Some(made) = MADE.with_borrow(|made| made.get(&key).map(Rc::clone)) {
        return Ok(made);
    }
    let made = Rc::new(make(view, layers, form)?);
    MADE.with_borrow_mut(|all| all.insert(key, Rc::clone(&made)));
    Ok(made)
}

fn make(view: View, layers: u32, form: Form) -> Result<Trials, SuiteError> {
    let yardstick = Yardstick::new(still_of(view)?, &form.method(layers, 0.0))?;
    let mut scorers = CRITERIA.map(|(_, criterion)| Scorer::new(form.scoring(criterion)));
    let mut trials = Vec::new();
    for step in 0..Steps::THESIS.values() {
        let lambda = Steps::THESIS.lambda(step);
        let method = form.method(layers, lambda);
        let maps = yardstick.still.maps(&method)?;
        let (k, words, side) = (layers as usize, maps.code().words(), method.resolution);
        let all = Layers::new((side, side), k, words, words - k, maps.words())?;
        let mut scores = [0.0; 5];
        for (score, scorer) in scores.iter_mut().zip(&mut scorers) {
            *score = scorer.score(&all)?;
        }
        let mean = |layer: usize| {
            let sum: f64 = (0..maps.texels()).map(|t| form.shown(all.texel(t)[layer])).sum();
            sum / maps.texels() as f64
        };
        let (error, halves) = yardstick.errors(&maps)?;
        let means = (0..k).map(mean).collect();
        trials.push(Trial { lambda, scores, error, halves, means });
    }
    Ok(Trials(trials))
}

/// The deep shadow map's answer to every receiver, with a method's model, taps and bias.
pub struct Yardstick {
    still: Rc<Still>,
    deep: Vec<f32>,
}

impl Yardstick {
    /// Of a method's grid.
    ///
    /// # Errors
    /// Those of [`Still::deep`].
    pub fn new(still: Rc<Still>, method: &Method) -> Result<Self, SuiteError> {
        Ok(Self { deep: still.deep(method)?, still })
    }

    /// The layering error of maps of the same grid: of all receivers, and of either half of them.
    ///
    /// # Errors
    /// A value that is not finite.
    pub fn errors(&self, maps: &Maps) -> Result<(f64, [f64; 2]), SuiteError> {
        let (shaded, mask) = (self.still.shade(maps)?, self.still.case.mask());
        let rest = |half: usize| {
            let kept: Vec<bool> =
                mask.iter().enumerate().map(|(i, m)| *m && i % 2 == half).collect();
            dapple_metrics::rmse(&shaded, &self.deep, Some(&kept))
        };
        Ok((dapple_metrics::rmse(&shaded, &self.deep, Some(mask))?, [rest(0)?, rest(1)?]))
    }

    /// The layering error of a method of the same grid, and its error against light rays.
    ///
    /// # Errors
    /// Settings that are refused.
    pub fn of(&self, method: &Method) -> Result<Errors, SuiteError> {
        let maps = self.still.maps(method)?;
        let (shaded, mask) = (self.still.shade(&maps)?, Some(self.still.case.mask()));
        Ok(Errors {
            layering: dapple_metrics::rmse(&shaded, &self.deep, mask)?,
            rmse: dapple_metrics::rmse(&shaded, self.still.case.truth(), mask)?,
        })
    }
}

/// How wrong a method is.
#[derive(Clone, Copy, Debug)]
pub struct Errors {
    /// Against the deep shadow map of the same texels.
    pub layering: f64,
    /// Against light rays.
    pub rmse: f64,
}

/// In figures.
pub fn name((scene, light): View) -> String {
    format!("{scene}, light {light}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_of_the_best_is_adopted() {
        let trial = |lambda, correlation, sad| Trial {
            lambda,
            scores: [correlation, sad, 0.0, 0.0, 0.0],
            error: f64::from(lambda),
            halves: [0.0; 2],
            means: Vec::new(),
        };
        let trials = Trials(vec![trial(0.0, 3.0, 1.0), trial(0.5, 2.0, 4.0), trial(1.0, 2.0, 4.0)]);
        assert_eq!(trials.adopted(CORRELATION).lambda, 0.5);
        assert_eq!(trials.adopted(SAD).lambda, 0.5);
        assert_eq!(trials.adopted(2).lambda, 0.0);
        assert_eq!((trials.least(), trials.ends()), (0.0, [0.0, 1.0]));
    }

    #[test]
    fn trials_are_made_once_and_agree_with_the_definition() {
        let view = ("grass_sparse", "above");
        let made = trials(view, 4, Form::Repaired).unwrap();
        assert!(Rc::ptr_eq(&made, &trials(view, 4, Form::Repaired).unwrap()));
        assert_eq!(made.0.len(), 11);
        let method = Form::Repaired.method(4, made.0[3].lambda);
        let expected = still_of(view).unwrap().score(&method).unwrap().layering;
        assert!((made.0[3].error - expected).abs() < 1e-12);
        // Sums never fall, so neither does what they show; the last does not depend on the split.
        for trial in &made.0 {
            assert!(trial.means.windows(2).all(|w| w[0] <= w[1]));
            assert!((trial.means[3] - made.0[0].means[3]).abs() < 1e-6);
        }
        // And the split matters.
        assert!(made.0[0].means[0] > made.0[10].means[0]);
    }
}
