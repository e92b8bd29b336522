//! What came out.

use std::fmt;

use serde::Deserialize;

/// What came out of checking the proofs of a recording.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Report {
    /// How many pairs of solids must be proved, by robot, cell and object.
    pub pairs: usize,
    /// How many steps of proofs were validated or found wrong, sweeps among them.
    pub leaves: usize,
    /// How many of those are sweeps, which stand for steps of many pairs.
    pub sweeps: usize,
    /// How many bounds on quantities of joints were validated or found wrong. A log that is older than these
    /// proofs has none.
    pub limits: usize,
    /// Bounds on efforts that the log claims and that were not computed here.
    pub unchecked_limits: usize,
    /// Of the pairs, the ones that the certificate says to be nearer than required at some instant.
    pub violated: Vec<PairName>,
    /// The ones of which it says that they are unknown or not checked. They are not checked here either.
    pub undecided: Vec<PairName>,
    /// The limits of joints of which the log says that they are exceeded at some instant.
    pub exceeded: Vec<LimitName>,
    /// What is wrong.
    pub findings: Vec<Finding>,
}

impl Report {
    /// Whether what the log's proofs say as a whole is right: nothing in them is wrong or missing, and either
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

/// What a joint has a limit of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LimitQuantity {
    /// The least position, rad or m.
    PositionMin,
    /// The largest position, rad or m.
    PositionMax,
    /// The largest magnitude of the velocity, rad/s or m/s.
    Velocity,
    /// … of the acceleration, rad/s² or m/s².
    Acceleration,
    /// … of the jerk, rad/s³ or m/s³.
    Jerk,
    /// … of the torque or force of the drive, N·m or N.
    Effort,
}

impl LimitQuantity {
    /// All of them.
    pub const ALL: [Self; 6] =
        [Self::PositionMin, Self::PositionMax, Self::Velocity, Self::Acceleration, Self::Jerk, Self::Effort];

    /// A word or two for it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::PositionMin => "least position",
            Self::PositionMax => "largest position",
            Self::Velocity => "velocity",
            Self::Acceleration => "acceleration",
            Self::Jerk => "jerk",
            Self::Effort => "effort",
        }
    }
}

/// A limit of a joint.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct LimitName {
    /// Name of the joint.
    pub joint: String,
    /// Of what.
    pub quantity: LimitQuantity,
}

impl fmt::Display for LimitName {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{} of {}", self.quantity.name(), self.joint)
    }
}

/// Where in the proofs something is wrong.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Place {
    /// In what is said about all.
    Whole,
    /// In the proof of two solids.
    Pair(PairName),
    /// In a box around a moving solid: of which body, and its index among the body's.
    Sweep(String, usize),
    /// In the proof of a limit.
    Limit(LimitName),
    /// In a jump of a joint: of which, and of which derivative (0 position, 1 velocity, 2 acceleration).
    Break(String, usize),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Whole => write!(f, "the whole"),
            Self::Pair(pair) => pair.fmt(f),
            Self::Sweep(body, part) => write!(f, "sweep of {body}[{part}]"),
            Self::Limit(limit) => limit.fmt(f),
            Self::Break(joint, order) => write!(f, "jump of derivative {order} of {joint}"),
        }
    }
}

/// One thing that the proofs say and that is not so.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// Where it stands.
    pub place: Place,
    /// From when to when, s; the same time twice for an instant.
    pub interval: [f64; 2],
    /// What is wrong.
    pub quantity: Quantity,
    /// What the log says.
    pub stated: f64,
    /// What was found here.
    pub recomputed: f64,
}

/// What can be wrong in a proof.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// How often a pair, a limit or a jump is there; it must be there as often as in scene and plan: once or
    /// never. A pair may be missing where sweeps prove it; the interval then says from when they do not.
    Occurrences,
    /// How many pairs there are.
    PairCount,
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
    /// A coordinate of a box, m: the solid gets beyond it.
    Box,
    /// A limit of a joint, in its unit: not the robot's.
    Limit,
    /// A bound on a quantity of a joint, in its unit: it gets beyond it.
    Bound,
    /// The value of a quantity of a joint at an instant, in its unit.
    Peak,
    /// The size of a jump, in its unit.
    Jump,
}

impl Quantity {
    /// A word or two for it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Occurrences => "occurrences",
            Self::PairCount => "number of pairs",
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
            Self::Box => "side of the box",
            Self::Limit => "limit",
            Self::Bound => "bound",
            Self::Peak => "peak",
            Self::Jump => "size",
        }
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let [start, end] = self.interval;
        write!(f, "{}, ", self.place)?;
        if start < end {
            write!(f, "t = {start} … {end} s: ")?;
        } else {
            write!(f, "t = {start} s: ")?;
        }
        write!(f, "{} is stated as {}, found to be {}", self.quantity.name(), self.stated, self.recomputed)
    }
}
