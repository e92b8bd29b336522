//! Bounds on the speed and the acceleration of the tool over a stretch of time, for any serial arm.
//!
//! Velocity and acceleration are the derivatives of the tool's origin, through the product of transforms
//! ([`SerialChain`]) with Taylor series of the joints ([`Jet`]). Between three instants each is a parabola but for a
//! remainder, as for torques; see [`torque_bounds`](crate::torque_bounds). The length of a parabola in space is at
//! most that of the longest of its Bernstein control points, which exceeds the truth by a share of the order of the
//! square of the stretch.
//!
//! ```
//! use graspcheck_model::{chain::SerialChain, example, tool_bounds::ToolBounds};
//! use graspcheck_motion::{Polynomial, Trajectory};
//!
//! // The planar arm, stretched out to 8 m, turns about its base at 0.5 rad/s.
//! let still = Polynomial::constant(0.0);
//! let motion = Trajectory::new(3, vec![0.0, 2.0], vec![Polynomial::new([0.1, 0.5]), still, still])?;
//! let chain = SerialChain::of(&example::planar());
//! let mut room = ToolBounds::new(&chain, &motion);
//! let [speed, acceleration] = room.over(0.5, 0.6);
//! assert!((speed - 4.0).abs() < 1e-2 && (acceleration - 2.0).abs() < 1e-2); // ω r and ω² r
//! # Ok::<(), graspcheck_motion::TrajectoryError>(())
//! ```

use graspcheck_motion::{Jet, Scalar, Trajectory};
use nalgebra::Vector3;

use crate::{
    chain::SerialChain,
    majorant::{self, JointReach, JointStretch, Link, Majorant, longest},
    robot::JointKind,
    spatial::Vector,
};

/// How many numbers [`ToolBounds::at`] gives: the coordinates of velocity and acceleration.
pub const TOOL_SAMPLE: usize = 6;

/// Bounds on how fast the tool's origin is in one motion of one arm.
#[derive(Clone, Debug)]
pub struct ToolBounds<'a> {
    chain: &'a SerialChain,
    motion: &'a Trajectory,
    /// What the bounds are computed from.
    reach: Reach,
    /// The same if no axes were parallel: what floats can be off by.
    rounding_reach: Reach,
    roundings: Vec<Option<Rounding>>,
    series: Vec<Jet<f64, 3>>,
    positions: Vec<Majorant>,
}

/// What rounding takes on a piece.
#[derive(Clone, Debug)]
struct Rounding {
    terms: Box<[Majorant]>,
    /// How far velocity and acceleration as floats compute them can be off.
    slack: [f64; 2],
}

/// Bounds on the magnitudes of the tool's velocity (m/s) and acceleration (m/s²) on a stretch of time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ToolBound {
    /// They are never more.
    pub most: [f64; 2],
    /// In the middle they are at least this.
    pub attained: [f64; 2],
}

impl<'a> ToolBounds<'a> {
    /// Bounds for `motion` of the arm `chain`.
    ///
    /// # Panics
    /// When the motion is of another number of joints.
    #[must_use]
    pub fn new(chain: &'a SerialChain, motion: &'a Trajectory) -> Self {
        let hinges = chain.hinges();
        assert_eq!(motion.dof(), hinges.len(), "a motion of another number of joints");
        Self {
            chain,
            motion,
            reach: Reach::of(chain, majorant::is_planar(hinges)),
            rounding_reach: Reach::of(chain, false),
            roundings: vec![None; motion.piece_count()],
            series: vec![Jet::constant(0.0); hinges.len()],
            positions: vec![Majorant::constant(0.0); hinges.len()],
        }
    }

    /// Bounds on speed (m/s) and acceleration (m/s²) between `t0` and `t1`, s; where the acceleration jumps both sides
    /// count. They hold for the exact values and for what floats compute.
    ///
    /// # Panics
    /// When not `0 ≤ t0 ≤ t1 ≤ duration`.
    pub fn over(&mut self, t0: f64, t1: f64) -> [f64; 2] {
        let knots = self.motion.knots();
        let first = self.motion.piece_at(t0);
        let last = first.max(knots.partition_point(|&knot| knot < t1).saturating_sub(1));
        let mut all = [0.0_f64; 2];
        for piece in first..=last {
            let from = if piece == first { t0 } else { knots[piece] };
            let to = if piece == last { t1 } else { knots[piece + 1] };
            let mut samples = [[0.0; TOOL_SAMPLE]; 3];
            for (time, sample) in [from, 0.5 * (from + to), to].into_iter().zip(&mut samples) {
                self.at(piece, time, sample);
            }
            let found = self.on(piece, [from, to], samples.each_ref().map(|sample| &sample[..]));
            all = [0, 1].map(|k| all[k].max(found.most[k]));
        }
        all
    }

    /// Velocity and acceleration of the tool's origin at an instant (s) as the given piece of the motion has it, in the
    /// world: a sample for [`ToolBounds::on`].
    ///
    /// # Panics
    /// When there is no such piece, or `sample` is not of [`TOOL_SAMPLE`] numbers.
    pub fn at(&mut self, piece: usize, time: f64, sample: &mut [f64]) {
        let local = time - self.motion.knots()[piece];
        for (series, polynomial) in self.series.iter_mut().zip(self.motion.piece_of_all(piece)) {
            let [q, qd, qdd, _] = polynomial.eval(local);
            series.coefficients = [q, qd, 0.5 * qdd];
        }
        let Vector(origin) = self.chain.tool(&self.series).origin;
        for (axis, Jet { coefficients: [_, velocity, half_acceleration] }) in origin.into_iter().enumerate() {
            sample[axis] = velocity;
            sample[3 + axis] = 2.0 * half_acceleration;
        }
    }

    /// Bounds between two instants (s) of one piece, from the samples of [`ToolBounds::at`] at the first, in the middle
    /// and at the last of them.
    ///
    /// # Panics
    /// When there is no such piece, or a sample is not of [`TOOL_SAMPLE`] numbers.
    pub fn on(&mut self, piece: usize, [from, to]: [f64; 2], samples: [&[f64]; 3]) -> ToolBound {
        if self.roundings[piece].is_none() {
            self.roundings[piece] = Some(self.rounding(piece));
        }
        let Rounding { terms, slack } = self.roundings[piece].as_ref().expect("it was just found");
        let start = self.motion.knots()[piece];
        let polynomials = self.motion.piece_of_all(piece);
        for ((position, polynomial), terms) in self.positions.iter_mut().zip(polynomials).zip(terms) {
            *position = JointStretch::new(polynomial, [from - start, to - start], terms).position;
        }
        let velocity = self.reach.origin(&self.positions).derivative();
        let acceleration = velocity.derivative();
        let half = 0.5 * (to - from) + 4.0 * f64::EPSILON * to;
        let mut bound = ToolBound::default();
        for (k, majorant) in [velocity, acceleration].into_iter().enumerate() {
            let of = |sample: &[f64]| Vector3::new(sample[3 * k], sample[3 * k + 1], sample[3 * k + 2]);
            let vectors = samples.map(of);
            bound.most[k] = longest(vectors, majorant.coefficients[3], half) + slack[k];
            bound.attained[k] = (vectors[1].norm() - slack[k]).max(0.0);
        }
        bound
    }

    /// How far floats can be off on a piece: a share of the magnitudes of all terms.
    #[cold]
    fn rounding(&mut self, piece: usize) -> Rounding {
        let length = self.motion.knots()[piece + 1] - self.motion.knots()[piece];
        let polynomials = self.motion.piece_of_all(piece);
        let (terms, share) = majorant::of_piece(polynomials, length, &mut self.positions);
        let [_, velocity, half_acceleration, ..] = self.rounding_reach.origin(&self.positions).coefficients;
        let slack = [velocity, 2.0 * half_acceleration].map(|magnitude| share * magnitude);
        Rounding { terms, slack: slack.map(|slack| if slack.is_nan() { f64::INFINITY } else { slack }) }
    }
}

/// An arm as far as majorants of its tool ask for it.
#[derive(Clone, Debug)]
struct Reach {
    joints: Vec<JointReach>,
    /// Distance of the tool from the last link's origin, m; in a planar arm across the axes.
    offset: f64,
    /// Whether the directions across and along the axes are apart.
    planar: bool,
}

impl Reach {
    fn of(chain: &SerialChain, planar: bool) -> Self {
        let tool = chain.tool_in_last_link();
        let offset = match chain.hinges().last() {
            Some(last) if planar => tool.cross(&last.axis).norm(),
            _ => tool.norm(),
        };
        let joints = chain.hinges().iter().map(|hinge| JointReach::of(hinge, planar)).collect();
        Self { joints, offset, planar }
    }

    /// The majorant of the tool's origin.
    fn origin(&self, positions: &[Majorant]) -> Majorant {
        let mut link = Link::base();
        let [mut origin, mut along] = [Majorant::constant(0.0); 2];
        for (joint, position) in self.joints.iter().zip(positions) {
            link = link.next(*joint, position);
            origin = origin + link.arm;
            if self.planar && joint.kind == JointKind::Prismatic {
                along = along + *position;
            }
        }
        // Across and along the axes: a length is at most the sum of both.
        origin + link.unit.scaled(self.offset) + along
    }
}
