//! Projections of occludees on planes behind them.

use crate::region::Cuboid;
use crate::region::horizon::{Projection, SLACK};

/// Everything of the plane w = `plane` that any line from a point of the cell through a point of the
/// occludee leads to; the occludee lies between the cell and the plane. `None` where it begins no
/// farther away than the cell ends, or reaches behind the plane: that has no end.
pub(super) fn beyond(cell: &Cuboid, occludee: &Cuboid, plane: f64) -> Option<Projection> {
    let [near, far] = occludee.w;
    if !(near > cell.w[1] && far <= plane) {
        return None;
    }
    // How much farther the plane is than the occludee, as a share of the way from the cell.
    let most = (plane - near) / (near - cell.w[1]);
    let least = (plane - far) / (far - cell.w[0]);
    let side = |[c0, c1]: [f64; 2], [o0, o1]: [f64; 2]| {
        let greatest = c0.abs().max(c1.abs()).max(o0.abs()).max(o1.abs());
        let slack = SLACK * greatest * (1.0 + most);
        let low = o0 + (o0 - c1) * if o0 < c1 { most } else { least };
        let high = o1 + (o1 - c0) * if o1 > c0 { most } else { least };
        [low - slack, high + slack]
    };
    let on_plane = Projection { u: side(cell.u, occludee.u), h: side(cell.h, occludee.h) };
    let ends = [on_plane.u, on_plane.h];
    ends.as_flattened().iter().all(|e| e.is_finite()).then_some(on_plane)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_point_half_way_is_cast_twice_as_far() {
        let cell = Cuboid { u: [-1.0, 1.0], w: [0.0, 0.0], h: [0.0, 2.0] };
        let at = |u: f64, w: f64, h: f64| Cuboid { u: [u; 2], w: [w; 2], h: [h; 2] };
        let near = |a: [f64; 2], b: [f64; 2]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-9);
        let p = beyond(&cell, &at(0.5, 5.0, 3.0), 10.0).unwrap();
        assert!(near(p.u, [0.0, 2.0]) && near(p.h, [4.0, 6.0]), "{p:?}");
        assert_eq!(beyond(&cell, &at(0.5, 0.0, 3.0), 10.0), None);
        assert_eq!(beyond(&cell, &at(0.5, 11.0, 3.0), 10.0), None);
        assert_eq!(beyond(&cell, &at(f64::NAN, 5.0, 3.0), 10.0), None);
    }

    proptest! {
        #[test]
        fn every_line_through_the_occludee_leads_into_its_projection(
            corner in prop::array::uniform3(-20.0_f64..20.0),
            size in prop::array::uniform3(0.0_f64..30.0),
            (gap, behind) in (0.01_f64..50.0, 0.0_f64..50.0),
            shares in prop::array::uniform6(0.0_f64..=1.0),
            depth in 0.0_f64..5.0,
        ) {
            let cell = Cuboid { u: [-5.0, 5.0], w: [0.0, depth], h: [0.0, 10.0] };
            let near = depth + gap;
            let occludee = Cuboid {
                u: [corner[0], corner[0] + size[0]],
                w: [near, near + size[1]],
                h: [corner[2], corner[2] + size[2]],
            };
            let plane = occludee.w[1] + behind;
            let p = beyond(&cell, &occludee, plane).unwrap();
            let at = |[low, high]: [f64; 2], share: f64| low + (high - low) * share;
            let k = (plane - at(cell.w, shares[1])) / (at(occludee.w, shares[4]) - at(cell.w, shares[1]));
            let through = |c: f64, o: f64| c + (o - c) * k;
            let u = through(at(cell.u, shares[0]), at(occludee.u, shares[3]));
            let h = through(at(cell.h, shares[2]), at(occludee.h, shares[5]));
            let room = 1e-12 * (1.0 + u.abs() + h.abs());
            prop_assert!(u >= p.u[0] - room && u <= p.u[1] + room);
            prop_assert!(h >= p.h[0] - room && h <= p.h[1] + room);
        }
    }
}
