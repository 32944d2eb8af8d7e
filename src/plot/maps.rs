//! Pictures of magnitude maps, of figures 6 to 9 of Lu (2024), and of HEALPix maps in the frame of a satellite with
//! several panels (as figures 2 and 4 of Lu 2024).

use std::collections::HashMap;
use std::f64::consts::FRAC_PI_2;

use super::error;
use super::picture::Picture;
use super::scale::Quantity;
use super::sky_disk::{AZIMUTHS, Disk, DiskContent, DiskSheet};
use crate::error::{Error, ErrorKind};
use crate::maps::{BodyView, Earth, Fact, FactValue, FigurePanel, PaperFigure, SkyView};
use crate::math::healpix::{MOST_NSIDE, cell_count, ring_cell};
use crate::photometry::{BrightnessModel, PhotometryOptions};

/// Radius of a single disk, and of each of three disks, pixels.
const ALONE: usize = 270;
const OF_THREE: usize = 210;

/// Limit of apparent magnitude that the IAU recommends to satellite operators, mag.
const LIMIT_MAG: f64 = 7.0;

/// Altitude, degrees, below which magnitudes with extinction do not determine the colour scale, because extinction
/// there amounts to whole magnitudes.
const LOW_DEG: f64 = 10.0;

/// Altitude at which the rim is evaluated, radians. On the horizon itself satellites have set and the airmass is
/// undefined.
const RIM_RAD: f64 = 1e-6;

const SKY_CAPTION: &str = "Zenith in the middle, horizon at the rim, east left.";
const BODY_CAPTION: &str = "Below the satellite, seen from above: nadir in the middle, longitudes from the Sun.";

/// Draws a map of the sky.
pub fn sky_picture(view: &SkyView<'_>) -> Picture {
    let facts = view.facts();
    let title = format!("{}, {}, {} km", apparent(&facts), text_of(&facts, "model"), tidy(view.height_km()));
    let site = match view.earth() {
        Earth::Sphere => String::new(),
        Earth::Ellipsoid(site) => format!(" Site: {}.", site.name),
    };
    let caption = format!("{SKY_CAPTION}{site}{}", conditions(&facts));
    let (altitude, azimuth) = (degrees(view.sun_altitude_rad()), degrees(view.sun_azimuth_rad()));
    let disk = sky_disk(view.clone(), format!("Sun at altitude {altitude}°, azimuth {azimuth}°"));
    drawn(title, caption, vec![disk], ALONE, sky_limit())
}

/// Draws a map of the directions below a satellite.
pub fn body_picture(view: &BodyView<'_>) -> Picture {
    let facts = view.facts();
    let disk = body_disk(view.clone(), format!("Sun at latitude {}°", degrees(view.sun_latitude_rad())));
    let title = format!("{}, {}", standard(&facts), text_of(&facts, "model"));
    let caption = format!("{BODY_CAPTION}{}", conditions(&facts));
    drawn(title, caption, vec![disk], ALONE, body_limit(view.height_km()))
}

/// Draws a figure of Lu (2024): three maps with a common colour scale, the Sun in the north, and a spherical Earth.
///
/// # Errors
/// A panel cannot be computed as a map.
pub fn paper_picture(
    figure: &PaperFigure,
    model: &BrightnessModel,
    options: PhotometryOptions,
) -> Result<Picture, Error> {
    let mut disks = Vec::new();
    let mut labels = (String::new(), "", String::new());
    let mut limit = sky_limit();
    for (panel, letter) in figure.panels.iter().zip(["a", "b", "c"]) {
        match *panel {
            FigurePanel::Body { sun_latitude_deg, height_km } => {
                let view = BodyView::new(model, sun_latitude_deg.to_radians(), height_km, options)?;
                let facts = view.facts();
                labels = (standard(&facts), BODY_CAPTION, conditions(&facts));
                limit = body_limit(height_km);
                let title = format!("({letter}) Sun at latitude {}°", degrees(view.sun_latitude_rad()));
                disks.push(body_disk(view, title));
            }
            FigurePanel::Sky { sun_altitude_deg, height_km } => {
                let sun_altitude_rad = sun_altitude_deg.to_radians();
                let view = SkyView::new(model, Earth::Sphere, height_km, 0.0, sun_altitude_rad, options)?;
                let facts = view.facts();
                labels = (format!("{}, {height_km} km", apparent(&facts)), SKY_CAPTION, conditions(&facts));
                let title = format!("({letter}) Sun at altitude {}°", degrees(view.sun_altitude_rad()));
                disks.push(sky_disk(view, title));
            }
        }
    }
    let title = format!("{}, {}", labels.0, model.source());
    let caption = format!("{} After figure {} of Lu (2024).{}", labels.1, figure.number, labels.2);
    Ok(drawn(title, caption, disks, OF_THREE, limit))
}

/// Draws disks with a contour line at a magnitude limit.
fn drawn(title: String, caption: String, disks: Vec<Disk<'_>>, radius: usize, limit: (f64, String)) -> Picture {
    DiskSheet {
        title,
        caption,
        disks,
        radius,
        disks_per_row: 3,
        contour_mag: Some(limit),
        nothing: "not lit",
        scale: None,
    }
    .picture()
}

/// Returns the magnitude of the contour line of a map of apparent magnitudes, and its label.
fn sky_limit() -> (f64, String) {
    (LIMIT_MAG, format!("{LIMIT_MAG} mag"))
}

/// Returns the magnitude of the contour line of a map of magnitudes at 1000 km, and its label. It corresponds to the
/// limit of apparent magnitude for an observer straight below, at a range of the satellite's height.
fn body_limit(height_km: f64) -> (f64, String) {
    // m₁₀₀₀ = m + 5 log₁₀(1000 km / h)
    let at_1000_km = LIMIT_MAG + 5.0 * (1000.0 / height_km).log10();
    (at_1000_km, format!("{at_1000_km:.1} mag: {LIMIT_MAG} mag from straight below"))
}

fn sky_disk(view: SkyView<'_>, title: String) -> Disk<'_> {
    let sun_longitude_rad = view.sun_azimuth_rad();
    let has_air = view.extinction_mag_per_airmass().is_some();
    Disk {
        title,
        quantity: Quantity::Magnitude,
        is_half: false,
        content: Box::new(move |azimuth, from_zenith| {
            let point = view.at(azimuth, (FRAC_PI_2 - from_zenith).max(RIM_RAD));
            match point.magnitude {
                Some(magnitude) => DiskContent::Value(magnitude.0),
                None if point.lit_fraction <= 0.0 => DiskContent::Shadow,
                None => DiskContent::Empty,
            }
        }),
        scaled_within_rad: if has_air { FRAC_PI_2 - LOW_DEG.to_radians() } else { FRAC_PI_2 },
        sun_longitude_rad: Some(sun_longitude_rad),
        rim: AZIMUTHS.to_vec(),
        circles: vec![(30.0, "60°".to_owned()), (60.0, "30°".to_owned())],
        limb_rad: None,
    }
}

fn body_disk(view: BodyView<'_>, title: String) -> Disk<'_> {
    let limb_rad = Some(FRAC_PI_2 + view.limb_latitude_rad());
    Disk {
        title,
        quantity: Quantity::Magnitude,
        is_half: false,
        content: Box::new(move |longitude, from_nadir| {
            view.at(longitude, from_nadir - FRAC_PI_2)
                .map_or(DiskContent::Empty, |magnitude| DiskContent::Value(magnitude.0))
        }),
        scaled_within_rad: FRAC_PI_2,
        sun_longitude_rad: Some(0.0),
        rim: vec![(0.0, "0°"), (90.0, "90°"), (180.0, "180°"), (270.0, "270°")],
        circles: vec![(30.0, "−60°".to_owned()), (60.0, "−30°".to_owned())],
        limb_rad,
    }
}

/// Returns text for the caption on extinction, earthshine, shadow and model, where they differ from the defaults.
fn conditions(facts: &[Fact]) -> String {
    let text = |name: &str| text_of(facts, name);
    let mut sentences = String::new();
    match text("extinction_mag_per_airmass").as_str() {
        "" => {}
        k => sentences.push_str(&format!(" Extinction {k} mag per airmass.")),
    }
    if text("earthshine") == "off" {
        sentences.push_str(" Sunlight only.");
    }
    if text("shadow") == "geometric" {
        sentences.push_str(" Shadow of the Earth without its atmosphere.");
    }
    match text("model_status").as_str() {
        "" => {}
        status => sentences.push_str(&format!(" The model is {status}.")),
    }
    sentences
}

/// Returns the label of the quantity of a sky map.
fn apparent(facts: &[Fact]) -> String {
    format!("Apparent magnitude {} ({})", text_of(facts, "band"), text_of(facts, "mag_system"))
}

/// Returns the label of the quantity of a body map.
fn standard(facts: &[Fact]) -> String {
    format!("Magnitude {} ({}) at 1000 km", text_of(facts, "band"), text_of(facts, "mag_system"))
}

fn text_of(facts: &[Fact], name: &str) -> String {
    let fact = facts.iter().find(|fact| fact.name == name);
    match fact.map(|fact| &fact.value) {
        Some(FactValue::Text(text)) => text.clone(),
        Some(FactValue::Real(number)) => number.to_string(),
        None => String::new(),
    }
}

/// Formats an angle in degrees with a true minus sign and as many decimals as needed.
fn degrees(angle_rad: f64) -> String {
    tidy(angle_rad.to_degrees()).replace('-', "−")
}

/// Formats a number with as many decimals as needed, three at most.
fn tidy(number: f64) -> String {
    ((number * 1e3).round() / 1e3).to_string()
}

/// Largest number of panels in one picture.
const MOST_PANELS: usize = 12;

/// HEALPix maps in a satellite's frame, in one or more panels.
#[derive(Clone, Debug)]
pub struct Layers<'a> {
    /// Title.
    pub title: &'a str,
    /// Caption below all panels; an explanation of the projection is added to it.
    pub caption: &'a str,
    /// HEALPix nside, 1 to 1024; the 12 nside² pixels are in RING order.
    pub nside: u32,
    /// If true, longitudes are folded to 0 to 180° and half disks are drawn.
    pub is_folded: bool,
    /// Panels, 1 to 12, in rows of four half disks or three disks.
    pub panels: Vec<LayerPanel<'a>>,
}

/// One disk, for one latitude of the Sun or for one quantity.
#[derive(Clone, Debug)]
pub struct LayerPanel<'a> {
    /// Title, for example `(a) Sun at latitude −14°`.
    pub title: &'a str,
    /// Quantity of the values, which determines the colours.
    pub quantity: Quantity,
    /// HEALPix pixels (RING number) and their values, which must be finite; counts must be 1 or more. A pixel is a
    /// direction of the observer: longitude from the Sun's azimuth and latitude above the plane of the chassis. Pixels
    /// above the plane are not drawn.
    pub cells: &'a [(u64, f64)],
}

/// Draws every panel in the projection of body maps: the nadir in the middle, the plane of the chassis at the rim, and
/// the Sun marked at longitude 0. Panels of the same quantity have the same colour scale; grey marks missing pixels.
///
/// # Errors
/// There is no panel or more than 12; no panel has a pixel; nside or a pixel number is invalid; a pixel occurs twice in
/// a panel; a value is not finite; or a count is below 1.
pub fn layers(input: &Layers<'_>) -> Result<Picture, Error> {
    let out = |what: &str, given: String, allowed| Err(Error::invalid(what, given, allowed));
    if !(1..=MOST_PANELS).contains(&input.panels.len()) {
        return out("the number of panels", input.panels.len().to_string(), "1 to 12");
    }
    if !(1..=MOST_NSIDE).contains(&input.nside) {
        return out("nside", input.nside.to_string(), "1 to 1024");
    }
    if input.panels.iter().all(|panel| panel.cells.is_empty()) {
        return Err(Error::new(ErrorKind::TooFewData, "nothing to draw: no cells in any panel"));
    }
    let disks = input.panels.iter().map(|panel| disk(input, panel)).collect::<Result<Vec<_>, _>>()?;
    let is_mixed = input.panels.iter().any(|panel| panel.quantity != input.panels[0].quantity);
    let disks_per_row = if input.is_folded { 4 } else { 3 };
    let meaning = match input.panels.iter().any(|panel| panel.quantity == Quantity::Residual) {
        true => " O−C above 0 (red): observed fainter than computed.",
        false => "",
    };
    let fold = if input.is_folded { ", folded to 0–180°" } else { "" };
    let caption = format!(
        "{} Nadir in the middle, plane of the chassis at the rim; longitudes from the Sun{fold}. HEALPix cells, nside {}.{meaning}",
        input.caption, input.nside
    );
    let columns = disks_per_row.min(disks.len());
    let sheet = DiskSheet {
        title: input.title.to_owned(),
        caption: caption.trim().to_owned(),
        radius: radius(columns, disks.len().div_ceil(columns), input.is_folded, is_mixed),
        disks,
        disks_per_row,
        contour_mag: None,
        nothing: "no cell",
        scale: None,
    };
    Ok(sheet.picture())
}

/// Returns the largest radius, in pixels, for which the picture stays within 1600 pixels on both sides.
fn radius(columns: usize, rows: usize, is_folded: bool, is_mixed: bool) -> usize {
    let bars = if is_mixed { columns } else { 1 };
    let across = (1600 - 120 * bars).saturating_sub(132 * columns) / columns / if is_folded { 1 } else { 2 };
    let down = (1600_usize - 190).saturating_sub(164 * rows) / rows / 2;
    across.min(down).min(270)
}

fn disk<'a>(input: &Layers<'_>, panel: &LayerPanel<'a>) -> Result<Disk<'a>, Error> {
    let mut value_of = HashMap::with_capacity(panel.cells.len());
    for (index, &(cell, value)) in panel.cells.iter().enumerate() {
        let what = || format!("cell {cell} of panel {}", panel.title);
        if cell >= cell_count(input.nside) {
            let what = format!("cell {index} (counted from 0) of panel {}", panel.title);
            return Err(Error::invalid(what, cell, "below 12 nside²"));
        }
        if !value.is_finite() {
            return Err(error::not_finite(&format!("cells of panel {}", panel.title), index, value));
        }
        if panel.quantity == Quantity::Count && value < 1.0 {
            return Err(Error::invalid(what(), value, "1 sample or more"));
        }
        if value_of.insert(cell, value).is_some() {
            return Err(Error::invalid(what(), "given twice", "once"));
        }
    }
    let nside = input.nside;
    let mut rim = vec![(0.0, "0°"), (90.0, "90°"), (180.0, "180°")];
    if !input.is_folded {
        rim.push((270.0, "270°"));
    }
    Ok(Disk {
        title: panel.title.to_owned(),
        quantity: panel.quantity,
        is_half: input.is_folded,
        content: Box::new(move |longitude, from_nadir| {
            let cell = ring_cell(nside, longitude, from_nadir - FRAC_PI_2);
            cell.and_then(|cell| value_of.get(&cell)).map_or(DiskContent::Empty, |value| DiskContent::Value(*value))
        }),
        scaled_within_rad: FRAC_PI_2,
        sun_longitude_rad: Some(0.0),
        rim,
        circles: vec![(30.0, "−60°".to_owned()), (60.0, "−30°".to_owned())],
        limb_rad: None,
    })
}
