//! Catalogues from real files, including damaged ones: numbers of records. Skipped without the data folder.

use std::collections::HashMap;
use std::path::PathBuf;

use serde_json::Value;
use streakcast::elements::{
    Certainty, Constellation, ElementFormat, ElementSet, Generation, GenerationTable, History, Keep, NoradId,
    OrbitPhase, ReadOptions, Satellites, StationRule, format_tle, orbit_phases, semi_major_axis_km,
};

fn read(path: PathBuf, keep: Keep) -> Satellites {
    Satellites::read(&[&path], &ReadOptions { keep, ..Default::default() })
        .unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// File, format, number of valid records, of rejected records, of objects, and of exact duplicates.
type Expected = (&'static str, ElementFormat, usize, usize, usize, usize);

const EXPECTED: [Expected; 26] = {
    use ElementFormat::{OmmCsv, OmmJson, OmmKvn, OmmXml, Tle};
    [
        ("messy/20001_tim_tle.txt", Tle, 19_690, 0, 19_690, 0),
        ("messy/active_gp_2023-06-21_dups.txt", Tle, 7982, 0, 7976, 2),
        ("messy/keeptrack_2021-07-28_bom_excerpt.txt", Tle, 300, 0, 300, 0),
        ("messy/keeptrack_alpha5_excerpt.txt", Tle, 3, 397, 3, 0),
        ("messy/starlink_2020-10-12_duplicates.txt", Tle, 2674, 0, 2311, 344),
        ("fullcat/tle_2020-05-17.txt", Tle, 19_895, 255, 19_895, 0),
        ("fullcat/TLE3_2023-04-07.txt", Tle, 24_548, 0, 24_548, 0),
        ("active/active_2024-08-14.txt", Tle, 10_081, 0, 10_081, 0),
        ("active/active_2026-04-25.txt", Tle, 15_851, 0, 15_847, 0),
        ("history/50001.txt", Tle, 2119, 0, 1, 234),
        ("mmt_2021/starlink_2021-03-15.txt", Tle, 1141, 0, 1141, 0),
        ("supgp/starlink_supgp_2020-02-23.tle", Tle, 296, 0, 296, 0),
        ("omm/iss_tle.txt", Tle, 1, 0, 1, 0),
        ("omm/iss_omm.json", OmmJson, 1, 0, 1, 0),
        ("omm/starlink_satellites_2023-07-17.omm.json", OmmJson, 4428, 0, 4428, 0),
        ("omm/ccsds_ndm/json/omm1_ct.json", OmmJson, 1, 0, 1, 0),
        ("omm/ccsds_ndm/json/omm1_st.json", OmmJson, 1, 0, 1, 0),
        ("omm/ccsds_ndm/kvn/omm1_ct.kvn", OmmKvn, 1, 0, 1, 0),
        ("omm/ccsds_ndm/kvn/omm1_st.kvn", OmmKvn, 1, 0, 1, 0),
        ("omm/ccsds_ndm/xml/omm_combined.xml", OmmXml, 19, 1, 19, 0),
        ("omm/ccsds_ndm/xml/omm_single_ndm.xml", OmmXml, 1, 0, 1, 0),
        ("omm/ccsds_ndm/xml/ndmxml-1.0-omm-2.0.xml", OmmXml, 1, 0, 1, 0),
        ("omm/sample_omm.csv", OmmCsv, 1, 0, 1, 0),
        ("omm/2004-047A.csv", OmmCsv, 33, 0, 1, 0),
        ("omm/2026-152A.csv", OmmCsv, 27, 0, 1, 0),
        ("pomenis_2022/20220505-174625.csv", OmmCsv, 5549, 0, 5549, 0),
    ]
};

#[test]
fn valid_every_real_file_reads() {
    let Some(data) = crate::common::data_dir() else { return };
    for (name, format, records, rejected, objects, duplicates) in EXPECTED {
        let catalogue = read(data.join("tle").join(name), Keep::Newest);
        let source = &catalogue.sources[0];
        assert_eq!(
            (source.format, source.records, source.rejected, catalogue.element_sets.len(), catalogue.duplicates),
            (format, records, rejected, objects, duplicates),
            "{name}"
        );
        assert_eq!(catalogue.rejected.len(), rejected);
    }
    let options = ReadOptions { accept_bad_checksums: true, keep: Keep::Newest };
    for (name, accepted, objects) in
        [("messy/keeptrack_alpha5_excerpt.txt", 397, 400), ("fullcat/tle_2020-05-17.txt", 255, 20_150)]
    {
        let catalogue = Satellites::read(&[data.join("tle").join(name)], &options).unwrap();
        assert_eq!((catalogue.sources[0].bad_checksums_accepted, catalogue.element_sets.len()), (accepted, objects));
    }
}

#[test]
fn valid_other_files_are_rejected_by_name() {
    let Some(data) = crate::common::data_dir() else { return };
    for (name, words) in [
        // Ephemeris in Modified ITC under another name: only the name of the published file identifies the satellite.
        ("omm/sample_starlink_ephemeris.txt", "allowed: MEME_NUMBER_NAME"),
        ("history/manoeuvres_Sentinel-6A.yaml", "contains no element sets"),
        ("omm/ccsds_ndm/LICENSE", "contains no element sets"),
    ] {
        let error = Satellites::read(&[data.join("tle").join(name)], &ReadOptions::default()).unwrap_err().to_string();
        assert!(error.contains(name) && error.contains(words), "{error}");
    }
}

#[test]
fn valid_the_same_object_in_two_syntaxes() {
    let Some(data) = crate::common::data_dir() else { return };
    let one = |name: &str| read(data.join("tle/omm").join(name), Keep::All).element_sets.remove(0);
    let (tle, omm) = (one("iss_tle.txt"), one("iss_omm.json"));
    // The TLE has fewer digits: seven instead of eight for the eccentricity, five instead of eight for B*.
    assert_eq!((tle.eccentricity, omm.eccentricity), (0.0006669, 0.00066697));
    assert_eq!((tle.bstar_per_earth_radius, omm.bstar_per_earth_radius), (0.10370e-3, 0.00010370434));
    let mut rounded = omm.clone();
    rounded.eccentricity = tle.eccentricity;
    rounded.bstar_per_earth_radius = tle.bstar_per_earth_radius;
    assert_eq!(rounded, tle);
    // The same message in JSON (Space-Track and CelesTrak), KVN and XML.
    let space_track = one("ccsds_ndm/json/omm1_st.json");
    for name in ["ccsds_ndm/json/omm1_ct.json", "ccsds_ndm/json/omm1_st.xml", "ccsds_ndm/kvn/omm1_st.kvn"] {
        assert_eq!(one(name), space_track, "{name}");
    }
    assert_eq!(one("ccsds_ndm/kvn/omm1_ct.kvn"), one("ccsds_ndm/json/omm1_ct.xml"));
    let (mut csv, xml) = (one("sample_omm.csv"), one("sample_omm.xml"));
    assert_eq!(csv, xml);
    // GP history: numbers as floats.
    csv = one("2004-047A.csv");
    assert_eq!((csv.norad_id, csv.revolution_at_epoch, &*csv.name), (NoradId(28485), 18_950, "SWIFT"));
}

#[test]
fn valid_a_real_catalogue_survives_a_round_trip() {
    let Some(data) = crate::common::data_dir() else { return };
    for name in ["active/active_2026-04-25.txt", "messy/20001_tim_tle.txt"] {
        for set in read(data.join("tle").join(name), Keep::All).element_sets {
            let [line1, line2] = format_tle(&set).unwrap();
            let text = format!("{}\n{line1}\n{line2}\n", set.name);
            let mut back =
                Satellites::from_bytes("written", text.as_bytes(), &ReadOptions::default()).unwrap().element_sets;
            let mut back = back.remove(0);
            // Designators of other forms cannot be written. The sign of zero and the form of an exponent may differ.
            back.international_designator = set.international_designator.clone();
            assert_eq!(back, set, "{line1}");
        }
    }
}

#[test]
fn valid_the_station_rule_on_real_histories() {
    let Some(data) = crate::common::data_dir() else { return };
    let file = data.join("derived/starlink_tle_history_2026-05-29_2026-08-21_sel.tle");
    let history = read(file, Keep::All).into_history();
    let index = std::fs::read_to_string(data.join("derived/starlink_tle_history_sel_index.csv")).unwrap();
    let mut tally: HashMap<&str, HashMap<&str, usize>> = HashMap::new();
    let (mut raising, mut decaying) = (0, 0);
    // Since 2025 some shells have heights of 460 to 485 km; Direct to Cell is at 360 km.
    let rule = StationRule { min_height_km: 355.0, ..Default::default() };
    for row in index.lines().skip(1) {
        let cells: Vec<_> = row.split(',').collect();
        let sets = history.sets_of(NoradId(cells[1].parse().unwrap()));
        assert!(!sets.is_empty(), "{row}");
        let phases = orbit_phases(sets, &rule);
        for phase in &phases {
            *tally.entry(cells[0]).or_default().entry(phase.name()).or_default() += 1;
        }
        // If the mean altitude changes by more than 2 km from both neighbours, the satellite is raising or decaying.
        for (at, three) in sets.windows(3).enumerate() {
            let [before, now, after] = [0, 1, 2].map(|index| semi_major_axis_km(&three[index]));
            if now - before > 2.0 && after - now > 2.0 {
                assert_eq!(phases[at + 1], OrbitPhase::Raising, "{row}");
                raising += 1;
            } else if before - now > 2.0 && now - after > 2.0 {
                assert_eq!(phases[at + 1], OrbitPhase::Decaying, "{row}");
                decaying += 1;
            }
        }
    }
    eprintln!("{tally:#?}");
    let share = |group: &str, phase: OrbitPhase| {
        let counts = &tally[group];
        *counts.get(phase.name()).unwrap_or(&0) as f64 / counts.values().sum::<usize>() as f64
    };
    assert!(share("v15_onstation_cfg", OrbitPhase::OnStation) > 0.95);
    assert!(share("v2mini_onstation", OrbitPhase::OnStation) > 0.9);
    assert!(share("raising", OrbitPhase::Raising) > 0.2 && share("decaying", OrbitPhase::Decaying) > 0.3);
    eprintln!("{raising} certainly raising, {decaying} certainly decaying");
    assert!(raising > 100 && decaying > 100);
}

/// Returns the Starlink element sets of the data folder that have a name or a launch, one per object.
fn starlinks(data: &std::path::Path) -> Vec<ElementSet> {
    let files = [
        "active/active_2024-08-14.txt",
        "active/active_2026-04-25.txt",
        "active/starlink_2023-10-16.txt",
        "daily/starlink_2026-08-21.tle",
        "mmt_2021/starlink_2020-12-27.txt",
        "mmt_2021/starlink_2021-03-15.txt",
        "pomenis_2022/starlink_2022-10-25.txt",
        "pomenis_2022/active_2022-01-06.tle",
        "fullcat/TLE3_2023-04-07.txt",
    ];
    let paths: Vec<_> = files.iter().map(|name| data.join("tle").join(name)).collect();
    let options = ReadOptions { keep: Keep::All, ..Default::default() };
    let history: History = Satellites::read(&paths, &options).unwrap().into_history();
    history.newest()
}

#[test]
fn valid_generations_against_the_list_of_launches() {
    let Some(data) = crate::common::data_dir() else { return };
    let text = std::fs::read_to_string(data.join("metadata/starlink_generations.json")).unwrap();
    let list: Value = serde_json::from_str(&text).unwrap();
    let listed: HashMap<u32, &str> = list["satellites"]
        .as_array()
        .unwrap()
        .iter()
        .map(|row| (row["sat_number"].as_u64().unwrap() as u32, row["generation"].as_str().unwrap()))
        .collect();
    let table = GenerationTable::embedded();
    let (mut with_launch, mut by_name, mut compared) = (0, 0, 0);
    for set in starlinks(&data) {
        let Some(&expected) = listed.get(&set.norad_id.0) else { continue };
        compared += 1;
        let kinds = |generation| match generation {
            Generation::StarlinkV09 => "v0.9",
            Generation::StarlinkV10 | Generation::StarlinkVisorSat => "v1",
            Generation::StarlinkV15 => "v1.5",
            // The list does not distinguish Direct to Cell from V2 Mini.
            Generation::StarlinkV2Mini | Generation::StarlinkDirectToCell => "v2 mini",
            _ => "other",
        };
        with_launch += usize::from(kinds(table.generation(&set)) == expected);
        // As if launched after the end of the table.
        let mut late = set.clone();
        late.international_designator = "".into();
        by_name += usize::from(kinds(table.generation(&late)) == expected);
    }
    let share = |count: usize| count as f64 / compared as f64;
    eprintln!("{compared} compared: table {:.5}, name alone {:.5}", share(with_launch), share(by_name));
    assert!(compared > 7500, "{compared}");
    assert!(share(with_launch) > 0.995 && share(by_name) > 0.995);
}

#[test]
fn valid_the_satellites_of_one_brightness_are_v15() {
    let Some(data) = crate::common::data_dir() else { return };
    let text = std::fs::read_to_string(data.join("photometry/pomenis/brightness_config_list.csv")).unwrap();
    let ids: Vec<u32> = text.lines().filter_map(|line| line.trim().parse().ok()).collect();
    assert_eq!(ids.len(), 756);
    let sets: HashMap<u32, ElementSet> = starlinks(&data).into_iter().map(|set| (set.norad_id.0, set)).collect();
    let found: Vec<_> = ids.iter().filter_map(|id| sets.get(id)).collect();
    eprintln!("{} of 756 in the catalogues", found.len());
    assert!(found.len() > 700);
    for set in found {
        assert_eq!(GenerationTable::embedded().classify(set), (Generation::StarlinkV15, Certainty::Table), "{set:?}");
    }
}

#[test]
fn valid_visorsats_of_the_mmt9_list() {
    let Some(data) = crate::common::data_dir() else { return };
    let text = std::fs::read_to_string(data.join("photometry/mmt9_cara/IDs_Starlink_VisorSat.txt")).unwrap();
    let sets: HashMap<u32, ElementSet> = starlinks(&data).into_iter().map(|set| (set.norad_id.0, set)).collect();
    let found: Vec<_> = text.split_whitespace().filter_map(|id| sets.get(&id.parse().ok()?)).collect();
    assert!(found.len() >= 29, "{}", found.len());
    for set in found {
        assert_eq!(GenerationTable::embedded().generation(set), Generation::StarlinkVisorSat, "{set:?}");
    }
}

#[test]
fn valid_constellations_by_name() {
    let Some(data) = crate::common::data_dir() else { return };
    let mut counts: HashMap<Generation, usize> = HashMap::new();
    for set in read(data.join("tle/active/active_2026-04-25.txt"), Keep::Newest).element_sets {
        *counts.entry(GenerationTable::embedded().generation(&set)).or_default() += 1;
    }
    eprintln!("{counts:?}");
    assert_eq!(
        (counts[&Generation::OneWeb], counts[&Generation::Kuiper], counts[&Generation::Qianfan]),
        (651, 238, 126)
    );
    // Satellites of five launches of BlueBird and BlueWalker 3, and all of Iridium NEXT.
    assert_eq!((counts[&Generation::IridiumNext], counts[&Generation::BlueBird]), (80, 7));
    assert!(counts[&Generation::StarlinkDirectToCell] > 600 && counts[&Generation::Guowang] > 150);
}

#[test]
fn valid_kinds_without_a_name_and_assumed_kinds() {
    let Some(data) = crate::common::data_dir() else { return };
    let table = GenerationTable::embedded();
    let ids = std::fs::read_to_string(data.join("photometry/mmt9_cara/IDs_Iridium_2ndGen.txt")).unwrap();
    let ids: Vec<u32> = ids.split_whitespace().filter_map(|id| id.parse().ok()).collect();
    assert_eq!(ids.len(), 27);
    let (mut iridium, mut later, mut earlier) = (0, 0, 0);
    for mut set in read(data.join("tle/active/active_2026-04-25.txt"), Keep::Newest).element_sets {
        let (kind, assumed) = (table.generation(&set), table.is_assumed(&set));
        iridium += usize::from(ids.contains(&set.norad_id.0) && kind == Generation::IridiumNext);
        if kind.is_starlink() {
            // The last launch of the table is 2025-071.
            let is_later = set.international_designator.get(..8).is_some_and(|launch| launch > "2025-071");
            assert_eq!(assumed, is_later, "{set:?}");
            *(if is_later { &mut later } else { &mut earlier }) += 1;
        } else {
            assert!(!assumed, "{set:?}");
        }
        // The same satellite before it had a name. Three test objects have names with Guowang.
        let was_test = set.name.starts_with("GUOWANG TEST");
        set.name = "OBJECT A".into();
        let is_dedicated = [Generation::Kuiper, Generation::Qianfan, Generation::Guowang, Generation::IridiumNext];
        if is_dedicated.contains(&kind) && !was_test {
            assert_eq!(table.generation(&set), kind, "{set:?}");
            assert_eq!(table.is_assumed(&set), kind != Generation::IridiumNext, "{set:?}");
        }
    }
    eprintln!("{iridium} of {} Iridium NEXT of MMT-9's list; Starlinks {earlier} by table, {later} later", ids.len());
    assert!(iridium == ids.len() && later > 3000 && earlier > 5000);
}

#[test]
fn valid_shells_against_a_published_list() {
    let Some(data) = crate::common::data_dir() else { return };
    let text = std::fs::read_to_string(data.join("metadata/constellations.json")).unwrap();
    let list: Value = serde_json::from_str(&text).unwrap();
    // Satellites by altitude and inclination in the list, for every constellation.
    let listed = |code: &str| -> Vec<(i64, f64, u64)> {
        let all = list.as_array().unwrap();
        let found = all.iter().find(|entry| entry["code"] == code).unwrap_or_else(|| panic!("{code}"));
        let mut shells: Vec<_> = found["shells"]
            .as_object()
            .unwrap()
            .values()
            .map(|shell| {
                let altitude = shell["alt"].as_f64().unwrap().round() as i64;
                (altitude, shell["inc"].as_f64().unwrap(), shell["totSat"].as_u64().unwrap())
            })
            // In the list, Gen1 includes the very low shells of 2018.
            .filter(|(altitude, _, _)| *altitude > 400)
            .collect();
        shells.sort_by(|a, b| a.partial_cmp(b).unwrap());
        shells
    };
    for (name, code) in [("starlink-gen1", "SL1"), ("oneweb", "OW2r"), ("kuiper", "AK"), ("guowang", "GW")] {
        let mut simulated: Vec<_> = Constellation::by_name(name)
            .unwrap()
            .shells
            .iter()
            .map(|shell| {
                let total = u64::from(shell.planes) * u64::from(shell.satellites_per_plane);
                (shell.altitude_km as i64, shell.inclination_deg, total)
            })
            .collect();
        simulated.sort_by(|a, b| a.partial_cmp(b).unwrap());
        for (simulated, expected) in simulated.iter().zip(listed(code)) {
            assert_eq!((simulated.0, simulated.2), (expected.0, expected.2), "{name}");
            // The list rounds Kuiper's inclination of 51.9 deg to 52 deg.
            assert!((simulated.1 - expected.1).abs() <= 0.11, "{name}: {} {}", simulated.1, expected.1);
        }
        assert_eq!(simulated.len(), listed(code).len());
    }
}
