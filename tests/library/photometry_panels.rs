//! Satellites made of panels compared with the closed form of chassis and sail and with single rays; covariance; errors
//! for invalid files.

use crate::common::agreement::Agreement;
use std::f64::consts::PI;

use crate::common::random::Random;
use nalgebra::Vector3;
use serde_json::{Value, json};
use streakcast::geometry::ViewingGeometry;
use streakcast::photometry::brdf::{Brdf, Facets, Incidence, Law, Retro};
use streakcast::photometry::earthshine::LitEarth;
use streakcast::photometry::panels::{Face, PanelAssembly, PanelsSpec, PlacedRectangle};
use streakcast::photometry::{
    BrightnessModel, Coefficients, ModelLibrary, PhotometryOptions, SatelliteModel, SatelliteShape,
};

/// Returns a model file of kind `panels` with this content.
pub fn file(panels: Value, covariance: Value) -> String {
    json!({
        "schema": 1, "name": "own", "title": "Own", "kind": "panels", "band": "V", "mag_system": "Vega", "size_m": 4.0,
        "panels": panels, "covariance": covariance, "rms_mag": null, "sigma_mag": 0.3, 
        "sigma_origin": "assumed", "geometry_range": null,
        "provenance": {"source": "a test", "data": "none", "n_points": null, "date": "2026", "provisional": true, "notes": []}
    })
    .to_string()
}

/// Returns the satellite of the paper as a list of panels.
fn chassis_and_sail(shape: &SatelliteShape) -> Value {
    let half = |width: f64| json!([-0.5 * width, 0.5 * width]);
    json!({
        "parameters": [
            {"name": "c1", "value": 0.1}, {"name": "c2", "value": 0.03}, {"name": "c3", "value": 0.005},
            {"name": "c4", "value": 0.2}, {"name": "c5", "value": 0.08}, {"name": "n_sail", "value": 5.0},
            {"name": "n_base", "value": 22.0}
        ],
        "panels": [
            {"name": "sail", "anchor_m": [0, 0, 0], "u_m": half(shape.sail_width_m), "v_m": [0, shape.sail_length_m],
             "attitude": {"law": "sun_azimuth", "offset_deg": shape.panel_offset_deg},
             "front": [{"law": "phong", "weight": "c1", "exponent": "n_sail"}, {"law": "lambert", "albedo": "c2"}],
             "through": [{"law": "lambert", "albedo": "c3"}]},
            {"name": "chassis", "anchor_m": [0, 0, 0], "u_m": half(shape.base_width_m), "v_m": [0, shape.base_length_m],
             "attitude": {"law": "nadir"},
             "front": [{"law": "phong", "weight": "c4", "exponent": "n_base"}, {"law": "lambert", "albedo": "c5"}]}
        ],
        "blocking": [{"panel": "sail", "by": "chassis"}]
    })
}

fn coefficients() -> Coefficients {
    Coefficients { c1: 0.1, c2: 0.03, c3: 0.005, c4: 0.2, c5: 0.08, n_sail: 5.0, n_base: 22.0 }
}

/// Returns a direction of the Sun in the half plane of azimuth 0, and any direction of the observer.
fn directions(random: &mut Random) -> (Vector3<f64>, Vector3<f64>) {
    let sun: f64 = random.between(-1.5, 1.5);
    (Vector3::new(sun.cos(), 0.0, sun.sin()), random.direction())
}

/// For any directions of Sun and observer and any panel offset, the light of each term and the blocked fraction of a
/// list of panels agree with the closed form to 1e-9. If the Sun or the observer is above the plane of the chassis, the
/// list of panels is more accurate (the back of the sail is not hidden, and the chassis is dark).
#[test]
fn verif_panels_equal_the_closed_form_of_chassis_and_sail() {
    let mut random = Random(3);
    let mut compared = 0;
    for _ in 0..40 {
        let shape = SatelliteShape {
            sail_length_m: random.between(1.0, 15.0),
            sail_width_m: random.between(0.5, 6.0),
            base_length_m: random.between(0.5, 6.0),
            base_width_m: random.between(0.5, 6.0),
            panel_offset_deg: random.between(-30.0, 30.0),
        };
        let closed = SatelliteModel::new(&shape, &coefficients()).unwrap();
        let model = BrightnessModel::from_json(&file(chassis_and_sail(&shape), Value::Null), "own").unwrap();
        let panels = model.assembly().unwrap();
        for _ in 0..500 {
            let (to_sun, to_observer) = directions(&mut random);
            let terms = closed.terms_of_directions(&to_sun, &to_observer);
            let parts = panels.parts(&to_sun, &to_observer);
            let of = |panel: usize, face: Face, law: usize| {
                let found = parts.iter().find(|part| (part.panel, part.face, part.law) == (panel, face, law));
                found.map_or(0.0, |part| part.m2_sr)
            };
            let pairs = [
                (terms.sail_glossy_m2_sr, of(0, Face::Front, 0)),
                (terms.sail_diffuse_m2_sr, of(0, Face::Front, 1)),
                (terms.sail_back_m2_sr, of(0, Face::Through, 0)),
                (terms.base_glossy_m2_sr, of(1, Face::Front, 0)),
                (terms.base_diffuse_m2_sr, of(1, Face::Front, 1)),
            ];
            for (closed, open) in pairs {
                assert!((closed - open).abs() < 1e-9, "{closed} {open} at {to_sun:?} {to_observer:?} {shape:?}");
            }
            compared += usize::from(terms.blocked.shadow_or_hidden > 0.0 && terms.blocked.shadow_or_hidden < 1.0);
        }
    }
    assert!(compared > 4000, "{compared} geometries were partly blocked");
}

/// Returns true if a ray from a point of a rectangle in a direction hits another rectangle.
fn meets(from: &Vector3<f64>, direction: &Vector3<f64>, other: &PlacedRectangle) -> bool {
    let along = other.axes.normal.dot(direction);
    let t = other.axes.normal.dot(&(other.anchor_m - from)) / along;
    let place = from + direction * t - other.anchor_m;
    let (u, v) = (place.dot(&other.axes.u), place.dot(&other.axes.v));
    along.abs() > 1e-12
        && t > 1e-9
        && (other.u_m[0]..=other.u_m[1]).contains(&u)
        && (other.v_m[0]..=other.v_m[1]).contains(&v)
}

/// Random satellites of four panels at random angles, all in front of the first: the exact fraction compared with a
/// grid of 100 x 100 rays to Sun and observer. The error of such a grid is the length of the borders in cells: 0.02 for
/// six borders.
#[test]
fn valid_obstruction_of_random_panels_against_rays_cast_one_by_one() {
    const GRID: usize = 100;
    let mut random = Random(11);
    let (mut partly, mut worst) = (0, 0.0_f64);
    for _ in 0..300 {
        let mut panels = Vec::new();
        for name in ["a", "b", "c", "d"] {
            let normal = random.direction();
            let v = normal.cross(&random.direction()).normalize();
            let spread = if name == "a" { 0.0 } else { 3.0 };
            let place: Vec<f64> = (0..3).map(|_| random.between(-spread, spread)).collect();
            panels.push(json!({
                "name": name, "anchor_m": place,
                "u_m": [-random.between(0.5, 3.0), random.between(0.5, 3.0)],
                "v_m": [-random.between(0.5, 3.0), random.between(0.5, 3.0)],
                "attitude": {"law": "fixed", "normal": normal.as_slice(), "v": v.as_slice()},
                "front": [{"law": "lambert", "albedo": 0.1}]
            }));
        }
        let blocking: Vec<Value> = ["b", "c", "d"].iter().map(|by| json!({"panel": "a", "by": by})).collect();
        let spec = json!({"parameters": [], "panels": panels, "blocking": blocking});
        let model = BrightnessModel::from_json(&file(spec, Value::Null), "own").unwrap();
        let assembly = model.assembly().unwrap();
        let (to_sun, to_observer) = directions(&mut random);
        let placed = assembly.placed(&to_sun);
        let a = &placed[0];
        let cell = |range: [f64; 2], n: usize| range[0] + (range[1] - range[0]) * (n as f64 + 0.5) / GRID as f64;
        let mut stopped = 0;
        for i in 0..GRID * GRID {
            let point = a.anchor_m + a.axes.u * cell(a.u_m, i / GRID) + a.axes.v * cell(a.v_m, i % GRID);
            let lost =
                placed[1..].iter().any(|other| meets(&point, &to_sun, other) || meets(&point, &to_observer, other));
            stopped += usize::from(lost);
        }
        let cast = stopped as f64 / (GRID * GRID) as f64;
        let exact = assembly.blocked(0, &to_sun, &to_observer);
        partly += usize::from(cast > 0.02 && cast < 0.98);
        worst = worst.max((cast - exact).abs());
        assert!((cast - exact).abs() < 0.02, "{cast} cast, {exact} exact");
    }
    assert!(partly > 100, "{partly} partly blocked, worst difference {worst}");
}

#[test]
fn verif_invalid_panels_are_rejected_with_key_and_allowed_values() {
    let shape = SatelliteShape {
        sail_length_m: 8.1,
        sail_width_m: 2.8,
        base_length_m: 1.3,
        base_width_m: 2.8,
        panel_offset_deg: 0.0,
    };
    let good = chassis_and_sail(&shape);
    assert!(BrightnessModel::from_json(&file(good.clone(), Value::Null), "own").is_ok());
    let error_of = |change: &dyn Fn(&mut Value)| {
        let mut spec = good.clone();
        change(&mut spec);
        BrightnessModel::from_json(&file(spec, Value::Null), "own.json").unwrap_err().to_string()
    };
    type Case<'a> = (&'a dyn Fn(&mut Value), &'a [&'a str]);
    let cases: &[Case] = &[
        (&|s| s["panels"][0]["v_m"] = json!([0, -8.1]), &["panels.sail.v_m[1]", "-8.1"]),
        (&|s| s["panels"][0]["front"][0]["law"] = json!("mirror"), &["mirror", "phong"]),
        (
            &|s| s["panels"][0]["front"][0]["exponent"] = json!(1e9),
            &["panels.sail.front.exponent", "1000000000", "10000"],
        ),
        (&|s| s["panels"][0]["front"][0]["exponent"] = json!("n_mast"), &["n_mast", "n_sail"]),
        (&|s| s["panels"][0]["front"][0]["exponent"] = Value::Null, &["a number or the name of a parameter"]),
        (
            &|s| {
                s["panels"][0]["front"][0].as_object_mut().unwrap().remove("exponent");
            },
            &["exponent"],
        ),
        (&|s| s["panels"][0]["front"][1]["colour"] = json!(1), &["colour"]),
        (
            &|s| s["panels"][0]["front"][1] = json!({"law": "facets", "weight": "c2", "slope": 0}),
            &["panels.sail.front.slope", "0.001", "1"],
        ),
        (
            &|s| s["panels"][0]["through"][0] = json!({"law": "straight", "weight": 11, "exponent": 2}),
            &["weight", "11"],
        ),
        (&|s| s["panels"][0]["front"][1] = json!({"law": "retro", "albedo": "c2", "exponent": 2}), &["albedo"]),
        (&|s| s["panels"][1]["name"] = json!("sail"), &["sail", "unique names"]),
        (
            &|s| s["panels"][0]["attitude"] = json!({"law": "fixed", "normal": [0, 0, 1], "v": [0, 1, 1]}),
            &["attitude.v"],
        ),
        (&|s| s["panels"][0]["attitude"]["offset_deg"] = json!([[0, 1], [-5, 2]]), &["Sun's latitude", "-5"]),
        (&|s| s["blocking"][0]["by"] = json!("mast"), &["mast", "sail, chassis"]),
        (&|s| s["blocking"][0]["by"] = json!("sail"), &["a panel other than"]),
        (&|s| s["panels"] = json!([]), &["panels.panels: number", "1 to 32"]),
        (&|s| s["parameters"][0]["name"] = json!("unused"), &["c1", "a number or one of"]),
        (
            &|s| s["parameters"].as_array_mut().unwrap().push(json!({"name": "spare", "value": 1})),
            &["spare", "used by a law"],
        ),
        (
            &|s| {
                s["conserves_energy"] = json!(true);
                s["parameters"][1]["value"] = json!(0.95)
            },
            &["reflected fraction", "sail"],
        ),
        (
            // Directly transmitted light is included.
            &|s| {
                s["conserves_energy"] = json!(true);
                s["panels"][0]["through"][0] = json!({"law": "straight", "weight": 0.95, "exponent": 30});
                s["parameters"].as_array_mut().unwrap().retain(|parameter| parameter["name"] != "c3");
            },
            &["reflected fraction", "sail"],
        ),
    ];
    for (change, words) in cases {
        let error = error_of(*change);
        assert!(words.iter().all(|word| error.contains(word)), "{error} lacks one of {words:?}");
        assert!(error.starts_with("model file own.json"), "{error}");
    }
    // The reflectance of one face may be given if the law is valid for one face.
    let mut held = good.clone();
    held["conserves_energy"] = json!(true);
    assert!(BrightnessModel::from_json(&file(held, Value::Null), "own").is_ok());
    let short = BrightnessModel::from_json(&file(good, json!([[1.0]])), "own").unwrap_err().to_string();
    assert!(short.contains("7 x 7"), "{short}");
}

/// Geometry without coefficients and laws without geometry together give the light of the paper's satellite.
#[test]
fn verif_lit_faces_and_laws_add_up_to_the_whole() {
    let shape = SatelliteShape {
        sail_length_m: 8.1,
        sail_width_m: 2.8,
        base_length_m: 1.3,
        base_width_m: 2.8,
        panel_offset_deg: 5.0,
    };
    let mut content = chassis_and_sail(&shape);
    content["panels"][1]["back"] = json!([{"law": "abg", "a": 0.01, "b": 0.1, "g": 1.5}]);
    let spec: PanelsSpec = serde_json::from_value(content).unwrap();
    let moved_values = [0.3, 0.01, 0.02, 0.1, 0.2, 9.0, 40.0];
    let (start, moved) = (spec.assemble(&[]), spec.assemble(&moved_values));
    let mut random = Random(17);
    let mut faces_seen = [0; 3];
    for _ in 0..3000 {
        let (to_sun, to_observer) = directions(&mut random);
        let lit = start.lit_faces(&to_sun, &to_observer);
        assert_eq!(lit, moved.lit_faces(&to_sun, &to_observer));
        // Geometry of one satellite with the laws of the other satellite.
        let sum: f64 = lit
            .iter()
            .flat_map(|lit| {
                moved.laws(lit.panel, lit.face).iter().map(|law| law.value_per_sr(&lit.incidence) * lit.open_m2)
            })
            .sum();
        let whole = moved.b_total_m2_sr(&to_sun, &to_observer);
        assert!((sum - whole).abs() <= 1e-14 * whole, "{sum} {whole}");
        for lit in lit {
            faces_seen[lit.face as usize] += 1;
            let area_m2 = start.placed(&to_sun)[lit.panel].area_m2();
            let projection = (lit.incidence.cos_in * lit.incidence.cos_out).abs();
            assert!((lit.open_m2 - projection * area_m2 * (1.0 - lit.blocked)).abs() < 1e-13);
            assert_eq!(lit.blocked, start.blocked(lit.panel, &to_sun, &to_observer));
        }
    }
    assert!(faces_seen.iter().all(|seen| *seen > 300), "{faces_seen:?}");
    assert!(start.laws(7, Face::Front).is_empty());
}

#[test]
fn verif_ranges_and_proportions_of_parameters() {
    let spec: PanelsSpec = serde_json::from_value(json!({
        "parameters": [
            {"name": "shared", "value": 0.6}, {"name": "shine", "value": 0.1}, {"name": "n", "value": 300},
            {"name": "a", "value": 1}, {"name": "b", "value": 1}, {"name": "g", "value": 1},
            {"name": "peak", "value": 1}, {"name": "width", "value": 1}, {"name": "lost", "value": 1}, {"name": "slope", "value": 1}
        ],
        "panels": [{
            "name": "plate", "anchor_m": [0, 0, 0], "u_m": [0, 1], "v_m": [0, 1], "attitude": {"law": "nadir"},
            "front": [{"law": "lambert", "albedo": "shine"}, {"law": "phong", "weight": "shine", "exponent": "n"}],
            "back": [{"law": "abg", "a": "a", "b": "b", "g": "g"},
                     {"law": "gaussian", "peak_per_sr": "peak", "width": "width"}],
            "through": [{"law": "straight", "weight": "shared", "exponent": "shared"},
                        {"law": "facets", "weight": "lost", "slope": "slope"}]
        }]
    }))
    .unwrap();
    // A parameter used as weight and as exponent has the range common to both; light is then not proportional to it.
    let expected = [
        ([0.5, 1.0], false),
        ([0.0, 1.0], true),
        ([0.5, 200.0], false),
        ([0.0, 100.0], true),
        ([1e-6, 10.0], false),
        ([0.1, 6.0], false),
        ([0.0, 1e3], true),
        ([1e-3, 2.0], false),
        ([0.0, 1.0], true),
        ([2e-3, 0.6], false),
    ];
    let ranges = spec.ranges();
    assert_eq!(ranges.len(), expected.len());
    for (place, (range, linear)) in expected.into_iter().enumerate() {
        assert_eq!((ranges[place], spec.is_linear(place)), (range, linear), "{}", spec.parameters[place].name);
    }
    assert!(!spec.is_linear(expected.len()));
}

/// Rough mirrors agree with those rendered by Mitsuba.
#[test]
fn valid_facets_against_mitsuba() {
    /// Relative tolerance: two masking factors, each a rational fit with an error of 0.35 %.
    const MASKING_FIT: f64 = 0.0071;
    let unit = |zenith_deg: f64, azimuth_deg: f64| {
        let (zenith, azimuth) = (zenith_deg.to_radians(), azimuth_deg.to_radians());
        Vector3::new(zenith.sin() * azimuth.cos(), zenith.sin() * azimuth.sin(), zenith.cos())
    };
    let rows = include_str!("../data/facets_golden.csv").lines().skip(2);
    let mut compared = 0;
    let mut light = Agreement::new("Reflection by rough facets", "Mitsuba 3", MASKING_FIT, "of the light");
    for row in rows {
        let numbers: Vec<f64> = row.split(',').map(|cell| cell.parse().unwrap()).collect();
        let [slope, zenith_in, zenith_out, azimuth, per_sr] = numbers[..] else { panic!("{row}") };
        let incidence = Incidence::new(&Vector3::z(), &unit(zenith_in, 0.0), &unit(zenith_out, azimuth));
        let computed = Facets { weight: 1.0, slope }.value_per_sr(&incidence);
        light.add(computed / per_sr - 1.0);
        compared += 1;
    }
    assert!(compared > 250, "{compared}");
}

/// The quadrature over the Earth is fine enough for the lobes of facets and retroreflection: the nodes for the exponent
/// of the law are compared with several times as many nodes in each direction.
#[test]
fn verif_earthshine_by_new_lobes() {
    let laws = [
        Law::Facets(Facets { weight: 1.0, slope: 0.04 }),
        Law::Facets(Facets { weight: 1.0, slope: 0.1 }),
        Law::Facets(Facets { weight: 1.0, slope: 0.3 }),
        Law::Retro(Retro { weight: 1.0, exponent: 3.0 }),
        Law::Retro(Retro { weight: 1.0, exponent: 80.0 }),
    ];
    /// Exponent for which the quadrature has at least 2.5 times the nodes that the laws require.
    const FINE_EXPONENT: f64 = 1000.0;
    let normal = -Vector3::z();
    let mut worst = [0.0_f64; 2];
    for (place, law) in laws.iter().enumerate() {
        for sun_latitude in [-0.3, -0.1, 0.2, 0.9] {
            let earth = LitEarth::new(sun_latitude, 550.0).unwrap();
            let coarse = earth.sources(law.equivalent_exponent());
            let fine = earth.sources(FINE_EXPONENT);
            for nadir_deg in [0.0_f64, 20.0, 45.0, 62.0] {
                for azimuth in [0.0_f64, 1.0, 2.5] {
                    let (sin, cos) = nadir_deg.to_radians().sin_cos();
                    let to_observer = Vector3::new(sin * azimuth.cos(), sin * azimuth.sin(), -cos);
                    let light = |sources: &[(Vector3<f64>, f64)]| -> f64 {
                        let of_source = |(to_source, irradiance): &(Vector3<f64>, f64)| {
                            let incidence = Incidence::new(&normal, to_source, &to_observer);
                            4.0 * irradiance * law.value_per_sr(&incidence) * incidence.front()
                        };
                        sources.iter().map(of_source).sum()
                    };
                    // Relative to the maximum light of the same panel, because lobes that do not reach lit ground are
                    // dark.
                    let off = (light(&coarse) - light(&fine)).abs() / light(&fine).max(0.01);
                    // The lobe of the first panel is narrower than the quadrature allows for, especially for grazing
                    // views.
                    let slant = usize::from(nadir_deg > 60.0 && place == 0);
                    worst[slant] = worst[slant].max(off);
                }
            }
        }
    }
    assert!(worst[0] < 2e-3 && worst[1] < 0.05, "{worst:?}");
}

/// Spheres in addition to panels: their light is added and can be separated again. Writing and reading the file gives
/// the same model.
#[test]
fn verif_spheres_add_to_the_panels() {
    let shape = SatelliteShape {
        sail_length_m: 8.1,
        sail_width_m: 2.8,
        base_length_m: 1.3,
        base_width_m: 2.8,
        panel_offset_deg: 0.0,
    };
    let bare: PanelsSpec = serde_json::from_value(chassis_and_sail(&shape)).unwrap();
    assert!(bare.spheres.is_empty());
    let mut content = chassis_and_sail(&shape);
    content["parameters"].as_array_mut().unwrap().push(json!({"name": "clutter", "value": 0.3}));
    content["spheres"] = json!([
        {"name": "antennas", "area_m2": 0.5, "albedo": "clutter", "phase": "lambert"},
        {"name": "radiator", "area_m2": 0.2, "albedo": 0.8, "phase": "isotropic"}
    ]);
    let model = BrightnessModel::from_json(&file(content.clone(), Value::Null), "own").unwrap();
    let spec = model.file().unwrap().panels.clone().unwrap();
    let again: PanelsSpec = serde_json::from_str(&serde_json::to_string(&spec).unwrap()).unwrap();
    assert_eq!((&spec, spec.spheres.len()), (&again, 2));
    let clutter = spec.parameters.len() - 1;
    assert!(spec.is_linear(clutter));
    assert_eq!(spec.ranges()[clutter], [0.0, 1.0]);

    let (with, without) = (model.assembly().unwrap(), bare.assemble(&[]));
    let mut moved_values: Vec<f64> = spec.parameters.iter().map(|parameter| parameter.value).collect();
    moved_values[clutter] *= 2.0;
    let moved = spec.assemble(&moved_values);
    let mut random = Random(23);
    for _ in 0..300 {
        let (to_sun, to_observer) = directions(&mut random);
        let phase = to_sun.angle(&to_observer);
        let parts: Vec<f64> = with.sphere_parts(&to_sun, &to_observer).collect();
        // B = c A 2/(3π²) (sin φ + (π - φ) cos φ), and c A / 4π
        let ball = 0.3 * 0.5 * 2.0 / (3.0 * PI * PI) * (phase.sin() + (PI - phase) * phase.cos());
        assert!((parts[0] - ball).abs() < 1e-9 && (parts[1] - 0.2 * 0.8 / (4.0 * PI)).abs() < 1e-15);
        let by_hand: Vec<f64> = with.spheres().iter().map(|sphere| sphere.m2_sr(phase)).collect();
        assert!(parts.iter().zip(by_hand).all(|(part, by_hand)| (part - by_hand).abs() < 1e-9));
        let total = |of: &PanelAssembly| of.b_total_m2_sr(&to_sun, &to_observer);
        assert!((total(with) - total(&without) - parts[0] - parts[1]).abs() < 1e-13);
        assert!((total(&moved) - total(with) - parts[0]).abs() < 1e-13);
    }
    let geometry = ViewingGeometry {
        sun_latitude_rad: 0.1,
        observer_longitude_rad: 0.5,
        observer_latitude_rad: -0.9,
        range_km: 700.0,
        height_km: 550.0,
        sun_distance_au: 1.0,
    };
    assert_eq!(with.earthshine_m2_sr(&geometry), without.earthshine_m2_sr(&geometry));

    let error_of = |change: &dyn Fn(&mut Value)| {
        let mut content = content.clone();
        change(&mut content);
        BrightnessModel::from_json(&file(content, Value::Null), "own.json").unwrap_err().to_string()
    };
    type Case<'a> = (&'a dyn Fn(&mut Value), &'a [&'a str]);
    let cases: &[Case] = &[
        (&|s| s["spheres"][0]["area_m2"] = json!(0), &["panels.spheres.antennas.area_m2", "0.0001"]),
        (&|s| s["spheres"][0]["albedo"] = json!("mast"), &["panels.spheres.antennas.albedo", "mast", "clutter"]),
        (&|s| s["spheres"][1]["albedo"] = json!(-0.1), &["panels.spheres.radiator.albedo", "-0.1"]),
        (&|s| s["spheres"][0]["phase"] = json!("phong"), &["phong", "isotropic"]),
        (&|s| s["spheres"][0]["radius_m"] = json!(1), &["radius_m"]),
        (&|s| s["spheres"][1]["name"] = json!("antennas"), &["antennas", "unique names"]),
        (&|s| s["spheres"][0]["albedo"] = json!(0.3), &["clutter", "a law or a sphere"]),
        (
            &|s| {
                s["conserves_energy"] = json!(true);
                s["spheres"][1]["albedo"] = json!(1.5);
            },
            &["panels.spheres.radiator: reflected fraction", "1.5"],
        ),
    ];
    for (change, words) in cases {
        let error = error_of(*change);
        assert!(words.iter().all(|word| error.contains(word)), "{error} lacks one of {words:?}");
    }
}

/// Sunlit satellites that are seen or lit from above, as by a telescope in orbit, have a magnitude of at most 10.5 at
/// 1000 km, with a sigma of at least 1.5 mag where it is that of a diffuse body. Geometries of the ground are those of
/// the panels alone.
#[test]
fn verif_no_lit_satellite_is_dark_from_above() {
    let library = ModelLibrary::embedded();
    let options = PhotometryOptions::default();
    for name in ["starlink-v1.5-facets", "visorsat-panels", "v2mini-panels", "oneweb-panels", "iridium-next"] {
        let model = library.find(name).unwrap();
        let (mut diffuse, mut panels) = (0, 0);
        for sun_deg in (-30..=60).step_by(5) {
            for observer_deg in (-85..=85).step_by(10) {
                for longitude_deg in (0..=180).step_by(20) {
                    let geometry = ViewingGeometry {
                        sun_latitude_rad: f64::from(sun_deg).to_radians(),
                        observer_latitude_rad: f64::from(observer_deg).to_radians(),
                        observer_longitude_rad: f64::from(longitude_deg).to_radians(),
                        range_km: 1000.0,
                        height_km: 550.0,
                        sun_distance_au: 1.0,
                    };
                    // Opposite to the Sun there is no light.
                    if geometry.phase_angle_rad() > 179_f64.to_radians() {
                        continue;
                    }
                    let place = format!("{name} {sun_deg} {observer_deg} {longitude_deg}");
                    let light = model.brightness(&geometry, 1.0, &options).expect(&place);
                    let is_above = sun_deg >= 5 || observer_deg >= 5;
                    if is_above && geometry.phase_angle_rad() < 150_f64.to_radians() {
                        assert!(light.magnitude.0 < 10.5, "{place}: {}", light.magnitude.0);
                    }
                    if light.source.to_string().ends_with("(diffuse body)") {
                        diffuse += 1;
                        assert!(light.sigma_mag >= 1.5 && !light.in_fitted_range, "{place}");
                    } else {
                        panels += 1;
                        let pure = model.standard_magnitude_with(&geometry, options.earthshine).expect(&place);
                        assert!((light.magnitude.0 - pure.0).abs() < 1e-9, "{place}");
                    }
                }
            }
        }
        assert!(diffuse > 100 && panels > 100, "{name}: {diffuse} {panels}");
    }
}
