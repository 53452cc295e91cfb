//! What lighting pixels costs, by point of view.

use super::{
    support::{ABOUT, COARSE, VIEWS, night, pipeline, prepared},
    verdict::{figure, judged},
};
use crate::{
    SuiteError,
    claims::{Claim, Judged, Verdict},
};
use dapple_many_lights::Shaded;
use serde_json::json;

pub fn claims() -> Vec<Claim> {
    vec![Claim {
        id: "conte-H5.10",
        statement: "Shading costs what buildings cover times the lists of what they show, so that the \
                    long street can be cheaper than the close-ended one",
        place: "Conte 2018, section 5.4 and table 5.VI: 29.7 against 38.4 ms",
        method: "6 x 6 city, 96 x 72, R4 at T = 1/1020: nodes visited in a frame, and the product of \
                 pixels that show walls and the mean nodes of their lists, by view. Cost \
                 follows where the street's nodes over the close-ended street's are within a factor of \
                 1.5 of the products' ratio: else contradicted. Met if the street also visits fewer; \
                 open where it does not: then these views do not show it",
        judge: Box::new(|_| shading()),
    }]
}

/// Nodes visited and product, of the close-ended street and of the long one.
fn follows(close_ended: [f64; 2], street: [f64; 2]) -> Verdict {
    let [cost, product] = [0, 1].map(|at| street[at] / close_ended[at]);
    if !(1.0 / ABOUT..=ABOUT).contains(&(cost / product)) {
        Verdict::Refuted
    } else if cost < 1.0 {
        Verdict::Reproduced
    } else {
        Verdict::Open
    }
}

fn shading() -> Result<Judged, SuiteError> {
    let (mut figures, mut all) = (Vec::new(), Vec::new());
    for view in VIEWS {
        let case = prepared("city", view, &[])?;
        let mut pipeline = pipeline(&case, &night(&[("cut", json!(COARSE))])?)?;
        pipeline.frame(0, true)?;
        let mut shaded = Shaded::default();
        pipeline.read(&mut shaded)?;
        let starts = pipeline.front().starts();
        let points = &case.night().town.world(false).frames[0].points;
        let walls = points.iter().filter(|p| p.is_there() && p.normal.y.abs() < 1e-3);
        let lists: Vec<f64> = walls.map(|p| starts.of(p.object).len() as f64).collect();
        let product: f64 = lists.iter().sum();
        let covered = lists.len() as f64 / points.len().max(1) as f64;
        figures.extend([
            figure(format!("{view}: nodes visited"), shaded.work.visits as f64, ""),
            figure(format!("{view}: covered by walls"), covered, ""),
            figure(
                format!("{view}: nodes of a wall's list"),
                product / lists.len().max(1) as f64,
                "",
            ),
        ]);
        all.push([shaded.work.visits as f64, product]);
    }
    let [b, c] = [all[1], all[2]];
    let because = format!(
        "the street visits {:.2} times the nodes of the close-ended street; its walls times lists are \
         {:.2} times",
        c[0] / b[0].max(1.0),
        c[1] / b[1].max(1.0)
    );
    Ok(judged(follows(b, c), because, figures))
}

#[cfg(test)]
mod tests {
    use super::*;
    use Verdict::{Open, Refuted, Reproduced};

    #[test]
    fn cost_follows_or_not() {
        assert_eq!(follows([2.0, 2.0], [1.0, 1.0]), Reproduced);
        assert_eq!(follows([2.0, 2.0], [3.0, 3.0]), Open);
        assert_eq!(follows([2.0, 2.0], [3.0, 1.0]), Refuted);
        assert_eq!(follows([2.0, 2.0], [1.0, 3.0]), Refuted);
        assert_eq!(follows([2.0, 2.0], [f64::NAN, 3.0]), Refuted);
    }
}
