//! H4.7 to H4.9: what more targets, the search for a layer and the bits of depth cost.

use super::{
    dom_layers::THREE,
    osm_packing::timed,
    support::{dom, still},
    verdict::{GREY_LEVEL, all_of, figure, judged, paired},
};
use crate::{
    SuiteError,
    claims::{Claim, ClaimContext, Judged, Verdict},
};
use dapple_opacity_maps::{
    Code, Fragment, Opaque,
    code::TexelCode,
    cpu::Maps,
    layered::{
        LayeredCode,
        boundaries::{Boundaries, geometric},
        placement::{Bounds, Place, Placement},
    },
};
use std::time::Instant;

/// Frames a second of deep opacity maps in the source's table 6.2.1: 4 and 32 maps.
const TABLE: [(&str, f64, f64); 3] =
    [("Trees", 112.10, 43.90), ("Grass", 77.38, 29.45), ("Dense grass", 70.53, 27.28)];

pub fn claims() -> Vec<Claim> {
    vec![
        Claim {
            id: "voicu-H4.7",
            statement: "Performance stays the same as render targets are added, as the number of \
                        passes does",
            place: "Voicu 2011, section 4.1; table 6.2.1",
            method: "`the same`: within 10 % from 4 maps in one target to 32 in eight. The source's own \
                     table decides: refuted if in every scene 32 maps take more than 1.1 times as \
                     long as 4. Else our ratio on hardware does; ours are shown either way",
            judge: Box::new(targets),
        },
        Claim {
            id: "voicu-H4.8",
            statement: "Evenly split layers are found in constant time and without an array of splits",
            place: "Voicu 2011, section 4.2",
            method: "100,000 depths, 8 and 256 layers. The formula must give the layer that a search \
                     of the explicit splits gives, but for depths within rounding of a split (at most \
                     1 in 1000); constant: time for 256 layers over 8 within 25 % of 1 (paired runs; \
                     open if three median deviations exceed that). The search's ratio is shown",
            judge: Box::new(constant),
        },
        Claim {
            id: "voicu-H4.9",
            statement: "One 32-bit channel of depth is accurate enough for deep opacity maps",
            place: "Voicu 2011, section 4.2",
            method: "the first depth rounded down to 24 bits of 0..1, which a 32-bit float resolves \
                     everywhere in that range, against unrounded: 16 maps of grass, tree and hair, \
                     interpolated. Enough if no transmittance moves by a grey level (1/255). 16 and 8 \
                     bits are shown; 8 must move more, or nothing is decided",
            judge: Box::new(depth_bits),
        },
    ]
}

/// Times of 32 maps over 4: the source's, and ours on hardware.
fn unchanged(source: &[f64], ours: Option<f64>) -> Verdict {
    if !source.is_empty() && source.iter().all(|ratio| *ratio > 1.1) {
        return Verdict::Refuted;
    }
    match ours {
        None => Verdict::NeedsHardware,
        Some(ratio) if (ratio - 1.0).abs() <= 0.1 => Verdict::Reproduced,
        Some(_) => Verdict::Refuted,
    }
}

fn targets(context: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let (mut figures, mut source) = (Vec::new(), Vec::new());
    for (scene, four, thirty_two) in TABLE {
        let ratio = four / thirty_two;
        figures.push(figure(format!("table 6.2.1, {scene}: time, 32 maps over 4"), ratio, ""));
        source.push(ratio);
    }
    let still = still("grass")?;
    let span = still.deepest()?;
    let (many, few) = (dom(32, span), dom(4, span));
    let ours = timed(context, &still, "32 maps over 4", (&many, &few), &mut figures)?;
    let least = source.iter().copied().fold(f64::INFINITY, f64::min);
    let because = format!(
        "in the source's own table 32 maps take at least {least:.2} times as long as 4{}",
        ours.map_or(String::new(), |(ratio, _)| format!(", here {ratio:.2} times"))
    );
    Ok(judged(unchanged(&source, ours.map(|o| o.0)), because, figures))
}

/// Share of depths in another layer; time for 256 layers over 8, with its deviation.
fn in_constant_time(other: f64, ratio: f64, mad: f64) -> Verdict {
    if other > 1e-3 {
        return Verdict::Refuted;
    }
    match (ratio - 1.0).abs() <= 0.25 {
        _ if 3.0 * mad > 0.25 => Verdict::Open,
        true => Verdict::Reproduced,
        false => Verdict::Refuted,
    }
}

/// Sum of the layers of all depths, so that none is optimised away, and the nanoseconds it took.
fn find(placement: &Placement, layers: usize, depths: &[f32]) -> (u64, f64) {
    let bounds = Bounds { first: 0.125, last: f32::INFINITY };
    let start = Instant::now();
    let layer = |depth: &f32| match placement.place(bounds, layers, *depth) {
        Place::At(c) => c as u64,
        Place::Before => 0,
        Place::Behind => layers as u64,
    };
    let sum = depths.iter().map(layer).sum();
    (std::hint::black_box(sum), start.elapsed().as_nanos() as f64)
}

fn constant(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    const SPAN: f32 = 0.5;
    // Even steps of the golden ratio: spread over the range, in no order.
    let depth = |i: u32| 0.125 + SPAN * (f64::from(i) * 0.618_033_988_749_894_9).fract() as f32;
    let depths: Vec<f32> = (0..100_000).map(depth).collect();
    let even = Placement::Deep { span: SPAN, uneven: None };
    let searched = |layers: usize| Placement::Deep {
        span: SPAN,
        uneven: Some(Boundaries(geometric(0.0, f64::from(SPAN), layers, 1.0))),
    };
    let bounds = Bounds { first: 0.125, last: f32::INFINITY };
    let mut other = 0.0_f64;
    for layers in [8, 256] {
        let slow = searched(layers);
        let layer = |placement: &Placement, depth| match placement.place(bounds, layers, depth) {
            Place::At(c) => c as usize,
            Place::Before | Place::Behind => usize::MAX,
        };
        let differ = depths.iter().filter(|d| layer(&even, **d) != layer(&slow, **d)).count();
        other = other.max(differ as f64 / depths.len() as f64);
    }
    let ns = |placement: &Placement, layers| Ok(find(placement, layers, &depths).1);
    let formula = paired(101, || ns(&even, 256), || ns(&even, 8))?;
    let (many, few) = (searched(256), searched(8));
    let search = paired(101, || ns(&many, 256), || ns(&few, 8))?;
    let figures = vec![
        figure("share of depths in another layer than a search finds", other, ""),
        figure("time, formula, 256 layers over 8", formula.median, ""),
        figure("the same, median absolute deviation", formula.mad, ""),
        figure("time, search of an array, 256 layers over 8", search.median, ""),
        figure("bytes of the array, 256 layers", 4.0 * 257.0, ""),
    ];
    let because = format!(
        "the formula takes {:.2} times as long for 32 times the layers, a search {:.2} times",
        formula.median, search.median
    );
    Ok(judged(in_constant_time(other, formula.median, formula.mad), because, figures))
}

/// Greatest change of transmittance with 24 and 8 bits of depth.
fn enough(fine: f64, coarse: f64) -> Verdict {
    match (fine < GREY_LEVEL, coarse >= GREY_LEVEL) {
        (false, _) => Verdict::Refuted,
        (true, true) => Verdict::Reproduced,
        (true, false) => Verdict::Open,
    }
}

/// Deep opacity maps whose first depth is stored in a few bits, and drawn from as stored.
struct Rounded {
    code: LayeredCode,
    steps: f32,
}

impl TexelCode for Rounded {
    fn words(&self) -> usize {
        self.code.words()
    }

    fn encode(
        &self,
        _: usize,
        fragments: &[Fragment],
        opaque: Option<Fragment>,
        scratch: &mut Vec<Fragment>,
        words: &mut [f32],
    ) {
        let own = self.code.bounds(fragments, opaque);
        let bounds = Bounds { first: (own.first * self.steps).floor() / self.steps, ..own };
        self.code.placement.write(bounds, words);
        self.code.draw(bounds, fragments, opaque, scratch, words);
    }

    fn decode(&self, texel: usize, words: &[f32], depth: f32) -> f32 {
        self.code.decode(texel, words, depth)
    }

    fn bytes_per_texel(&self) -> u64 {
        self.code.bytes_per_texel()
    }

    fn geometry_passes(&self) -> u64 {
        self.code.geometry_passes()
    }
}

fn depth_bits(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let (mut figures, mut most) = (Vec::new(), [0.0_f64; 3]);
    for scene in THREE {
        let still = still(scene)?;
        let method = dom(16, still.deepest()?);
        let plain = still.shade(&still.maps(&method)?)?;
        let fragments = still.fragments(&method)?;
        for (slot, bits) in most.iter_mut().zip([24, 16, 8]) {
            let Code::Layered(layered) = &method.settings.code else { continue };
            let steps = 2f32.powi(bits);
            let code = Rounded { code: LayeredCode::new(layered, Opaque::Separate), steps };
            let side = method.resolution;
            let mut maps = Maps::with_code(side, side, &method.settings, Box::new(code))?;
            maps.build(&fragments)?;
            let moved = dapple_metrics::max_abs(&still.shade(&maps)?, &plain, None)?;
            figures.push(figure(format!("{scene}: greatest change, {bits} bits"), moved, ""));
            *slot = slot.max(moved);
        }
    }
    let [fine, middle, coarse] = most;
    let because = format!(
        "transmittance moves by up to {fine:.1e} with 24 bits, {middle:.1e} with 16, {coarse:.2} \
         with 8"
    );
    Ok(judged(all_of(&[enough(fine, coarse)]), because, figures))
}

#[cfg(test)]
mod tests {
    use super::*;
    use Verdict::{NeedsHardware, Open, Refuted, Reproduced};

    #[test]
    fn the_sources_table_outweighs_ours() {
        assert_eq!(unchanged(&[2.5, 2.6, 2.6], Some(1.0)), Refuted);
        assert_eq!(unchanged(&[1.0, 1.05], None), NeedsHardware);
        assert_eq!(unchanged(&[1.0, 1.05], Some(1.05)), Reproduced);
        assert_eq!(unchanged(&[1.0, 2.0], Some(2.0)), Refuted);
    }

    #[test]
    fn constant_is_a_quarter_and_the_layers_must_be_right() {
        assert_eq!(in_constant_time(0.0, 1.1, 0.01), Reproduced);
        assert_eq!(in_constant_time(0.0, 2.0, 0.01), Refuted);
        assert_eq!(in_constant_time(0.0, 1.1, 0.2), Open);
        assert_eq!(in_constant_time(0.1, 1.0, 0.01), Refuted);
    }

    #[test]
    fn few_bits_must_show_before_many_are_enough() {
        assert_eq!(enough(1e-5, 0.1), Reproduced);
        assert_eq!(enough(0.1, 0.2), Refuted);
        assert_eq!(enough(1e-5, 1e-4), Open);
    }
}
