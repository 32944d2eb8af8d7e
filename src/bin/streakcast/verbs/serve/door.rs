//! What may come in: the checks that every request passes before anything is computed, in this order.

use std::net::IpAddr;
use std::sync::Mutex;
use std::time::Instant;

use hyper::header::{AUTHORIZATION, CONTENT_LENGTH, HOST, HeaderMap, TRANSFER_ENCODING};
use hyper::{Method, Request};

use super::bucket::Buckets;
use super::page;
use super::question::Question;
use super::reply::{Problem, Reply};
use super::routes::{self, Route};
use super::token::Token;

/// Longest path with its query, bytes.
pub const LONGEST_TARGET: usize = 2000;

/// Names under which a loopback address is asked for; anything else is another site's name that was pointed here.
const LOOPBACK_NAMES: [&str; 3] = ["localhost", "127.0.0.1", "[::1]"];

pub struct Door {
    buckets: Mutex<Buckets>,
    token: Option<Token>,
    is_loopback: bool,
}

/// What a request that came in wants.
pub enum Wanted {
    /// A file of the page.
    File(Reply),
    /// An answer of the API.
    Answer { route: &'static Route, question: Question },
}

impl Door {
    pub fn new(rate: u32, token: Option<Token>, is_loopback: bool) -> Self {
        Self { buckets: Mutex::new(Buckets::new(rate)), token, is_loopback }
    }

    /// Lets a request in, or says why not.
    pub fn admit<B>(&self, request: &Request<B>, from: IpAddr, now: Instant) -> Result<Wanted, Problem> {
        let (headers, uri) = (request.headers(), request.uri());
        let taken = self.buckets.lock().unwrap_or_else(std::sync::PoisonError::into_inner).take(from, now);
        taken.map_err(|wait| {
            let seconds = wait.as_secs_f64().ceil().max(1.0);
            Problem::new(429, "more requests than this address may make").with("Retry-After", seconds.to_string())
        })?;
        if uri.path_and_query().is_some_and(|target| target.as_str().len() > LONGEST_TARGET) {
            return Err(Problem::new(414, format!("path and query are longer than {LONGEST_TARGET} bytes")));
        }
        if self.is_loopback && !names_loopback(headers) {
            let detail = "the Host header names no loopback address; allowed: localhost, 127.0.0.1, [::1]";
            return Err(Problem::new(403, detail));
        }
        // Browsers say where a request comes from; other programs do not.
        if headers.get("sec-fetch-site").is_some_and(|site| site == "cross-site" || site == "same-site") {
            return Err(Problem::new(403, "the request comes from another site's page"));
        }
        let file = page::file(uri.path());
        let route = routes::find(uri.path());
        if file.is_none() && route.is_none() {
            return Err(Problem::new(404, "there is nothing at this path; /openapi.json lists what there is"));
        }
        if request.method() != Method::GET && request.method() != Method::HEAD {
            return Err(
                Problem::new(405, "allowed: GET and HEAD; nothing here can be changed").with("Allow", "GET, HEAD")
            );
        }
        if has_body(headers) {
            return Err(Problem::new(413, "a request with a body; none is taken"));
        }
        let Some(route) = route else {
            return file.map(Wanted::File).ok_or_else(|| Problem::new(404, "there is nothing at this path"));
        };
        if let Some(token) = self.token.as_ref().filter(|_| route.needs_token) {
            let authorization = headers.get(AUTHORIZATION).map(|header| header.as_bytes());
            if !token.is_carried_by(authorization) {
                let detail = "the token is missing or wrong; say Authorization: Bearer TOKEN";
                return Err(Problem::new(401, detail).with("WWW-Authenticate", "Bearer"));
            }
        }
        let question = Question::read(uri.query().unwrap_or_default(), route.parameters)?;
        Ok(Wanted::Answer { route, question })
    }
}

/// One Host header, of a loopback name with any port: a page elsewhere whose name was pointed at this machine says its own.
fn names_loopback(headers: &HeaderMap) -> bool {
    let mut hosts = headers.get_all(HOST).iter();
    let (Some(host), None) = (hosts.next(), hosts.next()) else { return false };
    let Ok(host) = host.to_str() else { return false };
    let name = match host.rsplit_once(':') {
        Some((name, port)) if !port.is_empty() && port.bytes().all(|byte| byte.is_ascii_digit()) => name,
        _ => host,
    };
    LOOPBACK_NAMES.iter().any(|known| name.eq_ignore_ascii_case(known))
}

/// Whether something follows the head.
pub fn has_body(headers: &HeaderMap) -> bool {
    let length = headers.get(CONTENT_LENGTH).is_some_and(|length| length != "0");
    length || headers.contains_key(TRANSFER_ENCODING)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn status(door: &Door, method: &str, path: &str, headers: &[(&str, &str)]) -> u16 {
        let mut request = Request::builder().method(method).uri(path);
        for (name, value) in headers {
            request = request.header(*name, *value);
        }
        match door.admit(&request.body(()).unwrap(), "127.0.0.1".parse().unwrap(), Instant::now()) {
            Ok(_) => 200,
            Err(problem) => problem.reply(path).status,
        }
    }

    #[test]
    fn hosts_are_those_of_loopback() {
        let door = Door::new(1000, None, true);
        for host in ["localhost", "127.0.0.1", "[::1]", "LOCALHOST:8642", "127.0.0.1:1", "[::1]:8642"] {
            assert_eq!(status(&door, "GET", "/health", &[("host", host)]), 200, "{host}");
        }
        for host in ["example.org", "127.0.0.1.example.org", "localhost.example.org:80", "", "127.0.0.2", "localhost:x"]
        {
            assert_eq!(status(&door, "GET", "/health", &[("host", host)]), 403, "{host}");
        }
        assert_eq!(status(&door, "GET", "/health", &[]), 403);
        assert_eq!(status(&door, "GET", "/health", &[("host", "localhost"), ("host", "localhost")]), 403);
        assert_eq!(status(&Door::new(1000, None, false), "GET", "/health", &[("host", "example.org")]), 200);
        let cross = [("host", "localhost"), ("sec-fetch-site", "cross-site")];
        assert_eq!(status(&door, "GET", "/health", &cross), 403);
    }

    #[test]
    fn paths_methods_bodies_and_lengths() {
        let door = Door::new(1000, None, true);
        let host = ("host", "localhost");
        for (method, path, more, expected) in [
            ("GET", "/", None, 200),
            ("HEAD", "/", None, 200),
            ("GET", "/etc/passwd", None, 404),
            ("GET", "/../../etc/passwd", None, 404),
            ("GET", "/%2e%2e/etc/passwd", None, 404),
            ("GET", "//", None, 404),
            ("POST", "/health", None, 405),
            ("DELETE", "/", None, 405),
            ("OPTIONS", "/api/v1/night", None, 405),
            ("BREW", "/health", None, 405),
            ("GET", "/health", Some(("content-length", "5")), 413),
            ("GET", "/health", Some(("transfer-encoding", "chunked")), 413),
            ("GET", "/health", Some(("content-length", "0")), 200),
            ("GET", "/health?x=1", None, 400),
            ("GET", "/fov/satellite-passes", None, 400),
        ] {
            let headers: Vec<_> = std::iter::once(host).chain(more).collect();
            assert_eq!(status(&door, method, path, &headers), expected, "{method} {path} {more:?}");
        }
        let long = format!("/health?{}", "x".repeat(LONGEST_TARGET));
        assert_eq!(status(&door, "GET", &long, &[host]), 414);
    }
}
