//! Answers that count from the next frame on.

use super::{
    support::{Way, asks, lost, path, town},
    verdict::{figure, judged},
};
use crate::{
    SuiteError,
    claims::{Claim, ClaimContext, Judged, Verdict},
};
use dapple_occlusion::camera::{Results, Settings, Technique};

pub fn claims() -> Vec<Claim> {
    vec![Claim {
        id: "conte-F2.4",
        statement: "Answers that come too late for a frame can be used in the next one, and \
                    visibility stays conservative",
        place: "Conte 2018, figure 2.4 and section 2.2.1",
        method: "CHC and CHC++ that never wait and use every answer in the next frame, along three \
                 paths through the generated city at their own speed and four and eight times as \
                 fast: pixels that lie deeper than when everything is drawn. One lost pixel is a \
                 contradiction. The same with answers of the frame itself must lose none, or the \
                 measuring is at fault and nothing is decided",
        judge: Box::new(late),
    }]
}

/// Pixels lost by answers of the next frame, and of the frame itself.
fn conservative(next: u64, same: u64) -> Verdict {
    match (next, same) {
        (_, 1..) => Verdict::Open,
        (0, 0) => Verdict::Reproduced,
        _ => Verdict::Refuted,
    }
}

fn late(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let city = town("city", &[])?;
    let (mut figures, mut next, mut same, mut worst) = (Vec::new(), 0, 0, 0.0_f64);
    for (name, step) in [
        ("street", 1),
        ("street", 4),
        ("turn", 1),
        ("turn", 4),
        ("tour", 1),
        ("tour", 4),
        ("tour", 8),
    ] {
        let path = path(&city, name, if step == 1 { 60 } else { 15 }, step)?;
        for technique in [Technique::Chc, Technique::ChcPlusPlus] {
            let way = Settings { results: Results::NextFrame, ..Settings::new(technique) };
            let shown = path.shown(&Way::Asks(way))?;
            let pixels = |lost: u64| {
                let all: usize = path.full.iter().map(|f| f.depth.len()).sum();
                lost as f64 / all.max(1) as f64 * 100.0
            };
            let (all, most) = (lost(&shown), shown.iter().map(|s| s.lost).max().unwrap_or(0));
            let what = format!("{name} at {step} x, {}", technique.name());
            figures.push(figure(format!("{what}: pixels lost"), pixels(all), "%"));
            let in_one = most as f64 / path.full[0].depth.len().max(1) as f64 * 100.0;
            figures.push(figure(format!("{what}: in the worst frame"), in_one, "%"));
            worst = worst.max(in_one);
            next += all;
            same += lost(&path.shown(&asks(technique))?);
        }
    }
    figures.push(figure("answers of the frame itself: pixels lost", same as f64, ""));
    let because = format!(
        "{next} pixels are missing, at most {worst:.1} % of a frame; {same} with answers of the \
         frame itself"
    );
    Ok(judged(conservative(next, same), because, figures))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lost_pixel_contradicts_if_the_measuring_holds() {
        assert_eq!(conservative(0, 0), Verdict::Reproduced);
        assert_eq!(conservative(1, 0), Verdict::Refuted);
        assert_eq!(conservative(1, 1), Verdict::Open);
        assert_eq!(conservative(0, 1), Verdict::Open);
    }
}
