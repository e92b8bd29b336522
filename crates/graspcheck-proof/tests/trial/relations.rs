//! Cases made from others, of which the proofs must say the same.

use graspcheck_model::{Pose, robot::JointKind, shape::Shape};
use graspcheck_motion::{Polynomial, Trajectory};
use nalgebra::{Isometry3, Matrix3, Point3, Rotation3, Unit, UnitQuaternion, Vector3};

use super::random::Case;

/// All of it, moved rigidly in the world.
pub fn moved(case: &Case, world_from_old: &Pose) -> Case {
    let mut case = case.clone();
    case.robot.world_from_base = world_from_old * case.robot.world_from_base;
    for body in &mut case.cell.bodies {
        body.world_from_shape = world_from_old * body.world_from_shape;
    }
    case
}

/// All of it behind the mirror y = 0: joints turn the other way, slides do not.
pub fn mirrored(case: &Case) -> Case {
    let mut case = case.clone();
    let robot = &mut case.robot;
    robot.world_from_base = mirrored_pose(&robot.world_from_base);
    robot.link_from_tool = mirrored_pose(&robot.link_from_tool);
    for joint in &mut robot.joints {
        joint.parent_from_joint = mirrored_pose(&joint.parent_from_joint);
        joint.axis = mirrored_axis(&joint.axis);
    }
    for finger in &mut robot.gripper.fingers {
        finger.link_from_finger = mirrored_pose(&finger.link_from_finger);
        finger.axis = mirrored_axis(&finger.axis);
    }
    let fingers = robot.gripper.fingers.iter_mut().map(|finger| &mut finger.link);
    for link in robot.links.iter_mut().chain([&mut robot.base]).chain(fingers) {
        for placed in &mut link.shapes {
            placed.body_from_shape = mirrored_pose(&placed.body_from_shape);
            mirror_shape(&mut placed.shape);
        }
    }
    for body in &mut case.cell.bodies {
        body.world_from_shape = mirrored_pose(&body.world_from_shape);
        mirror_shape(&mut body.shape);
    }
    if let Some(object) = &mut case.object {
        mirror_shape(&mut object.shape);
    }
    if let Some(grasp) = &mut case.plan.grasp {
        grasp.tool_from_object = mirrored_pose(&grasp.tool_from_object);
    }
    let turns = case.robot.joints.iter().map(|joint| joint.kind == JointKind::Revolute);
    let turns: Vec<bool> = turns.collect();
    case.plan.trajectory = each_piece(&case.plan.trajectory, |joint, polynomial| {
        let sign = if turns[joint] { -1.0 } else { 1.0 };
        Polynomial::new(polynomial.coefficients().map(|c| sign * c))
    });
    case
}

fn mirror() -> Matrix3<f64> {
    Matrix3::from_diagonal(&Vector3::new(1.0, -1.0, 1.0))
}

fn mirrored_pose(pose: &Pose) -> Pose {
    let turn = mirror() * pose.rotation.to_rotation_matrix().into_inner() * mirror();
    let turn = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(turn));
    Isometry3::from_parts((mirror() * pose.translation.vector).into(), turn)
}

fn mirrored_axis(axis: &Unit<Vector3<f64>>) -> Unit<Vector3<f64>> {
    Unit::new_normalize(mirror() * axis.into_inner())
}

/// All solids but hulls are their own mirror images.
fn mirror_shape(shape: &mut Shape) {
    if let Shape::Hull { points } = shape {
        points.iter_mut().for_each(|point| *point = Point3::from(mirror() * point.coords));
    }
}

fn each_piece(trajectory: &Trajectory, change: impl Fn(usize, &Polynomial) -> Polynomial) -> Trajectory {
    let pieces = (0..trajectory.piece_count()).flat_map(|piece| {
        let change = &change;
        trajectory.piece_of_all(piece).iter().enumerate().map(move |(joint, it)| change(joint, it))
    });
    Trajectory::new(trajectory.dof(), trajectory.knots().to_vec(), pieces.collect()).unwrap()
}

/// The motion takes `factor` times as long.
pub fn slowed(case: &Case, factor: f64) -> Case {
    let slow = |trajectory: &Trajectory| {
        let pieces = each_piece(trajectory, |_, polynomial| {
            let mut scaled = *polynomial.coefficients();
            (0..).zip(&mut scaled).for_each(|(power, c)| *c /= factor.powi(power));
            Polynomial::new(scaled)
        });
        let all = (0..pieces.piece_count()).flat_map(|piece| pieces.piece_of_all(piece).to_vec());
        let knots = trajectory.knots().iter().map(|knot| knot * factor).collect();
        Trajectory::new(trajectory.dof(), knots, all.collect()).unwrap()
    };
    with_motions(case, slow)
}

/// The motion backwards.
pub fn reversed(case: &Case) -> Case {
    let reverse = |trajectory: &Trajectory| {
        let knots = trajectory.knots();
        let mut pieces = Vec::new();
        for piece in (0..trajectory.piece_count()).rev() {
            let h = knots[piece + 1] - knots[piece];
            for polynomial in trajectory.piece_of_all(piece) {
                let mut backwards = *polynomial.shifted(h).coefficients();
                backwards.iter_mut().skip(1).step_by(2).for_each(|c| *c = -*c);
                pieces.push(Polynomial::new(backwards));
            }
        }
        let end = trajectory.duration();
        let knots = knots.iter().rev().map(|knot| end - knot).collect();
        Trajectory::new(trajectory.dof(), knots, pieces).unwrap()
    };
    with_motions(case, reverse)
}

/// The arm's motion with one more knot at a share of the duration, where nothing changes.
pub fn split(case: &Case, share: f64) -> Case {
    let trajectory = &case.plan.trajectory;
    let at = share * trajectory.duration();
    let (mut knots, mut pieces) = (vec![0.0], Vec::new());
    for piece in 0..trajectory.piece_count() {
        let (start, end) = (trajectory.knots()[piece], trajectory.knots()[piece + 1]);
        pieces.extend_from_slice(trajectory.piece_of_all(piece));
        if start < at && at < end {
            knots.push(at);
            pieces.extend(trajectory.piece_of_all(piece).iter().map(|it| it.shifted(at - start)));
        }
        knots.push(end);
    }
    let mut case = case.clone();
    case.plan.trajectory = Trajectory::new(case.robot.dof(), knots, pieces).unwrap();
    case
}

fn with_motions(case: &Case, change: impl Fn(&Trajectory) -> Trajectory) -> Case {
    let mut case = case.clone();
    case.plan.trajectory = change(&case.plan.trajectory);
    case.plan.opening = change(&case.plan.opening);
    let duration = case.plan.trajectory.duration();
    case.plan.phases[0].end = duration;
    case
}

/// The obstacles in another order, and rules that name the two bodies the other way round.
pub fn reordered(case: &Case) -> Case {
    let mut case = case.clone();
    case.cell.bodies.reverse();
    for rule in &mut case.cell.clearance.pairs {
        std::mem::swap(&mut rule.a, &mut rule.b);
    }
    for contact in &mut case.robot.allowed_contacts {
        std::mem::swap(&mut contact.a, &mut contact.b);
    }
    case
}

/// One obstacle, larger by `by` (m) on every side; none for a hull. The second number is by how much the support function
/// grows at most, as a multiple of `by`; it grows by no less than `by`.
pub fn inflated(case: &Case, obstacle: usize, by: f64) -> Option<(Case, f64)> {
    let mut case = case.clone();
    let most = match &mut case.cell.bodies[obstacle].shape {
        Shape::Box { half_extents } => {
            half_extents.add_scalar_mut(by);
            3.0_f64.sqrt()
        }
        Shape::Sphere { radius } | Shape::Capsule { radius, .. } => {
            *radius += by;
            1.0
        }
        Shape::Cylinder { radius, half_length } => {
            *radius += by;
            *half_length += by;
            2.0_f64.sqrt()
        }
        Shape::Hull { .. } => return None,
    };
    Some((case, most))
}
