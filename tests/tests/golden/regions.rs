//! From-region visibility: shadows of houses on planes behind them, alone and joined, and which of a
//! city's lights its facades keep.

use dapple_many_lights::region::{
    Cuboid, Edge, Fusion,
    fusion::{Horizon, Verdict, reference::Shadow},
    horizon::{Projection, Umbra, umbra},
    truth::kept,
};
use dapple_suite::{
    case::Case,
    knob::{self, Knobs},
    problem::{self, Form, Setting},
    problems::region_light_visibility::{RegionCase, SPEC, truth::Sighted},
};
use dapple_tests::golden::{LSB, Picture, Tolerance, assert_golden};
use std::fmt::Write as _;

/// Names and tolerances of this file's goldens.
pub fn goldens() -> Vec<(String, Tolerance)> {
    ["edges", "fusions", "lights-seen", "lights-kept", "lights-unfused"]
        .map(|name| (format!("region-{name}"), LSB))
        .into()
}

/// A storey of a facade; metres.
const CELL: Cuboid = Cuboid { u: [20.0, 32.0], w: [-1.0, 0.0], h: [3.0, 6.0] };

/// The upper left corner of what is shown of a plane, and a pixel: no edge runs along its middle.
const SHOWN: [f64; 2] = [-30.13, 31.07];
const PIXEL_M: f64 = 0.8;
const PANEL: [u32; 2] = [140, 40];

/// The middle of a panel's pixel: u, h.
fn place([x, y]: [u32; 2]) -> [f64; 2] {
    let [left, up] = SHOWN;
    [left + (f64::from(x) + 0.5) * PIXEL_M, up - (f64::from(y) + 0.5) * PIXEL_M]
}

/// Panels in rows and columns.
fn panels(count: [u32; 2], value: impl Fn([u32; 2], [f64; 2]) -> f32) -> Picture {
    let [width, height] = [0, 1].map(|i| count[i] * PANEL[i]);
    let pixels = (0..height).flat_map(|y| (0..width).map(move |x| [x, y]));
    let of =
        |[x, y]: [u32; 2]| value([x / PANEL[0], y / PANEL[1]], place([x % PANEL[0], y % PANEL[1]]));
    Picture::from_values(width, height, &pixels.map(of).collect::<Vec<_>>())
}

/// Whether the straight way from a point (u, w, h) to another, farther along w, meets a house.
fn meets(from: [f64; 3], to: [f64; 3], house: &Cuboid) -> bool {
    let (mut first, mut last) = (0.0_f64, 1.0_f64);
    for (axis, [low, high]) in [house.u, house.w, house.h].into_iter().enumerate() {
        let way = to[axis] - from[axis];
        let [a, b] = [(low - from[axis]) / way, (high - from[axis]) / way];
        if way != 0.0 {
            (first, last) = (first.max(a.min(b)), last.min(a.max(b)));
        } else if from[axis] < low || from[axis] > high {
            return false;
        }
    }
    first <= last
}

/// Points of the cell, its corners among them.
fn points_of_the_cell(steps: [u32; 3]) -> Vec<[f64; 3]> {
    let along = |[low, high]: [f64; 2], steps: u32| {
        (0..=steps).map(move |i| low + (high - low) * f64::from(i) / f64::from(steps))
    };
    let mut points = Vec::new();
    for u in along(CELL.u, steps[0]) {
        for w in along(CELL.w, steps[1]) {
            points.extend(along(CELL.h, steps[2]).map(|h| [u, w, h]));
        }
    }
    points
}

/// Whether a place on a plane is hidden from each of some points, by whichever house.
fn is_hidden(from: &[[f64; 3]], [u, h]: [f64; 2], plane: f64, houses: &[Cuboid]) -> bool {
    from.iter().all(|&p| houses.iter().any(|house| meets(p, [u, plane, h], house)))
}

fn contains(shadow: &Umbra, [u, h]: [f64; 2]) -> bool {
    shadow.hides(&Projection { u: [u; 2], h: [h; 2] })
}

/// A house with nothing below it.
fn house(u: [f64; 2], w: [f64; 2], top: f64) -> Cuboid {
    Cuboid { u, w, h: [f64::NEG_INFINITY, top] }
}

/// How bright a plane is where nothing is hidden, where something is and no shadow says so, and
/// where one does.
const OPEN: f32 = 0.1;
const MISSED: f32 = 0.5;
const FOUND: f32 = 0.9;

/// Shadows of single houses on a plane, by edge: level, sloped, whole. A place is hidden exactly if it
/// is from all eight corners of the cell: the whole edge misses nothing, and none adds anything. The last
/// one is a bridge, of which only the far face counts.
#[test]
fn edges_of_shadows_of_one_house() {
    const PLANE: f64 = 44.0;
    let houses = [
        house([4.0, 48.0], [16.0, 30.0], 9.0),
        house([36.0, 50.0], [20.0, 40.0], 12.0),
        house([12.0, 40.0], [16.0, 34.0], 5.0),
        Cuboid { u: [-5.0, 24.0], w: [24.0, 38.0], h: [7.5, 16.0] },
    ];
    let edges = [Edge::Flat, Edge::Sloped, Edge::Hull];
    let corners = points_of_the_cell([1, 1, 1]);
    let shadows = houses.map(|house| edges.map(|edge| umbra(&CELL, &house, PLANE, edge).unwrap()));
    let picture = panels([3, 4], |[column, row], at| {
        let hidden = is_hidden(&corners, at, PLANE, &houses[row as usize..][..1]);
        let found = contains(&shadows[row as usize][column as usize], at);
        assert!(hidden || !found, "house {row}, edge {column}: {at:?} is seen");
        match (hidden, found) {
            (_, true) => FOUND,
            (true, false) => MISSED,
            (false, false) => OPEN,
        }
    });
    let count = |column: u32, row: u32, value: f32| {
        let code = (value * 255.0).round() as u8;
        let [x, y] = [column * PANEL[0], row * PANEL[1]];
        let rows = picture.codes.chunks(picture.width as usize).skip(y as usize);
        let rows = rows.take(PANEL[1] as usize).map(|row| &row[x as usize..][..PANEL[0] as usize]);
        rows.flatten().filter(|found| **found == code).count()
    };
    for row in 0..4 {
        let [flat, sloped, whole] = [0, 1, 2].map(|column| count(column, row, FOUND));
        let missed = [0, 1, 2].map(|column| count(column, row, MISSED));
        println!("house {row}: {flat} {sloped} {whole} pixels, missed {missed:?}");
        assert!(flat > 0 && flat <= whole && sloped <= whole);
        if houses[row as usize].h[0] == f64::NEG_INFINITY {
            assert_eq!(missed[2], 0, "house {row}: of the whole edge");
        }
    }
    assert!((0..4).any(|row| count(0, row, MISSED) > 50), "level edges lose what they are to lose");
    assert_golden("region-edges", &picture, LSB);
}

/// Two rows of houses with a gap, one of them over a gateway.
fn rows() -> Vec<Cuboid> {
    let front = [(0.0, 8.0, 12.0), (8.0, 14.0, 21.0), (14.0, 22.0, 9.0), (24.0, 34.0, 15.0)];
    let mut houses: Vec<Cuboid> =
        front.map(|(left, right, top)| house([left, right], [16.0, 26.0], top)).into();
    houses.push(Cuboid { u: [34.0, 44.0], w: [16.0, 26.0], h: [4.0, 18.0] });
    let back = [(8.0, 18.0, 9.0), (18.0, 27.0, 18.0), (27.0, 36.0, 24.0)];
    houses.extend(back.map(|(left, right, top)| house([left, right], [42.0, 52.0], top)));
    houses
}

/// The far faces of the front row and of the back row, and planes behind each.
const PLANES: [f64; 4] = [26.0, 38.0, 52.0, 80.0];
const FUSIONS: [(&str, Fusion); 3] = [
    ("no-fusion", Fusion::None),
    ("insertion", Fusion::Insertion),
    ("height-ordered", Fusion::HeightOrdered),
];

/// The shadows on each plane, moved from the one before and joined with those of new houses.
fn swept(fusion: Fusion, houses: &[Cuboid]) -> [Horizon; 4] {
    let mut horizon = Horizon::new(fusion);
    let mut before = CELL.w[1];
    PLANES.map(|plane| {
        if !horizon.is_empty() {
            horizon.reproject(&CELL, before, plane);
        }
        let new = houses.iter().filter(|house| (before..plane).contains(&house.w[0]));
        let new: Vec<Umbra> =
            new.filter_map(|house| umbra(&CELL, house, plane, Edge::Flat)).collect();
        horizon.add(&new);
        before = plane;
        horizon.clone()
    })
}

/// Windows of 4 by 3 metres that lie on a plane: as many as are told to be hidden.
fn hidden_windows(horizon: &Horizon, from: &[[f64; 3]], plane: f64, houses: &[Cuboid]) -> u32 {
    let mut hidden = 0;
    for left in (-28..78).step_by(2) {
        for down in 0..9 {
            let [u, h] = [f64::from(left), 3.0 * f64::from(down)];
            let window = Projection { u: [u, u + 4.0], h: [h, h + 3.0] };
            if horizon.test(&window, &mut 0) == Verdict::Hidden {
                for at in [[u, h], [u + 4.0, h], [u, h + 3.0], [u + 4.0, h + 3.0]] {
                    assert!(is_hidden(from, at, plane, houses), "{window:?} is seen at {at:?}");
                }
                hidden += 1;
            }
        }
    }
    hidden
}

fn tell(shadow: &Shadow, depth: usize, text: &mut String) {
    let Umbra { u: [left, right], foot, top: [top, _], .. } = shadow.umbra;
    let indent = "  ".repeat(depth + 2);
    writeln!(text, "{indent}{left:.3} to {right:.3}, {foot:.3} to {top:.3}").unwrap();
    shadow.children.iter().for_each(|child| tell(child, depth + 1, text));
}

/// Columns: not joined, joined as they come, the tallest first. Downwards: planes. The brighter a place,
/// the more shadows hold it. Whatever is in one is hidden, by rays, from everywhere in the cell that
/// was tried, and so is every window that is told to be.
#[test]
fn shadows_of_rows_of_houses_on_planes() {
    let houses = rows();
    let from = points_of_the_cell([6, 1, 2]);
    let columns = FUSIONS.map(|(_, fusion)| swept(fusion, &houses));
    let picture = panels([3, 4], |[column, row], at| {
        let (plane, horizon) = (PLANES[row as usize], &columns[column as usize][row as usize]);
        let holding = horizon.nodes().filter(|shadow| contains(shadow, at)).count();
        let seen = holding > 0 && !is_hidden(&from, at, plane, &houses);
        assert!(!seen, "{} at {plane}: {at:?} is seen", FUSIONS[column as usize].0);
        OPEN + 0.2 * holding.min(4) as f32
    });
    let mut text = String::new();
    let mut told = [[0; 4]; 3];
    for ((name, _), (horizons, told)) in FUSIONS.iter().zip(columns.iter().zip(&mut told)) {
        for ((plane, horizon), told) in PLANES.iter().zip(horizons).zip(told) {
            *told = hidden_windows(horizon, &from, *plane, &houses);
            writeln!(text, "{name}, {plane} m: {} shadows hide {told} windows", horizon.len())
                .unwrap();
            let mut roots = horizon.roots();
            roots.sort_by(|a, b| a.umbra.u[0].total_cmp(&b.umbra.u[0]));
            roots.iter().for_each(|root| tell(root, 0, &mut text));
        }
    }
    let [none, insertion, ordered] = told;
    for plane in 0..4 {
        assert!(none[plane] <= insertion[plane].min(ordered[plane]), "{told:?}");
    }
    assert!(none[3] < insertion[3].min(ordered[3]), "joining hides no more: {told:?}");
    // With the gateway closed, so that no feet differ, the tallest first is best.
    let walls: Vec<Cuboid> = houses
        .iter()
        .map(|house| Cuboid { h: [f64::NEG_INFINITY, house.h[1]], ..*house })
        .collect();
    let [insertion, ordered] = [Fusion::Insertion, Fusion::HeightOrdered]
        .map(|fusion| hidden_windows(&swept(fusion, &walls)[3], &from, PLANES[3], &walls));
    assert!(insertion <= ordered, "{insertion} and {ordered} windows");
    insta::assert_snapshot!("shadows", text);
    assert_golden("region-fusions", &picture, LSB);
}

/// Every facade of the small city that a street shows is a cell; weaker lights do not matter.
fn city(threshold: f64) -> RegionCase {
    let given: [(String, _); 5] = [
        ("width".into(), 96.into()),
        ("tau".into(), 0.into()),
        ("threshold".into(), threshold.into()),
        ("most_split".into(), "facade".into()),
        ("truth_faces".into(), 1000.into()),
    ];
    let case = Case {
        problem: SPEC.id.into(),
        scene: "city_small".into(),
        view: "street".into(),
        seed: 0,
        parameters: knob::complete("parameter", SPEC.parameters, &Knobs::from(given)).unwrap(),
    };
    RegionCase::prepare(&case).unwrap()
}

/// What facade-cluster visibility keeps of every face of the first frame.
fn precuts(case: &RegionCase, variant: &str) -> Vec<Vec<u32>> {
    let technique = SPEC.technique("facade-cluster").unwrap();
    let setting = Setting {
        technique: technique.id.into(),
        variant: variant.into(),
        form: Form::Cpu,
        knobs: knob::complete("knob", technique.knobs, &Knobs::new()).unwrap(),
    };
    let asked: Vec<_> = case.frames()[0].iter().map(|question| question.asked()).collect();
    let mut precuts = Vec::new();
    case.many(&setting).unwrap().all(&asked, &mut precuts);
    precuts
}

/// Lights by face: as many as are kept. None is left out that a ray from the face reaches.
#[test]
fn lights_that_facades_keep() {
    let case = city(1.0 / 1020.0);
    let tree = &case.night().town.lights;
    let kept_by = FUSIONS.map(|(variant, _)| precuts(&case, variant));
    for (precuts, (variant, _)) in kept_by.iter().zip(FUSIONS) {
        let agreement = case.judge(0, precuts);
        println!("{variant}: {agreement:?}, tightness {:.3}", agreement.tightness());
        assert!(agreement.seen_culled == 0 && agreement.seen_kept > 1000, "{variant}");
    }
    let lights = |precut: &[u32]| kept(tree, precut).into_iter().filter(|kept| *kept).count();
    let mut text =
        format!("{} lights; kept: {}\n", tree.leaves.len(), FUSIONS.map(|f| f.0).join(", "));
    let mut all = [0; 3];
    for (index, question) in case.frames()[0].iter().enumerate() {
        let (cell, direction) = question.asked();
        let Some(face) = cell.face(direction) else { continue };
        let of = [0, 1, 2].map(|by: usize| &kept_by[by][index]);
        let counts = of.map(|precut| lights(precut));
        let [none, _, ordered] = counts;
        assert!(ordered <= none, "face {index}: {counts:?}");
        all = [0, 1, 2].map(|by| all[by] + counts[by]);
        let [low, high] = [face.region.min, face.region.max].map(|v| v.round().as_ivec3());
        let nodes = of.map(|precut| precut.len());
        writeln!(text, "{direction:?} {low} to {high} m: {counts:?} in {nodes:?} nodes").unwrap();
    }
    writeln!(text, "all faces: {all:?}").unwrap();
    assert!(all[2] < all[1] && all[1] < all[0], "{all:?}");
    insta::assert_snapshot!("facades", text);
}

/// Plans of the city, north up: its buildings, a face, and the lights before it, bright where they are
/// seen or kept. However weak it is, none that is seen is left out.
#[test]
fn plans_of_kept_lights() {
    let case = city(0.0);
    let plan = |precuts: &[Vec<u32>]| case.picture(precuts).unwrap();
    let [unfused, _, ordered] = FUSIONS.map(|(variant, _)| plan(&precuts(&case, variant)));
    // Lights that the truth shows as seen and the technique as left out.
    let lost = |plan: &problem::Picture| {
        plan.truth
            .iter()
            .zip(&plan.result)
            .filter(|(seen, kept)| **seen == 1.0 && **kept < 1.0)
            .count()
    };
    let shown = |values: &[f32]| values.iter().filter(|value| **value == 1.0).count();
    let nothing = plan(&vec![Vec::new(); case.frames()[0].len()]);
    let most = case.truth()[0].iter().max_by_key(|face| face.lights.len()).unwrap();
    let tree = &case.night().town.lights;
    // Seen, and without any effect on a surface there: such lights may be left out.
    let without = |precuts: &[Vec<u32>]| {
        let kept = kept(tree, &precuts[most.question]);
        let out = most.lights.iter().filter(|(light, _)| !kept[*light as usize]);
        assert!(out.clone().all(|(_, sighted)| *sighted != Sighted::Strong));
        out.filter(|(_, sighted)| *sighted == Sighted::Weak).count()
    };
    let out = [0, 2].map(|by: usize| without(&precuts(&case, FUSIONS[by].0)));
    println!("seen without effect and left out: {out:?}");
    assert!(lost(&unfused) <= out[0] && lost(&ordered) <= out[1] && out[1] < 20, "{out:?}");
    assert_eq!(lost(&nothing), shown(&nothing.truth), "control: lights left out are lost");
    let [seen, few, many] = [&ordered.truth, &ordered.result, &unfused.result].map(|v| shown(v));
    println!("places of lights: {seen} seen, {few} kept, {many} without fusion");
    assert!(0 < seen && seen <= few && few < many);
    let picture = |values| Picture::from_values(ordered.width, ordered.height, values);
    assert_golden("region-lights-seen", &picture(&ordered.truth), LSB);
    assert_golden("region-lights-kept", &picture(&ordered.result), LSB);
    assert_golden("region-lights-unfused", &picture(&unfused.result), LSB);
}
