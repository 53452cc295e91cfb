//! Planes by opacity or of growing distance, growing deep layers, and how deep layers should reach.

use super::{
    About, gate, input,
    layouts::{build, layers_of},
};
use crate::{
    SuiteError,
    verify::{Gate, GateContext, Tally},
};
use dapple_opacity_maps::{
    Layout, Opaque, Slicing,
    exact::Exact,
    layered::{LayeredCode, boundaries::Boundaries, placement::Placement, planes},
    search::oracle,
};
use rand::RngExt;

pub fn gates() -> Vec<Gate> {
    let about = |technique, name, statement, fault| About { technique, name, statement, fault };
    vec![
        gate(
            about(
                "osm",
                "row 11 density",
                "planes by density hold equal shares of all thickness, to a fragment",
                "even planes",
            ),
            density,
        ),
        gate(
            about(
                "osm",
                "row 11 growing",
                "growing planes go from the first to the last fragment, each gap 1.15 times the \
                 one before",
                "even planes",
            ),
            growing_planes,
        ),
        gate(
            about(
                "dom",
                "row 20 growing",
                "layers go from 0 to the span, each the growth times as deep as the one before",
                "even layers",
            ),
            growing_layers,
        ),
        gate(
            about(
                "dom",
                "row 19 span",
                "layers that end far too early or far too late err more than those of the rays' \
                 own depth",
                "layers are those of the rays' own depth, whatever the span",
            ),
            span,
        ),
    ]
}

fn density(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for case in 0..context.cases {
        let mut rng = input::rng(context.seed, "density", case);
        let mut fragments = input::fragments(&mut rng);
        // All depths differ: fragments at one depth cannot be told apart by planes.
        for (i, f) in fragments.items.iter_mut().enumerate() {
            f.depth += 1e-6 * i as f32;
        }
        let slicing = if faulty { Slicing::Uniform } else { Slicing::Density };
        let layered = input::layered(Layout::Planes(slicing), rng.random_range(1..=8));
        let maps = build(&layered, &fragments)?;
        let mut held = vec![0.0; layered.layers as usize];
        for texel in 0..fragments.texels() {
            let layers = layers_of(&maps, &layered, texel);
            held.iter_mut().zip(layers).for_each(|(sum, layer)| *sum += layer);
        }
        let share = held.iter().sum::<f64>() / f64::from(layered.layers);
        let most = fragments.items.iter().map(|f| f64::from(f.omega)).fold(0.0, f64::max);
        for layer in &held {
            tally.within((layer - share).abs(), 2.0 * most + 1e-4, || format!("{held:?}"));
        }
    }
    Ok(tally)
}

/// Holds depths against a first, a last, and the ratio of neighbouring gaps.
fn geometric(tally: &mut Tally, at: &[f32], [first, last]: [f32; 2], growth: f64) {
    let what = || format!("{at:?} from {first} to {last} by {growth}");
    tally.check(at.first() == Some(&first) && at.last() == Some(&last), what);
    for w in at.windows(3) {
        let [a, b, c] = [w[0], w[1], w[2]].map(f64::from);
        // Depths are rounded to 2^-24.
        let bound = 4e-7 * (1.0 + growth);
        tally.within(((c - b) - growth * (b - a)).abs(), bound, what);
    }
}

fn growing_planes(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for case in 0..context.cases {
        let mut rng = input::rng(context.seed, "growing planes", case);
        let fragments = input::fragments(&mut rng);
        let layers = rng.random_range(2..=16_usize);
        let placed =
            planes::place(Slicing::Growing, layers, &fragments, Opaque::Separate, &mut Vec::new());
        let depths = || fragments.items.iter().map(|f| f.depth);
        let ends = [depths().fold(f32::MAX, f32::min), depths().fold(f32::MIN, f32::max)];
        let Placement::Planes { uneven: Some(Boundaries(mut at)), .. } = placed else { continue };
        if faulty {
            let even = |k: usize| ends[0] + (ends[1] - ends[0]) * k as f32 / layers as f32;
            at = (0..=layers).map(even).collect();
        }
        geometric(&mut tally, &at, ends, planes::GROWTH);
    }
    Ok(tally)
}

fn growing_layers(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for case in 0..context.cases {
        let mut rng = input::rng(context.seed, "growing layers", case);
        let (span, growth) = (rng.random_range(0.01..1.5_f32), rng.random_range(1.05..2.0_f32));
        let given = if faulty { 1.0001 } else { growth };
        let layout = Layout::Deep { span, growth: given, listing: false };
        let layered = input::layered(layout, rng.random_range(2..=12));
        let code = LayeredCode::new(&layered, Opaque::Separate);
        if let Placement::Deep { uneven: Some(Boundaries(at)), .. } = &code.placement {
            geometric(&mut tally, at, [0.0, span], growth.into());
        }
    }
    Ok(tally)
}

fn span(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for case in 0..context.cases.min(8) {
        let mut rng = input::rng(context.seed, "span", case);
        let texel = |_| {
            let near = rng.random_range(0.1..0.3_f32);
            let one = |_| (near + rng.random_range(0.0..0.4_f32), 0.1);
            (0..40).map(one).collect()
        };
        let fragments = input::map(8, &(0..64).map(texel).collect::<Vec<_>>());
        let exact = Exact::of(&fragments);
        let error = |share: f32| {
            let share = if faulty { 1.0 } else { share };
            let layered = input::layered(input::deep(share * exact.deepest_span()), 8);
            Ok::<_, SuiteError>(oracle::rmse(&build(&layered, &fragments)?, &fragments, &exact)?)
        };
        let [early, own, late] = [error(0.05)?, error(1.0)?, error(15.0)?];
        let what = || format!("too early {early}, own {own}, too late {late}");
        tally.within(1.2 * own, early, what);
        tally.within(1.2 * own, late, what);
    }
    Ok(tally)
}
