//! One building of a CityJSON file.

use super::outline::footprints;
use super::surface::{Role, Surface};
use super::{Object, Reader};
use crate::SceneError;
use crate::city::Footprint;
use crate::city::import::assemble::{DraftBuilding, STOREY_M, flat};
use glam::{DVec2, DVec3};

/// Walls lower than this are no building, metres.
const LEAST_WALL_M: f64 = 0.1;
/// A roof that covers the outline to this share needs no lid.
const ROOF_TOLERANCE: f64 = 0.01;
/// Gables begin this far above the eaves, metres: files round to millimetres.
const GABLE_M: f64 = 2e-3;

impl Reader<'_> {
    /// Adds a building, or counts why it cannot be shown.
    pub(super) fn building(&mut self, id: &str, object: &Object) -> Result<(), SceneError> {
        if self.parts_know_better(id, object) {
            self.tally.add("buildings whose parts have more detail");
            return Ok(());
        }
        let level = best_level(object);
        let surfaces = self.surfaces(id, object)?;
        if surfaces.is_empty() {
            // A parent whose parts have all the geometry is nothing to report.
            if !self.parts.contains_key(id) {
                self.tally.add("buildings without surfaces");
            }
            return Ok(());
        }
        match self.raised(id, object, &surfaces) {
            Ok(made) => {
                self.levels.add(format!("buildings of level of detail {level}"));
                self.draft.buildings.extend(made);
            }
            Err(reason) => self.tally.add(format!("buildings {reason}")),
        }
        Ok(())
    }

    /// Whether a part of the building has a higher level of detail than the building itself.
    fn parts_know_better(&self, id: &str, object: &Object) -> bool {
        let own = best_level(object);
        !object.geometry.is_empty() && self.parts.get(id).is_some_and(|level| *level > own)
    }

    fn raised(
        &self,
        id: &str,
        object: &Object,
        surfaces: &[Surface],
    ) -> Result<Vec<DraftBuilding>, &'static str> {
        let of = |role: Role| surfaces.iter().filter(move |s| s.role == role);
        // Some files leave the underside out; then the roof has the outline.
        let outlines = footprints(of(Role::Ground)).or_else(|first| {
            footprints(of(Role::Roof))
                .map_err(|e| if of(Role::Ground).count() > 0 { first } else { e })
        })?;
        let heights = |role: Role| of(role).flat_map(|s| s.rings.iter().flatten()).map(|p| p.y);
        let lowest = |list: &mut dyn Iterator<Item = f64>| list.fold(f64::INFINITY, f64::min);
        let all = &mut surfaces.iter().flat_map(|s| s.rings.iter().flatten()).map(|p| p.y);
        let base_m = lowest(all);
        let mut eaves_m = lowest(&mut heights(Role::Roof));
        let flat_only = eaves_m <= base_m + LEAST_WALL_M || !eaves_m.is_finite();
        if flat_only {
            // An outline alone, or a roof that reaches the ground.
            eaves_m = base_m + height(object).ok_or("without a height")?;
        }
        let storeys = object.attributes.get("storeysAboveGround").and_then(|v| v.as_u64());
        let storeys = storeys.map(|s| s.clamp(1, u64::from(u32::MAX)) as u32);
        let mut made = vec![];
        let count = outlines.len();
        for (i, footprint) in outlines.into_iter().enumerate() {
            let own = |t: &[DVec3; 3]| count == 1 || footprint.contains(middle(t));
            let of_roof = |role: Role| of(role).flat_map(Surface::triangles).filter(own);
            let roof: Vec<[DVec3; 3]> =
                if flat_only { vec![] } else { of_roof(Role::Roof).collect() };
            let gables = if flat_only {
                vec![]
            } else {
                of_roof(Role::Wall).flat_map(|t| above(&t, eaves_m + GABLE_M)).collect()
            };
            let roof = closed(&footprint, eaves_m, roof)?;
            let id = if count == 1 { id.into() } else { format!("{id}/{i}") };
            made.push(DraftBuilding {
                id,
                footprint,
                base_m,
                eaves_m,
                storeys,
                roof: Some(roof),
                gables,
            });
        }
        Ok(made)
    }
}

/// The highest level of detail of an object's geometries, 0 for none.
pub(super) fn best_level(object: &Object) -> f64 {
    object.geometry.iter().map(super::model::Geometry::level).fold(0.0, f64::max)
}

/// What the attributes say, metres.
fn height(object: &Object) -> Option<f64> {
    let number = |name: &str| object.attributes.get(name).and_then(|v| v.as_f64());
    let storeys = || number("storeysAboveGround").map(|s| s * STOREY_M);
    number("measuredHeight").or_else(storeys).filter(|h| (LEAST_WALL_M..=1000.0).contains(h))
}

fn middle(t: &[DVec3; 3]) -> DVec2 {
    let m = (t[0] + t[1] + t[2]) / 3.0;
    DVec2::new(m.x, m.z)
}

/// The roof, with a flat lid at the eaves below it unless it covers the outline: nobody is to look
/// into a building from above.
fn closed(
    footprint: &Footprint,
    eaves_m: f64,
    mut roof: Vec<[DVec3; 3]>,
) -> Result<Vec<[DVec3; 3]>, &'static str> {
    let plan = |t: &[DVec3; 3]| 0.5 * (t[1] - t[0]).cross(t[2] - t[0]).y.abs();
    let (covered, area) = (roof.iter().map(plan).sum::<f64>(), footprint.area_m2());
    if (covered - area).abs() > ROOF_TOLERANCE * area {
        roof.extend(flat(footprint, eaves_m)?);
    }
    Ok(roof)
}

/// The part of a triangle above `y`, as triangles.
fn above(t: &[DVec3; 3], y: f64) -> Vec<[DVec3; 3]> {
    let mut kept: Vec<DVec3> = vec![];
    for i in 0..3 {
        let (a, b) = (t[i], t[(i + 1) % 3]);
        if a.y >= y {
            kept.push(a);
        }
        if (a.y >= y) != (b.y >= y) {
            kept.push(a.lerp(b, (y - a.y) / (b.y - a.y)));
        }
    }
    (2..kept.len()).map(|i| [kept[0], kept[i - 1], kept[i]]).collect()
}
