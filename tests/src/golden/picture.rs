//! A grey 8-bit picture.

use image::{GrayImage, ImageFormat};
use std::io::Cursor;

/// Grey codes, rows top to bottom.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// One a pixel.
    pub codes: Vec<u8>,
}

impl Picture {
    /// From values in 0..=1: `round(255 v)`.
    ///
    /// # Panics
    /// For a value that is not in 0..=1 (NaN included), or a wrong count of them.
    pub fn from_values(width: u32, height: u32, values: &[f32]) -> Self {
        assert_eq!(values.len(), (width * height) as usize, "values of a {width}x{height} picture");
        let code = |(i, v): (usize, &f32)| {
            assert!((0.0..=1.0).contains(v), "value {v} of pixel {i} is not in 0..=1");
            (v * 255.0).round() as u8
        };
        Self { width, height, codes: values.iter().enumerate().map(code).collect() }
    }

    /// As a PNG file.
    pub fn to_png(&self) -> Vec<u8> {
        let mut bytes = Cursor::new(Vec::new());
        let image = GrayImage::from_raw(self.width, self.height, self.codes.clone());
        let image = image.expect("one code a pixel");
        image.write_to(&mut bytes, ImageFormat::Png).expect("memory takes a PNG");
        bytes.into_inner()
    }

    /// From a PNG file; an error in words where it is not one, or not grey with 8 bits.
    ///
    /// # Errors
    /// What is wrong with the file.
    pub fn from_png(bytes: &[u8]) -> Result<Self, String> {
        let image = image::load_from_memory_with_format(bytes, ImageFormat::Png)
            .map_err(|error| error.to_string())?;
        match image {
            image::DynamicImage::ImageLuma8(grey) => {
                Ok(Self { width: grey.width(), height: grey.height(), codes: grey.into_raw() })
            }
            other => Err(format!("{:?} in place of 8-bit grey", other.color())),
        }
    }

    /// The same picture moved to the right by one pixel, its first column repeated.
    pub fn shifted(&self) -> Self {
        let row = |row: &[u8]| [&row[..1], &row[..row.len() - 1]].concat();
        let codes = self.codes.chunks(self.width as usize).flat_map(row).collect();
        Self { codes, ..self.clone() }
    }

    /// The same picture brightened by a share of white, clamped at white. (A factor would leave
    /// black and white pictures as they are.)
    pub fn brightened(&self, share: f32) -> Self {
        let more = (255.0 * share).round() as u8;
        let codes = self.codes.iter().map(|c| c.saturating_add(more)).collect();
        Self { codes, ..self.clone() }
    }

    /// The same picture dimmed by a factor.
    pub fn dimmed(&self, factor: f32) -> Self {
        let codes = self.codes.iter().map(|c| (f32::from(*c) * factor).round() as u8).collect();
        Self { codes, ..self.clone() }
    }
}
