//! `/health`: that it runs, and with what.

use serde_json::{Value, json};

use super::super::house::House;
use super::super::question::Question;
use super::super::reply::{Problem, Reply};
use super::document::object_schema;

pub fn answer(house: &House, _: &Question) -> Result<Reply, Problem> {
    let document = json!({
        "status": "ok",
        "version": env!("CARGO_PKG_VERSION"),
        "satellites": house.sky().elements().len(),
        "exposures": house.schedule.exposures.len(),
    });
    Ok(Reply::json(format!("{document}\n")))
}

pub fn schema() -> Value {
    let count = json!({"type": "integer", "minimum": 0});
    object_schema(&[
        ("status", json!({"type": "string", "enum": ["ok"]})),
        ("version", json!({"type": "string"})),
        ("satellites", count.clone()),
        ("exposures", count),
    ])
}
