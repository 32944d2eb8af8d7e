//! `/openapi.json`: made from the same tables that requests are read and answers are written with.

use serde_json::{Map, Value, json};

use super::house::House;
use super::question::{Parameter, Question};
use super::reply::{JSON, PROBLEM_JSON, Problem, Reply, STATUSES};
use super::routes::{ROUTES, Route};

pub fn answer(_: &House, _: &Question) -> Result<Reply, Problem> {
    Ok(Reply::json(format!("{}\n", document())))
}

/// OpenAPI 3.1.
pub fn document() -> Value {
    let paths: Map<String, Value> =
        ROUTES.iter().map(|route| (route.path.to_owned(), json!({"get": operation(route)}))).collect();
    let responses: Map<String, Value> = STATUSES
        .iter()
        .map(|(status, _, meaning)| {
            let content = json!({PROBLEM_JSON: {"schema": {"$ref": "#/components/schemas/Problem"}}});
            (status.to_string(), json!({"description": meaning, "content": content}))
        })
        .collect();
    json!({
        "openapi": "3.1.0",
        "info": {
            "title": "streakcast serve",
            "version": env!("CARGO_PKG_VERSION"),
            "description": "Satellites crossing the exposures of one schedule. Read only: GET and HEAD. Angles in degrees (ICRS for right ascension and declination), times UTC, magnitudes in the band and system that provenance names. The same question has the same answer as long as the server runs.",
            "license": {"name": "MIT OR Apache-2.0", "identifier": "MIT OR Apache-2.0"},
        },
        "servers": [{"url": "/"}],
        "paths": paths,
        "components": {
            "schemas": {"Problem": problem_schema()},
            "responses": responses,
            "securitySchemes": {
                "token": {"type": "http", "scheme": "bearer", "description": "Only where the server was started with a token."},
            },
        },
    })
}

fn operation(route: &Route) -> Value {
    let ok = json!({"description": "The answer.", "content": {JSON: {"schema": (route.schema)()}}});
    let mut responses = Map::from_iter([("200".to_owned(), ok)]);
    // Everything that may come, by what this path can meet.
    for (status, ..) in STATUSES {
        let can_come = match status {
            401 => route.needs_token,
            404 => route.path == "/api/v1/night",
            _ => true,
        };
        if can_come {
            responses.insert(status.to_string(), json!({"$ref": format!("#/components/responses/{status}")}));
        }
    }
    let security = if route.needs_token { json!([{}, {"token": []}]) } else { json!([]) };
    json!({
        "summary": route.summary,
        "operationId": route.path.trim_matches('/').replace(['/', '-', '.'], "_"),
        "parameters": route.parameters.iter().map(parameter).collect::<Vec<_>>(),
        "responses": responses,
        "security": security,
    })
}

fn parameter(parameter: &Parameter) -> Value {
    json!({
        "name": parameter.name,
        "in": "query",
        "required": parameter.required,
        "description": parameter.about,
        "schema": parameter.kind.schema(),
    })
}

fn problem_schema() -> Value {
    json!({
        "type": "object",
        "description": "RFC 9457.",
        "properties": {
            "type": {"type": "string"},
            "title": {"type": "string"},
            "status": {"type": "integer"},
            "detail": {"type": "string", "description": "What was given, and what is allowed."},
            "instance": {"type": "string", "description": "The path; not where the request could not be read."},
            "parameter": {"type": "string", "description": "The parameter that is wrong."},
        },
        "required": ["type", "title", "status", "detail"],
        "additionalProperties": false,
    })
}

pub fn schema() -> Value {
    json!({"type": "object", "required": ["openapi", "info", "paths"]})
}
