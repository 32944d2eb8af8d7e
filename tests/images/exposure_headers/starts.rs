//! Starts of exposures: keywords, their precedence, and their agreement.

use hifitime::Epoch;
use streakcast::frames::seconds_between;
use streakcast::images::{Calibration, ExposureTime, Header};

use super::{LENGTH, begins, time};

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
        ("DATE-BEG= '2020-03-06T00:04:15.0'\nDATE-OBS= '2020-03-06T00:04:15.9'", "2020-03-06T00:04:15", "DATE-BEG"),
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
        ("trailblazer/cutout_calexp-0941420_23.fits", 1, Err("in another time scale than TIMESYS"), 0.0),
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
        "UTC-OBS = '03:14:59.04'\nMJDEND  =       61274.13542824",
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
        ("UT      = '03:15:01'", 0),
        ("UT      = '03:15:03'", 1),
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
        ("MJD-OBS =                61274\nJD      =     2461274.63541667", "2026-08-22T03:15:00.000288", "JD", 1),
        ("DATE-OBS= '2026-08-22'\nTIME-OBS= '03:15'\nUT      = '03:15:40'", "2026-08-22T03:15:40", "UT", 0),
        ("JD      =         2461274.6354", "2026-08-22T03:14:58.56", "JD", 2),
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

/// A start in whole seconds is that of the same second in another clock with more digits.
#[test]
fn verif_the_finer_of_two_clocks_is_used() {
    let at = "DATE-OBS= '2026-08-22T03:14:45'\n";
    for (card, utc, from) in [
        ("UTSTART = '03:14:45.900'", "2026-08-22T03:14:45.9", "UTSTART"),
        ("TIME-OBS= '03:14:45.900'", "2026-08-22T03:14:45.9", "TIME-OBS"),
        ("DATE-STR= '2026-08-22T03:14:44.6'", "2026-08-22T03:14:44.6", "DATE-STR"),
        ("DATE-HP = '2026-08-22T03:14:45.900'", "2026-08-22T03:14:45.9", "DATE-HP"),
        ("UTSTART = '03:14:45.050'", "2026-08-22T03:14:45", "DATE-OBS"),
        ("UTSTART = '03:14:46'", "2026-08-22T03:14:45", "DATE-OBS"),
        // A clock that may be that of another instant, and a middle and an end, which may include the readout.
        ("DATE-AVG= '2026-08-22T03:15:15.900'", "2026-08-22T03:14:45", "DATE-OBS"),
        ("UT      = '03:14:45.900'", "2026-08-22T03:14:45", "DATE-OBS"),
        ("DATE-END= '2026-08-22T03:15:45.900'", "2026-08-22T03:14:45", "DATE-OBS"),
        ("DATE-BEG= '2026-08-22T03:14:45'\nUTSTART = '03:14:45.900'", "2026-08-22T03:14:45.9", "UTSTART"),
    ] {
        begins(&format!("{at}{card}\n{LENGTH}"), utc, from);
    }
    for (card, from) in [("MJD-OBS = 61274.13525347", "MJD-OBS"), ("JD      = 2461274.63525347", "JD")] {
        let found = time(&format!("{at}{card}\n{LENGTH}")).expect("a start");
        assert_eq!((found.start_from.as_str(), found.remarks.len()), (from, 0), "{:?}", found.remarks);
    }
    // Digits of DATE-OBS are kept.
    begins(
        &format!("DATE-OBS= '2026-08-22T03:14:45.0'\nUTSTART = '03:14:45.900'\n{LENGTH}"),
        "2026-08-22T03:14:45",
        "DATE-OBS",
    );
}

/// Days that differ from clocks which agree with each other are stated, as in headers of Gemini. One clock against one,
/// differences by a time zone and by half of the exposure, and ends that do not fit are errors.
#[test]
fn valid_days_are_outvoted_by_clocks() {
    let clocks = "DATE-OBS= '2026-08-22'\nTIME-OBS= '03:15:00.1'\nUTSTART = '03:15:00.2'\n";
    let end = "UTEND   = '03:16:00.5'\n";
    for (cards, words) in [
        (format!("{clocks}{end}MJD-OBS = 61274.135755"), "MJD-OBS gives one 29.1 s later, not used"),
        (format!("{clocks}MJD-OBS = 61274.135755"), "MJD-OBS gives one 29.1 s later"),
        (format!("{clocks}{end}MJD-OBS = 61274.145755"), "MJD-OBS gives one 893.1 s later"),
        (format!("{clocks}{end}UT      = '03:14:24.0' / UT at observation start"), "UT gives one 36.1 s earlier"),
    ] {
        let found = time(&format!("{cards}\n{LENGTH}")).expect(&cards);
        assert_eq!(found.start_from, "DATE-OBS + TIME-OBS");
        assert!(found.remarks.len() == 1 && found.remarks[0].contains(words), "{:?}", found.remarks);
    }
    for cards in [
        "DATE-OBS= '2026-08-22T03:15:00.1'\nMJD-OBS = 61274.135755".to_owned(),
        "DATE-OBS= '2026-08-22T03:15:00.1'\nDATE-BEG= '2026-08-22T03:15:00.1'\nMJD-OBS = 61274.135755".to_owned(),
        format!("{clocks}{end}MJD-OBS = 61274.427085"),
        format!("{clocks}MJD-OBS = 61274.135763889"),
        format!("{clocks}UT      = '03:15:29.3'\nUTSHUT  = '03:15:29.2'\nMJD-OBS = 61274.135755"),
        format!("{clocks}UTEND   = '03:18:30'\nMJD-OBS = 61274.135755"),
        format!("{clocks}{end}UT-STR  = '03:15:29'"),
        format!("{clocks}{end}MJD-OBS = 61274.635755"),
    ] {
        assert!(time(&format!("{cards}\n{LENGTH}")).is_err(), "{cards}");
    }
    // A number in single precision is too coarse to contradict, but is no start; zeros at its end make it exact.
    let found = time(&format!("{clocks}MJD-OBS = 61274.1015625\n{LENGTH}")).expect("a start");
    assert_eq!((found.start_from.as_str(), found.remarks.len()), ("DATE-OBS + TIME-OBS", 0), "{:?}", found.remarks);
    begins(&format!("MJD-OBS = 61274.1250000\n{LENGTH}"), "2026-08-22T03:00:00", "MJD-OBS");
    let error = time(&format!("MJD-OBS = 61274.13671875\n{LENGTH}")).unwrap_err();
    assert!(error.contains("uncertain by 169 s"), "{error}");
}

/// Clocks of real headers of Gemini and the CFHT: start, and words of the sentences.
#[test]
fn valid_clocks_of_gemini_and_cfht() {
    for (cards, length_s, start, from, words) in [
        // GMOS until 2015: UT is read before, and MJD-OBS differs from the three others.
        (
            "DATE-OBS= '2003-01-07'\nTIME-OBS= '14:31:00.7'\nUTSTART = '14:31:00.7' / UT at observation start\n\
             UT      = '14:30:25.4' / UT at observation start\nUTEND   = '14:32:40.7'\n\
             MJD-OBS = 52646.6052086554 / MJD of start of obseration",
            100.001399993896,
            "2003-01-07T14:31:00.7",
            "DATE-OBS + TIME-OBS",
            &["MJD-OBS gives one 29.3 s later", "UT gives one 35.3 s earlier"][..],
        ),
        // GMOS later: UTSTART and UTEND are those of the exposure.
        (
            "DATE-OBS= '2022-09-15'\nTIME-OBS= '19:03:25.2'\nUTSTART = '19:03:28.9500'\nUT      = '19:03:25.2'\n\
             UTEND   = '19:04:18.9500'\nMJD-OBS = 59837.7948444461",
            50.0,
            "2022-09-15T19:03:28.95",
            "UTSTART",
            &["DATE-OBS + TIME-OBS, UT give one 3.8 s earlier", "MJD-OBS gives one 65.6 s later"],
        ),
        // Flamingos-2: days in single precision, and the end of the exposure before.
        (
            "DATE-OBS= '2015-01-01'\nTIME-OBS= '04:04:26.7'\nUTSTART = '04:04:30.494034'\nUT      = '04:04:26.7'\n\
             UTEND   = '04:04:15.954037'\nMJD-OBS = 57023.19921875\nTIMESYS = 'UTC     '",
            85.0,
            "2015-01-01T04:04:30.494034",
            "UTSTART",
            &["UTEND is 14.5 s before the start of UTSTART", "DATE-OBS + TIME-OBS, UT give one 3.8 s earlier"],
        ),
        // GNIRS: the end includes overheads.
        (
            "DATE-OBS= '2011-03-23'\nTIME-OBS= '03:57:30.7'\nUTSTART = '03:57:30.7'\nUT      = '03:57:30.7'\n\
             UTEND   = '03:57:36.2'\nMJD_OBS = 55643.1641616067",
            1.5,
            "2011-03-23T03:57:30.7",
            "DATE-OBS + TIME-OBS",
            &["MJD_OBS gives one 67.1 s earlier"],
        ),
        // NIFS: one clock with a statement of the start, and days without.
        (
            "DATE-OBS= '2006-07-23' / Observation date (UT)\nUT      = '09:20:57.9' / Beginning of Observation (UT)\n\
             MJD_OBS = 53939.39032 / Mean Julian day of observation",
            60.0,
            "2006-07-23T09:20:57.9",
            "DATE-OBS + UT",
            &["MJD_OBS gives one 65.7 s later"],
        ),
        // NIRI: FRAME is twice in the header.
        (
            "FRAME   = 'FK5     '\nDATE-OBS= '2002-06-20'\nTIME-OBS= '07:12:37.6' / Beginning of Observation (UT)\n\
             UT      = '07:12:37.1' / Beginning of Observation (UT)\nFRAME   = 'AZEL_TOPO'\nUTEND   = '07:12:41.6'\n\
             MJD_OBS = 52445.3012255573 / Mean Julian day of observation",
            1.001,
            "2002-06-20T07:12:37.6",
            "DATE-OBS + TIME-OBS",
            &["MJD_OBS gives one 68.3 s later"],
        ),
        // MegaPrime: the end with the readout; days of the command, and the shutter.
        (
            "TELESCOP= 'CFHT 3.6m'\nDATE-OBS= '2010-11-03'\nUTC-OBS = '04:37:54.31'\nUTIME   = '04:37:54.31'\nMJD-OBS = 55503.1929897\n\
             MJDEND  = 55503.1937756\nUTCEND  = '04:39:02.21'",
            20.194,
            "2010-11-03T04:37:54.31",
            "DATE-OBS + UTC-OBS",
            &["it is 67.9 s from DATE-OBS + UTC-OBS to MJDEND, UTCEND: EXPTIME is used"],
        ),
        (
            "TELESCOP= 'CFHT 3.6m'\nSHUTOPEN= '2018-05-09T18:31:37.516' / Shutter blade opening time (UTC)\n\
             DATE-OBS= '2018-05-09'\nUTC-OBS = '18:31:36.42' / Time at start of observation (UTC)\n\
             TIME-OBS= '18:31:37.516'\nMJD-OBS = 58247.7719493\nTIMEEND = '18:32:37.567'\nMJDEND  = 58247.7719493",
            60.0,
            "2018-05-09T18:31:37.516",
            "SHUTOPEN",
            &["DATE-OBS + UTC-OBS, MJD-OBS give one 1.1 s earlier", "MJDEND is 1.1 s before the start"],
        ),
    ] {
        let text = format!("{cards}\nEXPTIME = {length_s:?}\n");
        begins(&text, start, from);
        let remarks = time(&text).expect("a start").remarks.join("; ");
        assert!(words.iter().all(|words| remarks.contains(words)), "{remarks}");
    }
    // The shutter far from the command, and an early end that nothing explains.
    for cards in [
        "DATE-OBS= '2018-05-09T18:31:36.42'\nSHUTOPEN= '2018-05-09T18:31:57.516'",
        "DATE-OBS= '2018-05-09T18:31:36.42'\nUTEND   = '18:31:20.0'",
        "DATE-OBS= '2018-05-09'\nTIME-OBS= '18:31:36.42'\nUT      = '18:31:36.42'\nUTEND   = '18:32:00.0'",
    ] {
        assert!(time(&format!("{cards}\n{LENGTH}")).is_err(), "{cards}");
    }
}

/// A late end within a minute is stated if it is that of the observation, by its comment, or if a second clock agrees
/// with the start and nothing states several exposures; factors are errors.
#[test]
fn valid_ends_of_observations() {
    let at = "DATE-OBS= '2020-02-02T00:03:34.047'\n";
    let of_observation = "/ Date time (UTC) of end of observation\n";
    let end = |time: &str, comment: &str| format!("{at}DATE-END= '2020-02-02T{time}' {comment}");
    for (cards, length_s, is_read) in [
        (end("00:05:44.550", of_observation), 100.0, true),
        (format!("{}MJD-END = 58881.003988", end("00:05:44.550", of_observation)), 100.0, true),
        (end("00:05:44.550", ""), 100.0, false),
        (end("00:07:00", of_observation), 100.0, false),
        (end("00:04:00", of_observation), 5.0, false),
        (end("00:04:00", "\nTELESCOP= 'CFHT 3.6m'\nUTC-OBS = '00:03:34.047'"), 5.0, true),
        (end("00:04:00", "\nUT      = '00:03:34.0'"), 5.0, true),
        (end("00:04:00", "\nMJD-OBS = 58881.00247739"), 5.0, false),
        (end("00:04:00", "\nUTC-OBS = '00:03:34.047'\nCOADDS  = 5"), 5.0, false),
        (end("00:04:00", "\nUTC-OBS = '00:03:34.047'\nNCOMBINE= 5"), 5.0, false),
        (end("00:05:00", "\nTELESCOP= 'CFHT 3.6m'\nUTC-OBS = '00:03:34.047'"), 5.0, false),
        (end("00:33:34", of_observation), 2.0, false),
    ] {
        let found = time(&format!("{cards}\nEXPTIME = {length_s:?}\n"));
        assert_eq!(
            found.as_ref().map(|found| found.remarks.is_empty()).ok(),
            is_read.then_some(false),
            "{cards}: {found:?}"
        );
    }
}

/// Keywords with different values in the headers of the image and of the file are stated.
#[test]
fn verif_different_values_of_two_headers_are_stated() {
    for (image, primary, words) in [
        ("EXPTIME = 30", "EXPTIME = 60", "EXPTIME is 30 in the header of the image, and 60 in the primary header"),
        ("DATE-OBS= '2026-08-22T03:15:00'", "DATE-OBS= '2026-08-22T03:14:00'", "DATE-OBS is"),
        ("TIMESYS = 'UTC'", "TIMESYS = 'TAI'", "TIMESYS is"),
        ("EXPTIME = 30.0", "EXPTIME = 30", ""),
        ("DATE-OBS= '2026-08-22T03:15:00'", "DATE-OBS= '2026-08-22'", ""),
        ("MJD-OBS = 61274.13541667", "DATE-OBS= '2026-08-22T03:15:00'", ""),
        ("OBJECT  = 'M 31'", "OBJECT  = 'M 32'", ""),
    ] {
        let image = format!("{image}\nDATE-OBS= '2026-08-22T03:15:00'\nEXPTIME = 30\n");
        let [image, primary] = [image.as_str(), primary].map(Header::from_text);
        let found = ExposureTime::from_headers(&[&image, &primary]).expect("a time");
        let is_stated = found.remarks.iter().any(|remark| !words.is_empty() && remark.contains(words));
        assert!(is_stated || (words.is_empty() && found.remarks.is_empty()), "{words}: {:?}", found.remarks);
    }
}

/// The comment of a card is that of the card with its value in the other header.
#[test]
fn comments_in_the_primary_header_count() {
    let read = |image: &str, primary: &str| {
        let [image, primary] = [image, primary].map(Header::from_text);
        ExposureTime::from_headers(&[&image, &primary])
    };
    let found = read(
        "DATE-OBS= '2026-08-22T03:15:15'\nEXPTIME = 30000\n",
        "DATE-OBS= '2026-08-22T03:15:15' / UTC at end of exposure\nEXPTIME = 30000 / [ms]\n",
    );
    let found = found.expect("a time");
    assert_eq!((found.start_from.as_str(), found.duration_s), ("DATE-OBS - the exposure", 30.0));
    // Not that of another value.
    let found = read(
        "DATE-OBS= '2026-08-22T03:15:15'\nEXPTIME = 30\n",
        "DATE-OBS= '2026-08-22T03:15:45' / UTC at end of exposure\nEXPTIME = 30000 / [ms]\n",
    );
    let found = found.expect("a time");
    assert_eq!((found.start_from.as_str(), found.duration_s), ("DATE-OBS", 30.0));
}

/// Times since a reference far from all times are left out, and a scale with a shift is no UTC.
#[test]
fn invalid_references_and_scales() {
    let at = "DATE-OBS= '2026-08-22T03:15:00'\n";
    let far = |cards: &str| format!("{at}{cards}\nMJDREF  = 50000.0\n{LENGTH}");
    begins(&far("TSTART  = 10.0\nTSTOP   = 70.0\nTIMEZERO= 1E308"), "2026-08-22T03:15:00", "DATE-OBS");
    assert!(time(&far("TSTART  = 1E30\nTSTOP   = 2E30")).is_err());
    for scale in ["UTC (+7 h)", "UTC(-7)", "UTC+8"] {
        assert!(time(&format!("{at}TIMESYS = '{scale}'\n{LENGTH}")).is_err(), "{scale}");
    }
    begins(&format!("{at}TIMESYS = 'UTC(NIST)'\n{LENGTH}"), "2026-08-22T03:15:00", "DATE-OBS");
}

/// Starts in keywords of other names are compared with the start, and are used without another one, which is stated.
#[test]
fn verif_starts_in_keywords_of_other_names() {
    let at = "DATE-OBS= '2026-08-22T03:15:00.000'\nUT      = '03:15:00.000'\nEXPTIME = 60.0\n";
    for (card, words) in [
        ("GPS_SUTC= '2026-08-22T03:15:00.400' / Start shutter time", "GPS_SUTC is 0.4 s later than the start"),
        ("GPS_ST  = '2026-08-22T03:15:07.100'", "GPS_ST is 7.1 s later"),
        ("OBSSTART= '2026-08-22T03:15:07.100' / shutter open", "OBSSTART is 7.1 s later"),
        ("STARTMJD=    61274.13548611111", "STARTMJD is 6.0 s later"),
        ("TOPEN   = '2026-08-22T03:14:58.5'", "TOPEN is 1.5 s earlier"),
        ("GPS_SUTC= '2026-08-22T03:15:00.050'", ""),
        ("FRAME_BE= '2026-08-22T03:15:02' / start of exposure", "FRAME_BE is 2.0 s later"),
        ("SEQSTART= '2026-08-22T03:05:00'", ""),
        ("ACQSTART= '2026-08-22T03:05:00' / acquisition start", ""),
        ("HIERARCH ESO OBS START = '2026-08-22T02:55:00' / OB start time", ""),
        ("STARTLOC= '2026-08-21T20:15:00'", ""),
        ("ST      = '00:53:23' / start", ""),
    ] {
        let found = time(&format!("{at}{card}")).expect(card);
        assert_eq!(found.start_from, "DATE-OBS", "{card}");
        let is_stated = found.remarks.len() == 1 && found.remarks[0].contains(words);
        assert!(if words.is_empty() { found.remarks.is_empty() } else { is_stated }, "{card}: {:?}", found.remarks);
    }
    for (cards, utc, from) in [
        ("OBSSTART= '2026-08-22T03:15:07.100' / shutter open", "2026-08-22T03:15:07.1", "OBSSTART"),
        ("STARTMJD=    61274.125000", "2026-08-22T03:00:00", "STARTMJD"),
        ("DATE-OBS= '2026-08-22'\nGPS_SUTC= '2026-08-22T03:15:07.1'", "2026-08-22T03:15:07.1", "GPS_SUTC"),
    ] {
        let text = format!("{cards}\n{LENGTH}");
        begins(&text, utc, from);
        let remarks = time(&text).expect("a start").remarks;
        assert!(remarks.len() == 1 && remarks[0].contains("by its name or comment"), "{remarks:?}");
    }
    for cards in ["SUNSTART= '2026-08-22T03:05:00'", "OBSSTART= '2026-08-21T20:15:00' / local time"] {
        assert!(time(&format!("{cards}\n{LENGTH}")).is_err(), "{cards}");
    }
}

/// Clocks more than a second from the start are stated on both sides, and agreement within the digits is not.
#[test]
fn verif_late_clocks_are_stated() {
    for (start, card, words) in [
        ("03:15:00.0", "UT      = '03:15:03.0'", "UT gives one 3.0 s later"),
        ("03:15:00.0", "UTC     = '03:14:57.0'", "UTC gives one 3.0 s earlier"),
        ("03:15:00.0", "MJD     =    61274.135451388887", "MJD gives one 3.0 s later"),
        ("03:15:00.0", "DATE-AVG= '2026-08-22T03:15:33.0'", "DATE-AVG - half of the exposure gives one 3.0 s later"),
        ("03:15:00.9", "UT      = '03:15:00'", ""),
        ("03:15:00", "UT      = '03:15:01'", ""),
        ("03:15:00.0", "JD      =  2461274.63542", ""),
        // Days equal to DATE are those of the file.
        ("03:15:00.0", "DATE    = '2026-08-22T03:16:09.5'\nMJD     =   61274.13622106", ""),
        ("03:15:00.0", "DATE    = '2026-08-22T03:16:09.5'\nJD      = 2461274.63622106", ""),
    ] {
        let found = time(&format!("DATE-OBS= '2026-08-22T{start}'\n{card}\n{LENGTH}")).expect(card);
        let is_stated = found.remarks.len() == 1 && found.remarks[0].contains(words);
        assert!(if words.is_empty() { found.remarks.is_empty() } else { is_stated }, "{card}: {:?}", found.remarks);
    }
}

/// A date is the start if the end agrees with it, although the comment of days with its value states the middle.
#[test]
fn verif_ends_decide_whether_a_date_is_the_middle() {
    let at =
        "DATE-OBS= '2026-08-22T03:15:00.0'\nMJD-OBS = 61274.135416667 / MJD at middle of exposure\nEXPTIME = 30.0\n";
    let of_middle = "DATE-OBS - half of the exposure";
    for (card, utc, from) in [
        ("DATE-END= '2026-08-22T03:15:30.0'", "2026-08-22T03:15:00", "DATE-OBS"),
        ("UTEND   = '03:15:30.2'", "2026-08-22T03:15:00", "DATE-OBS"),
        ("DATE-END= '2026-08-22T03:15:15.0'", "2026-08-22T03:14:45", of_middle),
        ("", "2026-08-22T03:14:45", of_middle),
    ] {
        let text = format!("{at}{card}\n");
        begins(&text, utc, from);
        assert_eq!(time(&text).expect("a start").remarks.len(), 1, "{card}");
    }
}

/// A date without a time in the header of the image is completed by the same date of the file.
#[test]
fn verif_dates_of_two_headers() {
    let read = |image: &str, primary: &str| {
        let [image, primary] = [image, primary].map(Header::from_text);
        ExposureTime::from_headers(&[&image, &primary])
    };
    let day = "DATE-OBS= '2026-08-22'\nEXPTIME = 30\n";
    for (primary, from) in
        [("DATE-OBS= '2026-08-22T03:15:00.5'", "DATE-OBS"), ("OBS-DATE= '2026-08-22T03:15:00.5' / UTC", "OBS-DATE")]
    {
        let found = read(day, primary).expect("a start");
        let expected: Epoch = "2026-08-22T03:15:00.5 UTC".parse().expect("a moment");
        assert!(seconds_between(expected, found.start).abs() < 1e-6, "{primary}: {}", found.start);
        assert_eq!((found.start_from.as_str(), found.remarks.len()), (from, 0), "{primary}: {:?}", found.remarks);
    }
    assert!(read(day, "DATE-OBS= '2026-08-23T03:15:00.5'").is_err());
}

/// The error of the start by its digits or its comment.
#[test]
fn verif_errors_of_the_start() {
    for (card, sigma_s) in [
        ("DATE-OBS= '2026-08-22T03:15:00'", 12f64.sqrt().recip()),
        ("DATE-OBS= '2026-08-22T03:15:00.000'", 0.001 / 12f64.sqrt()),
        ("DATE-OBS= '2026-08-22T03:15:00.000' / +/- 2 s", 2.0),
        ("MJD-OBS = 61274.13542", 0.5e-5 * 86_400.0 / 3f64.sqrt()),
    ] {
        let found = time(&format!("{card}\n{LENGTH}")).expect(card);
        assert!((found.start_sigma_s - sigma_s).abs() < 1e-4 * sigma_s.max(0.01), "{card}: {}", found.start_sigma_s);
    }
}
