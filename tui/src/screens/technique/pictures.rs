//! Truth, result and error map of one setting, from a child that is started for them and stopped
//! once they are there.

use super::World;
use crate::{
    msg::{Effect, JobId, Msg},
    plot::picture::Triplet,
};
use dapple_records::{Feed, FeedLine, Row, Show, catalogue::TechniqueInfo};
use std::collections::BTreeMap;

/// What is to be shown, and on which adapter.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Request {
    show: Show,
    adapter: Option<String>,
    /// The truth of the record; empty without one.
    truth: String,
}

/// Of one setting at a time.
#[derive(Clone, Debug, Default)]
pub(super) struct Pictures {
    wanted: Option<Request>,
    /// What is shown or being made.
    begun: Option<Request>,
    job: Option<(JobId, u64)>,
    /// The last words of the child, for when it fails.
    words: String,
    /// Once there.
    pub(super) shown: Option<Result<Triplet, String>>,
    /// Errors of what is shown.
    pub(super) errors: BTreeMap<String, f64>,
    /// What the child said about its case, where it is not the record's.
    pub(super) note: String,
    /// Which of the three is shown where there is room for one.
    pub(super) face: usize,
}

/// The setting of a record.
pub(super) fn request(row: &Row) -> Request {
    let show = Show {
        request: 0,
        problem: row.problem.clone(),
        scene: row.scene.clone(),
        view: row.view.clone(),
        seed: 0,
        parameters: BTreeMap::new(),
        technique: row.technique.clone(),
        variant: row.variant.clone(),
        form: row.form.clone(),
        knobs: row.knobs.clone(),
    };
    let adapter = (row.device != "cpu").then(|| row.adapter.clone());
    Request { show, adapter, truth: row.truth.clone() }
}

/// A technique as it is declared, on the default case.
pub(super) fn defaults(problem: &str, info: &TechniqueInfo) -> Request {
    // The processor is always there.
    let form = info.forms.iter().find(|f| *f == "cpu").or(info.forms.first());
    let show = Show {
        problem: problem.into(),
        technique: info.id.clone(),
        form: form.cloned().unwrap_or_default(),
        ..Show::default()
    };
    Request { show, adapter: None, truth: String::new() }
}

impl Pictures {
    /// Shows `request`, unless it is shown already.
    pub(super) fn want(&mut self, request: Request, world: &mut World) -> Vec<Effect> {
        if self.begun.as_ref() == Some(&request) {
            self.wanted = None;
            return Vec::new();
        }
        self.wanted = Some(request);
        // One child at a time; the newest request begins when the old child is gone.
        match self.job {
            Some((job, _)) => vec![Effect::Stop(job)],
            None => self.begin(world),
        }
    }

    /// Ends the child, if there is one.
    pub(super) fn stop(&mut self) -> Vec<Effect> {
        self.wanted = None;
        let Some((job, _)) = self.job.take() else { return Vec::new() };
        // Unfinished: begun again when it is wanted again.
        self.begun = None;
        vec![Effect::Stop(job)]
    }

    /// Whether pictures are on their way.
    pub(super) fn busy(&self) -> bool {
        self.job.is_some() || self.wanted.is_some()
    }

    /// The next of the three pictures.
    pub(super) fn flip(&mut self) {
        self.face = (self.face + 1) % 3;
    }

    fn begin(&mut self, world: &mut World) -> Vec<Effect> {
        let Some(mut request) = self.wanted.take() else { return Vec::new() };
        self.begun = Some(request.clone());
        (self.shown, self.note, self.words) = (None, String::new(), String::new());
        self.errors.clear();
        let number = world.next_request();
        request.show.request = number;
        let job = world.jobs.reserve();
        self.job = Some((job, number));
        let mut arguments = vec!["live".to_string()];
        if let Some(adapter) = request.adapter {
            arguments.extend(["--adapter".into(), adapter]);
        }
        let line = match to_line(&request.show) {
            Ok(line) => line,
            Err(why) => {
                self.job = None;
                self.shown = Some(Err(why));
                return Vec::new();
            }
        };
        vec![Effect::Start { job, arguments, input: true }, Effect::Write { job, line }]
    }

    /// A child's line or end.
    pub(super) fn hear(&mut self, msg: &Msg, world: &mut World) -> Vec<Effect> {
        let Some((ours, number)) = self.job else { return Vec::new() };
        match msg {
            Msg::Heard { job, line } if *job == ours => {
                let FeedLine::Event(event) = &**line else { return Vec::new() };
                self.take(event, number)
            }
            Msg::Grumbled { job, text } if *job == ours => {
                self.words.clone_from(text);
                Vec::new()
            }
            Msg::Ended { job, how, .. } if *job == ours => {
                self.job = None;
                if self.wanted.is_none() && self.shown.is_none() {
                    let words = if self.words.is_empty() { how } else { &self.words };
                    self.shown = Some(Err(format!("no pictures: {words}")));
                }
                self.begin(world)
            }
            _ => Vec::new(),
        }
    }

    fn take(&mut self, event: &Feed, number: u64) -> Vec<Effect> {
        match event {
            Feed::Ready { truth, .. } => {
                let of_record = self.begun.as_ref().map_or("", |r| r.truth.as_str());
                if !of_record.is_empty() && of_record != truth {
                    self.note = format!("the pictures' case differs from the record's: {truth}");
                }
            }
            Feed::Checked { request, errors, .. } if *request == number => {
                self.errors.clone_from(errors);
            }
            Feed::Picture { request, width, height, truth, result } if *request == number => {
                self.shown = Some(Triplet::decode(*width, *height, truth, result));
                return self.job.map(|(job, _)| Effect::Stop(job)).into_iter().collect();
            }
            Feed::Failed { request, reason } if *request == number || *request == 0 => {
                self.shown = Some(Err(reason.clone()));
                return self.job.map(|(job, _)| Effect::Stop(job)).into_iter().collect();
            }
            _ => {}
        }
        Vec::new()
    }
}

fn to_line(show: &Show) -> Result<String, String> {
    serde_json::to_string(show).map_err(|e| e.to_string())
}
