//! A row as the index reads it: every key is checked, few are kept, nothing is copied.

use std::borrow::Cow;
use std::fmt;

use serde::de::{Deserialize, Deserializer, Error, MapAccess, SeqAccess, Visitor};

use crate::fields::whole;
use crate::row::{Row, Status, median_and_mad_ns, p99_ns};

/// What the index keeps of a row.
///
/// Reading one is stricter than reading a [`Row`], never looser: what is read here is a row, with
/// these values; what is not may still be one, which the full reader decides.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Brief<'a> {
    pub run: Cow<'a, str>,
    pub row: Cow<'a, str>,
    pub group: Cow<'a, str>,
    pub technique: Cow<'a, str>,
    pub variant: Cow<'a, str>,
    pub form: Cow<'a, str>,
    /// Problem, case, scene hash, view, size, truth, machine, adapter, device: as in
    /// [`crate::front::Key`].
    pub key: [Cow<'a, str>; 9],
    pub time: Cow<'a, str>,
    pub status: super::Ended,
    pub clock: Cow<'a, str>,
    pub median_ns: Option<f64>,
    pub mad_ns: Option<f64>,
    pub p99_ns: Option<f64>,
    pub memory_bytes: u64,
    /// By name.
    pub errors: Vec<(Cow<'a, str>, f64)>,
    /// By name.
    pub counters: Vec<(Cow<'a, str>, u64)>,
}

impl<'a> Brief<'a> {
    /// Of a whole row.
    pub(crate) fn of(row: &'a Row) -> Self {
        let text = |text: &'a String| Cow::Borrowed(text.as_str());
        Self {
            run: text(&row.run),
            row: text(&row.row),
            group: text(&row.group),
            technique: text(&row.technique),
            variant: text(&row.variant),
            form: text(&row.form),
            key: [
                text(&row.problem),
                text(&row.case),
                text(&row.scene_hash),
                text(&row.view),
                text(&row.size),
                text(&row.truth),
                text(&row.machine),
                text(&row.adapter),
                text(&row.device),
            ],
            time: text(&row.time),
            status: match row.status {
                Status::Ok => super::Ended::Ok,
                Status::Failed { .. } => super::Ended::Failed,
                Status::NotRun { .. } => super::Ended::NotRun,
            },
            clock: text(&row.clock),
            median_ns: row.median_ns(),
            mad_ns: row.mad_ns(),
            p99_ns: row.p99_ns(),
            memory_bytes: row.memory_bytes,
            errors: row.errors.iter().map(|(name, v)| (text(name), *v)).collect(),
            counters: row.counters.iter().map(|(name, v)| (text(name), *v)).collect(),
        }
    }

    /// Of a line; none for what the full reader must decide.
    pub(crate) fn parse(line: &'a [u8]) -> Option<Self> {
        serde_json::from_slice(line).ok()
    }
}

const SCHEMA: u64 = crate::SCHEMA as u64;

/// Reads the object.
struct Keys;

impl<'de> Deserialize<'de> for Brief<'de> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(Keys)
    }
}

impl<'de> Visitor<'de> for Keys {
    type Value = Brief<'de>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a row")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Brief<'de>, A::Error> {
        let mut brief = Brief::default();
        // One bit for each required key.
        let mut seen = 0_u16;
        let mut samples: Vec<Vec<u64>> = Vec::new();
        while let Some(Text(name)) = map.next_key::<Text<'de>>()? {
            if name.contains('.') {
                with_prefix(&name, &mut map, &mut brief)?;
                continue;
            }
            let mut required = |bit: u16, text: Cow<'de, str>| {
                seen |= 1 << bit;
                text
            };
            match &*name {
                "kind" if map.next_value::<Text>()?.0 == "row" => seen |= 1,
                "schema" if (1..=SCHEMA).contains(&map.next_value::<Count>()?.0) => seen |= 1 << 1,
                "kind" | "schema" => return Err(A::Error::custom("not a row of ours")),
                "run" => brief.run = required(2, text(&mut map)?),
                "row" => brief.row = required(3, text(&mut map)?),
                "technique" => brief.technique = required(4, text(&mut map)?),
                "form" => brief.form = required(5, text(&mut map)?),
                "problem" => brief.key[0] = required(6, text(&mut map)?),
                "case" => brief.key[1] = required(7, text(&mut map)?),
                "status" => {
                    seen |= 1 << 8;
                    brief.status = match &*text(&mut map)? {
                        "ok" => super::Ended::Ok,
                        "failed" => super::Ended::Failed,
                        "not_run" => super::Ended::NotRun,
                        _ => return Err(A::Error::custom("an unknown status")),
                    }
                }
                "scene_hash" => brief.key[2] = text(&mut map)?,
                "view" => brief.key[3] = text(&mut map)?,
                "size" => brief.key[4] = text(&mut map)?,
                "truth" => brief.key[5] = text(&mut map)?,
                "machine" => brief.key[6] = text(&mut map)?,
                "adapter" => brief.key[7] = text(&mut map)?,
                "device" => brief.key[8] = text(&mut map)?,
                "group" => brief.group = text(&mut map)?,
                "variant" => brief.variant = text(&mut map)?,
                "time" => brief.time = text(&mut map)?,
                "clock" => brief.clock = text(&mut map)?,
                "stage" | "reason" | "scene" | "driver" | "cpu" | "revision" | "shader_hash"
                | "baseline" => drop(text(&mut map)?),
                "threads" => {
                    let Count(threads) = map.next_value()?;
                    u32::try_from(threads).map_err(A::Error::custom)?;
                }
                "dirty" => drop(map.next_value::<Option<bool>>()?),
                "ratio" => {
                    map.next_value::<Number>()?;
                }
                "memory_bytes" => brief.memory_bytes = map.next_value::<Count>()?.0,
                "samples_ns" => {
                    let list: Option<Vec<Vec<Count>>> = map.next_value()?;
                    let plain = |list: Vec<Count>| list.into_iter().map(|c| c.0).collect();
                    samples = list.unwrap_or_default().into_iter().map(plain).collect();
                }
                _ => {
                    map.next_value::<Anything>()?;
                }
            }
        }
        if seen != 0x1ff {
            return Err(A::Error::custom("a key is missing"));
        }
        sort(&mut brief.errors);
        sort(&mut brief.counters);
        (brief.median_ns, brief.mad_ns) = median_and_mad_ns(&samples).unzip();
        brief.p99_ns = p99_ns(&samples);
        Ok(brief)
    }
}

/// Keys made of a prefix and a name.
fn with_prefix<'de, A: MapAccess<'de>>(
    key: &Cow<'de, str>,
    map: &mut A,
    brief: &mut Brief<'de>,
) -> Result<(), A::Error> {
    if let Some(name) = named(key, "error.", "") {
        brief.errors.push((name, map.next_value::<Number>()?.0));
    } else if let Some(name) = named(key, "counter.", "") {
        let Count(count) = map.next_value::<Option<Count>>()?.ok_or_else(null)?;
        brief.counters.push((name, count));
    } else if named(key, "port.", "").is_some() {
        map.next_value::<Number>()?;
    } else if named(key, "pass.", "_ns").is_some() {
        map.next_value::<Option<Count>>()?.ok_or_else(null)?;
    } else {
        map.next_value::<Anything>()?;
    }
    Ok(())
}

fn null<E: Error>() -> E {
    E::custom("null is no count")
}

fn text<'de, A: MapAccess<'de>>(map: &mut A) -> Result<Cow<'de, str>, A::Error> {
    Ok(map.next_value::<Text<'de>>()?.0)
}

/// `PREFIX` NAME `SUFFIX`; the name is not empty.
fn named<'a>(key: &Cow<'a, str>, prefix: &str, suffix: &str) -> Option<Cow<'a, str>> {
    let name = match key {
        Cow::Borrowed(key) => Cow::Borrowed(key.strip_prefix(prefix)?.strip_suffix(suffix)?),
        Cow::Owned(key) => Cow::Owned(key.strip_prefix(prefix)?.strip_suffix(suffix)?.to_owned()),
    };
    (!name.is_empty()).then_some(name)
}

/// By name; of a key that is there twice the last counts.
fn sort<T>(list: &mut Vec<(Cow<'_, str>, T)>) {
    list.reverse();
    list.sort_by(|a, b| a.0.cmp(&b.0));
    list.dedup_by(|a, b| a.0 == b.0);
}

/// A string; null is the empty one.
struct Text<'a>(Cow<'a, str>);

/// A count, also one written as a float; null is none, 0.
#[derive(Clone, Copy)]
struct Count(u64);

/// A number; null is NaN.
struct Number(f64);

/// Any value, read to its end as the full reader would, and dropped. (Serde's own way to ignore a
/// value would pass over text that is not Unicode, and any nesting.)
struct Anything;

impl<'de> Deserialize<'de> for Text<'de> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Visit;
        impl<'de> Visitor<'de> for Visit {
            type Value = Text<'de>;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a string")
            }
            fn visit_borrowed_str<E: Error>(self, text: &'de str) -> Result<Text<'de>, E> {
                Ok(Text(Cow::Borrowed(text)))
            }
            fn visit_str<E: Error>(self, text: &str) -> Result<Text<'de>, E> {
                Ok(Text(Cow::Owned(text.to_owned())))
            }
            fn visit_unit<E: Error>(self) -> Result<Text<'de>, E> {
                Ok(Text(Cow::Borrowed("")))
            }
        }
        deserializer.deserialize_any(Visit)
    }
}

impl<'de> Deserialize<'de> for Count {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Visit;
        impl Visitor<'_> for Visit {
            type Value = Count;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a count")
            }
            fn visit_u64<E: Error>(self, count: u64) -> Result<Count, E> {
                Ok(Count(count))
            }
            fn visit_f64<E: Error>(self, value: f64) -> Result<Count, E> {
                whole(value).map(Count).ok_or_else(|| E::custom("a fraction"))
            }
            fn visit_unit<E: Error>(self) -> Result<Count, E> {
                Ok(Count(0))
            }
        }
        deserializer.deserialize_any(Visit)
    }
}

impl<'de> Deserialize<'de> for Number {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let number: Option<f64> = Option::deserialize(deserializer)?;
        Ok(Self(number.unwrap_or(f64::NAN)))
    }
}

impl<'de> Deserialize<'de> for Anything {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Visit;
        impl<'de> Visitor<'de> for Visit {
            type Value = Anything;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("any value")
            }
            fn visit_bool<E: Error>(self, _: bool) -> Result<Anything, E> {
                Ok(Anything)
            }
            fn visit_u64<E: Error>(self, _: u64) -> Result<Anything, E> {
                Ok(Anything)
            }
            fn visit_i64<E: Error>(self, _: i64) -> Result<Anything, E> {
                Ok(Anything)
            }
            fn visit_f64<E: Error>(self, _: f64) -> Result<Anything, E> {
                Ok(Anything)
            }
            fn visit_str<E: Error>(self, _: &str) -> Result<Anything, E> {
                Ok(Anything)
            }
            fn visit_unit<E: Error>(self) -> Result<Anything, E> {
                Ok(Anything)
            }
            fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Anything, A::Error> {
                while seq.next_element::<Anything>()?.is_some() {}
                Ok(Anything)
            }
            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Anything, A::Error> {
                while map.next_entry::<Text<'de>, Anything>()?.is_some() {}
                Ok(Anything)
            }
        }
        deserializer.deserialize_any(Visit)
    }
}
