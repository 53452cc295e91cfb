//! What holds for every technique that the problem declares.

use super::{About, cascades, gate, input};
use crate::{
    SuiteError,
    problem::Technique,
    problems::translucent_shadow::SPEC,
    verify::{Gate, GateContext, Tally},
};
use dapple_opacity_maps::{
    Code, Fragment, Fragments, Opaque, Receiver, Settings, Taps, faults::MISMATCH, fourier,
    layered::reference::tolerance, moments, reference::Reference,
};
use rand::RngExt;

/// Receivers of one random map.
const RECEIVERS: usize = 16;

/// Sums over taps and one exponential in 32-bit floats.
const FLOATS: f64 = 2e-6;

pub fn gates() -> Vec<Gate> {
    let about = |technique, name, statement, fault| About { technique, name, statement, fault };
    let mut gates = Vec::new();
    for technique in SPEC.techniques.iter().filter(|t| has_texels(t)) {
        let id = technique.id;
        gates.push(gate(
            about(
                id,
                "P4 range",
                "every transmittance is within 0..=1, and 1 in front of everything, outside the \
                 map, and of what is no receiver",
                "the weights of the taps add up to 1.001",
            ),
            move |context, faulty| range(id, context, faulty),
        ));
        gates.push(gate(
            about(
                id,
                "cpu port",
                "the processor's form lies within what rounding can do to the f64 reference, ties \
                 at layer boundaries included",
                "fragments lie 0.01 nearer when they are drawn; without a map, the nearest hides all",
            ),
            move |context, faulty| port(id, context, faulty),
        ));
        // A technique whose settings cannot be drawn gets all gates, and they say so.
        let code = input::settings_of(&mut input::rng(0, id, 0), id).map(|s| s.code);
        if !matches!(code, Ok(Code::Unshadowed | Code::Stochastic(_))) {
            gates.push(gate(
                about(
                    id,
                    "P5 end",
                    "behind everything lies e to the minus all thickness (a binary map: nothing), \
                     and that of an opaque caster's weight",
                    "the fragment drawn last is lost",
                ),
                move |context, faulty| end(id, context, faulty),
            ));
        }
        if !matches!(code, Ok(Code::Unshadowed | Code::Fourier(_))) {
            gates.push(gate(
                about(
                    id,
                    "P4 order",
                    "transmittance never rises along a ray",
                    "depths are counted from the far plane",
                ),
                move |context, faulty| falls(id, context, faulty),
            ));
        }
    }
    gates
}

/// Whether a technique stores fragments by texel: cascades are of their own kind, with gates of
/// their own.
pub fn has_texels(technique: &Technique) -> bool {
    technique.id != cascades::ID
}

fn range(id: &str, context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    let weights = if faulty { 1.001 } else { 1.0 };
    for case in 0..context.cases {
        let mut rng = input::rng(context.seed, id, case);
        let fragments = input::fragments(&mut rng);
        let fragments = input::with_opaque(&mut rng, fragments);
        let settings = input::settings_of(&mut rng, id)?;
        let maps = input::build(&settings, &fragments)?;
        let mut receivers = input::receivers(&mut rng, 2 * RECEIVERS);
        for extreme in [0.0, 1.0, 3.0, 1e-30, f32::MAX] {
            receivers.push(Receiver::at(rng.random_range(0.0..1.0), 1.0, extreme));
            let sloped = Receiver { slope_u: extreme, slope_v: f32::NAN, ..receivers[0] };
            receivers.push(sloped);
        }
        let inside = receivers.len();
        for (u, v) in [(-0.01, 0.5), (0.5, 1.01), (f32::NAN, 0.5), (2.0, -3.0)] {
            receivers.push(Receiver::at(u, v, 0.99));
        }
        for depth in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MIN, -0.5] {
            receivers.push(Receiver::at(0.5, 0.5, depth));
        }
        receivers.push(Receiver { flags: 0, ..Receiver::at(0.5, 0.5, 0.99) });
        let mut found = vec![0.0; receivers.len()];
        maps.shade(&receivers, &mut found)?;
        for (i, t) in found.iter().map(|t| weights * t).enumerate() {
            let right = if i < inside { (0.0..=1.0).contains(&t) } else { t == 1.0 };
            tally.check(right, || format!("{settings:?}: {:?} gives {t}", receivers[i]));
        }
    }
    Ok(tally)
}

fn port(id: &str, context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for case in 0..context.cases {
        let mut rng = input::rng(context.seed, id, case);
        let fragments = input::fragments(&mut rng);
        let fragments = input::with_opaque(&mut rng, fragments);
        let settings = input::settings_of(&mut rng, id)?;
        let reference = Reference::new(&settings, &fragments)?;
        let maps = if faulty {
            let nearer = |f: Fragment| Fragment { depth: f.depth - MISMATCH, ..f };
            input::build(&without_none(&settings), &input::mapped(&fragments, nearer))?
        } else {
            input::build(&settings, &fragments)?
        };
        let bound = port_bound(&settings, &fragments);
        for receiver in input::receivers(&mut rng, RECEIVERS) {
            let t = f64::from(maps.transmittance(&receiver));
            let (least, greatest) = reference.interval(&receiver);
            tally.within((least - t).max(t - greatest), bound, || {
                format!("{settings:?} at {receiver:?}: {t}, expected {least}..={greatest}")
            });
        }
    }
    Ok(tally)
}

/// The same settings; of a map that stores nothing, those of one that hides everything.
pub fn without_none(settings: &Settings) -> Settings {
    match settings.code {
        Code::Unshadowed => Settings { code: Code::Binary, ..settings.clone() },
        _ => settings.clone(),
    }
}

/// How far the processor's form may lie outside of the reference's interval.
pub fn port_bound(settings: &Settings, fragments: &Fragments) -> f64 {
    let most = |bound: &dyn Fn(&[Fragment], Option<Fragment>) -> f64| {
        let of = |texel: usize| {
            let opaque =
                dapple_opacity_maps::cpu::weighted(settings.opaque, fragments.opaque[texel]);
            bound(fragments.texel(texel), opaque)
        };
        (0..fragments.texels()).map(of).fold(0.0, f64::max)
    };
    FLOATS
        + match &settings.code {
            Code::Layered(_) => tolerance(fragments.items.len()),
            Code::Fourier(_) => most(&fourier::port_bound),
            Code::Moments(m) => most(&|f, opaque| moments::port_bound(m, f, opaque)),
            _ => 0.0,
        }
}

/// Settings whose end or order is promised, with one tap.
fn promised(settings: Settings) -> Settings {
    Settings { taps: Taps::One, ..input::sound(settings) }
}

fn end(id: &str, context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for case in 0..context.cases {
        let mut rng = input::rng(context.seed, id, case);
        let mut fragments = input::fragments(&mut rng);
        let settings = exact_sums(promised(input::settings_of(&mut rng, id)?));
        let weight = match settings.opaque {
            Opaque::Separate => 0.0,
            Opaque::Weight { weight, .. } => f64::from(weight),
        };
        if weight > 0.0 {
            fragments = input::with_opaque(&mut rng, fragments);
        }
        let drawn = if faulty { input::without_last(&fragments) } else { fragments.clone() };
        let maps = input::build(&settings, &drawn)?;
        for texel in 0..fragments.texels() {
            let opaque = fragments.opaque[texel] < dapple_opacity_maps::NO_OPAQUE;
            let omega = input::total(&fragments, texel) + if opaque { weight } else { 0.0 };
            let lit = fragments.texel(texel).is_empty() && !(opaque && weight > 0.0);
            let expected = match &settings.code {
                Code::Binary => f64::from(u8::from(lit)),
                _ => (-omega).exp(),
            };
            let bound = FLOATS
                + match &settings.code {
                    Code::Deep(deep) => f64::from(deep.tolerance),
                    _ => port_bound(&settings, &fragments),
                };
            // So deep that the last of open layers has ended.
            let t = f64::from(maps.transmittance(&receiver_over(texel, &fragments, 1e6)));
            tally.within((t - expected).abs(), bound, || format!("{settings:?}: {t} {expected}"));
        }
    }
    Ok(tally)
}

/// The same in 32-bit floats that are added.
fn exact_sums(mut settings: Settings) -> Settings {
    use dapple_opacity_maps::{Blend, Format, Layout, Lookup};
    match &mut settings.code {
        Code::Layered(layered) => {
            (layered.format, layered.blend) = (Format::F32, Blend::Add);
            // The last layer of deep maps has no end, and this lookup never counts it.
            let open = matches!(layered.layout, Layout::Deep { .. });
            if open && layered.lookup == Lookup::Exclusive {
                layered.lookup = Lookup::Nearest;
            }
        }
        Code::Fourier(f) => f.format = Format::F32,
        Code::Moments(m) => m.format = Format::F32,
        // As many nodes as the tolerance asks for.
        Code::Deep(deep) => deep.nodes = 1024,
        _ => {}
    }
    settings
}

/// A receiver in the middle of a texel.
fn receiver_over(texel: usize, fragments: &Fragments, depth: f32) -> Receiver {
    let (width, height) = (fragments.width as usize, fragments.height as usize);
    let centre = |place: usize, size: usize| (place as f32 + 0.5) / size as f32;
    Receiver::at(centre(texel % width, width), centre(texel / width, height), depth)
}

fn falls(id: &str, context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for case in 0..context.cases {
        let mut rng = input::rng(context.seed, id, case);
        let fragments = input::fragments(&mut rng);
        let settings = promised(input::settings_of(&mut rng, id)?);
        let maps = input::build(&settings, &fragments)?;
        // Bounds of moments fall in exact arithmetic; rounding is magnified by the bias.
        let slack = match &settings.code {
            Code::Moments(_) => port_bound(&settings, &fragments),
            Code::Layered(_) => 1e-6,
            _ => 0.0,
        };
        for texel in 0..fragments.texels() {
            let mut lowest = f64::INFINITY;
            let mut depths: Vec<f32> = (-5..=105).map(|i| i as f32 / 100.0).collect();
            depths.extend(
                fragments
                    .texel(texel)
                    .iter()
                    .flat_map(|f| [f.depth.next_down(), f.depth, f.depth.next_up()]),
            );
            depths.sort_by(f32::total_cmp);
            let mut worst = f64::NEG_INFINITY;
            for depth in depths {
                let seen = if faulty { 1.0 - depth } else { depth };
                let t = input::at(&maps, texel, seen);
                worst = worst.max(t - lowest);
                lowest = lowest.min(t);
            }
            tally.within(worst, slack, || format!("{settings:?}, texel {texel}"));
        }
    }
    Ok(tally)
}
