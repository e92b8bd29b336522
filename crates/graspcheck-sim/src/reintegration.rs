//! How far a run can be trusted: the recorded motion against the exact equations.
//!
//! The *integration defect*: windows of 50 ms in which the robot touches nothing are integrated again from the recorded
//! state with the recorded efforts, by the exact equations. How far the recorded positions are from that at most, per
//! joint, is what rapier's first-order integrator has done. It says nothing of contacts.
//!
//! The *exact plant*: the same controller, encoders and drives follow the same plan on the exact plant wherever the
//! robot touches nothing. The difference of the two tracking errors is the share of the integrator.

use graspcheck_model::{
    cell::Cell,
    execution::{Controller, Execution},
    plan::Plan,
    robot::{JointKind, RobotModel},
};
use graspcheck_motion::MotionState;
use graspcheck_recording::Recording;

use crate::{
    controller::ArmController, drives::Drives, encoders::Encoders, exact::ExactArm, validate::Timing,
};

/// Length of a window, s.
pub const WINDOW: f64 = 0.05;

/// The largest value of a joint, rad or m, and when, s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Worst {
    /// Its magnitude.
    pub value: f64,
    /// When it is reached, s.
    pub time: f64,
}

impl Worst {
    fn take(&mut self, value: f64, time: f64) {
        if value.abs() > self.value {
            *self = Self { value: value.abs(), time };
        }
    }
}

/// What the exact equations say of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Reintegration {
    /// Windows in which the robot touched nothing, and all windows.
    pub windows: [usize; 2],
    /// The integration defect of each joint.
    pub defect: Vec<Worst>,
    /// The tracking error of each joint where the robot touched nothing, as simulated, …
    pub tracking: Vec<Worst>,
    /// … and on the exact plant.
    pub exact_tracking: Vec<Worst>,
}

/// The recorded rows in which the equations of a free arm hold.
struct FreeRows(Vec<bool>);

impl FreeRows {
    /// Those without a contact of a body of the robot and without a push.
    fn of(recording: &Recording, robot: &RobotModel, execution: &Execution) -> Self {
        let fingers = robot.gripper.fingers.iter().map(|finger| &finger.link);
        let bodies: Vec<&str> = robot.links.iter().chain(fingers).map(|link| link.name.as_str()).collect();
        let times = &recording.measured.time_ns;
        let mut free = vec![true; times.len()];
        for contact in &recording.contacts {
            let is_of_robot =
                [&contact.body_a, &contact.body_b].iter().any(|name| bodies.contains(&name.as_str()));
            if let (true, Ok(row)) = (is_of_robot, times.binary_search(&contact.time_ns)) {
                free[row] = false;
            }
        }
        if let Some(push) = &execution.imperfections.push {
            for (is_free, time_ns) in free.iter_mut().zip(times) {
                let time = *time_ns as f64 / 1e9;
                *is_free &= !(push.start - execution.dt..=push.start + push.duration).contains(&time);
            }
        }
        Self(free)
    }

    /// Whether the steps from row `from` to row `to` were free.
    fn between(&self, from: usize, to: usize) -> bool {
        self.0[from..=to].iter().all(|is_free| *is_free)
    }

    /// The longest stretches of free rows, each from its first to its last row.
    fn stretches(&self) -> Vec<[usize; 2]> {
        let mut stretches: Vec<[usize; 2]> = Vec::new();
        for (row, _) in self.0.iter().enumerate().filter(|(_, is_free)| **is_free) {
            match stretches.last_mut() {
                Some([_, last]) if *last + 1 == row => *last = row,
                _ => stretches.push([row, row]),
            }
        }
        stretches
    }
}

/// Holds a run against the exact equations of the robot as it really is. None when the drives were servos, whose
/// torque is nowhere recorded.
pub(crate) fn reintegrate(
    recording: &Recording,
    [believed, real]: [&RobotModel; 2],
    cell: &Cell,
    plan: &Plan,
    execution: &Execution,
    timing: Timing,
) -> Option<Reintegration> {
    if execution.controller == Controller::IdealServo {
        return None;
    }
    let dof = real.dof();
    let free = FreeRows::of(recording, real, execution);
    let mut arm = ExactArm::new(real, cell.gravity);
    let mut result = Reintegration {
        windows: [0, 0],
        defect: vec![Worst::default(); dof],
        tracking: vec![Worst::default(); dof],
        exact_tracking: vec![Worst::default(); dof],
    };
    let run = Run { recording, dof, dt: execution.dt };
    let length = ((WINDOW / execution.dt).round() as usize).max(1);
    let rows = recording.measured.len();
    for from in (0..rows.saturating_sub(length)).step_by(length) {
        result.windows[1] += 1;
        if free.between(from, from + length) {
            result.windows[0] += 1;
            run.defect(&mut arm, from, length, &mut result.defect);
        }
    }
    let controller_of = |start: usize| {
        let opening = run.opening(start);
        let q = &plan.trajectory.eval(0.0).q;
        ArmController::new(believed, cell.gravity, execution, q, opening)
    };
    for [from, to] in free.stretches() {
        // A controller that begins anew in the middle begins where it then commands.
        let from = from.next_multiple_of(timing.command_stride);
        if from >= to {
            continue;
        }
        let mut loop_again = Loop {
            plan,
            timing,
            controller: controller_of(from),
            encoders: Encoders::new(execution, dof),
            drives: Drives::new(believed, execution, timing.steps_late),
            reference: MotionState::zeros(dof),
            next_reference: MotionState::zeros(dof),
        };
        loop_again.follow(&run, &mut arm, [from, to], &mut result);
    }
    Some(result)
}

/// A recorded run.
struct Run<'a> {
    recording: &'a Recording,
    dof: usize,
    dt: f64,
}

impl Run<'_> {
    fn q(&self, row: usize) -> &[f64] {
        &self.recording.measured.position_row(row)[..self.dof]
    }

    fn qd(&self, row: usize) -> &[f64] {
        &self.recording.measured.velocity_row(row)[..self.dof]
    }

    fn opening(&self, row: usize) -> f64 {
        self.recording.measured.position_row(row)[self.dof..].iter().sum()
    }

    fn time(&self, row: usize) -> f64 {
        self.recording.measured.time_ns[row] as f64 / 1e9
    }

    /// Integrates one window again.
    fn defect(&self, arm: &mut ExactArm, from: usize, length: usize, worst: &mut [Worst]) {
        let (mut q, mut qd) = (self.q(from).to_vec(), self.qd(from).to_vec());
        for row in from..from + length {
            arm.set_load(self.opening(row), None);
            let efforts = &self.recording.measured.effort_row(row)[..self.dof];
            arm.advance(&mut q, &mut qd, efforts, self.dt);
            for ((worst, exact), recorded) in worst.iter_mut().zip(&q).zip(self.q(row + 1)) {
                worst.take(exact - recorded, self.time(row + 1));
            }
        }
    }
}

/// The control loop once more.
struct Loop<'a> {
    plan: &'a Plan,
    timing: Timing,
    controller: ArmController,
    encoders: Encoders,
    drives: Drives,
    reference: MotionState,
    next_reference: MotionState,
}

impl Loop<'_> {
    /// Follows the plan on the exact plant from the recorded state of a row.
    fn follow(
        &mut self,
        run: &Run<'_>,
        arm: &mut ExactArm,
        [from, to]: [usize; 2],
        result: &mut Reintegration,
    ) {
        let (mut q, mut qd) = (run.q(from).to_vec(), run.qd(from).to_vec());
        let Timing { clock, command_stride, .. } = self.timing;
        for row in from..=to {
            let time = run.time(row);
            self.plan.trajectory.eval_held(time, &mut self.reference);
            take_errors(&mut result.exact_tracking, &q, &self.reference.q, time);
            take_errors(&mut result.tracking, run.q(row), &self.reference.q, time);
            let opening = run.opening(row);
            if row.is_multiple_of(command_stride) {
                let next = clock.seconds(row + command_stride);
                self.plan.trajectory.eval_held(next, &mut self.next_reference);
                self.encoders.read(&q, &qd);
                self.controller.set_load(opening, None);
                self.controller.update(
                    &self.reference,
                    &self.next_reference,
                    self.encoders.q(),
                    self.encoders.qd(),
                );
            }
            self.drives.act(self.controller.command(), &q);
            arm.set_load(opening, None);
            arm.advance(&mut q, &mut qd, &self.drives.applied().efforts, run.dt);
        }
    }
}

fn take_errors(worst: &mut [Worst], q: &[f64], reference: &[f64], time: f64) {
    for ((worst, q), reference) in worst.iter_mut().zip(q).zip(reference) {
        worst.take(q - reference, time);
    }
}

impl Reintegration {
    /// Enters the findings into the record `run` of a recording: for each joint the integration defect and both
    /// tracking errors, with their unit.
    pub(crate) fn enter(&self, robot: &RobotModel, recording: &mut Recording) {
        let mut enter = |key: String, value: String| {
            recording.metadata.insert(key, value);
        };
        let [free, all] = self.windows;
        enter("reintegrated_windows".to_owned(), format!("{free} of {all}, {WINDOW} s each"));
        if free == 0 {
            return;
        }
        let columns = [
            ("integration_defect", &self.defect),
            ("free_tracking_error", &self.tracking),
            ("free_tracking_error_exact_plant", &self.exact_tracking),
        ];
        for (name, worst) in columns {
            for (joint, Worst { value, time }) in robot.joints.iter().zip(worst) {
                let unit = if joint.kind == JointKind::Revolute { "rad" } else { "m" };
                enter(format!("{name}.{}", joint.name), format!("{value:.2e} {unit} at {time:.3} s"));
            }
        }
    }
}
