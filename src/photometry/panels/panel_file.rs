//! Content of the `panels` key of a model file.

use serde::{Deserialize, Serialize};

use super::shapes::SpherePhase;

/// Content of a model of kind `panels`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PanelsSpec {
    /// Named numbers to which laws and spheres refer, in the order of the covariance.
    pub parameters: Vec<PanelParameter>,
    /// The panels.
    pub panels: Vec<PanelSpec>,
    /// Spheres, for parts without an orientation.
    #[serde(default)]
    pub spheres: Vec<SphereSpec>,
    /// Pairs of panels of which one may shade or hide the other.
    #[serde(default)]
    pub blocking: Vec<BlockingSpec>,
    /// True if the laws of every face are checked to reflect no more than they receive.
    #[serde(default)]
    pub conserves_energy: bool,
}

/// A named number.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PanelParameter {
    /// Name used by laws.
    pub name: String,
    /// Value.
    pub value: f64,
}

/// One flat rectangle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PanelSpec {
    /// Name.
    pub name: String,
    /// Position of u = v = 0 in the body frame (x towards the Sun's azimuth, z to the zenith), m.
    pub anchor_m: [f64; 3],
    /// Extent along the edge u, m.
    pub u_m: [f64; 2],
    /// Extent along the edge v, m.
    pub v_m: [f64; 2],
    /// Attitude law.
    pub attitude: AttitudeSpec,
    /// Laws of the front; their light is summed.
    #[serde(default)]
    pub front: Vec<LawSpec>,
    /// Laws of the back.
    #[serde(default)]
    pub back: Vec<LawSpec>,
    /// Laws of light that falls on the front and is seen from behind.
    #[serde(default)]
    pub through: Vec<LawSpec>,
    /// True if earthshine falls on the front.
    #[serde(default)]
    pub earthshine: bool,
}

/// A sphere, for a part without an orientation. It is never shaded or hidden and receives no earthshine.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SphereSpec {
    /// Name.
    pub name: String,
    /// Cross-section, m².
    pub area_m2: f64,
    /// Fraction of the incident power that is reflected.
    pub albedo: Coefficient,
    /// Dependence of the light on the phase angle.
    pub phase: SpherePhase,
}

/// A pair of panels of which one blocks light of the other.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BlockingSpec {
    /// Panel that loses light.
    pub panel: String,
    /// Panel that blocks it.
    pub by: String,
}

/// An attitude law.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "law", rename_all = "snake_case", deny_unknown_fields)]
pub enum AttitudeSpec {
    /// Facing straight down; u along y, v towards the Sun's azimuth.
    Nadir {},
    /// Upright and turned to the Sun's azimuth, leaning back by the offset.
    SunAzimuth {
        /// Angle of the normal above the chassis plane, degrees.
        offset_deg: OffsetSpec,
    },
    /// Facing the Sun, or a direction above it.
    SunTracking {
        /// Angle of the normal above the Sun, degrees.
        offset_deg: OffsetSpec,
    },
    /// Fixed in the body frame.
    Fixed {
        /// Normal, of any length.
        normal: [f64; 3],
        /// Edge v, of any length, at right angles to the normal.
        v: [f64; 3],
    },
}

/// An angle, constant or as a function of the Sun's latitude.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged, expecting = "degrees, or rows of [Sun's latitude, offset] in degrees")]
pub enum OffsetSpec {
    /// Degrees.
    Constant(f64),
    /// Rows of (Sun's latitude, offset), degrees, by increasing latitude; linear interpolation, constant beyond the
    /// ends.
    Table(Vec<[f64; 2]>),
}

/// A number, or the name of a parameter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged, expecting = "a number or the name of a parameter")]
pub enum Coefficient {
    /// A fixed value.
    Number(f64),
    /// Value of this parameter.
    Parameter(String),
}

/// A reflection law with its coefficients.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "law", rename_all = "snake_case", deny_unknown_fields)]
pub enum LawSpec {
    /// Lambert's law.
    Lambert {
        /// Fraction of the incident power that is reflected.
        albedo: Coefficient,
    },
    /// Phong's lobe.
    Phong {
        /// Fraction of the power in the lobe.
        weight: Coefficient,
        /// Narrowness of the lobe.
        exponent: Coefficient,
    },
    /// The ABg law.
    Abg {
        /// Amplitude, sr⁻¹.
        a: Coefficient,
        /// Shoulder.
        b: Coefficient,
        /// Slope.
        g: Coefficient,
    },
    /// A Gaussian-like lobe.
    Gaussian {
        /// Peak value, sr⁻¹.
        peak_per_sr: Coefficient,
        /// 1 - cos θ at 1/e of the peak.
        width: Coefficient,
    },
    /// A lobe about the transmitted direction.
    Straight {
        /// Fraction of the power in the lobe.
        weight: Coefficient,
        /// Narrowness of the lobe.
        exponent: Coefficient,
    },
    /// A lobe about the direction back to the Sun.
    Retro {
        /// Fraction of the power in the lobe.
        weight: Coefficient,
        /// Narrowness of the lobe.
        exponent: Coefficient,
    },
    /// A rough mirror of small facets.
    Facets {
        /// Reflectance of a facet.
        weight: Coefficient,
        /// Rms slope along one axis.
        slope: Coefficient,
    },
    /// A binomial expansion of the logarithm; its coefficients are numbers of a laboratory fit.
    Binomial {
        /// Coefficients b\[k\]\[i\].
        b: Vec<Vec<f64>>,
        /// Coefficients c\[k\]\[j\], with as many rows as b.
        c: Vec<Vec<f64>>,
        /// Ratio of successive widths.
        d: f64,
        /// Index of the widest lobe.
        first: i32,
    },
}
