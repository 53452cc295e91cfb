//! What stands around a screen: tabs, trouble, keys, questions. The keys come from the table.

use crate::{
    jobs::Jobs,
    keys::{self, Action},
    screens::{Screen, World},
    theme::Theme,
    widgets::{bar, format, pane, popup, text},
};
use ratatui::{
    buffer::Buffer,
    layout::Rect,
    text::{Line, Span},
    widgets::{Paragraph, Widget},
};

/// The tabs in as much room as there is: whole names, short ones, numbers, or the current one.
pub fn tabs(current: Screen, width: u16, theme: Theme) -> Line<'static> {
    let short = |screen: Screen| screen.title().chars().take(4).collect::<String>();
    let labels: [&dyn Fn(usize, Screen) -> String; 3] = [
        &|i, screen| format!("{}{}", i + 1, screen.title()),
        &|i, screen| format!("{}{}", i + 1, short(screen)),
        &|i, screen| match screen == current {
            true => format!("{}{}", i + 1, screen.title()),
            false => format!("{}", i + 1),
        },
    ];
    for (level, label) in labels.iter().enumerate() {
        let spans: Vec<Span<'_>> = Screen::ALL
            .iter()
            .enumerate()
            .map(|(i, &screen)| match screen == current {
                true => Span::styled(format!("[{}]", label(i, screen)), theme.title()),
                false if level == 2 => Span::styled(label(i, screen), theme.dim()),
                false => Span::styled(format!(" {} ", label(i, screen)), theme.dim()),
            })
            .collect();
        let line = Line::from(spans);
        if line.width() <= usize::from(width) {
            return line;
        }
    }
    let at = Screen::ALL.iter().position(|s| *s == current).unwrap_or_default() + 1;
    Line::styled(format!("{at}/{} {}", Screen::ALL.len(), current.title()), theme.title())
}

/// What the user should know before reading on.
pub fn trouble(world: &World) -> Option<String> {
    let catalogue = world.catalogue_trouble.as_ref();
    let catalogue =
        catalogue.map(|why| format!("what there is could not be learnt: {why} (r: again)"));
    let all: Vec<String> = catalogue.into_iter().chain(world.store.complaint()).collect();
    (!all.is_empty()).then(|| all.join("; "))
}

/// As many of the screen's keys as fit, the way out first; a running job at the right.
pub fn footer(screen: Screen, world: &World, theme: Theme, area: Rect, buf: &mut Buffer) {
    let job = world.jobs.running().map(|job| {
        let share = bar::percent(job.done, job.total).map(|p| format!(" {p}%")).unwrap_or_default();
        let left = job.left_ms(world.now_ms).map(|ms| format!(" {} left", format::clock(ms)));
        format!(" {}{share}{}", job.title, left.unwrap_or_default())
    });
    let job = job.filter(|job| text::width(job) + 30 < usize::from(area.width)).unwrap_or_default();
    let room = usize::from(area.width).saturating_sub(text::width(&job));
    let labelled = || keys::on(screen).filter(|b| !b.label.is_empty());
    let last = |b: &&keys::Binding| matches!(b.action, Action::Quit | Action::Help);
    let mut line = String::new();
    for binding in labelled().filter(last).chain(labelled().filter(|b| !last(b))) {
        let more = format!("{} {}", binding.name, binding.label);
        let gap = if line.is_empty() { "" } else { "  " };
        if text::width(&line) + gap.len() + text::width(&more) > room {
            continue;
        }
        line = line + gap + &more;
    }
    let keys = Rect { width: room.min(area.width.into()) as u16, ..area };
    Line::styled(line, theme.dim()).render(keys, buf);
    let right = Rect { x: keys.right(), width: area.width - keys.width, ..area };
    Line::styled(job, theme.title()).render(right, buf);
}

/// The keys of a screen, from line `from` on.
pub fn help(screen: Screen, from: u16, theme: Theme, area: Rect, buf: &mut Buffer) {
    let mut pairs: Vec<_> = keys::on(screen).map(|b| pane::pair(b.name, b.help)).collect();
    pairs.push(pane::pair("Ctrl-C", "leave, also from a form"));
    let title = format!("{}: keys", screen.title());
    let height = pairs.len() as u16 + 2;
    let inside = popup::draw(&title, [58, height], theme, area, buf);
    let lines = pane::lines(&pairs, inside.width, theme);
    let most = (lines.len() as u16).saturating_sub(inside.height);
    let from = from.min(most);
    let shown: Vec<_> = lines.into_iter().skip(from.into()).take(inside.height.into()).collect();
    Paragraph::new(shown).render(inside, buf);
    // Where there is more, the frame's corner says which way.
    let more = match (from > 0, from < most) {
        (false, false) => return,
        (false, true) => " Down: more ",
        (true, false) => " Up: more ",
        (true, true) => " Up, Down: more ",
    };
    if inside.bottom() < area.bottom() && inside.width > 20 {
        Line::styled(more, theme.dim())
            .right_aligned()
            .render(Rect { y: inside.bottom(), height: 1, ..inside }, buf);
    }
}

/// Asks whether running jobs may be stopped.
pub fn ask(jobs: &Jobs, theme: Theme, area: Rect, buf: &mut Buffer) {
    let count = jobs.list.iter().filter(|job| !job.is_over()).count();
    let text = format!(
        "{} not done. q: stop and leave (finished rows are kept, a run can be resumed). \
         Any other key: stay.",
        format::plural(count, "job")
    );
    say("leave?", &text, theme, area, buf);
}

/// Says that the end takes a moment.
pub fn leaving(theme: Theme, area: Rect, buf: &mut Buffer) {
    say("leaving", "Waiting for what is at work to be written down.", theme, area, buf);
}

fn say(title: &str, words: &str, theme: Theme, area: Rect, buf: &mut Buffer) {
    let width = 56.min(area.width);
    let lines = text::wrap(words, usize::from(width.saturating_sub(2)).max(1));
    let inside = popup::draw(title, [width, lines.len() as u16 + 2], theme, area, buf);
    Paragraph::new(lines.into_iter().map(Line::from).collect::<Vec<_>>()).render(inside, buf);
}
