//! Pictures as PNG: result and truth in grey, their difference in two colours.

use dapple_records::picture::signed_colour;
use dapple_suite::{SuiteError, problem::Picture};
use image::{DynamicImage, GrayImage, ImageFormat, Luma, Rgb, RgbImage, imageops::FilterType};
use std::{fs, io::Cursor, path::Path};

/// Names of the three, in the order of [`images`].
const NAMES: [&str; 3] = ["truth.png", "result.png", "error.png"];

/// Truth, result and signed error map.
fn images(picture: &Picture) -> [DynamicImage; 3] {
    let index = |x: u32, y: u32| (y * picture.width + x) as usize;
    let grey = |values: &[f32]| {
        let level = |x, y| Luma([(values[index(x, y)].clamp(0.0, 1.0) * 255.0).round() as u8]);
        GrayImage::from_fn(picture.width, picture.height, level).into()
    };
    let error = RgbImage::from_fn(picture.width, picture.height, |x, y| {
        let i = index(x, y);
        Rgb(signed_colour(picture.result[i] - picture.truth[i]))
    });
    [grey(&picture.truth), grey(&picture.result), error.into()]
}

/// Writes `truth.png`, `result.png` and `error.png` into a folder, which is made.
///
/// # Errors
/// [`SuiteError::Io`] naming the folder or file.
pub fn write(picture: &Picture, folder: &Path) -> Result<(), SuiteError> {
    fs::create_dir_all(folder).map_err(SuiteError::io(format!("making {}", folder.display())))?;
    for (image, name) in images(picture).iter().zip(NAMES) {
        let path = folder.join(name);
        image.save(&path).map_err(|e| {
            let source = std::io::Error::other(e.to_string());
            SuiteError::Io { what: format!("writing {}", path.display()), source }
        })?;
    }
    Ok(())
}

/// The three as PNG files in memory, at most `columns` wide; and their size.
///
/// # Errors
/// [`SuiteError::Internal`] if the encoder refuses.
pub fn png(picture: &Picture, columns: u32) -> Result<([Vec<u8>; 3], [u32; 2]), SuiteError> {
    let mut files = [const { Vec::new() }; 3];
    let mut size = [picture.width, picture.height];
    for (file, image) in files.iter_mut().zip(images(picture)) {
        let small = if image.width() > columns {
            image.resize(columns, u32::MAX, FilterType::Triangle)
        } else {
            image
        };
        size = [small.width(), small.height()];
        small
            .write_to(&mut Cursor::new(file), ImageFormat::Png)
            .map_err(|e| SuiteError::Internal(format!("encoding a picture: {e}")))?;
    }
    Ok((files, size))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wide_pictures_shrink_in_proportion_and_narrow_ones_stay() {
        let picture = Picture {
            width: 64,
            height: 32,
            truth: vec![1.0; 64 * 32],
            result: vec![0.0; 64 * 32],
        };
        let (files, size) = png(&picture, 16).unwrap();
        assert_eq!(size, [16, 8]);
        let levels: Vec<_> = files
            .iter()
            .map(|file| *image::load_from_memory(file).unwrap().to_rgb8().get_pixel(3, 3))
            .collect();
        assert_eq!(levels, [Rgb([255; 3]), Rgb([0; 3]), Rgb(signed_colour(-1.0))]);
        assert_eq!(png(&picture, 64).unwrap().1, [64, 32]);
    }
}
