//! Tests of the command line program.

mod common;

mod annotate_formats;
mod bad_input;
#[cfg(unix)]
mod bounded_input;
mod doctor;
mod element_ages;
mod ephemeris;
mod fetch;
mod fit;
mod forecast;
mod gate;
mod growth;
#[cfg(unix)]
mod help;
#[cfg(all(unix, not(target_os = "macos")))]
mod home;
mod identify;
#[cfg(unix)]
mod infrared;
mod inject;
#[cfg(unix)]
mod inject_chosen;
#[cfg(unix)]
mod inject_detector;
#[cfg(unix)]
mod inject_outputs;
mod inject_psf;
#[cfg(unix)]
mod inject_raw;
#[cfg(unix)]
mod killed;
mod learn;
mod magnitudes;
mod main_job;
mod maps;
#[cfg(unix)]
mod mask;
#[cfg(unix)]
mod measure;
#[cfg(unix)]
mod measure_real;
mod measure_tables;
mod opsim;
mod plot;
#[cfg(unix)]
mod reports;
mod reproduce;
#[cfg(unix)]
mod serve;
#[cfg(unix)]
mod serve_errors;
mod settings;
mod shorthands;
mod space_observer;
mod statistics;
mod tips;
mod unknown;
#[cfg(unix)]
mod user_files;
mod windows;
