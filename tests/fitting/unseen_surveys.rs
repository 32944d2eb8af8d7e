//! Sigma of the default models for a survey to which they were not fitted: g' magnitudes of VisorSats and V1.0 from the
//! Plaskett telescope (Boley et al. 2021). The models were fitted to MMT-9 and to Mallama's means.
//!
//! Requires the data folder; skipped with a message without it.

use hifitime::Epoch;
use streakcast::elements::{Generation, ReadOptions, Satellites};
use streakcast::fit::{ResidualStatistics, sigma_68_mag};
use streakcast::frames::EopTable;
use streakcast::geometry::{Illumination, Observer, Site};
use streakcast::passes::{ModelChoice, Sky};
use streakcast::photometry::{Band, MagSystem, Magnitude, PhotometryOptions};

/// Exposure time to which the zero points of Boley et al. refer, seconds.
const EXPOSURE_S: f64 = 30.0;

/// Returns name, time of the passage, and apparent g' magnitude (AB) of each measured satellite.
fn plaskett(folder: &std::path::Path) -> Vec<(String, Epoch, Magnitude)> {
    let text = std::fs::read_to_string(folder.join("mags-streaks.dat")).unwrap();
    let row = |line: &str| {
        let cells: Vec<&str> = line.split_whitespace().collect();
        // One satellite is defunct and has another attitude.
        if cells.get(12) != Some(&"+") {
            return None;
        }
        let number = |cell: usize| cells[cell].parse::<f64>().unwrap();
        let [zero_point, adu, pixels, background, streak, rate] = [1, 3, 4, 5, 6, 7].map(number);
        let id = cells[0].trim_start_matches("starlink").trim_end_matches('v');
        // Counts were measured during the time t for which the satellite was inside the boxes: m = zero point - 2.5
        // log10(counts 30 s / t)
        let magnitude = zero_point - 2.5 * ((adu - pixels * background) * EXPOSURE_S * rate / streak).log10();
        let epoch = format!("2021-07-16T{} UTC", cells[9]).parse().unwrap();
        Some((format!("STARLINK-{id}"), epoch, Magnitude(magnitude)))
    };
    text.lines().skip(1).filter(|line| !line.trim().is_empty()).filter_map(row).collect()
}

#[test]
fn valid_sigma_on_another_survey() {
    let Some(data) = crate::common::data_dir() else { return };
    let folder = data.join("photometry/boley2021_plaskett");
    let sets = Satellites::read(&[folder.join("starlink.15JUL2021")], &ReadOptions::default()).unwrap().element_sets;
    let site = Site::new_deg("DAO", 48.519974, -123.417006, 244.2).unwrap();
    let choice = ModelChoice::default();
    let sky = Sky::with_models(sets, Observer::new(site), EopTable::embedded().without_polar_motion(), &choice);
    let options = PhotometryOptions::in_band(Band::LsstG, MagSystem::Ab);
    // Number of satellites, number within one sigma, mean residual and half width that contains 68 %, mag.
    for (kind, expected, expected_mag) in
        [(Generation::StarlinkVisorSat, [14, 4], [-0.61, 1.00]), (Generation::StarlinkV10, [8, 8], [-0.08, 0.28])]
    {
        let mut residuals = Vec::new();
        let mut within = Vec::new();
        let mut observed: Vec<(String, Magnitude, bool)> = Vec::new();
        for (name, epoch, magnitude) in plaskett(&folder) {
            let index = sky.elements().iter().position(|set| &*set.name == name.as_str());
            let Some(index) = index else { panic!("{name}") };
            if choice.model_of(&sky.elements()[index]).source() != choice.of_kind(kind).unwrap().source() {
                continue;
            }
            let (points, _) = sky.ephemeris(&[index], &[epoch], Some(&options)).unwrap();
            let brightness = points[0].point.brightness.as_ref().unwrap();
            let residual = magnitude.0 - brightness.magnitude.0;
            println!(
                "{kind} {name}: {:.2} observed, {:.2} +- {:.2} predicted, {residual:+.2}, phase {:.0} deg",
                magnitude.0,
                brightness.magnitude.0,
                brightness.sigma_mag,
                points[0].point.geometry.phase_angle_rad().to_degrees()
            );
            within.push(residual.abs() <= brightness.sigma_mag);
            residuals.push(residual);
            let is_in_penumbra = matches!(points[0].point.illumination, Illumination::Penumbra { .. });
            observed.push((name, magnitude, is_in_penumbra));
        }
        let statistics = ResidualStatistics::unweighted(&residuals).unwrap();
        let share = within.iter().filter(|within| **within).count();
        let found_mag = [statistics.mean_mag, sigma_68_mag(&residuals)];
        println!("{kind}: {share} of {} within sigma; 68 % within {:.2}; {statistics:.2?}", within.len(), found_mag[1]);
        assert_eq!([within.len(), share], expected, "{kind}");
        // The magnitudes depend on the models, and on SGP4 through the positions of the satellites.
        for (found, expected) in found_mag.iter().zip(expected_mag) {
            assert!((found - expected).abs() < 0.02, "{kind}: {found_mag:?}");
        }
        if kind == Generation::StarlinkV10 {
            // In the penumbra satellites are fainter than the mean of the others by these magnitudes.
            let expected = [("STARLINK-1012", 3.3), ("STARLINK-1498", 4.8)];
            let (dark, sunlit): (Vec<_>, Vec<_>) = observed.iter().partition(|(_, _, is_in_penumbra)| *is_in_penumbra);
            let mean = sunlit.iter().map(|(_, magnitude, _)| magnitude.0).sum::<f64>() / sunlit.len() as f64;
            assert_eq!(dark.len(), expected.len(), "{observed:?}");
            for ((name, magnitude, _), (expected_name, fainter_mag)) in dark.into_iter().zip(expected) {
                assert!(name == expected_name && (magnitude.0 - mean - fainter_mag).abs() < 0.05, "{observed:?}");
            }
        }
    }
}
