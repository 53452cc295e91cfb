//! The sources that techniques cite, from `docs/references.bib`.

use biblatex::{Bibliography, ChunksExt, DateValue, Entry, PermissiveType};

const REFERENCES: &str = include_str!("../../../docs/references.bib");

/// All sources.
pub struct Sources(Bibliography);

impl Sources {
    /// Reads the list that is built in; one that cannot be read is empty (a test reads it).
    pub fn read() -> Self {
        Self(Bibliography::parse(REFERENCES).unwrap_or_default())
    }

    /// `Peters and Klein, Moment shadow mapping, 2015`; the key itself where it is not listed.
    pub fn line(&self, key: &str) -> String {
        let Some(entry) = self.0.get(key) else { return key.into() };
        let parts = [authors(entry), title(entry), year(entry)];
        parts.into_iter().flatten().collect::<Vec<_>>().join(", ")
    }
}

fn authors(entry: &Entry) -> Option<String> {
    let names: Vec<String> = entry.author().ok()?.into_iter().map(|person| person.name).collect();
    match names.as_slice() {
        [] => None,
        [one] => Some(one.clone()),
        [one, two] => Some(format!("{one} and {two}")),
        [first, ..] => Some(format!("{first} et al.")),
    }
}

fn title(entry: &Entry) -> Option<String> {
    Some(entry.title().ok()?.format_verbatim())
}

fn year(entry: &Entry) -> Option<String> {
    match entry.date().ok()? {
        PermissiveType::Typed(date) => match date.value {
            DateValue::At(at) | DateValue::After(at) | DateValue::Before(at) => {
                Some(at.year.to_string())
            }
            DateValue::Between(from, _) => Some(from.year.to_string()),
        },
        PermissiveType::Chunks(text) => Some(text.format_verbatim()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dapple_suite::problems;

    #[test]
    fn every_technique_has_an_author_a_title_and_a_year() {
        let sources = Sources::read();
        let mut seen = 0;
        for technique in problems::ALL.iter().flat_map(|p| p.spec().techniques) {
            let line = sources.line(technique.source);
            let year = line.rsplit(", ").next().and_then(|y| y.parse::<i32>().ok());
            assert!(year.is_some_and(|y| y > 1900), "{}: {line}", technique.id);
            assert!(line.split(", ").count() >= 3, "{}: {line}", technique.id);
            seen += 1;
        }
        assert!(seen > 10);
        assert_eq!(sources.line("nobody1900"), "nobody1900");
    }

    #[test]
    fn accents_and_braces_are_read() {
        let sources = Sources::read();
        assert_eq!(sources.line("peters2015"), "Peters and Klein, Moment shadow mapping, 2015");
        let line = sources.line("andersson2020");
        assert_eq!(
            line,
            "Andersson et al., FLIP: a difference evaluator for alternating images, 2020"
        );
        assert!(sources.line("gumbau2011").starts_with("Gumbau Portalés, "));
    }
}
