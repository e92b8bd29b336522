//! The fingers: force-limited velocity motors that follow the commanded opening.
//!
//! While the plan closes and holds, it commands an opening *below* the object's width. The object stops the
//! fingers, the motors push at their force limit, and that limit is the grasp's force: each pad presses
//! with it whatever the object's true width.
//!
//! A plan that asks for more than the fingers' speed or opening is refused before the run. What is cut off
//! here is the *correction* of an error: fingers that are held back close it at their own speed. How far
//! they are from the commanded opening is judged by a check.

use graspcheck_model::{
    plan::{Grasp, Holding},
    robot::Gripper,
};

/// How fast an error of the opening is closed, 1/s: within about 10 ms.
const FOLLOW_GAIN: f64 = 100.0;

/// What the motors of both fingers are told for one step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FingerCommand {
    /// Velocity of each finger, positive opens, m/s.
    pub(crate) velocity: f64,
    /// Largest force of each finger, N.
    pub(crate) force: f64,
    /// Whether the commanded opening is below the object's width, so that the pads press.
    pub(crate) presses: bool,
}

/// The drive of the fingers.
pub(crate) struct GripperDrive<'a> {
    gripper: &'a Gripper,
    grasp: Option<&'a Grasp>,
}

impl<'a> GripperDrive<'a> {
    /// The drive of this gripper; without a grasp it only follows the opening.
    pub(crate) fn new(gripper: &'a Gripper, grasp: Option<&'a Grasp>) -> Self {
        Self { gripper, grasp }
    }

    /// The command for a commanded opening, m, its velocity, m/s, and the measured opening, m.
    ///
    /// The force limit is the grasp's from the moment the fingers begin to close until they have let go
    /// (the command is still below the object's width when they begin to open), else the gripper's.
    pub(crate) fn command(
        &self,
        holding: Holding,
        opening: f64,
        opening_velocity: f64,
        measured: f64,
    ) -> FingerCommand {
        let velocity = opening_velocity / 2.0 + FOLLOW_GAIN * (opening - measured) / 2.0;
        let speed = self.gripper.finger_speed;
        let at_object = matches!(holding, Holding::Closing | Holding::Held | Holding::Opening);
        let grasp = self.grasp.filter(|_| at_object);
        FingerCommand {
            velocity: velocity.clamp(-speed, speed),
            force: grasp.map_or(self.gripper.force_max, |grasp| grasp.force),
            presses: grasp.is_some_and(|grasp| opening < grasp.width),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures;

    #[test]
    fn pads_press_with_the_grasp_force_until_they_have_let_go() {
        let robot = fixtures::scara();
        let grasp = fixtures::grasp(8.0);
        let drive = GripperDrive::new(&robot.gripper, Some(&grasp));
        let below = grasp.width - 0.004;
        for holding in [Holding::Closing, Holding::Held, Holding::Opening] {
            let command = drive.command(holding, below, 0.0, grasp.width);
            assert!(command.velocity < -0.01, "{holding:?}: {command:?}");
            assert_eq!((command.force, command.presses), (8.0, true), "{holding:?}");
        }
        let open = drive.command(Holding::Placed, 0.06, 0.0, 0.06);
        assert_eq!((open.velocity, open.force, open.presses), (0.0, robot.gripper.force_max, false));
    }

    #[test]
    fn speed_is_limited_in_both_directions() {
        let robot = fixtures::scara();
        let drive = GripperDrive::new(&robot.gripper, None);
        let speed = robot.gripper.finger_speed;
        let velocity = |opening, measured| drive.command(Holding::Nothing, opening, 0.0, measured).velocity;
        assert_eq!((velocity(0.08, 0.0), velocity(0.0, 0.08)), (speed, -speed));
    }
}
