//! Our own goals of growth: the walk's cost, and memory.

use super::{
    replay::{record, walk_ns},
    support::{Path, Town, path, town},
    verdict::{all_of, figure, judged, paired},
};
use crate::{
    SuiteError,
    claims::{Claim, ClaimContext, Judged, Verdict},
};
use dapple_occlusion::camera::{Settings, State, Technique};

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
            method: "CHC++ down the street of both cities, 24 frames, 256 x 144. Nodes taken from \
                     the queue for an object drawn; and time of the walk alone for a node, nothing \
                     drawn and recorded answers repeated, median of 15 paired ratios. 15 x 15 over \
                     6 x 6 at most 1.25 in both; a time that the noise could explain stays open",
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

fn flat_walk(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let settings = Settings::new(Technique::ChcPlusPlus);
    let mut figures = Vec::new();
    let mut walk = |scene: &str| -> Result<_, SuiteError> {
        let path = path(&town(scene, &[])?, "street", 24, 1)?;
        let recorded = record(&path, &settings)?;
        let nodes: u64 = recorded.frames.iter().map(|f| f.work.nodes).sum();
        let drawn: u64 = recorded.frames.iter().map(|f| f.work.draws).sum();
        let share = nodes as f64 / drawn.max(1) as f64;
        let objects = path.town.objects.objects.len() as f64;
        let frames = recorded.frames.len().max(1) as f64;
        figures.push(figure(format!("{scene}: objects"), objects, ""));
        figures.push(figure(format!("{scene}: objects drawn a frame"), drawn as f64 / frames, ""));
        figures.push(figure(format!("{scene}: nodes for an object drawn"), share, ""));
        Ok((path, recorded, nodes as f64, share))
    };
    let (small, large) = (walk("city")?, walk("city_15")?);
    let ns = |path: &Path, recorded, nodes: f64| {
        Ok::<f64, SuiteError>(walk_ns(path, &settings, recorded)? / nodes.max(1.0))
    };
    let ratio = paired(15, || ns(&large.0, &large.1, large.2), || ns(&small.0, &small.1, small.2))?;
    let nodes = large.3 / small.3.max(f64::MIN_POSITIVE);
    figures.push(figure("nodes for an object drawn, 15 x 15 over 6 x 6", nodes, ""));
    figures.push(figure("time for a node, 15 x 15 over 6 x 6", ratio.median, ""));
    figures.push(figure("the same, MAD", ratio.mad, ""));
    let because = format!(
        "{nodes:.2} times the nodes for an object drawn, {:.2} times the time for a node",
        ratio.median
    );
    Ok(judged(flat(nodes, ratio.median, ratio.mad), because, figures))
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
    fn memory_grows_with_its_contents_or_faster() {
        assert_eq!(bounded(&[vec![10.0, 10.2, 9.0]]), Reproduced);
        assert_eq!(bounded(&[vec![10.0, 10.2, 9.0], vec![10.0, 11.0]]), Refuted);
        assert_eq!(bounded(&[vec![10.0, f64::NAN]]), Refuted);
        assert_eq!(bounded(&[]), Open);
    }
}
