//! Exposure times and zero points read from headers of observatories.

use hifitime::Epoch;
use streakcast::frames::seconds_between;
use streakcast::images::{Calibration, CountBasis, ExposureTime, Header, PixelUnit};

fn time(text: &str) -> Result<ExposureTime, String> {
    ExposureTime::from_headers(&[&Header::from_text(text)]).map_err(|error| error.to_string())
}

#[track_caller]
fn begins(text: &str, utc: &str, from: &str) {
    let found = time(text).unwrap_or_else(|error| panic!("{error}"));
    let expected: Epoch = format!("{utc} UTC").parse().expect("a moment");
    // One microsecond is the resolution of days in one f64.
    assert!(seconds_between(expected, found.start).abs() < 1e-6, "{} is not {utc}", found.start);
    assert_eq!(found.start_from, from);
}

const LENGTH: &str = "EXPTIME =                 60.0\n";

#[test]
fn verif_spellings_of_the_start() {
    for (cards, utc, from) in [
        ("DATE-OBS= '2020-03-06T00:04:15.410235'", "2020-03-06T00:04:15.410235", "DATE-OBS"),
        ("DATE-OBS= '2020-03-06'\nTIME-OBS= '00:04:15.41'", "2020-03-06T00:04:15.41", "DATE-OBS + TIME-OBS"),
        ("DATE_OBS= '2020-03-06'\nUTC_OBS = '00:04:15.41'", "2020-03-06T00:04:15.41", "DATE_OBS + UTC_OBS"),
        (
            "DATE-OBS= '2020-05-28'\nUT-STR  = '14:32:17.921'\nUT      = '14:32:20.9'",
            "2020-05-28T14:32:17.921",
            "DATE-OBS + UT-STR",
        ),
        ("DATE-OBS= '2020-05-28'\nUT      = '14:32:17.5'", "2020-05-28T14:32:17.5", "DATE-OBS + UT"),
        ("DATE-OBS= '2020-03-06T00:04:52.410'\nTIMESYS = 'TAI'", "2020-03-06T00:04:15.410", "DATE-OBS"),
        ("DATE-OBS= '2020-03-06T00:05:24.594'\nTIMESYS = 'TT'", "2020-03-06T00:04:15.410", "DATE-OBS"),
        ("DATE-BEG= '2020-03-06T00:04:15'\nDATE-OBS= '2020-03-06T00:04:15.9'", "2020-03-06T00:04:15", "DATE-BEG"),
        ("DATE-OBS= '2020-03-06T02:04:15.41+02:00'", "2020-03-06T00:04:15.41", "DATE-OBS"),
        ("DATE-OBS= '2020-03-05 17:04:15.41-0700'", "2020-03-06T00:04:15.41", "DATE-OBS"),
        ("DATE-OBS= '2020-03-06T05:34:15+05:30'\nMJD-OBS =  58914.00295139", "2020-03-06T00:04:15", "DATE-OBS"),
        ("MJD-OBS =             58914.250000", "2020-03-06T06:00:00", "MJD-OBS"),
        ("DATE-OBS= '06/03/20'\nMJD-OBS =             58914.250000", "2020-03-06T06:00:00", "MJD-OBS"),
        ("DATE-OBS= '2020-03-06'\nMJD-OBS =             58914.250000", "2020-03-06T06:00:00", "MJD-OBS"),
        ("JD      =          2458914.750000", "2020-03-06T06:00:00", "JD"),
        ("JD      =          2458914.750000 / end of exposure", "2020-03-06T05:59:00", "JD - the exposure"),
        ("MJD     =            58914.250000 / mid exposure", "2020-03-06T05:59:30", "MJD - half of the exposure"),
        ("DATE-AVG= '2020-03-06T06:00:00'", "2020-03-06T05:59:30", "DATE-AVG - half of the exposure"),
        ("DATE-END= '2020-03-06T06:00:00'", "2020-03-06T05:59:00", "DATE-END - the exposure"),
        (
            "DATE-OBS= '2009-10-17'\nTAIHMS  = '01:53:10.59'\nTIMESYS = 'TAI'\nTAI     =        4762461190.59",
            "2009-10-17T01:52:36.59",
            "DATE-OBS + TAIHMS",
        ),
        ("DATE-OBS= '22/08/2019'\nTIME-OBS= '06:00:00'", "2019-08-22T06:00:00", "DATE-OBS + TIME-OBS"),
        ("DATE-OBS= '06/03/92'\nUT      = '06:00:00'", "1992-03-06T06:00:00", "DATE-OBS + UT"),
        ("DATE-OBS= '20200306T060000Z'", "2020-03-06T06:00:00", "DATE-OBS"),
        // Numbers, other orders and other keywords with one reading.
        ("DATE-OBS=             20200306\nTIME-OBS= '060000.00'", "2020-03-06T06:00:00", "DATE-OBS + TIME-OBS"),
        ("DATE-OBS=         58914.250000", "2020-03-06T06:00:00", "DATE-OBS"),
        ("DATE-OBS= '3/26/2020 6:00:00 PM'", "2020-03-26T18:00:00", "DATE-OBS"),
        ("DATE-OBS= 'Mar 6, 2020'\nUT      = '06h00m00s'", "2020-03-06T06:00:00", "DATE-OBS + UT"),
        ("UTC-DATE= '2020-066'\nUTC-TIME= '06 00 00'", "2020-03-06T06:00:00", "UTC-DATE + UTC-TIME"),
        ("OBS-DATE= '2020-03-06T06:00:00'", "2020-03-06T06:00:00", "OBS-DATE"),
        ("DATE-OBS= '2020-03-06T06:00:37'\nTIME-SYS= 'TAI'", "2020-03-06T06:00:00", "DATE-OBS"),
        ("DATE-OBS= '2020-03-06T06:00:00'\nTIMESYS = 'Coordinated Universal Time'", "2020-03-06T06:00:00", "DATE-OBS"),
        ("DATE-OBS= '2016-12-31T23:59:60.5'", "2017-01-01T00:00:00", "DATE-OBS"),
    ] {
        if cards.contains("23:59:60.5") {
            // Within a leap second: half a second before the new year.
            let found = time(&format!("{cards}\n{LENGTH}")).expect("a moment");
            let expected: Epoch = format!("{utc} UTC").parse().expect("a moment");
            assert!((seconds_between(found.start, expected) - 0.5).abs() < 1e-6, "{}", found.start);
            continue;
        }
        begins(&format!("{cards}\n{LENGTH}"), utc, from);
    }
}

#[test]
fn verif_missing_and_contradictory_keywords() {
    for (cards, words) in [
        ("EXPTIME = 60.0", "start of the exposure is missing"),
        ("DATE-OBS= '2020-03-06'\nEXPTIME = 60.0", "DATE-OBS is the date 2020-03-06 without a time"),
        (
            "DATE-OBS= '26/07/02'\nTIME-OBS= '19:36:37'\nEXPTIME = 60",
            "DATE-OBS is the ambiguous date \"26/07/02\"; allowed: yyyy-mm-dd",
        ),
        ("DATE-OBS= '26/07/02'\nJD      = 2452482.31709\nEXPTIME = 60", "or --start"),
        ("DATE-OBS= 'soon'\nEXPTIME = 60", "DATE-OBS is \"soon\"; allowed: a date such as"),
        ("DATE-OBS= '2020-03-06'\nTIME-OBS= 'noon'\nEXPTIME = 60", "TIME-OBS is \"noon\"; allowed: a time such as"),
        ("MJD-OBS = 1.0\nEXPTIME = 60", "MJD-OBS is \"1.0\"; allowed: a modified Julian date"),
        (
            "DATE-OBS= '2020-03-06T00:00:00Z'\nTIMESYS = 'TAI'\nEXPTIME = 60",
            "has a zone as in UTC, and its scale is TAI",
        ),
        (
            "DATE-OBS= '2020-03-06T02:00:00+02:00'\nTIMESYS = 'TT'\nEXPTIME = 60",
            "has a zone as in UTC, and its scale is TT",
        ),
        (
            "DATE-OBS= '2020-03-06T00:00:00 UTC'\nTIMESYS = 'TAI'\nEXPTIME = 60",
            "has a zone as in UTC, and its scale is TAI",
        ),
        ("DATE-OBS= '2020-03-06T00:00:00'\nTIMESYS = 'LST'\nEXPTIME = 60", "TIMESYS is \"LST\"; allowed: UTC, TAI"),
        (
            "DATE-OBS= '2020-03-06T00:00:00'\nMJD-OBS = 58914.0010\nEXPTIME = 60",
            "start of DATE-OBS (UTC) is 2020-03-06T00:00:00 UTC, and MJD-OBS (UTC) gives 2020-03-06T00:01:26.4",
        ),
        ("DATE-OBS= '2020-03-06T00:00:00'\nDATE-AVG= '2020-03-06T00:01:07'\nEXPTIME = 60", "37.0 s apart"),
        ("DATE-OBS= '2020-03-06T00:00:00'", "length of the exposure is missing"),
        ("DATE-OBS= '2020-03-06T00:00:00'\nEXPTIME = 0.0", "EXPTIME is 0 s; allowed: above 0 s"),
        ("DATE-OBS= '2020-03-06T00:00:00'\nEXPTIME = -30", "EXPTIME is -30 s"),
        ("DATE-OBS= '2020-03-06T00:00:00'\nEXPTIME = 'long'", "EXPTIME is \"long\"; allowed: a number of seconds"),
        (
            "DATE-OBS= '2020-03-06T00:00:00'\nEXPTIME = 30\nEXPOSURE= 60",
            "EXPTIME is 30 s and EXPOSURE is 60 s; allowed: one length",
        ),
    ] {
        let error = time(cards).expect_err(words);
        assert!(error.contains(words), "{error}");
    }
}

#[test]
fn verif_rounded_values_are_no_conflict() {
    // Days with five decimals have a resolution of 0.86 s.
    let found =
        time("DATE-OBS= '2021-04-07T12:03:57.256'\nMJD_OBS =          59311.50275\nEXPTIME = 120.27").expect("agree");
    assert_eq!((found.start_from.as_str(), found.duration_s), ("DATE-OBS", 120.27));
}

#[test]
fn verif_lengths_in_other_units() {
    let at = "DATE-OBS= '2020-03-06T00:00:00'\n";
    let seconds = |card: &str| time(&format!("{at}{card}")).expect(card).duration_s;
    assert_eq!(seconds("EXPOSURE=                 65.0 /Observation: Exposure Minutes"), 3900.0);
    assert_eq!(seconds("ITIME   =                250.0 / [ms] integration"), 0.25);
    assert_eq!(seconds("EXPTIME = '53.907456'          / Exposure time (seconds)"), 53.907_456);
}

#[test]
fn verif_the_image_header_precedes_the_primary_header() {
    let image = Header::from_text("EXPTIME = 10.0\nGAIN    = 2.0");
    let primary = Header::from_text("DATE-OBS= '2020-03-06T00:00:00'\nEXPTIME = 20.0\nFILTER  = 'r'");
    let found = ExposureTime::from_headers(&[&image, &primary]).expect("both");
    assert_eq!((found.duration_s, found.start_from.as_str()), (10.0, "DATE-OBS"));
    // The scale of a date is that of its own header.
    let date = |text: &str| Header::from_text(&format!("TIMESYS = 'TAI'\n{text}"));
    let (image_utc, primary_tai) =
        (Header::from_text("EXPTIME = 10.0\nTIMESYS = 'UTC'"), date("DATE-OBS= '2020-03-06T00:00:37'"));
    let at = ExposureTime::from_headers(&[&image_utc, &primary_tai]).expect("TAI").start;
    let image_date = Header::from_text("EXPTIME = 10.0\nDATE-OBS= '2020-03-06T00:00:37'");
    assert_eq!(ExposureTime::from_headers(&[&image_date, &date("")]).expect("TAI").start, at);
    assert_eq!(at, found.start);
    let calibration = Calibration::from_headers(&[&image, &primary]);
    assert_eq!(calibration.band.expect("a band").value, "r");
    assert_eq!(calibration.gain_e_adu.expect("a gain").value, 2.0);
}

#[test]
fn verif_zero_points() {
    let zero_point = |text: &str| Calibration::from_headers(&[&Header::from_text(text)]).zero_point;
    for (cards, mag, basis, keyword) in [
        ("MAGZERO = 25.1454997926978", 25.145_499_792_697_8, Some(CountBasis::Second), "MAGZERO"),
        ("MAGZP   = 26.1", 26.1, Some(CountBasis::Frame), "MAGZP"),
        ("MAGZPT  = 27.0", 27.0, None, "MAGZPT"),
        ("ZP      = 27.0 / [mag] for 1 ADU/s", 27.0, Some(CountBasis::Second), "ZP"),
        ("PHOTZP  = 27.0\nBUNIT   = 'electron/s'", 27.0, Some(CountBasis::Frame), "PHOTZP"),
        ("FLUXMAG0= 63095734448.0194", 27.0, Some(CountBasis::Frame), "FLUXMAG0"),
        ("BUNIT   = 'nanomaggy'", 22.5, Some(CountBasis::Frame), "BUNIT"),
        // -2.5 log10 of the unit over 3631 Jy.
        ("BUNIT   = 'nJy'\nZP      = 27.0", 31.4, Some(CountBasis::Frame), "BUNIT"),
        ("BUNIT   = 'uJy'", 23.9, Some(CountBasis::Frame), "BUNIT"),
        ("BUNIT   = 'mJy/pixel'", 16.4, Some(CountBasis::Frame), "BUNIT"),
        ("BUNIT   = 'Jy'", 8.9, Some(CountBasis::Frame), "BUNIT"),
        ("BUNIT   = 'nanoJansky'", 31.4, Some(CountBasis::Frame), "BUNIT"),
        ("PHOTZP  = 29.4 / Photometric zeropoint MAG=-2.5*log(data)+PHOTZP", 29.4, Some(CountBasis::Frame), "PHOTZP"),
        ("MAGZPT  = 24.0 / m = -2.5 log10(counts/exptime) + MAGZPT", 24.0, Some(CountBasis::Second), "MAGZPT"),
        ("PHOTZP  = 24.0 / -2.5*log(flux)+PHOTZP", 24.0, None, "PHOTZP"),
    ] {
        let found = zero_point(cards).expect(cards);
        assert!((found.mag - mag).abs() < 1e-9, "{cards}: {}", found.mag);
        assert_eq!((found.basis, found.keyword.as_str()), (basis, keyword), "{cards}");
    }
    assert_eq!(zero_point("MAGZERO = 0.0\nZP      = 'none'"), None);
    // A surface brightness, megajanskys, and a unit whose first letter may be milli or mega.
    for unit in ["MJy/sr", "mJy/sr", "Jy/beam", "MJy", "MJY", "mjy"] {
        assert_eq!(zero_point(&format!("BUNIT   = '{unit}'")), None, "{unit}");
    }
}

#[test]
fn the_gain_of_counts_does_not_apply_to_a_flux() {
    let of = |unit: &str| {
        Calibration::from_headers(&[&Header::from_text(&format!("GAIN    = 1.5 / e-/ADU\nBUNIT   = '{unit}'"))])
    };
    for unit in
        ["MJy/sr", "MJy sr-1", "nJy", "Jy/beam", "erg/s/cm2/Angstrom", "erg s^-1 cm^-2 Hz^-1", "W m-2", "nanomaggy"]
    {
        let found = of(unit);
        let doubt = format!("GAIN is that of counts, the pixels are in {unit}");
        assert_eq!((found.pixel_unit, found.doubtful_gain), (PixelUnit::Flux, Some(doubt)), "{unit}");
    }
    for unit in ["adu", "ADU/s", "DN", "counts", "count/s"] {
        let found = of(unit);
        assert_eq!((found.pixel_unit, found.doubtful_gain), (PixelUnit::Counts, None), "{unit}");
    }
    assert_eq!(of("e-/s").pixel_unit, PixelUnit::Electrons);
    for unit in ["mag", "mag/arcsec2", "MAG(AB)"] {
        assert_eq!(of(unit).pixel_unit, PixelUnit::Magnitudes, "{unit}");
    }
}

#[test]
fn verif_amplifiers_and_invalid_values() {
    let of = |text: &str| Calibration::from_headers(&[&Header::from_text(text)]);
    let pair = of("GAINA   = 3.9\nGAINB   = 4.1\nRDNOISEA= 6.0\nRDNOISEB= 7.0\nSATURATA= 46994.0\nSATURATB= 47770.0");
    let gain = pair.gain_e_adu.expect("a gain");
    assert_eq!((gain.value, gain.keyword.as_str()), (4.0, "GAINA, GAINB"));
    assert_eq!(pair.read_noise_e.expect("a noise").value, 6.5);
    assert_eq!(pair.saturation_adu.expect("a limit").value, 46_994.0);
    assert_eq!(of("GAIN    = 0.0 / [electron/ADU]").gain_e_adu, None);
    assert_eq!(of("HIERARCH GAIN = 1.5").gain_e_adu.expect("a gain").value, 1.5);
    assert_eq!(of("GAIN    = 0.5 / [ADU/e-] inverse").gain_e_adu.expect("a gain").value, 2.0);
}

#[cfg(all(feature = "fits", unix))]
#[test]
fn valid_real_headers() {
    use streakcast::images::FrameFile;
    let Some(data) = crate::common::data_dir() else { return };
    // Start in UTC according to the web page, paper or time keyword of the observatory; or the error message.
    for (name, hdu, expected, seconds) in [
        ("galsim_wcs/tpv.fits", 0, Ok("2007-10-11T04:28:14.1"), 420.0),
        ("galsim_wcs/tnx.fits", 0, Ok("2006-07-28T02:09:22.0"), 30.0),
        ("galsim_wcs/sipsample.fits", 0, Ok("2007-06-29T03:15:33.555"), 10.4),
        ("trailblazer/cutout_c4d_200306_000415_ori.fits.fz", 5, Ok("2020-03-06T00:04:15.410235"), 120.0),
        ("trailblazer/cutout_HSCA21787010.fits", 0, Ok("2020-05-28T14:32:17.921"), 40.0),
        ("trailblazer/cutout_GMOSN.i.2021-01-17T14_35_11.5_2PAC.fits", 0, Err("69.7 s apart"), 50.0),
        ("trailblazer/cutout_LMI.VR.2021-06-01T04_06_03.67_1PA.fits", 0, Ok("2021-06-01T04:06:03.67"), 300.0),
        ("trailblazer/cutout_A3671-C2018_F4-R-3.fit", 0, Ok("2020-12-09T12:33:40.0"), 300.0),
        ("trailblazer/cutout_frame-i-008108-5-0025.fits", 0, Ok("2009-10-17T01:52:36.59"), 53.907_456),
        ("trailblazer/cutout_lbcb.20210407.120357.fits", 2, Ok("2021-04-07T12:03:57.256"), 120.27),
        ("clean/HorseHead.fits", 0, Ok("1990-12-22T13:49:00"), 3900.0),
        ("clean/sep_image.fits", 0, Ok("1992-10-26T15:04:07.968"), 1200.0),
        // MJD-OBS is 69.7 s later than DATE-OBS (possibly TT). The primary header below states TAI for a DATE-OBS in
        // UTC.
        ("trailblazer/cutout_calexp-0941420_23.fits", 1, Err("37.0 s apart"), 0.0),
        // 26/07/102 is in 2002; JD, the end by its comment, is the same instant as the start.
        ("astride/long.fits", 0, Err("-0.4 s from DATE-OBS + TIME-OBS to JD"), 0.0),
        ("clean/gc_2mass_k.fits", 0, Err("length of the exposure is missing"), 0.0),
    ] {
        let file = FrameFile::open(&data.join("frames").join(name)).unwrap_or_else(|error| panic!("{error}"));
        let found = ExposureTime::from_headers(&[file.header(hdu).expect(name), file.header(0).expect(name)]);
        match (found, expected) {
            (Ok(found), Ok(utc)) => {
                let start: Epoch = format!("{utc} UTC").parse().expect("a moment");
                assert!(seconds_between(start, found.start).abs() < 1e-4, "{name}: {}", found.start);
                assert_eq!(found.duration_s, seconds, "{name}");
            }
            (Err(error), Err(words)) => assert!(error.to_string().contains(words), "{name}: {error}"),
            (found, _) => panic!("{name}: {found:?}"),
        }
    }
    let file = FrameFile::open(&data.join("frames/trailblazer/cutout_c4d_200306_000415_ori.fits.fz")).expect("a file");
    let calibration = Calibration::from_headers(&[file.header(1).expect("S1"), file.header(0).expect("primary")]);
    assert!((calibration.gain_e_adu.expect("a gain").value - 4.031).abs() < 1e-9);
    assert_eq!(calibration.band.expect("a band").value, "g DECam SDSS c0001 4720.0 1520.0");
}

/// The sum of an extremely long exposure time and any epoch is outside the calendar.
#[test]
fn verif_an_extremely_long_exposure_is_rejected() {
    let error = time("DATE-OBS= '2024-08-14T00:00:00'\nEXPTIME =  9223372036854775807").expect_err("refused");
    assert!(error.contains("EXPTIME is 9223372036854776000 s") && error.contains("at most 86400 s"), "{error}");
}

/// Comments that state which part of the exposure an instant is, as observatories and cameras write them.
#[test]
fn verif_comments_state_the_part_of_the_exposure() {
    for (cards, utc, from) in [
        (
            "DATE-OBS= '2020-03-06T06:00:00' / UTC at midpoint of exposure",
            "2020-03-06T05:59:30",
            "DATE-OBS - half of the exposure",
        ),
        ("DATE-OBS= '2020-03-06T06:00:00' / UT, end of integration", "2020-03-06T05:59:00", "DATE-OBS - the exposure"),
        ("DATE-OBS= '2020-03-06T06:00:00' / shutter closed", "2020-03-06T05:59:00", "DATE-OBS - the exposure"),
        (
            "MJD-OBS =             58914.250000 / [d] mid-exposure",
            "2020-03-06T05:59:30",
            "MJD-OBS - half of the exposure",
        ),
        (
            "DATE-OBS= '2020-03-06'\nUT      = '06:00:00' / centre of exposure",
            "2020-03-06T05:59:30",
            "DATE-OBS + UT - half of the exposure",
        ),
        (
            "DATE-OBS= '2020-03-06' / start\nTIME-OBS= '06:00:00' / end",
            "2020-03-06T05:59:00",
            "DATE-OBS + TIME-OBS - the exposure",
        ),
        (
            "DATE-OBS= '2020-03-06' / UT date at mid exposure\nUT-OBS  = '06:00:00'",
            "2020-03-06T05:59:30",
            "DATE-OBS + UT-OBS - half of the exposure",
        ),
        // A keyword of the start precedes one whose comment states the middle.
        ("DATE-OBS= '2020-03-06T06:00:00' / mid\nDATE-BEG= '2020-03-06T05:59:30'", "2020-03-06T05:59:30", "DATE-BEG"),
        // The start of a keyword that is not usable comes from another keyword.
        (
            "DATE-OBS= '2020-03-05T23:00:00' / local time\nMJD-OBS =             58914.250000",
            "2020-03-06T06:00:00",
            "MJD-OBS",
        ),
        (
            "DATE-OBS= '2020-03-06' \nTIME-OBS= '03:00:00' / MST\nUT      = '10:00:00'",
            "2020-03-06T10:00:00",
            "DATE-OBS + UT",
        ),
        (
            "DATE-OBS= '2020-03-06T06:01:01' / Frame Received\nDATE-AVG= '2020-03-06T06:00:30'",
            "2020-03-06T06:00:00",
            "DATE-AVG - half of the exposure",
        ),
        // Comments that state no part.
        (
            "DATE-OBS= '2020-03-06T06:00:00' / Gregorian calendar date, Greenwich mean time",
            "2020-03-06T06:00:00",
            "DATE-OBS",
        ),
        ("DATE-OBS= '2020-03-06T06:00:00' / System Clock:Est. Frame Start", "2020-03-06T06:00:00", "DATE-OBS"),
        ("DATE-OBS= '2020-03-06T06:00:37' / TAI at start", "2020-03-06T06:00:00", "DATE-OBS"),
        ("DATE-OBS= '2020-03-06T06:00:00' / UTC (not the exposure end)", "2020-03-06T06:00:00", "DATE-OBS"),
        ("DATE-OBS= '2020-03-06T06:00:00'\nTIMESCAL= 'linear'", "2020-03-06T06:00:00", "DATE-OBS"),
        ("DATE-OBS= '2020-03-06T06:00:37'\nTIMESYS = 'TAI'\nTIMESCAL= 'log'", "2020-03-06T06:00:00", "DATE-OBS"),
        // "unknown" beside a complete keyword.
        ("DATE-OBS= '2020-03-06T06:00:00'\nDATE_OBS= 'unknown'", "2020-03-06T06:00:00", "DATE-OBS"),
        ("DATE-BEG= 'n/a'\nDATE-OBS= '2020-03-06T06:00:00'", "2020-03-06T06:00:00", "DATE-OBS"),
        ("DATE-OBS= '2020-03-06T06:00:00'\nUTCTIME = '06:00:04'", "2020-03-06T06:00:00", "DATE-OBS"),
        ("DATE-OBS= '2020-03-06T06:00:00'\nUT-TIME = '06:00:04'", "2020-03-06T06:00:00", "DATE-OBS"),
        ("DATE-OBS= '2020-03-06'\nUT-TIME = '06:00:00'", "2020-03-06T06:00:00", "DATE-OBS + UT-TIME"),
    ] {
        begins(&format!("{cards}\n{LENGTH}"), utc, from);
    }
    for (cards, words) in [
        ("DATE-OBS= '2020-03-05T23:00:00' / Local time at start of exposure", "a local time by its comment"),
        ("DATE-OBS= '2020-03-05T23:00:00' / MST date of observation", "a local time by its comment"),
        ("DATE-OBS= '2020-03-06'\nTIME-OBS= '06:00:00' / CEST", "a local time by its comment"),
        // A Julian date that was computed from the local time is not another clock.
        ("DATE-OBS= '2020-03-06T06:00:00' / local\nJD      =          2458914.750000", "a local time by its comment"),
        ("DATE-OBS= '2020-03-06T06:01:01' / System Clock:Frame Received", "the time of an event after the exposure"),
        ("DATE-OBS= '2020-03-06T06:01:01' / Image created time", "the time of an event after the exposure"),
        ("DATE-OBS= '2020-03-06T06:01:01' / start or end of exposure", "of more than one part of the exposure"),
        ("MJD-OBS =             58914.250000 / BJD of start", "a time corrected to the Sun or the barycentre"),
        ("DATE-OBS= '2020-03-06T06:00:00' / mid\nMJD-OBS =         58914.250000 / start", "30.0 s apart"),
        ("DATE-OBS= '2020-03-06T06:00:00' / TAI at start\nTIMESYS = 'UTC'", "in another time scale than TIMESYS"),
        ("DATE-OBS= '2020-03-06'\nUTSTART = '06:00:00' / end of exposure", "not the part of the exposure"),
        ("DATE-OBS= '06/03/2020'\nTIME-OBS= '06:00:00'", "the ambiguous date"),
        ("DATE-OBS= '6/3/2020 6:00:00 AM'", "the ambiguous date"),
        ("DATE-OBS= '2020-03-06T06:00:00'\nDATE_OBS= '2020-03-06T06:00:30'", "30.0 s apart"),
        ("DATE-OBS= '2020-03-05T23:00:00' / MST (UTC = MST + 7 h)", "a local time by its comment"),
        ("DATE-OBS= '2020-03-06T06:00:30' / start + 30 s", "perhaps of another part"),
        ("DATE-OBS= '06/03/20'\nTIME-OBS= '06:00:00'", "dd/mm/yy until 1999"),
        (
            "DATE-OBS= '2020-03-06T06:00:30'\nTIME-SYS= 'TAI'\nTIMESYS = 'UTC'",
            "TIME-SYS is \"TAI\", and TIMESYS is \"UTC\"",
        ),
        (
            "DATE-OBS= '2020-03-06T06:00:30'\nTIMESYS = 'UTC'\nTIMESCAL= 'TAI'",
            "TIMESYS is \"UTC\", and TIMESCAL is \"TAI\"",
        ),
    ] {
        let error = time(&format!("{cards}\n{LENGTH}")).expect_err(words);
        assert!(error.contains(words) && error.contains("--start"), "{error}");
    }
}

/// Stacks, co-added exposures, and units that the comment states.
#[test]
fn verif_lengths_of_several_exposures_and_units() {
    let at = "DATE-OBS= '2020-03-06T06:00:00'\n";
    for (cards, words) in [
        (
            "EXPTIME = 2.0\nDATE-END= '2020-03-06T06:30:00'",
            "EXPTIME is 2 s, but it is 1800.0 s from DATE-OBS to DATE-END",
        ),
        ("EXPTIME = 2.0\nMJD-END = 58914.2708333", "from DATE-OBS to MJD-END"),
        ("EXPTIME = 30.0\nDATE-END= '2020-03-06T06:00:02'", "2.0 s from DATE-OBS to DATE-END"),
        ("EXPTIME = 1425.6\nTELAPSE = 1800.0 / [s]", "TELAPSE is 1800 s (from start to end)"),
        ("EXPOSURE= 0.0165 / [d] time on source\nTELAPSE = 0.0208333333 / [d]", "from start to end"),
        ("EXPTIME = 10.0\nLIVETIME= 1200.0", "LIVETIME is 1200 s (in all parts)"),
        ("EXPTIME = 10.0\nSTACKCNT= 150", "STACKCNT is 150: the time of one exposure or of all"),
        ("EXPTIME = 600.0 / total\nNCOMBINE= 5", "NCOMBINE is 5"),
        ("ITIME   = 2.0 / integration time per coadd\nCOADDS  = 30", "2 s of each of 30 exposures (COADDS)"),
        ("EXPTIME = 2.0 / Integration time\nHIERARCH ESO DET NDIT = 10", "ESO DET NDIT is 10"),
        ("EXPTIME = '00:01:00 PM'", "EXPTIME is \"00:01:00 PM\""),
        ("EXPTIME = '01:01:00 am'", "EXPTIME is \"01:01:00 am\""),
        ("EXPTIME = 20 / [fortnight]", "20 in the unit [fortnight]"),
        ("EXPTIME = 20 / in seconds or ms", "20 in several units"),
        ("EXPTIME = 2 / weeks", "2 in the unit weeks"),
        ("EXPTIME = 600 / exposure x10", "multiplied by a number"),
        ("EXPTIME = '60 s' / [ms]", "EXPTIME is \"60 s\""),
        ("EXPTIME = '1:30'", "EXPTIME is \"1:30\""),
        ("EXPTIME = 5 / Exposure time in 10 ms", "5 in seconds or in the unit of \"10 ms\" (comment"),
    ] {
        let error = time(&format!("{at}{cards}")).expect_err(words);
        assert!(error.contains(words) && error.contains("--exposure"), "{error}");
    }
    for (cards, seconds) in [
        ("EXPTIME = 20000 / [us] exposure time", 0.02),
        ("EXPOSURE= 2.0E-05 / [d] time on source", 1.728),
        ("EXPTIME = 0.5 / [h]", 1800.0),
        ("EXPTIME = 300 / 5 minutes exposure", 300.0),
        ("EXPTIME = 5 / Exposure (min/frame)", 300.0),
        ("EXPTIME = 120 / Exposure time (min)", 7200.0),
        ("EXPTIME = 30.0 / exposure 1/3 (seconds)", 30.0),
        ("EXPTIME = 30.0 / seconds, frame 1/5", 30.0),
        ("EXPTIME = 30.0 / see MJD-OBS", 30.0),
        ("EXPTIME = 30\nEXPTIME = 30.0", 30.0),
        ("EXPTIME = 1500 / exposure in milliseconds", 1.5),
        ("EXPTIME = 60.0 / Exposure time (s) for sum of all coadds\nCOADDS  = 30", 60.0),
        ("EXPTIME = 60.0\nITIME   = 2.0 / per coadd\nCOADDS  = 30", 60.0),
        ("ITIME   = 2.0 / integration time per coadd\nCOADDS  = 1", 2.0),
        ("EXPTIME = 600.0\nNCOMBINE= 5\nDATE-END= '2020-03-06T06:10:20'", 600.0),
        ("EXPTIME = 40.0\nDATE-END= '2020-03-06T06:00:42'", 40.0),
        ("XPOSURE = 107.368\nEXPOSURE= '1' / Exposure request number", 107.368),
        ("EXPTIME = 60.0\nIMGWIDTH= 4656 / width of input images", 60.0),
        ("EXPTIME = 60.0\nIMGHIGHT= 3520 / height of stacked frames", 60.0),
        ("EXPTIME = 60.0 / [s] (not ms)", 60.0),
        ("EXPTIME = 60.0 / [s] not including overheads", 60.0),
        ("EXPTIME = '60 s' / [s] exposure", 60.0),
        ("EXPTIME = '1.5 min'", 90.0),
        ("EXPTIME = '00:01:30'", 90.0),
    ] {
        let found = time(&format!("{at}{cards}")).unwrap_or_else(|error| panic!("{cards}: {error}"));
        assert!((found.duration_s - seconds).abs() < 1e-9, "{cards}: {}", found.duration_s);
    }
    // A given exposure time is not compared with the end of a stack.
    let stack = Header::from_text(&format!("{at}EXPTIME = 2.0\nDATE-END= '2020-03-06T06:30:00'"));
    assert!(ExposureTime::with_given(&[&stack], None, Some(1800.0)).is_ok());
}

/// Gains that are settings of cameras, as N.I.N.A., SharpCap and INDI write them.
#[test]
fn verif_settings_of_cameras_are_no_gains() {
    let of = |text: &str| Calibration::from_headers(&[&Header::from_text(text)]);
    for cards in [
        "GAIN    = 360",
        "GAIN    = 2 / Sensor gain",
        "GAIN    = 12.0 / [dB]",
        "GAIN    = 4 / Gain of Camera",
        "GAIN    = 5 / Gain\nOFFSET  = 10 / Offset",
        "GAIN    = 1 / Gain Value",
        "GAIN    = 100 / pre-amp",
        "GAIN    = 4 / preamp gain",
        "GAIN    = 16 / [%]",
        "GAIN    = 1.7 / [uV/e-]",
        "GAIN    = 3 / gain table entry",
        "GAIN    = 1.39 / 0.1dB units",
        "GAIN    = 3 / left shift",
        "GAIN    = 12\nINSTRUME= 'ZWO ASI294MM Pro'",
        "GAIN    = 12\nINSTRUME= 'ASI294MM'",
        "GAIN    = 8\nCAMERA  = 'Sony A7'",
        "GAIN    = 5 / gain\nSWCREATE= 'N.I.N.A. 3.1.2.9001 (x64)'",
        "EGAIN   = 340",
        "EGAINSAV= 340",
        "CCDGAIN = 100",
        "GAINA   = 360\nGAINB   = 360",
        "EGAIN   = 1.0 / gain setting",
        "GAIN    = 2 / x2",
        "GAIN    = 5\nINSTRUME= 'SV605CC'",
        "GAIN    = 10\nINSTRUME= 'Vespera Pro'",
        "GAIN    = 10\nINSTRUME= 'Seestar S50'",
        "GAIN    = 3\nINSTRUME= 'MallinCam DS26c'",
        "GAIN    = 12\nINSTRUME= 'FLIR Blackfly S'",
    ] {
        let calibration = of(cards);
        assert_eq!(calibration.gain_e_adu, None, "{cards}");
        assert!(calibration.doubtful_gain.expect(cards).contains("a setting of the camera"), "{cards}");
    }
    let other = of("EGAIN   = 0.1226 / Electrons per ADU at true ADC bit depth");
    assert_eq!(other.gain_e_adu, None);
    assert!(other.doubtful_gain.unwrap().contains("not of the pixels of this file"));
    for (cards, words) in [
        ("SWCREATE= 'SharpCap v4.1.10745.0, 64 bit'\nEGAIN   = 3.6 / Electrons per ADU", "SharpCap without EGAINSAV"),
        ("CREATOR = 'SharpCap v4.1'\nGAIN    = 100\nEGAIN   = 0.9", "SharpCap without EGAINSAV"),
        ("GAIN    = 0.54 / e- to ADU conversion", "electrons per count or counts per electron"),
        ("GAIN    = 2.5 / electrons to counts", "electrons per count or counts per electron"),
    ] {
        let calibration = of(cards);
        assert_eq!(calibration.gain_e_adu, None, "{cards}");
        assert!(calibration.doubtful_gain.expect(cards).contains(words), "{cards}");
    }
    for unit in ["[e-/ADU]", "[electrons/count]", "[e/DN]"] {
        let two = of(&format!("GAIN    = 1.0 / {unit}\nEGAIN   = 2.5"));
        let words = format!("GAIN is 1 ({unit})");
        assert_eq!((two.gain_e_adu, two.doubtful_gain.unwrap().contains(&words)), (None, true), "{unit}");
    }
    for (cards, gain) in [
        ("GAIN    = 360 / Sensor gain\nEGAIN   = 0.25 / [e-/ADU] Electrons per A/D unit", 0.25),
        (
            "EGAIN   = 0.1226 / Electrons per ADU at true ADC bit depth\nEGAINSAV= 0.00766 / Electrons per ADU at saved bit depth",
            0.00766,
        ),
        ("GAIN    = 1250.0 / [e-/ADU] Maximum equivalent gain", 1250.0),
        ("EGAIN   = 340 / e-/ADU", 340.0),
        ("GAIN    = 100\nEGAIN   = 0.25\nOFFSET  = 10", 0.25),
        ("GAIN    = 3.3 / e/DN conversion", 3.3),
        ("GAIN    = 4.5 / camera gain (electrons/ADU)", 4.5),
        ("GAIN    = 1.6", 1.6),
        ("GAIN    = 1.6\nINSTRUME= 'ALFOSC'", 1.6),
        ("GAIN    = 0.98\nINSTRUME= 'Asiago AFOSC'", 0.98),
        ("GAIN    = 0.8\nDETECTOR= 'Sony IMX455'", 0.8),
        ("GAIN    = 0.25 / e-/ADU\nINSTRUME= 'QHY600M'", 0.25),
        // ESO: GAIN is the inverse of CONAD.
        ("GAIN    = 0.5 / Conversion from electrons to ADU", 2.0),
        ("GAIN    = 0.8 / Conversion from ADUs to electrons", 0.8),
        ("HIERARCH ESO DET OUT1 CONAD = 1.91 / Conversion from ADUs to electrons", 1.91),
        ("SWCREATE= 'SharpCap v4.1'\nEGAIN   = 3.6\nEGAINSAV= 0.225", 0.225),
        ("GAIN    = 1.5\nINSTRUME= 'SVOM VT'", 1.5),
    ] {
        let calibration = of(cards);
        assert_eq!((calibration.gain_e_adu.expect(cards).value, calibration.doubtful_gain), (gain, None), "{cards}");
    }
}

/// Units in other keywords, counts of added frames, and times of the end without a date.
#[test]
fn valid_units_and_parts_in_other_keywords() {
    let read = |text: &str| {
        let header = Header::from_text(&format!("DATE-OBS= '2026-08-22T23:59:00'\n{text}"));
        ExposureTime::from_headers(&[&header])
    };
    for (text, seconds) in [
        ("EXPTIME = 2000\nEXPUNIT = 'ms'\n", 2.0),
        ("XPOSURE = 0.0005\nTIMEUNIT= 'd'\n", 43.2),
        ("EXPOSURE= 2.31481481481481E-05 / [d] time on source\n", 2.0),
        ("EXPTIME = 2.0 / [s]\nTIMEUNIT= 'd'\n", 2.0),
        ("EXPTIME = 2.0\nNFRAMES = 30 / frames of the sequence\n", 2.0),
        ("EXPTIME = 30.0\nUT-END  = '00:00:10'\n", 30.0),
    ] {
        assert_eq!(read(text).expect(text).duration_s, seconds, "{text}");
    }
    for text in [
        "EXPTIME = 2.0\nTIMEUNIT= 'd'\n",
        "EXPTIME = 2.0\nEXPUNIT = 'ticks'\n",
        "EXPTIME = 2.0\nNFRAMES = 30 / number of stacked frames\n",
        "EXPTIME = 2.0\nUT-END  = '00:29:00'\n",
    ] {
        assert!(read(text).is_err(), "{text}");
    }
    // The date may be the local one, a day before that of universal time.
    let header =
        Header::from_text("DATE-OBS= '2026-08-21'\nTIME-OBS= '20:14:59' / LT\nUT      = '03:14:59'\nEXPTIME = 2.0\n");
    assert!(ExposureTime::from_headers(&[&header]).is_err());
    let header =
        Header::from_text("DATE-OBS= '2026-08-21'\nTIME-OBS= '18:14:59' / LT\nUT      = '23:14:59'\nEXPTIME = 2.0\n");
    assert!(ExposureTime::from_headers(&[&header]).is_ok());
}

/// Keywords of the start, the middle and the end, whatever their spelling, must agree.
#[test]
fn verif_all_keywords_of_an_instant_must_agree() {
    let at = "DATE-OBS= '2026-08-22T03:14:59'\nEXPTIME =                  2.0\n";
    for cards in [
        "UTC-OBS = '04:14:59' / UT at start of exposure",
        "UTSTART = '03:15:09'",
        "UT      = '04:14:59' / UT at start of exposure",
        "UT      = '02:14:59'",
        "TIME-OBS= '03:25:59'",
        "JD      =            2461274.7 / Julian date at start of exposure",
        "MJD     =              61274.2 / MJD at start of exposure",
        "EXPSTART=       61274.20000000",
        "MJDEND  =       61274.15627000",
        "JD-END  =     2461274.65627000",
        "EXPEND  = '2026-08-22T03:44:59'",
        "DATE-STP= '2026-08-22T03:44:59'",
        "DATE-OBS= '2026-08-23T03:14:59'",
        "DATE-LOC= '2026-08-22T03:14:59' / local",
        "LOCALTIM= '8/21/2026 03:14:59 AM MST'",
        "TREFPOS = 'BARYCENT'",
        "TIMEREF = 'SOLARSYSTEM'",
    ] {
        let error = time(&format!("{at}{cards}")).expect_err(cards);
        assert!(error.contains("--start") || error.contains("--exposure"), "{error}");
    }
    for cards in [
        "UTC-OBS = '03:14:59.4'\nMJDEND  =       61274.13542824",
        "UT      = '03:15:40' / end of readout",
        "UT      =             11699.00 / [s] UTC at start",
        "UT      =            3.2497222 / hours",
        "UTC     = '03:15:04'",
        "JD      =       2461274.635439 / at midtime",
        "DATE-LOC= '2026-08-21T20:14:59' / local",
        "DATE-LOC= '2026-08-22T03:14:59' / local\nSITELONG= '-00 10 00'",
        "DATE-LOC= '2026-08-22T03:14:59' / local\nTIMEZONE= 0",
        "DATE-LOC= '2026-08-22T03:14:59' / local\nTIMESYS = 'UTC'",
        "TREFPOS = 'TOPOCENTER'",
        "TIMEREF = 'GPS'",
        "MJD     =                61274 / number of the night",
        "MJD-OBS =       61274.13540509 / Modified Julian Date at start of exposure",
        "DATE-OBS= '2026-08-22T03:14:59'",
    ] {
        begins(&format!("{at}{cards}"), "2026-08-22T03:14:59", "DATE-OBS");
    }
    let zone = "DATE-OBS= '2026-08-21T20:14:59'\nEXPTIME = 2.0\nDATE-LOC= '2026-08-21T20:14:59'\nTIMEZONE= -7\n";
    assert!(time(zone).is_err());
}

/// Dates without a time, and comments in COMMENT cards.
#[test]
fn verif_dates_of_the_night_and_remarks() {
    for (cards, utc, from) in [
        (
            "DATE-OBS= '2026-08-21' / date of start\nUT      = '00:00:10' / end of exposure\nEXPTIME = 20.0",
            "2026-08-21T23:59:50",
            "DATE-OBS + UT - the exposure",
        ),
        ("DATE-OBS= '2026-08-22'\nUT      = 11699.0 / [s]\nEXPTIME = 2.0", "2026-08-22T03:14:59", "DATE-OBS + UT"),
        ("SHUTOPEN= '2026-08-22T03:14:59.000'\nEXPTIME = 30.0", "2026-08-22T03:14:59", "SHUTOPEN"),
        ("UTC-OBS = '2026-08-22T03:14:59.000'\nEXPTIME = 30.0", "2026-08-22T03:14:59", "UTC-OBS"),
        (
            "DATE-OBS= '2026-08-22T03:15:29'\nEXPTIME = 60.0\nCOMMENT DATE-OBS is the mid-time of the exposure",
            "2026-08-22T03:14:59",
            "DATE-OBS - half of the exposure",
        ),
    ] {
        begins(cards, utc, from);
    }
    for (cards, words) in [
        ("DATE-OBS= '2026-08-21'\nUT      = '00:00:10' / end", "on the day before the date"),
        (
            "DATE-OBS= '2026-08-22' / UT date at end of exposure\nUT      = '23:59:40' / UT at start",
            "which is that of the middle or the end",
        ),
        ("DATE-OBS= '2026-08-21' / UT date at start of night\nUT      = '03:14:59'", "date of the evening"),
        ("DATE-OBS= '2026-08-21'\nUT-DATE = '2026-08-22'\nUT      = '03:14:59'", "UT-DATE is 2026-08-22"),
        ("DATE-OBS= '2026-08-22'\nUT      = 3.2497", "UT is 3.2497 without a unit"),
        ("DATE-OBS= '2026-08-22T03:15:17' / GPS time", "GPS time"),
        ("DATE-OBS= '2026-08-22T03:15:17' / PC time", "the clock of a computer"),
        ("DATE-OBS= '2026-08-22T03:15:17' / UTC start of sequence", "another event"),
        ("DATE-OBS= '2026-08-22T03:15:17' / TCB", "coordinate time"),
    ] {
        let error = time(&format!("{cards}\nEXPTIME = 20.0")).expect_err(words);
        assert!(error.contains(words), "{error}");
    }
}

/// Counts of added frames in keywords, comments and the history.
#[test]
fn verif_counts_of_stacked_frames() {
    let at = "DATE-OBS= '2026-08-22T03:14:59'\n";
    for cards in [
        "EXP_TIME= 3.0 / [s] Integration time per exposure\nNEXP    = 2 / Number of exposures in integration",
        "EXPTIME = 120.0\nHISTORY ImageIntegration.numberOfImages: 30",
        "EXPTIME = 60.0\nIMCMB001= 'a.fits'\nIMCMB002= 'b.fits'",
        "EXPTIME = 60.0\nNINPUTS = 20 / number of inputs",
        "EXPTIME = 1800.0 / Maximum equivalent exposure time (s)",
        "EXPTIME = 2.0\nFRAMES  = 30 / Number of frames in stack",
        "EXPTIME = 2.0\nNSUB    = 30 / number of stacked subframes",
        "EXPTIME = 2.0\nLIGHTS  = 30 / light frames count, averaged",
        "EXPTIME = 12.0\nHIERARCH ESO DET DIT = 5.0\nHIERARCH ESO DET NDIT = 5",
        "EXPTIME = 12.0\nHIERARCH ESO DET DIT = 12.0\nHIERARCH ESO DET NDIT = 5\nNCOMBINE= 4",
        "EXPTIME = 30.0\nIMAGETYP= 'Master Light'",
        "EXPTIME = 30.0\nBINFRMS = 4 / frames binned in software",
        "EXPTIME = 2028.0\nNDRIZIM = 4 / Drizzle, number of images drizzled onto output",
        "EXPTIME = 1200.0 / Total exposure time in seconds.\nLIGH_CNT= 20 / Light frames combined.",
        "EXPTIME = 60.0\nLUM_CNT = 20 / Luminance images combined.",
        "EXPTIME = 30.0\nNIMAGES = 40 / Images in this batch stack",
        "EXPTIME = 30.0\nNIMG    = 40 / NUMBER IMAGES COADDED",
        "EXPTIME = 30.0\nNFRAMES = 40 / frames averaged",
        "EXPTIME = 30.0\nNIMAGES = '40' / number of images stacked",
        "EXPTIME = 30.0\nACCUM   = 10 / Accumulated images",
        "EXPTIME = 30.0\nNUMACC  = 10 / number of accumulations",
        "EXPOSURE= 2.0 / Total Exposure Time\nACT     = 10.0 / Accumulate cycle time\nNUMACC  = 5",
        "EXPTIME = 30.0 / Exposure of each sub (s)\nNSUBS   = 12",
        "EXPTIME = 10.0\nEXP1TIME= 10.0\nCOEXP   = 6",
        "EXPTIME = 30.0\nPROCTYPE= 'Stacked'",
        "EXPTIME = 30.0\nIMAGETYP= 'STACK'",
        "EXPTIME = 30.0\nIMAGETYP= 'Integration'",
        "EXPTIME = 30.0\nIMAGETYP= 'MasterLight'",
        "EXPTIME = 30.0\nFRAMETYP= 'LiveStack'",
        "EXPTIME = 900.0\nINTEGRAT= 'Integration' / integration of light frames",
        "EXPTIME = 900.0\nCALSTAT = 'DFBS'",
        "EXPTIME = 12.0\nHIERARCH ESO DET WIN1 NDIT = 5",
        "EXPTIME = 30.0\nCOMMENT Stacked 12 images using median",
        "EXPTIME = 30.0\nHISTORY [Siril] Stacking result: 12 frames",
        "EXPTIME = 30.0\nHISTORY Combined 12 frames with average",
    ] {
        let error = time(&format!("{at}{cards}")).expect_err(cards);
        assert!(error.contains("--exposure"), "{error}");
    }
    for (cards, seconds) in [
        ("EXPTIME = 60.0\nNBIAS   = 20 / number of bias frames combined", 60.0),
        ("EXPTIME = 60.0\nIMAGEID = 7 / image identification number in stack", 60.0),
        ("EXPTIME = 60.0\nDARK_CNT= 20 / Dark frames combined.", 60.0),
        ("EXPTIME = 60.0\nPROCTYPE= 'MasterCal stack, bias'", 60.0),
        ("EXPTIME = 60.0\nIMAGETYP= 'Master Dark'", 60.0),
        ("EXPTIME = 60.0\nIMAGETYP= 'MasterFlat integration'", 60.0),
        ("EXPTIME = 60.0\nCALSTAT = 'BDF'", 60.0),
        ("EXPTIME = 60.0\nCALSTAT = 'BIAS'", 60.0),
        ("EXPTIME = 30.0\nHIERARCH ESO DET WIN1 DIT1 = 0.1\nHIERARCH ESO DET WIN1 NDIT = 300", 30.0),
        ("EXPTIME = 12.0\nHIERARCH ESO DET WIN1 DIT1 = 12.0\nHIERARCH ESO DET WIN1 NDIT = 5", 60.0),
        ("EXPTIME = 12.0\nHIERARCH ESO DET2 DIT = 12.0\nHIERARCH ESO DET2 NDIT = 5", 60.0),
        ("EXPTIME = 10.4 / [sec] Effective integration time per pixel\nNUMREPS = 4 / Number of frame repeats", 10.4),
        ("EXPTIME = 12.0\nHIERARCH ESO DET DIT = 12.0\nHIERARCH ESO DET NDIT = 5", 60.0),
        ("EXPTIME = 300.0\nHIERARCH ESO DET DIT = 60.0\nHIERARCH ESO DET NDIT = 5", 300.0),
        ("EXPTIME = 12.0\nHIERARCH ESO DET SEQ1 DIT = 12.0\nHIERARCH ESO DET NDIT = 2", 24.0),
        ("EXPTIME = 60.0\nHISTORY Master flat combined from 12 frames", 60.0),
        ("EXPTIME = 60.0\nHISTORY 12 frames in the night", 60.0),
        ("EXPTIME = 60.0\nEXP1TIME= 10.0\nCOEXP   = 6", 60.0),
        ("EXPTIME = 60.0\nIMCMB001= 'a.fits'", 60.0),
        ("EXPTIME = 60.0 / Total integration time\nHIERARCH ESO DET DIT = 12.0\nHIERARCH ESO DET NDIT = 5", 60.0),
        ("EXPOINUS= 2000000 / Exposure time in us", 2.0),
        ("EXPTIME = 2.0\nEXPOINUS= 2000000", 2.0),
        ("TRUITIME= 2.0\nCOADDONE= 1", 2.0),
        ("EXPTIME = 2.0\nEXPCOUNT= 7", 2.0),
        ("EXPTIME = 2.0 / [s] time of each frame\nNSEQ    = 5 / number of exposures in sequence", 2.0),
    ] {
        let found = time(&format!("{at}{cards}")).unwrap_or_else(|error| panic!("{cards}: {error}"));
        assert_eq!(found.duration_s, seconds, "{cards}");
    }
}

/// What may state a stack, another exposure, another instant or a local time is stated.
#[test]
fn verif_other_readings_of_a_header_are_stated() {
    let at = "DATE-OBS= '2026-08-22T03:15:00'\nEXPTIME =                 30.0\n";
    for (card, words) in [
        ("CRSPLIT = 2 / number of cosmic ray split exposures", "CRSPLIT is 2"),
        ("NB_IMG  = 10 / nombre d'images additionnees", "NB_IMG is 10"),
        ("SUMFRAME= 4", "SUMFRAME is 4"),
        ("STACK_N = 4", "STACK_N is 4"),
        ("UT      = '03:15:00' / start of stack", "UT is that of a stack"),
        ("NAVERAGE= 4", "NAVERAGE is 4"),
        ("HISTORY Drizzle 6 images", "HISTORY is"),
        ("NSTACKED= 4", "NSTACKED is 4"),
        ("NIMCOMB = 4", "NIMCOMB is 4"),
        ("ISSTACK = T", "ISSTACK is T"),
        ("SOFTNAME= 'SWarp'", "SOFTNAME is \"SWarp\""),
        ("DATE-OB2= '2026-08-22T03:25:00' / last frame", "DATE-OB2 is 570.0 s later than the end"),
        ("MJDMEAN = 61274.1388889", "MJDMEAN is"),
        ("NAVER   = 5.0", "NAVER is 5"),
        ("LIVESTK = 10 / live stack count", "LIVESTK is 10"),
        ("HIERARCH STACK COUNT = 5", "STACK COUNT is 5"),
        ("HIERARCH FRAMES STACKED = 5", "FRAMES STACKED is 5"),
        ("COMBINET= 'sum 3 images'", "COMBINET is \"sum 3 images\""),
        ("COMBINED= T", "COMBINED is T"),
        ("STACK   = '12x30s'", "STACK is \"12x30s\""),
        ("OBJECT  = 'M 31, 12 subs x 30 s'", "OBJECT is"),
        ("COMBINE1= 'a.fits'\nCOMBINE2= 'b.fits[1]'", "COMBINE1 is the first of 2 files"),
        ("INP_0000= 'a.fits'\nINP_0001= 'b.fits'", "INP_0000 is the first of 2 files"),
        ("HISTORY ncombine = 12", "HISTORY is \"ncombine = 12\""),
        ("HISTORY imcombine: a1.fits a2.fits a3.fits", "HISTORY is"),
        ("HISTORY ImageIntegration.pixelCombination: Average", "HISTORY is"),
        ("COMMENT Average of 12 frames", "COMMENT is"),
        ("SUBEXP  = 5", "SUBEXP is 5"),
        ("FRAMEAVG= 16", "FRAMEAVG is 16"),
        ("ACTEXP  = 12.0 / actual exposure time", "ACTEXP is 12 s"),
        ("EXPMEAS = 28.2", "EXPMEAS is 28.2 s"),
        ("T_EXP   = 28.2 / measured exposure time", "T_EXP is 28.2 s"),
        ("DARKTIME= 12.1", "DARKTIME is 12.1 s"),
        ("ABORTED = T", "ABORTED is T: if the exposure was shorter"),
        ("EXPSTATE= 'ABORTED'", "EXPSTATE is \"ABORTED\""),
        ("TZNAME  = 'MST'", "TZNAME is MST: if it is a local time"),
        ("DST     = T / daylight saving time", "DST is T: if it is a local time"),
        ("DAYLTSAV= T", "DAYLTSAV is T"),
        ("DST     = 'YES'", "DST is YES"),
        ("EXPSTACK= 600.0", "EXPSTACK is 600 s"),
        ("CLKREF  = 'LOCAL' / clock reference", "CLKREF is LOCAL"),
        ("DURATION= 130.0", "DURATION is 130 s"),
        (
            "OPENSHUT= '2026-08-22T03:14:27' / Time when shutter opened (UTC)",
            "OPENSHUT is 33.0 s earlier than the start",
        ),
        ("TOTTIME = 600.0", "TOTTIME is 600 s"),
        ("WALLTIME= 600.0", "WALLTIME is 600 s"),
        ("OBS-DUR = 600", "OBS-DUR is 600 s"),
        ("TIMESPAN= 10.0 / [min]", "TIMESPAN is 600 s"),
        ("LENGTH  = 600.0 / [s] wall-clock time", "LENGTH is 600 s"),
        ("UTC-LAST= '03:25:00'", "UTC-LAST is 570.0 s later than the end of the exposure"),
        ("LASTUT  = '02:00:00'", "LASTUT is 4530.0 s earlier than the end of the exposure"),
        ("MAXJD   = 2461274.65", "MAXJD is"),
        ("UTCFIRST= '03:05:00'", "UTCFIRST is 600.0 s earlier than the start of the exposure"),
        ("DATELAST= '2026-08-25'", "DATELAST is"),
        ("DATE-END= '2026-08-25'", "DATE-END is"),
        ("NINTS   = 12 / Number of integrations in exposure", "NINTS is 12"),
        ("SOFTWARE= 'DeepSkyStacker 5.1.3'", "SOFTWARE is \"DeepSkyStacker 5.1.3\""),
        ("INSTRUME= 'Canon EOS 6D'", "INSTRUME is Canon EOS 6D: if it is a local time"),
        ("T_STACK = 600.0 / total exposure time (s)", "T_STACK is 600 s"),
        ("OBS-END = '2026-08-22T03:45:00'", "OBS-END is 1770.0 s later than the end of the exposure"),
        ("SHUTCLOS= '2026-08-22T03:15:02'", "SHUTCLOS is 28.0 s earlier than the end"),
        ("TSTOP   = 61274.2 / MJD stop", "TSTOP is"),
        ("MIDMJD  = 61274.2", "later than the middle of the exposure"),
        ("JD_UTC  = 2461274.7 / Julian Date at mid-exposure", "later than the middle of the exposure"),
        ("UTOFFSET= -7", "UTOFFSET is -7: if it is a local time"),
        ("TIMEZONE= -7.0 / hours", "TIMEZONE is -7"),
        ("TZ      = 'America/Phoenix'", "TZ is America/Phoenix"),
        ("LOCALOFF= -25200 / offset from UTC (s)", "LOCALOFF is -25200"),
        ("COMMENT DATE-OBS: GPS trigger time", "perhaps another instant"),
        ("COMMENT All times refer to mid-exposure", "the header has the card \"COMMENT All times"),
        ("HISTORY PC clock was 45 s fast", "the header has the card"),
        ("TIMSYER = 30.0 / [s]", "the header has the card \"TIMSYER = 30.0"),
        ("CLKERR  = 12.0 / [s] clock error", "the header has the card \"CLKERR"),
        ("HISTORY Median of 25 light frames", "HISTORY is"),
        ("COMMENT DATE-OBS: start, accurate to 5 s", "uncertain by 5.0 s, by its digits or comment"),
    ] {
        let found = time(&format!("{at}{card}")).unwrap_or_else(|error| panic!("{card}: {error}"));
        assert!(found.remarks.len() == 1 && found.remarks[0].contains(words), "{card}: {:?}", found.remarks);
        assert_eq!(found.duration_s, 30.0, "{card}");
    }
    for card in [
        "CRSPLIT = 2\nNCOMBINE= 1",
        "NUMKIN  = 5 / kinetic series",
        "EXPCOUNT= 7",
        "ASSON1  = 'weight.fits'\nASSON2  = 'mask.fits'",
        "FLAT1   = 'a.fits'\nFLAT2   = 'b.fits'",
        "HISTORY flatcombine: a1.fits a2.fits a3.fits",
        "CCDSUM  = '2 x 2'",
        "CHECKSUM= '12'",
        "FLATEXP = 360.0 / total exposure of flats",
        "DARKTIME= 38.8 / Total elapsed time (sec)",
        "DARKTIME= 30.0",
        "ABORTED = F",
        "OPENSHUT= '2026-08-22T03:15:01.2' / Time when shutter opened (UTC)",
        "CANABORT= T",
        "AIRMASS = 1.31 / actual airmass at start of exposure",
        "TIMEREF = 'LOCAL'",
        "EXPREQ  = 30.0 / requested exposure time",
        "CLOCK   = 'GPS'",
        "APMEDJD = 2461274.6 / Median JD used in abs phot cal",
        "LAUNCH  = 1500",
        "OBSEND  = '2026-08-22T03:15:31'",
        "BLOCKEND= '2026-08-22T04:45:00' / end of observation block",
        "BJD_TDB = 2461274.7 / Barycentric JD at mid-exposure",
        "TIMEZONE= -7\nTIMESYS = 'UTC'",
        "TIMEZONE= -7\nDATE-LOC= '2026-08-21T20:15:00'",
        "TIMEZONE= 'UTC'",
        "TZERO1  = 3600",
        "DETREND = '2026-08-23T03:15:00' / date of the processing",
        "DUT1    = 0.1 / UT1 offset from UTC",
        "LEAPSEC = 37 / offset of TAI from UTC",
        "TIMSYER = 0.05 / [s]",
        "SKYMEAN = 2461274.0",
        "DATE_OBS= '2026-08-22'",
        "CALEND  = '2030-01-01T00:00:00' / end of validity of calibration",
        "COMMENT Exposure time in seconds, times in UTC at start",
        "D2IMERR1= 0.02",
        "UTC-FIRST= '03:15:00'\nUTC-LAST= '03:15:30'",
        "MINJD   = 2461274.63542\nMAXJD   = 2461274.63576",
        "DATELAST= '2026-08-22'",
        "STEND   = '05:55:07' / ST end",
        "LASTCAL = '2026-08-25T03:15:00'",
        "LASTEXP = 12",
        "GUIDEUT = '03:05:00' / UTC of the last frame of the guider",
        "PREVOBS = '2026-08-22T03:05:00' / UTC of the last exposure",
        "DATE-CAL= '2026-08-22T03:05:00' / UTC of the last image",
        "INSTRUME= 'Canon EOS 6D'\nTIMESYS = 'UTC'",
        "WALLTEMP= 285.0",
    ] {
        let found = time(&format!("{at}{card}")).unwrap_or_else(|error| panic!("{card}: {error}"));
        assert_eq!(found.remarks, [""; 0], "{card}");
    }
    for (cards, words) in [
        ("EXPTIME = 30.0 / individual exposure time\nNUM     = 12", "its comment is \"individual exposure time\""),
        ("EXPTIME = 60.0 / [sec] total (3 x 20)", "its comment is"),
        ("EXPTIME = 60.0 / sum of 10 exposures", "its comment is"),
        ("EXPTIME = 60.0 / [s] +/- 5 s", "approximately"),
        ("EXPTIME = 60.0 / [s] incl. 2 s of readout", "with overheads"),
        ("EXPTIME = 12.0\nHIERARCH ESO DET DIT = 12.0\nHIERARCH ESO DET NDIT = 5", "ESO DET DIT x ESO DET NDIT = 60 s"),
    ] {
        let found = time(&format!("DATE-OBS= '2026-08-22T03:15:00'\n{cards}")).expect(cards);
        assert!(found.remarks.len() == 1 && found.remarks[0].contains(words), "{cards}: {:?}", found.remarks);
    }
    for (stated, remarks) in [("", 1), (" / UT date", 0)] {
        let found = time(&format!("OBS-DATE= '2026-08-22T03:15:00'{stated}\nEXPTIME = 60.0")).unwrap();
        assert_eq!(found.remarks.len(), remarks, "{stated}: {:?}", found.remarks);
    }
    for card in ["DATETIME= '2026:08:21 20:15:00'", "DATE-TIM= '2026-08-21 20:15:00'"] {
        assert!(time(&format!("{card}\nEXPTIME = 60.0")).is_err(), "{card}");
    }
    let error = time("DATE-OBS= '2026-08-22T03:15:00' / start (+/- 30 s)\nEXPTIME = 60.0").unwrap_err();
    assert!(error.contains("uncertain by 30 s") && error.contains("--start"), "{error}");
}

/// Days computed from a date are of the same part of the exposure, and the clock UT of Subaru is that of the start.
#[test]
fn valid_middles_of_wise_and_subaru() {
    for (cards, utc) in [
        ("DATE_OBS= '2026-08-22T03:15:30' / Date of mid-frame (UTC)\nMJD_OBS = 61274.13576389", "2026-08-22T03:15:00"),
        ("TAI     = 5294085367.0 / TAI seconds at centre of exposure", "2026-08-22T03:15:00"),
        (
            "DATE-OBS= '2026-08-22'\nUT-STR  = '03:15:00'\nUT      = '03:15:00' / typical UTC at the exposure (middle",
            "2026-08-22T03:15:00",
        ),
    ] {
        let found = time(&format!("{cards}\n{LENGTH}")).unwrap_or_else(|error| panic!("{error}"));
        let expected: Epoch = format!("{utc} UTC").parse().expect("a moment");
        assert!(seconds_between(expected, found.start).abs() < 1e-3, "{cards}: {}", found.start);
    }
    // One reading of the clock is that of the start or of the middle.
    let error = time(&format!("DATE-OBS= '2026-08-22'\nUT      = '03:15:00' / middle\nTIME-OBS= '03:15:00'\n{LENGTH}"));
    assert!(error.unwrap_err().contains("30.0 s apart"));
}

/// Clocks read after the exposure are late, and never before the start.
#[test]
fn verif_a_clock_is_not_before_the_start() {
    let at = "DATE-OBS= '2026-08-22T03:15:00'\nEXPTIME =                300.0\n";
    for card in [
        "UT      = '03:10:00'",
        "UTC     = '03:12:30'",
        "JD      =   2461274.6336805555",
        "MJD     =     61274.1319444444",
        "UTIME   = '03:14:47'",
        "UT-END  = '03:15:00'",
    ] {
        assert!(time(&format!("{at}{card}")).is_err(), "{card}");
    }
    for (card, remarks) in [
        ("UT      = '03:14:59.5'", 0),
        // As in headers of ESO's HARPS.
        ("UTC     = '03:14:54.6' / 03:14:54.600 UTC at start (sec)", 1),
        ("UT      = '03:15:03'", 0),
        ("UT      = '03:20:45'", 1),
        // Days of which the digits after the fourth are cut off.
        ("JD      =         2461274.6354", 0),
        ("MJD     =                61274 / number of the night", 0),
    ] {
        let found = time(&format!("{at}{card}")).expect(card);
        assert_eq!((found.start_from.as_str(), found.remarks.len()), ("DATE-OBS", remarks), "{:?}", found.remarks);
    }
}

/// Days with few decimals and times without seconds are used only to confirm a better clock.
#[test]
fn verif_coarse_times_are_no_starts() {
    for (cards, words) in [
        ("MJD-OBS =                61274", "MJD-OBS is \"61274\", uncertain by 43200 s"),
        ("DATE-OBS= '2026-08-22'\nMJD-OBS =                61274", "MJD-OBS is \"61274\""),
        ("DATE-OBS= '2026-08-22'\nJD      =              2461275", "JD is \"2461275\""),
        ("DATE-OBS= '2026-08-22'\nJD      =            2461274.6", "uncertain by 4320 s"),
        ("MJD-OBS = '61274.135'", "uncertain by 43 s"),
        ("DATE-OBS= '2026-08-22T03:15'", "DATE-OBS is \"2026-08-22T03:15\", uncertain by 60 s"),
        ("DATE-OBS= '2026-08-22'\nUT      = '03:15'", "DATE-OBS + UT is \"03:15\""),
        ("DATE-OBS= '2026-08-22'\nUT      = 3.25 / [h]", "uncertain by 18 s"),
        ("MJD-END =              61274.1", "uncertain by 4320 s"),
    ] {
        let error = time(&format!("{cards}\n{LENGTH}")).expect_err(cards);
        assert!(error.contains(words) && error.contains("--start"), "{error}");
    }
    for (cards, utc, from, remarks) in [
        ("DATE-OBS= '2026-08-22T00:00:00'", "2026-08-22T00:00:00", "DATE-OBS", 0),
        ("MJD-OBS =                61274\nJD      =     2461274.63541667", "2026-08-22T03:15:00.000288", "JD", 0),
        ("DATE-OBS= '2026-08-22'\nTIME-OBS= '03:15'\nUT      = '03:15:40'", "2026-08-22T03:15:40", "UT", 0),
        ("JD      =         2461274.6354", "2026-08-22T03:14:58.56", "JD", 1),
    ] {
        let found = time(&format!("{cards}\n{LENGTH}")).unwrap_or_else(|error| panic!("{error}"));
        let expected: Epoch = format!("{utc} UTC").parse().expect("a moment");
        assert!(seconds_between(expected, found.start).abs() < 1e-3, "{} is not {utc}", found.start);
        assert_eq!((found.start_from.as_str(), found.remarks.len()), (from, remarks), "{:?}", found.remarks);
    }
    // Ten times 1 s do not fit into 1.9 s.
    for (cards, is_read) in [
        ("EXPTIME = 1.0\nCOADDS  = 10\nDATE-END= '2026-08-22T03:15:01.9'", true),
        ("EXPTIME = 2.0\nNDIT    = 5\nDATE-END= '2026-08-22T03:15:03.1'", true),
        ("EXPTIME = 1.0\nNCOMBINE= 10\nDATE-END= '2026-08-22T03:15:01.9'", false),
        ("EXPTIME = 1.0\nCOADDS  = 2\nDATE-END= '2026-08-22T03:15:01.9'", false),
    ] {
        assert_eq!(time(&format!("DATE-OBS= '2026-08-22T03:15:00.0'\n{cards}\n")).is_ok(), is_read, "{cards}");
    }
    // The end of a stack must be precise to confirm its length.
    for end in ["EXPTIME = 600.0\nMJD-END = 61274", "EXPTIME = 1.0\nDATE-END= '2026-08-22T03:15:02.0'"] {
        assert!(time(&format!("DATE-OBS= '2026-08-22T03:15:00.0'\nNCOMBINE= 5\n{end}\n")).is_err(), "{end}");
    }
}

/// Differences of seconds to minutes from the end and the middle are stated.
#[test]
fn verif_gaps_in_an_exposure_are_stated() {
    let remarks = |length_s: f64, card: &str| {
        let found = time(&format!("DATE-OBS= '2026-08-22T03:15:00'\nEXPTIME = {length_s:?}\n{card}")).expect(card);
        assert_eq!(found.duration_s, length_s, "{card}");
        found.remarks
    };
    for (length_s, card, words) in [
        (3600.0, "DATE-END= '2026-08-22T04:20:30'", "it is 3930.0 s from DATE-OBS to DATE-END: EXPTIME is used"),
        (300.0, "DATE-END= '2026-08-22T03:19:35'", "275.0 s from DATE-OBS to DATE-END"),
        // As in headers of MegaCam, with the readout.
        (300.0, "MJDEND  = 61274.1394444", "348.0 s from DATE-OBS to MJDEND"),
        (3600.0, "TELAPSE = 3930.0", "TELAPSE is 3930 s (from start to end)"),
        (3600.0, "TELAPSE = 3400.0", "TELAPSE is 3400 s"),
        (3600.0, "LIVETIME= 3700.0", "LIVETIME is 3700 s (in all parts)"),
        (3600.0, "DATE-AVG= '2026-08-22T03:50:00'", "DATE-AVG - half of the exposure gives one 300.0 s later"),
        (60.0, "TIME-END= '03:16:59'", "119.0 s from DATE-OBS to TIME-END"),
        (30.0, "NFRAMES = 40", "NFRAMES is 40: EXPTIME is used"),
        (30.0, "NEXP    = 40 / Number of exposures", "NEXP is 40"),
        (30.0, "TIMESYS = 'UTC approximate'", "TIMESYS is \"UTC approximate\": times are read as UTC"),
    ] {
        let found = remarks(length_s, card);
        assert!(found.len() == 1 && found[0].contains(words), "{found:?}");
    }
    for (length_s, card) in [
        (60.0, "DATE-END= '2026-08-22T03:16:04'"),
        (600.0, "TELAPSE = 604.0"),
        (60.0, "NFRAMES = 5 / frames of the sequence"),
        (60.0, "MJD-END = 61274.1"),
        (60.0, "DST     = 'NO'"),
        (60.0, "DSTATUS = 'OK'"),
    ] {
        assert_eq!(remarks(length_s, card), [""; 0], "{card}");
    }
    // Differences in short exposures, also where the middle or the end is the same reading of the clock as the start.
    for (start, cards, words) in [
        (
            "03:15:00",
            "DATE-AVG= '2026-08-22T03:15:00'\nEXPTIME = 2.0",
            "DATE-AVG - half of the exposure gives one 1.0 s earlier",
        ),
        ("03:15:00.5", "MJD-END = 61274.13542245\nEXPTIME = 0.8", "0.0 s from DATE-OBS to MJD-END"),
        ("03:15:00.0", "DATE-END= '2026-08-22T03:15:03.0'\nEXPTIME = 2.0", "it is 3.0 s from DATE-OBS to DATE-END"),
        ("03:15:00.0", "TELAPSE = 3.0\nEXPTIME = 2.0", "TELAPSE is 3 s (from start to end)"),
        ("03:15:00.0", "LIVETIME= 2.9\nEXPTIME = 2.0", "LIVETIME is 2.9 s (in all parts)"),
        (
            "03:15:00.0+00:00",
            "DATE-BEG= '2026-08-22T03:15:00.8+00:00'\nEXPTIME = 2.0",
            "DATE-OBS gives one 0.8 s earlier",
        ),
        ("03:15:00.0 UTC", "DATE-BEG= '2026-08-22T031500.4'\nEXPTIME = 2.0", "DATE-OBS gives one 0.4 s earlier"),
        ("03:15:00.0", "TIMEOFFS= 0.8\nEXPTIME = 2.0", "the header has the card \"TIMEOFFS= 0.8"),
        ("03:15:00.0", "DATE-AVG= '2026-08-22T03:15:00.3'\nEXPTIME = 2.0", "gives one 0.7 s earlier"),
        ("03:15:00.0", "EXPTIME = 2.0 / +/- 0.8 s", "approximately"),
        ("03:15:00.0", "DATE-BEG= '2026-08-22T03:15:00.4'\nEXPTIME = 2.0", "DATE-OBS gives one 0.4 s earlier"),
        ("03:15:00.0", "MJD-OBS = 61274.13542130\nEXPTIME = 2.0", "MJD-OBS gives one 0.4 s later"),
    ] {
        let found = time(&format!("DATE-OBS= '2026-08-22T{start}'\n{cards}")).expect(cards);
        assert!(found.remarks.len() == 1 && found.remarks[0].contains(words), "{cards}: {:?}", found.remarks);
    }
    for (start, cards) in [
        ("03:15:00.0", "DATE-END= '2026-08-22T03:15:02.1'\nTELAPSE = 2.1\nEXPTIME = 2.0"),
        ("03:15:00", "DATE-AVG= '2026-08-22T03:15:01'\nEXPTIME = 2.0"),
        ("03:15:00", "DATE-END= '2026-08-22T03:15:00'\nEXPTIME = 0.8"),
        ("03:15:00.50", "DATE-END= '2026-08-22T03:15:00.55'\nEXPTIME = 0.05"),
        ("03:15:00", "MJD-OBS = 61274.13542130\nEXPTIME = 2.0"),
        ("031500", "MJD-OBS = 61274.13542130\nEXPTIME = 2.0"),
        ("03h15m00s", "MJD-OBS = 61274.13542130\nEXPTIME = 2.0"),
    ] {
        let found = time(&format!("DATE-OBS= '2026-08-22T{start}'\n{cards}")).expect(cards);
        assert_eq!(found.remarks, [""; 0], "{cards}");
    }
    let error = time("DATE-OBS= '2026-08-22T03:15:00'\nEXPTIME = 60\nDATE-END= '2026-08-22T03:14:00'").unwrap_err();
    assert!(error.contains("an end after the start") && !error.contains("--exposure -60"), "{error}");
}

/// Times of devices and observatories whose comments or other cards state what they are.
#[test]
fn valid_times_of_devices() {
    let seestar = |creator: &str| {
        format!("CREATOR = '{creator}'\nEXPTIME = 10.\nDATE-OBS= '2025-06-05T00:39:21.574249' / Image created time\n")
    };
    let found = time(&seestar("ZWO Seestar S50")).unwrap();
    assert_eq!(found.start_from, "DATE-OBS - the exposure");
    assert!(
        found.remarks.iter().any(|remark| remark.contains("read as the end of the exposure")),
        "{:?}",
        found.remarks
    );
    let error = time(&seestar("ZWO ASIAIR Plus")).unwrap_err();
    assert!(error.contains("Autorun_Log") && error.contains("--start"), "{error}");
    assert!(!time(&seestar("Other")).unwrap_err().contains("Autorun_Log"));
    // Keck's LRIS: the time of writing in UTC, and the start in DATE_BEG of newer frames.
    let lris = "DATE    = '2026-08-22T03:20:12.5'\nDATE-OBS= '2026-08-22'\nUTC     = '03:20:12.5'\nELAPTIME= 300\n";
    let found = time(lris).unwrap();
    let words = "the file was written 0.0 s after it, before the end of the exposure";
    assert!(found.remarks.iter().any(|remark| remark.contains(words)), "{:?}", found.remarks);
    begins(&format!("{lris}DATE_BEG= '2026-08-22T03:14:59.1'"), "2026-08-22T03:14:59.1", "DATE_BEG");
    for stated in ["DATE-OBS= '2026-08-22T03:20:12.5' / start of exposure", "DATE-OBS= '2026-08-22T03:15:00.0'"] {
        let found = time(&format!("DATE    = '2026-08-22T03:20:12.5'\n{stated}\nEXPTIME = 300")).unwrap();
        assert_eq!(found.remarks, [""; 0], "{stated}");
    }
    // Another order of UTDATE, and a zone beside TAI.
    begins(
        "DATE-OBS= '1995-07-08'\nUTDATE  = '07/08/95'\nUT      = '06:00:00'\nEXPTIME = 60",
        "1995-07-08T06:00:00",
        "DATE-OBS + UT",
    );
    begins(
        "DATE-OBS= '2026-08-22T03:00:00Z'\nTIMESYS = 'TAI'\nMJD-OBS = 61274.125000\nEXPTIME = 60",
        "2026-08-22T02:59:23",
        "MJD-OBS",
    );
    // The AAT, and the Mosaic camera of Kitt Peak, whose clocks differ by seconds.
    begins("UTDATE  = '2014:01:19'\nUTSTART = '11:45:20'\nEXPOSED = 60.0", "2014-01-19T11:45:20", "UTDATE + UTSTART");
    let mosaic = "DATE-OBS= '2014-09-22T01:35:48.0'\nMJDSTART= 56922.066558066\nEXPTIME = 60\n";
    assert!(time(mosaic).unwrap_err().contains("2.6 s apart"));
    let found = time(&format!("{mosaic}TIMESYS = 'UTC approximate'")).unwrap();
    assert!(found.remarks.iter().any(|remark| remark.contains("2.6 s later")), "{:?}", found.remarks);
    // DWARF: EXP with a unit.
    let dwarf = "DATE-OBS= '2023-06-10T21:38:19.442' / Time start to exposure\nEXP     = 15.";
    assert_eq!(time(&format!("{dwarf} / [s] Sub Exposure Time")).unwrap().duration_s, 15.0);
    assert!(time(dwarf).is_err());
    let per_frame = time("DATE-OBS= '2023-06-10T21:38:19'\nEXPTIME = 2.0 / (s/frame)").unwrap();
    assert!(per_frame.remarks.iter().any(|remark| remark.contains("if it is a stack")), "{:?}", per_frame.remarks);
}
