//! Bounds and bins of bounding opacity maps, and how they compare with other layers.

use super::{About, gate, input};
use crate::{
    SuiteError,
    verify::{Gate, GateContext, Tally},
};
use dapple_opacity_maps::{
    Bins, Code, Format, Fragment, Fragments, Layered, Layout, Lookup, Slicing, cpu::Maps,
};
use rand::RngExt;

pub fn gates() -> Vec<Gate> {
    let about = |technique, name, statement, fault| About { technique, name, statement, fault };
    vec![
        gate(
            about(
                "bom",
                "P10 bounds",
                "stored bounds are a texel's first and last fragment",
                "the next texel's bounds",
            ),
            bounds,
        ),
        gate(
            about(
                "bom",
                "row 27 bins",
                "every layer between the bounds holds its share of even fragments",
                "K - 1 bins: the last map holds the last fragment alone",
            ),
            bins,
        ),
        gate(
            about(
                "bom",
                "P8 meets osm and dom",
                "where all rays have the same bounds, planes, deep layers of that depth and \
                 bounded ones hold the same to the bit",
                "K - 1 bins",
            ),
            meet,
        ),
        gate(
            about(
                "bom",
                "P9 affine",
                "an affine change of all depths changes no layer",
                "layers of a fixed depth",
            ),
            affine,
        ),
        gate(
            about(
                "bom",
                "P9 reversed",
                "reversed light exchanges the bounds, and what lies in front of a boundary with \
                 what lies behind",
                "K - 1 bins",
            ),
            reversed,
        ),
    ]
}

/// Maps of layers without a bias.
pub fn build(layered: &Layered, fragments: &Fragments) -> Result<Maps, SuiteError> {
    input::build(&input::plain(Code::Layered(layered.clone())), fragments)
}

/// What each layer of a texel holds by itself.
pub fn layers_of(maps: &Maps, layered: &Layered, texel: usize) -> Vec<f64> {
    let mut before = 0.0;
    let one = |&sum: &f32| f64::from(sum - std::mem::replace(&mut before, sum));
    input::sums(maps, layered, texel).iter().map(one).collect()
}

fn bounds(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for case in 0..context.cases {
        let mut rng = input::rng(context.seed, "bounds", case);
        let fragments = input::fragments(&mut rng);
        let maps = build(&input::layers_of(&mut rng, "bom"), &fragments)?;
        for texel in 0..fragments.texels() {
            let words = maps.texel((texel + usize::from(faulty)) % fragments.texels());
            let depths = || fragments.texel(texel).iter().map(|f| f.depth);
            let ends = [depths().fold(1.0, f32::min), depths().fold(0.0, f32::max)];
            tally.check(words[..2] == ends, || format!("{:?} for {ends:?}", &words[..2]));
        }
    }
    Ok(tally)
}

/// Bounded layers without a split, in K bins or K - 1.
fn even(layers: u32, faulty: bool) -> Layered {
    let mut layout = input::bounded(0.0);
    if let Layout::Bounded { bins, .. } = &mut layout
        && faulty
    {
        *bins = Bins::Thesis;
    }
    input::layered(layout, layers)
}

fn bins(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for case in 0..context.cases {
        let mut rng = input::rng(context.seed, "bins", case);
        let (near, span) = (rng.random_range(0.0..0.5), rng.random_range(0.05..0.5));
        let depth = |i: i32| (near + span * f64::from(i) / 999.0) as f32;
        let fragments = input::map(1, &[(0..1000).map(|i| (depth(i), 1.0)).collect()]);
        let layered = even(rng.random_range(2..=16), faulty);
        let share = 1000.0 / f64::from(layered.layers);
        let held = layers_of(&build(&layered, &fragments)?, &layered, 0);
        for layer in &held {
            tally.within((layer - share).abs(), 1.5, || format!("{held:?}"));
        }
    }
    Ok(tally)
}

fn meet(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for case in 0..context.cases {
        let mut rng = input::rng(context.seed, "meet", case);
        let layers = rng.random_range(1..=40);
        // From 0.25 to 0.75 in every texel.
        let mut texel = || {
            let mut all = vec![(0.25, 0.5), (0.75, 0.25)];
            let count = rng.random_range(0..20);
            all.extend((0..count).map(|_| {
                (input::dyadic(rng.random_range(0.25..0.75)), rng.random_range(0.0..1.0))
            }));
            all
        };
        let fragments = input::map(3, &(0..9).map(|_| texel()).collect::<Vec<_>>());
        let bounded = even(layers, faulty && layers > 1);
        let ours = build(&bounded, &fragments)?;
        for layout in [Layout::Planes(Slicing::Uniform), input::deep(0.5)] {
            let other = input::layered(layout, layers);
            let theirs = build(&other, &fragments)?;
            for texel in 0..fragments.texels() {
                let a = input::sums(&ours, &bounded, texel);
                let b = input::sums(&theirs, &other, texel);
                tally.check(a == b, || format!("{:?}: {a:?}, bounded {b:?}", other.layout));
            }
        }
        // One layer, counted in full, is the total.
        let one = Layered { lookup: Lookup::Nearest, ..even(1, false) };
        let maps = build(&one, &fragments)?;
        for texel in 0..fragments.texels() {
            let expected = (-input::total(&fragments, texel)).exp();
            let t = input::at(&maps, texel, rng.random_range(0.25..0.9));
            tally.within((t - expected).abs(), 1e-6, || format!("{t}, all {expected}"));
        }
    }
    Ok(tally)
}

fn affine(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for case in 0..context.cases {
        let mut rng = input::rng(context.seed, "affine", case);
        let fragments = input::fragments(&mut rng);
        // By powers of two, so that f32 moves depths exactly.
        let moved = input::mapped(&fragments, |f| Fragment { depth: 0.5 * f.depth + 0.25, ..f });
        let mut layered = input::layers_of(&mut rng, "bom");
        if faulty {
            layered.layout = input::deep(0.3);
        }
        let [a, b] = [build(&layered, &fragments)?, build(&layered, &moved)?];
        for texel in 0..fragments.texels() {
            let [a, b] = [&a, &b].map(|maps| input::sums(maps, &layered, texel));
            tally.check(a == b, || format!("{layered:?}: {a:?}, moved {b:?}"));
        }
    }
    Ok(tally)
}

fn reversed(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for case in 0..context.cases {
        let mut rng = input::rng(context.seed, "reversed", case);
        let fragments = input::fragments(&mut rng);
        let turned = input::mapped(&fragments, |f| Fragment { depth: 1.0 - f.depth, ..f });
        let layers = rng.random_range(2..=20_u32);
        let layered = Layered { format: Format::Fixed, ..even(layers, faulty) };
        let [a, b] = [build(&layered, &fragments)?, build(&layered, &turned)?];
        for texel in (0..fragments.texels()).filter(|t| !fragments.texel(*t).is_empty()) {
            let [here, there] = [a.texel(texel), b.texel(texel)];
            let exchanged = here[0] == 1.0 - there[1] && here[1] == 1.0 - there[0];
            tally.check(exchanged, || format!("{:?} {:?}", &here[..2], &there[..2]));
            let depth = here[1] - here[0];
            let total = input::total(&fragments, texel);
            for k in (1..layers).filter(|_| depth > 1e-3) {
                let z = here[0] + depth * k as f32 / layers as f32;
                // What lies on a boundary is behind it from either side.
                if fragments.texel(texel).iter().any(|f| (f.depth - z).abs() < 1e-5) {
                    continue;
                }
                let front = input::sums(&a, &layered, texel)[k as usize - 1];
                let back = input::sums(&b, &layered, texel)[(layers - k) as usize - 1];
                tally.within((f64::from(front + back) - total).abs(), 1e-4, || {
                    format!("{k} of {layers}: {front} + {back}, all {total}")
                });
            }
        }
    }
    Ok(tally)
}
