//! Phases one after the other.

use graspcheck_model::plan::{Holding, Phase};
use graspcheck_motion::{Trajectory, TrajectoryError};

/// A motion that grows phase by phase.
#[derive(Debug, Default)]
pub(crate) struct Sequence {
    trajectory: Option<Trajectory>,
    phases: Vec<Phase>,
}

impl Sequence {
    /// Adds a phase in which the arm makes `motion`.
    ///
    /// # Errors
    /// When it is a motion of another number of joints.
    pub(crate) fn add(
        &mut self,
        name: &str,
        motion: &Trajectory,
        holding: Holding,
    ) -> Result<(), TrajectoryError> {
        let start = self.end();
        let trajectory = match &self.trajectory {
            Some(so_far) => so_far.then(motion)?,
            None => motion.clone(),
        };
        self.phases.push(Phase { name: name.to_owned(), start, end: trajectory.duration(), holding });
        self.trajectory = Some(trajectory);
        Ok(())
    }

    /// When the motion ends so far, s.
    fn end(&self) -> f64 {
        self.trajectory.as_ref().map_or(0.0, Trajectory::duration)
    }

    /// The whole motion and its phases.
    ///
    /// # Errors
    /// When nothing was added.
    pub(crate) fn finish(self) -> Result<(Trajectory, Vec<Phase>), TrajectoryError> {
        let trajectory = self.trajectory.ok_or(TrajectoryError::TooFewKnots { count: 0 })?;
        Ok((trajectory, self.phases))
    }
}
