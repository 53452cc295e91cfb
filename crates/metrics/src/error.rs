//! What a metric refuses.

/// Why there is no figure.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MetricError {
    /// Two inputs (or an input and its mask) differ in length.
    #[error("lengths differ: {left} and {right}")]
    Length {
        /// Elements of the first input.
        left: usize,
        /// Elements of the second input, or of the mask.
        right: usize,
    },
    /// Nothing to measure: no element, or none that the mask or the metric selects.
    #[error("no element to measure")]
    Empty,
    /// A NaN or infinity at this index of one of the inputs, or a difference beyond the range of
    /// `f64`.
    #[error("element {index} is not finite")]
    NotFinite {
        /// Index of the element.
        index: usize,
    },
    /// A denominator that is not above zero.
    #[error("element {index} of the denominator is not above zero")]
    NotPositive {
        /// Index of the element.
        index: usize,
    },
    /// An image whose pixel count does not match its size, or that is too large.
    #[error("an image of {width}x{height} with {channels} channels does not have {len} values")]
    Size {
        /// Pixels a row.
        width: u32,
        /// Rows.
        height: u32,
        /// Values a pixel.
        channels: u32,
        /// Values given.
        len: usize,
    },
    /// An image beyond what the perceptual metrics index.
    #[error("an image of {width}x{height} is beyond the limit of {limit} pixels")]
    TooLarge {
        /// Pixels a row.
        width: u32,
        /// Rows.
        height: u32,
        /// Most pixels.
        limit: u64,
    },
    /// A parameter outside its range.
    #[error("{name} is {value}, outside {range}")]
    Parameter {
        /// The parameter.
        name: &'static str,
        /// Its value.
        value: f64,
        /// What is allowed.
        range: &'static str,
    },
}
