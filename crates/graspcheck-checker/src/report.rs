//! What came out.

use std::fmt;

/// What came out of checking the certificate of a recording.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Report {
    /// How many pairs of solids must be proved, by robot, cell and object.
    pub pairs: usize,
    /// How many steps of proofs were validated or found wrong.
    pub leaves: usize,
    /// Of those pairs, the ones that the certificate says to be nearer than required at some instant.
    pub violated: Vec<PairName>,
    /// The ones of which it says that they are unknown or not checked. They are not checked here either.
    pub undecided: Vec<PairName>,
    /// What is wrong.
    pub findings: Vec<Finding>,
}

impl Report {
    /// Whether what the certificate says as a whole is right: nothing in it is wrong or missing, and either
    /// every pair was proved to be free, or one to be nearer than required. Pairs that are undecided leave
    /// the first open and do not matter to the second.
    #[must_use]
    pub fn is_confirmed(&self) -> bool {
        let is_decided = self.undecided.is_empty() || !self.violated.is_empty();
        self.findings.is_empty() && is_decided && self.pairs > 0
    }
}

/// Two convex solids: each by the name of its body and its index among the body's.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct PairName {
    /// Name of the first body.
    pub a: String,
    /// Index of its solid.
    pub part_a: usize,
    /// Name of the second body.
    pub b: String,
    /// Index of its solid.
    pub part_b: usize,
}

impl fmt::Display for PairName {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Self { a, part_a, b, part_b } = self;
        write!(f, "{a}[{part_a}] - {b}[{part_b}]")
    }
}

/// One thing that the certificate says and that is not so.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// Which solids; none where it is about the whole certificate.
    pub pair: Option<PairName>,
    /// From when to when, s; the same time twice for an instant.
    pub interval: [f64; 2],
    /// What is wrong.
    pub quantity: Quantity,
    /// What the certificate says.
    pub stated: f64,
    /// What was found here.
    pub recomputed: f64,
}

/// What can be wrong in a certificate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// How often a pair is in the certificate; it must be there as often as in the scene: once or never.
    Occurrences,
    /// The duration of the plan, s.
    Duration,
    /// When an interval starts, s: not where the one before ended, or not before its own end.
    Start,
    /// When the last interval ends, s: not at the end of the plan.
    End,
    /// When an interval starts or ends, s: beyond the phase of its middle (`recomputed` is that limit), so that
    /// two phases share it. Of a violation its time: not in the phase that is named.
    Phase,
    /// The required distance, m.
    Required,
    /// The length of the normal.
    Normal,
    /// A bound on the distance at the middle of the interval, m, is too large.
    Gap,
    /// A bound on what motion can take from it, m, is too small.
    Loss,
    /// The distance over the interval, m, falls below the required one (which is what `recomputed` says), or
    /// is not known because a coordinate or a joint's position is too large to compute with.
    Clearance,
    /// The margin of a pair, m, is larger than its steps show.
    Margin,
    /// The distance of a violation, m, is not below the required one.
    Violation,
    /// How deep a witness point of a violation lies in its solid, m: it is outside.
    Witness,
    /// The distance of a violation, m, is smaller than its witness points show.
    WitnessDistance,
}

impl Quantity {
    /// A word or two for it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Occurrences => "occurrences of the pair",
            Self::Duration => "duration",
            Self::Start => "start of the interval",
            Self::End => "end of the last interval",
            Self::Phase => "time within one phase",
            Self::Required => "required distance",
            Self::Normal => "length of the normal",
            Self::Gap => "gap",
            Self::Loss => "loss",
            Self::Clearance => "gap less loss",
            Self::Margin => "margin",
            Self::Violation => "distance of the violation",
            Self::Witness => "depth of the witness point",
            Self::WitnessDistance => "distance of the witness points",
        }
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let [start, end] = self.interval;
        if let Some(pair) = &self.pair {
            write!(f, "{pair}, ")?;
        }
        if start < end {
            write!(f, "t = {start} … {end} s: ")?;
        } else {
            write!(f, "t = {start} s: ")?;
        }
        write!(f, "{} is stated as {}, found to be {}", self.quantity.name(), self.stated, self.recomputed)
    }
}
