//! `dapple live`: shows one setting after another, as they are asked for on standard input, one
//! `Show` a line; what happens is told in JSON lines (`dapple_records::feed`).
//!
//! What is dear is kept while it can be: the prepared case (scene and truth) while problem, scene,
//! view, seed and parameters stay, the subject while technique, variant, form and knobs do. Times
//! told here are for the eye: frames are spread out so that the machine stays usable, and caches
//! and clocks cool down between them. `dapple measure` makes the times that count.

mod inbox;
mod wanted;

use crate::{
    Outcome, args,
    feed::{self, tell},
    verbs::choice,
};
use anyhow::Result;
use dapple_gpu::{Gpu, GpuError};
use dapple_records::Feed;
use dapple_suite::{
    SuiteError,
    problem::{Checked, Form, FrameTime, Prepared, Subject},
};
use inbox::{Inbox, Next};
use std::{
    cell::OnceCell,
    io,
    sync::Arc,
    thread,
    time::{Duration, Instant},
};
use wanted::{Asked, Wanted};

/// Between two frames told of: more than 30 a second nobody can see.
const LIVELY: Duration = Duration::from_millis(33);

/// Frames after which nothing new is to be expected and the pace falls: 10 seconds' worth.
const LIVELY_FRAMES: usize = 300;

/// Between two frames from then on.
const IDLE: Duration = Duration::from_millis(500);

/// Runs until standard input ends; what was asked last is still answered.
pub fn run(args: &args::Live) -> Result<Outcome> {
    let inbox = Arc::new(Inbox::default());
    let reader = Arc::clone(&inbox);
    thread::spawn(move || reader.fill(&mut io::stdin().lock(), &mut refused));
    let device = Device { choice: args.adapter.clone(), opened: OnceCell::new() };
    let mut next = ask(&inbox, None)?;
    while let Next::Asked(asked) = next {
        next = show_case(&inbox, &device, *asked)?;
    }
    Ok(Outcome::Ok)
}

/// The adapter, opened when the first setting needs it, and then once.
struct Device {
    choice: Option<String>,
    opened: OnceCell<Result<Gpu, GpuError>>,
}

impl Device {
    fn open(&self) -> Result<&Gpu, SuiteError> {
        let opened = self.opened.get_or_init(|| Gpu::open(&choice(self.choice.as_ref())));
        opened.as_ref().map_err(|error| error.clone().into())
    }

    fn if_open(&self) -> Option<&Gpu> {
        self.opened.get()?.as_ref().ok()
    }
}

/// Tells that a line or a request came to nothing.
fn refused(request: u64, reason: &str) -> io::Result<()> {
    tell(&Feed::Failed { request, reason: reason.into() })
}

/// The next request that names something there is, or that there was none for so long.
fn ask(inbox: &Inbox, most: Option<Duration>) -> io::Result<Next<Asked>> {
    loop {
        let show = match inbox.take(most) {
            Next::Asked(show) => show,
            Next::Nothing => return Ok(Next::Nothing),
            Next::Closed => return Ok(Next::Closed),
        };
        match Wanted::of(&show) {
            Ok(wanted) => {
                return Ok(Next::Asked(Box::new(Asked { request: show.request, wanted })));
            }
            Err(error) => refused(show.request, &error.to_string())?,
        }
    }
}

/// Says why a request came to nothing and waits for the next. A device that is gone ends the
/// process: nothing that it would still do could be believed, and the next one opens it anew.
fn fail(inbox: &Inbox, request: u64, error: SuiteError) -> Result<Next<Asked>> {
    refused(request, &error.to_string())?;
    match error {
        SuiteError::Gpu(GpuError::DeviceLost(_) | GpuError::Timeout { .. }) => Err(error.into()),
        _ => Ok(ask(inbox, None)?),
    }
}

/// Prepares a case and answers requests while they are about it. Returns the first that is not.
fn show_case(inbox: &Inbox, device: &Device, first: Asked) -> Result<Next<Asked>> {
    let Asked { request, wanted } = &first;
    stage(wanted, "prepare")?;
    let opened = match wanted.setting.form {
        Form::Gpu => device.open().map(Some),
        Form::Reference | Form::Cpu => Ok(device.if_open()),
    };
    let prepared = opened.and_then(|gpu| Ok((gpu, wanted.problem.prepare(&wanted.case, gpu)?)));
    let (gpu, prepared) = match prepared {
        Ok(prepared) => prepared,
        Err(error) => return fail(inbox, *request, error),
    };
    for text in prepared.facts().notes {
        tell(&Feed::Note { text })?;
    }
    let case = wanted.case.clone();
    let mut ready = false;
    let mut asked = first;
    loop {
        // A case that was prepared without the adapter has nothing for it.
        let fits =
            asked.wanted.case == case && (gpu.is_some() || asked.wanted.setting.form != Form::Gpu);
        if !fits {
            return Ok(Next::Asked(Box::new(asked)));
        }
        let request = asked.request;
        let shown = show_setting(inbox, gpu, &*prepared, asked, &mut ready);
        let next = match shown {
            Ok(next) => next,
            Err(Trouble::Setting(error)) => fail(inbox, request, error)?,
            Err(Trouble::Output(error)) => return Err(error.into()),
        };
        match next {
            Next::Asked(next) => asked = *next,
            other => return Ok(other),
        }
    }
}

/// What ends the showing of a setting before another is asked for.
enum Trouble {
    /// It cannot be shown, or no longer: the next may.
    Setting(SuiteError),
    /// Nobody can be told.
    Output(io::Error),
}

impl From<SuiteError> for Trouble {
    fn from(error: SuiteError) -> Self {
        Self::Setting(error)
    }
}

impl From<io::Error> for Trouble {
    fn from(error: io::Error) -> Self {
        Self::Output(error)
    }
}

/// Checks a setting, shows it and runs its frames until something else is asked for, which it
/// returns. A request for the same again is answered with what is there.
fn show_setting(
    inbox: &Inbox,
    gpu: Option<&Gpu>,
    prepared: &dyn Prepared,
    asked: Asked,
    ready: &mut bool,
) -> Result<Next<Asked>, Trouble> {
    let Asked { mut request, wanted } = asked;
    stage(&wanted, "check")?;
    let mut subject = prepared.subject(&wanted.setting)?;
    if !std::mem::replace(ready, true) {
        let (case, truth) = (wanted.case.name(), prepared.facts().truth);
        tell(&Feed::Ready { case, truth, frames: subject.frames() })?;
    }
    let checked = subject.check()?;
    let picture = if wanted.problem.spec().pictures { subject.picture()? } else { None };
    if let Some(gpu) = gpu {
        gpu.check().map_err(SuiteError::from)?;
    }
    loop {
        tell(&answer(request, &checked))?;
        if let Some(picture) = &picture {
            tell(&feed::picture(request, picture))?;
        }
        let next = match wanted.setting.form {
            // An oracle, written for reading: its time would say nothing.
            Form::Reference => ask(inbox, None)?,
            Form::Cpu | Form::Gpu => run_frames(inbox, request, &mut *subject)?,
        };
        match next {
            Next::Asked(again) if again.wanted.is(&wanted) => request = again.request,
            next => return Ok(next),
        }
    }
}

fn stage(wanted: &Wanted, stage: &str) -> io::Result<()> {
    tell(&Feed::Stage {
        what: wanted.case.name(),
        setting: wanted.setting.to_string(),
        stage: stage.into(),
    })
}

/// The outcome of a check. JSON has no word for a value that is not finite: it is a violation.
fn answer(request: u64, checked: &Checked) -> Feed {
    let mut violations = checked.violations.clone();
    let mut errors = checked.errors.clone();
    errors.retain(|metric, value| {
        if !value.is_finite() {
            violations.push(format!("error.{metric} is {value}"));
        }
        value.is_finite()
    });
    Feed::Checked {
        request,
        errors,
        counters: checked.counters.clone(),
        memory_bytes: checked.memory_bytes,
        violations,
    }
}

/// Runs the path over and over, one frame at a time with rests between, until something is asked.
fn run_frames(
    inbox: &Inbox,
    request: u64,
    subject: &mut dyn Subject,
) -> Result<Next<Asked>, Trouble> {
    let path = subject.frames().max(1);
    let mut told = 0_usize;
    loop {
        let begun = Instant::now();
        if told.is_multiple_of(path) {
            subject.reset()?;
        }
        let (clock, ns) = time(&subject.frame(told % path)?);
        tell(&Feed::Frame { request, ns, clock: clock.into() })?;
        told = told.wrapping_add(1);
        match ask(inbox, Some(rest(begun.elapsed(), told)))? {
            Next::Nothing => {}
            next => return Ok(next),
        }
    }
}

/// The device's time where it is sound, as in records.
fn time(frame: &FrameTime) -> (&'static str, u64) {
    frame.gpu_ns.map_or(("wall", frame.wall_ns), |ns| ("gpu", ns))
}

/// How long to rest after a frame: up to the pace, and as long as the frame took, so that at least
/// half of the machine stays free.
fn rest(took: Duration, told: usize) -> Duration {
    let pace = if told < LIVELY_FRAMES { LIVELY } else { IDLE };
    pace.saturating_sub(took).max(took)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_rest_to_the_pace_and_at_least_as_long_as_they_took() {
        let ms = Duration::from_millis;
        assert_eq!(rest(ms(3), 1), ms(30));
        assert_eq!(rest(ms(20), 1), ms(20));
        assert_eq!(rest(ms(700), 1), ms(700));
        assert_eq!(rest(ms(3), LIVELY_FRAMES), ms(497));
    }

    #[test]
    fn a_value_that_is_not_finite_is_told_as_a_violation() {
        let mut checked = Checked::default();
        checked.errors.insert("a".into(), 0.5);
        checked.errors.insert("b".into(), f64::NAN);
        let told = answer(7, &checked);
        let read = dapple_records::FeedLine::parse(&told.to_line()).unwrap();
        assert_eq!(read, Some(dapple_records::FeedLine::Event(told.clone())));
        let Feed::Checked { errors, violations, .. } = told else { panic!("{told:?}") };
        assert_eq!(errors.len(), 1);
        assert_eq!(violations, ["error.b is NaN"]);
    }
}
