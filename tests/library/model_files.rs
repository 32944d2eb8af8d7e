//! Bundled model files and their JSON Schema, and errors for invalid files.

use serde_json::{Value, json};
use streakcast::photometry::{BrightnessModel, ModelFile, ModelLibrary};

const SCHEMA: &str = include_str!("../../src/photometry/models/model.schema.json");

/// Checks a value against the JSON Schema keywords that the schema uses; other keywords are an error.
fn check(value: &Value, schema: &Value, root: &Value, path: &str) -> Result<(), String> {
    let fail = |what: String| Err(format!("{path}: {what}"));
    for (keyword, rule) in schema.as_object().ok_or("a schema is an object")? {
        match keyword.as_str() {
            "$schema" | "$id" | "$defs" | "title" | "description" => {}
            "$ref" => {
                let name = rule.as_str().unwrap_or("").strip_prefix("#/$defs/").ok_or("a $ref into $defs")?;
                check(value, &root["$defs"][name], root, path)?;
            }
            "type" => {
                let is = |name: &str| match name {
                    "object" => value.is_object(),
                    "array" => value.is_array(),
                    "string" => value.is_string(),
                    "number" => value.is_number(),
                    "integer" => value.is_u64() || value.is_i64(),
                    "boolean" => value.is_boolean(),
                    "null" => value.is_null(),
                    _ => false,
                };
                let names: Vec<&str> = rule.as_array().map_or_else(
                    || rule.as_str().into_iter().collect(),
                    |a| a.iter().filter_map(Value::as_str).collect(),
                );
                if !names.iter().any(|name| is(name)) {
                    return fail(format!("{value} is none of {names:?}"));
                }
            }
            "oneOf" => {
                let branches = rule.as_array().ok_or("oneOf is a list")?;
                let met = branches.iter().filter(|branch| check(value, branch, root, path).is_ok()).count();
                if met != 1 {
                    return fail(format!("{value} meets {met} of {} alternatives", branches.len()));
                }
            }
            "enum" => {
                if !rule.as_array().is_some_and(|allowed| allowed.contains(value)) {
                    return fail(format!("{value} is not in {rule}"));
                }
            }
            "minimum" | "maximum" => {
                if let (Some(x), Some(bound)) = (value.as_f64(), rule.as_f64())
                    && ((keyword == "minimum" && x < bound) || (keyword == "maximum" && x > bound))
                {
                    return fail(format!("{x} against {keyword} {bound}"));
                }
            }
            "minLength" | "maxLength" | "minItems" | "maxItems" => {
                let len = value.as_str().map(|s| s.chars().count()).or_else(|| value.as_array().map(Vec::len));
                if let (Some(len), Some(bound)) = (len, rule.as_u64())
                    && ((keyword.starts_with("min") && (len as u64) < bound)
                        || (keyword.starts_with("max") && len as u64 > bound))
                {
                    return fail(format!("length {len} against {keyword} {bound}"));
                }
            }
            "pattern" => {
                assert_eq!(rule, "^[a-z0-9.-]+$", "the one pattern that is known here");
                let text = value.as_str().unwrap_or("");
                let good = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || ".-".contains(c);
                if text.is_empty() || !text.chars().all(good) {
                    return fail(format!("{text:?} against {rule}"));
                }
            }
            "items" => {
                for (i, item) in value.as_array().into_iter().flatten().enumerate() {
                    check(item, rule, root, &format!("{path}[{i}]"))?;
                }
            }
            "required" => {
                if let Some(object) = value.as_object() {
                    for key in rule.as_array().into_iter().flatten().filter_map(Value::as_str) {
                        if !object.contains_key(key) {
                            return fail(format!("{key} is missing"));
                        }
                    }
                }
            }
            "properties" => {
                for (key, inner) in value.as_object().into_iter().flatten() {
                    if let Some(inner_schema) = rule.get(key) {
                        check(inner, inner_schema, root, &format!("{path}.{key}"))?;
                    }
                }
            }
            "additionalProperties" => {
                assert_eq!(rule, &json!(false));
                for key in value.as_object().into_iter().flatten().map(|(key, _)| key) {
                    if schema["properties"].get(key).is_none() {
                        return fail(format!("{key} is not known"));
                    }
                }
            }
            other => return Err(format!("keyword {other} is not known to this test")),
        }
    }
    Ok(())
}

fn schema_check(value: &Value) -> Result<(), String> {
    let schema: Value = serde_json::from_str(SCHEMA).unwrap();
    check(value, &schema, &schema, "model")
}

fn shipped(file: &str) -> &'static str {
    ModelLibrary::shipped_files().iter().find(|(name, _)| *name == file).unwrap().1
}

#[test]
fn verif_bundled_files_are_valid() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("src/photometry/models");
    let mut on_disk: Vec<String> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .filter(|name| name.ends_with(".json") && !name.ends_with(".schema.json"))
        .collect();
    on_disk.sort();
    let mut listed: Vec<&str> = ModelLibrary::shipped_files().iter().map(|(name, _)| *name).collect();
    listed.sort_unstable();
    assert_eq!(on_disk, listed, "every file in the folder is shipped");
    let library = ModelLibrary::embedded();
    assert_eq!(library.names().count(), listed.len());
    for (file, text) in ModelLibrary::shipped_files() {
        schema_check(&serde_json::from_str(text).unwrap()).unwrap_or_else(|error| panic!("{file}: {error}"));
        let model = BrightnessModel::from_json(text, file).unwrap_or_else(|error| panic!("{error}"));
        let content = model.file().unwrap();
        assert_eq!(format!("{}.json", content.name), *file, "a file is named after its model");
        // The printed file is valid and gives the same model.
        let printed = content.to_json();
        assert_eq!(&ModelFile::from_json(&printed, file).unwrap(), content);
        schema_check(&serde_json::from_str(&printed).unwrap()).unwrap();
        for name in std::iter::once(&content.name).chain(&content.aliases) {
            assert_eq!(library.get(&name.to_uppercase()).unwrap().file(), Some(content), "{name}");
        }
    }
    assert!(library.get("no-such-model").is_none());
}

#[test]
fn verif_the_metadata_of_the_v15_model() {
    let value: Value = serde_json::from_str(shipped("starlink-v1.5.json")).unwrap();
    let c = &value["coefficients"];
    for (key, expected) in
        [("c1", 0.0), ("c2", 0.030635), ("c3", 0.00472185), ("c4", 0.155253), ("c5", 0.0875597), ("n_base", 27.9225)]
    {
        assert_eq!(c[key].as_f64(), Some(expected), "{key}");
    }
    // Fixed parameters have no error; the others have one.
    for (index, is_held) in [true, false, false, false, false, true, false].into_iter().enumerate() {
        assert_eq!(value["covariance"][index][index].as_f64() == Some(0.0), is_held, "{index}");
    }
    // The sigma contains 68.3 %; the RMS includes the wings.
    assert_eq!([&value["rms_mag"], &value["sigma_mag"]].map(Value::as_f64), [Some(0.528), Some(0.394)]);
    assert_eq!(value["provenance"]["provisional"], json!(false));
}

#[test]
fn verif_names_that_catalogues_use_are_known() {
    let library = ModelLibrary::embedded();
    let names = "starlink-v1.5 visorsat starlink-v1.0 starlink-v0.9 v2mini direct-to-cell oneweb kuiper qianfan guowang \
                 bluebird rocket-body unknown";
    for name in names.split_whitespace() {
        assert!(library.get(name).is_some(), "{name}");
    }
    assert_eq!(library.unknown().unwrap().source().to_string(), "prior");
    assert_eq!(library.get("oneweb").unwrap().source().to_string(), "prior:oneweb");
}

/// Returns a bundled file of kind brdf with one change.
fn changed_file(change: impl Fn(&mut Value)) -> String {
    let mut value: Value = serde_json::from_str(shipped("starlink-v1.5.json")).unwrap();
    change(&mut value);
    value.to_string()
}

#[test]
fn verif_invalid_files_give_one_clear_error() {
    type Change = fn(&mut Value);
    let cases: &[(Change, &[&str])] = &[
        (|v| v["coefficients"]["n_base"] = json!(1e9), &["coefficients.n_base", "1000000000", "0 to 10000"]),
        (|v| v["coefficients"]["c4"] = json!(-0.1), &["coefficients.c4", "-0.1", "0 to 10"]),
        (|v| v["shape"]["sail_width_m"] = json!(-2.8), &["shape.sail_width_m", "-2.8", "0.01 to 200"]),
        (|v| v["shape"]["panel_offset_deg"] = json!(88.0), &["shape.panel_offset_deg", "-60 to 60"]),
        (|v| drop(v["coefficients"].as_object_mut().unwrap().remove("c3")), &["line ", "missing key 'c3'"]),
        (|v| v["coefficients"]["c6"] = json!(1.0), &["unknown key 'c6'", "allowed: c1, c2"]),
        (|v| v["coefficients"]["c2"] = json!(null), &["invalid value null", "allowed: a number"]),
        (|v| v["coefficients"]["c2"] = json!("0.1"), &["invalid value \"0.1\"", "allowed: a number"]),
        (|v| v["kind"] = json!("three_panel"), &["unknown value 'three_panel'", "two_panel"]),
        (|v| drop(v.as_object_mut().unwrap().remove("shape")), &["kind two_panel requires the key \"shape\""]),
        (|v| v["mean_mag"] = json!(6.0), &["kind two_panel does not use the key \"mean_mag\""]),
        (|v| v["schema"] = json!(2), &["schema is 2; allowed: 1"]),
        (|v| v["band"] = json!("W"), &["band is \"W\"", "allowed: B V R"]),
        (|v| v["mag_system"] = json!("ST"), &["mag_system", "Vega or AB"]),
        (|v| v["name"] = json!("My Model"), &["name is \"My Model\"", "lower-case"]),
        (|v| v["geometry_range"]["sun_latitude_deg"] = json!([-5, -23]), &["sun_latitude_deg[1] is -23", "-5 to 90"]),
        (|v| v["covariance"] = json!([[1.0]]), &["covariance", "7 x 7", "1 rows"]),
        (|v| v["provenance"]["source"] = json!("  "), &["provenance.source"]),
    ];
    for (change, words) in cases {
        let error = BrightnessModel::from_json(&changed_file(change), "mine.json").unwrap_err().to_string();
        assert!(error.starts_with("model file mine.json: ") && !error.contains('\n'), "{error}");
        for word in *words {
            assert!(error.contains(word), "{error:?} should contain {word:?}");
        }
    }
    // NaN is not valid JSON. A number that is too large is also an error.
    for text in [
        "",
        "{",
        "[1]",
        &changed_file(|_| {}).replace("0.030635", "NaN"),
        &changed_file(|_| {}).replace("0.030635", "1e999"),
    ] {
        assert!(
            BrightnessModel::from_json(text, "x").is_err_and(|error| error.to_string().contains("model file x: ")),
            "{text}"
        );
    }
}

#[test]
fn verif_covariances_must_be_symmetric() {
    let good: Vec<Vec<f64>> = (0..7).map(|i| (0..7).map(|j| if i == j { 1e-4 } else { 1e-6 }).collect()).collect();
    let with =
        |matrix: &[Vec<f64>]| ModelFile::from_json(&changed_file(|v| v["covariance"] = json!(matrix)), "mine.json");
    assert_eq!(with(&good).unwrap().covariance.unwrap()[3][2], 1e-6);
    let mut lopsided = good.clone();
    lopsided[1][4] = 2e-6;
    assert!(with(&lopsided).unwrap_err().to_string().contains("[1][4]"));
    let mut negative = good;
    negative[2][2] = -1.0;
    assert!(with(&negative).unwrap_err().to_string().contains("[2][2]"));
}

#[test]
fn verif_a_user_model_replaces_a_bundled_one() {
    let mut library = ModelLibrary::embedded();
    let before = library.names().count();
    let own = changed_file(|v| {
        v["name"] = json!("my-sat");
        v["aliases"] = json!(["mine"]);
    });
    assert_eq!(library.add_json(&own, "my.json").unwrap(), "my-sat");
    assert_eq!(library.get("mine").unwrap().source().to_string(), "brdf:my-sat");
    let replaced = changed_file(|v| v["coefficients"]["c5"] = json!(0.2));
    library.add_json(&replaced, "v15.json").unwrap();
    assert_eq!(library.names().count(), before + 1);
    assert_eq!(library.get("v1.5").unwrap().file().unwrap().coefficients.unwrap().c5, 0.2);
    let same = library.clone();
    assert!(library.add_json("{}", "bad.json").is_err());
    assert_eq!(library, same, "a bad file changes nothing");
}

/// A satellite with two arrays and all kinds of laws, attitudes and spheres is valid for the schema and for the reader.
#[test]
fn verif_a_file_of_panels_meets_the_schema() {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/two-arrays.json");
    let text = std::fs::read_to_string(path).unwrap();
    schema_check(&serde_json::from_str(&text).unwrap()).unwrap();
    let model = BrightnessModel::from_json(&text, "two-arrays.json").unwrap();
    assert_eq!(model.assembly().unwrap().names().collect::<Vec<_>>(), ["bus", "right", "left"]);
    for law in ["lambert", "phong", "abg", "gaussian", "binomial", "straight", "retro", "facets", "isotropic"] {
        assert!(text.contains(&format!("\"{law}\"")), "{law} is not shown");
    }
    let again = model.file().unwrap().to_json();
    schema_check(&serde_json::from_str(&again).unwrap()).unwrap();
    assert_eq!(BrightnessModel::from_json(&again, "again").unwrap(), model);
    let mut wrong: Value = serde_json::from_str(&text).unwrap();
    wrong["panels"]["panels"][0]["front"][0]["law"] = json!("mirror");
    assert!(schema_check(&wrong).is_err());
    let mut wrong: Value = serde_json::from_str(&text).unwrap();
    wrong["panels"]["spheres"][0]["phase"] = json!("phong");
    assert!(schema_check(&wrong).is_err());
}
