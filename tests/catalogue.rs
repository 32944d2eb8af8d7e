//! The catalogue: every syntax gives the same satellite, bad input is named and counted.

mod common;

use std::io::Write;
use std::path::Path;

use flate2::Compression;
use flate2::write::GzEncoder;
use hifitime::{Epoch, Unit};
use proptest::prelude::*;
use streakcast::catalogue::{
    Catalogue, CatalogueError, ElementFormat, ElementSet, History, Keep, NoradId, ReadOptions, StationRule, format_tle,
    orbit_phases, semi_major_axis_km,
};
use streakcast::orbit::Propagator;

const LINE1: &str = "1 90001U 26001A   26079.52426840 -.00001234  12345-7  10370-3 0  9991";
const LINE2: &str = "2 90001  53.0541 193.4497 0006669 272.1743  87.8481 15.06394766123458";

fn sample(name: &str) -> Vec<u8> {
    let path = common::golden_dir().join("elements").join(name);
    std::fs::read(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

fn read(bytes: &[u8]) -> Result<Catalogue, CatalogueError> {
    Catalogue::from_bytes("test", bytes, &ReadOptions::default())
}

fn read_all(bytes: &[u8]) -> Catalogue {
    let options = ReadOptions { keep: Keep::All, ..Default::default() };
    Catalogue::from_bytes("test", bytes, &options).expect("readable")
}

fn reasons(catalogue: &Catalogue) -> Vec<(usize, String)> {
    catalogue.rejected.iter().map(|rejected| (rejected.line, rejected.reason.to_string())).collect()
}

fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

/// The sample with another day of its epoch, with right checksums.
fn pair(norad_id: u32, day: &str) -> String {
    let mut set = read(sample("sample.2le").as_slice()).unwrap().element_sets.remove(0);
    set.norad_id = NoradId(norad_id);
    let [line1, line2] = format_tle(&set).unwrap();
    let line1 = format!("{}{day}{}", &line1[..20], &line1[32..68]);
    format!("{line1}\n{line2}\n")
}

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

/// Positions and velocities over ten days, km and km/s.
fn ephemeris(set: &ElementSet) -> Vec<([f64; 3], [f64; 3])> {
    let propagator = Propagator::new(set).expect("a good orbit");
    (-10..=10).map(|day| propagator.teme_state_at_minutes(f64::from(day) * 720.0).expect("in orbit")).collect()
}

#[test]
fn verif_dressing_of_a_text_file_does_not_matter() {
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

#[test]
fn verif_a_bad_record_is_named_and_the_rest_goes_on() {
    let bad_checksum = LINE1.replace("9991", "9992");
    let bad_number = LINE2.replace("53.0541", "53.O541");
    let text = format!(
        "GOOD\n{LINE1}\n{LINE2}\n\
         BAD SUM\n{bad_checksum}\n{LINE2}\n\
         BAD NUMBER\n{LINE1}\n{bad_number}\n\
         NO LINE TWO\n{LINE1}\n\
         CUT\n{LINE1}\n{}\n\
         {LINE2}\n\
         a stray line\n\
         ALSO GOOD\n{}\
         the end",
        &LINE2[..63],
        pair(90002, "079.52426840"),
    );
    let catalogue = read(text.as_bytes()).unwrap();
    let ids: Vec<_> = catalogue.element_sets.iter().map(|set| (set.norad_id.0, set.name.to_string())).collect();
    assert_eq!(ids, [(90001, "GOOD".into()), (90002, "ALSO GOOD".into())]);
    let reason = |line, reason: &str| (line, reason.to_string());
    assert_eq!(
        reasons(&catalogue),
        [
            reason(5, "line 1: the checksum is '2', the line adds up to 1"),
            reason(9, "line 2: inclination \"53.O541\" is not a number in columns 9-16"),
            reason(11, "line 1 of an element set is not followed by its line 2"),
            reason(14, "line 2 has 63 characters; 69 are allowed, or 68 where the checksum is missing"),
            reason(15, "line 2 of an element set has no line 1 before it"),
            reason(16, "\"a stray line\" is neither part of an element set nor the name of one"),
            reason(20, "\"the end\" is neither part of an element set nor the name of one"),
        ]
    );
    assert_eq!(catalogue.rejected[0].to_string(), "test:5: line 1: the checksum is '2', the line adds up to 1");
    assert_eq!((catalogue.sources[0].records, catalogue.sources[0].rejected), (2, 7));

    let options = ReadOptions { accept_bad_checksums: true, ..Default::default() };
    let lenient = Catalogue::from_bytes("test", text.as_bytes(), &options).unwrap();
    assert_eq!(lenient.rejected.len(), 6);
    assert_eq!(lenient.sources[0].bad_checksums_accepted, 1);
    assert_eq!(lenient.duplicates, 1);
}

#[test]
fn verif_broken_messages_stay_alone() {
    let json = String::from_utf8(sample("sample.json")).unwrap();
    let good = json.trim().trim_start_matches('[').trim_end_matches(']');
    let text = format!(
        "[{good},\n{},\n{},\n{},\n{{\"NORAD_CAT_ID\": 7, oops}},\n{}",
        good.replace("0.0006669", "1.5"),
        good.replace("\"MEAN_MOTION\": 15.06394766,", ""),
        good.replace("90001", "123456789"),
        good.replace("90001", "90003").trim_end_matches('}'),
    );
    let catalogue = read(text.as_bytes()).unwrap();
    let ids: Vec<_> = catalogue.element_sets.iter().map(|set| set.norad_id.0).collect();
    assert_eq!(ids, [90001, 123_456_789]);
    let words: Vec<_> = reasons(&catalogue).into_iter().map(|(_, reason)| reason).collect();
    assert_eq!(
        words,
        [
            "eccentricity 1.5 is out of range: 0 to below 1",
            "MEAN_MOTION is missing",
            "broken JSON: \"oops\" where a key, a value or a bracket is allowed",
            "broken JSON: the file ends inside this object",
        ]
    );
    assert_eq!(catalogue.rejected[2].line, 1 + text[..text.find("{\"NORAD").unwrap()].matches('\n').count());

    // Lists in objects, an object a line, and records that carry nothing but the two lines.
    let lines = format!("{{\"name\": \"X\", \"line1\": \"{LINE1}\", \"line2\": \"{LINE2}\"}}");
    let wrapped = [
        format!("{{\"name\": \"list\", \"total\": 1, \"data\": [{good}]}}"),
        good.replace('\n', " "),
        lines.clone(),
        format!("{{\"@id\": 1, \"member\": [{lines}]}}"),
    ];
    for text in wrapped {
        let catalogue = read(text.as_bytes()).unwrap_or_else(|error| panic!("{text}: {error}"));
        assert_eq!(catalogue.element_sets[0].norad_id, NoradId(90001), "{text}");
        assert_eq!((catalogue.element_sets.len(), reasons(&catalogue)), (1, vec![]), "{text}");
    }
    let a_line_each = format!("{}\n{}\n", good.replace('\n', " "), good.replace('\n', " ").replace("90001", "90002"));
    assert_eq!(read(a_line_each.as_bytes()).unwrap().element_sets.len(), 2);

    let csv = String::from_utf8(sample("sample.csv")).unwrap();
    let row = csv.lines().nth(1).unwrap();
    let text = format!(
        "{csv}{}\nx,y\n{}\n{}\n{}\n",
        row.replace("SAMPLE & SON", "\"SAMPLE, \"\"B\"\"\"").replace("90001", "90002.0"),
        row.replace("2026-03-20", "2026-13-20"),
        row.replace("90001", "\"90004"),
        row.replace("90001", "A0005"),
    );
    let catalogue = read(text.as_bytes()).unwrap();
    let ids: Vec<_> = catalogue.element_sets.iter().map(|set| (set.norad_id.0, set.name.to_string())).collect();
    assert_eq!(
        ids,
        [(90001, "SAMPLE & SON".into()), (90002, "SAMPLE, \"B\"".into()), (100_005, "SAMPLE & SON".into())]
    );
    assert_eq!(
        reasons(&catalogue),
        [
            (4, "broken CSV: 2 cells under 17 titles".to_string()),
            (
                5,
                "epoch \"2026-13-20T12:34:56.789760\" is not a date: \
                 UTC as YYYY-MM-DDThh:mm:ss.ssssss or YYYY-DDDThh:mm:ss.ssssss"
                    .to_string()
            ),
            (6, "NORAD_CAT_ID \"\\\"90004\" is not a catalogue number (1 to 999999999, or Alpha-5)".to_string()),
        ]
    );

    let xml = String::from_utf8(sample("sample.xml")).unwrap();
    let message = &xml[xml.find("<omm").unwrap()..xml.find("</ndm>").unwrap()];
    let text = format!(
        "<ndm>{message}{}{}{}{}</ndm>",
        message.replace("90001", "90002").replace("</EPOCH>", "</EPOK>"),
        message.replace("90001", "90003").replace(">TEME<", ">EME2000<"),
        message.replace("90001", "90004").replace(">SGP4<", ">SGP4-XP<"),
        message.replace("90001", "90005").replace("SAMPLE &amp; SON", "&#83;AMPLE <![CDATA[& SON]]>"),
    );
    let catalogue = read(text.as_bytes()).unwrap();
    let ids: Vec<_> = catalogue.element_sets.iter().map(|set| (set.norad_id.0, set.name.to_string())).collect();
    assert_eq!(ids, [(90001, "SAMPLE & SON".into()), (90005, "SAMPLE & SON".into())]);
    let words: Vec<_> = reasons(&catalogue).into_iter().map(|(_, reason)| reason).collect();
    assert!(words[0].starts_with("broken XML: "), "{}", words[0]);
    assert_eq!(
        words[1..],
        ["REF_FRAME \"EME2000\" is not supported: TEME", "MEAN_ELEMENT_THEORY \"SGP4-XP\" is not supported: SGP4"]
    );

    let kvn = String::from_utf8(sample("sample.kvn")).unwrap();
    let text = format!(
        "{kvn}\n{}\n{}\n{}",
        kvn.replace("90001", "90002").replace("BSTAR   ", "BSTER   "),
        kvn.replace("90001", "90003").replace("EPOCH              =", "EPOCH"),
        kvn.replace("90001", "90004"),
    );
    let catalogue = read(text.as_bytes()).unwrap();
    let ids: Vec<_> = catalogue.element_sets.iter().map(|set| set.norad_id.0).collect();
    assert_eq!(ids, [90001, 90004]);
    assert_eq!(
        reasons(&catalogue),
        [
            (29, "BSTAR is missing".to_string()),
            (69, "broken KVN: \"EPOCH 2026-03-20T12:34:56.789760\" is not KEYWORD = value".to_string())
        ]
    );
}

#[test]
fn verif_a_whole_file_fails_with_one_clear_error() {
    let allowed = "TLE, 2LE, 3LE or OMM (JSON, CSV, XML, KVN), plain or gzipped";
    let packed = gzip(&sample("sample.3le"));
    let cases: [(&[u8], String); 9] = [
        (b"", format!("test is empty; it should hold element sets as {allowed}")),
        (b" \r\n\n", format!("test is empty; it should hold element sets as {allowed}")),
        (&gzip(b""), format!("test is empty; it should hold element sets as {allowed}")),
        (
            b"No GP data found",
            format!("test holds no element sets (it begins \"No GP data found\"); allowed are {allowed}"),
        ),
        (
            b"<!DOCTYPE html><html>403</html>",
            format!("test holds no element sets (it is a web page or another kind of XML); allowed are {allowed}"),
        ),
        (
            b"PK\x03\x04zip",
            format!("test holds no element sets (it is a zip archive; unpack it); allowed are {allowed}"),
        ),
        (b"[]", "test (OMM JSON) holds no usable element set: it has no records".into()),
        (
            &LINE1.as_bytes()[..65],
            "test (TLE) holds no usable element set: 1 rejected, the first at line 1: \
             line 1 of an element set is not followed by its line 2"
                .into(),
        ),
        (b"[list]\nx = 1\n", format!("test holds no element sets (it begins \"[list]\"); allowed are {allowed}")),
    ];
    for (bytes, expected) in cases {
        assert_eq!(read(bytes).unwrap_err().to_string(), expected);
    }
    let error = read(&packed[..packed.len() - 12]).unwrap_err().to_string();
    assert!(error.starts_with("test is a broken gzip file ("), "{error}");

    let folder = tempfile::tempdir().unwrap();
    let error = Catalogue::read(&[folder.path()], &ReadOptions::default()).unwrap_err();
    assert!(matches!(error, CatalogueError::Directory { .. }), "{error}");
    let missing = folder.path().join("missing.tle");
    let error = Catalogue::read(&[&missing], &ReadOptions::default()).unwrap_err();
    assert!(error.to_string().starts_with(&format!("cannot read {}: ", missing.display())), "{error}");
    assert!(matches!(Catalogue::read::<&Path>(&[], &ReadOptions::default()), Err(CatalogueError::NoFiles)));
}

#[test]
fn verif_history_and_selection() {
    let text = [
        pair(90001, "079.50000000"),
        pair(90001, "081.50000000"),
        pair(90001, "080.50000000"),
        pair(90002, "070.00000000"),
        pair(90001, "080.50000000"),
    ]
    .concat();
    let epoch = |day: f64| Epoch::from_gregorian_utc_at_midnight(2026, 1, 1) + (day - 1.0) * Unit::Day;
    let all = read_all(text.as_bytes());
    assert_eq!((all.element_sets.len(), all.duplicates, all.superseded), (4, 1, 0));
    assert_eq!((all.sources[0].first_epoch, all.sources[0].last_epoch), (epoch(70.0), epoch(81.5)));
    let at = all.at(epoch(80.4));
    let history = all.into_history();
    assert_eq!(at, history.at(epoch(80.4)));
    let epochs: Vec<_> = history.of(NoradId(90001)).iter().map(|set| set.epoch).collect();
    assert_eq!(epochs, [epoch(79.5), epoch(80.5), epoch(81.5)]);
    for (asked, nearest) in [(10.0, 79.5), (79.9, 79.5), (80.0, 80.5), (80.9, 80.5), (81.1, 81.5), (300.0, 81.5)] {
        let found = history.nearest(NoradId(90001), epoch(asked)).unwrap();
        assert_eq!(found.epoch, epoch(nearest), "asked for day {asked}");
    }
    assert!(history.nearest(NoradId(1), epoch(80.0)).is_none());
    assert_eq!(history.of(NoradId(1)), []);

    let kept = |keep| {
        let options = ReadOptions { keep, ..Default::default() };
        let catalogue = Catalogue::from_bytes("test", text.as_bytes(), &options).unwrap();
        assert_eq!((catalogue.duplicates, catalogue.superseded), (1, 2));
        catalogue.element_sets
    };
    let newest = kept(Keep::Newest);
    assert_eq!(newest.iter().map(|set| set.epoch).collect::<Vec<_>>(), [epoch(81.5), epoch(70.0)]);
    assert_eq!(newest, history.newest());
    let near = kept(Keep::Nearest(epoch(80.4)));
    assert_eq!(near.iter().map(|set| set.epoch).collect::<Vec<_>>(), [epoch(80.5), epoch(70.0)]);
    assert_eq!(near, history.at(epoch(80.4)));
}

/// Long texts are read in pieces on several cores; the answer is the one of a single piece.
#[test]
fn verif_long_files_read_as_short_ones_do() {
    const COUNT: usize = 6000;
    let text = |name: &str| String::from_utf8(sample(name)).unwrap();
    let number = |text: &str, index: usize| text.replace("90001", &format!("{}", 10_000 + index));
    let tle = |index: usize| {
        let lines = number(&text("sample.3le"), index);
        // Without checksums, and now and then something is amiss.
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
    let spoil =
        |text: String, index: usize| if index.is_multiple_of(100) { text.replace("15.06394766", "-1") } else { text };
    let all = |make: &dyn Fn(usize) -> String| (0..COUNT).map(make).collect::<String>();
    let files = [
        (all(&tle), 2),
        (format!("{titles}\n{}", all(&|index| spoil(number(row, index), index) + "\n")), 1),
        (format!("<ndm>\n{}</ndm>", all(&|index| spoil(number(message, index), index))), 1),
        (all(&|index| spoil(number(&text("sample.kvn"), index), index)), 1),
    ];
    for (text, bad_in_a_hundred) in files {
        assert!(text.len() > 700_000);
        let catalogue = read(text.as_bytes()).unwrap();
        let bad = COUNT / 100 * bad_in_a_hundred;
        let format = catalogue.sources[0].format;
        assert_eq!((catalogue.rejected.len(), catalogue.element_sets.len()), (bad, COUNT - bad), "{format}");
        assert!(catalogue.element_sets.windows(2).all(|pair| pair[0].norad_id < pair[1].norad_id), "{format}");
        // Every line number leads to a record that was spoilt.
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
    let catalogue = Catalogue::read(&paths, &ReadOptions::default()).unwrap();
    let ids: Vec<_> = catalogue.element_sets.iter().map(|set| set.norad_id.0).collect();
    assert_eq!((ids, catalogue.duplicates), (vec![90001, 900_010], 1));
    // The two-line file had no name; the duplicate lends it.
    assert_eq!(&*catalogue.element_sets[0].name, "SAMPLE & SON");
    let formats: Vec<_> = catalogue.sources.iter().map(|source| (source.format.to_string(), source.gzipped)).collect();
    assert_eq!(formats, [("TLE".into(), false), ("OMM JSON".into(), true), ("OMM XML".into(), false)]);
    // `sha256sum tests/data/elements/sample.2le`
    assert_eq!(catalogue.sources[0].sha256, "8062e4964ca2f6279c7675b74f95723426d4a8f12f54ddb0816363567b9e9e57");
}

#[test]
fn verif_the_station_rule() {
    let base = read(&sample("sample.2le")).unwrap().element_sets.remove(0);
    // a falls by 2/3 a dn/n: at 15.06 rev/day 1e-5 rev/day are 3 m.
    let history = |changes: &[f64]| -> Vec<ElementSet> {
        let mut mean_motion = base.mean_motion_rev_day;
        changes
            .iter()
            .enumerate()
            .map(|(day, change)| {
                mean_motion += change;
                let mut set = base.clone();
                set.epoch = base.epoch + day as f64 * Unit::Day;
                set.mean_motion_rev_day = mean_motion;
                set
            })
            .collect()
    };
    let names = |changes: &[f64], rule: &StationRule| -> Vec<&str> {
        orbit_phases(&history(changes), rule).into_iter().map(|phase| phase.name()).collect()
    };
    let rule = StationRule::default();
    assert!((semi_major_axis_km(&base) - 6378.137 - 547.8).abs() < 1.0, "{}", semi_major_axis_km(&base));
    assert_eq!(names(&[0.0, 1e-5, -1e-5, 2e-5], &rule), ["on_station"; 4]);
    assert_eq!(names(&[0.0, -1e-2, -1e-2, -1e-2], &rule), ["raising"; 4]);
    assert_eq!(names(&[0.0, 1e-2, 1e-2, 1e-2], &rule), ["decaying"; 4]);
    assert_eq!(names(&[0.0, 1e-2, -1e-2], &rule), ["unknown"; 3]);
    assert_eq!(names(&[0.0, 0.0], &rule), ["unknown"; 2]);
    assert_eq!(names(&[], &rule), [""; 0]);
    assert_eq!(names(&[0.0, 0.0, 0.0], &StationRule { min_height_km: 560.0, ..rule }), ["parked"; 3]);
    // It arrives: the sets after the burn are steady.
    let phases = names(&[0.0, -1e-2, -1e-2, 0.0, 0.0, 0.0], &rule);
    assert_eq!(phases, ["raising", "raising", "on_station", "on_station", "on_station", "on_station"]);
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    /// Whatever stands in a file, reading ends with an answer.
    #[test]
    fn verif_reading_never_panics(bytes in proptest::collection::vec(any::<u8>(), 0..600)) {
        let _ = read(&bytes);
        let _ = read(&gzip(&bytes));
    }

    /// The same for texts that look right at first.
    #[test]
    fn verif_damaged_files_never_panic(
        which in 0_usize..7,
        at in any::<prop::sample::Index>(),
        length in 0_usize..30,
        with in proptest::collection::vec(any::<u8>(), 0..30),
    ) {
        let names =
            ["sample.2le", "sample.3le", "sample.json", "sample_strings.json", "sample.csv", "sample.xml", "sample.kvn"];
        let mut bytes = sample(names[which]);
        let start = at.index(bytes.len());
        let end = (start + length).min(bytes.len());
        bytes.splice(start..end, with);
        if let Ok(catalogue) = read(&bytes) {
            for set in &catalogue.element_sets {
                prop_assert!(set.mean_motion_rev_day > 0.0 && (0.0..1.0).contains(&set.eccentricity));
            }
        }
    }

    /// What is written as a TLE is read back to the last digit that a TLE holds.
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
        // The mantissa needs its five digits.
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
        // Minus zero is zero.
        back.bstar_per_earth_radius += 0.0;
        prop_assert_eq!(back, set);
    }

    /// The nearest of a history is what a search through all of it finds.
    #[test]
    fn verif_nearest_equals_brute_force(
        minutes in proptest::collection::vec(0_i32..5000, 1..40),
        asked in -500_i32..5500,
    ) {
        let base = read(&sample("sample.2le")).unwrap().element_sets.remove(0);
        let at = |minute: i32| base.epoch + f64::from(minute) * Unit::Minute;
        let sets = minutes.iter().enumerate().map(|(index, minute)| {
            let mut set = base.clone();
            set.norad_id = NoradId(1 + index as u32 % 3);
            set.epoch = at(*minute);
            set
        });
        let history = History::new(sets.collect());
        for id in 1..=3 {
            let best = history
                .element_sets()
                .iter()
                .filter(|set| set.norad_id.0 == id)
                .map(|set| (set.epoch - at(asked)).abs())
                .min();
            let found = history.nearest(NoradId(id), at(asked)).map(|set| (set.epoch - at(asked)).abs());
            prop_assert_eq!(found, best);
        }
    }
}
