//! H9.1 to H9.3: a split for every tile, and the number of layers by what a frame may cost.

use super::{
    bench_times::{SIDE, timed},
    search_trials::{Form, View, Yardstick, name, still_of, trials},
    support::{CpuRun, bom, frame_ns, still},
    verdict::{all_of, count, figure, judged, vote},
};
use crate::{
    SuiteError,
    claims::{Claim, ClaimContext, Judged, Verdict},
    problems::translucent_shadow::subject_gpu::refused,
};
use dapple_gpu::Gpu;
use dapple_metrics::stats;
use dapple_opacity_maps::{
    Criterion,
    auto_layers::{Controller, Rule, Timed, WINDOW, largest_within, raised_while_fast},
    gpu::SearchRenderer,
    search::{Plan, Search, Steps},
};

/// Milliseconds of a frame in real time: 30 frames a second (thesis, section 7).
const REAL_TIME: f64 = 1000.0 / 30.0;

/// Tiles that must have the same split on both devices: scores differ by rounding, and where two
/// splits score alike either is right.
const SAME_TILES: f64 = 0.95;

/// Texels of a tile's side.
const TILES: [u32; 2] = [16, 8];

pub fn claims() -> Vec<Claim> {
    vec![
        Claim {
            id: "voicu-H9.1",
            statement: "A split for every tile is found on the graphics device in real time, \
                        without the processor waiting for it",
            place: "Voicu 2011, section 7, algorithm 7.1",
            method: "mixed, 16 bounding layers, tiles of 16 texels, equal transmittance. Nothing is \
                     read back in twelve frames on the device, at most one more opacity pass is \
                     drawn, and afterwards at least 95 % of the tiles must have the split that a \
                     search on the processor adopts from its own fragments. Real time: a frame \
                     that searches, at the thesis's size (map of 512), within 1/30 s; judged on \
                     graphics hardware alone",
            judge: Box::new(tiles_on_device),
        },
        Claim {
            id: "voicu-H9.2",
            statement: "Where dense and sparse stand side by side, a split for every tile beats one \
                        for all, for one more opacity pass a frame",
            place: "Voicu 2011, section 7, figure 7.1",
            method: "mixed lit from above and from the side, 8 and 16 layers, tiles of 16 and 8 \
                     texels; splits adopted by equal transmittance for tiles and for all. Rms \
                     against the deep shadow map must be less with tiles, voted over eight cases; \
                     maps built a frame must be two. Beside: the best of all single splits, \
                     larger tiles, tiles that know the answer, and texels of their own split by \
                     absolute differences, as the thesis has it",
            judge: Box::new(tiles),
        },
        Claim {
            id: "voicu-H9.3",
            statement: "Adding layers while frames are fast enough finds the most that a budget \
                        allows",
            place: "Voicu 2011, section 7",
            method: "bounding maps of grass, 8 to 32 layers in eights, nine frames each in turn on \
                     the processor; budgets half way between the medians of neighbouring numbers \
                     of layers; open where these medians do not rise, as on a busy machine. The controller that is fed these frames must settle on the largest \
                     number whose median is within the budget, for all three budgets; what the \
                     loop as printed (raise K while frames are fast, then stop) settles on beside",
            judge: Box::new(most_layers),
        },
    ]
}

/// Share of tiles with the same split, further opacity passes, and a frame on hardware, ms.
fn found_on_device(same: f64, passes: u64, frame_ms: Option<f64>) -> Verdict {
    let alone = vote(&[same >= SAME_TILES && passes <= 1]);
    let fast = frame_ms.map_or(Verdict::NeedsHardware, |ms| vote(&[ms <= REAL_TIME]));
    all_of(&[alone, fast])
}

fn plan(layers: u32, tile: u32, criterion: Criterion) -> Plan {
    Plan { tile, ..Plan::plain(bom(layers).settings, criterion) }
}

fn tiles_on_device(context: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let Some(gpu) = context.gpu else {
        return Ok(judged(Verdict::NeedsHardware, "no adapter", Vec::new()));
    };
    let (still, method) = (still("mixed")?, bom(16));
    let plan = plan(16, TILES[0], Criterion::EqualTransmittance);
    let fragments = still.fragments(&method)?;
    let side = method.resolution;
    let mut expected = Search::new(side, side, plan.clone())?;
    while expected.is_searching() {
        expected.frame(&fragments)?;
    }
    let size = [side; 2];
    let mesh = still.case.light_mesh(true);
    let mut found = SearchRenderer::new(gpu, &mesh, method.model, &still.receivers(), size, &plan)
        .map_err(refused)?;
    let passes = found.counters().trial_passes;
    for _ in 0..=Steps::THESIS.values() {
        let mut frame = gpu.frame();
        found.record(&mut frame);
        frame.finish()?;
    }
    let lambdas = found.read_lambdas(gpu).map_err(refused)?;
    let texture = expected.texture();
    let equal = |(tile, lambda): (usize, &f32)| {
        let region = texture.region(tile);
        let texel = region.rows.0 * side as usize + region.columns.0;
        (texture.lambda(texel) - lambda).abs() < 1e-3
    };
    let same = lambdas.iter().enumerate().filter(|t| equal(*t)).count();
    let same = same as f64 / texture.len() as f64;
    let (searching, settled) = device_ms(context, gpu)?;
    let device = if context.hardware { "graphics hardware" } else { "software adapter" };
    let figures = vec![
        figure("tiles of the same split as on the processor", same, ""),
        figure("further opacity passes of a frame that searches", passes as f64, ""),
        figure("read-backs of a frame", 0.0, ""),
        figure(format!("{device}: a frame that searches"), searching, "ms"),
        figure(format!("{device}: that frame over one that does not"), searching / settled, ""),
    ];
    let because = format!(
        "{:.1} % of the tiles get the processor's split, with {passes} more opacity pass and no \
         read-back; a frame that searches takes {searching:.1} ms on a {device}",
        100.0 * same
    );
    let judged_ms = context.hardware.then_some(searching);
    Ok(judged(found_on_device(same, passes, judged_ms), because, figures))
}

/// Milliseconds of a frame that searches and of one that does not, medians.
fn device_ms(context: &ClaimContext<'_>, gpu: &Gpu) -> Result<(f64, f64), SuiteError> {
    let still = timed("mixed")?;
    let side = if context.hardware { SIDE } else { SIDE / 2 };
    let method = bom(16).at(side);
    let plan = Plan { repeat: true, ..plan(16, TILES[0], Criterion::EqualTransmittance) };
    let mesh = still.case.light_mesh(true);
    let mut search =
        SearchRenderer::new(gpu, &mesh, method.model, &still.receivers(), [side; 2], &plan)
            .map_err(refused)?;
    let plain = still.renderer(gpu, &method)?;
    let (mut searching, mut settled) = (Vec::new(), Vec::new());
    for _ in 0..if context.hardware { 11 } else { 4 } {
        let mut frame = gpu.frame();
        search.record(&mut frame);
        let times = frame.finish()?;
        searching.push(times.gpu_ns.unwrap_or(times.wall_ns) as f64 / 1e6);
        settled.push(frame_ns(gpu, &plain)? / 1e6);
    }
    Ok((stats::median(&searching)?, stats::median(&settled)?))
}

/// Errors with tiles and with one split for all, and map sets a frame.
fn beats(pairs: &[(f64, f64)], map_sets: u32) -> (Verdict, Vec<bool>) {
    let holds: Vec<bool> = pairs.iter().map(|(tiles, one)| tiles < one).collect();
    (all_of(&[vote(&holds), vote(&[map_sets == 2])]), holds)
}

fn tiles(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    const VIEWS: [View; 2] = [("mixed", "above"), ("mixed", "side")];
    let (mut figures, mut pairs, mut map_sets) = (Vec::new(), Vec::new(), 0);
    for view in VIEWS {
        let still = still_of(view)?;
        for layers in [8, 16] {
            let method = bom(layers);
            let fragments = still.fragments(&method)?;
            let yardstick = Yardstick::new(still_of(view)?, &method)?;
            let mut error = |tile: u32, criterion: Criterion| {
                let side = method.resolution;
                let mut search = Search::new(side, side, plan(layers, tile, criterion))?;
                while search.is_searching() {
                    map_sets = map_sets.max(search.frame(&fragments)?.map_sets);
                }
                Ok::<_, SuiteError>(yardstick.errors(search.maps())?.0)
            };
            let what = format!("{}, {layers} layers", name(view));
            let one = error(0, Criterion::EqualTransmittance)?;
            figures.push(figure(format!("{what}: one split"), one, ""));
            let best = trials(view, layers, Form::Repaired)?.least();
            figures.push(figure(format!("{what}: the best single split"), best, ""));
            for tile in TILES {
                let own = error(tile, Criterion::EqualTransmittance)?;
                figures.push(figure(format!("{what}: tiles of {tile}"), own, ""));
                pairs.push((own, one));
            }
            for (tile, criterion) in [(64, Criterion::EqualTransmittance), (16, Criterion::Oracle)]
            {
                let own = error(tile, criterion)?;
                figures.push(figure(format!("{what}: tiles of {tile}, {criterion:?}"), own, ""));
            }
            let texels = error(1, Criterion::Sad)?;
            figures.push(figure(format!("{what}: texels, absolute differences"), texels, ""));
        }
    }
    figures.push(figure("maps built a frame", f64::from(map_sets), ""));
    let (verdict, holds) = beats(&pairs, map_sets);
    let because =
        format!("tiles err less in {} cases, with {map_sets} maps a frame", count(&holds));
    Ok(judged(verdict, because, figures))
}

/// Frames of each number of layers: for a budget, the largest within it, what the controller
/// settles on, and what the printed loop does.
fn settle(frames: &[(u32, Vec<f64>)], budget_ms: f64) -> Result<[u32; 3], SuiteError> {
    let mut timed = Vec::new();
    for (layers, ms) in frames {
        timed.push(Timed { layers: *layers, ms: stats::median(ms)? });
    }
    let choices: Vec<u32> = frames.iter().map(|(layers, _)| *layers).collect();
    let largest = largest_within(budget_ms, &timed).unwrap_or(0);
    let mut controller = Controller::new(Rule { budget_ms, margin: 0.0 }, &choices)?;
    // As many windows as there are choices lead to the top; then to and fro.
    for frame in 0..4 * WINDOW * frames.len() {
        let at = choices.iter().position(|k| *k == controller.layers()).unwrap_or(0);
        let times = &frames[at].1;
        controller.observe(times[frame % times.len()]);
    }
    let ms = |layers: u32| {
        let at = timed.iter().find(|t| t.layers == layers);
        at.map_or(f64::INFINITY, |t| t.ms)
    };
    let most = choices.last().copied().unwrap_or(1);
    let step = choices.get(1).map_or(1, |second| second - choices[0]);
    let printed = raised_while_fast(1000.0 / budget_ms, choices[0], step, most, ms);
    Ok([largest, controller.layers(), printed])
}

fn most_layers(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let still = still("grass")?;
    let (mut figures, mut runs) = (Vec::new(), Vec::new());
    for layers in [8, 16, 24, 32] {
        let mut run = CpuRun::new(&still, &bom(layers))?;
        run.ns()?;
        runs.push((layers, run, Vec::new()));
    }
    for _ in 0..WINDOW {
        for (_, run, times) in &mut runs {
            times.push(run.ns()? / 1e6);
        }
    }
    let frames: Vec<(u32, Vec<f64>)> = runs.into_iter().map(|(k, _, ms)| (k, ms)).collect();
    let mut medians = Vec::new();
    for (layers, ms) in &frames {
        medians.push(stats::median(ms)?);
        figures.push(figure(format!("{layers} layers"), stats::median(ms)?, "ms"));
    }
    let (mut holds, mut printed_holds) = (Vec::new(), Vec::new());
    for (below, pair) in medians.windows(2).enumerate() {
        let budget = 0.5 * (pair[0] + pair[1]);
        let [largest, settled, printed] = settle(&frames, budget)?;
        let what = format!("budget between {} and {}", frames[below].0, frames[below + 1].0);
        figures.push(figure(format!("{what}: most layers within it"), f64::from(largest), ""));
        figures.push(figure(format!("{what}: controller"), f64::from(settled), ""));
        figures.push(figure(format!("{what}: loop as printed"), f64::from(printed), ""));
        holds.push(settled == largest);
        printed_holds.push(printed == largest);
    }
    if medians.windows(2).any(|w| w[1] <= w[0]) {
        let because = "the times of more layers do not rise: the machine is busy";
        return Ok(judged(Verdict::Open, because, figures));
    }
    let because = format!(
        "the controller finds the most layers in {} budgets, the loop as printed in {}",
        count(&holds),
        count(&printed_holds)
    );
    Ok(judged(vote(&holds), because, figures))
}

#[cfg(test)]
mod tests {
    use super::*;
    use Verdict::{NeedsHardware, Open, Refuted, Reproduced};

    #[test]
    fn a_device_must_agree_and_be_fast() {
        assert_eq!(found_on_device(0.99, 1, None), NeedsHardware);
        assert_eq!(found_on_device(0.9, 1, None), Refuted);
        assert_eq!(found_on_device(0.99, 2, None), Refuted);
        assert_eq!(found_on_device(0.99, 1, Some(5.0)), Reproduced);
        assert_eq!(found_on_device(0.99, 1, Some(50.0)), Refuted);
    }

    #[test]
    fn tiles_must_err_less_for_two_maps() {
        assert_eq!(beats(&[(0.1, 0.2)], 2).0, Reproduced);
        assert_eq!(beats(&[(0.1, 0.2), (0.2, 0.2)], 2).0, Open);
        assert_eq!(beats(&[(0.2, 0.2)], 2).0, Refuted);
        assert_eq!(beats(&[(0.1, 0.2)], 3).0, Refuted);
    }

    #[test]
    fn the_printed_loop_stops_one_step_late() {
        let frames: Vec<(u32, Vec<f64>)> = [(4, 10.0), (8, 20.0), (12, 30.0), (16, 40.0)]
            .map(|(k, ms)| (k, vec![ms; WINDOW]))
            .into();
        assert_eq!(settle(&frames, 25.0).unwrap(), [8, 8, 12]);
        assert_eq!(settle(&frames, 100.0).unwrap(), [16, 16, 16]);
        assert!(settle(&[], 25.0).is_err());
    }
}
