//! What the source's tables say of the same thing in several places.

use super::{
    support::{THESIS_SIZE, asks, chc_plus_plus, path_of, town},
    verdict::{all_of, figure, judged},
};
use crate::{
    SuiteError,
    claims::{Claim, ClaimContext, Judged, Verdict},
};
use dapple_occlusion::camera::Technique;

/// Triangles and milliseconds of the close-ended street by occlusion queries: tables 5.I and 5.III.
const CLOSE_ENDED: [(f64, f64); 2] = [(1156.0, 1.7), (2312.0, 1.1)];

/// Triangles of a storey.
const STOREY: u32 = 16;

/// Most storeys of a building.
const STOREYS: u32 = 7;

pub fn claims() -> Vec<Claim> {
    vec![
        Claim {
            id: "conte-T5.I-III",
            statement: "Tables 5.I and 5.III give what is seen of the close-ended street, and what \
                        drawing it takes, as the same numbers",
            place: "Conte 2018, tables 5.I and 5.III",
            method: "triangles and times of the two tables, by each other. Two runs of one \
                     conservative technique differ by what it draws for nothing: within a factor \
                     of 1.5 would be agreement. Ours beside them: stop-and-wait and CHC++ at that \
                     view, 1200 x 900",
            judge: Box::new(close_ended),
        },
        Claim {
            id: "conte-T5.I-facade",
            statement: "A single facade of a building of 1 to 7 storeys, 16 triangles each, shows \
                        160 triangles",
            place: "Conte 2018, section 5.1 and table 5.I",
            method: "160 over 16 must be a number of storeys that a facade may have. Ours beside \
                     it: objects and triangles that own a pixel of the view, 1200 x 900",
            judge: Box::new(facade),
        },
    ]
}

/// Ratios of one table to the other.
fn agree(ratios: &[f64]) -> Verdict {
    // Written so that a NaN is refused.
    let close = |r: &f64| (1.0 / 1.5..=1.5).contains(r);
    if !ratios.is_empty() && ratios.iter().all(close) {
        Verdict::Reproduced
    } else {
        Verdict::Refuted
    }
}

fn close_ended(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let [(few, slow), (many, fast)] = CLOSE_ENDED;
    let mut figures = vec![
        figure("triangles, table 5.III over 5.I", many / few, ""),
        figure("first pass, table 5.III over 5.I", fast / slow, ""),
        figure("storeys of 16 triangles that 2,312 are", many / f64::from(STOREY), ""),
    ];
    let path = path_of(&town("city", &[])?, "close_ended", 8, 1, THESIS_SIZE)?;
    for (name, way) in
        [("stop-and-wait", asks(Technique::StopAndWait)), ("CHC++", chc_plus_plus(|_| {}))]
    {
        let shown = path.shown(&way)?;
        let last = shown.last().map_or(0, |s| s.work.triangles);
        figures.push(figure(format!("{name}: triangles drawn"), last as f64, ""));
    }
    let owning = path.full.last().map_or(0, super::support::Full::owning);
    figures.push(figure("triangles that own a pixel", owning as f64, ""));
    let because = format!(
        "one table has exactly {:.0} times the triangles of the other in {:.2} of the time: perhaps \
         one counts quads",
        many / few,
        fast / slow
    );
    Ok(judged(agree(&[many / few, fast / slow]), because, figures))
}

fn storeys(triangles: u32) -> Verdict {
    let whole = triangles.is_multiple_of(STOREY);
    let storeys = triangles / STOREY;
    if whole && (1..=STOREYS).contains(&storeys) { Verdict::Reproduced } else { Verdict::Refuted }
}

fn facade(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let path = path_of(&town("city", &[])?, "facade", 8, 1, THESIS_SIZE)?;
    let full = &path.full[0];
    let seen = full.pixels.iter().filter(|p| **p > 0).count();
    let figures = vec![
        figure("storeys that 160 triangles are", 160.0 / f64::from(STOREY), ""),
        figure("most storeys of a building", f64::from(STOREYS), ""),
        figure("objects that own a pixel", seen as f64, ""),
        figure("triangles that own a pixel", full.owning() as f64, ""),
    ];
    let because = "160 triangles are ten storeys, where the text has at most seven".to_string();
    Ok(judged(all_of(&[storeys(160)]), because, figures))
}

#[cfg(test)]
mod tests {
    use super::*;
    use Verdict::{Refuted, Reproduced};

    #[test]
    fn tables_agree_or_not() {
        assert_eq!(agree(&[1.0, 1.4]), Reproduced);
        assert_eq!(agree(&[2.0, 1.0]), Refuted);
        assert_eq!(agree(&[0.5]), Refuted);
        assert_eq!(agree(&[f64::NAN]), Refuted);
        assert_eq!(agree(&[]), Refuted);
    }

    #[test]
    fn facades_are_whole_storeys() {
        assert_eq!(storeys(112), Reproduced);
        assert_eq!(storeys(160), Refuted);
        assert_eq!(storeys(100), Refuted);
        assert_eq!(storeys(0), Refuted);
    }
}
