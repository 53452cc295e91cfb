//! Frames of opacity, deep and bounding opacity maps on the thesis's scenes, timed in turn: once a
//! device, shared by what is said of times.

use super::{
    search_tables::{LAYERS, SCENES},
    support::{CpuRun, Method, Still, bom, dom, frame_ns, osm, still_with},
};
use crate::{SuiteError, claims::ClaimContext};
use dapple_gpu::Gpu;
use dapple_metrics::stats::{self, Ratio};
use dapple_opacity_maps::{Packing, Storage, gpu::Renderer};
use std::{cell::RefCell, collections::BTreeMap, rc::Rc};

/// Methods, in the order of time that the thesis finds.
pub const METHODS: [&str; 3] = ["osm", "dom", "bom"];

/// Rounds in which every setting draws one frame.
const ROUNDS: usize = 9;

/// The same on a software adapter, which is shown and not judged.
const SOFTWARE_ROUNDS: usize = 3;

/// Side of the map, texels: the thesis's.
pub const SIDE: u32 = 512;

/// The same on a software adapter.
const SOFTWARE_SIDE: u32 = 256;

/// Milliseconds by round, of [`SCENES`], [`METHODS`] and [`LAYERS`].
pub struct Times {
    /// What ran them.
    pub device: &'static str,
    samples: Vec<[[Vec<f64>; 4]; 3]>,
}

impl Times {
    /// Median of one setting, ms.
    ///
    /// # Errors
    /// None but of empty samples.
    pub fn ms(&self, scene: usize, method: usize, layers: usize) -> Result<f64, SuiteError> {
        Ok(stats::median(&self.samples[scene][method][layers])?)
    }

    /// Medians of all numbers of layers.
    ///
    /// # Errors
    /// As [`Times::ms`].
    pub fn by_layers(&self, scene: usize, method: usize) -> Result<[f64; 4], SuiteError> {
        let mut all = [0.0; 4];
        for (k, ms) in all.iter_mut().enumerate() {
            *ms = self.ms(scene, method, k)?;
        }
        Ok(all)
    }

    /// Time of one setting (method, place in [`LAYERS`]) over another's, round by round.
    ///
    /// # Errors
    /// As [`Times::ms`].
    pub fn ratio(
        &self,
        scene: usize,
        (method, layers): (usize, usize),
        (other, others): (usize, usize),
    ) -> Result<Ratio, SuiteError> {
        let of = &self.samples[scene];
        Ok(stats::paired_ratio(&of[method][layers], &of[other][others])?)
    }
}

/// Whether a ratio lies above 1, `None` where the spread of its rounds could explain either: within
/// 1.5 median absolute deviations, about two standard errors of a median of nine.
pub fn above_one(ratio: Ratio) -> Option<bool> {
    ((ratio.median - 1.0).abs() > 1.5 * ratio.mad).then_some(ratio.median > 1.0)
}

/// Times that are judged: of graphics hardware where there is any, else of the processor.
///
/// # Errors
/// Scenes or settings that are refused, or the device's.
pub fn judged(context: &ClaimContext<'_>) -> Result<Rc<Times>, SuiteError> {
    match context.gpu.filter(|_| context.hardware) {
        Some(gpu) => made("graphics hardware", || on_gpu(gpu, "graphics hardware", SIDE, ROUNDS)),
        None => made("processor", on_cpu),
    }
}

/// Times shown beside them: of the processor where hardware is judged, else of a software adapter,
/// where there is one.
///
/// # Errors
/// As [`judged`].
pub fn beside(context: &ClaimContext<'_>) -> Result<Option<Rc<Times>>, SuiteError> {
    const SOFTWARE: &str = "software adapter";
    Ok(Some(match (context.gpu, context.hardware) {
        (None, _) => return Ok(None),
        (Some(_), true) => made("processor", on_cpu)?,
        (Some(gpu), false) => {
            made(SOFTWARE, || on_gpu(gpu, SOFTWARE, SOFTWARE_SIDE, SOFTWARE_ROUNDS))?
        }
    }))
}

fn made(
    device: &'static str,
    make: impl FnOnce() -> Result<Times, SuiteError>,
) -> Result<Rc<Times>, SuiteError> {
    thread_local! {
        static MADE: RefCell<BTreeMap<&'static str, Rc<Times>>> =
            const { RefCell::new(BTreeMap::new()) };
    }
    if let Some(times) = MADE.with_borrow(|made| made.get(device).map(Rc::clone)) {
        return Ok(times);
    }
    let times = Rc::new(make()?);
    MADE.with_borrow_mut(|made| made.insert(device, Rc::clone(&times)));
    Ok(times)
}

/// A scene of [`SCENES`] at the width that is timed. Truth is not looked at: one ray a receiver.
///
/// # Errors
/// Those of [`still_with`].
pub fn timed(scene: &str) -> Result<Rc<Still>, SuiteError> {
    let given = [("width", 512.into()), ("footprint", 0.0.into()), ("truth_rays", 1.into())];
    still_with(scene, 0, &given)
}

/// A method of [`METHODS`] with the suite's taps: the deep one as deep as the deepest ray.
///
/// # Errors
/// Those of [`Still::deepest`].
pub fn method(still: &Still, method: usize, layers: u32, side: u32) -> Result<Method, SuiteError> {
    Ok(match method {
        0 => osm(layers),
        1 => dom(layers, still.deepest()?),
        _ => bom(layers),
    }
    .at(side))
}

fn on_cpu() -> Result<Times, SuiteError> {
    let mut samples = Vec::new();
    for scene in SCENES {
        let still = timed(scene)?;
        let of = |at: usize, layers: u32| {
            let method = method(&still, at, layers, SIDE)?;
            // The best of our forms: every target in one pass, or fragments sorted first.
            let mut forms = Vec::new();
            for packing in [Packing::Targets(8), Packing::Sorted] {
                let mut run = CpuRun::new(&still, &method.clone().packing(packing))?;
                run.ns()?;
                forms.push((run.ns()?.min(run.ns()?), run));
            }
            let best = forms.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
            best.map(|(_, run)| run).ok_or_else(|| SuiteError::Internal("no form".into()))
        };
        samples.push(rounds(ROUNDS, of, CpuRun::ns)?);
    }
    Ok(Times { device: "processor", samples })
}

fn on_gpu(gpu: &Gpu, device: &'static str, side: u32, rows: usize) -> Result<Times, SuiteError> {
    let mut samples = Vec::new();
    for scene in SCENES {
        let still = timed(scene)?;
        let of = |at: usize, layers: u32| {
            let blended = method(&still, at, layers, side)?;
            let renderer = still.renderer(gpu, &blended)?;
            let time = frame_ns(gpu, &renderer)?.min(frame_ns(gpu, &renderer)?);
            if side != SIDE {
                return Ok(renderer);
            }
            // The best of our forms: the blending unit, or integer atomics.
            let atomic = blended.with(|layered| layered.storage = Storage::Atomic);
            let other = still.renderer(gpu, &atomic)?;
            let others = frame_ns(gpu, &other)?.min(frame_ns(gpu, &other)?);
            Ok(if others < time { other } else { renderer })
        };
        let one = |renderer: &mut Renderer| frame_ns(gpu, renderer);
        samples.push(rounds(rows, of, one)?);
    }
    Ok(Times { device, samples })
}

/// Makes every setting of a scene, then draws a frame of each in turn.
fn rounds<R>(
    rounds: usize,
    make: impl Fn(usize, u32) -> Result<R, SuiteError>,
    ns: impl Fn(&mut R) -> Result<f64, SuiteError>,
) -> Result<[[Vec<f64>; 4]; 3], SuiteError> {
    let mut runs = Vec::new();
    for at in 0..METHODS.len() {
        for (k, layers) in LAYERS.into_iter().enumerate() {
            runs.push((at, k, make(at, layers)?));
        }
    }
    let mut samples: [[Vec<f64>; 4]; 3] = Default::default();
    for _ in 0..rounds {
        for (at, k, run) in &mut runs {
            samples[*at][*k].push(ns(run)? / 1e6);
        }
    }
    Ok(samples)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ratios_are_of_the_same_round() {
        let slow = |factor: f64| vec![factor, 2.0 * factor, 4.0 * factor];
        let row =
            |factor| [slow(factor), slow(2.0 * factor), slow(3.0 * factor), slow(4.0 * factor)];
        let times = Times { device: "", samples: vec![[row(1.0), row(2.0), row(3.0)]] };
        assert_eq!(times.by_layers(0, 1).unwrap(), [4.0, 8.0, 12.0, 16.0]);
        let ratio = times.ratio(0, (2, 0), (1, 3)).unwrap();
        assert_eq!((ratio.median, ratio.mad), (3.0 / 8.0, 0.0));
    }

    #[test]
    fn noise_leaves_an_order_undecided() {
        let ratio = |median, mad| Ratio { median, mad };
        assert_eq!(above_one(ratio(1.2, 0.1)), Some(true));
        assert_eq!(above_one(ratio(0.8, 0.1)), Some(false));
        assert_eq!(above_one(ratio(1.1, 0.1)), None);
        assert_eq!(above_one(ratio(f64::NAN, 0.1)), None);
    }

    #[test]
    fn every_setting_draws_once_a_round() {
        let samples = rounds(3, |at, layers| Ok((at, layers)), |run| Ok(1e6 * f64::from(run.1)));
        let samples = samples.unwrap();
        assert_eq!(samples[2][3], [32.0; 3]);
        assert!(
            rounds(1, |_, _| Err::<(), _>(SuiteError::Internal("x".into())), |()| Ok(1.0)).is_err()
        );
    }
}
