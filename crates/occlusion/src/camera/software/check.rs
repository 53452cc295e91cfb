//! What the software renderers refuse.

use super::super::{Bounds, Mask, Objects, Query, Template, View};
use crate::OcclusionError;
use dapple_scene::MAX_TEXTURE_SIDE;

/// # Errors
/// A coordinate that is not finite, an index out of range, a mask without its texels.
pub fn objects(objects: &Objects) -> Result<(), OcclusionError> {
    for (i, template) in objects.templates.iter().enumerate() {
        let refuse = |limit: String| Err(OcclusionError::value(format!("template {i}"), limit));
        if let Some(c) = template.positions.iter().position(|p| !p.is_finite()) {
            return refuse(format!("corner {c} is not finite"));
        }
        let corners = template.positions.len();
        let beyond = |t: &[u32; 3]| t.iter().any(|&c| c as usize >= corners);
        if let Some(t) = template.triangles.iter().position(beyond) {
            return refuse(format!("triangle {t} names a corner beyond the {corners} there are"));
        }
        if let Err(limit) = masked(template, &objects.masks) {
            return refuse(limit);
        }
    }
    for (i, object) in objects.objects.iter().enumerate() {
        let refuse = |limit: &str| Err(OcclusionError::value(format!("object {i}"), limit));
        if object.template as usize >= objects.templates.len() {
            return refuse("names a template that is not there");
        }
        if !object.linear.is_finite() || !object.translation.is_finite() {
            return refuse("its placement is not finite");
        }
    }
    Ok(())
}

fn masked(template: &Template, masks: &[Mask]) -> Result<(), String> {
    let Some(index) = template.mask else { return Ok(()) };
    let Some(mask) = masks.get(index as usize) else {
        return Err(format!("mask {index} is not there"));
    };
    let texels = u64::from(mask.width) * u64::from(mask.height);
    if texels == 0 || (mask.words.len() as u64) < texels.div_ceil(32) || texels > 1 << 32 {
        return Err(format!(
            "mask {index} has {} words for {} x {} texels",
            mask.words.len(),
            mask.width,
            mask.height
        ));
    }
    if template.uvs.len() != template.positions.len() {
        return Err(format!(
            "{} texture coordinates for {} corners",
            template.uvs.len(),
            template.positions.len()
        ));
    }
    Ok(())
}

/// # Errors
/// An image without pixels or beyond [`MAX_TEXTURE_SIDE`].
pub fn view(view: &View) -> Result<(), OcclusionError> {
    let side = 1..=MAX_TEXTURE_SIDE;
    if side.contains(&view.width) && side.contains(&view.height) {
        return Ok(());
    }
    Err(OcclusionError::value(
        format!("image of {} x {}", view.width, view.height),
        format!("sides of 1 to {MAX_TEXTURE_SIDE} pixels"),
    ))
}

/// # Errors
/// An object that is not there.
pub fn drawn(drawn: &[u32], objects: usize) -> Result<(), OcclusionError> {
    match drawn.iter().find(|&&i| i as usize >= objects) {
        None => Ok(()),
        Some(i) => Err(OcclusionError::value(
            format!("drawing object {i}"),
            format!("there are {objects} objects"),
        )),
    }
}

/// # Errors
/// A box that is not finite or inside out, a query of boxes that are not there.
pub fn asked(boxes: &[Bounds], queries: &[Query]) -> Result<(), OcclusionError> {
    let broken = |b: &Bounds| !b.min.is_finite() || !b.max.is_finite() || !b.min.cmple(b.max).all();
    if let Some(i) = boxes.iter().position(broken) {
        return Err(OcclusionError::value(
            format!("box {i} of a batch"),
            "finite, its lower corner not above its upper one",
        ));
    }
    let beyond = |q: &Query| q.boxes.start > q.boxes.end || q.boxes.end as usize > boxes.len();
    if let Some(i) = queries.iter().position(beyond) {
        return Err(OcclusionError::value(
            format!("query {i} of a batch"),
            format!("a range of the batch's {} boxes", boxes.len()),
        ));
    }
    Ok(())
}
