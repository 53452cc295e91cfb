//! Layers: one of them is the plain technique.

use super::{About, gate, input};
use crate::{
    SuiteError,
    verify::{Gate, GateContext, Tally},
};
use dapple_shadows::filtering::{Settings, reference};

pub fn gates() -> Vec<Gate> {
    [
        ("lvsm", "vsm", "min-variance"),
        ("layered-gaussian", "gaussian-cdf", "plain"),
        ("layered-power", "power-cdf", "plain"),
    ]
    .into_iter()
    .map(|(technique, plain, variant)| {
        gate(
            About {
                technique,
                name: "P7.12 one layer",
                statement: "one layer is the technique without layers",
                fault: "two layers",
            },
            move |context, faulty| one_layer(technique, plain, variant, context, faulty),
        )
    })
    .collect()
}

fn one_layer(
    technique: &str,
    plain: &str,
    variant: &str,
    context: &GateContext<'_>,
    faulty: bool,
) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    let layers = if faulty { 2 } else { 1 };
    for case in 0..context.cases {
        let mut rng = input::rng(context.seed, technique, case);
        let map = input::map(&mut rng);
        let receivers = input::receivers(&mut rng, &map, 60);
        let splits = if case % 2 == 0 { "uniform" } else { "lloyd" };
        let layered = Settings { layers, ..input::plain(technique, splits, 5)? };
        let single = input::plain(plain, variant, 5)?;
        let found = reference::visibility(&map, &receivers, &layered)?;
        let expected = reference::visibility(&map, &receivers, &single)?;
        for ((a, b), receiver) in found.iter().zip(expected).zip(&receivers) {
            tally.within((a - b).abs(), 1e-9, || format!("{splits} at {receiver:?}"));
        }
    }
    Ok(tally)
}
