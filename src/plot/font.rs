//! The one font of all pictures: DejaVu Sans, cut down to Latin, Greek and a few signs, its licence beside it.

use std::sync::OnceLock;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use plotters::style::{FontStyle, register_font};

use super::error::PlotError;

/// DejaVu Sans 2.37 as matplotlib 3.11.2 brings it, through fonttools 4.68.0 (`pyftsubset`, unhinted) on 2026-11-21.
const DEJAVU_SANS: &[u8] = include_bytes!("fonts/DejaVuSans-subset.ttf");

/// The name under which it is known to the drawing crate, and in SVG.
pub(super) const FAMILY: &str = "DejaVu Sans";

/// The style sheet that brings the font along in an SVG. Viewers that take no fonts from files have a sans serif of their own.
pub(super) fn style_sheet() -> String {
    let bytes = STANDARD.encode(DEJAVU_SANS);
    format!(
        "<style>@font-face{{font-family:\"{FAMILY}\";src:url(data:font/ttf;base64,{bytes}) format(\"truetype\")}}\
         text{{font-family:\"{FAMILY}\",sans-serif}}</style>"
    )
}

/// Makes the font known, once a process.
pub(super) fn make_ready() -> Result<(), PlotError> {
    static READY: OnceLock<bool> = OnceLock::new();
    let is_ready = READY.get_or_init(|| register_font(FAMILY, FontStyle::Normal, DEJAVU_SANS).is_ok());
    if *is_ready { Ok(()) } else { Err(PlotError::Drawing("the built-in font could not be read".to_owned())) }
}
