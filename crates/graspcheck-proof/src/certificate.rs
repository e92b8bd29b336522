//! The proof of clearance as data: what travels with a recording as `certificate.json`.

use serde::{Deserialize, Serialize};

/// Version of the form of `certificate.json`.
pub const CERTIFICATE_SCHEMA: u32 = 2;

/// For every pair of convex solids a proof that it keeps its required distance at every instant of a plan,
/// a proof that it does not, or that neither was found.
///
/// A free pair is covered: at every instant of `[0, duration]` there is a leaf of the pair or, for a solid of
/// the cell, a [`Sweep`] of the other solid that keeps far enough from it. Leaves of a pair do not overlap, and
/// neither do sweeps of a solid; where one ends, another begins at the very same number.
///
/// Between the two limits at a knot where a position jumps the plan says nothing, and neither does this:
/// the check of continuity names such a jump.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Certificate {
    /// [`CERTIFICATE_SCHEMA`] when it was written.
    pub schema: u32,
    /// Duration of the plan, s: leaves and sweeps of a free pair cover `[0, duration]`.
    pub duration: f64,
    /// How many pairs the scene has; those that `pairs` does not list are proved by sweeps alone.
    #[serde(default)]
    pub pair_count: usize,
    /// Pairs of the scene that have leaves or are not free, in a fixed order.
    pub pairs: Vec<PairCertificate>,
    /// Boxes that hold a solid of the robot or the object for a while, in order of time; none where the cell
    /// has few bodies.
    #[serde(default)]
    pub sweeps: Vec<Sweep>,
}

/// What is proved of one pair of convex solids.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PairCertificate {
    /// Name of the body of the first solid.
    pub a: String,
    /// Index of the solid among those of its body.
    pub part_a: usize,
    /// Name of the body of the second solid.
    pub b: String,
    /// Index of the solid among those of its body.
    pub part_b: usize,
    /// How it came out.
    pub verdict: PairVerdict,
    /// The steps of the proof in order of time, as far as it got; where a sweep covers the pair there is none.
    pub leaves: Vec<Leaf>,
}

/// How the proof for one pair came out.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PairVerdict {
    /// Proved to keep its required distance at every instant.
    Free {
        /// On all leaves the distance less the required one is at least this, m; not the largest such bound.
        margin: f64,
    },
    /// Proved not to.
    Violated(Violation),
    /// Neither could be proved near one instant, where the distance is too near to the required one, and no
    /// violation was found elsewhere. The leaves leave such intervals out.
    Unknown(Doubt),
    /// Not looked at to the end; never to be taken for free.
    NotChecked {
        /// Why.
        reason: String,
    },
}

/// An instant at which a pair is nearer than required.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Violation {
    /// When, s; not the first nor the worst instant.
    pub time: f64,
    /// Name of the phase.
    pub phase: String,
    /// The signed distance is at most this, m.
    pub distance: f64,
    /// What is required, m.
    pub required: f64,
    /// A point of each solid in the world, m, as far apart as `distance` says; where the solids overlap,
    /// points common to both.
    pub points: [[f64; 3]; 2],
}

/// An interval so short that the search ended.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Doubt {
    /// From when to when, s.
    pub interval: [f64; 2],
    /// Name of the phase.
    pub phase: String,
    /// The signed distance in its middle is at least and at most this, m.
    pub distance: [f64; 2],
    /// What is required, m.
    pub required: f64,
}

/// One step of a proof: on this interval the pair keeps at least `gap - loss`, which is at least `required`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Leaf {
    /// When the interval begins, s.
    pub start: f64,
    /// When it ends, s. The reference time is the middle, `0.5 * (start + end)`.
    pub end: f64,
    /// Direction of length 1 from a to b, in the world at the reference time.
    pub normal: [f64; 3],
    /// Lower bound on the signed distance at the reference time, m, by the slab across `normal`.
    pub gap: f64,
    /// Bound on what motion can take from it on the interval, m: how much farther the joints can make each of
    /// the two reach out along `normal` than at the reference time. For each of them it is either of the two
    /// bounds B1 and B2 that the docs of `displacement` state.
    pub loss: f64,
    /// What is required, m; negative, the deepest overlap, while the pair may touch.
    pub required: f64,
}

/// One step of the proofs of many pairs: on this interval all of a solid of the robot or the object is inside
/// of a box. Each solid of the cell whose own box (the smallest one along the axes of the world) is farther
/// from this one than the pair's required distance and [`GAP_SLACK`](crate::gap::GAP_SLACK) together, and than
/// that slack alone, is proved for the interval without a leaf.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sweep {
    /// When the interval begins, s.
    pub start: f64,
    /// When it ends, s. The reference time is the middle, `0.5 * (start + end)`.
    pub end: f64,
    /// Name of the body.
    pub body: String,
    /// Index of the solid among those of its body.
    pub part: usize,
    /// The least coordinates of the box in the world, m: minus support and loss along `-x`, `-y`, `-z`.
    pub min: [f64; 3],
    /// The largest coordinates, m: support and loss along `x`, `y`, `z`.
    pub max: [f64; 3],
}

/// How a whole certificate came out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ProofOutcome {
    /// Every pair is free, and there is at least one.
    Free,
    /// A pair is proved to be nearer than required.
    Violated,
    /// No pair is, but one is undecided.
    Unknown,
    /// No pair is, but one was not checked, or there is no pair.
    NotChecked,
}

impl Certificate {
    /// Violated if any pair is, else not checked if any is not or the scene has none, else unknown if any is,
    /// else free.
    #[must_use]
    pub fn outcome(&self) -> ProofOutcome {
        let any = |test: fn(&PairVerdict) -> bool| self.pairs.iter().any(|pair| test(&pair.verdict));
        if any(|verdict| matches!(verdict, PairVerdict::Violated(_))) {
            ProofOutcome::Violated
        } else if self.pair_count == 0 || any(|verdict| matches!(verdict, PairVerdict::NotChecked { .. })) {
            ProofOutcome::NotChecked
        } else if any(|verdict| matches!(verdict, PairVerdict::Unknown(_))) {
            ProofOutcome::Unknown
        } else {
            ProofOutcome::Free
        }
    }

    /// Whether every pair is proved free.
    #[must_use]
    pub fn is_free(&self) -> bool {
        self.outcome() == ProofOutcome::Free
    }

    /// The pairs that are proved to be nearer than required, each with an instant.
    pub fn violations(&self) -> impl Iterator<Item = (&PairCertificate, &Violation)> {
        self.pairs.iter().filter_map(|pair| match &pair.verdict {
            PairVerdict::Violated(violation) => Some((pair, violation)),
            _ => None,
        })
    }

    /// Every pair of a free certificate keeps its required distance and at least this much more, m; not the
    /// largest such bound. Of pairs that sweeps prove it counts only that they keep what is required.
    #[must_use]
    pub fn proved_margin(&self) -> f64 {
        let of_pairs = self.pairs.iter().filter_map(|pair| match pair.verdict {
            PairVerdict::Free { margin } => Some(margin),
            _ => None,
        });
        of_pairs.fold(if self.sweeps.is_empty() { f64::INFINITY } else { 0.0 }, f64::min)
    }

    /// The number of steps of all proofs, sweeps and leaves.
    #[must_use]
    pub fn leaf_count(&self) -> usize {
        self.sweeps.len() + self.pairs.iter().map(|pair| pair.leaves.len()).sum::<usize>()
    }
}
