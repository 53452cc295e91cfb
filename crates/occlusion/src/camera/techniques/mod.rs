//! Techniques that decide what to draw by asking the renderer.
//!
//! Shared by all of them:
//! - Nodes are taken front to back, by the nearest point of their boxes along the view direction.
//! - A node outside the frustum is left, and is not remembered as visited: when it comes back,
//!   nothing is known of it.
//! - A node that the near plane cuts, or that holds the eye, cannot be asked: it counts as visible.
//! - Answers come in the order of asking; they are dealt with in that order, a batch at a time.
//! - A node becomes visible together with all that hold it (pull-up). A visible inner node none of
//!   whose leaves is visible any more is asked itself in the next frame (pull-down).
//!
//! Why nothing that shows is culled: a node is left undrawn only where it is outside the frustum,
//! or where a box that holds it showed nothing in this very frame. What is drawn later only hides
//! more. What is remembered decides what is asked, never what is culled.

mod chc;
mod chc_plus_plus;
mod jitter;
mod multiquery;
pub mod oracle;
mod simple;
#[cfg(test)]
pub(super) mod tests;
mod tight_bounds;
mod walk;

use super::settings::{Settings, Technique};
use super::state::{Frame, State};
use super::{Objects, Renderer, Tree, View};
use crate::OcclusionError;
use walk::Walk;

/// Draws one frame as `settings` say, and gives what was drawn in `out`. `state` is that of the same
/// tree, renderer and settings from frame to frame; after an error it has to be reset.
///
/// # Errors
/// Settings out of range, a state or tree of something else, or the renderer's.
pub fn frame(
    settings: &Settings,
    objects: &Objects,
    tree: &Tree,
    view: &View,
    state: &mut State,
    renderer: &mut dyn Renderer,
    out: &mut Frame,
) -> Result<(), OcclusionError> {
    settings.check()?;
    if state.nodes.len() != tree.nodes.len() {
        let limit = format!("{} nodes, where the tree has {}", state.nodes.len(), tree.nodes.len());
        return Err(OcclusionError::value("state", limit));
    }
    if tree.objects.len() != objects.objects.len() {
        let (has, of) = (tree.objects.len(), objects.objects.len());
        return Err(OcclusionError::value("tree", format!("{has} objects, where there are {of}")));
    }
    out.clear();
    let mut walk = Walk { settings, objects, tree, view, state, renderer, out };
    walk.begin()?;
    match settings.technique {
        Technique::None => simple::none(&mut walk),
        Technique::Frustum => simple::frustum(&mut walk),
        Technique::StopAndWait => simple::stop_and_wait(&mut walk)?,
        Technique::Chc => chc::frame(&mut walk)?,
        Technique::ChcPlusPlus => chc_plus_plus::frame(&mut walk)?,
    }
    walk.end()
}
