//! The processor's form and the shaders against the reference, receiver by receiver.

use super::input;
use crate::{
    SuiteError,
    problems::shadow_filtering::{SPEC, subject_gpu::filter_error, tolerance::Deviation},
    verify::{Gate, GateContext, Tally},
};
use dapple_gpu::Gpu;
use dapple_shadows::filtering::{
    DepthMap, Format, Receiver, Settings, cpu,
    faults::{self, Fault},
    gpu,
    reference::{self, Rounding},
};

/// Maps of one gate of the shaders: making the pipelines of one costs a tenth of a second and
/// more.
const MOST_MAPS: u32 = 6;
const RECEIVERS: usize = 200;

/// What the controls of the 32-bit gates multiply the middle weight of either axis by.
const LIGHT_WEIGHT: f64 = 0.999;

#[derive(Clone, Copy)]
enum Port {
    Cpu,
    Gpu,
}

#[derive(Clone, Copy)]
enum Formats {
    /// Every format: a share of the receivers may have met a tie in 16 bits.
    Any,
    /// Floats: every receiver within its bounds, but for four moments.
    F32,
}

pub fn gates() -> Vec<Gate> {
    let mut gates = Vec::new();
    for port in [Port::Cpu, Port::Gpu] {
        for technique in SPEC.techniques {
            gates.extend([Formats::Any, Formats::F32].map(|of| gate(technique.id, port, of)));
        }
    }
    gates
}

fn gate(id: &'static str, port: Port, formats: Formats) -> Gate {
    let (name, statement) = match (port, formats) {
        (Port::Cpu, Formats::Any) => (
            "P7.6 cpu port",
            "separable, parallel f32 windows give what brute-force f64 ones give, within what \
             rounding can do to each receiver",
        ),
        (Port::Cpu, Formats::F32) => (
            "P7.6 cpu port in f32",
            "in floats no receiver (half a percent with four moments) is outside what rounding can \
             do to it",
        ),
        (Port::Gpu, Formats::Any) => (
            "gpu port",
            "the shaders give what brute-force f64 windows give, within what rounding can do to \
             each receiver",
        ),
        (Port::Gpu, Formats::F32) => (
            "gpu port in f32",
            "in floats no receiver (half a percent with four moments) is outside what rounding can \
             do to it",
        ),
    };
    Gate {
        technique: id.into(),
        name: name.into(),
        statement,
        needs_gpu: matches!(port, Port::Gpu),
        run: Box::new(move |context| hold_port(id, context, port, formats, false)),
        fault: match formats {
            Formats::Any => "the window begins one texel early",
            Formats::F32 => "the middle weight of the kernel is 0.1 % too small",
        },
        control: Box::new(move |context| hold_port(id, context, port, formats, true)),
    }
}

/// One check a map, of a port or of a faulty reference in its place.
fn hold_port(
    id: &str,
    context: &GateContext<'_>,
    port: Port,
    formats: Formats,
    faulty: bool,
) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    let maps = match (port, faulty) {
        (Port::Gpu, false) => context.cases.min(MOST_MAPS),
        _ => context.cases,
    };
    for case in 0..maps {
        let mut rng = input::rng(context.seed, id, case);
        let (map, mut settings) = (input::map(&mut rng), input::settings_of(&mut rng, id)?);
        if matches!(formats, Formats::F32) {
            settings = settings.with_format(Format::F32);
        }
        let receivers = input::receivers(&mut rng, &map, RECEIVERS);
        let rounding = match port {
            Port::Cpu => Rounding::cpu(),
            Port::Gpu => Rounding::gpu(&settings),
        };
        let got = match (faulty, port, context.gpu) {
            (true, ..) => fault(&map, &receivers, &settings, formats)?,
            (false, Port::Cpu, _) => on_cpu(&map, &receivers, &settings)?,
            (false, Port::Gpu, Some(device)) => on_gpu(device, &map, &receivers, &settings)?,
            // Not called without a device; an empty tally fails the gate.
            (false, Port::Gpu, None) => return Ok(tally),
        };
        let expected = reference::expected(&map, &receivers, &settings, &rounding)?;
        let deviation = Deviation::between(&got, &expected);
        tally.check(deviation.allowed(&settings), || {
            let words = deviation.violation(&settings).unwrap_or_default();
            format!("{settings:?}: {words}")
        });
    }
    Ok(tally)
}

fn fault(
    map: &DepthMap,
    receivers: &[Receiver],
    settings: &Settings,
    formats: Formats,
) -> Result<Vec<f32>, SuiteError> {
    let wrong = match formats {
        Formats::Any => faults::visibility(map, receivers, settings, Fault::WindowOffByOne)?,
        Formats::F32 => {
            reference::visibility_one_weight_off(map, receivers, settings, LIGHT_WEIGHT)?
        }
    };
    Ok(wrong.into_iter().map(|v| v as f32).collect())
}

fn on_cpu(
    map: &DepthMap,
    receivers: &[Receiver],
    settings: &Settings,
) -> Result<Vec<f32>, SuiteError> {
    let mut filter = cpu::Filter::new(map.width, map.height, settings)?;
    let mut result = vec![0.0; receivers.len()];
    filter.prefilter(map)?;
    filter.shade(map, receivers, &mut result)?;
    Ok(result)
}

fn on_gpu(
    device: &Gpu,
    map: &DepthMap,
    receivers: &[Receiver],
    settings: &Settings,
) -> Result<Vec<f32>, SuiteError> {
    let filter = gpu::Filter::new(device, map.width, map.height, receivers, settings)
        .map_err(filter_error)?;
    filter.upload_depths(device, map).map_err(filter_error)?;
    let mut frame = device.frame();
    filter.record(&mut frame);
    frame.finish()?;
    Ok(filter.read(device)?)
}
