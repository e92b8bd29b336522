//! A tree of boxes that stand still, to find those that are near to another box.
//!
//! Each node bounds a range of the boxes and is halved at the median of their middles along its longest edge
//! (Ericson, *Real-Time Collision Detection*, section 6.2). A query looks at few more boxes than are near.

use crate::bounds::Bounds;

/// A node with no more boxes than this is not halved: they are as quickly looked at as two nodes.
const MOST_IN_LEAF: usize = 4;

/// Boxes with an index each.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tree {
    /// In the order of a walk that goes into the first half before the second.
    nodes: Vec<Node>,
    /// The boxes, those of each node next to each other.
    boxes: Vec<(Bounds, usize)>,
}

#[derive(Clone, Copy, Debug)]
struct Node {
    bounds: Bounds,
    /// The node that follows when this one and all below it are passed over.
    next: usize,
    /// The boxes of a node that is not halved; empty for others.
    first: usize,
    end: usize,
}

impl Tree {
    /// The tree of some boxes.
    pub(crate) fn new(boxes: Vec<(Bounds, usize)>) -> Self {
        let mut tree = Self { nodes: Vec::with_capacity(boxes.len()), boxes };
        if !tree.boxes.is_empty() {
            tree.grow(0, tree.boxes.len());
        }
        tree
    }

    fn grow(&mut self, first: usize, end: usize) {
        let boxes = &mut self.boxes[first..end];
        let bounds = boxes.iter().skip(1).fold(boxes[0].0, |all, (bounds, _)| all.joined(bounds));
        let node = self.nodes.len();
        if boxes.len() <= MOST_IN_LEAF {
            self.nodes.push(Node { bounds, next: node + 1, first, end });
            return;
        }
        let axis = bounds.extent().imax();
        let middle = |bounds: &Bounds| bounds.low[axis] + bounds.high[axis];
        boxes.sort_by(|(a, _), (b, _)| middle(a).total_cmp(&middle(b)));
        self.nodes.push(Node { bounds, next: 0, first, end: first });
        let half = first + (end - first) / 2;
        self.grow(first, half);
        self.grow(half, end);
        self.nodes[node].next = self.nodes.len();
    }

    /// Calls with every box, as index and distance (m), that is not farther than `distance` (m) from some
    /// bounds, or of which that cannot be told.
    pub(crate) fn near(&self, bounds: &Bounds, distance: f64, mut found: impl FnMut(usize, f64)) {
        let mut at = 0;
        while let Some(node) = self.nodes.get(at) {
            // A NaN is near.
            if node.bounds.distance(bounds) > distance {
                at = node.next;
                continue;
            }
            for (other, index) in &self.boxes[node.first..node.end] {
                let apart = other.distance(bounds);
                let is_far = apart > distance;
                if !is_far {
                    found(*index, apart);
                }
            }
            at += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;
    use crate::fixtures::Draw;

    fn random(draw: &mut Draw, most: f64) -> Bounds {
        let mut vector = |low: f64, high: f64| Vector3::from_fn(|_, _| draw.between(low, high));
        let low = vector(-1.0, 1.0);
        Bounds { low, high: low + vector(0.0, most) }
    }

    #[test]
    fn the_near_boxes_are_those_that_a_look_at_all_finds() {
        let mut draw = Draw(31);
        for count in [0, 1, 4, 5, 9, 100, 700] {
            let boxes: Vec<Bounds> = (0..count).map(|_| random(&mut draw, 0.2)).collect();
            let tree = Tree::new(boxes.iter().copied().zip(0..).collect());
            for _ in 0..50 {
                let (at, reach) = (random(&mut draw, 0.5), draw.between(0.0, 0.3));
                let mut found = Vec::new();
                tree.near(&at, reach, |index, apart| found.push((index, apart)));
                found.sort_by_key(|(index, _)| *index);
                let all = boxes.iter().enumerate().map(|(index, other)| (index, at.distance(other)));
                assert_eq!(found, all.filter(|(_, apart)| *apart <= reach).collect::<Vec<_>>());
            }
        }
    }

    #[test]
    fn all_boxes_are_near_to_what_is_nowhere() {
        let mut draw = Draw(32);
        let tree = Tree::new((0..50).map(|index| (random(&mut draw, 0.2), index)).collect());
        let nowhere = Vector3::new(f64::NAN, 0.0, 0.0);
        let mut count = 0;
        tree.near(&Bounds { low: nowhere, high: nowhere }, 0.1, |_, _| count += 1);
        assert_eq!(count, 50);
    }
}
