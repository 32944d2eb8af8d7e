//! `/health`: returns the status of the server and the sizes of its inputs.

use serde_json::{Value, json};

use super::super::problem::Problem;
use super::super::query::Query;
use super::super::state::RequestState;
use super::document::{count_schema, object_schema, text_schema};

pub fn handle(state: &RequestState, _: &Query) -> Result<String, Problem> {
    let document = json!({
        "status": "ok",
        "version": env!("CARGO_PKG_VERSION"),
        "satellites": state.sky().elements().len(),
        "exposures": state.exposures.len(),
    });
    Ok(format!("{document}\n"))
}

pub fn schema() -> Value {
    object_schema(&[
        ("status", json!({"type": "string", "enum": ["ok"]})),
        ("version", text_schema()),
        ("satellites", count_schema()),
        ("exposures", count_schema()),
    ])
}
