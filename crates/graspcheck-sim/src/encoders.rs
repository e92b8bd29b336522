//! What the controller believes of the joints: readings with a step, noise and a wrong zero.

use graspcheck_model::execution::Execution;

use crate::random::{Random, Stream};

/// The encoders of the arm's joints, with their last readings.
pub(crate) struct Encoders {
    step: Vec<f64>,
    noise: Vec<f64>,
    offset: Vec<f64>,
    /// Time between two readings, s.
    period: f64,
    random: Random,
    q: Vec<f64>,
    qd: Vec<f64>,
    has_read: bool,
}

impl Encoders {
    /// The encoders of `dof` joints, which are read at each command.
    pub(crate) fn new(execution: &Execution, dof: usize) -> Self {
        let imperfections = &execution.imperfections;
        Self {
            step: of_each(&imperfections.encoder_step, dof),
            noise: of_each(&imperfections.encoder_noise, dof),
            offset: of_each(&imperfections.calibration, dof),
            period: execution.command_period(),
            random: Random::new(execution.seed, Stream::Encoders),
            q: vec![0.0; dof],
            qd: vec![0.0; dof],
            has_read: false,
        }
    }

    /// What a reading is beyond the true position of each joint, but for step and noise, rad or m.
    pub(crate) fn offset(&self) -> &[f64] {
        &self.offset
    }

    /// Reads the joints at their true positions and velocities.
    pub(crate) fn read(&mut self, q: &[f64], qd: &[f64]) {
        for joint in 0..self.q.len() {
            let (step, noise) = (self.step[joint], self.noise[joint]);
            let mut reading = q[joint] + self.offset[joint];
            if noise > 0.0 {
                reading += noise * self.random.normal();
            }
            if step > 0.0 {
                reading = (reading / step).round() * step;
            }
            let is_fine = step == 0.0 && noise == 0.0;
            let rate = (reading - self.q[joint]) / self.period;
            self.qd[joint] = if is_fine || !self.has_read { qd[joint] } else { rate };
            self.q[joint] = reading;
        }
        self.has_read = true;
    }

    /// Positions as read, rad or m.
    pub(crate) fn q(&self) -> &[f64] {
        &self.q
    }

    /// Velocities as measured, rad/s or m/s.
    pub(crate) fn qd(&self) -> &[f64] {
        &self.qd
    }
}

/// A value for each joint; empty stands for zeros.
fn of_each(values: &[f64], dof: usize) -> Vec<f64> {
    if values.is_empty() { vec![0.0; dof] } else { values.to_vec() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures;

    #[test]
    fn readings_have_steps_noise_and_an_offset() {
        let mut execution = fixtures::execution();
        let mut perfect = Encoders::new(&execution, 1);
        perfect.read(&[0.123_456], &[0.7]);
        assert_eq!((perfect.q(), perfect.qd()), (&[0.123_456][..], &[0.7][..]));

        execution.imperfections.calibration = vec![0.5];
        execution.imperfections.encoder_step = vec![0.01];
        let mut coarse = Encoders::new(&execution, 1);
        coarse.read(&[0.1234], &[0.7]);
        assert!((coarse.q()[0] - 0.62).abs() < 1e-15 && coarse.qd() == [0.7]);
        // Two steps on within a millisecond.
        coarse.read(&[0.1434], &[0.7]);
        assert!((coarse.q()[0] - 0.64).abs() < 1e-15 && (coarse.qd()[0] - 20.0).abs() < 1e-9);

        execution.imperfections.encoder_step.clear();
        execution.imperfections.encoder_noise = vec![1e-3];
        let mut noisy = Encoders::new(&execution, 1);
        let spread: Vec<f64> = (0..2000)
            .map(|_| {
                noisy.read(&[0.0], &[0.0]);
                noisy.q()[0] - 0.5
            })
            .collect();
        let deviation = (spread.iter().map(|x| x * x).sum::<f64>() / 2000.0).sqrt();
        assert!((deviation - 1e-3).abs() < 5e-5, "{deviation}");
    }
}
