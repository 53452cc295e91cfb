//! Extremes of the scene, of the image and of the camera's kind.

use super::{SAME, USUAL, checked, load, made, made::field, of, of_scene, pushed};
use crate::{
    city::Loaded,
    problems::camera_visibility::VisibilityCase,
    stress::{Axis, Prepare, Values, edit, world},
};
use dapple_scene::{Instance, Mesh, Projection, Scene};
use glam::{DAffine3, DQuat, DVec3};

/// The axes, each pushed alone.
pub fn axes() -> Vec<Axis> {
    vec![
        scale(),
        offset(),
        degenerate(),
        objects(),
        object_triangles(),
        blocks(),
        street(),
        columns(),
        opening(),
        parallel(),
        far_object(),
    ]
}

fn scale() -> Axis {
    let help = "all lengths of the scene times this: the same is drawn";
    world::scale(SAME, help, pushed(|loaded, value, _| scaled(loaded, value)))
}

fn offset() -> Axis {
    let help = "distance of the scene, made 1 m in radius, from the origin in its own radii, by \
                placements in f64: the same is drawn";
    world::offset(SAME, help, pushed(|loaded, value, _| moved(loaded, value)))
}

/// All lengths times `scale`.
pub(super) fn scaled(mut loaded: Loaded, scale: f64) -> Loaded {
    for solid in inner(&mut loaded) {
        solid.centre *= scale;
        solid.half *= scale;
    }
    Loaded { scene: edit::scaled(loaded.scene, scale), ..loaded }
}

/// Made 1 m in radius, then moved by so many metres.
pub(super) fn moved(loaded: Loaded, radii: f64) -> Loaded {
    let radius = loaded.scene.bounds().radius();
    let mut loaded = scaled(loaded, 1.0 / radius);
    let away = edit::away(&loaded.scene, radii);
    for solid in inner(&mut loaded) {
        solid.centre += away;
    }
    Loaded { scene: edit::moved_by(loaded.scene, away), ..loaded }
}

/// Boxes that lie inside buildings: what else a city says of places is not asked.
fn inner(loaded: &mut Loaded) -> impl Iterator<Item = &mut dapple_scene::city::OrientedBox> {
    let buildings = loaded.city.iter_mut().flat_map(|(city, _)| &mut city.buildings);
    buildings.flat_map(|building| &mut building.inner)
}

fn degenerate() -> Axis {
    let help = "triangles without area added to a mesh of cubes: a corner three times, a corner \
                twice, corners on a line; they show nowhere, but are drawn";
    let added = made(|value, case| {
        let one = as_one_mesh(field(FIELD, case.seed));
        edit::with_degenerate_triangles(one, value as u32, case.seed)
    });
    world::degenerate(USUAL, help, added)
}

/// Cubes of a field where their number is not pushed.
pub(super) const FIELD: u32 = 300;

fn objects() -> Axis {
    let help = "cubes strewn before the camera, the smaller the more there are, down to some that \
                own no pixel";
    of_scene(
        "objects",
        help,
        Values::Whole { least: 1, greatest: 100_000, per_decade: 1 },
        f64::from(FIELD),
        made(|value, case| field(value as u32, case.seed)),
    )
}

fn object_triangles() -> Axis {
    let values = Values::Whole { least: 1, greatest: 1_048_576, per_decade: 1 };
    let prepare: Prepare = Box::new(|case, value, gpu| {
        let loaded = checked(of(as_one_mesh(load(case)?.scene)))?;
        let mut case = case.clone();
        case.parameters.insert("object_triangles".into(), (value as i64).into());
        Ok(Box::new(VisibilityCase::of(loaded, &case, gpu)?))
    });
    Axis {
        unit: "triangles",
        ..of_scene(
            "object-triangles",
            "the scene as one mesh, cut into objects of at most so many triangles, from each by \
             itself to all in one",
            values,
            128.0,
            prepare,
        )
    }
}

/// All that is placed, as one mesh of the first material.
pub(super) fn as_one_mesh(mut scene: Scene) -> Scene {
    let mut mesh = Mesh { name: "all".into(), ..Mesh::default() };
    for (_, corners) in scene.world_triangles() {
        let first = mesh.positions.len() as u32;
        mesh.positions.extend(corners.map(|p| p.as_vec3()));
        mesh.triangles.push([first, first + 1, first + 2]);
    }
    scene.meshes = vec![mesh];
    scene.instances = vec![Instance { mesh: 0, transform: DAffine3::IDENTITY }];
    scene
}

fn blocks() -> Axis {
    USUAL.of_parameter(
        "blocks",
        "blocks",
        "blocks a side of a generated city",
        Values::Whole { least: 1, greatest: 6, per_decade: 4 },
        2.0,
    )
}

fn street() -> Axis {
    Axis {
        unit: "m",
        ..USUAL.of_parameter(
            "street",
            "street",
            "width of a generated city's streets",
            Values::Linear { least: 6.0, greatest: 30.0, steps: 4 },
            12.0,
        )
    }
}

fn columns() -> Axis {
    Axis {
        unit: "px",
        ..USUAL.of_parameter(
            "width",
            "columns",
            "columns of the image; rows are 9/16 of it",
            Values::Whole { least: 16, greatest: 1024, per_decade: 2 },
            64.0,
        )
    }
}

fn opening() -> Axis {
    Axis {
        unit: "degrees",
        ..of_scene(
            "opening",
            "vertical opening of the camera, from a needle to nearly a half space; past what an \
             image can show it must be refused",
            Values::Log { least: 1e-4, greatest: 179.9, per_decade: 1 },
            60.0,
            made(|value, case| {
                let fov_y_rad = value.to_radians();
                projected(field(FIELD, case.seed), Projection::Perspective { fov_y_rad })
            }),
        )
    }
}

fn parallel() -> Axis {
    Axis {
        unit: "m",
        ..of_scene(
            "parallel",
            "height of the image of a camera with parallel rays before cubes of about 0.4 m",
            Values::Log { least: 1e-3, greatest: 1e3, per_decade: 1 },
            4.0,
            made(|value, case| {
                projected(field(FIELD, case.seed), Projection::Orthographic { height_m: value })
            }),
        )
    }
}

/// Seen by cameras of another kind.
fn projected(mut scene: Scene, projection: Projection) -> Scene {
    for path in &mut scene.paths {
        for key in &mut path.keys {
            key.projection = projection;
        }
    }
    scene
}

fn far_object() -> Axis {
    Axis {
        unit: "m",
        ..of_scene(
            "far-object",
            "distance of one more cube, a tenth as wide as it is far: the near plane is a share of \
             the scene's radius and moves away with it, through all else",
            Values::Log { least: 20.0, greatest: 1e8, per_decade: 1 },
            20.0,
            made(|value, case| {
                let mut scene = field(FIELD, case.seed);
                // Above the wall that ends the view.
                let middle = DVec3::new(0.0, 0.5 * value, -value);
                let half = DVec3::splat(0.05 * value);
                let place =
                    DAffine3::from_scale_rotation_translation(half, DQuat::IDENTITY, middle);
                scene.instances.push(Instance { mesh: made::CUBE, transform: place });
                scene
            }),
        )
    }
}
