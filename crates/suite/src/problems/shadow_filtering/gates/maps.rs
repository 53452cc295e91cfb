//! What holds for every technique on whole maps: the range, receivers outside, and the port of
//! the processor.

use super::{About, gate, input};
use crate::{
    SuiteError,
    problems::shadow_filtering::{SPEC, tolerance},
    verify::{Gate, GateContext, Tally},
};
use dapple_shadows::filtering::{
    DepthMap, Receiver, Settings, cpu,
    faults::{self, Fault},
    reference,
};
use rand::RngExt;

/// Receivers of one random map.
const RECEIVERS: usize = 200;

pub fn gates() -> Vec<Gate> {
    let mut gates = Vec::new();
    for technique in SPEC.techniques {
        let id = technique.id;
        gates.push(gate(
            About {
                technique: id,
                name: "P7.1 range",
                statement: "every visibility is finite and within 0..=1, and 1 outside the map",
                fault: "a receiver outside the map is moved to its border",
            },
            move |context, faulty| range(id, context, faulty),
        ));
        gates.push(gate(
            About {
                technique: id,
                name: "P7.6 cpu port",
                statement: "separable, parallel f32 windows give what brute-force f64 ones give",
                fault: "the reference's window begins one texel early",
            },
            move |context, faulty| cpu_port(id, context, faulty),
        ));
    }
    gates
}

fn evaluate(
    map: &DepthMap,
    receivers: &[Receiver],
    settings: &Settings,
    fault: Option<Fault>,
) -> Result<Vec<f64>, SuiteError> {
    Ok(match fault {
        None => reference::visibility(map, receivers, settings)?,
        Some(fault) => faults::visibility(map, receivers, settings, fault)?,
    })
}

fn range(id: &str, context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    let fault = faulty.then_some(Fault::ClampedReceiver);
    for case in 0..context.cases {
        let mut rng = input::rng(context.seed, id, case);
        let (map, settings) = (input::map(&mut rng), input::settings_of(&mut rng, id)?);
        let mut receivers = input::receivers(&mut rng, &map, RECEIVERS);
        for extreme in [0.0, 1.0, -1.0, 3.0, 1e-30, f32::MAX, f32::MIN] {
            receivers.push(Receiver::new(rng.random_range(0.0..1.0), 1.0, extreme));
            receivers.push(Receiver::new(0.0, 0.0, 0.5).with_slope(extreme, f32::INFINITY));
        }
        let inside = receivers.len();
        for (u, v) in [(-0.01, 0.5), (0.5, 1.01), (f32::NAN, 0.5), (2.0, -3.0)] {
            receivers.push(Receiver::new(u, v, 0.99));
        }
        receivers.push(Receiver::new(0.5, 0.5, f32::NAN));
        receivers.push(Receiver { valid: 0.0, ..Receiver::new(0.5, 0.5, 0.99) });
        let visibilities = evaluate(&map, &receivers, &settings, fault)?;
        for (i, v) in visibilities.iter().enumerate() {
            let right = if i < inside { (0.0..=1.0).contains(v) } else { *v == 1.0 };
            tally.check(right, || format!("{:?}: {:?} gives {v}", settings, receivers[i]));
        }
    }
    Ok(tally)
}

fn cpu_port(id: &str, context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    let fault = faulty.then_some(Fault::WindowOffByOne);
    for case in 0..context.cases {
        let mut rng = input::rng(context.seed, id, case);
        let (map, settings) = (input::map(&mut rng), input::settings_of(&mut rng, id)?);
        let receivers = input::receivers(&mut rng, &map, RECEIVERS);
        let mut filter = cpu::Filter::new(map.width, map.height, &settings)?;
        let mut port = vec![0.0; receivers.len()];
        filter.prefilter(&map)?;
        filter.shade(&map, &receivers, &mut port)?;
        let expected = evaluate(&map, &receivers, &settings, fault)?;
        hold(&mut tally, &port, &expected, &settings);
    }
    Ok(tally)
}

/// One check a map: the share of receivers beyond the settings' tolerance.
pub fn hold(tally: &mut Tally, port: &[f32], expected: &[f64], settings: &Settings) {
    let deviation = tolerance::Deviation::between(port, expected, settings);
    let allowed = tolerance::of(settings).beyond;
    // As a multiple of what is allowed: tolerances differ between settings.
    tally.within(deviation.share_beyond / allowed, 1.0, || {
        format!("{settings:?}: share of receivers beyond tolerance (largest {:.3})", deviation.max)
    });
    tally.check(deviation.max.is_finite(), || format!("{settings:?}: a value is not finite"));
}
