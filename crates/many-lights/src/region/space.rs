//! Spaces that cells and occluders are upright boxes in.

use glam::{DVec2, DVec3};

/// A rotation about the vertical: turned x runs along a horizontal unit vector, y stays up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turn {
    /// Turned x in local (x, z), unit length.
    axis: DVec2,
}

/// Half turns are told apart by directions: all turns lie in 0..90 degrees.
const QUARTER_DEG: u32 = 90;

impl Turn {
    /// Turned space is local space.
    pub const NONE: Self = Self { axis: DVec2::X };

    /// Turned x at so many whole degrees from local x towards local z, modulo 90; exact at 0.
    pub fn degrees(degrees: u32) -> Self {
        match degrees % QUARTER_DEG {
            0 => Self::NONE,
            whole => Self { axis: DVec2::from_angle(f64::from(whole).to_radians()) },
        }
    }

    /// The nearest whole degree to a horizontal direction (x, z), modulo 90; any vector but 0.
    pub fn nearest_degrees(along: DVec2) -> u32 {
        let degrees = along.to_angle().to_degrees().rem_euclid(f64::from(QUARTER_DEG));
        degrees.round() as u32 % QUARTER_DEG
    }

    /// Turned x in local (x, z).
    pub fn axis(&self) -> DVec2 {
        self.axis
    }

    /// A local point or vector, turned.
    pub fn to(&self, v: DVec3) -> DVec3 {
        let DVec2 { x, y } = self.axis;
        DVec3::new(x * v.x + y * v.z, v.y, x * v.z - y * v.x)
    }

    /// A turned point or vector, local.
    pub fn from(&self, v: DVec3) -> DVec3 {
        let DVec2 { x, y } = self.axis;
        DVec3::new(x * v.x - y * v.z, v.y, x * v.z + y * v.x)
    }

    /// The turned box around a local box. Exact for [`Turn::NONE`] and for points.
    pub fn around(&self, min: DVec3, max: DVec3) -> (DVec3, DVec3) {
        if *self == Self::NONE {
            return (min, max);
        }
        // All turns are within a quarter: which corner is outermost is known.
        let DVec2 { x, y } = self.axis;
        let low = DVec3::new(x * min.x + y * min.z, min.y, x * min.z - y * max.x);
        let high = DVec3::new(x * max.x + y * max.z, max.y, x * max.z - y * min.x);
        (low, high)
    }

    /// The local box around a turned box.
    pub fn local_around(&self, min: DVec3, max: DVec3) -> (DVec3, DVec3) {
        if *self == Self::NONE {
            return (min, max);
        }
        around(min, max, |v| self.from(v))
    }
}

fn around(min: DVec3, max: DVec3, turn: impl Fn(DVec3) -> DVec3) -> (DVec3, DVec3) {
    let corners = [(min.x, min.z), (max.x, min.z), (min.x, max.z), (max.x, max.z)];
    let turned = corners.map(|(x, z)| turn(DVec3::new(x, 0.0, z)));
    let low = turned.into_iter().fold(DVec3::INFINITY, DVec3::min);
    let high = turned.into_iter().fold(DVec3::NEG_INFINITY, DVec3::max);
    (low.with_y(min.y), high.with_y(max.y))
}

/// A horizontal direction of turned space: away from a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Direction {
    /// Towards greater turned x.
    PlusX,
    /// Towards smaller turned x.
    MinusX,
    /// Towards greater turned z.
    PlusZ,
    /// Towards smaller turned z.
    MinusZ,
}

impl Direction {
    /// All four, in the order of their indices.
    pub const ALL: [Self; 4] = [Self::PlusX, Self::MinusX, Self::PlusZ, Self::MinusZ];

    /// Its place in [`Direction::ALL`].
    pub fn index(self) -> usize {
        self as usize
    }

    /// As a turned unit vector.
    pub fn vector(self) -> DVec3 {
        match self {
            Self::PlusX => DVec3::X,
            Self::MinusX => DVec3::NEG_X,
            Self::PlusZ => DVec3::Z,
            Self::MinusZ => DVec3::NEG_Z,
        }
    }

    /// A turned box in the direction's space: w = ±x and u = z, or w = ±z and u = x.
    pub fn cuboid(self, min: DVec3, max: DVec3) -> Cuboid {
        let h = [min.y, max.y];
        let (x, z) = ([min.x, max.x], [min.z, max.z]);
        let mirrored = |[low, high]: [f64; 2]| [-high, -low];
        match self {
            Self::PlusX => Cuboid { u: z, w: x, h },
            Self::MinusX => Cuboid { u: z, w: mirrored(x), h },
            Self::PlusZ => Cuboid { u: x, w: z, h },
            Self::MinusZ => Cuboid { u: x, w: mirrored(z), h },
        }
    }

    /// A point of the direction's space (u, w, h), turned.
    pub fn turned(self, u: f64, w: f64, h: f64) -> DVec3 {
        match self {
            Self::PlusX => DVec3::new(w, h, u),
            Self::MinusX => DVec3::new(-w, h, u),
            Self::PlusZ => DVec3::new(u, h, w),
            Self::MinusZ => DVec3::new(u, h, -w),
        }
    }
}

/// An upright box in the space of a direction, metres; each side `[low, high]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cuboid {
    /// Along the plane.
    pub u: [f64; 2],
    /// Away from the cell.
    pub w: [f64; 2],
    /// Up. An occluder's `h[0]` is its foot: minus infinity where nothing passes below it.
    pub h: [f64; 2],
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turning_and_back_is_nothing_and_no_turn_is_exact() {
        let v = DVec3::new(3.0, -2.0, 7.5);
        for degrees in [0, 1, 30, 45, 89, 90, 135] {
            let turn = Turn::degrees(degrees);
            assert!((turn.from(turn.to(v)) - v).length() < 1e-14);
            let axis = turn.axis();
            let along = DVec3::new(axis.x, 0.0, axis.y);
            assert!((turn.to(along) - DVec3::X).length() < 1e-15);
            assert_eq!(Turn::nearest_degrees(axis), degrees % 90);
            assert_eq!(Turn::nearest_degrees(-axis), degrees % 90);
            assert_eq!(Turn::nearest_degrees(axis.perp()), degrees % 90);
        }
        assert_eq!(Turn::degrees(90), Turn::NONE);
        assert_eq!(Turn::NONE.to(v), v);
        assert_eq!(Turn::NONE.around(-v.abs(), v.abs()), (-v.abs(), v.abs()));
    }

    #[test]
    fn a_box_around_holds_every_corner() {
        let (min, max) = (DVec3::new(1.0, 2.0, 3.0), DVec3::new(4.0, 5.0, 9.0));
        let turn = Turn::degrees(37);
        let (low, high) = turn.around(min, max);
        for x in [min.x, max.x] {
            for z in [min.z, max.z] {
                let corner = turn.to(DVec3::new(x, 2.5, z));
                assert!(corner.cmpge(low - 1e-12).all() && corner.cmple(high + 1e-12).all());
            }
        }
        assert_eq!((low.y, high.y), (2.0, 5.0));
    }

    #[test]
    fn directions_point_away_along_w() {
        let (min, max) = (DVec3::new(1.0, 2.0, 3.0), DVec3::new(4.0, 5.0, 9.0));
        for direction in Direction::ALL {
            assert_eq!(Direction::ALL[direction.index()], direction);
            let c = direction.cuboid(min, max);
            let far = direction.turned(c.u[0], c.w[1], c.h[0]);
            let near = direction.turned(c.u[0], c.w[0], c.h[0]);
            let along = (far - near).dot(direction.vector());
            assert_eq!(along, c.w[1] - c.w[0]);
            assert!(far.cmpge(min).all() && far.cmple(max).all());
        }
    }
}
