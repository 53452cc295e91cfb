//! The values one steps a knob through: a short grid of round numbers, for searches and people.

use super::{Knob, Range};
use serde_json::Value;

/// Values on a grid at most, ends and default among them.
const MOST: usize = 9;

/// Decades below the greatest value where a logarithmic grid starts that has no least one.
const DECADES: i32 = 6;

impl Knob {
    /// The values one steps the knob through, ascending: the default, both useful ends, and round
    /// numbers between them, even or even in the logarithm, at most nine. Choices all, in the order
    /// declared.
    pub fn steps(&self) -> Vec<Value> {
        match self.range {
            Range::Choice(words) => words.iter().map(|word| Value::from(*word)).collect(),
            Range::Int { min, max, default } => {
                let ends = self.useful.map_or([min as f64, max as f64], |[a, b]| [a, b]);
                let grid = match self.logarithmic {
                    true => finest(ends, default as f64, &|n| powers(ends, default as f64, n)),
                    // Steps below 10^0 would give the same integer twice.
                    false => finest(ends, default as f64, &|n| multiples(ends, n, 0)),
                };
                grid.into_iter().map(|x| Value::from(x as i64)).collect()
            }
            Range::Float { min, max, default } => {
                let ends = self.useful.unwrap_or([min, max]);
                let grid = match self.logarithmic {
                    true => finest(ends, default, &|n| decades(ends, n)),
                    false => finest(ends, default, &|n| multiples(ends, n, -300)),
                };
                grid.into_iter().map(Value::from).collect()
            }
        }
    }
}

/// The finest of ever coarser grids that, with ends and default, has no more than [`MOST`] values.
fn finest(
    [least, greatest]: [f64; 2],
    default: f64,
    grid: &dyn Fn(u32) -> Option<Vec<f64>>,
) -> Vec<f64> {
    let with_ends = |mut values: Vec<f64>| {
        values.retain(|v| (least..=greatest).contains(v));
        values.extend([least, greatest, default]);
        values.sort_by(f64::total_cmp);
        values.dedup();
        values
    };
    let grids = (0..).map_while(grid).map(with_ends);
    grids.into_iter().find(|g| g.len() <= MOST).unwrap_or_else(|| with_ends(Vec::new()))
}

/// Integers that differ by factors of 2, 4, 8, ... from the default, or from the least value where
/// the default is 0.
fn powers([least, greatest]: [f64; 2], default: f64, coarseness: u32) -> Option<Vec<f64>> {
    let factor = 2f64.powi(coarseness as i32 + 1);
    let from = if default > 0.0 { default } else { least.max(1.0) };
    let down =
        std::iter::successors(Some(from), |v| Some((v / factor).floor()).filter(|v| *v > 0.0));
    let up = std::iter::successors(Some(from), |v| Some(v * factor));
    // A factor as large as the range adds nothing: the end of the coarser grids.
    let more = factor <= greatest.max(2.0);
    more.then(|| down.chain(up.take_while(|v| *v <= greatest)).collect())
}

/// 1-2-5, 1-3 or 1 in every decade, then in every second, third, ...
fn decades([least, greatest]: [f64; 2], coarseness: u32) -> Option<Vec<f64>> {
    let last = greatest.log10().ceil() as i32;
    let first = if least > 0.0 { least.log10().floor() as i32 } else { last - DECADES };
    let (mantissas, stride): (&[f64], i32) = match coarseness {
        0 => (&[1.0, 2.0, 5.0], 1),
        1 => (&[1.0, 3.0], 1),
        n => (&[1.0], n as i32 - 1),
    };
    let in_decade = |e: i32| mantissas.iter().map(move |m| scaled(*m, e));
    (stride <= (last - first).max(1))
        .then(|| (first..=last).step_by(stride as usize).flat_map(in_decade).collect())
}

/// Multiples of 1, 2 or 5 times a power of ten, that power at least `exponent`, from a thousandth
/// of the range up to all of it.
fn multiples([least, greatest]: [f64; 2], coarseness: u32, exponent: i32) -> Option<Vec<f64>> {
    let range = greatest - least;
    let first = (range.max(f64::MIN_POSITIVE).log10().floor() as i32 - 3).max(exponent);
    let mantissa = [1.0, 2.0, 5.0][coarseness as usize % 3];
    let exponent = first + coarseness as i32 / 3;
    let step = scaled(mantissa, exponent);
    if step > range {
        return None;
    }
    let (from, to) = ((least / step).ceil() as i64, (greatest / step).floor() as i64);
    Some((from..=to).map(|k| scaled(mantissa * k as f64, exponent)).collect())
}

/// `mantissa` times that power of ten, correctly rounded: 0.3 and not 0.30000000000000004.
fn scaled(mantissa: f64, exponent: i32) -> f64 {
    let power = 10f64.powi(exponent.abs());
    if exponent < 0 { mantissa / power } else { mantissa * power }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::problems;
    use proptest::prelude::*;

    fn numbers(knob: &Knob) -> Vec<f64> {
        knob.steps().iter().map(|v| v.as_f64().unwrap()).collect()
    }

    #[test]
    fn steps_by_hand() {
        let int = |range| Knob::int("n", range, "");
        let float = |range| Knob::float("x", range, "");
        for (knob, expected) in [
            (
                int([16, 512, 8192]).log().useful(128.0, 4096.0),
                &[128.0, 256.0, 512.0, 1024.0, 2048.0, 4096.0][..],
            ),
            (int([1, 4, 8]).log(), &[1.0, 2.0, 4.0, 8.0]),
            (int([0, 0, 4095]).log().useful(2.0, 16.0), &[0.0, 2.0, 4.0, 8.0, 16.0]),
            (int([1, 8, 64]), &[1.0, 8.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 64.0]),
            (int([3, 4, 5]), &[3.0, 4.0, 5.0]),
            (int([7, 7, 7]), &[7.0]),
            (float([0.0, 0.2, 0.95]), &[0.0, 0.2, 0.4, 0.6, 0.8, 0.95]),
            (
                float([0.0, 1e-3, 0.1]).log().useful(1e-4, 2e-2),
                &[1e-4, 2e-4, 5e-4, 1e-3, 2e-3, 5e-3, 1e-2, 2e-2],
            ),
            (
                float([0.0, 0.0, 0.5]).log().useful(1e-7, 1e-2),
                &[0.0, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2],
            ),
            (float([0.0, 0.0, 44.0]).log().useful(2.0, 40.0), &[0.0, 2.0, 5.0, 10.0, 20.0, 40.0]),
        ] {
            assert_eq!(numbers(&knob), expected, "{knob:?}");
        }
        let choice = Knob::choice("c", &["b", "a"], "");
        assert_eq!(choice.steps(), ["b", "a"]);
    }

    fn hold(knob: &Knob) -> Result<(), TestCaseError> {
        let steps = knob.steps();
        prop_assert!(steps.contains(&knob.default_value()), "{knob:?}: {steps:?}");
        for step in &steps {
            prop_assert!(knob.check("knob", step).is_ok(), "{knob:?}: {step}");
        }
        if let Range::Choice(_) = knob.range {
            return Ok(());
        }
        let values = numbers(knob);
        prop_assert!(values.len() <= MOST, "{knob:?}: {values:?}");
        prop_assert!(values.windows(2).all(|w| w[0] < w[1]), "{knob:?}: {values:?}");
        if let Some(ends) = knob.useful {
            prop_assert!(ends.iter().all(|end| values.contains(end)), "{knob:?}: {values:?}");
        }
        Ok(())
    }

    #[test]
    fn every_declared_knob_has_steps_that_it_takes() {
        let mut checked = 0;
        for problem in problems::ALL {
            let spec = problem.spec();
            for knob in spec.techniques.iter().flat_map(|t| t.knobs).chain(spec.parameters) {
                hold(knob).unwrap();
                // A range of extremes is no range of use: between 1e-300 and 1 lies no grid.
                let least = match knob.range {
                    Range::Int { min, .. } => min as f64,
                    Range::Float { min, .. } => min,
                    Range::Choice(_) => 1.0,
                };
                assert!(!knob.logarithmic || least > 0.0 || knob.useful.is_some(), "{}", knob.name);
                checked += 1;
            }
        }
        assert!(checked > 20);
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn any_range_has_ascending_steps_within_it(
            mut ints in prop::array::uniform3(-1_000_000i64..1_000_000),
            mut floats in prop::array::uniform3(-1e6f64..1e6),
            scale in -30i32..30,
            log: bool,
        ) {
            ints.sort_unstable();
            floats.sort_by(f64::total_cmp);
            let floats = floats.map(|x| x * 10f64.powi(scale));
            let mut knobs = vec![Knob::int("n", ints, ""), Knob::float("x", floats, "")];
            if log {
                let ints = ints.map(i64::abs).map(|n| n.max(1));
                let (least, greatest) = (ints[0].min(ints[2]), ints[0].max(ints[2]));
                knobs = vec![
                    Knob::int("n", [0, ints[1], 1_000_000], "").log().useful(least as f64, greatest as f64),
                    Knob::float("x", [0.0, 0.0, 1e40], "").log().useful(10f64.powi(scale.min(0)), 10f64.powi(scale.max(1))),
                ];
            }
            for knob in knobs {
                hold(&knob)?;
            }
        }
    }
}
