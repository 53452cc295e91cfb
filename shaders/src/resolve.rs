//! Textual imports: `#import common/index.wgsl` on a line of its own.

/// What can be wrong with a shader file.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ShaderError {
    /// A file that is not embedded.
    #[error("{from}: no shader file `{path}`")]
    Unknown {
        /// The file asked for.
        path: String,
        /// `file:line` of the import, or `source()` where the caller asked.
        from: String,
    },
    /// A file that imports itself, directly or through others.
    #[error("{from}: import of `{path}` closes a cycle")]
    Cycle {
        /// The file imported again.
        path: String,
        /// `file:line` of the import.
        from: String,
    },
    /// Text that naga does not parse.
    #[error("{path}: {message}")]
    Parse {
        /// The file, or a name for the text.
        path: String,
        /// naga's message with the lines concerned, of the resolved text.
        message: String,
    },
    /// A module that naga parses but finds invalid.
    #[error("{path}: {message}")]
    Invalid {
        /// The file, or a name for the text.
        path: String,
        /// naga's message with the lines concerned, of the resolved text.
        message: String,
    },
    /// A struct that the text does not declare.
    #[error("no struct `{name}`; there are: {have}")]
    NoStruct {
        /// The struct asked for.
        name: String,
        /// The structs there are.
        have: String,
    },
}

type Lookup<'a> = &'a dyn Fn(&str) -> Option<&'static str>;

/// Resolves `path` over the files that `lookup` knows.
pub(crate) fn resolve(path: &str, lookup: Lookup<'_>) -> Result<String, ShaderError> {
    let mut state = State { lookup, open: Vec::new(), done: Vec::new(), enables: Vec::new() };
    let mut body = String::new();
    state.append(path, "source()", &mut body)?;
    let mut text = String::new();
    for enable in &state.enables {
        text.push_str(enable);
        text.push('\n');
    }
    text.push_str(&body);
    Ok(text)
}

struct State<'a> {
    lookup: Lookup<'a>,
    open: Vec<String>,
    done: Vec<String>,
    enables: Vec<String>,
}

impl State<'_> {
    fn append(&mut self, path: &str, from: &str, out: &mut String) -> Result<(), ShaderError> {
        if self.open.iter().any(|open| open == path) {
            return Err(ShaderError::Cycle { path: path.into(), from: from.into() });
        }
        if self.done.iter().any(|done| done == path) {
            return Ok(());
        }
        let text = (self.lookup)(path)
            .ok_or_else(|| ShaderError::Unknown { path: path.into(), from: from.into() })?;
        self.open.push(path.into());
        for (number, line) in text.lines().enumerate() {
            let trimmed = line.trim();
            if let Some(import) = trimmed.strip_prefix("#import ") {
                self.append(import.trim(), &format!("{path}:{}", number + 1), out)?;
            } else if trimmed.starts_with("enable ") {
                if !self.enables.iter().any(|known| known == trimmed) {
                    self.enables.push(trimmed.into());
                }
            } else {
                out.push_str(line);
                out.push('\n');
            }
        }
        self.open.pop();
        self.done.push(path.into());
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn files(
        list: &'static [(&'static str, &'static str)],
    ) -> impl Fn(&str) -> Option<&'static str> {
        move |path| list.iter().find(|(known, _)| *known == path).map(|(_, text)| *text)
    }

    #[test]
    fn imports_are_depth_first_and_each_file_once() {
        let list = files(&[
            ("main", "#import a\n#import b\nmain"),
            ("a", "#import c\na"),
            ("b", "#import c\nb"),
            ("c", "c"),
        ]);
        assert_eq!(resolve("main", &list).unwrap(), "c\na\nb\nmain\n");
    }

    #[test]
    fn enable_directives_move_to_the_top_once() {
        let list = files(&[("main", "enable f16;\n#import a\nmain"), ("a", "enable f16;\na")]);
        assert_eq!(resolve("main", &list).unwrap(), "enable f16;\na\nmain\n");
    }

    #[test]
    fn an_unknown_import_names_file_and_line() {
        let list = files(&[("main", "one\n#import gone")]);
        let error = resolve("main", &list).unwrap_err();
        assert_eq!(error, ShaderError::Unknown { path: "gone".into(), from: "main:2".into() });
        assert_eq!(error.to_string(), "main:2: no shader file `gone`");
        let error = resolve("nowhere", &list).unwrap_err();
        assert_eq!(error.to_string(), "source(): no shader file `nowhere`");
    }

    #[test]
    fn cycles_are_refused_where_they_close() {
        let list = files(&[("a", "#import b"), ("b", "\n\n#import a")]);
        let error = resolve("a", &list).unwrap_err();
        assert_eq!(error, ShaderError::Cycle { path: "a".into(), from: "b:3".into() });
        let own = files(&[("a", "#import a")]);
        assert!(matches!(resolve("a", &own), Err(ShaderError::Cycle { .. })));
    }
}
