//! How a setting makes whole frames.

use super::case::NightCase;
use crate::{SuiteError, knob::Get, problem::Setting};
use dapple_many_lights::{
    Form, LightTree, Lighting, Reservoirs, Shaded, Technique, Work, cut::Starts, make,
};
use dapple_night_city::{Counts, Device, Drawer, FrameTimes, Front, Night, Pipeline};
use std::{sync::Arc, time::Instant};

/// A technique made ready.
pub enum Method<'g> {
    /// What is seen, its cells, their precuts, cuts of these.
    Cuts(Box<Pipeline<'g>>),
    /// What is seen; all lights at every pixel by another technique.
    Other {
        /// What is seen.
        front: Box<Front<'g>>,
        /// How pixels are lit.
        lighting: Box<dyn Lighting + 'g>,
    },
}

impl<'g> Method<'g> {
    /// Allocates what frames need.
    ///
    /// # Errors
    /// Settings that are refused, or a device that is too small.
    pub fn new(
        case: &NightCase<'g>,
        setting: &Setting,
        night: &Night,
        device: Option<&Device<'g>>,
    ) -> Result<Self, SuiteError> {
        let town = &case.night().town;
        if setting.technique != "reservoirs" {
            return Ok(Self::Cuts(Box::new(Pipeline::new(town, night, device)?)));
        }
        let technique = Technique::Reservoirs(Reservoirs {
            candidates: setting.knobs.int("candidates")? as u32,
            temporal: true,
            history: 20,
            neighbours: setting.knobs.int("neighbours")? as u32,
            radius_px: 30.0,
            unbiased: true,
        });
        let none = Arc::new(LightTree::default());
        let lighting = make(Form::Cpu, &technique, town.world(true), &none, None)?;
        let front = Front::new(town, night, Drawer::new(&town.objects, device)?)?;
        Ok(Self::Other { front: Box::new(front), lighting })
    }

    /// Forgets every earlier frame.
    ///
    /// # Errors
    /// The device's.
    pub fn reset(&mut self, seed: u32) -> Result<(), SuiteError> {
        match self {
            Self::Cuts(pipeline) => pipeline.reset()?,
            Self::Other { front, lighting } => {
                front.reset()?;
                lighting.reset(seed)?;
            }
        }
        Ok(())
    }

    /// One frame.
    ///
    /// # Errors
    /// The device's.
    pub fn frame(&mut self, index: usize, count: bool) -> Result<FrameTimes, SuiteError> {
        match self {
            Self::Cuts(pipeline) => Ok(pipeline.frame(index, count)?),
            Self::Other { front, lighting } => {
                let begun = Instant::now();
                let prepared = front.prepare(index)?;
                let lit = Instant::now();
                let passes = lighting.shade(index, count)?;
                Ok(FrameTimes {
                    visibility_ns: prepared.visibility_ns,
                    shading_ns: lit.elapsed().as_nanos() as u64,
                    wall_ns: begun.elapsed().as_nanos() as u64,
                    passes,
                    counts: Counts { drawn: prepared.counts.drawn, ..Counts::default() },
                    ..FrameTimes::default()
                })
            }
        }
    }

    /// What the last frame came out as.
    ///
    /// # Errors
    /// The device's.
    pub fn read(&mut self, shaded: &mut Shaded) -> Result<Work, SuiteError> {
        match self {
            Self::Cuts(pipeline) => pipeline.read(shaded)?,
            Self::Other { lighting, .. } => lighting.read(shaded)?,
        }
        Ok(shaded.work)
    }

    /// What objects of the last frame start at, where cuts start anywhere.
    pub fn starts(&self) -> Option<&Starts> {
        match self {
            Self::Cuts(pipeline) => Some(pipeline.front().starts()),
            Self::Other { .. } => None,
        }
    }

    /// Everything before pixels are lit.
    pub fn front(&self) -> &Front<'g> {
        match self {
            Self::Cuts(pipeline) => pipeline.front(),
            Self::Other { front, .. } => front,
        }
    }

    /// Bytes of everything but frames, scene and lights.
    pub fn bytes(&self) -> u64 {
        match self {
            Self::Cuts(pipeline) => pipeline.bytes(),
            Self::Other { front, lighting } => front.bytes() + lighting.bytes(),
        }
    }
}
