//! Seeded random input of the gates: fragments of whole maps, receivers, settings of a technique.

pub use crate::verify::rng;

use super::super::{SPEC, settings};
use crate::{
    SuiteError,
    knob::{self, Knob, Knobs, Range},
    problem::{Form, Setting},
};
use dapple_opacity_maps::{
    Bins, Blend, Blur, Code, EndMap, Format, Fragment, Fragments, Layered, Layout, Lookup,
    NO_OPAQUE, Opaque, Packing, Receiver, Settings, Slicing, Split, SplitKind, Storage, Taps,
    code::TexelCode, cpu::Maps,
};
use rand::RngExt;
use rand_pcg::Pcg64;

/// Most fragments of a texel.
const MOST: usize = 24;

/// Draws of settings, some of which do not go together.
const DRAWS: u32 = 1000;

/// A map of texels given by (depth, thickness), without opaque surfaces.
pub fn map(width: u32, texels: &[Vec<(f32, f32)>]) -> Fragments {
    let mut map = Fragments {
        width,
        height: texels.len() as u32 / width.max(1),
        starts: vec![0],
        items: Vec::new(),
        opaque: vec![NO_OPAQUE; texels.len()],
    };
    for texel in texels {
        map.items.extend(texel.iter().map(|&(depth, omega)| Fragment { depth, omega }));
        map.starts.push(map.items.len() as u32);
    }
    map
}

/// One texel: none, one, all at one depth, in few depths, evenly, clustered at either end. Depths
/// are multiples of 2^-16, so that halves and shifts by such are exact.
pub fn texel(rng: &mut Pcg64) -> Vec<(f32, f32)> {
    let count = match rng.random_range(0..8) {
        0 => 0,
        1 => 1,
        _ => rng.random_range(2..=MOST),
    };
    let (near, span) = (rng.random_range(0.0..0.6), rng.random_range(0.05..0.4));
    let kind = rng.random_range(0..10);
    (0..count)
        .map(|i| {
            let t = match kind {
                0 => 0.0,
                1 => f64::from(rng.random_range(0..4_u8)) / 3.0,
                2 => i as f64 / count as f64,
                3 => rng.random_range(0.0..1.0_f64).powi(3),
                4 => 1.0 - rng.random_range(0.0..1.0_f64).powi(3),
                _ => rng.random_range(0.0..1.0),
            };
            (dyadic(near + span * t), rng.random_range(0.0..1.2_f32))
        })
        .collect()
}

/// The nearest multiple of 2^-16.
pub fn dyadic(depth: f64) -> f32 {
    ((depth * 65_536.0).round() / 65_536.0) as f32
}

/// A small map of such texels, in the order drawn.
pub fn fragments(rng: &mut Pcg64) -> Fragments {
    let (width, height) = (rng.random_range(1..5_u32), rng.random_range(2..5_u32));
    let texels: Vec<_> = (0..width * height).map(|_| texel(rng)).collect();
    map(width, &texels)
}

/// The same with an opaque surface behind the translucent ones of every third texel or so.
pub fn with_opaque(rng: &mut Pcg64, mut fragments: Fragments) -> Fragments {
    for texel in 0..fragments.texels() {
        if rng.random_range(0..3) == 0 {
            let last = fragments.texel(texel).iter().map(|f| f.depth).fold(0.3, f32::max);
            fragments.opaque[texel] = last + rng.random_range(0.01..0.1_f32);
        }
    }
    fragments
}

/// The same fragments drawn in another order.
pub fn shuffled(rng: &mut Pcg64, fragments: &Fragments) -> Fragments {
    let mut out = fragments.clone();
    for texel in 0..out.texels() {
        let (from, to) = (out.starts[texel] as usize, out.starts[texel + 1] as usize);
        for i in (from + 1..to).rev() {
            out.items.swap(i, rng.random_range(from..=i));
        }
    }
    out
}

/// Each texel's fragments changed one by one; the texels stay as they are.
pub fn mapped(fragments: &Fragments, change: impl Fn(Fragment) -> Fragment) -> Fragments {
    let items = fragments.items.iter().map(|f| change(*f)).collect();
    Fragments { items, ..fragments.clone() }
}

/// A deliberate fault for any map: the fragment drawn last is lost.
pub fn without_last(fragments: &Fragments) -> Fragments {
    let of = |texel: usize| {
        let all = fragments.texel(texel);
        let kept = &all[..all.len().saturating_sub(1)];
        kept.iter().map(|f| (f.depth, f.omega)).collect()
    };
    let texels: Vec<Vec<_>> = (0..fragments.texels()).map(of).collect();
    Fragments { opaque: fragments.opaque.clone(), ..map(fragments.width, &texels) }
}

/// Receivers inside the map, in front of, among and behind its fragments, slightly sloped.
pub fn receivers(rng: &mut Pcg64, count: usize) -> Vec<Receiver> {
    let mut any = |least: f32, most: f32| rng.random_range(least..most);
    (0..count)
        .map(|_| Receiver {
            slope_u: any(-0.1, 0.1),
            slope_v: any(-0.1, 0.1),
            ..Receiver::at(any(0.0, 1.0), any(0.0, 1.0), any(-0.05, 1.05))
        })
        .collect()
}

/// Settings of a technique with random variant and knobs, drawn until they go together.
///
/// # Errors
/// An unknown technique; one whose knobs never do.
pub fn settings_of(rng: &mut Pcg64, technique: &str) -> Result<Settings, SuiteError> {
    settings_in(rng, technique, Form::Cpu)
}

/// The same of another form than the processor's.
///
/// # Errors
/// As [`settings_of`].
pub fn settings_in(rng: &mut Pcg64, technique: &str, form: Form) -> Result<Settings, SuiteError> {
    let technique = SPEC.technique(technique)?;
    let mut refusal = None;
    for _ in 0..DRAWS {
        let given: Knobs =
            technique.knobs.iter().map(|k| (k.name.to_string(), value(rng, k))).collect();
        let variant = technique.variants[rng.random_range(0..technique.variants.len())].id.into();
        let knobs = knob::complete("knob", technique.knobs, &given)?;
        let setting = Setting { technique: technique.id.into(), variant, form, knobs };
        match settings::settings(&setting, || Ok(0.5)) {
            Ok(settings) => return Ok(settings),
            Err(error) => refusal = Some(error),
        }
    }
    Err(refusal.unwrap_or_else(|| SuiteError::Usage("no settings were drawn".into())))
}

/// A value of a knob: the default one time in three, else anything useful.
fn value(rng: &mut Pcg64, knob: &Knob) -> serde_json::Value {
    let [min, max] = match knob.range {
        Range::Choice(words) => return words[rng.random_range(0..words.len())].into(),
        _ if rng.random_range(0..3) == 0 => return knob.default_value(),
        Range::Int { min, max, .. } => knob.useful.unwrap_or([min as f64, max as f64]),
        Range::Float { min, max, .. } => knob.useful.unwrap_or([min, max]),
    };
    let share: f64 = rng.random_range(0.0..=1.0);
    let value = if knob.logarithmic && min > 0.0 {
        min * (max / min).powf(share)
    } else {
        min + (max - min) * share
    };
    match knob.range {
        Range::Int { .. } => (value.round() as i64).into(),
        _ => value.clamp(min, max).into(),
    }
}

/// The same settings with channels that are independent and printed masks repaired: what the
/// properties of layers are promised for.
pub fn sound(mut settings: Settings) -> Settings {
    if let Code::Layered(layered) = &mut settings.code {
        if layered.blend != Blend::Over {
            layered.blend = Blend::Add;
        }
        if let Layout::Deep { listing, .. } = &mut layered.layout {
            *listing = false;
        }
    }
    settings
}

/// Settings of layers: 32-bit floats, sorted, linear lookup, one tap, no bias.
pub fn layered(layout: Layout, layers: u32) -> Layered {
    Layered {
        layout,
        layers,
        lookup: Lookup::Lerp,
        write_bias: 0.0,
        soft_start: false,
        blend: Blend::Add,
        format: Format::F32,
        packing: Packing::Sorted,
        storage: Storage::Blend,
        end_map: EndMap::MaxBlend,
    }
}

/// A code without a bias, read at one texel.
pub fn plain(code: Code) -> Settings {
    Settings {
        code,
        taps: Taps::One,
        blur: Blur::Transmittance,
        bias: 0.0,
        opaque: Opaque::Separate,
    }
}

/// Layers of the technique of this id with random places and numbers.
pub fn layers_of(rng: &mut Pcg64, technique: &str) -> Layered {
    let layers = [1, 2, 3, 4, 5, 8, 16, 32, 33][rng.random_range(0..9_usize)];
    layered(layout_of(rng, technique), layers)
}

/// A random layout of the technique of this id; of bounding opacity maps for any other.
pub fn layout_of(rng: &mut Pcg64, technique: &str) -> Layout {
    match technique {
        "osm" => Layout::Planes(
            [Slicing::Uniform, Slicing::Density, Slicing::Growing][rng.random_range(0..3_usize)],
        ),
        "dom" => Layout::Deep {
            span: rng.random_range(0.05..1.0),
            growth: [1.0, 1.0, 1.3, 2.0][rng.random_range(0..4_usize)],
            listing: false,
        },
        _ => {
            let kind = SPLITS[rng.random_range(0..SPLITS.len())];
            let lambda = [0.0, 1.0, rng.random_range(0.0..1.0)][rng.random_range(0..3_usize)];
            Layout::Bounded { split: Split { lambda, kind, width: 512 }, bins: Bins::Full }
        }
    }
}

/// All kinds of split.
pub const SPLITS: [SplitKind; 5] = [
    SplitKind::Normalised,
    SplitKind::Listing,
    SplitKind::Table8,
    SplitKind::Table32,
    SplitKind::Positions,
];

/// Bounding opacity maps of a normalised split.
pub fn bounded(lambda: f32) -> Layout {
    let split = Split { lambda, kind: SplitKind::Normalised, width: 512 };
    Layout::Bounded { split, bins: Bins::Full }
}

/// Deep opacity maps of even layers.
pub fn deep(span: f32) -> Layout {
    Layout::Deep { span, growth: 1.0, listing: false }
}

/// Maps of fragments.
///
/// # Errors
/// Settings that are refused.
pub fn build(settings: &Settings, fragments: &Fragments) -> Result<Maps, SuiteError> {
    let mut maps = Maps::new(fragments.width, fragments.height, settings)?;
    maps.build(fragments)?;
    Ok(maps)
}

/// The same by a code at hand.
///
/// # Errors
/// As [`build`].
pub fn build_with(
    settings: &Settings,
    fragments: &Fragments,
    code: Box<dyn TexelCode>,
) -> Result<Maps, SuiteError> {
    let mut maps = Maps::with_code(fragments.width, fragments.height, settings, code)?;
    maps.build(fragments)?;
    Ok(maps)
}

/// Transmittance of a texel just before a depth.
pub fn at(maps: &Maps, texel: usize, depth: f32) -> f64 {
    f64::from(maps.code().decode(texel, maps.texel(texel), depth))
}

/// A texel's cumulative sums, without its bounds.
pub fn sums<'a>(maps: &'a Maps, layered: &Layered, texel: usize) -> &'a [f32] {
    let words = maps.texel(texel);
    &words[words.len() - layered.layers as usize..]
}

/// Thickness of all of a texel's fragments.
pub fn total(fragments: &Fragments, texel: usize) -> f64 {
    prefix(fragments, texel, |_| true)
}

/// Thickness of those whose depth is `inside`.
pub fn prefix(fragments: &Fragments, texel: usize, inside: impl Fn(f32) -> bool) -> f64 {
    let those = fragments.texel(texel).iter().filter(|f| inside(f.depth));
    those.map(|f| f64::from(f.omega)).sum()
}
