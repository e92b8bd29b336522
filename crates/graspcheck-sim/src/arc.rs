//! The pads move along arcs, and what they hold with them.
//!
//! Friction is solved for velocities: in each step the object gets the velocity that the pad has at the
//! step's beginning. Over the step the object then moves along a straight line, the pad along an arc, and
//! by half the centripetal acceleration times dt² they are apart: at 4 m/s² and 1 kHz the object creeps out
//! of the hand by 2 mm/s, however strong the grip. So the tangential target velocity between pad and object
//! is corrected by what arc and straight line differ, over dt. Coulomb's limit stays: a grip that is too
//! weak slips as before.

use graspcheck_model::{Pose, robot::RobotModel};
use rapier3d::{
    dynamics::{RigidBodyHandle, RigidBodySet},
    math::{Pose as RapierPose, Rotation, Vector},
    pipeline::{ContactModificationContext, PhysicsHooks},
};

use crate::{convert, tool};

/// The motion of the hand in the step to come, as far as the present velocities tell.
pub(crate) struct ArcCorrection {
    dt: f64,
    fingers: [RigidBodyHandle; 2],
    object: Option<RigidBodyHandle>,
    /// From the hand's place at the beginning of the step to that at its end, in the world.
    displacement: RapierPose,
    /// A point of the hand, its velocity, and the hand's angular velocity, in the world.
    point: Vector,
    velocity: Vector,
    angular_velocity: Vector,
    next_q: Vec<f64>,
    world_from_link: Vec<Pose>,
}

impl ArcCorrection {
    /// For steps of `dt` seconds; the hand stands still until [`ArcCorrection::predict`] says otherwise.
    pub(crate) fn new(
        robot: &RobotModel,
        dt: f64,
        fingers: [RigidBodyHandle; 2],
        object: Option<RigidBodyHandle>,
    ) -> Self {
        Self {
            dt,
            fingers,
            object,
            displacement: RapierPose::IDENTITY,
            point: Vector::ZERO,
            velocity: Vector::ZERO,
            angular_velocity: Vector::ZERO,
            next_q: vec![0.0; robot.dof()],
            world_from_link: vec![Pose::identity(); robot.dof()],
        }
    }

    /// Predicts the step from positions and velocities of the arm's joints.
    pub(crate) fn predict(&mut self, robot: &RobotModel, q: &[f64], qd: &[f64]) {
        robot.forward_into(q, &mut self.world_from_link);
        let world_from_tool = tool::world_from_tool(robot, &self.world_from_link);
        let [vx, vy, vz, wx, wy, wz] = tool::twist(robot, &self.world_from_link, qd);
        for ((next, position), rate) in self.next_q.iter_mut().zip(q).zip(qd) {
            *next = position + rate * self.dt;
        }
        robot.forward_into(&self.next_q, &mut self.world_from_link);
        let world_from_next = tool::world_from_tool(robot, &self.world_from_link);
        self.displacement = convert::to_rapier(&(world_from_next * world_from_tool.inverse()));
        self.point = convert::vector_to_rapier(&world_from_tool.translation.vector);
        self.velocity = Vector::new(vx, vy, vz);
        self.angular_velocity = Vector::new(wx, wy, wz);
    }

    /// Arc less straight line of a point of the hand, over dt, m/s.
    fn of_hand(&self, point: Vector) -> Vector {
        let along_arc = (self.displacement * point - point) / self.dt;
        along_arc - (self.velocity + self.angular_velocity.cross(point - self.point))
    }

    /// The same of a point of the object, whose centre of mass moves along a straight line.
    fn of_object(&self, bodies: &RigidBodySet, object: RigidBodyHandle, point: Vector) -> Vector {
        let body = &bodies[object];
        let (spin, lever) = (body.angvel(), point - body.center_of_mass());
        let turned = Rotation::from_scaled_axis(spin * self.dt) * lever;
        (turned - lever) / self.dt - spin.cross(lever)
    }
}

impl PhysicsHooks for ArcCorrection {
    fn modify_solver_contacts(&self, context: &mut ContactModificationContext<'_>) {
        let (Some(body_1), Some(body_2), Some(object)) =
            (context.rigid_body1, context.rigid_body2, self.object)
        else {
            return;
        };
        // The target is the velocity of the second body at the contact less that of the first.
        let sign = match (body_1, body_2) {
            (finger, other) if other == object && self.fingers.contains(&finger) => 1.0,
            (other, finger) if other == object && self.fingers.contains(&finger) => -1.0,
            _ => return,
        };
        let bodies = context.bodies;
        let Some(manifold) = context.rigid_mut() else { return };
        for contact in manifold.solver_contacts.iter_mut() {
            let point = (contact.anchor1 + contact.anchor2) / 2.0;
            let relative = (self.of_hand(point) - self.of_object(bodies, object, point)) * sign;
            // Rapier also lets the normal part of it act on the depth, which is not meant.
            contact.tangent_velocity = relative.reject_from_normalized(*manifold.normal);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures;

    #[test]
    fn a_turning_hand_falls_behind_its_tangent_by_half_the_centripetal_acceleration() {
        let robot = fixtures::rrr();
        let dt = 1e-4;
        let mut arc = ArcCorrection::new(&robot, dt, [RigidBodyHandle::invalid(); 2], None);
        // Only the first joint turns: every point moves on a circle about the origin.
        let rate = 1.3;
        arc.predict(&robot, &[0.4, 0.7, -0.2], &[rate, 0.0, 0.0]);
        for point in [Vector::new(5.0, 3.0, 0.2), Vector::new(-1.0, 0.5, 0.0)] {
            let inward = Vector::new(point.x, point.y, 0.0) * (-0.5 * rate * rate * dt);
            let off = (arc.of_hand(point) - inward).length();
            assert!(off < 1e-3 * inward.length(), "{off} of {}", inward.length());
        }
    }

    #[test]
    fn a_hand_that_slides_straight_needs_no_correction() {
        let robot = fixtures::scara();
        let mut arc = ArcCorrection::new(&robot, 1e-3, [RigidBodyHandle::invalid(); 2], None);
        arc.predict(&robot, &[0.4, 0.7, -0.2, 0.3], &[0.0, 0.0, 0.8, 0.0]);
        assert!(arc.of_hand(Vector::new(0.4, 0.2, 0.1)).length() < 1e-12);
    }
}
