//! Zero points, gains and amplifiers.

use streakcast::images::{Calibration, CountBasis, Header, PixelUnit};

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
        ("PHOTZP  = 24.0 / -2.5*log(data)+2.5*log(EXPTIME)+PHOTZP", 24.0, Some(CountBasis::Second), "PHOTZP"),
        ("MAGZPT  = 24.0 / 2.5 log10(t) - 2.5 log10(counts) + MAGZPT", 24.0, Some(CountBasis::Second), "MAGZPT"),
        ("MAGZP   = 24.0 / -2.5*log(data)-2.5*log(EXPTIME)+MAGZP", 24.0, None, "MAGZP"),
        ("ZP      = 24.0 / -2.5*log(data)/EXPTIME+ZP", 24.0, None, "ZP"),
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
    ] {
        let calibration = of(cards);
        assert_eq!((calibration.gain_e_adu.expect(cards).value, calibration.doubtful_gain), (gain, None), "{cards}");
    }
}

/// Gains whose unit or camera leaves open what they are, and those that are inverse.
#[test]
fn verif_gains_of_cameras_and_inverse_gains() {
    let gain = |cards: &str| Calibration::from_headers(&[&Header::from_text(cards)]);
    for (cards, e_adu) in [
        ("GAIN    = 0.5 / Conversion from ADUs to electrons", 0.5),
        ("GAIN    = 1.5 / [e-] gain", 1.5),
        ("GAIN    = 70.0 / [e-/ADU]", 70.0),
        ("EGAIN   = 3.6\nEGAINSAV= 0.9\nSWCREATE= 'SharpCap v4.1'", 0.9),
        ("EGAIN   = 3.6\nSWCREATE= 'MaxIm DL'", 3.6),
        ("HIERARCH ESO DET OUT1 CONAD = 1.85 / Conversion from ADUs to electrons", 1.85),
        ("GAIN    = 1.5\nINSTRUME= 'SVOM VT'", 1.5),
    ] {
        let found = gain(cards);
        let value = found.gain_e_adu.unwrap_or_else(|| panic!("{cards}: {:?}", found.doubtful_gain)).value;
        assert!((value - e_adu).abs() < 1e-9, "{cards}: {value}");
    }
    for cards in [
        "GAIN    = 100000 / [electrons]",
        "GAIN    = 1.36 / Conversion from electrons to ADU",
        "GAIN    = 1\nINSTRUME= 'Moravian Instruments C3-61000'",
        "GAIN    = 5\nINSTRUME= 'SV605CC'",
        "GAIN    = 10\nINSTRUME= 'Vespera Pro'",
        "GAIN    = 10\nCREATOR = 'ZWO Seestar S50'",
        "GAIN    = 12\nINSTRUME= 'FLIR Blackfly S'",
        "EGAIN   = 3.6\nGAIN    = 100\nSWCREATE= 'SharpCap v4.1.10745.0, 64 bit'",
    ] {
        let found = gain(cards);
        assert!(found.gain_e_adu.is_none() && found.doubtful_gain.is_some(), "{cards}");
    }
}

/// Flux densities have the zero points of the AB system; surface brightnesses have none.
#[test]
fn verif_zero_points_of_flux_densities() {
    let zero_point =
        |unit: &str| Calibration::from_headers(&[&Header::from_text(&format!("BUNIT   = '{unit}'"))]).zero_point;
    for (unit, mag) in [("nJy", 31.4), ("uJy", 23.9), ("mJy", 16.4), ("Jy", 8.9)] {
        assert_eq!(zero_point(unit).map(|found| (found.mag, found.basis)), Some((mag, Some(CountBasis::Frame))));
    }
    for unit in ["MJy/sr", "MJy", "adu", "nJy/s"] {
        assert_eq!(zero_point(unit), None, "{unit}");
    }
}
