//! Renderers without a device: what the others are judged by, and what runs where there is none.
//!
//! [`Reference`] is scalar f64 and as plain as can be; [`Fast`] snaps corners to 1/256 of a pixel, as
//! devices do, and fills bands of rows in parallel. Both place corners in f32 as all forms, then
//! project in f64, sample at pixel centres and share edges by the top-left rule. Their images differ
//! only at pixels whose centre lies within 1/128 of a pixel of an edge, and where depths tie.

mod answers;
pub(crate) mod check;
mod fast;
mod fill;
mod project;
mod reference;
mod setup;

pub use fast::Fast;
pub use reference::Reference;

use super::Image;

/// How many pixels each of `objects` objects owns: its exact coverage.
pub fn owners(image: &Image, objects: usize) -> Vec<u32> {
    let mut counts = vec![0; objects];
    for [object, _] in &image.ids {
        if let Some(count) = (*object as usize).checked_sub(1).and_then(|i| counts.get_mut(i)) {
            *count += 1;
        }
    }
    counts
}

#[cfg(test)]
mod tests;
