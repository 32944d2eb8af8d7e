//! Content of the `panels` key of a model file.

use serde::{Deserialize, Serialize};

use super::shapes::SpherePhase;

/// Content of a model of kind `panels`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PanelsSpec {
    /// Named numbers to which laws and spheres may refer, in the order of the covariance.
    pub parameters: Vec<PanelParameter>,
    /// The panels.
    pub panels: Vec<PanelSpec>,
    /// Spheres, which represent parts without an orientation.
    #[serde(default)]
    pub spheres: Vec<SphereSpec>,
    /// Pairs of panels of which one may shade or hide the other.
    #[serde(default)]
    pub blocking: Vec<BlockingSpec>,
    /// If true, it is checked that the laws of a face do not reflect more light than they receive.
    #[serde(default)]
    pub conserves_energy: bool,
}

/// Named number to which laws and spheres may refer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PanelParameter {
    /// Name by which laws and spheres refer to the number.
    pub name: String,
    /// Value.
    pub value: f64,
}

/// One flat rectangular panel.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PanelSpec {
    /// Name.
    pub name: String,
    /// Position of the point u = v = 0 in the body frame (x towards the Sun's azimuth, z to the zenith), m.
    pub anchor_m: [f64; 3],
    /// Extent along the edge u, m.
    pub u_m: [f64; 2],
    /// Extent along the edge v, m.
    pub v_m: [f64; 2],
    /// Rule for the attitude of the panel.
    pub attitude: AttitudeSpec,
    /// Laws of the front; their light is summed.
    #[serde(default)]
    pub front: Vec<LawSpec>,
    /// Laws of the back; their light is summed.
    #[serde(default)]
    pub back: Vec<LawSpec>,
    /// Laws of light that falls on the front and is seen from behind.
    #[serde(default)]
    pub through: Vec<LawSpec>,
    /// True if earthshine falls on the front.
    #[serde(default)]
    pub earthshine: bool,
}

/// Sphere, which represents a part without an orientation. It is never shaded or hidden and receives no earthshine.
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

/// Pair of panels, of which one may shade or hide the other.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BlockingSpec {
    /// Name of the panel that loses light.
    pub panel: String,
    /// Name of the panel that shades or hides it.
    pub by: String,
}

/// Rule that determines the attitude of a panel.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "law", rename_all = "snake_case", deny_unknown_fields)]
pub enum AttitudeSpec {
    /// The panel faces straight down; u is along y, and v points towards the Sun's azimuth.
    Nadir {},
    /// The panel is upright, turned to the Sun's azimuth, and leans back by the offset.
    SunAzimuth {
        /// Angle of the normal above the chassis plane, degrees.
        offset_deg: OffsetSpec,
    },
    /// The panel faces the Sun, or a direction above it.
    SunTracking {
        /// Angle of the normal above the Sun, degrees.
        offset_deg: OffsetSpec,
    },
    /// The axes are fixed in the body frame.
    Fixed {
        /// Normal of the front; its length is arbitrary.
        normal: [f64; 3],
        /// Edge v, perpendicular to the normal; its length is arbitrary.
        v: [f64; 3],
    },
}

/// Angle that is constant or depends on the Sun's latitude.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged, expecting = "degrees, or rows of [Sun's latitude, offset] in degrees")]
pub enum OffsetSpec {
    /// Constant angle, degrees.
    Constant(f64),
    /// Rows of the Sun's latitude and the angle, degrees, in order of latitude. The angle is interpolated linearly and
    /// constant beyond the ends.
    Table(Vec<[f64; 2]>),
}

/// Value of a coefficient: a number, or the name of a parameter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged, expecting = "a number or the name of a parameter")]
pub enum Coefficient {
    /// A fixed value.
    Number(f64),
    /// The value of the parameter with this name.
    Parameter(String),
}

/// A reflection law with its coefficients.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "law", rename_all = "snake_case", deny_unknown_fields)]
pub enum LawSpec {
    /// Lambert's law (diffuse reflection).
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
        /// Value B that determines where the flat top ends.
        b: Coefficient,
        /// Slope of the wing.
        g: Coefficient,
    },
    /// A Gaussian-like lobe.
    Gaussian {
        /// Peak value, sr⁻¹.
        peak_per_sr: Coefficient,
        /// The value of 1 - cos θ at which the lobe is 1/e of its peak.
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
        /// Root mean square slope along one axis.
        slope: Coefficient,
    },
    /// A binomial expansion of the logarithm of the reflectance. Its coefficients are those of a fit to laboratory
    /// data.
    Binomial {
        /// Coefficients b\[k\]\[i\].
        b: Vec<Vec<f64>>,
        /// Coefficients c\[k\]\[j\], with as many rows as b.
        c: Vec<Vec<f64>>,
        /// Ratio of the widths of successive lobes.
        d: f64,
        /// Index of the widest lobe.
        first: i32,
    },
}
