//! Telling a dashboard what happens: `--feed` turns standard output into JSON lines.

use crate::{Outcome, chain, exit_code, output::put};
use anyhow::Result;
use base64::{Engine, engine::general_purpose::STANDARD};
use dapple_records::{Feed, Line};
use dapple_suite::problem::Picture;
use image::{GrayImage, imageops::thumbnail};
use std::io;

/// One event.
pub fn tell(event: &Feed) -> io::Result<()> {
    put!("{}", event.to_line())
}

/// One record line: what is told is what the record holds.
pub fn tell_line(line: &Line) -> io::Result<()> {
    put!("{}", line.to_line())
}

/// How the verb ended: with its error, if it has one, and its exit code.
pub fn tell_end(result: &Result<Outcome>) -> io::Result<()> {
    if let Err(error) = result {
        tell(&Feed::Failed { request: 0, reason: chain(error) })?;
    }
    tell(&Feed::Done { code: exit_code(result) })
}

/// Most columns of a picture that is told: more than any terminal shows.
const MOST_COLUMNS: u32 = 960;

/// Truth and result of a request as an event, one byte a pixel; large ones are scaled down.
pub fn picture(request: u64, picture: &Picture) -> Feed {
    let Picture { width, height, truth, result } = picture;
    let grey = |values: &[f32]| {
        let bytes = values.iter().map(|v| (v.clamp(0.0, 1.0) * 255.0).round() as u8).collect();
        // As many values as pixels, or an empty picture.
        let image = GrayImage::from_raw(*width, *height, bytes).unwrap_or_default();
        if image.width() <= MOST_COLUMNS {
            return image;
        }
        let rows = u64::from(*height) * u64::from(MOST_COLUMNS) / u64::from(*width);
        thumbnail(&image, MOST_COLUMNS, (rows as u32).max(1))
    };
    let (truth, result) = (grey(truth), grey(result));
    let (width, height) = truth.dimensions();
    let text = |image: GrayImage| STANDARD.encode(image.into_raw());
    Feed::Picture { request, width, height, truth: text(truth), result: text(result) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_are_one_byte_a_pixel_and_no_wider_than_a_terminal_shows() {
        let of = |width: u32, height: u32| {
            let pixels = (width * height) as usize;
            let whole =
                Picture { width, height, truth: vec![1.0; pixels], result: vec![0.25; pixels] };
            let Feed::Picture { request: 3, width, height, truth, result } = picture(3, &whole)
            else {
                panic!("a picture with its number")
            };
            let [truth, result] = [truth, result].map(|text| STANDARD.decode(text).unwrap());
            assert!(truth.iter().all(|v| *v == 255) && result.iter().all(|v| *v == 64));
            assert_eq!(truth.len(), result.len());
            assert_eq!(truth.len(), (width * height) as usize);
            (width, height)
        };
        assert_eq!(of(32, 18), (32, 18));
        assert_eq!(of(1920, 1080), (960, 540));
        assert_eq!(of(4000, 2), (960, 1));
    }
}
