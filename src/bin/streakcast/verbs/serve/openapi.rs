//! `/openapi.json`: OpenAPI document, generated from the same tables that parse requests and write responses.

use serde_json::{Map, Value, json};

use super::problem::{PROBLEM_JSON, Problem, STATUSES};
use super::query::{Parameter, Query};
use super::state::RequestState;

pub const JSON: &str = "application/json";

/// Path of the API with its parameters, handler and schema.
pub struct Route {
    pub path: &'static str,
    /// The same path without its final slash.
    pub alias: Option<&'static str>,
    pub summary: &'static str,
    pub parameters: &'static [Parameter],
    /// True if the path requires the access token of the server.
    pub needs_token: bool,
    /// Computes the JSON body of a response.
    pub handler: fn(&RequestState, &Query) -> Result<String, Problem>,
    /// Returns the JSON Schema of the body.
    pub schema: fn() -> Value,
}

/// Returns the OpenAPI 3.1 document of the paths.
pub fn document(routes: &[Route]) -> Value {
    let paths: Map<String, Value> =
        routes.iter().map(|route| (route.path.to_owned(), json!({"get": operation(route)}))).collect();
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
            "description": "Satellites crossing the exposures of a schedule or any other exposure. Read only: GET and HEAD. Angles in degrees (ICRS for right ascension and declination), times UTC, magnitudes in the band and system that provenance names. The same request has the same response as long as the server runs.",
            "license": {"name": "MIT OR Apache-2.0", "identifier": "MIT OR Apache-2.0"},
        },
        "servers": [{"url": "/"}],
        "paths": paths,
        "components": {
            "schemas": {"Problem": problem_schema()},
            "responses": responses,
            "securitySchemes": {
                "token": {"type": "http", "scheme": "bearer", "description": "Required if the server was started with a token."},
            },
        },
    })
}

fn operation(route: &Route) -> Value {
    let ok = json!({"description": "The response.", "content": {JSON: {"schema": (route.schema)()}}});
    let mut responses = Map::from_iter([("200".to_owned(), ok)]);
    for (status, ..) in STATUSES {
        let is_possible = match status {
            401 => route.needs_token,
            404 => false,
            _ => true,
        };
        if is_possible {
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
            "detail": {"type": "string", "description": "What is wrong, and what is allowed."},
            "instance": {"type": "string", "description": "The path of the request, unless its head is malformed."},
            "parameter": {"type": "string", "description": "The parameter that is wrong."},
        },
        "required": ["type", "title", "status", "detail"],
        "additionalProperties": false,
    })
}

pub fn schema() -> Value {
    json!({"type": "object", "required": ["openapi", "info", "paths"]})
}
