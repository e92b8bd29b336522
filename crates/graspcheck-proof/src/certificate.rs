//! The proof of clearance as data: what travels with a recording as `certificate.json`.

use serde::{Deserialize, Serialize};

/// Version of the form of `certificate.json`.
pub const CERTIFICATE_SCHEMA: u32 = 1;

/// For every pair of convex solids a proof that it keeps its required distance at every instant of a plan,
/// a proof that it does not, or that neither was found.
///
/// Between the two limits at a knot where a position jumps the plan says nothing, and neither does this:
/// the check of continuity names such a jump.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Certificate {
    /// [`CERTIFICATE_SCHEMA`] when it was written.
    pub schema: u32,
    /// Duration of the plan, s: the leaves of a free pair cover `[0, duration]`.
    pub duration: f64,
    /// All pairs of the scene, in a fixed order.
    pub pairs: Vec<PairCertificate>,
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
    /// The steps of the proof in order of time, as far as it got.
    pub leaves: Vec<Leaf>,
}

/// How the proof for one pair came out.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PairVerdict {
    /// Proved to keep its required distance at every instant.
    Free {
        /// Distance less the required one is at least this, m; not the largest such bound.
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
    /// Bound on what motion can take from it on the interval, m.
    pub loss: f64,
    /// What is required, m; negative, the deepest overlap, while the pair may touch.
    pub required: f64,
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
    /// Violated if any pair is, else not checked if any is not or there is none, else unknown if any is,
    /// else free.
    #[must_use]
    pub fn outcome(&self) -> ProofOutcome {
        let any = |test: fn(&PairVerdict) -> bool| self.pairs.iter().any(|pair| test(&pair.verdict));
        if any(|verdict| matches!(verdict, PairVerdict::Violated(_))) {
            ProofOutcome::Violated
        } else if self.pairs.is_empty() || any(|verdict| matches!(verdict, PairVerdict::NotChecked { .. })) {
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

    /// The number of steps of all proofs.
    #[must_use]
    pub fn leaf_count(&self) -> usize {
        self.pairs.iter().map(|pair| pair.leaves.len()).sum()
    }
}
