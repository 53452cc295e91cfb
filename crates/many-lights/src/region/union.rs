//! One list of start nodes from those of several directions.

/// The union of precuts of one tree in increasing order, nodes inside others left out: no light is
/// counted twice. `size` is of the tree's nodes: the subtree of `i` is `i .. i + size(i)`.
pub fn union(precuts: &[&[u32]], size: impl Fn(u32) -> u32, nodes: &mut Vec<u32>) {
    nodes.clear();
    nodes.extend(precuts.iter().copied().flatten());
    nodes.sort_unstable();
    let mut end = 0;
    nodes.retain(|&node| {
        let kept = node >= end;
        if kept {
            end = node + size(node);
        }
        kept
    });
}

#[cfg(test)]
mod tests {
    use super::union;

    #[test]
    fn nodes_inside_others_and_doubles_are_left_out() {
        // 0 (1 2 (3 4) 5), 6
        let sizes = [6, 1, 3, 1, 1, 1, 1];
        let mut nodes = vec![9];
        union(&[&[2, 6], &[1, 3], &[4, 6]], |i| sizes[i as usize], &mut nodes);
        assert_eq!(nodes, [1, 2, 6]);
        union(&[&[0], &[5, 6]], |i| sizes[i as usize], &mut nodes);
        assert_eq!(nodes, [0, 6]);
        union(&[], |_| 1, &mut nodes);
        assert!(nodes.is_empty());
    }
}
