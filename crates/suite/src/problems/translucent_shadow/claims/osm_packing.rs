//! H3.3, H3.4, H3.6, H3.7: layers over textures and passes, and what taps cost.

use super::{
    support::{CpuRun, Method, Still, osm, still},
    verdict::{all_of, figure, judged},
};
use crate::{
    SuiteError,
    claims::{Claim, ClaimContext, Figure, Judged, Verdict},
};
use dapple_metrics::{max_abs, stats};
use dapple_opacity_maps::{
    Code, Fragments, Packing, Taps,
    cpu::Maps,
    layered::counters::{self, building},
};
use std::time::Instant;

/// Frames timed in turn.
const PAIRS: usize = 11;

/// What doubling the maps from 4 to 8 costs in the source's table 6.1.1 at the least: 147.58
/// frames a second against 124.85. Who doubles the maps calls less than that little.
const LITTLE: f64 = 147.58 / 124.85;

pub fn claims() -> Vec<Claim> {
    vec![
        Claim {
            id: "voicu-H3.3",
            statement: "Four maps in the channels of a texture hold what one map a texture does, \
                        in a quarter of the memory",
            place: "Voicu 2011, section 3.3; appendix 2",
            method: "64 maps, one a texture against four a texture and slab, on grass, tree and \
                     hair. Equal: transmittances differ by no more than each fragment of the \
                     fullest texel rounding once (2^-24 of the sum, and x e^-x is at most 1/e), a \
                     prefix of slabs once more; memory: bytes a texel as stored, exactly a quarter",
            judge: Box::new(channels),
        },
        Claim {
            id: "voicu-H3.4",
            statement: "Eight render targets in a pass give the maps of several passes, faster",
            place: "Voicu 2011, section 3.4",
            method: "32 maps: one pass of eight targets against one pass a map and one a texture. \
                     Equal as in H3.3. Faster: median ratio of paired times below 1 by more than \
                     three median deviations, on hardware; the processor's and a software \
                     adapter's ratios are shown and do not vote",
            judge: Box::new(targets),
        },
        Claim {
            id: "voicu-H3.6",
            statement: "16 taps cost little, as the texture cache holds what they share",
            place: "Voicu 2011, section 3.5",
            method: "frame time with 4 x 4 taps over one tap, 32 maps, on hardware. `Little`: below \
                     1.18, what doubling the maps from 4 to 8 costs at the least in table 6.1.1; \
                     from 1.5 on, half a frame, no one calls it little; open between. The \
                     processor's ratios (frame and shading) are shown",
            judge: Box::new(taps),
        },
        Claim {
            id: "voicu-H3.7",
            statement: "Maps of N fragments in K layers cost N K steps pass by pass, and N + K where \
                        fragments are sorted into slabs",
            place: "Voicu 2011, section 1.1",
            method: "steps = fragments read, channels blended and words written, from the layout, on \
                     hair; every fragment doubled, and maps from 16 to 32. Interaction = (steps of \
                     both doubled - each doubled alone + neither) / both doubled: 1/4 for a \
                     product, 0 for a sum. Agrees if the passes' exceeds 0.2 and the sorted's is \
                     below 0.02. Times of the processor's form are shown: rounding of clocks and \
                     caches makes them a weaker witness",
            judge: Box::new(steps),
        },
    ]
}

/// Greatest difference of transmittances, and what rounding allows.
fn difference(still: &Still, a: &Method, b: &Method) -> Result<(f64, f64), SuiteError> {
    let shade =
        |method: &Method| -> Result<Vec<f32>, SuiteError> { still.shade(&still.maps(method)?) };
    let fragments = still.fragments(a)?;
    let most = (0..fragments.texels()).map(|t| fragments.texel(t).len()).max().unwrap_or(0);
    let roundings = most as f64 + a.layers().div_ceil(4) as f64;
    let allowed = 2.0 * roundings * 2f64.powi(-24) / std::f64::consts::E + 2f64.powi(-22);
    Ok((max_abs(&shade(a)?, &shade(b)?, None)?, allowed))
}

/// Differences with what is allowed, and the share of memory.
fn same(differences: &[(f64, f64)], memory: f64) -> Verdict {
    let equal = differences.iter().all(|(got, allowed)| got <= allowed);
    if equal && memory == 0.25 { Verdict::Reproduced } else { Verdict::Refuted }
}

fn channels(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let single = osm(64).packing(Packing::Single);
    let slabs = osm(64).packing(Packing::Slabs);
    let (mut figures, mut differences, mut memory) = (Vec::new(), Vec::new(), f64::NAN);
    for scene in ["grass", "tree", "hair"] {
        let still = still(scene)?;
        let (got, allowed) = difference(&still, &single, &slabs)?;
        figures.push(figure(format!("{scene}: greatest difference"), got, ""));
        figures.push(figure(format!("{scene}: allowed"), allowed, ""));
        differences.push((got, allowed));
        let bytes = |method| -> Result<f64, SuiteError> {
            Ok(still.maps(method)?.code().bytes_per_texel() as f64)
        };
        memory = bytes(&slabs)? / bytes(&single)?;
    }
    figures.push(figure("bytes of four maps a texture over one", memory, ""));
    let most = differences.iter().map(|d| d.0).fold(0.0, f64::max);
    let because = format!("transmittances differ by at most {most:.1e}; memory is {memory} of it");
    Ok(judged(same(&differences, memory), because, figures))
}

/// Whether `a` is faster than `b` by a ratio and its deviation; only hardware decides.
pub fn faster(hardware: Option<(f64, f64)>) -> Verdict {
    match hardware {
        None => Verdict::NeedsHardware,
        Some((ratio, mad)) if (ratio - 1.0).abs() <= 3.0 * mad => Verdict::Open,
        Some((ratio, _)) if ratio < 1.0 => Verdict::Reproduced,
        Some(_) => Verdict::Refuted,
    }
}

/// Paired times of two methods on the processor and on the device where there is one, as figures;
/// median and deviation of the device's where it is hardware.
pub fn timed(
    context: &ClaimContext<'_>,
    still: &Still,
    what: &str,
    (a, b): (&Method, &Method),
    figures: &mut Vec<Figure>,
) -> Result<Option<(f64, f64)>, SuiteError> {
    let name = &still.name;
    let mut tell = |form: &str, ratio: &stats::Ratio| {
        figures.push(figure(format!("{name}: time, {what}, {form}"), ratio.median, ""));
        figures.push(figure("the same, median absolute deviation", ratio.mad, ""));
    };
    tell("cpu form", &still.cpu_ratio(PAIRS, a, b)?);
    let Some(gpu) = context.gpu else { return Ok(None) };
    let ratio = still.gpu_ratio(gpu, PAIRS, a, b)?;
    tell(if context.hardware { "device" } else { "software adapter" }, &ratio);
    Ok(context.hardware.then_some((ratio.median, ratio.mad)))
}

fn targets(context: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let at_once = osm(32).packing(Packing::Targets(8));
    let (mut figures, mut parts) = (Vec::new(), Vec::new());
    let still = still("grass")?;
    for (name, packing) in
        [("one map a pass", Packing::Single), ("one texture a pass", Packing::Slabs)]
    {
        let several = osm(32).packing(packing);
        let (got, allowed) = difference(&still, &at_once, &several)?;
        figures.push(figure(format!("greatest difference from {name}"), got, ""));
        figures.push(figure("allowed", allowed, ""));
        parts.push(same(&[(got, allowed)], 0.25));
        let what = format!("eight targets over {name}");
        parts.push(faster(timed(context, &still, &what, (&at_once, &several), &mut figures)?));
    }
    let verdict = all_of(&parts);
    let because = match verdict {
        Verdict::Refuted if parts.iter().step_by(2).any(|p| *p == Verdict::Refuted) => {
            "the maps differ by more than rounding"
        }
        Verdict::Refuted => "the maps are the same, and one pass is no faster",
        Verdict::Reproduced => "the maps are the same, and one pass is faster",
        Verdict::NeedsHardware => "the maps are the same to rounding; times need hardware",
        Verdict::Open => "the maps are the same to rounding; times do not decide",
    };
    Ok(judged(verdict, because, figures))
}

/// Frame with 16 taps over one with one.
fn little(hardware: Option<f64>) -> Verdict {
    match hardware {
        None => Verdict::NeedsHardware,
        Some(ratio) if ratio < LITTLE => Verdict::Reproduced,
        Some(ratio) if ratio >= 1.5 => Verdict::Refuted,
        Some(_) => Verdict::Open,
    }
}

fn taps(context: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let (sixteen, one) = (osm(32).taps(Taps::Box4), osm(32).one_tap());
    let mut figures = vec![figure("`little`", LITTLE, "")];
    let still = still("grass")?;
    let hardware = timed(context, &still, "16 taps over one", (&sixteen, &one), &mut figures)?;
    let (mut a, mut b) = (CpuRun::new(&still, &sixteen)?, CpuRun::new(&still, &one)?);
    let shading = super::verdict::paired(PAIRS, || a.shade_ns(), || b.shade_ns())?;
    figures.push(figure("grass: the same, cpu form, shading alone", shading.median, ""));
    let because = match hardware {
        Some((ratio, _)) => format!("a frame takes {ratio:.2} times as long"),
        None => format!(
            "a texture cache is hardware's; on the processor shading alone takes {:.1} times as \
             long",
            shading.median
        ),
    };
    Ok(judged(little(hardware.map(|h| h.0)), because, figures))
}

/// Interaction of fragments and layers: cost of neither doubled, fragments, layers, both.
fn interaction([none, fragments, layers, both]: [f64; 4]) -> f64 {
    (both - fragments - layers + none) / both
}

fn product_and_sum(passes: f64, sorted: f64) -> Verdict {
    match (passes > 0.2, sorted < 0.02) {
        (true, true) => Verdict::Reproduced,
        (false, false) => Verdict::Refuted,
        _ => Verdict::Open,
    }
}

/// Every fragment twice.
fn doubled(fragments: &Fragments) -> Fragments {
    let mut out = fragments.clone();
    out.starts = fragments.starts.iter().map(|s| 2 * s).collect();
    out.items = fragments.items.iter().flat_map(|f| [*f, *f]).collect();
    out
}

fn steps(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let still = still("hair")?;
    let once = still.fragments(&osm(16))?;
    let twice = doubled(&once);
    let mut figures = Vec::new();
    let mut found = [0.0; 2];
    for (slot, (name, packing)) in
        found.iter_mut().zip([("one pass a map", Packing::Single), ("sorted", Packing::Sorted)])
    {
        let (mut steps, mut times) = ([0.0; 4], [0.0; 4]);
        let corners = [(&*once, 16), (&twice, 16), (&*once, 32), (&twice, 32)];
        for (i, (fragments, layers)) in corners.into_iter().enumerate() {
            let method = osm(layers).packing(packing);
            let Code::Layered(layered) = &method.settings.code else { continue };
            let work: counters::Counters = building(layered, &method.settings, fragments);
            steps[i] = (work.fragments_read + work.additions + work.words_written) as f64;
            let mut maps = Maps::new(fragments.width, fragments.height, &method.settings)?;
            let mut ns = Vec::new();
            for _ in 0..7 {
                let start = Instant::now();
                maps.build(fragments)?;
                ns.push(start.elapsed().as_nanos() as f64);
            }
            times[i] = stats::median(&ns)?;
        }
        *slot = interaction(steps);
        figures.push(figure(format!("{name}: steps, 16 maps"), steps[0], ""));
        figures.push(figure(format!("{name}: steps, both doubled"), steps[3], ""));
        figures.push(figure(format!("{name}: interaction of steps"), *slot, ""));
        figures.push(figure(
            format!("{name}: interaction of times, cpu form"),
            interaction(times),
            "",
        ));
        figures.push(figure(
            format!("{name}: time, both doubled over neither"),
            times[3] / times[0],
            "",
        ));
    }
    let [passes, sorted] = found;
    let because = format!(
        "fragments and layers interact by {passes:.3} pass by pass (a product: 0.25) and by \
         {sorted:.3} sorted (a sum: 0)"
    );
    Ok(judged(product_and_sum(passes, sorted), because, figures))
}

#[cfg(test)]
mod tests {
    use super::*;
    use Verdict::{NeedsHardware, Open, Refuted, Reproduced};

    #[test]
    fn channels_must_be_equal_and_a_quarter() {
        assert_eq!(same(&[(1e-7, 1e-6)], 0.25), Reproduced);
        assert_eq!(same(&[(1e-7, 1e-6), (1e-5, 1e-6)], 0.25), Refuted);
        assert_eq!(same(&[(1e-7, 1e-6)], 0.5), Refuted);
        assert_eq!(same(&[(f64::NAN, 1e-6)], 0.25), Refuted);
    }

    #[test]
    fn only_hardware_is_faster_or_little() {
        assert_eq!(faster(None), NeedsHardware);
        assert_eq!(faster(Some((0.5, 0.01))), Reproduced);
        assert_eq!(faster(Some((1.5, 0.01))), Refuted);
        assert_eq!(faster(Some((0.98, 0.01))), Open);
        assert_eq!(little(None), NeedsHardware);
        assert_eq!(little(Some(1.1)), Reproduced);
        assert_eq!(little(Some(1.3)), Open);
        assert_eq!(little(Some(2.0)), Refuted);
    }

    #[test]
    fn a_product_interacts_and_a_sum_does_not() {
        let (n, k) = (3.0, 5.0);
        let product = interaction([n * k, 2.0 * n * k, 2.0 * n * k, 4.0 * n * k]);
        let sum = interaction([n + k, 2.0 * n + k, n + 2.0 * k, 2.0 * n + 2.0 * k]);
        assert_eq!((product, sum), (0.25, 0.0));
        assert_eq!(product_and_sum(product, sum), Reproduced);
        assert_eq!(product_and_sum(sum, sum), Open);
        assert_eq!(product_and_sum(sum, product), Refuted);
    }

    #[test]
    fn a_software_adapter_gives_figures_but_no_verdict() {
        let Some(gpu) = dapple_gpu::testing::test_gpu() else { return };
        let context = ClaimContext { gpu: Some(gpu), hardware: false };
        let judged = targets(&context).unwrap();
        assert_eq!(judged.verdict, NeedsHardware);
        let timed = judged.figures.iter().filter(|f| f.what.contains("software adapter"));
        assert_eq!(timed.filter(|f| f.value > 0.0).count(), 2);
    }
}
