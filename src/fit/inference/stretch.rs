//! The stretch move of Goodman and Weare (2010, CAMCoS 5, 65), as emcee makes it (Foreman-Mackey et al. 2013).
//!
//! A walker is moved along the line to another one of the other half: y = c + z (x - c), z drawn from g(z) ∝ 1/√z on [1/a, a],
//! and the move accepted with the probability min(1, z^(n-1) p(y)/p(x)).

/// The scale a of g.
pub(super) const SCALE: f64 = 2.0;

/// One proposal.
pub(super) struct Proposal {
    /// Where to.
    pub to: Vec<f64>,
    /// ln z^(n-1).
    pub log_factor: f64,
}

/// From a walker's place and one of the other half, by a number drawn evenly from [0, 1).
pub(super) fn propose(from: &[f64], other: &[f64], even: f64) -> Proposal {
    // z = ((a - 1) u + 1)² / a
    let z = ((SCALE - 1.0) * even + 1.0).powi(2) / SCALE;
    let to = from.iter().zip(other).map(|(from, other)| other + z * (from - other)).collect();
    Proposal { to, log_factor: (from.len() as f64 - 1.0) * z.ln() }
}
