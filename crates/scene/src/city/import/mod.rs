//! Real cities: CityJSON (`.city.json`, `.json`) and OpenStreetMap (`.osm.pbf`, `.pbf`).
//!
//! Both give drafts: outlines, heights, points and flat pieces in metres. What follows is the same
//! for both: facades and party walls, square tiles as blocks, inner boxes, views and paths.

mod assemble;
mod cityjson;
mod free_space;
mod osm;
mod party;
mod views;

use super::{City, windows};
use crate::SceneError;
use std::path::Path;

/// Extensions that [`load`] reads, for messages.
const KNOWN: &str = "city.json, json, osm.pbf, pbf";

/// Files give no windows: all cities have the same rule and one seed.
const LIGHT_SEED: u64 = 1;

/// A city and what was left out of it or chosen for it.
#[derive(Clone, Debug)]
pub struct LoadedCity {
    /// With at least a building, a tree or a piece of ground.
    pub city: City,
    /// One sentence each, naming the file, with counts.
    pub warnings: Vec<String>,
}

/// Loads a city by its file's extension (case does not matter).
///
/// # Errors
/// [`SceneError`] for an unreadable or malformed file, another extension, coordinates in degrees or
/// out of range, or a file with nothing to show.
pub fn load(path: &Path) -> Result<LoadedCity, SceneError> {
    let file = path.display().to_string();
    let extension = crate::import::extension(path);
    let parse = match extension.as_str() {
        "json" => cityjson::parse,
        "pbf" => osm::parse,
        _ => return Err(SceneError::Extension { file, extension, known: KNOWN }),
    };
    let bytes = crate::import::read(path, &file)?;
    let draft = parse(&Source { bytes: &bytes, file: &file })?;
    let mut loaded = assemble::city(&file, name(path), draft)?;
    windows::light(&mut loaded.city, windows::LIGHTS_PER_STOREY, LIGHT_SEED)
        .map_err(|e| SceneError::format(&file, "window lights", e))?;
    Ok(loaded)
}

/// The file's name without `.json`, `.city.json`, `.pbf` or `.osm.pbf`.
fn name(path: &Path) -> String {
    let stem = crate::import::stem(path);
    let known = |s: &str| matches!(s.to_lowercase().as_str(), "city" | "osm");
    match stem.rsplit_once('.') {
        Some((name, last)) if known(last) && !name.is_empty() => name.into(),
        _ => stem,
    }
}

/// A file in memory.
struct Source<'a> {
    bytes: &'a [u8],
    /// Path as given, for messages.
    file: &'a str,
}

impl Source<'_> {
    fn error(&self, element: impl Into<String>, reason: impl std::fmt::Display) -> SceneError {
        SceneError::format(self.file, element, reason)
    }
}

/// Counts what is left out, by reason, in the order of the reasons.
#[derive(Clone, Debug, Default)]
struct Tally(std::collections::BTreeMap<String, u64>);

impl Tally {
    fn add(&mut self, what: impl Into<String>) {
        *self.0.entry(what.into()).or_default() += 1;
    }

    /// One sentence a reason.
    fn sentences<'a>(&'a self, file: &'a str, end: &'a str) -> impl Iterator<Item = String> + 'a {
        self.0.iter().map(move |(what, count)| format!("{file}: {count} {what} {end}"))
    }
}
