//! Shadows on planes: P2 to P5, P7, and where they end.

use super::{
    ALL,
    model::{any_corner, corners},
    worlds::{self, Wanted},
};
use crate::{
    SuiteError,
    verify::{About, Gate, GateContext, Tally, gate, rng},
};
use dapple_many_lights::region::{
    Cuboid, Direction, Edge, Fusion, OccluderMode,
    fusion::{Horizon, reference::Shadow},
    horizon::{Umbra, reproject, umbra, union_of_edges},
};
use rand::{RngExt, seq::SliceRandom};
use rand_pcg::Pcg64;

const FUSIONS: [Fusion; 3] = [Fusion::None, Fusion::Insertion, Fusion::HeightOrdered];
const EDGES: [Edge; 3] = [Edge::Flat, Edge::Sloped, Edge::Hull];

/// Share of the coordinates by which boxes are larger where it is asked what they hide: two that touch
/// hide together, however a ray between them is rounded.
const TOUCH: f64 = 1e-9;

/// Share of a shadow from its borders that is looked at beside them.
const BESIDE: f64 = 1e-6;

/// Share of the coordinates by which edges may be off: ends are rounded, and edges may be steep there.
const STRAIGHT: f64 = 1e-6;

/// Worlds of a gate, at least: each has many planes.
const WORLDS: u32 = 24;

pub fn gates() -> Vec<Gate> {
    let about =
        |name, statement, fault| About { technique: "facade-cluster", name, statement, fault };
    let own = |name, statement, fault| About { technique: ALL, name, statement, fault };
    vec![
        gate(
            about(
                "P2 shadows",
                "every point of every shadow, joined and moved from plane to plane, is hidden by some \
                 occluder from every corner of the cell, and from anywhere in it",
                "shadows are joined across gaps",
            ),
            |context, faulty| hidden(context, faulty, false),
        ),
        gate(
            about(
                "P7 any order",
                "the same when shadows arrive one by one in any order",
                "shadows are joined across gaps",
            ),
            |context, faulty| hidden(context, faulty, true),
        ),
        gate(
            about(
                "P3 trees",
                "on the plane where they are joined, shadows lie within the interval of the one that \
                 holds them and are as high at least; roots without feet do not meet, on later planes \
                 neither",
                "shadows and those that hold them change places, and roots are as wide as two",
            ),
            trees,
        ),
        gate(
            own(
                "P4 moved",
                "a level shadow that is moved is the one of the farther plane, by one step or by two",
                "the cell has grown by a tenth of its width when it is moved",
            ),
            moved,
        ),
        gate(
            own(
                "P5 closed form",
                "a shadow is exactly what all corners of the cell see hidden: inside nothing is seen, \
                 beside every border something is",
                "a shadow is what any corner sees hidden",
            ),
            closed,
        ),
        gate(
            own(
                "collapse",
                "the shadow of a flat occluder of width o at distance D of a flat cell of width v > o \
                 ends at Dv / (v - o)",
                "the cell is a hundredth wider",
            ),
            collapse,
        ),
        gate(
            own(
                "edges",
                "the single edge lies below the whole one, that is the one by definition, and no \
                 horizon has more than three edges",
                "the single edge is as high as the whole one is at its highest",
            ),
            edges,
        ),
    ]
}

/// A cell in the space of a direction, and what stands behind it.
struct Scene {
    cell: Cuboid,
    solids: Vec<Cuboid>,
}

fn scene(context: &GateContext<'_>, number: u32, rng: &mut Pcg64) -> Result<Scene, SuiteError> {
    let world = worlds::random(context.seed, number, Wanted { omni: true, floating: true })?;
    let direction = Direction::ALL[rng.random_range(0..4)];
    let turned = world.occluders.turned(world.cell.turn, OccluderMode::Leaf);
    let solids = turned.solids.iter().map(|s| direction.cuboid(s.min, s.max));
    let cell = world.face(direction).unwrap_or(Cuboid { u: [0.0; 2], w: [0.0; 2], h: [0.0; 2] });
    let mut solids: Vec<Cuboid> = solids.filter(|s| s.w[1] > cell.w[1]).collect();
    solids.sort_by(|a, b| a.w[1].total_cmp(&b.w[1]));
    Ok(Scene { cell, solids })
}

/// Whether a segment meets a box or the part of it before a plane; what touches meets.
fn blocks(solid: &Cuboid, from: [f64; 3], to: [f64; 3]) -> bool {
    let size = |ends: [f64; 2]| TOUCH * ends[0].abs().max(ends[1].abs());
    let by = [solid.u, solid.w].map(size).into_iter().fold(TOUCH * (to[1] - from[1]), f64::max);
    let (mut first, mut last) = (0.0_f64, 1.0_f64);
    for (axis, ends) in [solid.u, solid.w, solid.h].into_iter().enumerate() {
        let [low, high] = [ends[0] - by, ends[1] + by];
        let (start, way) = (from[axis], to[axis] - from[axis]);
        if way == 0.0 {
            if start < low || start > high {
                return false;
            }
            continue;
        }
        let (a, b) = ((low - start) / way, (high - start) / way);
        first = first.max(a.min(b));
        last = last.min(a.max(b));
    }
    first <= last
}

fn point(of: &Cuboid) -> [f64; 3] {
    [of.u[0], of.w[0], of.h[0]]
}

fn between([low, high]: [f64; 2], share: f64) -> f64 {
    ((1.0 - share) * low + share * high).clamp(low, high)
}

/// Corners of a cell and points anywhere in it.
fn eyes(cell: &Cuboid, rng: &mut Pcg64) -> Vec<[f64; 3]> {
    let mut eyes: Vec<[f64; 3]> = corners(cell).iter().map(point).collect();
    eyes.extend((0..4).map(|_| [cell.u, cell.w, cell.h].map(|side| between(side, rng.random()))));
    eyes
}

/// Points of a shadow: beside its ends and anywhere, up to its edge.
fn points(shadow: &Umbra, lowest: f64, rng: &mut Pcg64) -> Vec<[f64; 2]> {
    let shares = [BESIDE, 1.0 - BESIDE, 0.5, rng.random(), rng.random()];
    let mut points = Vec::new();
    for u in shares.map(|share| between(shadow.u, share)) {
        let top = shadow.height(u);
        let foot = shadow.foot.max(lowest.min(top - 1.0));
        if foot <= top {
            points
                .extend([1.0 - BESIDE, rng.random()].map(|share| [u, between([foot, top], share)]));
        }
    }
    points
}

/// All shadows on planes, held against rays.
fn hidden(context: &GateContext<'_>, faulty: bool, one_by_one: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    let more = if context.deep { 20 } else { 1 };
    for number in 0..context.cases.max(WORLDS) * more {
        if faulty && tally.failed > 0 {
            break;
        }
        let mut rng = rng(context.seed, "P2", number);
        let Scene { cell, solids } = scene(context, number, &mut rng)?;
        let fusion = FUSIONS[1 + rng.random_range(0..2)];
        let fusion = if number % 5 == 0 { Fusion::None } else { fusion };
        let edge = EDGES[rng.random_range(0..3)];
        let mut horizon = Horizon::new(fusion);
        let mut plane = cell.w[1];
        let mut planes: Vec<f64> = solids.iter().map(|s| s.w[1]).collect();
        planes.dedup();
        // The plane of some occluders is passed over.
        planes.retain(|_| rng.random_bool(0.6));
        for next in planes {
            horizon.reproject(&cell, plane, next);
            let before: Vec<&Cuboid> = solids.iter().filter(|s| s.w[0] <= next).collect();
            let new = before.iter().filter(|s| s.w[1] > plane);
            let mut shadows: Vec<Umbra> = new.filter_map(|s| umbra(&cell, s, next, edge)).collect();
            if one_by_one {
                shadows.shuffle(&mut rng);
                shadows.iter().for_each(|shadow| horizon.add(&[*shadow]));
            } else {
                horizon.add(&shadows);
            }
            plane = next;
            let mut all: Vec<Umbra> = horizon.nodes().collect();
            if faulty {
                all = across_gaps(&shadows);
            }
            let eyes = eyes(&cell, &mut rng);
            for shadow in &all {
                for [u, h] in points(shadow, cell.h[0], &mut rng) {
                    let eye = eyes[rng.random_range(0..eyes.len())];
                    let to = [u, plane, h];
                    let is_hidden = before.iter().any(|s| blocks(s, eye, to));
                    tally.check(is_hidden, || {
                        format!("world {number}, {fusion:?} {edge:?}: {to:?} is seen from {eye:?}")
                    });
                }
            }
        }
    }
    Ok(tally)
}

/// Neighbours from end to end, whether they meet or not.
fn across_gaps(shadows: &[Umbra]) -> Vec<Umbra> {
    let pairs = shadows.iter().zip(shadows.iter().skip(1));
    let joined = pairs.map(|(a, b)| {
        let u = [a.u[0].min(b.u[0]), a.u[1].max(b.u[1])];
        Umbra::flat(u, a.foot.max(b.foot), a.lowest().min(b.lowest()))
    });
    joined.filter(|umbra| umbra.foot < umbra.highest()).collect()
}

fn trees(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for number in 0..context.cases.max(WORLDS) {
        let mut rng = rng(context.seed, "P3", number);
        let Scene { cell, mut solids } = scene(context, number, &mut rng)?;
        // Those with feet need not be joined where they meet.
        solids.iter_mut().for_each(|solid| solid.h[0] = f64::NEG_INFINITY);
        let mut planes: Vec<f64> = solids.iter().map(|s| s.w[1]).collect();
        planes.dedup();
        for fusion in [Fusion::Insertion, Fusion::HeightOrdered] {
            let mut horizon = Horizon::new(fusion);
            let mut plane = cell.w[1];
            for &next in &planes {
                horizon.reproject(&cell, plane, next);
                check_roots(&mut tally, &horizon.roots(), faulty, "moved");
                let new = solids.iter().filter(|s| s.w[1] > plane && s.w[0] <= next);
                let shadows: Vec<Umbra> =
                    new.filter_map(|s| umbra(&cell, s, next, Edge::Flat)).collect();
                // Only what is joined now: what was joined before may have shrunk apart.
                let mut alone = Horizon::new(fusion);
                alone.add(&shadows);
                let roots = alone.roots();
                check_roots(&mut tally, &roots, faulty, "joined");
                roots.iter().for_each(|root| check_children(&mut tally, root, faulty));
                horizon.add(&shadows);
                check_roots(&mut tally, &horizon.roots(), faulty, "added");
                plane = next;
            }
        }
    }
    Ok(tally)
}

fn check_roots(tally: &mut Tally, roots: &[Shadow], faulty: bool, when: &str) {
    for pair in roots.windows(2) {
        let end = if faulty { pair[1].umbra.u[1] } else { pair[0].umbra.u[1] };
        tally.check(end < pair[1].umbra.u[0], || {
            format!("{when}: {:?} and {:?}", pair[0].umbra, pair[1].umbra)
        });
    }
}

fn check_children(tally: &mut Tally, parent: &Shadow, faulty: bool) {
    for child in &parent.children {
        let [outer, inner] = match faulty {
            false => [&parent.umbra, &child.umbra],
            true => [&child.umbra, &parent.umbra],
        };
        let is_within = outer.u[0] <= inner.u[0] && inner.u[1] <= outer.u[1];
        let is_lower = outer.lowest() <= inner.lowest() && outer.foot >= inner.foot;
        tally.check(is_within && is_lower, || format!("{inner:?} in {outer:?}"));
        check_children(tally, child, faulty);
    }
}

/// Relative to what lengths are there.
fn apart(a: &Umbra, b: &Umbra, size: f64) -> f64 {
    let ends = [a.u[0] - b.u[0], a.u[1] - b.u[1], a.lowest() - b.lowest()];
    let foot = if a.foot == b.foot { 0.0 } else { a.foot - b.foot };
    ends.into_iter().chain([foot]).map(|off| off.abs() / size).fold(0.0, f64::max)
}

fn moved(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for number in 0..context.cases.max(WORLDS) {
        let mut rng = rng(context.seed, "P4", number);
        let Scene { cell, solids } = scene(context, number, &mut rng)?;
        let width = 0.1 * (1.0 + cell.u[1] - cell.u[0]);
        let wrong = Cuboid { u: [cell.u[0], cell.u[1] + width], ..cell };
        let by = if faulty { &wrong } else { &cell };
        for solid in solids.iter().filter(|s| s.w[0] > cell.w[1]) {
            let first = solid.w[1];
            let reach = first - cell.w[0];
            let second = first + reach * rng.random_range(0.0..2.0);
            let third = second + reach * rng.random_range(0.0..2.0);
            let on = |plane| umbra(&cell, solid, plane, Edge::Flat);
            let Some(start) = on(first) else { continue };
            let once = reproject(by, &start, first, third);
            let twice = reproject(by, &start, first, second)
                .and_then(|shadow| reproject(by, &shadow, second, third));
            for (what, moved) in [("one step", once), ("two steps", twice)] {
                let Some(direct) = on(third) else { continue };
                let size = [direct.u[0], direct.u[1], direct.lowest(), third - cell.w[0]];
                let size = size.into_iter().map(f64::abs).fold(0.0, f64::max);
                let is_thin =
                    (direct.u[1] - direct.u[0]).min(direct.highest() - direct.foot) <= 1e-9 * size;
                match moved {
                    Some(moved) => tally.within(apart(&moved, &direct, size), 1e-6, || {
                        format!("case {number}: {what}: {moved:?} for {direct:?}")
                    }),
                    None => tally.check(is_thin, || format!("case {number}: {what}: {direct:?}")),
                }
            }
        }
    }
    Ok(tally)
}

fn closed(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for number in 0..context.cases.max(WORLDS) {
        let mut rng = rng(context.seed, "P5", number);
        let Scene { cell, mut solids } = scene(context, number, &mut rng)?;
        solids.retain(|s| s.w[0] > cell.w[1] && s.h[0] < cell.h[0]);
        for solid in &solids {
            let plane = solid.w[1] + (solid.w[1] - cell.w[0]) * rng.random_range(0.0..2.0);
            // Of one that is lower than the cell's top the far face counts alone.
            let standing = match solid.h[1] < cell.h[1] {
                true => Cuboid { w: [solid.w[1]; 2], ..*solid },
                false => *solid,
            };
            let found = match faulty {
                false => umbra(&cell, solid, plane, Edge::Flat),
                true => any_corner(&cell, solid, plane),
            };
            let Some(found) = found else { continue };
            let eyes: Vec<[f64; 3]> = corners(&cell).iter().map(point).collect();
            let is_hidden =
                |u: f64, h: f64| eyes.iter().all(|eye| blocks(&standing, *eye, [u, plane, h]));
            for [u, h] in points(&found, cell.h[0], &mut rng) {
                tally.check(is_hidden(u, h), || format!("case {number}: {u} {h} is seen"));
            }
            let top = found.lowest();
            let size = found.u[0].abs().max(found.u[1].abs()).max(top.abs()).max(plane - cell.w[0]);
            let step = BESIDE * size;
            let low = top - 0.5 * (top - solid.h[0].max(cell.h[0]).min(top)) - step;
            let beside = [found.u[0] - step, found.u[1] + step];
            for u in beside {
                tally.check(!is_hidden(u, low), || format!("case {number}: {u} {low} is hidden"));
            }
            // Somewhere along the level edge what is above it is seen; of a deep box whose side is
            // seen past, the level edge is lower than it might be.
            let is_wide = solid.u[0] <= cell.u[0] && solid.u[1] >= cell.u[1];
            if !is_wide && standing.w[0] < standing.w[1] {
                continue;
            }
            let steps = 64;
            let along = (0..=steps).map(|i| between(found.u, f64::from(i) / f64::from(steps)));
            let mut knees: Vec<f64> = along.collect();
            for eye in &eyes {
                for (u, w) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                    let k = (plane - eye[1]) / (standing.w[w] - eye[1]);
                    knees.push(eye[0] + k * (standing.u[u] - eye[0]));
                }
            }
            let inside = knees.into_iter().filter(|u| (found.u[0]..=found.u[1]).contains(u));
            let is_seen = inside.into_iter().any(|u| !is_hidden(u, top + step));
            tally.check(is_seen, || format!("case {number}: above {top} all is hidden"));
        }
    }
    Ok(tally)
}

fn collapse(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for number in 0..context.cases {
        let mut rng = rng(context.seed, "collapse", number);
        let width = rng.random_range(1.0..20.0);
        let occluder = width * rng.random_range(0.05..0.95);
        let distance = rng.random_range(1.0..50.0);
        let middle = rng.random_range(-5.0..5.0);
        let end = distance * width / (width - occluder);
        let asked = if faulty { 1.01 * width } else { width };
        let around = |width: f64| [middle - 0.5 * width, middle + 0.5 * width];
        let cell = Cuboid { u: around(asked), w: [0.0; 2], h: [0.0, 3.0] };
        let h = [f64::NEG_INFINITY, 1e3];
        let wall = Cuboid { u: around(occluder), w: [distance; 2], h };
        for (share, is_there) in [(1.0 - 1e-6, true), (1.0 + 1e-6, false)] {
            let plane = share * end;
            let direct = umbra(&cell, &wall, plane, Edge::Flat);
            let moved = umbra(&cell, &wall, distance, Edge::Flat)
                .and_then(|shadow| reproject(&cell, &shadow, distance, plane));
            for found in [direct, moved] {
                tally.check(found.is_some() == is_there, || {
                    format!("case {number}: at {share} of the end: {found:?}")
                });
            }
        }
    }
    Ok(tally)
}

fn edges(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for number in 0..context.cases.max(WORLDS) {
        let mut rng = rng(context.seed, "edges", number);
        let Scene { cell, solids } = scene(context, number, &mut rng)?;
        // What nearly touches the cell throws its edges as far as any rounding.
        let least = 1e-6 * solids.last().map_or(0.0, |far| far.w[1] - cell.w[0]);
        let apart = |s: &&Cuboid| s.w[0] > cell.w[1] + least && s.h[0] <= cell.h[0];
        for solid in solids.iter().filter(apart) {
            let plane = solid.w[1] + (solid.w[1] - cell.w[0]) * rng.random_range(0.0..2.0);
            let edges = union_of_edges(&cell, solid).len();
            tally.within(edges as f64, 3.0, || format!("case {number}: edges of {solid:?}"));
            let on = |edge| umbra(&cell, solid, plane, edge);
            let (Some(single), Some(whole)) = (on(Edge::Sloped), on(Edge::Hull)) else { continue };
            let single = match faulty {
                true => Umbra::flat(single.u, single.foot, whole.highest() + 1.0),
                false => single,
            };
            for _ in 0..8 {
                let share = rng.random();
                let (u, size) = (between(whole.u, share), size(&whole, plane - cell.w[0]));
                let off = (whole.height(u) - edge_at(&cell, solid, plane, u)).abs() / size;
                tally.within(off, STRAIGHT, || format!("case {number}: whole edge at {u}"));
                let (u, size) = (between(single.u, share), size.max(single.highest().abs()));
                let above = (single.height(u) - edge_at(&cell, solid, plane, u)) / size;
                tally.within(above, STRAIGHT, || format!("case {number}: single edge at {u}"));
            }
        }
    }
    Ok(tally)
}

/// The greatest coordinate that a shadow's edge depends on.
fn size(of: &Umbra, depth: f64) -> f64 {
    of.u.into_iter().chain(of.top).chain([of.highest()]).fold(depth, |a, b| a.max(b.abs()))
}

/// Height at `u` of what all corners of a cell's top see hidden by a box, by definition: over each corner
/// the highest line between two corners of the box's top, and the lowest of these.
fn edge_at(cell: &Cuboid, solid: &Cuboid, plane: f64, u: f64) -> f64 {
    let over = |eye: [f64; 2]| {
        let corners = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(side, face)| {
            let k = (plane - eye[1]) / (solid.w[face] - eye[1]);
            [eye[0] + k * (solid.u[side] - eye[0]), cell.h[1] + k * (solid.h[1] - cell.h[1])]
        });
        let mut highest = f64::NEG_INFINITY;
        for a in corners {
            for b in corners {
                if a[0] <= u && u <= b[0] {
                    let share = if b[0] > a[0] { (u - a[0]) / (b[0] - a[0]) } else { 0.0 };
                    highest = highest.max((1.0 - share) * a[1] + share * b[1]);
                }
            }
        }
        highest
    };
    let eyes = cell.u.into_iter().flat_map(|u| cell.w.map(|w| [u, w]));
    eyes.map(over).fold(f64::INFINITY, f64::min)
}
