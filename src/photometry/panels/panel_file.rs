//! Panels as they stand in a model file.

use serde::{Deserialize, Serialize};

use super::shapes::SpherePhase;

/// Content of a model of kind `panels`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PanelsSpec {
    /// Numbers with names, which laws and spheres refer to; their order is that of the covariance.
    pub parameters: Vec<PanelParameter>,
    /// The panels.
    pub panels: Vec<PanelSpec>,
    /// Parts without orientation.
    #[serde(default)]
    pub spheres: Vec<SphereSpec>,
    /// Pairs of panels of which one may shade or hide the other.
    #[serde(default)]
    pub blocking: Vec<BlockingSpec>,
    /// True where the laws of every face are checked to reflect no more than they receive.
    #[serde(default)]
    pub conserves_energy: bool,
}

/// A number with a name.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PanelParameter {
    /// Name used by laws.
    pub name: String,
    /// Its value.
    pub value: f64,
}

/// One flat rectangle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PanelSpec {
    /// Its name.
    pub name: String,
    /// The point u = v = 0 in the body frame (x towards the Sun's azimuth, z to the zenith), m.
    pub anchor_m: [f64; 3],
    /// Extent along the edge u, m.
    pub u_m: [f64; 2],
    /// Extent along the edge v, m.
    pub v_m: [f64; 2],
    /// Law of its attitude.
    pub attitude: AttitudeSpec,
    /// Laws of the front; their light adds up.
    #[serde(default)]
    pub front: Vec<LawSpec>,
    /// Laws of the back.
    #[serde(default)]
    pub back: Vec<LawSpec>,
    /// Laws of light that falls on the front and is seen from behind.
    #[serde(default)]
    pub through: Vec<LawSpec>,
    /// True where earthshine falls on the front.
    #[serde(default)]
    pub earthshine: bool,
}

/// A part without orientation; never blocked, and without earthshine.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SphereSpec {
    /// Its name.
    pub name: String,
    /// Cross-section, m².
    pub area_m2: f64,
    /// Share of the incident power that leaves again.
    pub albedo: Coefficient,
    /// Dependence of its light on the phase angle.
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

/// A law of attitude.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "law", rename_all = "snake_case", deny_unknown_fields)]
pub enum AttitudeSpec {
    /// Facing straight down; u along y, v towards the Sun's azimuth.
    Nadir {},
    /// Upright and turned to the Sun's azimuth, leaning back by the offset.
    SunAzimuth {
        /// Degrees above the chassis plane that the normal points to.
        offset_deg: OffsetSpec,
    },
    /// Facing the Sun, or this far above it.
    SunTracking {
        /// Degrees above the Sun that the normal points to.
        offset_deg: OffsetSpec,
    },
    /// Fixed in the body frame.
    Fixed {
        /// Direction of the normal, of any length.
        normal: [f64; 3],
        /// Direction of the edge v, of any length, at right angles to the normal.
        v: [f64; 3],
    },
}

/// An angle, constant or against the Sun's latitude.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged, expecting = "degrees, or rows of [Sun's latitude, offset] in degrees")]
pub enum OffsetSpec {
    /// Degrees.
    Constant(f64),
    /// Rows of (Sun's latitude, offset), degrees, latitudes rising; straight lines between, constant beyond.
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

/// A law of reflection with its coefficients.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "law", rename_all = "snake_case", deny_unknown_fields)]
pub enum LawSpec {
    /// Lambert's law.
    Lambert {
        /// Share of the incident power that leaves again.
        albedo: Coefficient,
    },
    /// Phong's lobe.
    Phong {
        /// Share of the power in the lobe.
        weight: Coefficient,
        /// Narrowness.
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
        /// Height, sr⁻¹.
        peak_per_sr: Coefficient,
        /// 1 - cos θ where it has fallen to 1/e.
        width: Coefficient,
    },
    /// A lobe about the continued ray.
    Straight {
        /// Share of the power in the lobe.
        weight: Coefficient,
        /// Narrowness.
        exponent: Coefficient,
    },
    /// A lobe about the direction back to the Sun.
    Retro {
        /// Share of the power in the lobe.
        weight: Coefficient,
        /// Narrowness.
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
        /// b\[k\]\[i\].
        b: Vec<Vec<f64>>,
        /// c\[k\]\[j\], as many rows as b.
        c: Vec<Vec<f64>>,
        /// Ratio of successive widths.
        d: f64,
        /// Index of the widest lobe.
        first: i32,
    },
}
