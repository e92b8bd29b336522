//! Motions of the joints through points at given times, exactly: cubic pieces.
//!
//! N points make N - 1 cubics, each from position and velocity at one point to those at the next (see
//! [`imposed::cubic`]). The positions are given; every law in this module is a way to choose the velocities
//! at the points:
//!
//! | law | velocities at the inner points | acceleration there |
//! |---|---|---|
//! | [`imposed`] | given | jumps |
//! | [`computed`] | mean of the slopes beside the point, 0 where these differ in sign | jumps |
//! | [`spline`] | such that the acceleration is continuous | continuous |
//! | [`virtual_points`] | the same, with velocity *and* acceleration given at both ends | continuous |
//!
//! Counting says why the last one needs more than the points: the cubics have 4(N - 1) coefficients.
//! Positions ask 2(N - 1) conditions, continuous velocity and acceleration at the inner points 2(N - 2), which
//! leaves 2 for the ends: two velocities, or two accelerations, but not four. Two more points whose positions
//! are free make the system square.
//!
//! What only has to pass *near* its points, at constant velocity between them, is [`mod@crate::lfpb`].
//!
//! Every law returns a [`Trajectory`](graspcheck_motion::Trajectory) whose time 0 is the time of the first
//! point; its knots are the points, and where the acceleration jumps it declares a break. Whether a motion
//! keeps limits between the points is for the checks to say: a cubic can overshoot its ends.
//!
//! Sources: Biagiotti and Melchiorri, *Trajectory Planning for Automatic Machines and Robots*, chapter 4;
//! Siciliano et al., *Robotics: Modelling, Planning and Control*, section 4.2.2.

pub mod computed;
pub mod imposed;
pub(crate) mod points;
pub mod spline;
pub(crate) mod tridiagonal;
pub mod virtual_points;

pub use points::{ViaError, ViaPoints};
