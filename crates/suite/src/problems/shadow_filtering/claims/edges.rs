//! H7.4, D7.1 and D7.2: where the edge of a shadow lies and how wide it is.

use super::{
    still::{ESM, VSM},
    verdict::{all_of, count, figure, judged, near, vote},
};
use crate::{
    SuiteError,
    claims::{Claim, ClaimContext, Figure, Judged, Verdict},
    scene,
};
use dapple_metrics::edge;
use dapple_scene::LightView;
use dapple_shadows::filtering::{
    DepthMap, Estimator, Receiver, Settings, cpu, estimators::gaussian, estimators::power,
};
use dapple_trace::Tracer;
use glam::DVec3;
use std::f64::consts::SQRT_2;

/// Window of the profiles, texels.
const KERNEL: u32 = 15;
/// Samples a texel along a profile.
const STEPS: i32 = 16;
/// Biases as a share of the depth between occluder and receiver.
const SHARES: [f64; 4] = [0.01, 0.05, 0.1, 0.2];

pub fn claims() -> Vec<Claim> {
    vec![
        Claim {
            id: "gumbau-H7.4",
            statement: "The power CDF's edges are sharper than those of PCF, VSM, ESM and the \
                        Gaussian with the same window, and at 512 texels about as sharp as the \
                        others at 1024",
            place: "Gumbau 2011, section 7.3 (L1949 to 1953), figure 7.5",
            method: "half_plane, profile across the edge at 16 samples a texel, window 15 texels, \
                     f32, cpu form, biases of 1, 5, 10 and 20 % of the depth between occluder and \
                     receiver, which span 98 % of the depth range (the source gives no bias), one \
                     bias for all methods. Sharper: a 10-90 % width at least 5 % below the \
                     narrowest of the others (a profile's grid is finer); widths under a texel do \
                     not count on either side, they are aliased rather than sharp (ESM under a \
                     large bias); as sharp at half the \
                     resolution: a width in metres at most sqrt(2) times PCF's at 1024, nearer to \
                     equal than to the doubling that resolution alone brings. Each voted over the \
                     biases; refuted if either holds at none, reproduced if both hold at all. The \
                     offset of the 50 % level from the true edge is printed: an edge may be sharp \
                     because it was moved; and the others' widths at a bias of 1e-3 of the range",
            judge: Box::new(sharper),
        },
        Claim {
            id: "gumbau-D7.1",
            statement: "The Gaussian CDF moves the 50 % edge of a planar shadow outwards, to where \
                        31.3 % of the window is covered: 0.187 of a window",
            place: "Follows from Gumbau 2011, eq. 7.4, for two depths: 1 - erf sqrt(p / 2(1 - p))",
            method: "bisection of the estimator for two depths, f64, within 1e-3 of 0.313 (three \
                     digits and the approximate erf); and the 50 % crossing of the half_plane \
                     profile, window 31 texels, map 512, no bias and no least variance, within \
                     1/31 of a window (a texel) of 0.187",
            judge: Box::new(gaussian_dilates),
        },
        Claim {
            id: "gumbau-D7.2",
            statement: "The power CDF moves the 50 % edge outwards to where a share of about 2.5 \
                        times the relative bias is covered: bias is its hidden knob",
            place: "Follows from Gumbau 2011, eqs. 7.6 and 7.7, for two depths",
            method: "bisection of the estimator for two depths at biases of 0.01, 0.05, 0.1, 0.2 \
                     of their distance, f64: within 1e-3 of 0.026, 0.124, 0.235, 0.421 (three \
                     digits) and each within 20 % of 2.5 times the bias; and the half_plane \
                     profile (window 31, map 512) within a texel of that place",
            judge: Box::new(power_dilates),
        },
    ]
}

/// The half-plane's map and projection.
struct HalfPlane {
    view: LightView,
    map: DepthMap,
    /// Depth between occluder and receiver, normalised.
    gap: f64,
}

impl HalfPlane {
    fn new(resolution: u32) -> Result<Self, SuiteError> {
        let loaded = scene::load("half_plane", 0)?;
        let tracer = Tracer::build(&loaded.scene)?;
        let (view, _) = scene::light_view(&loaded.scene, &tracer.bounds())?;
        let depths = dapple_trace::depth_map(&tracer, &view, resolution, resolution);
        // The occluder lies 2 m above the floor.
        let gap = view.project(DVec3::ZERO).z - view.project(DVec3::Y * 2.0).z;
        Ok(Self { view, map: DepthMap { width: resolution, height: resolution, depths }, gap })
    }

    fn texel_m(&self) -> f64 {
        self.view.side_m() / f64::from(self.map.width)
    }

    /// Visibility along the floor from 1.5 windows inside the shadow to as far outside.
    fn profile(&self, s: &Settings) -> Result<Vec<f64>, SuiteError> {
        let reach = 3 * s.width_texels as i32 * STEPS / 2;
        let receiver = |i: i32| {
            let x = f64::from(i) / f64::from(STEPS) * self.texel_m();
            let p = self.view.project(DVec3::new(x, 0.0, 0.1));
            Receiver::new(p.x as f32, p.y as f32, p.z as f32)
        };
        let receivers: Vec<Receiver> = (-reach..=reach).map(receiver).collect();
        let mut filter = cpu::Filter::new(self.map.width, self.map.height, s)?;
        filter.prefilter(&self.map)?;
        let mut out = vec![0.0; receivers.len()];
        filter.shade(&self.map, &receivers, &mut out)?;
        Ok(out.into_iter().map(f64::from).collect())
    }

    /// Distance of the 50 % level from the true edge, outwards, in windows.
    fn offset(&self, s: &Settings, profile: &[f64]) -> Result<Option<f64>, SuiteError> {
        let middle = (profile.len() - 1) as f64 / 2.0;
        let window = f64::from(STEPS) * f64::from(s.width_texels);
        Ok(edge::position_50(profile)?.map(|at| (at - middle) / window))
    }

    /// 10-90 % width, texels.
    fn width(&self, profile: &[f64]) -> Result<Option<f64>, SuiteError> {
        Ok(edge::width_10_90(profile)?.map(|steps| steps / f64::from(STEPS)))
    }
}

/// Narrowest edge that is still antialiased, texels.
const ANTIALIASED: f64 = 1.0;

/// Widths at one bias, texels; `None` where the profile never reaches 10 % or 90 %.
struct Widths {
    power: Option<f64>,
    others: Vec<f64>,
    /// PCF's at the finer map.
    pcf: f64,
}

/// Sharper than the narrowest, and at half the resolution nearly as sharp in metres.
fn as_stated(all: &[Widths]) -> (Verdict, String) {
    let narrowest = |w: &Widths| {
        w.others.iter().copied().filter(|o| *o >= ANTIALIASED).fold(f64::INFINITY, f64::min)
    };
    let power = |w: &Widths| w.power.filter(|p| *p >= ANTIALIASED);
    let sharper: Vec<bool> =
        all.iter().map(|w| power(w).is_some_and(|p| p <= 0.95 * narrowest(w))).collect();
    // A texel of the coarser map is twice as long.
    let half: Vec<bool> =
        all.iter().map(|w| power(w).is_some_and(|p| 2.0 * p <= SQRT_2 * w.pcf)).collect();
    let because = format!(
        "sharper at {} biases; at half the resolution about as sharp at {}",
        count(&sharper),
        count(&half)
    );
    (all_of(&[vote(&sharper), vote(&half)]), because)
}

fn sharper(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let (coarse, fine) = (HalfPlane::new(512)?, HalfPlane::new(1024)?);
    let (mut figures, mut all) = (Vec::new(), Vec::new());
    for share in SHARES {
        let settings = |estimator| Settings {
            width_texels: KERNEL,
            bias: (share * fine.gap) as f32,
            ..Settings::new(estimator)
        };
        let mut measure = |plane: &HalfPlane, name: &str, estimator| {
            let s = settings(estimator);
            let profile = plane.profile(&s)?;
            let (width, offset) = (plane.width(&profile)?, plane.offset(&s, &profile)?);
            let what = format!("{name} at {}, bias {share}", plane.map.width);
            figures.extend(width.map(|w| figure(format!("{what}: 10-90 % width"), w, "texels")));
            let metres = |w: f64| figure(format!("{what}: width"), w * plane.texel_m(), "m");
            figures.extend(width.map(metres));
            let moved = |o: f64| figure(format!("{what}: 50 % level moved out"), o, "windows");
            figures.extend(offset.map(moved));
            Ok::<_, SuiteError>(width)
        };
        let power = measure(&coarse, "power", Estimator::PowerCdf)?;
        let mut others = Vec::new();
        for (name, estimator) in [
            ("PCF", Estimator::Pcf { taps: 0 }),
            ("VSM", VSM),
            ("ESM", ESM),
            ("Gaussian", Estimator::GaussianCdf),
        ] {
            others.extend(measure(&coarse, name, estimator)?);
        }
        let pcf = measure(&fine, "PCF", Estimator::Pcf { taps: 0 })?;
        all.push(Widths { power, others, pcf: pcf.unwrap_or(f64::INFINITY) });
    }
    for (name, estimator) in [("VSM", VSM), ("ESM", ESM), ("Gaussian", Estimator::GaussianCdf)] {
        let s = Settings { width_texels: KERNEL, ..Settings::new(estimator) };
        let profile = coarse.profile(&s)?;
        let what = format!("{name} at 512, bias {:e} of the range: 10-90 % width", s.bias);
        figures.extend(coarse.width(&profile)?.map(|w| figure(what, w, "texels")));
    }
    let (verdict, because) = as_stated(&all);
    Ok(judged(verdict, because, figures))
}

/// The covered share of a window at which a falling visibility passes 1/2.
fn covered_at_half(visibility: impl Fn(f64) -> f64) -> f64 {
    let (mut lit, mut dark) = (0.0, 1.0);
    for _ in 0..60 {
        let middle = 0.5 * (lit + dark);
        if visibility(middle) > 0.5 { lit = middle } else { dark = middle }
    }
    0.5 * (lit + dark)
}

/// Share `p` at depth 0, the rest at 1, receiver at 1.
fn gaussian_of_two(p: f64) -> f64 {
    gaussian::visibility(1.0 - p, 1.0 - p, 1.0, 0.0)
}

/// The same for the power estimator with the receiver at 1 - `bias`.
fn power_of_two(p: f64, bias: f64) -> f64 {
    power::visibility(0.0, 1.0, 1.0 - p, 1.0 - bias, 0.0)
}

/// Offset on the half-plane's map, windows; an error in words where there is no edge.
fn measured_offset(plane: &HalfPlane, s: &Settings) -> Result<f64, SuiteError> {
    let offset = plane.offset(s, &plane.profile(s)?)?;
    offset.ok_or_else(|| SuiteError::Internal("half_plane: the profile holds no edge".into()))
}

fn on_map(estimator: Estimator, bias: f64) -> Settings {
    Settings { width_texels: 31, bias: bias as f32, min_variance: 0.0, ..Settings::new(estimator) }
}

fn gaussian_dilates(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let share = covered_at_half(gaussian_of_two);
    let plane = HalfPlane::new(512)?;
    let offset = measured_offset(&plane, &on_map(Estimator::GaussianCdf, 0.0))?;
    let exact = measured_offset(&plane, &on_map(Estimator::Pcf { taps: 0 }, 1e-4))?;
    let verdict = near(&[(share, 0.313, 1e-3), (offset, 0.187, 1.0 / 31.0)]);
    let figures = vec![
        figure("covered share at v = 1/2, two depths", share, ""),
        figure("half_plane: 50 % level moved out", offset, "windows"),
        figure("half_plane: the same for PCF", exact, "windows"),
    ];
    let because = format!("p = {share:.4}; on the map the edge moves by {offset:.3} of a window");
    Ok(judged(verdict, because, figures))
}

fn power_dilates(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let plane = HalfPlane::new(512)?;
    let (mut figures, mut values): (Vec<Figure>, _) = (Vec::new(), Vec::new());
    for (bias, predicted) in SHARES.into_iter().zip([0.026, 0.124, 0.235, 0.421]) {
        let share = covered_at_half(|p| power_of_two(p, bias));
        let settings = on_map(Estimator::PowerCdf, bias * plane.gap);
        let offset = measured_offset(&plane, &settings)?;
        figures.push(figure(format!("bias {bias}: covered share at v = 1/2"), share, ""));
        figures.push(figure(format!("bias {bias}: share over bias"), share / bias, ""));
        let what = format!("half_plane, bias {bias}: 50 % level moved out");
        figures.push(figure(what, offset, "windows"));
        values.push((share, predicted, 1e-3));
        values.push((share / bias, 2.5, 0.5));
        values.push((offset, 0.5 - share, 1.0 / 31.0));
    }
    let because = format!(
        "share over bias runs from {:.2} to {:.2}; the edge moves by up to {:.2} of a window",
        values[1].0, values[10].0, values[2].0
    );
    Ok(judged(near(&values), because, figures))
}

#[cfg(test)]
mod tests {
    use super::*;
    use Verdict::{Open, Refuted, Reproduced};

    fn widths(power: Option<f64>) -> Widths {
        Widths { power, others: vec![12.0, 11.0], pcf: 12.0 }
    }

    #[test]
    fn sharpness_gives_each_verdict() {
        assert_eq!(as_stated(&[widths(Some(8.0))]).0, Reproduced);
        // Sharper than the others, but not enough for half the resolution.
        assert_eq!(as_stated(&[widths(Some(10.0))]).0, Refuted);
        assert_eq!(as_stated(&[widths(Some(8.0)), widths(Some(10.0))]).0, Open);
        assert_eq!(as_stated(&[widths(Some(11.0))]).0, Refuted);
        assert_eq!(as_stated(&[widths(None)]).0, Refuted);
        // Aliased edges are not sharp, on either side.
        assert_eq!(as_stated(&[widths(Some(0.5))]).0, Refuted);
        let aliased = Widths { others: vec![12.0, 0.2], ..widths(Some(8.0)) };
        assert_eq!(as_stated(&[aliased]).0, Reproduced);
    }

    #[test]
    fn half_is_found_on_a_ramp() {
        assert!((covered_at_half(|p| 1.0 - p) - 0.5).abs() < 1e-12);
        assert!((covered_at_half(|p| 1.0 - 2.0 * p) - 0.25).abs() < 1e-12);
        // 1 - erf sqrt(p / 2(1 - p)) = 1/2 at p / (1 - p) = 0.4549.
        assert!((gaussian_of_two(0.3127) - 0.5).abs() < 1e-3);
    }

    #[test]
    fn percentage_closer_edges_are_ramps_at_the_true_place() {
        let plane = HalfPlane::new(256).unwrap();
        let s = Settings { width_texels: 15, ..Settings::new(Estimator::Pcf { taps: 0 }) };
        let profile = plane.profile(&s).unwrap();
        let offset = plane.offset(&s, &profile).unwrap().unwrap();
        assert!(offset.abs() < 0.01, "{offset}");
        // 80 % of the window's 15 texels.
        let width = plane.width(&profile).unwrap().unwrap();
        assert!((width - 12.0).abs() < 0.3, "{width}");
        assert!((plane.gap - 2.0 / (plane.view.far_m - plane.view.near_m)).abs() < 1e-12);
    }
}
