//! Tests of photometry, fits and model validation.

#[path = "../common/mod.rs"]
mod common;

mod alarms;
mod before_after;
mod default_models;
mod error_distributions;
mod fit_closed_circle;
mod fit_panels;
mod fit_two_panel;
mod learning;
mod measured;
mod measured_real;
mod model_validation;
mod night_offsets;
mod outside_geometry;
mod pass_update;
#[path = "../common/simulated_photometry.rs"]
mod simulated_photometry;
mod survey;
mod unseen_surveys;
