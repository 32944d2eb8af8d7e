//! Checks that every request passes before it is routed.

use std::net::IpAddr;
use std::time::Instant;

use axum::http::header::{CONTENT_LENGTH, HOST, RETRY_AFTER, TRANSFER_ENCODING};
use axum::http::{HeaderMap, Method, Request};

use super::problem::Problem;
use super::rate_limit::RateLimiter;

/// Longest path with its query, bytes.
pub const MAX_TARGET_BYTES: usize = 2000;
/// Host names of a loopback address. Any other is a name of another site that was pointed to this address.
const LOOPBACK_NAMES: [&str; 3] = ["localhost", "127.0.0.1", "[::1]"];

/// Limits on the requests of a server.
pub struct RequestFilter {
    pub limiter: RateLimiter,
    /// Whether the server listens on a loopback address, and the Host header has to name one.
    pub is_loopback: bool,
}

impl RequestFilter {
    /// Checks the rate, the length of the target, the headers Host and Sec-Fetch-Site, and that there is no body.
    pub fn check<B>(&self, request: &Request<B>, address: IpAddr, now: Instant) -> Result<(), Problem> {
        let headers = request.headers();
        if !self.limiter.allows(address, now) {
            return Err(Problem::new(429, "too many requests from this address").with(RETRY_AFTER, "1"));
        }
        if request.uri().path_and_query().is_some_and(|target| target.as_str().len() > MAX_TARGET_BYTES) {
            return Err(Problem::new(414, format!("path and query are longer than {MAX_TARGET_BYTES} bytes")));
        }
        if self.is_loopback && !names_loopback(headers) {
            let detail = "the Host header names no loopback address; allowed: localhost, 127.0.0.1, [::1]";
            return Err(Problem::new(403, detail));
        }
        // Only browsers send this header.
        if headers.get("sec-fetch-site").is_some_and(|site| site == "cross-site" || site == "same-site") {
            return Err(Problem::new(403, "the request comes from a page of another site"));
        }
        // Other methods get 405 from the router.
        if [Method::GET, Method::HEAD].contains(request.method()) && has_body(headers) {
            return Err(Problem::new(413, "the request has a body; allowed: none"));
        }
        Ok(())
    }
}

/// Whether there is one Host header and it has a loopback name, with any port.
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

/// Whether a body follows the head.
pub fn has_body(headers: &HeaderMap) -> bool {
    headers.get(CONTENT_LENGTH).is_some_and(|length| length != "0") || headers.contains_key(TRANSFER_ENCODING)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn status(is_loopback: bool, target: &str, headers: &[(&str, &str)]) -> u16 {
        let filter = RequestFilter { limiter: RateLimiter::new(1000), is_loopback };
        let mut request = Request::builder().uri(target);
        for (name, value) in headers {
            request = request.header(*name, *value);
        }
        let checked = filter.check(&request.body(()).unwrap(), "127.0.0.1".parse().unwrap(), Instant::now());
        checked.map_or_else(|problem| problem.status, |()| 200)
    }

    #[test]
    fn on_loopback_hosts_have_loopback_names() {
        for host in ["localhost", "127.0.0.1", "[::1]", "LOCALHOST:8642", "127.0.0.1:1", "[::1]:8642"] {
            assert_eq!(status(true, "/health", &[("host", host)]), 200, "{host}");
        }
        for host in ["example.org", "127.0.0.1.example.org", "localhost.example.org:80", "", "127.0.0.2", "localhost:x"]
        {
            assert_eq!(status(true, "/health", &[("host", host)]), 403, "{host}");
        }
        assert_eq!(status(true, "/health", &[]), 403);
        assert_eq!(status(true, "/health", &[("host", "localhost"), ("host", "localhost")]), 403);
        assert_eq!(status(false, "/health", &[("host", "example.org")]), 200);
        assert_eq!(status(true, "/health", &[("host", "localhost"), ("sec-fetch-site", "cross-site")]), 403);
    }

    #[test]
    fn bodies_and_long_targets_are_rejected() {
        for (header, expected) in
            [(("content-length", "5"), 413), (("transfer-encoding", "chunked"), 413), (("content-length", "0"), 200)]
        {
            assert_eq!(status(false, "/health", &[header]), expected, "{header:?}");
        }
        assert_eq!(status(false, &format!("/?{}", "x".repeat(MAX_TARGET_BYTES - 2)), &[]), 200);
        assert_eq!(status(false, &format!("/?{}", "x".repeat(MAX_TARGET_BYTES - 1)), &[]), 414);
    }
}
