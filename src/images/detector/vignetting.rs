//! Vignetting: loss of light towards the corners of a frame.

use serde::Deserialize;

use crate::error::Error;

/// Transmission as a function of the distance from a centre; 1 means no loss.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Vignetting {
    /// Polynomial 1 + c₀ ρ² + c₁ ρ⁴ + ..., with the distance ρ in units of a given radius; negative values become 0.
    Polynomial {
        /// Position of the centre, `[x, y]` in pixels counted from 0; by default the middle of the frame.
        #[serde(default)]
        centre_pix: Option<[f64; 2]>,
        /// Radius at which ρ is 1, pixels, above 0.
        radius_pix: f64,
        /// Coefficients c₀, c₁, ..., at least one, each in \[-10, 10\].
        coefficients: Vec<f64>,
    },
    /// Table of transmissions, interpolated linearly between the given radii and constant beyond the last radius.
    Table {
        /// Position of the centre, `[x, y]` in pixels counted from 0; by default the middle of the frame.
        #[serde(default)]
        centre_pix: Option<[f64; 2]>,
        /// Increasing radii, pixels; the first is 0.
        radii_pix: Vec<f64>,
        /// Transmission at each radius, \[0, 2\].
        transmission: Vec<f64>,
    },
}

impl Vignetting {
    pub(super) fn validate(&self) -> Result<(), Error> {
        let centre = match self {
            Self::Polynomial { centre_pix, .. } | Self::Table { centre_pix, .. } => centre_pix,
        };
        for coordinate in centre.iter().flatten() {
            Error::check_range("vignetting.centre_pix", *coordinate, -1e6, 1e6)?;
        }
        match self {
            Self::Polynomial { radius_pix, coefficients, .. } => {
                Error::check_range("vignetting.radius_pix", *radius_pix, 1.0, 1e6)?;
                if coefficients.is_empty() {
                    return Err(Error::invalid("vignetting.coefficients", "empty", "at least one number"));
                }
                coefficients.iter().try_for_each(|c| Error::check_range("vignetting.coefficients", *c, -10.0, 10.0))
            }
            Self::Table { radii_pix, transmission, .. } => {
                if radii_pix.len() != transmission.len() || radii_pix.first() != Some(&0.0) {
                    let allowed = "as many numbers as in transmission, of which the first is 0";
                    return Err(Error::invalid("vignetting.radii_pix", format!("{radii_pix:?}"), allowed));
                }
                if radii_pix.windows(2).any(|pair| !(pair[1] > pair[0] && pair[1].is_finite())) {
                    let allowed = "numbers that increase";
                    return Err(Error::invalid("vignetting.radii_pix", format!("{radii_pix:?}"), allowed));
                }
                transmission.iter().try_for_each(|t| Error::check_range("vignetting.transmission", *t, 0.0, 2.0))
            }
        }
    }

    /// Multiplies pixels of one row, beginning at `first_column`, by their transmission in a frame of `rows` by
    /// `columns`.
    pub(super) fn apply(&self, rows: usize, columns: usize, row: usize, first_column: usize, light: &mut [f32]) {
        let middle = [0.5 * (columns as f64 - 1.0), 0.5 * (rows as f64 - 1.0)];
        let (Self::Polynomial { centre_pix, .. } | Self::Table { centre_pix, .. }) = self;
        let [x, y] = centre_pix.unwrap_or(middle);
        for (column, light) in (first_column..).zip(light) {
            let r_pix = (column as f64 - x).hypot(row as f64 - y);
            *light *= self.transmission(r_pix) as f32;
        }
    }

    fn transmission(&self, r_pix: f64) -> f64 {
        match self {
            Self::Polynomial { radius_pix, coefficients, .. } => {
                let square = (r_pix / radius_pix).powi(2);
                let sum = coefficients.iter().rev().fold(0.0, |sum, coefficient| (sum + coefficient) * square);
                (1.0 + sum).max(0.0)
            }
            Self::Table { radii_pix, transmission, .. } => {
                let after = radii_pix.partition_point(|radius| *radius <= r_pix);
                if after == radii_pix.len() {
                    return transmission[after - 1];
                }
                let share = (r_pix - radii_pix[after - 1]) / (radii_pix[after] - radii_pix[after - 1]);
                transmission[after - 1] + share * (transmission[after] - transmission[after - 1])
            }
        }
    }
}
