//! Bytes of precuts: those of what is seen, and those of a whole city.

use super::{
    super::settings,
    support::{KEPT, front, night, prepared, setting, standing},
    verdict::{figure, judged},
};
use crate::{
    SuiteError,
    claims::{Claim, Judged, Verdict},
};
use serde_json::json;

/// What the source's lists take at its view from above, and the facades that this shows.
const SAID: (f64, f64) = (2e6, 2185.0);

pub fn claims() -> Vec<Claim> {
    vec![
        Claim {
            id: "conte-H5.9",
            statement: "Lists of all that is visible fit into 2 MB, with 2,185 visible facades",
            place: "Conte 2018, table 5.VI: 1.8 MB",
            method: "the 6 x 6 city from above, 96 x 72: bytes of ranges and lists of the first frame \
                     as a device holds them, 4 an index. At most 2 MB is met, above 4 contradicts; open \
                     between, as what is a facade differs: ours also lists roofs and streets. Bytes \
                     that the processor keeps stand beside",
            judge: Box::new(|_| from_above()),
        },
        Claim {
            id: "conte-4.1-precomputed",
            statement: "Finding precuts of what is seen as it is seen takes a small part of the memory \
                        of finding them all before",
            place: "Conte 2018, chapters 2 and 4: why visibility is found on line",
            method: "the 2 x 2 city, each facade a cell: bytes kept before the first frame over bytes \
                     kept after the first frame of the close-ended street. 10 and more is met, 2 and \
                     fewer contradicts: what is kept grows by what is seen and the city is small. Time \
                     to find all stands beside, over that of the first frame",
            judge: Box::new(|_| precomputed()),
        },
    ]
}

fn fits(bytes: f64) -> Verdict {
    if bytes <= SAID.0 {
        Verdict::Reproduced
    } else if bytes <= 2.0 * SAID.0 {
        Verdict::Open
    } else {
        Verdict::Refuted
    }
}

fn from_above() -> Result<Judged, SuiteError> {
    let case = prepared("city", "birds_eye", &[])?;
    let mut front = front(&case, &night(&[("validity", json!(KEPT))])?)?;
    let counts = standing(&mut front, 1)?[0].counts;
    let bytes = counts.list_bytes as f64;
    let figures = vec![
        figure("ranges and lists", bytes, "B"),
        figure("nodes of lists", counts.list_nodes as f64, ""),
        figure("lists", counts.lists as f64, ""),
        figure("objects that have one", counts.listed as f64, ""),
        figure("bytes an object", bytes / (counts.listed as f64).max(1.0), "B"),
        figure("the source's bytes a facade, at most", SAID.0 / SAID.1, "B"),
        figure("kept by the processor", counts.kept_bytes as f64, "B"),
    ];
    let because = format!("lists of {} objects take {:.2} MB", counts.listed, bytes / 1e6);
    Ok(judged(fits(bytes), because, figures))
}

fn saves(times: f64) -> Verdict {
    if times >= 10.0 {
        Verdict::Reproduced
    } else if times > 2.0 {
        Verdict::Open
    } else {
        Verdict::Refuted
    }
}

fn precomputed() -> Result<Judged, SuiteError> {
    let case = prepared("city_small", "close_ended", &[])?;
    let knobs = [("most_split", json!("facade")), ("tau", json!(0))];
    let whole = settings::night(&setting("facade-cluster/precomputed", &knobs)?, 0)?;
    let whole = front(&case, &whole)?;
    let mut seen = front(&case, &night(&knobs)?)?;
    let first = standing(&mut seen, 1)?[0];
    let ratio = whole.kept().bytes() as f64 / (first.counts.kept_bytes as f64).max(1.0);
    let time = whole.precomputing_ns() as f64 / (first.region_ns as f64).max(1.0);
    let figures = vec![
        figure("kept before the first frame", whole.kept().bytes() as f64, "B"),
        figure("precuts of all", whole.kept().len() as f64, ""),
        figure("kept after the first frame", first.counts.kept_bytes as f64, "B"),
        figure("precuts of what is seen", first.counts.kept as f64, ""),
        figure("bytes, all over seen", ratio, "times"),
        figure("time, all over the first frame's", time, "times"),
    ];
    let because = format!("all precuts take {ratio:.1} times the bytes of those of what is seen");
    Ok(judged(saves(ratio), because, figures))
}

#[cfg(test)]
mod tests {
    use super::*;
    use Verdict::{Open, Refuted, Reproduced};

    #[test]
    fn lists_fit_or_not() {
        assert_eq!([2e6, 3e6, 5e6, f64::NAN].map(fits), [Reproduced, Open, Refuted, Refuted]);
    }

    #[test]
    fn memory_is_saved_or_not() {
        assert_eq!([10.0, 5.0, 2.0, f64::NAN].map(saves), [Reproduced, Open, Refuted, Refuted]);
    }
}
