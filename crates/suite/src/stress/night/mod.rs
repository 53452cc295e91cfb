//! Extremes of cities at night, which all problems share that ask which lights reach what.
//!
//! `world` pushes a city as a whole and the image, `walls` what stands where, `lights` what shines from
//! where, `content` what there is at all and where the camera is; `bad` is input that must be refused.
//! `knobs` pushes settings that these problems have in common.
//! `made` builds the small cities of all these, `edit` changes cities.

mod bad;
mod content;
pub mod edit;
pub mod knobs;
mod lights;
pub mod made;
mod walls;
mod world;

use super::{Axis, Criterion, Prepare, Values, settings::Usual};
use crate::{
    SuiteError,
    case::Case,
    city::{self, Loaded},
    night::Night,
    problem::Prepared,
};
use dapple_gpu::Gpu;
use dapple_scene::city::City;

/// Poses a problem's question of a city at hand.
pub type Pose =
    for<'g> fn(Night, &Case, Option<&'g Gpu>) -> Result<Box<dyn Prepared + 'g>, SuiteError>;

/// Whose axes these are.
#[derive(Clone, Copy)]
pub struct Posed {
    /// What they have in common; its criterion is for another question.
    pub usual: Usual,
    /// For the same question in other units.
    pub unchanged: Criterion,
    /// How a changed city is asked about.
    pub pose: Pose,
    /// Whether a case must be refused whose lights all give nothing.
    pub refuses_dark: bool,
}

/// What a value of an axis makes of a city.
type Push = fn(Loaded, f64, &Case) -> Result<Loaded, SuiteError>;

/// The axes, each pushed alone.
pub fn axes(posed: Posed) -> Vec<Axis> {
    [
        world::axes(posed),
        walls::axes(posed),
        lights::axes(posed),
        content::axes(posed),
        bad::axes(posed),
    ]
    .into_iter()
    .flatten()
    .collect()
}

impl Posed {
    /// An axis of the city alone: every technique is pushed, as it is.
    fn axis(
        self,
        id: &'static str,
        help: &'static str,
        values: Values,
        home: f64,
        prepare: Prepare,
    ) -> Axis {
        Axis { prepare, ..self.usual.axis(id, help, values, home) }
    }

    /// The case's city, changed.
    pub fn pushed(self, push: Push) -> Prepare {
        Box::new(move |case, value, gpu| {
            let loaded = city::load(&case.scene, case.seed, &case.parameters)?;
            self.ask(push(loaded, value, case)?, case, gpu)
        })
    }

    /// A city of the axis's own along its only path, whatever the case's.
    pub fn made(self, make: fn(f64, &Case) -> Result<City, SuiteError>) -> Prepare {
        Box::new(move |case, value, gpu| {
            self.ask(loaded(make(value, case)?)?, &first_view(case), gpu)
        })
    }

    /// The question about a changed city.
    fn ask<'g>(
        self,
        changed: Loaded,
        case: &Case,
        gpu: Option<&'g Gpu>,
    ) -> Result<Box<dyn Prepared + 'g>, SuiteError> {
        changed.scene.validate()?;
        (self.pose)(Night::of(known(changed), case)?, case, gpu)
    }
}

/// The case with the first path that there is.
pub fn first_view(case: &Case) -> Case {
    Case { view: String::new(), ..case.clone() }
}

/// A city as it is loaded from a file.
pub fn loaded(city: City) -> Result<Loaded, SuiteError> {
    let made = city.scene();
    let mut scene = made.scene;
    scene.validate()?;
    let notes = scene.add_defaults();
    Ok(Loaded { hash: String::new(), scene, city: Some((city, made.parts)), notes })
}

/// What was changed is known by what it has become: the truth is stored under that. Lights and the boxes
/// that hide them are no part of the scene.
fn known(changed: Loaded) -> Loaded {
    let mut hasher = blake3::Hasher::new();
    hasher.update(changed.scene.hash().as_bytes());
    if let Some((city, _)) = &changed.city {
        hasher.update(format!("{:?} {:?}", city.lights, city.lamps).as_bytes());
        for building in &city.buildings {
            let solid = (&building.footprint, building.base_m, building.eaves_m, &building.inner);
            hasher.update(format!("{solid:?}").as_bytes());
        }
    }
    Loaded { hash: hasher.finalize().to_hex()[..32].into(), ..changed }
}
