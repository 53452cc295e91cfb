//! Rays, codes and faults that the tests share.

use dapple_opacity_maps::{
    Adaptive, Code, Deep, Format, Fourier, Fragment, Moments, Order, Settings, Stochastic,
    code::{self, TexelCode},
};
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// `n` cases unless PROPTEST_CASES says otherwise.
pub fn cases(n: u32) -> ProptestConfig {
    let asked = std::env::var("PROPTEST_CASES").ok().and_then(|n| n.parse().ok());
    let cases = asked.unwrap_or(n);
    ProptestConfig { cases, failure_persistence: None, ..ProptestConfig::default() }
}

/// A texel after encoding.
pub struct Texel {
    code: Box<dyn TexelCode>,
    pub words: Vec<f32>,
}

impl Texel {
    pub fn new(settings: &Settings, fragments: &[Fragment]) -> Self {
        settings.check().unwrap();
        Self::with_code(code::of(settings), 0, fragments, None)
    }

    pub fn with_code(
        code: Box<dyn TexelCode>,
        texel: usize,
        fragments: &[Fragment],
        opaque: Option<Fragment>,
    ) -> Self {
        // Words hold what an earlier frame left.
        let mut words = vec![f32::NAN; code.words()];
        code.encode(texel, fragments, opaque, &mut vec![Fragment::default(); 3], &mut words);
        Self { code, words }
    }

    /// What is stored, without room that is left.
    pub fn used(&self) -> &[f32] {
        &self.words[..self.code.used_bytes(&self.words) as usize / 4]
    }

    pub fn t(&self, depth: f32) -> f32 {
        self.code.decode(0, &self.words, depth)
    }
}

pub fn fourier(pairs: u32, bounded: bool, format: Format) -> Settings {
    Settings::plain(Code::Fourier(Fourier { pairs, bounded, format }))
}

pub fn moments(moments: u32, bounded: bool, format: Format) -> Settings {
    let (bias, overestimation) = (0.0, 0.75);
    Settings::plain(Code::Moments(Moments { moments, bias, overestimation, bounded, format }))
}

pub fn adaptive(nodes: u32, order: Order) -> Settings {
    Settings::plain(Code::Adaptive(Adaptive { nodes, order }))
}

pub fn stochastic(samples: u32, seed: u32) -> Settings {
    Settings::plain(Code::Stochastic(Stochastic { samples, seed }))
}

pub fn deep(tolerance: f32, nodes: u32) -> Settings {
    Settings::plain(Code::Deep(Deep { tolerance, nodes }))
}

/// Every code at settings from small to large.
pub fn all() -> Vec<Settings> {
    let mut all = vec![Settings::plain(Code::Binary)];
    for bounded in [false, true] {
        for format in [Format::F32, Format::F16] {
            all.extend([1, 3, 7, 15].map(|pairs| fourier(pairs, bounded, format)));
            all.extend([4, 6].map(|n| moments(n, bounded, format)));
        }
    }
    for order in [Order::Drawn, Order::Sorted] {
        all.extend([2, 8, 64].map(|nodes| adaptive(nodes, order)));
    }
    all.extend([1, 16, 64].map(|samples| stochastic(samples, 7)));
    all.extend([(0.0, 1024), (0.01, 64), (0.2, 2)].map(|(t, n)| deep(t, n)));
    all
}

/// Whether T is 1 up to and including the first fragment, and e^-Σω behind the last.
pub fn meets_both_ends(code: &Code) -> bool {
    match code {
        Code::Fourier(f) => f.bounded,
        Code::Moments(m) => m.bounded,
        _ => true,
    }
}

/// How far T behind everything may lie from e^-Σω.
pub fn end_bound(settings: &Settings, exact: f64, fragments: &[Fragment]) -> f64 {
    // One rounding an addition, relative to the sum so far.
    let additions = fragments.len() as f64 * total(fragments);
    let float = |format| match format {
        Format::F16 => exact * (additions / 2048.0).exp_m1() + 1e-6,
        _ => exact * (additions / 16_777_216.0).exp_m1() + 1e-6,
    };
    match &settings.code {
        Code::Fourier(f) => float(f.format),
        Code::Moments(m) => float(m.format),
        // See `random`.
        Code::Stochastic(_) => 1.0,
        Code::Deep(d) if d.nodes < 64 => 1.0,
        Code::Deep(d) => f64::from(d.tolerance) + 1e-6,
        _ => 1e-6,
    }
}

pub fn at(depth: f32, omega: f32) -> Fragment {
    Fragment { depth, omega }
}

/// Σω.
pub fn total(fragments: &[Fragment]) -> f64 {
    fragments.iter().map(|f| f64::from(f.omega)).sum()
}

/// First and last depth.
pub fn ends(fragments: &[Fragment]) -> (f32, f32) {
    let depths = fragments.iter().map(|f| f.depth);
    (depths.clone().fold(f32::MAX, f32::min), depths.fold(f32::MIN, f32::max))
}

/// Depths that tell codes apart: between, at and just beside fragments, and all over the range.
pub fn probes(fragments: &[Fragment]) -> Vec<f32> {
    let mut probes: Vec<f32> = (0..=64).map(|i| i as f32 / 64.0).collect();
    for f in fragments.iter().take(100) {
        probes.extend([f.depth, f.depth.next_down(), f.depth.next_up(), f.depth + 1e-3]);
    }
    probes.extend([-0.1, 1.1]);
    probes.retain(|d| d.is_finite());
    probes.sort_by(f32::total_cmp);
    probes
}

/// Rays: any, of few depths, of one depth, bunched.
pub fn rays() -> impl Strategy<Value = Vec<Fragment>> {
    let omega = prop_oneof![4 => 0.0..1.5f32, 1 => Just(0.0f32), 1 => 1.0..20.0f32];
    let omegas = prop::collection::vec(omega, 1..60);
    let depth = prop_oneof![
        prop::collection::vec(0.0..=1.0f32, 60),
        (prop::collection::vec(0.0..=1.0f32, 3), prop::collection::vec(0usize..3, 60))
            .prop_map(|(few, picks)| picks.into_iter().map(|i| few[i]).collect()),
        (0.0..=1.0f32).prop_map(|one| vec![one; 60]),
        (0.1..0.8f32, prop::collection::vec(0.0..0.01f32, 60))
            .prop_map(|(start, near)| near.into_iter().map(|d| start + d).collect()),
    ];
    (depth, omegas).prop_map(|(depths, omegas)| {
        depths.into_iter().zip(omegas).map(|(depth, omega)| at(depth, omega)).collect()
    })
}

/// Hair: two tufts of strands of one opacity, in drawing order.
pub fn hair(seed: u64, strands: usize) -> Vec<Fragment> {
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let omega = 0.32;
    let near: f32 = random.random_range(0.1..0.3);
    let far: f32 = random.random_range(0.5..0.7);
    let strand = |i: usize| {
        let tuft = if i.is_multiple_of(3) { far } else { near };
        at(tuft + random.random_range(0.0..0.25f32), omega)
    };
    (0..strands).map(strand).collect()
}

/// A code that is read a little too deep.
pub struct Late(pub Box<dyn TexelCode>);

impl TexelCode for Late {
    fn words(&self) -> usize {
        self.0.words()
    }
    fn encode(
        &self,
        texel: usize,
        fragments: &[Fragment],
        opaque: Option<Fragment>,
        scratch: &mut Vec<Fragment>,
        words: &mut [f32],
    ) {
        self.0.encode(texel, fragments, opaque, scratch, words);
    }
    fn decode(&self, texel: usize, words: &[f32], depth: f32) -> f32 {
        self.0.decode(texel, words, depth + 0.05)
    }
    fn bytes_per_texel(&self) -> u64 {
        self.0.bytes_per_texel()
    }
    fn geometry_passes(&self) -> u64 {
        self.0.geometry_passes()
    }
}
