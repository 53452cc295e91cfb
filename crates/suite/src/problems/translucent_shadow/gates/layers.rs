//! Layers of opacity: which layer a fragment is in, what a map holds, what is read between and at
//! boundaries.

use super::{About, gate, input};
use crate::{
    SuiteError,
    verify::{Gate, GateContext, Tally},
};
use dapple_opacity_maps::{
    Code, Format, Fragment, Fragments, Layered, Layout, Lookup, Slicing, SplitKind, cpu::Maps,
    faults::Fault, layered::split_reference::SplitReference,
};
use rand::RngExt;
use rand_pcg::Pcg64;

pub fn gates() -> Vec<Gate> {
    let mut gates = Vec::new();
    for id in ["osm", "dom", "bom"] {
        let about = |name, statement, fault| About { technique: id, name, statement, fault };
        gates.push(gate(
            about(
                "P2 one layer",
                "every fragment is in one layer, and none is lost",
                "a layer's sum lacks what lies in it",
            ),
            move |context, faulty| one_layer(id, context, faulty),
        ));
        gates.push(gate(
            about("P3 sums", "sums never fall from layer to layer", "the printed masks"),
            move |context, faulty| sums_rise(id, context, faulty),
        ));
        gates.push(gate(
            about(
                "P3 total",
                "the last sum is the thickness of all, to the bit, in any order of drawing and \
                 whatever the layers",
                "row 42: the opacity pass tests and writes depth",
            ),
            move |context, faulty| same_total(id, context, faulty),
        ));
        gates.push(gate(
            about(
                "P6 boundaries",
                "read linearly, thickness at a layer's boundary is what lies in front of it, and \
                 between two boundaries it lies between both",
                "fragments are written with another bias than receivers are read with",
            ),
            move |context, faulty| boundaries(id, context, faulty.then_some(Fault::MismatchedBias)),
        ));
        if id != "osm" {
            gates.push(gate(
                about(
                    "P6 own bounds",
                    "read linearly, thickness at a layer's boundary is what lies in front of it, \
                     and between two boundaries it lies between both",
                    "layers lie between the next texel's bounds",
                ),
                move |context, faulty| {
                    boundaries(id, context, faulty.then_some(Fault::NextTexelBounds))
                },
            ));
            gates.push(gate(
                about(
                    "row 18 front",
                    "the first surface is lit in full where layers are read linearly",
                    "the sum up to and including the receiver's own layer is read",
                ),
                move |context, faulty| front(id, context, faulty),
            ));
        }
        gates.push(gate(
            about(
                "P6 many layers",
                "with a layer for each fragment the lookups are what is strictly in front, what is \
                 in front or level, and between both; the same between fragments",
                "the lookup up to the layer before is that up to the receiver's own",
            ),
            move |context, faulty| many_layers(id, context, faulty),
        ));
    }
    gates
}

/// Maps by settings of layers, honest or with a fault that they have.
fn maps(
    layered: &Layered,
    fragments: &Fragments,
    fault: Option<Fault>,
) -> Result<Maps, SuiteError> {
    let settings = input::plain(Code::Layered(layered.clone()));
    match fault.and_then(|fault| fault.code(&settings)) {
        None => input::build(&settings, fragments),
        Some(code) => input::build_with(&settings, fragments, code),
    }
}

fn one_layer(id: &str, context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for case in 0..context.cases {
        let mut rng = input::rng(context.seed, id, case);
        let ones = |f| Fragment { omega: 1.0, ..f };
        let fragments = input::mapped(&input::fragments(&mut rng), ones);
        let layered = input::layers_of(&mut rng, id);
        let maps = maps(&layered, &fragments, faulty.then_some(Fault::LatePrefix))?;
        for texel in 0..fragments.texels() {
            let sums = input::sums(&maps, &layered, texel);
            let (last, count) = (sums[sums.len() - 1], fragments.texel(texel).len());
            let right = sums.iter().all(|s| s.fract() == 0.0) && last == count as f32;
            tally.check(right, || format!("{layered:?}: {count} fragments, {sums:?}"));
        }
    }
    Ok(tally)
}

fn sums_rise(id: &str, context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for case in 0..context.cases {
        let mut rng = input::rng(context.seed, id, case);
        let fragments = input::fragments(&mut rng);
        let layered = input::layers_of(&mut rng, id);
        let maps = maps(&layered, &fragments, faulty.then_some(Fault::Listing))?;
        for texel in 0..fragments.texels() {
            let sums = input::sums(&maps, &layered, texel);
            let rises = sums.windows(2).all(|w| w[0] <= w[1]);
            tally.check(rises, || format!("{layered:?}: {sums:?}"));
        }
    }
    Ok(tally)
}

fn same_total(id: &str, context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    let fault = faulty.then_some(Fault::DepthTested);
    for case in 0..context.cases {
        let mut rng = input::rng(context.seed, id, case);
        let fragments = input::fragments(&mut rng);
        let one = Layered { format: Format::Fixed, ..input::layers_of(&mut rng, id) };
        let layout = input::layout_of(&mut rng, ["osm", "dom", "bom"][case as usize % 3]);
        let other = Layered { layout, ..one.clone() };
        let here = maps(&one, &fragments, fault)?;
        let turned = maps(&one, &input::shuffled(&mut rng, &fragments), fault)?;
        let elsewhere = maps(&other, &fragments, None)?;
        for texel in 0..fragments.texels() {
            let last = |maps: &Maps, of: &Layered| input::sums(maps, of, texel).last().copied();
            let all = [last(&here, &one), last(&turned, &one), last(&elsewhere, &other)];
            let what = || format!("{one:?} and {:?}: {all:?}", other.layout);
            tally.check(all[0] == all[1] && all[1] == all[2], what);
            // A fragment is rounded to 2^-20.
            let bound = fragments.texel(texel).len() as f64 * 2f64.powi(-20) + 1e-9;
            let exact = input::total(&fragments, texel);
            tally.within((f64::from(all[0].unwrap_or(-1.0)) - exact).abs(), bound, what);
        }
    }
    Ok(tally)
}

/// Even layers of a technique, or bounded ones of a split whose boundaries have a formula.
fn with_known_boundaries(rng: &mut Pcg64, id: &str) -> Layered {
    let layout = match id {
        "osm" => Layout::Planes(Slicing::Uniform),
        "dom" => input::deep(rng.random_range(0.1..0.8)),
        _ => {
            let kinds = [SplitKind::Normalised, SplitKind::Table32, SplitKind::Positions];
            let mut layout = input::bounded(rng.random_range(0.0..1.0));
            if let Layout::Bounded { split, .. } = &mut layout {
                split.kind = kinds[rng.random_range(0..3_usize)];
            }
            layout
        }
    };
    input::layered(layout, [2, 3, 4, 5, 8, 16][rng.random_range(0..6_usize)])
}

/// Depths of all boundaries of a texel, from the first to the last; none where it is flat.
fn known_boundaries(layered: &Layered, fragments: &Fragments, texel: usize) -> Vec<f64> {
    let all = match layered.layout {
        Layout::Planes(_) => fragments.items.as_slice(),
        _ => fragments.texel(texel),
    };
    let depths = || all.iter().map(|f| f64::from(f.depth));
    let (first, last) =
        (depths().fold(f64::INFINITY, f64::min), depths().fold(f64::NEG_INFINITY, f64::max));
    if first >= last {
        return Vec::new();
    }
    let share = |k: u32| f64::from(k) / f64::from(layered.layers);
    let at = |k: u32| match &layered.layout {
        Layout::Planes(_) => first + (last - first) * share(k),
        Layout::Deep { span, .. } => first + f64::from(*span) * share(k),
        Layout::Bounded { split, .. } => {
            first + (last - first) * SplitReference::new(split).position(share(k))
        }
    };
    (0..=layered.layers).map(at).collect()
}

fn boundaries(
    id: &str,
    context: &GateContext<'_>,
    fault: Option<Fault>,
) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    // How far rounding moves a boundary, and what it does to a sum.
    let (near, slack) = (3e-5, 1e-3);
    for case in 0..context.cases {
        let mut rng = input::rng(context.seed, id, case);
        let fragments = input::fragments(&mut rng);
        let layered = with_known_boundaries(&mut rng, id);
        let maps = maps(&layered, &fragments, fault)?;
        for texel in 0..fragments.texels() {
            let before = |d: f64| input::prefix(&fragments, texel, |z| f64::from(z) < d);
            let omega = |d: f64| -input::at(&maps, texel, d as f32).ln();
            let at = known_boundaries(&layered, &fragments, texel);
            for (k, pair) in at.windows(2).enumerate().skip(1) {
                // The last of deep layers takes everything beyond.
                let open = matches!(layered.layout, Layout::Deep { .. }) && k + 2 == at.len();
                let (here, next) = (pair[0], pair[1]);
                let behind = if open { f64::INFINITY } else { next };
                let what = |d: f64| format!("{layered:?}, boundary {here}..{next}, at {d}");
                let off = |d: f64, from: f64, to: f64| {
                    let omega = omega(d);
                    (before(from - near) - omega).max(omega - before(to + near))
                };
                tally.within(off(here, here, here), slack, || what(here));
                let between = here + (next - here) * rng.random_range(0.1..0.9);
                tally.within(off(between, here, behind), slack, || what(between));
            }
        }
    }
    Ok(tally)
}

fn front(id: &str, context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for case in 0..context.cases {
        let mut rng = input::rng(context.seed, id, case);
        let fragments = input::fragments(&mut rng);
        let mut layered = input::layers_of(&mut rng, id);
        layered.lookup = if faulty { Lookup::Nearest } else { Lookup::Lerp };
        let maps = maps(&layered, &fragments, None)?;
        for texel in 0..fragments.texels() {
            let depths = fragments.texel(texel).iter().map(|f| f.depth);
            let first = depths.fold(1.0, f32::min);
            let t = input::at(&maps, texel, first);
            tally.within((t - 1.0).abs(), 0.0, || format!("{layered:?} at {first}: {t}"));
        }
    }
    Ok(tally)
}

fn many_layers(id: &str, context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    let layout = match id {
        "osm" => Layout::Planes(Slicing::Uniform),
        "dom" => input::deep(1.0),
        _ => input::bounded(0.0),
    };
    for case in 0..context.cases.min(8) {
        let mut rng = input::rng(context.seed, id, case);
        // At the beginning of every 16th of 256 layers, from 0 to 1.
        let texel = (0..=16).map(|i| (i as f32 / 16.0, rng.random_range(0.01..0.2_f32)));
        let fragments = input::map(1, &[texel.collect()]);
        let of = |lookup| {
            let lookup =
                if faulty && lookup == Lookup::Exclusive { Lookup::Nearest } else { lookup };
            let layered = Layered { lookup, ..input::layered(layout.clone(), 256) };
            maps(&layered, &fragments, None)
        };
        let [exclusive, nearest, lerp] =
            [of(Lookup::Exclusive)?, of(Lookup::Nearest)?, of(Lookup::Lerp)?];
        let omega = |maps: &Maps, depth: f32| -input::at(maps, 0, depth).ln();
        let mut near = |found: f64, expected: f64, what: &str| {
            tally.within((found - expected).abs(), 1e-5, || format!("{what}: {found} {expected}"));
        };
        for i in 0..16 {
            let depth = i as f32 / 16.0;
            let strict = input::prefix(&fragments, 0, |z| z < depth);
            let inclusive = input::prefix(&fragments, 0, |z| z <= depth);
            near(omega(&exclusive, depth), strict, "strictly in front");
            near(omega(&nearest, depth), inclusive, "in front or level");
            let between = omega(&lerp, depth).clamp(strict, inclusive);
            near(omega(&lerp, depth), between, "between both");
            for maps in [&exclusive, &nearest, &lerp] {
                near(omega(maps, depth + 1.0 / 32.0), inclusive, "between fragments");
            }
        }
    }
    Ok(tally)
}
