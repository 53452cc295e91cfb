//! Maps of random fragments, and settings to try on them.

use dapple_opacity_maps::{
    Bins, Blend, Blur, Code, EndMap, Format, Fragment, Fragments, Layered, Layout, Lookup,
    NO_OPAQUE, OpacityError, Opaque, Packing, Receiver, Settings, Slicing, Split, SplitKind,
    Storage, Taps, code::TexelCode, cpu::Maps,
};
use rand::{Rng, RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

pub fn generator(seed: u64) -> Pcg64Mcg {
    Pcg64Mcg::seed_from_u64(seed)
}

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

/// Settings without a bias.
pub fn settings(layered: Layered) -> Settings {
    Settings {
        code: Code::Layered(layered),
        taps: Taps::One,
        blur: Blur::Transmittance,
        bias: 0.0,
        opaque: Opaque::Separate,
    }
}

pub fn bounded(lambda: f32) -> Layout {
    let split = Split { lambda, kind: SplitKind::Normalised, width: 512 };
    Layout::Bounded { split, bins: Bins::Full }
}

pub fn deep(span: f32) -> Layout {
    Layout::Deep { span, growth: 1.0, listing: false }
}

pub fn even() -> Layout {
    Layout::Planes(Slicing::Uniform)
}

/// Every layout and every way to split.
pub fn layouts() -> Vec<Layout> {
    let kinds = [
        SplitKind::Normalised,
        SplitKind::Listing,
        SplitKind::Table8,
        SplitKind::Table32,
        SplitKind::Positions,
    ];
    let split =
        |kind| Layout::Bounded { split: Split { lambda: 0.6, kind, width: 512 }, bins: Bins::Full };
    let thesis = Layout::Bounded {
        split: Split { lambda: 1.0, kind: SplitKind::Listing, width: 512 },
        bins: Bins::Thesis,
    };
    let mut all = vec![
        even(),
        Layout::Planes(Slicing::Density),
        Layout::Planes(Slicing::Growing),
        deep(0.4),
        Layout::Deep { span: 0.7, growth: 1.5, listing: false },
        bounded(0.0),
        bounded(1.0),
        thesis,
    ];
    all.extend(kinds.map(split));
    all
}

/// A map of texels given as (depth, thickness).
pub fn map(width: u32, texels: &[Vec<(f32, f32)>]) -> Fragments {
    let mut fragments = Fragments {
        width,
        height: texels.len() as u32 / width,
        starts: vec![0],
        items: Vec::new(),
        opaque: vec![NO_OPAQUE; texels.len()],
    };
    for texel in texels {
        fragments.items.extend(texel.iter().map(|&(depth, omega)| Fragment { depth, omega }));
        fragments.starts.push(fragments.items.len() as u32);
    }
    fragments
}

/// Random texels: some empty, some of one fragment, some of one depth, some clustered; depths are
/// multiples of 2^-16 so that shifts and halvings are exact.
pub fn random(seed: u64, width: u32, height: u32, most: usize) -> Fragments {
    let mut rng = generator(seed);
    let dyadic = |x: f64| ((x * 65_536.0).round() / 65_536.0) as f32;
    let mut texel = || {
        let count = match rng.random_range(0..8) {
            0 => 0,
            1 => 1,
            _ => rng.random_range(2..=most.max(2)),
        };
        let (from, depth) = (rng.random_range(0.0..0.6), rng.random_range(0.0..0.4));
        let flat = rng.random_range(0..10) == 0;
        let one = |_| {
            let share: f64 = if flat { 0.0 } else { rng.random() };
            (dyadic(from + depth * share), rng.random_range(0.0..1.2f64) as f32)
        };
        (0..count).map(one).collect::<Vec<_>>()
    };
    let texels: Vec<Vec<(f32, f32)>> = (0..width * height).map(|_| texel()).collect();
    map(width, &texels)
}

/// The same with an opaque surface in every third texel or so, behind the translucent ones.
pub fn with_opaque(mut fragments: Fragments, seed: u64) -> Fragments {
    let mut rng = generator(seed);
    for texel in 0..fragments.texels() {
        if rng.random_range(0..3) == 0 {
            let last = fragments.texel(texel).iter().map(|f| f.depth).fold(0.3, f32::max);
            fragments.opaque[texel] = last + rng.random_range(0.01..0.1f32);
        }
    }
    fragments
}

/// The same fragments in another order within their texels.
pub fn shuffled(fragments: &Fragments, seed: u64) -> Fragments {
    let mut rng = generator(seed);
    let mut out = fragments.clone();
    for texel in 0..out.texels() {
        let (from, to) = (out.starts[texel] as usize, out.starts[texel + 1] as usize);
        for i in (from + 1..to).rev() {
            out.items.swap(i, rng.random_range(from..=i));
        }
    }
    out
}

pub fn receivers(seed: u64, count: usize) -> Vec<Receiver> {
    let mut rng = generator(seed);
    let mut any = || rng.random_range(0.0..1.0f64) as f32;
    (0..count).map(|_| Receiver::at(any(), any(), any())).collect()
}

pub fn build(settings: &Settings, fragments: &Fragments) -> Maps {
    let mut maps = Maps::new(fragments.width, fragments.height, settings).unwrap();
    maps.build(fragments).unwrap();
    maps
}

pub fn build_with(
    settings: &Settings,
    fragments: &Fragments,
    code: Box<dyn TexelCode>,
) -> Result<Maps, OpacityError> {
    let mut maps = Maps::with_code(fragments.width, fragments.height, settings, code)?;
    maps.build(fragments)?;
    Ok(maps)
}

/// A texel's sums, without its bounds.
pub fn sums(maps: &Maps, layered: &Layered, texel: usize) -> Vec<f32> {
    let words = maps.texel(texel);
    words[words.len() - layered.layers as usize..].to_vec()
}

/// Total thickness of a texel.
pub fn total(fragments: &Fragments, texel: usize) -> f64 {
    fragments.texel(texel).iter().map(|f| f64::from(f.omega)).sum()
}

/// Thickness strictly in front of `depth`, and the same with what lies at it.
pub fn prefix(fragments: &Fragments, texel: usize, depth: f32) -> (f64, f64) {
    let sum = |inside: &dyn Fn(f32) -> bool| {
        let those = fragments.texel(texel).iter().filter(|f| inside(f.depth));
        those.map(|f| f64::from(f.omega)).sum::<f64>()
    };
    (sum(&|d| d < depth), sum(&|d| d <= depth))
}

/// A number that any generator gives, for tests that draw their own.
pub fn unit(rng: &mut impl Rng) -> f32 {
    rng.random_range(0.0..1.0f64) as f32
}

/// A fixed input on which faults show.
pub fn rich() -> Fragments {
    random(77, 6, 6, 40)
}
