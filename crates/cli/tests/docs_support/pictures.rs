//! Pictures of `dapple render`: made again and compared pixel by pixel.

use super::root;
use std::{fs, path::Path};

const NAMES: [&str; 3] = ["truth", "result", "error"];

/// Mean difference of a channel, in steps of 1/255, that two machines' arithmetic may make.
const MEAN_STEPS: f64 = 0.25;

/// An 8-bit picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Image(image::RgbImage);

impl Image {
    pub fn filled(width: u32, height: u32, colour: [u8; 3]) -> Self {
        Self(image::RgbImage::from_pixel(width, height, image::Rgb(colour)))
    }

    pub fn set(&mut self, x: u32, y: u32, colour: [u8; 3]) {
        self.0.put_pixel(x, y, image::Rgb(colour));
    }

    fn open(path: &Path) -> Result<Self, String> {
        image::open(path).map(|i| Self(i.to_rgb8())).map_err(|e| format!("{}: {e}", path.display()))
    }
}

/// Where a command line puts its pictures: the argument of `-o`, if it renders.
pub fn folder(command: &str) -> Option<String> {
    let words: Vec<&str> = command.split_whitespace().collect();
    let at = words.iter().position(|word| *word == "-o")?;
    (words.get(1) == Some(&"render")).then(|| words[at + 1].to_string())
}

/// The three pictures in a row, as seen from a page, and the figures that were printed.
pub fn markdown(output: &str, printed: &str) -> String {
    let figures: Vec<String> = printed
        .lines()
        .filter_map(|line| {
            let mut words = line.split_whitespace();
            let (name, value) = (words.next()?, words.next()?);
            let shown = ["rmse", "max", "flip", "leak", "dark"].contains(&name);
            shown.then(|| format!("{name} {value}"))
        })
        .collect();
    let title = printed.lines().next().unwrap_or_default();
    let cell = |name: &str| format!("![{name}]({output}/{name}.png)");
    format!(
        "| truth | result | error: orange too light, blue too dark |\n|---|---|---|\n| {} | {} | {} \
         |\n\n{title}: {}",
        cell("truth"),
        cell("result"),
        cell("error"),
        figures.join(", ")
    )
}

/// Compares the pictures made below `made` with those kept below the root, or keeps them.
pub fn compare(made: &Path, output: &str, bless: bool) -> Option<String> {
    let mut differences = Vec::new();
    for name in NAMES {
        let file = format!("{output}/{name}.png");
        if bless {
            fs::create_dir_all(root().join(output)).unwrap();
            fs::copy(made.join(&file), root().join(&file)).unwrap();
            continue;
        }
        let pair =
            Image::open(&root().join(&file)).and_then(|a| Ok((a, Image::open(&made.join(&file))?)));
        let found = match pair {
            Ok((kept, new)) => difference(&kept, &new),
            Err(error) => Some(error),
        };
        differences.extend(found.map(|d| format!("{file}: {d}")));
    }
    (!differences.is_empty()).then(|| differences.join("; "))
}

/// How two pictures differ, if they do.
pub fn difference(kept: &Image, made: &Image) -> Option<String> {
    let (a, b) = (&kept.0, &made.0);
    if a.dimensions() != b.dimensions() {
        return Some(format!("{:?} became {:?}", a.dimensions(), b.dimensions()));
    }
    let steps: u64 =
        a.as_raw().iter().zip(b.as_raw()).map(|(x, y)| u64::from(x.abs_diff(*y))).sum();
    let mean = steps as f64 / a.as_raw().len().max(1) as f64;
    (mean > MEAN_STEPS).then(|| format!("differs by {mean:.2} steps on average"))
}
