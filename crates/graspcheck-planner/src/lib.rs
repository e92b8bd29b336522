//! Paths, time scalings, via points and the grasp planner.
