//! Checks of what a task says, before anything is computed from it.

use crate::error::PlanError;

/// Checks that joint positions fit the arm and are finite.
pub(crate) fn check_joint_count(place: &str, q: &[f64], dof: usize) -> Result<(), PlanError> {
    if q.len() != dof {
        return Err(PlanError::JointCount { place: place.to_owned(), count: q.len(), dof });
    }
    for (joint, &value) in q.iter().enumerate() {
        check_number(&format!("{place}, joint {joint}"), value, true, "finite")?;
    }
    Ok(())
}

/// Checks that a number is finite and `holds`; the error says what it `must` be.
pub(crate) fn check_number(
    place: &str,
    value: f64,
    holds: bool,
    must: &'static str,
) -> Result<(), PlanError> {
    if holds && value.is_finite() {
        Ok(())
    } else {
        Err(PlanError::BadNumber { place: place.to_owned(), value, must })
    }
}
