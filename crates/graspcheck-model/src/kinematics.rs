//! Forward kinematics and the Jacobian of any serial arm.
//!
//! `q` is the vector of joint positions (rad or m), `qd` its rate. Each joint's transform is multiplied to that of
//! the link before it: `world_from_link = world_from_base · Π parent_from_link(qₖ)` (Siciliano et al., *Robotics:
//! Modelling, Planning and Control*, 2.8).
//!
//! ```
//! use graspcheck_model::example;
//!
//! let robot = example::planar(); // 4, 3 and 1 m
//! let q = [0.3, 0.8, -0.5];
//! let tool = robot.world_from_tool(&q);
//! assert!((tool.translation.vector.y - (4.0 * 0.3_f64.sin() + 3.0 * 1.1_f64.sin() + 0.6_f64.sin())).abs() < 1e-14);
//! // The end of link 2 is where the frame of the last link has its origin.
//! assert_eq!(robot.world_from_wrist(&q), robot.forward(&q)[2]);
//! // How fast the tool moves when the shoulder turns by 1 rad/s: perpendicular to its arm.
//! let velocity = robot.tool_jacobian(&q).column(0).clone_owned();
//! assert!((velocity[0] + tool.translation.vector.y).abs() < 1e-14);
//! assert!((velocity[1] - tool.translation.vector.x).abs() < 1e-14);
//! assert_eq!(velocity[5], 1.0);
//! ```

use nalgebra::{Isometry3, Matrix6xX, Translation3, UnitQuaternion, Vector3};

use crate::{
    Pose,
    robot::{Joint, JointKind, RobotModel},
};

impl Joint {
    /// From the frame of the joint at position `q` (rad or m) to the frame of the link before it.
    #[must_use]
    pub fn parent_from_link(&self, q: f64) -> Pose {
        match self.kind {
            JointKind::Revolute => self.parent_from_joint * UnitQuaternion::from_axis_angle(&self.axis, q),
            JointKind::Prismatic => self.parent_from_joint * Translation3::from(self.axis.into_inner() * q),
        }
    }
}

impl RobotModel {
    /// Poses of all moving links in the world at joint positions `q` (rad or m), into a slice that is
    /// there already; allocates nothing.
    ///
    /// # Panics
    /// When `q` or `world_from_link` has another length than the arm has joints.
    pub fn forward_into(&self, q: &[f64], world_from_link: &mut [Pose]) {
        assert_eq!(q.len(), self.dof(), "positions for another number of joints");
        assert_eq!(world_from_link.len(), self.dof(), "poses for another number of links");
        let mut world_from_parent = self.world_from_base;
        for ((joint, &position), pose) in self.joints.iter().zip(q).zip(world_from_link) {
            world_from_parent *= joint.parent_from_link(position);
            *pose = world_from_parent;
        }
    }

    /// Poses of all moving links in the world at joint positions `q` (rad or m), from base to tool.
    ///
    /// # Panics
    /// When `q` has another length than the arm has joints.
    #[must_use]
    pub fn forward(&self, q: &[f64]) -> Vec<Pose> {
        let mut world_from_link = vec![Isometry3::identity(); self.dof()];
        self.forward_into(q, &mut world_from_link);
        world_from_link
    }

    /// Pose of the tool frame in the world at joint positions `q` (rad or m).
    ///
    /// # Panics
    /// When `q` has another length than the arm has joints.
    #[must_use]
    pub fn world_from_tool(&self, q: &[f64]) -> Pose {
        self.world_from_wrist(q) * self.link_from_tool
    }

    /// Pose of the last link's frame in the world at joint positions `q` (rad or m). Its origin lies on the
    /// axis of the last joint: for a planar R-R-R arm this is the wrist, the end of link 2.
    ///
    /// # Panics
    /// When `q` has another length than the arm has joints.
    #[must_use]
    pub fn world_from_wrist(&self, q: &[f64]) -> Pose {
        assert_eq!(q.len(), self.dof(), "positions for another number of joints");
        self.joints.iter().zip(q).fold(self.world_from_base, |world_from_parent, (joint, &position)| {
            world_from_parent * joint.parent_from_link(position)
        })
    }

    /// The geometric Jacobian of the tool at joint positions `q`: `[v; ω] = J qd`, where v is the velocity
    /// of the tool's origin (m/s, rows 0–2) and ω its angular velocity (rad/s, rows 3–5), both in the
    /// world frame. Column k of a revolute joint with axis z through point p is `[z × (p_tool − p); z]`, of
    /// a prismatic one `[z; 0]` (Siciliano et al., *Robotics: Modelling, Planning and Control*, 3.1.3).
    ///
    /// # Panics
    /// When `q` has another length than the arm has joints.
    #[must_use]
    pub fn tool_jacobian(&self, q: &[f64]) -> Matrix6xX<f64> {
        let world_from_link = self.forward(q);
        let last = world_from_link.last().unwrap_or(&self.world_from_base);
        let tool = (last * self.link_from_tool).translation.vector;
        let mut jacobian = Matrix6xX::zeros(self.dof());
        for (k, (joint, pose)) in self.joints.iter().zip(&world_from_link).enumerate() {
            let axis = pose.rotation * joint.axis.into_inner();
            let (linear, angular) = match joint.kind {
                JointKind::Revolute => (axis.cross(&(tool - pose.translation.vector)), axis),
                JointKind::Prismatic => (axis, Vector3::zeros()),
            };
            jacobian.fixed_view_mut::<3, 1>(0, k).copy_from(&linear);
            jacobian.fixed_view_mut::<3, 1>(3, k).copy_from(&angular);
        }
        jacobian
    }
}
