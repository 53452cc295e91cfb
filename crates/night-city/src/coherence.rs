//! Precuts kept from frame to frame: the camera never changes which lights reach a facade.
//!
//! Based on: Melino Conte, "Real-time Rendering of Cities at Night", 2018, section 5.2.3 (a precut is
//! kept for 50 frames) and section 5.2.1 (lists of the light tree's nodes).
//! Deviations: the thesis leaves open what a precut belongs to. Here it is a node of the scene's
//! hierarchy and a direction. The first span is drawn between one frame and all of them, so that what
//! came into sight together is not found anew together. What no frame used for longest is forgotten
//! where memory is bounded.

use crate::lists::Precut;
use dapple_many_lights::region::Direction;
use std::collections::BTreeMap;

/// What a precut belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Key {
    /// Node of the scene's hierarchy.
    pub node: u32,
    /// Where the cell's surfaces face.
    pub direction: Direction,
}

/// How long precuts are kept, and how many.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Keeping {
    /// Frames after which a precut is found anew, at least 1; `None`: never.
    pub validity: Option<u32>,
    /// Bytes that are kept beside what the frame itself uses; `None`: all.
    pub capacity_bytes: Option<u64>,
    /// Of the first spans.
    pub seed: u64,
}

/// Precuts of one light tree.
#[derive(Clone, Debug, Default)]
pub struct Kept {
    keeping: Keeping,
    entries: BTreeMap<Key, Entry>,
    frame: u64,
    bytes: u64,
    forgotten: u64,
}

#[derive(Clone, Debug, Default)]
struct Entry {
    nodes: Vec<u32>,
    /// One a node; empty where none was asked for.
    hidden_below: Vec<f32>,
    /// Objects that the cell was around, in order; empty where it was around all below the node.
    objects: Vec<u32>,
    /// The first frame in which it is no longer valid.
    expires: u64,
    /// The latest frame that asked for it.
    used: u64,
}

impl Entry {
    fn bytes(&self) -> u64 {
        let lists = size_of_val(&self.nodes[..]) + size_of_val(&self.objects[..]);
        let heights = size_of_val(&self.hidden_below[..]);
        (lists + heights + size_of::<(Key, Self)>()) as u64
    }

    fn holds(&self, objects: &[u32]) -> bool {
        let is_of_all = self.objects.is_empty();
        is_of_all || objects.iter().all(|object| self.objects.binary_search(object).is_ok())
    }
}

impl Kept {
    /// Nothing yet.
    pub fn new(keeping: Keeping) -> Self {
        Self { keeping, ..Self::default() }
    }

    /// Forgets everything, frames included.
    pub fn reset(&mut self) {
        *self = Self::new(self.keeping);
    }

    /// A frame begins.
    pub fn begin(&mut self) {
        self.frame += 1;
    }

    /// Whether a precut has to be found for this frame. `objects`, in order, are those that it will
    /// serve where a cell is around what is visible alone; none where it is around all below the node.
    pub fn wants(&mut self, key: Key, objects: &[u32]) -> bool {
        let frame = self.frame;
        let Some(entry) = self.entries.get_mut(&key) else { return true };
        entry.used = frame;
        entry.expires <= frame || !entry.holds(objects)
    }

    /// A precut was found for this frame, for a cell around `objects`, as [`Kept::wants`] has them.
    pub fn put(&mut self, key: Key, objects: &[u32], precut: Precut<'_>) {
        let before = self.entries.remove(&key);
        let span = match (self.keeping.validity, &before) {
            (None, _) => u64::MAX,
            (Some(frames), Some(_)) => u64::from(frames.max(1)),
            (Some(frames), None) => 1 + self.drawn(key) % u64::from(frames.max(1)),
        };
        let entry = Entry {
            nodes: precut.nodes.to_vec(),
            hidden_below: precut.hidden_below.to_vec(),
            objects: objects.to_vec(),
            expires: self.frame.saturating_add(span),
            used: self.frame,
        };
        self.bytes += entry.bytes();
        self.bytes -= before.map_or(0, |entry| entry.bytes());
        self.entries.insert(key, entry);
    }

    /// A precut, expired or not.
    pub fn get(&self, key: Key) -> Option<Precut<'_>> {
        let Entry { nodes, hidden_below, .. } = self.entries.get(&key)?;
        Some(Precut { nodes, hidden_below })
    }

    /// The frame uses a precut that it did not ask for, where it is kept.
    pub fn touch(&mut self, key: Key) {
        if let Some(entry) = self.entries.get_mut(&key) {
            entry.used = self.frame;
        }
    }

    /// Forgets what no frame used for longest until the rest fits, but nothing that the current frame
    /// uses.
    pub fn end(&mut self) {
        let Some(most) = self.keeping.capacity_bytes else { return };
        if self.bytes <= most {
            return;
        }
        let unused = self.entries.iter().filter(|(_, entry)| entry.used < self.frame);
        let mut unused: Vec<(u64, Key)> = unused.map(|(key, entry)| (entry.used, *key)).collect();
        unused.sort_unstable();
        for (_, key) in unused {
            if self.bytes <= most {
                break;
            }
            if let Some(entry) = self.entries.remove(&key) {
                self.bytes -= entry.bytes();
                self.forgotten += 1;
            }
        }
    }

    /// Precuts that are kept.
    pub fn len(&self) -> usize {
        self.entries.len()
    }

    /// Whether none is.
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// Bytes of all of them.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Precuts that were forgotten for want of room.
    pub fn forgotten(&self) -> u64 {
        self.forgotten
    }

    /// A number by chance for a key, the same on every machine (splitmix64).
    fn drawn(&self, key: Key) -> u64 {
        let mut bits =
            self.keeping.seed ^ (u64::from(key.node) << 2 | key.direction.index() as u64);
        for _ in 0..2 {
            bits = bits.wrapping_add(0x9E37_79B9_7F4A_7C15);
            bits = (bits ^ bits >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
            bits = (bits ^ bits >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
            bits ^= bits >> 31;
        }
        bits
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn precut(nodes: &[u32]) -> Precut<'_> {
        Precut { nodes, hidden_below: &[] }
    }

    fn key(node: u32) -> Key {
        Key { node, direction: Direction::ALL[node as usize % 4] }
    }

    /// Frames in which each of `keys` was found, of `frames`.
    fn found(keeping: Keeping, keys: u32, frames: u64) -> Vec<Vec<u64>> {
        let mut kept = Kept::new(keeping);
        let mut found = vec![Vec::new(); keys as usize];
        for frame in 0..frames {
            kept.begin();
            for node in 0..keys {
                if kept.wants(key(node), &[]) {
                    kept.put(key(node), &[], precut(&[node; 3]));
                    found[node as usize].push(frame);
                }
                assert_eq!(kept.get(key(node)).unwrap().nodes, [node; 3]);
            }
            kept.end();
        }
        found
    }

    #[test]
    fn the_first_span_is_between_one_frame_and_all_and_every_other_is_all() {
        let keeping = Keeping { validity: Some(50), seed: 3, ..Keeping::default() };
        let found = found(keeping, 400, 200);
        let mut first = [0_u32; 51];
        for frames in &found {
            assert_eq!(frames[0], 0);
            first[frames[1] as usize] += 1;
            assert!(frames[1..].windows(2).all(|pair| pair[1] - pair[0] == 50), "{frames:?}");
        }
        assert_eq!(first[0], 0);
        let different = first.iter().filter(|count| **count > 0).count();
        assert!(different > 40, "{different} of 50 spans");
        // After the first, about as many in every frame.
        let later: usize = found.iter().map(|frames| frames.len() - 1).sum();
        assert!((1400..1600).contains(&later), "{later}");
    }

    #[test]
    fn one_frame_is_every_frame_and_no_limit_is_once() {
        let of = |validity| found(Keeping { validity, ..Keeping::default() }, 5, 20);
        assert!(of(Some(1)).iter().all(|frames| frames.iter().copied().eq(0..20)));
        assert!(of(None).iter().all(|frames| frames[..] == [0]));
    }

    #[test]
    fn what_was_unused_for_longest_goes_first_and_what_a_frame_uses_stays() {
        let one = Entry { nodes: vec![0; 10], ..Entry::default() }.bytes();
        let capacity_bytes = Some(3 * one);
        let mut kept = Kept::new(Keeping { capacity_bytes, ..Keeping::default() });
        let mut show = |nodes: &[u32]| {
            kept.begin();
            for &node in nodes {
                if kept.wants(key(node), &[]) {
                    kept.put(key(node), &[], precut(&[0; 10]));
                }
            }
            kept.end();
            let left: Vec<u32> = (0..9).filter(|node| kept.get(key(*node)).is_some()).collect();
            (left, kept.bytes() / one)
        };
        assert_eq!(show(&[0, 1]), (vec![0, 1], 2));
        assert_eq!(show(&[1, 2]), (vec![0, 1, 2], 3));
        assert_eq!(show(&[3]), (vec![1, 2, 3], 3));
        assert_eq!(show(&[4, 5, 6, 7]), (vec![4, 5, 6, 7], 4));
        assert_eq!(show(&[]), (vec![5, 6, 7], 3));
        assert_eq!(kept.forgotten(), 5);
        kept.reset();
        assert!(kept.is_empty() && kept.bytes() == 0 && kept.forgotten() == 0);
    }

    #[test]
    fn a_precut_serves_no_object_that_its_cell_was_not_around() {
        let mut kept = Kept::new(Keeping::default());
        kept.begin();
        kept.put(key(0), &[3, 7], precut(&[1]));
        kept.put(key(1), &[], precut(&[2]));
        assert!(!kept.wants(key(0), &[3]) && !kept.wants(key(0), &[3, 7]));
        assert!(kept.wants(key(0), &[3, 8]));
        assert!(!kept.wants(key(1), &[3, 8]), "around all below");
        let before = kept.bytes();
        kept.put(key(2), &[], Precut { nodes: &[1, 5], hidden_below: &[0.5, 2.0] });
        assert_eq!(kept.get(key(2)).unwrap().hidden_below, [0.5, 2.0]);
        kept.put(key(2), &[], precut(&[1, 5]));
        assert_eq!(
            kept.bytes() - before,
            (2 * size_of::<u32>() + size_of::<(Key, Entry)>()) as u64
        );
    }
}
