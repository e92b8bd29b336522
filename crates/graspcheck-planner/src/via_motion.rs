//! The motion of all coordinates through the points of a task, on the clock of the plan.
//!
//! The plan begins at 0 and so does its clock, which the times of the points are read on. Until the motion
//! begins (at the first point's time, or half a blend before) everything rests at the first point.

use graspcheck_model::via::{EndCondition, ParabolicBlends, ViaLaw};
use graspcheck_motion::{Trajectory, TrajectoryError};

use crate::{
    lfpb::{Lfpb, LfpbError, LfpbMotion, LfpbPoint, Met},
    via::{
        ViaError, ViaPoints, computed, imposed,
        points::Quantity,
        spline::{self, SplineEnd, SplineEnds},
        virtual_points::{self, EndState},
    },
};

/// Why there is no motion through the points of a task.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ViaMotionError {
    /// The points or what the law says of them make no sense.
    #[error(transparent)]
    Points(#[from] ViaError),
    /// The blends do not fit.
    #[error("{coordinate}: {error}")]
    Lfpb {
        /// The joint, or `x`, `y` or `theta`.
        coordinate: String,
        /// Why.
        #[source]
        error: LfpbError,
    },
    /// There is not one entry for each point, or in it one for each coordinate.
    #[error("{count} blends for {needed}: give one for each point and coordinate")]
    BlendCount {
        /// How many there are.
        count: usize,
        /// How many there must be.
        needed: usize,
    },
    /// A velocity is given for a point that is only passed near.
    #[error(
        "point {point}: a velocity belongs to a point that is met; say within which time, or leave it out"
    )]
    VelocityUnused {
        /// Number of the point.
        point: usize,
    },
    /// The motion would begin before the plan.
    #[error(
        "the motion would begin at {begins} s, before the plan; every point must be due at least {} s later",
        -begins
    )]
    BeforeStart {
        /// When it would begin, s.
        begins: f64,
    },
    /// The polynomials are not a trajectory.
    #[error(transparent)]
    Trajectory(#[from] TrajectoryError),
}

/// The motion past `positions[k]` at `times[k]`, s, under the law; `names` are those of the coordinates.
///
/// # Errors
/// When the points make no sense, their law does not fit them or the motion would begin before 0.
pub(crate) fn via_motion(
    times: &[f64],
    positions: &[Vec<f64>],
    law: &ViaLaw,
    names: &[&str],
) -> Result<Trajectory, ViaMotionError> {
    let points = ViaPoints::new(times.to_vec(), positions.to_vec())?;
    let dof = points.dof();
    let rest = vec![0.0; dof];
    let (begins, motion) = match law {
        ViaLaw::ParabolicBlends(blends) => {
            let motion = parabolic(&points, blends, names)?;
            (motion.start(), motion.trajectory().clone())
        }
        ViaLaw::ImposedVelocities(velocities) => (times[0], imposed::through(&points, velocities)?),
        ViaLaw::ComputedVelocities => (times[0], computed::through(&points, &rest, &rest)?),
        ViaLaw::Spline(condition) => (times[0], spline::through(&points, &spline_ends(*condition, &rest))?),
        ViaLaw::VirtualPoints(virtual_times) => {
            let rest = EndState::at_rest(dof);
            (times[0], virtual_points::through(&points, &rest, &rest, *virtual_times)?.trajectory)
        }
    };
    if begins < 0.0 {
        return Err(ViaMotionError::BeforeStart { begins });
    }
    if begins > 0.0 {
        let first = motion.eval(0.0).q;
        return Ok(Trajectory::hold(&first, begins)?.then(&motion)?);
    }
    Ok(motion)
}

fn parabolic(
    points: &ViaPoints,
    blends: &ParabolicBlends,
    names: &[&str],
) -> Result<LfpbMotion, ViaMotionError> {
    let (needed, count) =
        (points.len() * points.dof(), blends.points.iter().map(|point| point.blends.len()).sum());
    if count != needed || blends.points.iter().any(|point| point.blends.len() != points.dof()) {
        return Err(ViaMotionError::BlendCount { count, needed });
    }
    for (k, point) in blends.points.iter().enumerate() {
        let Some(velocity) = &point.velocity else { continue };
        if point.met.is_none() {
            return Err(ViaMotionError::VelocityUnused { point: k + 1 });
        }
        points.check_joints(&format!("point {}", k + 1), Quantity::Velocity, velocity)?;
    }
    let coordinate = |joint: usize| {
        let one = |((&time, positions), at): ((&f64, &Vec<f64>), &graspcheck_model::via::PointBlends)| {
            let velocity = at.velocity.as_ref().map(|velocity| velocity[joint]);
            let met = at.met.map(|bracket| Met { bracket, velocity });
            LfpbPoint { time, position: positions[joint], blend: at.blends[joint], met }
        };
        let of_joint: Vec<LfpbPoint> =
            points.times().iter().zip(points.positions()).zip(&blends.points).map(one).collect();
        Lfpb::new(&of_joint, blends.ends).map_err(|error| ViaMotionError::Lfpb {
            coordinate: names.get(joint).map_or_else(|| format!("coordinate {joint}"), ToString::to_string),
            error,
        })
    };
    let coordinates = (0..points.dof()).map(coordinate).collect::<Result<_, _>>()?;
    Ok(LfpbMotion::new(coordinates)?)
}

/// What a spline's ends ask for, with zeros for all coordinates.
pub(crate) fn spline_ends(condition: EndCondition, rest: &[f64]) -> SplineEnds {
    match condition {
        EndCondition::AtRest => SplineEnds::both(SplineEnd::Velocity(rest.to_vec())),
        EndCondition::Natural => SplineEnds::both(SplineEnd::Natural),
        EndCondition::NotAKnot => SplineEnds::both(SplineEnd::NotAKnot),
        EndCondition::Periodic => SplineEnds::Periodic,
    }
}

/// The same motion with these instants, s, among its knots, where they are inside and not knots yet.
pub(crate) fn with_knots(motion: &Trajectory, instants: &[f64]) -> Result<Trajectory, TrajectoryError> {
    /// Instants as near as this share of the motion to a knot are that knot up to rounding.
    const SAME_INSTANT: f64 = 1e-12;

    let near = SAME_INSTANT * motion.duration();
    let mut knots = motion.knots().to_vec();
    for &t in instants {
        if knots.iter().all(|knot| (knot - t).abs() > near) && (0.0..=motion.duration()).contains(&t) {
            knots.push(t);
        }
    }
    knots.sort_by(f64::total_cmp);
    let mut pieces = Vec::with_capacity((knots.len() - 1) * motion.dof());
    for &knot in &knots[..knots.len() - 1] {
        let piece = motion.piece_at(knot);
        let later = knot - motion.knots()[piece];
        pieces.extend(motion.piece_of_all(piece).iter().map(|polynomial| polynomial.shifted(later)));
    }
    Trajectory::new(motion.dof(), knots, pieces)
}

#[cfg(test)]
mod tests {
    use graspcheck_model::via::{Blend, BlendEnds, PointBlends};

    use super::*;

    fn of(times: &[f64], law: &ViaLaw) -> Result<Trajectory, ViaMotionError> {
        let positions: Vec<Vec<f64>> = (0..times.len()).map(|k| vec![k as f64, 1.0]).collect();
        via_motion(times, &positions, law, &["shoulder", "elbow"])
    }

    fn centred(duration: f64) -> ViaLaw {
        let ViaLaw::ParabolicBlends(blends) = ViaLaw::blends_of(duration, 3, 2) else { panic!() };
        ViaLaw::ParabolicBlends(ParabolicBlends { ends: BlendEnds::Centred, ..blends })
    }

    #[test]
    fn times_of_the_points_are_read_on_the_clock_of_the_plan() {
        let times = [0.5, 1.5, 3.0];
        for law in [
            ViaLaw::ComputedVelocities,
            ViaLaw::Spline(EndCondition::AtRest),
            ViaLaw::VirtualPoints([1.0, 2.0]),
            ViaLaw::ImposedVelocities(vec![vec![0.0; 2]; 3]),
        ] {
            let motion = of(&times, &law).unwrap();
            assert!((motion.duration() - 3.0).abs() < 1e-15);
            for (k, t) in times.into_iter().enumerate() {
                assert!((motion.eval(t).q[0] - k as f64).abs() < 1e-12, "{law:?} at {t} s");
            }
            assert!(motion.eval(0.25).q[0].abs() < 1e-15 && motion.eval(0.25).qd[0].abs() < 1e-15);
        }
        let motion = of(&times, &centred(0.4)).unwrap();
        assert!((motion.knots()[1] - 0.3).abs() < 1e-15 && (motion.duration() - 3.2).abs() < 1e-12);
        // The point at 1.5 s is missed by Δv b/8.
        let miss = (1.0 / 1.5 - 1.0) * 0.4 / 8.0;
        assert!((motion.eval(1.5).q[0] - 1.0 - miss).abs() < 1e-12);
    }

    #[test]
    fn a_motion_that_would_begin_before_the_plan_says_by_how_much() {
        let error = of(&[0.0, 1.0, 2.0], &centred(0.5)).unwrap_err();
        assert_eq!(
            error.to_string(),
            "the motion would begin at -0.25 s, before the plan; every point must be due at least 0.25 s later"
        );
        let error = of(&[-1.0, 1.0, 2.0], &ViaLaw::ComputedVelocities).unwrap_err();
        assert_eq!(error, ViaMotionError::BeforeStart { begins: -1.0 });
    }

    #[test]
    fn blends_are_counted_and_named_by_their_joint() {
        let mut law = ViaLaw::blends_of(0.5, 3, 2);
        let ViaLaw::ParabolicBlends(blends) = &mut law else { panic!() };
        blends.points[1] = PointBlends {
            blends: vec![Blend::Duration(0.5), Blend::Duration(0.0)],
            met: None,
            velocity: None,
        };
        let error = of(&[0.0, 1.0, 2.0], &law).unwrap_err();
        assert_eq!(error.to_string(), "elbow: point 2: blend time 0 must be a positive finite number");
        let error = of(&[0.0, 1.0, 2.0], &ViaLaw::blends_of(0.5, 2, 3)).unwrap_err();
        assert_eq!(error, ViaMotionError::BlendCount { count: 6, needed: 6 });
    }

    #[test]
    fn a_point_is_met_at_the_velocity_that_is_given_or_that_of_the_rule() {
        let mut law = ViaLaw::blends_of(0.2, 3, 2);
        for (velocity, expected) in [(None, [0.75, 0.0]), (Some(vec![-0.3, 0.4]), [-0.3, 0.4])] {
            let ViaLaw::ParabolicBlends(blends) = &mut law else { panic!() };
            blends.points[1].met = Some(0.3);
            blends.points[1].velocity = velocity;
            let met = of(&[0.0, 1.0, 3.0], &law).unwrap().eval(1.0);
            for (found, expected) in met.qd.iter().zip(expected) {
                assert!((found - expected).abs() < 1e-12, "{met:?}");
            }
            assert!((met.q[0] - 1.0).abs() < 1e-12 && (met.q[1] - 1.0).abs() < 1e-12);
        }
        let ViaLaw::ParabolicBlends(blends) = &mut law else { panic!() };
        blends.points[1].velocity = Some(vec![1.0]);
        assert!(matches!(of(&[0.0, 1.0, 3.0], &law), Err(ViaMotionError::Points(_))));
        let ViaLaw::ParabolicBlends(blends) = &mut law else { panic!() };
        (blends.points[1].met, blends.points[1].velocity) = (None, Some(vec![1.0, 1.0]));
        assert_eq!(of(&[0.0, 1.0, 3.0], &law), Err(ViaMotionError::VelocityUnused { point: 2 }));
    }

    /// The end of a motion as the model says it, from the points and the law alone.
    #[test]
    fn the_motion_ends_half_the_longest_blend_after_the_last_point() {
        let times = [1.0, 2.0, 4.5];
        let positions = [vec![0.0, 1.0], vec![1.0, -1.0], vec![3.0, 0.5]];
        let point =
            |blends: [Blend; 2], met, velocity| PointBlends { blends: blends.to_vec(), met, velocity };
        let (time, rate) = (Blend::Duration, Blend::Acceleration);
        let first = point([time(0.3), time(0.2)], None, None);
        for middle in [
            point([time(0.2), time(0.2)], None, None),
            point([time(0.2), time(0.2)], Some(0.4), None),
            point([time(0.2), time(0.2)], Some(0.4), Some(vec![2.0, -1.5])),
        ] {
            for last in [[time(0.4), time(0.1)], [rate(9.0), rate(5.0)], [rate(2.0), time(0.05)]] {
                for ends in [BlendEnds::Centred, BlendEnds::Inside] {
                    let points = vec![first.clone(), middle.clone(), point(last, None, None)];
                    let law = ViaLaw::ParabolicBlends(ParabolicBlends { points, ends });
                    let motion = via_motion(&times, &positions, &law, &["x", "y"]).unwrap();
                    let expected = 4.5 + law.overrun(&times, &positions);
                    assert!((motion.duration() - expected).abs() < 1e-12, "{} {law:?}", motion.duration());
                }
            }
        }
    }

    #[test]
    fn more_knots_change_nothing() {
        let motion = of(&[0.0, 1.0, 2.0], &ViaLaw::blends_of(0.5, 3, 2)).unwrap();
        let more = with_knots(&motion, &[0.0, 1.0, 1.75, 2.0, 1.1, 9.0]).unwrap();
        assert_eq!(more.knots().len(), motion.knots().len() + 3);
        for k in 0..=40 {
            let t = f64::from(k) / 20.0;
            for (a, b) in motion.eval(t).q.iter().zip(more.eval(t).q) {
                assert!((a - b).abs() < 1e-14);
            }
        }
    }
}
