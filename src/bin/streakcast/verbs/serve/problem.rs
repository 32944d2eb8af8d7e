//! Error responses: problem documents (RFC 9457).

use axum::http::header::CONTENT_TYPE;
use axum::http::{HeaderName, HeaderValue, StatusCode};
use axum::response::{IntoResponse, Response};
use serde_json::json;
use streakcast::message::{Quoted, bounded};
use streakcast::{Error, ErrorKind};

pub const PROBLEM_JSON: &str = "application/problem+json";

/// Content of an error response.
#[derive(Clone, Debug, PartialEq)]
pub struct Problem {
    pub status: u16,
    detail: String,
    /// Name of the invalid parameter.
    parameter: Option<String>,
    /// Additional header required by the status.
    header: Option<(HeaderName, &'static str)>,
}

impl Problem {
    pub fn new(status: u16, detail: impl Into<String>) -> Self {
        Self { status, detail: bounded(&detail.into()).into_owned(), parameter: None, header: None }
    }

    pub fn of_parameter(name: &str, detail: String) -> Self {
        Self { parameter: Some(name.to_owned()), ..Self::new(400, detail) }
    }

    /// Returns the error for an invalid value of a parameter.
    pub fn parameter(name: &str, given: &str, allowed: &str) -> Self {
        Self::of_parameter(name, format!("invalid {name} '{}'; allowed: {allowed}", Quoted::new(given)))
    }

    /// Returns the same error for a value in a part of another parameter, such as `exposure 3`.
    pub fn in_part(self, name: &str, part: &str) -> Self {
        Self::of_parameter(name, format!("{part}: {}", self.detail))
    }

    /// Returns the error for a missing parameter.
    pub fn missing(name: &str, allowed: &str) -> Self {
        Self::of_parameter(name, format!("missing {name}; allowed: {allowed}"))
    }

    /// Returns the error for two parameters that exclude each other.
    pub fn both(name: &str, other: &str) -> Self {
        Self::of_parameter(name, format!("{name} and {other} are both given; allowed: one of them"))
    }

    /// Returns the error for a parameter that is given more than once.
    pub fn repeated(name: &str) -> Self {
        Self::of_parameter(name, format!("{name} is given more than once; allowed: once"))
    }

    pub fn with(self, name: HeaderName, value: &'static str) -> Self {
        Self { header: Some((name, value)), ..self }
    }

    /// Returns the problem document as JSON, with the path of the request if it is known.
    pub fn document(&self, path: Option<&str>) -> String {
        let mut document = json!({
            "type": "about:blank",
            "title": title(self.status),
            "status": self.status,
            "detail": self.detail,
        });
        for (name, value) in [("instance", path), ("parameter", self.parameter.as_deref())] {
            if let Some(value) = value {
                document[name] = json!(value);
            }
        }
        document.to_string()
    }

    /// Returns the response to a request for this path.
    pub fn response(&self, path: &str) -> Response {
        let status = StatusCode::from_u16(self.status).unwrap_or(StatusCode::INTERNAL_SERVER_ERROR);
        let mut response = (status, [(CONTENT_TYPE, PROBLEM_JSON)], self.document(Some(path))).into_response();
        response.headers_mut().extend(self.header.clone().map(|(name, value)| (name, HeaderValue::from_static(value))));
        response
    }
}

/// Error statuses: status, title, and meaning in this API.
pub const STATUSES: &[(u16, &str, &str)] = &[
    (
        400,
        "Bad Request",
        "A parameter is missing, unknown, repeated, malformed or out of range; or the request is malformed.",
    ),
    (401, "Unauthorized", "The server has a token, and the request does not carry it."),
    (403, "Forbidden", "The Host header names no loopback address, or the request comes from a page of another site."),
    (404, "Not Found", "Unknown path."),
    (405, "Method Not Allowed", "Methods other than GET and HEAD."),
    (408, "Request Timeout", "The head of the request did not arrive within 10 s."),
    (413, "Content Too Large", "The request has a body."),
    (414, "URI Too Long", "Path and query are longer than 16000 bytes."),
    (429, "Too Many Requests", "The address sends too many requests; Retry-After gives the time to wait."),
    (431, "Request Header Fields Too Large", "The head of the request is above 16 kB or 64 lines."),
    (500, "Internal Server Error", "An error of the program; the server continues."),
    (
        503,
        "Service Unavailable",
        "The server is busy, or the computation took too long; Retry-After gives the time to wait.",
    ),
];

impl From<Error> for Problem {
    /// Converts an error of the library, which is one of the request, except for files of the server.
    fn from(error: Error) -> Self {
        let status = if error.kind() == ErrorKind::File { 500 } else { 400 };
        Self::new(status, error.to_string())
    }
}

/// Returns the reason phrase of a status.
pub fn title(status: u16) -> &'static str {
    STATUSES.iter().find(|(known, ..)| *known == status).map_or("Error", |(_, title, _)| title)
}

#[cfg(test)]
mod tests {
    use axum::http::header::RETRY_AFTER;
    use serde_json::Value;

    use super::*;

    #[test]
    fn problems_are_documents() {
        let problem = Problem::parameter("dec_deg", &"9".repeat(100), "-90 to 90").with(RETRY_AFTER, "1");
        let response = problem.response("/api/v1/exposure");
        assert_eq!(response.status(), 400);
        assert_eq!(response.headers()["content-type"], PROBLEM_JSON);
        assert_eq!(response.headers()["retry-after"], "1");
        let document: Value = serde_json::from_str(&problem.document(Some("/api/v1/exposure"))).unwrap();
        assert_eq!((&document["title"], &document["parameter"]), (&json!("Bad Request"), &json!("dec_deg")));
        assert_eq!(document["instance"], "/api/v1/exposure");
        assert!(document["detail"].as_str().unwrap().len() < 120);
    }
}
