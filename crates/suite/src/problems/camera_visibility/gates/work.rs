//! Counters of techniques beside each other, and what each option changes.

use super::{asked::Asked, input, play, questions};
use crate::{
    SuiteError,
    problems::camera_visibility::case::VisibilityCase,
    verify::{About, Gate, GateContext, Tally, gate},
};
use dapple_occlusion::camera::{Settings, Technique, TightBounds, Work};

/// Worlds whose work is summed.
const WORLDS: u32 = 4;

/// Operations until an answer is there.
const LATENCY: u32 = 20;

pub fn gates() -> Vec<Gate> {
    let about = |technique: Technique, name, statement, fault| About {
        technique: technique.name(),
        name,
        statement,
        fault,
    };
    vec![
        gate(
            about(
                Technique::Frustum,
                "row 7 fewer triangles",
                "the frustum's objects are fewer than all, and show the same",
                "everything is drawn",
            ),
            |context, faulty| {
                let first = if faulty { Technique::None } else { Technique::Frustum };
                less(context, Settings::new(first), Technique::None, |work| work.triangles)
            },
        ),
        gate(
            about(
                Technique::StopAndWait,
                "row 8 stalls",
                "every query is a batch and a stall",
                "answers are looked at later, as CHC does",
            ),
            stalls,
        ),
        gate(
            about(
                Technique::Chc,
                "row 9 fewer stalls",
                "along a path that walks CHC stalls less often than who waits for every answer",
                "every answer is waited for",
            ),
            |context, faulty| {
                let first = if faulty { Technique::StopAndWait } else { Technique::Chc };
                less(context, Settings::new(first), Technique::StopAndWait, |work| work.stalls)
            },
        ),
        gate(
            about(
                Technique::ChcPlusPlus,
                "row 10 fewer batches",
                "CHC++ asks in fewer batches than CHC",
                "batches of one and no option: what CHC does",
            ),
            |context, faulty| {
                let settings = if faulty { bare() } else { full() };
                less(context, settings, Technique::Chc, |work| work.batches)
            },
        ),
        gate(
            about(
                Technique::ChcPlusPlus,
                "row 10 options",
                "each option by itself changes what is asked, and no pixel",
                "the option is not switched",
            ),
            options,
        ),
        gate(
            about(
                Technique::ChcPlusPlus,
                "row 10 origin",
                "with batches of one and no option CHC++ does what CHC does",
                "leaves in sight are not asked for two frames",
            ),
            origin,
        ),
    ]
}

fn full() -> Settings {
    Settings::new(Technique::ChcPlusPlus)
}

/// Nothing that CHC has not got.
fn bare() -> Settings {
    Settings {
        batch: 1,
        assumed_visible: 0,
        jitter: false,
        visible_queue: false,
        multiqueries: false,
        tight_bounds: TightBounds::OFF,
        ..full()
    }
}

/// Work along the whole path, and pixels that are wrong.
fn work(case: &VisibilityCase<'_>, settings: &Settings) -> Result<(Work, usize), SuiteError> {
    let mut renderer = Asked::new(case.shared_objects(), LATENCY, None)?;
    let (mut sum, mut wrong) = (Work::default(), 0);
    questions::along(case, settings, &mut renderer, 0..case.views().len(), |index, r, out, _| {
        sum += out.work;
        wrong += questions::wrong(case, index, r)?;
        Ok(())
    })?;
    Ok((sum, wrong))
}

/// Over all worlds the first does less than the second by one counter, and shows the same.
fn less(
    context: &GateContext<'_>,
    first: Settings,
    second: Technique,
    counter: fn(&Work) -> u64,
) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    let (mut ours, mut theirs) = (0, 0);
    for number in 0..context.cases.min(WORLDS) {
        let case = input::walk(context.seed, number)?;
        let (work_of_first, wrong) = work(&case, &first)?;
        ours += counter(&work_of_first);
        theirs += counter(&work(&case, &Settings::new(second))?.0);
        tally.within(wrong as f64, 0.0, || format!("pixels differ, world {number}"));
    }
    tally.check(ours < theirs, || format!("{first:?}: {ours}, {}: {theirs}", second.name()));
    Ok(tally)
}

fn stalls(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    let technique = if faulty { Technique::Chc } else { Technique::StopAndWait };
    for number in 0..play::cases(context, WORLDS, faulty) {
        let case = input::case(context.seed, number, None)?;
        let Work { queries, batches, stalls, boxes, .. } =
            work(&case, &Settings::new(technique))?.0;
        let all = [batches, stalls, boxes];
        tally.check(all == [queries; 3], || format!("{queries} queries, {all:?}"));
    }
    Ok(tally)
}

/// Turns an option off.
type Switch = fn(Settings) -> Settings;

fn options(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    let switched: [(&str, Switch); 6] = [
        ("batches", |s| Settings { batch: 1, ..s }),
        ("assumed visibility", |s| Settings { assumed_visible: 0, ..s }),
        ("jitter", |s| Settings { jitter: false, ..s }),
        ("queue of visible leaves", |s| Settings { visible_queue: false, ..s }),
        ("multiqueries", |s| Settings { multiqueries: false, ..s }),
        ("tight bounds", |s| Settings { tight_bounds: TightBounds::OFF, ..s }),
    ];
    let mut changed = [false; 6];
    for number in 0..context.cases.min(WORLDS) {
        let case = input::walk(context.seed, number)?;
        let with = work(&case, &full())?.0;
        for (changed, (name, switch)) in changed.iter_mut().zip(switched) {
            let settings = if faulty { full() } else { switch(full()) };
            let (without, wrong) = work(&case, &settings)?;
            *changed |= with != without;
            tally.within(wrong as f64, 0.0, || format!("without {name}, world {number}"));
        }
    }
    for (changed, (name, _)) in changed.iter().zip(switched) {
        tally.check(*changed, || format!("{name} changes nothing"));
    }
    Ok(tally)
}

fn origin(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for number in 0..play::cases(context, WORLDS, faulty) {
        let case = input::case(context.seed, number, None)?;
        let settings = Settings { assumed_visible: if faulty { 2 } else { 0 }, ..bare() };
        let (ours, theirs) =
            (work(&case, &settings)?.0, work(&case, &Settings::new(Technique::Chc))?.0);
        let counters = |w: Work| [w.nodes, w.queries, w.batches, w.draws, w.triangles];
        tally.check(counters(ours) == counters(theirs), || {
            format!("world {number}: {ours:?}, CHC {theirs:?}")
        });
    }
    Ok(tally)
}
