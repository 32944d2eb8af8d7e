//! Time to read 25,000 element sets from text in every format; target: below 0.2 s.

use std::fmt::Write;

use divan::Bencher;
use divan::counter::ItemsCount;
use hifitime::Epoch;
use streakcast::elements::{Constellation, ElementSet, NoradId, ReadOptions, Satellites, format_tle};

const COUNT: usize = 25_000;

fn main() {
    divan::main();
}

/// Every fourth satellite of the simulated constellation Starlink Gen2, with numbers that fit a TLE.
fn sets() -> Vec<ElementSet> {
    let constellation = Constellation::by_name("starlink-gen2").expect("embedded");
    let mut sets = constellation.element_sets(Epoch::from_gregorian_utc_at_noon(2026, 3, 20));
    sets.truncate(COUNT);
    for (index, set) in sets.iter_mut().enumerate() {
        set.norad_id = NoradId(40_000 + index as u32);
        set.bstar_per_earth_radius = 1.0370434e-4;
    }
    sets
}

/// Keywords and values of an OMM.
fn fields(set: &ElementSet) -> Vec<(&'static str, String)> {
    let epoch = set.epoch.to_gregorian_str(hifitime::TimeScale::UTC);
    let epoch = epoch.trim_end_matches(" UTC").to_string();
    vec![
        ("OBJECT_NAME", set.name.to_string()),
        ("OBJECT_ID", "2026-001A".into()),
        ("EPOCH", epoch),
        ("MEAN_MOTION", set.mean_motion_rev_day.to_string()),
        ("ECCENTRICITY", "0.0001234".into()),
        ("INCLINATION", set.inclination_deg.to_string()),
        ("RA_OF_ASC_NODE", set.right_ascension_of_node_deg.to_string()),
        ("ARG_OF_PERICENTER", "90.1304".into()),
        ("MEAN_ANOMALY", set.mean_anomaly_deg.to_string()),
        ("EPHEMERIS_TYPE", "0".into()),
        ("CLASSIFICATION_TYPE", "U".into()),
        ("NORAD_CAT_ID", set.norad_id.to_string()),
        ("ELEMENT_SET_NO", "999".into()),
        ("REV_AT_EPOCH", "20326".into()),
        ("BSTAR", set.bstar_per_earth_radius.to_string()),
        ("MEAN_MOTION_DOT", "5.84e-6".into()),
        ("MEAN_MOTION_DDOT", "0".into()),
    ]
}

fn text(format: &str) -> String {
    let mut text = String::new();
    for (index, set) in sets().iter().enumerate() {
        let fields = fields(set);
        match format {
            "tle" => {
                let [line1, line2] = format_tle(set).expect("fits");
                writeln!(text, "{}\n{line1}\n{line2}", set.name).expect("memory");
            }
            "csv" => {
                if index == 0 {
                    let titles: Vec<_> = fields.iter().map(|(key, _)| *key).collect();
                    writeln!(text, "{}", titles.join(",")).expect("memory");
                }
                let cells: Vec<_> = fields.into_iter().map(|(_, value)| value).collect();
                writeln!(text, "{}", cells.join(",")).expect("memory");
            }
            "json" => {
                let members: Vec<_> = fields.iter().map(|(key, value)| format!("\"{key}\":\"{value}\"")).collect();
                text.push_str(if index == 0 { "[" } else { "," });
                write!(text, "{{{}}}", members.join(",")).expect("memory");
            }
            "xml" => {
                let elements: String = fields.iter().map(|(key, value)| format!("<{key}>{value}</{key}>")).collect();
                writeln!(text, "<omm><body><segment>{elements}</segment></body></omm>").expect("memory");
            }
            _ => {
                text.push_str("CCSDS_OMM_VERS = 2.0\n");
                for (key, value) in fields {
                    writeln!(text, "{key} = {value}").expect("memory");
                }
            }
        }
    }
    if format == "json" {
        text.push(']');
    }
    text
}

/// Reads a catalogue from the bytes of a file, and computes its provenance.
#[divan::bench(args = ["tle", "csv", "json", "xml", "kvn"], sample_count = 20)]
fn read_25000(bencher: Bencher, format: &str) {
    let text = text(format);
    bencher.counter(ItemsCount::new(COUNT)).bench_local(|| {
        let catalogue = Satellites::from_bytes("bench", text.as_bytes(), &ReadOptions::default()).expect("good");
        assert_eq!(catalogue.element_sets.len(), COUNT);
        catalogue
    });
}

/// Reads a catalogue from a file on disk. With RAYON_NUM_THREADS=1 it uses one core.
#[divan::bench(sample_count = 20)]
fn read_25000_tle_from_disk(bencher: Bencher) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("elements.tle");
    std::fs::write(&path, text("tle")).expect("space");
    bencher
        .counter(ItemsCount::new(COUNT))
        .bench_local(|| Satellites::read(&[&path], &ReadOptions::default()).expect("good"));
}
