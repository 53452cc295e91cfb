//! Cuts from the source's own precuts, beside those by rays.

use super::{
    support::{FINE, front, night, prepared},
    verdict::{figure, judged},
};
use crate::{
    SuiteError,
    claims::{Claim, Figure, Judged, Verdict},
    problem::Form,
    problems::many_lights::claims::precuts::{Reached, lighting, subtrees},
};
use dapple_many_lights::{
    BoundForm, LightTree, Shaded, World,
    cut::{Method, Rule, Starts},
    tree::Representative,
};
use serde_json::json;
use std::{cell::RefCell, collections::BTreeMap, rc::Rc, sync::Arc};

/// The source's table is of this view.
const VIEW: (&str, &str) = ("city", "close_ended");

/// The trees: ours, then the ones it is held against.
const TREES: [&str; 3] = ["city", "original", "halves"];

pub fn claims() -> Vec<Claim> {
    vec![
        Claim {
            id: "conte-H3.3-precuts",
            statement: "From facade-cluster visibility's own precuts the revised tree is twice as fast \
                        and visits fewer nodes",
            place: "Conte 2018, table 5.IV: 136.6 against 67.5 ms",
            method: "close-ended street of the 6 x 6 city, 96 x 72, R4 at T = 1/25500 from lists of a \
                     first frame (threshold 1/1020); for Walter's tree and for halves the largest \
                     subtrees of just their lights. Waited visits over the revised tree's: 2/1.5 times \
                     and more against Walter's tree is met, fewer than 1 contradicts. Halves, and lists \
                     by rays for the same objects, the tightest that there can be, stand beside",
            judge: Box::new(|_| twice()),
        },
        Claim {
            id: "conte-H3.4-precuts",
            statement: "Starting at facade-cluster visibility's precuts makes cuts ten times as fast by \
                        either tree",
            place: "Conte 2018, table 5.IV: 10.0 and 18.8 times",
            method: "visits from the roots over visits from the same lists, by tree. Ten times by the \
                     revised tree and by Walter's is met, below five by both contradicts. By lists by \
                     rays stands beside: what is left beyond is what conservative cells give away",
            judge: Box::new(|_| ten_times()),
        },
    ]
}

/// Nodes visited by pixels, and by lanes that wait for each other.
#[derive(Clone, Copy, Debug, Default)]
struct Visits {
    own: f64,
    waited: f64,
}

/// By tree: from the roots, from lists, from lists by rays.
type Measured = [[Visits; 3]; 3];

/// Lists of a tree that hold, for each object, just the lights of its list in the town's tree.
fn moved(lists: &Starts, from: &LightTree, to: &LightTree) -> Result<Starts, SuiteError> {
    let mut made: BTreeMap<[u32; 2], Vec<u32>> = BTreeMap::new();
    let (ranges, _) = lists.lists();
    let mut all: Vec<Option<Vec<u32>>> = Vec::new();
    for object in 0..ranges.len().saturating_sub(1) as u32 {
        let range = lists.range(object);
        let nodes = made.entry(range).or_insert_with(|| {
            let mut wanted = vec![false; from.leaves.len()];
            for &node in lists.nodes(range) {
                let end = node + from.nodes[node as usize].size;
                for below in &from.nodes[node as usize..end as usize] {
                    if below.is_leaf() {
                        wanted[below.light as usize] = true;
                    }
                }
            }
            subtrees(to, &wanted)
        });
        all.push(Some(nodes.clone()));
    }
    Ok(Starts::new(&to.roots, &all, to.nodes.len())?)
}

fn visits(
    world: &Arc<World>,
    tree: &Arc<LightTree>,
    starts: Option<Starts>,
) -> Result<Visits, SuiteError> {
    let method = Method::Rule(Rule::Absolute(FINE), BoundForm::Cheap);
    let mut cut = lighting(Form::Cpu, world, tree, starts, method, None)?;
    let mut shaded = Shaded::default();
    cut.reset(0)?;
    cut.shade(0, true)?;
    cut.read(&mut shaded)?;
    let work = shaded.work;
    Ok(Visits { own: work.visits as f64, waited: work.lane_visits as f64 })
}

fn measured() -> Result<Rc<Measured>, SuiteError> {
    thread_local! {
        static MADE: RefCell<Option<Rc<Measured>>> = const { RefCell::new(None) };
    }
    if let Some(made) = MADE.with_borrow(Option::clone) {
        return Ok(made);
    }
    let case = prepared(VIEW.0, VIEW.1, &[])?;
    let town = &case.night().town;
    let mut front = front(&case, &night(&[("validity", json!(1))])?)?;
    front.prepare(0)?;
    let lists = front.starts();
    let rays = Reached::trace(town.world(true), 0, |object| {
        let [first, number] = lists.range(object);
        (0, first, number)
    });
    let world = town.world(false);
    let trees = [
        Arc::clone(&town.lights),
        Arc::new(LightTree::original(&world.lights, Representative::Weighted)?),
        Arc::new(LightTree::median(&world.lights)?),
    ];
    let mut all = Measured::default();
    for (tree, all) in trees.iter().zip(&mut all) {
        let own = moved(lists, &town.lights, tree)?;
        *all = [
            visits(world, tree, None)?,
            visits(world, tree, Some(own))?,
            visits(world, tree, Some(rays.starts(tree)?))?,
        ];
    }
    let made = Rc::new(all);
    MADE.set(Some(Rc::clone(&made)));
    Ok(made)
}

fn gains(walter: f64) -> Verdict {
    if walter >= 2.0 / 1.5 {
        Verdict::Reproduced
    } else if walter >= 1.0 {
        Verdict::Open
    } else {
        Verdict::Refuted
    }
}

fn twice() -> Result<Judged, SuiteError> {
    let all = measured()?;
    let mut figures: Vec<Figure> = Vec::new();
    for (at, lists) in [(1, "own lists"), (2, "lists by rays")] {
        for (tree, name) in [1, 2].map(|tree| (tree, TREES[tree])) {
            let [ours, theirs] = [all[0][at], all[tree][at]];
            figures.extend([
                figure(
                    format!("{lists}, {name}: waited visits over ours"),
                    theirs.waited / ours.waited.max(1.0),
                    "times",
                ),
                figure(
                    format!("{lists}, {name}: visits over ours"),
                    theirs.own / ours.own.max(1.0),
                    "times",
                ),
            ]);
        }
    }
    let walter = all[1][1].waited / all[0][1].waited.max(1.0);
    let because = format!("Walter's tree waits for {walter:.2} times as many visits");
    Ok(judged(gains(walter), because, figures))
}

/// How many times fewer visits by the revised tree and by Walter's.
fn saves(times: [f64; 2]) -> Verdict {
    if times.iter().all(|t| *t >= 10.0) {
        Verdict::Reproduced
    } else if times.iter().all(|t| *t < 5.0) {
        Verdict::Refuted
    } else {
        Verdict::Open
    }
}

fn ten_times() -> Result<Judged, SuiteError> {
    let all = measured()?;
    let mut figures = Vec::new();
    for (name, of) in TREES.into_iter().zip(all.iter()) {
        for (at, lists) in [(1, "own lists"), (2, "lists by rays")] {
            let times = of[0].own / of[at].own.max(1.0);
            figures.push(figure(format!("{name}: visits from roots over {lists}"), times, "times"));
        }
    }
    let times = [0, 1].map(|tree| all[tree][0].own / all[tree][1].own.max(1.0));
    let because = format!(
        "{:.1} times fewer by the revised tree, {:.1} times by Walter's",
        times[0], times[1]
    );
    Ok(judged(saves(times), because, figures))
}

#[cfg(test)]
mod tests {
    use super::*;
    use Verdict::{Open, Refuted, Reproduced};

    #[test]
    fn the_revised_tree_gains_or_not() {
        assert_eq!([1.4, 1.2, 0.9, f64::NAN].map(gains), [Reproduced, Open, Refuted, Refuted]);
    }

    #[test]
    fn precuts_save_or_not() {
        assert_eq!(saves([10.0, 12.0]), Reproduced);
        assert_eq!(saves([10.0, 4.0]), Open);
        assert_eq!(saves([4.0, 4.9]), Refuted);
        assert_eq!(saves([f64::NAN, 4.0]), Open);
    }

    #[test]
    fn lists_keep_their_lights_in_another_tree() {
        let case = prepared("city_small", "close_ended", &[("width", json!(24))]).unwrap();
        let town = &case.night().town;
        let mut front = front(&case, &night(&[]).unwrap()).unwrap();
        front.prepare(0).unwrap();
        let halves = LightTree::median(&town.world(false).lights).unwrap();
        let starts = moved(front.starts(), &town.lights, &halves).unwrap();
        let lights = |tree: &LightTree, nodes: &[u32]| {
            let inside = |n: &u32| *n..*n + tree.nodes[*n as usize].size;
            let nodes = nodes.iter().flat_map(inside).map(|n| tree.nodes[n as usize]);
            let mut lights: Vec<u32> = nodes.filter(|n| n.is_leaf()).map(|n| n.light).collect();
            lights.sort_unstable();
            lights
        };
        let mut compared = 0;
        for object in front.drawn() {
            let theirs = lights(&town.lights, front.starts().of(*object));
            assert_eq!(lights(&halves, starts.of(*object)), theirs, "object {object}");
            compared += usize::from(theirs.len() < town.lights.leaves.len());
        }
        assert!(compared > 3, "{compared}");
    }
}
