//! Extremes of what hides and of what shows through.

use super::{
    made::{self, Made, field},
    of_scene,
    world::FIELD,
};
use crate::{
    case::Case,
    knob::Get,
    stress::{Axis, Values},
};
use dapple_scene::Scene;
use glam::{DQuat, DVec3};

/// The axes, each pushed alone.
pub fn axes() -> Vec<Axis> {
    vec![
        slit("slit", |value, case| behind_a_slit(value, 0.0, case)),
        slit("slit-aslant", |value, case| behind_a_slit(value, SLANT_RAD, case)),
        wall_distance(),
        separation(),
        coplanar(),
        screen_holes(),
        screens(),
    ]
}

/// Turn of a slit that crosses a column's pixel centres at every height.
const SLANT_RAD: f64 = 0.21;

/// Columns that the slit is seen at, frame by frame: both edges of the image, and jumps. Negative
/// counts from the right.
const COLUMNS: [f64; 5] = [0.0, 0.0, 1.0, -1.0, 30.0];

fn slit(id: &'static str, make: fn(f64, &Case) -> Scene) -> Axis {
    Axis {
        unit: "px",
        ..of_scene(
            id,
            "width of a slit between two walls, upright or aslant, on pixel centres at the image's \
             edges, before far objects; below 1/256 px, to which rasterisers snap, forms show \
             different things in it",
            Values::Log { least: 1e-3, greatest: 10.0, per_decade: 3 },
            1.0,
            super::made(make),
        )
    }
}

/// Two walls at distance 1 that leave `slit_px` pixels open, and far cubes behind all of the image.
pub(super) fn behind_a_slit(slit_px: f64, turn_rad: f64, case: &Case) -> Scene {
    let width = case.parameters.int("width").unwrap_or(64) as u32;
    let pixel = made::pixel(width);
    // The slit's middle is at x = 0: seen from x, it is at -x.
    let centre = |column: f64| {
        let column = if column < 0.0 { f64::from(width) + column } else { column };
        (column + 0.5 - 0.5 * f64::from(width)) * pixel
    };
    let positions = COLUMNS.map(|column| DVec3::new(-centre(column), 0.0, 0.0));
    let mut made = Made::seen_from("slit", &positions);
    let (half, turn) = (4.0, DQuat::from_rotation_z(turn_rad));
    for side in [-1.0, 1.0] {
        let middle = turn * DVec3::new(side * (half + 0.5 * slit_px * pixel), 0.0, 0.0);
        made.square(middle - DVec3::Z, DVec3::splat(half), turn);
    }
    let distance = 60.0;
    for (i, j) in (-14..=14).flat_map(|i| (-8..=8).map(move |j| (i, j))) {
        let middle = DVec3::new(f64::from(i) * 6.0, f64::from(j) * 6.0, -distance);
        made.cube(middle, DVec3::new(3.0, 3.0, 1.0));
    }
    made.scene()
}

fn wall_distance() -> Axis {
    Axis {
        unit: "near planes",
        ..of_scene(
            "wall-distance",
            "distance of two walls from the eye in distances of the near plane, from none: one \
             across the left half of the view, one along it",
            Values::FromZero { least: 1e-3, greatest: 1e4, per_decade: 1 },
            1e3,
            super::made(|value, case| {
                let mut scene = field(FIELD, case.seed);
                let near = super::super::case::NEAR * scene.bounds().radius();
                let mut walls = Made::seen_from("walls", &[DVec3::ZERO]);
                let half = DVec3::new(2.0, 2.0, 1.0);
                walls.square(DVec3::new(-2.0, 0.0, -value * near), half, DQuat::IDENTITY);
                let along = DQuat::from_rotation_y(std::f64::consts::FRAC_PI_2);
                walls.square(DVec3::new(value * near, -0.3, 0.0), half * 0.1, along);
                scene.instances.extend(walls.scene().instances);
                scene
            }),
        )
    }
}

fn separation() -> Axis {
    Axis {
        unit: "m",
        ..of_scene(
            "separation",
            "distance of squares before and behind a wall from it, until all lie in one plane for \
             f32",
            Values::FromZero { least: 1e-9, greatest: 1.0, per_decade: 1 },
            0.1,
            super::made(|value, _| {
                let mut made = Made::seen_from("separation", &still());
                let z = -4.0;
                made.square(DVec3::new(0.0, 0.0, z), DVec3::splat(8.0), DQuat::IDENTITY);
                for (i, j) in (-6..=6).flat_map(|i| (-3..=3).map(move |j| (i, j))) {
                    let side = if (i + j) % 2 == 0 { value } else { -value };
                    let middle = DVec3::new(0.5 * f64::from(i), 0.5 * f64::from(j), z + side);
                    made.square(middle, DVec3::splat(0.21), DQuat::IDENTITY);
                }
                made.scene()
            }),
        )
    }
}

/// A camera that stays, and then moves a little.
fn still() -> [DVec3; 5] {
    [0.0, 0.0, 0.0, 0.01, 0.02].map(|x| DVec3::new(x, 0.0, 0.0))
}

fn coplanar() -> Axis {
    Axis {
        unit: "walls",
        ..of_scene(
            "coplanar",
            "walls in one plane, one over the other, before all else: any of them may show",
            Values::Whole { least: 1, greatest: 1000, per_decade: 2 },
            1.0,
            super::made(|value, case| {
                let mut made = Made::seen_from("coplanar", &still());
                for _ in 0..value as u32 {
                    let middle = DVec3::new(-0.4, 0.1, -1.0);
                    made.square(middle, DVec3::splat(0.5), DQuat::IDENTITY);
                }
                made.cubes(FIELD, case.seed);
                made.scene()
            }),
        )
    }
}

fn screen_holes() -> Axis {
    of_scene(
        "screen-holes",
        "share of an alpha-tested screen's texels that are not there, before all else: it hides by \
         its drawn pixels and by nothing else",
        Values::Linear { least: 0.0, greatest: 1.0, steps: 8 },
        0.5,
        super::made(|value, case| {
            let mut made = Made::seen_from("screen", &still());
            made.screen(DVec3::new(0.0, 0.0, -1.0), 1.2, 64, value, case.seed);
            made.cubes(FIELD, case.seed);
            made.scene()
        }),
    )
}

fn screens() -> Axis {
    Axis {
        unit: "screens",
        ..of_scene(
            "screens",
            "alpha-tested screens of half their texels one behind the other before all else, until \
             hardly anything shows through",
            Values::Whole { least: 1, greatest: 100, per_decade: 3 },
            1.0,
            super::made(|value, case| {
                let mut made = Made::seen_from("screens", &still());
                for i in 0..value as u32 {
                    let distance = 1.0 + f64::from(i) / value;
                    made.screen(
                        DVec3::new(0.0, 0.0, -distance),
                        1.2 * distance,
                        64,
                        0.5,
                        case.seed,
                    );
                }
                made.cubes(FIELD, case.seed);
                made.scene()
            }),
        )
    }
}
