//! What the source says of its tree's shape, and of building it.

use super::{
    support::{cut, prepared},
    verdict::{all_of, figure, judged, vote},
};
use crate::{
    SuiteError,
    claims::{Claim, ClaimContext, Judged, Verdict},
};
use dapple_many_lights::{LightTree, tree::Representative, worlds};

/// Cities with windows alone, smallest first.
pub const CITIES: [&str; 3] = ["city_small", "city", "city_9"];

/// Levels of edges between a city and a window: block, building, facade, storey, window.
const LEVELS: usize = 5;

/// Nodes over lights of the source's tree and of a binary one.
const REVISED: f64 = 1.5;
const BINARY: f64 = 2.0;

/// Storeys and windows of Figure 3.1.
const FIGURE: [u32; 2] = [5, 3];

pub fn claims() -> Vec<Claim> {
    vec![
        Claim {
            id: "conte-H3.1",
            statement: "The revised tree has about 1.5 nodes a light where a binary one has two, and \
                        depth 5 where that has at least log2 of the lights",
            place: "Conte 2018, section 3.1 and table 5.IV",
            method: "trees over the windows of cities of three sizes: met in a city if the revised \
                     tree's nodes over its lights are nearer to 1.5 than to 2, its depth (edges) is \
                     5, and Walter's tree has 2n - 1 nodes and no less depth than halves have; \
                     contradicted in it if the revised tree has as many nodes or as much depth. All \
                     cities must agree",
            judge: Box::new(shapes),
        },
        Claim {
            id: "conte-F3.1",
            statement: "Over a facade of five storeys of three windows, the revised tree is shallower \
                        and needs fewer subdivisions until every light stands for itself",
            place: "Conte 2018, figure 3.1",
            method: "both trees over just those lights (a storey is 3 m, a window 2 m): depth, and \
                     clusters, each of which is a subdivision. Both must be smaller. The binary tree \
                     has 14 clusters whatever its shape; the revised one 6",
            judge: Box::new(facade),
        },
    ]
}

/// Nodes, lights and depth of a tree.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Shape {
    /// All nodes.
    pub nodes: usize,
    /// Leaves.
    pub lights: usize,
    /// Most edges from a root to a leaf.
    pub depth: usize,
}

impl Shape {
    /// That of a tree.
    pub fn of(tree: &LightTree) -> Self {
        let (mut ends, mut depth) = (Vec::new(), 0);
        for (index, node) in tree.nodes.iter().enumerate() {
            while ends.last().is_some_and(|end| *end <= index) {
                ends.pop();
            }
            depth = depth.max(ends.len());
            ends.push(index + node.size as usize);
        }
        Self { nodes: tree.nodes.len(), lights: tree.leaves.len(), depth }
    }

    /// Clusters: nodes that are no lights.
    pub fn inner(&self) -> usize {
        self.nodes - self.lights
    }

    fn nodes_a_light(&self) -> f64 {
        self.nodes as f64 / self.lights.max(1) as f64
    }
}

/// The least depth that a binary tree over so many lights can have.
pub fn halves(lights: usize) -> usize {
    lights.max(1).next_power_of_two().ilog2() as usize
}

/// The tree of that name over the windows of a city.
pub fn shape_of(city: &str, tree: &str) -> Result<Shape, SuiteError> {
    let case = prepared(city, "close_ended", &[])?;
    let setting = cut(tree, 0.0)?;
    let technique = super::super::settings::technique(&setting)?;
    Ok(Shape::of(&*case.tree(&technique, &setting)?))
}

/// One city's trees.
fn as_said(revised: Shape, original: Shape) -> Verdict {
    if revised.nodes >= original.nodes || revised.depth >= original.depth {
        return Verdict::Refuted;
    }
    let is_lean = revised.nodes_a_light() < 0.5 * (REVISED + BINARY);
    let is_binary = original.nodes + 1 == 2 * original.lights;
    let is_deep = original.depth >= halves(original.lights);
    let met = is_lean && revised.depth == LEVELS && is_binary && is_deep;
    if met { Verdict::Reproduced } else { Verdict::Open }
}

fn shapes(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let (mut figures, mut verdicts, mut told) = (Vec::new(), Vec::new(), Vec::new());
    for city in CITIES {
        let (revised, original) = (shape_of(city, "city")?, shape_of(city, "original")?);
        figures.extend([
            figure(format!("{city}: lights"), revised.lights as f64, ""),
            figure(format!("{city}: nodes a light, revised"), revised.nodes_a_light(), ""),
            figure(format!("{city}: nodes a light, Walter's"), original.nodes_a_light(), ""),
            figure(format!("{city}: depth, revised"), revised.depth as f64, "edges"),
            figure(format!("{city}: depth, Walter's"), original.depth as f64, "edges"),
            figure(format!("{city}: depth, halves"), halves(original.lights) as f64, "edges"),
        ]);
        told.push(format!("{:.2} and {}", revised.nodes_a_light(), revised.depth));
        verdicts.push(as_said(revised, original));
    }
    let because = format!("nodes a light and depth of the revised tree are {}", told.join(", "));
    Ok(judged(all_of(&verdicts), because, figures))
}

/// Depth and subdivisions of the revised tree and of Walter's.
fn smaller(revised: Shape, original: Shape) -> Verdict {
    let is = [revised.depth < original.depth, revised.inner() < original.inner()];
    vote(&is)
}

fn facade(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let [storeys, windows] = FIGURE;
    let facade = worlds::Facade { storeys, windows, ..worlds::Facade::default() };
    let (made, paths) = worlds::facade(&facade);
    let lights = &made.world.lights;
    let revised = Shape::of(&LightTree::by_keys(lights, &paths)?);
    let original = Shape::of(&LightTree::original(lights, Representative::Weighted)?);
    let figures = vec![
        figure("lights", revised.lights as f64, ""),
        figure("depth, revised", revised.depth as f64, "edges"),
        figure("depth, Walter's", original.depth as f64, "edges"),
        figure("subdivisions to every light, revised", revised.inner() as f64, ""),
        figure("subdivisions to every light, Walter's", original.inner() as f64, ""),
    ];
    let because = format!(
        "{} against {} edges deep, {} against {} subdivisions",
        revised.depth,
        original.depth,
        revised.inner(),
        original.inner()
    );
    Ok(judged(smaller(revised, original), because, figures))
}

#[cfg(test)]
mod tests {
    use super::*;
    use Verdict::{Open, Refuted, Reproduced};

    fn shape(nodes: usize, lights: usize, depth: usize) -> Shape {
        Shape { nodes, lights, depth }
    }

    #[test]
    fn shapes_are_as_said_or_not() {
        let original = shape(1999, 1000, 14);
        assert_eq!(as_said(shape(1500, 1000, 5), original), Reproduced);
        assert_eq!(as_said(shape(1800, 1000, 5), original), Open);
        assert_eq!(as_said(shape(1500, 1000, 6), original), Open);
        assert_eq!(as_said(shape(1500, 1000, 14), original), Refuted);
        assert_eq!(as_said(shape(2000, 1000, 5), original), Refuted);
        assert_eq!(as_said(shape(1500, 1000, 5), shape(1998, 1000, 14)), Open);
        assert_eq!(as_said(shape(1500, 1000, 5), shape(1999, 1000, 9)), Open);
    }

    #[test]
    fn facades_need_less_or_more() {
        assert_eq!(smaller(shape(21, 15, 2), shape(29, 15, 5)), Reproduced);
        assert_eq!(smaller(shape(21, 15, 5), shape(29, 15, 5)), Open);
        assert_eq!(smaller(shape(29, 15, 5), shape(29, 15, 5)), Refuted);
    }

    #[test]
    fn halves_are_as_shallow_as_can_be() {
        assert_eq!([0, 1, 2, 3, 39_202].map(halves), [0, 0, 1, 2, 16]);
        let case = prepared("light_facade", "", &[]).unwrap();
        let lights = &case.world().lights;
        let median = Shape::of(&LightTree::median(lights).unwrap());
        assert_eq!(median.depth, halves(lights.len()));
        assert_eq!((median.lights, median.inner()), (lights.len(), lights.len() - 1));
        assert_eq!(Shape::of(&LightTree::default()), Shape::default());
    }
}
