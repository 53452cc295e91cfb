//! P3: parents lie across their children, no higher than they, and roots beside each other.

use dapple_many_lights::region::fusion::{join, reference::Shadow};
use dapple_many_lights::region::horizon::Umbra;

/// Relative to the size of coordinates: shadows are moved with their own roundings.
const ROUNDING: f64 = 1e-13;

fn size(umbra: &Umbra) -> f64 {
    let foot = if umbra.foot.is_finite() { umbra.foot } else { 0.0 };
    let numbers = [umbra.u[0], umbra.u[1], umbra.top[0], umbra.top[1], foot];
    numbers.into_iter().fold(1.0, |size, number| number.abs().max(size))
}

/// A child that reaches out of its parent, or is lower than it. Edges that are not level may sink
/// below their parents as they are moved: they lose height.
fn broken_parent(shadow: &Shadow, roots: Roots) -> Option<String> {
    let parent = &shadow.umbra;
    shadow.children.iter().find_map(|child| {
        let umbra = &child.umbra;
        let slack = ROUNDING * size(parent);
        let beside = parent.u[0] <= umbra.u[0] + slack && umbra.u[1] - slack <= parent.u[1];
        let may_sink = roots != Roots::Joined && !umbra.is_flat();
        let above = may_sink || parent.highest() <= umbra.lowest() + slack;
        let below = umbra.foot <= parent.foot + slack;
        match beside && above && below {
            true => broken_parent(child, roots),
            false => Some(format!("{umbra:?} in {parent:?}")),
        }
    })
}

/// Whether a level shadow lies wholly within another one.
fn adds_nothing(joined: &Umbra, to: &Umbra) -> bool {
    let beside = to.u[0] <= joined.u[0] && joined.u[1] <= to.u[1];
    beside && joined.highest() <= to.lowest() && to.foot <= joined.foot
}

/// What roots may have in common.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Roots {
    /// Anything: no shadow is joined.
    Single,
    /// Nothing, but for such as cannot be joined, or hide no more together.
    Joined,
    /// Nothing but an end, as moving rounds, and for such as cannot be joined.
    JoinedAndMoved,
    /// Anything: parents may have left their children.
    Moved,
}

/// What is wrong with trees: no shadow is empty, parents are right, and so are roots.
pub fn broken(trees: &[Shadow], roots: Roots) -> Option<String> {
    let empty = |s: &Shadow| !(s.umbra.u[0] < s.umbra.u[1] && s.umbra.foot < s.umbra.highest());
    let mut open: Vec<&Shadow> = trees.iter().collect();
    while let Some(shadow) = open.pop() {
        if empty(shadow) {
            return Some(format!("empty: {:?}", shadow.umbra));
        }
        if roots == Roots::Single && !shadow.children.is_empty() {
            return Some(format!("joined: {:?}", shadow.umbra));
        }
        open.extend(&shadow.children);
    }
    let slack = match roots {
        Roots::Joined => 0.0,
        Roots::JoinedAndMoved => ROUNDING,
        Roots::Single | Roots::Moved => f64::INFINITY,
    };
    let pairs = trees.iter().enumerate().flat_map(|(n, a)| trees[..n].iter().map(move |b| (a, b)));
    let mut overlaps = pairs.filter_map(|(a, b)| {
        let joined = join(&a.umbra, &b.umbra)?;
        if adds_nothing(&joined, &a.umbra) || adds_nothing(&joined, &b.umbra) {
            return None;
        }
        let overlap = a.umbra.u[1].min(b.umbra.u[1]) - a.umbra.u[0].max(b.umbra.u[0]);
        let is_fault = slack == 0.0 || overlap > slack * size(&joined);
        is_fault.then(|| format!("not joined: {:?} {:?}", a.umbra, b.umbra))
    });
    trees.iter().find_map(|tree| broken_parent(tree, roots)).or_else(|| overlaps.next())
}

#[test]
fn faults_of_trees_are_found() {
    let leaf = |u, foot, top| Shadow { umbra: Umbra::flat(u, foot, top), children: Vec::new() };
    let above = |umbra: Umbra, children: &[Shadow]| Shadow { umbra, children: children.to_vec() };
    let low = f64::NEG_INFINITY;
    let [a, b] = [leaf([0.0, 2.0], low, 5.0), leaf([2.0, 3.0], low, 4.0)];
    let parent = Umbra::flat([0.0, 3.0], low, 4.0);
    let family = [a.clone(), b.clone()];
    assert_eq!(broken(&[above(parent, &family)], Roots::Joined), None);
    assert_eq!(broken(&[a.clone(), leaf([2.1, 3.0], low, 4.0)], Roots::Joined), None);
    assert_eq!(broken(&[a.clone(), leaf([1.0, 3.0], 6.0, 8.0)], Roots::Joined), None);
    assert!(broken(&family, Roots::Joined).is_some());
    assert_eq!(broken(&family, Roots::Single), None);
    assert_eq!(broken(&[a.clone(), leaf([0.5, 1.0], low, 3.0)], Roots::Joined), None);
    assert!(broken(&[above(parent, &family)], Roots::Single).is_some());
    for wrong in [
        Umbra::flat([0.1, 3.0], low, 4.0),
        Umbra::flat([0.0, 2.9], low, 4.0),
        Umbra::flat([0.0, 3.0], low, 4.1),
        Umbra::flat([3.0, 0.0], low, 4.0),
    ] {
        assert!(broken(&[above(wrong, &family)], Roots::Joined).is_some(), "{wrong:?}");
    }
    let footed = leaf([0.0, 1.0], 1.0, 5.0);
    assert!(broken(&[above(parent, &[footed])], Roots::Joined).is_some());
}
