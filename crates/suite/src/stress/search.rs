//! Which value of an axis to probe next: home, then a grid, then bisection at each end of the
//! safe set.
//!
//! What is probed follows from what is known alone, in any order: a search that was interrupted
//! goes on exactly where it stopped.
//!
//! Resolution: neighbours on the grid lie at most [`step`] apart, so intervals and holes wider
//! than that are found. Each of the ends found is then halved `refine` times; a value in the
//! middle may move by 1/64 of its bracket to a number that is short to write, so that an end is
//! known to `step * (33/64)^refine`.

use super::Values;

/// Grid points that an axis has at most, whatever it declares.
pub const MOST_POINTS: usize = 1000;

/// Share of its bracket by which a value may move to a shorter number.
const SHORTER: f64 = 1.0 / 64.0;

/// A value that needs no more probing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Known {
    /// Where.
    pub value: f64,
    /// Whether the technique did what it must; `None` where that could not be seen.
    pub safe: Option<bool>,
}

/// The value to probe next; none when all is known.
pub fn next(values: Values, home: f64, known: &[Known], refine: u32) -> Option<f64> {
    wanted(values, home, known, refine).into_iter().next()
}

/// All values that can be probed next, in order: home alone until it is known (others are judged
/// by the error there), then what is missing of the grid, then the middle of each bracket.
pub fn wanted(values: Values, home: f64, known: &[Known], refine: u32) -> Vec<f64> {
    let safe_at = |value: f64| known.iter().find(|k| k.value == value).map(|k| k.safe);
    let (grid, home) = (grid(values, home), at_home(values, home));
    let missing = |value: &f64| safe_at(*value).is_none();
    if let Some(home) = home.filter(missing) {
        return vec![home];
    }
    let rest: Vec<f64> = grid.iter().copied().filter(missing).collect();
    if !rest.is_empty() {
        return rest;
    }
    let brackets = grid.windows(2).filter_map(|pair| {
        let (mut low, mut high) = (pair[0], pair[1]);
        let below = safe_at(low)??;
        if safe_at(high)?? == below {
            return None;
        }
        for _ in 0..refine {
            let middle = middle(values, low, high)?;
            match safe_at(middle) {
                None => return Some(middle),
                Some(safe) if safe? == below => low = middle,
                Some(_) => high = middle,
            }
        }
        None
    });
    brackets.collect()
}

/// Home on the axis: clamped to its ends; none on an axis without values.
pub fn at_home(values: Values, home: f64) -> Option<f64> {
    let (least, greatest) = ends(values)?;
    let home = if home.is_nan() { least } else { home.clamp(least, greatest) + 0.0 };
    Some(match values {
        Values::Log { .. } | Values::Linear { .. } => home,
        Values::FromZero { least, .. } if home < least => 0.0,
        Values::FromZero { .. } => home,
        Values::Whole { .. } | Values::Words(_) => home.round(),
    })
}

/// Least and greatest value; none on an axis without values.
pub fn ends(values: Values) -> Option<(f64, f64)> {
    let (least, greatest) = match values {
        Values::Log { least, greatest, .. } if least > 0.0 => (least, greatest),
        Values::FromZero { least, greatest, .. } if least > 0.0 && least <= greatest => {
            (0.0, greatest)
        }
        Values::Whole { least, greatest, .. } => (f64::from(least), f64::from(greatest)),
        Values::Linear { least, greatest, .. } => (least, greatest),
        Values::Words(words) => (0.0, words.len() as f64 - 1.0),
        Values::Log { .. } | Values::FromZero { .. } => return None,
    };
    let sound = least.is_finite() && greatest.is_finite() && least <= greatest;
    // Adding zero makes a negative zero positive: values are told apart by their bits.
    sound.then_some((least + 0.0, greatest + 0.0))
}

/// The grid with home among it, ascending, each value once; empty for ends that are none.
pub fn grid(values: Values, home: f64) -> Vec<f64> {
    let Some((least, greatest)) = ends(values) else { return Vec::new() };
    let mut grid = match values {
        Values::Linear { steps, .. } => even(values, least, greatest, steps as usize),
        Values::Log { per_decade, .. } => {
            even(values, least, greatest, logarithmic_steps(least, greatest, per_decade))
        }
        Values::FromZero { least, per_decade, .. } => {
            even(values, least, greatest, logarithmic_steps(least, greatest, per_decade))
        }
        Values::Whole { per_decade, .. } => {
            let from = least.max(1.0).min(greatest);
            even(values, from, greatest, logarithmic_steps(from.max(1.0), greatest, per_decade))
                .into_iter()
                .map(|value| value.round().clamp(least, greatest))
                .collect()
        }
        Values::Words(words) => (0..words.len().min(MOST_POINTS)).map(|i| i as f64).collect(),
    };
    grid.push(least);
    grid.extend(at_home(values, home));
    grid.sort_by(f64::total_cmp);
    grid.dedup();
    grid
}

/// Steps of the grid at least this fine.
fn logarithmic_steps(least: f64, greatest: f64, per_decade: u32) -> usize {
    // Less a trifle: 3 decades are 3 and not 3.0000000000000004.
    ((greatest / least).log10() * f64::from(per_decade.max(1)) - 1e-9).ceil().max(0.0) as usize
}

/// Values evenly spaced on the axis's scale, both ends included.
fn even(values: Values, least: f64, greatest: f64, steps: usize) -> Vec<f64> {
    let steps = steps.clamp(1, MOST_POINTS);
    let (from, to) = (scale(values, least), scale(values, greatest));
    let width = (to - from) / steps as f64;
    let between = (1..steps).map(|i| {
        let exact = unscale(values, from + width * i as f64).clamp(least, greatest);
        let exact = if is_whole(values) { exact.round() } else { exact };
        shorter(values, exact, width.abs() * SHORTER, (least, greatest))
    });
    std::iter::once(least).chain(between).chain([greatest]).collect()
}

/// The greatest distance of neighbours on the grid, on the axis's scale (decades where that is
/// logarithmic; the step from 0 left out).
pub fn step(values: Values, home: f64) -> f64 {
    let steps = grid(values, home);
    let steps = steps.windows(2).filter(|w| !is_logarithmic(values) || w[0] > 0.0);
    steps.map(|w| scale(values, w[1]) - scale(values, w[0])).fold(0.0, f64::max)
}

/// Points that a search probes at most.
pub fn most_points(values: Values, home: f64, refine: u32) -> usize {
    let grid = grid(values, home).len();
    grid + refine as usize * grid.saturating_sub(1)
}

/// Whether steps are even in the logarithm.
pub fn is_logarithmic(values: Values) -> bool {
    match values {
        Values::Log { .. } | Values::FromZero { .. } | Values::Whole { .. } => true,
        Values::Linear { .. } | Values::Words(_) => false,
    }
}

fn is_whole(values: Values) -> bool {
    matches!(values, Values::Whole { .. })
}

/// Position on the axis's own scale.
fn scale(values: Values, value: f64) -> f64 {
    if is_logarithmic(values) { value.log10() } else { value }
}

fn unscale(values: Values, position: f64) -> f64 {
    if is_logarithmic(values) { 10_f64.powf(position) } else { position }
}

/// Strictly between two values; none where there is nothing, or nothing that means anything.
fn middle(values: Values, low: f64, high: f64) -> Option<f64> {
    let middle = match values {
        Values::Words(_) => return None,
        Values::Whole { .. } if high - low < 2.0 => return None,
        Values::Whole { .. } => {
            let exact = (low.max(1.0) * high).sqrt().round().clamp(low + 1.0, high - 1.0);
            shorter_between(values, exact, low.max(1.0), high)
        }
        // A zero and the least value above it: no number lies halfway in the logarithm.
        Values::Log { .. } | Values::FromZero { .. } if low <= 0.0 => return None,
        Values::Log { .. } | Values::FromZero { .. } => {
            shorter_between(values, low.sqrt() * high.sqrt(), low, high)
        }
        Values::Linear { .. } => shorter_between(values, low / 2.0 + high / 2.0, low, high),
    };
    (low < middle && middle < high).then_some(middle)
}

fn shorter_between(values: Values, exact: f64, low: f64, high: f64) -> f64 {
    let tolerance = (scale(values, high) - scale(values, low)) * SHORTER;
    shorter(values, exact, tolerance, (low, high))
}

/// The number with the fewest digits within `tolerance` of `exact` on the axis's scale and
/// strictly between two others; else `exact`.
fn shorter(values: Values, exact: f64, tolerance: f64, (low, high): (f64, f64)) -> f64 {
    let candidates = (0..17).filter_map(|digits| format!("{exact:.digits$e}").parse::<f64>().ok());
    let near = |short: &f64| {
        let distance = (scale(values, *short) - scale(values, exact)).abs();
        let fits = !is_whole(values) || short.fract() == 0.0;
        low < *short && *short < high && distance <= tolerance && fits
    };
    candidates.map(|short| short + 0.0).find(near).unwrap_or(exact)
}

#[cfg(test)]
#[path = "search_tests.rs"]
mod tests;
