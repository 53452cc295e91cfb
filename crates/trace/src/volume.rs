//! Volumes of metaballs, with no surface at all: exactly by chords.

use crate::error::TraceError;
use crate::tracer::Ray;
use dapple_scene::Aabb;
use glam::DVec3;

/// How a ball's extinction falls off with the distance from its centre.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Profile {
    /// The same everywhere inside.
    #[default]
    Homogeneous,
    /// (1 - (r / radius)²)² of it: smooth up to the border.
    Soft,
}

/// A ball that absorbs light. Where balls overlap, their extinctions add up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ball {
    /// World space, metres.
    pub centre: DVec3,
    /// Metres, > 0.
    pub radius: f64,
    /// At the centre, per metre, >= 0.
    pub extinction: f64,
    /// Its fall-off.
    pub profile: Profile,
}

impl Ball {
    /// Where a ray enters and leaves the ball, in units of its direction, whatever the ray's range;
    /// `None` where it misses.
    pub fn chord(&self, ray: &Ray) -> Option<(f64, f64)> {
        let length = ray.direction.length();
        let direction = ray.direction / length;
        let to_centre = self.centre - ray.origin;
        let middle = to_centre.dot(direction);
        let miss = (to_centre - direction * middle).length();
        let half = ((self.radius - miss) * (self.radius + miss)).sqrt();
        // False for what is not a number as well.
        (half > 0.0).then_some(((middle - half) / length, (middle + half) / length))
    }

    /// Extinction at a point, per metre.
    pub fn extinction_at(&self, point: DVec3) -> f64 {
        let squared = (point - self.centre).length_squared() / (self.radius * self.radius);
        match self.profile {
            _ if squared >= 1.0 => 0.0,
            Profile::Homogeneous => self.extinction,
            Profile::Soft => self.extinction * (1.0 - squared) * (1.0 - squared),
        }
    }

    /// Extinction integrated over the part of the ray within its range.
    pub fn optical_depth(&self, ray: &Ray) -> f64 {
        let Some((enter, leave)) = self.chord(ray) else { return 0.0 };
        let (from, to) = (enter.max(ray.t_min), leave.min(ray.t_max));
        let meets = from < to;
        if !meets {
            return 0.0;
        }
        let length = ray.direction.length();
        match self.profile {
            Profile::Homogeneous => self.extinction * (to - from) * length,
            Profile::Soft => {
                // In radii from the middle of the chord, half of which is h: 1 - r² = h² - s².
                let half = 0.5 * (leave - enter) * length / self.radius;
                let middle = 0.5 * (enter + leave);
                let place = |t: f64| ((t - middle) * length / self.radius).clamp(-half, half);
                let h2 = half * half;
                let integral = |s: f64| s * (h2 * h2 - s * s * (2.0 / 3.0 * h2 - s * s / 5.0));
                self.extinction * self.radius * (integral(place(to)) - integral(place(from)))
            }
        }
    }
}

/// Extinction of all balls integrated over a ray's range; e to the minus this is the light that
/// gets through. 0 for a ray that is not finite.
pub fn optical_depth(balls: &[Ball], ray: &Ray) -> f64 {
    balls.iter().map(|ball| ball.optical_depth(ray)).sum()
}

/// The box around all balls.
///
/// # Errors
/// A ball that is not finite, has no size or a negative extinction.
pub fn ball_bounds(balls: &[Ball]) -> Result<Aabb, TraceError> {
    let mut bounds = Aabb::EMPTY;
    for (ball, &Ball { centre, radius, extinction, .. }) in balls.iter().enumerate() {
        let sized = radius > 0.0 && radius.is_finite() && extinction >= 0.0;
        if !(sized && extinction.is_finite() && centre.is_finite()) {
            return Err(TraceError::Ball { ball, centre, radius, extinction });
        }
        bounds = bounds.grow(centre - radius).grow(centre + radius);
    }
    Ok(bounds)
}

#[cfg(test)]
mod tests {
    use super::*;

    const UNIT: Ball =
        Ball { centre: DVec3::ZERO, radius: 1.0, extinction: 2.0, profile: Profile::Homogeneous };

    fn ray_at(miss: f64) -> Ray {
        Ray::new(DVec3::new(miss, 0.0, -5.0), DVec3::Z * 0.5)
    }

    #[test]
    fn chords_and_optical_depths_by_hand() {
        assert_eq!(UNIT.chord(&ray_at(0.0)), Some((8.0, 12.0)));
        assert_eq!(UNIT.chord(&ray_at(1.0)), None);
        assert_eq!(UNIT.chord(&ray_at(f64::NAN)), None);
        assert!((UNIT.optical_depth(&ray_at(0.6)) - 2.0 * 1.6).abs() < 1e-14);
        // From the centre, to the centre, past it, before it.
        let part = |t_min, t_max| UNIT.optical_depth(&Ray { t_min, t_max, ..ray_at(0.0) });
        assert_eq!(part(10.0, 99.0), 2.0);
        assert_eq!(part(0.0, 10.0), 2.0);
        assert_eq!((part(12.0, 99.0), part(0.0, 8.0), part(99.0, 0.0)), (0.0, 0.0, 0.0));
        // 16/15 h⁵ of a soft one: through the middle, and at 0.6 (h = 0.8).
        let soft = Ball { profile: Profile::Soft, radius: 2.0, ..UNIT };
        let through = |miss: f64| soft.optical_depth(&ray_at(miss));
        assert!((through(0.0) - 2.0 * 2.0 * 16.0 / 15.0).abs() < 1e-14);
        assert!((through(1.2) - 2.0 * 2.0 * 16.0 / 15.0 * 0.8_f64.powi(5)).abs() < 1e-14);
    }

    #[test]
    fn chords_are_the_integral_of_the_extinction() {
        let balls = [
            UNIT,
            Ball { centre: DVec3::new(0.5, 0.2, 0.1), radius: 0.8, ..UNIT },
            Ball { centre: DVec3::new(0.1, -0.4, 0.3), profile: Profile::Soft, ..UNIT },
        ];
        let ray = Ray {
            origin: DVec3::new(-2.0, 0.1, 0.2),
            direction: DVec3::new(3.0, -0.3, 0.4),
            t_min: 0.4,
            t_max: 0.9,
        };
        let (steps, length) = (200_000, ray.direction.length());
        let step = (ray.t_max - ray.t_min) / f64::from(steps);
        let sum: f64 = (0..steps)
            .map(|i| ray.at(ray.t_min + step * (f64::from(i) + 0.5)))
            .map(|p| balls.iter().map(|ball| ball.extinction_at(p)).sum::<f64>())
            .sum();
        let (got, expected) = (optical_depth(&balls, &ray), sum * step * length);
        assert!(expected > 1.0 && (got / expected - 1.0).abs() < 1e-5, "{got} {expected}");
    }

    #[test]
    fn bad_balls_are_named() {
        let broken = |change: fn(&mut Ball)| {
            let mut balls = [UNIT; 3];
            change(&mut balls[1]);
            ball_bounds(&balls).unwrap_err().to_string()
        };
        assert!(broken(|b| b.radius = 0.0).contains("ball 1"));
        assert!(broken(|b| b.radius = f64::INFINITY).contains("ball 1"));
        assert!(broken(|b| b.extinction = -1.0).contains("-1"));
        assert!(broken(|b| b.extinction = f64::NAN).contains("NaN"));
        assert!(broken(|b| b.centre.y = f64::NAN).contains("NaN"));
        assert_eq!(ball_bounds(&[UNIT]).unwrap().max, DVec3::ONE);
        assert!(ball_bounds(&[]).unwrap().is_empty());
    }
}
