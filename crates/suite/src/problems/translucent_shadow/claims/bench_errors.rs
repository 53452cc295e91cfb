//! H10.4 and H10.5: how many layers of which method err alike.

use super::{
    bench_times::{self, above_one},
    search_tables::{FRAME_RATES, SCENES},
    search_trials::{Errors, Yardstick},
    support::{Method, bom, bom_split, dom, layered, osm, still},
    verdict::{all_of, count, figure, judged, vote, vote_open},
};
use crate::{
    SuiteError,
    claims::{Claim, ClaimContext, Figure, Judged, Verdict},
};
use dapple_opacity_maps::{Layout, SplitKind, search::Steps};

/// Parts of the deepest ray that a deep opacity map's layers are tried at.
const SPANS: [f32; 4] = [1.0, 0.7, 0.5, 0.35];

/// How much deeper each of its layers is than the one before.
const GROWTHS: [f32; 3] = [1.0, 1.2, 1.5];

pub fn claims() -> Vec<Claim> {
    vec![
        Claim {
            id: "voicu-H10.4",
            statement: "Four bounding layers look like sixteen deep ones and take less time",
            place: "Voicu 2011, section 6.3, tables 6.2.1 and 6.3.1",
            method: "trees, grass, dense grass and hair, 256 texels, 3 x 3 taps: rms against the \
                     deep shadow map of the same texels. As the thesis uses them (even layers, \
                     deep ones as far as the deepest ray), and each at its best (lambda of \
                     eleven; four spans and three growths): the error must not be greater, voted \
                     over the eight cases. Time: as in H10.1, ratio above 1 by 1.5 deviations, \
                     voted over the three scenes of the tables",
            judge: Box::new(few),
        },
        Claim {
            id: "voicu-H10.5",
            statement: "Sixteen bounding layers err no more than 128 opacity maps or 32 deep ones",
            place: "Voicu 2011, sections 3.3, 5 and 6.3 (the thesis measures no error)",
            method: "as the first part of H10.4; each comparison is voted over the eight cases \
                     (opacity maps at their best: even planes or such by density)",
            judge: Box::new(many),
        },
    ]
}

const SEEN: [&str; 4] = [SCENES[0], SCENES[1], SCENES[2], "hair"];

/// A scene that methods are held against each other on.
struct Bench {
    name: &'static str,
    yardstick: Yardstick,
    deepest: f32,
}

impl Bench {
    fn new(name: &'static str) -> Result<Self, SuiteError> {
        let still = still(name)?;
        let deepest = still.deepest()?;
        Ok(Self { name, yardstick: Yardstick::new(still, &bom(1))?, deepest })
    }

    /// Errors of the first of some methods, and of the best of all.
    fn errors(&self, methods: &[Method]) -> Result<[Errors; 2], SuiteError> {
        let all: Result<Vec<Errors>, _> = methods.iter().map(|m| self.yardstick.of(m)).collect();
        let all = all?;
        let best = all.iter().copied().min_by(|a, b| a.layering.total_cmp(&b.layering));
        match (all.first(), best) {
            (Some(first), Some(best)) => Ok([*first, best]),
            _ => Err(SuiteError::Internal("no method to compare".into())),
        }
    }

    fn bounding(&self, layers: u32) -> Result<[Errors; 2], SuiteError> {
        let lambdas = (0..Steps::THESIS.values()).map(|step| Steps::THESIS.lambda(step));
        let methods: Vec<_> =
            lambdas.map(|l| bom_split(layers, l, SplitKind::Normalised)).collect();
        self.errors(&methods)
    }

    fn deep(&self, layers: u32) -> Result<[Errors; 2], SuiteError> {
        let mut methods = vec![dom(layers, self.deepest)];
        for growth in GROWTHS {
            for part in SPANS {
                let span = part * self.deepest;
                methods.push(layered(Layout::Deep { span, growth, listing: false }, layers));
            }
        }
        self.errors(&methods)
    }

    fn planes(&self, layers: u32) -> Result<[Errors; 2], SuiteError> {
        let density = Layout::Planes(dapple_opacity_maps::Slicing::Density);
        self.errors(&[osm(layers), layered(density, layers)])
    }
}

/// Adds both errors to the figures; whether the first does not exceed the second, as used and at
/// its best.
fn compare(
    figures: &mut Vec<Figure>,
    scene: &str,
    (name, ours): (&str, [Errors; 2]),
    (other_name, other): (&str, [Errors; 2]),
) -> [bool; 2] {
    for (at, how) in ["even", "best"].into_iter().enumerate() {
        for (name, e) in [(name, ours[at]), (other_name, other[at])] {
            figures.push(figure(format!("{scene}, {how}: {name}, layering error"), e.layering, ""));
            figures.push(figure(format!("{scene}, {how}: {name}, error"), e.rmse, ""));
        }
    }
    [0, 1].map(|at| ours[at].layering <= other[at].layering)
}

/// Cases in which the error is no greater, and ratios of time.
fn matches(no_worse: &[bool], faster: &[Option<bool>]) -> Verdict {
    all_of(&[vote(no_worse), vote_open(faster)])
}

fn few(context: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let (mut figures, mut holds) = (Vec::new(), Vec::new());
    for scene in SEEN {
        let bench = Bench::new(scene)?;
        let pair = (("bom 4", bench.bounding(4)?), ("dom 16", bench.deep(16)?));
        holds.extend(compare(&mut figures, bench.name, pair.0, pair.1));
    }
    let times = bench_times::judged(context)?;
    let mut faster = Vec::new();
    for (scene, name) in SCENES.into_iter().enumerate() {
        let ratio = times.ratio(scene, (1, 2), (2, 0))?;
        let what = format!("{name}: time of dom 16 over bom 4");
        figures.push(figure(format!("{what}, {}", times.device), ratio.median, ""));
        let theirs = FRAME_RATES[2][scene][0] / FRAME_RATES[1][scene][2];
        figures.push(figure(format!("{what}, thesis"), theirs, ""));
        faster.push(above_one(ratio));
    }
    let quick = faster.iter().filter(|f| **f == Some(true)).count();
    let because = format!(
        "four bounding layers err no more in {} cases; they are faster in {quick} of 3 scenes ({})",
        count(&holds),
        times.device
    );
    Ok(judged(matches(&holds, &faster), because, figures))
}

fn many(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let (mut figures, mut planes, mut deep) = (Vec::new(), Vec::new(), Vec::new());
    for scene in SEEN {
        let bench = Bench::new(scene)?;
        let ours = ("bom 16", bench.bounding(16)?);
        planes.extend(compare(&mut figures, scene, ours, ("osm 128", bench.planes(128)?)));
        deep.extend(compare(&mut figures, scene, ours, ("dom 32", bench.deep(32)?)));
    }
    let because = format!(
        "no more than 128 opacity maps in {} cases, than 32 deep layers in {}",
        count(&planes),
        count(&deep)
    );
    Ok(judged(all_of(&[vote(&planes), vote(&deep)]), because, figures))
}

#[cfg(test)]
mod tests {
    use super::*;
    use Verdict::{Open, Refuted, Reproduced};

    #[test]
    fn fewer_layers_must_match_and_be_faster() {
        assert_eq!(matches(&[true, true], &[Some(true)]), Reproduced);
        assert_eq!(matches(&[true, false], &[Some(true)]), Open);
        assert_eq!(matches(&[false], &[Some(true)]), Refuted);
        assert_eq!(matches(&[true], &[Some(false)]), Refuted);
        assert_eq!(matches(&[true], &[None]), Open);
    }

    #[test]
    fn errors_are_compared_even_and_at_their_best() {
        let e = |layering| Errors { layering, rmse: 2.0 * layering };
        let mut figures = Vec::new();
        let (ours, other) = (("a", [e(0.2), e(0.1)]), ("b", [e(0.1), e(0.1)]));
        assert_eq!(compare(&mut figures, "x", ours, other), [false, true]);
        assert_eq!(figures.len(), 8);
    }
}
