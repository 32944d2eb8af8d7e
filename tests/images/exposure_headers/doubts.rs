//! Other readings of a header, which are stated.

use super::{begins, time};

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
        "OPENSHUT= '2026-08-22T03:15:01.0' / Time when shutter opened (UTC)",
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
        for card in ["OBS-DATE= '2026-08-22T03:15:00'", "DATETIME= '2026-08-22 03:15:00.5'"] {
            let found = time(&format!("{card}{stated}\nEXPTIME = 60.0")).unwrap();
            assert_eq!(found.remarks.len(), remarks, "{card}{stated}: {:?}", found.remarks);
        }
        let found = time(&format!("DATE-OBS= '2026-08-22'\nTIME    = '03:15:00'{stated}\nEXPTIME = 60.0")).unwrap();
        assert_eq!(
            (found.start_from.as_str(), found.remarks.len()),
            ("DATE-OBS + TIME", remarks),
            "{:?}",
            found.remarks
        );
    }
    // A local time in TIME is not compared with a full date, and 30 s are no time of day.
    let found = time("DATE-OBS= '2026-08-22T03:15:00'\nTIME    = '20:15:00'\nEXPTIME = 60.0").unwrap();
    assert_eq!(found.remarks, [""; 0]);
    assert!(time("DATE-OBS= '2026-08-22'\nTIME    = '00:01:00' / exposure time\nEXPTIME = 60.0").is_err());
    assert!(time("DATE-OBS= '2026-08-22'\nTIME    = 30.0\nEXPTIME = 60.0").is_err());
    for card in ["DATETIME= '2026:08:21 20:15:00'", "DATE-TIM= '2026-08-21 20:15:00'"] {
        assert!(time(&format!("{card}\nEXPTIME = 60.0")).is_err(), "{card}");
    }
    let error = time("DATE-OBS= '2026-08-22T03:15:00' / start (+/- 30 s)\nEXPTIME = 60.0").unwrap_err();
    assert!(error.contains("uncertain by 30 s") && error.contains("--start"), "{error}");
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

/// Cards beside a start and a length that may mean another one, with words of their sentence; empty without one.
#[test]
fn verif_relative_times_unix_times_and_sidereal_times_are_compared() {
    let at = "DATE-OBS= '2026-08-22T03:15:00'\nEXPTIME =                 30.0\n";
    let met = "MJDREFI =                61274\nTIMESYS = 'UTC'\n";
    let mauna_kea = "OBSGEO-B= 19.8\nOBSGEO-L= -155.5\nOBSGEO-H= 4200.0\n";
    for (cards, words) in [
        ("TSTART  = 1000.0\nTSTOP   = 1030.0".to_owned(), ""),
        // Days and minutes
        ("TSTART  = 0.5\nTSTOP   = 1.0".to_owned(), ""),
        ("TSTART  = 0.0\nTSTOP   = 1800.0".to_owned(), "it is 1800 s from TSTART to TSTOP, if they are in seconds"),
        (format!("{met}TSTART  = 11700.0\nTSTOP   = 11730.0"), ""),
        (format!("{met}TSTART  = 11700.0\nTSTOP   = 11730.0\nTIMEZERO= 60.0"), "TSTART is 60.0 s later"),
        (format!("{met}TSTART  = 11760.0\nTSTOP   = 11790.0\nUTCFINIT= -60.0"), ""),
        ("EXPSTART= 1787368500.0\nEXPEND  = 1787368530.0".to_owned(), ""),
        ("EXPEND  = 1787370300.0".to_owned(), "EXPEND is 1770.0 s later than the end"),
        ("EXPSTART= 1787343300000".to_owned(), "EXPSTART is 25200.0 s earlier than the start"),
        (format!("{mauna_kea}LST     = '14:55:00'"), ""),
        (format!("{mauna_kea}LST     = '14:49:00'"), ""),
        (format!("{mauna_kea}ST      = '00:53:23'"), "ST is 00:53:23, 9.98 h later than the sidereal time"),
        ("LST     = '00:53:23'".to_owned(), ""),
        ("TRUITIME= 1.0".to_owned(), "TRUITIME is 1 s"),
    ] {
        let found = time(&format!("{at}{cards}")).unwrap_or_else(|error| panic!("{cards}: {error}"));
        let is_stated = found.remarks.iter().any(|remark| remark.contains(words));
        assert!(if words.is_empty() { found.remarks.is_empty() } else { is_stated }, "{cards}: {:?}", found.remarks);
    }
    for cards in ["TSTART  = 1000.0 / [s]\nTSTOP   = 2800.0", "TIMEUNIT= 's'\nTSTART  = 1.0\nTSTOP   = 1801.0"] {
        let error = time(&format!("{at}{cards}")).expect_err(cards);
        assert!(error.contains("it is 1800 s from TSTART to TSTOP; allowed"), "{error}");
    }
}

/// Dates of HEASARC are in UTC by their comments, and those of WISE are middles.
#[test]
fn valid_dates_of_missions() {
    let length = "EXPOSURE=                 30.0\n";
    for (cards, utc, from, remarks) in [
        (
            "DATE-OBS= '2026-08-22T03:14:45' / TSTART, expressed in UTC\nTIMESYS = 'TT'",
            "2026-08-22T03:14:45",
            "DATE-OBS",
            1,
        ),
        (
            "DATE-OBS= '2026-08-22T03:14:45Z' / TSTART as UTC calendar date\nTIMESYS = 'TDB'",
            "2026-08-22T03:14:45",
            "DATE-OBS",
            1,
        ),
        (
            "DATE_OBS= '2026-08-22T03:15:00'\nMJD_OBS = 61274.135416667\nTELESCOP= 'WISE'",
            "2026-08-22T03:14:45",
            "DATE_OBS - half of the exposure",
            1,
        ),
        (
            "DATE_OBS= '2026-08-22T03:15:00' / UTC\nMJD_OBS = 61274.135416667 / MJD of obs mid-point",
            "2026-08-22T03:14:45",
            "DATE_OBS - half of the exposure",
            1,
        ),
    ] {
        let text = format!("{cards}\n{length}");
        begins(&text, utc, from);
        assert_eq!(time(&text).expect("a time").remarks.len(), remarks, "{cards}");
    }
    // The end does not give the start in a scale in which the start is not used.
    let error = time(&format!(
        "DATE-OBS= '2026-08-22T03:14:45' / Start Time (UTC)\nDATE-END= '2026-08-22T03:15:15'\nTIMESYS = 'TT'\n{length}"
    ));
    assert!(error.expect_err("two scales").contains("in another time scale than TIMESYS"));
}

/// A time of day in these keywords belongs to a date without a time; other values of them are no times.
#[test]
fn valid_times_of_day_beside_a_date() {
    let date = "DATE-OBS= '2026-08-22'\nEXPTIME =                 30.0\n";
    for (card, utc, from) in [
        ("EXPSTART= '03:15:00'", "2026-08-22T03:15:00", "DATE-OBS + EXPSTART"),
        ("EXP-STRT= '03:15:00'", "2026-08-22T03:15:00", "DATE-OBS + EXP-STRT"),
        ("TU-START= '03:15:00'", "2026-08-22T03:15:00", "DATE-OBS + TU-START"),
        ("TIME_UTC= '03:15:00'", "2026-08-22T03:15:00", "DATE-OBS + TIME_UTC"),
        ("MIDPOINT= '03:15:00'", "2026-08-22T03:14:45", "DATE-OBS + MIDPOINT - half of the exposure"),
        ("UTMIDDLE= '03:15:00'", "2026-08-22T03:14:45", "DATE-OBS + UTMIDDLE - half of the exposure"),
        ("EXPSTART=       61274.13541667\nTIME-OBS= '03:15:00'", "2026-08-22T03:15:00", "DATE-OBS + TIME-OBS"),
        ("UTMIDDLE=                 3.25\nTIME-OBS= '03:15:00'", "2026-08-22T03:15:00", "DATE-OBS + TIME-OBS"),
    ] {
        begins(&format!("{date}{card}"), utc, from);
    }
    begins("FRAME   = '2026-08-22T03:14:45'\nEXPTIME = 30.0", "2026-08-22T03:14:45", "FRAME");
    for card in ["FRAME   =                   27", "FRAME   = 'ICRS'", "EXPSTART=           1787368500.0"] {
        assert!(time(&format!("{date}{card}")).expect_err(card).contains("without a time"), "{card}");
    }
}
