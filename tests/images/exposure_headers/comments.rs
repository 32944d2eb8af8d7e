//! Parts of the exposure, units and zones in comments.

use streakcast::images::{ExposureTime, Header};

use super::{LENGTH, begins, time};

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
