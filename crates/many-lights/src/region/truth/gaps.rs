//! Gaps between occluders towards a light.

use crate::region::Cuboid;

/// A stretch of a level line from which a light is seen past all occluders, without its ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gap {
    /// Left end, metres along u.
    pub from: f64,
    /// Right end, greater.
    pub to: f64,
}

/// All gaps of the level line from `u[0]` to `u[1]` at depth `w` and height `h` towards a light at
/// (u, w, h), which lies at a greater w; from left to right. Occluders are closed boxes: two that touch
/// leave no gap. `hidden` is used as memory.
pub fn gaps(
    [first, last]: [f64; 2],
    (w, h): (f64, f64),
    light: [f64; 3],
    occluders: &[Cuboid],
    hidden: &mut Vec<[f64; 2]>,
    found: &mut Vec<Gap>,
) {
    found.clear();
    hidden.clear();
    hidden.extend(occluders.iter().filter_map(|o| shadow((w, h), light, o)));
    hidden.retain(|[low, high]| *high >= first && *low <= last);
    hidden.sort_unstable_by(|a, b| a[0].total_cmp(&b[0]));
    let mut reached = first;
    for &[low, high] in hidden.iter() {
        if low > reached {
            found.push(Gap { from: reached, to: low });
        }
        reached = reached.max(high);
    }
    let is_open = hidden.is_empty() || last > reached;
    if is_open && first <= last {
        found.push(Gap { from: reached.min(last), to: last });
    }
}

/// From where on the level line at (w, h) the segment to the light meets the occluder.
fn shadow(
    (w, h): (f64, f64),
    [light_u, light_w, light_h]: [f64; 3],
    o: &Cuboid,
) -> Option<[f64; 2]> {
    // The depths at which the segment is neither above nor below the occluder.
    let rise = (light_h - h) / (light_w - w);
    let (mut near, mut far) = (o.w[0].max(w), o.w[1].min(light_w));
    if rise == 0.0 {
        if h < o.h[0] || h > o.h[1] {
            return None;
        }
    } else {
        let at = |height: f64| w + (height - h) / rise;
        let (a, b) = (at(o.h[0]), at(o.h[1]));
        near = near.max(a.min(b));
        far = far.min(a.max(b));
    }
    if near > far {
        return None;
    }
    // Seen from the light, that part of the occluder on the line.
    let back = |u: f64, depth: f64| {
        let left = light_w - depth;
        if left > 0.0 {
            light_u + (u - light_u) * ((light_w - w) / left)
        } else {
            // The occluder reaches the light's depth: it hides it from all of a side, or not at all.
            match u.total_cmp(&light_u) {
                std::cmp::Ordering::Less => f64::NEG_INFINITY,
                std::cmp::Ordering::Equal => light_u,
                std::cmp::Ordering::Greater => f64::INFINITY,
            }
        }
    };
    let low = back(o.u[0], near).min(back(o.u[0], far));
    let high = back(o.u[1], near).max(back(o.u[1], far));
    Some([low, high])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all(span: [f64; 2], at: (f64, f64), light: [f64; 3], boxes: &[Cuboid]) -> Vec<[f64; 2]> {
        let (mut hidden, mut found) = (vec![], vec![]);
        gaps(span, at, light, boxes, &mut hidden, &mut found);
        found.iter().map(|g| [g.from, g.to]).collect()
    }

    fn wall(u: [f64; 2], top: f64) -> Cuboid {
        Cuboid { u, w: [5.0, 5.0], h: [f64::NEG_INFINITY, top] }
    }

    #[test]
    fn a_wall_half_way_hides_twice_its_width_and_touching_walls_leave_no_gap() {
        let light = [0.0, 10.0, 2.0];
        let see = |walls: &[Cuboid]| all([-10.0, 10.0], (0.0, 2.0), light, walls);
        assert_eq!(see(&[]), [[-10.0, 10.0]]);
        assert_eq!(see(&[wall([-1.0, 2.0], 3.0)]), [[-10.0, -2.0], [4.0, 10.0]]);
        // As high as the line of sight still hides, lower does not.
        assert_eq!(see(&[wall([-1.0, 2.0], 2.0)]), [[-10.0, -2.0], [4.0, 10.0]]);
        assert_eq!(see(&[wall([-1.0, 2.0], 1.9)]), [[-10.0, 10.0]]);
        assert_eq!(see(&[wall([-6.0, 1.0], 3.0), wall([1.0, 6.0], 3.0)]), [[0.0; 2]; 0]);
        assert_eq!(see(&[wall([-6.0, 1.0], 3.0), wall([1.5, 6.0], 3.0)]), [[2.0, 3.0]]);
        // A wall over the whole line, and one beside it.
        assert_eq!(all([-1.0, 1.0], (0.0, 2.0), light, &[wall([2.0, 3.0], 3.0)]), [[-1.0, 1.0]]);
        // A line of no length.
        assert_eq!(all([7.0, 7.0], (0.0, 2.0), light, &[]), [[7.0, 7.0]]);
        assert_eq!(all([7.0, 7.0], (0.0, 2.0), light, &[wall([3.0, 4.0], 3.0)]), [[0.0; 2]; 0]);
    }

    #[test]
    fn the_part_below_the_roof_hides_and_the_part_below_the_foot_does_not() {
        // The segment climbs from 0 to 10 over 10 m: it is within 4..6 high at depths 4..6 only.
        let floating = Cuboid { u: [-1.0, 1.0], w: [0.0, 10.0], h: [4.0, 6.0] };
        let found = all([-10.0, 10.0], (0.0, 0.0), [0.0, 10.0, 10.0], &[floating]);
        assert_eq!(found, [[-10.0, -2.5], [2.5, 10.0]]);
    }
}
