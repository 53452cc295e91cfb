//! Which pixels a pixel looks at.

use super::Plan;
use crate::sample::Random;

/// The neighbours of a pixel, by chance: number of the pixel and the number in 0..1 that decides for
/// or against it. Each costs two random numbers, whether it lies in the image or not; those outside
/// and the pixel itself are left out. The same again from a copy.
#[derive(Clone, Debug)]
pub(crate) struct Neighbours {
    random: Random,
    left: u32,
    plan: Plan,
    size: [i32; 2],
    at: [i32; 2],
}

impl Neighbours {
    /// Those of `pixel` in an image of width x height.
    pub fn new(plan: &Plan, random: Random, size: [u32; 2], pixel: usize) -> Self {
        let (width, pixel) = (size[0].max(1), pixel as u32);
        let at = [(pixel % width) as i32, (pixel / width) as i32];
        let left = plan.neighbours;
        Self { random, left, plan: *plan, size: size.map(|side| side as i32), at }
    }
}

impl Iterator for Neighbours {
    type Item = (usize, f32);

    #[inline]
    fn next(&mut self) -> Option<Self::Item> {
        while self.left > 0 {
            self.left -= 1;
            let [x, y] = offset(&self.plan, self.random.bits());
            let unit = self.random.unit();
            let [column, row] = [self.at[0] + x, self.at[1] + y];
            let inside = column >= 0 && row >= 0 && column < self.size[0] && row < self.size[1];
            if inside && [x, y] != [0, 0] {
                return Some(((row * self.size[0] + column) as usize, unit));
            }
        }
        None
    }
}

/// A place of the square by 16 bits each; outside of the disc it is halved, and is inside then.
fn offset(plan: &Plan, bits: u32) -> [i32; 2] {
    let side = 2 * plan.radius as u32 + 1;
    let place = |bits: u32| ((bits * side) >> 16) as i32 - plan.radius;
    let [x, y] = [place(bits >> 16), place(bits & 0xffff)];
    if x * x + y * y > plan.radius_squared { [x / 2, y / 2] } else { [x, y] }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plan(radius_px: f64) -> Plan {
        let settings = crate::Reservoirs {
            candidates: 1,
            temporal: false,
            history: 0,
            neighbours: 50,
            radius_px,
            unbiased: true,
        };
        Plan::new(&settings).unwrap()
    }

    #[test]
    fn offsets_stay_within_the_radius_and_reach_every_pixel_of_it() {
        for radius in [1.0, 1.5, 2.9, 7.0, 16_383.0] {
            let plan = plan(radius);
            let mut seen = std::collections::BTreeSet::new();
            let mut random = Random::new(3, 0, 0);
            for _ in 0..20_000 {
                let [x, y] = offset(&plan, random.bits());
                assert!(f64::from(x * x + y * y).sqrt() <= radius, "{x} {y} of {radius}");
                seen.insert([x, y]);
            }
            let reach = (-7..=7).flat_map(|x| (-7..=7).map(move |y| [x, y]));
            let disc = |[x, y]: &[i32; 2]| f64::from(x * x + y * y).sqrt() <= radius;
            if radius <= 7.0 {
                assert_eq!(reach.filter(disc).filter(|p| !seen.contains(p)).count(), 0, "{radius}");
            }
        }
    }

    #[test]
    fn neighbours_lie_in_the_image_and_are_others() {
        for (radius, size) in [(3.0, [5, 4]), (12.0, [5, 4]), (0.9, [5, 4]), (9.0, [1, 1])] {
            let plan = plan(radius);
            let mut met = 0;
            for pixel in 0..(size[0] * size[1]) as usize {
                let all = Neighbours::new(&plan, Random::new(1, 0, pixel as u32), size, pixel);
                for (neighbour, unit) in all.clone() {
                    met += 1;
                    assert!(neighbour < (size[0] * size[1]) as usize && neighbour != pixel);
                    assert!((0.0..1.0).contains(&unit));
                }
                assert!(all.clone().eq(all));
            }
            assert_eq!(met > 0, radius >= 1.0 && size != [1, 1]);
        }
    }
}
