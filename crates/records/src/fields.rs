//! Ordered writing and typed reading of flat JSON objects.

use std::collections::BTreeMap;

use serde::ser::{SerializeMap, Serializer};
use serde_json::{Map, Value};

use crate::error::RecordError;

/// Key and value pairs, written in the order given.
#[derive(Default)]
pub(crate) struct Object(Vec<(String, Value)>);

impl Object {
    pub(crate) fn new(kind: &str) -> Self {
        let mut object = Self::default();
        object.put("kind", kind);
        object.put("schema", crate::SCHEMA);
        object
    }

    /// A non-finite float becomes `null`.
    pub(crate) fn put(&mut self, key: impl Into<String>, value: impl Into<Value>) {
        self.0.push((key.into(), value.into()));
    }

    pub(crate) fn texts<const N: usize>(&mut self, pairs: [(&str, &String); N]) {
        for (key, text) in pairs {
            self.put(key, text.as_str());
        }
    }

    /// Leaves the key out where there is no value.
    pub(crate) fn maybe(&mut self, key: &str, value: Option<f64>) {
        if let Some(value) = value {
            self.put(key, value);
        }
    }

    /// Keys and values in the order given.
    pub(crate) fn into_pairs(self) -> Vec<(String, Value)> {
        self.0
    }

    /// One line without its line feed.
    pub(crate) fn to_line(&self) -> String {
        let mut bytes = Vec::with_capacity(1024);
        let mut serializer = serde_json::Serializer::new(&mut bytes);
        let written = serializer.serialize_map(Some(self.0.len())).and_then(|mut map| {
            for (key, value) in &self.0 {
                map.serialize_entry(key, value)?;
            }
            map.end()
        });
        debug_assert!(written.is_ok(), "string keys and plain values always serialise");
        String::from_utf8_lossy(&bytes).into_owned()
    }
}

/// A parsed object, read key by key; errors name the key.
pub(crate) struct Fields(Map<String, Value>);

impl Fields {
    pub(crate) fn parse(bytes: &[u8]) -> Result<Self, RecordError> {
        match serde_json::from_slice::<Value>(bytes) {
            Ok(Value::Object(map)) => Ok(Self(map)),
            Ok(other) => Err(RecordError::Json(format!("found {}", type_name(&other)))),
            Err(error) => Err(RecordError::Json(error.to_string())),
        }
    }

    pub(crate) fn required(&mut self, key: &str) -> Result<String, RecordError> {
        if !self.0.contains_key(key) {
            return Err(RecordError::Missing(key.to_owned()));
        }
        self.text(key)
    }

    /// Empty if absent or null.
    pub(crate) fn text(&mut self, key: &str) -> Result<String, RecordError> {
        match self.0.remove(key) {
            None | Some(Value::Null) => Ok(String::new()),
            Some(Value::String(text)) => Ok(text),
            Some(_) => Err(type_error(key, "a string")),
        }
    }

    /// False if absent or null.
    pub(crate) fn flag(&mut self, key: &str) -> Result<bool, RecordError> {
        match self.0.remove(key) {
            None | Some(Value::Null) => Ok(false),
            Some(Value::Bool(flag)) => Ok(flag),
            Some(_) => Err(type_error(key, "true or false")),
        }
    }

    /// Zero if absent or null.
    pub(crate) fn count(&mut self, key: &str) -> Result<u64, RecordError> {
        match self.0.remove(key) {
            None | Some(Value::Null) => Ok(0),
            Some(value) => as_count(key, &value),
        }
    }

    pub(crate) fn count32(&mut self, key: &str) -> Result<u32, RecordError> {
        u32::try_from(self.count(key)?).map_err(|_| type_error(key, "a count below 2^32"))
    }

    /// None if absent or null.
    pub(crate) fn number(&mut self, key: &str) -> Result<Option<f64>, RecordError> {
        match self.0.remove(key) {
            None | Some(Value::Null) => Ok(None),
            Some(value) => value.as_f64().map(Some).ok_or_else(|| type_error(key, "a number")),
        }
    }

    /// Numbers; a null among them reads as NaN.
    pub(crate) fn list(&mut self, key: &str) -> Result<Vec<f64>, RecordError> {
        let wrong = || type_error(key, "a list of numbers");
        match self.0.remove(key) {
            None | Some(Value::Null) => Ok(Vec::new()),
            Some(Value::Array(items)) => items
                .iter()
                .map(|v| if v.is_null() { Some(f64::NAN) } else { v.as_f64() }.ok_or_else(wrong))
                .collect(),
            Some(_) => Err(wrong()),
        }
    }

    pub(crate) fn texts(&mut self, key: &str) -> Result<Vec<String>, RecordError> {
        let wrong = || type_error(key, "a list of strings");
        match self.0.remove(key) {
            None | Some(Value::Null) => Ok(Vec::new()),
            Some(Value::Array(items)) => {
                items.iter().map(|v| v.as_str().map(str::to_owned).ok_or_else(wrong)).collect()
            }
            Some(_) => Err(wrong()),
        }
    }

    pub(crate) fn samples(&mut self, key: &str) -> Result<Vec<Vec<u64>>, RecordError> {
        let wrong = || type_error(key, "a list of lists of counts");
        let list = match self.0.remove(key) {
            None | Some(Value::Null) => return Ok(Vec::new()),
            Some(Value::Array(list)) => list,
            Some(_) => return Err(wrong()),
        };
        list.iter()
            .map(|repeat| {
                let frames = repeat.as_array().ok_or_else(wrong)?;
                frames.iter().map(|v| as_count(key, v)).collect()
            })
            .collect()
    }

    /// Takes every `PREFIX` NAME `SUFFIX` key; the name may contain anything but is not empty.
    fn take(&mut self, prefix: &str, suffix: &str) -> Vec<(String, String, Value)> {
        let name = |key: &str| -> Option<String> {
            let name = key.strip_prefix(prefix)?.strip_suffix(suffix)?;
            (!name.is_empty()).then(|| name.to_owned())
        };
        let keys: Vec<(String, String)> =
            self.0.keys().filter_map(|key| Some((key.clone(), name(key)?))).collect();
        keys.into_iter()
            .filter_map(|(key, name)| self.0.remove(&key).map(|value| (key, name, value)))
            .collect()
    }

    pub(crate) fn values(&mut self, prefix: &str) -> BTreeMap<String, Value> {
        self.take(prefix, "").into_iter().map(|(_, name, value)| (name, value)).collect()
    }

    /// Null reads as NaN: JSON has no other way to say "not finite".
    pub(crate) fn numbers(&mut self, prefix: &str) -> Result<BTreeMap<String, f64>, RecordError> {
        self.take(prefix, "")
            .into_iter()
            .map(|(key, name, value)| match value {
                Value::Null => Ok((name, f64::NAN)),
                other => {
                    let number = other.as_f64().ok_or_else(|| type_error(&key, "a number"))?;
                    Ok((name, number))
                }
            })
            .collect()
    }

    pub(crate) fn counts(
        &mut self,
        prefix: &str,
        suffix: &str,
    ) -> Result<BTreeMap<String, u64>, RecordError> {
        self.take(prefix, suffix)
            .into_iter()
            .map(|(key, name, value)| Ok((name, as_count(&key, &value)?)))
            .collect()
    }
}

/// Other tools write integers as `12.0`; that is accepted, a fraction or a negative value is not.
fn as_count(key: &str, value: &Value) -> Result<u64, RecordError> {
    let count = value.as_u64().or_else(|| whole(value.as_f64()?));
    count.ok_or_else(|| type_error(key, "a count"))
}

/// A float that is a count.
pub(crate) fn whole(value: f64) -> Option<u64> {
    let fits = (0.0..9_007_199_254_740_992.0).contains(&value) && value.fract() == 0.0;
    fits.then_some(value as u64)
}

pub(crate) fn type_error(key: &str, expected: &'static str) -> RecordError {
    RecordError::Type { key: key.to_owned(), expected }
}

fn type_name(value: &Value) -> &'static str {
    match value {
        Value::Null => "null",
        Value::Bool(_) => "true or false",
        Value::Number(_) => "a number",
        Value::String(_) => "a string",
        Value::Array(_) => "a list",
        Value::Object(_) => "an object",
    }
}
