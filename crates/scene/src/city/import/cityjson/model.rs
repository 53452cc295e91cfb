//! The parts of a CityJSON file that are read, as `serde` sees them.

use serde::Deserialize;
use serde_json::Value;
use std::collections::BTreeMap;

/// Versions whose structure this is.
pub const VERSIONS: [&str; 3] = ["1.0", "1.1", "2.0"];

/// The whole file.
#[derive(Deserialize)]
pub struct File {
    /// From stored to world coordinates; the identity if absent.
    pub transform: Option<Transform>,
    /// By id, so in an order that does not depend on the file's.
    #[serde(rename = "CityObjects")]
    pub objects: BTreeMap<String, Object>,
    pub vertices: Vec<[f64; 3]>,
    #[serde(default)]
    pub metadata: Metadata,
}

/// The least that tells whether a file is CityJSON.
#[derive(Deserialize)]
pub struct Head {
    #[serde(rename = "type")]
    pub kind: Option<Value>,
    pub version: Option<Value>,
}

#[derive(Deserialize)]
pub struct Transform {
    pub scale: [f64; 3],
    pub translate: [f64; 3],
}

#[derive(Default, Deserialize)]
pub struct Metadata {
    /// The coordinate reference system, a URL or URN.
    #[serde(rename = "referenceSystem")]
    pub reference_system: Option<String>,
}

#[derive(Deserialize)]
pub struct Object {
    #[serde(rename = "type")]
    pub kind: String,
    #[serde(default)]
    pub geometry: Vec<Geometry>,
    #[serde(default)]
    pub parents: Vec<String>,
    #[serde(default)]
    pub attributes: BTreeMap<String, Value>,
}

#[derive(Deserialize)]
pub struct Geometry {
    #[serde(rename = "type")]
    pub kind: String,
    /// A string since 1.1, a number before.
    pub lod: Option<Value>,
    /// Nested as deep as the type asks for.
    #[serde(default)]
    pub boundaries: Value,
    pub semantics: Option<Semantics>,
}

#[derive(Deserialize)]
pub struct Semantics {
    pub surfaces: Vec<Surface>,
    /// Nested like the boundaries, down to the surfaces.
    #[serde(default)]
    pub values: Value,
}

#[derive(Deserialize)]
pub struct Surface {
    #[serde(rename = "type")]
    pub kind: String,
}

impl Geometry {
    /// Level of detail, 0 if none is given.
    pub fn level(&self) -> f64 {
        match &self.lod {
            Some(Value::String(text)) => text.parse().unwrap_or(0.0),
            Some(value) => value.as_f64().unwrap_or(0.0),
            None => 0.0,
        }
    }
}
