//! Table 5.VII: how many triangles and lights a city has.

use super::{
    support::town,
    verdict::{figure, judged},
};
use crate::{
    SuiteError,
    claims::{Claim, ClaimContext, Judged, Verdict},
};

/// A row of the source's table: blocks a side, triangles, lights.
const TABLE: [(u32, u64, u64); 3] =
    [(6, 978_652, 39_202), (9, 2_204_572, 88_278), (15, 6_124_564, 245_106)];

/// Scenes of these sizes.
const SCENES: [&str; 3] = ["city", "city_9", "city_15"];

/// Buildings of a block.
const BUILDINGS: f64 = 44.0;

pub fn claims() -> Vec<Claim> {
    vec![
        Claim {
            id: "conte-T5.VII-lights",
            statement: "A city has 1,089 lights a block, at every size",
            place: "Conte 2018, section 5.1 and table 5.VII",
            method: "lights of the generated cities of 6, 9 and 15 blocks a side, over their \
                     blocks, against the table's. The source does not say how a block's 44 \
                     buildings stand, and its two layouts that are possible differ by 4.4 % (a \
                     double row has 1,104, a ring 1,056): met if within 5 % at every size",
            judge: Box::new(lights),
        },
        Claim {
            id: "conte-T5.VII-triangles",
            statement: "A city of buildings with four facades, 1 to 7 storeys of eight quads and a \
                        roof has 27,185 triangles a block",
            place: "Conte 2018, section 5.1 and table 5.VII",
            method: "what the text says, multiplied: 44 buildings x (4 facades x 4 storeys in the \
                     mean x 8 quads + a roof) x 2, against the table's triangles a block, and the \
                     generated cities' beside them. Streets and sidewalks may add to it: met if \
                     within 5 %. Not met if beyond what 7 storeys everywhere would give",
            judge: Box::new(triangles),
        },
        Claim {
            id: "conte-T5.VII-windows",
            statement: "Every storey has three windows, every window a light",
            place: "Conte 2018, section 5.1",
            method: "remainders of the table's lights by three: every one must be 0. Where storeys \
                     without windows are left out, they leave out three lights each",
            judge: Box::new(windows),
        },
    ]
}

/// Pairs of ours and theirs.
fn within(pairs: &[(f64, f64)], share: f64) -> Verdict {
    let met = pairs.iter().all(|(ours, theirs)| (ours / theirs - 1.0).abs() <= share);
    match (pairs.is_empty(), met) {
        (true, _) => Verdict::Open,
        (_, true) => Verdict::Reproduced,
        _ => Verdict::Refuted,
    }
}

fn lights(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let (mut figures, mut pairs) = (Vec::new(), Vec::new());
    for (scene, (side, _, theirs)) in SCENES.iter().zip(TABLE) {
        let city = town(scene, &[])?;
        let blocks = f64::from(side * side);
        let (ours, theirs) = (city.city.lights.len() as f64 / blocks, theirs as f64 / blocks);
        figures.push(figure(format!("{side} x {side} blocks: lights a block"), ours, ""));
        figures.push(figure(format!("{side} x {side} blocks: the table's"), theirs, ""));
        pairs.push((ours, theirs));
    }
    let most = pairs.iter().map(|(a, b)| (a / b - 1.0).abs()).fold(0.0, f64::max);
    let because =
        format!("lights a block differ from the table's by at most {:.1} %", most * 100.0);
    Ok(judged(within(&pairs, 0.05), because, figures))
}

/// Triangles a block: said in the table, said by the text, and by the text with all storeys there
/// can be.
fn told(table: f64, text: f64, most: f64) -> Verdict {
    if (table / text - 1.0).abs() <= 0.05 {
        Verdict::Reproduced
    } else if table > most {
        Verdict::Refuted
    } else {
        Verdict::Open
    }
}

fn triangles(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let block = |storeys: f64| BUILDINGS * (4.0 * storeys * 8.0 + 1.0) * 2.0;
    let (text, most) = (block(4.0), block(7.0));
    let mut figures = vec![
        figure("a block by the text, 4 storeys in the mean", text, ""),
        figure("a block by the text, 7 storeys everywhere", most, ""),
    ];
    let mut verdicts = Vec::new();
    for (scene, (side, theirs, _)) in SCENES.iter().zip(TABLE) {
        let blocks = f64::from(side * side);
        let table = theirs as f64 / blocks;
        let ours = town(scene, &[])?.triangles() as f64 / blocks;
        figures.push(figure(format!("{side} x {side} blocks: the table's a block"), table, ""));
        figures.push(figure(format!("{side} x {side} blocks: generated, grounds too"), ours, ""));
        figures.push(figure(
            format!("{side} x {side} blocks: the table's a building"),
            table / BUILDINGS,
            "",
        ));
        verdicts.push(told(table, text, most));
    }
    let verdict = super::verdict::all_of(&verdicts);
    let because = format!(
        "the text gives {text:.0} triangles a block and at most {most:.0}; the table has 27,185 to \
         27,220: the same at every size, so of something the text does not name"
    );
    Ok(judged(verdict, because, figures))
}

/// Remainders of lights by the windows of a storey.
fn whole(remainders: &[u64]) -> Verdict {
    let whole = !remainders.is_empty() && remainders.iter().all(|r| *r == 0);
    if whole { Verdict::Reproduced } else { Verdict::Refuted }
}

fn windows(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let remainders = TABLE.map(|(_, _, lights)| lights % 3);
    let figures = TABLE
        .iter()
        .zip(remainders)
        .map(|((side, _, lights), r)| {
            figure(format!("{side} x {side} blocks: {lights} lights, remainder by 3"), r as f64, "")
        })
        .collect();
    let odd = remainders.iter().filter(|r| **r != 0).count();
    let because = format!("{odd} of the table's 3 numbers of lights cannot be divided by three");
    Ok(judged(whole(&remainders), because, figures))
}

#[cfg(test)]
mod tests {
    use super::*;
    use Verdict::{Open, Refuted, Reproduced};

    #[test]
    fn counts_are_met_or_not() {
        assert_eq!(within(&[(1104.0, 1089.0)], 0.05), Reproduced);
        assert_eq!(within(&[(1104.0, 1089.0), (900.0, 1089.0)], 0.05), Refuted);
        assert_eq!(within(&[(f64::NAN, 1089.0)], 0.05), Refuted);
        assert_eq!(within(&[], 0.05), Open);
    }

    #[test]
    fn a_table_may_be_beyond_what_its_text_allows() {
        assert_eq!(told(100.0, 101.0, 200.0), Reproduced);
        assert_eq!(told(150.0, 100.0, 200.0), Open);
        assert_eq!(told(300.0, 100.0, 200.0), Refuted);
    }

    #[test]
    fn windows_come_by_threes() {
        assert_eq!(whole(&[0, 0]), Reproduced);
        assert_eq!(whole(&[0, 1]), Refuted);
    }
}
