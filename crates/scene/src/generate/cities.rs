//! Named cities.

use crate::city::{City, Heights, Knobs, generate};

/// What the city of a name is made with; `None` for an unknown one.
pub fn knobs(name: &str) -> Option<Knobs> {
    let blocks = |n: u32| Knobs { blocks_x: n, blocks_z: n, ..Knobs::default() };
    Some(match name {
        "city" => Knobs::default(),
        "city_small" => blocks(2),
        "city_trees" => Knobs { trees_per_block: 12, ..blocks(2) },
        "city_flat" => Knobs { heights: Heights::Fixed(7), ..Knobs::default() },
        "city_9" => blocks(9),
        "city_15" => blocks(15),
        _ => return None,
    })
}

/// The city of a name; `None` for an unknown one.
pub fn by_name(name: &str, seed: u64) -> Option<City> {
    let city = generate(&knobs(name)?, seed).ok()?;
    Some(City { name: name.into(), ..city })
}
