//! Continuous-time proofs of clearance and limits, kept as certificates.
