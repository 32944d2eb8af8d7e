//! Sun positions and heights of the panels of figures 6 to 9 of Lu (2024), section 5.

/// One panel of a figure.
#[derive(Copy, Clone, Debug, PartialEq)]
pub enum FigurePanel {
    /// Map of standard magnitudes below a satellite.
    Body {
        /// The Sun's latitude above the plane of the chassis, degrees.
        sun_latitude_deg: f64,
        /// Height of the satellite, km.
        height_km: f64,
    },
    /// Map of apparent magnitudes over the sky.
    Sky {
        /// The Sun's altitude above the horizon, degrees.
        sun_altitude_deg: f64,
        /// Height of the satellites, km.
        height_km: f64,
    },
}

/// A figure of three panels, (a) to (c).
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct PaperFigure {
    /// Number of the figure in the paper.
    pub number: u8,
    /// Panels in the order of decreasing altitude of the Sun.
    pub panels: [FigurePanel; 3],
    /// Range of magnitudes that the caption states; `None` for figure 6, whose caption states none.
    pub stated_range_mag: Option<[f64; 2]>,
    /// Altitude of the Sun down to which satellites are visible according to the caption, degrees; `None` for figure 6.
    pub stated_last_sun_deg: Option<f64>,
}

const fn body(sun_latitude_deg: f64) -> FigurePanel {
    FigurePanel::Body { sun_latitude_deg, height_km: 550.0 }
}

const fn sky(height_km: f64, sun_altitude_deg: f64) -> FigurePanel {
    FigurePanel::Sky { sun_altitude_deg, height_km }
}

/// Figures 6 to 9 of Lu (2024).
pub const PAPER_FIGURES: [PaperFigure; 4] = [
    PaperFigure {
        number: 6,
        panels: [body(-8.0), body(-14.0), body(-20.0)],
        stated_range_mag: None,
        stated_last_sun_deg: None,
    },
    PaperFigure {
        number: 7,
        panels: [sky(550.0, -8.0), sky(550.0, -16.0), sky(550.0, -24.0)],
        stated_range_mag: Some([5.0, 9.0]),
        stated_last_sun_deg: Some(-30.0),
    },
    PaperFigure {
        number: 8,
        panels: [sky(340.0, -6.0), sky(340.0, -12.0), sky(340.0, -18.0)],
        stated_range_mag: Some([4.0, 8.0]),
        stated_last_sun_deg: Some(-21.0),
    },
    PaperFigure {
        number: 9,
        panels: [sky(1200.0, -18.0), sky(1200.0, -26.0), sky(1200.0, -34.0)],
        stated_range_mag: Some([6.0, 10.0]),
        stated_last_sun_deg: Some(-40.0),
    },
];
