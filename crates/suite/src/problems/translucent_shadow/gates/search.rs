//! Searches for the split: eleven frames, the best by definition, and what tiles gain.

use super::{About, gate, input};
use crate::{
    SuiteError,
    verify::{Gate, GateContext, Tally},
};
use dapple_opacity_maps::{
    Code, Criterion, Fragments, Settings,
    exact::Exact,
    search::{
        Cycle, Layers, Plan, Scorer, Scoring, Search, Shown, Steps, criteria::is_better, oracle,
        state::PrintedLoop,
    },
};
use rand::RngExt;
use rand_pcg::Pcg64;

/// Side of the maps that are searched, texels.
pub const SIDE: u32 = 24;

pub fn gates() -> Vec<Gate> {
    let about = |name, statement, fault| About { technique: "bom-search", name, statement, fault };
    vec![
        gate(
            about(
                "row 29 by definition",
                "a search adopts the split whose maps, scored one by one, are best, and repeats it",
                "its best is the worst",
            ),
            finds_best,
        ),
        gate(
            about(
                "P12 eleven frames",
                "a search scores each of its eleven values once and rests",
                "algorithm 5.2.3.1 as printed: a sum of tenths is compared with 1.1",
            ),
            eleven_frames,
        ),
        gate(
            about(
                "row 30 oracle",
                "no split that any criterion adopts errs less than the oracle's",
                "the oracle adopts an even split",
            ),
            oracle_is_best,
        ),
        gate(
            about(
                "row 36 tiles",
                "where dense and sparse stand side by side, tiles of their own split err less than \
                 the best split for all",
                "one tile for all",
            ),
            tiles,
        ),
    ]
}

/// Rays of one density, each over most of the range.
fn volume(rng: &mut Pcg64, density: f32, omega: f32) -> Vec<(f32, f32)> {
    let (mut depth, far) = (rng.random_range(0.1..0.3_f32), rng.random_range(0.7..0.9_f32));
    let mut ray = Vec::new();
    while depth < far {
        ray.push((depth, omega));
        depth -= (1.0 - rng.random_range(0.0..1.0_f32)).ln() / density;
    }
    ray
}

/// A map of them, of one density and opacity.
pub fn stand(rng: &mut Pcg64) -> Fragments {
    let (density, omega) = (rng.random_range(6.0..30.0), rng.random_range(0.05..0.7));
    let texels: Vec<_> = (0..SIDE * SIDE).map(|_| volume(rng, density, omega)).collect();
    input::map(SIDE, &texels)
}

fn bounding(layers: u32) -> Settings {
    input::plain(Code::Layered(input::layered(input::bounded(0.0), layers)))
}

/// A criterion that sees maps alone.
fn criterion(case: u32) -> Criterion {
    [
        Criterion::Sad,
        Criterion::Correlation,
        Criterion::MutualInformation,
        Criterion::EqualOpacity,
        Criterion::EqualTransmittance,
    ][case as usize % 5]
}

/// Runs a search to its end; the number of scored frames.
fn finish(search: &mut Search, fragments: &Fragments) -> Result<u32, SuiteError> {
    let mut scored = 0;
    for _ in 0..40 {
        let report = search.frame(fragments)?;
        scored += u32::from(report.trial.is_some());
        if report.adopted {
            break;
        }
    }
    Ok(scored)
}

fn searched(
    criterion: Criterion,
    layers: u32,
    tile: u32,
    fragments: &Fragments,
) -> Result<Search, SuiteError> {
    let plan = Plan { tile, ..Plan::plain(bounding(layers), criterion) };
    let mut search = Search::new(SIDE, SIDE, plan)?;
    finish(&mut search, fragments)?;
    Ok(search)
}

fn finds_best(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for case in 0..context.cases.min(10) {
        let mut rng = input::rng(context.seed, "finds best", case);
        let fragments = stand(&mut rng);
        let (criterion, layers) = (criterion(case), rng.random_range(3..=9_u32));
        let mut scores = Vec::new();
        for step in 0..=10_u8 {
            let layered = input::layered(input::bounded(f32::from(step) / 10.0), layers);
            let maps = input::build(&input::plain(Code::Layered(layered)), &fragments)?;
            let (words, k) = (maps.code().words(), layers as usize);
            let all = Layers::new((SIDE, SIDE), k, words, words - k, maps.words())?;
            scores.push(Scorer::new(Scoring::plain(criterion)).score(&all)?);
        }
        let better = |a: usize, b: usize| is_better(criterion, scores[b], scores[a]) != faulty;
        let best = (0..=10).reduce(|a, b| if better(a, b) { b } else { a });
        let best = best.unwrap_or_default() as f32 / 10.0;
        let mut search = searched(criterion, layers, 0, &fragments)?;
        for _ in 0..2 {
            let found = search.lambda();
            let what = || format!("{criterion:?} of {layers}: {found}, by definition {best}");
            tally.within(f64::from((found - best).abs()), 0.0, what);
            search.needs_recompute();
            let scored = finish(&mut search, &fragments)?;
            tally.check(scored == 11, || format!("{scored} frames"));
        }
    }
    Ok(tally)
}

fn eleven_frames(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for case in 0..context.cases {
        let mut rng = input::rng(context.seed, "eleven", case);
        let scores: Vec<f64> = (0..11).map(|_| f64::from(rng.random_range(-5..5_i8))).collect();
        let best = (0..11).reduce(|a, b| if scores[b] < scores[a] { b } else { a });
        let best = best.unwrap_or_default() as f32 / 10.0;
        let at = |lambda: f64| scores[((lambda * 10.0).round() as usize).min(10)];
        let (frames, adopted) = if faulty { printed(at) } else { repaired(at) };
        tally.check(frames == 11, || format!("{frames} frames"));
        tally.check(adopted == best, || format!("{adopted}, least at {best}"));
    }
    Ok(tally)
}

/// Scored frames, of forty, and the split at their end.
fn repaired(score: impl Fn(f64) -> f64) -> (u32, f32) {
    let mut cycle = Cycle::new(Criterion::Correlation, Steps::THESIS, Shown::Adopted);
    let mut frames = 0;
    for _ in 0..40 {
        if let Some(trial) = cycle.frame().trial {
            frames += 1;
            cycle.scored(trial, score(trial.lambda.into()));
        }
    }
    (frames, cycle.adopted())
}

/// The same of the printed loop.
fn printed(score: impl Fn(f64) -> f64) -> (u32, f32) {
    let mut printed = PrintedLoop::new(Criterion::Correlation);
    let mut frames = 0;
    while frames < 40 && !printed.has_ended() {
        printed.frame(&score);
        frames += 1;
    }
    (frames, printed.best() as f32)
}

/// Error of a split for all.
fn error_at(lambda: f32, layers: u32, fragments: &Fragments) -> Result<f64, SuiteError> {
    let layered = input::layered(input::bounded(lambda), layers);
    let maps = input::build(&input::plain(Code::Layered(layered)), fragments)?;
    Ok(oracle::rmse(&maps, fragments, &Exact::of(fragments))?)
}

fn oracle_is_best(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for case in 0..context.cases.min(5) {
        let mut rng = input::rng(context.seed, "oracle", case);
        let fragments = stand(&mut rng);
        let layers = [4, 8, 16][case as usize % 3];
        let known = searched(Criterion::Oracle, layers, 0, &fragments)?.lambda();
        let least = error_at(if faulty { 0.0 } else { known }, layers, &fragments)?;
        for other in 0..5 {
            let lambda = searched(criterion(other), layers, 0, &fragments)?.lambda();
            let error = error_at(lambda, layers, &fragments)?;
            tally.within(least, error, || format!("{:?} adopts {lambda}", criterion(other)));
        }
    }
    Ok(tally)
}

fn tiles(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for case in 0..context.cases.min(4) {
        let mut rng = input::rng(context.seed, "tiles", case);
        let texels: Vec<_> = (0..SIDE * SIDE)
            .map(|i| match i % SIDE {
                0..8 => volume(&mut rng, 60.0, 0.4),
                _ => volume(&mut rng, 12.0, 0.05),
            })
            .collect();
        let fragments = input::map(SIDE, &texels);
        let layers = [8, 16][case as usize % 2];
        let error = |tile| {
            let search = searched(Criterion::Oracle, layers, tile, &fragments)?;
            Ok::<_, SuiteError>(oracle::rmse(search.maps(), &fragments, &Exact::of(&fragments))?)
        };
        let one = error(0)?;
        let own = error(if faulty { 0 } else { 8 })?;
        tally.within(own, 0.999 * one, || format!("{layers} layers"));
    }
    Ok(tally)
}
