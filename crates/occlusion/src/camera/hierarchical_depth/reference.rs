//! The reference: the same two passes, every object asked about every pixel of its rectangle, in
//! the order of the definition. What it draws beyond the visible is what boxes cannot tell.

use super::{Place, Seen, ShowsDepth};
use crate::OcclusionError;
use crate::camera::{Frame, Objects, View};

/// What is kept from frame to frame.
#[derive(Clone, Debug)]
pub struct State {
    seen: Seen,
}

impl State {
    /// The state before the first frame: nothing was visible.
    pub fn new(objects: &Objects) -> Self {
        Self { seen: Seen::new(objects) }
    }

    /// Forgets what was visible.
    pub fn reset(&mut self) {
        self.seen.visible.fill(false);
    }

    /// Whether each object was visible in the last frame.
    pub fn visible(&self) -> &[bool] {
        &self.seen.visible
    }
}

/// Draws what `view` sees of `objects`.
///
/// # Errors
/// Objects that `state` was not made for, the renderer's.
pub fn frame(
    objects: &Objects,
    view: &View,
    state: &mut State,
    renderer: &mut dyn ShowsDepth,
    frame: &mut Frame,
) -> Result<(), OcclusionError> {
    state.seen.check(objects)?;
    frame.clear();
    renderer.begin(view)?;
    let count = objects.objects.len() as u32;
    let on_screen = |&object: &u32| place(objects, view, object) != Place::Outside;

    let visible = |&object: &u32| state.seen.visible[object as usize];
    let first: Vec<u32> = (0..count).filter(visible).filter(on_screen).collect();
    renderer.draw(&first)?;
    frame.drew(objects, &first);
    let mut drawn = vec![false; objects.objects.len()];
    first.iter().for_each(|&object| drawn[object as usize] = true);

    let after = renderer.depth();
    let shows = |&object: &u32| !hidden(place(objects, view, object), view.width, after);
    let others = (0..count).filter(|&object| !drawn[object as usize]).filter(on_screen);
    let second: Vec<u32> = others.filter(shows).collect();
    renderer.draw(&second)?;
    frame.drew(objects, &second);

    let all = renderer.depth();
    for object in 0..count {
        let place = place(objects, view, object);
        let shows = place != Place::Outside && !hidden(place, view.width, all);
        state.seen.visible[object as usize] = shows;
    }
    frame.work.nodes = 3 * u64::from(count);
    renderer.end()
}

fn place(objects: &Objects, view: &View, object: u32) -> Place {
    Place::of(view, &objects.objects[object as usize].bounds)
}

/// Whether everything drawn at the box's pixels is nearer than its nearest point.
fn hidden(place: Place, width: u32, depth: &[f32]) -> bool {
    let Place::At(pixels, nearest) = place else { return false };
    (pixels.min[1]..=pixels.max[1])
        .all(|y| (pixels.min[0]..=pixels.max[0]).all(|x| depth[(y * width + x) as usize] > nearest))
}
