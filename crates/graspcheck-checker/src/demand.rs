//! What is demanded of a statement of the log.

use crate::{Finding, Place, Quantity};

/// What was demanded of statements at one place and does not hold: which quantity, as stated and as found.
#[derive(Default)]
pub(crate) struct Demands(Vec<(Quantity, f64, f64)>);

impl Demands {
    /// Conditions are written so that they are false where a number is NaN.
    pub(crate) fn that(&mut self, holds: bool, quantity: Quantity, stated: f64, found: f64) {
        if !holds {
            self.0.push((quantity, stated, found));
        }
    }

    /// That something is there as often as it must.
    pub(crate) fn occurs(&mut self, count: usize, expected: usize) {
        self.that(count == expected, Quantity::Occurrences, count as f64, expected as f64);
    }

    /// Enters what does not hold.
    pub(crate) fn report(self, findings: &mut Vec<Finding>, interval: [f64; 2], place: impl Fn() -> Place) {
        let finding = |(quantity, stated, recomputed)| Finding {
            place: place(),
            interval,
            quantity,
            stated,
            recomputed,
        };
        findings.extend(self.0.into_iter().map(finding));
    }
}

#[expect(clippy::float_cmp, reason = "times of one plan and limits of one robot are copies of each other")]
pub(crate) fn is_equal(a: f64, b: f64) -> bool {
    a == b
}
