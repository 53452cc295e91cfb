//! The original tree, join by join.

use super::{input, trees::cloud};
use crate::{
    SuiteError,
    verify::{GateContext, Tally},
};
use dapple_many_lights::{
    Emission, Light, LightTree,
    cut::children,
    tree::{Build, Representative},
    worlds::WINDOW,
};
use glam::{DQuat, DVec3};
use std::f64::consts::PI;

/// Share by which a join may cost more than the least one: costs are rounded.
const ROUNDING: f64 = 1e-6;

/// Edges from a root to its deepest leaf.
pub fn depth(tree: &LightTree) -> usize {
    let mut ends: Vec<usize> = Vec::new();
    let mut deepest = 0;
    for (index, node) in tree.nodes.iter().enumerate() {
        ends.retain(|&end| end > index);
        deepest = deepest.max(ends.len());
        ends.push(index + node.size as usize);
    }
    deepest
}

/// The angle between unit vectors, radians.
pub fn angle(a: DVec3, b: DVec3) -> f64 {
    a.cross(b).length().atan2(a.dot(b))
}

/// What Eq. 2.2 knows of a cluster.
#[derive(Clone, Copy)]
struct Cluster {
    min: DVec3,
    max: DVec3,
    luminance: f64,
    axis: DVec3,
    /// Half the opening of the least cone around those of its parts.
    cone_rad: f64,
}

impl Cluster {
    fn of(light: &Light) -> Self {
        let (min, max, axis) = (light.position, light.position, light.axis);
        Self { min, max, luminance: light.luminance(), axis, cone_rad: 0.0 }
    }

    fn joined(&self, other: &Self) -> Self {
        let apart = angle(self.axis, other.axis);
        let half = 0.5 * (self.cone_rad + other.cone_rad + apart);
        let (axis, cone_rad) = if half <= self.cone_rad {
            (self.axis, self.cone_rad)
        } else if half <= other.cone_rad {
            (other.axis, other.cone_rad)
        } else if half >= PI {
            (self.axis, PI)
        } else {
            let about = self.axis.cross(other.axis).try_normalize();
            let about = about.unwrap_or_else(|| self.axis.any_orthonormal_vector());
            (DQuat::from_axis_angle(about, half - self.cone_rad) * self.axis, half)
        };
        Self {
            min: self.min.min(other.min),
            max: self.max.max(other.max),
            luminance: self.luminance + other.luminance,
            axis,
            cone_rad,
        }
    }

    /// I (α² + c² (1 - cos β)²) of both together.
    fn cost(&self, other: &Self, c_squared: f64) -> f64 {
        let both = self.joined(other);
        let turned = (1.0 - both.cone_rad.cos()).powi(2);
        both.luminance * ((both.max - both.min).length_squared() + c_squared * turned)
    }
}

/// Holds every join of a tree against all pairs that there were.
fn joins(lights: &[Light], tree: &LightTree, c_squared: f64, tally: &mut Tally) {
    let count = tree.nodes.len();
    let mut clusters: Vec<Option<Cluster>> = tree
        .nodes
        .iter()
        .map(|node| node.is_leaf().then(|| Cluster::of(&lights[node.light as usize])))
        .collect();
    let mut alive: Vec<usize> = (0..count).filter(|&i| clusters[i].is_some()).collect();
    let cost = |clusters: &[Option<Cluster>], a: usize, b: usize| match (&clusters[a], &clusters[b])
    {
        (Some(a), Some(b)) => a.cost(b, c_squared),
        _ => f64::INFINITY,
    };
    let mut costs = vec![f64::INFINITY; count * count];
    for &a in &alive {
        for &b in alive.iter().filter(|&&b| a < b) {
            costs[a * count + b] = cost(&clusters, a, b);
        }
    }
    let pair = |node: usize| {
        let mut below = children(node as u32, |n| tree.nodes[n as usize].size);
        below.next().zip(below.next()).map(|(a, b)| (a as usize, b as usize))
    };
    let mut left: Vec<(usize, (usize, usize))> =
        (0..count).filter_map(|node| Some((node, pair(node)?))).collect();
    while alive.len() > 1 {
        let all = alive.iter().flat_map(|&a| alive.iter().map(move |&b| a * count + b));
        let least = all.map(|at| costs[at]).fold(f64::INFINITY, f64::min);
        let next =
            left.iter().enumerate().map(|(place, (_, (a, b)))| (costs[a * count + b], place));
        let Some((given, place)) = next.min_by(|a, b| a.0.total_cmp(&b.0)) else { break };
        tally.check(given <= least * (1.0 + ROUNDING), || {
            format!("{} clusters left: a join costs {given}, the least {least}", alive.len())
        });
        let (node, (a, b)) = left.swap_remove(place);
        clusters[node] = clusters[a].zip(clusters[b]).map(|(a, b)| a.joined(&b));
        for gone in [a, b] {
            alive.retain(|&one| one != gone);
        }
        for &other in &alive {
            let at = node.min(other) * count + node.max(other);
            costs[at] = cost(&clusters, node, other);
        }
        alive.push(node);
    }
    tally.check(alive.len() == 1, || format!("{} clusters are never joined", alive.len()));
}

/// Row 34.
///
/// # Errors
/// None for these lights.
pub fn gate(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for number in 0..input::cases(context, 8, faulty) {
        let mut rng = input::rng(context.seed, "greedy", number);
        let count = [200, 2, 3, 17, 60, 100, 150, 5][number as usize % 8];
        let emission = if number % 3 == 1 { Emission::Omni } else { WINDOW };
        let spread = [1.0, 0.0, 3.0][number as usize % 3];
        let lights = cloud(&mut rng, count, emission);
        let build = if faulty { Build::Median } else { Build::Greedy { spread } };
        let tree = LightTree::build(&lights, build, Representative::Weighted)?;
        let nodes = tree.nodes.len();
        tally.check(nodes == 2 * count - 1, || format!("{count} lights: {nodes} nodes"));
        let min = lights.iter().map(|l| l.position).fold(DVec3::INFINITY, DVec3::min);
        let max = lights.iter().map(|l| l.position).fold(DVec3::NEG_INFINITY, DVec3::max);
        let c = if emission == Emission::Omni { 0.0 } else { spread * (max - min).length() };
        joins(&lights, &tree, c * c, &mut tally);
    }
    Ok(tally)
}
