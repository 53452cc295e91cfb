//! Input that must be refused, each kind with a good one beside it.

use super::{
    Axis, Values, edit,
    settings::{Changes, Usual, position, with_all},
    world::Kind,
};

/// All but the first word are bad.
pub fn bad(value: f64) -> bool {
    position(value) > 0
}

/// What may become of a vertex, with the good word beside it.
pub const VERTICES: [Kind; 6] = [
    ("good", |scene, _| scene),
    ("nan", |scene, _| edit::with_coordinate(scene, f32::NAN)),
    ("+inf", |scene, _| edit::with_coordinate(scene, f32::INFINITY)),
    ("-inf", |scene, _| edit::with_coordinate(scene, f32::NEG_INFINITY)),
    ("1e38", |scene, _| edit::with_coordinate(scene, 1e38)),
    ("index", |scene, _| edit::with_missing_vertex(scene)),
];

/// [`VERTICES`] and what else is bad in a problem's scenes. `N` must be the length of both.
pub const fn vertices_and<const M: usize, const N: usize>(more: [Kind; M]) -> [Kind; N] {
    assert!(VERTICES.len() + M == N, "another number of kinds");
    let mut all = [VERTICES[0]; N];
    let mut i = 0;
    while i < N {
        all[i] = if i < VERTICES.len() { VERTICES[i] } else { more[i - VERTICES.len()] };
        i += 1;
    }
    all
}

/// An axis of damages to a scene, by the words of a table that [`vertices_and`] made. It pushes
/// nothing yet.
pub fn bad_vertices(usual: Usual, help: &'static str, words: &'static [&'static str]) -> Axis {
    Axis { must_refuse: bad, ..usual.axis("bad-vertices", help, Values::Words(words), 0.0) }
}

/// A word and the knobs that it sets to what no technique can have; none for the first, good word.
pub type BadSetting = (&'static str, Changes);

/// An axis of settings that are bad, by a table with its words.
pub fn bad_settings(
    usual: Usual,
    settings: &'static [BadSetting],
    words: &'static [&'static str],
) -> Axis {
    let help = "a setting that no technique can have, each to be refused by name";
    Axis {
        must_refuse: bad,
        setting: Box::new(|setting, value| with_all(setting, settings.get(position(value))?.1)),
        ..usual.axis("bad-settings", help, Values::Words(words), 0.0)
    }
}
