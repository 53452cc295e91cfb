//! Which texels are read, what is averaged, and how opaque casters take part.

use super::{About, gate, input};
use crate::{
    SuiteError,
    verify::{Gate, GateContext, Tally},
};
use dapple_opacity_maps::{
    Blur, Code, Fragments, Layout, Lookup, Opaque, Receiver, Settings, Slicing, Taps, cpu::Maps,
};
use rand::RngExt;

const WIDER: [Taps; 3] = [Taps::Box3, Taps::Box4, Taps::Stochastic16];

pub fn gates() -> Vec<Gate> {
    let about = |technique, name, statement, fault| About { technique, name, statement, fault };
    let mut gates = Vec::new();
    for id in ["osm", "dom", "bom", "fourier", "moments"] {
        gates.push(gate(
            about(
                id,
                "P13 constants",
                "where all texels are the same, any taps and either blur give what one tap gives",
                "one texel is empty",
            ),
            move |context, faulty| constants(id, context, faulty),
        ));
    }
    for id in ["osm", "dom", "bom"] {
        gates.push(gate(
            about(
                id,
                "row 34 opaque weight",
                "behind an opaque caster of weight w, e to the minus w of what arrives is left; in \
                 front of it nothing of it shows",
                "the caster is left out",
            ),
            move |context, faulty| opaque_weight(id, context, faulty),
        ));
    }
    gates.extend([
        gate(
            about(
                "osm",
                "P13 blurs",
                "thickness blurred before it is decoded is never lighter than light blurred after",
                "the blurs are exchanged",
            ),
            darker,
        ),
        gate(
            about(
                "osm",
                "row 16 noise",
                "variance falls as taps are added, jittered ones too",
                "all read one tap",
            ),
            noise,
        ),
        gate(
            about(
                "shadow-map",
                "row 2 steps",
                "a plane hides all behind it and nothing else, and its edge is in ninths or \
                 sixteenths",
                "a translucent plane's own light shows behind it",
            ),
            steps,
        ),
        gate(
            about(
                "bom",
                "row 35 opaque in bounds",
                "an opaque caster far behind leaves layers empty if it stretches the bounds, and \
                 none if not",
                "the switch is the other way round",
            ),
            in_bounds,
        ),
    ]);
    gates
}

fn constants(id: &str, context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for case in 0..context.cases {
        let mut rng = input::rng(context.seed, id, case);
        let texel = loop {
            let texel = input::texel(&mut rng);
            if !texel.is_empty() {
                break texel;
            }
        };
        let mut texels = vec![texel; 36];
        if faulty {
            texels[14].clear();
        }
        let fragments = input::map(6, &texels);
        let settings = Settings {
            opaque: Opaque::Separate,
            ..input::sound(input::settings_of(&mut rng, id)?)
        };
        let of =
            |taps, blur| input::build(&Settings { taps, blur, ..settings.clone() }, &fragments);
        let single = of(Taps::One, Blur::Transmittance)?;
        let mut receivers = input::receivers(&mut rng, 16);
        // Some of them above the texel that a fault empties.
        receivers.extend([0.1, 0.3, 0.6, 0.9].map(|depth| Receiver::at(0.4, 0.4, depth)));
        for taps in WIDER {
            for blur in [Blur::Transmittance, Blur::Stored] {
                let maps = of(taps, blur)?;
                for receiver in &receivers {
                    let [a, b] = [&single, &maps].map(|m| f64::from(m.transmittance(receiver)));
                    let bound = super::shared::port_bound(&settings, &fragments) + 1e-5;
                    tally.within((a - b).abs(), bound, || {
                        format!("{taps:?} {blur:?} {settings:?} at {receiver:?}: {b}, one tap {a}")
                    });
                }
            }
        }
    }
    Ok(tally)
}

/// Even planes, read as asked.
fn planes(taps: Taps, blur: Blur) -> Settings {
    let code = Code::Layered(input::layered(Layout::Planes(Slicing::Uniform), 16));
    Settings { taps, blur, ..input::plain(code) }
}

fn darker(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for case in 0..context.cases {
        let mut rng = input::rng(context.seed, "darker", case);
        let fragments = input::fragments(&mut rng);
        let taps = WIDER[case as usize % 3];
        let stored = input::build(&planes(taps, Blur::Stored), &fragments)?;
        let each = input::build(&planes(taps, Blur::Transmittance), &fragments)?;
        for receiver in input::receivers(&mut rng, 20) {
            let [a, b] = [&stored, &each].map(|m| f64::from(m.transmittance(&receiver)));
            let [a, b] = if faulty { [b, a] } else { [a, b] };
            tally.within(a - b, 1e-6, || format!("{taps:?} at {receiver:?}: {a} over {b}"));
        }
    }
    Ok(tally)
}

fn noise(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for case in 0..context.cases.min(4) {
        let mut rng = input::rng(context.seed, "noise", case);
        let mut texel = || vec![(0.2, rng.random_range(0.0..2.0_f32)), (0.8, 0.1)];
        let texels: Vec<_> = (0..32 * 32).map(|_| texel()).collect();
        let fragments = input::map(32, &texels);
        let receivers: Vec<Receiver> = input::receivers(&mut rng, 1000)
            .iter()
            .map(|r| Receiver { depth: 0.9, ..*r })
            .collect();
        let spread = |taps| {
            let taps = if faulty { Taps::One } else { taps };
            let maps = input::build(&planes(taps, Blur::Transmittance), &fragments)?;
            let values = receivers.iter().map(|r| f64::from(maps.transmittance(r)));
            let (n, mean) = (1000.0, values.clone().sum::<f64>() / 1000.0);
            Ok::<_, SuiteError>(values.map(|v| (v - mean).powi(2)).sum::<f64>() / n)
        };
        let [one, nine, sixteen, jittered] = [
            spread(Taps::One)?,
            spread(Taps::Box3)?,
            spread(Taps::Box4)?,
            spread(Taps::Stochastic16)?,
        ];
        let what = || format!("{one} of one tap, {nine}, {sixteen}, jittered {jittered}");
        tally.within(nine, 0.25 * one, what);
        tally.within(sixteen, 0.8 * nine, what);
        tally.within(jittered, 0.25 * one, what);
    }
    Ok(tally)
}

fn steps(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for case in 0..context.cases {
        let mut rng = input::rng(context.seed, "steps", case);
        // A plane over the columns from some column on.
        let (edge, depth) = (rng.random_range(1..7_usize), rng.random_range(0.2..0.7_f32));
        let texels: Vec<_> =
            (0..64).map(|i| if i % 8 >= edge { vec![(depth, 0.35)] } else { Vec::new() }).collect();
        let fragments = input::map(8, &texels);
        for (taps, n) in [(Taps::One, 1.0), (Taps::Box3, 9.0), (Taps::Box4, 16.0)] {
            let code = if faulty { planes(taps, Blur::default()).code } else { Code::Binary };
            let maps = input::build(&Settings { taps, ..input::plain(code) }, &fragments)?;
            for receiver in input::receivers(&mut rng, 12) {
                let t = f64::from(maps.transmittance(&receiver));
                let what = || format!("{taps:?}, edge {edge}/8 at {depth}: {t} at {receiver:?}");
                tally.within((t * n - (t * n).round()).abs(), 1e-5, what);
                let from_edge = 8.0 * receiver.u - edge as f32;
                if receiver.depth <= depth || from_edge < -2.0 {
                    tally.check(t == 1.0, what);
                } else if from_edge > 2.0 {
                    tally.check(t == 0.0, what);
                }
            }
        }
    }
    Ok(tally)
}

/// The same map with an opaque surface below every texel.
fn over_ground(fragments: &Fragments, depth: f32) -> Fragments {
    Fragments { opaque: vec![depth; fragments.texels()], ..fragments.clone() }
}

fn opaque_weight(id: &str, context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for case in 0..context.cases {
        let mut rng = input::rng(context.seed, id, case);
        // All translucent fragments end before 1.
        let bare = input::fragments(&mut rng);
        let fragments = over_ground(&bare, 1.2);
        let weight = [3.0, 10.0, 1e6, rng.random_range(0.1..5.0)][rng.random_range(0..4_usize)];
        let opaque = Opaque::Weight { weight, in_bounds: rng.random_range(0..2) == 0 };
        let mut layered = input::layers_of(&mut rng, id);
        // What the last of open layers holds counts in full.
        layered.lookup = Lookup::Nearest;
        let settings = Settings { opaque, ..input::plain(Code::Layered(layered)) };
        let drawn = if faulty { &bare } else { &fragments };
        let maps: Maps = input::build(&settings, drawn)?;
        for texel in 0..fragments.texels() {
            let expected = (-input::total(&fragments, texel) - f64::from(weight)).exp();
            let t = input::at(&maps, texel, 9.0);
            let what = || format!("{settings:?}: {t}, expected {expected}");
            tally.within((t - expected).abs(), 1e-5, what);
            tally.check(input::at(&maps, texel, -0.1) == 1.0, what);
        }
    }
    Ok(tally)
}

fn in_bounds(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for case in 0..context.cases {
        let mut rng = input::rng(context.seed, "in bounds", case);
        let near = rng.random_range(0.0..0.2_f32);
        let texel = (0..64).map(|i| (near + i as f32 * 1e-3, 0.1)).collect();
        let fragments = over_ground(&input::map(1, &[texel]), 0.9);
        for in_bounds in [false, true] {
            let layered = input::layered(input::bounded(0.0), 16);
            let opaque = Opaque::Weight { weight: 3.0, in_bounds: in_bounds != faulty };
            let settings = Settings { opaque, ..input::plain(Code::Layered(layered.clone())) };
            let maps = input::build(&settings, &fragments)?;
            let mut before = 0.0;
            let sums = input::sums(&maps, &layered, 0).iter();
            let used = sums.filter(|&&s| s > std::mem::replace(&mut before, s)).count();
            let right = if in_bounds { used <= 4 } else { used == 16 };
            tally.check(right, || format!("{used} of 16 layers used, in bounds: {in_bounds}"));
        }
    }
    Ok(tally)
}
