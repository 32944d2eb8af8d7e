//! Lengths of exposures: units, gaps and stacks.

use streakcast::images::{ExposureTime, Header};

use super::time;

#[test]
fn verif_lengths_in_other_units() {
    let at = "DATE-OBS= '2020-03-06T00:00:00'\n";
    let seconds = |card: &str| time(&format!("{at}{card}")).expect(card).duration_s;
    assert_eq!(seconds("EXPOSURE=                 65.0 /Observation: Exposure Minutes"), 3900.0);
    assert_eq!(seconds("ITIME   =                250.0 / [ms] integration"), 0.25);
    assert_eq!(seconds("EXPTIME = '53.907456'          / Exposure time (seconds)"), 53.907_456);
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

/// Times of the shutter are compared with the exposure time; that of the request is used alone.
#[test]
fn valid_times_of_shutters_and_requests() {
    let at = "DATE-OBS= '2026-08-22T03:15:00'\n";
    for (cards, seconds, remarks) in [
        // LATISS
        ("EXPTIME = 1.0\nSHUTTIME= 1.241", 1.0, 1),
        ("EXPTIME = 5.0\nSHUTTIME= 0.0", 5.0, 0),
        ("SHUTTIME= 5.0", 5.0, 0),
        // CPAPIR
        ("TEXP    = 20.0 / Exposure time asked for", 20.0, 0),
        ("TEXP    = 20.0\nEXPTIME = 20.0", 20.0, 0),
        // GMOS and WIRCam
        ("EXPTIME = 30.4990820884705\nEXPOSURE= 30.0 / Requested exposure time in seconds", 30.4990820884705, 1),
        ("EXPOSURE= 30.0 / Requested exposure time in seconds", 30.0, 0),
        ("EXPTIME = 1.0\nINT-TIME= 6.0 / EXPTIME + reset time", 1.0, 1),
        // The end of MegaPrime and WIRCam is after the readout.
        ("EXPTIME = 20.194\nUTC-OBS = '03:15:00.2'\nDATE-END= '2026-08-22T03:16:07.9'", 20.194, 1),
    ] {
        let found = time(&format!("{at}{cards}")).unwrap_or_else(|error| panic!("{cards}: {error}"));
        assert_eq!((found.duration_s, found.remarks.len()), (seconds, remarks), "{cards}: {:?}", found.remarks);
    }
    assert!(time(&format!("{at}EXPTIME = 20.194\nDATE-END= '2026-08-22T03:16:07.9'")).is_err());
}
