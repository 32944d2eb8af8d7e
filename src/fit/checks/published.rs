//! Published means and phase functions of satellites, as magnitudes at 1000 km, each with its source. Angles are in
//! degrees.
//!
//! These numbers are independent of those in the model files, so that an error in one of the two is found.

use crate::photometry::ModelFile;

use super::photometry::DataSet;

/// Standard deviation assumed for a survey that states none, mag. Published values are 0.64 to 0.86, and larger for
/// satellites at many heights.
const USUAL_SURVEY_SD_MAG: f64 = 0.7;

/// Published mean magnitude of a survey.
#[derive(Copy, Clone, Debug, PartialEq)]
pub(super) struct PublishedMean {
    /// Mean magnitude at 1000 km.
    pub mean_mag: f64,
    /// Standard deviation of the survey's magnitudes, mag; `None` if the publication does not state it.
    pub sd_mag: Option<f64>,
    /// Publication.
    pub source: &'static str,
}

impl PublishedMean {
    /// Returns the standard deviation of single magnitudes, mag, as published or as assumed.
    pub fn survey_sd_mag(&self) -> f64 {
        self.sd_mag.unwrap_or(USUAL_SURVEY_SD_MAG)
    }
}

/// Published phase function: a polynomial in the Sun-satellite-observer angle.
#[derive(Copy, Clone, Debug, PartialEq)]
pub(super) struct PublishedCurve {
    /// Coefficients of φ⁰, φ¹, … with φ in degrees, mag.
    pub coefficients: &'static [f64],
    /// Publication.
    pub source: &'static str,
}

impl PublishedCurve {
    /// Range of validity of the polynomials, degrees.
    const PHASES_DEG: [f64; 2] = [30.0, 150.0];

    /// Returns the magnitude at 1000 km; `None` outside [`Self::PHASES_DEG`].
    pub fn at(&self, phase_angle_rad: f64) -> Option<f64> {
        let phase = phase_angle_rad.to_degrees();
        let [least, greatest] = Self::PHASES_DEG;
        // m = a0 + φ (a1 + φ (a2 + …))
        (least..=greatest).contains(&phase).then(|| self.coefficients.iter().rev().fold(0.0, |sum, a| sum * phase + a))
    }
}

/// Satellites of one type, with the published references for their brightness.
#[derive(Copy, Clone, Debug, PartialEq)]
pub(super) struct Subject {
    /// Name of the satellites.
    pub name: &'static str,
    /// Names and aliases of the models of these satellites. The name of a model may continue with a hyphen.
    pub model_names: &'static [&'static str],
    /// Height above 6378.137 km, in km, and inclination, in degrees, of the shell over which models are averaged;
    /// `None` for satellites on various orbits.
    pub shell: Option<(f64, f64)>,
    /// Published means.
    pub means: &'static [PublishedMean],
    /// Published phase function.
    pub curve: Option<PublishedCurve>,
    /// Set of measurements in a data folder.
    pub photometry: Option<DataSet>,
}

impl Subject {
    /// Returns the standard deviation of single magnitudes in the survey that gave the curve, mag. It is that of the
    /// first mean, which comes from the same survey.
    pub fn survey_sd_mag(&self) -> f64 {
        self.means.first().map_or(USUAL_SURVEY_SD_MAG, PublishedMean::survey_sd_mag)
    }

    /// Returns the satellites of a model file, by its name first and then by its aliases. The longest matching name is
    /// used.
    pub fn from_model_file(file: &ModelFile) -> Option<&'static Self> {
        std::iter::once(&file.name).chain(&file.aliases).find_map(|name| Self::by_name(name))
    }

    fn by_name(name: &str) -> Option<&'static Self> {
        let fits = |known: &str| name.strip_prefix(known).is_some_and(|rest| rest.is_empty() || rest.starts_with('-'));
        SUBJECTS
            .iter()
            .flat_map(|subject| subject.model_names.iter().map(move |known| (*known, subject)))
            .filter(|(known, _)| fits(known))
            .max_by_key(|(known, _)| known.len())
            .map(|(_, subject)| subject)
    }
}

const fn mean(mean_mag: f64, sd_mag: Option<f64>, source: &'static str) -> PublishedMean {
    PublishedMean { mean_mag, sd_mag, source }
}

const fn curve(coefficients: &'static [f64], source: &'static str) -> Option<PublishedCurve> {
    Some(PublishedCurve { coefficients, source })
}

/// All satellites with published references.
const SUBJECTS: &[Subject] = &[
    Subject {
        name: "Starlink V1.0",
        model_names: &["starlink-v1.0", "v1.0"],
        shell: Some((550.0, 53.0)),
        means: &[mean(5.93, Some(0.67), "Mallama, arXiv 2006.08422")],
        curve: None,
        photometry: None,
    },
    Subject {
        name: "Starlink VisorSat",
        model_names: &["visorsat", "starlink-visorsat"],
        shell: Some((550.0, 53.0)),
        means: &[mean(7.22, Some(0.85), "Mallama, arXiv 2101.00374")],
        curve: curve(&[5.732, 0.03352, -0.000177], "Mallama, arXiv 2101.00374"),
        photometry: Some(DataSet::Mmt9VisorSat),
    },
    Subject {
        name: "Starlink V1.5",
        model_names: &["starlink-v1.5", "v1.5"],
        shell: Some((540.0, 53.2)),
        means: &[mean(6.34, Some(0.86), "Mallama, arXiv 2210.17268, 2507.00107")],
        curve: curve(&[3.944, 0.06893, -0.0004089], "Mallama, arXiv 2210.17268"),
        photometry: Some(DataSet::Pomenis),
    },
    Subject {
        name: "Starlink V2 Mini",
        model_names: &["v2mini", "starlink-v2mini"],
        shell: Some((525.0, 53.0)),
        means: &[
            mean(7.87, None, "Mallama et al., arXiv 2306.06657 (mitigated)"),
            mean(7.22, None, "Mallama et al., arXiv 2407.03092 (implied)"),
        ],
        curve: curve(&[2.630, 0.1065, -0.0005167], "Mallama et al., arXiv 2306.06657"),
        photometry: Some(DataSet::SlingshotV2),
    },
    Subject {
        name: "Starlink Direct-to-Cell",
        model_names: &["direct-to-cell", "starlink-dtc"],
        shell: Some((360.0, 53.0)),
        means: &[mean(6.47, Some(1.32), "Mallama et al., arXiv 2502.03651")],
        curve: curve(&[3.365, 0.06376, -1.716e-4, -1.139e-6], "Mallama et al., arXiv 2502.03651"),
        photometry: None,
    },
    Subject {
        name: "OneWeb",
        model_names: &["oneweb"],
        shell: Some((1200.0, 87.9)),
        means: &[mean(7.18, Some(0.68), "Mallama, arXiv 2012.05100")],
        curve: None,
        photometry: Some(DataSet::Mmt9OneWeb),
    },
    Subject {
        name: "Iridium NEXT",
        model_names: &["iridium-next"],
        shell: None,
        means: &[],
        curve: None,
        photometry: Some(DataSet::Mmt9IridiumNext),
    },
    Subject {
        name: "Amazon Leo (Kuiper)",
        model_names: &["kuiper", "amazon-leo"],
        shell: Some((630.0, 51.9)),
        means: &[mean(6.81, Some(0.64), "Mallama et al., arXiv 2601.07708")],
        curve: None,
        photometry: None,
    },
    Subject {
        name: "Qianfan",
        model_names: &["qianfan"],
        shell: Some((1070.0, 89.0)),
        means: &[mean(5.24, None, "Mallama et al., arXiv 2505.07194")],
        curve: None,
        photometry: None,
    },
    Subject {
        name: "Guowang",
        model_names: &["guowang"],
        shell: Some((1145.0, 50.0)),
        means: &[mean(4.21, None, "Mallama, benchmark of constellations (raising)")],
        curve: None,
        photometry: None,
    },
    Subject {
        name: "BlueBird",
        model_names: &["bluebird"],
        shell: Some((520.0, 53.0)),
        means: &[mean(3.84, None, "Mallama et al., arXiv 2505.05820")],
        curve: None,
        photometry: None,
    },
    Subject {
        name: "payloads",
        model_names: &["unknown"],
        shell: None,
        means: &[],
        curve: None,
        photometry: Some(DataSet::AmateursPayloads),
    },
    Subject {
        name: "rocket bodies",
        model_names: &["rocket-body"],
        shell: None,
        means: &[],
        curve: None,
        photometry: Some(DataSet::AmateursRocketBodies),
    },
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verif_the_longest_name_matches_and_part_of_a_word_does_not() {
        let name = |model: &str| Subject::by_name(model).map(|subject| subject.name);
        assert_eq!(name("starlink-v1.5-phase"), Some("Starlink V1.5"));
        assert_eq!(name("v2mini-panels"), Some("Starlink V2 Mini"));
        assert_eq!(name("oneweb"), Some("OneWeb"));
        assert_eq!(name("onewebs"), None);
        assert_eq!(name("starlink"), None);
    }

    #[test]
    fn verif_curves_end_at_their_range_of_validity() {
        let curve = SUBJECTS[1].curve.expect("VisorSat has one");
        // 5.732 + 3.0168 - 1.4337
        assert!((curve.at(90_f64.to_radians()).expect("in range") - 7.3151).abs() < 1e-9);
        assert_eq!(curve.at(20_f64.to_radians()), None);
        assert_eq!(curve.at(160_f64.to_radians()), None);
    }
}
