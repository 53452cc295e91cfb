//! Surfaces of what is drawn, for cells around them.

use dapple_many_lights::{Frame, Point, region::Surface};
use dapple_occlusion::camera::Objects;
use dapple_scene::{Scene, city::OrientedBox};
use glam::{DVec2, DVec3};
use std::{f64::consts::PI, ops::Range};

/// Normals of an object that are no farther apart, radians, count as one: points round theirs to f32.
const ALIKE_RAD: f64 = 1e-7;

/// Normals whose upward part is no greater count as horizontal, for the same reason.
const LEVEL: f64 = 1e-9;

/// What a point's normal may be off from its surface's, radians: more than rounding, less than any two
/// sides of a thing.
const OF_SURFACE_RAD: f64 = 1e-3;

/// The surfaces of every object.
#[derive(Clone, Debug, Default)]
pub struct Surfaces {
    surfaces: Vec<Surface>,
    /// One an object.
    ranges: Vec<Range<u32>>,
}

impl Surfaces {
    /// Those of a scene's objects; `owners` has the object of each placed triangle, as
    /// [`Objects::from_scene`] gives it. Of an object, each horizontal normal makes a surface; all that
    /// face up or down make one together. What is masked shows both of its sides: one surface of any
    /// normal.
    pub fn of(scene: &Scene, objects: &Objects, owners: &[[u32; 2]]) -> Self {
        let mut of_object: Vec<Vec<Group>> = vec![Vec::new(); objects.objects.len()];
        for ((_, corners), [owner, _]) in scene.world_triangles().zip(owners) {
            let Some(groups) = of_object.get_mut(*owner as usize) else { continue };
            let template = objects.objects[*owner as usize].template as usize;
            let template = &objects.templates[template];
            let corners = corners.map(|corner| corner - objects.origin);
            let Some((normal, area)) = normal(corners) else { continue };
            let shows = Shows::of(normal, template.mask.is_some());
            let group = match groups.iter_mut().find(|group| group.shows.is_with(shows)) {
                Some(group) => group,
                None => {
                    groups.push(Group::new(shows, template.albedo.as_dvec3()));
                    let last = groups.len() - 1;
                    &mut groups[last]
                }
            };
            group.add(corners, normal, area);
        }
        let mut all = Self::default();
        for groups in of_object {
            let first = all.surfaces.len() as u32;
            all.surfaces.extend(groups.iter().map(Group::surface));
            all.ranges.push(first..all.surfaces.len() as u32);
        }
        all
    }

    /// Those of an object; none of one that there is not.
    pub fn of_object(&self, object: u32) -> &[Surface] {
        match self.ranges.get(object as usize) {
            Some(range) => &self.surfaces[range.start as usize..range.end as usize],
            None => &[],
        }
    }

    /// Number of objects.
    pub fn objects(&self) -> u32 {
        self.ranges.len() as u32
    }

    /// Whether a point shows the front of one of its object's surfaces.
    pub fn shows_front(&self, point: &Point) -> bool {
        let normal = point.normal.as_dvec3();
        self.of_object(point.object).iter().any(|surface| {
            normal.angle_between(surface.normal_axis) <= surface.normal_spread_rad + OF_SURFACE_RAD
        })
    }

    /// Gives points that show a back side to no object, so that they start at the roots: cells are
    /// around fronts alone. How many there were.
    pub fn release_backs(&self, frame: &mut Frame) -> usize {
        let nobody = self.objects();
        let backs = frame.points.iter_mut().filter(|p| p.is_there() && !self.shows_front(p));
        backs.map(|point| point.object = nobody).count()
    }

    /// Bytes.
    pub fn bytes(&self) -> u64 {
        (size_of_val(&self.surfaces[..]) + size_of_val(&self.ranges[..])) as u64
    }
}

/// The unit normal of a triangle, on the side from which its corners run counter-clockwise, and its
/// area; `None` for one without.
fn normal([a, b, c]: [DVec3; 3]) -> Option<(DVec3, f64)> {
    let across = (b - a).cross(c - a);
    let normal = across.try_normalize()?;
    let area = 0.5 * across.length();
    if normal.y.abs() > LEVEL {
        return Some((normal, area));
    }
    Some((normal.with_y(0.0).try_normalize()?, area))
}

/// What a surface shows.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Shows {
    /// Both sides of triangles that stand any way.
    Both,
    /// The front of what faces up or down.
    Inclined,
    /// The front of a wall of this normal.
    Wall(DVec3),
}

impl Shows {
    fn of(normal: DVec3, is_masked: bool) -> Self {
        match is_masked {
            true => Self::Both,
            false if normal.y == 0.0 => Self::Wall(normal),
            false => Self::Inclined,
        }
    }

    /// Whether both are of one surface.
    fn is_with(self, other: Self) -> bool {
        match (self, other) {
            (Self::Wall(a), Self::Wall(b)) => a.angle_between(b) <= ALIKE_RAD,
            (a, b) => a == b,
        }
    }
}

/// Triangles that become a surface.
#[derive(Clone, Debug)]
struct Group {
    shows: Shows,
    /// Along its box's first horizontal side, (x, z).
    axis: DVec2,
    /// Corners in the space of the box: along, up, across.
    min: DVec3,
    max: DVec3,
    /// Different ones, of what is inclined.
    normals: Vec<DVec3>,
    area: f64,
    albedo: DVec3,
}

impl Group {
    fn new(shows: Shows, albedo: DVec3) -> Self {
        let axis = match shows {
            // A wall's box is as deep as the wall.
            Shows::Wall(normal) => DVec2::new(normal.z, -normal.x),
            Shows::Both | Shows::Inclined => DVec2::X,
        };
        let (min, max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        Self { shows, axis, min, max, normals: Vec::new(), area: 0.0, albedo }
    }

    fn add(&mut self, corners: [DVec3; 3], normal: DVec3, area: f64) {
        for corner in corners {
            let plan = DVec2::new(corner.x, corner.z);
            let inside = DVec3::new(plan.dot(self.axis), corner.y, plan.dot(self.axis.perp()));
            (self.min, self.max) = (self.min.min(inside), self.max.max(inside));
        }
        self.area += area;
        let is_known = |other: &DVec3| other.angle_between(normal) <= ALIKE_RAD;
        if self.shows == Shows::Inclined && !self.normals.iter().any(is_known) {
            self.normals.push(normal);
        }
    }

    fn surface(&self) -> Surface {
        let middle = 0.5 * (self.min + self.max);
        let plan = self.axis * middle.x + self.axis.perp() * middle.z;
        let around = OrientedBox {
            centre: DVec3::new(plan.x, middle.y, plan.y),
            axis: self.axis,
            half: 0.5 * (self.max - self.min),
        };
        let (normal_axis, normal_spread_rad) = match self.shows {
            Shows::Both => (DVec3::Y, PI),
            Shows::Inclined => cone(&self.normals),
            Shows::Wall(normal) => (normal, 0.0),
        };
        let vote = match self.shows {
            Shows::Wall(_) => self.axis * self.area,
            Shows::Both | Shows::Inclined => DVec2::ZERO,
        };
        Surface { around, normal_axis, normal_spread_rad, albedo: self.albedo, vote }
    }
}

/// The cone that holds all normals: axis, and half its opening.
fn cone(normals: &[DVec3]) -> (DVec3, f64) {
    if let [normal] = normals {
        return (*normal, 0.0);
    }
    match normals.iter().sum::<DVec3>().try_normalize() {
        Some(axis) => {
            let spread = normals.iter().map(|normal| axis.angle_between(*normal));
            (axis, (spread.fold(0.0, f64::max) + ALIKE_RAD).min(PI))
        }
        None => (DVec3::Y, PI),
    }
}
