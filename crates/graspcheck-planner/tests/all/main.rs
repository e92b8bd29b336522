//! All integration tests of the planner in one program: one link instead of eleven.

mod joint_segments;
mod joint_via;
mod lfpb_laws;
mod lines;
mod path_splines;
mod paths;
mod pick_and_place;
#[path = "../robots/mod.rs"]
mod robots;
mod ruckig;
mod scipy_splines;
mod time_laws;
mod via_laws;
mod via_points;
