//! Errors of learning.

use thiserror::Error;

use crate::watch::Interrupted;

/// Errors of learning from measurements.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum LearnError {
    /// No magnitude can be used.
    #[error("nothing to learn from: {reason}; allowed: {allowed}")]
    Nothing {
        /// Description of what is missing.
        reason: String,
        /// What is required of measurements.
        allowed: &'static str,
    },
    /// A table of measured streaks cannot be read.
    #[error("measurements {file}: {problem}")]
    Table {
        /// Name of the file.
        file: String,
        /// Cause, and position if known.
        problem: String,
    },
    /// The computation was stopped by its caller.
    #[error(transparent)]
    Interrupted(#[from] Interrupted),
}
