//! The seeded generator of night cities: blocks of buildings on a grid of streets.
//!
//! Based on: E. Conte, "Real-time Rendering of Cities at Night", MSc thesis, Université de
//! Montréal, 2018, section 5.1 and the counts of table 5.VII.
//! Deviations: the thesis gives no measures; lots are 10 x 10 m, storeys 3 m, sidewalks 2 m. 44
//! buildings a block stand in two rows of 22 over an alley of 5 m (or around a yard), which comes
//! within 1.4 % of its lights a block. Heights are spread evenly over every block, as its counts
//! agree between cities better than independent heights would.
//!
//! Built from arithmetic and square roots alone, so that a seed gives the same bits everywhere.

mod grounds;
mod heights;
mod knobs;
mod layout;
mod trees;
mod views;

pub use knobs::{BlockShape, Heights, Knobs};

use super::{Building, City, CityError, Facade, Footprint, OrientedBox, windows};
use crate::Aabb;
use glam::{DVec2, DVec3};
use layout::{LOT_M, Layout, Lot, STOREY_M};
use rand::SeedableRng;
use rand_pcg::Pcg64;

/// How far inner boxes stay within the walls, metres: what the walls themselves draw is never
/// hidden by them.
const INNER_MARGIN_M: f64 = 1e-3;

/// The city of `knobs`; equal seeds give equal bits.
///
/// # Errors
/// [`CityError::Value`] for a knob beyond its range.
pub fn generate(knobs: &Knobs, seed: u64) -> Result<City, CityError> {
    knobs.check()?;
    let mut rng = Pcg64::seed_from_u64(seed);
    let layout = Layout::new(knobs);
    let mut city = City { name: "city".into(), ..City::default() };
    for index in 0..layout.rows * layout.columns {
        let empty = heights::empty_lots(knobs.empty_lots, layout.lots.len(), index as usize);
        let storeys = heights::storeys(knobs.heights, layout.lots.len(), empty, &mut rng);
        let corner = layout.block(index / layout.columns, index % layout.columns);
        let first = city.buildings.len() as u32;
        for (number, lot) in layout.lots.iter().enumerate().filter(|(i, _)| storeys[*i] > 0) {
            let party = lot.neighbours.map(|n| n.is_some_and(|n| storeys[n] > 0));
            city.buildings.push(building(index, number, corner, lot, storeys[number], party));
        }
        city.blocks.push(first..city.buildings.len() as u32);
    }
    city.grounds = grounds::grounds(&layout);
    city.trees = trees::trees(&layout, knobs.trees_per_block, &mut rng);
    city.cameras = views::cameras(&city, &layout);
    city.paths = views::paths(&city, &layout, &city.cameras);
    windows::light(&mut city, knobs.lights_per_storey, seed)?;
    Ok(city)
}

/// A building on its whole lot; `party` says which walls it shares.
fn building(
    block: u32,
    number: usize,
    corner: DVec2,
    lot: &Lot,
    storeys: u32,
    party: [bool; 4],
) -> Building {
    let (min, max) = (corner + lot.min, corner + lot.min + LOT_M);
    let eaves_m = STOREY_M * f64::from(storeys);
    let ring = ring(min, max);
    let facade = |i: usize| Facade { from: ring[i], to: ring[(i + 1) % 4], party: party[i] };
    let outer = Aabb { min: DVec3::new(min.x, 0.0, min.y), max: DVec3::new(max.x, eaves_m, max.y) };
    let inner = OrientedBox {
        centre: outer.centre(),
        axis: DVec2::X,
        half: 0.5 * (outer.max - outer.min) - INNER_MARGIN_M,
    };
    Building {
        id: format!("{block}.{number}"),
        footprint: Footprint { outer: ring.into(), holes: vec![] },
        base_m: 0.0,
        eaves_m,
        storeys,
        facades: (0..4).map(facade).collect(),
        roof: rectangle(min, max, eaves_m).into(),
        gables: vec![],
        outer,
        inner: vec![inner],
    }
}

/// The corners of a rectangle, counter-clockwise seen from above; its sides face +z, +x, -z, -x.
fn ring(min: DVec2, max: DVec2) -> [DVec2; 4] {
    [DVec2::new(min.x, max.y), max, DVec2::new(max.x, min.y), min]
}

/// A rectangle at height `y`, facing up.
fn rectangle(min: DVec2, max: DVec2, y: f64) -> [[DVec3; 3]; 2] {
    let [a, b, c, d] = ring(min, max).map(|p| DVec3::new(p.x, y, p.y));
    [[a, b, c], [a, c, d]]
}
