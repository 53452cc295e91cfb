//! Small city files: CityJSON text, and a writer of just enough protocol buffers for OpenStreetMap.

use dapple_scene::SceneError;
use dapple_scene::city::{self, LoadedCity};
use std::collections::BTreeMap;

/// Loads bytes under a file name.
pub fn load(name: &str, bytes: &[u8]) -> Result<LoadedCity, SceneError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    city::load(&path)
}

/// Why bytes are refused.
pub fn message(name: &str, bytes: &[u8]) -> String {
    load(name, bytes).unwrap_err().to_string()
}

/// The eight corners of a box in millimetres: its floor counter-clockwise, then its top.
pub fn box_corners(lo: [i64; 3], hi: [i64; 3]) -> Vec<[i64; 3]> {
    let ring =
        |z: i64| [[lo[0], lo[1], z], [hi[0], lo[1], z], [hi[0], hi[1], z], [lo[0], hi[1], z]];
    [ring(lo[2]), ring(hi[2])].concat()
}

/// A building of eight corners from `first`.
pub fn box_solid(first: usize) -> String {
    let faces =
        [[0, 3, 2, 1], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7], [4, 5, 6, 7]];
    let ring = |f: &[usize; 4]| {
        let corners: Vec<String> = f.iter().map(|c| (c + first).to_string()).collect();
        format!("[[{}]]", corners.join(","))
    };
    let shell: Vec<String> = faces.iter().map(ring).collect();
    format!(
        r#"{{"type":"Building","geometry":[{{"type":"Solid","lod":"1","boundaries":[[{}]]}}]}}"#,
        shell.join(",")
    )
}

/// A file of these objects, stored in millimetres.
pub fn cityjson(version: &str, crs: &str, objects: &str, corners: &[[i64; 3]]) -> String {
    let corners: Vec<String> = corners.iter().map(|c| format!("{c:?}")).collect();
    format!(
        r#"{{"type":"CityJSON","version":"{version}","metadata":{{"referenceSystem":"{crs}"}},
        "transform":{{"scale":[0.001,0.001,0.001],"translate":[85000,447000,5]}},
        "CityObjects":{{{objects}}},"vertices":[{}]}}"#,
        corners.join(",")
    )
}

/// An OpenStreetMap file to be. Places are metres east and north of 60 N, 25 E.
#[derive(Clone)]
pub struct Pbf {
    pub features: Vec<String>,
    strings: Vec<String>,
    known: BTreeMap<String, usize>,
    nodes: Vec<(i64, [f64; 2], Vec<usize>)>,
    ways: Vec<Vec<u8>>,
    relations: Vec<Vec<u8>>,
}

impl Default for Pbf {
    fn default() -> Self {
        Self {
            features: vec!["OsmSchema-V0.6".into(), "DenseNodes".into()],
            strings: vec![String::new()],
            known: BTreeMap::new(),
            nodes: vec![],
            ways: vec![],
            relations: vec![],
        }
    }
}

/// A closed square way of four new nodes, its first corner at `corner`.
pub fn square_way(pbf: &mut Pbf, id: i64, corner: [f64; 2], side: f64, tags: &[(&str, &str)]) {
    let [x, y] = corner;
    let ring = [[x, y], [x + side, y], [x + side, y + side], [x, y + side]];
    pbf.ring(id, &ring, tags);
}

impl Pbf {
    /// A node with tags.
    pub fn point(&mut self, place: [f64; 2], tags: &[(&str, &str)]) -> i64 {
        let tags = tags.iter().flat_map(|(k, v)| [self.string(k), self.string(v)]).collect();
        let id = self.nodes.len() as i64 + 1;
        self.nodes.push((id, place, tags));
        id
    }

    /// A closed way of new nodes.
    pub fn ring(&mut self, id: i64, places: &[[f64; 2]], tags: &[(&str, &str)]) {
        let mut nodes: Vec<i64> = places.iter().map(|p| self.point(*p, &[])).collect();
        nodes.push(nodes[0]);
        self.way(id, &nodes, tags);
    }

    /// A way over nodes.
    pub fn way(&mut self, id: i64, nodes: &[i64], tags: &[(&str, &str)]) {
        let mut way = number(1, id as u64);
        self.tags(&mut way, tags);
        way.extend(packed(8, differences(nodes.iter().copied())));
        self.ways.push(way);
    }

    /// A relation of ways.
    pub fn relation(&mut self, id: i64, members: &[(i64, &str)], tags: &[(&str, &str)]) {
        let mut relation = number(1, id as u64);
        self.tags(&mut relation, tags);
        let roles: Vec<u64> = members.iter().map(|(_, role)| self.string(role) as u64).collect();
        relation.extend(packed(8, roles));
        relation.extend(packed(9, differences(members.iter().map(|m| m.0))));
        relation.extend(packed(10, members.iter().map(|_| 1)));
        self.relations.push(relation);
    }

    /// The file, with its blocks packed; nodes in columns or one by one.
    pub fn bytes(&self, dense: bool) -> Vec<u8> {
        self.file(dense, true)
    }

    /// The same with its blocks as they are, so that damage reaches what they say.
    pub fn bytes_raw(&self, dense: bool) -> Vec<u8> {
        self.file(dense, false)
    }

    fn file(&self, dense: bool, pack: bool) -> Vec<u8> {
        let mut header = vec![];
        for feature in &self.features {
            header.extend(bytes(4, feature.as_bytes()));
        }
        let strings: Vec<u8> = self.strings.iter().flat_map(|s| bytes(1, s.as_bytes())).collect();
        let mut block = bytes(1, &strings);
        block.extend(bytes(2, &self.group_of_nodes(dense)));
        block.extend(bytes(2, &self.ways.iter().flat_map(|w| bytes(3, w)).collect::<Vec<_>>()));
        block
            .extend(bytes(2, &self.relations.iter().flat_map(|r| bytes(4, r)).collect::<Vec<_>>()));
        let mut file = blob("OSMHeader", &header, pack);
        file.extend(blob("OSMData", &block, pack));
        file
    }

    fn group_of_nodes(&self, dense: bool) -> Vec<u8> {
        // Units of 100 nanodegrees; lengths of a degree at 60 N.
        let unit = |degrees: f64| (degrees * 1e7).round() as i64;
        let lat = |p: &[f64; 2]| unit(60.0 + p[1] / 111_412.24);
        let lon = |p: &[f64; 2]| unit(25.0 + p[0] / 55_800.0);
        if !dense {
            let node = |(id, place, tags): &(i64, [f64; 2], Vec<usize>)| {
                let mut node = number(1, zigzag(*id));
                let of = |odd: usize| tags.iter().skip(odd).step_by(2).map(|s| *s as u64);
                node.extend(packed(2, of(0)));
                node.extend(packed(3, of(1)));
                node.extend(number(8, zigzag(lat(place))));
                node.extend(number(9, zigzag(lon(place))));
                bytes(1, &node)
            };
            return self.nodes.iter().flat_map(node).collect();
        }
        let mut columns = packed(1, differences(self.nodes.iter().map(|n| n.0)));
        columns.extend(packed(8, differences(self.nodes.iter().map(|n| lat(&n.1)))));
        columns.extend(packed(9, differences(self.nodes.iter().map(|n| lon(&n.1)))));
        let tags = self.nodes.iter().flat_map(|n| n.2.iter().map(|s| *s as u64).chain([0]));
        columns.extend(packed(10, tags));
        bytes(2, &columns)
    }

    fn tags(&mut self, to: &mut Vec<u8>, tags: &[(&str, &str)]) {
        let keys: Vec<u64> = tags.iter().map(|(k, _)| self.string(k) as u64).collect();
        let values: Vec<u64> = tags.iter().map(|(_, v)| self.string(v) as u64).collect();
        to.extend(packed(2, keys));
        to.extend(packed(3, values));
    }

    fn string(&mut self, text: &str) -> usize {
        let next = self.strings.len();
        let index = *self.known.entry(text.into()).or_insert(next);
        if index == next {
            self.strings.push(text.into());
        }
        index
    }
}

fn blob(kind: &str, block: &[u8], pack: bool) -> Vec<u8> {
    let blob = if pack {
        let mut encoder = flate2::write::ZlibEncoder::new(vec![], flate2::Compression::fast());
        std::io::Write::write_all(&mut encoder, block).unwrap();
        let mut blob = number(2, block.len() as u64);
        blob.extend(bytes(3, &encoder.finish().unwrap()));
        blob
    } else {
        bytes(1, block)
    };
    let mut header = bytes(1, kind.as_bytes());
    header.extend(number(3, blob.len() as u64));
    let mut all = (header.len() as u32).to_be_bytes().to_vec();
    all.extend(header);
    all.extend(blob);
    all
}

fn varint(mut value: u64) -> Vec<u8> {
    let mut out = vec![];
    while value >= 0x80 {
        out.push(value as u8 | 0x80);
        value >>= 7;
    }
    out.push(value as u8);
    out
}

fn zigzag(value: i64) -> u64 {
    ((value << 1) ^ (value >> 63)) as u64
}

fn number(field: u64, value: u64) -> Vec<u8> {
    [varint(field << 3), varint(value)].concat()
}

fn bytes(field: u64, content: &[u8]) -> Vec<u8> {
    [varint(field << 3 | 2), varint(content.len() as u64), content.to_vec()].concat()
}

fn packed(field: u64, values: impl IntoIterator<Item = u64>) -> Vec<u8> {
    bytes(field, &values.into_iter().flat_map(varint).collect::<Vec<_>>())
}

fn differences(values: impl Iterator<Item = i64>) -> Vec<u64> {
    let mut before = 0;
    values.map(|v| zigzag(v - std::mem::replace(&mut before, v))).collect()
}
