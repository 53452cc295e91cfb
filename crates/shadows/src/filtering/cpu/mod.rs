//! The fast form: f32, parallel, no allocation after [`Filter::new`].
//!
//! Windows cost the same at every width for boxes, minimum and maximum (`windows`), and grow with
//! the width for Gaussians. Pack is fused with filter-x: a depth is read, packed and rounded on
//! its way into the row pass. The filtered map lies in columns of sixteen texels, one behind the
//! other, so that the column pass reads and writes memory in order without a transpose.
//!
//! Values are rounded to the [`Format`](super::Format) wherever the GPU form stores one (packed
//! channel, result of filter-x, result of filter-y), but kept in f32: this form models the
//! precision of 16-bit maps, not their bandwidth. Sums are f64.

mod closer;

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

use rayon::prelude::*;

use self::closer::CloserTaps;
use super::channels::{Channels, MAX_READ, Reduction};
use super::kernel::Kernel;
use super::lookup::{Footprint, biased_depth};
use super::windows::{LANES, Lanes, Scratch};
use super::{Counters, DepthMap, Estimator, FilterError, KernelShape, Lookup, Receiver, Settings};

/// Receivers shaded by one task.
const SHADE_CHUNK: usize = 1024;
const STORED_BYTES: u64 = size_of::<f32>() as u64;

/// A filter for maps of one size with fixed settings.
#[derive(Debug)]
pub struct Filter {
    width: usize,
    height: usize,
    settings: Settings,
    kernel: Kernel,
    taps: CloserTaps,
    /// Of the map filtered last.
    channels: Option<Channels>,
    /// After filter-x: a plane a channel, rows rounded up to whole groups of [`LANES`]. For
    /// percentage-closer filtering in 16 bits: the rounded depths.
    rows: Vec<f32>,
    /// After filter-y: a plane a channel, in columns [`LANES`] wide.
    columns: Vec<f32>,
    /// One for every thread of the pool, so that none waits.
    scratch: Vec<Mutex<Scratch>>,
    /// Of the last [`Filter::shade`].
    shaded: AtomicU64,
    offered: AtomicU64,
}

impl Filter {
    /// Allocates everything for maps of `width` x `height` texels.
    ///
    /// # Errors
    /// Whatever [`Settings::check`] refuses.
    pub fn new(width: u32, height: u32, settings: &Settings) -> Result<Self, FilterError> {
        settings.check(width, height)?;
        let kernel = Kernel::of(settings);
        let taps = match settings.estimator {
            Estimator::Pcf { taps } => CloserTaps::new(&kernel, taps),
            _ => CloserTaps::new(&kernel, 0),
        };
        let (width, height) = (width as usize, height as usize);
        let channels = settings.channel_count() as usize;
        let (rows, columns, scratch) = if settings.prefiltered() {
            let scratch = || Mutex::new(Scratch::new(width.max(height), kernel.radius()));
            (
                vec![0.0; channels * width * height.next_multiple_of(LANES)],
                vec![0.0; channels * height * width.next_multiple_of(LANES)],
                (0..=rayon::current_num_threads()).map(|_| scratch()).collect(),
            )
        } else {
            (vec![0.0; width * height], Vec::new(), Vec::new())
        };
        Ok(Self {
            width,
            height,
            settings: *settings,
            kernel,
            taps,
            channels: None,
            rows,
            columns,
            scratch,
            shaded: AtomicU64::new(0),
            offered: AtomicU64::new(0),
        })
    }

    /// Pack, filter-x and filter-y; for `Hard` and `Pcf` only the rounding of a 16-bit map.
    ///
    /// # Errors
    /// A map of another size or with a depth outside 0..=1; the last filtered map is then gone.
    pub fn prefilter(&mut self, map: &DepthMap) -> Result<(), FilterError> {
        self.channels = None;
        map.check_size(self.width as u32, self.height as u32)?;
        map.check()?;
        let channels = Channels::new(&self.settings, map);
        if self.settings.prefiltered() {
            self.filter_x(map, &channels);
            self.filter_y(&channels);
        } else if self.settings.format != super::Format::F32 {
            let format = self.settings.format;
            let pairs = self.rows.par_iter_mut().zip(&map.depths);
            pairs.for_each(|(stored, &z)| *stored = format.round_f32(z));
        }
        self.channels = Some(channels);
        Ok(())
    }

    fn filter_x(&mut self, map: &DepthMap, channels: &Channels) {
        let Self { width, height, settings, kernel, rows, scratch, .. } = self;
        let (width, height, format, radius) = (*width, *height, settings.format, kernel.radius());
        let groups = height.div_ceil(LANES);
        rows.par_chunks_mut(LANES * width).enumerate().for_each(|(task, out)| {
            let (channel, top) = (task / groups, task % groups * LANES);
            let reduction = channels.reduction(channel);
            let curve = Curve::new(reduction, settings.exponent);
            let mut scratch = borrow(scratch);
            let lines = scratch.inner(width, radius);
            for lane in 0..LANES {
                // The last group repeats the last row rather than leave lanes unset.
                let y = (top + lane).min(height - 1);
                let depths = &map.depths[y * width..(y + 1) * width];
                for (slot, &z) in lines.iter_mut().zip(depths) {
                    slot[lane] = curve.load(format.round_f32(channels.pack(channel, z)));
                }
            }
            scratch.filter(reduction, kernel, width, |x, lanes| {
                for (lane, &value) in lanes.iter().enumerate() {
                    out[lane * width + x] = format.round_f32(curve.store(value));
                }
            });
        });
    }

    fn filter_y(&mut self, channels: &Channels) {
        let Self { width, height, settings, kernel, rows, columns, scratch, .. } = self;
        let (width, height, format, radius) = (*width, *height, settings.format, kernel.radius());
        let plane = width * height.next_multiple_of(LANES);
        let groups = width.div_ceil(LANES);
        columns.par_chunks_mut(LANES * height).enumerate().for_each(|(task, out)| {
            let (channel, left) = (task / groups, task % groups * LANES);
            let reduction = channels.reduction(channel);
            let curve = Curve::new(reduction, settings.exponent);
            let used = LANES.min(width - left);
            let mut scratch = borrow(scratch);
            for (y, slot) in scratch.inner(height, radius).iter_mut().enumerate() {
                let start = channel * plane + y * width + left;
                let row = &rows[start..start + used];
                for (slot, &value) in slot.iter_mut().zip(row) {
                    *slot = curve.load(value);
                }
                slot[used..].fill(0.0);
            }
            scratch.filter(reduction, kernel, height, |y, lanes: &Lanes| {
                for (out, &value) in out[y * LANES..].iter_mut().zip(&lanes[..used]) {
                    *out = format.round_f32(curve.store(value));
                }
            });
        });
    }

    /// Visibility in 0..=1 of every receiver, in order, into `out`; 1 for those outside the map.
    ///
    /// `map` is the one given to [`Filter::prefilter`]: `Hard` and `Pcf` in 32 bits read it again.
    ///
    /// # Errors
    /// No map filtered before, a map of another size, an output of another length.
    pub fn shade(
        &self,
        map: &DepthMap,
        receivers: &[Receiver],
        out: &mut [f32],
    ) -> Result<(), FilterError> {
        let channels = self.channels.as_ref().ok_or(FilterError::NotFiltered)?;
        map.check_size(self.width as u32, self.height as u32)?;
        if receivers.len() != out.len() {
            return Err(FilterError::OutputLength {
                receivers: receivers.len(),
                outputs: out.len(),
            });
        }
        let stored = match self.settings.format {
            super::Format::F32 => &map.depths,
            _ => &self.rows,
        };
        let in_map = out
            .par_chunks_mut(SHADE_CHUNK)
            .zip(receivers.par_chunks(SHADE_CHUNK))
            .map(|(out, receivers)| {
                let mut in_map = 0;
                for (out, receiver) in out.iter_mut().zip(receivers) {
                    *out = if !receiver.in_map() {
                        1.0
                    } else {
                        in_map += 1;
                        let footprint = self.footprint(receiver);
                        if self.settings.prefiltered() {
                            self.look_up(channels, receiver, &footprint)
                        } else {
                            self.closer_filtered(stored, receiver, &footprint)
                        }
                    };
                }
                in_map
            })
            .sum();
        self.shaded.store(in_map, Ordering::Relaxed);
        self.offered.store(receivers.len() as u64, Ordering::Relaxed);
        Ok(())
    }

    fn footprint(&self, receiver: &Receiver) -> Footprint {
        Footprint::new(receiver, self.settings.lookup, self.width as u32, self.height as u32)
    }

    fn look_up(&self, channels: &Channels, receiver: &Receiver, footprint: &Footprint) -> f32 {
        let (width, height) = (self.width, self.height);
        let z = biased_depth(receiver, &self.settings, width as u32, height as u32);
        let groups = width.div_ceil(LANES);
        let corners = footprint.corners();
        let mut stats = [0.0; MAX_READ];
        for (stat, channel) in stats.iter_mut().zip(channels.read(z)) {
            let at = |x: usize, y: usize| {
                let column = channel * groups + x / LANES;
                self.columns[(column * height + y) * LANES + x % LANES]
            };
            *stat = if self.settings.lookup == Lookup::Nearest {
                at(footprint.x0 as usize, footprint.y0 as usize)
            } else {
                let corners = corners.map(|((x, y), share)| (share, at(x as usize, y as usize)));
                channels.blend(channel, corners)
            };
        }
        channels.visibility(&stats, z)
    }

    /// Work of the last [`Filter::prefilter`] and the last [`Filter::shade`].
    ///
    /// Each of the two passes reads a texel twice for boxes, minimum and maximum (as part of a
    /// block's tail and of a head), `2 radius + 1` times for a Gaussian mean:
    /// `prefilter_texels = 2 * width * height * (2 or 2 radius + 1)`, whatever the width of a box.
    /// Shade reads 1 or 4 texels, or the taps of percentage-closer filtering, for every receiver
    /// in the map. Bytes are those of the f32 planes this form moves to and from memory.
    #[must_use]
    pub fn counters(&self) -> Counters {
        let texels = (self.width * self.height) as u64;
        let shaded = self.shaded.load(Ordering::Relaxed);
        let receivers = self.offered.load(Ordering::Relaxed);
        let bilinear = self.settings.lookup == Lookup::Bilinear;
        let (prefilter_texels, prefilter_bytes, per_receiver, channels);
        if self.settings.prefiltered() {
            let reads = match self.settings.kernel {
                KernelShape::Box => 2,
                KernelShape::Gaussian => self.kernel.support() as u64,
            };
            prefilter_texels = 2 * texels * reads;
            // Read and written alike: once a channel in each pass.
            prefilter_bytes = 2 * texels * u64::from(self.settings.channel_count()) * STORED_BYTES;
            per_receiver = if bilinear { 4 } else { 1 };
            let layers = if self.settings.splits().is_some() { self.settings.layers } else { 1 };
            channels = u64::from(self.settings.channel_count() / layers);
        } else {
            let packs = self.settings.format != super::Format::F32;
            prefilter_texels = if packs { texels } else { 0 };
            prefilter_bytes = prefilter_texels * STORED_BYTES;
            let side = self.taps.along_one_axis(bilinear) as u64;
            per_receiver = side * side;
            channels = 1;
        }
        let shade_texels = shaded * per_receiver;
        Counters {
            texels_fetched: prefilter_texels + shade_texels,
            prefilter_texels,
            shade_texels,
            bytes_read: prefilter_bytes
                + shade_texels * channels * STORED_BYTES
                + receivers * size_of::<Receiver>() as u64,
            bytes_written: prefilter_bytes + receivers * STORED_BYTES,
        }
    }
}

fn borrow(pool: &[Mutex<Scratch>]) -> MutexGuard<'_, Scratch> {
    let thread = rayon::current_thread_index().unwrap_or(0);
    // Scratch is overwritten before it is read: a panic elsewhere leaves nothing to distrust.
    pool[thread % pool.len()].lock().unwrap_or_else(PoisonError::into_inner)
}

/// What a value is turned into before it is summed, and back.
#[derive(Clone, Copy)]
enum Curve {
    Straight,
    /// `exp(c x)`, c <= 700: neither it nor a sum of it leaves f64.
    Exponential(f64),
}

impl Curve {
    fn new(reduction: Reduction, exponent: f32) -> Self {
        match reduction {
            Reduction::LogMean => Self::Exponential(f64::from(exponent)),
            _ => Self::Straight,
        }
    }

    #[inline]
    fn load(self, value: f32) -> f64 {
        match self {
            Self::Straight => f64::from(value),
            Self::Exponential(c) => (c * f64::from(value)).exp(),
        }
    }

    #[inline]
    fn store(self, value: f64) -> f32 {
        match self {
            Self::Straight => value as f32,
            Self::Exponential(c) => (value.ln() / c) as f32,
        }
    }
}
