//! The image of a point, made by the command that its record holds.

use crate::{
    msg::{Effect, JobId, Msg},
    plot::picture::Triplet,
    screens::World,
};
use dapple_records::{Feed, FeedLine};

/// Lines of the child's own words that are kept.
const LAST_WORDS: usize = 6;

/// A child at work on a point, and what came of it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Image {
    job: Option<JobId>,
    /// The command shown, empty for none.
    pub command: String,
    /// Truth, result and error.
    pub picture: Option<Triplet>,
    /// What the child said.
    pub said: Vec<String>,
    /// How it ended, in words.
    pub ended: Option<String>,
}

impl Image {
    /// Starts the command of a record, for its pictures. One that is at work is stopped.
    pub fn start(&mut self, command: &str, world: &mut World) -> Vec<Effect> {
        let mut effects = self.stop();
        self.command = command.into();
        let Some(arguments) = arguments(command) else {
            self.ended = Some("the record's command cannot be read".into());
            return effects;
        };
        let job = world.jobs.reserve();
        self.job = Some(job);
        effects.push(Effect::Start { job, arguments, input: false });
        effects
    }

    /// Stops the child and forgets everything.
    pub fn stop(&mut self) -> Vec<Effect> {
        let job = self.job.take();
        *self = Self::default();
        job.map(Effect::Stop).into_iter().collect()
    }

    /// Whether the child is at work.
    pub fn works(&self) -> bool {
        self.job.is_some()
    }

    /// Takes in what the child says.
    pub fn hear(&mut self, msg: &Msg) {
        match msg {
            Msg::Heard { job, line } if Some(*job) == self.job => match &**line {
                FeedLine::Event(Feed::Picture { width, height, truth, result, .. }) => {
                    match Triplet::decode(*width, *height, truth, result) {
                        Ok(picture) => self.picture = Some(picture),
                        Err(reason) => self.say(format!("the picture: {reason}")),
                    }
                }
                FeedLine::Event(Feed::Failed { reason, .. }) => self.say(reason.clone()),
                FeedLine::Event(Feed::Note { text }) => self.say(text.clone()),
                _ => {}
            },
            Msg::Grumbled { job, text } if Some(*job) == self.job => self.say(text.clone()),
            Msg::Ended { job, code, how } if Some(*job) == self.job => {
                self.job = None;
                // 1 says that the point failed, which the record says too.
                self.ended = (!matches!(code, Some(0 | 1))).then(|| how.clone());
                if self.picture.is_none() && self.ended.is_none() {
                    self.say("there is no picture of this point".into());
                }
            }
            _ => {}
        }
    }

    fn say(&mut self, text: String) {
        if self.said.len() == LAST_WORDS {
            self.said.remove(0);
        }
        self.said.push(text);
    }
}

/// The program's arguments of a command as a shell would take it, told to speak in JSON lines.
fn arguments(command: &str) -> Option<Vec<String>> {
    let mut words = shlex::split(command)?.into_iter();
    words.next().filter(|program| program == "dapple")?;
    let mut words: Vec<String> = words.collect();
    // A record is no script: nothing else is started from it.
    (words.first()? == "stress").then(|| {
        words.push("--feed".into());
        words
    })
}

#[cfg(test)]
mod tests {
    use super::arguments;

    #[test]
    fn only_a_stress_command_of_this_program_is_started() {
        let words = arguments("dapple stress p --axis a --param 'x=1 2' --at 1e-6").unwrap();
        assert_eq!(
            words,
            ["stress", "p", "--axis", "a", "--param", "x=1 2", "--at", "1e-6", "--feed"]
        );
        for bad in ["", "dapple", "rm -rf x", "dapple measure x", "dapple stress 'open"] {
            assert_eq!(arguments(bad), None, "{bad}");
        }
    }
}
