//! Shadows of single occluders on a plane, as seen from everywhere in a cell, and projections of what
//! they may hide.
//!
//! Based on: Melino Conte, "Real-time Rendering of Cities at Night", 2018, sections 4.2.3 (horizons),
//! 4.2.5 (reprojection), after F. Durand et al., "Conservative visibility preprocessing using extended
//! projections", 2000.
//! Deviations: the thesis gives no formulas; these are exact for boxes: a point lies in the umbra of a
//! convex occluder exactly if it is hidden from all corners of the cell. Occluders have a foot, minus
//! infinity where they are the thesis's, which reach down for ever. The edge is level or whole, besides
//! the thesis's single one. Of an occluder lower than the cell's top only the far face counts, save for
//! the whole edge: what the near face adds at the ends it takes from the height, so that joined shadows
//! hide less.
//!
//! Boxes are closed sets, and so are umbrae: what touches hides together. What rounding could give to
//! an umbra is taken from it in [`umbra`] and [`reproject`], save where an occluder's side lies on the
//! plane, which stays exact; [`project`] makes occludees larger, so that ties count as visible.

mod hull;
mod line;
mod outline;
pub mod point;
mod project;
mod reproject;
mod shadow;

pub use hull::{hull, union_of_edges};
pub use project::{Projection, SLACK, Supports, project};
pub use reproject::reproject;
pub use shadow::umbra;

/// The part of a plane that is hidden from every point of a cell: between `u[0]` and `u[1]`, above
/// `foot`, below an upper edge that goes from `top[0]` at `u[0]` by way of the peak, if there is one,
/// to `top[1]` at `u[1]`. It is convex.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Umbra {
    /// Left and right end, metres; the left one is smaller.
    pub u: [f64; 2],
    /// Height of the edge at each end.
    pub top: [f64; 2],
    /// Height above which it hides.
    pub foot: f64,
    /// Where it is higher than at its ends.
    pub peak: Option<Peak>,
}

/// The level part of an upper edge that falls to one side at least.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Peak {
    /// Its left and right end; they may be one point.
    pub u: [f64; 2],
    /// Its height.
    pub h: f64,
}

impl Umbra {
    /// A rectangle: from `u[0]` to `u[1]`, from `foot` to `top`.
    pub fn flat(u: [f64; 2], foot: f64, top: f64) -> Self {
        Self { u, top: [top; 2], foot, peak: None }
    }

    /// Whether its edge is level.
    pub fn is_flat(&self) -> bool {
        self.top[0] == self.top[1] && self.peak.is_none()
    }

    /// Whether a projection lies wholly inside.
    pub fn hides(&self, p: &Projection) -> bool {
        p.u[0] >= self.u[0] && p.u[1] <= self.u[1] && p.h[0] >= self.foot && {
            p.h[1] <= self.height(p.u[0]).min(self.height(p.u[1]))
        }
    }

    /// Height of the edge at `u`, which lies between the ends; not above it by rounding.
    pub fn height(&self, u: f64) -> f64 {
        let [left, right] = self.u;
        match self.peak {
            None if self.top[0] == self.top[1] => self.top[0],
            None => line::between([left, self.top[0]], [right, self.top[1]], u),
            Some(Peak { u: [first, _], h }) if u < first => {
                line::between([left, self.top[0]], [first, h], u)
            }
            Some(Peak { u: [_, last], h }) if u > last => {
                line::between([last, h], [right, self.top[1]], u)
            }
            Some(Peak { h, .. }) => h,
        }
    }

    /// The lowest point of the edge: up to there it hides over its whole width.
    pub fn lowest(&self) -> f64 {
        self.top[0].min(self.top[1])
    }

    /// The highest point of the edge: above it nothing is hidden.
    pub fn highest(&self) -> f64 {
        // Where it falls to one side only, an end may be higher than the peak.
        let ends = self.top[0].max(self.top[1]);
        self.peak.map_or(ends, |peak| peak.h.max(ends))
    }

    /// The edge from left to right, as points (u, h): two to four.
    pub fn vertices(&self) -> Vec<[f64; 2]> {
        let mut vertices = vec![[self.u[0], self.top[0]]];
        if let Some(Peak { u, h }) = self.peak {
            vertices.extend(u.map(|u| [u, h]));
        }
        vertices.push([self.u[1], self.top[1]]);
        vertices.dedup();
        vertices
    }
}
