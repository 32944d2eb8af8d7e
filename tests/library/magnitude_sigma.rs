//! Effect of the age of element sets on the sigma of a magnitude.

use hifitime::{Epoch, Unit};
use streakcast::elements::{Constellation, ElementSet, Origin};
use streakcast::frames::EopTable;
use streakcast::geometry::{Observer, Site};
use streakcast::passes::{ModelChoice, Sky, VisiblePass, VisibleRequest};
use streakcast::photometry::{ModelLibrary, PhotometryOptions};

fn passes(elements: Vec<ElementSet>, start: Epoch) -> Vec<VisiblePass> {
    let site = Site::new_deg("Cerro Pachón", -30.244639, -70.749417, 2663.0).expect("a site");
    let choice = ModelChoice::new(&ModelLibrary::embedded()).expect("shipped models");
    let sky = Sky::with_models(elements, Observer::new(site), EopTable::embedded(), &choice).with_elements_of_any_age();
    let request = VisibleRequest {
        start,
        end: start + 2.0 * Unit::Hour,
        dark: Vec::new(),
        min_altitude_rad: 0.3,
        min_culmination_rad: 0.3,
        limit: None,
        include_dark: true,
        samples: 0,
        photometry: PhotometryOptions::default(),
    };
    sky.visible_passes(&request, &|_| true).expect("passes").passes
}

/// The same satellites with element sets of the same epoch that are treated as three months older. SGP4 gives other
/// positions, but only sigmas are compared. Recent elements do not change the sigma of the model; old ones increase it
/// to at most 3 mag.
#[test]
fn verif_old_elements_widen_the_sigma_of_a_magnitude() {
    let start = Epoch::from_gregorian_utc(2026, 4, 25, 23, 30, 0, 0);
    let shell = Constellation::by_name("starlink-gen1").expect("a shell");
    let mut own = Vec::new();
    for age_days in [0.0, 90.0] {
        let elements = shell
            .element_sets(start - age_days * Unit::Day)
            .into_iter()
            .step_by(9)
            // Simulated satellites have no position errors, so that they are marked as published.
            .map(|elements| ElementSet { origin: Origin::Published, ..elements })
            .collect();
        let sigmas: Vec<f64> = passes(elements, start)
            .iter()
            .filter_map(|pass| pass.culmination.brightness.as_ref().map(|light| light.sigma_mag))
            .collect();
        assert!(sigmas.len() > 30, "{}", sigmas.len());
        let mean = sigmas.iter().sum::<f64>() / sigmas.len() as f64;
        let least = sigmas.iter().copied().fold(f64::INFINITY, f64::min);
        let greatest = sigmas.iter().copied().fold(0.0, f64::max);
        // 0.359 mag is the sigma of the default model of V1.5.
        assert!(least >= 0.359 && greatest < 3.3, "{least} {greatest}");
        own.push(mean);
    }
    let [fresh, old] = own[..] else { panic!("two ages") };
    assert!(old > fresh + 0.05, "fresh {fresh}, old {old}");
}
