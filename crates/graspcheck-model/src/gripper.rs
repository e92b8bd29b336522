//! Where the fingers of a gripper stand at an opening.

use nalgebra::Translation3;

use crate::{Pose, robot::Gripper, shape::PlacedShape};

impl Gripper {
    /// From the frame of a finger (0 or 1) to the last link when the pads are `opening` metres apart: each
    /// finger is half of that from the middle.
    ///
    /// ```
    /// let gripper = graspcheck_model::example::planar().gripper;
    /// let [left, right] = [0, 1].map(|finger| gripper.link_from_finger_at(finger, 0.05).translation.vector);
    /// assert!(((left - right).norm() - 0.05).abs() < 1e-15);
    /// ```
    ///
    /// # Panics
    /// When `finger` is neither 0 nor 1.
    #[must_use]
    pub fn link_from_finger_at(&self, finger: usize, opening: f64) -> Pose {
        let finger = &self.fingers[finger];
        finger.link_from_finger * Translation3::from(finger.axis.into_inner() * (0.5 * opening))
    }

    /// The solids of a finger (0 or 1) in the frame of the last link when the pads are `opening` metres
    /// apart: those of the link, moved by [`Gripper::link_from_finger_at`]. Empty for a finger without any.
    ///
    /// # Panics
    /// When `finger` is neither 0 nor 1.
    #[must_use]
    pub fn finger_shapes(&self, finger: usize, opening: f64) -> Vec<PlacedShape> {
        let link_from_finger = self.link_from_finger_at(finger, opening);
        self.fingers[finger]
            .link
            .shapes
            .iter()
            .map(|placed| PlacedShape {
                body_from_shape: link_from_finger * placed.body_from_shape,
                shape: placed.shape.clone(),
            })
            .collect()
    }
}
