//! Which way round the fastest trapezoid between two moving ends goes.
//!
//! Under limits on velocity and acceleration the fastest law from velocity v₀ to v₁ changes its velocity to a peak v_p,
//! cruises there if v_p is the limit, and changes its velocity to v₁. The *direct* law goes from v₀ to v₁ in one
//! change and covers D₀. A distance D above D₀ needs a peak above both ends; one below it is the same problem with all
//! signs changed.

/// A distance this near to that of the direct law, relative to the numbers of which it is a difference, is that
/// of the direct law. Between ends that both move backwards the next larger distance takes a long way round, and
/// rounding alone must not send a joint there.
const DIRECT: f64 = 4.0 * f64::EPSILON;

/// A problem turned so that the peak velocity is above both ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Turned {
    /// 1, or -1 where all signs were changed.
    pub(super) sign: f64,
    /// Velocities at both ends after that.
    pub(super) velocities: [f64; 2],
    /// What has to be covered beyond the direct law; not negative.
    pub(super) beyond: f64,
}

impl Turned {
    /// Turns a problem, given `[position, velocity]` at its ends and how long the direct law takes, s.
    pub(super) fn new([q0, v0]: [f64; 2], [q1, v1]: [f64; 2], direct: f64) -> Self {
        let covered = 0.5 * (v0 + v1) * direct;
        let beyond = q1 - q0 - covered;
        let rounding = DIRECT * (q0.abs() + q1.abs() + covered.abs());
        let beyond = if beyond.abs() <= rounding { 0.0 } else { beyond };
        let sign = if beyond >= 0.0 { 1.0 } else { -1.0 };
        Self { sign, velocities: [sign * v0, sign * v1], beyond: sign * beyond }
    }
}
