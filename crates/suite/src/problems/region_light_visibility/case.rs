//! A prepared case: the faces of every frame, and what some of them see.

use super::{
    faces::{Cutting, Question, questions},
    picture, settings, subject,
    truth::{FaceTruth, Sampling, Sighted, of_frame},
};
use crate::{
    SuiteError,
    case::Case,
    knob::Get,
    night::{Night, part},
    problem::{Facts, Form, Picture, Prepared, Setting, Subject},
};
use dapple_many_lights::region::{Many, Occluders, RegionTechnique, make, truth::Agreement};
use dapple_night_city::cells::WholeCells;
use std::{cell::OnceCell, sync::Arc};

/// Faces of a city's cells, with the truth of some of them.
pub struct RegionCase {
    facts: Facts,
    night: Night,
    threshold: f64,
    seed: u32,
    /// By frame.
    frames: Vec<Vec<Question>>,
    truth: Vec<Vec<FaceTruth>>,
    /// Buildings and every facade's wall.
    objects: OnceCell<Arc<Occluders>>,
}

impl RegionCase {
    /// Loads the city, finds its cells, and looks from their faces (cached between runs).
    ///
    /// # Errors
    /// A scene that cannot be used, an unknown view, or nothing to be judged.
    pub fn prepare(case: &Case) -> Result<Self, SuiteError> {
        Self::of(Night::load(case)?, case)
    }

    /// The same for a city at hand; of `case`, its scene's name is not used.
    ///
    /// # Errors
    /// As [`RegionCase::prepare`].
    pub fn of(night: Night, case: &Case) -> Result<Self, SuiteError> {
        let parameters = &case.parameters;
        let cutting = Cutting {
            tau_px: parameters.int("tau")? as f64,
            split: part(parameters.word("most_split")?)?,
        };
        let threshold = parameters.float("threshold")?;
        let sampling = Sampling {
            faces: parameters.int("truth_faces")? as usize,
            lights: parameters.int("truth_lights")? as usize,
            points: parameters.int("truth_points")? as u32,
            threshold,
            seed: case.seed,
        };
        let mut whole = WholeCells::default();
        let frames = (0..night.town.views.len())
            .map(|frame| questions(&night, frame, cutting, &mut whole))
            .collect::<Result<Vec<_>, _>>()?;
        let of = |(frame, questions): (usize, &Vec<Question>)| {
            of_frame(&night, frame, questions, &sampling)
        };
        let truth: Vec<Vec<FaceTruth>> = frames.iter().enumerate().map(of).collect();
        let looked: usize = truth.iter().flatten().map(|face| face.lights.len()).sum();
        if looked == 0 {
            return Err(SuiteError::Usage(format!(
                "scene {}, view {}: no face has a light in front of it that could matter",
                night.scene, night.view
            )));
        }
        let faces: usize = frames.iter().map(Vec::len).sum();
        let judged: usize = truth.iter().map(Vec::len).sum();
        let mut notes = night.notes.clone();
        notes.push(format!(
            "{faces} faces in {} frames; truth of {judged} of them, of {looked} lights",
            frames.len()
        ));
        let facts = Facts {
            scene: night.scene.clone(),
            scene_hash: night.hash.clone(),
            view: night.view.clone(),
            size: format!("{}x{}, {} frames", night.size[0], night.size[1], frames.len()),
            truth: format!(
                "rays to at most {} lights a face, {} points of it for each beside silhouettes",
                sampling.lights, sampling.points
            ),
            notes,
        };
        Ok(Self {
            facts,
            night,
            threshold,
            seed: (case.seed ^ case.seed >> 32) as u32,
            frames,
            truth,
            objects: OnceCell::new(),
        })
    }

    /// The city.
    pub fn night(&self) -> &Night {
        &self.night
    }

    /// Radiance below which a light does not matter.
    pub fn threshold(&self) -> f64 {
        self.threshold
    }

    /// Faces, by frame.
    pub fn frames(&self) -> &[Vec<Question>] {
        &self.frames
    }

    /// What some faces see, by frame.
    pub fn truth(&self) -> &[Vec<FaceTruth>] {
        &self.truth
    }

    /// What hides lights, as a setting asks for it.
    ///
    /// # Errors
    /// A knob that is not there.
    pub fn occluders(&self, setting: &Setting) -> Result<Arc<Occluders>, SuiteError> {
        let town = &self.night.town;
        let objects = setting.knobs.contains_key("occluders")
            && setting.knobs.word("occluders")? == "objects";
        Ok(match objects {
            false => Arc::clone(&town.occluders),
            true => {
                let made =
                    || Arc::new(Occluders::of_objects(&self.night.city, town.objects.origin));
                Arc::clone(self.objects.get_or_init(made))
            }
        })
    }

    /// The technique that a setting asks for.
    ///
    /// # Errors
    /// Settings that are refused.
    pub fn technique(&self, setting: &Setting) -> Result<RegionTechnique, SuiteError> {
        settings::technique(setting, self.threshold, self.seed)
    }

    /// A technique made ready for this case, once a thread.
    ///
    /// # Errors
    /// Settings that are refused.
    pub fn many(&self, setting: &Setting) -> Result<Many, SuiteError> {
        let (technique, occluders) = (self.technique(setting)?, self.occluders(setting)?);
        let town = &self.night.town;
        let reference = setting.form == Form::Reference;
        let made = || make(&technique, reference, town.world(true), &town.lights, &occluders);
        Ok(Many::new(made)?)
    }

    /// Counts a frame's lights by what rays say and by whether they are kept.
    pub fn judge(&self, frame: usize, precuts: &[Vec<u32>]) -> Agreement {
        let tree = &self.night.town.lights;
        let mut agreement = Agreement::default();
        for face in &self.truth[frame] {
            let kept = dapple_many_lights::region::truth::kept(tree, &precuts[face.question]);
            let judged = face.lights.iter().filter(|(_, sighted)| *sighted != Sighted::Weak);
            let pairs =
                judged.map(|(light, sighted)| (*sighted == Sighted::Strong, kept[*light as usize]));
            agreement += Agreement::of(pairs);
        }
        agreement
    }

    /// Seen from above: what the face with most lights of the last frame should keep, and what it
    /// does.
    pub fn picture(&self, precuts: &[Vec<u32>]) -> Option<Picture> {
        let face = self.truth.last()?.iter().max_by_key(|face| face.lights.len())?;
        let question = self.frames.last()?.get(face.question)?;
        Some(picture::plan(&self.night, question, face, precuts.get(face.question)?))
    }
}

impl Prepared for RegionCase {
    fn facts(&self) -> Facts {
        self.facts.clone()
    }

    fn subject<'a>(&'a self, setting: &Setting) -> Result<Box<dyn Subject + 'a>, SuiteError> {
        Ok(Box::new(subject::RegionSubject::new(self, setting)?))
    }
}
