//! What can go wrong with a scene, naming the file or scene, the element and the limit.

/// Why a scene was refused.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// A file is missing or unreadable.
    #[error("{file}: cannot be read: {source}")]
    Read {
        /// Path as given.
        file: String,
        /// The system's reason.
        source: std::io::Error,
    },
    /// A file cannot be written.
    #[error("{file}: cannot be written: {source}")]
    Write {
        /// Path as given.
        file: String,
        /// The system's reason.
        source: std::io::Error,
    },
    /// Not one of the formats read here.
    #[error("{file}: extension \"{extension}\" is not read here; known: {known}")]
    Extension {
        /// Path as given.
        file: String,
        /// Its extension, possibly empty.
        extension: String,
        /// The extensions that are read.
        known: &'static str,
    },
    /// The file does not follow its format, or uses a part of it that is not supported.
    #[error("{file}: {element}: {reason}")]
    Format {
        /// Path as given.
        file: String,
        /// The part of the file at fault, e.g. `accessor 3` or `line 12, face 4`.
        element: String,
        /// What is wrong, with the limit.
        reason: String,
    },
    /// The data are well formed, but not a scene that can be worked with.
    #[error("{scene}: {element}: {limit}")]
    Invalid {
        /// Scene name or file path.
        scene: String,
        /// The element at fault, e.g. `mesh 3 "leaf", vertex 17`.
        element: String,
        /// The rule it breaks, with the value found.
        limit: String,
    },
}

impl SceneError {
    pub(crate) fn format(
        file: &str,
        element: impl Into<String>,
        reason: impl std::fmt::Display,
    ) -> Self {
        Self::Format { file: file.into(), element: element.into(), reason: reason.to_string() }
    }
}
