//! Correction of the magnitudes of a pass by an earlier measurement of the same pass, on held-out tracks and passes.
//!
//! `cargo test --test fitting -- --ignored write_pass_update_table` writes docs/tables/pass-update.md.
//!
//! Requires the data folder; skipped with a message without it.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;

use streakcast::fit::{FitPoint, HeldOutPoint};
use streakcast::photometry::{ErrorDistribution, pass_correlation};

use super::survey::{GroupMean, SURVEYS, Weighted, in_order_of_held_out, log_density, median_and_sigma_mag};

/// Distances between the two measurements, degrees.
const DISTANCES_DEG: [[f64; 2]; 4] = [[0.3, 3.0], [3.0, 8.0], [8.0, 15.0], [15.0, 30.0]];
/// Smallest gain of the log score by a measurement within 8 deg, for each kind.
const LEAST_GAIN: f64 = 0.1;
/// Largest number of measurements of a pass that are compared with one another.
const MOST_OF_A_PASS: usize = 40;

struct Kind {
    name: String,
    /// For each interval of distances, and for those up to 8 deg: mean absolute residual without and with the earlier
    /// measurement, their difference (mag), and gain of the log score.
    rows: Vec<[GroupMean; 4]>,
}

/// Distance that corresponds to a correlation, degrees.
fn distance_deg(one: &FitPoint, other: &FitPoint) -> f64 {
    -12.0 * (pass_correlation(&one.geometry, &other.geometry) / 0.9).ln()
}

fn kinds(data: &Path) -> Vec<Kind> {
    // Nights of Pomenis contain different satellites.
    let of = |survey: &super::survey::Survey| {
        let points = survey.points(data);
        let held_out = survey.held_out(&survey.models[0], &points);
        let [median, sigma] = median_and_sigma_mag(held_out.iter());
        let ordered = in_order_of_held_out(&points);
        assert_eq!(ordered.len(), held_out.len());
        let mut passes = BTreeMap::<u32, Vec<(&FitPoint, &HeldOutPoint)>>::new();
        for (point, one) in ordered.iter().zip(&held_out) {
            assert_eq!(point.magnitude, one.observed_mag);
            passes.entry(one.group).or_default().push((point, one));
        }
        let mut pairs = vec![Vec::new(); DISTANCES_DEG.len() + 1];
        for (group, pass) in &passes {
            let step = pass.len().div_ceil(MOST_OF_A_PASS);
            let pass: Vec<_> = pass.iter().step_by(step).collect();
            for (i, (here, now)) in pass.iter().enumerate() {
                for (j, (there, earlier)) in pass.iter().enumerate() {
                    let distance = distance_deg(here, there);
                    let bin = DISTANCES_DEG.iter().position(|[from, to]| (*from..*to).contains(&distance));
                    let Some(bin) = bin.filter(|_| i != j) else { continue };
                    let (r, known) = (now.residual_mag() - median, earlier.residual_mag() - median);
                    let c = pass_correlation(&here.geometry, &there.geometry);
                    let (updated, narrow) = (r - c * known, sigma * (1.0 - c * c).sqrt());
                    let score = |r, sigma| log_density(&ErrorDistribution::SATELLITES, r, sigma);
                    let (before, after) = (r.abs(), updated.abs());
                    let values = [before, after, after - before, score(updated, narrow) - score(r, sigma)];
                    let weight = now.weight * earlier.weight;
                    for into in [Some(bin), (bin < 2).then_some(DISTANCES_DEG.len())].into_iter().flatten() {
                        pairs[into].push((values, weight, *group));
                    }
                }
            }
        }
        let means = |pairs: &Vec<([f64; 4], f64, u32)>| {
            [0, 1, 2, 3].map(|k| {
                GroupMean::of(pairs.iter().map(|(v, weight, group)| Weighted {
                    value: v[k],
                    weight: *weight,
                    group: *group,
                }))
            })
        };
        Kind { name: survey.kind.to_string(), rows: pairs.iter().map(means).collect() }
    };
    SURVEYS[1..].iter().map(of).collect()
}

fn table(kinds: &[Kind]) -> String {
    let mut table = "| kind |".to_owned();
    DISTANCES_DEG.iter().for_each(|[from, to]| write!(table, " {from} to {to} deg |").unwrap());
    table += " gain of the log score up to 8 deg |\n|---|";
    DISTANCES_DEG.iter().for_each(|_| table += "---|");
    table += "---|\n";
    for kind in kinds {
        write!(table, "| {} |", kind.name).unwrap();
        for [without, with, ..] in &kind.rows[..DISTANCES_DEG.len()] {
            write!(table, " {:.2}, {:.2} |", without.mean, with.mean).unwrap();
        }
        let gain = kind.rows[DISTANCES_DEG.len()][3];
        writeln!(table, " {:+.2} +- {:.2} |", gain.mean, gain.error).unwrap();
    }
    table
}

#[test]
fn valid_a_measurement_corrects_its_pass() {
    let Some(data) = crate::common::data_dir() else { return };
    let kinds = kinds(&data);
    let table = table(&kinds);
    println!("{table}");
    for kind in &kinds {
        assert!(kind.rows[DISTANCES_DEG.len()][3].mean >= LEAST_GAIN, "{}\n{table}", kind.name);
        // Beyond 15 deg the correction neither helps nor harms, within two errors between groups.
        let harm_mag = kind.rows[3][2];
        assert!(harm_mag.mean <= 2.0 * harm_mag.error, "{}: {harm_mag:?}\n{table}", kind.name);
    }
    crate::common::assert_is_documented("pass-update.md", &table);
}

#[test]
#[ignore = "writes into the docs"]
fn write_pass_update_table() {
    let data = crate::common::data_dir().expect("the data folder");
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/tables/pass-update.md");
    std::fs::write(path, table(&kinds(&data))).unwrap();
}
