//! Choice of the site among the positions and names in headers.

use crate::error::Error;
use crate::geometry::{SAME_SITE_KM, Site};
use crate::images::header::Header;
use crate::message::listed;

use super::super::moment::Keywords;
use super::coordinates::compared;
use super::names::{NameOfSite, names_of_sites, telescope_in_orbit};
use super::positions::{OBSGEO, UNNAMED_SITE, codes, difference_of_positions, positions};

/// Description of the keywords, for errors.
pub const SITE_KEYWORDS: &str =
    "OBSGEO-X, -Y, -Z; OBSGEO-B, -L, -H; MPC-CODE; or a known site in INSTRUME, TELESCOP or OBSERVAT";

/// Site in the headers of a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct HeaderSite {
    /// The site.
    pub site: Site,
    /// Sentences about latitudes and longitudes that differ from the site or fit it only in another sense, about sites
    /// nearby, and about an unknown code of the Minor Planet Center.
    pub remark: Option<String>,
}

/// Largest distance of two sites of a header, km, such as a mountain and a telescope on it: satellites 500 km away move
/// by 0.3 deg.
const LARGEST_KM: f64 = 3.0;

/// Returns the site in the headers of a frame; `None` if they have no site. The headers are given in the order of
/// precedence: first the header of the image, then the primary header.
///
/// OBSGEO-X, -Y and -Z take precedence over OBSGEO-B, -L and -H. Without these, the site is the first known site among
/// the names of instrument, telescope and observatory. SITELONG, OBS-LONG and similar keywords do not give the
/// site, because no standard defines their sign and unit, and both signs are in use; they must not contradict it.
///
/// # Errors
/// A position that is not on the Earth; names and positions more than 3 km apart; SITELAT, SITELONG, ... of another
/// place; a name that fits several sites, such as ATLAS, without a keyword that decides between them; or a telescope in
/// orbit. Names of several sites and first words of names do not contradict a position: they are also those of mounts.
pub fn site_from_headers(headers: &[&Header]) -> Result<Option<HeaderSite>, Error> {
    let keywords = Keywords(headers);
    // Sites with the keywords that give them, in order of precedence.
    let mut stated = positions(keywords)?;
    let (of_codes, unknown_code) = codes(keywords);
    stated.extend(of_codes);
    let is_position = !stated.is_empty();
    // Names of several sites, and first words of names.
    let mut unclear: Vec<NameOfSite> = Vec::new();
    for name in names_of_sites(keywords) {
        // The latitude and the longitude decide between the sites of a network.
        let fits = |site: &&&Site| name.sites.len() == 1 || compared(keywords, site, true).is_ok();
        match name.sites.iter().filter(fits).collect::<Vec<_>>()[..] {
            [site] if !name.is_first_word => stated.push((name.shown, (*site).clone())),
            _ => unclear.push(name),
        }
    }
    let networks: Vec<&NameOfSite> = unclear.iter().filter(|name| !name.is_first_word).collect();
    // "Gemini" and "Cerro Pachon" have one site in common.
    if let ([], [first, others @ ..]) = (&stated[..], &networks[..]) {
        let is_of = |site: &Site, name: &NameOfSite| name.distance_km(site) <= SAME_SITE_KM;
        let common = first.sites.iter().filter(|site| others.iter().all(|name| is_of(site, name)));
        if let [site] = common.collect::<Vec<_>>()[..] {
            stated.push((first.shown.clone(), (*site).clone()));
        }
    }
    let Some((first_from, first)) = stated.first() else {
        return match (networks.first(), unknown_code, telescope_in_orbit(keywords)) {
            (Some(name), ..) => {
                let given = format!("one of several sites: {}", listed(name.sites.iter().map(|site| &*site.name)));
                Err(Error::invalid(&name.shown, given, "the name of one site, or for example --site or --mpc"))
            }
            (None, Some((name, code)), _) => {
                let allowed =
                    "a known code of the Minor Planet Center, or for example --site, --mpc or --lat and --lon";
                Err(Error::unknown(name, &code, allowed))
            }
            (None, None, Some(telescope)) => {
                let allowed = "--observer-elements with its element sets or its ephemeris";
                Err(Error::invalid(format!("TELESCOP {telescope:?}"), "a telescope in orbit", allowed))
            }
            (None, None, None) => Ok(None),
        };
    };
    // Distances of the other sites, and whether they contradict the first one.
    let of_stated = stated[1..].iter().map(|(from, site)| (from, site.distance_km(first), true));
    // Mounts have names of observatories, too, such as Gemini and Atlas: they do not contradict a position.
    let of_unclear = unclear.iter().map(|name| (&name.shown, name.distance_km(first), !is_position));
    let others: Vec<(&String, f64, bool)> = of_stated.chain(of_unclear).collect();
    if let Some((from, distance_km, _)) = others.iter().find(|other| other.2 && other.1 > LARGEST_KM) {
        let given = format!("{distance_km:.0} km from that of {from}");
        let allowed = format!("one site within {LARGEST_KM} km, or for example --site, --mpc or --lat and --lon");
        return Err(Error::invalid(format!("site of {first_from}"), given, allowed));
    }
    let other = others.iter().find(|other| other.1 > SAME_SITE_KM).map(|(from, distance_km, _)| {
        let digits = usize::from(*distance_km < 10.0);
        format!(
            "the site is that of {first_from}, {distance_km:.digits$} km from that of {from}; for another one specify --site"
        )
    });
    let is_named = stated.iter().any(|(from, _)| !from.starts_with(OBSGEO)) || !networks.is_empty();
    let mut remarks = compared(keywords, first, is_named).map_err(|given| {
        let allowed = "the coordinates of this site, or for example --site, --mpc or --lat and --lon";
        Error::invalid(format!("site of {first_from}"), given, allowed)
    })?;
    let mut site = first.clone();
    // The name is not that of this position.
    if first_from.starts_with(OBSGEO) && other.is_some() {
        site.name = UNNAMED_SITE.to_owned();
    }
    remarks.extend(other);
    remarks
        .extend(unknown_code.map(|(name, code)| {
            format!("{name} {code:?} is no known code of the Minor Planet Center: it is not used")
        }));
    if remarks.is_empty() {
        remarks.extend(difference_of_positions(keywords));
    }
    Ok(Some(HeaderSite { site, remark: (!remarks.is_empty()).then(|| remarks.join("; ")) }))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(headers: &[&Header]) -> Result<Option<Site>, Error> {
        site_from_headers(headers).map(|found| found.map(|found| found.site))
    }

    fn site(text: &str) -> Result<Option<Site>, Error> {
        found(&[&Header::from_text(text), &Header::from_text("OBSERVAT= 'CTIO'\n")])
    }

    fn remark(text: &str) -> Result<String, String> {
        let found = site_from_headers(&[&Header::from_text(text)]).map_err(|error| error.to_string())?;
        Ok(found.and_then(|found| found.remark).unwrap_or_default())
    }

    /// Names of different sites in the headers of the image and of the file are an error, and other positions are
    /// stated.
    #[test]
    fn valid_sites_of_two_headers_are_compared() {
        let read = |image: &str, primary: &str| {
            let [image, primary] = [image, primary].map(Header::from_text);
            let found = site_from_headers(&[&image, &primary]).map_err(|error| error.to_string())?;
            Ok::<String, String>(found.and_then(|found| found.remark).unwrap_or_default())
        };
        let error = read("TELESCOP= 'VST'", "TELESCOP= 'Subaru'").unwrap_err();
        assert!(error.contains("TELESCOP \"VST\"") && error.contains("TELESCOP \"Subaru\""), "{error}");
        assert_eq!(read("TELESCOP= 'Subaru'", "TELESCOP= 'Subaru'"), Ok(String::new()));
        assert_eq!(read("TELESCOP= 'Subaru'", "TELESCOP= 'my telescope'"), Ok(String::new()));
        let position = "OBSGEO-B= 30.0\nOBSGEO-L= -110.0\nOBSGEO-H= 1000.0\n";
        let remark = read(position, &position.replace("30.0", "31.0"));
        assert!(remark.is_ok_and(|remark| remark.contains("OBSGEO-B is 30 in the header of the image, and 31")));
    }

    #[test]
    fn unknown_codes_are_stated() {
        for code in ["'Z99'", "999.5"] {
            assert!(
                remark(&format!("OBSERVAT= 'CTIO'\nMPC-CODE= {code}")).unwrap().contains("is no known code"),
                "{code}"
            );
        }
        for code in ["'807'", "'none'"] {
            assert_eq!(remark(&format!("OBSERVAT= 'CTIO'\nMPC-CODE= {code}")).unwrap(), "", "{code}");
        }
    }

    /// Longitudes to the west or in hours beside a position or a name.
    #[test]
    fn longitudes_in_other_senses_are_stated() {
        let position = "OBSGEO-B= 30.0\nOBSGEO-L= -110.0\nOBSGEO-H= 1000.0\n";
        for (text, expected) in [
            (format!("{position}LONGITUD= 110.0"), "LONGITUD is 110, which is read as counted to the west"),
            (
                format!("{position}SITELONG= '+110 00 00'"),
                "SITELONG is \"+110 00 00\", which is read as counted to the west",
            ),
            ("OBSERVAT= 'Palomar'\nLONGITUD= '07:47:27'".to_owned(), "read as in hours, counted to the west"),
            ("OBSERVAT= 'CTIO'\nOBS-LONG= 70.81489 / [deg] east longitude".to_owned(), "counted to the west"),
            (format!("{position}LONGITUD= 110.0 / [deg W]"), ""),
            (format!("{position}LONGITUD= -110.0"), ""),
            (format!("{position}LONGITUD= 250.0"), ""),
        ] {
            let remark = remark(&text).unwrap();
            assert!(remark.contains(expected) && remark.is_empty() == expected.is_empty(), "{text}: {remark}");
        }
        let error = remark(&format!("{position}LONGITUD= 110.0 / [deg] east positive")).unwrap_err();
        assert!(error.contains("LONGITUD is 110 (comment"), "{error}");
    }

    /// Latitudes and longitudes up to half a degree away from the site are stated, except those of the same place.
    #[test]
    fn coordinates_beside_the_site_are_stated() {
        for (text, expected) in [
            (
                "SITELAT = -30.5",
                "SITELAT is -30.5, 0.33 deg from the site (at latitude -30.17 and longitude -70.81 deg)",
            ),
            ("LATITUDE= '-30:08:00'", "LATITUDE is \"-30:08:00\", 0.04 deg from the site"),
            ("LONG-OBS= -71.1", "LONG-OBS is -71.1, 0.25 deg from the site"),
            ("SITELAT = -30.16\nSITELONG= -70.82", ""),
            ("SITELAT = '-30 10'\nLONGITUD= 289.2", ""),
        ] {
            let remark = remark(&format!("OBSERVAT= 'CTIO'\n{text}")).unwrap();
            assert!(remark.starts_with(expected) && remark.is_empty() == expected.is_empty(), "{text}: {remark}");
        }
        let position = "OBSGEO-B= 42.94\nOBSGEO-L= 0.14\nOBSGEO-H= 2890.0\n";
        assert!(remark(&format!("{position}LAT-OBS = 43.0")).unwrap().starts_with("LAT-OBS is 43, 0.06 deg from"));
        // The nearest sense near the meridian of Greenwich.
        assert!(
            remark(&format!("{position}LONGITUD= -0.14")).unwrap().contains("which is read as counted to the west")
        );
        // At the South Pole a longitude is no distance.
        assert_eq!(remark("OBSERVAT= 'South Pole'\nSITELONG= -45.1").unwrap(), "");
    }

    #[test]
    fn codes_of_las_cumbres_are_sites() {
        for (code, name) in
            [("coj", "LCO Siding Spring"), ("tlv", "Wise Observatory"), ("ogg", "Faulkes Telescope North")]
        {
            let header = Header::from_text(&format!("TELESCOP= '1m0-09'\nSITEID  = '{code}'\n"));
            assert_eq!(found(&[&header]).unwrap().unwrap().name, name);
        }
        assert_eq!(found(&[&Header::from_text("SITEID  = '703'\n")]).unwrap(), None);
        let error = site("SITEID  = 'cpt'\n").unwrap_err().to_string();
        assert!(error.contains("km from that of SITEID"), "{error}");
    }

    /// Coordinates of Rubin Observatory in both forms, as in the headers of LSSTCam, where X, Y and Z are given to
    /// centimetres.
    #[test]
    fn valid_positions_are_read_before_names() {
        let cartesian =
            "TELESCOP= 'Simonyi'\nOBSGEO-X= 1818938.94\nOBSGEO-Y= -5208470.95\nOBSGEO-Z= -3195172.08\nOBSGEO-L= 0\n";
        let geodetic = "OBSGEO_B= -30.244639\nOBSGEO_L= 289.250583\nOBSGEO_H= 2663.0\nOBSGEO-X= 1\n";
        for text in [cartesian, geodetic] {
            let site = found(&[&Header::from_text(text)]).unwrap().unwrap();
            assert!((site.latitude_rad.to_degrees() + 30.244_639).abs() < 1e-7, "{site:?}");
            assert!((site.longitude_rad.to_degrees() + 70.749_417).abs() < 1e-6, "{site:?}");
            assert!((site.height_m - 2663.0).abs() < 0.01, "{site:?}");
        }
        assert_eq!(found(&[&Header::from_text(cartesian)]).unwrap().unwrap().name, "Simonyi");
        // Cerro Tololo is 10 km from it.
        assert!(site(cartesian).unwrap_err().to_string().contains("10 km from that of OBSERVAT \"CTIO\""));
        let error = site("OBSGEO-X= 0.0\nOBSGEO-Y= 0.0\nOBSGEO-Z= 0.0\n").unwrap_err().to_string();
        assert!(error.contains("OBSGEO-X, OBSGEO-Y, OBSGEO-Z") && error.contains("0, 0, 0"), "{error}");
        assert!(site("OBSGEO-B= 91\nOBSGEO-L= 3\nOBSGEO-H= 0\n").is_err());
    }

    #[test]
    fn names_are_read_and_longitudes_of_unknown_sign_are_not() {
        let decam = "OBS-LONG= 70.81489\nOBS-LAT = -30.16606\nTELESCOP= 'CTIO 4.0-m telescope'\nINSTRUME= 'DECam'\n";
        assert_eq!(site(decam).unwrap().unwrap().mpc_code.as_deref(), Some("W84"));
        let schmidt = "SITELAT = -31.277\nSITELONG= 210.934\nTELESCOP= 'UK Schmidt - Doubl'\n";
        assert_eq!(found(&[&Header::from_text(schmidt)]).unwrap(), None);
        for (telescope, name) in [("ESO-NTT", "La Silla"), ("ESO-VLT-U4", "Paranal"), ("NASA IRTF", "IRTF")] {
            let header = Header::from_text(&format!("TELESCOP= '{telescope}'\n"));
            assert_eq!(found(&[&header]).unwrap().unwrap().name, name);
        }
        // The primary header names another observatory.
        let error = site(schmidt).unwrap_err().to_string();
        assert!(error.contains("SITELAT is -31.277"), "{error}");
        for fits in [
            "SITELONG= '-70:48:53'\n",
            "OBS-LONG= '04:43:15'\n",
            "LONGITUD= 289.2\n",
            "SITELAT = '30 10 S'\n",
            "SITELAT = 0.0\n",
        ] {
            assert_eq!(site(fits).unwrap().unwrap().name, "Cerro Tololo", "{fits}");
        }
        for far in ["SITELONG= -155.5\n", "LATITUDE= 19.8\n", "SITELAT = '+30:10:00'\n", "SITENAME= 'Siding Spring'\n"]
        {
            assert!(site(far).is_err(), "{far}");
        }
    }

    #[test]
    fn contradictory_and_ambiguous_sites_are_errors() {
        let of = |text: &str| found(&[&Header::from_text(text)]);
        let error = |text: &str| of(text).unwrap_err().to_string();
        let atlas = error("TELESCOP= 'ATLAS'\n");
        assert!(atlas.contains("ATLAS Chile") && atlas.contains("--mpc"), "{atlas}");
        assert!(error("OBSERVAT= 'Gemini'\n").contains("Gemini South"));
        let decided = of("TELESCOP= 'ATLAS'\nOBSERVAT= 'Sutherland'\n").unwrap().unwrap();
        assert!((decided.longitude_rad.to_degrees() - 20.81).abs() < 0.01, "{decided:?}");
        for text in [
            "TELESCOP= 'ATLAS'\nOBSERVAT= 'Paranal'\n",
            "TELESCOP= 'VLT'\nOBSERVAT= 'La Silla'\n",
            "TELESCOP= 'Rubin'\nOBSGEO-B= -30.24\nOBSGEO-L= 70.75\nOBSGEO-H= 2663\n",
            "OBSGEO-X= 1818938.94\nOBSGEO-Y= -5208470.95\nOBSGEO-Z= -3195172.08\nOBSGEO-B= 30.2\nOBSGEO-L= -70.7\nOBSGEO-H= 2663\n",
        ] {
            let error = error(text);
            assert!(error.contains(" km from that of ") && error.contains("--site"), "{error}");
        }
        for text in [
            "TELESCOP= 'CTIO 1.0 meter telescope'\nOBSERVAT= 'KPNO'\n",
            "TELESCOP= 'Bok 2.3m'\nSITENAME= 'Siding Spring'\n",
        ] {
            assert!(error(text).contains(" km from that of TELESCOP"), "{text}");
        }
        assert_eq!(of("TELESCOP= 'Bok 2.3m'\nOBSERVAT= 'KPNO'\n").unwrap().unwrap().name, "Kitt Peak");
        assert_eq!(of("TELESCOP= 'Bok 2.3m'\n").unwrap(), None);
        for text in ["TELESCOP= 'T17 iTelescope'\n", "SITE    = 'Dome 2'\n", "TELESCOP= 'South 0.4m'\n"] {
            assert_eq!(of(&format!("{text}OBSERVAT= 'KPNO'\n")).unwrap().unwrap().name, "Kitt Peak", "{text}");
        }
        assert!(error("OBSERVAT= 'LCO'\n").contains("Las Campanas"));
        assert_eq!(of("TELESCOP= 'Magellan'\nOBSERVAT= 'LCO'\n").unwrap().unwrap().name, "Las Campanas");
        // The telescope in space, and the observatory on the Earth.
        for telescope in ["WISE", "HST", "NEOSSAT", "JWST", "XMM", "Swift", "TESS"] {
            let error = error(&format!("TELESCOP= '{telescope}'\nSITELAT = 30.0\nSITELONG= 10.0\n"));
            assert!(error.contains("a telescope in orbit; allowed: --observer-elements"), "{error}");
        }
        assert!(
            error("TELESCOP= 'any'\nOBSGEO-X= 7e6\nOBSGEO-Y= 0.0\nOBSGEO-Z= 0.0\n").contains("--observer-elements")
        );
        assert_eq!(of("OBSERVAT= 'Wise'\n").unwrap().unwrap().name, "Wise Observatory");
        for keywords in ["OBSLAT  = '56 23 00'\n", "LAT     = 56.4\n", "HIERARCH ESO TEL GEOLAT = 56.4\n"] {
            let error = error(&format!("OBSERVAT= 'Perth'\n{keywords}"));
            assert!(error.contains("at latitude -32.01"), "{error}");
        }
        assert!(error("OBSGEO-B= 0.0\nOBSGEO-L= 0.0\nOBSGEO-H= 0.0\n").contains("0, 0, 0"));
        assert_eq!(of("TELESCOP= 'VST'\nOBSERVAT= 'Paranal'\n").unwrap().unwrap().name, "VST");
        assert!(error("TELESCOP= 'SPECULOOS'\n").contains("SPECULOOS North"));
        assert!(error("OBSERVAT= 'Lowell Observatory'\n").contains("Anderson Mesa"));
        // Instruments with the name or the code of another site.
        for instrument in ["FAST", "AO", "DOT"] {
            assert_eq!(of(&format!("INSTRUME= '{instrument}'\n")).unwrap(), None, "{instrument}");
        }
        assert_eq!(of("INSTRUME= 'DECam'\n").unwrap().unwrap().name, "CTIO Blanco");
    }

    #[test]
    fn names_of_mounts_are_no_sites() {
        let position = "OBSGEO-B= 35.0\nOBSGEO-L= 138.0\nOBSGEO-H= 700.0\n";
        for (text, name, is_stated) in [
            ("NOT SET", UNNAMED_SITE, false),
            ("Not connected", UNNAMED_SITE, false),
            ("Vista", UNNAMED_SITE, false),
            ("Atlas EQ-G", UNNAMED_SITE, true),
            ("Gemini", UNNAMED_SITE, true),
            ("Gemini Telescope .NET", "Gemini Telescope .NET", false),
            ("My telescope", "My telescope", false),
        ] {
            let header = Header::from_text(&format!("{position}TELESCOP= '{text}'"));
            let found = site_from_headers(&[&header]).unwrap().unwrap();
            let stated = found.remark.is_some_and(|remark| remark.contains("km from that of TELESCOP"));
            assert_eq!((&*found.site.name, stated), (name, is_stated), "{text}");
            assert!((found.site.latitude_rad.to_degrees() - 35.0).abs() < 1e-9);
        }
        assert_eq!(found(&[&Header::from_text("TELESCOP= 'NOT SET'\n")]).unwrap(), None);
        assert!(
            remark(&format!("{position}TELESCOP= 'NOT'")).unwrap_err().contains("km from that of TELESCOP \"NOT\"")
        );
        let code = "MPC-CODE= '703'\nTELESCOP= 'Atlas EQ-G'\n";
        assert!(remark(code).unwrap().contains("km from that of TELESCOP"));
    }

    #[test]
    fn sites_that_differ_are_stated_or_errors() {
        let kitt_peak = remark("TELESCOP= 'Bok'\nOBSERVAT= 'KPNO'\n").unwrap();
        assert!(
            kitt_peak.starts_with("the site is that of TELESCOP \"Bok\", 0.7 km from that of OBSERVAT"),
            "{kitt_peak}"
        );
        assert_eq!(remark("INSTRUME= 'DECam'\nOBSERVAT= 'CTIO'\n").unwrap(), "");
        for text in [
            "OBSERVAT= 'Mount Lemmon'\nMPC-CODE= '703'\n",
            "OBSERVAT= 'Rubin Observatory'\nOBSGEO-B= -30.169\nOBSGEO-L= -70.8063\nOBSGEO-H= 2215\n",
        ] {
            assert!(remark(text).unwrap_err().contains("allowed: one site within 3 km"), "{text}");
        }
        // Gemini South, 1.2 km from the Rubin Observatory.
        let gemini = "OBSERVAT= 'Rubin Observatory'\nOBSGEO-B= -30.240639\nOBSGEO-L= -70.73655\nOBSGEO-H= 2715.4\n";
        let header = Header::from_text(gemini);
        let found = site_from_headers(&[&header]).unwrap().unwrap();
        assert_eq!(found.site.name, UNNAMED_SITE);
        assert!(found.remark.unwrap().contains("1.3 km from that of OBSERVAT"));
        let of = |text: &str| site_from_headers(&[&Header::from_text(text)]);
        for (text, name) in [
            ("TELESCOP= 'Gemini'\nOBSERVAT= 'Cerro Pachon'\n", "Gemini South"),
            ("TELESCOP= 'SOAR'\nOBSERVAT= 'Cerro Pachon'\n", "SOAR"),
            ("TELESCOP= 'ATLAS'\nOBSERVAT= 'Mauna Loa'\n", "ATLAS Mauna Loa"),
        ] {
            let found = of(text).unwrap().unwrap();
            assert_eq!((&*found.site.name, found.remark), (name, None), "{text}");
        }
        for name in ["Cerro Pachon", "Catalina Sky Survey"] {
            assert!(
                of(&format!("OBSERVAT= '{name}'\n")).unwrap_err().to_string().contains("one of several sites"),
                "{name}"
            );
        }
    }
}
