//! What a residual costs.

/// The loss ρ(r) of a residual in units of its error; half of it is the negative logarithm of a likelihood, up to a constant.
#[derive(Copy, Clone, Debug, PartialEq, Default)]
pub enum Loss {
    /// r²: normal errors.
    #[default]
    Squares,
    /// 2 (√(1 + r²) - 1): a square near 0, a line far off; SciPy's `soft_l1`.
    SoftL1,
    /// (ν + 1) ln(1 + r²/ν): Student's errors of ν degrees of freedom.
    Student(f64),
}

impl Loss {
    /// ρ of r².
    pub fn of(self, r2: f64) -> f64 {
        match self {
            Self::Squares => r2,
            Self::SoftL1 => 2.0 * ((1.0 + r2).sqrt() - 1.0),
            Self::Student(nu) => (nu + 1.0) * (r2 / nu).ln_1p(),
        }
    }

    /// dρ/d(r²): the weight of the residual in the normal equations.
    pub fn weight(self, r2: f64) -> f64 {
        match self {
            Self::Squares => 1.0,
            Self::SoftL1 => 1.0 / (1.0 + r2).sqrt(),
            Self::Student(nu) => (nu + 1.0) / (nu + r2),
        }
    }
}

impl Loss {
    /// Derivative of the pull ψ(r) = ρ'(r²) r: the curvature of the cost itself, where [`Self::weight`] is that of a descent. Negative far off
    /// for Student's errors.
    pub fn bend(self, r2: f64) -> f64 {
        // ψ' = ρ' + 2 r² ρ''
        match self {
            Self::Squares => 1.0,
            Self::SoftL1 => (1.0 + r2).powf(-1.5),
            Self::Student(nu) => (nu + 1.0) * (nu - r2) / (nu + r2).powi(2),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verif_weights_are_derivatives_of_losses() {
        for loss in [Loss::Squares, Loss::SoftL1, Loss::Student(4.0)] {
            assert_eq!(loss.of(0.0), 0.0);
            for r2 in [0.01, 1.0, 30.0] {
                let h = 1e-5 * r2;
                let slope = (loss.of(r2 + h) - loss.of(r2 - h)) / (2.0 * h);
                assert!((slope - loss.weight(r2)).abs() < 1e-8, "{loss:?} {r2}");
                let (r, h) = (r2.sqrt(), 1e-5 * r2.sqrt());
                let pull = |r: f64| loss.weight(r * r) * r;
                let bend = (pull(r + h) - pull(r - h)) / (2.0 * h);
                assert!((bend - loss.bend(r2)).abs() < 1e-8, "{loss:?} {r2}");
            }
        }
    }
}
