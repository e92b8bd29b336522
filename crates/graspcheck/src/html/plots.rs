//! Which plots a report has, and what is drawn in them.

use graspcheck_model::robot::{Joint, JointKind};
use graspcheck_recording::{JointSeries, MonitorSample};
use graspcheck_verify::{CheckResult, Evidence, Outcome, Verdict};

use super::{
    columns::{of_motion, of_samples},
    plot::{Curve, Plot, number},
};
use crate::report::word;

/// What is drawn over time for a joint: a column of the grid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Quantity {
    /// 0 position, 1 velocity, 2 acceleration, 3 jerk.
    Derivative(usize),
    Effort,
    Tracking,
}

impl Quantity {
    pub(super) const ALL: [Self; 6] = [
        Self::Derivative(0),
        Self::Derivative(1),
        Self::Derivative(2),
        Self::Derivative(3),
        Self::Effort,
        Self::Tracking,
    ];

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Derivative(0) => "position",
            Self::Derivative(1) => "velocity",
            Self::Derivative(2) => "acceleration",
            Self::Derivative(_) => "jerk",
            Self::Effort => "torque",
            Self::Tracking => "tracking error",
        }
    }

    /// Unit for people, and the factor from SI to it.
    fn unit(self, kind: JointKind) -> (String, f64) {
        let (length, factor) = match kind {
            JointKind::Revolute => ("°", 180.0 / std::f64::consts::PI),
            JointKind::Prismatic => ("mm", 1e3),
        };
        match (self, kind) {
            (Self::Derivative(order), _) => {
                (format!("{length}{}", ["", "/s", "/s²", "/s³"][order.min(3)]), factor)
            }
            (Self::Tracking, _) => (length.to_owned(), factor),
            (Self::Effort, JointKind::Revolute) => ("N·m".to_owned(), 1.0),
            (Self::Effort, JointKind::Prismatic) => ("N".to_owned(), 1.0),
        }
    }

    /// Lower and upper limit, SI; none where the robot has none.
    fn limits(self, joint: &Joint) -> Vec<f64> {
        let limits = &joint.limits;
        match self {
            Self::Derivative(0) => vec![limits.position_min, limits.position_max],
            Self::Derivative(1) => vec![-limits.velocity, limits.velocity],
            Self::Derivative(2) => vec![-limits.acceleration, limits.acceleration],
            Self::Derivative(_) => vec![-limits.jerk, limits.jerk],
            Self::Effort => vec![-limits.effort, limits.effort],
            Self::Tracking => Vec::new(),
        }
    }

    /// The quantity that a check of a joint judges.
    fn of_check(word: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|quantity| quantity.name() == word)
    }
}

/// A scalar of the monitor, as it is drawn.
struct Monitored<'m> {
    title: &'m str,
    /// The word of the check that judges it.
    check: &'m str,
    /// In the unit of the title.
    value: &'m dyn Fn(&MonitorSample) -> Option<f64>,
    limits: Vec<f64>,
}

/// What all plots of a report share.
pub(super) struct Plots<'a> {
    pub(super) evidence: &'a Evidence<'a>,
    pub(super) verdict: &'a Verdict,
}

impl<'a> Plots<'a> {
    /// From the beginning to the end of plan and execution, s.
    pub(super) fn whole(&self) -> [f64; 2] {
        let recorded = self.evidence.recording.measured.time_ns.last().map_or(0.0, |ns| seconds(*ns));
        [0.0, self.evidence.plan.duration().max(recorded)]
    }

    /// A quantity of a joint; `None` when nothing of it was planned or recorded.
    pub(super) fn of_joint(
        &self,
        index: usize,
        quantity: Quantity,
        time: [f64; 2],
        size: [f64; 2],
    ) -> Option<Plot<'a>> {
        let evidence = self.evidence;
        let joint = &evidence.joints()[index];
        let (unit, factor) = quantity.unit(joint.kind);
        let columns = columns(size);
        let scaled = |points: Vec<[f64; 2]>| points.into_iter().map(|[t, v]| [t, factor * v]).collect();
        let class = |what: &str| format!("{what} joint{}", index % 4);
        let recording = evidence.recording;
        let row = |series: &'a JointSeries| series.names.iter().position(|name| *name == joint.name);
        let samples = |values: &'a [f64], row: usize| {
            let series = &recording.measured;
            let value = move |k: usize| values.get(k * series.names.len() + row).copied().unwrap_or(f64::NAN);
            of_samples(
                series.time_ns.iter().enumerate().map(|(k, ns)| (seconds(*ns), value(k))),
                time,
                columns,
            )
        };
        let mut curves = Vec::new();
        if let Quantity::Derivative(order) = quantity {
            let planned = of_motion(&evidence.plan.trajectory, [index, order], time, columns);
            curves.push(Curve { class: class("planned"), points: scaled(planned) });
        }
        let measured = match (quantity, row(&recording.measured), row(&recording.reference)) {
            (Quantity::Derivative(0), Some(row), _) => samples(&recording.measured.position, row),
            (Quantity::Derivative(1), Some(row), _) => samples(&recording.measured.velocity, row),
            (Quantity::Effort, Some(row), _) => samples(&recording.measured.effort, row),
            (Quantity::Tracking, Some(row), Some(reference)) => {
                let (measured, commanded) = (&recording.measured, &recording.reference);
                let error = |k: usize| {
                    let at = |series: &JointSeries, row: usize| {
                        series.position.get(k * series.names.len() + row).copied().unwrap_or(f64::NAN)
                    };
                    at(measured, row) - at(commanded, reference)
                };
                of_samples(
                    measured.time_ns.iter().enumerate().map(|(k, ns)| (seconds(*ns), error(k))),
                    time,
                    columns,
                )
            }
            _ => Vec::new(),
        };
        if !measured.is_empty() {
            let look = if curves.is_empty() { "planned" } else { "executed" };
            curves.push(Curve { class: class(look), points: scaled(measured) });
        }
        if curves.is_empty() {
            return None;
        }
        let limits: Vec<f64> = quantity.limits(joint).into_iter().map(|limit| factor * limit).collect();
        let violated = self.violated(|result| {
            Quantity::of_check(&word(&result.check)) == Some(quantity)
                && result.place.subjects == [joint.name.clone()]
        });
        let title = format!("{} {} [{unit}]", joint.name, quantity.name());
        let description = describe(&title, &curves, &limits, violated.len());
        Some(Plot {
            title,
            description,
            time,
            size,
            phases: &evidence.plan.phases,
            names_phases: false,
            curves,
            limits,
            violated,
        })
    }

    /// For velocity, acceleration, jerk and torque how much of its limit the worst joint uses, %.
    pub(super) fn shares(&self, time: [f64; 2], size: [f64; 2]) -> Plot<'a> {
        let evidence = self.evidence;
        let columns = columns(size);
        let mut curves = Vec::new();
        for (order, class) in [(1, "joint0"), (2, "joint2"), (3, "joint3")] {
            curves
                .push(Curve { class: format!("planned {class}"), points: self.share(order, time, columns) });
        }
        let torque = |sample: &MonitorSample| Some(100.0 * sample.torque_ratio);
        let torque = self.monitored(&torque, time, columns);
        if !torque.is_empty() {
            curves.push(Curve { class: "planned joint1".to_owned(), points: torque });
        }
        let violated = self.violated(|result| {
            let quantity = Quantity::of_check(&word(&result.check));
            matches!(quantity, Some(Quantity::Derivative(1..) | Quantity::Effort))
        });
        let title = "share of the limit, worst joint [%]".to_owned();
        Plot {
            description: describe(&title, &curves, &[100.0], violated.len()),
            title,
            time,
            size,
            phases: &evidence.plan.phases,
            names_phases: true,
            curves,
            limits: vec![100.0],
            violated,
        }
    }

    /// The largest |derivative| / limit over the joints, %.
    fn share(&self, order: usize, time: [f64; 2], columns: usize) -> Vec<[f64; 2]> {
        let mut worst: Vec<[f64; 2]> = Vec::new();
        for (index, joint) in self.evidence.joints().iter().enumerate() {
            let limit = Quantity::Derivative(order).limits(joint)[1];
            let points = of_motion(&self.evidence.plan.trajectory, [index, order], time, columns);
            // Two points a column: the larger magnitude of both stands for it.
            let shares = points.chunks(2).map(|ends| {
                let at = ends.iter().max_by(|a, b| a[1].abs().total_cmp(&b[1].abs()));
                at.map_or([0.0; 2], |[t, value]| [*t, 100.0 * value.abs() / limit])
            });
            if worst.is_empty() {
                worst = shares.collect();
                continue;
            }
            for (most, share) in worst.iter_mut().zip(shares) {
                if share[1] > most[1] {
                    *most = share;
                }
            }
        }
        worst
    }

    /// How much room the nearest pair has beyond its required clearance, mm, up to ten times the least
    /// requirement that was judged; none when it was not recorded.
    pub(super) fn clearance(&self, time: [f64; 2], size: [f64; 2]) -> Option<Plot<'a>> {
        let monitor = &self.evidence.recording.monitor;
        let least =
            monitor.iter().filter_map(|sample| sample.clearance_margin_m).fold(f64::INFINITY, f64::min);
        let limit = self.verdict.checks.iter().find(|it| it.check == "planned.clearance")?.limit;
        let most = (10.0 * limit.unwrap_or(0.0).abs()).max(2.0 * least).max(0.02);
        self.of_monitor(
            &Monitored {
                title: "room beyond the required clearance, nearest pair [mm]",
                check: "clearance",
                value: &|sample| sample.clearance_margin_m.map(|margin| 1e3 * margin.min(most)),
                limits: vec![0.0],
            },
            time,
            size,
        )
    }

    /// A scalar of the monitor with its limit; none when it was not recorded.
    fn of_monitor(&self, monitored: &Monitored, time: [f64; 2], size: [f64; 2]) -> Option<Plot<'a>> {
        let points = self.monitored(monitored.value, time, columns(size));
        if points.is_empty() {
            return None;
        }
        let curves = vec![Curve { class: "planned joint0".to_owned(), points }];
        let violated = self.violated(|result| word(&result.check) == monitored.check);
        Some(Plot {
            description: describe(monitored.title, &curves, &monitored.limits, violated.len()),
            title: monitored.title.to_owned(),
            time,
            size,
            phases: &self.evidence.plan.phases,
            names_phases: true,
            curves,
            limits: monitored.limits.clone(),
            violated,
        })
    }

    /// The plot that shows what a check judges, around the time at which it is worst.
    pub(super) fn of_check(&self, result: &CheckResult, size: [f64; 2]) -> Option<Plot<'a>> {
        let time = self.around(result);
        let quantity = word(&result.check);
        let mut plot = match (Quantity::of_check(&quantity), result.place.subjects.as_slice()) {
            (Some(quantity), [name]) => {
                let joint = self.evidence.joints().iter().position(|joint| joint.name == *name)?;
                self.of_joint(joint, quantity, time, size)?
            }
            _ if quantity == "clearance" => self.clearance(time, size)?,
            _ => {
                let limits = |factor: f64| result.limit.map(|limit| factor * limit).into_iter().collect();
                let monitored = match result.check.as_str() {
                    "executed.tracking" => Monitored {
                        title: "distance of the tool from where it is commanded [mm]",
                        check: "tracking",
                        value: &|sample| Some(1e3 * sample.tool_error_m),
                        limits: limits(1e3),
                    },
                    "executed.grip" => Monitored {
                        title: "smaller force of both fingers on the object [N]",
                        check: "grip",
                        value: &|sample| Some(sample.grip_force_n),
                        limits: limits(1.0),
                    },
                    "executed.opening" => Monitored {
                        title: "distance between the pads [mm]",
                        check: "opening",
                        value: &|sample| Some(1e3 * sample.opening_m),
                        limits: Vec::new(),
                    },
                    "executed.saturation" => Monitored {
                        title: "joints whose command was limited",
                        check: "saturation",
                        value: &|sample| Some(f64::from(sample.saturated_joints)),
                        limits: Vec::new(),
                    },
                    _ => return None,
                };
                self.of_monitor(&monitored, time, size)?
            }
        };
        plot.names_phases = true;
        Some(plot)
    }

    /// A tenth of the run on both sides of a finding, or four times its length where that is more.
    fn around(&self, result: &CheckResult) -> [f64; 2] {
        let [start, end] = self.whole();
        let Some([first, last]) = result.violated.or_else(|| result.time.map(|t| [t, t])) else {
            return [start, end];
        };
        let room = (0.1 * (end - start)).max(4.0 * (last - first));
        [(first - room).max(start), (last + room).min(end)]
    }

    fn monitored(
        &self,
        value: &dyn Fn(&MonitorSample) -> Option<f64>,
        time: [f64; 2],
        columns: usize,
    ) -> Vec<[f64; 2]> {
        let monitor = self.evidence.recording.monitor.iter();
        let samples = monitor.filter_map(|sample| Some((seconds(sample.time_ns), value(sample)?)));
        of_samples(samples, time, columns)
    }

    fn violated(&self, is_shown: impl Fn(&CheckResult) -> bool) -> Vec<[f64; 2]> {
        let failed = self.verdict.checks.iter().filter(|result| result.outcome == Outcome::Fail);
        failed
            .filter(|result| is_shown(result))
            .filter_map(|result| result.violated.or_else(|| result.time.map(|t| [t, t])))
            .collect()
    }
}

pub(super) fn seconds(ns: i64) -> f64 {
    ns as f64 * 1e-9
}

/// Two columns for three pixels: more would not be seen.
fn columns(size: [f64; 2]) -> usize {
    (size[0] / 1.5).ceil() as usize
}

/// What a plot shows in one sentence.
fn describe(title: &str, curves: &[Curve], limits: &[f64], violations: usize) -> String {
    let points = curves.iter().flat_map(|curve| &curve.points).filter(|point| point[1].is_finite());
    let Some(most) = points.max_by(|a, b| a[1].abs().total_cmp(&b[1].abs())) else {
        return format!("{title}: no data");
    };
    let mut text = format!("{title}: largest {} at {} s", number(most[1]), number(most[0]));
    if let Some(limit) = limits.iter().copied().reduce(f64::max) {
        text.push_str(&format!(", limit {}", number(limit)));
    }
    match violations {
        0 => text,
        1 => format!("{text}, violated once"),
        n => format!("{text}, violated {n} times"),
    }
}
