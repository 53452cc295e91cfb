//! The shaders against the references, on what the device itself rasterises.

use super::super::subject_cascades::refused as cascades_refused;
use super::{
    About, cascades,
    device_input::{self as given, Mesh, Shown, gate, is_mirrored},
    device_search, input, shared,
};
use crate::{
    SuiteError,
    problem::{Form, Technique},
    problems::translucent_shadow::SPEC,
    verify::{Gate, GateContext, Tally},
};
use dapple_gpu::Gpu;
use dapple_opacity_maps::{
    Blend, Blur, Code, EndMap, Format, Receiver, Settings, gpu::OpacityGpuError,
    reference::Reference,
};
use dapple_shadows::cascades::{CascadeReceiver, gpu::Shadows, reference};

/// Maps of one gate: making the pipelines of one costs a tenth of a second.
const MOST_MAPS: u32 = 3;

/// Draws of settings, some of which have no graphics form.
const DRAWS: u32 = 100;

pub fn gates() -> Vec<Gate> {
    let about = |technique, name, statement, fault| About { technique, name, statement, fault };
    let texels = |t: &&Technique| shared::has_texels(t);
    let mut gates = Vec::new();
    for technique in SPEC.techniques.iter().filter(texels) {
        let id = technique.id;
        // A search has a renderer of its own.
        if technique.forms.contains(&Form::Gpu) && id != device_search::ID {
            gates.push(gate(
                about(
                    id,
                    "gpu port",
                    "on the fragments that the device rasterises, its shaders lie within what \
                     rounding can do to the f64 reference",
                    "receivers are read 0.2 too deep; without a map, the nearest hides all",
                ),
                move |gpu, context, faulty| port(id, gpu, context, faulty),
            ));
        }
    }
    gates.push(gate(
        about(
            cascades::ID,
            "gpu port",
            "on the maps that the device rasterises, its shader lies within what rounding can do \
             to the f64 reference",
            "receivers are a cascade farther away",
        ),
        cascade_port,
    ));
    gates
}

/// How far shaders may lie outside of the reference's interval.
fn bound(settings: &Settings, mesh: &Mesh) -> f64 {
    let floats = 6e-6 + shared::port_bound(settings, &mesh.own);
    let most = (0..mesh.own.texels()).map(|t| mesh.own.texel(t).len()).max().unwrap_or(0);
    // Every addition is rounded, to 11 binary digits of a half (Ω e^-Ω <= 1 / e) or to a byte.
    let (halves, bytes) = (most as f64 / 1024.0 / std::f64::consts::E, most as f64 / 255.0);
    match &settings.code {
        Code::Layered(layered) => match layered.format {
            Format::F32 if layered.blend == Blend::Over => 1e-4 + floats,
            Format::F32 | Format::Fixed => floats,
            Format::F16 => halves + floats,
            Format::Unorm8 | Format::Unorm8Scaled => bytes + floats,
        },
        // Devices round a half after every addition, in the order things are drawn.
        Code::Fourier(f) if f.format == Format::F16 => 0.05 + floats,
        Code::Moments(m) if m.format == Format::F16 => 0.05 + floats,
        _ => floats,
    }
}

/// Random settings that have a graphics form, and what a frame of them gives.
fn shown(
    id: &str,
    gpu: &Gpu,
    rng: &mut rand_pcg::Pcg64,
    mesh: &Mesh,
    receivers: &[Receiver],
    faulty: bool,
) -> Result<(Settings, Shown), SuiteError> {
    for _ in 0..DRAWS {
        // The order of drawing is not that of the sorted fragments.
        let mut settings = input::sound(input::settings_in(rng, id, Form::Gpu)?);
        // A mirrored depth is off by 2^-24: its own gate judges that, and flat rays magnify it.
        if let Code::Layered(layered) = &mut settings.code {
            if is_mirrored(layered.end_map) {
                layered.end_map = EndMap::Greater;
            }
            // Devices may interpolate for a lone texture of bytes by another path, a unit in the
            // last place away: where a ray's fragments share one depth, its own receivers do not
            // see it, but receivers at another texel's layer do.
            if matches!(layered.format, Format::Unorm8 | Format::Unorm8Scaled) {
                settings.blur = Blur::Transmittance;
            }
        }
        let drawn = if faulty { shared::without_none(&settings) } else { settings.clone() };
        match given::frame(gpu, &mesh.mesh, receivers, &drawn, None) {
            Ok(shown) => return Ok((settings, shown)),
            Err(OpacityGpuError::NoForm { .. } | OpacityGpuError::Opacity(_)) => {}
            Err(error) => return Err(given::refused(error)),
        }
    }
    Err(SuiteError::Usage(format!("no settings of {id} have a graphics form")))
}

fn port(id: &str, gpu: &Gpu, context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for case in 0..context.cases.min(MOST_MAPS) {
        let mut rng = input::rng(context.seed, id, case);
        let mesh = Mesh::new(gpu, &mut rng)?;
        let receivers = input::receivers(&mut rng, 200);
        let deeper = if faulty { 0.2 } else { 0.0 };
        let read: Vec<Receiver> =
            receivers.iter().map(|r| Receiver { depth: r.depth + deeper, ..*r }).collect();
        let (settings, shown) = shown(id, gpu, &mut rng, &mesh, &read, faulty)?;
        let reference = Reference::new(&settings, &mesh.own)?;
        let bound = bound(&settings, &mesh);
        for (receiver, t) in receivers.iter().zip(&shown.transmittances) {
            let (least, greatest) = reference.interval(receiver);
            let t = f64::from(*t);
            tally.check((0.0..=1.0).contains(&t), || format!("{settings:?}: {t}"));
            tally.within((least - t).max(t - greatest), bound, || {
                format!("{settings:?} at {receiver:?}: {t}, expected {least}..={greatest}")
            });
        }
    }
    Ok(tally)
}

fn cascade_port(gpu: &Gpu, context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for case in 0..context.cases.min(MOST_MAPS) {
        let mut rng = input::rng(context.seed, "pssm gpu port", case);
        let mesh = given::mesh(&mut rng);
        let cascades::Shaded { cascades, receivers, settings, .. } = cascades::shaded(&mut rng);
        let farther = if faulty { 1.0 } else { 0.0 };
        let read: Vec<CascadeReceiver> = receivers
            .iter()
            .map(|r| CascadeReceiver { view_depth: r.view_depth + farther, ..*r })
            .collect();
        let side = cascades::SIDE;
        let shadows = Shadows::new(gpu, &mesh, &cascades, side, &read, &settings)
            .map_err(cascades_refused)?;
        let mut frame = gpu.frame();
        shadows.record(&mut frame);
        frame.finish()?;
        let (maps, found) = (shadows.read_maps(gpu)?, shadows.read(gpu)?);
        let bounds = reference::port_bounds(&maps, &cascades, &receivers, &settings)?;
        for ((v, (least, greatest)), receiver) in found.iter().zip(bounds).zip(&receivers) {
            let v = f64::from(*v);
            tally.within((least - v).max(v - greatest), 1e-6, || {
                format!("{settings:?} at {receiver:?}: {v}, expected {least}..={greatest}")
            });
        }
    }
    Ok(tally)
}
