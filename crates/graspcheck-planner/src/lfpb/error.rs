//! Why there is no linear function with parabolic blends, and the least change with which there is.

use std::fmt;

use graspcheck_model::via::Blend;

use crate::via::ViaError;

/// A place of the motion: a point, counted from 1, or one of the pseudo via points about a point that must be
/// met.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// The point itself.
    Point(usize),
    /// The pseudo via point before it.
    Before(usize),
    /// The pseudo via point after it.
    After(usize),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Point(point) => write!(f, "point {point}"),
            Self::Before(point) => write!(f, "the pseudo via point before point {point}"),
            Self::After(point) => write!(f, "the pseudo via point after point {point}"),
        }
    }
}

/// The least change of one blend that makes room in a segment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Remedy {
    /// Where the blend is.
    pub place: Place,
    /// The longest blend time, or the least acceleration, with which the segment's blends just touch while
    /// everything else stays.
    pub blend: Blend,
}

impl fmt::Display for Remedy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.blend {
            Blend::Duration(longest) => {
                write!(f, "shorten the blend at {} to at most {longest} s", self.place)
            }
            Blend::Acceleration(least) => {
                write!(f, "raise the acceleration at {} to at least {least}", self.place)
            }
        }
    }
}

/// Why there is no LFPB motion.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LfpbError {
    /// The points make no sense, whatever the law.
    #[error(transparent)]
    Points(#[from] ViaError),
    /// The numbers of times, positions and blends differ.
    #[error(
        "an LFPB motion needs a time, a position and a blend for each point, got {times}, {positions} and {blends}"
    )]
    PointCount {
        /// How many times.
        times: usize,
        /// How many positions.
        positions: usize,
        /// How many blends.
        blends: usize,
    },
    /// A blend takes no time, which needs infinite acceleration, or has none, or a bracket is empty.
    #[error("point {point}: {quantity} {value} must be a positive finite number")]
    NotPositive {
        /// Number of the point.
        point: usize,
        /// `blend time`, `blend acceleration` or `bracket`.
        quantity: &'static str,
        /// What was given, s or per s².
        value: f64,
    },
    /// The first or the last point is to lie between pseudo via points.
    #[error(
        "point {point}: an end cannot lie between pseudo via points; it is met as it is when the blends of \
         the ends lie inside"
    )]
    EndBracketed {
        /// Number of the point.
        point: usize,
    },
    /// A pseudo via point would not lie between its point and the neighbour of this.
    #[error(
        "point {point}: bracket {bracket} s must be less than {below} s, or its pseudo via point passes {neighbour}"
    )]
    BracketTooWide {
        /// Number of the point.
        point: usize,
        /// What was given, s.
        bracket: f64,
        /// What the neighbour leaves, s.
        below: f64,
        /// The neighbour.
        neighbour: Place,
    },
    /// An acceleration at an end is too small to come from rest to the line, or back, within the segment.
    #[error(
        "{place}: acceleration {acceleration} is too small for a distance of {distance} in {available} s; {}",
        remedies_text(remedies)
    )]
    AccelerationTooSmall {
        /// The end.
        place: Place,
        /// Magnitude that was given, per s².
        acceleration: f64,
        /// What the segment covers, magnitude.
        distance: f64,
        /// What there is for it, s.
        available: f64,
        /// What would do, each alone.
        remedies: Vec<Remedy>,
    },
    /// The blends of a segment's points overlap.
    #[error(
        "segment from {from} to {to}: its blends take {needed} s of the {available} s from {start} s to {end} s, \
         {} s too much; {}",
        needed - available,
        remedies_text(remedies)
    )]
    BlendsOverlap {
        /// Where the segment begins.
        from: Place,
        /// Where it ends.
        to: Place,
        /// When its first point is due, s.
        start: f64,
        /// When its second point is due, s.
        end: f64,
        /// The parts of both blends that lie in the segment, s.
        needed: f64,
        /// What the segment has, s.
        available: f64,
        /// What would do, each alone.
        remedies: Vec<Remedy>,
    },
    /// A blend is so short that its ends are no longer apart when their times are rounded.
    #[error(
        "{place}: a blend of {duration} s is shorter than times are exact; it must take more than {least} s"
    )]
    BlendTooShort {
        /// Where.
        place: Place,
        /// How long it would take, s.
        duration: f64,
        /// What it must exceed, s.
        least: f64,
    },
    /// The numbers are so far apart that a velocity or an acceleration overflows.
    #[error(
        "{place}: the velocity or the acceleration overflows; move the points nearer or give them more time"
    )]
    Overflow {
        /// Where.
        place: Place,
    },
}

/// All remedies in words.
fn remedies_text(remedies: &[Remedy]) -> String {
    if remedies.is_empty() {
        return "no change of one blend alone would do: give the segment more time".to_owned();
    }
    let words: Vec<String> = remedies.iter().map(ToString::to_string).collect();
    words.join(", or ")
}
