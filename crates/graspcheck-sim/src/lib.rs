//! The rapier plant, its controllers and the grasp.
