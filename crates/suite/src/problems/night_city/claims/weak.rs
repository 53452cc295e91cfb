//! What culling weak clusters takes from images.

use super::{
    support::{COARSE, RGB, VIEWS, checked, error, night, pipeline, prepared},
    verdict::{figure, judged, vote},
};
use crate::{
    SuiteError,
    claims::{Claim, Judged},
};
use dapple_many_lights::Shaded;
use serde_json::json;

pub fn claims() -> Vec<Claim> {
    vec![Claim {
        id: "conte-H5.13",
        statement: "Leaving out clusters that give a cell less than a quarter of an RGB step changes no \
                    pixel by more than two steps",
        place: "Conte 2018, section 5.2.2",
        method: "four views of the 6 x 6 city, 96 x 72, R4 at T = 1/25500 in both: greatest difference \
                 of a channel, linear, between images with threshold 1/1020 and with 0. At most 2/255 \
                 is met, view by view. No sum of what is left out is bounded: a thousand clusters of \
                 less than a quarter step each may be left out of one cell. Losses against the truth \
                 (pixels taken apart) stand beside",
        judge: Box::new(|_| changes()),
    }]
}

fn image(view: &str, threshold: f64) -> Result<Shaded, SuiteError> {
    let case = prepared("city", view, &[])?;
    let mut pipeline = pipeline(&case, &night(&[("threshold", json!(threshold))])?)?;
    pipeline.frame(0, true)?;
    let mut shaded = Shaded::default();
    pipeline.read(&mut shaded)?;
    Ok(shaded)
}

fn changes() -> Result<Judged, SuiteError> {
    let (mut figures, mut most) = (Vec::new(), Vec::new());
    for view in VIEWS {
        let [whole, culled] = [image(view, 0.0)?, image(view, COARSE)?];
        let pairs = whole.radiance.iter().zip(&culled.radiance);
        let of = pairs.map(|(a, b)| f64::from((*a - *b).abs().max_element())).fold(0.0, f64::max);
        figures.push(figure(format!("{view}: greatest change"), of / RGB, "1/255"));
        let visits = whole.work.visits as f64 / culled.work.visits.max(1) as f64;
        figures.push(figure(format!("{view}: nodes visited without over with"), visits, "times"));
        most.push(of);
    }
    let case = prepared("city", "close_ended", &[])?;
    let run = checked(&case, "facade-cluster", &[])?;
    figures.push(figure("close_ended: greatest loss", error(&run, "e_irr") / RGB, "1/255"));
    let told: Vec<String> = most.iter().map(|m| format!("{:.2}", m / RGB)).collect();
    let because = format!("pixels change by up to {} / 255", told.join(", "));
    Ok(judged(vote(&are_small(&most)), because, figures))
}

fn are_small(most: &[f64]) -> Vec<bool> {
    most.iter().map(|most| *most <= 2.0 * RGB).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::claims::Verdict::{Open, Refuted, Reproduced};

    #[test]
    fn changes_are_small_or_not() {
        let of = |most: [f64; 2]| vote(&are_small(&most.map(|m| m * RGB)));
        assert_eq!(of([2.0, 0.5]), Reproduced);
        assert_eq!(of([2.1, 0.5]), Open);
        assert_eq!(of([2.1, f64::NAN]), Refuted);
    }
}
