//! Cutting a mesh into clusters of few triangles.

use glam::Vec3;

/// The triangles of each cluster, ascending; at most `most` of them (at least 1). Halved again and
/// again at the median of the longest side of the triangles' centres; ties by index.
pub(super) fn clusters(positions: &[Vec3], triangles: &[[u32; 3]], most: u32) -> Vec<Vec<u32>> {
    let centres: Vec<Vec3> = triangles
        .iter()
        .map(|t| t.iter().map(|&c| positions[c as usize] / 3.0).sum::<Vec3>())
        .collect();
    let mut all: Vec<u32> = (0..triangles.len() as u32).collect();
    let mut done = Vec::new();
    let mut open = vec![&mut all[..]];
    while let Some(part) = open.pop() {
        if part.len() <= most.max(1) as usize {
            part.sort_unstable();
            done.push(part.to_vec());
            continue;
        }
        let axis = longest_axis(&centres, part);
        let key = |&t: &u32| (centres[t as usize][axis], t);
        let half = part.len() / 2;
        part.select_nth_unstable_by(half, |a, b| {
            let ((x, i), (y, j)) = (key(a), key(b));
            x.total_cmp(&y).then(i.cmp(&j))
        });
        let (low, high) = part.split_at_mut(half);
        // The lower half is taken first.
        open.push(high);
        open.push(low);
    }
    done
}

fn longest_axis(centres: &[Vec3], part: &[u32]) -> usize {
    let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    for &t in part {
        low = low.min(centres[t as usize]);
        high = high.max(centres[t as usize]);
    }
    (high - low).max_position()
}
