//! A scatter of error against time as SVG: log axes, the front as a step line.

use self::Shape::{Circle, Cross, Diamond, Down, Plus, Square, Up};
use crate::text::{duration, significant};
use maud::{Markup, html};

/// A point of the plot.
#[derive(Clone, Debug, PartialEq)]
pub struct Dot {
    /// Time, > 0, finite.
    pub time_ns: f64,
    /// Error, >= 0, finite.
    pub error: f64,
    /// Which series: decides shape and colour.
    pub series: usize,
    /// On the front.
    pub on_front: bool,
    /// For the tooltip.
    pub label: String,
}

/// Columns and rows of the drawing, in its own units.
const SIZE: [f64; 2] = [760.0, 420.0];
/// The frame: left, top, right, bottom.
const FRAME: [f64; 4] = [70.0, 14.0, 745.0, 370.0];
/// Height of the band at the bottom that holds errors of exactly zero.
const ZERO_BAND: f64 = 26.0;

#[derive(Clone, Copy)]
enum Shape {
    Circle,
    Square,
    Up,
    Diamond,
    Cross,
    Plus,
    Down,
}

const SHAPES: [Shape; 7] = [Circle, Square, Up, Diamond, Cross, Plus, Down];
const COLOURS: usize = 7;

/// A logarithmic axis from values to the drawing.
pub(super) struct Axis {
    least: f64,
    greatest: f64,
    from: f64,
    to: f64,
}

impl Axis {
    /// Spans the values with a little room; a single value gets a factor of 2 on both sides.
    pub(super) fn spanning(values: impl Iterator<Item = f64>, from: f64, to: f64) -> Self {
        let (mut least, mut greatest) = (f64::INFINITY, 0.0_f64);
        for value in values.filter(|v| v.is_finite() && *v > 0.0) {
            (least, greatest) = (least.min(value), greatest.max(value));
        }
        if least > greatest {
            (least, greatest) = (1.0, 1.0);
        }
        let room = if least == greatest { 2.0 } else { (greatest / least).powf(0.06).max(1.05) };
        // Kept finite and above zero at the ends of f64.
        let least = (least / room).max(f64::MIN_POSITIVE);
        Self { least, greatest: (greatest * room).min(f64::MAX), from, to }
    }

    pub(super) fn at(&self, value: f64) -> f64 {
        let share = (value.ln() - self.least.ln()) / (self.greatest.ln() - self.least.ln());
        self.from + share * (self.to - self.from)
    }

    /// Round values: decades, with 2 and 5 between them where there are few.
    pub(super) fn ticks(&self) -> Vec<f64> {
        let (low, high) = (self.least.log10().floor() as i32, self.greatest.log10().ceil() as i32);
        let decades = high - low;
        let step = (decades / 8).max(1);
        let within: &[f64] = if decades <= 3 { &[1.0, 2.0, 5.0] } else { &[1.0] };
        (low..=high)
            .filter(|e| (e - low) % step == 0)
            .flat_map(|e| within.iter().map(move |m| m * 10_f64.powi(e)))
            .filter(|v| (self.least..=self.greatest).contains(v))
            .collect()
    }
}

/// Draws the dots; `title` and `description` are for those who cannot see them.
pub fn scatter(title: &str, description: &str, metric: &str, dots: &[Dot]) -> Markup {
    let [left, top, right, bottom] = FRAME;
    let zero = dots.iter().any(|d| d.error == 0.0);
    let floor = if zero { bottom - ZERO_BAND } else { bottom };
    let x = Axis::spanning(dots.iter().map(|d| d.time_ns), left, right);
    let y = Axis::spanning(dots.iter().map(|d| d.error), floor, top);
    let height = |error: f64| if error == 0.0 { bottom - ZERO_BAND / 2.0 } else { y.at(error) };
    html! {
        svg.plot viewBox={"0 0 " (SIZE[0]) " " (SIZE[1])} role="img" {
            title { (title) }
            desc { (description) }
            @for tick in x.ticks() {
                @let at = round(x.at(tick));
                line.grid x1=(at) x2=(at) y1=(top) y2=(bottom) {}
                text.tick x=(at) y=(bottom + 18.0) text-anchor="middle" { (duration(tick)) }
            }
            @for tick in y.ticks() {
                @let at = round(y.at(tick));
                line.grid x1=(left) x2=(right) y1=(at) y2=(at) {}
                text.tick x=(left - 6.0) y=(at + 4.0) text-anchor="end" { (plain(tick)) }
            }
            @if zero {
                rect.zero x=(left) y=(floor) width=(right - left) height=(ZERO_BAND) {}
                text.tick x=(left - 6.0) y=(bottom - ZERO_BAND / 2.0 + 4.0) text-anchor="end" { "0" }
            }
            rect.frame x=(left) y=(top) width=(right - left) height=(bottom - top) {}
            text x=((left + right) / 2.0) y=(SIZE[1] - 8.0) text-anchor="middle" { "time a frame (log)" }
            text x="14" y=((top + bottom) / 2.0) text-anchor="middle"
                transform={"rotate(-90 14 " ((top + bottom) / 2.0) ")"} { (metric) " (log)" }
            path.step d=(steps(dots, &|d| (x.at(d.time_ns), height(d.error)), right, top)) {}
            @for dot in dots {
                g {
                    title { (dot.label) }
                    (mark(dot.series, dot.on_front, x.at(dot.time_ns), height(dot.error)))
                }
            }
        }
    }
}

/// The sign of a series, for a legend.
pub fn sign(series: usize) -> Markup {
    html! { svg viewBox="0 0 16 16" aria-hidden="true" { (mark(series, true, 8.0, 8.0)) } }
}

/// What is attainable: right of a point on the front nothing worse need be accepted, so the line
/// runs level to the next and then falls.
fn steps(dots: &[Dot], at: &dyn Fn(&Dot) -> (f64, f64), right: f64, top: f64) -> String {
    let mut front: Vec<_> = dots.iter().filter(|d| d.on_front).map(at).collect();
    front.sort_by(|a, b| a.0.total_cmp(&b.0));
    let Some(first) = front.first() else { return String::new() };
    let mut path = format!("M{} {}", round(first.0), round(top));
    for (x, y) in front {
        path += &format!("H{}V{}", round(x), round(y));
    }
    path + &format!("H{}", round(right))
}

/// Shape and colour together name the series; the front's are drawn stronger.
fn mark(series: usize, on_front: bool, x: f64, y: f64) -> Markup {
    let r = if on_front { 5.0 } else { 3.8 };
    let class = format!("mark s{}{}", series % COLOURS, if on_front { " on" } else { "" });
    // Shapes advance a step further each time round the colours, so that no pair repeats early.
    let shape = SHAPES[(series + series / COLOURS) % SHAPES.len()];
    let p = |dx: f64, dy: f64| format!("{} {}", round(x + dx * r), round(y + dy * r));
    let path = match shape {
        Circle => {
            return html! { circle class=(class) cx=(round(x)) cy=(round(y)) r=(r) {} };
        }
        Square => {
            format!("M{}L{}L{}L{}Z", p(-1., -1.), p(1., -1.), p(1., 1.), p(-1., 1.))
        }
        Up => format!("M{}L{}L{}Z", p(0., -1.2), p(1.1, 0.8), p(-1.1, 0.8)),
        Down => format!("M{}L{}L{}Z", p(0., 1.2), p(1.1, -0.8), p(-1.1, -0.8)),
        Diamond => {
            format!("M{}L{}L{}L{}Z", p(0., -1.3), p(1.3, 0.), p(0., 1.3), p(-1.3, 0.))
        }
        Cross => format!("M{}L{}M{}L{}", p(-1., -1.), p(1., 1.), p(-1., 1.), p(1., -1.)),
        Plus => format!("M{}L{}M{}L{}", p(0., -1.2), p(0., 1.2), p(-1.2, 0.), p(1.2, 0.)),
    };
    html! { path class=(class) d=(path) {} }
}

/// A tenth of a unit is finer than any screen shows.
fn round(x: f64) -> f64 {
    (x * 10.0).round() / 10.0
}

/// A tick's value without trailing zeros.
fn plain(x: f64) -> String {
    if (1e-4..1e5).contains(&x) {
        let text = format!("{x:.6}");
        text.trim_end_matches('0').trim_end_matches('.').into()
    } else {
        significant(x)
    }
}
