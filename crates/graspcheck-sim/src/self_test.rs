//! Compares the built multibody with the model's own dynamics before anything is simulated.
//!
//! Both are computed from the same data in different ways: rapier assembles Σ Jᵀ diag(m, I) J with its own
//! Jacobians, the model uses recursive Newton–Euler. They agree to rounding, or the bridge between them is
//! wrong (a turned joint frame, an inertia in the wrong axes, a hidden damping), and then no simulation is
//! worth looking at.

use graspcheck_model::{cell::Cell, dynamics::Dynamics, execution::ContactModel, robot::RobotModel};

use crate::{
    error::SimError,
    plant::{FINGERS, Plant, PlantSettings},
    random::{Random, Stream},
};

/// How far mass matrix and bias forces may differ, as a share of the largest entry. Both sides are sums of
/// some hundred products with rounding errors of 1.1e-16 each; rapier's principal axes of inertia cost
/// about 1e-9. A wrong frame or damping shows at 1e-3 and more.
pub(crate) const MODEL_TOLERANCE: f64 = 1e-6;

/// At how many states the two are compared.
const STATES: usize = 4;

/// Length of the step that yields accelerations, s. Rapier's error in them is proportional to it.
const STEP: f64 = 1e-9;

/// Range of a joint without position limits, rad or m.
const UNLIMITED_RANGE: f64 = 3.0;

/// Compares at states drawn from `seed`.
///
/// # Errors
/// [`SimError::ModelMismatch`] with the worst entry.
pub(crate) fn run(
    robot: &RobotModel,
    cell: &Cell,
    contact: &ContactModel,
    seed: u64,
) -> Result<(), SimError> {
    let empty = Cell { bodies: Vec::new(), ..cell.clone() };
    let settings = PlantSettings { dt: STEP, substeps: 1, contact };
    let mut plant = Plant::new(robot, &empty, None, &settings)?;
    let mut dynamics = Dynamics::new(robot, cell.gravity);
    let mut random = Random::new(seed, Stream::SelfTest);
    for _ in 0..STATES {
        let state = State::draw(robot, &mut random);
        compare(robot, &mut plant, &mut dynamics, &state)?;
    }
    Ok(())
}

/// Positions and velocities of the arm, and the fingers' common position.
struct State {
    q: Vec<f64>,
    qd: Vec<f64>,
    finger: f64,
}

impl State {
    fn draw(robot: &RobotModel, random: &mut Random) -> Self {
        let mut q = Vec::new();
        let mut qd = Vec::new();
        for joint in &robot.joints {
            let limits = &joint.limits;
            let bounded = |limit: f64, fallback: f64| if limit.is_finite() { limit } else { fallback };
            let low = bounded(limits.position_min, -UNLIMITED_RANGE);
            let high = bounded(limits.position_max, UNLIMITED_RANGE);
            q.push(low + (high - low) * random.unit());
            qd.push(bounded(limits.velocity, 1.0) * (2.0 * random.unit() - 1.0));
        }
        Self { q, qd, finger: robot.gripper.opening_max / 2.0 * random.unit() }
    }
}

fn compare(
    robot: &RobotModel,
    plant: &mut Plant,
    dynamics: &mut Dynamics,
    state: &State,
) -> Result<(), SimError> {
    let dof = robot.dof();
    let mut q = state.q.clone();
    let mut qd = state.qd.clone();
    q.extend([state.finger; FINGERS]);
    qd.extend([0.0; FINGERS]);
    plant.set_state(&q, &qd);
    // The fingers stand still relative to the hand, so the arm's block of the matrix, and its rows of
    // M a + h = 0, are those of an arm with fixed fingers.
    let mass = plant.mass_matrix();
    dynamics.set_load(2.0 * state.finger, None);
    let expected_mass = dynamics.mass_matrix(&state.q);
    let arm_mass = mass.view((0, 0), (dof, dof));
    let mismatch = |quantity, joint: usize, rapier, model, tolerance| SimError::ModelMismatch {
        quantity,
        joint: robot.joints[joint].name.clone(),
        rapier,
        model,
        tolerance,
        q: state.q.clone(),
        qd: state.qd.clone(),
    };
    let tolerance = MODEL_TOLERANCE * expected_mass.amax();
    for row in 0..dof {
        for column in 0..dof {
            let (rapier, model) = (arm_mass[(row, column)], expected_mass[(row, column)]);
            if !within(rapier, model, tolerance) {
                return Err(mismatch("mass matrix", row, rapier, model, tolerance));
            }
        }
    }

    plant.step(&());
    let mut acceleration = vec![0.0; q.len()];
    plant.unconstrained_acceleration(&mut acceleration);
    let inertial_force = &mass * nalgebra::DVector::from_vec(acceleration);
    let mut bias = vec![0.0; dof];
    dynamics.inverse(&state.q, &state.qd, &vec![0.0; dof], &mut bias);
    let viscous: Vec<f64> = robot.joints.iter().zip(&qd).map(|(joint, rate)| joint.damping * rate).collect();
    let largest = bias.iter().zip(&viscous).fold(0.0, |worst: f64, (h, d)| worst.max((h + d).abs()));
    let tolerance = MODEL_TOLERANCE * largest.max(expected_mass.amax());
    for joint in 0..dof {
        let (rapier, model) = (-inertial_force[joint], bias[joint] + viscous[joint]);
        if !within(rapier, model, tolerance) {
            return Err(mismatch("bias force", joint, rapier, model, tolerance));
        }
    }
    Ok(())
}

/// False also when a value is NaN.
fn within(left: f64, right: f64, tolerance: f64) -> bool {
    (left - right).abs() <= tolerance
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures;
    use nalgebra::{Matrix3, Vector3};

    // Gravity along no axis.
    const SLANTED: Vector3<f64> = Vector3::new(1.5, -3.0, -9.0);

    /// Compares the plant of one robot with the model of another.
    fn test(built: &RobotModel, modelled: &RobotModel) -> Result<(), SimError> {
        let contact = fixtures::execution().contact;
        let settings = PlantSettings { dt: STEP, substeps: 1, contact: &contact };
        let mut plant = Plant::new(built, &fixtures::empty_cell(SLANTED), None, &settings)?;
        let mut dynamics = Dynamics::new(modelled, SLANTED);
        let mut random = Random::new(7, Stream::SelfTest);
        for _ in 0..STATES {
            compare(modelled, &mut plant, &mut dynamics, &State::draw(modelled, &mut random))?;
        }
        Ok(())
    }

    fn quantity(result: Result<(), SimError>) -> &'static str {
        match result {
            Err(SimError::ModelMismatch { quantity, .. }) => quantity,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn rapier_and_the_model_agree_on_every_arm() {
        for robot in [fixtures::scara(), fixtures::rrr(), fixtures::tilted()] {
            assert_eq!(test(&robot, &robot), Ok(()), "{}", robot.name);
            let cell = fixtures::empty_cell(SLANTED);
            for seed in 0..20 {
                assert_eq!(run(&robot, &cell, &fixtures::execution().contact, seed), Ok(()));
            }
        }
    }

    #[test]
    fn small_inertias_keep_their_principal_axes() {
        // With parry's own eigenvectors this finger, of some mg·m², had two principal inertias swapped.
        let moments = [[1.3e-5, 1.1e-5, 2.9e-6], [2.9e-6, 1.3e-5, 1.1e-5], [1.1e-7, 3.0e-7, 2.5e-7]];
        let tilt = nalgebra::Rotation3::from_euler_angles(0.3, -0.7, 1.1);
        for rotation in [nalgebra::Rotation3::identity(), tilt] {
            for moments in moments {
                let mut robot = fixtures::scara();
                for finger in &mut robot.gripper.fingers {
                    let principal = Matrix3::from_diagonal(&Vector3::from(moments));
                    finger.link.inertial.tensor =
                        rotation.matrix() * principal * rotation.matrix().transpose();
                }
                // Light links, so that the fingers' inertia is no small share of the whole.
                for link in &mut robot.links {
                    link.inertial.mass *= 1e-3;
                    link.inertial.tensor *= 1e-3;
                }
                for joint in &mut robot.joints {
                    joint.rotor_inertia = 0.0;
                }
                assert_eq!(test(&robot, &robot), Ok(()), "{moments:?}");
            }
        }
    }

    #[test]
    fn an_inertia_that_is_not_rotated_is_found() {
        let built = fixtures::tilted();
        let mut modelled = built.clone();
        let tensor = &mut modelled.links[2].inertial.tensor;
        *tensor = Matrix3::from_diagonal(&tensor.symmetric_eigenvalues());
        assert_eq!(quantity(test(&built, &modelled)), "mass matrix");
    }

    #[test]
    fn a_centre_of_mass_that_is_off_by_a_millimetre_is_found() {
        let built = fixtures::scara();
        let mut modelled = built.clone();
        modelled.links[0].inertial.center.y += 1e-3;
        assert_eq!(quantity(test(&built, &modelled)), "mass matrix");
    }

    #[test]
    fn rapiers_hidden_damping_would_be_found() {
        let mut built = fixtures::scara();
        let modelled = built.clone();
        built.joints[0].damping = 0.1;
        assert_eq!(quantity(test(&built, &modelled)), "bias force");
    }

    #[test]
    fn a_base_that_is_not_turned_is_found() {
        let built = fixtures::rrr();
        let mut modelled = built.clone();
        modelled.world_from_base.rotation = nalgebra::UnitQuaternion::from_euler_angles(0.01, 0.0, 0.0);
        assert_eq!(quantity(test(&built, &modelled)), "bias force");
    }
}
