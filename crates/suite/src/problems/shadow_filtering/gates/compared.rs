//! Hard maps and percentage-closer filtering: exact by definition.

use super::{About, gate, input};
use crate::{
    SuiteError,
    verify::{Gate, GateContext, Tally},
};
use dapple_shadows::filtering::{
    DepthMap, Receiver, Settings,
    faults::{self, Fault},
    reference,
};
use rand::RngExt;

const OFF_BY_ONE: &str = "the window begins one texel early";

pub fn gates() -> Vec<Gate> {
    let about = |technique, name, statement, fault| About { technique, name, statement, fault };
    vec![
        gate(
            about(
                "hard",
                "one comparison",
                "visibility is the comparison with the texel that holds the receiver",
                OFF_BY_ONE,
            ),
            |context, faulty| mean_of_steps("hard", context, faulty),
        ),
        gate(
            about(
                "pcf",
                "mean of comparisons",
                "visibility is the mean of K x K comparisons; one texel is the hard map",
                OFF_BY_ONE,
            ),
            |context, faulty| mean_of_steps("pcf", context, faulty),
        ),
        gate(
            about(
                "hard",
                "P7.10 lit plane",
                "an unoccluded plane is lit at every slope",
                "no receiver-plane bias",
            ),
            |context, faulty| lit_plane("hard", context, faulty),
        ),
        gate(
            about(
                "pcf",
                "P7.10 lit plane",
                "an unoccluded plane is lit at every slope",
                "no receiver-plane bias",
            ),
            |context, faulty| lit_plane("pcf", context, faulty),
        ),
    ]
}

fn settings(id: &str, width: u32) -> Result<Settings, SuiteError> {
    input::plain(id, "plain", width)
}

fn mean_of_steps(id: &str, context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for case in 0..context.cases {
        let mut rng = input::rng(context.seed, id, case);
        let map = input::map(&mut rng);
        let width = if id == "hard" { 1 } else { 2 * rng.random_range(0..5) + 1 };
        let s = Settings { plane_bias: false, ..settings(id, width)? };
        let receivers = input::receivers(&mut rng, &map, 60);
        let found = if faulty {
            faults::visibility(&map, &receivers, &s, Fault::WindowOffByOne)?
        } else {
            reference::visibility(&map, &receivers, &s)?
        };
        for (receiver, v) in receivers.iter().zip(found) {
            let expected = steps(&map, receiver, (width / 2).into(), s.bias);
            tally.within((v - expected).abs(), 1e-9, || format!("{width} texels at {receiver:?}"));
        }
    }
    Ok(tally)
}

/// Written without a line of the library's.
fn steps(map: &DepthMap, receiver: &Receiver, radius: i64, bias: f32) -> f64 {
    let texel = |c: f32, n: u32| i64::from(((c * n as f32).floor() as u32).min(n - 1));
    let (x, y) = (texel(receiver.u, map.width), texel(receiver.v, map.height));
    let z = receiver.z - bias;
    let (mut lit, mut all) = (0_u32, 0_u32);
    for j in y - radius..=y + radius {
        for i in x - radius..=x + radius {
            let i = i.clamp(0, i64::from(map.width) - 1) as usize;
            let j = j.clamp(0, i64::from(map.height) - 1) as usize;
            all += 1;
            lit += u32::from(map.depths[j * map.width as usize + i] >= z);
        }
    }
    f64::from(lit) / f64::from(all)
}

fn lit_plane(id: &str, context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for case in 0..context.cases {
        let mut rng = input::rng(context.seed, id, case);
        let (width, height) = (rng.random_range(16..64_u32), rng.random_range(16..64_u32));
        let (du, dv) = (rng.random_range(-0.45..0.45_f32), rng.random_range(-0.45..0.45_f32));
        let depth = |u: f32, v: f32| 0.5 + du * (u - 0.5) + dv * (v - 0.5);
        let depths = (0..width * height)
            .map(|i| {
                let (x, y) = ((i % width) as f32 + 0.5, (i / width) as f32 + 0.5);
                depth(x / width as f32, y / height as f32)
            })
            .collect();
        let map = DepthMap { width, height, depths };
        let kernel = 2 * rng.random_range(0..5) + 1;
        let s = Settings { plane_bias: !faulty, bias: 1e-4, ..settings(id, kernel)? };
        let receivers: Vec<Receiver> = (0..40)
            .map(|_| {
                let (u, v) = (rng.random_range(0.0..1.0), rng.random_range(0.0..1.0));
                Receiver::new(u, v, depth(u, v)).with_slope(du, dv)
            })
            .collect();
        for (receiver, v) in receivers.iter().zip(reference::visibility(&map, &receivers, &s)?) {
            tally.within(1.0 - v, 1e-12, || format!("slopes {du} {dv} at {receiver:?}"));
        }
    }
    Ok(tally)
}
