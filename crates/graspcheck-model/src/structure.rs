//! Which closed-form kinematics fits an arm: measured on the arm at its zero position.
//!
//! Both families are a two-link arm in the plane of the base's x and y, followed by a joint that turns the
//! tool about the base's z. With the plane read as complex numbers (1 along x, i along y):
//!
//! ```text
//! wrist = p₁ + upper·exp(i φ₁) + fore·exp(i (φ₁ + φ₂)),   φ₁ = q₁ + shoulder_zero,  φ₂ = q₂ + elbow_zero
//! tool  = wrist + exp(i ψ)·tool_offset,                   ψ = q₁ + q₂ + q_last
//! ```
//!
//! ψ is the *turn of the tool*: the rotation about the base's z that takes the tool from where it points
//! at the zero position to where it points now. The quill of a SCARA adds its position to the tool's
//! height; a planar arm keeps the height.
//!
//! ```
//! use graspcheck_model::{example, robot::Family, structure::PlanarGeometry};
//! let geometry = PlanarGeometry::of(&example::scara())?;
//! assert!(matches!(geometry.family(), Family::Scara { upper, fore } if (upper - 0.25).abs() + (fore - 0.2).abs() < 1e-15));
//! // An arm that does not fit says why.
//! let mut leaning = example::scara();
//! leaning.joints[1].axis = nalgebra::Unit::new_normalize(nalgebra::Vector3::new(0.0, 0.1, 1.0));
//! let why = PlanarGeometry::of(&leaning).expect_err("no closed form");
//! assert_eq!(why, "the axis of joint elbow leans 9.967e-2 rad from the base's z");
//! # Ok::<(), String>(())
//! ```

use nalgebra::{Matrix6xX, Point2, Point3, Rotation2, UnitQuaternion, Vector2, Vector3, Vector6};

use crate::{
    Pose,
    robot::{Family, JointKind, RobotModel},
};

/// How far an axis may lean from the base's z, rad, or a shared axis be off, and the arm still counts as
/// planar: closed-form solutions are then exact to this angle times the arm's reach. Products of exact
/// rotations are off by 1e-15, an angle written with five digits by 1e-6.
const AXIS_TOLERANCE: f64 = 1e-9;

/// The numbers in which all arms with closed-form kinematics differ.
#[derive(Clone, Debug, PartialEq)]
pub struct PlanarGeometry {
    /// Axis 1 in the base's x-y plane, m.
    pub shoulder: Point2<f64>,
    /// From axis 1 to axis 2, m.
    pub upper: f64,
    /// From axis 2 to the wrist, which is the last axis, m.
    pub fore: f64,
    /// Direction of the upper arm at q₁ = 0 against the base's x, rad.
    pub shoulder_zero: f64,
    /// Angle from the upper arm to the forearm at q₂ = 0, rad.
    pub elbow_zero: f64,
    /// From the wrist to the tool's origin at the zero position, in the base's x-y plane, m.
    pub tool_offset: Vector2<f64>,
    /// Height of the tool's origin at the zero position over the base, m.
    pub tool_height: f64,
    /// From the tool frame to the base at the zero position, rotation only.
    pub base_from_tool_zero: UnitQuaternion<f64>,
    /// Index of the quill, if the arm is a SCARA.
    pub quill: Option<usize>,
}

impl PlanarGeometry {
    /// The geometry of an arm, or a lower-case sentence that says why no closed form fits it.
    ///
    /// # Errors
    /// When the joints are neither R-R-P-R nor R-R-R, an axis is not along the base's +z, or two axes
    /// that span a link coincide.
    pub fn of(robot: &RobotModel) -> Result<Self, String> {
        use JointKind::{Prismatic, Revolute};
        let kinds: Vec<JointKind> = robot.joints.iter().map(|joint| joint.kind).collect();
        let quill = match kinds[..] {
            [Revolute, Revolute, Prismatic, Revolute] => Some(2),
            [Revolute, Revolute, Revolute] => None,
            _ => return Err("its joints are neither R-R-P-R nor R-R-R".to_owned()),
        };
        let base_from_link = zero_poses(robot);
        for (joint, pose) in robot.joints.iter().zip(&base_from_link) {
            let lean = (pose.rotation * joint.axis.into_inner()).cross(&Vector3::z());
            let upright = (pose.rotation * joint.axis.into_inner()).z > 0.0;
            if !upright || lean.norm() > AXIS_TOLERANCE {
                let angle = (pose.rotation * joint.axis.into_inner()).angle(&Vector3::z());
                return Err(format!(
                    "the axis of joint {} leans {angle:.3e} rad from the base's z",
                    joint.name
                ));
            }
        }
        let last = base_from_link[base_from_link.len() - 1];
        let shoulder = base_from_link[0].translation.vector.xy();
        let elbow = base_from_link[1].translation.vector.xy();
        let wrist = last.translation.vector.xy();
        let base_from_tool = last * robot.link_from_tool;
        let (upper, fore) = (elbow - shoulder, wrist - elbow);
        for (length, name) in [(upper.norm(), "1 and 2"), (fore.norm(), "2 and the last")] {
            if length <= AXIS_TOLERANCE {
                return Err(format!("axes {name} are {length:.3e} m apart and span no link"));
            }
        }
        Ok(Self {
            shoulder: shoulder.into(),
            upper: upper.norm(),
            fore: fore.norm(),
            shoulder_zero: upper.y.atan2(upper.x),
            elbow_zero: upper.perp(&fore).atan2(upper.dot(&fore)),
            tool_offset: base_from_tool.translation.vector.xy() - wrist,
            tool_height: base_from_tool.translation.z,
            base_from_tool_zero: base_from_tool.rotation,
            quill,
        })
    }

    /// The family with its lengths.
    #[must_use]
    pub fn family(&self) -> Family {
        let (upper, fore) = (self.upper, self.fore);
        match self.quill {
            Some(_) => Family::Scara { upper, fore },
            None => Family::PlanarRrr { upper, fore, hand: self.tool_offset.norm() },
        }
    }

    /// From the tool to the base at joint positions `q`, by the closed form at the head of this module.
    ///
    /// # Panics
    /// When `q` has another length than the arm has joints: four with a quill, else three.
    ///
    /// ```
    /// use graspcheck_model::{example, structure::PlanarGeometry};
    /// let (robot, q) = (example::scara(), [0.4, -0.9, -0.1, 2.0]);
    /// let closed = PlanarGeometry::of(&robot)?.forward(&q);
    /// assert!((closed.to_homogeneous() - robot.world_from_tool(&q).to_homogeneous()).amax() < 1e-14);
    /// # Ok::<(), String>(())
    /// ```
    #[must_use]
    pub fn forward(&self, q: &[f64]) -> Pose {
        let [upper, fore, _] = self.links(q);
        self.base_from_tool(
            self.shoulder + upper + fore,
            self.turn(q),
            self.quill.map_or(0.0, |quill| q[quill]),
        )
    }

    /// The geometric Jacobian of the tool in the base frame at joint positions `q`, by the closed form: with i the
    /// quarter turn about z, joint 1 moves the tool's origin by i (upper + fore + offset), joint 2 by i (fore +
    /// offset), the last by i offset, and all three turn it about z; a quill moves it along z. Rows as in
    /// [`RobotModel::tool_jacobian`].
    ///
    /// # Panics
    /// When `q` has another length than the arm has joints.
    ///
    /// ```
    /// use graspcheck_model::{example, structure::PlanarGeometry};
    /// let (robot, q) = (example::planar(), [0.4, -0.9, 2.0]);
    /// let closed = PlanarGeometry::of(&robot)?.jacobian(&q);
    /// assert!((closed - robot.tool_jacobian(&q)).amax() < 1e-14);
    /// # Ok::<(), String>(())
    /// ```
    #[must_use]
    pub fn jacobian(&self, q: &[f64]) -> Matrix6xX<f64> {
        let [upper, fore, offset] = self.links(q);
        let mut jacobian = Matrix6xX::zeros(q.len());
        for (joint, arm) in [(0, upper + fore + offset), (1, fore + offset), (q.len() - 1, offset)] {
            jacobian.set_column(joint, &Vector6::new(-arm.y, arm.x, 0.0, 0.0, 0.0, 1.0));
        }
        if let Some(quill) = self.quill {
            jacobian[(2, quill)] = 1.0;
        }
        jacobian
    }

    /// The upper arm, the forearm and the tool's offset from the wrist, in the base's x-y plane, m.
    fn links(&self, q: &[f64]) -> [Vector2<f64>; 3] {
        assert_eq!(
            q.len(),
            if self.quill.is_some() { 4 } else { 3 },
            "positions for another number of joints"
        );
        let along = |angle: f64, length: f64| Vector2::new(angle.cos(), angle.sin()) * length;
        let upper = q[0] + self.shoulder_zero;
        [
            along(upper, self.upper),
            along(upper + q[1] + self.elbow_zero, self.fore),
            Rotation2::new(self.turn(q)) * self.tool_offset,
        ]
    }

    /// ψ, the turn of the tool, rad.
    fn turn(&self, q: &[f64]) -> f64 {
        q[0] + q[1] + q[q.len() - 1]
    }

    /// From the tool to the base when the wrist is at `wrist` (base's x-y plane, m) and the tool is turned
    /// by `turn` (ψ, rad) and raised by `rise` (m) from the zero position.
    #[must_use]
    pub fn base_from_tool(&self, wrist: Point2<f64>, turn: f64, rise: f64) -> Pose {
        let rotation = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), turn);
        let tool = wrist + Rotation2::new(turn) * self.tool_offset;
        Pose::from_parts(
            Point3::new(tool.x, tool.y, self.tool_height + rise).into(),
            rotation * self.base_from_tool_zero,
        )
    }

    /// Angle of the tool's x axis against the base's x at the zero position, rad; 0 when the tool's x axis
    /// is vertical.
    #[must_use]
    pub fn tool_angle_zero(&self) -> f64 {
        let out = self.base_from_tool_zero * Vector3::x();
        if out.xy().norm() <= AXIS_TOLERANCE { 0.0 } else { out.y.atan2(out.x) }
    }
}

/// Poses of the links in the base frame when all joints are at 0.
fn zero_poses(robot: &RobotModel) -> Vec<Pose> {
    robot
        .joints
        .iter()
        .scan(Pose::identity(), |base_from_link, joint| {
            *base_from_link *= joint.parent_from_joint;
            Some(*base_from_link)
        })
        .collect()
}
