//! What a count is worth: zero point, gain, read noise, saturation, band.

use super::super::header::Header;
use super::moment::Keywords;

/// A value and the keyword that said it.
#[derive(Clone, Debug, PartialEq)]
pub struct Stated<T> {
    /// The value.
    pub value: T,
    /// The keyword, or several of them.
    pub keyword: String,
}

/// Which counts a zero point is for.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum CountBasis {
    /// Those of the frame as it is: a source whose pixels sum to 1 has the magnitude of the zero point.
    Frame,
    /// Those of a second: the sum over the pixels is divided by the length of the exposure first.
    Second,
}

/// A magnitude zero point.
#[derive(Clone, Debug, PartialEq)]
pub struct ZeroPoint {
    /// Magnitude of a source of one count.
    pub mag: f64,
    /// Counts of what; `None` where neither the keyword nor its comment settles it: whoever uses it must be told.
    pub basis: Option<CountBasis>,
    /// The keyword.
    pub keyword: String,
}

/// What pixels hold.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum PixelUnit {
    /// Counts, or what is not said.
    Counts,
    /// Electrons.
    Electrons,
    /// A flux, calibrated: nanomaggies, janskys.
    Flux,
}

/// A unit as BUNIT spells it, and whether it is one a second.
fn parsed_unit(text: &str) -> (PixelUnit, bool) {
    let unit = text.to_ascii_lowercase().replace([' ', '*', '^', '(', ')'], "");
    let ends = ["/second", "/sec", "/s", "second-1", "sec-1", "s-1", "persecond", "persec"];
    let bare = ends.iter().find_map(|end| unit.strip_suffix(end));
    let name = bare.unwrap_or(&unit).trim_end_matches(['.', '/']);
    let kind = match name {
        "e" | "e-" | "electron" | "electrons" | "photon" | "photons" => PixelUnit::Electrons,
        "nanomaggy" | "nanomaggies" | "nmgy" | "jy" | "mjy" | "ujy" | "njy" | "microjy" | "nanojy" => PixelUnit::Flux,
        _ => PixelUnit::Counts,
    };
    (kind, bare.is_some())
}

/// What a header says of its detector and its photometry; each with the keyword that said it, `None` where nothing does or it makes no sense (a gain of 0).
#[derive(Clone, Debug, PartialEq)]
pub struct Calibration {
    /// Magnitude zero point.
    pub zero_point: Option<ZeroPoint>,
    /// Electrons of one count; of two amplifiers the mean.
    pub gain_e_adu: Option<Stated<f64>>,
    /// Read noise, electrons; of two amplifiers the mean.
    pub read_noise_e: Option<Stated<f64>>,
    /// Where pixels saturate, counts; of two amplifiers the lower one.
    pub saturation_adu: Option<Stated<f64>>,
    /// Filter or band, as it is written.
    pub band: Option<Stated<String>>,
    /// BUNIT, the unit of the pixels.
    pub unit: Option<Stated<String>>,
    /// What that is; counts where nothing is said.
    pub pixel_unit: PixelUnit,
    /// True where pixels hold what came in a second, not in the whole exposure.
    pub is_rate: bool,
}

/// Zero points under their names, and what those who write them mean.
///
/// MAGZERO: the community pipeline of DECam and Mosaic, 1 ADU in a second (25.1 in g is what DECam's throughput of 26.6 for an electron and its gain of
/// 4 give). MAGZP: ZTF and 2MASS, 1 DN of the frame. The others are used both ways.
const ZERO_POINTS: &[(&str, Option<CountBasis>)] = &[
    ("MAGZERO", Some(CountBasis::Second)),
    ("MAGZP", Some(CountBasis::Frame)),
    ("MAGZPT", None),
    ("PHOTZP", None),
    ("ZP", None),
    ("ZEROPT", None),
];

/// A nanomaggy is this magnitude (SDSS, Legacy Surveys).
const NANOMAGGY_MAG: f64 = 22.5;

impl Calibration {
    /// From the headers of a frame in the order in which they count: that of the image, then the primary one.
    pub fn from_headers(headers: &[&Header]) -> Self {
        let keywords = Keywords(headers);
        let (pixel_unit, is_rate) =
            keywords.text(&["BUNIT"]).map_or((PixelUnit::Counts, false), |(_, unit)| parsed_unit(&unit));
        let stated_text = |names: &[&str]| keywords.text(names).map(|(keyword, value)| Stated { value, keyword });
        Self {
            zero_point: zero_point(keywords),
            gain_e_adu: gain(keywords),
            read_noise_e: of_amplifiers(
                keywords,
                &["RDNOISE", "READNOIS", "READNOISE", "RON", "RONOISE", "ENOISE"],
                &["RDNOISEA", "RDNOISEB"],
                mean,
            ),
            saturation_adu: of_amplifiers(
                keywords,
                &["SATURATE", "SATURAT", "SATLEVEL", "SATURATION"],
                &["SATURATA", "SATURATB"],
                f64::min,
            ),
            band: stated_text(&["FILTER", "BAND", "FILTNAM", "FILTER01", "FILTER1", "INSFLNAM", "FILTERS", "FILTER2"]),
            unit: stated_text(&["BUNIT"]),
            pixel_unit,
            is_rate,
        }
    }
}

fn mean(a: f64, b: f64) -> f64 {
    (a + b) / 2.0
}

/// A number under one of its names, else from both amplifiers.
fn of_amplifiers(
    keywords: Keywords<'_>,
    names: &[&str],
    pair: &[&str; 2],
    join: impl Fn(f64, f64) -> f64,
) -> Option<Stated<f64>> {
    let positive = |number: f64| number > 0.0;
    if let Some((keyword, value, _)) = keywords.number(names, positive) {
        return Some(Stated { value, keyword });
    }
    let [first, second] = pair.map(|name| keywords.number(&[name], positive));
    let ((a, value_a, _), (b, value_b, _)) = (first?, second?);
    Some(Stated { value: join(value_a, value_b), keyword: format!("{a}, {b}") })
}

/// Electrons of a count; a comment may say that it is the other way round.
fn gain(keywords: Keywords<'_>) -> Option<Stated<f64>> {
    let positive = |number: f64| number > 0.0;
    if let Some((keyword, value, comment)) = keywords.number(&["EGAIN", "GAIN", "HIERARCH GAIN", "CCDGAIN"], positive) {
        let comment = comment.to_ascii_lowercase().replace(' ', "");
        let is_inverse = ["adu/e", "dn/e", "aduperelectron", "counts/e"].iter().any(|words| comment.contains(words));
        return Some(Stated { value: if is_inverse { value.recip() } else { value }, keyword });
    }
    of_amplifiers(keywords, &[], &["GAINA", "GAINB"], mean)
}

fn zero_point(keywords: Keywords<'_>) -> Option<ZeroPoint> {
    let unit =
        keywords.text(&["BUNIT"]).map(|(_, unit)| unit.to_ascii_lowercase().replace(' ', "")).unwrap_or_default();
    if unit == "nanomaggy" || unit == "nanomaggies" || unit == "nmgy" {
        return Some(ZeroPoint { mag: NANOMAGGY_MAG, basis: Some(CountBasis::Frame), keyword: "BUNIT".to_owned() });
    }
    // Frames of the LSST pipelines: counts of a source of magnitude 0.
    if let Some((keyword, flux, _)) = keywords.number(&["FLUXMAG0"], |flux| flux > 0.0) {
        return Some(ZeroPoint { mag: 2.5 * flux.log10(), basis: Some(CountBasis::Frame), keyword });
    }
    let is_magnitude = |number: f64| number != 0.0 && number.is_finite() && number.abs() < 60.0;
    ZERO_POINTS.iter().find_map(|(name, meant)| {
        let (keyword, mag, comment) = keywords.number(&[name], is_magnitude)?;
        let comment = comment.to_ascii_lowercase();
        let is_said = ["/s", "per sec", "1 sec", "s-1", "s^-1"].iter().any(|words| comment.contains(words));
        let said = is_said.then_some(CountBasis::Second);
        // Pixels that are rates already: the frame's own counts are those of a second.
        let is_rate = parsed_unit(&unit).1;
        let basis = if is_rate { Some(CountBasis::Frame) } else { said.or(*meant) };
        Some(ZeroPoint { mag, basis, keyword })
    })
}
