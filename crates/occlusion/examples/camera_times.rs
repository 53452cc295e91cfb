//! What the techniques that walk a hierarchy cost along a walk down a city's street, as tables: where
//! a frame's time goes, what a node costs as the city grows, how often a frame waits, and how many
//! queries cull nothing. Build it optimised; `--example camera_times -- city city_15` names the
//! cities, the first of which the last two tables are of; `--walk` times the walk alone.
//!
//! The walk alone is timed by playing recorded answers back to it, without drawing. Every figure is
//! the least of several runs over the path (the walk's: of each frame), divided by its frames. The last column of the
//! first table is a hash of all that was drawn, counted and remembered: it may not change with speed.
#![allow(clippy::print_stdout, reason = "a program that prints tables")]
#![allow(clippy::unwrap_used, reason = "generated cities and fixed settings are sound")]

use dapple_occlusion::OcclusionError;
use dapple_occlusion::camera::software::Fast;
use dapple_occlusion::camera::{
    Bounds, Frame, Latency, Objects, Query, Readiness, Renderer, Settings, State, Technique, Tree,
    View, Work, city_keys, techniques,
};
use dapple_scene::generate;
use std::collections::VecDeque;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Operations before an answer is there.
const LATENCY: u32 = 64;
const RUNS: usize = 5;
const WALKS: usize = 20;
const SMALL: [u32; 2] = [256, 144];
const LARGE: [u32; 2] = [960, 540];

fn main() {
    let (flags, named): (Vec<String>, _) = std::env::args().skip(1).partition(|a| a == "--walk");
    let runs = if flags.is_empty() { RUNS } else { 0 };
    let names: Vec<String> =
        if named.is_empty() { vec!["city".into(), "city_15".into()] } else { named };
    println!(
        "| city | image | technique | frame ms | begin | draw | ask | walk | nodes | ns a node | ns a visible node | hash |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|---|");
    for name in &names {
        for size in [SMALL, LARGE] {
            let world = World::of(name, size);
            for technique in Technique::ALL {
                phases(&world, name, technique, runs);
            }
        }
    }
    let world = World::of(&names[0], SMALL);
    println!("\n| technique | frames | queries | batches | stalls | wasted | draws |");
    println!("|---|---|---|---|---|---|---|");
    for technique in [Technique::StopAndWait, Technique::Chc, Technique::ChcPlusPlus] {
        by_frames(&world, technique);
    }
    println!("\n| assumed visible | queries | wasted | stalls | draws |\n|---|---|---|---|---|");
    for assumed_visible in [0, 1, 2, 5, 10, 20, 60] {
        let settings = Settings { assumed_visible, ..Settings::new(Technique::ChcPlusPlus) };
        let work = steady(&world, &settings);
        let all: Work = sum(&work);
        let each = |n: u64| n as f64 / work.len() as f64;
        println!(
            "| {assumed_visible} | {:.1} | {:.1} | {:.2} | {:.0} |",
            each(all.queries),
            each(all.wasted),
            each(all.stalls),
            each(all.draws)
        );
    }
}

struct World {
    objects: Arc<Objects>,
    tree: Tree,
    views: Vec<View>,
}

impl World {
    fn of(name: &str, [width, height]: [u32; 2]) -> Self {
        let made = generate::city_of(name, 1).unwrap().scene();
        let (scene, parts) = (made.scene, made.parts);
        let (objects, owners) = Objects::from_scene(&scene, 128).unwrap();
        let keys = city_keys(&parts, &scene, &owners, &objects);
        let street = scene.paths.iter().find(|p| p.name == "street").unwrap();
        let near_m = 1e-4 * scene.bounds().radius();
        let view = |i| View::new(&street.camera(i)?, &objects, width, height, near_m).ok();
        let views = (0..street.frames).filter_map(view).collect();
        Self { tree: Tree::by_keys(&objects, &keys).unwrap(), objects: Arc::new(objects), views }
    }

    fn fast(&self) -> Fast {
        Fast::new(self.objects.clone(), Readiness::Modelled(LATENCY)).unwrap()
    }

    /// Plays the path once from nothing known, and hands on every frame.
    fn play(
        &self,
        settings: &Settings,
        renderer: &mut dyn Renderer,
        state: &mut State,
        out: &mut Frame,
        mut each: impl FnMut(&Frame, &State),
    ) {
        for view in &self.views {
            let (objects, tree) = (&self.objects, &self.tree);
            techniques::frame(settings, objects, tree, view, state, renderer, out).unwrap();
            each(out, state);
        }
        state.reset(renderer).unwrap();
    }
}

fn phases(world: &World, name: &str, technique: Technique, runs: usize) {
    let settings = Settings::new(technique);
    let (mut state, mut out) = (State::new(&world.tree), Frame::default());
    let mut hasher = DefaultHasher::new();
    let (mut nodes, mut visible) = (0, 0);
    let mut timed = Timed::new(world.fast());
    world.play(&settings, &mut timed, &mut state, &mut out, |frame, state| {
        frame.drawn.hash(&mut hasher);
        format!("{:?} {:?} {:?}", frame.work, state.nodes(), state.coverage()).hash(&mut hasher);
        nodes += frame.work.nodes;
        visible += state.nodes().iter().filter(|n| n.visible == state.frames()).count() as u64;
    });
    let mut playback = Playback::of(std::mem::take(&mut timed.answers));
    let mut least = [if runs == 0 { Duration::ZERO } else { Duration::MAX }; 4];
    for _ in 0..runs {
        timed.forget();
        let start = Instant::now();
        world.play(&settings, &mut timed, &mut state, &mut out, |_, _| {});
        let all = start.elapsed();
        let times = [all, timed.begin, timed.draw, timed.ask];
        least = std::array::from_fn(|i| least[i].min(times[i]));
    }
    // Short enough that something else gets in between now and then: the least is a frame's.
    let mut walks = vec![Duration::MAX; world.views.len()];
    for _ in 0..WALKS {
        playback.rewind();
        let (mut start, mut index) = (Instant::now(), 0);
        world.play(&settings, &mut playback, &mut state, &mut out, |_, _| {
            walks[index] = walks[index].min(start.elapsed());
            (start, index) = (Instant::now(), index + 1);
        });
    }
    let walk: Duration = walks.iter().sum();
    let frames = world.views.len() as f64;
    let ms = |t: Duration| t.as_secs_f64() * 1e3 / frames;
    let ([all, begin, draw, ask], walk_ms) = (least.map(ms), ms(walk));
    let ns = |count: u64| match count {
        0 => "-".to_owned(),
        n => format!("{:.0}", walk.as_secs_f64() * 1e9 / n as f64),
    };
    let [width, height] = [world.views[0].width, world.views[0].height];
    println!(
        "| {name} | {width}x{height} | {} | {all:.2} | {begin:.2} | {draw:.2} | {ask:.2} | {walk_ms:.3} | {:.0} | {} | {} | {:016x} |",
        technique.name(),
        nodes as f64 / frames,
        ns(nodes),
        ns(visible),
        hasher.finish()
    );
}

fn by_frames(world: &World, technique: Technique) {
    let work = steady(world, &Settings::new(technique));
    for frames in [0..1, 1..2, 2..10, 10..30, 30..work.len()] {
        let all = sum(&work[frames.clone()]);
        let each = |n: u64| n as f64 / frames.len() as f64;
        println!(
            "| {} | {}..{} | {:.1} | {:.1} | {:.2} | {:.1} | {:.0} |",
            technique.name(),
            frames.start,
            frames.end,
            each(all.queries),
            each(all.batches),
            each(all.stalls),
            each(all.wasted),
            each(all.draws)
        );
    }
}

fn steady(world: &World, settings: &Settings) -> Vec<Work> {
    let mut work = Vec::new();
    let mut state = State::new(&world.tree);
    let each = |frame: &Frame, _: &State| work.push(frame.work);
    world.play(settings, &mut world.fast(), &mut state, &mut Frame::default(), each);
    work
}

fn sum(work: &[Work]) -> Work {
    work.iter().fold(Work::default(), |mut all, &one| {
        all += one;
        all
    })
}

/// Adds up the time of each kind of call, and keeps all answers.
struct Timed {
    inner: Fast,
    begin: Duration,
    draw: Duration,
    ask: Duration,
    answers: Vec<u32>,
}

impl Timed {
    fn new(inner: Fast) -> Self {
        let zero = Duration::ZERO;
        Self { inner, begin: zero, draw: zero, ask: zero, answers: Vec::new() }
    }

    fn forget(&mut self) {
        (self.begin, self.draw, self.ask) = Default::default();
        self.answers.clear();
    }
}

impl Renderer for Timed {
    fn begin(&mut self, view: &View) -> Result<(), OcclusionError> {
        let start = Instant::now();
        self.inner.begin(view)?;
        self.begin += start.elapsed();
        Ok(())
    }

    fn draw(&mut self, objects: &[u32]) -> Result<(), OcclusionError> {
        let start = Instant::now();
        self.inner.draw(objects)?;
        self.draw += start.elapsed();
        Ok(())
    }

    fn ask(&mut self, boxes: &[Bounds], queries: &[Query]) -> Result<(), OcclusionError> {
        let start = Instant::now();
        self.inner.ask(boxes, queries)?;
        self.ask += start.elapsed();
        Ok(())
    }

    fn ready(&mut self) -> Result<bool, OcclusionError> {
        self.inner.ready()
    }

    fn collect(&mut self, counts: &mut Vec<u32>) -> Result<(), OcclusionError> {
        let given = counts.len();
        self.inner.collect(counts)?;
        self.answers.extend_from_slice(&counts[given..]);
        Ok(())
    }

    fn end(&mut self) -> Result<(), OcclusionError> {
        self.inner.end()
    }
}

/// Draws nothing and answers as recorded, by the same clock.
struct Playback {
    answers: Vec<u32>,
    next: usize,
    clock: Latency,
    batches: VecDeque<usize>,
}

impl Playback {
    fn of(answers: Vec<u32>) -> Self {
        Self { answers, next: 0, clock: Latency::default(), batches: VecDeque::new() }
    }

    fn rewind(&mut self) {
        (self.next, self.clock) = (0, Latency::default());
        self.batches.clear();
    }
}

impl Renderer for Playback {
    fn begin(&mut self, _: &View) -> Result<(), OcclusionError> {
        Ok(())
    }

    fn draw(&mut self, objects: &[u32]) -> Result<(), OcclusionError> {
        self.clock.drew(objects.len());
        Ok(())
    }

    fn ask(&mut self, boxes: &[Bounds], queries: &[Query]) -> Result<(), OcclusionError> {
        self.clock.asked(boxes.len());
        self.batches.push_back(queries.len());
        Ok(())
    }

    fn ready(&mut self) -> Result<bool, OcclusionError> {
        Ok(self.clock.ready(LATENCY))
    }

    fn collect(&mut self, counts: &mut Vec<u32>) -> Result<(), OcclusionError> {
        let queries = self.batches.pop_front().unwrap();
        self.clock.collected(LATENCY);
        counts.extend_from_slice(&self.answers[self.next..self.next + queries]);
        self.next += queries;
        Ok(())
    }

    fn end(&mut self) -> Result<(), OcclusionError> {
        Ok(())
    }
}
