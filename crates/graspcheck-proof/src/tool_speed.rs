//! How fast the tool is and how hard it accelerates at most, proved over continuous time for any serial arm.
//!
//! The tool is the origin of its frame, between the pads. Stretches are bounded by
//! [`ToolBounds`] and halved (`peak`), as for torques.

use graspcheck_model::{
    chain::SerialChain,
    plan::Plan,
    robot::RobotModel,
    tool_bounds::{TOOL_SAMPLE, ToolBounds},
};

use crate::{
    peak::{Bound, Bounded, Course, Kept, MOST_STEPS, find_peaks, keep_limits},
    stretch::{cuts, middle},
};

/// Certified bounds of the largest speed or acceleration of the tool in a phase.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ToolPeak {
    /// At `time` it is at least this, m/s or m/s².
    pub lower: f64,
    /// At no instant of the phase is it more.
    pub upper: f64,
    /// When, s.
    pub time: f64,
    /// Whether the bounds are as near to each other as was asked for; if not, the search gave up.
    pub is_settled: bool,
}

/// The largest speed (m/s) and the largest acceleration (m/s²) of the tool in every phase of a plan, between bounds
/// that differ by at most the tolerances.
///
/// # Errors
/// Says in words what does not fit in the plan.
pub fn tool_peaks(
    robot: &RobotModel,
    plan: &Plan,
    tolerances: [f64; 2],
) -> Result<Vec<[ToolPeak; 2]>, String> {
    let chain = SerialChain::of(robot);
    let phases = phases(plan, robot.dof())?;
    let mut tool = Tool { bounds: ToolBounds::new(&chain, &plan.trajectory), pieces: Vec::new() };
    let of_phase = |Stretches { courses, pieces }| {
        tool.pieces = pieces;
        let (peaks, is_settled) = find_peaks(&mut tool, &courses, &tolerances, MOST_STEPS);
        [0, 1].map(|k| {
            let peak = peaks[k];
            ToolPeak { lower: peak.lower, upper: peak.upper, time: peak.time, is_settled }
        })
    };
    Ok(phases.into_iter().map(of_phase).collect())
}

/// Whether the tool keeps a limit of speed (m/s) and one of acceleration (m/s²) at every instant of a plan; none when it
/// comes too near to one to tell. A limit may be infinite.
///
/// # Errors
/// As [`tool_peaks`].
pub fn keeps_tool_limits(robot: &RobotModel, plan: &Plan, limits: [f64; 2]) -> Result<Option<bool>, String> {
    let chain = SerialChain::of(robot);
    let mut all = Stretches::default();
    for phase in phases(plan, robot.dof())? {
        all.courses.extend(phase.courses);
        all.pieces.extend(phase.pieces);
    }
    let Stretches { courses, pieces } = all;
    let mut tool = Tool { bounds: ToolBounds::new(&chain, &plan.trajectory), pieces };
    Ok(match keep_limits(&mut tool, &courses, &limits) {
        Kept::Always => Some(true),
        Kept::Not { .. } => Some(false),
        Kept::Unknown { .. } => None,
    })
}

/// Stretches of time, and the piece of the motion that each is in.
#[derive(Clone, Default)]
struct Stretches {
    courses: Vec<Course>,
    pieces: Vec<usize>,
}

/// The stretches of every phase.
fn phases(plan: &Plan, dof: usize) -> Result<Vec<Stretches>, String> {
    let mut phases = vec![Stretches::default(); plan.phases.len()];
    for ends in cuts(plan, dof)?.windows(2) {
        let [start, end] = [ends[0], ends[1]];
        let phase = &mut phases[plan.phase_index_at(middle(start, end))];
        phase.courses.push(Course { start, end });
        phase.pieces.push(plan.trajectory.piece_at(middle(start, end)));
    }
    Ok(phases)
}

/// Speed and acceleration of the tool as functions of time.
struct Tool<'a> {
    bounds: ToolBounds<'a>,
    /// For each course the piece of the motion.
    pieces: Vec<usize>,
}

impl Bounded for Tool<'_> {
    fn count(&self) -> usize {
        2
    }

    fn sample_size(&self) -> usize {
        TOOL_SAMPLE
    }

    fn sample(&mut self, course: usize, time: f64, sample: &mut [f64]) {
        self.bounds.at(self.pieces[course], time, sample);
    }

    fn bound(&mut self, course: usize, ends: [f64; 2], samples: [&[f64]; 3], bounds: &mut [Bound]) {
        let found = self.bounds.on(self.pieces[course], ends, samples);
        for (k, bound) in bounds.iter_mut().enumerate() {
            *bound = Bound { most: found.most[k], attained: found.attained[k], undecided: 0.0 };
        }
    }
}

#[cfg(test)]
mod tests {
    use graspcheck_model::{example, robot::JointKind};
    use graspcheck_motion::{Polynomial, Trajectory};
    use nalgebra::Vector3;

    use super::*;
    use crate::fixtures::{self, Draw, at};

    /// Largest speed and acceleration of the tool by differences of its poses, at 2 kHz.
    fn sampled(robot: &RobotModel, plan: &Plan) -> [f64; 2] {
        let step = 1e-4;
        let place = |t: f64| robot.world_from_tool(&plan.trajectory.eval(t).q).translation.vector;
        let mut most = [0.0_f64; 2];
        let count = (plan.duration() * 2000.0) as usize;
        for i in 1..count {
            let t = (i as f64 / 2000.0).clamp(step, plan.duration() - step);
            let [before, now, after] = [t - step, t, t + step].map(place);
            most[0] = most[0].max((after - before).norm() / (2.0 * step));
            most[1] = most[1].max((after - now * 2.0 + before).norm() / (step * step));
        }
        most
    }

    #[test]
    fn no_difference_of_poses_is_faster_and_one_nearly_as_fast() {
        let mut draw = Draw(3);
        for robot in [fixtures::scara(), example::planar(), fixtures::six_axes()] {
            for _ in 0..4 {
                let mut ends = || (0..robot.dof()).map(|_| draw.between(-1.2, 1.2)).collect::<Vec<f64>>();
                let plan = fixtures::rest_to_rest(&ends(), &ends(), 1.0);
                let peaks = tool_peaks(&robot, &plan, [1e-6, 1e-5]).unwrap()[0];
                for ((peak, sampled), tolerance) in peaks.iter().zip(sampled(&robot, &plan)).zip([1e-6, 1e-5])
                {
                    assert!(peak.is_settled && peak.upper - peak.lower <= tolerance, "{peak:?}");
                    assert!(sampled <= peak.upper * (1.0 + 1e-5), "{sampled} {peak:?}");
                    assert!(peak.lower <= sampled * (1.0 + 1e-3), "{sampled} {peak:?}");
                }
            }
        }
    }

    #[test]
    fn a_turning_arm_and_a_sliding_one_are_as_fast_as_the_formulas_say() {
        // ω r and ω² r at 0.4 m, then 0.3 m/s along the axis on top: √(ω² r² + 0.3²).
        let robot = fixtures::robot(
            vec![
                fixtures::joint("turn", JointKind::Revolute, at(0.0, 0.0, 0.0), Vector3::z()),
                fixtures::joint("slide", JointKind::Prismatic, at(0.4, 0.0, 0.0), Vector3::z()),
            ],
            vec![fixtures::link("arm", vec![]), fixtures::link("rod", vec![])],
        );
        let mut plan = fixtures::rest_to_rest(&[0.0; 2], &[0.0; 2], 1.0);
        let turn = Polynomial::new([0.0, 2.0]);
        let slide = Polynomial::new([0.0, 0.3]);
        plan.trajectory = Trajectory::new(2, vec![0.0, 1.0], vec![turn, slide]).unwrap();
        let [speed, acceleration] = tool_peaks(&robot, &plan, [1e-9, 1e-9]).unwrap()[0];
        assert!((speed.upper - (0.8_f64 * 0.8 + 0.09).sqrt()).abs() < 1e-8, "{speed:?}");
        assert!((acceleration.upper - 1.6).abs() < 1e-8, "{acceleration:?}");
        let keeps = |limits| keeps_tool_limits(&robot, &plan, limits).unwrap();
        assert_eq!(keeps([speed.upper * 1.000_001, f64::INFINITY]), Some(true));
        assert_eq!(keeps([speed.upper * 0.999_999, f64::INFINITY]), Some(false));
        assert_eq!(keeps([f64::INFINITY, 1.599]), Some(false));
    }

    #[test]
    fn each_phase_has_its_own_peak() {
        let robot = fixtures::scara();
        let fast = fixtures::rest_to_rest(&[0.0; 4], &[1.0, 0.0, 0.0, 0.0], 0.5);
        let slow = fixtures::rest_to_rest(&[1.0, 0.0, 0.0, 0.0], &[1.0, 0.0, 0.1, 0.0], 0.5);
        let mut plan = fixtures::rest_to_rest(&[0.0; 4], &[0.0; 4], 1.0);
        plan.trajectory = fast.trajectory.then(&slow.trajectory).unwrap();
        let mut second = plan.phases[0].clone();
        (plan.phases[0].end, second.start, second.name) = (0.5, 0.5, "down".to_owned());
        plan.phases.push(second);
        let peaks = tool_peaks(&robot, &plan, [1e-6, 1e-5]).unwrap();
        // The peak of a quintic is 15/8 D/T: at 0.6 m, and along the quill.
        assert!((peaks[0][0].upper - 15.0 / 8.0 * 2.0 * 0.6).abs() < 1e-5, "{peaks:?}");
        assert!((peaks[1][0].upper - 15.0 / 8.0 * 0.2).abs() < 1e-5, "{peaks:?}");
        assert!((peaks[1][0].time - 0.75).abs() < 1e-3);
    }
}
