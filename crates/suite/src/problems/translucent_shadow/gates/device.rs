//! The graphics form's routes, storages and passes against each other.

use super::{
    About,
    device_input::{self as given, Mesh, SIZE, Shown, gate},
    input,
};
use crate::{
    SuiteError,
    verify::{Gate, GateContext, Tally},
};
use dapple_gpu::Gpu;
use dapple_opacity_maps::{
    Code, EndMap, Format, Layered, Packing, Receiver, Storage,
    gpu::Fault,
    layered::{bytes_per_texel, geometry_passes},
};

const ROUTES: [EndMap; 5] =
    [EndMap::MaxBlend, EndMap::Atomic, EndMap::Greater, EndMap::Swapped, EndMap::RangeFlip];

pub fn gates() -> Vec<Gate> {
    let about = |technique, name, statement, fault| About { technique, name, statement, fault };
    let mut gates = Vec::new();
    for id in ["osm", "dom", "bom"] {
        gates.push(gate(
            about(
                id,
                "P7 gpu packings",
                "packings change passes and bytes, which are those of the layout, and no bit of \
                 what is stored",
                "one layer more",
            ),
            move |gpu, context, faulty| packings(id, gpu, context, faulty),
        ));
        gates.push(gate(
            about(
                id,
                "gpu atomics",
                "fixed-point atomics give what blended floats give",
                "one layer more",
            ),
            move |gpu, context, faulty| atomics(id, gpu, context, faulty),
        ));
        gates.push(gate(
            about(
                id,
                "gpu same bits",
                "fixed-point atomics give the same bits in any order of drawing",
                "floats are blended",
            ),
            move |gpu, context, faulty| same_bits(id, gpu, context, faulty),
        ));
    }
    gates.push(gate(
        about(
            "bom",
            "row 23 end maps",
            "five routes to the last depth find that of the device's own fragments, mirrored ones \
             to a unit in the last place of 1",
            "the next texel's",
        ),
        end_maps,
    ));
    gates.push(gate(
        about(
            "bom",
            "row 42 depth test",
            "light behind sheets does not depend on the order in which they are drawn",
            "the opacity pass tests and writes depth",
        ),
        drawn_in_any_order,
    ));
    gates
}

/// Layers of a technique, a number that no texture is filled by.
fn layers(id: &str, rng: &mut rand_pcg::Pcg64, case: u32) -> Layered {
    let mut layered = input::layers_of(rng, id);
    layered.packing = Packing::Targets(8);
    layered.layers = [5, 16, 33][case as usize % 3];
    layered
}

fn frame(
    gpu: &Gpu,
    mesh: &Mesh,
    receivers: &[Receiver],
    layered: &Layered,
) -> Result<Shown, SuiteError> {
    let settings = input::plain(Code::Layered(layered.clone()));
    given::frame(gpu, &mesh.mesh, receivers, &settings, None).map_err(given::refused)
}

fn one_more(layered: &Layered, faulty: bool) -> Layered {
    Layered { layers: layered.layers + u32::from(faulty), ..layered.clone() }
}

fn packings(
    id: &str,
    gpu: &Gpu,
    context: &GateContext<'_>,
    faulty: bool,
) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    let case = (context.seed % 3) as u32;
    let mut rng = input::rng(context.seed, id, case);
    let mesh = Mesh::new(gpu, &mut rng)?;
    let receivers = input::receivers(&mut rng, 200);
    let all = layers(id, &mut rng, case);
    let first = frame(gpu, &mesh, &receivers, &all)?;
    for packing in [Packing::Targets(1), Packing::Single, Packing::Slabs] {
        let layered = Layered { packing, ..all.clone() };
        let other = frame(gpu, &mesh, &receivers, &one_more(&layered, faulty))?;
        let what = || format!("{layered:?}: {:?}", other.counters);
        let passes = geometry_passes(&layered);
        tally.check(other.counters.geometry_passes == passes, what);
        // The opaque map takes four bytes a texel besides.
        let bytes = u64::from(SIZE[0] * SIZE[1]) * (bytes_per_texel(&layered) + 4);
        tally.check(other.counters.map_bytes == bytes, what);
        if gpu.abilities.timestamps {
            tally.check(other.geometry_passes as u64 == passes, what);
        }
        if packing == Packing::Slabs {
            // Slabs are added up after they are read.
            for (a, b) in first.transmittances.iter().zip(&other.transmittances) {
                tally.within(f64::from((a - b).abs()), 1e-6, what);
            }
        } else {
            tally.check(first.maps == other.maps, what);
            tally.check(first.transmittances == other.transmittances, what);
        }
    }
    Ok(tally)
}

fn atomics(
    id: &str,
    gpu: &Gpu,
    context: &GateContext<'_>,
    faulty: bool,
) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for case in 0..context.cases.min(2) {
        let mut rng = input::rng(context.seed, id, case);
        let mesh = Mesh::new(gpu, &mut rng)?;
        let receivers = input::receivers(&mut rng, 200);
        let blended = layers(id, &mut rng, case);
        let atomic = Layered { storage: Storage::Atomic, format: Format::Fixed, ..blended.clone() };
        let a = frame(gpu, &mesh, &receivers, &blended)?;
        let b = frame(gpu, &mesh, &receivers, &one_more(&atomic, faulty))?;
        for (a, b) in a.transmittances.iter().zip(&b.transmittances) {
            let what = || format!("{blended:?}: {a}, by atomics {b}");
            tally.within(f64::from((a - b).abs()), 1e-5, what);
        }
    }
    Ok(tally)
}

fn same_bits(
    id: &str,
    gpu: &Gpu,
    context: &GateContext<'_>,
    faulty: bool,
) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for case in 0..context.cases.min(2) {
        let mut rng = input::rng(context.seed, id, case);
        let mesh = Mesh::new(gpu, &mut rng)?;
        let receivers = input::receivers(&mut rng, 100);
        let blended = layers(id, &mut rng, case);
        let layered = if faulty {
            blended
        } else {
            Layered { storage: Storage::Atomic, format: Format::Fixed, ..blended }
        };
        let turned = Mesh { mesh: given::reversed(&mesh.mesh), own: mesh.own.clone() };
        let first = frame(gpu, &mesh, &receivers, &layered)?;
        for mesh in [&mesh, &turned] {
            let again = frame(gpu, mesh, &receivers, &layered)?;
            let what = || format!("{layered:?}");
            tally.check(again.maps == first.maps, what);
            tally.check(again.transmittances == first.transmittances, what);
        }
    }
    Ok(tally)
}

fn end_maps(gpu: &Gpu, context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    let mut rng = input::rng(context.seed, "end maps", 0);
    let mesh = Mesh::new(gpu, &mut rng)?;
    let bounds_of = |texel: usize| {
        let depths = || mesh.own.texel(texel).iter().map(|f| f.depth);
        [depths().fold(1.0, f32::min), depths().fold(0.0, f32::max)]
    };
    let texels = mesh.own.texels();
    for end_map in ROUTES {
        let layered = Layered { end_map, ..layers("bom", &mut rng, 0) };
        let found = frame(gpu, &mesh, &[], &layered)?.bounds;
        tally.check(found.len() == texels, || format!("{end_map:?}: {} texels", found.len()));
        // A depth mirrored and back is off by half a unit in the last place of 1.
        let last = if given::is_mirrored(end_map) { 6e-8 } else { 0.0 };
        for (texel, found) in found.iter().enumerate() {
            let expected = bounds_of((texel + usize::from(faulty)) % texels);
            let what = || format!("{end_map:?}, texel {texel}: {found:?}, {expected:?}");
            let off = |end: usize| f64::from((found[end] - expected[end]).abs());
            tally.within(off(0), 0.0, what);
            tally.within(off(1), last, what);
        }
    }
    Ok(tally)
}

fn drawn_in_any_order(
    gpu: &Gpu,
    context: &GateContext<'_>,
    faulty: bool,
) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    let mut rng = input::rng(context.seed, "any order", 0);
    let alphas = [0.3_f32, 0.5, 0.1, 0.69, 0.2];
    let sheets = given::sheets(&alphas);
    let receivers = [Receiver::at(0.5, 0.5, 0.95)];
    let expected: f64 =
        alphas.iter().map(|a| -given::MODEL.omega(f64::from(*a))).sum::<f64>().exp();
    let settings = input::plain(Code::Layered(layers("bom", &mut rng, 0)));
    let fault = faulty.then_some(Fault::DepthTested);
    for mesh in [&sheets, &given::reversed(&sheets)] {
        let shown =
            given::frame(gpu, mesh, &receivers, &settings, fault).map_err(given::refused)?;
        let t = f64::from(shown.transmittances[0]);
        tally.within((t - expected).abs(), 1e-5, || format!("{t}, product {expected}"));
    }
    Ok(tally)
}
