//! Errors of learning.

use thiserror::Error;

/// Errors of learning from measurements.
#[derive(Debug, Error)]
pub enum LearnError {
    /// Neither magnitudes nor delays can be used.
    #[error("nothing to learn from: {reason}; allowed: {allowed}")]
    Nothing {
        /// Numbers of measurements that were left out, with reasons.
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
}
