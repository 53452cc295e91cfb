//! Parallel-split shadow maps: where the view is cut, which cascade a depth is in, its region, and
//! the processor's form.

use super::{About, gate, input};
use crate::{
    SuiteError,
    verify::{Gate, GateContext, Tally},
};
use dapple_shadows::{
    cascades::{
        Cascade, CascadeReceiver, CasterBox, Fit, Settings, Taps,
        cpu::Shadows,
        faults::{self, Fault},
        fit,
        lookup::{Region, select},
        reference, splits,
    },
    filtering::DepthMap,
};
use rand::RngExt;
use rand_pcg::Pcg64;

/// The technique that these are of.
pub const ID: &str = "pssm";

/// Side of a cascade's map, texels.
pub const SIDE: u32 = 24;

pub fn gates() -> Vec<Gate> {
    let about = |name, statement, fault| About { technique: ID, name, statement, fault };
    vec![
        gate(
            about(
                "P1 splits",
                "depths go strictly from near to far, mix even distances and even ratios as \
                 written, and are either of them to the bit at the ends of lambda",
                "lambda is 1 - lambda",
            ),
            cuts,
        ),
        gate(
            about(
                "row 3 one cascade",
                "every view depth has exactly one cascade: the slice it lies in, the first or last \
                 beyond both ends",
                "the next cascade",
            ),
            one_cascade,
        ),
        gate(
            about(
                "P16 region",
                "a region's longer side spans the overlap of slice and casters exactly, its shorter \
                 is in the middle",
                "the region begins one texel early",
            ),
            region,
        ),
        gate(
            about(
                "P4 range",
                "every visibility is within 0..=1, and 1 outside its cascade and of what is no \
                 receiver",
                "the weights of the taps add up to 1.001",
            ),
            range,
        ),
        gate(
            about(
                "cpu port",
                "the processor's form lies within what rounding can do to the f64 reference",
                "the next cascade's map is read",
            ),
            |context, faulty| port(context, faulty.then_some(Fault::NextCascade)),
        ),
        gate(
            about(
                "cpu port of crops",
                "the processor's form lies within what rounding can do to the f64 reference",
                "the region lies one texel to the left of its map",
            ),
            |context, faulty| port(context, faulty.then_some(Fault::CropOneTexel)),
        ),
    ]
}

/// Near, far, number of slices and lambda.
fn knobs(rng: &mut Pcg64) -> (f64, f64, usize, f64) {
    let near = 10_f64.powf(rng.random_range(-3.0..3.0));
    let far = near * 10_f64.powf(rng.random_range(0.1..5.0));
    let lambda = [0.0, 1.0, rng.random_range(0.0..1.0)][rng.random_range(0..3_usize)];
    (near, far, rng.random_range(1..=8), lambda)
}

fn cuts(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for case in 0..context.cases {
        let (near, far, count, lambda) = knobs(&mut input::rng(context.seed, "splits", case));
        let given = if faulty { 1.0 - lambda } else { lambda };
        let depths = splits(near, far, count, given)?;
        let what = || format!("{near}..{far} in {count}, lambda {lambda}: {depths:?}");
        let ends = depths.first() == Some(&near) && depths.last() == Some(&far);
        tally.check(ends && depths.len() == count + 1, what);
        tally.check(depths.windows(2).all(|w| w[0] < w[1]), what);
        for (i, depth) in depths.iter().enumerate().take(count).skip(1) {
            let share = i as f64 / count as f64;
            let even = near + (far - near) * share;
            let ratio = near * (far / near).powf(share);
            let expected = lambda * ratio + (1.0 - lambda) * even;
            tally.within((depth / expected - 1.0).abs(), 1e-12, what);
            if lambda == 0.0 {
                tally.check(depth.to_bits() == even.to_bits(), what);
            }
        }
    }
    Ok(tally)
}

/// Cascades that each cover the whole map.
fn whole(rng: &mut Pcg64) -> Result<Vec<Cascade>, SuiteError> {
    let (near, far, count, lambda) = knobs(rng);
    let depths = splits(near, far, count, lambda)?;
    Ok(depths.windows(2).map(|w| Cascade::whole(w[0], w[1])).collect())
}

fn one_cascade(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for case in 0..context.cases {
        let mut rng = input::rng(context.seed, "one cascade", case);
        let cascades = whole(&mut rng)?;
        let regions: Vec<Region> = cascades.iter().map(|c| Region::new(c, SIDE)).collect();
        let last = cascades.len() - 1;
        let reach = cascades[last].far as f32;
        let mut depths: Vec<f32> = cascades.iter().map(|c| c.far as f32).collect();
        depths.extend((0..20).map(|_| reach * rng.random_range(-0.1..1.2_f32)));
        for depth in depths {
            let far = |i: usize| cascades[i].far as f32;
            let holds = |i: usize| (i == 0 || depth > far(i - 1)) && (i == last || depth <= far(i));
            let holding: Vec<usize> = (0..cascades.len()).filter(|i| holds(*i)).collect();
            let found = (select(&regions, depth) + usize::from(faulty)) % cascades.len();
            tally.check(holding == [found], || format!("{depth} in {found} of {cascades:?}"));
        }
    }
    Ok(tally)
}

fn region(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for case in 0..context.cases {
        let mut rng = input::rng(context.seed, "region", case);
        let mut range = || {
            let from: f64 = rng.random_range(0.0..0.8);
            [from, rng.random_range(from + 0.05..1.0)]
        };
        // Every third time casters and slice are the whole map: the crop is the identity.
        let full = case % 3 == 0;
        let [u, v] = [range(), range()].map(|r| if full { [0.0, 1.0] } else { r });
        let corners = std::array::from_fn(|i| [u[i & 1], v[i >> 1 & 1]]);
        let how = Fit { side: SIDE, margin_texels: 0 };
        let cascades = fit(&[1.0, 2.0], &[corners], &CasterBox::WHOLE, how)?;
        let mut cascade = cascades[0];
        if faulty {
            cascade.offset[0] -= cascade.scale / f64::from(SIDE);
        }
        let least = cascade.local([u[0], v[0]]);
        let most = cascade.local([u[1], v[1]]);
        let longer = usize::from(v[1] - v[0] > u[1] - u[0]);
        let what = || format!("{u:?} {v:?}: {cascade:?}");
        tally.within(least[longer].abs(), 1e-12, what);
        tally.within((most[longer] - 1.0).abs(), 1e-12, what);
        let shorter = 1 - longer;
        tally.within((least[shorter] + most[shorter] - 1.0).abs(), 1e-12, what);
        if full {
            tally.check(cascade.offset == [0.0; 2] && cascade.scale == 1.0, what);
        }
    }
    Ok(tally)
}

/// Cascades, their maps of noise, receivers of all kinds, and settings.
pub struct Shaded {
    /// Slices a unit deep.
    pub cascades: Vec<Cascade>,
    maps: Vec<DepthMap>,
    /// In and around all of them.
    pub receivers: Vec<CascadeReceiver>,
    /// Random taps and bias.
    pub settings: Settings,
}

/// Random ones of a case.
pub fn shaded(rng: &mut Pcg64) -> Shaded {
    let count = rng.random_range(2..=4_usize);
    let mut cascades = Vec::new();
    for i in 0..count {
        let scale = rng.random_range(0.2..0.9);
        let offset = [rng.random_range(-0.1..0.5), rng.random_range(-0.1..0.5)];
        cascades.push(Cascade { near: i as f64, far: i as f64 + 1.0, offset, scale });
    }
    let texels = (SIDE * SIDE) as usize;
    let map = |rng: &mut Pcg64| DepthMap {
        width: SIDE,
        height: SIDE,
        depths: (0..texels).map(|_| rng.random_range(0.0..1.0_f32)).collect(),
    };
    let maps = (0..count).map(|_| map(rng)).collect();
    let mut any = |least: f32, most: f32| rng.random_range(least..most);
    let receivers = (0..60)
        .map(|_| {
            let view_depth = any(-0.5, count as f32 + 0.5);
            CascadeReceiver::at(any(-0.1, 1.1), any(-0.1, 1.1), any(0.0, 1.0), view_depth)
                .with_slope(any(-0.3, 0.3), any(-0.3, 0.3))
        })
        .collect();
    let taps = Taps::ALL[rng.random_range(0..3_usize)];
    let plane_bias = rng.random_range(0..2) == 0;
    let settings = Settings { plane_bias, ..Settings::new(taps) };
    Shaded { cascades, maps, receivers, settings }
}

fn on_processor(input: &Shaded) -> Result<Vec<f32>, SuiteError> {
    let mut found = vec![0.0; input.receivers.len()];
    let shadows = Shadows::new(SIDE, &input.cascades, &input.settings)?;
    shadows.shade(&input.maps, &input.receivers, &mut found)?;
    Ok(found)
}

fn range(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    let weights = if faulty { 1.001 } else { 1.0 };
    for case in 0..context.cases {
        let mut input = shaded(&mut input::rng(context.seed, "pssm range", case));
        let inside = input.receivers.len();
        let one = input.receivers[0];
        for bad in [f32::NAN, f32::INFINITY, -9.0] {
            input.receivers.push(CascadeReceiver { u: bad, ..one });
            input.receivers.push(CascadeReceiver { depth: bad, ..one });
        }
        input.receivers.push(CascadeReceiver { flags: 0, depth: 0.99, ..one });
        for (i, v) in on_processor(&input)?.iter().map(|v| weights * v).enumerate() {
            let right = if i < inside { (0.0..=1.0).contains(&v) } else { v == 1.0 };
            tally.check(right, || format!("{:?} gives {v}", input.receivers[i]));
        }
    }
    Ok(tally)
}

fn port(context: &GateContext<'_>, fault: Option<Fault>) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for case in 0..context.cases {
        let input = shaded(&mut input::rng(context.seed, "pssm port", case));
        let Shaded { cascades, maps, receivers, settings } = &input;
        let bounds = reference::port_bounds(maps, cascades, receivers, settings)?;
        let found: Vec<f64> = match fault {
            None => on_processor(&input)?.into_iter().map(f64::from).collect(),
            Some(fault) => faults::visibility(maps, cascades, receivers, settings, fault)?,
        };
        for ((v, (least, greatest)), receiver) in found.iter().zip(bounds).zip(receivers) {
            tally.within((least - v).max(v - greatest), 1e-6, || {
                format!("{settings:?} at {receiver:?}: {v}, expected {least}..={greatest}")
            });
        }
    }
    Ok(tally)
}
