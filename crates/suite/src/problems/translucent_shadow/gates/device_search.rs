//! The search for a split on the device: the processor's scores, and nothing read back.

use super::{
    About,
    device_input::{self as given, MODEL, Mesh, SIZE, gate, refused},
    input,
};
use crate::{
    SuiteError,
    verify::{Gate, GateContext, Tally},
};
use dapple_gpu::Gpu;
use dapple_opacity_maps::{
    Code, Criterion, Layered, Packing,
    gpu::SearchRenderer,
    search::{Plan, Search, criteria::is_better, with_lambda},
};
use rand::RngExt;

/// Relative error of sums of 32-bit floats over a map, and what fragments on a boundary do to it.
const FLOATS: f64 = 1e-3;

/// The technique that this is of.
pub const ID: &str = "bom-search";

const CRITERIA: [Criterion; 4] = [
    Criterion::Correlation,
    Criterion::EqualTransmittance,
    Criterion::EqualOpacity,
    Criterion::Sad,
];

pub fn gates() -> Vec<Gate> {
    let about = About {
        technique: ID,
        name: "row 32 gpu search",
        statement: "eleven frames score the eleven splits as the processor does, the best of each \
                    tile is adopted and drawn with, and nothing is read back",
        fault: "the search is cut off before its last trial",
    };
    vec![gate(about, searched)]
}

fn searched(gpu: &Gpu, context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for case in 0..context.cases.min(2) {
        let mut rng = input::rng(context.seed, "gpu search", case);
        let mesh = Mesh::new(gpu, &mut rng)?;
        let receivers = input::receivers(&mut rng, 100);
        let layers = rng.random_range(3..=12);
        let layered =
            Layered { packing: Packing::Targets(8), ..input::layered(input::bounded(0.0), layers) };
        let criterion = CRITERIA[rng.random_range(0..CRITERIA.len())];
        let tile = [0, 8][case as usize % 2];
        let plan = Plan { tile, ..Plan::plain(input::plain(Code::Layered(layered)), criterion) };
        let mut renderer = SearchRenderer::new(gpu, &mesh.mesh, MODEL, &receivers, SIZE, &plan)
            .map_err(refused)?;
        let values = plan.steps.values() - u32::from(faulty);
        let mut tried = Vec::new();
        while renderer.is_searching() && tried.len() < values as usize {
            let mut frame = gpu.frame();
            tried.extend(renderer.record(&mut frame));
            frame.finish()?;
        }
        let what = || format!("{plan:?}: {tried:?}");
        let all: Vec<f32> = (0..plan.steps.values()).map(|step| plan.steps.lambda(step)).collect();
        tally.check(tried == all, what);
        tally.check(renderer.read_backs() == 0, what);

        let scores = renderer.read_scores(gpu).map_err(refused)?;
        let known = by_processor(&plan, &mesh)?;
        let scale = known.iter().fold(0.0_f64, |most, s| most.max(s.abs()));
        for (step, (scores, known)) in scores.iter().zip(&known).enumerate() {
            let sum: f64 = scores.iter().map(|&s| f64::from(s)).sum();
            let off = (sum - known).abs() / scale;
            tally.within(off, FLOATS, || format!("{plan:?}, step {step}: {sum}, not {known}"));
        }
        let adopted = renderer.read_lambdas(gpu).map_err(refused)?;
        for (at, lambda) in adopted.iter().enumerate() {
            let score = |step: usize| f64::from(scores[step][at]);
            let better = |a: usize, b: usize| is_better(criterion, score(b), score(a));
            let best = (0..scores.len()).reduce(|a, b| if better(a, b) { b } else { a });
            let best = plan.steps.lambda(best.unwrap_or_default() as u32);
            tally.check(*lambda == best, || format!("{plan:?}, tile {at}: {lambda}, not {best}"));
        }
        if let [lambda] = adopted[..] {
            let settings = with_lambda(&plan.settings, lambda)?;
            let drawn = renderer.read(gpu).map_err(refused)?;
            let alone = given::frame(gpu, &mesh.mesh, &receivers, &settings, None);
            tally.check(drawn == alone.map_err(refused)?.transmittances, what);
        }
    }
    Ok(tally)
}

/// Scores of every step on the device's own fragments, of all tiles together.
fn by_processor(plan: &Plan, mesh: &Mesh) -> Result<Vec<f64>, SuiteError> {
    let mut search = Search::new(SIZE[0], SIZE[1], plan.clone())?;
    let mut scores = Vec::new();
    while search.is_searching() {
        scores.extend(search.frame(&mesh.own)?.trial.map(|trial| trial.1));
    }
    Ok(scores)
}
