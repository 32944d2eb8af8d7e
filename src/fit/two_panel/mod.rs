//! The two-panel form of Lu (2024, section 2) as a fit: seven coefficients and the panel offset.
//!
//! `form` contains the satellite and the bounds of its coefficients, `prepared` the geometry of the points, `kernel`
//! the evaluation of coefficients on it.

mod form;
mod kernel;
mod prepared;

pub use form::TwoPanelForm;
