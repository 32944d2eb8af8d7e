//! Catalogues: all formats give the same satellite, from short and long texts, and from one or several files.

use crate::common::elements::{gzip, read, reasons, sample};
use hifitime::Epoch;
use proptest::prelude::*;
use streakcast::elements::{ElementFormat, ElementSet, NoradId, ReadOptions, Satellites, format_tle};
use streakcast::orbit::Propagator;

const LINE1: &str = "1 90001U 26001A   26079.52426840 -.00001234  12345-7  10370-3 0  9991";
const LINE2: &str = "2 90001  53.0541 193.4497 0006669 272.1743  87.8481 15.06394766123458";

#[test]
fn verif_every_syntax_gives_the_same_satellite_bit_for_bit() {
    let expected = read(&sample("sample.3le")).unwrap().element_sets.remove(0);
    assert_eq!(&*expected.name, "SAMPLE & SON");
    assert_eq!(&*expected.international_designator, "2026-001A");
    assert_eq!(expected.epoch, Epoch::from_gregorian_utc(2026, 3, 20, 12, 34, 56, 789_760_000));
    assert_eq!(expected.mean_motion_ddot_rev_day3, 0.12345e-7);
    let states = ephemeris(&expected);
    for (name, format) in [
        ("sample.json", ElementFormat::OmmJson),
        ("sample_strings.json", ElementFormat::OmmJson),
        ("sample.csv", ElementFormat::OmmCsv),
        ("sample.xml", ElementFormat::OmmXml),
        ("sample.kvn", ElementFormat::OmmKvn),
    ] {
        for bytes in [sample(name), gzip(&sample(name))] {
            let catalogue = read(&bytes).unwrap();
            assert_eq!(catalogue.sources[0].format, format, "{name}");
            assert_eq!(reasons(&catalogue), [], "{name}");
            assert_eq!(catalogue.element_sets, std::slice::from_ref(&expected), "{name}");
            assert_eq!(ephemeris(&catalogue.element_sets[0]), states, "{name}");
        }
    }
}

/// Returns positions and velocities over ten days, km and km/s.
fn ephemeris(set: &ElementSet) -> Vec<([f64; 3], [f64; 3])> {
    let propagator = Propagator::new(set).expect("a good orbit");
    (-10..=10).map(|day| propagator.teme_state_at_minutes(f64::from(day) * 720.0).expect("in orbit")).collect()
}

#[test]
fn verif_line_ends_and_blank_lines_do_not_matter() {
    let plain = read(&sample("sample.3le")).unwrap().element_sets;
    let text = format!("SAMPLE & SON\n{LINE1}\n{LINE2}\n");
    let utf16: Vec<u8> = [0xff, 0xfe].into_iter().chain(text.encode_utf16().flat_map(u16::to_le_bytes)).collect();
    let cases: [(&str, Vec<u8>); 10] = [
        ("byte order mark", format!("\u{feff}{text}").into_bytes()),
        ("CRLF", text.replace('\n', "\r\n").into_bytes()),
        ("CR only", text.replace('\n', "\r").into_bytes()),
        ("trailing blanks", text.replace('\n', "   \t\n").into_bytes()),
        ("blank lines", text.replace('\n', "\n\n \n").into_bytes()),
        ("no last line end", text.trim_end().as_bytes().to_vec()),
        ("indented", text.replace("1 9", "  1 9").replace("2 9", "  2 9").into_bytes()),
        ("comments", format!("# elements\n{text}# end\n").into_bytes()),
        ("UTF-16", utf16),
        ("gzip in two members", [gzip(&text.as_bytes()[..100]), gzip(&text.as_bytes()[100..])].concat()),
    ];
    for (what, bytes) in cases {
        let catalogue = read(&bytes).unwrap_or_else(|error| panic!("{what}: {error}"));
        assert_eq!(catalogue.element_sets, plain, "{what}");
        assert_eq!(reasons(&catalogue), [], "{what}");
    }
}

/// Long texts are parsed in parallel chunks; the result equals that of one chunk.
#[test]
fn verif_long_files_are_read_like_short_ones() {
    const COUNT: usize = 6000;
    let text = |name: &str| String::from_utf8(sample(name)).unwrap();
    let number = |text: &str, index: usize| text.replace("90001", &format!("{}", 10_000 + index));
    let tle = |index: usize| {
        let lines = number(&text("sample.3le"), index);
        // Lines without checksums, and some invalid records.
        let lines: String = lines.lines().map(|line| format!("{}\n", &line[..line.len().min(68)])).collect();
        match index % 100 {
            0 => lines.replace("53.0541", "53.O541"),
            50 => lines.lines().take(2).map(|line| format!("{line}\n")).collect(),
            _ => lines,
        }
    };
    let csv = text("sample.csv");
    let (titles, row) = csv.trim_end().split_once('\n').unwrap();
    let xml = text("sample.xml");
    let message = &xml[xml.find("<omm").unwrap()..xml.find("</ndm>").unwrap()];
    let damage =
        |text: String, index: usize| if index.is_multiple_of(100) { text.replace("15.06394766", "-1") } else { text };
    let all = |make: &dyn Fn(usize) -> String| (0..COUNT).map(make).collect::<String>();
    let files = [
        (all(&tle), 2),
        (format!("{titles}\n{}", all(&|index| damage(number(row, index), index) + "\n")), 1),
        (format!("<ndm>\n{}</ndm>", all(&|index| damage(number(message, index), index))), 1),
        (all(&|index| damage(number(&text("sample.kvn"), index), index)), 1),
    ];
    for (text, bad_in_a_hundred) in files {
        assert!(text.len() > 700_000);
        let catalogue = read(text.as_bytes()).unwrap();
        let bad = COUNT / 100 * bad_in_a_hundred;
        let format = catalogue.sources[0].format;
        assert_eq!((catalogue.rejected.len(), catalogue.element_sets.len()), (bad, COUNT - bad), "{format}");
        assert!(catalogue.element_sets.windows(2).all(|pair| pair[0].norad_id < pair[1].norad_id), "{format}");
        // Every reported line number is that of an invalid record.
        let lines: Vec<_> = text.lines().collect();
        let mut last = 0;
        for rejected in &catalogue.rejected {
            assert!(rejected.line > last, "{rejected}");
            last = rejected.line;
            let here = lines[rejected.line - 1];
            match format {
                ElementFormat::Tle => assert!(here.contains("53.O541") || here.starts_with("1 "), "{rejected}: {here}"),
                ElementFormat::OmmCsv => assert!(here.contains(",-1,"), "{rejected}: {here}"),
                ElementFormat::OmmXml => assert!(here.starts_with("<omm"), "{rejected}: {here}"),
                _ => assert!(here.starts_with("CCSDS_OMM_VERS"), "{rejected}: {here}"),
            }
        }
    }
}

#[test]
fn verif_mixed_files_in_one_run() {
    let folder = tempfile::tempdir().unwrap();
    let paths: Vec<_> = [
        ("a.2le", sample("sample.2le")),
        ("b.json.gz", gzip(&sample("sample.json"))),
        ("c.xml", String::from_utf8(sample("sample.xml")).unwrap().replace("90001", "900010").into_bytes()),
    ]
    .into_iter()
    .map(|(name, bytes)| {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        path
    })
    .collect();
    let catalogue = Satellites::read(&paths, &ReadOptions::default()).unwrap();
    let ids: Vec<_> = catalogue.element_sets.iter().map(|set| set.norad_id.0).collect();
    assert_eq!((ids, catalogue.duplicates), (vec![90001, 900_010], 1));
    // The two-line file contains no name; the name of the duplicate record is used.
    assert_eq!(&*catalogue.element_sets[0].name, "SAMPLE & SON");
    let formats: Vec<_> = catalogue.sources.iter().map(|source| (source.format.to_string(), source.gzipped)).collect();
    assert_eq!(formats, [("TLE".into(), false), ("OMM JSON".into(), true), ("OMM XML".into(), false)]);
    // `sha256sum tests/data/elements/sample.2le`
    assert_eq!(catalogue.sources[0].sha256, "8062e4964ca2f6279c7675b74f95723426d4a8f12f54ddb0816363567b9e9e57");
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    /// A TLE that was written is read with identical digits.
    #[test]
    fn verif_tle_round_trip(
        id in 1_u32..340_000,
        (year, day) in (1957_i32..2057, 0_i64..365),
        fraction in 0_i64..100_000_000,
        angles in proptest::array::uniform4(0_u32..3_600_000),
        inclination in 0_u32..=1_800_000,
        eccentricity in 0_u32..10_000_000,
        motion in 1_u64..1_700_000_000,
        (bstar, negative) in (10_000_i32..100_000, any::<bool>()),
        exponent in 0_i32..10,
        dot in -99_999_999_i64..100_000_000,
        revolution in 0_u32..100_000,
    ) {
        // The mantissa requires all five digits.
        let bstar = f64::from(if negative { -bstar } else { bstar }) / 1e5;
        let mut set = read(&sample("sample.2le")).unwrap().element_sets.remove(0);
        set.norad_id = NoradId(id);
        set.epoch = Epoch::from_gregorian_utc_at_midnight(year, 1, 1)
            + hifitime::Duration::from_total_nanoseconds(i128::from(day) * 86_400_000_000_000 + i128::from(fraction) * 864_000);
        set.inclination_deg = f64::from(inclination) / 1e4;
        set.right_ascension_of_node_deg = f64::from(angles[0]) / 1e4;
        set.argument_of_perigee_deg = f64::from(angles[1]) / 1e4;
        set.mean_anomaly_deg = f64::from(angles[2]) / 1e4;
        set.eccentricity = f64::from(eccentricity) / 1e7;
        set.mean_motion_rev_day = motion as f64 / 1e8;
        set.bstar_per_earth_radius = format!("{bstar}e-{exponent}").parse().unwrap();
        set.mean_motion_dot_rev_day2 = dot as f64 / 1e8;
        set.mean_motion_ddot_rev_day3 = 0.0;
        set.revolution_at_epoch = revolution;
        let [line1, line2] = format_tle(&set).unwrap();
        prop_assert_eq!((line1.len(), line2.len()), (69, 69));
        let mut back = read(format!("{line1}\n{line2}").as_bytes()).unwrap().element_sets.remove(0);
        // Minus zero becomes zero.
        back.bstar_per_earth_radius += 0.0;
        prop_assert_eq!(back, set);
    }
}
