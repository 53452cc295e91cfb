//! From a technique's knobs to the filter's settings.

use crate::{
    SuiteError,
    knob::{Get, Knobs},
    problem::Setting,
};
use dapple_shadows::filtering::{
    EsmSpace, Estimator, EvsmComponents, Format, KernelShape, Lookup, Settings, Splits, VsmVariant,
    settings::MAX_WIDTH_TEXELS,
};

/// Longest side of a map, texels: the common limit of graphics adapters.
pub const MOST_SIDE: u32 = 16384;

/// Side of the map that a setting asks for, texels.
///
/// # Errors
/// [`SuiteError::Value`] for a side of 0 or past [`MOST_SIDE`]; [`SuiteError::Internal`] where the
/// knobs were not completed.
pub fn resolution(setting: &Setting) -> Result<u32, SuiteError> {
    whole(&setting.knobs, "resolution", 1, MOST_SIDE)
}

/// A knob that is a whole number in `least..=most`. Extremes are set past a knob's own range.
fn whole(knobs: &Knobs, name: &str, least: u32, most: u32) -> Result<u32, SuiteError> {
    let value = knobs.int(name)?;
    let fits = u32::try_from(value).ok().filter(|v| (least..=most).contains(v));
    fits.ok_or_else(|| SuiteError::Value {
        what: "knob",
        name: name.into(),
        value: value.to_string(),
        limit: format!("must be an integer in {least}..={most}"),
    })
}

/// The odd number of texels nearest to `footprint * resolution`, at least 1; the larger of two
/// that are equally near.
pub fn kernel_texels(footprint: f64, resolution: u32) -> u32 {
    let texels = footprint * f64::from(resolution);
    2 * ((texels - 1.0) / 2.0).round().max(0.0) as u32 + 1
}

/// The filter's settings for a map of that resolution and a footprint as a share of its side.
///
/// # Errors
/// An unknown technique or variant, or a knob that does not fit (a layer count of 3, say).
pub fn settings(setting: &Setting, footprint: f64) -> Result<Settings, SuiteError> {
    let knobs = &setting.knobs;
    let mut s = Settings::new(estimator(setting)?).with_format(format(knobs.word("format")?)?);
    s.width_texels = kernel_texels(footprint, resolution(setting)?);
    s.bias = knobs.float("bias")? as f32;
    s.plane_bias = knobs.word("plane_bias")? == "on";
    s.lookup = if knobs.word("lookup")? == "nearest" { Lookup::Nearest } else { Lookup::Bilinear };
    if knobs.get("kernel").is_some_and(|k| k == "gaussian") {
        s.kernel = KernelShape::Gaussian;
    }
    if knobs.contains_key("bleed_reduction") {
        s.bleed_reduction = knobs.float("bleed_reduction")? as f32;
    }
    if knobs.contains_key("layers") {
        s.layers = whole(knobs, "layers", 0, u32::MAX)?;
    }
    // 0 stands for the format's own default, which is already there.
    let over = |name, field: &mut f32| -> Result<(), SuiteError> {
        if knobs.contains_key(name) && knobs.float(name)? != 0.0 {
            *field = knobs.float(name)? as f32;
        }
        Ok(())
    };
    over("min_variance", &mut s.min_variance)?;
    over("exponent", &mut s.exponent)?;
    over("moment_bias", &mut s.moment_bias)?;
    let side = resolution(setting)?;
    s.check(side, side)?;
    Ok(s)
}

fn format(word: &str) -> Result<Format, SuiteError> {
    match word {
        "f32" => Ok(Format::F32),
        "f16" => Ok(Format::F16),
        "u16" => Ok(Format::U16),
        other => Err(SuiteError::unknown("format", other, ["f32", "f16", "u16"])),
    }
}

fn taps(knobs: &Knobs) -> Result<u32, SuiteError> {
    whole(knobs, "taps", 0, MAX_WIDTH_TEXELS)
}

fn splits(variant: &str) -> Splits {
    if variant == "lloyd" { Splits::Lloyd } else { Splits::Uniform }
}

/// The estimator of a technique and variant.
fn estimator(setting: &Setting) -> Result<Estimator, SuiteError> {
    let variant = setting.variant.as_str();
    Ok(match setting.technique.as_str() {
        "hard" => Estimator::Hard,
        "pcf" => Estimator::Pcf { taps: taps(&setting.knobs)? },
        "vsm" => Estimator::Vsm {
            variant: match variant {
                "plain" => VsmVariant::Plain,
                "linstep" => VsmVariant::Linstep,
                "max" => VsmVariant::Max,
                _ => VsmVariant::MinVariance,
            },
        },
        "gaussian-cdf" => Estimator::GaussianCdf,
        "power-cdf" => Estimator::PowerCdf,
        "esm" => Estimator::Esm {
            space: if variant == "linear" { EsmSpace::Linear } else { EsmSpace::Log },
        },
        "lvsm" => Estimator::LayeredVsm { splits: splits(variant) },
        "layered-gaussian" => Estimator::LayeredGaussian { splits: splits(variant) },
        "layered-power" => Estimator::LayeredPower { splits: splits(variant) },
        "evsm" => Estimator::Evsm {
            components: if variant == "two" { EvsmComponents::Two } else { EvsmComponents::Four },
        },
        "msm" => Estimator::Msm,
        other => {
            let known = super::SPEC.techniques.iter().map(|t| t.id);
            return Err(SuiteError::unknown("technique", other, known));
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{knob, problem::Form, problems::shadow_filtering::SPEC};

    #[test]
    fn kernels_are_the_nearest_odd_widths() {
        for (footprint, resolution, texels) in [
            (0.015, 512, 7),   // 7.68
            (0.015, 256, 3),   // 3.84
            (0.015, 1024, 15), // 15.36
            (0.01, 1000, 11),  // 10: between 9 and 11
            (0.001, 16, 1),    // 0.016
            (0.5, 16, 9),      // 8
        ] {
            assert_eq!(kernel_texels(footprint, resolution), texels, "{footprint} {resolution}");
        }
    }

    #[test]
    fn every_variant_has_valid_defaults_and_its_own_estimator() {
        for technique in SPEC.techniques {
            let mut seen = Vec::new();
            for variant in technique.variants {
                let setting = Setting {
                    technique: technique.id.into(),
                    variant: variant.id.into(),
                    form: Form::Cpu,
                    knobs: knob::complete("knob", technique.knobs, &Knobs::new()).unwrap(),
                };
                let estimator = settings(&setting, 0.015).unwrap().estimator;
                assert!(!seen.contains(&estimator), "{}/{}", technique.id, variant.id);
                seen.push(estimator);
            }
        }
    }

    #[test]
    fn knobs_reach_the_filter_and_zero_is_the_formats_default() {
        let technique = SPEC.technique("evsm").unwrap();
        let make = |given: &[(&str, serde_json::Value)]| {
            let given = given.iter().map(|(n, v)| (n.to_string(), v.clone())).collect();
            let knobs = knob::complete("knob", technique.knobs, &given).unwrap();
            let variant = technique.variants[0].id.into();
            settings(&Setting { technique: "evsm".into(), variant, form: Form::Cpu, knobs }, 0.015)
        };
        assert_eq!(make(&[]).unwrap().exponent, 10.0);
        assert_eq!(make(&[("format", "f16".into())]).unwrap().exponent, 5.54);
        let s = make(&[
            ("exponent", 3.0.into()),
            ("min_variance", 0.5e-3.into()),
            ("kernel", "gaussian".into()),
            ("lookup", "nearest".into()),
            ("plane_bias", "off".into()),
            ("bias", 0.25e-1.into()),
            ("resolution", 1024.into()),
        ])
        .unwrap();
        assert_eq!((s.exponent, s.min_variance, s.bias), (3.0, 0.5e-3, 0.25e-1));
        assert_eq!((s.kernel, s.lookup), (KernelShape::Gaussian, Lookup::Nearest));
        assert_eq!((s.plane_bias, s.width_texels), (false, 15));
        let refused = make(&[("format", "f16".into()), ("exponent", 20.0.into())]).unwrap_err();
        assert_eq!(refused.exit_code(), 2);
        assert!(refused.to_string().contains("5.54"), "{refused}");
    }
}
