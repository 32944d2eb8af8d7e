//! World coordinates in a header, including common non-standard keywords. "Paper II" is Calabretta and Greisen (2002,
//! A&A 395, 1077).

use super::super::header::Header;
use super::distortion::{Distortion, attribute};
use super::projection::NativePole;
use super::projection::{Projection, Zpn};
use crate::error::{Error, ErrorKind};
use crate::message::Quoted;

/// Codes of the supported projections.
pub(super) const KNOWN_PROJECTIONS: &str = "TAN (with SIP or PVi_m), TPV, TNX, ZPX, SIN, STG, ARC, ZEA, ZPN, CAR";

/// Largest difference from 2000, in years, of an equinox that is taken as 2000.
const EQUINOX_SLACK: f64 = 1e-3;

/// Parameters of the transformation from pixels to the sky, as given by a header.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct HeaderTerms {
    /// Number of the right ascension axis, 0 or 1.
    pub longitude_axis: usize,
    /// CRPIX, counted from 1.
    pub reference_pixel: [f64; 2],
    /// Matrix from pixels to degrees of the projection plane, (along right ascension, along declination).
    pub matrix_deg: [[f64; 2]; 2],
    /// Distortion of pixel coordinates relative to the reference pixel.
    pub pixel_distortion: Option<Distortion>,
    /// Distortion of positions in the projection plane, degrees.
    pub plane_distortion: Option<Distortion>,
    /// Projection.
    pub projection: Projection,
    /// Orientation of the projection on the sky.
    pub pole: NativePole,
    /// Numbers of columns and rows, if the header gives them.
    pub size: Option<[usize; 2]>,
}

impl HeaderTerms {
    /// Reads the parameters from a header.
    pub fn from_header(header: &Header) -> Result<Self, Error> {
        let types: Vec<String> = (1..=2).map(|axis| header.text(&format!("CTYPE{axis}")).unwrap_or_default()).collect();
        let longitude_axis = match (types[0].split('-').next(), types[1].split('-').next()) {
            (Some("RA"), Some("DEC")) => 0,
            (Some("DEC"), Some("RA")) => 1,
            _ => {
                let [ctype1, ctype2] = [&types[0], &types[1]].map(Quoted::new);
                let sentence = format!("no celestial coordinates: CTYPE1 is {ctype1:?} and CTYPE2 is {ctype2:?}");
                return Err(Error::new(ErrorKind::NoCoordinates, sentence).allowing("one RA---xxx and one DEC--xxx"));
            }
        };
        check_system(header)?;
        reject_lookup_tables(header)?;
        let latitude_axis = 1 - longitude_axis;
        let code = |axis: usize| {
            types[axis].trim_start_matches(|c: char| c != '-').trim_start_matches('-').to_ascii_uppercase()
        };
        let (code, other) = (code(longitude_axis), code(latitude_axis));
        if code != other {
            return Err(Error::invalid(
                format!("CTYPE{}", latitude_axis + 1),
                format!("{:?}", types[latitude_axis]),
                "the projection of the other axis",
            ));
        }
        // Other distortions, such as -PLY and -TAB, are not read.
        let projection_code = code.strip_suffix("SIP").unwrap_or(&code).trim_end_matches('-');
        let units = [unit_deg(header, 1)?, unit_deg(header, 2)?];
        let reference_pixel = [required(header, "CRPIX1")?, required(header, "CRPIX2")?];
        let values = [required(header, "CRVAL1")? * units[0], required(header, "CRVAL2")? * units[1]];
        let declination_deg = values[latitude_axis];
        if declination_deg.abs() > 90.0 {
            return Err(Error::invalid(
                format!("CRVAL{}", latitude_axis + 1),
                format!("{declination_deg} degrees"),
                "a declination from -90 to 90 degrees",
            ));
        }
        let by_axis = matrix(header, units, latitude_axis)?;
        let matrix_deg = [by_axis[longitude_axis], by_axis[latitude_axis]];
        let pv = |axis: usize, m: usize| header.number(&format!("PV{}_{m}", axis + 1));
        let wat = |axis: usize| header.numbered_text(&format!("WAT{}_", axis + 1));
        let (wat_longitude, wat_latitude) = (wat(longitude_axis), wat(latitude_axis));
        let pixel_distortion = Distortion::sip(header)?;
        let has_pv = |axis: usize, mut terms: std::ops::Range<usize>| terms.any(|m| pv(axis, m).is_some());
        // PVi_m on both axes, or with m > 4, are coefficients of SCAMP; the first of one axis alone are not.
        let is_scamp = projection_code == "TAN"
            && (has_pv(longitude_axis, 5..40)
                || has_pv(latitude_axis, 5..40)
                || (has_pv(longitude_axis, 0..3) && has_pv(latitude_axis, 0..3)));
        // The standard has no parameters of TAN on the latitude axis (wcslib ignores them), SCAMP has.
        if projection_code == "TAN"
            && !is_scamp
            && pixel_distortion.is_none()
            && let Some(m) =
                (0..5).find(|m| pv(latitude_axis, *m).is_some_and(|term| term != 0.0 && (*m, term) != (1, 1.0)))
        {
            let what = format!("PV{}_{m}", latitude_axis + 1);
            let allowed = "no parameters of TAN on this axis; CTYPE TPV for a distortion";
            return Err(Error::invalid(what, pv(latitude_axis, m).unwrap_or_default(), allowed));
        }
        let mut plane_distortion = None;
        let projection = match projection_code {
            // PVi_m coefficients of SCAMP together with SIP describe the same distortion twice, so SIP alone is used.
            "TAN" if is_scamp && pixel_distortion.is_none() => {
                plane_distortion = Some(Distortion::tpv(header, longitude_axis));
                Projection::Tan
            }
            "TAN" => Projection::Tan,
            "TPV" => {
                plane_distortion = Some(Distortion::tpv(header, longitude_axis));
                Projection::Tan
            }
            "TNX" => {
                plane_distortion = Distortion::iraf(&wat_longitude, &wat_latitude, "TNX")?;
                Projection::Tan
            }
            "ZPX" => {
                plane_distortion = Distortion::iraf(&wat_longitude, &wat_latitude, "ZPX")?;
                let named = |m: usize| {
                    let word = attribute(&wat_latitude, &format!("projp{m}"))
                        .or_else(|| attribute(&wat_longitude, &format!("projp{m}")));
                    word.and_then(|word| word.parse().ok())
                };
                zpn(&named)?
            }
            "ZPN" => zpn(&|m| pv(latitude_axis, m))?,
            "SIN" if (1..=2).any(|m| pv(latitude_axis, m).is_some_and(|slant| slant != 0.0)) => {
                return Err(Error::invalid(
                    format!("PV{}_1", latitude_axis + 1),
                    "that of a slant SIN",
                    KNOWN_PROJECTIONS,
                ));
            }
            "SIN" => Projection::Sin,
            "STG" => Projection::Stg,
            "ARC" => Projection::Arc,
            "ZEA" => Projection::Zea,
            "CAR" => Projection::Car,
            _ => {
                let what = format!("projection of CTYPE{}", longitude_axis + 1);
                return Err(Error::invalid(what, format!("{code:?}"), KNOWN_PROJECTIONS));
            }
        };
        // PVi_1 to PVi_4 of the longitude axis are the native position of the reference point, and LONPOLE and LATPOLE,
        // over which they take precedence (paper II, section 2.5). With a distortion they are its coefficients.
        let native_pole = |m: usize| pv(longitude_axis, m).filter(|_| plane_distortion.is_none() && !is_scamp);
        let reference = if projection.is_zenithal() { [0.0, 90.0] } else { [0.0, 0.0] };
        for (m, usual_deg) in (1..).zip(reference) {
            if let Some(given_deg) = native_pole(m).filter(|given_deg| *given_deg != usual_deg) {
                let what = format!("PV{}_{m}", longitude_axis + 1);
                return Err(Error::invalid(what, given_deg, format!("{usual_deg} (the reference point of {code})")));
            }
        }
        let pole = NativePole {
            right_ascension_deg: values[longitude_axis],
            declination_deg,
            // LONGPOLE is the name in drafts of the standard (Subaru, IRAF).
            lonpole_deg: native_pole(3).or_else(|| header.number("LONPOLE")).or_else(|| header.number("LONGPOLE")),
            latpole_deg: native_pole(4).or(header.number("LATPOLE")),
            is_zenithal: projection.is_zenithal(),
        };
        Ok(Self {
            longitude_axis,
            reference_pixel,
            matrix_deg,
            pixel_distortion,
            plane_distortion,
            projection,
            pole,
            size: size(header),
        })
    }
}

fn required(header: &Header, keyword: &str) -> Result<f64, Error> {
    if let Some(number) = header.number(keyword) {
        return Ok(number);
    }
    match header.card(keyword) {
        None => Err(Error::invalid(keyword.to_owned(), "missing", "a number")),
        Some(card) => Err(Error::invalid(keyword.to_owned(), format!("{:?}", card.text()[9..].trim()), "a number")),
    }
}

/// Returns the number of degrees in the unit of an axis; 1 without CUNIT.
fn unit_deg(header: &Header, axis: usize) -> Result<f64, Error> {
    let keyword = format!("CUNIT{axis}");
    let unit = header.text(&keyword).unwrap_or_default();
    match unit.to_ascii_lowercase().as_str() {
        "" | "deg" | "degree" | "degrees" | "degs" => Ok(1.0),
        "arcmin" | "arcminute" | "arcminutes" => Ok(1.0 / 60.0),
        "arcsec" | "arcsecond" | "arcseconds" | "asec" => Ok(1.0 / 3600.0),
        "mas" => Ok(1.0 / 3.6e6),
        "rad" | "radian" | "radians" => Ok(1f64.to_degrees()),
        _ => Err(Error::invalid(
            keyword,
            format!("{unit:?}"),
            "deg, arcmin, arcsec, mas or rad (or one of these spelt out)",
        )),
    }
}

/// Rejects distortions that are tables in other HDUs (FITS standard distortion paper; HST's CPDIS and D2IM).
fn reject_lookup_tables(header: &Header) -> Result<(), Error> {
    let stems = ["CPDIS", "CQDIS", "D2IMDIS", "DP", "DQ"];
    let keywords = stems.iter().flat_map(|stem| [1, 2].map(|axis| format!("{stem}{axis}")));
    let of_axes = keywords.filter_map(|keyword| header.text(&keyword).map(|text| (keyword, text)));
    let of_old_form = header.text("D2IMEXT").map(|text| ("D2IMEXT".to_owned(), text));
    match of_axes.chain(of_old_form).next() {
        Some((keyword, text)) => {
            let allowed = "world coordinates without distortion tables (SIP, TPV, TNX and ZPX are read); resample the frame, \
                           or fit a SIP polynomial";
            Err(Error::invalid(keyword, format!("{text:?}"), allowed))
        }
        None => Ok(()),
    }
}

/// Largest difference between two matrices of one header, as a fraction of the larger one; over 1000 pixels it is a
/// tenth of a pixel.
const MATRIX_SLACK: f64 = 1e-4;
/// Largest difference between CROTAi of both axes, degrees; over 1000 pixels it is a tenth of a pixel.
const ROTATION_SLACK_DEG: f64 = 0.01;

/// Returns the matrix: CDi_j if given, otherwise CDELTi with PCi_j, or with the old keyword CROTA of the declination
/// axis.
///
/// # Errors
/// CDi_j and PCi_j, or PCi_j and CROTAi, or the CROTAi of both axes give different matrices.
fn matrix(header: &Header, units: [f64; 2], latitude_axis: usize) -> Result<[[f64; 2]; 2], Error> {
    let entry = |stem: &str, i: usize, j: usize| header.number(&format!("{stem}{}_{}", i + 1, j + 1));
    let entries = [(0, 0), (0, 1), (1, 0), (1, 1)];
    let steps = [0, 1].map(|axis| header.number(&format!("CDELT{}", axis + 1)).unwrap_or(1.0) * units[axis]);
    let old_name = |i: usize, j: usize| header.number(&format!("PC{:03}{:03}", i + 1, j + 1));
    let turn = |i: usize, j: usize| entry("PC", i, j).or_else(|| old_name(i, j));
    let is_turned = entries.iter().any(|(i, j)| turn(*i, *j).is_some());
    let has_cd = entries.iter().any(|(i, j)| entry("CD", *i, *j).is_some());
    let rotation = rotation_deg(header, latitude_axis, is_turned || has_cd)?;
    let (sine, cosine) = rotation.to_radians().sin_cos();
    let (mut turned, mut rotated) = ([[0.0; 2]; 2], [[0.0; 2]; 2]);
    for (i, j) in entries {
        // Paper II, eq. 191: PC = [[cos ρ, -sin ρ s₂/s₁], [sin ρ s₁/s₂, cos ρ]] with the steps s (CDELT). The product
        // of CDELTi and PCi_j contains the step of axis j if i and j differ.
        rotated[i][j] = if i == j {
            steps[i] * cosine
        } else {
            let sign = if i == latitude_axis { 1.0 } else { -1.0 };
            sign * steps[j] * sine
        };
        turned[i][j] = steps[i] * turn(i, j).unwrap_or(if i == j { 1.0 } else { 0.0 });
    }
    let differs = |a: [[f64; 2]; 2], b: [[f64; 2]; 2]| {
        let largest = a.iter().flatten().fold(0.0, |largest: f64, term| largest.max(term.abs()));
        entries.iter().any(|(i, j)| (a[*i][*j] - b[*i][*j]).abs() > MATRIX_SLACK * largest)
    };
    let missing = (1..=2).map(|axis| format!("CDELT{axis}")).find(|step| !header.contains(step));
    if let Some(step) = missing.filter(|_| !has_cd && !is_turned) {
        return Err(Error::invalid(step, "missing", "CDELT1 and CDELT2, or a matrix of CDi_j"));
    }
    if !has_cd {
        if is_turned && rotation != 0.0 && differs(turned, rotated) {
            return Err(Error::invalid(
                format!("CROTA{}", latitude_axis + 1),
                format!("{rotation}, but PCi_j with CDELTi is another matrix, {turned:?} deg"),
                "one of the two; remove the other from the header",
            ));
        }
        return Ok(if is_turned { turned } else { rotated });
    }
    let mut given = [[0.0; 2]; 2];
    for (i, j) in entries {
        given[i][j] = entry("CD", i, j).unwrap_or(0.0) * units[i];
    }
    // CDELT and CROTA beside CD are ignored, as the standard allows; PC and CD exclude each other. A PC matrix of 1
    // without CDELT is left over from a template.
    let has_steps = (1..=2).any(|axis| header.contains(&format!("CDELT{axis}")));
    let is_unit = entries.iter().all(|(i, j)| turn(*i, *j).is_none_or(|term| term == if i == j { 1.0 } else { 0.0 }));
    if is_turned && (has_steps || !is_unit) && differs(given, turned) {
        return Err(Error::invalid(
            "matrix of CDi_j",
            format!("{given:?}, and that of PCi_j with CDELTi is {turned:?} deg"),
            "one of the two; remove the other from the header",
        ));
    }
    Ok(given)
}

/// Returns CROTA of the declination axis, degrees; 0 without it. `is_given` is true if the header has a matrix.
///
/// # Errors
/// CROTA of the other axis is another angle, unless the header has a matrix, which takes precedence.
fn rotation_deg(header: &Header, latitude_axis: usize, is_given: bool) -> Result<f64, Error> {
    let [own, other] =
        [latitude_axis, 1 - latitude_axis].map(|axis| header.number(&format!("CROTA{}", axis + 1)).unwrap_or(0.0));
    let apart_deg = ((own - other + 180.0).rem_euclid(360.0) - 180.0).abs();
    if !is_given && other != 0.0 && apart_deg > ROTATION_SLACK_DEG {
        let given = format!("{other}, but CROTA{} is {own}", latitude_axis + 1);
        let allowed = "the same angle, or none: only that of the declination axis is defined";
        return Err(Error::invalid(format!("CROTA{}", 2 - latitude_axis), given, allowed));
    }
    Ok(own)
}

fn zpn(named: &dyn Fn(usize) -> Option<f64>) -> Result<Projection, Error> {
    let mut coefficients: Vec<f64> = (0..30).map(|m| named(m).unwrap_or(0.0)).collect();
    let used = coefficients.iter().rposition(|c| *c != 0.0).map_or(0, |last| last + 1);
    coefficients.truncate(used);
    let shown = format!("{coefficients:?}");
    Zpn::new(coefficients).map(Projection::Zpn).ok_or_else(|| {
        Error::invalid("PV2_m (or projpm)".to_owned(), shown, "a polynomial that grows from the centre on")
    })
}

/// Checks that the reference system is ICRS or FK5 of equinox 2000. Without RADESYS, the equinox determines the system
/// (paper II, section 3.1).
fn check_system(header: &Header) -> Result<(), Error> {
    let year = |keyword: &str| {
        // EQUINOX = 'J2000'
        header.number(keyword).or_else(|| header.text(keyword)?.trim_start_matches(['J', 'j']).trim().parse().ok())
    };
    let equinox = year("EQUINOX").or_else(|| year("EPOCH"));
    let named = header.text("RADESYS").or_else(|| header.text("RADECSYS")).map(|name| name.to_ascii_uppercase());
    let unreadable = header.text("EQUINOX").filter(|_| year("EQUINOX").is_none());
    let is_2000 = unreadable.is_none() && equinox.is_none_or(|year| (year - 2000.0).abs() < EQUINOX_SLACK);
    let is_known = match named.as_deref() {
        Some("ICRS" | "GCRS") => true,
        Some("FK5" | "J2000" | "FK5J2000") | None => is_2000,
        Some(_) => false,
    };
    if is_known {
        return Ok(());
    }
    let name = named.unwrap_or_else(|| "a system without RADESYS".to_owned());
    let equinox = unreadable.or_else(|| equinox.map(|year| year.to_string()));
    let system = equinox.map_or(name.clone(), |equinox| format!("{name}, equinox {equinox}"));
    let allowed = "ICRS, or FK5 of equinox 2000, which is taken as ICRS (they differ by 0.02 arcsec)";
    Err(Error::invalid("reference system", system, allowed))
}

/// Returns the numbers of columns and rows: of the image inside a compressed HDU, of the image, or from the keywords of
/// astrometry.net.
fn size(header: &Header) -> Option<[usize; 2]> {
    [["ZNAXIS1", "ZNAXIS2"], ["NAXIS1", "NAXIS2"], ["IMAGEW", "IMAGEH"]].iter().find_map(|[columns, rows]| {
        let count = |keyword: &str| {
            header.integer(keyword).and_then(|count| usize::try_from(count).ok()).filter(|count| *count > 0)
        };
        Some([count(columns)?, count(rows)?])
    })
}
