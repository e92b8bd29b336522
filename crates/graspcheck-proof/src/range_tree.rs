//! Least and largest of many ranges, of any run of them at once.

/// A binary tree over ranges: the union of any run of `n` of them is put together from at most `2 log₂ n`
/// nodes.
#[derive(Clone, Debug)]
pub(crate) struct RangeTree {
    /// Node i has the children 2i and 2i + 1; the leaves begin at half of the length.
    nodes: Vec<[f64; 2]>,
}

/// The union with this is the other one.
const NOTHING: [f64; 2] = [f64::INFINITY, f64::NEG_INFINITY];

fn union(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0].min(b[0]), a[1].max(b[1])]
}

impl RangeTree {
    /// The tree over some ranges.
    pub(crate) fn new(leaves: impl ExactSizeIterator<Item = [f64; 2]>) -> Self {
        let count = leaves.len();
        let mut nodes = vec![NOTHING; count];
        nodes.extend(leaves);
        for node in (1..count).rev() {
            nodes[node] = union(nodes[2 * node], nodes[2 * node + 1]);
        }
        Self { nodes }
    }

    /// The union of the ranges from `first` up to, but without, `end`; empty, that is upside down, of none.
    pub(crate) fn union_of(&self, first: usize, end: usize) -> [f64; 2] {
        let count = self.nodes.len() / 2;
        let (mut first, mut end, mut all) = (first + count, end + count, NOTHING);
        while first < end {
            if first & 1 == 1 {
                all = union(all, self.nodes[first]);
                first += 1;
            }
            if end & 1 == 1 {
                end -= 1;
                all = union(all, self.nodes[end]);
            }
            (first, end) = (first / 2, end / 2);
        }
        all
    }
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "a union has the very ends of its parts")]
mod tests {
    use super::*;
    use crate::fixtures::Draw;

    #[test]
    fn every_run_is_the_union_of_its_ranges() {
        let mut draw = Draw(5);
        for count in [1, 2, 3, 7, 64, 101] {
            let ranges: Vec<[f64; 2]> = (0..count)
                .map(|_| {
                    let low = draw.between(-1.0, 1.0);
                    [low, low + draw.between(0.0, 0.1)]
                })
                .collect();
            let tree = RangeTree::new(ranges.iter().copied());
            for first in 0..=count {
                for end in first..=count {
                    let expected = ranges[first..end].iter().copied().fold(NOTHING, union);
                    assert_eq!(tree.union_of(first, end), expected, "{first}..{end} of {count}");
                }
            }
        }
    }
}
