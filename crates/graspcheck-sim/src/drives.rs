//! From what the controller commands to what the drives do: late, and with a ripple of the torque.

use std::f64::consts::TAU;

use graspcheck_model::{execution::Execution, robot::JointKind, robot::RobotModel};

use crate::{
    controller::Command,
    random::{Random, Stream},
};

/// The drives of the arm's joints, with the commands that are on their way.
pub(crate) struct Drives {
    /// A ring: the commands of the last steps.
    on_their_way: Vec<Command>,
    next: usize,
    has_begun: bool,
    ripple: f64,
    /// Waves a radian of each joint, and where they begin, rad.
    waves: Vec<(f64, f64)>,
    applied: Command,
}

impl Drives {
    /// The drives of this robot, which act `steps_late` steps after a command.
    pub(crate) fn new(robot: &RobotModel, execution: &Execution, steps_late: usize) -> Self {
        let imperfections = &execution.imperfections;
        let mut random = Random::new(execution.seed, Stream::Ripple);
        let waves = robot.joints.iter().map(|joint| {
            let phase = TAU * random.unit();
            let turns = if joint.kind == JointKind::Revolute { imperfections.ripple_waves } else { 0.0 };
            (turns, phase)
        });
        Self {
            waves: waves.collect(),
            on_their_way: vec![Command::zeros(robot.dof()); steps_late + 1],
            next: 0,
            has_begun: false,
            ripple: imperfections.torque_ripple,
            applied: Command::zeros(robot.dof()),
        }
    }

    /// Takes the command of a step and finds what acts in it, at true positions `q`. Before the first command
    /// arrives the drives do what it says: the arm was at rest under the same controller.
    pub(crate) fn act(&mut self, command: &Command, q: &[f64]) {
        if !self.has_begun {
            self.on_their_way.iter_mut().for_each(|late| late.copy_from(command));
            self.has_begun = true;
        }
        self.on_their_way[self.next].copy_from(command);
        self.next = (self.next + 1) % self.on_their_way.len();
        self.applied.copy_from(&self.on_their_way[self.next]);
        if self.ripple > 0.0 {
            for ((effort, (turns, phase)), q) in self.applied.efforts.iter_mut().zip(&self.waves).zip(q) {
                if *turns > 0.0 {
                    *effort *= 1.0 + self.ripple * (turns * q + phase).sin();
                }
            }
        }
    }

    /// What acts.
    pub(crate) fn applied(&self) -> &Command {
        &self.applied
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures;

    fn command(value: f64) -> Command {
        let mut command = Command::zeros(4);
        command.efforts.fill(value);
        command
    }

    #[test]
    fn commands_act_as_many_steps_late_as_they_should() {
        let (robot, execution) = (fixtures::scara(), fixtures::execution());
        for late in [0, 1, 3] {
            let mut drives = Drives::new(&robot, &execution, late);
            for step in 0..10_usize {
                drives.act(&command(step as f64), &[0.0; 4]);
                assert_eq!(drives.applied(), &command(step.saturating_sub(late) as f64), "{late} late");
            }
        }
    }

    #[test]
    fn ripple_goes_with_the_angle_and_leaves_a_slide_alone() {
        let robot = fixtures::scara();
        let mut execution = fixtures::execution();
        execution.imperfections.torque_ripple = 0.1;
        execution.imperfections.ripple_waves = 12.0;
        let mut drives = Drives::new(&robot, &execution, 0);
        let mut at = |angle: f64| {
            drives.act(&command(2.0), &[angle; 4]);
            drives.applied().efforts.clone()
        };
        let turn: Vec<Vec<f64>> = (0..360).map(|degree| at(f64::from(degree).to_radians())).collect();
        let extreme = |joint: usize, pick: fn(f64, f64) -> f64| {
            turn.iter().map(|efforts| efforts[joint]).reduce(pick).unwrap()
        };
        assert!((extreme(0, f64::max) - 2.2).abs() < 2e-3 && (extreme(0, f64::min) - 1.8).abs() < 2e-3);
        assert!((turn[0][0] - turn[30][0]).abs() < 1e-9, "a wave is a twelfth of a turn");
        assert!((extreme(2, f64::max) - 2.0).abs() < 1e-15);
    }
}
