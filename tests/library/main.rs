//! Tests of element sets, orbits, geometry, brightness, crossings, verdicts, forecasts, maps and plots.

#[path = "../common/mod.rs"]
mod common;

mod catalogue;
mod catalogue_history;
mod catalogue_hostile;
mod catalogue_real;
#[cfg(feature = "plot")]
mod charts;
mod clear_windows;
mod crossing_probabilities;
mod crossings;
mod earthshine;
mod ephemeris;
mod forecast_reference;
mod frames;
mod horizons;
mod identify;
mod interruption;
mod lu2024_figures;
mod magnitude_sigma;
mod maps;
#[cfg(any(all(feature = "fits", unix), feature = "plot"))]
mod maps_files;
mod model_files;
mod mutated_files;
mod next_clear_start;
mod operator_ephemerides;
mod orbit_uncertainty;
mod overhead;
mod partly_lit;
mod passes_reference;
mod photometry_model;
mod photometry_panels;
mod radiation_pressure;
mod several_element_sets;
mod sgp4_verification;
mod shadow;
mod shells;
mod space_observers;
mod standard_magnitudes;
mod station_keeping;
mod statistics;
mod streak_cost;
