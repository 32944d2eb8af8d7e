//! The paths, what may be asked at each, and who answers.

use serde_json::Value;

use super::answers::{dome, exposure, health, night, satchecker};
use super::house::House;
use super::openapi;
use super::question::{Parameter, Question};
use super::reply::{Problem, Reply};

/// One path of the API.
pub struct Route {
    pub path: &'static str,
    /// The path without the stroke at its end, as people type it.
    pub also: Option<&'static str>,
    pub summary: &'static str,
    pub parameters: &'static [Parameter],
    /// False where everybody may ask, token or not.
    pub needs_token: bool,
    pub answer: fn(&House, &Question) -> Result<Reply, Problem>,
    /// What an answer of 200 looks like, as JSON Schema.
    pub schema: fn() -> Value,
}

/// All of them.
pub static ROUTES: &[Route] = &[
    Route {
        path: "/api/v1/night",
        also: None,
        summary: "One night of the schedule: exposures, verdicts, the Sun, the field, the site.",
        parameters: night::PARAMETERS,
        needs_token: true,
        answer: night::answer,
        schema: night::schema,
    },
    Route {
        path: "/api/v1/exposure",
        also: None,
        summary: "Any exposure: its verdict, its crossings, the next clear start; as `flag` and `passes` of the command line.",
        parameters: exposure::PARAMETERS,
        needs_token: true,
        answer: exposure::answer,
        schema: exposure::schema,
    },
    Route {
        path: "/api/v1/dome",
        also: None,
        summary: "The sky over the site: sunlit satellites, a model's magnitudes at one height, the edge of the Earth's shadow, the Sun.",
        parameters: dome::PARAMETERS,
        needs_token: true,
        answer: dome::answer,
        schema: dome::schema,
    },
    Route {
        path: "/fov/satellite-passes/",
        also: Some("/fov/satellite-passes"),
        summary: "Satellites in a circular field during a stretch of time, in the shape of SatChecker, with magnitudes.",
        parameters: satchecker::PASSES,
        needs_token: true,
        answer: satchecker::passes,
        schema: satchecker::passes_schema,
    },
    Route {
        path: "/fov/satellites-above-horizon/",
        also: Some("/fov/satellites-above-horizon"),
        summary: "Satellites above the horizon at one moment, in the shape of SatChecker, with magnitudes.",
        parameters: satchecker::ABOVE,
        needs_token: true,
        answer: satchecker::above,
        schema: satchecker::above_schema,
    },
    Route {
        path: "/health",
        also: None,
        summary: "That it runs, and with what.",
        parameters: &[],
        needs_token: false,
        answer: health::answer,
        schema: health::schema,
    },
    Route {
        path: "/openapi.json",
        also: None,
        summary: "This document.",
        parameters: &[],
        needs_token: false,
        answer: openapi::answer,
        schema: openapi::schema,
    },
];

/// The route of a path.
pub fn find(path: &str) -> Option<&'static Route> {
    ROUTES.iter().find(|route| route.path == path || route.also == Some(path))
}
