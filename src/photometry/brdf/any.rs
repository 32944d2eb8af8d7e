//! All reflection laws as one enum.

use super::law::{Brdf, Incidence};
use super::{Abg, Binomial, Facets, Gaussian, Lambert, Phong, Retro, Straight};

/// A reflection law.
#[derive(Clone, Debug, PartialEq)]
pub enum Law {
    /// Equal radiance in every direction.
    Lambert(Lambert),
    /// A lobe proportional to a power of the cosine.
    Phong(Phong),
    /// A lobe with a shoulder and a power-law wing.
    Abg(Abg),
    /// A Gaussian-like lobe.
    Gaussian(Gaussian),
    /// A polynomial expansion of the logarithm of the reflectance.
    Binomial(Binomial),
    /// A lobe about the transmitted direction.
    Straight(Straight),
    /// A lobe about the direction back to the source.
    Retro(Retro),
    /// A rough mirror of small facets.
    Facets(Facets),
}

impl Law {
    /// Returns the exponent of a Phong lobe of the same width, by which the sampling of extended sources is chosen.
    pub fn equivalent_exponent(&self) -> f64 {
        /// Exponent for binomial laws, whose lobes may have any width. It is that of the narrowest lobe for which the
        /// integral over the Earth is tested.
        const LARGEST_EXPONENT: f64 = 200.0;
        // cosⁿθ falls to half at θ² ≈ 2 ln 2 / n
        let of_half_width = |theta: f64| 2.0 * std::f64::consts::LN_2 / theta.powi(2);
        let exponent = match self {
            Self::Lambert(_) => 1.0,
            // Only the width of the lobe matters here.
            Self::Phong(Phong { exponent, .. })
            | Self::Straight(Straight { exponent, .. })
            | Self::Retro(Retro { exponent, .. }) => *exponent,
            // A facet tilted by β across the plane of incidence deflects light by θ = 2β cos φ_i. At φ_i = 60°, about
            // the angle at which light from the Earth's limb falls on a panel that faces the nadir, θ = β, and
            // e^(-tan²β/2w²) ≈ e^(-θ²/2w²), while cosⁿθ ≈ e^(-nθ²/2). For light along the normal the lobe is twice as
            // wide, 2w. Slopes below 0.07 would need an exponent above LARGEST_EXPONENT. For a slope of 0.04 the error
            // of earthshine is up to 0.04 mag near the horizon and 0.002 mag elsewhere.
            Self::Facets(law) => law.slope.powi(-2),
            // e^((cos θ - 1)/w) ≈ e^(-θ²/2w)
            Self::Gaussian(law) => 1.0 / law.width,
            // The half maximum is at x^g = B.
            Self::Abg(law) => of_half_width(law.b.powf(1.0 / law.g.max(0.1))),
            Self::Binomial(_) => LARGEST_EXPONENT,
        };
        exponent.clamp(1.0, LARGEST_EXPONENT)
    }
}

impl Brdf for Law {
    fn value_per_sr(&self, incidence: &Incidence) -> f64 {
        match self {
            Self::Lambert(law) => law.value_per_sr(incidence),
            Self::Phong(law) => law.value_per_sr(incidence),
            Self::Abg(law) => law.value_per_sr(incidence),
            Self::Gaussian(law) => law.value_per_sr(incidence),
            Self::Binomial(law) => law.value_per_sr(incidence),
            Self::Straight(law) => law.value_per_sr(incidence),
            Self::Retro(law) => law.value_per_sr(incidence),
            Self::Facets(law) => law.value_per_sr(incidence),
        }
    }
}

/// Laws of one face, whose light is summed.
impl Brdf for [Law] {
    fn value_per_sr(&self, incidence: &Incidence) -> f64 {
        self.iter().map(|law| law.value_per_sr(incidence)).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    #[test]
    fn verif_facets_have_the_width_of_their_exponent() {
        let facets = Facets { weight: 1.0, slope: 0.08 };
        let exponent = Law::Facets(facets).equivalent_exponent();
        let (light, mirror) = (Vector3::new(0.75_f64.sqrt(), 0.0, 0.5), Vector3::new(-(0.75_f64.sqrt()), 0.0, 0.5));
        let across = |degrees: f64| {
            let (sin, cos) = degrees.to_radians().sin_cos();
            facets.value_per_sr(&Incidence::new(&Vector3::z(), &light, &(mirror * cos + Vector3::y() * sin)))
        };
        for degrees in [2.0_f64, 4.0, 6.0, 8.0] {
            // Within a few θ².
            let ratio = across(degrees) / across(0.0) / degrees.to_radians().cos().powf(exponent);
            assert!((ratio - 1.0).abs() < 0.05, "{degrees}°: {ratio}");
        }
    }
}
