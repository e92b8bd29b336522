//! What the motors of an arm must bring, by Newton's and Euler's laws for every body in the world frame and d'Alembert's
//! principle: no joint frame but those of the kinematics is used.

use graspcheck_model::{Pose, inertia::Inertial, plan::Holding, robot::JointKind};
use nalgebra::{Isometry3, Matrix3, Vector3};

use super::random::Case;

/// How a body-fixed frame moves in the world.
#[derive(Clone)]
struct Motion {
    place: Pose,
    turning: Vector3<f64>,
    turning_rate: Vector3<f64>,
    /// Of the frame's origin.
    acceleration: Vector3<f64>,
}

/// The torques (N·m or N) of all joints at time `t`, without friction, with what the gripper holds.
pub fn torques(case: &Case, gravity: &Vector3<f64>, t: f64) -> Vec<f64> {
    let robot = &case.robot;
    let state = case.plan.trajectory.eval(t);
    let mut motion = Motion {
        place: robot.world_from_base,
        turning: Vector3::zeros(),
        turning_rate: Vector3::zeros(),
        acceleration: Vector3::zeros(),
    };
    // Of every joint the axis and a point of it, in the world.
    let mut axes: Vec<(Vector3<f64>, Vector3<f64>)> = Vec::new();
    let mut torques: Vec<f64> =
        robot.joints.iter().zip(&state.qdd).map(|(joint, qdd)| joint.rotor_inertia * qdd).collect();
    let mut load = |motion: &Motion, inertial: &Inertial, axes: &[(Vector3<f64>, Vector3<f64>)]| {
        let arm = motion.place.rotation * inertial.center.coords;
        let acceleration = motion.acceleration
            + motion.turning_rate.cross(&arm)
            + motion.turning.cross(&motion.turning.cross(&arm));
        let force = (acceleration - gravity) * inertial.mass;
        let turn: Matrix3<f64> = motion.place.rotation.to_rotation_matrix().into_inner();
        let tensor = turn * inertial.tensor * turn.transpose();
        let moment = tensor * motion.turning_rate + motion.turning.cross(&(tensor * motion.turning));
        let center = motion.place.translation.vector + arm;
        for (joint, (axis, point)) in axes.iter().enumerate() {
            torques[joint] += match robot.joints[joint].kind {
                JointKind::Revolute => axis.dot(&(moment + (center - point).cross(&force))),
                JointKind::Prismatic => axis.dot(&force),
            };
        }
    };
    for (index, joint) in robot.joints.iter().enumerate() {
        let (q, qd, qdd) = (state.q[index], state.qd[index], state.qdd[index]);
        let at_zero = motion.place * joint.parent_from_joint;
        let axis = at_zero.rotation * joint.axis.into_inner();
        let local = joint.axis.into_inner();
        let place = at_zero
            * match joint.kind {
                JointKind::Revolute => Isometry3::new(Vector3::zeros(), local * q),
                JointKind::Prismatic => Isometry3::new(local * q, Vector3::zeros()),
            };
        let step = place.translation.vector - motion.place.translation.vector;
        let carried = motion.acceleration
            + motion.turning_rate.cross(&step)
            + motion.turning.cross(&motion.turning.cross(&step));
        motion = match joint.kind {
            JointKind::Revolute => Motion {
                place,
                turning_rate: motion.turning_rate + motion.turning.cross(&axis) * qd + axis * qdd,
                turning: motion.turning + axis * qd,
                acceleration: carried,
            },
            JointKind::Prismatic => Motion {
                place,
                acceleration: carried + motion.turning.cross(&axis) * (2.0 * qd) + axis * qdd,
                ..motion
            },
        };
        axes.push((axis, place.translation.vector));
        load(&motion, &robot.links[index].inertial, &axes);
    }
    let half = 0.5 * case.plan.opening.eval(t).q[0];
    for finger in &robot.gripper.fingers {
        let opened = Pose::translation(finger.axis.x * half, finger.axis.y * half, finger.axis.z * half);
        load(&motion, &finger.link.inertial.transformed(&(finger.link_from_finger * opened)), &axes);
    }
    if let (Some(object), Some(grasp)) = (&case.object, &case.plan.grasp) {
        assert_eq!(case.plan.phases[0].holding, Holding::Held);
        let place = robot.link_from_tool * grasp.tool_from_object;
        load(&motion, &object.shape.inertial(object.mass).transformed(&place), &axes);
    }
    torques
}
