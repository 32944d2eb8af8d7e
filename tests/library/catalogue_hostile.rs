//! Invalid input: errors are specific and counted, valid records are read, and nothing panics.

use std::path::Path;

use crate::common::elements::{gzip, pair, read, reasons, sample};
use proptest::prelude::*;
use streakcast::ErrorKind;
use streakcast::elements::{NoradId, ReadOptions, Satellites};

const LINE1: &str = "1 90001U 26001A   26079.52426840 -.00001234  12345-7  10370-3 0  9991";
const LINE2: &str = "2 90001  53.0541 193.4497 0006669 272.1743  87.8481 15.06394766123458";

#[test]
fn verif_an_invalid_record_is_named_and_the_others_are_read() {
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
            reason(5, "line 1: checksum '2' does not match the sum of the line, 1"),
            reason(9, "line 2: inclination \"53.O541\" is not a number in columns 9-16"),
            reason(11, "line 1 of an element set is not followed by its line 2"),
            reason(14, "line 2 has 63 characters, expected 69, or 68 without a checksum"),
            reason(15, "line 2 of an element set is not preceded by its line 1"),
        ]
    );
    assert_eq!(catalogue.rejected[0].to_string(), "test:5: line 1: checksum '2' does not match the sum of the line, 1");
    assert_eq!((catalogue.sources[0].records, catalogue.sources[0].rejected), (2, 5));

    let options = ReadOptions { accept_bad_checksums: true, ..Default::default() };
    let lenient = Satellites::from_bytes("test", text.as_bytes(), &options).unwrap();
    assert_eq!(lenient.rejected.len(), 4);
    assert_eq!(lenient.sources[0].bad_checksums_accepted, 1);
    assert_eq!(lenient.duplicates, 1);
}

#[test]
fn verif_broken_messages_do_not_affect_others() {
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
            "record 2, object 90001, SAMPLE & SON: eccentricity 1.5 is out of range: allowed 0 to below 1",
            "record 3, object 90001, SAMPLE & SON: MEAN_MOTION is missing",
            "invalid JSON: unexpected \"oops\", expected a key, a value or a bracket",
            "invalid JSON: the file ends inside this object",
        ]
    );
    assert_eq!(catalogue.rejected[2].line, 1 + text[..text.find("{\"NORAD").unwrap()].matches('\n').count());

    // Lists in objects, one object per line, and records that contain only the two lines of a TLE.
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
            (4, "invalid CSV: 2 cells under 17 titles".to_string()),
            (
                5,
                "invalid epoch \"2026-13-20T12:34:56.789760\": expected \
                 UTC as YYYY-MM-DDThh:mm:ss.ssssss or YYYY-DDDThh:mm:ss.ssssss"
                    .to_string()
            ),
            (6, "invalid NORAD_CAT_ID \"\"90004\": expected 1 to 999999999, or Alpha-5".to_string()),
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
    assert!(words[0].starts_with("invalid XML: "), "{}", words[0]);
    assert_eq!(
        words[1..],
        [
            "unsupported REF_FRAME \"EME2000\": allowed TEME",
            "unsupported MEAN_ELEMENT_THEORY \"SGP4-XP\": allowed SGP4"
        ]
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
            (69, "invalid KVN: \"EPOCH 2026-03-20T12:34:56.789760\" is not KEYWORD = value".to_string())
        ]
    );
}

#[test]
fn verif_a_whole_file_fails_with_one_clear_error() {
    let allowed =
        "TLE, 2LE, 3LE, OMM (JSON, CSV, XML, KVN), or ephemerides as OEM (KVN, XML) or Modified ITC, plain or gzipped";
    let packed = gzip(&sample("sample.3le"));
    let cases: [(&[u8], String); 9] = [
        (b"", format!("test is empty; allowed: {allowed}")),
        (b" \r\n\n", format!("test is empty; allowed: {allowed}")),
        (&gzip(b""), format!("test is empty; allowed: {allowed}")),
        (
            b"No GP data found",
            format!("test contains no element sets (it begins \"No GP data found\"); allowed: {allowed}"),
        ),
        (
            b"<!DOCTYPE html><html>403</html>",
            format!("test contains no element sets (it is a web page or another kind of XML); allowed: {allowed}"),
        ),
        (
            b"PK\x03\x04zip",
            format!("test contains no element sets (it is a zip archive; unpack it); allowed: {allowed}"),
        ),
        (b"[]", "test (OMM JSON) contains no valid element set: it has no records".into()),
        (
            &LINE1.as_bytes()[..65],
            "test (TLE) contains no valid element set: 1 rejected, the first at line 1: \
             line 1 of an element set is not followed by its line 2"
                .into(),
        ),
        (b"[list]\nx = 1\n", format!("test contains no element sets (it begins \"[list]\"); allowed: {allowed}")),
    ];
    for (bytes, expected) in cases {
        assert_eq!(read(bytes).unwrap_err().to_string(), expected);
    }
    let error = read(&packed[..packed.len() - 12]).unwrap_err().to_string();
    assert!(error.starts_with("test is an invalid gzip file ("), "{error}");

    let folder = tempfile::tempdir().unwrap();
    let error = Satellites::read(&[folder.path()], &ReadOptions::default()).unwrap_err();
    assert!(error.to_string().contains(" contains no files; allowed: "), "{error}");
    let missing = folder.path().join("missing.tle");
    let error = Satellites::read(&[&missing], &ReadOptions::default()).unwrap_err();
    assert!(error.to_string().starts_with(&format!("cannot read {}: ", missing.display())), "{error}");
    let error = Satellites::read::<&Path>(&[], &ReadOptions::default()).unwrap_err();
    assert_eq!((error.kind(), error.to_string().as_str()), (ErrorKind::Missing, "no file of element sets is given"));
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    /// Any bytes give a result or an error, and no panic.
    #[test]
    fn verif_reading_never_panics(bytes in proptest::collection::vec(any::<u8>(), 0..600)) {
        let _ = read(&bytes);
        let _ = read(&gzip(&bytes));
    }

    /// Texts that begin like valid files also give a result or an error.
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
}

/// Texts around element sets: bulletins of packet radio, with a key to the columns, an end mark and a signature.
#[test]
fn texts_around_element_sets_are_no_damaged_records() {
    let head = "SB KEPS\nELEMENTS FOR AMATEURS\n1 AAAAAU 00  0  0 BBBBB.BBBBBBBB  .CCCCCCCC  00000-0  00000-0 0  DDDZ\n\
                2 AAAAA EEE.EEEE FFF.FFFF GGGGGGG HHH.HHHH III.IIII JJ.JJJJJJJJKKKKKZ\nKEY: A-CATALOGNUM\n";
    for end in [
        "/EX\n",
        "NNNN\n",
        "To unsubscribe, mail x@y.org\n1 per week is posted\n2 much mail?\n",
        "-----\n",
        "73, the editor\nwww.example.org\n",
        "73 de W1AW\n",
        "Arc 20260815.10-0821.9 WRMS resid 0.021 totl 0.012 xtrk\n",
        "*** END OF BULLETIN ***\n",
        "(Thanks to N2YO for the elements)\n",
        "No GP data found\n",
        "\nPage 2\n",
        "2026-08-21\n",
        "https://celestrak.org/\n",
        "QUIT\n",
        "",
    ] {
        let text = format!("{head}GOOD\n{LINE1}\n{LINE2}\n{end}");
        let catalogue = read(text.as_bytes()).unwrap();
        assert_eq!(catalogue.element_sets[0].name.as_ref(), "GOOD");
        assert_eq!((reasons(&catalogue), catalogue.sources[0].cut_short), (vec![], false), "{end}");
    }
    // Lines of text between the sets, as in mails of SeeSat, with capitals and small letters or without names.
    let arc = "Arc 20260815.10-0821.9 WRMS resid 0.021 totl 0.012 xtrk";
    for text in [
        format!("GOOD\n{LINE1}\n{LINE2}\n{arc}\nNEXT\n{}{arc}\n", pair(90002, "079.52426840")),
        format!("{LINE1}\n{LINE2}\nRemarks: none\n"),
    ] {
        let catalogue = read(text.as_bytes()).unwrap();
        assert_eq!((reasons(&catalogue), catalogue.sources[0].cut_short), (vec![], false), "{text}");
        assert!(catalogue.element_sets.get(1).is_none_or(|set| &*set.name == "NEXT"), "{text}");
    }
    // A name without its set between others.
    let lost = format!("GOOD\n{LINE1}\n{LINE2}\nLOST\nNEXT\n{}", pair(90002, "079.52426840"));
    assert_eq!(reasons(&read(lost.as_bytes()).unwrap()).len(), 1);
    // A file that is cut after a name, or inside a line, may be truncated.
    for end in ["NEXT\n", "NEXT\n1 ", "NEXT\n1 90002U 26001A   26079.5\n", &format!("NEXT\n{LINE1}\n")] {
        let catalogue = read(format!("GOOD\n{LINE1}\n{LINE2}\n{end}").as_bytes()).unwrap();
        assert!(catalogue.sources[0].cut_short, "{end}");
    }
}

/// Concatenated files of other formats are read; elements in a form that is not read are counted with their lines.
#[test]
fn no_satellite_of_a_concatenated_file_is_lost() {
    let forms = ["sample.3le", "sample.csv", "sample.json", "sample.xml", "sample.kvn"];
    let text_of = |name: &str| String::from_utf8(sample(name)).unwrap();
    for first in forms {
        for second in forms.iter().filter(|second| **second != first) {
            let other = match *second {
                "sample.3le" => format!("SECOND\n{}", pair(90002, "079.52426840")),
                name => text_of(name).replace("90001", "90002"),
            };
            let catalogue = read(format!("{}\n{other}", text_of(first)).as_bytes()).unwrap();
            let ids: Vec<_> = catalogue.element_sets.iter().map(|set| set.norad_id.0).collect();
            assert_eq!((ids, reasons(&catalogue)), (vec![90001, 90002], vec![]), "{first} {second}");
            let name = catalogue.element_sets[1].name.as_ref();
            assert_eq!(name, if *second == "sample.3le" { "SECOND" } else { "SAMPLE & SON" }, "{first} {second}");
        }
    }
    // Tables with other titles, and one object per line.
    let csv = text_of("sample.csv");
    let lines = format!("NORAD_CAT_ID,LINE1,LINE2\n7,{LINE1},{LINE2}\n");
    assert_eq!(read(format!("{lines}{}", csv.replace("90001", "90002")).as_bytes()).unwrap().element_sets.len(), 2);
    let object = text_of("sample.json").replace('\n', " ").replace("90001", "90002");
    let object = object.trim().trim_start_matches('[').trim_end_matches(']');
    let mixed = format!("GOOD\n{LINE1}\n{LINE2}\n{object}\n{}\n", object.replace("90002", "90003"));
    assert_eq!(read(mixed.as_bytes()).unwrap().element_sets.len(), 3);

    let three = format!("NEXT\n{}OTHER\n{}", pair(90002, "079.52426840"), pair(90003, "079.52426840"));
    let row = csv.lines().nth(1).unwrap();
    let each = |form: fn(&str) -> String| three.lines().map(form).collect::<Vec<_>>().join("\n");
    for (what, text) in [
        ("quoted", each(|line| format!("> {line}"))),
        ("in quotation marks", each(|line| format!("\"{line}\""))),
        ("numbered", each(|line| format!("17: {line}"))),
        ("named", each(|line| format!("L1: {line}"))),
        ("with no-break spaces", three.replace(' ', "\u{a0}")),
        ("without line numbers", each(|line| line.trim_start_matches(['1', '2']).trim().to_owned())),
        ("in one line", three.replace("\n1 ", ",1 ").replace("\n2 ", ",2 ")),
        ("table without titles", format!("{row}\n{row}")),
        ("quoted messages", text_of("sample.kvn").repeat(2).lines().map(|line| format!("> {line}\n")).collect()),
    ] {
        let catalogue = read(format!("GOOD\n{LINE1}\n{LINE2}\n{text}\n").as_bytes()).unwrap();
        assert_eq!(
            (catalogue.element_sets.len(), catalogue.rejected.len()),
            (1, 2),
            "{what}: {:?}",
            reasons(&catalogue)
        );
        assert!(catalogue.rejected.iter().all(|rejected| rejected.reason.to_string().starts_with("unexpected line")));
        let before = read(format!("{text}\nGOOD\n{LINE1}\n{LINE2}\n").as_bytes()).unwrap();
        assert_eq!((&*before.element_sets[0].name, before.rejected.len()), ("GOOD", 2), "{what}");
    }
    let quoted = format!("{}\n{}", text_of("sample.xml"), each(|line| format!("> {line}")));
    let catalogue = read(quoted.as_bytes()).unwrap();
    let lines: Vec<usize> = catalogue.rejected.iter().map(|rejected| rejected.line).collect();
    let of_xml = quoted.split("> NEXT").next().unwrap().matches('\n').count();
    assert_eq!((catalogue.element_sets.len(), lines), (1, vec![of_xml + 2, of_xml + 5]));
}

/// Ephemerides before, after and between element sets and other ephemerides of one file are read.
#[test]
fn no_ephemeris_of_a_concatenated_file_is_lost() {
    let of = |folder: &str, name: &str| {
        std::fs::read_to_string(format!("{}/tests/data/{folder}/{name}", env!("CARGO_MANIFEST_DIR"))).unwrap()
    };
    let oems = ["invented.oem", "invented_itrf.xml"].map(|name| of("ephemerides", name));
    let segments = oems.each_ref().map(|text| read(text.as_bytes()).unwrap().ephemerides.len());
    // The element set is of another satellite than the ephemerides.
    let tle = format!("SECOND\n{}", pair(90002, "079.52426840"));
    let sets = ["sample.csv", "sample.json", "sample.xml", "sample.kvn"].map(|name| of("elements", name));
    for (oem, expected) in oems.iter().zip(segments) {
        let many_lines = tle.repeat(30);
        for set in sets.iter().map(|text| text.replace("90001", "90002")).chain([tle.clone(), many_lines]) {
            for text in [format!("{set}\n{oem}"), format!("{oem}\n{set}"), format!("{oem}\n{set}\n{}", oems[0])] {
                let catalogue = read(text.as_bytes()).unwrap();
                let more = if text.len() > oem.len() + set.len() + 1 { segments[0] } else { 0 };
                assert_eq!(
                    (catalogue.element_sets.len(), catalogue.ephemerides.len(), reasons(&catalogue)),
                    (1, expected + more, vec![]),
                    "{}",
                    &text[..40]
                );
            }
        }
    }
    // A title and comments before the first keyword.
    let titled = format!("COMMENT a title\nCOMMENT two lines\n{}\n{}", oems[0], oems[0]);
    let catalogue = read(titled.as_bytes()).unwrap();
    assert_eq!((catalogue.ephemerides.len(), reasons(&catalogue)), (2 * segments[0], vec![]));
    // The line of an error is that of the whole file.
    let wrong = oems[0].replacen("META_STOP", "META_STOPPED", 1);
    let at = wrong.split("META_STOPPED").next().unwrap().matches('\n').count() + 1;
    let error = read(format!("{tle}{wrong}").as_bytes()).unwrap_err().to_string();
    assert!(error.contains(&format!(":{}:", at + 3)), "{error}");
}

/// The answer of a server without records, and records whose period or size contradicts the mean motion.
#[test]
fn errors_of_servers_and_contradictory_messages_are_named() {
    let error = |text: &str| read(text.as_bytes()).unwrap_err().to_string();
    let answer = error("[{\"error\":\"You've violated your query rate limit.\"}]");
    assert!(answer.contains("error message instead of a record: You've violated your query rate limit."), "{answer}");
    let json = String::from_utf8(sample("sample.json")).unwrap();
    let with = |cards: &str| json.replace("\"EPOCH\"", &format!("{cards}, \"EPOCH\""));
    // 1440 min / 15.06394766 = 95.592 min.
    for (cards, is_read) in [
        ("\"PERIOD\": 95.592, \"SEMIMAJOR_AXIS\": 6925.0", true),
        ("\"PERIOD\": null, \"SEMIMAJOR_AXIS\": \"\"", true),
        ("\"PERIOD\": 97.0", false),
        ("\"SEMIMAJOR_AXIS\": \"7378.0\"", false),
    ] {
        assert_eq!(read(with(cards).as_bytes()).is_ok(), is_read, "{cards}");
    }
    let reason = error(&with("\"PERIOD\": 1436.1"));
    let expected = "MEAN_MOTION is 15.06394766 and PERIOD is 1436.1: they contradict each other; allowed: PERIOD within 1 % of 95.592";
    assert!(reason.contains(expected), "{reason}");
}

/// Epochs that can be read in two ways, and satellites that are known to have decayed.
#[test]
fn unclear_epochs_and_decayed_satellites() {
    let json = String::from_utf8(sample("sample.json")).unwrap();
    let epoch = json.split("\"EPOCH\": \"").nth(1).and_then(|rest| rest.split('"').next()).unwrap();
    let error = |text: &str| read(text.as_bytes()).unwrap_err().to_string();
    assert!(error(&json.replace(epoch, &epoch[..10])).contains("invalid epoch \"2026-03-20\""));
    assert!(error(&json.replace(epoch, &epoch[..16])).contains("invalid epoch \"2026-03-20T12:34\""));
    assert!(error(&json.replace(epoch, "2026-079")).contains("invalid epoch \"2026-079\""));
    let day_0 = format!("{}\n{LINE2}\n", LINE1.replace("26079.52426840", "26000.52426840").replace("9991", "9992"));
    assert!(error(&day_0).contains("day 0 is 31 December"), "{}", error(&day_0));

    let with = |cards: &str| json.replace("\"EPOCH\"", &format!("{cards}, \"EPOCH\""));
    let decayed = |text: &str| read(text.as_bytes()).unwrap().element_sets[0].decayed;
    assert_eq!(decayed(&json), None);
    assert_eq!(decayed(&with("\"DECAY_DATE\": null")), None);
    let end = Some("2026-03-22T00:00:00 UTC".parse::<hifitime::Epoch>().unwrap());
    for text in ["2026-03-21", "2026-03-21 00:00:00"] {
        assert_eq!(decayed(&with(&format!("\"DECAY_DATE\": \"{text}\""))), end, "{text}");
    }
    // User-defined parameters of Space-Track in XML and KVN. Those that are keywords of the standard are not read.
    let of = |name: &str| String::from_utf8(sample(name)).unwrap();
    let in_xml = |parameter: &str, text: &str| {
        let parameter = format!("<USER_DEFINED parameter=\"{parameter}\">{text}</USER_DEFINED>");
        let more = format!("</tleParameters><userDefinedParameters>{parameter}</userDefinedParameters>");
        of("sample.xml").replace("</tleParameters>", &more)
    };
    let in_kvn = |parameter: &str, text: &str| format!("{}USER_DEFINED_{parameter} = {text}\n", of("sample.kvn"));
    let at_epoch = read(json.as_bytes()).unwrap().element_sets[0].epoch;
    for with in [&in_xml as &dyn Fn(&str, &str) -> String, &in_kvn] {
        assert_eq!(decayed(&with("DECAY_DATE", "2026-03-21")), end);
        assert_eq!(decayed(&with("DECAY_DATE", "")), None);
        assert_eq!(decayed(&with("DECAYED", "0")), None);
        assert_eq!(decayed(&with("DECAYED", "1")), Some(at_epoch));
        assert_eq!(read(with("MEAN_MOTION", "1").as_bytes()).unwrap().element_sets[0].mean_motion_rev_day, 15.06394766);
        assert!(error(&with("PERIOD", "50")).contains("PERIOD is 50"));
    }
    // A satellite that has decayed at an unknown time: positions after the epoch are unknown.
    let set = read(with("\"DECAYED\": \"1\"").as_bytes()).unwrap().element_sets.remove(0);
    let propagator = streakcast::orbit::Propagator::new(&set).unwrap();
    assert!(propagator.teme_state_at_minutes(-10.0).is_ok());
    let reason = propagator.teme_state_at_minutes(10.0).unwrap_err().to_string();
    assert!(reason.contains("has decayed (DECAYED of its element set) at an unknown time"), "{reason}");
    let noon = Some("2026-03-21T12:00:00 UTC".parse::<hifitime::Epoch>().unwrap());
    assert_eq!(decayed(&with("\"DECAY_DATE\": \"2026-03-21T12:00:00\"")), noon);
    assert!(error(&with("\"DECAY_DATE\": \"soon\"")).contains("DECAY_DATE as YYYY-MM-DD"));
    // Positions exist up to the end of that day.
    let set = read(with("\"DECAY_DATE\": \"2026-03-21\"").as_bytes()).unwrap().element_sets.remove(0);
    let propagator = streakcast::orbit::Propagator::new(&set).unwrap();
    let minutes = |epoch: &str| propagator.minutes_since_epoch(epoch.parse().unwrap());
    assert!(propagator.teme_state_at_minutes(minutes("2026-03-21T23:00:00 UTC")).is_ok());
    let error = propagator.teme_state_at_minutes(minutes("2026-03-22T01:00:00 UTC")).unwrap_err().to_string();
    assert!(error.contains("has decayed before 2026-03-22"), "{error}");
}

/// Values of an OMM in other units than the standard ones are not read as these.
#[test]
fn other_units_in_messages_are_rejected() {
    let kvn = String::from_utf8(sample("sample.kvn")).unwrap();
    let xml = String::from_utf8(sample("sample.xml")).unwrap();
    let rates = |unit: &str| xml.replace("units=\"rev/day\"", &format!("units=\"{unit}\""));
    for (text, expected) in [
        (kvn.replace("53.0541 [deg]", "0.92597 [rad]"), "unsupported unit \"rad\" of INCLINATION: allowed deg"),
        (xml.replace("units=\"deg\"", "units=\"rad\""), "unsupported unit \"rad\" of INCLINATION: allowed deg"),
        (rates("rad/s"), "unsupported unit \"rad/s\" of MEAN_MOTION: allowed rev/day"),
        (kvn.replace("193.4497", "12.896 [h]"), "unsupported unit \"h\" of RA_OF_ASC_NODE: allowed deg"),
    ] {
        let error = read(text.as_bytes()).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    }
    for text in [kvn.replace("[deg]", "[DEG]").replace("193.4497", "193.4497 [degrees]"), rates("REV/DAY")] {
        assert_eq!(read(text.as_bytes()).unwrap().element_sets.len(), 1, "{text}");
    }
}
