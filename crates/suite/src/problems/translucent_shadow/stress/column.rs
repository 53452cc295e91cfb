//! Extremes of what lies behind one another: sheets across the light that every texel of a small map
//! meets alike, so that nothing but layering and storage can be wrong.

use super::{TranslucentCase, USUAL};
use crate::{
    SuiteError,
    case::Case,
    problem::Setting,
    problems::translucent_shadow::{SPEC, scene::Loaded},
    stress::{
        Axis, Prepare, Push, Values,
        settings::{Usual, with, with_word},
    },
};
use dapple_scene::{Camera, Instance, Light, Material, Mesh, Projection, Scene};
use glam::{DAffine3, DVec3, Vec3};

/// Optical thickness of a column where it is not pushed: half of the light is lost, and an 8-bit
/// sum is not full.
const THICKNESS: f64 = 0.7;

/// Sheets of a column where their number is not pushed.
const SHEETS: u32 = 16;

/// Texels a side: all of them are the same.
const SIDE: u32 = 4;

/// One light ray a receiver and few receivers, as no neighbour differs: each may pass all sheets.
const ONE_RAY: &[(&str, &str)] = &[("width", "24"), ("truth_rays", "1"), ("footprint", "0")];

const COLUMN: Usual = Usual { parameters: ONE_RAY, ..USUAL };

/// Height of the column and its half width, metres.
const HEIGHT: f64 = 1.0;
const HALF_WIDTH: f64 = 1.0;

/// The axes: numbers and thickness of sheets, each in the storage formats that they strain.
pub fn axes() -> Vec<Axis> {
    vec![
        fragments("fragments", None),
        fragments("fragments-f16", Some("f16")),
        fragments("fragments-unorm8", Some("unorm8")),
        fragments("fragments-unorm8-scaled", Some("unorm8-scaled")),
        fragments("fragments-fixed", Some("fixed")),
        thickness("thickness", None),
        thickness("thickness-unorm8", Some("unorm8")),
        thickness("thickness-unorm8-scaled", Some("unorm8-scaled")),
    ]
}

fn fragments(id: &'static str, format: Option<&'static str>) -> Axis {
    Axis {
        unit: "fragments",
        prepare: prepared(|value| column(value as u32, THICKNESS)),
        setting: in_format(format),
        ..COLUMN.axis(
            id,
            "sheets on every light ray, of the same thickness together: of few each counts for \
             much, of many each is too faint for its storage (the format that the name ends in)",
            Values::Whole { least: 1, greatest: 50_000, per_decade: 1 },
            f64::from(SHEETS),
        )
    }
}

fn thickness(id: &'static str, format: Option<&'static str>) -> Axis {
    Axis {
        prepare: prepared(|value| column(SHEETS, value)),
        setting: in_format(format),
        ..COLUMN.axis(
            id,
            "optical thickness of 16 sheets together, until no light is left or storage is full \
             (in the format that the name ends in)",
            // At the end a sheet lets a 500th through; at twice that it would count as opaque.
            Values::Log { least: 1e-3, greatest: 100.0, per_decade: 2 },
            THICKNESS,
        )
    }
}

fn prepared(make: fn(f64) -> Scene) -> Prepare {
    Box::new(move |case, value, gpu| {
        Ok(Box::new(TranslucentCase::of(loaded(make(value))?, &first_view(case), gpu)?))
    })
}

/// The case with the only view that there is.
pub(super) fn first_view(case: &Case) -> Case {
    Case { view: String::new(), ..case.clone() }
}

/// The column as it is loaded.
pub(super) fn loaded(seen: Scene) -> Result<Loaded, SuiteError> {
    let none = Loaded { seen, casters: None, lift_m: 0.0, hash: String::new(), notes: Vec::new() };
    super::checked(none)
}

/// A small map in a format (its own default for none), where the technique has such.
fn in_format(format: Option<&'static str>) -> Push {
    Box::new(move |setting, _| match format {
        Some(format) => with_word(&SPEC, &small(setting)?, "format", format),
        None => small(setting),
    })
}

/// One tap: all are the same.
fn small(setting: &Setting) -> Option<Setting> {
    let small = with(setting, "resolution", SIDE)?;
    Some(with(&small, "taps", "1").unwrap_or(small))
}

/// Opacity of each of `count` sheets of `thickness` together.
pub(super) fn sheet_opacity(count: u32, thickness: f64) -> f32 {
    -(-thickness / f64::from(count)).exp_m1() as f32
}

/// `count` level sheets over a floor of the same width, lit from straight above, and a camera whose
/// every ray meets about two of them. Their distances are uneven, or layers would fall on them.
pub(super) fn column(count: u32, thickness: f64) -> Scene {
    let corner = |x: f64, y: f64, z: f64| Vec3::new(x as f32, y as f32, z as f32);
    let sheet = |mesh: &mut Mesh, y: f64| {
        let first = mesh.positions.len() as u32;
        let w = HALF_WIDTH;
        mesh.positions.extend([
            corner(-w, y, -w),
            corner(-w, y, w),
            corner(w, y, w),
            corner(w, y, -w),
        ]);
        mesh.triangles.extend([[0, 1, 2], [0, 2, 3]].map(|t| t.map(|i| first + i)));
    };
    let mut sheets = Mesh { name: "sheets".into(), material: 0, ..Mesh::default() };
    for i in 0..count {
        // Multiples of the golden ratio fill every interval evenly and repeat nowhere.
        let within = (f64::from(i) * 0.618_033_988_749_895).fract();
        sheet(&mut sheets, HEIGHT * (f64::from(i) + within) / f64::from(count));
    }
    let mut floor = Mesh { name: "floor".into(), material: 1, ..Mesh::default() };
    sheet(&mut floor, -0.1 * HEIGHT);
    let opacity = sheet_opacity(count, thickness);
    let translucent = Material { name: "sheet".into(), opacity, ..Material::default() };
    let opaque = Material { name: "floor".into(), ..Material::default() };
    // Two sheets lie over one another on the way across the column.
    let rise = (2.0 * HEIGHT / f64::from(count)).atan2(2.0 * HALF_WIDTH);
    let target = DVec3::new(0.0, 0.5 * HEIGHT, 0.0);
    let camera = Camera {
        name: "side".into(),
        position: target + 4.0 * DVec3::new(0.0, rise.sin(), rise.cos()),
        target,
        up: DVec3::Y,
        projection: Projection::Orthographic { height_m: HEIGHT },
    };
    let placed = |mesh| Instance { mesh, transform: DAffine3::IDENTITY };
    Scene {
        name: format!("column of {count}"),
        meshes: vec![sheets, floor],
        materials: vec![translucent, opaque],
        instances: vec![placed(0), placed(1)],
        lights: vec![Light::Directional { direction: DVec3::NEG_Y }],
        cameras: vec![camera],
        ..Scene::default()
    }
}
