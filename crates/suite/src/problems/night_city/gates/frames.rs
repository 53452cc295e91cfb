//! What every technique's frames owe: ports, repetition, and P12.

use super::cities::{SEED, SMALL, Seen, city, frames, lit, setting};
use crate::{
    SuiteError,
    problem::{Form, Technique},
    problems::{many_lights::port, night_city::SPEC},
    verify::{About, Gate, GateContext, Tally, gate},
};
use dapple_many_lights::Shaded;
use dapple_night_city::{Night, Part, coherence::Keeping};
use glam::Vec3;

/// Share of a device's pixels that may differ: those whose cut falls the other way by rounding.
const DIFFERING: f64 = 0.005;

/// Frames that a camera stands still for.
const STILL: usize = 120;

/// By how much fewer evaluations a standing camera costs with precuts that are kept for 50 frames.
const FEWER: f64 = 10.0;

pub fn gates() -> Vec<Gate> {
    let mut gates = Vec::new();
    for technique in SPEC.techniques {
        let about =
            |name, statement, fault| About { technique: technique.id, name, statement, fault };
        gates.push(gate(
            about(
                "repeats",
                "frames are the same bits again, whatever was lit before, on any number of threads",
                "another frame is lit",
            ),
            |context, faulty| repeats(technique, context, faulty),
        ));
        gates.push(gate(
            about(
                "finite",
                "every radiance is finite and at least 0, nothing is lit where nothing shows, and \
                 something is where something does",
                "surfaces give back less than nothing of the red, or nothing",
            ),
            |context, faulty| finite(technique, context, faulty),
        ));
        if technique.variants.iter().any(|v| technique.has(v.id, Form::Gpu)) {
            let port = gate(
                about(
                    "gpu port",
                    "the device lights what the processor does from the same lists, but for pixels \
                     whose cut falls the other way by rounding",
                    "every pixel is the one beside it",
                ),
                |context, faulty| ported(technique, context, faulty),
            );
            gates.push(Gate { needs_gpu: true, ..port });
        }
    }
    let about =
        |name, statement, fault| About { technique: "facade-cluster", name, statement, fault };
    gates.push(gate(
        about(
            "P12 validity",
            "where nothing moves, frames are the same whether precuts are kept for 1, 3 or 50 frames, \
             for ever, as long as there is room, or were all found before the first",
            "weak clusters are left out a hundred times as early in all but one",
        ),
        validity,
    ));
    gates.push(gate(
        about(
            "standing still",
            "precuts that are kept for 50 frames cost a standing camera a tenth of the evaluations at \
             most, and those that are kept for ever only the first frame's",
            "they are kept for 5 frames",
        ),
        standing,
    ));
    gates
}

fn repeats(
    technique: &Technique,
    context: &GateContext<'_>,
    faulty: bool,
) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    let alone = alone.map_err(|error| SuiteError::Internal(error.to_string()))?;
    let case = city(SMALL, context.seed, None)?;
    for variant in technique.variants {
        let setting = setting(technique, variant.id, Form::Cpu, &[])?;
        let first = frames(&case, &setting)?;
        let mut method = case.method(&setting)?;
        let mut shaded = Shaded::default();
        method.frame(first.len() - 1, true)?;
        method.reset(SEED)?;
        let mut again = Vec::new();
        for index in 0..first.len() {
            let index = if faulty { first.len() - 1 - index } else { index };
            method.frame(index, true)?;
            method.read(&mut shaded)?;
            again.push(shaded.radiance.clone());
        }
        let third = alone.install(|| -> Result<_, SuiteError> {
            let case = city(SMALL, context.seed, None)?;
            frames(&case, &setting)
        })?;
        for (index, first) in first.iter().enumerate() {
            tally.check(*first == again[index], || format!("{setting}: frame {index} again"));
            tally.check(*first == third[index], || format!("{setting}: frame {index} alone"));
        }
    }
    Ok(tally)
}

fn finite(
    technique: &Technique,
    context: &GateContext<'_>,
    faulty: bool,
) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    let case = city(SMALL, context.seed, None)?;
    for variant in technique.variants {
        let setting = setting(technique, variant.id, Form::Cpu, &[])?;
        for (index, frame) in frames(&case, &setting)?.iter().enumerate() {
            let points = &case.night().town.world(false).frames[index].points;
            tally.check(points.len() == frame.len(), || format!("{setting}: {}", frame.len()));
            let mut lit = 0;
            for (point, radiance) in points.iter().zip(frame) {
                let radiance =
                    if faulty { *radiance * Vec3::new(-1.0, 0.0, 0.0) } else { *radiance };
                let sound = radiance.is_finite() && radiance.min_element() >= 0.0;
                let dark = point.is_there() || radiance == Vec3::ZERO;
                tally.check(sound && dark, || format!("{setting}, frame {index}: {radiance}"));
                lit += usize::from(radiance.max_element() > 0.0);
            }
            tally.check(lit > 0, || format!("{setting}, frame {index}: all is dark"));
        }
    }
    Ok(tally)
}

fn ported(
    technique: &Technique,
    context: &GateContext<'_>,
    faulty: bool,
) -> Result<Tally, SuiteError> {
    use crate::problems::night_city::settings;
    use dapple_many_lights::{self as lights, Technique as Lit, cut};
    let mut tally = Tally::default();
    let case = city(Seen { frames: 2, width: 32, ..SMALL }, context.seed, context.gpu)?;
    let town = &case.night().town;
    let (mut ours, mut theirs) = (Shaded::default(), Shaded::default());
    for variant in technique.variants.iter().filter(|v| technique.has(v.id, Form::Gpu)) {
        let setting = setting(technique, variant.id, Form::Gpu, &[])?;
        let night = settings::night(&setting, case.seed())?;
        let mut method = case.method(&setting)?;
        method.reset(SEED)?;
        let world = town.world(night.shadow_rays);
        let given = cut::Given::new(&Lit::Absolute(night.cut), world, &town.lights)?;
        let mut host = cut::starting(lights::Form::Cpu, &given, None)?;
        let (mut differ, mut pixels) = (0, 0);
        for index in 0..town.views.len() {
            method.frame(index, false)?;
            method.read(&mut ours)?;
            let Some(starts) = method.starts() else { continue };
            host.start(starts)?;
            host.shade(index, false)?;
            host.read(&mut theirs)?;
            if faulty {
                ours.radiance.rotate_right(1);
            }
            let pairs = ours.radiance.iter().zip(&theirs.radiance);
            differ += pairs.filter(|(a, b)| !port::alike(**a, **b)).count();
            pixels += theirs.radiance.len();
        }
        let share = differ as f64 / pixels.max(1) as f64;
        tally.within(share, DIFFERING, || format!("{setting}: {differ} of {pixels} pixels"));
    }
    Ok(tally)
}

fn validity(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    let case = city(Seen { frames: 6, ..SMALL }, context.seed, None)?;
    // There and back: what was forgotten is asked for again.
    let path: Vec<usize> = (0..6).chain((0..6).rev()).collect();
    // As cells that cover more than a pixel are divided, and as every facade is a cell.
    for (tau_px, split) in [(Night::default().tau_px, Part::Any), (0.0, Part::Facade)] {
        let night = Night { tau_px, split, ..Night::default() };
        let kept = |validity, capacity_bytes| Night {
            keeping: Keeping { validity, capacity_bytes, seed: context.seed },
            ..night
        };
        let (expected, _) = lit(&case, &kept(Some(1), None), &path)?;
        let mut others = vec![
            ("3 frames", kept(Some(3), None)),
            ("50 frames", kept(Some(50), None)),
            ("for ever", kept(None, None)),
            ("as long as there is room", kept(None, Some(2000))),
        ];
        if split == Part::Facade {
            others.push(("before the first", Night { precomputed: true, ..night }));
        }
        for (what, other) in others {
            let other = if faulty { weaker(other) } else { other };
            let (found, _) = lit(&case, &other, &path)?;
            for (index, (found, expected)) in found.iter().zip(&expected).enumerate() {
                tally.check(found == expected, || format!("{split:?}, {what}: frame {index}"));
            }
        }
    }
    Ok(tally)
}

/// With a threshold a hundred times as high.
fn weaker(night: Night) -> Night {
    use dapple_many_lights::region::{FacadeCluster, RegionTechnique};
    let region = match night.region {
        RegionTechnique::FacadeCluster(region) => RegionTechnique::FacadeCluster(FacadeCluster {
            threshold: 100.0 * region.threshold,
            ..region
        }),
        other => other,
    };
    Night { region, ..night }
}

fn standing(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    let case = city(Seen { width: 16, frames: 1, ..SMALL }, context.seed, None)?;
    let night = Night { tau_px: 65_536.0, ..Night::default() };
    let of = |validity| -> Result<Vec<u64>, SuiteError> {
        let keeping = Keeping { validity, seed: context.seed, ..night.keeping };
        Ok(lit(&case, &Night { keeping, ..night }, &[0; STILL])?.1)
    };
    let [always, fifty, ever] = [of(Some(1))?, of(Some(if faulty { 5 } else { 50 }))?, of(None)?];
    // What is seen, and so cells, has settled by then, and every first span, which is by chance, is over.
    let settled = |frames: &[u64]| frames[50.min(STILL)..].iter().sum::<u64>();
    let all = settled(&always);
    tally.check(all > 0, || format!("every frame: {always:?}"));
    let ratio = settled(&fifty) as f64 / all as f64;
    tally.within(ratio, 1.0 / FEWER, || "share of the evaluations".into());
    let only = ever[0] == always[0] && settled(&ever) == 0;
    tally.check(only, || format!("for ever: {ever:?}"));
    Ok(tally)
}
