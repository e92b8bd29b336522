//! A recording as a Rerun file with a blueprint.
