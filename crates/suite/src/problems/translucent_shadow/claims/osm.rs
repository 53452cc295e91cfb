//! H3.1, H3.2, H3.5: what planes shared by all rays do to a picture.

use super::{
    support::{Method, SCENES, osm, still, still_with},
    verdict::{GREY_LEVEL, all_of, count, figure, judged, vote},
};
use crate::{
    SuiteError,
    claims::{Claim, ClaimContext, Judged, Verdict},
};
use dapple_opacity_maps::{Layout, Slicing, Taps};

pub fn claims() -> Vec<Claim> {
    vec![
        Claim {
            id: "voicu-H3.1",
            statement: "Few opacity maps show as layers; their error and banding fall from 16 \
                        over 64 to 128",
            place: "Voicu 2011, section 3.2 and 3.3, figures 3.2.1, 3.2.2 and 3.3.1",
            method: "ten scenes, 128 px, map 256, one tap, interpolated. Error: rms against the \
                     deep shadow map of the same texels; banding: rms step of that error along \
                     light rays in 128 steps. A scene shows layers if its error at 16 maps \
                     exceeds one grey level (1/255); it agrees if it does and both figures fall \
                     strictly from 16 over 64 to 128. All scenes: reproduced, none: refuted, \
                     else open",
            judge: Box::new(layering),
        },
        Claim {
            id: "voicu-H3.2",
            statement: "Even planes waste maps where objects lie far apart: many consecutive maps \
                        hold the same",
            place: "Voicu 2011, section 3.1",
            method: "16 maps of 256, a map counts as wasted if it equals the one before in every \
                     texel. `Many`: in two_far (two objects far apart) at least a quarter of the \
                     maps, and in none of the scenes of one object (grass, willow, hair, slab) \
                     more than one, as even a whole object may leave its last layer empty. \
                     Density-based planes are shown beside",
            judge: Box::new(waste),
        },
        Claim {
            id: "voicu-H3.5",
            statement: "Filtered with 16 taps, a map of half the side is no worse than an \
                        unfiltered one",
            place: "Voicu 2011, section 3.5",
            method: "64 opacity maps (what 16 textures hold), rms against light rays. 256 with \
                     4 x 4 taps against 512 with one, and 128 against 256, with truth averaged \
                     over the problem's footprint (0.004 of the whole map) and over none. Holds \
                     where the former does not exceed the latter; voted over scenes, sizes and \
                     footprints. Nothing is allowed for: `no worse` is an order",
            judge: Box::new(filtered),
        },
    ]
}

/// Error and banding of a scene at 16, 64, 128 maps.
type Row = [(f64, f64); 3];

fn falls(rows: &[Row]) -> (Verdict, String) {
    let fall = |row: &Row| {
        let shown = row[0].0 > GREY_LEVEL;
        shown && row.windows(2).all(|w| w[1].0 < w[0].0 && w[1].1 < w[0].1)
    };
    let holds: Vec<bool> = rows.iter().map(fall).collect();
    let most = |of: fn(&Row) -> f64| rows.iter().map(of).fold(0.0, f64::max);
    let because = format!(
        "error and banding fall throughout on {} scenes; from 16 to 128 maps the error falls to \
         at most {:.2} of itself, banding to {:.2}: most of its steps are fragments'",
        count(&holds),
        most(|row| row[2].0 / row[0].0),
        most(|row| row[2].1 / row[0].1)
    );
    (vote(&holds), because)
}

fn layering(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let (mut figures, mut rows) = (Vec::new(), Vec::new());
    for scene in SCENES {
        let still = still(scene)?;
        let mut row = Row::default();
        for (slot, layers) in row.iter_mut().zip([16, 64, 128]) {
            let score = still.score(&osm(layers).one_tap())?;
            *slot = (score.layering, score.banding);
            figures.push(figure(format!("{scene}: error, {layers} maps"), score.layering, ""));
            figures.push(figure(format!("{scene}: banding, {layers} maps"), score.banding, ""));
        }
        rows.push(row);
    }
    let (verdict, because) = falls(&rows);
    Ok(judged(verdict, because, figures))
}

/// Wasted maps of 16 in the scene of two objects, and the most in a scene of one.
fn wasted(two: u32, one: u32) -> Verdict {
    match (two >= 4, one <= 1) {
        (true, true) => Verdict::Reproduced,
        (false, _) => Verdict::Refuted,
        // Distance is not what wastes them.
        (true, false) => Verdict::Open,
    }
}

/// Maps that equal the one before.
fn equal_maps(words: &[f32], layers: usize) -> u32 {
    let equal = |k: &usize| words.chunks_exact(layers).all(|texel| texel[*k] == texel[k - 1]);
    (1..layers).filter(equal).count() as u32
}

fn waste(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    const LAYERS: u32 = 16;
    let (mut figures, mut two, mut one) = (Vec::new(), 0, 0);
    for scene in ["two_far", "grass", "willow", "hair", "slab"] {
        let still = still(scene)?;
        for (name, slicing) in [("even", Slicing::Uniform), ("by density", Slicing::Density)] {
            let method = osm(LAYERS).with(|layered| layered.layout = Layout::Planes(slicing));
            let maps = still.maps(&method)?;
            let equal = equal_maps(maps.words(), LAYERS as usize);
            let error = still.score(&method)?.layering;
            figures.push(figure(format!("{scene}, {name}: wasted maps"), f64::from(equal), ""));
            figures.push(figure(format!("{scene}, {name}: error"), error, ""));
            match (slicing, scene) {
                (Slicing::Uniform, "two_far") => two = equal,
                (Slicing::Uniform, _) => one = one.max(equal),
                _ => {}
            }
        }
    }
    let because = format!(
        "{two} of {LAYERS} maps equal the one before where two objects lie far apart, at most \
         {one} in a scene of one"
    );
    Ok(judged(wasted(two, one), because, figures))
}

/// Errors of the small map filtered and the large one not.
fn no_worse(pairs: &[(f64, f64)]) -> (Verdict, String) {
    let holds: Vec<bool> = pairs.iter().map(|(small, large)| small <= large).collect();
    (vote(&holds), format!("the filtered map of half the side is no worse in {}", count(&holds)))
}

fn filtered(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let (mut figures, mut parts, mut told) = (Vec::new(), Vec::new(), Vec::new());
    for footprint in [0.004, 0.0] {
        let mut pairs = Vec::new();
        for scene in ["grass", "grass_sparse", "tree", "willow", "hair", "mixed"] {
            let still = still_with(scene, 0, &[("footprint", footprint.into())])?;
            let error = |method: Method| still.score(&method).map(|s| s.rmse);
            for side in [256, 128] {
                let small = error(osm(64).at(side).taps(Taps::Box4))?;
                let large = error(osm(64).at(2 * side).one_tap())?;
                let what = format!("{scene}, footprint {footprint}");
                figures.push(figure(format!("{what}: {side}, 16 taps"), small, ""));
                figures.push(figure(format!("{what}: {}, one tap", 2 * side), large, ""));
                pairs.push((small, large));
            }
        }
        let (verdict, because) = no_worse(&pairs);
        told.push(format!("footprint {footprint}: {because}"));
        parts.push(verdict);
    }
    Ok(judged(all_of(&parts), told.join("; "), figures))
}

#[cfg(test)]
mod tests {
    use super::*;
    use Verdict::{Open, Refuted, Reproduced};

    #[test]
    fn both_figures_must_fall_and_layers_must_show() {
        let good = [(0.1, 0.1), (0.05, 0.05), (0.02, 0.02)];
        let banded = [(0.1, 0.1), (0.05, 0.11), (0.02, 0.02)];
        let unseen = [(1e-3, 0.1), (1e-4, 0.05), (1e-5, 0.02)];
        assert_eq!(falls(&[good, good]).0, Reproduced);
        assert_eq!(falls(&[good, banded]).0, Open);
        assert_eq!(falls(&[banded, unseen]).0, Refuted);
    }

    #[test]
    fn many_is_a_quarter_where_two_are_apart_and_no_more_than_one_elsewhere() {
        assert_eq!(wasted(9, 0), Reproduced);
        assert_eq!(wasted(3, 0), Refuted);
        assert_eq!(wasted(9, 2), Open);
        assert_eq!(equal_maps(&[0.0, 1.0, 1.0, 0.5, 0.5, 0.5], 3), 1);
    }

    #[test]
    fn no_worse_is_an_order() {
        assert_eq!(no_worse(&[(0.1, 0.1), (0.1, 0.2)]).0, Reproduced);
        assert_eq!(no_worse(&[(0.11, 0.1), (0.1, 0.2)]).0, Open);
        assert_eq!(no_worse(&[(0.2, 0.1)]).0, Refuted);
    }
}
