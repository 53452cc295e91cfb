//! Cities and paths as the judges see them, made once and shared, and techniques run along them.

use super::super::{SPEC, case::inner_boxes};
use crate::{
    SuiteError, city,
    knob::{self, Knobs},
};
use dapple_occlusion::camera::{
    Frame, Image, Objects, Readiness, Settings, State, Technique, Tree, View, Work, city_keys,
    hierarchical_depth::{self, cpu},
    masked, software, techniques,
};
use dapple_scene::{Scene, city::City};
use serde_json::Value;
use std::{cell::RefCell, collections::BTreeMap, rc::Rc, sync::Arc, time::Instant};

/// Columns and rows of paths: the counters hardly depend on them.
pub const SIZE: [u32; 2] = [256, 144];

/// Columns and rows of the source's still views.
pub const THESIS_SIZE: [u32; 2] = [1200, 900];

/// Operations until an answer is there, as by default.
pub const LATENCY: Readiness = Readiness::Modelled(64);

/// Near plane over the scene's radius, as cases have it.
const NEAR: f64 = 1e-4;

/// Triangles of an object, at most, as by default.
const OBJECT_TRIANGLES: u32 = 128;

/// A city ready to be drawn.
#[derive(Clone)]
pub struct Town {
    /// Its buildings and lights.
    pub city: Rc<City>,
    /// With cameras and paths.
    pub scene: Rc<Scene>,
    /// One a storey, roof, ground or tree.
    pub objects: Arc<Objects>,
    /// The city's own hierarchy.
    pub tree: Rc<Tree>,
    /// Boxes that lie inside buildings.
    pub inner: Rc<Vec<masked::InnerBox>>,
}

/// A city by its scene's name, with some parameters given.
///
/// # Errors
/// Those of [`city::load`]; test data that are not at hand.
pub fn town(name: &str, given: &[(&str, Value)]) -> Result<Rc<Town>, SuiteError> {
    thread_local! {
        // What is shared counts its users in one thread.
        static MADE: RefCell<BTreeMap<String, Rc<Town>>> = const { RefCell::new(BTreeMap::new()) };
    }
    let key = format!("{name} {given:?}");
    if let Some(made) = MADE.with_borrow(|made| made.get(&key).map(Rc::clone)) {
        return Ok(made);
    }
    let given: Knobs = given.iter().map(|(name, v)| ((*name).into(), v.clone())).collect();
    let parameters = knob::complete("parameter", SPEC.parameters, &given)?;
    let loaded = city::load(name, 0, &parameters)?;
    let Some((city, parts)) = loaded.city else {
        return Err(SuiteError::Internal(format!("scene {name} is no city")));
    };
    let scene = loaded.scene;
    let (objects, owners) = Objects::from_scene(&scene, OBJECT_TRIANGLES)?;
    let tree = Tree::by_keys(&objects, &city_keys(&parts, &scene, &owners, &objects))?;
    let inner = inner_boxes(&city, objects.origin);
    let objects = Arc::new(objects);
    let town = Rc::new(Town {
        city: Rc::new(city),
        scene: Rc::new(scene),
        objects,
        tree: Rc::new(tree),
        inner: Rc::new(inner),
    });
    MADE.with_borrow_mut(|made| made.insert(key, Rc::clone(&town)));
    Ok(town)
}

impl Town {
    /// Every `step`-th view of a path, `frames` of them at most, or a still view so many times.
    ///
    /// # Errors
    /// An unknown view, an image without pixels.
    pub fn views(
        &self,
        view: &str,
        frames: u32,
        step: usize,
        [width, height]: [u32; 2],
    ) -> Result<Vec<View>, SuiteError> {
        let needed = frames.saturating_mul(step as u32);
        let (_, cameras) = city::cameras(&self.scene, view, needed)?;
        let near_m = NEAR * self.scene.bounds().radius();
        let one = |camera| Ok(View::new(camera, &self.objects, width, height, near_m)?);
        cameras.iter().step_by(step.max(1)).take(frames as usize).map(one).collect()
    }

    /// The same city under the hierarchy of smallest surfaces.
    ///
    /// # Errors
    /// None that the city's own has not met.
    pub fn bottom_up(&self) -> Result<Self, SuiteError> {
        Ok(Self { tree: Rc::new(Tree::bottom_up(&self.objects)?), ..self.clone() })
    }

    /// Triangles of all objects.
    pub fn triangles(&self) -> u64 {
        (0..self.objects.objects.len() as u32)
            .map(|o| u64::from(self.objects.triangle_count(o)))
            .sum()
    }
}

/// What a frame shows when everything is drawn.
pub struct Full {
    /// Reversed depth.
    pub depth: Vec<f32>,
    /// Pixels of each object.
    pub pixels: Vec<u32>,
    /// Triangles of each object that own a pixel.
    pub triangles: Vec<u32>,
}

impl Full {
    fn of(image: &Image, objects: usize) -> Self {
        let pixels = software::owners(image, objects);
        let mut ids: Vec<[u32; 2]> = image.ids.iter().copied().filter(|id| id[0] > 0).collect();
        ids.sort_unstable();
        ids.dedup();
        let mut triangles = vec![0; objects];
        for [object, _] in ids {
            if let Some(count) = triangles.get_mut(object as usize - 1) {
                *count += 1;
            }
        }
        Self { depth: image.depth.clone(), pixels, triangles }
    }

    /// Pixels of an image that lie deeper than these: something that shows is missing.
    pub fn lost(&self, image: &Image) -> u64 {
        image.depth.iter().zip(&self.depth).filter(|(a, b)| a < b).count() as u64
    }

    /// Triangles that own a pixel.
    pub fn owning(&self) -> u64 {
        self.triangles.iter().map(|t| u64::from(*t)).sum()
    }
}

/// Views one after the other, and what each shows.
pub struct Path {
    /// The city.
    pub town: Rc<Town>,
    /// One a frame.
    pub views: Vec<View>,
    /// One a frame.
    pub full: Vec<Full>,
}

/// A path at the usual size.
///
/// # Errors
/// As [`Town::views`].
pub fn path(town: &Rc<Town>, view: &str, frames: u32, step: usize) -> Result<Rc<Path>, SuiteError> {
    path_of(town, view, frames, step, SIZE)
}

/// A path of some size, made once.
///
/// # Errors
/// As [`Town::views`].
pub fn path_of(
    town: &Rc<Town>,
    view: &str,
    frames: u32,
    step: usize,
    size: [u32; 2],
) -> Result<Rc<Path>, SuiteError> {
    thread_local! {
        static MADE: RefCell<BTreeMap<String, Rc<Path>>> = const { RefCell::new(BTreeMap::new()) };
    }
    let key = format!("{:p} {view} {frames} {step} {size:?}", Rc::as_ptr(town));
    if let Some(made) = MADE.with_borrow(|made| made.get(&key).map(Rc::clone)) {
        return Ok(made);
    }
    let views = town.views(view, frames, step, size)?;
    let mut renderer = software::Fast::new(Arc::clone(&town.objects), LATENCY)?;
    let settings = Settings::new(Technique::None);
    let (mut state, mut out) = (State::new(&town.tree), Frame::default());
    let mut full = Vec::with_capacity(views.len());
    for view in &views {
        let Town { objects, tree, .. } = &**town;
        techniques::frame(&settings, objects, tree, view, &mut state, &mut renderer, &mut out)?;
        full.push(Full::of(renderer.image(), objects.objects.len()));
    }
    let path = Rc::new(Path { town: Rc::clone(town), views, full });
    MADE.with_borrow_mut(|made| made.insert(key, Rc::clone(&path)));
    Ok(path)
}

/// A technique with its knobs.
#[derive(Clone, Copy, Debug)]
pub enum Way {
    /// One that walks the tree and may ask.
    Asks(Settings),
    /// Two passes by hierarchical depth.
    Hierarchical(hierarchical_depth::Settings),
    /// Masked software occlusion culling.
    Masked(masked::Settings),
}

/// A technique that walks the tree, with its defaults.
pub fn asks(technique: Technique) -> Way {
    Way::Asks(Settings::new(technique))
}

/// CHC++ with some of its knobs changed.
pub fn chc_plus_plus(change: impl FnOnce(&mut Settings)) -> Way {
    let mut settings = Settings::new(Technique::ChcPlusPlus);
    change(&mut settings);
    Way::Asks(settings)
}

/// Two passes by hierarchical depth, with its defaults.
pub fn hierarchical() -> Way {
    Way::Hierarchical(hierarchical_depth::Settings::default())
}

/// Masked culling as the problem has it by default.
pub fn masked(occluders: masked::Occluders) -> Way {
    Way::Masked(masked::Settings {
        form: masked::Form::Fast,
        occluders,
        columns: Some(256),
        most_triangles: 8192,
    })
}

/// One frame of a technique.
#[derive(Clone, Debug)]
pub struct Shown {
    /// Counters.
    pub work: Work,
    /// Objects drawn.
    pub drawn: Vec<u32>,
    /// Pixels that lie deeper than when everything is drawn.
    pub lost: u64,
}

/// A frame of a technique as it was just drawn.
pub struct Now<'a> {
    /// Its number.
    pub index: usize,
    /// What was drawn with what work.
    pub frame: &'a Frame,
    /// What it shows.
    pub image: &'a Image,
    /// What is remembered, by techniques that ask.
    pub state: &'a State,
}

/// A technique under way along a path.
pub struct Walker<'p> {
    path: &'p Path,
    way: Way,
    renderer: software::Fast,
    state: State,
    depth_state: cpu::State,
    culler: Option<masked::Culler>,
    out: Frame,
}

impl<'p> Walker<'p> {
    /// Before the first frame.
    ///
    /// # Errors
    /// Settings that are refused.
    pub fn new(path: &'p Path, way: &Way) -> Result<Self, SuiteError> {
        let Town { objects, tree, inner, .. } = &*path.town;
        let culler = match way {
            Way::Masked(settings) => Some(masked::Culler::new(*settings, objects, inner)?),
            _ => None,
        };
        Ok(Self {
            path,
            way: *way,
            renderer: software::Fast::new(Arc::clone(objects), LATENCY)?,
            state: State::new(tree),
            depth_state: cpu::State::new(objects, tree),
            culler,
            out: Frame::default(),
        })
    }

    /// Draws a frame.
    ///
    /// # Errors
    /// Settings that are refused.
    pub fn frame(&mut self, index: usize) -> Result<(), SuiteError> {
        let Town { objects, tree, .. } = &*self.path.town;
        let view = &self.path.views[index];
        let (r, out) = (&mut self.renderer, &mut self.out);
        match (&self.way, &mut self.culler) {
            (Way::Asks(settings), _) => {
                techniques::frame(settings, objects, tree, view, &mut self.state, r, out)?;
            }
            (Way::Hierarchical(settings), _) => {
                cpu::frame(settings, objects, tree, view, &mut self.depth_state, r, out)?;
            }
            (Way::Masked(_), Some(culler)) => culler.frame(objects, tree, view, r, out)?,
            (Way::Masked(_), None) => {}
        }
        Ok(())
    }

    /// Nanoseconds of a frame.
    ///
    /// # Errors
    /// As [`Walker::frame`].
    pub fn ns(&mut self, index: usize) -> Result<f64, SuiteError> {
        let start = Instant::now();
        self.frame(index)?;
        Ok(start.elapsed().as_nanos() as f64)
    }
}

impl Path {
    /// Runs a technique from the path's start and looks at each frame.
    ///
    /// # Errors
    /// Settings that are refused.
    pub fn walk(
        &self,
        way: &Way,
        mut look: impl FnMut(Now<'_>) -> Result<(), SuiteError>,
    ) -> Result<(), SuiteError> {
        let mut walker = Walker::new(self, way)?;
        for index in 0..self.views.len() {
            walker.frame(index)?;
            let state = &walker.state;
            look(Now { index, frame: &walker.out, image: walker.renderer.image(), state })?;
        }
        Ok(())
    }

    /// Runs a technique from the path's start.
    ///
    /// # Errors
    /// As [`Path::walk`].
    pub fn shown(&self, way: &Way) -> Result<Vec<Shown>, SuiteError> {
        let mut shown = Vec::with_capacity(self.views.len());
        self.walk(way, |now| {
            shown.push(Shown {
                work: now.frame.work,
                drawn: now.frame.drawn.clone(),
                lost: self.full[now.index].lost(now.image),
            });
            Ok(())
        })?;
        Ok(shown)
    }

    /// Triangles drawn that own no pixel, over triangles that own one; over the whole path.
    pub fn overdraw(&self, shown: &[Shown]) -> f64 {
        let (mut drawn, mut owning_drawn, mut owning) = (0, 0, 0);
        for (shown, full) in shown.iter().zip(&self.full) {
            drawn += shown.work.triangles;
            owning += full.owning();
            owning_drawn +=
                shown.drawn.iter().map(|o| u64::from(full.triangles[*o as usize])).sum::<u64>();
        }
        (drawn - owning_drawn) as f64 / owning.max(1) as f64
    }
}

/// A sum over frames.
pub fn sum(shown: &[Shown], of: impl Fn(&Work) -> u64) -> f64 {
    shown.iter().map(|s| of(&s.work)).sum::<u64>() as f64
}

/// The mean of a counter over frames.
pub fn mean(shown: &[Shown], of: impl Fn(&Work) -> u64) -> f64 {
    sum(shown, of) / shown.len().max(1) as f64
}

/// Pixels lost over all frames.
pub fn lost(shown: &[Shown]) -> u64 {
    shown.iter().map(|s| s.lost).sum()
}

/// A claim's judge, open where test data are not at hand.
///
/// # Errors
/// All other errors.
pub fn open_without_data(
    judged: Result<crate::claims::Judged, SuiteError>,
) -> Result<crate::claims::Judged, SuiteError> {
    match judged {
        Err(error @ SuiteError::MissingData { .. }) => {
            let figures = vec![crate::claims::figure("files at hand", 0.0, "")];
            Ok(crate::claims::verdict::judged(
                crate::claims::Verdict::Open,
                error.to_string(),
                figures,
            ))
        }
        other => other,
    }
}
