//! The processor's form: texels are encoded in parallel, receivers are shaded in parallel.
//!
//! A frame starts from fragments, as a shadow filter's starts from depths: rasterising them is the
//! graphics device's business and is not in the processor's time.

use crate::{
    Blur, Fragment, Fragments, OpacityError, Opaque, Receiver, Settings,
    code::{self, TexelCode},
    taps::{self, MOST, Tap},
};
use rayon::prelude::*;

/// Texels that one task encodes.
const CHUNK: usize = 1024;

/// Receivers that one task shades.
const SHADED: usize = 4096;

/// A technique's maps, allocated once.
pub struct Maps {
    settings: Settings,
    code: Box<dyn TexelCode>,
    width: u32,
    height: u32,
    words: Vec<f32>,
    opaque: Vec<f32>,
}

impl Maps {
    /// Allocates the maps of `width` x `height` texels.
    ///
    /// # Errors
    /// Settings out of range, an empty map.
    pub fn new(width: u32, height: u32, settings: &Settings) -> Result<Self, OpacityError> {
        settings.check()?;
        Self::with_code(width, height, settings, code::of(settings))
    }

    /// The same with a code at hand, which may be one with a deliberate fault.
    ///
    /// # Errors
    /// An empty map.
    pub fn with_code(
        width: u32,
        height: u32,
        settings: &Settings,
        code: Box<dyn TexelCode>,
    ) -> Result<Self, OpacityError> {
        if width == 0 || height == 0 {
            return Err(OpacityError::EmptyMap { width, height });
        }
        let texels = width as usize * height as usize;
        let words = vec![0.0; texels * code.words()];
        let opaque = vec![crate::NO_OPAQUE; texels];
        Ok(Self { settings: settings.clone(), code, width, height, words, opaque })
    }

    /// Encodes every texel.
    ///
    /// # Errors
    /// Fragments of another size than the maps. Their numbers are not checked here: see
    /// [`Fragments::check`].
    pub fn build(&mut self, fragments: &Fragments) -> Result<(), OpacityError> {
        let (expected, actual) = (self.opaque.len(), fragments.texels());
        let sizes = (self.width, self.height) == (fragments.width, fragments.height);
        if !sizes || fragments.starts.len() != expected + 1 || fragments.opaque.len() != expected {
            return Err(OpacityError::Length { what: "texels of the fragments", expected, actual });
        }
        self.code.prepare(fragments);
        self.opaque.copy_from_slice(&fragments.opaque);
        let words = self.code.words();
        if words == 0 {
            return Ok(());
        }
        let (code, opaque) = (&self.code, self.settings.opaque);
        let one = |scratch: &mut Vec<Fragment>, (chunk, out): (usize, &mut [f32])| {
            for (i, texel_words) in out.chunks_exact_mut(words).enumerate() {
                let texel = chunk * CHUNK + i;
                let weighted = weighted(opaque, fragments.opaque[texel]);
                code.encode(texel, fragments.texel(texel), weighted, scratch, texel_words);
            }
        };
        self.words.par_chunks_mut(words * CHUNK).enumerate().for_each_init(Vec::new, one);
        Ok(())
    }

    /// Transmittance of every receiver, 0..=1; 1 outside the map.
    ///
    /// # Errors
    /// `out` of another length than the receivers.
    pub fn shade(&self, receivers: &[Receiver], out: &mut [f32]) -> Result<(), OpacityError> {
        let (expected, actual) = (receivers.len(), out.len());
        if expected != actual {
            return Err(OpacityError::Length { what: "results", expected, actual });
        }
        out.par_chunks_mut(SHADED).zip(receivers.par_chunks(SHADED)).for_each(
            |(out, receivers)| {
                for (t, receiver) in out.iter_mut().zip(receivers) {
                    *t = self.transmittance(receiver);
                }
            },
        );
        Ok(())
    }

    /// Transmittance of one receiver.
    pub fn transmittance(&self, receiver: &Receiver) -> f32 {
        if !receiver.in_map() {
            return 1.0;
        }
        let mut found = [Tap { texel: 0, du: 0.0, dv: 0.0 }; MOST];
        let (width, height) = (self.width, self.height);
        let n = taps::taps(self.settings.taps, receiver, width, height, &mut found);
        let found = &found[..n];
        let depth = receiver.depth - self.settings.bias;
        let lit = |tap: &Tap| self.is_lit(receiver, tap);
        match self.settings.blur {
            Blur::Transmittance => {
                let decoded = |tap: &Tap| {
                    if lit(tap) {
                        self.code.decode(tap.texel, self.texel(tap.texel), depth)
                    } else {
                        0.0
                    }
                };
                found.iter().map(decoded).sum::<f32>() / n as f32
            }
            Blur::Stored => {
                let mut read: [(usize, &[f32]); MOST] = [(0, &[]); MOST];
                for (slot, tap) in read.iter_mut().zip(found) {
                    *slot = (tap.texel, self.texel(tap.texel));
                }
                let share = found.iter().filter(|tap| lit(tap)).count() as f32 / n as f32;
                let own = taps::own(receiver, width, height);
                share * self.code.decode_mean((own, self.texel(own)), &read[..n], depth)
            }
        }
    }

    /// What a texel stores.
    pub fn texel(&self, texel: usize) -> &[f32] {
        let words = self.code.words();
        &self.words[texel * words..(texel + 1) * words]
    }

    /// What all texels store, texel after texel.
    pub fn words(&self) -> &[f32] {
        &self.words
    }

    /// Number of texels.
    pub fn texels(&self) -> usize {
        self.opaque.len()
    }

    /// What the maps were asked for.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// The code that reads these maps.
    pub fn code(&self) -> &dyn TexelCode {
        self.code.as_ref()
    }

    /// Bytes of the maps as the technique stores them, the opaque map included where there is one.
    pub fn map_bytes(&self) -> u64 {
        let opaque = if self.settings.opaque == Opaque::Separate { 4 } else { 0 };
        (self.code.bytes_per_texel() + opaque) * self.opaque.len() as u64
    }

    /// The same of what texels use, where codes are of variable length.
    pub fn used_bytes(&self) -> u64 {
        let used: u64 =
            (0..self.opaque.len()).map(|texel| self.code.used_bytes(self.texel(texel))).sum();
        used + self.map_bytes() - self.code.bytes_per_texel() * self.opaque.len() as u64
    }

    fn is_lit(&self, receiver: &Receiver, tap: &Tap) -> bool {
        self.settings.opaque != Opaque::Separate
            || is_lit(receiver, tap, self.settings.bias, self.opaque[tap.texel])
    }
}

/// The test against an opaque map at a tap. Nothing opaque hides nothing, however deep.
pub fn is_lit(receiver: &Receiver, tap: &Tap, bias: f32, opaque_depth: f32) -> bool {
    opaque_depth >= crate::NO_OPAQUE || receiver.plane_depth(tap.du, tap.dv) - bias <= opaque_depth
}

/// The opaque fragment that goes into the opacity maps.
pub fn weighted(mode: Opaque, opaque_depth: f32) -> Option<Fragment> {
    match mode {
        Opaque::Weight { weight, .. } if opaque_depth < crate::NO_OPAQUE => {
            Some(Fragment { depth: opaque_depth, omega: weight })
        }
        _ => None,
    }
}
