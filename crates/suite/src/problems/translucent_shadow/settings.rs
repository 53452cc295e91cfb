//! From a technique's knobs to the maps' settings.

use crate::{
    SuiteError,
    knob::{Get, Knobs, choice},
    problem::{Form, Setting},
};
use dapple_opacity_maps::{
    Adaptive, Bins, Blend, Blur, Code, Deep, EndMap, Format, Fourier, Layered, Layout, Lookup,
    Model, Moments, Opaque, Order, Packing, Settings, Slicing, Split, SplitKind, Stochastic,
    Storage, Taps,
};

/// Longest side of a map, texels.
pub const MOST_SIDE: u32 = 8192;

/// Width of the split function's table: the thesis's.
pub const TABLE_WIDTH: u32 = 512;

/// Side of the map that a setting asks for, texels.
///
/// # Errors
/// [`SuiteError::Value`] for a side of 0 or past [`MOST_SIDE`].
pub fn resolution(setting: &Setting) -> Result<u32, SuiteError> {
    whole(&setting.knobs, "resolution", 1, MOST_SIDE)
}

/// Thickness model of a setting; techniques without the knob never ask.
///
/// # Errors
/// A word that is none.
pub fn model(setting: &Setting) -> Result<Model, SuiteError> {
    if !setting.knobs.contains_key("model") {
        return Ok(Model::ExpTau);
    }
    choice(&setting.knobs, "model", &[("tau", Model::ExpTau), ("alpha", Model::ExpAlpha)])
}

/// Whether the map covers casters and receivers alone.
///
/// # Errors
/// A word that is none.
pub fn crop(setting: &Setting) -> Result<bool, SuiteError> {
    if !setting.knobs.contains_key("crop") {
        return Ok(true);
    }
    choice(&setting.knobs, "crop", &[("on", true), ("off", false)])
}

/// The settings. `span` is asked for the depth of the deepest ray where a DOM's span is 0.
///
/// # Errors
/// An unknown technique or variant, or a knob that does not fit.
pub fn settings(
    setting: &Setting,
    span: impl FnOnce() -> Result<f32, SuiteError>,
) -> Result<Settings, SuiteError> {
    let knobs = &setting.knobs;
    let mut s = Settings::plain(code(setting, span)?);
    if s.code == Code::Unshadowed {
        // Nothing is stored, so nothing opaque hides either.
        s.opaque = Opaque::Weight { weight: 1.0, in_bounds: false };
    }
    if knobs.contains_key("taps") {
        let taps = [
            ("1", Taps::One),
            ("3x3", Taps::Box3),
            ("4x4", Taps::Box4),
            ("stochastic", Taps::Stochastic16),
        ];
        s.taps = choice(knobs, "taps", &taps)?;
    }
    if knobs.contains_key("blur") {
        let blurs = [("transmittance", Blur::Transmittance), ("stored", Blur::Stored)];
        s.blur = choice(knobs, "blur", &blurs)?;
    }
    if knobs.contains_key("bias") {
        s.bias = knobs.float("bias")? as f32;
    }
    if knobs.contains_key("opaque") {
        let weight = knobs.float("opaque_weight")? as f32;
        s.opaque = match knobs.word("opaque")? {
            "separate" => Opaque::Separate,
            "weight" => Opaque::Weight { weight, in_bounds: false },
            "weight-in-bounds" => Opaque::Weight { weight, in_bounds: true },
            other => {
                let known = ["separate", "weight", "weight-in-bounds"];
                return Err(SuiteError::unknown("opaque", other, known));
            }
        };
    }
    s.check()?;
    Ok(s)
}

fn code(
    setting: &Setting,
    span: impl FnOnce() -> Result<f32, SuiteError>,
) -> Result<Code, SuiteError> {
    let knobs = &setting.knobs;
    let variant = setting.variant.as_str();
    Ok(match setting.technique.as_str() {
        "unshadowed" => Code::Unshadowed,
        "shadow-map" => Code::Binary,
        "osm" => {
            let slicings = [
                ("uniform", Slicing::Uniform),
                ("density", Slicing::Density),
                ("growing", Slicing::Growing),
            ];
            let layout = Layout::Planes(choice(knobs, "slicing", &slicings)?);
            let mut layered = layered(setting, layout)?;
            layered.packing = match variant {
                "single" => Packing::Single,
                "slabs" => Packing::Slabs,
                "sorted" => Packing::Sorted,
                "targets" => Packing::Targets(8),
                _ => layered.packing,
            };
            Code::Layered(layered)
        }
        "dom" => {
            let asked = knobs.float("span")? as f32;
            let span = if asked == 0.0 { span()?.clamp(1e-6, 10.0) } else { asked };
            let growth = knobs.float("growth")? as f32;
            let listing = variant == "listing";
            Code::Layered(layered(setting, Layout::Deep { span, growth, listing })?)
        }
        "bom" => bounded(setting)?,
        "bom-search" => {
            let split = Split { lambda: 0.0, kind: SplitKind::Normalised, width: TABLE_WIDTH };
            Code::Layered(layered(setting, Layout::Bounded { split, bins: Bins::Full })?)
        }
        "fourier" => Code::Fourier(Fourier {
            pairs: whole(knobs, "pairs", 0, u32::MAX)?,
            bounded: knobs.word("bounds")? == "ray",
            format: format(knobs)?,
        }),
        "avsm" => Code::Adaptive(Adaptive {
            nodes: whole(knobs, "nodes", 0, u32::MAX)?,
            order: if variant == "sorted" { Order::Sorted } else { Order::Drawn },
        }),
        "moments" => Code::Moments(Moments {
            moments: if variant == "six" { 6 } else { 4 },
            bias: knobs.float("moment_bias")? as f32,
            overestimation: knobs.float("overestimation")? as f32,
            bounded: knobs.word("bounds")? == "ray",
            format: format(knobs)?,
        }),
        "stochastic" => {
            Code::Stochastic(Stochastic { samples: whole(knobs, "samples", 0, u32::MAX)?, seed: 0 })
        }
        "deep" => Code::Deep(Deep {
            tolerance: knobs.float("tolerance")? as f32,
            nodes: whole(knobs, "nodes", 0, u32::MAX)?,
        }),
        other => {
            let known = super::SPEC.techniques.iter().map(|t| t.id);
            return Err(SuiteError::unknown("technique", other, known));
        }
    })
}

fn bounded(setting: &Setting) -> Result<Code, SuiteError> {
    let knobs = &setting.knobs;
    let kinds = [
        ("normalised", SplitKind::Normalised),
        ("listing", SplitKind::Listing),
        ("table8", SplitKind::Table8),
        ("table32", SplitKind::Table32),
        ("positions", SplitKind::Positions),
    ];
    let ends = [
        ("max-blend", EndMap::MaxBlend),
        ("atomic", EndMap::Atomic),
        ("greater", EndMap::Greater),
        ("swapped", EndMap::Swapped),
        ("range-flip", EndMap::RangeFlip),
    ];
    let split = Split {
        lambda: knobs.float("lambda")? as f32,
        kind: choice(knobs, "split", &kinds)?,
        width: TABLE_WIDTH,
    };
    let thesis = setting.variant == "thesis";
    let bins = if thesis { Bins::Thesis } else { Bins::Full };
    let mut layered = layered(setting, Layout::Bounded { split, bins })?;
    layered.end_map = choice(knobs, "end_map", &ends)?;
    if thesis {
        layered.write_bias = knobs.float("bias")? as f32;
    }
    Ok(Code::Layered(layered))
}

/// A layered map's common knobs, packed as suits the form: a processor touches each fragment once,
/// a device blends into eight targets at once.
fn layered(setting: &Setting, layout: Layout) -> Result<Layered, SuiteError> {
    let knobs = &setting.knobs;
    let lookups =
        [("lerp", Lookup::Lerp), ("nearest", Lookup::Nearest), ("exclusive", Lookup::Exclusive)];
    let blends = [
        ("add", Blend::Add),
        ("over", Blend::Over),
        ("alpha", Blend::Alpha),
        ("premultiplied", Blend::Premultiplied),
    ];
    let blend = or_default(knobs, "blend", &blends)?;
    // Where channels depend on each other, what shares a texture decides the result.
    let apart = matches!(blend, Blend::Add | Blend::Over);
    let packing =
        if setting.form == Form::Gpu || !apart { Packing::Targets(8) } else { Packing::Sorted };
    let storages = [("blend", Storage::Blend), ("atomic", Storage::Atomic)];
    Ok(Layered {
        layout,
        layers: whole(knobs, "layers", 0, u32::MAX)?,
        lookup: choice(knobs, "lookup", &lookups)?,
        blend,
        format: format(knobs)?,
        packing,
        storage: or_default(knobs, "storage", &storages)?,
        end_map: EndMap::MaxBlend,
        write_bias: 0.0,
        soft_start: false,
    })
}

fn format(knobs: &Knobs) -> Result<Format, SuiteError> {
    let formats = [
        ("f32", Format::F32),
        ("f16", Format::F16),
        ("unorm8", Format::Unorm8),
        ("unorm8-scaled", Format::Unorm8Scaled),
        ("fixed", Format::Fixed),
    ];
    choice(knobs, "format", &formats)
}

/// The value of a knob that not every technique has: the first where it is absent.
fn or_default<T: Copy + Default>(
    knobs: &Knobs,
    name: &'static str,
    words: &[(&'static str, T)],
) -> Result<T, SuiteError> {
    if knobs.contains_key(name) { choice(knobs, name, words) } else { Ok(T::default()) }
}

/// A knob that is a whole number in `least..=most`. Extremes are set past a knob's own range.
///
/// # Errors
/// [`SuiteError::Value`].
pub fn whole(knobs: &Knobs, name: &str, least: u32, most: u32) -> Result<u32, SuiteError> {
    let value = knobs.int(name)?;
    let fits = u32::try_from(value).ok().filter(|v| (least..=most).contains(v));
    fits.ok_or_else(|| SuiteError::Value {
        what: "knob",
        name: name.into(),
        value: value.to_string(),
        limit: format!("must be an integer in {least}..={most}"),
    })
}
