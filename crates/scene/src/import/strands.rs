//! Strand files: TressFX 4 (`.tfx`) and Cem Yuksel's HAIR (`.hair`), both binary and little-endian.
//!
//! Coordinates are taken as they are, y up. A HAIR file's thickness is a diameter. What has no
//! bearing on shape is left aside: inverse masses and texture coordinates of the one, colours and
//! transparencies of the other (every file is given the same hair, so that files compare).

use super::{Loaded, Source};
use crate::defaults::default_views;
use crate::generate::hair_material;
use crate::strands::{Facing, Ribbons, Strands};
use crate::{Instance, Scene, SceneError};
use glam::{DAffine3, Vec3};
use std::path::Path;

/// Without a thickness in the file a strand is as thick as this share of the largest extent: hair of
/// 0.07 mm on a head of 14 cm.
const THICKNESS_OF_EXTENT: f64 = 1.0 / 2000.0;

/// A radius below this share of the file's largest is raised to it: tips that taper to nothing would
/// end in triangles without area.
const THINNEST: f32 = 1e-3;

/// How strands are stored.
#[derive(Clone, Copy, Debug)]
pub enum Format {
    Tfx,
    Hair,
}

/// Reads strands, named after the file, with a sentence for each thing chosen or left out.
pub fn read(source: &Source<'_>, format: Format) -> Result<(Strands, Vec<String>), SceneError> {
    let (mut strands, mut warnings) = match format {
        Format::Tfx => tfx(source)?,
        Format::Hair => hair(source)?,
    };
    strands.name = super::stem(Path::new(source.file));
    choose_radius(source, &mut strands, &mut warnings);
    strands.validate_as(source.file)?;
    Ok((strands, warnings))
}

/// The file as a scene: one mesh of ribbons that face the first of the default views, with the
/// strands' name.
pub fn parse(source: &Source<'_>, format: Format) -> Result<Loaded, SceneError> {
    let (strands, mut warnings) = read(source, format)?;
    let view = &default_views(&strands.bounds())[0];
    let Ribbons { mesh, skipped } = strands.ribbons(Facing::Point(view.position));
    let file = source.file;
    warnings.push(format!(
        "{file}: {} strands drawn as ribbons that face the {} view at {:.3}; from elsewhere they are \
         narrower",
        strands.starts.len(),
        view.name,
        view.position,
    ));
    if skipped > 0 {
        warnings.push(format!("{file}: {skipped} segments have no length and are left out"));
    }
    let scene = Scene {
        meshes: vec![mesh],
        materials: vec![hair_material()],
        instances: vec![Instance { mesh: 0, transform: DAffine3::IDENTITY }],
        ..Scene::default()
    };
    Ok(Loaded { scene, warnings })
}

fn choose_radius(source: &Source<'_>, strands: &mut Strands, warnings: &mut Vec<String>) {
    let file = source.file;
    let largest = strands.radius.iter().copied().fold(0.0, f32::max);
    if largest > 0.0 {
        let least = THINNEST * largest;
        let thin = |r: &&mut f32| (0.0..least).contains(*r);
        let raised = strands.radius.iter_mut().filter(thin).map(|r| *r = least).count();
        if raised > 0 {
            warnings.push(format!(
                "{file}: {raised} radii below {THINNEST} of the largest, {largest} m, raised to that"
            ));
        }
    } else if strands.radius.iter().all(|&r| r == 0.0) {
        let bounds = strands.bounds();
        let extent = (bounds.max - bounds.min).max_element();
        let radius = (0.5 * THICKNESS_OF_EXTENT * extent) as f32;
        // Points all in one place have no extent: any radius will do, nothing is drawn.
        strands.radius = vec![if radius > 0.0 { radius } else { 1.0 }];
        warnings.push(format!(
            "{file}: no thickness in the file: a radius of {radius:.3e} m, half of a 2000th of the \
             largest extent, was chosen"
        ));
    }
}

impl Source<'_> {
    /// Four bytes at `at`; the caller has checked the file's length.
    fn word(&self, at: usize) -> [u8; 4] {
        self.bytes.get(at..at + 4).and_then(|b| b.try_into().ok()).unwrap_or_default()
    }

    fn u32(&self, at: usize) -> u32 {
        u32::from_le_bytes(self.word(at))
    }

    fn f32(&self, at: usize) -> f32 {
        f32::from_le_bytes(self.word(at))
    }

    fn vec3(&self, at: usize) -> Vec3 {
        Vec3::new(self.f32(at), self.f32(at + 4), self.f32(at + 8))
    }

    /// Refuses a file that is too short for `count` items of `size` bytes from `start`, before any
    /// memory is taken for them. Returns where the items end.
    fn holds(&self, what: &str, start: u64, count: u64, size: u64) -> Result<u64, SceneError> {
        let have = self.bytes.len() as u64;
        let end = count.checked_mul(size).and_then(|n| n.checked_add(start));
        end.filter(|end| *end <= have).ok_or_else(|| {
            let reason =
                format!("{count} of {size} bytes from byte {start}, but the file has {have} bytes");
            self.error(what, reason)
        })
    }
}

/// TressFX 4: version, strands, vertices a strand, then byte offsets of positions (four floats a
/// vertex, the last its inverse mass), of texture coordinates, thicknesses and colours, 0 if absent;
/// the header takes 160 bytes.
fn tfx(source: &Source<'_>) -> Result<(Strands, Vec<String>), SceneError> {
    const HEADER: u64 = 160;
    source.holds("TFX header", 0, 1, HEADER)?;
    let version = source.f32(0);
    if !(4.0..5.0).contains(&version) {
        return Err(source.error("TFX header", format!("version {version}, only 4 is read")));
    }
    let (count, each, start) = (source.u32(4), source.u32(8), source.u32(12));
    if count == 0 || each < 2 {
        let reason =
            format!("{count} strands of {each} vertices, at least 1 strand of 2 is needed");
        return Err(source.error("TFX header", reason));
    }
    if u64::from(start) < HEADER {
        let reason = format!("positions begin at byte {start}, inside the header of {HEADER}");
        return Err(source.error("TFX header", reason));
    }
    let points = u64::from(count) * u64::from(each);
    source.holds("TFX positions", u64::from(start), points, 16)?;
    // The file holds them, so they fit in memory and, at 16 bytes each, in 32 bits unless it is huge.
    let points = u32::try_from(points).map_err(|_| {
        source.error("TFX header", format!("{points} points, at most {} are read", u32::MAX))
    })?;
    let mut warnings = vec![];
    let thickness = source.u32(28);
    if thickness != 0 {
        warnings.push(format!(
            "{}: the thicknesses at byte {thickness} are not read: the format gives no unit for them",
            source.file
        ));
    }
    let strands = Strands {
        name: String::new(),
        starts: (0..count).map(|i| i * each).collect(),
        points: (0..points as usize).map(|i| source.vec3(start as usize + 16 * i)).collect(),
        radius: vec![0.0],
    };
    Ok((strands, warnings))
}

/// HAIR: "HAIR", strands, points, flags of the arrays that follow (segments, points, thickness,
/// transparency, colour), then what holds where an array is absent; the header takes 128 bytes.
fn hair(source: &Source<'_>) -> Result<(Strands, Vec<String>), SceneError> {
    const HEADER: u64 = 128;
    const SEGMENTS: u32 = 1;
    const POINTS: u32 = 2;
    const THICKNESS: u32 = 4;
    source.holds("HAIR header", 0, 1, HEADER)?;
    if source.word(0) != *b"HAIR" {
        return Err(source.error("HAIR header", "the first four bytes are not \"HAIR\""));
    }
    let (count, points, arrays) = (source.u32(4), source.u32(8), source.u32(12));
    let (default_segments, default_thickness) = (source.u32(16), source.f32(20));
    if arrays & POINTS == 0 {
        return Err(source.error("HAIR header", format!("flags {arrays:#x} say it has no points")));
    }
    if count == 0 {
        return Err(source.error("HAIR header", "0 strands, at least 1 is needed"));
    }
    let segments_at = HEADER;
    let has_segments = arrays & SEGMENTS != 0;
    let segments = if has_segments { u64::from(count) } else { 0 };
    let points_at = source.holds("HAIR segments", segments_at, segments, 2)?;
    let thickness_at = source.holds("HAIR points", points_at, u64::from(points), 12)?;
    let has_thickness = arrays & THICKNESS != 0;
    let thicknesses = if has_thickness { u64::from(points) } else { 0 };
    source.holds("HAIR thicknesses", thickness_at, thicknesses, 4)?;
    // Each strand has a point at least, or the file may claim strands without end.
    if count > points {
        let reason = format!("{count} strands, but only {points} points");
        return Err(source.error("HAIR header", reason));
    }
    let mut starts = Vec::with_capacity(count as usize);
    let mut used = 0u64;
    for i in 0..count as usize {
        starts.push(used as u32);
        let at = segments_at as usize + 2 * i;
        let own = || u32::from(u16::from_le_bytes([source.bytes[at], source.bytes[at + 1]]));
        used += 1 + u64::from(if has_segments { own() } else { default_segments });
        if used > u64::from(points) {
            let reason = format!("ends at point {used}, but there are {points} points");
            return Err(source.error(format!("strand {i}"), reason));
        }
    }
    let mut warnings = vec![];
    if used < u64::from(points) {
        let unused = u64::from(points) - used;
        warnings
            .push(format!("{}: {unused} points belong to no strand and are left out", source.file));
    }
    let used = used as usize;
    let radius = match has_thickness {
        true => (0..used).map(|i| 0.5 * source.f32(thickness_at as usize + 4 * i)).collect(),
        false => vec![0.5 * default_thickness],
    };
    let strands = Strands {
        name: String::new(),
        starts,
        points: (0..used).map(|i| source.vec3(points_at as usize + 12 * i)).collect(),
        radius,
    };
    Ok((strands, warnings))
}
