//! H8.1 to H8.3: opaque objects among translucent ones.

use super::{
    support::{Method, Still, bom, dom, osm, still_with},
    verdict::{count, figure, judged, near, vote},
};
use crate::{
    SuiteError,
    claims::{Claim, ClaimContext, Judged},
};
use dapple_metrics::stats;
use dapple_opacity_maps::{
    Fragments, Lookup, NO_OPAQUE, Opaque, Receiver,
    cpu::Maps,
    lighting::{Light, Rules, Surface, luminance, shade},
    taps,
};
use glam::Vec3;
use std::rc::Rc;

/// Scenes with a trunk.
const TRUNKS: [&str; 3] = ["tree", "willow", "trees"];

/// Layers of all maps.
const LAYERS: u32 = 16;

/// A picture is flat if its contrast is less than this part of what shading gives it.
const FLAT: f64 = 0.5;

/// A trunk casts a shadow if less than this part of the light behind it is left.
const SHADOW: f64 = 0.5;

/// Least transmittance by truth of what counts as fully lit.
const LIT: f32 = 0.95;

/// Fewest receivers that a case is judged by.
const FEWEST: usize = 30;

/// Light depth by which an opaque caster must lie in front, well beyond the bias of 0.001.
const IN_FRONT: f32 = 0.01;

/// Receivers, and what light each has left: no case of fewer than [`FEWEST`].
type Shares = Vec<f64>;

pub fn claims() -> Vec<Claim> {
    vec![
        Claim {
            id: "voicu-H8.1",
            statement: "Opaque objects need Blinn-Phong: lit by transmittance alone they look flat",
            place: "Voicu 2011, section 5.3, figure 5.3.1",
            method: "trunks of tree, willow and trees (the ground left out), 384 px, lit at 45 \
                     degrees and from the side, bounding opacity maps of 16 layers: what faces the light and \
                     is in full light by truth (T >= 0.95), so that all it can show is its shape. \
                     Contrast: standard deviation over mean of luminance, without highlights and \
                     with 0.15 of ambient light. Flat: below half the contrast that Blinn-Phong \
                     gives. Voted over the cases of 30 receivers or more",
            judge: Box::new(flat),
        },
        Claim {
            id: "voicu-H8.2",
            statement: "Opaque casters drawn into the opacity maps cast shadows",
            place: "Voicu 2011, section 5.3, figure 5.3.2",
            method: "tree, willow and trees lit at 45 degrees, opacity, deep and bounding maps of \
                     16 layers, one tap: receivers at least 0.01 of the light's depth behind the \
                     nearest opaque surface. Their mean transmittance with the trunk as a fragment \
                     of thickness 3 must be below half of that without it. Voted over nine cases; \
                     a depth map of the opaque casters beside",
            judge: Box::new(trunks),
        },
        Claim {
            id: "voicu-H8.3",
            statement: "Behind an opaque caster of thickness w the share e^-w of the light is left: \
                        5 % for 3",
            place: "Voicu 2011, section 5.3",
            method: "receivers as in H8.2 whose texel holds nothing translucent, thickness 1, 3 \
                     and 10, read by the layer's own sum (thesis): mean transmittance within 1 % \
                     of e^-w for all three methods and scenes. Interpolated sums beside",
            judge: Box::new(leak),
        },
    ]
}

fn slanted(scene: &str, light: &str) -> Result<Rc<Still>, SuiteError> {
    still_with(scene, 0, &[("light", light.into())])
}

/// The same seen by more pixels: trunks are thin.
fn large(scene: &str, light: &str) -> Result<Rc<Still>, SuiteError> {
    still_with(scene, 0, &[("light", light.into()), ("width", 384.into())])
}

/// Standard deviation over mean.
fn contrast(values: &[f64]) -> f64 {
    let n = values.len().max(1) as f64;
    let mean = values.iter().sum::<f64>() / n;
    let variance = values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / n;
    if mean > 0.0 { variance.sqrt() / mean } else { 0.0 }
}

/// Contrast with transmittance alone, and with Blinn-Phong.
fn is_flat(alone: f64, shaded: f64) -> bool {
    alone < FLAT * shaded
}

/// Luminance of lit trunks, with transmittance alone and as opaque surfaces.
fn luminances(still: &Still) -> Result<[Shares; 2], SuiteError> {
    let case = &still.case;
    let [width, height] = case.size();
    let layers = dapple_trace::camera_layers(
        case.tracer(),
        case.caster_opacities(),
        case.camera(),
        width,
        height,
    )?;
    let given = still.shade(&still.maps(&bom(LAYERS))?)?;
    if layers.surfaces.len() != given.len() {
        return Err(SuiteError::Internal("receivers are not the camera's surfaces".into()));
    }
    let towards = -case.view(true).forward;
    let mut out = [Vec::new(), Vec::new()];
    for (i, seen) in layers.surfaces.iter().enumerate() {
        let material = &case.casters().materials[seen.material as usize];
        let trunk = layers.alpha[i] >= 1.0 && material.name != "floor";
        if !(trunk && case.mask()[i] && case.truth()[i] >= LIT) {
            continue;
        }
        let eye = (case.camera().position - seen.position).normalize_or_zero().as_vec3();
        let light = Light {
            towards: towards.as_vec3(),
            diffuse: Vec3::ONE,
            specular: Vec3::ONE,
            attenuation: 1.0,
            transmittance: given[i],
        };
        for (opaque, out) in [false, true].into_iter().zip(&mut out) {
            let surface = Surface {
                normal: seen.normal.as_vec3(),
                tangent: None,
                albedo: Vec3::ONE,
                specular: Vec3::ZERO,
                shininess: 32.0,
                alpha: 1.0,
                opaque,
            };
            let colour = shade(&surface, eye, &[light], Vec3::splat(0.15), &Rules::default());
            out.push(f64::from(luminance(colour)));
        }
    }
    Ok(out)
}

fn flat(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let (mut figures, mut holds) = (Vec::new(), Vec::new());
    for scene in TRUNKS {
        for light in ["slanted", "side"] {
            let [alone, shaded] = luminances(&*large(scene, light)?)?;
            let what = format!("{scene}, light {light}");
            figures.push(figure(format!("{what}: receivers"), alone.len() as f64, ""));
            if alone.len() < FEWEST {
                continue;
            }
            let [alone, shaded] = [contrast(&alone), contrast(&shaded)];
            figures.push(figure(format!("{what}: contrast, transmittance alone"), alone, ""));
            figures.push(figure(format!("{what}: contrast, Blinn-Phong"), shaded, ""));
            holds.push(is_flat(alone, shaded));
        }
    }
    let because = format!("trunks are flat without Blinn-Phong in {} cases", count(&holds));
    Ok(judged(vote(&holds), because, figures))
}

fn methods(still: &Still) -> Result<[(&'static str, Method); 3], SuiteError> {
    let deep = dom(LAYERS, still.deepest()?);
    Ok([("osm", osm(LAYERS)), ("dom", deep), ("bom", bom(LAYERS))]
        .map(|(name, method)| (name, method.one_tap())))
}

fn weighing(mut method: Method, weight: f32) -> Method {
    method.settings.opaque = Opaque::Weight { weight, in_bounds: false };
    method
}

/// Receivers that lie behind an opaque caster, and whether their texel holds leaves.
fn behind(still: &Still, fragments: &Fragments) -> Vec<(usize, bool)> {
    let receivers = still.receivers();
    let hidden = |(i, receiver): (usize, &Receiver)| {
        if !(still.case.mask()[i] && receiver.in_map()) {
            return None;
        }
        let texel = taps::own(receiver, fragments.width, fragments.height);
        let far = receiver.depth - fragments.opaque[texel] > IN_FRONT;
        far.then_some((i, !fragments.texel(texel).is_empty()))
    };
    receivers.iter().enumerate().filter_map(hidden).collect()
}

/// Mean of some receivers' light.
fn mean(light: &[f32], of: impl Iterator<Item = usize>) -> Result<f64, SuiteError> {
    let values: Vec<f64> = of.map(|i| f64::from(light[i])).collect();
    stats::median(&values)?;
    Ok(values.iter().sum::<f64>() / values.len() as f64)
}

/// Light behind trunks with and without them in the maps.
fn casts(with: f64, without: f64) -> bool {
    with < SHADOW * without
}

fn trunks(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let (mut figures, mut holds) = (Vec::new(), Vec::new());
    for scene in TRUNKS {
        let still = slanted(scene, "slanted")?;
        for (name, method) in methods(&still)? {
            let fragments = still.fragments(&method)?;
            let hidden = behind(&still, &fragments);
            let bare = Fragments {
                opaque: vec![NO_OPAQUE; fragments.texels()],
                ..Fragments::clone(&fragments)
            };
            let weighted = weighing(method.clone(), 3.0);
            let mut maps = Maps::new(bare.width, bare.height, &weighted.settings)?;
            maps.build(&bare)?;
            let all = || hidden.iter().map(|(i, _)| *i);
            let without = mean(&still.shade(&maps)?, all())?;
            let with = mean(&still.shade(&still.maps(&weighted)?)?, all())?;
            let apart = mean(&still.shade(&still.maps(&method)?)?, all())?;
            let what = format!("{scene}, {name}: light behind trunks");
            figures.push(figure(format!("{what}, not in the maps"), without, ""));
            figures.push(figure(format!("{what}, thickness 3"), with, ""));
            figures.push(figure(format!("{what}, a depth map of their own"), apart, ""));
            holds.push(casts(with, without));
        }
    }
    let because = format!("trunks cast shadows in {} cases", count(&holds));
    Ok(judged(vote(&holds), because, figures))
}

fn leak(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let (mut figures, mut cases) = (Vec::new(), Vec::new());
    for scene in TRUNKS {
        let still = slanted(scene, "slanted")?;
        for (name, method) in methods(&still)? {
            let hidden = behind(&still, &*still.fragments(&method)?);
            let of = |leaves: bool| hidden.iter().filter(move |h| h.1 == leaves).map(|h| h.0);
            let receivers = of(false).count();
            figures.push(figure(format!("{scene}, {name}: receivers"), receivers as f64, ""));
            if receivers == 0 {
                continue;
            }
            for weight in [1.0_f32, 3.0, 10.0] {
                let expected = f64::from(-weight).exp();
                for (how, lookup) in [("own sum", Lookup::Nearest), ("interpolated", Lookup::Lerp)]
                {
                    let method = weighing(method.clone(), weight).lookup(lookup);
                    let light = still.shade(&still.maps(&method)?)?;
                    let what = format!("{scene}, {name}, thickness {weight}, {how}");
                    let bare = mean(&light, of(false))?;
                    figures.push(figure(format!("{what}: light over e^-w"), bare / expected, ""));
                    if lookup == Lookup::Nearest {
                        cases.push((bare / expected, 1.0, 0.01));
                    }
                }
            }
        }
    }
    let worst = cases.iter().map(|c| (c.0 - 1.0).abs()).fold(0.0, f64::max);
    let because = format!("light behind the trunk is at most {worst:.3} of e^-w off it");
    Ok(judged(near(&cases), because, figures))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::claims::Verdict;

    #[test]
    fn flat_is_less_than_half_the_contrast() {
        assert_eq!(contrast(&[1.0, 1.0]), 0.0);
        assert!((contrast(&[0.5, 1.5]) - 0.5).abs() < 1e-12);
        assert!(is_flat(0.1, 0.3) && !is_flat(0.2, 0.3) && !is_flat(0.0, 0.0));
    }

    #[test]
    fn a_shadow_halves_the_light() {
        assert!(casts(0.05, 0.4) && !casts(0.3, 0.4) && !casts(f64::NAN, 0.4));
        assert_eq!(vote(&[casts(0.05, 0.4), casts(0.3, 0.4)]), Verdict::Open);
        assert!(mean(&[0.5], [].into_iter()).is_err());
        assert_eq!(mean(&[0.5, 1.0, 0.0], [0, 1].into_iter()).unwrap(), 0.75);
    }

    #[test]
    fn leaks_are_held_to_a_hundredth() {
        assert_eq!(near(&[(1.005, 1.0, 0.01)]), Verdict::Reproduced);
        assert_eq!(near(&[(1.05, 1.0, 0.01)]), Verdict::Refuted);
    }
}
