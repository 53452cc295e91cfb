//! Packings, blend states and formats: what is stored, whoever adds it and however it is spread.

use super::{About, gate, input};
use crate::{
    SuiteError,
    verify::{Gate, GateContext, Tally},
};
use dapple_opacity_maps::{
    Blend, Code, Format, Fragment, Fragments, Layered, Layout, Model, Packing, Slicing,
    cpu::Maps,
    faults::Fault,
    layered::{
        bytes_per_texel,
        unit::{SCALE, Unit},
    },
};
use rand::RngExt;

/// Planes that four channels make one texture of.
const LAYERS: u32 = 8;

pub fn gates() -> Vec<Gate> {
    let about = |technique, name, statement, fault| About { technique, name, statement, fault };
    let mut gates = Vec::new();
    for id in ["osm", "dom", "bom"] {
        gates.push(gate(
            about(
                id,
                "P7 packings",
                "one map a texture, slabs, targets and sorted fragments give the same, to the bit \
                 in fixed point",
                "the printed masks in one of them",
            ),
            move |context, faulty| packings(id, context, faulty),
        ));
    }
    let osm = |name, statement, fault| about("osm", name, statement, fault);
    gates.extend([
        gate(
            osm(
                "row 8 room",
                "four layers a texture take a quarter of the room of one",
                "the maps of one more texture",
            ),
            room,
        ),
        gate(
            osm(
                "row 12 alpha",
                "in the states of colour and alpha the alpha channel holds 1 - Π(1 - α), as \
                 channel by channel",
                "the red channel, which is darkened by what is not in its layer",
            ),
            alpha_channel,
        ),
        gate(
            osm(
                "row 13 channels",
                "what lies in a later layer leaves earlier maps alone, added or multiplied",
                "a state of colour and alpha",
            ),
            independent,
        ),
        gate(
            osm(
                "P14 product",
                "multiplied channel by channel, light is Π(1 - α) in any order, in bytes within \
                 half a step a surface, and at most e to the minus Σα",
                "opacities are added, not multiplied",
            ),
            product,
        ),
        gate(
            osm(
                "row 15 scaled bytes",
                "bytes of 8 ln 2 do not saturate before T falls below 1/256",
                "bytes of 1",
            ),
            scaled_bytes,
        ),
        gate(
            osm(
                "fixed point",
                "12.20 bits add up small opacities without end, to 4096",
                "half floats, which stall",
            ),
            fixed_point,
        ),
    ]);
    gates
}

fn build(
    layered: &Layered,
    fragments: &Fragments,
    fault: Option<Fault>,
) -> Result<Maps, SuiteError> {
    let settings = input::plain(Code::Layered(layered.clone()));
    settings.check()?;
    match fault.and_then(|fault| fault.code(&settings)) {
        None => input::build(&settings, fragments),
        Some(code) => input::build_with(&settings, fragments, code),
    }
}

fn packings(id: &str, context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    let fault = faulty.then_some(Fault::Listing);
    let all = [Packing::Single, Packing::Slabs, Packing::Targets(1), Packing::Targets(8)];
    for case in 0..context.cases {
        let mut rng = input::rng(context.seed, id, case);
        // Thin enough that no product reaches the largest opacity that is decoded.
        let thin = |f: Fragment| Fragment { omega: 0.2 * f.omega, ..f };
        let fragments = input::mapped(&input::fragments(&mut rng), thin);
        let receivers = input::receivers(&mut rng, 12);
        let layered = input::layers_of(&mut rng, id);
        for (format, blend) in
            [(Format::F32, Blend::Add), (Format::F32, Blend::Over), (Format::Fixed, Blend::Add)]
        {
            let of = |packing, fault| {
                build(&Layered { packing, format, blend, ..layered.clone() }, &fragments, fault)
            };
            let sorted = of(Packing::Sorted, None)?;
            for packing in all {
                let maps = of(packing, fault)?;
                for receiver in &receivers {
                    let [a, b] = [&sorted, &maps].map(|m| f64::from(m.transmittance(receiver)));
                    // Slabs are added up after they are read; floats round in another order.
                    let bound = match (format, packing) {
                        (Format::Fixed, Packing::Slabs) => 1e-6,
                        (Format::Fixed, _) => 0.0,
                        _ => 2e-5,
                    };
                    tally.within((a - b).abs(), bound, || {
                        format!("{layered:?} {packing:?} {format:?} {blend:?}: {a} {b}")
                    });
                }
            }
        }
    }
    Ok(tally)
}

fn room(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for case in 0..context.cases {
        let mut rng = input::rng(context.seed, "room", case);
        let layers = 4 * rng.random_range(1..=64_u32);
        let one = input::layered(Layout::Planes(Slicing::Uniform), layers);
        let bytes = |packing, layers| bytes_per_texel(&Layered { packing, layers, ..one.clone() });
        let single = bytes(Packing::Single, layers);
        for packing in [Packing::Slabs, Packing::Targets(8)] {
            let packed = bytes(packing, if faulty { layers + 1 } else { layers });
            let what = || format!("{layers} layers: {single} and {packed} bytes");
            tally.check(packed == 4 * u64::from(layers) && single == 4 * packed, what);
        }
    }
    Ok(tally)
}

/// Eight even planes in textures of four channels.
fn textures(blend: Blend, format: Format) -> Layered {
    let packing = Packing::Targets(2);
    let even = input::layered(Layout::Planes(Slicing::Uniform), LAYERS);
    Layered { blend, format, packing, ..even }
}

fn alpha_channel(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for case in 0..context.cases {
        let mut rng = input::rng(context.seed, "alpha", case);
        let fragments = input::fragments(&mut rng);
        let channel = if faulty { 0 } else { 3 };
        let over = textures(Blend::Over, Format::F32);
        let right = build(&over, &fragments, None)?;
        for blend in [Blend::Alpha, Blend::Premultiplied] {
            let maps = build(&textures(blend, Format::F32), &fragments, None)?;
            for texel in 0..fragments.texels() {
                for texture in 0..2 {
                    let at = |maps| input::sums(maps, &over, texel)[4 * texture + channel];
                    let (a, b) = (at(&right), at(&maps));
                    tally.check(a == b, || format!("{blend:?}: {b}, each by itself {a}"));
                }
            }
        }
    }
    Ok(tally)
}

fn independent(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for case in 0..context.cases {
        let mut rng = input::rng(context.seed, "channels", case);
        let format = [Format::F32, Format::F16, Format::Unorm8][rng.random_range(0..3_usize)];
        let blend = match (faulty, case % 2) {
            (false, 0) => Blend::Add,
            (false, _) => Blend::Over,
            (true, 0) => Blend::Alpha,
            (true, _) => Blend::Premultiplied,
        };
        // Planes from 0 to 1; what is added lies in front of the last.
        let mut all = vec![(0.0, 0.3), (0.4, 0.5), (0.2, 0.25), (1.0, 0.1)];
        all.push((0.85, rng.random_range(0.2..1.0)));
        let layered = textures(blend, format);
        let with = build(&layered, &input::map(1, &[all.clone()]), None)?;
        all.pop();
        let without = build(&layered, &input::map(1, &[all]), None)?;
        let later = (0.85 * f64::from(LAYERS)) as usize;
        let [a, b] = [&without, &with].map(|maps| &input::sums(maps, &layered, 0)[..later]);
        tally.check(a == b, || format!("{blend:?} {format:?}: {a:?}, then {b:?}"));
    }
    Ok(tally)
}

fn product(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for case in 0..context.cases {
        let mut rng = input::rng(context.seed, "product", case);
        let count = rng.random_range(1..30_usize);
        let alphas: Vec<f64> = (0..count).map(|_| rng.random_range(0.0..0.6)).collect();
        let texel = |model: Model| {
            let one = |(i, a): (usize, &f64)| (0.2 + 0.01 * i as f32, model.omega(*a) as f32);
            input::map(1, &[alphas.iter().enumerate().map(one).collect()])
        };
        let model = if faulty { Model::ExpAlpha } else { Model::ExpTau };
        let fragments = texel(model);
        let turned = input::shuffled(&mut rng, &fragments);
        let blend = if faulty { Blend::Add } else { Blend::Over };
        let end = |blend, format, fragments: &Fragments| {
            let maps = build(&Layered { blend, ..textures(blend, format) }, fragments, None)?;
            Ok::<_, SuiteError>(input::at(&maps, 0, 9.0))
        };
        let exact: f64 = alphas.iter().map(|a| 1.0 - a).product();
        // The largest opacity that is decoded is 1 - 2^-10.
        let exact = exact.max(1.0 - Model::MOST_OPACITY);
        let what = || format!("{alphas:?}");
        let float = end(blend, Format::F32, &fragments)?;
        tally.within((float - exact).abs(), 1e-5, what);
        tally.within((end(blend, Format::F32, &turned)? - exact).abs(), 1e-5, what);
        let steps = 0.5 * count as f64 / 255.0 + 1e-3;
        tally.within((end(blend, Format::Unorm8, &fragments)? - exact).abs(), steps, what);
        let added = end(Blend::Add, Format::F32, &texel(Model::ExpAlpha))?;
        tally.within(exact - added.max(1.0 - Model::MOST_OPACITY), 1e-6, what);
    }
    Ok(tally)
}

fn scaled_bytes(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    let format = if faulty { Format::Unorm8 } else { Format::Unorm8Scaled };
    for case in 0..context.cases {
        let mut rng = input::rng(context.seed, "bytes", case);
        let omega = rng.random_range(0.1..1.2_f32);
        let unit = Unit { blend: Blend::Add, format };
        let (mut raw, mut sum, mut count) = (0.0, 0.0, 0.0);
        loop {
            (raw, sum, count) = (unit.step(raw, omega), sum + f64::from(omega), count + 1.0);
            if sum >= SCALE {
                break;
            }
            let found = unit.thickness(f64::from(unit.word(raw)));
            let bound = count * SCALE / 510.0 + 1e-6;
            tally.within((found - sum).abs(), bound, || format!("{count} of {omega}: {found}"));
        }
    }
    Ok(tally)
}

fn fixed_point(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    let unit = Unit { blend: Blend::Add, format: if faulty { Format::F16 } else { Format::Fixed } };
    for case in 0..context.cases {
        let mut rng = input::rng(context.seed, "fixed", case);
        let (omega, count) = (rng.random_range(1e-3..2.0_f32), rng.random_range(1..10_000_u32));
        let raw = (0..count).fold(0.0, |raw, _| unit.step(raw, omega));
        let found = unit.thickness(f64::from(unit.word(raw)));
        let expected = (f64::from(omega) * f64::from(count)).min(4096.0);
        // Half a step a fragment, and the word's own rounding.
        let bound = f64::from(count) * 2f64.powi(-21) + 3e-4;
        let what = || format!("{count} of {omega}: {found}, expected {expected}");
        tally.within((found - expected).abs(), bound, what);
    }
    Ok(tally)
}
