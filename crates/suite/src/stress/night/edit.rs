//! Cities that are scaled, moved or turned.

use super::{Loaded, SuiteError, loaded};
use dapple_scene::{
    Aabb,
    city::{City, Footprint},
};
use glam::{DVec2, DVec3};

/// What becomes of a city's places, and by how much its lengths grow.
struct Change<'a> {
    place: &'a dyn Fn(DVec3) -> DVec3,
    /// Horizontal directions.
    turn: DVec2,
    scale: f64,
}

/// All lengths and places times `scale`, and intensities its square: the same light.
pub fn scaled(city: City, scale: f64) -> City {
    let place = |p: DVec3| p * scale;
    changed(city, &Change { place: &place, turn: DVec2::X, scale })
}

/// Moved by an offset, metres.
pub fn moved(city: City, offset: DVec3) -> City {
    let place = |p: DVec3| p + offset;
    changed(city, &Change { place: &place, turn: DVec2::X, scale: 1.0 })
}

/// Turned about the vertical through the origin, from +x towards +z.
pub fn turned(city: City, degrees: f64) -> City {
    let turn = DVec2::from_angle(degrees.to_radians());
    let place = |p: DVec3| {
        let flat = turn.rotate(DVec2::new(p.x, p.z));
        DVec3::new(flat.x, p.y, flat.y)
    };
    changed(city, &Change { place: &place, turn, scale: 1.0 })
}

/// The same case of a city that was changed.
pub fn of_city(from: Loaded, change: impl FnOnce(City) -> City) -> Result<Loaded, SuiteError> {
    let Some((city, _)) = from.city else { return Ok(from) };
    loaded(change(city))
}

fn changed(mut city: City, change: &Change<'_>) -> City {
    let Change { place, turn, scale } = *change;
    let level = |p: DVec2| {
        let p = place(DVec3::new(p.x, 0.0, p.y));
        DVec2::new(p.x, p.z)
    };
    let height = |y: f64| place(DVec3::new(0.0, y, 0.0)).y;
    for b in &mut city.buildings {
        let Footprint { outer, holes } = &mut b.footprint;
        outer.iter_mut().chain(holes.iter_mut().flatten()).for_each(|p| *p = level(*p));
        (b.base_m, b.eaves_m) = (height(b.base_m), height(b.eaves_m));
        for facade in &mut b.facades {
            (facade.from, facade.to) = (level(facade.from), level(facade.to));
        }
        b.roof.iter_mut().chain(&mut b.gables).flatten().for_each(|p| *p = place(*p));
        let bounds = b.footprint.outer.iter().flat_map(|p| {
            let [low, high] = [b.outer.min.y, b.outer.max.y].map(height);
            [DVec3::new(p.x, low, p.y), DVec3::new(p.x, high, p.y)]
        });
        b.outer = bounds.fold(Aabb::EMPTY, Aabb::grow);
        for solid in &mut b.inner {
            solid.centre = place(solid.centre);
            solid.axis = turn.rotate(solid.axis);
            solid.half *= scale;
        }
    }
    let square = (scale * scale) as f32;
    for light in &mut city.lights {
        light.position = place(light.position);
        let direction = turn.rotate(DVec2::new(light.direction.x, light.direction.z));
        light.direction = DVec3::new(direction.x, light.direction.y, direction.y);
        light.intensity *= square;
    }
    for lamp in &mut city.lamps {
        lamp.position = place(lamp.position);
        lamp.intensity *= square;
    }
    for tree in &mut city.trees {
        tree.position = place(tree.position);
        tree.height_m *= scale;
        tree.crown_radius_m *= scale;
    }
    let corners = city.grounds.iter_mut().flat_map(|ground| &mut ground.triangles).flatten();
    corners.for_each(|p| *p = place(*p));
    let keys = city.paths.iter_mut().flat_map(|path| &mut path.keys);
    for camera in city.cameras.iter_mut().chain(keys) {
        camera.position = place(camera.position);
        camera.target = place(camera.target);
    }
    city
}
