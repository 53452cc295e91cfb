//! Rings of a multipolygon: its member ways, joined end to end.

use std::collections::BTreeMap;

/// Joins open ways into closed rings of node ids; the first node is not repeated.
///
/// # Errors
/// One clause, where an end is left over or it is open how to go on.
pub fn join(ways: &[&[i64]]) -> Result<Vec<Vec<i64>>, &'static str> {
    let mut rings = vec![];
    // Open ways at each of their ends.
    let mut ends: BTreeMap<i64, Vec<usize>> = BTreeMap::new();
    for (i, way) in ways.iter().enumerate() {
        let (Some(&first), Some(&last)) = (way.first(), way.last()) else {
            return Err("with members without nodes");
        };
        if first == last {
            rings.push(way[..way.len() - 1].to_vec());
        } else {
            ends.entry(first).or_default().push(i);
            ends.entry(last).or_default().push(i);
        }
    }
    if ends.values().any(|ways| ways.len() != 2) {
        return Err("whose rings are not closed");
    }
    let mut used = vec![false; ways.len()];
    for i in 0..ways.len() {
        let open = ways[i].first() != ways[i].last();
        if !open || std::mem::replace(&mut used[i], true) {
            continue;
        }
        let start = ways[i][0];
        let mut ring = ways[i].to_vec();
        while let Some(&here) = ring.last().filter(|&&here| here != start) {
            let onward = ends.get(&here).and_then(|w| w.iter().copied().find(|&w| !used[w]));
            let Some(next) = onward else { return Err("whose rings are not closed") };
            used[next] = true;
            let way = ways[next];
            if way[0] == here {
                ring.extend(&way[1..]);
            } else {
                ring.extend(way.iter().rev().skip(1));
            }
        }
        ring.pop();
        rings.push(ring);
    }
    Ok(rings)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ways_join_in_any_direction_and_open_ends_are_told() {
        let joined = join(&[&[1, 2, 3], &[5, 4, 3], &[5, 1], &[7, 8, 9, 7]]).unwrap();
        assert_eq!(joined, [vec![7, 8, 9], vec![1, 2, 3, 4, 5]]);
        assert!(join(&[&[1, 2], &[2, 3]]).is_err());
        assert!(join(&[&[1, 2], &[2, 1], &[1, 3], &[3, 1]]).is_err(), "which way from 1?");
        assert!(join(&[&[]]).is_err());
        assert_eq!(
            join(&[&[1, 2], &[2, 1]]).unwrap(),
            [vec![1, 2]],
            "two corners: for others to refuse"
        );
        assert!(join(&[]).unwrap().is_empty());
    }
}
