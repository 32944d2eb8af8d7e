//! Errors of streaks: their light, their images and masks.

use thiserror::Error;

use super::background::BackgroundError;
use super::count_scale::CountScaleError;
use super::optics::OpticsError;
use super::psf::BlurError;
use super::render::PathError;
use crate::passes::{FieldError, SkyError};

/// Errors of streaks: their light, their images and masks.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum StreaksError {
    /// A number that is out of range or none.
    #[error("{what} is {given} (allowed: {allowed})")]
    Modulation {
        /// Which number.
        what: &'static str,
        /// As given.
        given: f64,
        /// What is allowed.
        allowed: &'static str,
    },
    /// A light curve whose times do not grow, or of fewer than two points.
    #[error("light curve, point {point}: {problem}")]
    LightCurve {
        /// Counted from 1.
        point: usize,
        /// What is wrong, and what is allowed.
        problem: &'static str,
    },
    /// A number out of range.
    #[error("random streaks: {what} of {from} to {to} (allowed: {allowed})")]
    RandomStreaks {
        /// Which numbers.
        what: &'static str,
        /// The lower end as given.
        from: f64,
        /// The upper end as given.
        to: f64,
        /// What is allowed.
        allowed: &'static str,
    },
    /// No preset of this name.
    #[error("mask preset {given:?} is not known (allowed: {allowed})")]
    MaskPreset {
        /// As given.
        given: String,
        /// All of them.
        allowed: String,
    },
    /// All bits of a 32-bit mask are taken.
    #[error("the frame's own mask names planes in all bits up to {highest}: none is left for {plane}")]
    MaskBits {
        /// The plane that found none.
        plane: &'static str,
        /// The highest usable bit.
        highest: u32,
    },
    /// The sky has no answer.
    #[error(transparent)]
    Sky(#[from] SkyError),
    /// The chips span no field.
    #[error("the field of the frame's chips: {0}")]
    Field(#[from] FieldError),
    /// Its image has no form.
    #[error(transparent)]
    Optics(#[from] OpticsError),
    /// Its way is none.
    #[error("the way over HDU {hdu}: {source}")]
    Path {
        /// The chip's HDU.
        hdu: usize,
        /// What is wrong.
        source: PathError,
    },
    /// Background of a frame.
    #[error(transparent)]
    Background(#[from] BackgroundError),
    /// Zero point or exposure of a frame.
    #[error(transparent)]
    CountScale(#[from] CountScaleError),
    /// Profile of a light.
    #[error(transparent)]
    Blur(#[from] BlurError),
}
