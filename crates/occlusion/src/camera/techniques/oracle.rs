//! What an all-knowing technique would draw.

use crate::OcclusionError;
use crate::camera::state::Frame;
use crate::camera::{Objects, Renderer, View};

/// Draws exactly the objects of `owners`, nearest box first: what owns a pixel of the image,
/// counted from an image of everything. No technique that is exact draws less.
///
/// # Errors
/// An owner that is not an object, or the renderer's.
pub fn frame(
    owners: &[u32],
    objects: &Objects,
    view: &View,
    renderer: &mut dyn Renderer,
    out: &mut Frame,
) -> Result<(), OcclusionError> {
    let count = objects.objects.len();
    if let Some(owner) = owners.iter().find(|&&o| o as usize >= count) {
        let limit = format!("not among {count} objects");
        return Err(OcclusionError::value(format!("owner {owner}"), limit));
    }
    let mut nearest_first = owners.to_vec();
    let distance = |object: u32| view.distance(&objects.objects[object as usize].bounds);
    nearest_first.sort_unstable_by(|&a, &b| distance(a).total_cmp(&distance(b)).then(a.cmp(&b)));
    nearest_first.dedup();
    out.clear();
    out.drew(objects, &nearest_first);
    renderer.begin(view)?;
    renderer.draw(&nearest_first)?;
    renderer.end()
}
