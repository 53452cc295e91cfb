//! What may be hidden, on a plane before it.

use super::super::Cuboid;

/// Everything of a plane that any line from a point of a cell to a point of an occludee crosses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Projection {
    /// Left and right end, metres.
    pub u: [f64; 2],
    /// The lowest and the highest point.
    pub h: [f64; 2],
}

/// Projections are larger than they would have to be by this share of the greatest coordinate along
/// the same axis of the cell and the occludee, and of their distance. Their own rounding is a
/// thousandth of it; the rest is for boxes that were turned, which moves sides by some 1e-16 of their
/// coordinates, the more the nearer occluders are to the cell. So what only touches the border of an
/// umbra is visible, at the origin too.
pub const SLACK: f64 = 1e-12;

/// Lies in no umbra.
const EVERYWHERE: Projection =
    Projection { u: [f64::NEG_INFINITY, f64::INFINITY], h: [f64::NEG_INFINITY, f64::INFINITY] };

/// What the projections of an occludee on all planes have in common: the planes between it and the
/// cell that touch both.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Supports {
    /// Where the cell ends.
    front: f64,
    /// Where the occludee begins and ends.
    w: [f64; 2],
    /// From the cell's rear to where the occludee begins, and from its front to where that ends.
    depths: [f64; 2],
    u: Side,
    h: Side,
}

/// Along one axis: ends of the occludee, the way from each to the cell's, whether it is the cell's rear
/// that the touching plane meets, and what is added.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Side {
    from: [f64; 2],
    way: [f64; 2],
    rear: [bool; 2],
    slack: f64,
}

impl Supports {
    /// Of a cell and an occludee.
    pub fn of(cell: &Cuboid, occludee: &Cuboid) -> Self {
        let depth = occludee.w[1] - cell.w[0];
        let side = |[c0, c1]: [f64; 2], [o0, o1]: [f64; 2]| Side {
            from: [o0, o1],
            way: [c0 - o0, c1 - o1],
            rear: [o0 < c0, o1 > c1],
            slack: SLACK * (depth + c0.abs().max(c1.abs()).max(o0.abs()).max(o1.abs())),
        };
        Self {
            front: cell.w[1],
            w: occludee.w,
            depths: [occludee.w[0] - cell.w[0], occludee.w[1] - cell.w[1]],
            u: side(cell.u, occludee.u),
            h: side(cell.h, occludee.h),
        }
    }

    /// The projection on the plane w = `plane`, which lies behind the cell and not behind the
    /// occludee's near face; everywhere, if it does not.
    pub fn on(&self, plane: f64) -> Projection {
        if !(plane >= self.front && self.w[0] >= plane) {
            return EVERYWHERE;
        }
        // How far back from the occludee the plane lies, as a share of the way to the cell: 0 on it.
        let [least, most] = [0, 1].map(|i| match self.w[i] == plane {
            true => 0.0,
            false => (self.w[i] - plane) / self.depths[i],
        });
        let side = |side: &Side| {
            let end =
                |i: usize| side.from[i] + side.way[i] * if side.rear[i] { least } else { most };
            [end(0) - side.slack, end(1) + side.slack]
        };
        Projection { u: side(&self.u), h: side(&self.h) }
    }
}

/// The projection of an occludee on the plane w = `plane`, which lies behind the cell and not behind
/// the occludee's near face; everywhere, if it does not.
pub fn project(cell: &Cuboid, occludee: &Cuboid, plane: f64) -> Projection {
    Supports::of(cell, occludee).on(plane)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn before_the_plane_or_in_front_of_it_nothing_is_inside_an_umbra() {
        let cell = Cuboid { u: [0.0, 1.0], w: [0.0, 1.0], h: [0.0, 1.0] };
        let occludee = Cuboid { u: [0.0, 1.0], w: [5.0, 6.0], h: [0.0, 1.0] };
        assert_eq!(project(&cell, &occludee, 5.5), EVERYWHERE);
        assert_eq!(project(&cell, &occludee, 0.5), EVERYWHERE);
        assert_eq!(project(&cell, &occludee, f64::NAN), EVERYWHERE);
        assert_ne!(project(&cell, &occludee, 5.0), EVERYWHERE);
    }
}
