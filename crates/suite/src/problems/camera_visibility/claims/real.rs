//! Whether what holds in generated cities holds in real ones.

use super::{
    support::{
        Shown, asks, chc_plus_plus, hierarchical, lost, masked, mean, open_without_data, path, town,
    },
    verdict::{all_of, figure, judged},
};
use crate::{
    SuiteError,
    claims::{Claim, ClaimContext, Figure, Judged, Verdict},
};
use dapple_occlusion::camera::{Technique, masked::Occluders};

pub fn claims() -> Vec<Claim> {
    let claim = |id, statement, file: &'static str| Claim {
        id,
        statement,
        place: "Conte 2018, section 5.3, of generated cities alone",
        method: "the file's own street path, 24 frames, 256 x 144. Four parts, each as in the \
                 generated city: no technique loses a pixel; queries draw less than half of the \
                 frustum's triangles (18 times less by table 5.III; less than half is what makes \
                 them worth their waits); CHC++ takes less than a third of CHC's batches; and \
                 assuming nodes visible for 20 frames wastes less than half of the queries that \
                 asking every frame does. Open without the file",
        judge: Box::new(move |_: &ClaimContext<'_>| open_without_data(real(file))),
    };
    vec![
        claim(
            "conte-T5.III-delft",
            "Occlusion queries serve a real city of LoD2 solids (Delft) as they serve a generated \
             one",
            "data:city/delft.city.json",
        ),
        claim(
            "conte-T5.III-helsinki",
            "Occlusion queries serve a real city of extruded outlines (Helsinki) as they serve a \
             generated one",
            "data:city/Helsinki.osm.pbf",
        ),
    ]
}

/// What was counted of a city.
#[derive(Clone, Copy, Debug, Default)]
struct City {
    lost: u64,
    /// Triangles by the frustum and by queries.
    triangles: [f64; 2],
    /// Batches of CHC and of CHC++.
    batches: [f64; 2],
    /// Wasted queries assumed visible for no and for 20 frames.
    wasted: [f64; 2],
}

fn serves(city: &City) -> Verdict {
    let less = |[a, b]: [f64; 2], share: f64| match b < share * a {
        true => Verdict::Reproduced,
        false => Verdict::Refuted,
    };
    let kept = if city.lost == 0 { Verdict::Reproduced } else { Verdict::Refuted };
    all_of(&[
        kept,
        less(city.triangles, 0.5),
        less(city.batches, 1.0 / 3.0),
        less(city.wasted, 0.5),
    ])
}

fn real(file: &str) -> Result<Judged, SuiteError> {
    let path = path(&town(file, &[])?, "street", 24, 1)?;
    let town = &path.town;
    let mut figures: Vec<Figure> = vec![
        figure("objects", town.objects.objects.len() as f64, ""),
        figure("triangles", town.triangles() as f64, ""),
        figure("lights", town.city.lights.len() as f64, ""),
        figure("boxes inscribed in buildings", town.inner.len() as f64, ""),
    ];
    let mut found = City::default();
    let mut run = |name: &str, way| -> Result<Vec<Shown>, SuiteError> {
        let shown = path.shown(&way)?;
        found.lost += lost(&shown);
        let mut add =
            |what: &str, value| figures.push(figure(format!("{name}: {what}"), value, ""));
        add("triangles a frame", mean(&shown, |w| w.triangles));
        add("drawn for nothing", path.overdraw(&shown));
        add("queries a frame", mean(&shown, |w| w.queries));
        add("batches a frame", mean(&shown, |w| w.batches));
        add("stalls a frame", mean(&shown, |w| w.stalls));
        add("wasted queries a frame", mean(&shown, |w| w.wasted));
        Ok(shown)
    };
    let frustum = run("frustum", asks(Technique::Frustum))?;
    run("stop-and-wait", asks(Technique::StopAndWait))?;
    let chc = run("CHC", asks(Technique::Chc))?;
    let revised = run("CHC++", chc_plus_plus(|_| {}))?;
    let every = run("CHC++, asked every frame", chc_plus_plus(|s| s.assumed_visible = 0))?;
    let seldom = run("CHC++, visible for 20 frames", chc_plus_plus(|s| s.assumed_visible = 20))?;
    run("two passes", hierarchical())?;
    run("masked, boxes", masked(Occluders::InnerBoxes))?;
    run("masked, meshes", masked(Occluders::Meshes))?;
    found.triangles = [mean(&frustum, |w| w.triangles), mean(&revised, |w| w.triangles)];
    found.batches = [mean(&chc, |w| w.batches), mean(&revised, |w| w.batches)];
    found.wasted = [mean(&every, |w| w.wasted), mean(&seldom, |w| w.wasted)];
    figures.push(figure("pixels lost by all", found.lost as f64, ""));
    let [triangles, batches, wasted] =
        [found.triangles, found.batches, found.wasted].map(|[a, b]| b / a.max(f64::MIN_POSITIVE));
    let because = format!(
        "{} pixels lost; queries draw {triangles:.2} of the frustum's triangles, CHC++ asks in \
         {batches:.2} of CHC's batches, 20 frames assumed visible waste {wasted:.2} of the queries",
        found.lost
    );
    Ok(judged(serves(&found), because, figures))
}

#[cfg(test)]
mod tests {
    use super::*;
    use Verdict::{Refuted, Reproduced};

    #[test]
    fn a_city_is_served_in_every_part_or_not() {
        let good = City { lost: 0, triangles: [9.0, 1.0], batches: [9.0, 1.0], wasted: [9.0, 1.0] };
        assert_eq!(serves(&good), Reproduced);
        assert_eq!(serves(&City { lost: 1, ..good }), Refuted);
        assert_eq!(serves(&City { triangles: [9.0, 5.0], ..good }), Refuted);
        assert_eq!(serves(&City { batches: [9.0, 4.0], ..good }), Refuted);
        assert_eq!(serves(&City { wasted: [9.0, f64::NAN], ..good }), Refuted);
    }

    #[test]
    fn missing_files_leave_it_open() {
        let missing = SuiteError::MissingData { path: "x".into(), variable: "DAPPLE_DATA" };
        let judged = open_without_data(Err(missing)).unwrap();
        assert_eq!(judged.verdict, Verdict::Open);
        assert!(judged.because.contains("DAPPLE_DATA"), "{}", judged.because);
        assert!(open_without_data(Err(SuiteError::Internal("x".into()))).is_err());
    }
}
