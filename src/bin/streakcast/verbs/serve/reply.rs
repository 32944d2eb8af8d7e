//! What goes back: a status, a body, and for errors a problem document (RFC 9457).

use std::time::Instant;

use hifitime::Epoch;
use hifitime::efmt::Formatter;
use hifitime::efmt::consts::RFC2822;
use http_body_util::Full;
use hyper::body::Bytes;
use hyper::header::{CONTENT_LENGTH, CONTENT_TYPE, HeaderMap, HeaderName, HeaderValue};
use hyper::{Response, StatusCode};
use serde_json::json;

/// JSON answers.
pub const JSON: &str = "application/json";
/// Errors.
pub const PROBLEM_JSON: &str = "application/problem+json";

/// Nothing but what this server itself gives may run, load or be asked by the page; and nobody may frame it.
const CONTENT_SECURITY_POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; \
     connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// Sent with everything.
const HEADERS: [(&str, &str); 6] = [
    ("content-security-policy", CONTENT_SECURITY_POLICY),
    ("x-content-type-options", "nosniff"),
    ("referrer-policy", "no-referrer"),
    ("cross-origin-resource-policy", "same-origin"),
    ("cross-origin-opener-policy", "same-origin"),
    ("cache-control", "no-store"),
];

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

    /// As hyper sends it.
    pub fn response(self, is_head: bool, began: Instant) -> Response<Full<Bytes>> {
        let mut headers = self.headers();
        let took_ms = began.elapsed().as_secs_f64() * 1e3;
        if let Ok(timing) = HeaderValue::from_str(&format!("answer;dur={took_ms:.2}")) {
            headers.insert("server-timing", timing);
        }
        let status = StatusCode::from_u16(self.status).unwrap_or_default();
        let mut response = Response::new(Full::new(if is_head { Bytes::new() } else { self.body }));
        *response.status_mut() = status;
        *response.headers_mut() = headers;
        response
    }

    /// Head and body as they go over the wire where hyper has no request to answer: the connection's last.
    pub fn last_answer(&self) -> Vec<u8> {
        let mut answer = format!("HTTP/1.1 {} {}\r\n", self.status, title(self.status)).into_bytes();
        let mut line = |name: &str, value: &[u8]| {
            answer.extend([name.as_bytes(), b": ", value, b"\r\n"].concat());
        };
        for (name, value) in &self.headers() {
            line(name.as_str(), value.as_bytes());
        }
        line("connection", b"close");
        if let Ok(now) = Epoch::now() {
            line("date", format!("{} GMT", Formatter::new(now, RFC2822)).as_bytes());
        }
        answer.extend(b"\r\n");
        answer.extend(&self.body);
        answer
    }

    fn headers(&self) -> HeaderMap {
        let fixed = |(name, value)| (HeaderName::from_static(name), HeaderValue::from_static(value));
        let mut headers: HeaderMap = HEADERS.into_iter().map(fixed).collect();
        headers.insert(CONTENT_TYPE, HeaderValue::from_static(self.content_type));
        headers.insert(CONTENT_LENGTH, HeaderValue::from(self.body.len()));
        if let Some((name, value)) = &self.header
            && let (Ok(name), Ok(value)) = (name.parse::<HeaderName>(), HeaderValue::from_str(value))
        {
            headers.insert(name, value);
        }
        headers
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

    /// The document, with the path that was asked for where it is known.
    pub fn reply<'a>(&self, path: impl Into<Option<&'a str>>) -> Reply {
        let mut document = json!({
            "type": "about:blank",
            "title": title(self.status),
            "status": self.status,
            "detail": self.detail,
        });
        if let Some(path) = path.into() {
            document["instance"] = json!(path);
        }
        if let Some(parameter) = &self.parameter {
            document["parameter"] = json!(parameter);
        }
        let body = document.to_string().into_bytes().into();
        Reply { status: self.status, content_type: PROBLEM_JSON, body, header: self.header.clone() }
    }
}

/// The statuses that can come, with what they mean here.
pub const STATUSES: &[(u16, &str, &str)] = &[
    (
        400,
        "Bad Request",
        "A parameter is missing, unknown, said twice, of the wrong form or out of range; or what came is no request.",
    ),
    (401, "Unauthorized", "The server has a token, and the request does not carry it."),
    (403, "Forbidden", "The Host header names no loopback address, or the request comes from another site's page."),
    (404, "Not Found", "There is nothing at this path."),
    (405, "Method Not Allowed", "Something else than GET or HEAD: nothing here can be changed."),
    (408, "Request Timeout", "The head of the request did not come within 10 s."),
    (413, "Content Too Large", "The request has a body: none is taken."),
    (414, "URI Too Long", "Path and query are longer than 2000 bytes."),
    (429, "Too Many Requests", "The address asks more often than it may; Retry-After tells when to come again."),
    (431, "Request Header Fields Too Large", "The head of the request is above 16 kB or 64 lines."),
    (500, "Internal Server Error", "A fault of the program; the server goes on."),
    (503, "Service Unavailable", "Too much work waits, or this took too long; Retry-After tells when to come again."),
];

fn title(status: u16) -> &'static str {
    STATUSES.iter().find(|(known, ..)| *known == status).map_or("Error", |(_, title, _)| title)
}

#[cfg(test)]
mod tests {
    use serde_json::Value;

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
