//! A technique that answers for every face of the path.

use super::{SPEC, case::RegionCase};
use crate::{
    SuiteError,
    problem::{Checked, Form, FrameTime, Picture, Setting, Subject},
};
use dapple_many_lights::region::{
    Direction, Many, OccluderMode, RegionTechnique, Steps, ViewCell, truth::Agreement,
};
use std::{collections::BTreeMap, time::Instant};

/// A technique made ready.
pub struct RegionSubject<'a> {
    case: &'a RegionCase,
    setting: Setting,
    many: Many,
    precuts: Vec<Vec<u32>>,
}

impl<'a> RegionSubject<'a> {
    /// Allocates what a frame needs.
    ///
    /// # Errors
    /// Settings that are refused.
    pub fn new(case: &'a RegionCase, setting: &Setting) -> Result<Self, SuiteError> {
        SPEC.check(setting)?;
        let (many, setting) = (case.many(setting)?, setting.clone());
        Ok(Self { case, setting, many, precuts: Vec::new() })
    }

    fn asked(&self, frame: usize) -> Vec<(&'a ViewCell, Direction)> {
        self.case.frames()[frame].iter().map(|question| question.asked()).collect()
    }

    /// Nodes by which the precuts of a frame differ from the reference's.
    fn differing(&self, frame: usize) -> Result<u64, SuiteError> {
        let reference = Setting { form: Form::Reference, ..self.setting.clone() };
        let mut theirs = Vec::new();
        self.case.many(&reference)?.all(&self.asked(frame), &mut theirs);
        let apart = |a: &Vec<u32>, b: &Vec<u32>| {
            let missing = |a: &[u32], b: &[u32]| {
                a.iter().filter(|node| b.binary_search(node).is_err()).count() as u64
            };
            missing(a, b) + missing(b, a)
        };
        Ok(self.precuts.iter().zip(&theirs).map(|(a, b)| apart(a, b)).sum())
    }
}

impl Subject for RegionSubject<'_> {
    fn frames(&self) -> usize {
        self.case.frames().len()
    }

    fn reset(&mut self) -> Result<(), SuiteError> {
        Ok(())
    }

    fn frame(&mut self, index: usize) -> Result<FrameTime, SuiteError> {
        let asked = self.asked(index);
        let start = Instant::now();
        self.many.all(&asked, &mut self.precuts);
        let wall_ns = start.elapsed().as_nanos() as u64;
        Ok(FrameTime { wall_ns, ..FrameTime::default() })
    }

    fn check(&mut self) -> Result<Checked, SuiteError> {
        let mut checked = Checked::default();
        let mut agreement = Agreement::default();
        let tree = &self.case.night().town.lights;
        let (mut lights, mut most, mut faces) = (0, 0, 0);
        // Steps are counted from the start.
        self.many = self.case.many(&self.setting)?;
        for frame in 0..self.frames() {
            let asked = self.asked(frame);
            self.many.all(&asked, &mut self.precuts);
            for (question, precut) in self.precuts.iter().enumerate() {
                if let Some(place) =
                    broken(tree.nodes.len(), precut, |n| tree.nodes[n as usize].size)
                {
                    let face = format!("frame {frame}, face {question}");
                    checked.violations.push(format!("{face}: the precut is none at place {place}"));
                    return Ok(checked);
                }
                most = most.max(precut.len() as u64);
                lights += leaves(tree, precut);
            }
            faces += asked.len() as u64;
            agreement += self.case.judge(frame, &self.precuts);
            let fast = self.setting.form != Form::Reference;
            if frame == 0
                && fast
                && SPEC
                    .technique(&self.setting.technique)?
                    .has(&self.setting.variant, Form::Reference)
            {
                let differing = self.differing(frame)?;
                checked.port_errors.insert("nodes".into(), differing as f64);
                if differing > 0 {
                    let found =
                        format!("port: {differing} nodes differ from the reference's precuts");
                    checked.violations.push(found);
                }
            }
        }
        let steps = self.many.steps();
        if !steps.is_consistent() {
            checked.violations.push(format!("steps do not add up: {steps:?}"));
        }
        let all = faces as f64 * tree.leaves.len() as f64;
        checked.errors = [
            ("kept_hidden", 1.0 - agreement.tightness()),
            ("false_hidden", agreement.false_hidden()),
            (
                "false_visible",
                share(agreement.hidden_kept, agreement.hidden_kept + agreement.seen_kept),
            ),
            ("precut_share", if all == 0.0 { 0.0 } else { lights as f64 / all }),
            ("occluders_lost", self.lost()?),
        ]
        .map(|(name, value)| (name.to_string(), value))
        .into();
        checked.counters = counters(&steps);
        checked.counters.insert("faces".into(), faces);
        checked.counters.insert("most_precut".into(), most);
        checked.counters.insert("lights_kept".into(), lights);
        checked.memory_bytes = self.many.bytes();
        Ok(checked)
    }

    fn picture(&mut self) -> Result<Option<Picture>, SuiteError> {
        self.frame(self.frames() - 1)?;
        Ok(self.case.picture(&self.precuts))
    }
}

impl RegionSubject<'_> {
    /// Mean share of the boxes that turns of cells took, over faces.
    fn lost(&self) -> Result<f64, SuiteError> {
        let mode = match self.case.technique(&self.setting)? {
            RegionTechnique::FacadeCluster(settings) => settings.occluders,
            RegionTechnique::ExtendedProjection { .. } => OccluderMode::Leaf,
            RegionTechnique::Everything | RegionTechnique::Sampled(_) => return Ok(0.0),
        };
        let occluders = self.case.occluders(&self.setting)?;
        let all = self.case.frames().iter().flatten();
        let lost: Vec<f64> = all.map(|q| occluders.turned(q.cell.cell.turn, mode).lost).collect();
        Ok(lost.iter().sum::<f64>() / lost.len().max(1) as f64)
    }
}

/// Place of the first node that is not in the tree, or not behind the subtree before it.
fn broken(nodes: usize, precut: &[u32], size: impl Fn(u32) -> u32) -> Option<usize> {
    let mut end = 0;
    precut.iter().position(|&node| {
        let bad = node as usize >= nodes || node < end;
        if !bad {
            end = node + size(node);
        }
        bad
    })
}

fn leaves(tree: &dapple_many_lights::LightTree, precut: &[u32]) -> u64 {
    let of = |node: &u32| {
        let end = node + tree.nodes[*node as usize].size;
        tree.nodes[*node as usize..end as usize].iter().filter(|n| n.is_leaf()).count() as u64
    };
    precut.iter().map(of).sum()
}

fn share(part: u64, whole: u64) -> f64 {
    if whole == 0 { 0.0 } else { part as f64 / whole as f64 }
}

/// By name; what did not happen is left out.
pub fn counters(steps: &Steps) -> BTreeMap<String, u64> {
    [
        ("evaluations", steps.evaluations),
        ("iterations", steps.iterations),
        ("potential_tests", steps.potential),
        ("potential_culled", steps.potential_culled),
        ("last_tests", steps.last),
        ("last_culled", steps.last_culled),
        ("last_divided", steps.last_divided),
        ("last_output", steps.last_output),
        ("last_projections", steps.last_projected),
        ("early_tests", steps.early),
        ("early_culled", steps.early_culled),
        ("early_projections", steps.early_projected),
        ("straddling", steps.straddling),
        ("reprojections", steps.reprojections),
        ("shadows_moved", steps.moved),
        ("occluder_planes", steps.projections),
        ("occluders_projected", steps.projected),
        ("shadows_compared", steps.compared),
        ("precut_nodes", steps.output),
        ("rays", steps.rays),
    ]
    .into_iter()
    .filter(|(_, count)| *count > 0)
    .map(|(name, count)| (name.to_string(), count))
    .collect()
}
