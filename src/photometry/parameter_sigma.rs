//! Uncertainty of a magnitude that follows from the covariance of the parameters of a model.

use nalgebra::{DMatrix, SymmetricEigen};

/// Covariance of parameters, decomposed into independent directions, each with a length of one sigma.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ParameterSigmas {
    /// Vectors of length `n_parameter`, one per direction; directions without variance are omitted.
    directions: Vec<Vec<f64>>,
}

impl ParameterSigmas {
    /// Decomposes a symmetric matrix that is given row by row.
    pub fn new(covariance: &[Vec<f64>]) -> Self {
        let n = covariance.len();
        let matrix = DMatrix::from_fn(n, n, |row, column| covariance[row].get(column).copied().unwrap_or(0.0));
        let eigen = SymmetricEigen::new(matrix);
        // Rounding may make the variance of a direction slightly negative: it is treated as 0.
        let directions = eigen
            .eigenvalues
            .iter()
            .zip(eigen.eigenvectors.column_iter())
            .filter(|(variance, _)| **variance > 0.0)
            .map(|(variance, direction)| direction.iter().map(|part| part * variance.sqrt()).collect())
            .collect();
        Self { directions }
    }

    /// Returns the variance of a quantity, J Σ Jᵀ, from its derivatives with respect to the parameters.
    pub fn variance_of_gradient(&self, gradient: &[f64]) -> f64 {
        // Σ = Σ_k d_k d_kᵀ, so J Σ Jᵀ = Σ_k (J · d_k)²
        let along = |direction: &Vec<f64>| direction.iter().zip(gradient).map(|(d, g)| d * g).sum::<f64>();
        self.directions.iter().map(|direction| along(direction).powi(2)).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verif_variance_of_a_linear_quantity() {
        let covariance = vec![vec![0.04, 0.01, 0.0], vec![0.01, 0.09, 0.0], vec![0.0, 0.0, 0.0]];
        let sigmas = ParameterSigmas::new(&covariance);
        let gradient = [2.0, -1.0, 5.0];
        // 4·0.04 + 0.09 - 2·2·0.01
        let expected = 0.16 + 0.09 - 0.04;
        assert!((sigmas.variance_of_gradient(&gradient) - expected).abs() < 1e-14);
    }
}
