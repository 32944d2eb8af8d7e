//! From photometry to a model: forms of law with parameters, their least squares and posterior, and the model file made of them.
//!
//! `point` is what a fit sees of a measurement, `form` what a law must answer (`two_panel` the paper's, `phase` those that it
//! has to beat), `objective` a form held against points under a `loss`, `solve` its least squares from several starts with
//! their `covariance` (of pixels by `jackknife` over the `tracks` behind them), `posterior` the walkers' draws (kept by
//! `chain_file`), `comparison` and `cross_validation` which form explains more. `inference` knows functions of a vector and nothing of satellites.

mod chain_file;
pub mod checks;
mod comparison;
mod contest;
mod covariance;
mod coverage;
mod cross_validation;
mod error;
mod form;
pub mod inference;
mod jackknife;
mod linear_starts;
mod log_nodes;
mod loss;
mod markdown;
pub mod measurements;
mod model_of_fit;
mod objective;
mod observed;
mod panel_earth;
mod panels_form;
mod paper;
mod phase;
mod point;
mod posterior;
mod solve;
mod soundness;
mod statistics;
mod tables;
mod tracks;
mod two_panel;

pub use crate::photometry::PANEL_OFFSET;
pub use chain_file::{ChainAbout, read_chain, write_chain};
pub use comparison::{PairedTest, aic, aic_under, paired_t_test, rms};
pub use contest::{Entrant, Standing, baselines, contest};
pub use covariance::{Certainty, CovarianceKind};
pub use coverage::PoorAxis;
pub use cross_validation::{Folds, HeldOut, cross_validate, predict};
pub use error::FitError;
pub use form::{BLOCK, Evaluated, Form, Parameter, Prepared, Sloped};
pub use inference::Chain;
pub use jackknife::jackknife;
pub use loss::Loss;
pub use markdown::Report;
pub use model_of_fit::{ModelWords, model_file, range_of};
pub use objective::Objective;
pub use observed::{RawWeights, points_of_measurements, points_of_pixels};
pub use panels_form::PanelsForm;
pub use paper::{COEFFICIENTS, LayerOffset, PaperTests, Rivals, paper_tests};
pub use phase::{PhaseForm, SphereForm};
pub use point::{FitPoint, group_error_factors};
pub use posterior::{Marginal, Posterior, PosteriorSettings, draw, posterior, starting_places};
pub use solve::{Fit, FitSettings, Problem};
pub use soundness::{Fault, faults, points_behind};
pub use statistics::{Spread, honest_sigma_mag, share_within};
pub use tables::{marginal_table, offset_table, parameter_table, rival_table, standing_table};
pub use two_panel::TwoPanelForm;
