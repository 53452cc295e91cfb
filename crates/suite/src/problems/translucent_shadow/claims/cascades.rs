//! H2.1: the binary yardstick.

use super::{
    super::{SPEC, subject_cascades::CascadeSubject},
    support::{SCENES, Still, bom, frame_ns, still},
    verdict::{all_of, count, figure, judged, paired, vote},
};
use crate::{
    SuiteError,
    claims::{Claim, ClaimContext, Judged, Verdict},
    knob::{self, Knobs},
    problem::{Form, FrameTime, Setting, Subject},
};
use dapple_gpu::Gpu;
use dapple_metrics::stats::Ratio;
use dapple_opacity_maps::Code;

/// Depth biases of the cascades: the source gives none.
const BIASES: [f64; 3] = [1e-4, 1e-3, 1e-2];

pub fn claims() -> Vec<Claim> {
    vec![Claim {
        id: "voicu-H2.1",
        statement: "Parallel-split shadow maps are cheaper than bounding opacity maps, but have no \
                    graded self-shadow: their error is larger in every translucent scene",
        place: "Voicu 2011, section 2.2; the author's manual",
        method: "ten scenes, 128 px, maps of 256, 3 x 3 taps. Two splits, half logarithmic, at \
                 their best bias of 1e-4, 1e-3 and 1e-2 against 16 bounding layers as they come: rms \
                 against light rays. Larger: by more than nothing, in every scene reproduced, in \
                 none refuted. Graded: the share of receivers with truth between 0.05 and 0.95 is \
                 shown, with what one binary map of all geometry does. Cheaper: on hardware, whole \
                 frames with all maps on grass, below 1 by three median deviations; bytes of \
                 maps are shown",
        judge: Box::new(binary),
    }]
}

/// Errors of a scene: cascades, bounding maps.
fn larger(rows: &[(f64, f64)]) -> (Verdict, String) {
    let holds: Vec<bool> = rows.iter().map(|(cascades, bounding)| cascades > bounding).collect();
    (vote(&holds), format!("cascades err more in {} scenes", count(&holds)))
}

/// Two cascades at a bias.
fn setting(form: Form, bias: f64) -> Result<Setting, SuiteError> {
    let technique = SPEC.techniques.iter().find(|t| t.id == "pssm");
    let known = || SPEC.techniques.iter().map(|t| t.id);
    let technique = technique.ok_or_else(|| SuiteError::unknown("technique", "pssm", known()))?;
    let given = Knobs::from([("bias".into(), bias.into())]);
    Ok(Setting {
        technique: technique.id.into(),
        variant: technique.variants[0].id.into(),
        form,
        knobs: knob::complete("knob", technique.knobs, &given)?,
    })
}

/// A frame of cascades over one of bounding maps on the device, both with all their maps.
fn frames(gpu: &Gpu, still: &Still) -> Result<Ratio, SuiteError> {
    let setting = setting(Form::Gpu, 1e-3)?;
    let mut cascades = CascadeSubject::new(&still.case, Some(gpu), &setting)?;
    let bounding = still.renderer(gpu, &bom(16))?;
    let ns = |t: FrameTime| t.gpu_ns.unwrap_or(t.wall_ns) as f64;
    paired(11, || cascades.frame(0).map(ns), || frame_ns(gpu, &bounding))
}

fn binary(context: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let (mut figures, mut rows) = (Vec::new(), Vec::new());
    for scene in SCENES {
        let still = still(scene)?;
        let mut best = f64::INFINITY;
        let mut bytes = 0.0;
        for bias in BIASES {
            let setting = setting(Form::Cpu, bias)?;
            let checked = CascadeSubject::new(&still.case, None, &setting)?.check()?;
            if let Some(violation) = checked.violations.first() {
                return Err(SuiteError::Usage(format!("{scene}: {violation}")));
            }
            best = checked.errors.get("rmse").copied().unwrap_or(f64::NAN).min(best);
            bytes = checked.counters.get("map_bytes").copied().unwrap_or(0) as f64;
        }
        let score = still.score(&bom(16))?;
        let method = super::support::Method::of(Code::Binary);
        let one_map = still.score(&method)?.rmse;
        let counted = || still.case.truth().iter().zip(still.case.mask()).filter(|(_, m)| **m);
        let graded = counted().filter(|(t, _)| (0.05..=0.95).contains(*t)).count() as f64;
        let what = "receivers of graded truth";
        figures.extend([
            figure(format!("{scene}: {what}"), graded / counted().count().max(1) as f64, ""),
            figure(format!("{scene}: error, cascades at their best bias"), best, ""),
            figure(format!("{scene}: error, one binary map"), one_map, ""),
            figure(format!("{scene}: error, bounding maps"), score.rmse, ""),
        ]);
        if scene == "grass" {
            let more = still.maps(&bom(16))?.map_bytes() as f64 / bytes.max(1.0);
            figures.push(figure("bytes of maps, bounding over cascades", more, ""));
        }
        rows.push((best, score.rmse));
    }
    let (error, mut because) = larger(&rows);
    let mut hardware = None;
    if let Some(gpu) = context.gpu {
        let ratio = frames(gpu, &*still("grass")?)?;
        let on = if context.hardware { "device" } else { "software adapter" };
        let what = format!("grass: frame time, cascades over bounding maps, {on}");
        figures.push(figure(what, ratio.median, ""));
        figures.push(figure("the same, median absolute deviation", ratio.mad, ""));
        hardware = context.hardware.then_some((ratio.median, ratio.mad));
    }
    let cheaper = super::osm_packing::faster(hardware);
    because += match cheaper {
        Verdict::NeedsHardware => "; whether they are cheaper needs hardware",
        Verdict::Reproduced => "; they are cheaper",
        Verdict::Open => "; times do not tell which is cheaper",
        Verdict::Refuted => "; they are not cheaper",
    };
    Ok(judged(all_of(&[error, cheaper]), because, figures))
}

#[cfg(test)]
mod tests {
    use super::*;
    use Verdict::{NeedsHardware, Open, Refuted, Reproduced};

    #[test]
    fn errors_must_be_larger_everywhere() {
        assert_eq!(larger(&[(0.2, 0.1), (0.15, 0.1)]).0, Reproduced);
        assert_eq!(larger(&[(0.2, 0.1), (0.1, 0.1)]).0, Open);
        assert_eq!(larger(&[(0.1, 0.2)]).0, Refuted);
        assert_eq!(larger(&[(f64::NAN, 0.2)]).0, Refuted);
    }

    #[test]
    fn without_an_adapter_the_price_is_not_known() {
        let judged = binary(&ClaimContext { gpu: None, hardware: false }).unwrap();
        assert!(matches!(judged.verdict, NeedsHardware | Open | Refuted));
        assert!(judged.because.contains("needs hardware"));
    }
}
