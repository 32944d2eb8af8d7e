//! From photometry to brightness models: reading, selection, reduction, fits, posteriors, and checks of models.
//!
//! - `measurements`, `point`: measured magnitudes, and the points of a fit made from them
//! - `form`, `two_panel_form`, `two_panel_kernel`, `panels_form`, `log_nodes`, `phase`: brightness laws with free
//!   parameters: the trait, the two panels of Lu (2024), any panels, and the baselines
//! - `objective`, `solve`, `linear_starts`: the cost of a law under a loss function, and least-squares fits from
//!   several starting points
//! - `covariance`, `jackknife`: errors of the parameters, from groups of points or, for pixels, from sets of tracks
//! - `soundness`, `cross_validation`, `paper_tests`: faults of a fit, comparison of laws on held-out points, the tests
//!   of Lu (2024)
//! - `simulation`, `lu2024`: simulated photometry of a known brightness law, and the printed numbers of Lu (2024) with
//!   the same numbers computed from photometry
//! - `posterior`: samples of the posterior, drawn by an ensemble of walkers, and the files of their chains
//! - `model_of_fit`, `report`: model file and report of a fit
//! - `inference`: numerical methods without astronomy
//! - `checks`: comparison of models with published results
//!
//! ```
//! use streakcast::fit::measurements::{Measurement, Measurements};
//! use streakcast::fit::{FitSettings, Problem, RawWeights, TwoPanelForm, points_of_measurements};
//! use streakcast::geometry::ViewingGeometry;
//! use streakcast::photometry::{Earthshine, ModelLibrary, StandardMagnitude};
//!
//! // Measurements of a known model that are 0.2 mag too faint.
//! let truth = ModelLibrary::embedded().find("starlink-v1.5")?;
//! let mut measured = Measurements::default();
//! measured.groups.push("track 1".to_owned());
//! for step in 0..200 {
//!     let (longitude, latitude) = (0.013 * f64::from(step), -1.3 + 0.003 * f64::from(step));
//!     let geometry = ViewingGeometry::from_angles(-0.2, longitude, latitude, 900.0, 550.0).expect("a geometry");
//!     let Some(magnitude) = truth.standard_magnitude(&geometry) else { continue };
//!     measured.points.push(Measurement {
//!         magnitude: StandardMagnitude(magnitude.0 + 0.2),
//!         sigma_mag: Some(0.1),
//!         geometry,
//!         group: 0,
//!         norad_id: None,
//!         epoch: None,
//!         grazing_height_km: None,
//!         lit_fraction: 1.0,
//!     });
//! }
//! let form = TwoPanelForm::from_model(&truth, Earthshine::Off).expect("two panels");
//! let points = points_of_measurements(&measured, &RawWeights::default());
//! let fit = Problem::new(&form, &points, &FitSettings::free(&["c2", "c4"]))?.solve()?;
//! for parameter in &fit.parameters {
//!     println!("{} {:.4}", parameter.name, parameter.value);
//! }
//! # Ok::<(), streakcast::Error>(())
//! ```

#[doc(hidden)]
pub mod checks;
mod covariance;
mod cross_validation;
mod error;
mod form;
#[doc(hidden)]
pub mod inference;
mod jackknife;
mod linear_starts;
mod log_nodes;
mod lu2024;
pub mod measurements;
mod model_of_fit;
mod objective;
mod panels_form;
mod paper_tests;
mod phase;
mod point;
mod posterior;
mod report;
mod simulation;
mod solve;
mod soundness;
mod statistics;
mod two_panel_form;
mod two_panel_kernel;

pub use covariance::FitUncertainty;
pub use form::{Form, Parameter};
pub use inference::Chain;
pub use objective::{Loss, Objective};
pub use paper_tests::COEFFICIENTS;
pub use point::{FitPoint, RawWeights, points_of_measurements};
pub use posterior::{Marginal, Posterior, PosteriorSettings, draw, posterior};
pub use solve::{Fit, FitSettings, Problem};
pub use soundness::{Fault, PoorAxis, faults};
pub use statistics::rms;
pub use two_panel_form::TwoPanelForm;

// Not documented, without a promise of stability: for the program, the Python extension, tests and benches, and for
// code of other features.
#[doc(hidden)]
pub use self::{
    covariance::CovarianceKind,
    cross_validation::{CompetingForm, FormScore, HeldOutPoint, baseline_forms, compare_forms, predict},
    jackknife::jackknife,
    lu2024::{
        LU2024_PARTS, Lu2024, Lu2024Data, Lu2024Row, Lu2024Truth, lu2024, lu2024_rows, lu2024_table, recovered_table,
    },
    model_of_fit::{ModelDescription, model_file, range_of},
    panels_form::PanelsForm,
    paper_tests::{PaperTests, paper_tests},
    phase::{PhaseForm, SphereForm},
    point::points_of_pixels,
    posterior::{ChainAbout, read_chain, write_chain},
    report::{Report, form_score_table, marginal_table, offset_table, paired_model_table, parameter_table},
    simulation::{Simulation, SimulationOptions, simulate},
    solve::weigh_groups,
    soundness::points_behind,
    statistics::{ResidualStatistics, median_mag, sigma_68_mag, weighted_quantile, weighted_sigma_68_mag},
};
