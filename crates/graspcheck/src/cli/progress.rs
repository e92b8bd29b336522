//! Progress on standard error: one past-tense line a stage, and a bar while a long simulation runs.

use std::{
    io::IsTerminal as _,
    time::{Duration, Instant},
};

use anstream::eprintln;
use graspcheck::{
    Observer, Stage,
    report::{DIM, NAME},
};
use graspcheck_proof::ProofOutcome;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Quick things are quiet: no bar before this.
const BAR_AFTER: Duration = Duration::from_millis(300);

/// Prints stages with the wall time that each took.
pub(super) struct Progress {
    since: Instant,
    bar: Option<ProgressBar>,
    animated: bool,
}

impl Progress {
    pub(super) fn new() -> Self {
        let animated = std::io::stderr().is_terminal() && std::env::var_os("CI").is_none();
        Self { since: now(), bar: None, animated }
    }

    /// A line of the past tense with the time since the line before it.
    pub(super) fn line(&mut self, verb: &str, what: &str) {
        let elapsed = self.since.elapsed();
        if let Some(bar) = self.bar.take() {
            bar.finish_and_clear();
        }
        let millis = elapsed.as_secs_f64() * 1e3;
        let decimals = if millis < 10.0 { 1 } else { 0 };
        eprintln!("{NAME}{verb:>12}{NAME:#}  {what:<72} {DIM}{millis:>8.decimals$} ms{DIM:#}");
        self.since = now();
    }
}

#[expect(
    clippy::disallowed_methods,
    reason = "the wall time of a stage is shown to a person and kept nowhere"
)]
fn now() -> Instant {
    Instant::now()
}

impl Observer for Progress {
    fn done(&mut self, stage: Stage) {
        match stage {
            Stage::Planned { phases, pieces, duration } => {
                self.line(
                    "Planned",
                    &format!("{phases} phases, {pieces} polynomial pieces, {duration:.3} s of motion"),
                );
            }
            Stage::Proved { outcome, pairs, leaves, with_the_plan } => {
                let verb = match outcome {
                    ProofOutcome::Free => "Proved",
                    ProofOutcome::Violated => "Refuted",
                    ProofOutcome::Unknown | ProofOutcome::NotChecked => "Undecided",
                };
                let when = if with_the_plan { ", while planning" } else { "" };
                let what = format!("clearance of {pairs} pairs at every instant, {leaves} leaves{when}");
                self.line(verb, &what);
            }
            Stage::Simulated { steps, dt } => {
                let real_time = steps as f64 * dt / self.since.elapsed().as_secs_f64();
                self.line(
                    "Simulated",
                    &format!("{steps} steps of {} ms, {real_time:.0} times real time", dt * 1e3),
                );
            }
            Stage::Judged { checks } => {
                self.line("Judged", &format!("{checks} checks, from the recording alone"));
            }
        }
    }

    fn simulating(&mut self, step: usize, steps: usize) {
        if self.bar.is_none() && self.animated && self.since.elapsed() > BAR_AFTER {
            let style = ProgressStyle::with_template("  Simulating  {pos} of {len} steps  {wide_bar}")
                .unwrap_or_else(|_| ProgressStyle::default_bar());
            let bar = ProgressBar::with_draw_target(Some(steps as u64), ProgressDrawTarget::stderr());
            self.bar = Some(bar.with_style(style));
        }
        if let Some(bar) = &self.bar {
            bar.set_position(step as u64);
        }
    }
}
