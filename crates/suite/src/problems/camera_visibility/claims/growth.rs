//! Our own goals of growth: the walk's cost, and memory.

use super::{
    replay::{Recorded, record, walk_ns},
    support::{Path, Town, path, town},
    verdict::{all_of, figure, judged, paired},
};
use crate::{
    SuiteError,
    claims::{Claim, ClaimContext, Figure, Judged, Verdict},
};
use dapple_occlusion::camera::{Frame, Settings, State, Technique, Work};
use std::rc::Rc;

/// What stays flat may grow by this much: the larger city's hierarchy is a level deeper here and
/// there, and machines are noisy.
const FLAT: f64 = 1.25;

/// Bytes of a thing may differ by this much between sizes: a city has a rim.
const EQUAL: f64 = 1.05;

pub fn claims() -> Vec<Claim> {
    vec![
        Claim {
            id: "dapple-S5.3",
            statement: "The walk costs the same for a visible node in cities of 6 x 6 and 15 x 15 \
                        blocks",
            place: "goal of this project; Conte 2018, hypothesis of table 5.VII",
            method: "CHC++ down the street of both cities, 24 frames, 256 x 144, under the city's \
                     own hierarchy and under the one of smallest surfaces. Nodes taken from the queue for an object drawn, from \
                     the second frame on: in the first nothing is known. And time of the walk alone \
                     for a node, nothing drawn and recorded answers repeated, median of 15 paired \
                     ratios. 15 x 15 over 6 x 6 at most 1.25 in both; a time that the noise could \
                     explain stays open, and so does what one hierarchy meets and one does not",
            judge: Box::new(flat_walk),
        },
        Claim {
            id: "dapple-S5.4",
            statement: "Cities load in memory that grows with what is in them",
            place: "goal of this project",
            method: "bytes for a triangle (objects, hierarchy, what is remembered), for a light and \
                     for a facade in the generated cities of 6, 9 and 15 blocks a side: none more \
                     than 5 % above that of 6",
            judge: Box::new(memory),
        },
    ]
}

/// Nodes and time for a visible node, large city over small, and the time's scatter.
fn flat(nodes: f64, time: f64, mad: f64) -> Verdict {
    let nodes = if nodes <= FLAT { Verdict::Reproduced } else { Verdict::Refuted };
    let time = if time <= FLAT {
        Verdict::Reproduced
    } else if time - 3.0 * mad <= FLAT {
        Verdict::Open
    } else {
        Verdict::Refuted
    };
    all_of(&[nodes, time])
}

/// Several hierarchies, each by itself.
fn any_and_all(hierarchies: &[Verdict]) -> Verdict {
    match hierarchies.first() {
        Some(first) if hierarchies.iter().all(|v| v == first) => *first,
        _ => Verdict::Open,
    }
}

/// A city's walk down the street, written down.
struct Walk {
    path: Rc<Path>,
    recorded: Recorded,
    nodes: f64,
    /// Nodes for an object drawn, from the second frame on.
    share: f64,
}

fn walk(town: &Rc<Town>, name: &str, figures: &mut Vec<Figure>) -> Result<Walk, SuiteError> {
    let path = path(town, "street", 24, 1)?;
    let recorded = record(&path, &Settings::new(Technique::ChcPlusPlus))?;
    let sum = |frames: &[Frame], of: fn(&Work) -> u64| -> f64 {
        frames.iter().map(|f| of(&f.work)).sum::<u64>() as f64
    };
    let share = |frames: &[Frame]| sum(frames, |w| w.nodes) / sum(frames, |w| w.draws).max(1.0);
    let frames = &recorded.frames;
    let later = frames.get(1..).unwrap_or(&[]);
    let drawn = sum(later, |w| w.draws) / later.len().max(1) as f64;
    figures.push(figure(format!("{name}: objects drawn a frame"), drawn, ""));
    figures.push(figure(format!("{name}: nodes for an object drawn"), share(later), ""));
    let first = share(frames.get(..1).unwrap_or(&[]));
    figures.push(figure(format!("{name}: the same in the first frame"), first, ""));
    let (nodes, share) = (sum(frames, |w| w.nodes), share(later));
    Ok(Walk { path, recorded, nodes, share })
}

fn flat_walk(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let settings = Settings::new(Technique::ChcPlusPlus);
    let (mut figures, mut verdicts, mut told) = (Vec::new(), Vec::new(), Vec::new());
    for hierarchy in ["city's hierarchy", "smallest surfaces"] {
        let mut of = |scene: &str| -> Result<Walk, SuiteError> {
            let own = town(scene, &[])?;
            let town = match hierarchy {
                "smallest surfaces" => Rc::new(own.bottom_up()?),
                _ => own,
            };
            walk(&town, &format!("{scene}, {hierarchy}"), &mut figures)
        };
        let (small, large) = (of("city")?, of("city_15")?);
        let ns = |walk: &Walk| {
            Ok::<f64, SuiteError>(
                walk_ns(&walk.path, &settings, &walk.recorded)? / walk.nodes.max(1.0),
            )
        };
        let ratio = paired(15, || ns(&large), || ns(&small))?;
        let nodes = large.share / small.share.max(f64::MIN_POSITIVE);
        let what = format!("{hierarchy}, 15 x 15 over 6 x 6");
        figures.push(figure(format!("{what}: nodes for an object drawn"), nodes, ""));
        figures.push(figure(format!("{what}: time for a node"), ratio.median, ""));
        figures.push(figure(format!("{what}: the same, MAD"), ratio.mad, ""));
        verdicts.push(flat(nodes, ratio.median, ratio.mad));
        told.push(format!("{hierarchy} {nodes:.2} and {:.2}", ratio.median));
    }
    let because = format!(
        "times the nodes for an object drawn, and times the time for a node: {}",
        told.join("; ")
    );
    Ok(judged(any_and_all(&verdicts), because, figures))
}

/// Bytes for a thing at rising sizes.
fn bounded(things: &[Vec<f64>]) -> Verdict {
    // Written so that a NaN is refused.
    let steady = |sizes: &Vec<f64>| sizes.iter().all(|b| *b <= sizes[0] * EQUAL);
    match things.is_empty() || things.iter().any(Vec::is_empty) {
        true => Verdict::Open,
        false if things.iter().all(steady) => Verdict::Reproduced,
        false => Verdict::Refuted,
    }
}

/// Bytes for a triangle, a light and a facade.
fn bytes(town: &Town) -> [f64; 3] {
    let tree = &town.tree;
    let nodes = size_of_val(&tree.nodes[..]) + size_of_val(&tree.objects[..]);
    let drawn = town.objects.bytes() + nodes as u64 + State::new(tree).bytes();
    let city = town.city.bytes();
    let facades: usize = town.city.buildings.iter().map(|b| b.facades.len()).sum();
    let each = |bytes: u64, things: u64| bytes as f64 / things.max(1) as f64;
    [
        each(drawn, town.triangles()),
        each(city.lights, (town.city.lights.len() + town.city.lamps.len()) as u64),
        each(city.buildings, facades as u64),
    ]
}

fn memory(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let mut figures = Vec::new();
    let mut things = vec![Vec::new(); 3];
    for scene in ["city", "city_9", "city_15"] {
        let town = town(scene, &[])?;
        figures.push(figure(format!("{scene}: triangles"), town.triangles() as f64, ""));
        for (i, what) in ["a triangle", "a light", "a facade"].into_iter().enumerate() {
            let bytes = bytes(&town)[i];
            figures.push(figure(format!("{scene}: bytes for {what}"), bytes, "B"));
            things[i].push(bytes);
        }
    }
    let last: Vec<f64> = things.iter().filter_map(|t| t.last().copied()).collect();
    let because =
        format!("15 x 15 blocks take {last:.1?} bytes for a triangle, a light and a facade");
    Ok(judged(bounded(&things), because, figures))
}

#[cfg(test)]
mod tests {
    use super::*;
    use Verdict::{Open, Refuted, Reproduced};

    #[test]
    fn what_is_flat_grows_little() {
        assert_eq!(flat(1.1, 1.2, 0.0), Reproduced);
        assert_eq!(flat(1.3, 1.0, 0.0), Refuted);
        assert_eq!(flat(1.0, 1.4, 0.1), Open);
        assert_eq!(flat(1.0, 1.8, 0.1), Refuted);
        assert_eq!(flat(f64::NAN, 1.0, 0.0), Refuted);
    }

    #[test]
    fn hierarchies_that_differ_leave_it_open() {
        assert_eq!(any_and_all(&[Reproduced, Reproduced]), Reproduced);
        assert_eq!(any_and_all(&[Refuted, Refuted]), Refuted);
        assert_eq!(any_and_all(&[Refuted, Reproduced]), Open);
        assert_eq!(any_and_all(&[]), Open);
    }

    #[test]
    fn memory_grows_with_its_contents_or_faster() {
        assert_eq!(bounded(&[vec![10.0, 10.2, 9.0]]), Reproduced);
        assert_eq!(bounded(&[vec![10.0, 10.2, 9.0], vec![10.0, 11.0]]), Refuted);
        assert_eq!(bounded(&[vec![10.0, f64::NAN]]), Refuted);
        assert_eq!(bounded(&[]), Open);
    }
}
