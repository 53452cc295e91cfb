//! Record files in blocks of whole lines, so that memory stays bounded whatever a file holds.

use std::io::{self, Read};

use memchr::{memchr, memmem, memrchr};

use crate::read::{LONGEST_LINE, START};

/// Bytes read at a time.
const BLOCK: usize = 1 << 20;

/// Consecutive bytes of one file.
#[derive(Debug)]
pub(crate) struct Block {
    /// Where they begin in the file.
    pub offset: u64,
    /// Number of the first line, from 1.
    pub line: usize,
    /// The bytes.
    pub bytes: Vec<u8>,
    /// What they are.
    pub part: Part,
}

/// What a block holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Part {
    /// Whole lines; the last of a file may lack its line feed.
    Lines,
    /// A piece of a line longer than the limit. Pieces are cut where a line of ours may begin.
    Piece {
        /// The line's first piece.
        first: bool,
    },
}

/// Cuts what it reads into blocks.
pub(crate) struct Blocks<R> {
    reader: R,
    offset: u64,
    line: usize,
    /// Read, and not yet given out.
    carry: Vec<u8>,
    /// Bytes of `carry` that hold no line feed.
    searched: usize,
    /// The carry begins within a line that is too long.
    inside: bool,
    ended: bool,
    block: usize,
    longest: usize,
}

impl<R: Read> Blocks<R> {
    /// From a reader that stands at `offset`, the beginning of line number `line`.
    pub(crate) fn new(reader: R, offset: u64, line: usize) -> Self {
        Self::sized(reader, offset, line, BLOCK, LONGEST_LINE)
    }

    pub(crate) fn sized(reader: R, offset: u64, line: usize, block: usize, longest: usize) -> Self {
        let (carry, searched, inside, ended) = (Vec::new(), 0, false, false);
        Self { reader, offset, line, carry, searched, inside, ended, block, longest }
    }

    /// The next block; none at the end.
    pub(crate) fn next(&mut self) -> io::Result<Option<Block>> {
        loop {
            if self.ended {
                let rest = self.carry.len();
                return Ok((rest > 0).then(|| self.give(rest)));
            }
            self.carry.reserve(self.block);
            let wanted = self.block as u64;
            if self.reader.by_ref().take(wanted).read_to_end(&mut self.carry)? == 0 {
                self.ended = true;
                continue;
            }
            let fresh = &self.carry[self.searched..];
            // The end of a long line ends its last piece; otherwise as many lines as there are.
            let end = if self.inside { memchr(b'\n', fresh) } else { memrchr(b'\n', fresh) };
            if let Some(end) = end {
                return Ok(Some(self.give(self.searched + end + 1)));
            }
            self.searched = self.carry.len();
            if self.carry.len() >= self.longest {
                // Whole lines of ours may stand inside; the last may go on.
                let later = memmem::rfind(&self.carry, START).filter(|&at| at > 0);
                let cut = later.unwrap_or(self.carry.len() + 1 - START.len());
                let first = !self.inside;
                self.inside = true;
                return Ok(Some(self.cut(cut, Part::Piece { first })));
            }
        }
    }

    fn give(&mut self, end: usize) -> Block {
        let part = if self.inside { Part::Piece { first: false } } else { Part::Lines };
        self.inside = false;
        self.searched = 0;
        self.cut(end, part)
    }

    fn cut(&mut self, end: usize, part: Part) -> Block {
        let rest = self.carry.split_off(end);
        let bytes = std::mem::replace(&mut self.carry, rest);
        self.searched = self.searched.saturating_sub(end);
        let block = Block { offset: self.offset, line: self.line, part, bytes };
        self.offset += block.bytes.len() as u64;
        self.line += memchr::memchr_iter(b'\n', &block.bytes).count();
        block
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn blocks(text: &[u8], block: usize, longest: usize) -> Vec<Block> {
        let mut blocks = Blocks::sized(text, 0, 1, block, longest);
        std::iter::from_fn(|| blocks.next().unwrap()).collect()
    }

    #[test]
    fn blocks_hold_every_byte_once_and_end_at_line_feeds() {
        let text = b"one\ntwo\n\nthree, a longer one\nfour";
        for block in 1..40 {
            let blocks = blocks(text, block, 100);
            let all: Vec<u8> = blocks.iter().flat_map(|b| b.bytes.clone()).collect();
            assert_eq!(all, text);
            let mut line = 1;
            for b in &blocks {
                assert_eq!((b.line, b.part), (line, Part::Lines), "{block}");
                assert_eq!(&text[b.offset as usize..][..b.bytes.len()], b.bytes);
                line += b.bytes.iter().filter(|&&b| b == b'\n').count();
            }
            let (last, others) = blocks.split_last().unwrap();
            assert!(others.iter().all(|b| b.bytes.ends_with(b"\n")));
            assert!(last.bytes.ends_with(b"four"));
        }
    }

    #[test]
    fn a_line_without_end_comes_in_pieces_cut_where_lines_may_begin() {
        let mut text = vec![b'x'; 300];
        text.splice(100..100, START.iter().copied());
        text.extend(b"\nshort\n");
        for block in 1..60 {
            let blocks = blocks(&text, block, 64);
            assert!(blocks.iter().all(|b| b.bytes.len() <= 64 + 2 * block), "{block}");
            let pieces =
                |first| blocks.iter().filter(|b| b.part == (Part::Piece { first })).count();
            assert_eq!(pieces(true), 1);
            assert!(pieces(false) >= 1);
            assert!(blocks.iter().any(|b| b.bytes.starts_with(START)), "{block}");
            let last = blocks.last().unwrap();
            assert!(last.part == Part::Lines && last.bytes.ends_with(b"short\n"));
            assert_eq!(last.line, 2);
            let all: Vec<u8> = blocks.iter().flat_map(|b| b.bytes.clone()).collect();
            assert_eq!(all, text);
        }
    }
}
