//! The values behind a PLY header. The crate's own payload reader takes memory for whatever length
//! a list claims (and panics on a negative one); here a list grows only as its bytes are found.

use ply_rs_bw::ply::{Encoding, PropertyType, ScalarType};

/// A cursor over the payload, in text or binary.
pub struct Payload<'a> {
    encoding: Encoding,
    rest: &'a [u8],
}

impl<'a> Payload<'a> {
    pub fn new(encoding: Encoding, rest: &'a [u8]) -> Self {
        Self { encoding, rest }
    }

    pub fn remaining(&self) -> usize {
        // A last line may lack its line end.
        self.rest.len() + usize::from(self.encoding == Encoding::Ascii)
    }

    /// One property's value; a list goes to `list`, and its length is returned.
    pub fn property(&mut self, kind: &PropertyType, list: &mut Vec<f64>) -> Result<f64, String> {
        match kind {
            PropertyType::Scalar(kind) => self.scalar(kind),
            PropertyType::List(length, kind) => {
                list.clear();
                let count = self.scalar(length)?;
                if !(count >= 0.0 && count.fract() == 0.0) {
                    return Err(format!("{count} is not a list length"));
                }
                for _ in 0..count as u64 {
                    list.push(self.scalar(kind)?);
                }
                Ok(count)
            }
        }
    }

    /// In text, an item ends with its line, whatever else stands there.
    pub fn end_of_item(&mut self) {
        if self.encoding == Encoding::Ascii {
            let end = self.rest.iter().position(|&b| b == b'\n').map_or(self.rest.len(), |i| i + 1);
            self.rest = &self.rest[end..];
        }
    }

    fn scalar(&mut self, kind: &ScalarType) -> Result<f64, String> {
        match self.encoding {
            Encoding::Ascii => self.word(),
            Encoding::BinaryLittleEndian => self.binary(kind, false),
            Encoding::BinaryBigEndian => self.binary(kind, true),
        }
    }

    fn word(&mut self) -> Result<f64, String> {
        let start = self.rest.iter().position(|b| !b.is_ascii_whitespace());
        let word = &self.rest[start.unwrap_or(self.rest.len())..];
        let end = word.iter().position(u8::is_ascii_whitespace).unwrap_or(word.len());
        let (word, rest) = word.split_at(end);
        self.rest = rest;
        if word.is_empty() {
            return Err("truncated: a number is missing".into());
        }
        let word = String::from_utf8_lossy(word);
        word.parse().map_err(|_| format!("\"{word}\" is not a number"))
    }

    fn binary(&mut self, kind: &ScalarType, big_endian: bool) -> Result<f64, String> {
        Ok(match kind {
            ScalarType::Char => f64::from(self.take::<1>(false)?[0] as i8),
            ScalarType::UChar => f64::from(self.take::<1>(false)?[0]),
            ScalarType::Short => f64::from(i16::from_le_bytes(self.take(big_endian)?)),
            ScalarType::UShort => f64::from(u16::from_le_bytes(self.take(big_endian)?)),
            ScalarType::Int => f64::from(i32::from_le_bytes(self.take(big_endian)?)),
            ScalarType::UInt => f64::from(u32::from_le_bytes(self.take(big_endian)?)),
            ScalarType::Float => f64::from(f32::from_le_bytes(self.take(big_endian)?)),
            ScalarType::Double => f64::from_le_bytes(self.take(big_endian)?),
        })
    }

    fn take<const N: usize>(&mut self, reverse: bool) -> Result<[u8; N], String> {
        let (head, rest) =
            self.rest.split_first_chunk::<N>().ok_or("truncated: bytes are missing")?;
        self.rest = rest;
        let mut bytes = *head;
        if reverse {
            bytes.reverse();
        }
        Ok(bytes)
    }
}
