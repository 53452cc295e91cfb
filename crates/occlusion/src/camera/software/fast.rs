//! The renderer to use without a device: bands of rows filled in parallel.
//!
//! A draw goes through its objects in rounds. In each, pieces of the list are placed, projected and
//! set up in parallel, their triangles sorted into the bands they touch; then the bands are filled in
//! parallel, each from the pieces in the order of the list. So the image is that of drawing one
//! triangle after the other, on any number of threads, and a round's buffers bound the memory.
//! Nothing is taken from the heap once they have grown to what a frame needs.

use super::super::{Bounds, Image, Objects, Query, Readiness, Renderer, View};
use super::answers::Answers;
use super::check;
use super::fill::{Band, passing};
use super::project::{BOX, Projection};
use super::setup::{Masked, SOLID, Snapped, Triangle, Visible, clipped, setup};
use crate::OcclusionError;
use rayon::prelude::*;
use std::sync::Arc;

/// Fast on processors: what the `cpu` forms draw with.
#[derive(Clone, Debug)]
pub struct Fast {
    objects: Arc<Objects>,
    answers: Answers,
    frame: Option<(View, Projection)>,
    image: Image,
    pieces: Vec<Piece>,
    counts: Vec<u32>,
}

/// Triangles that a piece of the list of objects holds at most, if it is not one object.
const PIECE: usize = 2048;
/// Pieces of a round.
const ROUND: usize = 64;
/// Least number of triangles that more than one thread sets up and fills.
const PARALLEL: usize = 1024;
/// Least number of boxes that more than one thread asks about.
const PARALLEL_BOXES: usize = 8;
/// Least number of rows of a band, and most bands.
const BAND_ROWS: u32 = 8;
const BANDS: u32 = 64;

/// What has been set up of a piece of the list of objects.
#[derive(Clone, Debug, Default)]
struct Piece {
    corners: Vec<Snapped>,
    triangles: Vec<Triangle>,
    masked: Vec<Masked>,
    // Indices of triangles, for each band.
    bands: Vec<Vec<u32>>,
}

impl Fast {
    /// # Errors
    /// Objects with coordinates that are not finite or indices out of range, or answers polled.
    pub fn new(objects: Arc<Objects>, readiness: Readiness) -> Result<Self, OcclusionError> {
        check::objects(&objects)?;
        Ok(Self {
            objects,
            answers: Answers::new(readiness)?,
            frame: None,
            image: Image::default(),
            pieces: Vec::new(),
            counts: Vec::new(),
        })
    }

    /// What has been drawn since the frame began.
    pub fn image(&self) -> &Image {
        &self.image
    }

    /// How many samples of the grown box would pass the depth test now: the box test at full
    /// resolution. Every pixel of the image for a box that cannot be asked about, 0 before the first
    /// frame.
    pub fn would_show(&self, bounds: &Bounds) -> u32 {
        match &self.frame {
            None => 0,
            Some((view, _)) if view.touches(bounds) => view.width * view.height,
            Some((view, projection)) => shown(projection, &view.guarded(bounds), &self.image),
        }
    }
}

fn frame(frame: &Option<(View, Projection)>) -> Result<&(View, Projection), OcclusionError> {
    frame.as_ref().ok_or_else(|| OcclusionError::value("drawing", "begins with a frame"))
}

impl Renderer for Fast {
    fn begin(&mut self, view: &View) -> Result<(), OcclusionError> {
        check::view(view)?;
        self.image.clear(view.width, view.height);
        self.frame = Some((view.clone(), Projection::new(view)));
        Ok(())
    }

    fn draw(&mut self, objects: &[u32]) -> Result<(), OcclusionError> {
        check::drawn(objects, self.objects.objects.len())?;
        let (view, projection) = frame(&self.frame)?;
        let mut rest = objects;
        while !rest.is_empty() {
            rest = round(&self.objects, view, projection, rest, &mut self.pieces, &mut self.image);
        }
        self.answers.drew(objects.len());
        Ok(())
    }

    fn ask(&mut self, boxes: &[Bounds], queries: &[Query]) -> Result<(), OcclusionError> {
        check::asked(boxes, queries)?;
        let (view, projection) = frame(&self.frame)?;
        let image = &self.image;
        let count = |query: &Query| {
            boxes[query.boxes.start as usize..query.boxes.end as usize]
                .iter()
                .map(|b| shown(projection, &view.guarded(b), image))
                .fold(0, u32::saturating_add)
        };
        self.counts.clear();
        self.counts.resize(queries.len(), 0);
        let answers = &mut self.counts[..];
        if boxes.len() < PARALLEL_BOXES {
            answers.iter_mut().zip(queries).for_each(|(answer, query)| *answer = count(query));
        } else {
            answers.par_iter_mut().zip(queries).for_each(|(answer, query)| *answer = count(query));
        }
        self.answers.asked(boxes.len(), &self.counts);
        Ok(())
    }

    fn ready(&mut self) -> Result<bool, OcclusionError> {
        Ok(self.answers.ready())
    }

    fn collect(&mut self, counts: &mut Vec<u32>) -> Result<(), OcclusionError> {
        self.answers.collect(counts)
    }

    fn end(&mut self) -> Result<(), OcclusionError> {
        Ok(())
    }
}

/// Draws the first objects of `list` and gives those that are left.
fn round<'a>(
    objects: &Objects,
    view: &View,
    projection: &Projection,
    list: &'a [u32],
    pieces: &mut Vec<Piece>,
    image: &mut Image,
) -> &'a [u32] {
    let band_rows = BAND_ROWS.max(image.height.div_ceil(BANDS));
    let mut parts: [&[u32]; ROUND] = [&[]; ROUND];
    let (mut rest, mut used, mut triangles) = (list, 0, 0);
    while used < ROUND && !rest.is_empty() {
        let (length, inside) = piece_of(objects, rest);
        (parts[used], rest) = rest.split_at(length);
        triangles += inside;
        used += 1;
    }
    pieces.resize_with(pieces.len().max(used), Piece::default);
    let prepare = |(piece, part): (&mut Piece, &&[u32])| {
        piece.clear(image.height.div_ceil(band_rows) as usize);
        for &index in *part {
            piece.add(objects, view, projection, index, band_rows);
        }
    };
    let pieces = &mut pieces[..used];
    if triangles < PARALLEL {
        pieces.iter_mut().zip(&parts).for_each(prepare);
    } else {
        pieces.par_iter_mut().zip(&parts).for_each(prepare);
    }
    let pieces = &*pieces;
    let (width, set_up) = (image.width, pieces.iter().map(|p| p.triangles.len()).sum::<usize>());
    let pixels = (band_rows * width) as usize;
    let fill = |(i, (depth, ids)): (usize, (&mut [f32], &mut [[u32; 2]]))| {
        let mut band = Band { first: i as u32 * band_rows, width, depth, ids };
        for piece in pieces {
            for &triangle in &piece.bands[i] {
                let triangle = &piece.triangles[triangle as usize];
                band.draw(triangle, &piece.masked, &objects.masks);
            }
        }
    };
    let (depth, ids) = (&mut image.depth[..], &mut image.ids[..]);
    if set_up < PARALLEL {
        depth.chunks_mut(pixels).zip(ids.chunks_mut(pixels)).enumerate().for_each(fill);
    } else {
        depth.par_chunks_mut(pixels).zip(ids.par_chunks_mut(pixels)).enumerate().for_each(fill);
    }
    rest
}

/// How many objects the next piece takes, and how many triangles they have.
fn piece_of(objects: &Objects, list: &[u32]) -> (usize, usize) {
    let mut triangles = 0;
    for (i, &index) in list.iter().enumerate() {
        let more = objects.triangle_count(index) as usize;
        if i > 0 && triangles + more > PIECE {
            return (i, triangles);
        }
        triangles += more;
    }
    (list.len(), triangles)
}

impl Piece {
    fn clear(&mut self, bands: usize) {
        self.triangles.clear();
        self.masked.clear();
        self.bands.resize_with(bands.max(self.bands.len()), Vec::new);
        self.bands.iter_mut().for_each(Vec::clear);
    }

    /// Sets up what the view sees of one object.
    fn add(
        &mut self,
        objects: &Objects,
        view: &View,
        projection: &Projection,
        index: u32,
        band_rows: u32,
    ) {
        let object = &objects.objects[index as usize];
        if !view.sees(&object.bounds) {
            return;
        }
        let template = &objects.templates[object.template as usize];
        self.corners.clear();
        self.corners.extend(
            template
                .positions
                .iter()
                .map(|&p| Snapped::new(projection, projection.clip(object.place(p)))),
        );
        for (i, triangle) in template.triangles.iter().enumerate() {
            let id = [index + 1, i as u32];
            let snapped = triangle.map(|c| &self.corners[c as usize]);
            let ready = setup(projection, snapped, id);
            if matches!(ready, Visible::Nothing) {
                continue;
            }
            let masked = match template.mask {
                None => SOLID,
                Some(mask) => {
                    let corners = projection.triangle(object, template, i);
                    self.masked.push(Masked::new(mask, projection, &corners));
                    self.masked.len() as u32 - 1
                }
            };
            match ready {
                Visible::Nothing => {}
                Visible::Whole(whole) => self.push(Triangle { masked, ..whole }, band_rows),
                Visible::Clip => {
                    let corners = projection.triangle(object, template, i);
                    clipped(projection, &corners, id, |part| {
                        self.push(Triangle { masked, ..part }, band_rows);
                    });
                }
            }
        }
    }

    fn push(&mut self, triangle: Triangle, band_rows: u32) {
        let bands = triangle.rows.map(|y| (u32::from(y) / band_rows) as usize);
        let index = self.triangles.len() as u32;
        for band in &mut self.bands[bands[0]..=bands[1]] {
            band.push(index);
        }
        self.triangles.push(triangle);
    }
}

/// Samples of a box at least as near as what is drawn; every face counts.
fn shown(projection: &Projection, bounds: &Bounds, image: &Image) -> u32 {
    let snapped = bounds.corners().map(|p| Snapped::new(projection, projection.clip(p)));
    let mut count = 0_u32;
    let mut add = |triangle: &Triangle| {
        count = count.saturating_add(passing(triangle, image.width, &image.depth));
    };
    for (i, triangle) in BOX.iter().enumerate() {
        let corners = triangle.map(|c| &snapped[usize::from(c)]);
        match setup(projection, corners, [0, 0]) {
            Visible::Nothing => {}
            Visible::Whole(triangle) => add(&triangle),
            Visible::Clip => {
                let corners = projection.triangles_of(bounds)[i];
                clipped(projection, &corners, [0, 0], |part| add(&part));
            }
        }
    }
    count
}
