//! The processor's form: the pyramid over a software renderer's depth.

use rayon::prelude::*;

use super::{Fault, Pixels, Place, Pyramid, Seen, Settings, ShowsDepth, Traversal};
use crate::OcclusionError;
use crate::camera::{Frame, Objects, Tree, View};

/// What is kept from frame to frame, allocated once.
#[derive(Clone, Debug)]
pub struct State {
    seen: Seen,
    /// Nodes with a visible object below, by the last frame that went down the tree.
    below: Vec<bool>,
    drawn: Vec<bool>,
    places: Vec<Place>,
    list: Vec<u32>,
    stack: Vec<u32>,
    pyramid: Pyramid,
    fault: Option<Fault>,
}

impl State {
    /// The state before the first frame: nothing was visible.
    pub fn new(objects: &Objects, tree: &Tree) -> Self {
        let count = objects.objects.len();
        Self {
            seen: Seen::new(objects),
            below: vec![false; tree.nodes.len()],
            drawn: vec![false; count],
            places: vec![Place::Outside; count],
            list: Vec::with_capacity(count),
            stack: Vec::new(),
            pyramid: Pyramid::default(),
            fault: None,
        }
    }

    /// The same with a deliberate fault, for what must find it.
    pub fn with_fault(objects: &Objects, tree: &Tree, fault: Fault) -> Self {
        Self { fault: Some(fault), ..Self::new(objects, tree) }
    }

    /// Forgets what was visible.
    pub fn reset(&mut self) {
        self.seen.visible.fill(false);
        self.below.fill(false);
    }

    /// Whether each object was visible in the last frame.
    pub fn visible(&self) -> &[bool] {
        &self.seen.visible
    }

    /// The pyramid over the last frame.
    pub fn pyramid(&self) -> &Pyramid {
        &self.pyramid
    }
}

/// Draws what `view` sees of `objects`.
///
/// # Errors
/// Settings out of range, objects or a tree that `state` was not made for, the renderer's.
pub fn frame(
    settings: &Settings,
    objects: &Objects,
    tree: &Tree,
    view: &View,
    state: &mut State,
    renderer: &mut dyn ShowsDepth,
    frame: &mut Frame,
) -> Result<(), OcclusionError> {
    settings.check()?;
    state.seen.check(objects)?;
    if state.below.len() != tree.nodes.len() {
        let (made, given) = (state.below.len(), tree.nodes.len());
        return Err(OcclusionError::value("tree", format!("{given} nodes, not {made}")));
    }
    frame.clear();
    renderer.begin(view)?;
    let State { seen: Seen { visible }, below, drawn, places, list, stack, pyramid, fault } = state;
    let mut boxes = Boxes::new(settings.traversal, objects, tree, view, places, stack);
    drawn.fill(false);

    list.clear();
    let known: &[bool] = if settings.traversal == Traversal::Tree { below } else { visible };
    boxes.visit(
        |item, _, _| !known[item],
        |_, object| {
            if visible[object as usize] {
                drawn[object as usize] = true;
                list.push(object);
            }
        },
    );
    renderer.draw(list)?;
    frame.drew(objects, list);
    // Twice where the second pass draws anything: against what the first drew, then against all.
    for second in [true, false] {
        match fault {
            None => pyramid.build(view.width, view.height, renderer.depth()),
            Some(Fault::Nearest) => {
                pyramid.build_by(view.width, view.height, renderer.depth(), f32::max);
            }
        }
        frame.work.pyramid_texels += pyramid.texels().len() as u64;
        list.clear();
        visible.fill(false);
        below.fill(false);
        boxes.visit(
            |_, pixels, nearest| nearest < pyramid.farthest(pixels, settings.across),
            |item, object| {
                visible[object as usize] = true;
                if settings.traversal == Traversal::Tree {
                    mark(tree, below, item);
                }
                if second && !drawn[object as usize] {
                    list.push(object);
                }
            },
        );
        if list.is_empty() {
            break;
        }
        renderer.draw(list)?;
        frame.drew(objects, list);
    }
    frame.work.nodes += boxes.taken;
    renderer.end()
}

/// Node `leaf` and all above it have a visible object below.
fn mark(tree: &Tree, below: &mut [bool], leaf: usize) {
    let mut at = leaf;
    while !std::mem::replace(&mut below[at], true) {
        at = tree.nodes[at].parent as usize;
    }
}

/// The boxes of one frame.
struct Boxes<'a> {
    traversal: Traversal,
    tree: &'a Tree,
    view: &'a View,
    /// By object; filled where every object is asked.
    places: &'a [Place],
    stack: &'a mut Vec<u32>,
    /// Boxes looked at.
    taken: u64,
}

impl<'a> Boxes<'a> {
    fn new(
        traversal: Traversal,
        objects: &Objects,
        tree: &'a Tree,
        view: &'a View,
        places: &'a mut [Place],
        stack: &'a mut Vec<u32>,
    ) -> Self {
        let mut taken = 0;
        if traversal == Traversal::Flat {
            taken = places.len() as u64;
            places
                .par_iter_mut()
                .zip(&objects.objects)
                .with_min_len(1 << 10)
                .for_each(|(place, object)| *place = Place::of(view, &object.bounds));
        }
        Self { traversal, tree, view, places, stack, taken }
    }

    /// Hands on every object on the screen whose box, and every box above it, `hidden` does not
    /// claim. Items are objects, or nodes of the tree.
    fn visit(
        &mut self,
        hidden: impl Fn(usize, Pixels, f32) -> bool,
        mut leaf: impl FnMut(usize, u32),
    ) {
        if self.traversal == Traversal::Flat {
            for (object, place) in self.places.iter().enumerate() {
                let Place::At(pixels, nearest) = *place else {
                    if *place == Place::Near {
                        leaf(object, object as u32);
                    }
                    continue;
                };
                self.taken += 1;
                if !hidden(object, pixels, nearest) {
                    leaf(object, object as u32);
                }
            }
            return;
        }
        self.stack.clear();
        self.stack.extend((!self.tree.nodes.is_empty()).then_some(0));
        while let Some(node) = self.stack.pop() {
            self.taken += 1;
            let item = node as usize;
            match Place::of(self.view, &self.tree.nodes[item].bounds) {
                Place::Outside => continue,
                Place::At(pixels, nearest) if hidden(item, pixels, nearest) => continue,
                Place::Near | Place::At(..) => {}
            }
            if self.tree.is_leaf(node) {
                self.tree.objects_of(node).iter().for_each(|&object| leaf(item, object));
            }
            self.stack.extend(self.tree.nodes[item].children.clone().rev());
        }
    }
}
