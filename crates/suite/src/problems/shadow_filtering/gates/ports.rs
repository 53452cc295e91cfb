//! The shaders against the reference.

use super::{input, maps};
use crate::{
    SuiteError,
    problems::shadow_filtering::{SPEC, subject_gpu::filter_error},
    verify::{Gate, GateContext, Tally},
};
use dapple_shadows::filtering::{
    faults::{self, Fault},
    gpu, reference,
};

/// Maps of one gate: making the pipelines of one costs a tenth of a second and more.
const MOST_MAPS: u32 = 6;
const RECEIVERS: usize = 400;

pub fn gates() -> Vec<Gate> {
    let gate = |id: &'static str| Gate {
        technique: id.into(),
        name: "gpu port".into(),
        statement: "the shaders give what brute-force f64 windows give",
        needs_gpu: true,
        run: Box::new(move |context| gpu_port(id, context, false)),
        fault: "the reference's window begins one texel early",
        control: Box::new(move |context| gpu_port(id, context, true)),
    };
    SPEC.techniques.iter().map(|t| gate(t.id)).collect()
}

fn gpu_port(id: &str, context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    // Not called without a device; an empty tally fails the gate.
    let Some(device) = context.gpu else { return Ok(tally) };
    for case in 0..context.cases.min(MOST_MAPS) {
        let mut rng = input::rng(context.seed, id, case);
        let (map, settings) = (input::map(&mut rng), input::settings_of(&mut rng, id)?);
        let receivers = input::receivers(&mut rng, &map, RECEIVERS);
        let filter = gpu::Filter::new(device, map.width, map.height, &receivers, &settings)
            .map_err(filter_error)?;
        filter.upload_depths(device, &map).map_err(filter_error)?;
        let mut frame = device.frame();
        filter.record(&mut frame);
        frame.finish()?;
        let port = filter.read(device)?;
        let expected = if faulty {
            faults::visibility(&map, &receivers, &settings, Fault::WindowOffByOne)?
        } else {
            reference::visibility(&map, &receivers, &settings)?
        };
        maps::hold(&mut tally, &port, &expected, &settings);
    }
    Ok(tally)
}
