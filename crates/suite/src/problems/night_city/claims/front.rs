//! Who is cheapest at each error.

use super::{
    super::SPEC,
    support::{RGB, checked, error, ns, prepared, setting},
    verdict::{figure, judged, vote},
};
use crate::{
    SuiteError,
    claims::{Claim, Judged},
};
use serde_json::{Value, json};

const VIEWS: [&str; 2] = ["close_ended", "street"];

/// The technique that is asked about.
const OURS: &str = "facade-cluster";

pub fn claims() -> Vec<Claim> {
    vec![Claim {
        id: "night-cheapest",
        statement: "Facade-cluster visibility is the cheapest way to every error that it reaches",
        place: "goal of this project; Conte 2018 compares with no rival",
        method: "close-ended street and long street of the 6 x 6 city, 64 x 48, two frames \
                 from a cold start. Cuts of all lights, facade-cluster visibility without \
                 and with shadow rays, traced cuts (each at T = 1/25500, 1/1020 and 1/255) and reservoirs \
                 of 32 candidates: 99th percentile of the error and time, median of three. For 2, 8 and \
                 32 RGB steps in each view that the first variant reaches: met where none that reaches it \
                 takes less time. Levels that it does not reach say nothing",
        judge: Box::new(|_| cheapest()),
    }]
}

/// A technique's name in figures, its own, and its knobs.
type Rival = (&'static str, &'static str, Vec<(&'static str, Value)>);

fn rivals() -> Vec<Rival> {
    let mut all: Vec<Rival> = Vec::new();
    for threshold in [RGB / 100.0, RGB / 4.0, RGB] {
        let cut = ("cut", json!(threshold));
        all.push(("full-tree", "full-tree", vec![cut.clone()]));
        all.push((OURS, OURS, vec![cut.clone()]));
        let rays = ("shadow_rays", json!("on"));
        all.push(("facade-cluster with rays", OURS, vec![cut.clone(), rays]));
        all.push(("traced-cut", "traced-cut", vec![cut]));
    }
    all.push(("reservoirs", "reservoirs", Vec::new()));
    all
}

/// Of techniques with their errors and times: the quickest that reaches a level; whether ours reaches
/// it, and is that one.
fn quickest(all: &[(&'static str, f64, f64)], level: f64) -> (Option<&'static str>, Option<bool>) {
    let reach = all.iter().filter(|(_, error, _)| *error <= level);
    let best = reach.clone().min_by(|a, b| a.2.total_cmp(&b.2)).map(|best| best.0);
    let ours = reach.clone().any(|(name, _, _)| *name == OURS);
    (best, ours.then_some(best == Some(OURS)))
}

fn cheapest() -> Result<Judged, SuiteError> {
    let (mut figures, mut holds, mut told) = (Vec::new(), Vec::new(), Vec::new());
    for view in VIEWS {
        let case = prepared("city", view, &[("width", json!(64)), ("frames", json!(2))])?;
        let mut all = Vec::new();
        for (name, technique, knobs) in rivals() {
            let error = error(&*checked(&case, technique, &knobs)?, "error_p99");
            let time = ns(&case, &setting(technique, &knobs)?, 1)?;
            let cut = knobs.first().and_then(|(_, value)| value.as_f64());
            let with = cut.map_or(String::new(), |t| format!(" at 1/{:.0}", 1.0 / t));
            figures.push(figure(format!("{view}, {name}{with}: error_p99"), error / RGB, "1/255"));
            figures.push(figure(format!("{view}, {name}{with}: two frames"), time / 1e6, "ms"));
            all.push((name, error, time));
        }
        for level in SPEC.levels {
            let (best, ours) = quickest(&all, level);
            told.push(format!("{view} at {:.0}: {}", level / RGB, best.unwrap_or("none")));
            holds.extend(ours);
        }
    }
    let because = format!("cheapest are {}", told.join(", "));
    Ok(judged(vote(&holds), because, figures))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_quickest_that_reaches_a_level_counts() {
        let all = [("full-tree", 9.0, 1.0), (OURS, 2.0, 3.0), ("traced-cut", 0.1, 5.0)];
        assert_eq!(quickest(&all, 10.0), (Some("full-tree"), Some(false)));
        assert_eq!(quickest(&all, 2.0), (Some(OURS), Some(true)));
        assert_eq!(quickest(&all, 1.0), (Some("traced-cut"), None));
        assert_eq!(quickest(&all, 0.0), (None, None));
    }
}
