//! Lists of lists in one array, as maps and images have them, and where their rays go.

use rayon::prelude::*;
use std::{
    ops::Range,
    sync::atomic::{AtomicUsize, Ordering},
};

/// Bands of rows that are filled in parallel. More balance better, but each may have to look through
/// all there is.
const BANDS: u32 = 64;

/// Coordinate 0..=1 of the middle of texel or pixel `i` of `n`.
pub(crate) fn centre(i: u32, n: u32) -> f64 {
    (f64::from(i) + 0.5) / f64::from(n)
}

/// Where each list starts, and at last where they end, from their lengths.
pub(crate) fn starts(lengths: impl Iterator<Item = u32>) -> Vec<u32> {
    let mut end = 0;
    let ends = lengths.map(|length| {
        end += length;
        end
    });
    std::iter::once(0).chain(ends).collect()
}

/// Where list `index` lies; empty where there is none.
pub(crate) fn range(starts: &[u32], index: usize) -> Range<usize> {
    match (starts.get(index), starts.get(index + 1)) {
        (Some(&start), Some(&end)) => start as usize..end as usize,
        _ => 0..0,
    }
}

/// The items of consecutive lists, `lists` at a time.
pub(crate) fn split<'a, T>(
    starts: &[u32],
    lists: usize,
    mut items: &'a mut [T],
) -> Vec<&'a mut [T]> {
    let mut parts = Vec::new();
    let mut first = 0;
    while first + 1 < starts.len() {
        let last = (first + lists.max(1)).min(starts.len() - 1);
        let here;
        (here, items) = items.split_at_mut((starts[last] - starts[first]) as usize);
        parts.push(here);
        first = last;
    }
    parts
}

/// A list for each cell of a raster, `limit` (< 2^32) items at most in all: their starts and the
/// items, or `None` if there are more.
///
/// `fill` hands over cell (counted from the first of the rows asked for) and item of everything in
/// some rows, until it is told false; it is asked twice, first to count.
pub(crate) fn gather<T: Copy + Default + Send>(
    [width, height]: [u32; 2],
    limit: usize,
    fill: impl Fn(Range<u32>, &mut dyn FnMut(usize, T) -> bool) + Sync,
) -> Option<(Vec<u32>, Vec<T>)> {
    let mut starts = vec![0; width as usize * height as usize + 1];
    if starts.len() == 1 {
        return Some((starts, Vec::new()));
    }
    let rows = height.div_ceil(BANDS);
    let band = |i: usize| i as u32 * rows..(i as u32 * rows + rows).min(height);
    let cells = rows as usize * width as usize;
    let total = AtomicUsize::new(0);
    starts[1..].par_chunks_mut(cells).enumerate().for_each(|(i, counts)| {
        let before = total.load(Ordering::Relaxed);
        let mut found = 0;
        fill(band(i), &mut |cell, _| {
            counts[cell] += 1;
            found += 1;
            before + found <= limit
        });
        total.fetch_add(found, Ordering::Relaxed);
    });
    let total = total.into_inner();
    if total > limit {
        return None;
    }
    let mut end = 0;
    for start in &mut starts {
        end += *start;
        *start = end;
    }
    let mut items = vec![T::default(); total];
    let bands = split(&starts, cells, &mut items);
    bands.into_par_iter().enumerate().for_each(|(i, items)| {
        let here = &starts[i * cells..];
        let mut next: Vec<u32> = here.iter().take(cells).map(|s| s - here[0]).collect();
        fill(band(i), &mut |cell, item| {
            items[next[cell] as usize] = item;
            next[cell] += 1;
            true
        });
    });
    Some((starts, items))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_lie_one_after_the_other() {
        assert_eq!(starts([3, 0, 2].into_iter()), [0, 3, 3, 5]);
        assert_eq!(starts(std::iter::empty()), [0]);
        let starts = starts([3, 0, 2].into_iter());
        assert_eq!([0, 1, 2, 3].map(|i| range(&starts, i)), [0..3, 3..3, 3..5, 0..0]);
        assert_eq!((centre(0, 4), centre(3, 4)), (0.125, 0.875));
    }

    #[test]
    fn items_gather_in_their_cells_in_the_order_they_come() {
        // Item k lies in cell k² mod 700 of 7 columns and 100 rows.
        let fill = |rows: Range<u32>, emit: &mut dyn FnMut(usize, usize) -> bool| {
            for item in 0..5000 {
                let cell = item * item % 700;
                if rows.contains(&(cell as u32 / 7)) && !emit(cell - 7 * rows.start as usize, item)
                {
                    return;
                }
            }
        };
        let (starts, items) = gather([7, 100], 5000, fill).unwrap();
        assert_eq!((starts.len(), items.len()), (701, 5000));
        for cell in 0..700 {
            let list = &items[range(&starts, cell)];
            assert!(list.is_sorted() && list.iter().all(|item| item * item % 700 == cell));
        }
        assert!(gather([7, 100], 4999, fill).is_none());
        assert!(gather([7, 100], 0, fill).is_none());
        assert_eq!(gather([0, 9], 5000, fill), Some((vec![0], Vec::new())));
    }

    #[test]
    fn items_are_split_where_their_lists_are() {
        let mut items = [1, 2, 3, 4, 5];
        let parts = split(&[0, 3, 3, 5], 2, &mut items);
        assert_eq!(parts, [&[1, 2, 3][..], &[4, 5]]);
        assert!(split::<u8>(&[0], 2, &mut []).is_empty());
        assert!(split::<u8>(&[], 0, &mut []).is_empty());
    }
}
