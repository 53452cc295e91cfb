//! A picture in the terminal: sixel, kitty, iTerm2 or half blocks, by what the terminal can do;
//! characters where colours are not wanted.

use crate::theme::Theme;
use base64::{Engine, engine::general_purpose::STANDARD};
use dapple_records::picture::signed_colour;
use image::{DynamicImage, GrayImage, Luma, Rgb, RgbImage, imageops::FilterType};
use ratatui::{
    buffer::Buffer,
    layout::{Rect, Size},
};
use ratatui_image::{
    FontSize, Image, Resize,
    picker::{Picker, ProtocolType},
    protocol::Protocol,
};
use std::{
    fmt,
    sync::{Arc, Mutex, PoisonError},
};

/// Dark to light.
const GREYS: &[u8] = b" .:-=+*#%@";

/// What a picture's pixels mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// 0 dark, 255 lit.
    Grey,
    /// Result less truth, for the colours of [`signed_colour`].
    Error,
}

/// A picture; cheap to clone. Its last encoding for the terminal is remembered.
#[derive(Clone)]
pub struct Picture {
    kind: Kind,
    width: u32,
    height: u32,
    /// -1..=1 for errors, 0..=1 for greys; rows top to bottom.
    values: Arc<Vec<f32>>,
    encoded: Arc<Mutex<Option<Encoded>>>,
}

/// Area in cells, cell in pixels, protocol.
type Inputs = (Size, [u16; 2], ProtocolType);

/// What an encoding depends on, and the encoding.
struct Encoded {
    inputs: Inputs,
    protocol: Protocol,
}

impl fmt::Debug for Picture {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Picture({:?}, {}x{})", self.kind, self.width, self.height)
    }
}

impl PartialEq for Picture {
    fn eq(&self, other: &Self) -> bool {
        (self.kind, self.width, self.height) == (other.kind, other.width, other.height)
            && self.values == other.values
    }
}

/// Truth, result and the error of the one against the other.
#[derive(Clone, Debug, PartialEq)]
pub struct Triplet {
    /// Ground truth.
    pub truth: Picture,
    /// The technique's result.
    pub result: Picture,
    /// Result less truth.
    pub error: Picture,
}

impl Triplet {
    /// From a child's `Feed::Picture`: two base64 strings of one byte a pixel.
    ///
    /// # Errors
    /// What does not fit, for people.
    pub fn decode(width: u32, height: u32, truth: &str, result: &str) -> Result<Self, String> {
        let pixels = u64::from(width) * u64::from(height);
        if pixels == 0 {
            return Err(format!("a picture of {width}x{height} has no pixels"));
        }
        let bytes = |name: &str, text: &str| -> Result<Vec<u8>, String> {
            let bytes = STANDARD.decode(text).map_err(|e| format!("the {name}: {e}"))?;
            if bytes.len() as u64 != pixels {
                let has = bytes.len();
                return Err(format!("the {name} has {has} pixels, not {width}x{height}"));
            }
            Ok(bytes)
        };
        let (truth, result) = (bytes("truth", truth)?, bytes("result", result)?);
        let values = |bytes: &[u8]| bytes.iter().map(|&b| f32::from(b) / 255.0).collect();
        let (truth, result): (Vec<f32>, Vec<f32>) = (values(&truth), values(&result));
        let error = result.iter().zip(&truth).map(|(r, t)| r - t).collect();
        Ok(Self {
            truth: Picture::new(Kind::Grey, width, height, truth),
            result: Picture::new(Kind::Grey, width, height, result),
            error: Picture::new(Kind::Error, width, height, error),
        })
    }
}

impl Picture {
    fn new(kind: Kind, width: u32, height: u32, values: Vec<f32>) -> Self {
        Self { kind, width, height, values: Arc::new(values), encoded: Arc::default() }
    }

    /// Draws it as large as `area` allows, its shape kept, from the top left. Returns the cells
    /// it takes. Drawing twice draws the same; only the first has to encode.
    pub fn draw(&self, picker: &Picker, theme: Theme, area: Rect, buf: &mut Buffer) -> Rect {
        let area = area.intersection(buf.area);
        if area.is_empty() {
            return area;
        }
        if !theme.colour {
            return self.draw_characters(picker.font_size(), area, buf);
        }
        let (size, font) = (area.as_size(), picker.font_size());
        let inputs = (size, [font.width, font.height], picker.protocol_type());
        let mut kept = self.encoded.lock().unwrap_or_else(PoisonError::into_inner);
        if kept.as_ref().is_none_or(|e| e.inputs != inputs) {
            // Nearest: a pixel of an error map must not be blurred into its neighbours.
            let resize = Resize::Scale(Some(FilterType::Nearest));
            *kept = picker
                .new_protocol(self.image(), size, resize)
                .ok()
                .map(|protocol| Encoded { inputs, protocol });
        }
        let Some(encoded) = kept.as_ref() else {
            drop(kept);
            return self.draw_characters(font, area, buf);
        };
        ratatui::widgets::Widget::render(Image::new(&encoded.protocol), area, buf);
        let used = encoded.protocol.size();
        Rect { width: used.width.min(area.width), height: used.height.min(area.height), ..area }
    }

    /// One character a cell: greys by how dark they print; errors `·` right, `o` and `O` too
    /// light, `x` and `X` too dark.
    fn draw_characters(&self, font: FontSize, area: Rect, buf: &mut Buffer) -> Rect {
        let used = fitted(self.width, self.height, font, area);
        for y in 0..used.height {
            for x in 0..used.width {
                let value = self.mean((x, used.width), (y, used.height));
                if let Some(cell) = buf.cell_mut((used.x + x, used.y + y)) {
                    cell.set_char(self.character(value));
                }
            }
        }
        used
    }

    fn character(&self, value: f32) -> char {
        match self.kind {
            Kind::Grey => {
                let last = (GREYS.len() - 1) as f32;
                char::from(GREYS[(value.clamp(0.0, 1.0) * last).round() as usize])
            }
            Kind::Error if value > 0.25 => 'O',
            Kind::Error if value > 0.02 => 'o',
            Kind::Error if value < -0.25 => 'X',
            Kind::Error if value < -0.02 => 'x',
            Kind::Error => '·',
        }
    }

    /// Mean of the pixels under cell `x.0` of `x.1` columns and `y.0` of `y.1` rows.
    fn mean(&self, x: (u16, u16), y: (u16, u16)) -> f32 {
        let span = |(at, of): (u16, u16), pixels: u32| {
            let begin = u64::from(at) * u64::from(pixels) / u64::from(of.max(1));
            let end = u64::from(at + 1) * u64::from(pixels) / u64::from(of.max(1));
            begin as usize..(end.max(begin + 1) as usize).min(pixels as usize)
        };
        let (columns, rows) = (span(x, self.width), span(y, self.height));
        let count = (columns.len() * rows.len()).max(1) as f32;
        let row = |y: usize| columns.clone().map(move |x| y * self.width as usize + x);
        rows.flat_map(row).filter_map(|i| self.values.get(i)).sum::<f32>() / count
    }

    fn image(&self) -> DynamicImage {
        let value = |x: u32, y: u32| self.values[(y * self.width + x) as usize];
        match self.kind {
            Kind::Grey => GrayImage::from_fn(self.width, self.height, |x, y| {
                Luma([(value(x, y) * 255.0).round() as u8])
            })
            .into(),
            Kind::Error => {
                RgbImage::from_fn(self.width, self.height, |x, y| Rgb(signed_colour(value(x, y))))
                    .into()
            }
        }
    }
}

/// The largest part of `area` of the picture's shape, at least one cell.
fn fitted(width: u32, height: u32, font: FontSize, area: Rect) -> Rect {
    let cell = f64::from(font.height.max(1)) / f64::from(font.width.max(1));
    // Columns a row, in cells.
    let shape = f64::from(width) / f64::from(height.max(1)) * cell;
    let (w, h) = (f64::from(area.width), f64::from(area.height));
    let (w, h) = if w / h > shape { (h * shape, h) } else { (w, w / shape) };
    Rect {
        width: (w.round() as u16).clamp(1, area.width.max(1)),
        height: (h.round() as u16).clamp(1, area.height.max(1)),
        ..area
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ratatui::style::Color;

    const COLOUR: Theme = Theme { colour: true };
    const PLAIN: Theme = Theme { colour: false };

    /// Two columns, one row each: truth dark and lit, result lit and lit.
    fn triplet() -> Triplet {
        Triplet::decode(2, 1, &STANDARD.encode([0, 255]), &STANDARD.encode([255, 255])).unwrap()
    }

    #[test]
    fn a_picture_keeps_its_shape() {
        let font = FontSize::new(10, 20);
        let at = |w, h, area| {
            let r = fitted(w, h, font, area);
            (r.width, r.height)
        };
        assert_eq!(at(100, 100, Rect::new(0, 0, 80, 10)), (20, 10));
        assert_eq!(at(200, 100, Rect::new(0, 0, 40, 40)), (40, 10));
        assert_eq!(at(1, 1000, Rect::new(0, 0, 9, 9)), (1, 9));
    }

    #[test]
    fn half_blocks_show_grey_and_the_sign_of_an_error_by_colour() {
        let picker = Picker::halfblocks();
        let area = Rect::new(0, 0, 4, 1);
        let colours = |picture: &Picture| {
            let mut buf = Buffer::empty(area);
            let used = picture.draw(&picker, COLOUR, area, &mut buf);
            assert_eq!(used, area);
            [buf[(0, 0)].bg, buf[(3, 0)].bg]
        };
        let shown = triplet();
        assert_eq!(colours(&shown.truth), [Color::Rgb(0, 0, 0), Color::Rgb(255, 255, 255)]);
        assert_eq!(colours(&shown.error), [Color::Rgb(230, 97, 1), Color::Rgb(255, 255, 255)]);
        // A second drawing comes from the remembered encoding and is the same.
        assert_eq!(colours(&shown.error), colours(&shown.error.clone()));
    }

    #[test]
    fn without_colour_characters_tell_light_from_dark_and_signs_apart() {
        let picker = Picker::halfblocks();
        let area = Rect::new(0, 0, 4, 1);
        let text = |picture: &Picture| {
            let mut buf = Buffer::empty(area);
            picture.draw(&picker, PLAIN, area, &mut buf);
            let plain = buf.content.iter().all(|c| c.fg == Color::Reset && c.bg == Color::Reset);
            assert!(plain);
            (0..4).map(|x| buf[(x, 0)].symbol().to_string()).collect::<String>()
        };
        let shown = triplet();
        assert_eq!(text(&shown.truth), "  @@");
        assert_eq!(text(&shown.error), "OO··");
        let dark = Triplet::decode(1, 1, "/w==", "AA==").unwrap();
        assert!(text(&dark.error).starts_with('X'));
    }

    #[test]
    fn what_does_not_fit_is_refused_in_words() {
        let of = |w, h, text: &str| Triplet::decode(w, h, text, text).unwrap_err();
        assert_eq!(of(2, 2, "AAAA"), "the truth has 3 pixels, not 2x2");
        assert_eq!(of(0, 2, ""), "a picture of 0x2 has no pixels");
        assert!(of(1, 1, "?").starts_with("the truth: "));
        assert!(Triplet::decode(u32::MAX, u32::MAX, "", "").is_err());
    }

    #[test]
    fn any_area_will_do() {
        for colour in [true, false] {
            for (w, h) in [(0, 0), (0, 3), (1, 1), (200, 1), (1, 60)] {
                let mut buf = Buffer::empty(Rect::new(0, 0, w, h));
                let area = Rect::new(0, 0, 300, 300);
                triplet().error.draw(&Picker::halfblocks(), Theme { colour }, area, &mut buf);
            }
        }
    }
}
