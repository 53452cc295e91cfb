//! Maps as a criterion sees them.

use super::Precision;
use crate::{Blend, Format, OpacityError, layered::unit::Unit};

/// Cumulative sums of opacity of all texels, row-major: texel t holds its `layers` sums from
/// `sums[t * stride + offset]` on. They are thicknesses unless [`Layers::stored_as`] says how they
/// stand for such.
#[derive(Clone, Copy, Debug)]
pub struct Layers<'a> {
    width: usize,
    height: usize,
    layers: usize,
    stride: usize,
    offset: usize,
    sums: &'a [f32],
    /// How sums are stored; none: as they are.
    unit: Option<Unit>,
}

impl<'a> Layers<'a> {
    /// Looks at `width` x `height` texels of `stride` words, of which `layers` from `offset` on
    /// are the sums.
    ///
    /// # Errors
    /// An empty map, no layers or more than 256, layers that leave the stride, a slice of another
    /// length than the texels need.
    pub fn new(
        (width, height): (u32, u32),
        layers: usize,
        stride: usize,
        offset: usize,
        sums: &'a [f32],
    ) -> Result<Self, OpacityError> {
        if width == 0 || height == 0 {
            return Err(OpacityError::EmptyMap { width, height });
        }
        if !(1..=256).contains(&layers) {
            return Err(OpacityError::setting("layers", layers, "1..=256"));
        }
        if offset + layers > stride {
            return Err(OpacityError::setting("layers", layers, "within the words of a texel"));
        }
        let (width, height) = (width as usize, height as usize);
        let expected = width * height * stride;
        if sums.len() != expected {
            let actual = sums.len();
            return Err(OpacityError::Length { what: "sums of the maps", expected, actual });
        }
        Ok(Self { width, height, layers, stride, offset, sums, unit: None })
    }

    /// The same, with sums as this blend state leaves them in this format.
    #[must_use]
    pub fn stored_as(self, blend: Blend, format: Format) -> Self {
        let plain = blend == Blend::Add && format != Format::Unorm8Scaled;
        Self { unit: (!plain).then_some(Unit { blend, format }), ..self }
    }

    /// A stored sum as it is scored.
    #[inline]
    pub(super) fn value(&self, precision: Precision, sum: f32) -> f32 {
        precision.value(match self.unit {
            None => sum,
            Some(unit) => unit.thickness(f64::from(sum)) as f32,
        })
    }

    /// Texels in a row, rows.
    pub fn size(&self) -> (usize, usize) {
        (self.width, self.height)
    }

    /// Number of maps K.
    pub fn layers(&self) -> usize {
        self.layers
    }

    /// The sums of a texel.
    pub fn texel(&self, texel: usize) -> &'a [f32] {
        let first = texel * self.stride + self.offset;
        &self.sums[first..first + self.layers]
    }
}

/// The texels that are scored: every `step`-th of a rectangle in both directions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Region {
    /// First and one beyond the last column.
    pub columns: (usize, usize),
    /// First and one beyond the last row.
    pub rows: (usize, usize),
    /// Distance of texels that are looked at, >= 1.
    pub step: usize,
}

impl Region {
    /// The whole map, thinned to at most `side` texels a side (0: not thinned).
    pub fn whole(layers: &Layers, side: usize) -> Self {
        let (width, height) = layers.size();
        let step = if side == 0 { 1 } else { width.max(height).div_ceil(side) };
        Self { columns: (0, width), rows: (0, height), step }
    }

    /// The part in band `band` of `rows` scored rows each, if there is one.
    pub(super) fn band(self, band: usize, rows: usize) -> Self {
        let height = rows * self.step;
        let first = self.rows.0 + band * height;
        Self { rows: (first, (first + height).min(self.rows.1)), ..self }
    }

    /// Scored rows.
    pub(super) fn scored_rows(self) -> usize {
        self.rows.1.saturating_sub(self.rows.0).div_ceil(self.step)
    }

    /// Indices of the texels in a map `width` texels wide.
    pub fn texels(self, width: usize) -> impl Iterator<Item = usize> {
        let Self { columns, rows, step } = self;
        (rows.0..rows.1)
            .step_by(step)
            .flat_map(move |y| (columns.0..columns.1).step_by(step).map(move |x| y * width + x))
    }
}
