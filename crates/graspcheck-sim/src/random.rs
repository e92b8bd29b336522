//! Numbers from a seed: the same on every machine.

use rand_chacha::{
    ChaCha8Rng,
    rand_core::{RngCore, SeedableRng},
};

/// What a stream of numbers is for: streams of one seed have nothing to do with each other.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Stream {
    SelfTest = 0,
    Encoders = 1,
    Ripple = 2,
}

/// A stream of numbers.
pub(crate) struct Random(ChaCha8Rng);

impl Random {
    /// The numbers of this seed for this use.
    pub(crate) fn new(seed: u64, stream: Stream) -> Self {
        let mut generator = ChaCha8Rng::seed_from_u64(seed);
        generator.set_stream(stream as u64);
        Self(generator)
    }

    /// The next number in [0, 1), all equally likely.
    pub(crate) fn unit(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// The next number of mean 0 and standard deviation 1, nearly normal: the sum of twelve from [0, 1), less 6.
    /// It takes sums alone, whose rounding is the same everywhere, and never exceeds 6.
    pub(crate) fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.unit()).sum::<f64>() - 6.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_mean_and_deviation_of_a_normal_distribution_and_follow_from_the_seed() {
        let mut random = Random::new(5, Stream::Encoders);
        let drawn: Vec<f64> = (0..20_000).map(|_| random.normal()).collect();
        let mean = drawn.iter().sum::<f64>() / 20_000.0;
        let variance = drawn.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / 20_000.0;
        assert!(mean.abs() < 0.03 && (variance - 1.0).abs() < 0.05, "{mean}, {variance}");
        let first = |seed, stream| Random::new(seed, stream).unit();
        assert_eq!(first(5, Stream::Ripple).to_bits(), first(5, Stream::Ripple).to_bits());
        assert_ne!(first(5, Stream::Ripple).to_bits(), first(5, Stream::Encoders).to_bits());
        assert_ne!(first(5, Stream::Ripple).to_bits(), first(6, Stream::Ripple).to_bits());
    }
}
