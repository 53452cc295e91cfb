//! Shadows of single occluders: edges, what one edge loses, and how long joined shadows last.

use super::verdict::{figure, judged};
use crate::{
    SuiteError,
    claims::{Claim, ClaimContext, Figure, Judged, Verdict},
};
use dapple_many_lights::{
    region::{
        Cuboid, Edge, Fusion,
        fusion::Horizon,
        horizon::{Umbra, hull, umbra, union_of_edges},
    },
    sample::Random,
};

/// Draws of cells and occluders.
const DRAWS: u32 = 4000;

/// From a cell's front to an occluder's, metres.
const DISTANCES_M: [f64; 6] = [5.0, 10.0, 20.0, 40.0, 80.0, 160.0];

/// Share of a distance that is surely more than rounding.
const BEYOND: f64 = 1e-6;

pub fn claims() -> Vec<Claim> {
    vec![
        Claim {
            id: "conte-H4.2",
            statement: "What a single edge loses of an occluder's shadow shrinks with its distance",
            place: "Conte 2018, section 4.2.3",
            method: "4,000 cells and buildings by chance (cells 5 to 20 m wide, of 1 to 7 storeys), \
                     each at 5 to 160 m: area above ground of the shadow with one edge over that with \
                     all of them, on the plane at the far face. Met if the loss falls with every \
                     doubling, contradicted if it is not less at the end than at the start. The level \
                     edge, which is ours, stands beside",
            judge: Box::new(distance),
        },
        Claim {
            id: "conte-H4.6",
            statement: "An upright cell and an upright box make at most three horizon edges",
            place: "Conte 2018, section 4.2.3",
            method: "the union of edges over the cell's top, and the edge of the exact umbra, for 4,000 \
                     cells and boxes by chance: more than three in any contradicts. It is the top that \
                     counts: with points below the roof and above it there are four",
            judge: Box::new(edges),
        },
        Claim {
            id: "conte-H4.4",
            statement: "Joined shadows outlive those that they are made of",
            place: "Conte 2018, section 4.2.5 and figure 4.9",
            method: "4,000 pairs of touching walls by chance, each narrower than the cell: the shadow \
                     of one ends at D v / (v - o). Met if just behind the end of the wider one nothing \
                     is left without joining, and with it something is, in all pairs; contradicted if \
                     in none",
            judge: Box::new(outlives),
        },
    ]
}

fn between(draws: &mut Random, low: f64, high: f64) -> f64 {
    low + (high - low) * f64::from(draws.unit())
}

fn storeys(draws: &mut Random) -> f64 {
    3.0 * f64::from(1 + draws.bits() % 7)
}

/// A cell whose front is at 0, and a building as far away as is asked for.
fn pair(draw: u32, distance: f64) -> (Cuboid, Cuboid) {
    let mut draws = Random::new(4, 2, draw);
    let width = between(&mut draws, 5.0, 20.0);
    let deep = between(&mut draws, 0.0, 10.0);
    let cell = Cuboid { u: [0.0, width], w: [-deep, 0.0], h: [0.0, storeys(&mut draws)] };
    let left = between(&mut draws, -30.0, 30.0);
    let right = left + between(&mut draws, 5.0, 30.0);
    let depth = between(&mut draws, 5.0, 15.0);
    let h = [f64::NEG_INFINITY, storeys(&mut draws)];
    (cell, Cuboid { u: [left, right], w: [distance, distance + depth], h })
}

/// Area above ground.
fn area(shadow: &Umbra) -> f64 {
    let strip = |[a, b]: &[[f64; 2]; 2]| 0.5 * (a[1].max(0.0) + b[1].max(0.0)) * (b[0] - a[0]);
    shadow.vertices().array_windows().map(strip).sum()
}

/// Share of all shadows' area that an edge loses at a distance.
fn lost(edge: Edge, distance: f64) -> f64 {
    let (mut kept, mut all) = (0.0, 0.0);
    for draw in 0..DRAWS {
        let (cell, occluder) = pair(draw, distance);
        let on = |edge| umbra(&cell, &occluder, occluder.w[1], edge).map_or(0.0, |u| area(&u));
        kept += on(edge);
        all += on(Edge::Hull);
    }
    1.0 - kept / all
}

/// Losses from near to far.
fn shrinks(losses: &[f64]) -> Verdict {
    let (Some(first), Some(last)) = (losses.first(), losses.last()) else { return Verdict::Open };
    // Written so that a NaN contradicts.
    if !losses.iter().all(|loss| loss.is_finite()) || last >= first {
        Verdict::Refuted
    } else if losses.array_windows().all(|[near, far]| far < near) {
        Verdict::Reproduced
    } else {
        Verdict::Open
    }
}

fn distance(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let of = |edge| DISTANCES_M.map(|metres| lost(edge, metres));
    let (single, level) = (of(Edge::Sloped), of(Edge::Flat));
    let tell = |name: &str, losses: &[f64]| -> Vec<Figure> {
        let each = DISTANCES_M.iter().zip(losses);
        each.map(|(m, loss)| figure(format!("{name}, {m} m: lost"), *loss, "")).collect()
    };
    let mut figures = tell("one edge", &single);
    figures.extend(tell("level", &level));
    let [near, .., far] = single;
    let because = format!("{:.1} % lost at 5 m, {:.1} % at 160 m", 100.0 * near, 100.0 * far);
    Ok(judged(shrinks(&single), because, figures))
}

/// The most edges of a union, and of an umbra.
fn at_most_three(most: [usize; 2]) -> Verdict {
    match most {
        [0, _] | [_, 0] => Verdict::Open,
        most if most.iter().all(|edges| *edges <= 3) => Verdict::Reproduced,
        _ => Verdict::Refuted,
    }
}

fn edges(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let (mut most, mut both) = ([0; 2], 0);
    for draw in 0..DRAWS {
        let (cell, occluder) = pair(draw, DISTANCES_M[draw as usize % DISTANCES_M.len()]);
        let union = union_of_edges(&cell, &occluder);
        let whole = hull(&cell, &occluder, occluder.w[1]);
        most = [most[0].max(union.len()), most[1].max(whole.len().saturating_sub(1))];
        // The same seen from below the roof as well.
        let low = Cuboid { h: [0.0, 0.5 * occluder.h[1].min(cell.h[1])], ..cell };
        let mut all = union;
        for edge in union_of_edges(&low, &occluder) {
            let [a, b] = edge;
            if !all.iter().any(|known| *known == edge || *known == [b, a]) {
                all.push(edge);
            }
        }
        both = both.max(all.len());
    }
    let figures = vec![
        figure("most edges of the union over a cell's top", most[0] as f64, ""),
        figure("most edges of an exact umbra", most[1] as f64, ""),
        figure("most edges of the union over a cell's top and low points", both as f64, ""),
    ];
    let because = format!("at most {} edges in {DRAWS} draws", most[0].max(most[1]));
    Ok(judged(at_most_three(most), because, figures))
}

/// Pairs whose joined shadow is left where single ones are gone, and all pairs.
fn outlive(outlived: u32, pairs: u32) -> Verdict {
    match outlived {
        _ if pairs == 0 => Verdict::Open,
        0 => Verdict::Refuted,
        n if n == pairs => Verdict::Reproduced,
        _ => Verdict::Open,
    }
}

fn outlives(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let (mut outlived, mut endless, mut farther, mut ending) = (0, 0_u32, 0.0, 0_u32);
    for draw in 0..DRAWS {
        let mut draws = Random::new(4, 4, draw);
        let (v, near) = (between(&mut draws, 5.0, 20.0), between(&mut draws, 5.0, 100.0));
        let widths = [0, 0].map(|_| v * between(&mut draws, 0.1, 0.9));
        let cell = Cuboid { u: [-0.5 * v, 0.5 * v], w: [0.0; 2], h: [0.0, 3.0] };
        let start = -0.5 * (widths[0] + widths[1]);
        let middle = start + widths[0];
        let ends = [[start, middle], [middle, middle + widths[1]]];
        let shadow = |u: [f64; 2], top: f64| {
            let wall = Cuboid { u, w: [near; 2], h: [f64::NEG_INFINITY, top] };
            umbra(&cell, &wall, near, Edge::Flat)
        };
        let tops = [0, 0].map(|_| 3.0 + storeys(&mut draws));
        let shadows: Vec<Umbra> =
            ends.into_iter().zip(tops).filter_map(|(u, top)| shadow(u, top)).collect();
        let end = |o: f64| near * v / (v - o);
        let gone = end(widths[0].max(widths[1])) * (1.0 + BEYOND);
        let left = |fusion| {
            let mut horizon = Horizon::new(fusion);
            horizon.add(&shadows);
            horizon.reproject(&cell, near, gone);
            horizon.len()
        };
        outlived += u32::from(left(Fusion::None) == 0 && left(Fusion::Insertion) > 0);
        let both = widths[0] + widths[1];
        if both >= v {
            endless += 1;
        } else {
            ending += 1;
            farther += end(both) / gone;
        }
    }
    let figures = vec![
        figure("pairs", f64::from(DRAWS), ""),
        figure("joined shadow left where both are gone", f64::from(outlived), "pairs"),
        figure("together as wide as the cell: hide for ever", f64::from(endless), "pairs"),
        figure("end of the others, over that of the wider", farther / f64::from(ending.max(1)), ""),
    ];
    let because = format!("{outlived} of {DRAWS} pairs hide together where neither does alone");
    Ok(judged(outlive(outlived, DRAWS), because, figures))
}

#[cfg(test)]
mod tests {
    use super::*;
    use Verdict::{Open, Refuted, Reproduced};

    #[test]
    fn losses_shrink_or_do_not() {
        assert_eq!(shrinks(&[0.3, 0.2, 0.1]), Reproduced);
        assert_eq!(shrinks(&[0.3, 0.1, 0.2]), Open);
        assert_eq!(shrinks(&[0.1, 0.2]), Refuted);
        assert_eq!(shrinks(&[0.3, f64::NAN, 0.1]), Refuted);
        assert_eq!(shrinks(&[]), Open);
    }

    #[test]
    fn three_edges_are_the_most() {
        assert_eq!(at_most_three([3, 3]), Reproduced);
        assert_eq!(at_most_three([4, 3]), Refuted);
        assert_eq!(at_most_three([0, 3]), Open);
    }

    #[test]
    fn shadows_outlive_or_not() {
        assert_eq!([outlive(5, 5), outlive(4, 5), outlive(0, 5)], [Reproduced, Open, Refuted]);
        assert_eq!(outlive(0, 0), Open);
    }

    #[test]
    fn area_is_counted_above_ground() {
        let shadow = Umbra { u: [0.0, 2.0], top: [-1.0, 4.0], foot: f64::NEG_INFINITY, peak: None };
        assert_eq!(area(&shadow), 4.0);
        assert_eq!(area(&Umbra::flat([0.0, 2.0], 0.0, 3.0)), 6.0);
    }
}
