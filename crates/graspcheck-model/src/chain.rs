//! Kinematics of any serial arm as a product of transforms: the second way to every number of the closed forms.
//!
//! [`SerialChain`] knows nothing of families of arms. It multiplies the transforms of a URDF's joints one after
//! the other, `world_from_tool = world_from_base · Π parent_from_link(qₖ) · link_from_tool`, with rotation
//! matrices where [`RobotModel::forward_into`] uses quaternions, and with any [`Scalar`]: floats give poses,
//! intervals give bounds on where the tool can be over a box of joint positions, dual numbers its velocity.
//!
//! ```
//! use graspcheck_motion::Interval;
//! use graspcheck_model::{chain::SerialChain, example};
//!
//! let chain = SerialChain::of(&example::planar()); // links of 4, 3 and 1 m
//! let tool = chain.tool(&[0.3, -0.8, 0.5]);
//! let x = 4.0 * 0.3_f64.cos() + 3.0 * (-0.5_f64).cos() + 1.0;
//! assert!((tool.origin.0[0] - x).abs() < 1e-14);
//!
//! let around = |x: f64| Interval::between(x - 0.01, x + 0.01);
//! let tools = chain.tool(&[0.3, -0.8, 0.5].map(around));
//! assert!(tools.origin.0[0].contains(x) && tools.origin.0[0].width() < 0.3);
//! ```

use graspcheck_motion::Scalar;
use nalgebra::{Matrix6xX, Vector3, Vector6};

use crate::{
    hinge::Hinge,
    robot::{JointKind, RobotModel},
    spatial::{Frame, Vector},
};

/// The joints of an arm as constants, ready for products.
#[derive(Clone, Debug)]
pub struct SerialChain {
    world_from_base: Frame<f64>,
    hinges: Vec<Hinge>,
    link_from_tool: Frame<f64>,
}

/// Velocity of a body for a unit velocity of one joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Twist<S> {
    /// Of the tool's origin, m/s per rad/s or m/s.
    pub linear: Vector<S>,
    /// Angular, rad/s per rad/s or m/s.
    pub angular: Vector<S>,
}

impl SerialChain {
    /// The chain of an arm; its structure does not matter.
    #[must_use]
    pub fn of(robot: &RobotModel) -> Self {
        Self {
            world_from_base: Frame::constant(&robot.world_from_base),
            hinges: robot.joints.iter().map(Hinge::new).collect(),
            link_from_tool: Frame::constant(&robot.link_from_tool),
        }
    }

    /// The number of joints.
    #[must_use]
    pub fn dof(&self) -> usize {
        self.hinges.len()
    }

    /// The joints, from base to tool.
    pub(crate) fn hinges(&self) -> &[Hinge] {
        &self.hinges
    }

    /// The tool's origin in the frame of the last link, m.
    pub(crate) fn tool_in_last_link(&self) -> Vector3<f64> {
        self.link_from_tool.origin.to_vector3()
    }

    /// Frames of all moving links in the world at joint positions `q` (rad or m), from base to tool, into a slice
    /// that is there already; allocates nothing.
    ///
    /// # Panics
    /// When `q` or `world_from_link` has another length than the arm has joints.
    pub fn links_into<S: Scalar>(&self, q: &[S], world_from_link: &mut [Frame<S>]) {
        assert_eq!(q.len(), self.dof(), "positions for another number of joints");
        assert_eq!(world_from_link.len(), self.dof(), "frames for another number of links");
        let mut world_from_parent = self.world_from_base.lifted();
        for ((hinge, &position), frame) in self.hinges.iter().zip(q).zip(world_from_link) {
            world_from_parent = world_from_parent.then(&hinge.parent_from_link(position));
            *frame = world_from_parent;
        }
    }

    /// Frame of the tool in the world at joint positions `q` (rad or m); allocates nothing.
    ///
    /// # Panics
    /// When `q` has another length than the arm has joints.
    #[must_use]
    pub fn tool<S: Scalar>(&self, q: &[S]) -> Frame<S> {
        assert_eq!(q.len(), self.dof(), "positions for another number of joints");
        let base = self.world_from_base.lifted();
        let last = self.hinges.iter().zip(q).fold(base, |world_from_parent, (hinge, &position)| {
            world_from_parent.then(&hinge.parent_from_link(position))
        });
        last.then(&self.link_from_tool.lifted())
    }

    /// The geometric Jacobian of the tool, a column a joint, into a slice that is there already: the tool's origin
    /// moves with Σ linear·qd, the tool turns with Σ angular·qd, both in the world frame. A revolute joint with
    /// axis z through point p gives `[z × (p_tool − p); z]`, a prismatic one `[z; 0]` (Siciliano et al., *Robotics:
    /// Modelling, Planning and Control*, 3.1.3). Allocates nothing.
    ///
    /// # Panics
    /// When `q` or `columns` has another length than the arm has joints.
    pub fn jacobian_into<S: Scalar>(&self, q: &[S], columns: &mut [Twist<S>]) {
        assert_eq!(columns.len(), self.dof(), "columns for another number of joints");
        let tool = self.tool(q).origin;
        let mut world_from_parent = self.world_from_base.lifted();
        for ((hinge, &position), column) in self.hinges.iter().zip(q).zip(columns) {
            let world_from_link: Frame<S> = world_from_parent.then(&hinge.parent_from_link(position));
            let axis = world_from_link.rotation.turn(Vector::constant(&hinge.axis));
            *column = match hinge.kind {
                JointKind::Revolute => {
                    Twist { linear: axis.cross(tool - world_from_link.origin), angular: axis }
                }
                JointKind::Prismatic => Twist { linear: axis, angular: Vector::zero() },
            };
            world_from_parent = world_from_link;
        }
    }

    /// The geometric Jacobian as a matrix: rows 0–2 linear, rows 3–5 angular; see [`SerialChain::jacobian_into`].
    ///
    /// # Panics
    /// When `q` has another length than the arm has joints.
    #[must_use]
    pub fn jacobian(&self, q: &[f64]) -> Matrix6xX<f64> {
        let zero = Twist { linear: Vector::zero(), angular: Vector::zero() };
        let mut columns = vec![zero; self.dof()];
        self.jacobian_into(q, &mut columns);
        let columns: Vec<Vector6<f64>> = columns
            .iter()
            .map(|Twist { linear: Vector([x, y, z]), angular: Vector([a, b, c]) }| {
                Vector6::new(*x, *y, *z, *a, *b, *c)
            })
            .collect();
        // From columns alone nalgebra cannot tell that there are six rows when there is no joint.
        if columns.is_empty() { Matrix6xX::zeros(0) } else { Matrix6xX::from_columns(&columns) }
    }
}
