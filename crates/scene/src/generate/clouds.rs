//! Clouds whose mean optical thickness is known in closed form, and a cloud of balls.
//!
//! A *quad cloud* is `quads` horizontal squares of side s whose centres lie anywhere in a volume V
//! with equal chance. Under light from straight above, a vertical ray that runs a length l through
//! V meets, in the mean over seeds,
//!
//! ```text
//! layers = quads / |V| * s^2 * l
//! ```
//!
//! squares: a centre counts if it lies in the column of cross-section s^2 about the ray. With w the
//! optical thickness of one square, the mean of the sum is w * layers, and as the count is binomial
//! with chance p = layers / quads, the mean transmittance is
//!
//! ```text
//! T = (1 - p (1 - e^-w))^quads, close to e^(-layers (1 - e^-w)).
//! ```
//!
//! Exact in the box at more than s / 2 from its sides; in the ball, l is the mean over the column,
//! which differs from that of the ray itself by the order of (s / radius)^2, more at its rim.
//!
//! Built from arithmetic and square roots alone, so that a seed gives the same bits everywhere.

use super::builder::Builder;
use super::mesh;
use super::random::in_ball;
use crate::{Mesh, Scene};
use glam::{DVec3, Vec3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

/// Where the centres of a cloud's squares lie.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Volume {
    /// An axis-aligned box.
    Slab {
        /// Lower corner, metres.
        min: DVec3,
        /// Upper corner, metres.
        max: DVec3,
    },
    /// A ball.
    Ball {
        /// Centre, metres.
        centre: DVec3,
        /// Metres.
        radius: f64,
    },
}

/// What is known of a quad cloud; the scene holds it for a seed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QuadCloud {
    /// Number of squares.
    pub quads: u32,
    /// Side of each, metres.
    pub side_m: f64,
    /// Opacity of each, in 0..=1.
    pub opacity: f32,
    /// Where their centres lie.
    pub volume: Volume,
}

/// The scene `slab`: 12.5 layers over its height of 3 m.
pub const SLAB: QuadCloud = QuadCloud {
    quads: 20_000,
    side_m: 0.1,
    opacity: 0.1,
    volume: Volume::Slab { min: DVec3::new(-2.0, 1.5, -2.0), max: DVec3::new(2.0, 4.5, 2.0) },
};

/// The scene `sphere_cloud`: 15.3 layers over its diameter of 3 m.
pub const SPHERE_CLOUD: QuadCloud = QuadCloud {
    quads: 20_000,
    side_m: 0.06,
    opacity: 0.1,
    volume: Volume::Ball { centre: DVec3::new(0.0, 3.0, 0.0), radius: 1.5 },
};

impl Volume {
    /// Cubic metres.
    pub fn cubic_m(&self) -> f64 {
        match *self {
            Self::Slab { min, max } => (max - min).element_product(),
            Self::Ball { radius, .. } => 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3),
        }
    }

    /// Metres of the vertical ray from above to `point` that lie in the volume.
    pub fn length_above(&self, point: DVec3) -> f64 {
        let (low, high) = match *self {
            Self::Slab { min, max } => {
                let inside =
                    (min.x..=max.x).contains(&point.x) && (min.z..=max.z).contains(&point.z);
                if inside { (min.y, max.y) } else { (0.0, 0.0) }
            }
            Self::Ball { centre, radius } => {
                let (dx, dz) = (point.x - centre.x, point.z - centre.z);
                let half = (radius * radius - dx * dx - dz * dz).max(0.0).sqrt();
                (centre.y - half, centre.y + half)
            }
        };
        (high - point.y.max(low)).max(0.0)
    }
}

impl QuadCloud {
    /// Mean number of squares strictly above a point.
    pub fn mean_layers(&self, point: DVec3) -> f64 {
        let per_metre = f64::from(self.quads) / self.volume.cubic_m() * self.side_m.powi(2);
        per_metre * self.volume.length_above(point)
    }

    /// Mean transmittance from above to a point, for squares of optical thickness `omega` each.
    pub fn mean_transmittance(&self, point: DVec3, omega: f64) -> f64 {
        let chance = self.mean_layers(point) / f64::from(self.quads);
        (1.0 - chance * (1.0 - (-omega).exp())).powf(f64::from(self.quads))
    }

    fn mesh(&self, rng: &mut Pcg64) -> Mesh {
        let half = (0.5 * self.side_m) as f32;
        let mut mesh = Mesh::default();
        for _ in 0..self.quads {
            let centre = match self.volume {
                Volume::Slab { min, max } => {
                    let (min, max) = (min.as_vec3(), max.as_vec3());
                    let mut along = |k: usize| rng.random_range(min[k]..max[k]);
                    Vec3::new(along(0), along(1), along(2))
                }
                Volume::Ball { centre, radius } => centre.as_vec3() + in_ball(rng) * radius as f32,
            };
            mesh::append(&mut mesh, &mesh::quad(centre, Vec3::Z * half, Vec3::X * half));
        }
        mesh
    }
}

/// A quad cloud above the ground, lit from straight above.
pub fn quad_cloud(name: &str, cloud: &QuadCloud, seed: u64) -> Scene {
    let mut b = Builder::outdoors(name);
    let material = b.translucent("cloud", [0.7; 3], cloud.opacity);
    b.add("cloud", material, cloud.mesh(&mut Pcg64::seed_from_u64(seed)));
    views(&mut b);
    b.0
}

fn views(b: &mut Builder) {
    let (eye, target) = (DVec3::new(0.0, 6.0, 11.0), DVec3::new(0.0, 1.9, 0.0));
    b.camera("front", eye, target, 34.0);
    b.orbit(eye, target, 34.0, 30.0);
}

/// One ball of the scene `metaballs`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ball {
    /// Metres.
    pub centre: Vec3,
    /// Metres.
    pub radius: f32,
}

/// Opacity of the balls' surfaces.
pub const BALL_OPACITY: f32 = 127.0 / 255.0;

/// The 30 overlapping balls of the scene `metaballs`, for those who draw them as volumes.
pub fn metaball_balls(seed: u64) -> Vec<Ball> {
    let mut rng = Pcg64::seed_from_u64(seed);
    (0..30)
        .map(|_| Ball {
            centre: Vec3::new(0.0, 3.2, 0.0) + in_ball(&mut rng) * Vec3::new(2.2, 0.9, 1.4),
            radius: rng.random_range(0.5..0.95),
        })
        .collect()
}

/// [`metaball_balls`] as translucent surfaces of 1,280 triangles each.
pub fn metaballs(seed: u64) -> Scene {
    let mut b = Builder::outdoors("metaballs");
    let material = b.translucent("ball", [0.8; 3], BALL_OPACITY);
    let balls = metaball_balls(seed);
    let surfaces: Vec<Mesh> =
        balls.iter().map(|ball| mesh::icosphere(ball.centre, ball.radius, 3)).collect();
    b.add("balls", material, mesh::join(&surfaces));
    views(&mut b);
    b.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_in_the_volumes_are_those_of_hand() {
        let slab = SLAB.volume;
        assert_eq!(slab.cubic_m(), 48.0);
        for (y, length) in [(9.0, 0.0), (4.5, 0.0), (3.5, 1.0), (1.5, 3.0), (0.0, 3.0)] {
            assert_eq!(slab.length_above(DVec3::new(1.0, y, -1.9)), length);
            assert_eq!(slab.length_above(DVec3::new(2.1, y, 0.0)), 0.0);
        }
        let ball = SPHERE_CLOUD.volume;
        for (x, y, length) in [(0.0, 0.0, 3.0), (0.0, 3.0, 1.5), (0.9, 0.0, 2.4), (1.6, 0.0, 0.0)] {
            let l = ball.length_above(DVec3::new(x, y, 0.0));
            assert!((l - length).abs() < 1e-12, "{l}");
        }
        assert!((SLAB.mean_layers(DVec3::ZERO) - 12.5).abs() < 1e-12);
        let most = SPHERE_CLOUD.mean_layers(DVec3::ZERO);
        assert!((most - 48.0 / std::f64::consts::PI).abs() < 0.02, "{most}");
        let t = SLAB.mean_transmittance(DVec3::ZERO, 0.1);
        assert!((t / (-12.5 * (1.0 - (-0.1f64).exp())).exp() - 1.0).abs() < 1e-4, "{t}");
        assert_eq!(SLAB.mean_transmittance(DVec3::Y * 5.0, 0.1), 1.0);
    }

    /// Squares above a point.
    fn counted(centres: &[Vec3], side: f64, at: DVec3) -> u32 {
        let near = |a: f32, b: f64| (f64::from(a) - b).abs() <= 0.5 * side;
        let above = |c: &&Vec3| f64::from(c.y) > at.y && near(c.x, at.x) && near(c.z, at.z);
        centres.iter().filter(above).count() as u32
    }

    /// Mean error of the count and of the transmittance over points a side apart, whose squares
    /// are not shared, in standard deviations.
    fn deviations(cloud: &QuadCloud, model: &QuadCloud, n: i32, y: f64) -> [f64; 2] {
        let mesh = cloud.mesh(&mut Pcg64::seed_from_u64(11));
        let centres: Vec<Vec3> = mesh.positions.chunks(4).map(|q| 0.5 * (q[0] + q[2])).collect();
        let omega = 0.1f64;
        let mut sums = [[0.0; 2]; 2];
        for i in 0..n * n {
            let place = |k: i32| (f64::from(k) - 0.5 * f64::from(n - 1)) * cloud.side_m;
            let at = DVec3::new(place(i % n), y, place(i / n));
            let layers = counted(&centres, cloud.side_m, at);
            let mean = model.mean_layers(at);
            let t = model.mean_transmittance(at, omega);
            // E[T^2] is the mean transmittance of squares twice as thick.
            let variance = model.mean_transmittance(at, 2.0 * omega) - t * t;
            sums[0][0] += f64::from(layers) - mean;
            sums[0][1] += mean;
            sums[1][0] += (-omega * f64::from(layers)).exp() - t;
            sums[1][1] += variance;
        }
        sums.map(|[error, variance]| (error / variance.sqrt()).abs())
    }

    #[test]
    fn clouds_have_the_mean_layers_and_transmittance_of_the_formula() {
        for y in [0.0, 2.5, 4.0] {
            let found = deviations(&SLAB, &SLAB, 36, y);
            assert!(found.iter().all(|z| *z < 4.0), "slab, y {y}: {found:?}");
        }
        for y in [0.0, 3.0] {
            let found = deviations(&SPHERE_CLOUD, &SPHERE_CLOUD, 24, y);
            assert!(found.iter().all(|z| *z < 4.0), "ball, y {y}: {found:?}");
        }
        // Control: squares 5 % larger than the formula's show.
        let larger = QuadCloud { side_m: 1.05 * SLAB.side_m, ..SLAB };
        let found = deviations(&SLAB, &larger, 36, 0.0);
        assert!(found.iter().all(|z| *z > 6.0), "{found:?}");
    }

    #[test]
    fn balls_overlap_into_one_cloud() {
        let balls = metaball_balls(3);
        assert_eq!(balls.len(), 30);
        for a in &balls {
            let meets = |b: &&Ball| *b != a && a.centre.distance(b.centre) < a.radius + b.radius;
            assert!(balls.iter().any(|b| meets(&b)), "{a:?} is alone");
        }
    }
}
