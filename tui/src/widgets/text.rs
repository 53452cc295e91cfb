//! Texts that must fit.

use ratatui::text::Span;

/// Columns that a text takes on the terminal.
pub fn width(text: &str) -> usize {
    Span::raw(text).width()
}

/// The text in at most `most` columns; what is cut off is marked with `…`.
pub fn fit(text: &str, most: usize) -> String {
    if width(text) <= most {
        return text.to_string();
    }
    let mut kept = String::new();
    let mut used = 0;
    for c in text.chars() {
        let wide = width(c.encode_utf8(&mut [0; 4]));
        if used + wide + 1 > most {
            break;
        }
        kept.push(c);
        used += wide;
    }
    if most > 0 {
        kept.push('…');
    }
    kept
}

/// Lines of at most `most` columns, broken between words; a word that is longer is broken itself.
/// Line feeds are kept. No columns, no lines.
pub fn wrap(text: &str, most: usize) -> Vec<String> {
    if most == 0 {
        return Vec::new();
    }
    let mut lines = Vec::new();
    for paragraph in text.lines() {
        let mut line = String::new();
        for word in paragraph.split_whitespace() {
            let gap = usize::from(!line.is_empty());
            if width(&line) + gap + width(word) <= most {
                if gap == 1 {
                    line.push(' ');
                }
                line.push_str(word);
                continue;
            }
            if !line.is_empty() {
                lines.push(std::mem::take(&mut line));
            }
            for c in word.chars() {
                if width(&line) + width(c.encode_utf8(&mut [0; 4])) > most && !line.is_empty() {
                    lines.push(std::mem::take(&mut line));
                }
                line.push(c);
            }
        }
        lines.push(line);
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_cut_is_marked() {
        assert_eq!(fit("texture", 7), "texture");
        assert_eq!(fit("texture", 4), "tex…");
        assert_eq!(fit("texture", 1), "…");
        assert_eq!(fit("texture", 0), "");
        // Two columns each.
        assert_eq!(fit("影影影", 5), "影影…");
        assert_eq!(fit("影影影", 4), "影…");
    }

    #[test]
    fn words_stay_whole_where_they_can() {
        assert_eq!(wrap("one two three", 7), ["one two", "three"]);
        assert_eq!(wrap("a\n\nb", 7), ["a", "", "b"]);
        assert_eq!(wrap("abcdefgh i", 3), ["abc", "def", "gh", "i"]);
        assert_eq!(wrap("影影", 1), ["影", "影"]);
        assert!(wrap("x", 0).is_empty() && wrap("", 5).is_empty());
    }
}
