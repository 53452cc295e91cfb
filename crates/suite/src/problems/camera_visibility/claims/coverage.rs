//! H4.8: the pixels that answers give, against those that objects own in the end.

use super::{
    support::{Path, Way, asks, chc_plus_plus, path, town},
    verdict::{figure, judged},
};
use crate::{
    SuiteError,
    claims::{Claim, ClaimContext, Figure, Judged, Verdict},
};
use dapple_occlusion::camera::Technique;

pub fn claims() -> Vec<Claim> {
    vec![
        Claim {
            id: "conte-H4.8",
            statement: "The pixels that an occlusion query counts are an upper estimate of those \
                        that the object covers in the final image",
            place: "Conte 2018, section 4.1",
            method: "stop-and-wait and CHC, which ask about every visible leaf in every frame, \
                     along three paths through the generated city, 256 x 144: stored count of every \
                     leaf that owns a pixel against the pixels it owns. One below is a \
                     contradiction. A box asked before later draws hide it counts too much; the sum \
                     over the pixels owned stands beside it",
            judge: Box::new(fresh),
        },
        Claim {
            id: "conte-H4.8-kept",
            statement: "The count kept with a node stays an upper estimate in frames in which the \
                        technique does not ask about it again",
            place: "Conte 2018, sections 4.1 and 5.2.1: CHC++, whose counts are kept",
            method: "the same of CHC++ with the count of the latest answer, assumed visible for 0, \
                     5, 20 and 50 frames. One below is a contradiction: a camera that nears an \
                     object makes it cover more than it was answered",
            judge: Box::new(kept),
        },
    ]
}

/// Stored counts against owned pixels, over leaves and frames.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Counted {
    /// Leaves and frames with pixels.
    owners: u64,
    /// Those whose stored count is less.
    below: u64,
    /// Pixels by which it is less.
    short: u64,
    stored: u64,
    owned: u64,
}

fn counted(path: &Path, way: &Way) -> Result<Counted, SuiteError> {
    let mut sums = Counted::default();
    path.walk(way, |now| {
        let pixels = &path.full[now.index].pixels;
        let tree = &path.town.tree;
        for (index, node) in tree.nodes.iter().enumerate().filter(|(_, n)| n.children.is_empty()) {
            let objects = tree.objects_of(index as u32).iter();
            let owned: u64 = objects.map(|o| u64::from(pixels[*o as usize])).sum();
            if owned == 0 || node.objects.is_empty() {
                continue;
            }
            let stored = u64::from(now.state.coverage()[index]);
            sums.owners += 1;
            sums.below += u64::from(stored < owned);
            sums.short += owned.saturating_sub(stored);
            sums.stored += stored;
            sums.owned += owned;
        }
        Ok(())
    })?;
    Ok(sums)
}

fn upper(cases: &[Counted]) -> Verdict {
    if cases.is_empty() || cases.iter().any(|c| c.owners == 0) {
        Verdict::Open
    } else if cases.iter().all(|c| c.below == 0) {
        Verdict::Reproduced
    } else {
        Verdict::Refuted
    }
}

fn judge(ways: &[(String, Way)]) -> Result<Judged, SuiteError> {
    let city = town("city", &[])?;
    let (mut figures, mut all): (Vec<Figure>, Vec<Counted>) = Default::default();
    for view in ["street", "turn", "tour"] {
        let path = path(&city, view, 24, if view == "tour" { 5 } else { 1 })?;
        for (name, way) in ways {
            let sums = counted(&path, way)?;
            let what = format!("{name}, {view}");
            let share = sums.below as f64 / sums.owners.max(1) as f64;
            let short = sums.short as f64 / sums.owned.max(1) as f64;
            let over = sums.stored as f64 / sums.owned.max(1) as f64;
            figures.push(figure(format!("{what}: leaves counted too few"), share * 100.0, "%"));
            figures.push(figure(format!("{what}: pixels not counted"), short * 100.0, "%"));
            figures.push(figure(format!("{what}: counted over owned"), over, ""));
            all.push(sums);
        }
    }
    let below: u64 = all.iter().map(|c| c.below).sum();
    let owners: u64 = all.iter().map(|c| c.owners).sum();
    let because = format!("{below} of {owners} counts are below the pixels owned");
    Ok(judged(upper(&all), because, figures))
}

fn fresh(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let ways = [Technique::StopAndWait, Technique::Chc];
    judge(&ways.map(|t| (t.name().to_string(), asks(t))))
}

fn kept(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let way = |frames| {
        let way = chc_plus_plus(|s| s.assumed_visible = frames);
        (format!("{frames} frames assumed visible"), way)
    };
    judge(&[0, 5, 20, 50].map(way))
}

#[cfg(test)]
mod tests {
    use super::*;
    use Verdict::{Open, Refuted, Reproduced};

    #[test]
    fn one_count_below_contradicts() {
        let good = Counted { owners: 9, stored: 20, owned: 10, ..Counted::default() };
        assert_eq!(upper(&[good, good]), Reproduced);
        assert_eq!(upper(&[good, Counted { below: 1, ..good }]), Refuted);
        assert_eq!(upper(&[good, Counted { owners: 0, ..good }]), Open);
        assert_eq!(upper(&[]), Open);
    }
}
