//! Names of sites and of telescopes in orbit in headers.

use crate::geometry::Site;

use super::super::moment::Keywords;

/// Cameras of one telescope. Other instruments have names of sites elsewhere: FAST is a spectrograph in Arizona, and a
/// radio telescope in China.
const CAMERAS: [&str; 6] = ["DECam", "HSC", "Hyper Suprime-Cam", "DESI", "ZTF", "Tomo-e Gozen"];
/// Keyword of the instrument.
const INSTRUMENT: &str = "INSTRUME";
/// Keywords with names of sites, in order of precedence.
const NAMES: [&str; 7] = [INSTRUMENT, "TELESCOP", "OBSERVAT", "OBSERVATORY", "SITENAME", "SITE", SITE_CODE];
/// Keyword of codes such as `coj` (Las Cumbres Observatory). Numbers are no codes of the Minor Planet
/// Center in this keyword, because they have another meaning in other headers.
const SITE_CODE: &str = "SITEID";
/// Codes of the sites of the Las Cumbres Observatory.
const LAS_CUMBRES: [&str; 7] = ["coj", "cpt", "elp", "lsc", "ogg", "tfn", "tlv"];
/// Telescopes in space, except [`WISE`]. Those about the Sun have ephemerides, and no element sets.
const IN_ORBIT: [&str; 19] = [
    "HST", "JWST", "NEOSSat", "TESS", "SWIFT", "XMM", "CHEOPS", "NEOWISE", "EUCLID", "SPHEREx", "GALEX", "CHANDRA",
    "SPITZER", "KEPLER", "INTEGRAL", "NUSTAR", "ASTROSAT", "SVOM", "AKARI",
];
/// The telescope in space. In other letters this is a site on the Earth.
const WISE: &str = "WISE";

/// Name in a header that is one of a site or begins with it.
pub(super) struct NameOfSite {
    /// Keyword and text.
    pub shown: String,
    /// Sites that it can mean: at least one.
    pub sites: Vec<&'static Site>,
    /// True if only the first word is the name of a site, as in "CTIO 1.0 meter telescope".
    pub is_first_word: bool,
}

impl NameOfSite {
    /// Returns the distance of a site from the nearest one of the name, km.
    pub(super) fn distance_km(&self, site: &Site) -> f64 {
        self.sites.iter().map(|own| own.distance_km(site)).fold(f64::INFINITY, f64::min)
    }
}

/// Returns the names of sites in the headers, in order of precedence.
pub(super) fn names_of_sites(keywords: Keywords<'_>) -> Vec<NameOfSite> {
    // The primary header and that of the image may have different names.
    let texts = NAMES.iter().flat_map(|keyword| keywords.texts(keyword).into_iter().map(move |text| (*keyword, text)));
    let names = texts.filter_map(|(keyword, text)| {
        let is_one_of = |known: &[&str]| known.iter().any(|name| name.eq_ignore_ascii_case(&text));
        let shown = format!("{keyword} {text:?}");
        let sites = match keyword {
            _ if is_no_site(&text) => return None,
            SITE_CODE if is_one_of(&LAS_CUMBRES) => Site::with_key(&text),
            SITE_CODE => return None,
            INSTRUMENT if !is_one_of(&CAMERAS) => return None,
            _ => Site::candidates(&text),
        };
        let is_first_word = sites.is_empty();
        let first_word = text.split([' ', ',', '/']).next().unwrap_or_default();
        let sites = if is_first_word { Site::with_key(first_word) } else { sites };
        (!sites.is_empty()).then_some(NameOfSite { shown, sites, is_first_word })
    });
    names.collect()
}

/// Returns the name of the telescope or else of the observatory; `None` if the headers have none.
pub(super) fn name_of_telescope(keywords: Keywords<'_>) -> Option<String> {
    let mut names = ["TELESCOP", "OBSERVAT"].iter().filter_map(|name| keywords.text(&[name]));
    names.find(|(_, text)| !is_no_site(text)).map(|(_, name)| name)
}

/// Returns the text of TELESCOP if it is the name of a telescope in orbit.
pub(super) fn telescope_in_orbit(keywords: Keywords<'_>) -> Option<String> {
    let (_, name) = keywords.text(&["TELESCOP"])?;
    let is_in_orbit = name == WISE || IN_ORBIT.iter().any(|known| known.eq_ignore_ascii_case(&name));
    is_in_orbit.then_some(name)
}

/// Returns true for a text in place of the name of a site: "NOT SET" and "Not connected" of mounts (NOT alone is the
/// Nordic Optical Telescope), WISE in capitals, the telescope in space, and Vista in small letters, a mount.
fn is_no_site(text: &str) -> bool {
    let lower = text.to_ascii_lowercase();
    let is_denied = lower.strip_prefix("not ").is_some_and(|rest| rest.starts_with(|c: char| c.is_ascii_lowercase()));
    is_denied || text == WISE || text == "Vista"
}
