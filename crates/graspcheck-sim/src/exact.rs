//! The arm as the exact equations of motion have it: what the rapier plant is held against.
//!
//! M(q) q̈ = τ − h(q, q̇) − D q̇ − F sign(q̇), with the mass matrix M and the bias h (gravity, Coriolis) from the model's
//! recursive Newton–Euler, viscous friction D and dry friction F. A joint at rest stays there as long as less
//! than F drives it. Within a step every joint keeps its direction, so that the right-hand side is smooth and classical
//! Runge–Kutta has its fourth order; a step in which a joint turns back is halved until at most ½ (F/M) dt² of
//! position is lost by letting it come to rest at its end.

use graspcheck_model::{dynamics::Dynamics, inertia::Inertial, robot::RobotModel};
use nalgebra::Vector3;

/// Below this speed a joint with dry friction is at rest, rad/s or m/s: rounding, not motion.
const REST: f64 = 1e-12;

/// A joint that turns back comes to rest within so long, s: at 1 rad/s² of dry friction that costs 5e-9 rad.
pub(crate) const LEAST_STEP: f64 = 1e-4;

/// How a joint meets its dry friction within a step.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Mode {
    /// Moves in the direction of this sign.
    Slides(f64),
    /// Stays.
    Sticks,
}

/// An arm that moves by the exact equations.
pub(crate) struct ExactArm {
    dynamics: Dynamics,
    damping: Vec<f64>,
    friction: Vec<f64>,
    modes: Vec<Mode>,
    room: Room,
    /// Four slopes of positions and velocities.
    slopes: [[Vec<f64>; 2]; 4],
    q: Vec<f64>,
    qd: Vec<f64>,
}

/// Room for one solution of the equations.
struct Room {
    zero: Vec<f64>,
    unit: Vec<f64>,
    bias: Vec<f64>,
    gravity: Vec<f64>,
    column: Vec<f64>,
    /// Row by row.
    mass: Vec<f64>,
    factor: Vec<f64>,
    driving: Vec<f64>,
}

impl ExactArm {
    /// The arm of this robot under this gravity, m/s² in the world, with a closed and empty gripper.
    pub(crate) fn new(robot: &RobotModel, gravity: Vector3<f64>) -> Self {
        let dof = robot.dof();
        let zeros = || vec![0.0; dof];
        Self {
            dynamics: Dynamics::new(robot, gravity),
            damping: robot.joints.iter().map(|joint| joint.damping).collect(),
            friction: robot.joints.iter().map(|joint| joint.friction).collect(),
            modes: vec![Mode::Sticks; dof],
            room: Room {
                zero: zeros(),
                unit: zeros(),
                bias: zeros(),
                gravity: zeros(),
                column: zeros(),
                mass: vec![0.0; dof * dof],
                factor: vec![0.0; dof * dof],
                driving: zeros(),
            },
            slopes: std::array::from_fn(|_| [zeros(), zeros()]),
            q: zeros(),
            qd: zeros(),
        }
    }

    /// From now on the gripper stands at `opening`, m, and the last link carries `load`, given in its frame.
    pub(crate) fn set_load(&mut self, opening: f64, load: Option<&Inertial>) {
        self.dynamics.set_load(opening, load);
    }

    /// Decides how each joint meets its dry friction from this state on, under these efforts, N·m or N.
    pub(crate) fn begin(&mut self, q: &[f64], qd: &[f64], efforts: &[f64]) {
        for ((mode, friction), rate) in self.modes.iter_mut().zip(&self.friction).zip(qd) {
            let moves = *friction == 0.0 || rate.abs() > REST;
            *mode = if moves { Mode::Slides(rate.signum()) } else { Mode::Sticks };
        }
        // Every round sets at least one joint free.
        for _ in 0..qd.len() {
            if !self.modes.contains(&Mode::Sticks) {
                return;
            }
            solve(self.parts(), q, qd, efforts, None);
            let mut breaks_loose = false;
            for joint in 0..qd.len() {
                let driving = self.room.driving[joint];
                if self.modes[joint] == Mode::Sticks && driving.abs() > self.friction[joint] {
                    self.modes[joint] = Mode::Slides(driving.signum());
                    breaks_loose = true;
                }
            }
            if !breaks_loose {
                return;
            }
        }
    }

    fn parts(&mut self) -> Parts<'_> {
        Parts {
            dynamics: &mut self.dynamics,
            damping: &self.damping,
            friction: &self.friction,
            modes: &self.modes,
            room: &mut self.room,
        }
    }

    /// Accelerations of all joints, rad/s² or m/s², in the modes that [`ExactArm::begin`] found.
    pub(crate) fn acceleration(&mut self, q: &[f64], qd: &[f64], efforts: &[f64], qdd: &mut [f64]) {
        solve(self.parts(), q, qd, efforts, Some(qdd));
    }

    /// Whether a joint with dry friction has turned back since [`ExactArm::begin`].
    pub(crate) fn turned_back(&self, qd: &[f64]) -> bool {
        self.modes.iter().zip(&self.friction).zip(qd).any(|((mode, friction), rate)| {
            matches!(mode, Mode::Slides(sign) if *friction > 0.0 && rate * sign < 0.0)
        })
    }

    /// Stops the joints that have turned back since [`ExactArm::begin`].
    pub(crate) fn end(&self, qd: &mut [f64]) {
        for ((mode, friction), rate) in self.modes.iter().zip(&self.friction).zip(qd) {
            match mode {
                Mode::Slides(sign) if *friction > 0.0 && *rate * sign < 0.0 => *rate = 0.0,
                Mode::Sticks => *rate = 0.0,
                Mode::Slides(_) => {}
            }
        }
    }

    /// Moves the arm on by `dt` seconds under constant efforts. A step in which a joint turns back against its dry
    /// friction is halved until that no longer matters.
    pub(crate) fn advance(&mut self, q: &mut [f64], qd: &mut [f64], efforts: &[f64], dt: f64) {
        self.begin(q, qd, efforts);
        let before = [q.to_vec(), qd.to_vec()];
        self.runge_kutta(q, qd, efforts, dt);
        if self.turned_back(qd) && dt > LEAST_STEP {
            q.copy_from_slice(&before[0]);
            qd.copy_from_slice(&before[1]);
            self.advance(q, qd, efforts, 0.5 * dt);
            self.advance(q, qd, efforts, 0.5 * dt);
        } else {
            self.end(qd);
        }
    }

    /// One step of classical Runge–Kutta of fourth order in the modes of its beginning.
    fn runge_kutta(&mut self, q: &mut [f64], qd: &mut [f64], efforts: &[f64], dt: f64) {
        let mut slopes = std::mem::take(&mut self.slopes);
        let (mut at_q, mut at_qd) = (std::mem::take(&mut self.q), std::mem::take(&mut self.qd));
        for stage in 0..4 {
            let reach = [0.0, 0.5, 0.5, 1.0][stage] * dt;
            at_q.copy_from_slice(q);
            at_qd.copy_from_slice(qd);
            if stage > 0 {
                let [rates, accelerations] = &slopes[stage - 1];
                add_scaled(&mut at_q, rates, reach);
                add_scaled(&mut at_qd, accelerations, reach);
            }
            let [rates, accelerations] = &mut slopes[stage];
            rates.copy_from_slice(&at_qd);
            self.acceleration(&at_q, &at_qd, efforts, accelerations);
        }
        for ([rates, accelerations], weight) in slopes.iter().zip([1.0, 2.0, 2.0, 1.0]) {
            add_scaled(q, rates, weight * dt / 6.0);
            add_scaled(qd, accelerations, weight * dt / 6.0);
        }
        (self.slopes, self.q, self.qd) = (slopes, at_q, at_qd);
    }

    /// Kinetic energy, J.
    pub(crate) fn kinetic(&mut self, q: &[f64], qd: &[f64]) -> f64 {
        let rates = nalgebra::DVector::from_column_slice(qd);
        0.5 * rates.dot(&(self.dynamics.mass_matrix(q) * &rates))
    }
}

/// What [`solve`] works on.
struct Parts<'a> {
    dynamics: &'a mut Dynamics,
    damping: &'a [f64],
    friction: &'a [f64],
    modes: &'a [Mode],
    room: &'a mut Room,
}

/// Solves for the accelerations; in the room is left what drives each joint against its dry friction.
fn solve(parts: Parts<'_>, q: &[f64], qd: &[f64], efforts: &[f64], qdd: Option<&mut [f64]>) {
    let Parts { dynamics, damping, friction, modes, room } = parts;
    let dof = q.len();
    dynamics.inverse(q, qd, &room.zero, &mut room.bias);
    dynamics.inverse(q, &room.zero, &room.zero, &mut room.gravity);
    for k in 0..dof {
        room.unit.fill(0.0);
        room.unit[k] = 1.0;
        dynamics.inverse(q, &room.zero, &room.unit, &mut room.column);
        for row in 0..dof {
            room.mass[row * dof + k] = room.column[row] - room.gravity[row];
        }
    }
    // A joint that sticks has no acceleration: its row and column are those of the identity.
    let sticks = |joint: usize| modes[joint] == Mode::Sticks;
    for row in 0..dof {
        for column in 0..dof {
            let free = !sticks(row) && !sticks(column);
            let entry = room.mass[row * dof + column];
            room.factor[row * dof + column] = if free { entry } else { f64::from(u8::from(row == column)) };
        }
    }
    for joint in 0..dof {
        let dry = match modes[joint] {
            Mode::Slides(sign) => sign * friction[joint],
            Mode::Sticks => 0.0,
        };
        room.driving[joint] = efforts[joint] - room.bias[joint] - damping[joint] * qd[joint] - dry;
        room.column[joint] = if sticks(joint) { 0.0 } else { room.driving[joint] };
    }
    cholesky_solve(&mut room.factor, &mut room.column);
    for row in 0..dof {
        let inertial: f64 = (0..dof).map(|k| room.mass[row * dof + k] * room.column[k]).sum();
        room.driving[row] -= inertial;
    }
    if let Some(qdd) = qdd {
        qdd.copy_from_slice(&room.column);
    }
}

/// Solves A x = b in place for a symmetric positive definite A, given row by row.
fn cholesky_solve(a: &mut [f64], b: &mut [f64]) {
    let n = b.len();
    for row in 0..n {
        for column in 0..=row {
            let known: f64 = (0..column).map(|k| a[row * n + k] * a[column * n + k]).sum();
            let rest = a[row * n + column] - known;
            a[row * n + column] = if row == column { rest.sqrt() } else { rest / a[column * n + column] };
        }
    }
    for row in 0..n {
        let known: f64 = (0..row).map(|k| a[row * n + k] * b[k]).sum();
        b[row] = (b[row] - known) / a[row * n + row];
    }
    for row in (0..n).rev() {
        let known: f64 = (row + 1..n).map(|k| a[k * n + row] * b[k]).sum();
        b[row] = (b[row] - known) / a[row * n + row];
    }
}

fn add_scaled(sum: &mut [f64], more: &[f64], factor: f64) {
    sum.iter_mut().zip(more).for_each(|(sum, more)| *sum += factor * more);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures;

    /// Inverse dynamics of what forward dynamics gives is where it came from.
    #[test]
    fn accelerations_are_those_whose_torques_were_given() {
        for mut robot in [fixtures::scara(), fixtures::rrr(), fixtures::tilted()] {
            robot.joints[0].friction = 3.0;
            robot.joints[1].damping = 0.4;
            let gravity = Vector3::new(1.0, -2.0, -9.0);
            let mut arm = ExactArm::new(&robot, gravity);
            let dof = robot.dof();
            let q: Vec<f64> = (0..dof).map(|k| 0.3 - 0.2 * k as f64).collect();
            let qd: Vec<f64> = (0..dof).map(|k| 1.0 - 0.7 * k as f64).collect();
            let efforts: Vec<f64> = (0..dof).map(|k| 40.0 - 31.0 * k as f64).collect();
            let mut qdd = vec![0.0; dof];
            arm.begin(&q, &qd, &efforts);
            arm.acceleration(&q, &qd, &efforts, &mut qdd);
            let mut dynamics = Dynamics::new(&robot, gravity);
            let (mut tau, mut friction) = (vec![0.0; dof], vec![0.0; dof]);
            dynamics.inverse(&q, &qd, &qdd, &mut tau);
            dynamics.friction(&qd, &mut friction);
            for joint in 0..dof {
                let again = tau[joint] + friction[joint];
                assert!((again - efforts[joint]).abs() < 1e-9, "{}: {again}", robot.name);
            }
        }
    }

    #[test]
    fn dry_friction_holds_up_to_its_limit_and_brakes_to_a_standstill() {
        let mut robot = fixtures::scara();
        robot.joints[0].friction = 5.0;
        let mut arm = ExactArm::new(&robot, Vector3::new(0.0, 0.0, -9.81));
        let weight = arm.dynamics.clone();
        let mut hold = vec![0.0; 4];
        weight.clone().inverse(&[0.0; 4], &[0.0; 4], &[0.0; 4], &mut hold);
        let moved = |arm: &mut ExactArm, effort: f64| {
            let (mut q, mut qd) = ([0.0; 4], [0.0; 4]);
            hold[0] = effort;
            for _ in 0..100 {
                arm.advance(&mut q, &mut qd, &hold, 1e-3);
            }
            (q[0], qd[0])
        };
        let mut moved = moved;
        assert_eq!(moved(&mut arm, 4.999), (0.0, 0.0));
        assert_eq!(moved(&mut arm, -4.999), (0.0, 0.0));
        assert!(moved(&mut arm, 5.1).1 > 0.0 && moved(&mut arm, -5.1).1 < 0.0);
        // The other joints locked by much friction, a push of the shoulder dies out.
        for joint in 1..4 {
            robot.joints[joint].friction = 1e6;
        }
        let mut arm = ExactArm::new(&robot, Vector3::zeros());
        let inertia = arm.dynamics.mass_matrix(&[0.0; 4])[(0, 0)];
        let (mut q, mut qd) = ([0.0; 4], [0.5, 0.0, 0.0, 0.0]);
        for _ in 0..1000 {
            arm.advance(&mut q, &mut qd, &[0.0; 4], 1e-3);
        }
        // v² / 2a with a = F / I.
        let way = 0.5 * 0.25 * inertia / 5.0;
        assert!(qd[0] == 0.0 && (q[0] - way).abs() < 1e-5, "{} m is not {way} m", q[0]);
    }
}
