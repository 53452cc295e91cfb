//! What the source's tables say of time, and of draw calls.

use super::{
    device::Device,
    replay::record,
    support::{Path, THESIS_SIZE, Walker, Way, asks, chc_plus_plus, path_of, town},
    verdict::{all_of, figure, judged, paired},
    views::VIEWS,
};
use crate::{
    SuiteError,
    claims::{Claim, ClaimContext, Figure, Judged, Verdict},
};
use dapple_occlusion::camera::{Settings, Technique, gpu::Drawing};

/// Pairs of frames timed in turn on the processor.
const PAIRS: usize = 5;

/// First pass of the four points of view, milliseconds: table 5.I.
const FIRST_PASS_MS: [f64; 4] = [1.0, 1.7, 9.2, 54.3];

/// First pass by no culling, by the frustum and by queries, milliseconds: table 5.III.
const CULLED_MS: [f64; 3] = [102.5, 11.3, 1.1];

/// How many times fewer calls, and shorter, counts as strong.
const TENFOLD: f64 = 10.0;
const TWICE: f64 = 2.0;

pub fn claims() -> Vec<Claim> {
    vec![
        Claim {
            id: "conte-H5.2",
            statement: "From a single facade to the bird's eye view the first pass grows far less \
                        (54 times) than the triangles (626 times)",
            place: "Conte 2018, table 5.I",
            method: "CHC++ on a device, two triangles a draw call as in the source, 1200 x 900 (256 x \
                     192 on software), settled still views: median time of frames in turn, bird's \
                     eye over facade, against the same ratio of triangles. Met on hardware if time \
                     grows by less than half as much as triangles. The processor's own renderer \
                     stands beside it and decides nothing",
            judge: Box::new(first_pass),
        },
        Claim {
            id: "conte-H5.3-time",
            statement: "At the close-ended street the first pass is 9.1 times faster by the frustum \
                        and 93 times by occlusion queries",
            place: "Conte 2018, table 5.III",
            method: "drawing everything, by the frustum and by CHC++ on a device, two triangles a \
                     draw call, as above: ratios of medians of frames in turn. Met on hardware if \
                     both are within a factor of 1.5 of the table's; contradicted if either is no \
                     faster than what it is compared with",
            judge: Box::new(culled),
        },
        Claim {
            id: "conte-T5.III-queries",
            statement: "Occlusion queries are close to ten times as fast as the frustum alone",
            place: "Conte 2018, section 5.3 and table 5.III",
            method: "the frustum over CHC++, as above: met on hardware within a factor of 1.5 of \
                     ten, contradicted below one. The text says it of queries, its table of the \
                     frustum (9.07) and of queries over the frustum (10.3)",
            judge: Box::new(queries),
        },
        Claim {
            id: "conte-H6.2",
            statement: "Instanced draw calls greatly improve the first pass at the bird's eye view",
            place: "Conte 2018, sections 5.1.1 and 6.1: future work",
            method: "CHC++, settled bird's eye view, 1200 x 900: calls of two triangles, of an \
                     object, and of a template between two batches of queries; tenfold fewer is met. \
                     Time by calls of two triangles over time by instances on hardware: twice is \
                     met",
            judge: Box::new(instances),
        },
    ]
}

/// Settled still view of the city.
fn still(view: &str, size: [u32; 2]) -> Result<std::rc::Rc<Path>, SuiteError> {
    path_of(&town("city", &[])?, view, 8, 1, size)
}

/// Time of `a` over time of `b` on the processor, last frames of still views in turn.
fn on_processor((path_a, a): (&Path, &Way), (path_b, b): (&Path, &Way)) -> Result<f64, SuiteError> {
    let (mut a, mut b) = (Walker::new(path_a, a)?, Walker::new(path_b, b)?);
    for index in 0..path_a.views.len().min(path_b.views.len()) {
        a.frame(index)?;
        b.frame(index)?;
    }
    Ok(paired(PAIRS, || a.ns(0), || b.ns(0))?.median)
}

/// Verdict of a time that only hardware decides.
fn on_hardware(hardware: bool, verdict: Verdict) -> Verdict {
    if hardware { verdict } else { Verdict::NeedsHardware }
}

/// Growth of time and of triangles.
fn slower(time: f64, triangles: f64) -> Verdict {
    if time < 0.5 * triangles {
        Verdict::Reproduced
    } else if time < triangles {
        Verdict::Open
    } else {
        Verdict::Refuted
    }
}

fn first_pass(context: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let way = chc_plus_plus(|_| {});
    let paths = VIEWS.map(|(view, _)| still(view, THESIS_SIZE));
    let [facade, close, street, birds] = paths;
    let paths = [facade?, close?, street?, birds?];
    let mut figures = Vec::new();
    let mut triangles = Vec::new();
    for ((view, _), path) in VIEWS.iter().zip(&paths) {
        let shown = path.shown(&way)?;
        triangles.push(shown.last().map_or(0, |s| s.work.triangles) as f64);
        let grown = on_processor((path, &way), (&paths[0], &way))?;
        figures.push(figure(format!("{view}: time over the facade's, processor"), grown, ""));
    }
    let theirs = FIRST_PASS_MS[3] / FIRST_PASS_MS[0];
    figures.push(figure("the table's, bird's eye over facade", theirs, ""));
    let grown = triangles[3] / triangles[0].max(1.0);
    figures.push(figure("triangles, bird's eye over facade", grown, ""));
    let mut told = "there is no device".to_string();
    let mut verdict = Verdict::NeedsHardware;
    if let Some(gpu) = context.gpu {
        let device = Device::new(gpu, context.hardware, &paths[0].town)?;
        let settings = Settings::new(Technique::ChcPlusPlus);
        let time = device.ratio(
            (VIEWS[3].0, &settings, Drawing::PerQuad),
            (VIEWS[0].0, &settings, Drawing::PerQuad),
        )?;
        figures.push(figure("bird's eye over facade, device", time.median, ""));
        figures.push(figure("the same, MAD", time.mad, ""));
        told = format!("time grows {:.1} times on the device", time.median);
        verdict = on_hardware(context.hardware, slower(time.median, grown));
    }
    let because = format!("{told}, triangles {grown:.0} times");
    Ok(judged(verdict, because, figures))
}

/// Times of everything, of the frustum and of CHC++ at the close-ended street: ratios to the first
/// and of the second to the third. On the processor, and on the device where there is one.
fn ratios(
    context: &ClaimContext<'_>,
    figures: &mut Vec<Figure>,
) -> Result<Option<[f64; 3]>, SuiteError> {
    let path = still("close_ended", THESIS_SIZE)?;
    let ways = [Technique::None, Technique::Frustum, Technique::ChcPlusPlus];
    let [none, frustum, queries] = ways.map(asks);
    let names = ["all over the frustum's", "all over CHC++'s", "the frustum's over CHC++'s"];
    let pairs = [(&none, &frustum), (&none, &queries), (&frustum, &queries)];
    for (name, (a, b)) in names.iter().zip(pairs) {
        let ratio = on_processor((&path, a), (&path, b))?;
        figures.push(figure(format!("time of {name}, processor"), ratio, ""));
    }
    let [all, by_frustum, by_queries] = CULLED_MS;
    let table = [all / by_frustum, all / by_queries, by_frustum / by_queries];
    for (name, theirs) in names.iter().zip(table) {
        figures.push(figure(format!("time of {name}, table"), theirs, ""));
    }
    let Some(gpu) = context.gpu else { return Ok(None) };
    let device = Device::new(gpu, context.hardware, &path.town)?;
    let run = |a: usize, b: usize| {
        let of = |i: usize| Settings::new(ways[i]);
        let view = "close_ended";
        device.ratio((view, &of(a), Drawing::PerQuad), (view, &of(b), Drawing::PerQuad))
    };
    let measured = [run(0, 1)?.median, run(0, 2)?.median, run(1, 2)?.median];
    for (name, ratio) in names.iter().zip(measured) {
        figures.push(figure(format!("time of {name}, device"), ratio, ""));
    }
    Ok(Some(measured))
}

/// A ratio against the table's.
fn as_fast(ratio: f64, theirs: f64) -> Verdict {
    if (theirs / 1.5..=theirs * 1.5).contains(&ratio) {
        Verdict::Reproduced
    } else if ratio > 1.0 {
        Verdict::Open
    } else {
        Verdict::Refuted
    }
}

fn told(measured: Option<[f64; 3]>) -> String {
    match measured {
        Some([a, b, c]) => format!(
            "on the device the frustum is {a:.1} times as fast as everything, CHC++ {b:.1} times, \
             and {c:.1} times as fast as the frustum"
        ),
        None => "there is no device".into(),
    }
}

fn culled(context: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let mut figures = Vec::new();
    let measured = ratios(context, &mut figures)?;
    let [all, by_frustum, by_queries] = CULLED_MS;
    let verdict = measured.map_or(Verdict::NeedsHardware, |[frustum, queries, _]| {
        all_of(&[as_fast(frustum, all / by_frustum), as_fast(queries, all / by_queries)])
    });
    Ok(judged(on_hardware(context.hardware, verdict), told(measured), figures))
}

fn queries(context: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let mut figures = Vec::new();
    let measured = ratios(context, &mut figures)?;
    let verdict = measured.map_or(Verdict::NeedsHardware, |[_, _, ratio]| as_fast(ratio, TENFOLD));
    Ok(judged(on_hardware(context.hardware, verdict), told(measured), figures))
}

/// Times fewer calls, and times shorter where hardware tells.
fn strongly(calls: f64, time: Option<f64>) -> Verdict {
    let calls = if calls >= TENFOLD { Verdict::Reproduced } else { Verdict::Refuted };
    let time = match time {
        None => Verdict::NeedsHardware,
        Some(time) if time >= TWICE => Verdict::Reproduced,
        Some(time) if time > 1.0 => Verdict::Open,
        Some(_) => Verdict::Refuted,
    };
    all_of(&[calls, time])
}

fn instances(context: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let settings = Settings::new(Technique::ChcPlusPlus);
    let path = still("birds_eye", THESIS_SIZE)?;
    let recorded = record(&path, &settings)?;
    let work = recorded.frames.last().map(|f| f.work).unwrap_or_default();
    let instanced = recorded.instanced_calls.last().copied().unwrap_or(0);
    let quads = (work.triangles / 2) as f64;
    let fewer = quads / instanced.max(1) as f64;
    let mut figures = vec![
        figure("calls of two triangles", quads, ""),
        figure("calls of an object", work.draws as f64, ""),
        figure("calls of a template between two batches", instanced as f64, ""),
        figure("batches", work.batches as f64, ""),
        figure("calls of two triangles over calls of a template", fewer, ""),
    ];
    let mut time = None;
    if let Some(gpu) = context.gpu {
        let device = Device::new(gpu, context.hardware, &path.town)?;
        let drawn = |drawing| ("birds_eye", &settings, drawing);
        let ratio = device.ratio(drawn(Drawing::PerQuad), drawn(Drawing::Instanced))?;
        figures.push(figure("time by two triangles over instances, device", ratio.median, ""));
        figures.push(figure("the same, MAD", ratio.mad, ""));
        time = Some(ratio.median).filter(|_| context.hardware);
    }
    let because = match time {
        Some(time) => format!("{fewer:.0} times fewer calls, {time:.1} times faster"),
        None => format!("{fewer:.0} times fewer calls; their time needs hardware"),
    };
    Ok(judged(strongly(fewer, time), because, figures))
}

#[cfg(test)]
mod tests {
    use super::*;
    use Verdict::{NeedsHardware, Open, Refuted, Reproduced};

    #[test]
    fn time_may_grow_less_than_triangles() {
        assert_eq!(slower(54.0, 626.0), Reproduced);
        assert_eq!(slower(400.0, 626.0), Open);
        assert_eq!(slower(700.0, 626.0), Refuted);
        assert_eq!(slower(f64::NAN, 626.0), Refuted);
        assert_eq!(on_hardware(false, Reproduced), NeedsHardware);
        assert_eq!(on_hardware(true, Refuted), Refuted);
    }

    #[test]
    fn ratios_meet_the_table_or_not() {
        assert_eq!(as_fast(9.0, 10.0), Reproduced);
        assert_eq!(as_fast(3.0, 10.0), Open);
        assert_eq!(as_fast(0.9, 10.0), Refuted);
        assert_eq!(as_fast(f64::NAN, 10.0), Refuted);
    }

    #[test]
    fn instances_help_by_calls_and_by_time() {
        assert_eq!(strongly(20.0, Some(3.0)), Reproduced);
        assert_eq!(strongly(20.0, Some(1.5)), Open);
        assert_eq!(strongly(20.0, Some(0.9)), Refuted);
        assert_eq!(strongly(20.0, None), NeedsHardware);
        assert_eq!(strongly(5.0, None), Refuted);
    }
}
