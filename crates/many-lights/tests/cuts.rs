//! What cuts have to be, whatever the lights, the tree and the point.
#![allow(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

mod cuts_support;

use cuts_support::{CLAMP_M, Case, case, covers, mirrored, rule, threshold};
use dapple_many_lights::{
    BoundForm, LightTree, Lightcuts, Node, Selection, bound,
    cut::{Found, Look, Member, Open, Rule, cut, recursion, walk},
};
use glam::DVec3;
use proptest::prelude::*;

/// Sums of up to some hundred numbers agree to this share.
const ROUNDING: f64 = 1e-12;

fn settings() -> impl Strategy<Value = Lightcuts> {
    let epsilon = prop::sample::select(vec![0.0, 0.005, 0.02, 0.1, f64::INFINITY]);
    let most = prop::sample::select(vec![1, 2, 5, 20, 1000]);
    let bound = prop::sample::select(vec![BoundForm::Cheap, BoundForm::Walter]);
    (epsilon, most, bound).prop_map(|(epsilon, most, bound)| Lightcuts {
        epsilon,
        most,
        selection: Selection::Heap,
        bound,
    })
}

/// The cut of the worst node first, by node.
fn worst_first(case: &Case, settings: &Lightcuts) -> (Found, Vec<Member>) {
    let size = |node: u32| case.tree.nodes[node as usize].size;
    let evaluate = |index: u32| {
        let node = &case.tree.nodes[index as usize];
        let estimate = bound::estimate(node, &case.point, CLAMP_M);
        let bound = bound::point(settings.bound, node, &case.point, CLAMP_M);
        Member { node: index, estimate, bound: if node.is_leaf() { 0.0 } else { bound } }
    };
    let mut members = Vec::new();
    let mut open = Open::new(settings.selection, 0);
    let leaf = |member: &Member| members.push(*member);
    let found = cut(settings, &case.tree.roots, size, evaluate, leaf, &mut open);
    members.extend(open.members());
    members.sort_by_key(|member| member.node);
    (found, members)
}

fn agree(a: DVec3, b: DVec3) -> bool {
    (a - b).abs().max_element() <= ROUNDING * a.abs().max(b.abs()).max_element()
}

fn sum(cut: &[(u32, Look)]) -> DVec3 {
    cut.iter().map(|(_, look)| look.estimate).sum()
}

/// P16: the error is at most the sum of the bounds of what stands for more than itself.
fn error_is_bounded(case: &Case, cut: &[(u32, Look)]) -> Result<(), String> {
    let bounds: f64 = cut.iter().map(|(_, look)| look.bound).sum();
    for (node, look) in cut.iter().filter(|(node, _)| !case.tree.nodes[*node as usize].is_leaf()) {
        if look.estimate.min_element() < 0.0 || look.estimate.max_element() > look.bound {
            return Err(format!(
                "node {node}: estimate {} outside of 0..={}",
                look.estimate, look.bound
            ));
        }
    }
    let truth = case.truth();
    let error = (sum(cut) - truth).abs().max_element();
    if error > bounds + ROUNDING * truth.max_element() {
        return Err(format!("off by {error}, bounded by {bounds}"));
    }
    Ok(())
}

proptest! {
    #[test]
    fn a_walk_looks_at_what_recursion_looks_at(case in case(40), rule in rule()) {
        let (mut walked, mut recursed) = (Vec::new(), Vec::new());
        let look = |seen: &mut Vec<(u32, Look)>, index: u32, node: &Node| {
            let look = rule.look(node, &case.receiver());
            seen.push((index, look));
            look.taken
        };
        let tree = &case.tree;
        walk(tree, &tree.roots, |index, node| look(&mut walked, index, node));
        for &root in &tree.roots {
            recursion(tree, root, &mut |index, node| look(&mut recursed, index, node));
        }
        prop_assert_eq!(walked, recursed);
    }

    #[test]
    fn cuts_cover_every_light_once(case in case(40), rule in rule(), settings in settings()) {
        let nodes = case.cut(rule);
        covers(&case.tree, nodes.iter().map(|(node, _)| *node)).map_err(TestCaseError::fail)?;
        let (_, members) = worst_first(&case, &settings);
        covers(&case.tree, members.iter().map(|m| m.node)).map_err(TestCaseError::fail)?;
    }

    #[test]
    fn without_a_threshold_all_lights_are_summed(case in case(40)) {
        let (found, truth) = (sum(&case.cut(Rule::Absolute(0.0))), case.truth());
        prop_assert!(agree(found, truth), "{found} for {truth}");
    }

    #[test]
    fn smaller_thresholds_refine(case in case(40), a in threshold(), b in threshold()) {
        let coarse = case.cut(Rule::Absolute(a.max(b)));
        let fine = case.cut(Rule::Absolute(a.min(b)));
        for (node, _) in fine {
            let above = coarse.iter().filter(|(top, _)| {
                (*top..*top + case.tree.nodes[*top as usize].size).contains(&node)
            });
            prop_assert_eq!(above.count(), 1);
        }
    }

    #[test]
    fn the_error_is_at_most_the_sum_of_the_bounds(case in case(40), rule in rule()) {
        error_is_bounded(&case, &case.cut(rule)).map_err(TestCaseError::fail)?;
    }

    #[test]
    fn no_bound_of_a_cut_exceeds_the_threshold(case in case(40), threshold in threshold()) {
        for (node, look) in case.cut(Rule::Absolute(threshold)) {
            prop_assert!(look.bound <= threshold, "node {} has {}", node, look.bound);
        }
    }

    #[test]
    fn the_worst_node_is_split_until_none_matters(case in case(40), settings in settings()) {
        let (found, members) = worst_first(&case, &settings);
        let total: DVec3 = members.iter().map(|member| member.estimate).sum();
        prop_assert!(agree(found.radiance, total));
        prop_assert_eq!(found.nodes, members.len());
        let leaves = members.iter().filter(|m| case.tree.nodes[m.node as usize].is_leaf()).count();
        prop_assert_eq!(found.leaves, leaves);
        prop_assert!(members.len() <= (settings.most as usize).max(case.tree.roots.len()));
        // A representative in the point itself gives up to 1e16 times the rest, of which the running
        // total keeps a rounding.
        let worst = members.iter().map(|member| member.bound).fold(0.0, f64::max);
        let greatest = case.lights.iter().map(|l| l.intensity.max_element()).sum::<f64>() / CLAMP_M.powi(2);
        let slack = 1e-13 * greatest;
        let met = worst <= settings.epsilon * (total.max_element() + slack) || settings.epsilon.is_infinite();
        prop_assert!(met || found.ended, "{} of {}", worst, total);
    }

    #[test]
    fn a_scan_makes_the_cut_of_the_heap(case in case(40), settings in settings()) {
        let scan = Lightcuts { selection: Selection::Scan, ..settings };
        let ((by_heap, of_heap), (by_scan, of_scan)) = (worst_first(&case, &settings), worst_first(&case, &scan));
        prop_assert_eq!(of_heap, of_scan);
        prop_assert_eq!(by_heap.ended, by_scan.ended);
    }

    #[test]
    fn the_order_of_siblings_changes_rounding_alone(case in case(40), rule in rule()) {
        let (other, order) = mirrored(&case.tree);
        let cut = case.cut(rule);
        let turned = case.cut_of(&other, rule);
        let mut nodes: Vec<u32> = turned.iter().map(|(node, _)| order[*node as usize]).collect();
        nodes.sort_unstable();
        prop_assert_eq!(nodes, cut.iter().map(|(node, _)| *node).collect::<Vec<_>>());
        prop_assert!(agree(sum(&cut), sum(&turned)));
    }

    #[test]
    fn an_endless_threshold_takes_the_roots(case in case(40)) {
        let nodes: Vec<u32> = case.cut(Rule::Absolute(f64::INFINITY)).iter().map(|(n, _)| *n).collect();
        prop_assert_eq!(&nodes, &case.tree.roots);
        let endless = Lightcuts { epsilon: 0.0, most: 1, selection: Selection::Heap, bound: case.form };
        let (found, members) = worst_first(&case, &endless);
        let nodes: Vec<u32> = members.iter().map(|member| member.node).collect();
        prop_assert_eq!(&nodes, &case.tree.roots);
        prop_assert_eq!(found.ended, members.iter().any(|member| member.bound > 0.0));
    }
}

/// The first of many drawn cases of which `fails` is true.
fn found(fails: impl Fn(&Case) -> bool) -> bool {
    let mut runner = proptest::test_runner::TestRunner::deterministic();
    let draws = case(40);
    (0..200).any(|_| {
        let tree = draws.new_tree(&mut runner).unwrap();
        fails(&proptest::strategy::ValueTree::current(&tree))
    })
}

#[test]
fn skipping_one_node_less_covers_lights_twice() {
    assert!(found(|case| {
        let mut faulty = case.tree.clone();
        faulty.nodes.iter_mut().filter(|node| node.size > 2).for_each(|node| node.size -= 1);
        let nodes = case.cut_of(&faulty, Rule::Absolute(1.0 / 255.0));
        covers(&case.tree, nodes.iter().map(|(node, _)| *node)).is_err()
    }));
}

#[test]
fn estimates_above_their_bounds_are_noticed() {
    assert!(found(|case| {
        let mut cut = case.cut(Rule::Absolute(1.0 / 255.0));
        cut.iter_mut().for_each(|(_, look)| look.estimate *= 3.0);
        error_is_bounded(case, &cut).is_err()
    }));
}

#[test]
fn an_error_above_the_sum_of_bounds_is_noticed() {
    assert!(found(|case| {
        let mut cut = case.cut(Rule::Absolute(1.0 / 255.0));
        cut.iter_mut().for_each(|(_, look)| look.bound = look.estimate.max_element());
        error_is_bounded(case, &cut).is_err()
    }));
}

#[test]
fn lights_that_are_not_there_and_single_ones_are_cut_too() {
    let none = LightTree::median(&[]).unwrap();
    assert!(none.roots.is_empty());
    walk(&none, &none.roots, |_, _| unreachable!("a tree without nodes has none to look at"));
    let mut singles = 0;
    let mut runner = proptest::test_runner::TestRunner::deterministic();
    for most in [1, 2] {
        for _ in 0..200 {
            let tree = case(most).new_tree(&mut runner).unwrap();
            let case = proptest::strategy::ValueTree::current(&tree);
            let cut = case.cut(Rule::Absolute(0.0));
            assert!(agree(sum(&cut), case.truth()));
            singles += usize::from(case.lights.len() == most);
        }
    }
    assert!(singles > 50);
}
