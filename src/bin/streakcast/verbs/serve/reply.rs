//! What goes back: a status, a body, and for errors a problem document (RFC 9457).

use hyper::body::Bytes;
use serde_json::{Value, json};

/// JSON answers.
pub const JSON: &str = "application/json";
/// Errors.
pub const PROBLEM_JSON: &str = "application/problem+json";

/// One answer, cheap to clone.
#[derive(Clone, Debug)]
pub struct Reply {
    pub status: u16,
    pub content_type: &'static str,
    pub body: Bytes,
    /// What this status brings beside the usual headers.
    pub header: Option<(&'static str, String)>,
}

impl Reply {
    /// A JSON document.
    pub fn json(text: String) -> Self {
        Self { status: 200, content_type: JSON, body: text.into_bytes().into(), header: None }
    }
}

/// Why there is no answer.
#[derive(Clone, Debug, PartialEq)]
pub struct Problem {
    status: u16,
    detail: String,
    /// The parameter that is wrong.
    parameter: Option<String>,
    header: Option<(&'static str, String)>,
}

impl Problem {
    pub fn new(status: u16, detail: impl Into<String>) -> Self {
        Self { status, detail: detail.into(), parameter: None, header: None }
    }

    /// 400: what was given, and what is allowed.
    pub fn parameter(name: &str, given: &str, allowed: &str) -> Self {
        let shown: String = given.chars().take(60).collect();
        let cut = if shown.len() < given.len() { "..." } else { "" };
        Self {
            parameter: Some(name.to_owned()),
            ..Self::new(400, format!("{name} '{shown}{cut}'; allowed: {allowed}"))
        }
    }

    /// 400 without a value.
    pub fn missing(name: &str, allowed: &str) -> Self {
        Self { parameter: Some(name.to_owned()), ..Self::new(400, format!("no {name}; allowed: {allowed}")) }
    }

    /// 400: two parameters of which each excludes the other.
    pub fn both(name: &str, other: &str) -> Self {
        let detail = format!("{name} and {other} are both said; allowed: one of them");
        Self { parameter: Some(name.to_owned()), ..Self::new(400, detail) }
    }

    /// 400: said more than once.
    pub fn twice(name: &str) -> Self {
        Self {
            parameter: Some(name.to_owned()),
            ..Self::new(400, format!("{name} is said more than once; allowed: once"))
        }
    }

    /// With a header that belongs to the status.
    pub fn with(self, name: &'static str, value: impl Into<String>) -> Self {
        Self { header: Some((name, value.into())), ..self }
    }

    pub fn reply(&self, path: &str) -> Reply {
        let mut document = json!({
            "type": "about:blank",
            "title": title(self.status),
            "status": self.status,
            "detail": self.detail,
            "instance": path,
        });
        if let (Some(parameter), Value::Object(members)) = (&self.parameter, &mut document) {
            members.insert("parameter".to_owned(), json!(parameter));
        }
        let body = document.to_string().into_bytes().into();
        Reply { status: self.status, content_type: PROBLEM_JSON, body, header: self.header.clone() }
    }
}

/// The statuses that can come, with what they mean here.
pub const STATUSES: &[(u16, &str, &str)] = &[
    (400, "Bad Request", "A parameter is missing, unknown, said twice, of the wrong form or out of range."),
    (401, "Unauthorized", "The server has a token, and the request does not carry it."),
    (403, "Forbidden", "The Host header names no loopback address, or the request comes from another site's page."),
    (404, "Not Found", "There is nothing at this path."),
    (405, "Method Not Allowed", "Something else than GET or HEAD: nothing here can be changed."),
    (413, "Content Too Large", "The request has a body: none is taken."),
    (414, "URI Too Long", "Path and query are longer than 2000 bytes."),
    (429, "Too Many Requests", "The address asks more often than it may; Retry-After tells when to come again."),
    (500, "Internal Server Error", "A fault of the program; the server goes on."),
    (503, "Service Unavailable", "Too much work waits, or this took too long; Retry-After tells when to come again."),
];

fn title(status: u16) -> &'static str {
    STATUSES.iter().find(|(known, ..)| *known == status).map_or("Error", |(_, title, _)| title)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn problems_are_documents_with_all_that_is_known() {
        let problem = Problem::parameter("dec_deg", &"9".repeat(100), "-90 to 90").with("Retry-After", "1");
        let reply = problem.reply("/api/v1/exposure");
        assert_eq!((reply.status, reply.content_type), (400, PROBLEM_JSON));
        let document: Value = serde_json::from_slice(&reply.body).unwrap();
        assert_eq!((&document["title"], &document["parameter"]), (&json!("Bad Request"), &json!("dec_deg")));
        assert!(document["detail"].as_str().unwrap().len() < 120);
        assert_eq!(reply.header, Some(("Retry-After", "1".to_owned())));
    }
}
