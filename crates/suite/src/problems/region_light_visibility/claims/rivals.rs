//! The raster that the source sets out from, and rays.

use super::{
    support::{OURS, VIEW, agreement, judged_faces, least_ns, one, prepared},
    verdict::{figure, judged},
};
use crate::{
    SuiteError,
    claims::{Claim, ClaimContext, Judged, Verdict},
};
use dapple_many_lights::region::{FacadeCluster, RegionTechnique, Sampled};

/// Faces that are judged and timed.
const FACES: u32 = 12;

/// Texels a side of the plane's map, and rays a light.
const TEXELS: [u32; 4] = [64, 128, 256, 1024];
const RAYS: [u32; 4] = [1, 4, 16, 64];

/// Share of the hidden lights by which two techniques are as tight.
const AS_TIGHT: f64 = 0.01;

/// Times or bytes by which one is surely cheaper.
const SURELY: f64 = 1.5;

/// The raster has no threshold: ours goes without as well.
const BARE: RegionTechnique =
    RegionTechnique::FacadeCluster(FacadeCluster { threshold: 0.0, ..OURS });

pub fn claims() -> Vec<Claim> {
    vec![
        Claim {
            id: "conte-H4.7",
            statement: "Evaluated in closed form, visibility has no artifacts of resolution; a raster has",
            place: "Conte 2018, section 4.2.4",
            method: "city, close-ended street, 12 faces by chance: share of the hidden lights that \
                     extended projections keep on maps of 64 to 1024 texels a side, conservative at \
                     each. Met if every finer map keeps less and nothing is left out that is seen, by \
                     either; contradicted if all maps keep the same to 1 in 1000, or the closed form \
                     leaves out a light that is seen. What has no resolution has nothing to vary",
            judge: Box::new(resolution),
        },
        Claim {
            id: "durand-raster-cost",
            statement: "The closed form is faster and smaller than a raster that is as tight",
            place: "Conte 2018, section 4.2.1, of Durand et al. 2000; raster on the processor here",
            method: "the same faces on one thread, without a threshold: the smallest map that keeps at \
                     most 1 in 100 of the hidden lights more than the closed form, or the largest. \
                     Time and bytes of the map over those of the closed form: both 1.5 or more is met, \
                     both 1/1.5 or less contradicts",
            judge: Box::new(cost),
        },
        Claim {
            id: "wonka-sampled",
            statement: "Visibility by rays errs to the hidden side, and less so with more rays",
            place: "Wonka et al. 2006, section 1",
            method: "the same faces, 1, 4, 16 and 64 rays a light: share of the seen lights that is \
                     left out. Met if every four times the rays leave out less, and 1 ray some; \
                     contradicted if 1 ray leaves out none, or 64 rays no less than 1",
            judge: Box::new(rays),
        },
        Claim {
            id: "conte-rival-sampled",
            statement: "At equal time rays leave out lights that are seen; the closed form leaves out none",
            place: "goal of this project",
            method: "the same faces on one thread: the most rays a light whose time is at most that of \
                     the closed form, or one ray if that takes longer. Met if the closed form leaves out \
                     no light that is seen and rays do, contradicted if the closed form does, or rays \
                     do not",
            judge: Box::new(equal_time),
        },
    ]
}

fn sampled(rays: u32) -> RegionTechnique {
    RegionTechnique::Sampled(Sampled { rays, seed: 0 })
}

fn raster(texels: u32) -> RegionTechnique {
    RegionTechnique::ExtendedProjection { texels }
}

/// Shares kept by maps from coarse to fine, and lights seen that are left out by the closed form and
/// by maps.
fn depends(kept: &[f64], false_culls: [u64; 2]) -> Verdict {
    let (low, high) =
        kept.iter().fold((f64::INFINITY, 0.0_f64), |(l, h), k| (l.min(*k), h.max(*k)));
    if false_culls[0] > 0 || high - low <= 1e-3 {
        Verdict::Refuted
    } else if false_culls[1] == 0 && kept.array_windows().all(|[coarse, fine]| fine < coarse) {
        Verdict::Reproduced
    } else {
        Verdict::Open
    }
}

fn resolution(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let case = prepared("city", VIEW, FACES)?;
    let closed = agreement(&case, &BARE, None)?;
    let mut figures = vec![
        figure("closed form: kept of the hidden", closed.false_visible(), ""),
        figure("closed form: seen and left out", closed.seen_culled as f64, ""),
    ];
    let (mut kept, mut false_culls) = (Vec::new(), 0);
    for texels in TEXELS {
        let map = agreement(&case, &raster(texels), None)?;
        figures.extend([
            figure(format!("{texels} texels: kept of the hidden"), map.false_visible(), ""),
            figure(format!("{texels} texels: seen and left out"), map.seen_culled as f64, ""),
        ]);
        kept.push(map.false_visible());
        false_culls += map.seen_culled;
    }
    let told: Vec<String> = kept.iter().map(|share| format!("{:.1} %", 100.0 * share)).collect();
    let because = format!(
        "maps keep {} of the hidden, the closed form {:.1} %",
        told.join(", "),
        100.0 * closed.false_visible()
    );
    Ok(judged(depends(&kept, [closed.seen_culled, false_culls]), because, figures))
}

/// Time and bytes of the raster over those of the closed form.
fn cheaper([time, bytes]: [f64; 2]) -> Verdict {
    let ratios = [time, bytes];
    if ratios.iter().all(|ratio| *ratio >= SURELY) {
        Verdict::Reproduced
    } else if ratios.iter().all(|ratio| *ratio <= 1.0 / SURELY) {
        Verdict::Refuted
    } else {
        Verdict::Open
    }
}

fn cost(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let case = prepared("city", VIEW, FACES)?;
    let asked = judged_faces(&case);
    let faces = asked.len().max(1) as f64;
    let closed = agreement(&case, &BARE, None)?.false_visible();
    let mut form = one(&case, &BARE, None)?;
    let ns = least_ns(&mut *form, &asked, 5);
    let bytes = form.bytes().max(1) as f64;
    let mut figures = vec![
        figure("closed form: kept of the hidden", closed, ""),
        figure("closed form: time", ns / faces / 1e3, "us an evaluation"),
        figure("closed form: memory of a thread", bytes, "B"),
    ];
    let (mut ratios, mut of) = ([f64::NAN; 2], 0);
    for texels in TEXELS {
        let kept = agreement(&case, &raster(texels), None)?.false_visible();
        let mut map = one(&case, &raster(texels), None)?;
        let time = least_ns(&mut *map, &asked, 1);
        (ratios, of) = ([time / ns, map.bytes() as f64 / bytes], texels);
        figures.extend([
            figure(format!("{texels} texels: kept of the hidden"), kept, ""),
            figure(format!("{texels} texels: time over the closed form's"), ratios[0], ""),
            figure(format!("{texels} texels: memory over the closed form's"), ratios[1], ""),
        ]);
        if kept <= closed + AS_TIGHT {
            break;
        }
    }
    let because = format!(
        "{of} texels a side take {:.0} times the time and {:.1} times the memory",
        ratios[0], ratios[1]
    );
    Ok(judged(cheaper(ratios), because, figures))
}

/// Shares of the seen that is left out, from few rays to many.
fn errs(left_out: &[f64]) -> Verdict {
    let (Some(few), Some(many)) = (left_out.first(), left_out.last()) else { return Verdict::Open };
    // Written so that a NaN contradicts.
    let is_less = *few > 0.0 && many < few;
    if !is_less {
        Verdict::Refuted
    } else if left_out.array_windows().all(|[few, many]| many < few || *few == 0.0) {
        Verdict::Reproduced
    } else {
        Verdict::Open
    }
}

fn rays(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let case = prepared("city", VIEW, FACES)?;
    let (mut figures, mut left_out) = (Vec::new(), Vec::new());
    for rays in RAYS {
        let found = agreement(&case, &sampled(rays), None)?;
        figures.extend([
            figure(format!("{rays} rays: left out of the seen"), found.false_hidden(), ""),
            figure(format!("{rays} rays: kept of the hidden"), found.false_visible(), ""),
        ]);
        left_out.push(found.false_hidden());
    }
    let told: Vec<String> =
        left_out.iter().map(|share| format!("{:.1} %", 100.0 * share)).collect();
    Ok(judged(errs(&left_out), format!("{} left out", told.join(", ")), figures))
}

/// Lights seen that the closed form leaves out, and those that rays do at its time.
fn wins(closed: u64, rays: u64) -> Verdict {
    if closed > 0 || rays == 0 { Verdict::Refuted } else { Verdict::Reproduced }
}

fn equal_time(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let case = prepared("city", VIEW, FACES)?;
    let asked = judged_faces(&case);
    let ours = RegionTechnique::FacadeCluster(OURS);
    let closed = agreement(&case, &ours, None)?;
    let ns = least_ns(&mut *one(&case, &ours, None)?, &asked, 5);
    let mut figures = vec![
        figure("closed form: left out of the seen", closed.false_hidden(), ""),
        figure("closed form: kept of the hidden", closed.false_visible(), ""),
    ];
    let mut affordable = (RAYS[0], f64::NAN);
    for rays in RAYS {
        let time = least_ns(&mut *one(&case, &sampled(rays), None)?, &asked, 1) / ns;
        figures.push(figure(format!("{rays} rays: time over the closed form's"), time, ""));
        if time <= 1.0 || rays == RAYS[0] {
            affordable = (rays, time);
        }
        if time > 1.0 {
            break;
        }
    }
    let (rays, time) = affordable;
    let found = agreement(&case, &sampled(rays), None)?;
    figures.extend([
        figure(format!("{rays} rays: left out of the seen"), found.false_hidden(), ""),
        figure(format!("{rays} rays: kept of the hidden"), found.false_visible(), ""),
    ]);
    let because = format!(
        "{rays} rays a light take {time:.1} times the time and leave out {:.1} % of what is seen",
        100.0 * found.false_hidden()
    );
    Ok(judged(wins(closed.seen_culled, found.seen_culled), because, figures))
}

#[cfg(test)]
mod tests {
    use super::*;
    use Verdict::{Open, Refuted, Reproduced};

    #[test]
    fn maps_depend_on_resolution_or_not() {
        assert_eq!(depends(&[0.8, 0.5, 0.4], [0, 0]), Reproduced);
        assert_eq!(depends(&[0.8, 0.9, 0.4], [0, 0]), Open);
        assert_eq!(depends(&[0.8, 0.5, 0.4], [0, 1]), Open);
        assert_eq!(depends(&[0.4, 0.4, 0.4], [0, 0]), Refuted);
        assert_eq!(depends(&[0.8, 0.5, 0.4], [1, 0]), Refuted);
    }

    #[test]
    fn cheaper_is_both() {
        assert_eq!([[9.0, 2.0], [9.0, 0.2], [0.1, 0.2]].map(cheaper), [Reproduced, Open, Refuted]);
        assert_eq!(cheaper([f64::NAN, 2.0]), Open);
    }

    #[test]
    fn rays_err_less_with_more_of_them_or_not() {
        assert_eq!(errs(&[0.5, 0.2, 0.0, 0.0]), Reproduced);
        assert_eq!(errs(&[0.5, 0.2, 0.3]), Open);
        assert_eq!([errs(&[0.0, 0.0]), errs(&[0.2, 0.3])], [Refuted, Refuted]);
        assert_eq!([errs(&[f64::NAN, 0.1]), errs(&[])], [Refuted, Open]);
    }

    #[test]
    fn rays_lose_or_win() {
        assert_eq!([wins(0, 3), wins(0, 0), wins(1, 3)], [Reproduced, Refuted, Refuted]);
    }
}
