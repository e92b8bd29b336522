//! The commanded opening of the gripper over time.
//!
//! [`Plan::opening`](graspcheck_model::plan::Plan::opening) is what the fingers are *commanded*, not where
//! they are: while the object is held the command is [`SQUEEZE`] less than the object's width, so that
//! force-limited fingers press with the force of the grasp and the pads stay on the object. Where the pads
//! are is `max(command, width)` from `close` to `open`.

use graspcheck_model::{
    object::Handle,
    plan::{Holding, Phase},
    robot::Gripper,
};
use graspcheck_motion::{Polynomial, Trajectory, TrajectoryError};

/// How much less than the object's width the commanded opening is while the object is held, m.
///
/// The reason: far more than pads and contacts give way under the force, so that the force limit decides
/// and not the stiffness; far less than would bring the fingers together at speed if the object were lost.
pub const SQUEEZE: f64 = 0.004;

/// Peak velocity of a quintic rest-to-rest motion over its mean velocity (worked examples, section 3).
const QUINTIC_PEAK: f64 = 15.0 / 8.0;

/// Why the gripper cannot grasp as asked.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum GripError {
    /// The object is wider than the gripper opens.
    #[error(
        "handle {handle}: width {width} m leaves no room in the gripper, which opens {opening_max} m; use \
         another handle or gripper"
    )]
    TooWide {
        /// Name of the handle.
        handle: String,
        /// Its width, m.
        width: f64,
        /// Largest opening, m.
        opening_max: f64,
    },
    /// The width of a handle is not positive.
    #[error("handle {handle}: width {width} m is not positive")]
    NoWidth {
        /// Name of the handle.
        handle: String,
        /// Its width, m.
        width: f64,
    },
    /// The grip force is not positive or more than a finger can give.
    #[error("grip force {force} N is not above 0 N and at most the fingers' {force_max} N")]
    Force {
        /// What is asked, N.
        force: f64,
        /// What a finger can give, N.
        force_max: f64,
    },
    /// The fingers would have to be faster than they are.
    #[error(
        "phase {phase}: finger speed {speed:.4} m/s exceeds {speed_max:.4} m/s; give it at least {least:.4} s"
    )]
    TooFast {
        /// `close` or `open`.
        phase: String,
        /// Peak speed of one finger, m/s.
        speed: f64,
        /// The limit, m/s.
        speed_max: f64,
        /// The shortest duration that keeps it, s.
        least: f64,
    },
}

/// The least duration in which a gripper can close or open at a handle, s.
///
/// # Errors
/// When the handle's width is not positive or leaves no room in the gripper.
pub fn least_duration(handle: &Handle, gripper: &Gripper) -> Result<f64, GripError> {
    Ok(Openings::at(handle, gripper)?.least_duration(gripper))
}

/// The openings of a grasp, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Openings {
    /// While approaching and leaving.
    pub(crate) free: f64,
    /// Commanded while the object is held.
    pub(crate) held: f64,
}

impl Openings {
    /// The openings with which the gripper grasps at a handle: the free opening on both sides, as far as
    /// the gripper opens, and [`SQUEEZE`] less than the width, not below 0.
    ///
    /// # Errors
    /// When the width is not positive or leaves no room.
    pub(crate) fn at(handle: &Handle, gripper: &Gripper) -> Result<Self, GripError> {
        let (name, width) = (&handle.name, handle.width);
        if width.is_nan() || width <= 0.0 {
            return Err(GripError::NoWidth { handle: name.clone(), width });
        }
        let opening_max = gripper.opening_max;
        if width >= opening_max {
            return Err(GripError::TooWide { handle: name.clone(), width, opening_max });
        }
        let free = (width + 2.0 * gripper.free_opening).min(opening_max);
        Ok(Self { free, held: (width - SQUEEZE).max(0.0) })
    }

    /// The least duration in which the fingers can close or open, s.
    fn least_duration(&self, gripper: &Gripper) -> f64 {
        let travel = 0.5 * (self.free - self.held);
        QUINTIC_PEAK * travel / gripper.finger_speed
    }

    /// Checks that the fingers can close or open in the `duration` (s) of `phase`.
    ///
    /// # Errors
    /// When they would have to be faster than the gripper's finger speed.
    pub(crate) fn check_speed(&self, gripper: &Gripper, phase: &str, duration: f64) -> Result<(), GripError> {
        let (least, speed_max) = (self.least_duration(gripper), gripper.finger_speed);
        let speed = speed_max * least / duration;
        if speed > speed_max {
            return Err(GripError::TooFast { phase: phase.to_owned(), speed, speed_max, least });
        }
        Ok(())
    }

    /// The commanded opening over the phases of a plan: quintic in time while closing and opening.
    ///
    /// # Errors
    /// When the phases do not follow each other from 0.
    pub(crate) fn over(&self, phases: &[Phase]) -> Result<Trajectory, TrajectoryError> {
        let mut knots = vec![0.0];
        let mut pieces = Vec::with_capacity(phases.len());
        for phase in phases {
            let (start, end) = match phase.holding {
                Holding::Closing => (self.free, self.held),
                Holding::Held => (self.held, self.held),
                Holding::Opening => (self.held, self.free),
                Holding::Nothing | Holding::AtStart | Holding::Placed => (self.free, self.free),
            };
            let duration = phase.end - phase.start;
            pieces.push(Polynomial::quintic_hermite([start, 0.0, 0.0], [end, 0.0, 0.0], duration));
            knots.push(phase.end);
        }
        Trajectory::new(1, knots, pieces)
    }
}

/// The commanded opening when nothing is grasped: as far as the gripper opens, all the time.
///
/// # Errors
/// When the duration (s) is not positive.
pub(crate) fn idle(gripper: &Gripper, duration: f64) -> Result<Trajectory, TrajectoryError> {
    Trajectory::hold(&[gripper.opening_max], duration)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robots::{cube, scara};

    fn phases() -> Vec<Phase> {
        use Holding::{AtStart, Closing, Held, Opening, Placed};
        let mut end = 0.0;
        [(AtStart, 0.7), (Closing, 0.3), (Held, 1.1), (Opening, 0.25), (Placed, 0.4)]
            .map(|(holding, duration)| {
                let start = end;
                end += duration;
                Phase { name: String::new(), start, end, holding }
            })
            .to_vec()
    }

    #[test]
    fn fingers_press_while_the_object_is_held() {
        let handle = &cube([0.0; 3], 0.0).handles[0];
        let openings = Openings::at(handle, &scara().gripper).unwrap();
        let opening = openings.over(&phases()).unwrap();
        assert!(opening.breaks().is_empty());
        for (t, expected) in
            [(0.0, 0.042), (0.7, 0.042), (1.0, 0.026), (1.5, 0.026), (2.1, 0.026), (2.75, 0.042)]
        {
            assert!((opening.eval(t).q[0] - expected).abs() < 1e-12, "{t}");
        }
        // Half way the quintic is half way and at its fastest, 15/8 of the mean.
        let middle = opening.eval(0.85);
        assert!((middle.q[0] - 0.034).abs() < 1e-12);
        assert!((middle.qd[0] + 15.0 / 8.0 * 0.016 / 0.3).abs() < 1e-12);
    }

    #[test]
    #[expect(clippy::float_cmp, reason = "bounds are met to the last digit")]
    fn openings_stay_within_the_gripper() {
        let mut handle = cube([0.0; 3], 0.0).handles[0].clone();
        let gripper = scara().gripper;
        handle.width = 0.065;
        assert_eq!(Openings::at(&handle, &gripper).unwrap().free, gripper.opening_max);
        handle.width = 0.001;
        assert_eq!(Openings::at(&handle, &gripper).unwrap().held, 0.0);
        handle.width = gripper.opening_max;
        assert!(matches!(Openings::at(&handle, &gripper), Err(GripError::TooWide { .. })));
        for width in [0.0, -0.1, f64::NAN] {
            handle.width = width;
            assert!(matches!(Openings::at(&handle, &gripper), Err(GripError::NoWidth { .. })));
        }
    }

    #[test]
    fn the_least_duration_is_just_enough() {
        let openings = Openings { free: 0.042, held: 0.026 };
        let gripper = scara().gripper;
        let Err(GripError::TooFast { least, .. }) = openings.check_speed(&gripper, "close", 0.1) else {
            panic!("8 mm in 0.1 s is too fast for 60 mm/s")
        };
        assert!((least - 0.25).abs() < 1e-12);
        assert!(openings.check_speed(&gripper, "close", least * (1.0 + 1e-12)).is_ok());
    }
}
