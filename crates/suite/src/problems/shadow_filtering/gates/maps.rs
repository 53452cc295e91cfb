//! What holds for every technique on whole maps: the range, and receivers outside.

use super::{About, gate, input};
use crate::{
    SuiteError,
    problems::shadow_filtering::SPEC,
    verify::{Gate, GateContext, Tally},
};
use dapple_shadows::filtering::{
    DepthMap, Receiver, Settings,
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
