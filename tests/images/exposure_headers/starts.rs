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
        ("DATE-STR= '2026-08-22T03:14:44.6'", "2026-08-22T03:14:44.6", "DATE-STR"),
        ("UTSTART = '03:14:45.050'", "2026-08-22T03:14:45", "DATE-OBS"),
        ("UTSTART = '03:14:46'", "2026-08-22T03:14:45", "DATE-OBS"),
        ("UT      = '03:14:45.900'", "2026-08-22T03:14:45", "DATE-OBS"),
    ] {
        begins(&format!("{at}{card}\n{LENGTH}"), utc, from);
    }
    let found = time(&format!("{at}MJD-OBS = 61274.13525347\n{LENGTH}")).expect("a start");
    assert_eq!(found.start_from, "MJD-OBS");
    // The name of the keyword states the start.
    begins(
        &format!("DATE-BEG= '2026-08-22T03:14:45'\nUTSTART = '03:14:45.900'\n{LENGTH}"),
        "2026-08-22T03:14:45",
        "DATE-BEG",
    );
}

/// Days that differ from clocks which agree with the end are stated, as in headers of Gemini; two clocks against one are
/// an error.
#[test]
fn valid_days_are_outvoted_by_clocks() {
    let clocks = "DATE-OBS= '2026-08-22'\nTIME-OBS= '03:15:00.1'\nUTSTART = '03:15:00.2'\n";
    let end = "UTEND   = '03:16:00.5'\n";
    let found = time(&format!("{clocks}{end}MJD-OBS = 61274.135755\n{LENGTH}")).expect("a start");
    assert_eq!(found.start_from, "DATE-OBS + TIME-OBS");
    assert!(
        found.remarks.iter().any(|remark| remark.contains("MJD-OBS gives one 29.1 s later")),
        "{:?}",
        found.remarks
    );
    for cards in [
        format!("{clocks}MJD-OBS = 61274.135755"),
        format!("{clocks}UTEND   = '03:18:00'\nMJD-OBS = 61274.135755"),
        format!("{clocks}{end}MJD-OBS = 61274.145755"),
        format!("{clocks}{end}UT-STR  = '03:15:29'"),
    ] {
        assert!(time(&format!("{cards}\n{LENGTH}")).is_err(), "{cards}");
    }
    // A number in single precision is a day with few decimals.
    let coarse = time(&format!("{clocks}MJD-OBS = 61274.1015625\n{LENGTH}")).expect("a start");
    assert_eq!(coarse.start_from, "DATE-OBS + TIME-OBS");
    assert!(time(&format!("{clocks}MJD-OBS = 61274.1015626\n{LENGTH}")).is_err());
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
