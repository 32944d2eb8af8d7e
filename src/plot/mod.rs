//! Maps and charts as pictures, PNG and SVG.
//!
//! `picture` is a list of lines, words and pixels, and `encode` makes a file of it. `scale` gives values colours, `contour` draws lines of equal
//! value. `disc` projects a half sphere on a disc and `disc_sheet` lays discs, colour bars and words out; `maps` makes pictures of the room
//! [`maps`](crate::maps) and of the paper's figures 6 to 9, `layers` of HEALPix cells. Charts stand on `axes` (a box with ticks), `bar` (of colours), `numbers` (how
//! they are written), `statistics`, `density` (how many points lie where) and `dots`: `corner`, `histogram`, `counts_and_spread`, `phase_curve`
//! and `residual_panels`. Charts for observers are `night` and `light_curve` (on `time_axis`, with `twilight` behind), `field_chart` and `sky_chart`
//! (with the numbers and lists of `tracks`), `sky_rate`, `equatorial_rate` and `sun_altitude`.

mod axes;
mod bar;
mod contour;
mod corner;
mod counts_and_spread;
mod density;
mod disc;
mod disc_sheet;
mod dots;
mod encode;
mod equatorial_rate;
mod error;
mod field_chart;
mod font;
mod histogram;
mod layers;
mod light_curve;
mod maps;
mod night;
mod numbers;
mod phase_curve;
mod picture;
mod residual_panels;
mod scale;
mod sky_chart;
mod sky_rate;
mod statistics;
mod sun_altitude;
mod time_axis;
mod tracks;
mod twilight;

pub use corner::{Corner, corner};
pub use counts_and_spread::{CountsAndSpread, counts_and_spread};
pub use disc::{Disc, Seen};
pub use disc_sheet::DiscSheet;
pub use encode::{PictureFormat, data_url};
pub use equatorial_rate::{EquatorialRate, equatorial_rate};
pub use error::PlotError;
pub use field_chart::{FieldChart, FieldStreak, field_chart};
pub use histogram::{ResidualHistogram, residual_histogram};
pub use layers::{LayerPanel, Layers, layers};
pub use light_curve::{LightCurve, light_curve};
pub use maps::{body_picture, paper_picture, sky_picture};
pub use night::{NightTimeline, night_timeline};
pub use phase_curve::{PhaseCurve, phase_curve};
pub use picture::Picture;
pub use residual_panels::{ResidualPanels, residual_panels};
pub use scale::{ColourScale, Quantity};
pub use sky_chart::{SkyChart, SkyTrack, sky_chart};
pub use sky_rate::{SkyRate, sky_rate};
pub use sun_altitude::{SunAltitude, sun_altitude};
pub use time_axis::LocalClock;
