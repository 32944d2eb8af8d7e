//! Checks of the form and rate of every request before routing, and the access token.

use std::collections::HashMap;
use std::net::{IpAddr, SocketAddr};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use anyhow::anyhow;
use axum::http::header::{CONTENT_LENGTH, HOST, RETRY_AFTER, TRANSFER_ENCODING};
use axum::http::{HeaderMap, Method, Request};
use subtle::ConstantTimeEq;

use super::arguments::ServeArguments;
use super::problem::Problem;

/// Largest accepted length of path and query, bytes.
pub const MAX_TARGET_BYTES: usize = 16_000;

/// Limits for the requests of a server.
pub struct RequestFilter {
    pub limiter: RateLimiter,
    /// True if the server listens on a loopback address; the Host header must then contain a loopback name.
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
            let detail = "the Host header names no loopback address; allowed: localhost, 127.0.0.1, [::1] and other loopback addresses";
            return Err(Problem::new(403, detail));
        }
        // This header is sent only by browsers.
        if headers.get("sec-fetch-site").is_some_and(|site| site == "cross-site" || site == "same-site") {
            return Err(Problem::new(403, "the request comes from a page of another site"));
        }
        // Other methods are rejected by the router with status 405.
        if [Method::GET, Method::HEAD].contains(request.method()) && has_body(headers) {
            return Err(Problem::new(413, "the request has a body; allowed: none"));
        }
        Ok(())
    }
}

/// Returns true if there is exactly one Host header, with a loopback address or `localhost`, and any port. A request
/// with another name may come from a foreign web page (DNS rebinding); an address cannot be rebound.
fn names_loopback(headers: &HeaderMap) -> bool {
    let mut hosts = headers.get_all(HOST).iter();
    let (Some(host), None) = (hosts.next(), hosts.next()) else { return false };
    let Ok(host) = host.to_str() else { return false };
    let name = match host.rsplit_once(':') {
        Some((name, port)) if !port.is_empty() && port.bytes().all(|byte| byte.is_ascii_digit()) => name,
        _ => host,
    };
    let unbracketed = name.strip_prefix('[').and_then(|name| name.strip_suffix(']'));
    let address = match unbracketed {
        Some(name) => name.parse().map(IpAddr::V6),
        None => name.parse().map(IpAddr::V4),
    };
    name.eq_ignore_ascii_case("localhost") || address.is_ok_and(|address| address.to_canonical().is_loopback())
}

/// Returns true if the request has a body.
pub fn has_body(headers: &HeaderMap) -> bool {
    headers.get(CONTENT_LENGTH).is_some_and(|length| length != "0") || headers.contains_key(TRANSFER_ENCODING)
}

/// Largest number of tracked addresses. When it is reached, addresses without recent requests are removed.
const MAX_ADDRESSES: usize = 4096;
/// Burst allowance: the number of requests allowed in this time may also arrive at once.
const BURST: Duration = Duration::from_secs(1);

/// Rate limiter with the generic cell rate algorithm: each address has a due time, which each request moves ahead by
/// one interval. A request is rejected if the due time would be more than `BURST` after now.
#[derive(Debug)]
pub struct RateLimiter {
    interval: Duration,
    due: Mutex<HashMap<IpAddr, Instant>>,
}

impl RateLimiter {
    pub fn new(requests_per_second: u32) -> Self {
        Self { interval: BURST / requests_per_second, due: Mutex::default() }
    }

    /// Returns true and counts the request if it is allowed. One second after a rejection, a request is allowed.
    pub fn allows(&self, address: IpAddr, now: Instant) -> bool {
        let mut due = self.due.lock().unwrap_or_else(PoisonError::into_inner);
        let network = network_of(address);
        if due.len() >= MAX_ADDRESSES && !due.contains_key(&network) {
            due.retain(|_, due| *due > now);
            if due.len() >= MAX_ADDRESSES {
                return false;
            }
        }
        let due = due.entry(network).or_insert(now);
        let next = now.max(*due) + self.interval;
        let is_allowed = next <= now + BURST;
        if is_allowed {
            *due = next;
        }
        is_allowed
    }
}

/// Returns the /64 network of an IPv6 address, which usually belongs to one client. An IPv4 address is unchanged.
fn network_of(address: IpAddr) -> IpAddr {
    match address.to_canonical() {
        IpAddr::V6(address) => {
            let [a, b, c, d, ..] = address.segments();
            IpAddr::from([a, b, c, d, 0, 0, 0, 0])
        }
        address => address,
    }
}

/// Smallest length of a token, characters. Shorter tokens could be guessed.
const SHORTEST: usize = 16;
const LONGEST: usize = 512;

/// Access token of the API. It is not printed.
pub struct Token(Vec<u8>);

impl Token {
    /// Reads the token from the file or environment variable in the flags. It is optional for loopback addresses.
    pub fn from_arguments(typed: &ServeArguments) -> anyhow::Result<Option<Self>> {
        let text = match (&typed.token_file, &typed.token_env) {
            (Some(path), _) => {
                let text = streakcast::input::read_to_string(path)
                    .map_err(|error| anyhow!("cannot read the token of {}: {error}", path.display()))?;
                text.lines().next().unwrap_or_default().trim().to_owned()
            }
            (None, Some(name)) => std::env::var(name)
                .map_err(|_| {
                    anyhow!("the environment variable {name} is not set; allowed: the name of a variable with a token")
                })?
                .trim()
                .to_owned(),
            (None, None) => return check_loopback(typed.bind).map(|()| None),
        };
        if !(SHORTEST..=LONGEST).contains(&text.len()) || !text.bytes().all(|byte| byte.is_ascii_graphic()) {
            let letters = text.chars().count();
            return Err(anyhow!(
                "invalid token of {letters} characters; allowed: {SHORTEST} to {LONGEST} printable ASCII characters without spaces"
            ));
        }
        Ok(Some(Self(text.into_bytes())))
    }

    /// Returns true if an Authorization header contains the token. The comparison takes constant time.
    pub fn is_carried_by(&self, authorization: Option<&[u8]>) -> bool {
        let Some((scheme, given)) = authorization.and_then(|header| header.split_at_checked(7)) else { return false };
        scheme.eq_ignore_ascii_case(b"bearer ") && bool::from(self.0.as_slice().ct_eq(given.trim_ascii()))
    }
}

fn check_loopback(bind: SocketAddr) -> anyhow::Result<()> {
    if bind.ip().to_canonical().is_loopback() {
        return Ok(());
    }
    Err(anyhow!(
        "--bind {bind} is reachable from other machines; allowed without a token: 127.0.0.1 and [::1]; specify --token-file FILE or --token-env NAME"
    ))
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
        for host in [
            "localhost",
            "127.0.0.1",
            "[::1]",
            "LOCALHOST:8642",
            "127.0.0.1:1",
            "[::1]:8642",
            "127.0.0.2:8642",
            "127.255.0.3",
            "[::ffff:127.0.0.1]:1",
        ] {
            assert_eq!(status(true, "/health", &[("host", host)]), 200, "{host}");
        }
        for host in [
            "example.org",
            "127.0.0.1.example.org",
            "localhost.example.org:80",
            "",
            "0.0.0.0:8642",
            "192.0.2.1",
            "127.1",
            "[::]",
            "::1",
            "[127.0.0.1]",
            "localhost:x",
        ] {
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

    #[test]
    fn a_burst_is_allowed_and_then_the_rate() {
        let limiter = RateLimiter::new(10);
        let (first, other): (IpAddr, IpAddr) = ("192.0.2.1".parse().unwrap(), "192.0.2.2".parse().unwrap());
        let begin = Instant::now();
        assert!((0..10).all(|_| limiter.allows(first, begin)));
        assert!(!limiter.allows(first, begin) && !limiter.allows(first, begin + Duration::from_millis(99)));
        assert!(limiter.allows(other, begin), "addresses are counted separately");
        let later = begin + Duration::from_millis(150);
        assert!(limiter.allows(first, later) && !limiter.allows(first, later));
        let network: [IpAddr; 2] = ["2001:db8::1".parse().unwrap(), "2001:db8::2".parse().unwrap()];
        assert!((0..10).all(|turn| limiter.allows(network[turn % 2], later)));
        assert!(!limiter.allows(network[0], later));
    }

    #[test]
    fn the_number_of_addresses_is_bounded() {
        let limiter = RateLimiter::new(1);
        let begin = Instant::now();
        let address = |number: u32| IpAddr::from(number.to_be_bytes());
        let allowed = (0..10_000).filter(|number| limiter.allows(address(*number), begin)).count();
        assert_eq!((allowed, limiter.due.lock().unwrap().len()), (MAX_ADDRESSES, MAX_ADDRESSES));
        // Addresses without a request in the last second are removed.
        assert!(limiter.allows(address(20_000), begin + Duration::from_secs(2)));
        assert_eq!(limiter.due.lock().unwrap().len(), 1);
    }

    #[test]
    fn only_the_whole_token_counts() {
        let token = Token(b"0123456789abcdef".to_vec());
        assert!(token.is_carried_by(Some(b"Bearer 0123456789abcdef")));
        assert!(token.is_carried_by(Some(b"bearer  0123456789abcdef ")));
        for wrong in [
            None,
            Some(&b""[..]),
            Some(b"Bearer"),
            Some(b"Bearer "),
            Some(b"Bearer 0123456789abcde"),
            Some(b"Bearer 0123456789abcdef0"),
            Some(b"Bearer 0123456789abcdeg"),
            Some(b"Basic  0123456789abcdef"),
            Some(b"0123456789abcdef"),
        ] {
            assert!(!token.is_carried_by(wrong), "{wrong:?}");
        }
    }
}
