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
/// items in the order they came, or `None` if there are more.
///
/// `fill` hands over cell (counted from the first of the rows asked for) and item of everything in
/// some rows, until it is told false.
pub(crate) fn gather<T: Copy + Default + Send + Sync>(
    [width, height]: [u32; 2],
    limit: usize,
    fill: impl Fn(Range<u32>, &mut dyn FnMut(u32, T) -> bool) + Sync,
) -> Option<(Vec<u32>, Vec<T>)> {
    if width == 0 || height == 0 {
        return Some((vec![0], Vec::new()));
    }
    let rows = height.div_ceil(BANDS);
    let total = AtomicUsize::new(0);
    let band = |i: u32| {
        let rows = i * rows..(i * rows + rows).min(height);
        let cells = rows.len() * width as usize;
        let before = total.load(Ordering::Relaxed);
        let mut found = Vec::new();
        fill(rows, &mut |cell, item| {
            found.push((cell, item));
            before + found.len() <= limit
        });
        total.fetch_add(found.len(), Ordering::Relaxed);
        sorted(cells, &found)
    };
    let bands: Vec<_> = (0..height.div_ceil(rows)).into_par_iter().map(band).collect();
    if total.into_inner() > limit {
        return None;
    }
    let starts = starts(bands.iter().flat_map(|band| &band.0).copied());
    let items: Vec<&[T]> = bands.iter().map(|band| band.1.as_slice()).collect();
    Some((starts, items.concat()))
}

/// The length of each cell's list, and the lists.
fn sorted<T: Copy + Default>(cells: usize, found: &[(u32, T)]) -> (Vec<u32>, Vec<T>) {
    let mut lengths = vec![0; cells];
    for (cell, _) in found {
        lengths[*cell as usize] += 1;
    }
    let mut next = starts(lengths.iter().copied());
    let mut items = vec![T::default(); found.len()];
    for &(cell, item) in found {
        items[next[cell as usize] as usize] = item;
        next[cell as usize] += 1;
    }
    (lengths, items)
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
        let fill = |rows: Range<u32>, emit: &mut dyn FnMut(u32, usize) -> bool| {
            for item in 0..5000 {
                let cell = (item * item % 700) as u32;
                if rows.contains(&(cell / 7)) && !emit(cell - 7 * rows.start, item) {
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
