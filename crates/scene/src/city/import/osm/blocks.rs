//! Nodes, ways and relations of a PBF file.
//!
//! Messages are decoded by `prost`, blocks inflated by `flate2`; sums of differences and references
//! are checked here. (The crate `osmpbf` adds them unchecked and panics on a member of an unknown
//! kind.)

use super::wire;
use crate::SceneError;
use crate::city::import::Source;
use prost::Message;
use std::collections::{BTreeMap, HashMap};
use std::io::Read;

/// Largest file: its nodes take several times as much memory.
const MOST_BYTES: usize = 128 << 20;
/// Limits of the format.
const MOST_HEADER_BYTES: usize = 64 << 10;
const MOST_BLOCK_BYTES: u64 = 32 << 20;
/// Blocks together, inflated.
const MOST_INFLATED_BYTES: u64 = 4 << 30;
/// What a reader has to know of, all of which is read here.
const FEATURES: [&str; 2] = ["OsmSchema-V0.6", "DenseNodes"];
/// Keys whose values are kept.
const KEYS: [&str; 15] = [
    "area",
    "building",
    "building:levels",
    "diameter_crown",
    "height",
    "highway",
    "layer",
    "lit",
    "location",
    "min_height",
    "natural",
    "tunnel",
    "type",
    "water",
    "width",
];

/// Kept tags.
pub type Tags = BTreeMap<&'static str, String>;

/// What a file holds.
#[derive(Default)]
pub struct Data {
    /// Latitude and longitude in nanodegrees. For look-ups alone: its order is not defined.
    pub nodes: HashMap<i64, [i64; 2]>,
    /// Nodes with tags that are kept.
    pub points: BTreeMap<i64, Tags>,
    pub ways: BTreeMap<i64, Way>,
    pub relations: BTreeMap<i64, Relation>,
}

pub struct Way {
    pub nodes: Vec<i64>,
    pub tags: Tags,
}

pub struct Relation {
    pub members: Vec<Member>,
    pub tags: Tags,
}

/// A way that takes part in a relation.
pub struct Member {
    pub way: i64,
    /// A hole rather than an outer ring.
    pub inner: bool,
}

/// Reads all blocks.
pub fn read(source: &Source<'_>) -> Result<Data, SceneError> {
    let bytes = source.bytes;
    if bytes.len() > MOST_BYTES {
        let reason =
            format!("{} bytes, at most {MOST_BYTES} are read: cut out a district", bytes.len());
        return Err(source.error("file", reason));
    }
    let (mut data, mut at, mut inflated, mut seen_header) = (Data::default(), 0usize, 0u64, false);
    while at < bytes.len() {
        let start = at;
        let bad = |reason: String| source.error(format!("blob at byte {start}"), reason);
        let mut take = |what: &str, size: usize| {
            let taken = bytes.get(at..).and_then(|rest| rest.get(..size));
            at += size;
            taken.ok_or_else(|| {
                bad(format!("{what} of {size} bytes, but the file has {} bytes", bytes.len()))
            })
        };
        let size = take("a length", 4)?;
        let size = size.iter().fold(0usize, |n, &b| n << 8 | usize::from(b));
        if size > MOST_HEADER_BYTES {
            return Err(bad(format!(
                "a header of {size} bytes, at most {MOST_HEADER_BYTES} are allowed"
            )));
        }
        let header = wire::BlobHeader::decode(take("a header", size)?)
            .map_err(|e| bad(format!("header: {e}")))?;
        let size = usize::try_from(header.size)
            .map_err(|_| bad(format!("a block of {} bytes", header.size)))?;
        let blob = wire::Blob::decode(take("a block", size)?).map_err(|e| bad(e.to_string()))?;
        let block = match header.kind.as_str() {
            "OSMHeader" | "OSMData" => inflate(blob).map_err(&bad)?,
            // Others are to be passed over, says the format.
            _ => continue,
        };
        inflated += block.len() as u64;
        if inflated > MOST_INFLATED_BYTES {
            return Err(bad(format!("more than {MOST_INFLATED_BYTES} bytes when inflated")));
        }
        if header.kind == "OSMHeader" {
            let header = wire::HeaderBlock::decode(&block[..]).map_err(|e| bad(e.to_string()))?;
            seen_header = true;
            let unknown = header.required_features.iter().find(|f| !FEATURES.contains(&f.as_str()));
            if let Some(feature) = unknown {
                return Err(bad(format!("needs \"{feature}\", which is not read here")));
            }
        } else if !seen_header {
            return Err(bad("data before any header".into()));
        } else {
            let block = wire::PrimitiveBlock::decode(&block[..]).map_err(|e| bad(e.to_string()))?;
            Block::new(&block).add_to(&mut data).map_err(&bad)?;
        }
    }
    if !seen_header {
        return Err(source.error("file", "no OpenStreetMap header"));
    }
    Ok(data)
}

fn inflate(blob: wire::Blob) -> Result<Vec<u8>, String> {
    if let Some(raw) = blob.raw {
        return Ok(raw);
    }
    let packed = blob.zlib.ok_or("packed otherwise than by zlib, which is not read here")?;
    let mut block = vec![];
    let most = MOST_BLOCK_BYTES + 1;
    flate2::read::ZlibDecoder::new(&packed[..])
        .take(most)
        .read_to_end(&mut block)
        .map_err(|e| format!("cannot be inflated: {e}"))?;
    if block.len() as u64 == most {
        return Err(format!("more than {MOST_BLOCK_BYTES} bytes when inflated"));
    }
    Ok(block)
}

/// A running sum of differences.
#[derive(Default)]
struct Sum(i64);

impl Sum {
    fn add(&mut self, difference: i64) -> Result<i64, String> {
        let sum = self.0.checked_add(difference);
        self.0 = sum.ok_or_else(|| format!("differences overflow: {} + {difference}", self.0))?;
        Ok(self.0)
    }
}

/// A block with its strings.
struct Block<'a> {
    block: &'a wire::PrimitiveBlock,
    strings: &'a [Vec<u8>],
}

impl<'a> Block<'a> {
    fn new(block: &'a wire::PrimitiveBlock) -> Self {
        let strings = block.strings.as_ref().map_or(&[][..], |t| &t.s[..]);
        Self { block, strings }
    }

    fn add_to(&self, data: &mut Data) -> Result<(), String> {
        for group in &self.block.groups {
            for node in &group.nodes {
                let tags = self.tags(&node.keys, &node.vals)?;
                self.node(data, node.id, node.lat, node.lon, tags)?;
            }
            if let Some(dense) = &group.dense {
                self.dense(data, dense)?;
            }
            for way in &group.ways {
                let tags = self.tags(&way.keys, &way.vals)?;
                let mut sum = Sum::default();
                let nodes = way.refs.iter().map(|&d| sum.add(d)).collect::<Result<_, _>>()?;
                data.ways.insert(way.id, Way { nodes, tags });
            }
            for relation in &group.relations {
                self.relation(data, relation)?;
            }
        }
        Ok(())
    }

    fn dense(&self, data: &mut Data, dense: &wire::DenseNodes) -> Result<(), String> {
        let counts = [dense.id.len(), dense.lat.len(), dense.lon.len()];
        if counts[0] != counts[1] || counts[0] != counts[2] {
            let [ids, lats, lons] = counts;
            return Err(format!("{ids} nodes with {lats} latitudes and {lons} longitudes"));
        }
        let (mut id, mut lat, mut lon) = (Sum::default(), Sum::default(), Sum::default());
        let mut pairs = dense.keys_vals.iter().copied();
        for i in 0..counts[0] {
            let mut tags = Tags::new();
            while let Some(key) = pairs.next().filter(|&k| k != 0) {
                let value = pairs.next().ok_or("a key without a value")?;
                self.tag(&mut tags, i64::from(key), i64::from(value))?;
            }
            let (id, lat) = (id.add(dense.id[i])?, lat.add(dense.lat[i])?);
            self.node(data, id, lat, lon.add(dense.lon[i])?, tags)?;
        }
        Ok(())
    }

    fn node(&self, data: &mut Data, id: i64, lat: i64, lon: i64, tags: Tags) -> Result<(), String> {
        let unit = i64::from(self.block.granularity());
        let place = |stored: i64, offset: i64, most_deg: i64| {
            let nano = stored.checked_mul(unit).and_then(|n| n.checked_add(offset));
            nano.filter(|n| n.unsigned_abs() <= most_deg.unsigned_abs() * 1_000_000_000)
                .ok_or_else(|| format!("node {id} lies beyond {most_deg} degrees"))
        };
        let place =
            [place(lat, self.block.lat_offset(), 90)?, place(lon, self.block.lon_offset(), 180)?];
        data.nodes.insert(id, place);
        if !tags.is_empty() {
            data.points.insert(id, tags);
        }
        Ok(())
    }

    fn relation(&self, data: &mut Data, relation: &wire::Relation) -> Result<(), String> {
        let tags = self.tags(&relation.keys, &relation.vals)?;
        let counts = [relation.members.len(), relation.roles.len(), relation.kinds.len()];
        if counts[0] != counts[1] || counts[0] != counts[2] {
            let [members, roles, kinds] = counts;
            let id = relation.id;
            return Err(format!("relation {id}: {members} members, {roles} roles, {kinds} kinds"));
        }
        let mut sum = Sum::default();
        let mut members = vec![];
        for i in 0..counts[0] {
            let way = sum.add(relation.members[i])?;
            if relation.kinds[i] == 1 {
                let inner = self.string(i64::from(relation.roles[i]))? == b"inner";
                members.push(Member { way, inner });
            }
        }
        data.relations.insert(relation.id, Relation { members, tags });
        Ok(())
    }

    fn tags(&self, keys: &[u32], values: &[u32]) -> Result<Tags, String> {
        if keys.len() != values.len() {
            return Err(format!("{} keys for {} values", keys.len(), values.len()));
        }
        let mut tags = Tags::new();
        for (&key, &value) in keys.iter().zip(values) {
            self.tag(&mut tags, i64::from(key), i64::from(value))?;
        }
        Ok(tags)
    }

    fn tag(&self, tags: &mut Tags, key: i64, value: i64) -> Result<(), String> {
        let (key, value) = (self.string(key)?, self.string(value)?);
        if let Some(key) = KEYS.iter().find(|k| k.as_bytes() == key) {
            tags.insert(key, String::from_utf8_lossy(value).into_owned());
        }
        Ok(())
    }

    fn string(&self, index: i64) -> Result<&'a [u8], String> {
        let found = usize::try_from(index).ok().and_then(|i| self.strings.get(i));
        found
            .map(Vec::as_slice)
            .ok_or_else(|| format!("string {index}, but there are {}", self.strings.len()))
    }
}
