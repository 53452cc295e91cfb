//! Evaluations by point of view: table 5.VI, and how what is seen and its lists grow.

use super::{
    support::{ABOUT, KEPT, VIEWS, front, mean, night, prepared, standing},
    verdict::{exponent, figure, judged},
};
use crate::{
    SuiteError,
    claims::{Claim, Figure, Judged, Verdict},
};
use serde_json::json;
use std::{cell::RefCell, rc::Rc};

/// Evaluations a frame at the source's points of view a to d; a's is below.
const SAID: [f64; 4] = [1.0, 3.0, 4.0, 20.0];

/// Frames of a camera that stands, and those that are left out as its start.
const FRAMES: [usize; 2] = [120, 60];

pub fn claims() -> Vec<Claim> {
    vec![
        Claim {
            id: "conte-T5.VI-evaluations",
            statement: "Where precuts are kept for 50 frames, fewer than 1, 3, 4 and 20 are found a \
                        frame at the four points of view",
            place: "Conte 2018, table 5.VI",
            method: "the 6 x 6 city, 96 x 72, a camera that stands, frames 61 to 120. Met if the first \
                     is below 1 and the others are within a factor of 1.5 or fewer; contradicted if the \
                     street's or the view from above need ten times as many, or if any view needs more \
                     than the next wider one; open between. Our cells are around all that lies below a \
                     node, roofs face four directions, and streets are cells of their own",
            judge: Box::new(|_| evaluations()),
        },
        Claim {
            id: "conte-H5.8",
            statement: "What is seen and its lists scale alike, and less than what is visible",
            place: "Conte 2018, section 5.4: from a to d 43 and 61 times for 626 times the triangles",
            method: "exponents over the four views in objects drawn of nodes of the hierarchy looked \
                     at by CHC++, and of evaluations of a frame that finds all. Met \
                     if both are below 1 and within a factor of 1.5 of each other, contradicted if both \
                     are 1 or more",
            judge: Box::new(|_| growth()),
        },
    ]
}

/// What a point of view needs.
#[derive(Clone, Copy, Debug)]
struct Needs {
    kept: f64,
    anew: f64,
    first: f64,
    nodes: f64,
    drawn: f64,
    cells: f64,
    ns: f64,
}

fn needs() -> Result<Rc<Vec<Needs>>, SuiteError> {
    thread_local! {
        static MADE: RefCell<Option<Rc<Vec<Needs>>>> = const { RefCell::new(None) };
    }
    if let Some(made) = MADE.with_borrow(Option::clone) {
        return Ok(made);
    }
    let mut all = Vec::new();
    for view in VIEWS {
        let case = prepared("city", view, &[])?;
        let mut front = front(&case, &night(&[("validity", json!(KEPT))])?)?;
        let frames = standing(&mut front, FRAMES[0])?;
        // What a frame needs is known when it is seen that what the first drew is hidden.
        let last = frames[FRAMES[0] - 1];
        let mut every = super::support::front(&case, &night(&[("validity", json!(1))])?)?;
        let all_anew = standing(&mut every, 3)?[2];
        all.push(Needs {
            kept: mean(&frames[FRAMES[1]..], |p| p.counts.evaluations),
            anew: all_anew.counts.evaluations as f64,
            first: frames[0].counts.evaluations as f64,
            nodes: front.visibility_work().nodes as f64,
            drawn: last.counts.drawn as f64,
            cells: last.counts.cells as f64,
            ns: frames[0].region_ns as f64,
        });
    }
    let made = Rc::new(all);
    MADE.set(Some(Rc::clone(&made)));
    Ok(made)
}

fn figures(all: &[Needs]) -> Vec<Figure> {
    let of = |(view, needs): (&str, &Needs)| {
        [
            figure(format!("{view}: evaluations a frame, kept for 50"), needs.kept, ""),
            figure(format!("{view}: evaluations, all anew"), needs.anew, ""),
            figure(format!("{view}: evaluations of a first frame"), needs.first, ""),
            figure(format!("{view}: cells"), needs.cells, ""),
            figure(format!("{view}: objects drawn"), needs.drawn, ""),
            figure(format!("{view}: nodes looked at"), needs.nodes, ""),
            figure(
                format!("{view}: an evaluation"),
                needs.ns / needs.first.max(1.0) / 1000.0,
                "us",
            ),
        ]
    };
    VIEWS.into_iter().zip(all).flat_map(of).collect()
}

fn few(kept: [f64; 4]) -> Verdict {
    let is_below = kept[0] < SAID[0];
    let are_about = kept.iter().zip(SAID).skip(1).all(|(k, said)| *k <= ABOUT * said);
    let grows = kept.windows(2).all(|pair| pair[0] <= pair[1]);
    let are_many = [2, 3].into_iter().any(|at| kept[at] >= 10.0 * SAID[at]);
    if !grows || are_many {
        Verdict::Refuted
    } else if is_below && are_about {
        Verdict::Reproduced
    } else {
        Verdict::Open
    }
}

fn evaluations() -> Result<Judged, SuiteError> {
    let all = needs()?;
    let kept = [0, 1, 2, 3].map(|at| all[at].kept);
    let told: Vec<String> = kept.iter().map(|k| format!("{k:.1}")).collect();
    let because = format!("{} evaluations a frame", told.join(", "));
    Ok(judged(few(kept), because, figures(&all)))
}

/// Exponents of what is seen and of lists.
fn alike(seen: f64, lists: f64) -> Verdict {
    let ratio = seen / lists;
    if seen < 1.0 && lists < 1.0 && (1.0 / ABOUT..=ABOUT).contains(&ratio) {
        Verdict::Reproduced
    } else if seen >= 1.0 && lists >= 1.0 {
        Verdict::Refuted
    } else {
        Verdict::Open
    }
}

fn growth() -> Result<Judged, SuiteError> {
    let all = needs()?;
    let drawn = all[3].drawn / all[0].drawn.max(1.0);
    let of = |of: fn(&Needs) -> f64| {
        exponent(&all.iter().map(|needs| (needs.drawn, of(needs))).collect::<Vec<_>>())
    };
    let (seen, lists) = (of(|needs| needs.nodes), of(|needs| needs.anew));
    let mut figures = figures(&all);
    figures.extend([
        figure("objects drawn, d over a", drawn, "times"),
        figure("exponent of nodes looked at", seen, ""),
        figure("exponent of evaluations", lists, ""),
    ]);
    let because = format!(
        "for {drawn:.0} times the objects, nodes grow with exponent {seen:.2} and evaluations with \
         {lists:.2}"
    );
    Ok(judged(alike(seen, lists), because, figures))
}

#[cfg(test)]
mod tests {
    use super::*;
    use Verdict::{Open, Refuted, Reproduced};

    #[test]
    fn evaluations_are_few_or_not() {
        assert_eq!(few([0.5, 2.0, 5.0, 29.0]), Reproduced);
        assert_eq!(few([1.5, 2.0, 5.0, 29.0]), Open);
        assert_eq!(few([0.5, 2.0, 5.0, 40.0]), Open);
        assert_eq!(few([0.5, 2.0, 5.0, 200.0]), Refuted);
        assert_eq!(few([0.5, 6.0, 5.0, 20.0]), Refuted);
        assert_eq!(few([0.5, f64::NAN, 5.0, 20.0]), Refuted);
    }

    #[test]
    fn both_grow_alike_or_not() {
        assert_eq!(alike(0.6, 0.7), Reproduced);
        assert_eq!(alike(0.3, 0.9), Open);
        assert_eq!(alike(1.0, 1.2), Refuted);
        assert_eq!(alike(f64::NAN, 0.5), Open);
    }
}
