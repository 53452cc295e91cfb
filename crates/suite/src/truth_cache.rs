//! A cache of ground truth by content hash. It can be deleted at any time; a damaged entry is
//! recomputed, never believed.

use std::{
    env, fs,
    path::{Path, PathBuf},
};

const MAGIC: &[u8; 8] = b"dpltru01";
const HASH_BYTES: usize = 32;

/// Environment variable that names the cache's folder; `off` turns it off.
pub const CACHE_VARIABLE: &str = "DAPPLE_CACHE";

/// A folder of truths. `None` computes every time.
#[derive(Clone, Debug)]
pub struct TruthCache {
    folder: Option<PathBuf>,
}

impl TruthCache {
    /// The folder named by `DAPPLE_CACHE`, else `dapple` in the user's cache folder.
    pub fn from_environment() -> Self {
        let folder = match env::var_os(CACHE_VARIABLE) {
            Some(value) if value == "off" || value.is_empty() => None,
            Some(value) => Some(PathBuf::from(value)),
            None => {
                // Empty or relative counts as unset (XDG Base Directory Specification): a cache
                // must not land in whatever folder the program happens to run in.
                let folder =
                    |name| env::var_os(name).map(PathBuf::from).filter(|p| p.is_absolute());
                folder("XDG_CACHE_HOME")
                    .or_else(|| Some(folder("HOME")?.join(".cache")))
                    .map(|cache| cache.join("dapple"))
            }
        };
        Self { folder }
    }

    /// A cache in `folder`.
    pub fn at(folder: PathBuf) -> Self {
        Self { folder: Some(folder) }
    }

    /// The values stored under `key`, or those that `compute` gives. `key` must name everything
    /// the values depend on, code version included. `len` values are expected.
    ///
    /// # Errors
    /// Those of `compute`. A cache that cannot be read or written is passed over.
    pub fn get<E>(
        &self,
        key: &str,
        len: usize,
        compute: impl FnOnce() -> Result<Vec<f32>, E>,
    ) -> Result<Vec<f32>, E> {
        let entry = self.entry(key);
        if let Some(values) = entry.as_ref().and_then(|p| read::<f32>(p, key))
            && values.len() == len
        {
            return Ok(values);
        }
        let values = compute()?;
        self.store(entry, key, bytemuck::cast_slice(&values));
        Ok(values)
    }

    /// The same for integers, of any number.
    pub fn words(&self, key: &str, compute: impl FnOnce() -> Vec<u32>) -> Vec<u32> {
        let entry = self.entry(key);
        if let Some(words) = entry.as_ref().and_then(|p| read::<u32>(p, key)) {
            return words;
        }
        let words = compute();
        self.store(entry, key, bytemuck::cast_slice(&words));
        words
    }

    fn entry(&self, key: &str) -> Option<PathBuf> {
        let name = blake3::hash(key.as_bytes()).to_hex();
        self.folder.as_ref().map(|f| f.join(format!("{}.truth", &name[..32])))
    }

    // Written beside and renamed: a reader never sees half an entry. A failure to store costs time,
    // not correctness.
    fn store(&self, entry: Option<PathBuf>, key: &str, payload: &[u8]) {
        let (Some(folder), Some(path)) = (&self.folder, entry) else {
            return;
        };
        let part = path.with_extension(format!("part{}", std::process::id()));
        let stored = fs::create_dir_all(folder)
            .and_then(|()| fs::write(&part, encode(payload, key)))
            .and_then(|()| fs::rename(&part, &path));
        if stored.is_err() {
            let _ = fs::remove_file(&part);
        }
    }
}

fn read<T: bytemuck::Pod>(path: &Path, key: &str) -> Option<Vec<T>> {
    decode(&fs::read(path).ok()?, key)
}

fn digest(payload: &[u8], key: &str) -> [u8; HASH_BYTES] {
    *blake3::Hasher::new().update(key.as_bytes()).update(&[0]).update(payload).finalize().as_bytes()
}

fn encode(payload: &[u8], key: &str) -> Vec<u8> {
    [MAGIC.as_slice(), &digest(payload, key), payload].concat()
}

fn decode<T: bytemuck::Pod>(bytes: &[u8], key: &str) -> Option<Vec<T>> {
    let (hash, payload) = bytes.strip_prefix(MAGIC)?.split_at_checked(HASH_BYTES)?;
    if hash != digest(payload, key) || payload.len() % size_of::<T>() != 0 {
        return None;
    }
    Some(bytemuck::pod_collect_to_vec(payload))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::convert::Infallible;

    fn get(cache: &TruthCache, key: &str, value: f32, calls: &mut u32) -> Vec<f32> {
        let Ok(values) = cache.get(key, 2, || {
            *calls += 1;
            Ok::<_, Infallible>(vec![value; 2])
        });
        values
    }

    #[test]
    fn a_second_request_is_served_from_disk_and_a_damaged_entry_is_recomputed() {
        let folder = tempfile::tempdir().unwrap();
        let cache = TruthCache::at(folder.path().into());
        let mut calls = 0;
        assert_eq!(get(&cache, "a", 1.0, &mut calls), [1.0, 1.0]);
        assert_eq!(get(&cache, "a", 2.0, &mut calls), [1.0, 1.0]);
        assert_eq!(calls, 1);
        assert_eq!(get(&cache, "b", 3.0, &mut calls), [3.0, 3.0]);
        assert_eq!(calls, 2);
        for entry in fs::read_dir(folder.path()).unwrap() {
            let path = entry.unwrap().path();
            let mut bytes = fs::read(&path).unwrap();
            *bytes.last_mut().unwrap() ^= 1;
            fs::write(&path, bytes).unwrap();
        }
        assert_eq!(get(&cache, "a", 4.0, &mut calls), [4.0, 4.0]);
        assert_eq!(calls, 3);
    }

    #[test]
    fn an_entry_of_another_key_or_length_is_not_believed() {
        let folder = tempfile::tempdir().unwrap();
        let cache = TruthCache::at(folder.path().into());
        let mut calls = 0;
        get(&cache, "a", 1.0, &mut calls);
        let Ok(values) = cache.get("a", 3, || Ok::<_, Infallible>(vec![5.0; 3]));
        assert_eq!(values, [5.0; 3]);
        assert!(decode::<f32>(&encode(&[1; 4], "a"), "b").is_none());
        assert!(decode::<f32>(&encode(&[1; 4], "a")[..20], "a").is_none());
        assert!(decode::<f32>(b"", "a").is_none());
    }

    #[test]
    fn integers_of_any_number_come_back_bit_for_bit() {
        let folder = tempfile::tempdir().unwrap();
        let cache = TruthCache::at(folder.path().into());
        // The bits of a signalling NaN among them.
        let words = vec![0, 1, 0x7fa0_0001, u32::MAX];
        assert_eq!(cache.words("a", || words.clone()), words);
        assert_eq!(cache.words("a", Vec::new), words);
        assert!(cache.words("b", Vec::new).is_empty());
    }

    #[test]
    fn an_unwritable_folder_costs_only_time() {
        let cache = TruthCache::at("/dev/null/nowhere".into());
        let mut calls = 0;
        assert_eq!(get(&cache, "a", 1.0, &mut calls), [1.0, 1.0]);
        assert_eq!(calls, 1);
    }
}
