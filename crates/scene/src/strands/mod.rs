//! Strands of hair or grass as plain data: polylines with a radius. A *line of given radius* is
//! drawn as the ribbon that faces whoever looks at it (`ribbons`).

mod ribbons;

use crate::{Aabb, MAX_COORDINATE_M, MAX_TRIANGLES, SceneError};
use glam::Vec3;
use std::ops::Range;

pub use ribbons::{Facing, Ribbons};

/// Polylines, one after another.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Strands {
    /// Name shown in tables and given to the ribbons' mesh.
    pub name: String,
    /// Index of each strand's first point; it ends where the next strand begins, the last one with
    /// the points.
    pub starts: Vec<u32>,
    /// Points from root to tip, metres.
    pub points: Vec<Vec3>,
    /// Half of the thickness, metres: one for all, or one a point.
    pub radius: Vec<f32>,
}

impl Strands {
    /// Checks what [`Strands::ribbons`] relies on: strands in order and none empty, coordinates
    /// finite and within [`MAX_COORDINATE_M`], radii positive and as many as they should be, and
    /// no more than [`MAX_TRIANGLES`] when drawn.
    ///
    /// # Errors
    /// [`SceneError::Invalid`] with the first broken rule, labelled `label` (a file or a name).
    pub fn validate_as(&self, label: &str) -> Result<(), SceneError> {
        self.check().map_err(|(element, limit)| SceneError::Invalid {
            scene: label.into(),
            element,
            limit,
        })
    }

    /// [`Self::validate_as`] with the strands' own name.
    ///
    /// # Errors
    /// As [`Self::validate_as`].
    pub fn validate(&self) -> Result<(), SceneError> {
        self.validate_as(&self.name)
    }

    fn check(&self) -> Result<(), (String, String)> {
        let n = self.points.len();
        if self.starts.first() != Some(&0) || n == 0 {
            let limit =
                format!("{} strands of {n} points; the first begins at 0", self.starts.len());
            return Err(("strands".into(), limit));
        }
        let ends = self.starts[1..].iter().map(|&end| end as usize).chain([n]);
        for (i, (&start, end)) in self.starts.iter().zip(ends).enumerate() {
            if start as usize >= end || end > n {
                let limit = format!("points {start}..{end} of {n}; each strand needs one");
                return Err((format!("strand {i}"), limit));
            }
        }
        let outside =
            |p: &Vec3| !p.is_finite() || f64::from(p.abs().max_element()) > MAX_COORDINATE_M;
        if let Some(at) = self.points.iter().position(outside) {
            let limit = format!(
                "position {} m, coordinates must be finite, at most {MAX_COORDINATE_M:e} m",
                self.points[at]
            );
            return Err((self.label(at), limit));
        }
        if self.radius.len() != 1 && self.radius.len() != n {
            let limit = format!("{} for {n} points; needs 1 or one each", self.radius.len());
            return Err(("radii".into(), limit));
        }
        let usable = |r: f32| r > 0.0 && f64::from(r) <= MAX_COORDINATE_M;
        if let Some(at) = self.radius.iter().position(|&r| !usable(r)) {
            let limit =
                format!("radius {} m is outside (0, {MAX_COORDINATE_M:e}]", self.radius[at]);
            return Err((self.label(at), limit));
        }
        let triangles = 2 * self.segment_count();
        if triangles > MAX_TRIANGLES {
            let limit = format!("{triangles} triangles as ribbons, at most {MAX_TRIANGLES}");
            return Err(("strands".into(), limit));
        }
        Ok(())
    }

    /// `strand 3, point 7` of a place in `points`.
    fn label(&self, point: usize) -> String {
        let strand = self.starts.partition_point(|&s| s as usize <= point).saturating_sub(1);
        format!("strand {strand}, point {}", point - self.starts[strand] as usize)
    }

    /// Places in `points` of each strand, in order.
    pub fn ranges(&self) -> impl Iterator<Item = Range<usize>> + '_ {
        let ends = self.starts.iter().skip(1).map(|&end| end as usize).chain([self.points.len()]);
        self.starts.iter().zip(ends).map(|(&start, end)| start as usize..end)
    }

    /// Pieces between neighbouring points, over all strands.
    pub fn segment_count(&self) -> usize {
        self.points.len() - self.starts.len().min(self.points.len())
    }

    /// Bounds of the points, without their thickness.
    pub fn bounds(&self) -> Aabb {
        self.points.iter().fold(Aabb::EMPTY, |b, p| b.grow(p.as_dvec3()))
    }

    fn radius_at(&self, point: usize) -> f64 {
        f64::from(self.radius[if self.radius.len() == 1 { 0 } else { point }])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn good() -> Strands {
        Strands {
            name: "tuft".into(),
            starts: vec![0, 2],
            points: vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z, Vec3::ONE],
            radius: vec![0.1],
        }
    }

    #[test]
    fn good_strands_pass_and_count() {
        let s = good();
        s.validate().unwrap();
        assert_eq!(s.ranges().collect::<Vec<_>>(), [0..2, 2..5]);
        assert_eq!(s.segment_count(), 3);
        assert_eq!((s.bounds().min, s.bounds().max), (glam::DVec3::ZERO, glam::DVec3::ONE));
        Strands { radius: vec![0.1; 5], ..good() }.validate().unwrap();
        // A strand of one point is no line, but no fault.
        Strands { starts: vec![0, 4], ..good() }.validate().unwrap();
    }

    #[test]
    fn every_rule_names_the_element_and_the_limit() {
        let broken = |change: &dyn Fn(&mut Strands)| {
            let mut s = good();
            change(&mut s);
            let message = s.validate_as("a.hair").unwrap_err().to_string();
            assert!(message.starts_with("a.hair: "), "{message}");
            message
        };
        let point = |v: f32| broken(&move |s| s.points[3].y = v);
        for value in [f32::NAN, f32::INFINITY, 2e9] {
            assert!(point(value).contains("strand 1, point 1: position"), "{}", point(value));
        }
        assert!(point(f32::NAN).contains("at most 1e9 m"));
        let radius = |v: f32| broken(&move |s| s.radius = vec![0.1, v, 0.1, 0.1, 0.1]);
        for value in [0.0, -1.0, f32::NAN, f32::INFINITY] {
            assert!(radius(value).contains("strand 0, point 1: radius"), "{}", radius(value));
        }
        assert!(broken(&|s| s.radius.clear()).contains("0 for 5 points"));
        assert!(broken(&|s| s.radius = vec![0.1; 4]).contains("4 for 5 points"));
        assert!(broken(&|s| s.starts = vec![]).contains("0 strands"));
        assert!(broken(&|s| s.starts = vec![1, 2]).contains("begins at 0"));
        assert!(broken(&|s| s.points.clear()).contains("of 0 points"));
        assert!(broken(&|s| s.starts = vec![0, 2, 2]).contains("strand 1: points 2..2 of 5"));
        assert!(broken(&|s| s.starts = vec![0, 3, 2]).contains("strand 1: points 3..2"));
        assert!(broken(&|s| s.starts = vec![0, 5]).contains("strand 1: points 5..5"));
        assert!(broken(&|s| s.starts = vec![0, 9]).contains("points 0..9 of 5"));
    }
}
