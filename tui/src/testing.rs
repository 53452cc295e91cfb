//! For tests: screens drawn into a buffer, and that buffer as text *with* its styles (what ratatui
//! prints of a test backend leaves them out).

use crate::{
    app::App,
    msg::{Effect, Msg},
    store::Store,
};
use dapple_records::{
    Feed, FeedLine,
    catalogue::{Catalogue, KnobInfo, ProblemInfo, TechniqueInfo},
};
use ratatui::{
    buffer::{Buffer, Cell},
    crossterm::event::{KeyCode, KeyEvent, KeyModifiers},
    layout::Rect,
    style::{Color, Modifier},
};
use std::{collections::BTreeMap, fmt::Write, path::Path, sync::Arc};

/// Half an hour after the fixture's last record: 2026-01-02T04:00:00Z.
pub const NOW: i64 = 1_767_326_400_000;

/// A dashboard over `fixtures/dashboard` that was told [`catalogue`].
pub fn app(colour: bool) -> App {
    let mut app = App::new(colour, NOW);
    let Some(Effect::Start { job, .. }) = app.start().pop() else {
        panic!("the catalogue is asked")
    };
    let line = Box::new(FeedLine::Event(Feed::Catalogue(Box::new(catalogue()))));
    app.update(Msg::Heard { job, line });
    app.update(Msg::Ended { job, code: Some(0), how: "done".into() });
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fixtures/dashboard");
    app.update(Msg::Store(Arc::new(Store::open(&folder))));
    assert_eq!(app.world.store.index.headers.len(), 2, "{}", folder.display());
    app
}

/// Two problems, of which the records know the first.
pub fn catalogue() -> Catalogue {
    let technique = |id: &str| TechniqueInfo {
        id: id.into(),
        title: id.to_uppercase(),
        source: "Somebody, Something, 2006".into(),
        forms: vec!["cpu".into(), "gpu".into()],
        variants: vec![("plain".into(), "as published".into())],
        knobs: vec![KnobInfo {
            name: "resolution".into(),
            unit: "texels".into(),
            help: "side of the map".into(),
            limit: "an integer in 1..=8192 texels".into(),
            default: 512.into(),
            steps: vec![256.into(), 512.into(), 1024.into()],
            accuracy: "monotone".into(),
        }],
    };
    let first = ProblemInfo {
        id: "shadow-filtering".into(),
        title: "Shadow-map filtering".into(),
        question: "Which share of a footprint is lit, from one depth map?".into(),
        truth: "Rays from the receiver, averaged over the footprint.".into(),
        metrics: vec![("rmse".into(), String::new(), "root mean square".into())],
        axis: "rmse".into(),
        levels: vec![0.005, 0.02, 0.05],
        default_scene: "spheres".into(),
        pictures: true,
        techniques: ["pcf", "vsm", "esm", "evsm", "msm"].map(technique).into(),
        extremes: vec![("scale".into(), String::new(), "size of the scene".into())],
        gates: BTreeMap::from([("pcf".into(), 1), ("vsm".into(), 1), ("msm".into(), 2)]),
        claims: vec![("c1".into(), "A is faster than B.".into())],
        ..ProblemInfo::default()
    };
    let second = ProblemInfo {
        id: "offsets".into(),
        title: "Offsets".into(),
        question: "Where does each part begin?".into(),
        truth: "A scan by one thread.".into(),
        metrics: vec![("wrong".into(), String::new(), "entries that differ".into())],
        axis: "wrong".into(),
        levels: vec![0.0, 1.0, 2.0],
        default_scene: "crown".into(),
        techniques: vec![technique("scan")],
        gates: BTreeMap::from([("scan".into(), 1)]),
        ..ProblemInfo::default()
    };
    Catalogue {
        problems: vec![first, second],
        sweeps: vec![("quick".into(), "under a minute".into())],
        scenes: vec![("spheres".into(), "two spheres".into())],
        machine: "aaaaaaaa".into(),
        cpu: "Imaginary CPU".into(),
        adapter: "Imaginary GPU".into(),
        device: "hardware".into(),
    }
}

/// A buffer of that size, drawn.
pub fn drawn(width: u16, height: u16, view: impl FnOnce(Rect, &mut Buffer)) -> Buffer {
    let area = Rect::new(0, 0, width, height);
    let mut buf = Buffer::empty(area);
    view(area, &mut buf);
    buf
}

/// Its lines, without trailing spaces.
pub fn text_of(buf: &Buffer) -> Vec<String> {
    rows(buf).map(|row| row.iter().map(|c| c.symbol()).collect::<String>()).map(trimmed).collect()
}

fn trimmed(text: String) -> String {
    text.trim_end().to_string()
}

fn rows(buf: &Buffer) -> impl Iterator<Item = &[Cell]> {
    buf.content.chunks(usize::from(buf.area.width.max(1))).take(buf.area.height.into())
}

/// Text, then the runs of styles of each line by a letter, then what the letters mean. Cells in the
/// plain style are not listed.
pub fn styled(buf: &Buffer) -> String {
    let mut legend: Vec<String> = Vec::new();
    let mut styles = String::new();
    for (y, row) in rows(buf).enumerate() {
        let mut runs = String::new();
        let mut x = 0;
        while x < row.len() {
            let style = style_of(&row[x]);
            let end = (x..row.len()).find(|&i| style_of(&row[i]) != style).unwrap_or(row.len());
            if !style.is_empty() {
                let at = legend.iter().position(|s| *s == style).unwrap_or_else(|| {
                    legend.push(style);
                    legend.len() - 1
                });
                let _ = write!(runs, " {}:{x}-{}", letter(at), end - 1);
            }
            x = end;
        }
        if !runs.is_empty() {
            let _ = writeln!(styles, "{y:>3}{runs}");
        }
    }
    let mut out = text_of(buf).iter().fold(String::new(), |out, line| out + "|" + line + "\n");
    out += "--- styles: line, then letter:columns\n";
    out += &styles;
    for (at, style) in legend.iter().enumerate() {
        let _ = writeln!(out, "{} = {style}", letter(at));
    }
    out
}

fn letter(at: usize) -> String {
    let of = |n: usize| char::from(b'a' + (n % 26) as u8);
    if at < 26 { of(at).to_string() } else { format!("{}{}", of(at / 26 - 1), of(at)) }
}

fn style_of(cell: &Cell) -> String {
    let mut words = Vec::new();
    if cell.fg != Color::Reset {
        words.push(format!("{}", cell.fg));
    }
    if cell.bg != Color::Reset {
        words.push(format!("on {}", cell.bg));
    }
    for (name, _) in cell.modifier.iter_names() {
        words.push(name.to_lowercase());
    }
    words.join(" ")
}

/// Whether any cell has a colour.
pub fn has_colour(buf: &Buffer) -> bool {
    buf.content.iter().any(|c| c.fg != Color::Reset || c.bg != Color::Reset)
}

/// Sizes from nothing to large, with the odd ones in between.
pub fn sizes() -> impl Iterator<Item = (u16, u16)> {
    let widths = (0..24).chain((24..=200).step_by(11)).chain([80, 120, 200]);
    widths.flat_map(|w| (0..12).chain([24, 40, 60]).map(move |h| (w, h)))
}

/// A key without modifiers.
pub fn key(code: KeyCode) -> KeyEvent {
    KeyEvent::new(code, KeyModifiers::NONE)
}

#[test]
fn styles_are_told_apart() {
    use ratatui::style::Style;
    let draw = |style: Style| {
        styled(&drawn(6, 2, |area, buf| {
            buf.set_string(area.x, area.y, "ab", style);
            buf.set_string(area.x, area.y + 1, " cd", Style::new());
        }))
    };
    let red = draw(Style::new().fg(Color::Red));
    assert_eq!(red, "|ab\n| cd\n--- styles: line, then letter:columns\n  0 a:0-1\na = Red\n");
    let others =
        [Style::new(), Style::new().bg(Color::Red), Style::new().add_modifier(Modifier::BOLD)];
    for other in others {
        assert_ne!(draw(other), red);
    }
}
