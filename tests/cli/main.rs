//! Tests of the command line program.

#[path = "../common/mod.rs"]
mod common;

mod annotate_formats;
mod bad_input;
#[cfg(unix)]
mod bounded_input;
#[cfg(feature = "cli")]
mod doctor;
mod element_ages;
mod ephemeris;
#[cfg(feature = "fetch")]
mod fetch;
#[cfg(feature = "fit")]
mod fit;
mod forecast;
mod gate;
#[cfg(all(feature = "fit", feature = "fits", unix, feature = "plot", feature = "serve", feature = "fetch"))]
mod help;
#[cfg(all(feature = "fetch", unix, not(target_os = "macos")))]
mod home;
#[cfg(feature = "cli")]
mod identify;
#[cfg(all(feature = "cli", feature = "fits", unix))]
mod inject;
#[cfg(all(feature = "cli", feature = "fits", unix))]
mod inject_detector;
#[cfg(all(feature = "cli", feature = "fits", unix))]
mod inject_outputs;
#[cfg(all(feature = "cli", feature = "fits", unix))]
mod inject_raw;
#[cfg(unix)]
mod killed;
#[cfg(feature = "fit")]
mod learn;
mod magnitudes;
mod main_job;
mod maps;
#[cfg(all(feature = "cli", feature = "fits", unix))]
mod mask;
#[cfg(all(feature = "cli", feature = "fits", unix))]
mod measure;
#[cfg(all(feature = "cli", feature = "fits", unix))]
mod measure_real;
#[cfg(feature = "sqlite")]
mod opsim;
#[cfg(feature = "plot")]
mod plot;
#[cfg(all(feature = "cli", feature = "fits", feature = "sqlite", unix))]
mod reports;
mod reproduce;
#[cfg(all(feature = "serve", unix))]
mod serve;
#[cfg(all(feature = "serve", unix))]
mod serve_errors;
mod settings;
mod shorthands;
mod space_observer;
mod unknown;
#[cfg(unix)]
mod user_files;
mod windows;
