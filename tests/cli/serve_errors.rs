//! Error responses of the server: problem documents for every kind of invalid request.

use std::io::{Read, Write};
use std::net::{Shutdown, TcpStream};
use std::time::Duration;

use crate::common::cli::run;
use crate::common::server::{RULES, Response, SHARED, Server, parse, serve, shared};
use serde_json::json;

#[test]
fn errors_are_problem_documents_and_everything_carries_its_headers() {
    let server = shared();
    for (method, target, headers, status) in [
        ("GET", "/nothing", vec![], 404),
        ("GET", "/../Cargo.toml", vec![], 404),
        ("GET", "/%2e%2e/Cargo.toml", vec![], 404),
        ("GET", "/api/v1/exposure", vec![], 400),
        ("GET", "/api/v1/exposure?start_utc=x", vec![], 400),
        ("GET", "/health?a=b", vec![], 400),
        ("PUT", "/health", vec![], 405),
        ("OPTIONS", "/", vec![], 405),
        ("GET", "/health", vec![("Host", "attacker.example")], 403),
        ("GET", "/health", vec![("Sec-Fetch-Site", "cross-site")], 403),
        ("GET", "/health", vec![("Content-Length", "3")], 413),
    ] {
        let response = server.send(method, target, &headers);
        assert_eq!(response.status, status, "{method} {target} {headers:?}");
        assert_eq!(response.header("content-type"), Some("application/problem+json"));
        let document = response.json();
        assert_eq!(document["status"], json!(status));
        assert!(!document["detail"].as_str().unwrap().is_empty() && document["title"].is_string());
        assert_eq!(response.header("allow"), (status == 405).then_some("GET, HEAD"));
    }
    for target in ["/", "/main.js", "/health", "/nothing"] {
        let response = server.get(target);
        assert!(response.header("content-security-policy").unwrap().starts_with("default-src 'none';"), "{target}");
        assert_eq!(response.header("x-content-type-options"), Some("nosniff"));
        assert!(response.header("access-control-allow-origin").is_none());
        let head = server.send("HEAD", target, &[]);
        assert_eq!((head.status, head.body.len()), (response.status, 0), "{target}");
        assert_eq!(head.header("content-length"), response.header("content-length"));
    }
}

/// Headers of all responses.
const HEADERS: [&str; 6] = [
    "content-security-policy",
    "x-content-type-options",
    "referrer-policy",
    "cross-origin-resource-policy",
    "cross-origin-opener-policy",
    "cache-control",
];

/// Checks that the response is a problem document with all headers, after which the connection is closed.
#[track_caller]
fn is_last_problem(response: &Response, status: u16, words: &str) {
    let text = String::from_utf8_lossy(&response.body);
    assert_eq!(response.status, status, "{text}");
    assert_eq!(response.header("content-type"), Some("application/problem+json"), "{text}");
    assert_eq!(response.header("connection"), Some("close"), "{text}");
    assert_eq!(response.header("content-length"), Some(response.body.len().to_string().as_str()), "{text}");
    assert!(HEADERS.iter().all(|name| response.header(name).is_some()), "{:?}", response.headers);
    let date = response.header("date").unwrap();
    assert!(date.len() == 29 && date.ends_with(" GMT") && date.as_bytes()[7] == b' ', "{date}");
    let document = response.json();
    assert_eq!((&document["status"], &document["type"]), (&json!(status), &json!("about:blank")));
    assert!(document["title"].is_string() && document["detail"].as_str().unwrap().contains(words), "{document}");
}

/// Returns a request for `/health` with these header lines and this body.
fn request(method: &str, lines: &str, body: &str) -> Vec<u8> {
    format!("{method} /health HTTP/1.1\r\nHost: localhost\r\n{lines}\r\n{body}").into_bytes()
}

#[test]
fn malformed_heads_get_problem_documents() {
    let server = shared();
    let lines = |count: usize| -> String { (0..count).map(|number| format!("X-{number}: 1\r\n")).collect() };
    for (bytes, status, words) in [
        (format!("GET /{} HTTP/1.1\r\nHost: localhost\r\n\r\n", "a".repeat(40_000)).into_bytes(), 414, "16000 bytes"),
        (request("GET", &format!("X: {}\r\n", "a".repeat(40_000)), ""), 431, "16 kB or 64 lines"),
        (request("GET", &lines(100), ""), 431, "16 kB or 64 lines"),
        (b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03".to_vec(), 400, "without TLS"),
        (b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n\0\0\0\x04\0\0\0\0\0".to_vec(), 400, "HTTP2 preface"),
        (b"GET\r\n\r\n".to_vec(), 400, "malformed head"),
        (b"GET /health\r\n".to_vec(), 400, "malformed head"),
        (b"GET / HTTP/9.9\r\n\r\n".to_vec(), 400, "HTTP/1.1 and 1.0"),
        (b"\0\0\0\0\r\n\r\n".to_vec(), 400, "malformed head"),
        (request("G\u{e9}T", "", ""), 400, "invalid HTTP method"),
        (request("GET", "no colon\r\n", ""), 400, "invalid HTTP header"),
        (request("GET", "Content-Length: -5\r\n", ""), 400, "content-length"),
        (request("GET", "Content-Length: 5\r\nContent-Length: 6\r\n", ""), 400, "content-length"),
        (request("GET", "Transfer-Encoding: gzip\r\n", ""), 400, "transfer-encoding"),
        (request("GET", "Transfer-Encoding: chunked, identity\r\n", ""), 400, "transfer-encoding"),
    ] {
        is_last_problem(&server.raw(&bytes), status, words);
    }
    // Invalid requests after valid requests on the same connection.
    let mut both = request("GET", "", "");
    both.extend(request("HEAD", "", ""));
    both.extend(b"bad\x01\r\n\r\n");
    let response = server.raw(&both);
    let whole = server.get("/health").body;
    assert!(response.status == 200 && response.body.starts_with(&whole), "{}", String::from_utf8_lossy(&response.body));
    let second = parse(&response.body[whole.len()..]);
    assert_eq!((second.status, second.header("content-type")), (200, Some("application/json")));
    is_last_problem(&parse(&second.body), 400, "invalid HTTP method");
    assert_eq!(server.get("/health").status, 200);
}

fn read(mut stream: TcpStream) -> Response {
    let mut response = Vec::new();
    stream.read_to_end(&mut response).unwrap();
    parse(&response)
}

#[test]
fn incomplete_and_late_heads_get_problem_documents() {
    let server = shared();
    let mut broken = server.connect();
    broken.write_all(b"GET /health HTTP/1.1\r\nHost: local").unwrap();
    broken.shutdown(Shutdown::Write).unwrap();
    is_last_problem(&read(broken), 400, "incomplete head");
    // Single bytes do not extend the time limit. A connection without a request is closed without a response.
    let (mut slow, silent) = (server.connect(), server.connect());
    for byte in b"GET /health" {
        slow.write_all(&[*byte]).unwrap();
        std::thread::sleep(Duration::from_millis(50));
    }
    is_last_problem(&read(slow), 408, "10 s");
    assert_eq!((read(silent).status, server.get("/health").status), (0, 200));
}

#[test]
fn bodies_are_not_read_as_requests() {
    let server = shared();
    let hidden = "0\r\n\r\nGET /nothing HTTP/1.1\r\nHost: localhost\r\n\r\n";
    for (method, lines, status) in [
        ("GET", "Content-Length: 5\r\nTransfer-Encoding: chunked\r\n", 413),
        ("GET", "Transfer-Encoding: chunked\r\nContent-Length: 5\r\n", 413),
        ("GET", "Transfer-Encoding: chunked\r\n", 413),
        ("POST", "Transfer-Encoding: chunked\r\n", 405),
        ("POST", "Content-Length: 5\r\n", 405),
        ("POST", "Content-Length: 5\r\nExpect: 100-continue\r\n", 405),
        ("BREW", "Content-Length: 5\r\n", 405),
    ] {
        // A second response would follow the JSON document.
        is_last_problem(&server.raw(&request(method, lines, hidden)), status, "");
    }
    // A malformed body does not cause a second response.
    is_last_problem(&server.raw(&request("POST", "Transfer-Encoding: chunked\r\n", "ZZ\r\nabc")), 405, "");
    // A client that is still sending receives the response.
    let large = "a".repeat(8 << 20);
    is_last_problem(&server.raw(&request("POST", &format!("Content-Length: {}\r\n", large.len()), &large)), 405, "");
}

#[test]
fn unusual_requests_get_responses() {
    let server = shared();
    for (head, status) in [
        ("GET /health HTTP/1.0\r\nHost: localhost\r\n", 200),
        ("GET /health HTTP/1.0\r\n", 403),
        ("GET http://localhost/health HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n", 200),
        ("GET /health HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\nExpect: tea\r\n", 200),
        ("GET /health HTTP/1.1\r\nHost: localhost\r\nConnection: upgrade, close\r\nUpgrade: h2c\r\n", 200),
        ("BREW /health HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n", 405),
        ("OPTIONS * HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n", 404),
        ("CONNECT localhost:80 HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n", 404),
    ] {
        let response = server.raw(format!("{head}\r\n").as_bytes());
        assert_eq!(response.status, status, "{head}");
        assert_eq!(response.json()["status"], if status == 200 { json!("ok") } else { json!(status) }, "{head}");
    }
}

#[test]
fn queries_of_any_bytes_are_read() {
    let server = shared();
    let long = format!("/health?{}", "a".repeat(17_000));
    assert_eq!(server.get(&long).status, 414);
    // Bytes that are not UTF-8, and characters with a meaning in HTML.
    for query in
        ["%ff%fe", "start_utc=%00", "a=<script>", "start_utc=2026-08-14T23:29:60Z&duration_s=1e400&ra_deg=1&dec_deg=1"]
    {
        assert_eq!(server.get(&format!("/api/v1/exposure?{query}")).status, 400, "{query}");
    }
    assert_eq!(server.get("/health").status, 200);
}

#[test]
fn too_many_requests_are_refused() {
    let server = serve(&["--rate", "1"]);
    // All requests are sent at once on one connection: on a slow machine, single requests could stay below the rate
    // limit.
    let first = server.raw(&[request("GET", "", "").repeat(100), request("GET", "Connection: close\r\n", "")].concat());
    assert_eq!(first.status, 200);
    let at = first.body.windows(12).position(|window| window == b"HTTP/1.1 429").expect("a refused request");
    let refused = parse(&first.body[at..]);
    assert_eq!(refused.header("retry-after"), Some("1"));
    let mut documents = serde_json::Deserializer::from_slice(&refused.body).into_iter::<serde_json::Value>();
    assert_eq!(documents.next().unwrap().unwrap()["status"], 429);
}

#[test]
fn other_addresses_than_loopback_need_a_token() {
    let open = [&["serve"], SHARED, RULES, &["--bind", "0.0.0.0:0"]].concat();
    let (code, _, stderr) = run(&[&open]);
    assert_eq!(code, 2);
    assert!(stderr.contains("--token-file FILE or --token-env NAME"), "{stderr}");
    let (code, _, stderr) = run(&[&open, &["--token-env", "STREAKCAST_TEST_NO_SUCH"]]);
    assert!(code == 2 && stderr.contains("STREAKCAST_TEST_NO_SUCH is not set"), "{stderr}");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("token").display().to_string();
    std::fs::write(&path, "short\n").unwrap();
    let (code, _, stderr) = run(&[&open, &["--token-file", &path]]);
    assert!(code == 2 && stderr.contains("invalid token of 5 characters"), "{stderr}");

    let token = "correct-horse-battery";
    let arguments = [SHARED, RULES, &["--bind", "0.0.0.0:0", "--token-env", "STREAKCAST_TEST_TOKEN"]].concat();
    let server = Server::start_with(&arguments[..], &[("STREAKCAST_TEST_TOKEN", token)]);
    let missing = server.get("/api/v1/night");
    assert_eq!((missing.status, missing.header("www-authenticate")), (401, Some("Bearer")));
    for wrong in ["Bearer correct-horse-batterz", "Bearer ", "Basic abc", "correct-horse-battery"] {
        assert_eq!(server.send("GET", "/api/v1/night", &[("Authorization", wrong)]).status, 401, "{wrong}");
    }
    let right = format!("Bearer {token}");
    assert_eq!(
        server.send("GET", "/api/v1/night", &[("Authorization", &right), ("Host", "telescope.example")]).status,
        200
    );
    // The page requires no token; it has an input field for the token.
    assert_eq!((server.get("/").status, server.get("/health").status), (200, 200));
    assert_eq!(server.get("/fov/satellites-above-horizon/?site=rubin&julian_date=2461267.4").status, 401);
}

#[test]
fn errors_at_the_start_are_one_line() {
    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let address = taken.local_addr().unwrap().to_string();
    for (arguments, words) in [
        (vec!["--bind", address.as_str()], "cannot listen at"),
        (vec!["--bind", "localhost"], "invalid value 'localhost'"),
        (vec!["--bind", "127.0.0.1:0", "--rate", "0"], "invalid value '0'"),
        (vec!["--bind", "127.0.0.1:0", "--utc-offset", "40"], "hours ahead of UTC from -14:00 to +14:00"),
        (vec!["--bind", "127.0.0.1:0", "--schedule", "no-such-file.csv"], "no-such-file.csv"),
    ] {
        let rules: &[&str] = if arguments.contains(&"--schedule") { &[] } else { RULES };
        let (code, stdout, stderr) = run(&[&["serve"], SHARED, rules, &arguments]);
        assert_eq!((code, stdout.as_str()), (2, ""), "{stderr}");
        assert!(stderr.contains(words) && stderr.lines().count() == 1, "{stderr}");
    }
}

/// A server at another loopback address accepts requests to this address.
#[cfg(target_os = "linux")]
#[test]
fn every_loopback_address_can_be_bound() {
    for bind in ["127.0.0.2:0", "127.255.255.254:0", "[::1]:0"] {
        // Not every machine has IPv6.
        let Ok(free) = std::net::TcpListener::bind(bind) else { continue };
        let address = free.local_addr().unwrap();
        drop(free);
        let address = address.to_string();
        let _server = Server::start(&[SHARED, &["--bind", &address]].concat());
        let mut stream = TcpStream::connect(&address).unwrap();
        write!(stream, "GET /health HTTP/1.1\r\nHost: {address}\r\nConnection: close\r\n\r\n").unwrap();
        assert_eq!(read(stream).status, 200, "{address}");
    }
}

#[cfg(unix)]
#[test]
fn a_token_that_others_can_read_gives_a_warning() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("token");
    std::fs::write(&path, "correct-horse-battery\n").unwrap();
    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let address = taken.local_addr().unwrap().to_string();
    for (mode, has_warning) in [(0o644, true), (0o640, true), (0o600, false), (0o400, false)] {
        std::fs::set_permissions(&path, std::fs::Permissions::from_mode(mode)).unwrap();
        let satellites: Vec<&str> = SHARED.iter().copied().filter(|word| *word != "--quiet").collect();
        // The server does not start, because the address is in use.
        let token = ["--bind", &address, "--token-file", path.to_str().unwrap()];
        let (code, _, stderr) = run(&[&["serve"], &satellites, &token]);
        assert!(code == 2 && stderr.contains("cannot listen at"), "{stderr}");
        assert_eq!(stderr.contains("can be read by others; run chmod 600"), has_warning, "{mode:o}: {stderr}");
    }
}

#[test]
fn an_unknown_band_is_an_error_that_lists_the_bands() {
    let server = shared();
    let exposure = "start_utc=2026-08-14T23:29:05Z&duration_s=30&ra_deg=198.9&dec_deg=7.7";
    for band in ["zz", "default", "G7", "%20g"] {
        let problem = server.get(&format!("/api/v1/exposure?{exposure}&band={band}"));
        assert_eq!((problem.status, problem.json()["parameter"].as_str()), (400, Some("band")), "{band}");
        let detail = problem.json()["detail"].as_str().unwrap().to_owned();
        assert!(detail.contains("allowed: ") && detail.contains(" V,") && detail.contains(" g,"), "{detail}");
    }
    for band in ["g", "V"] {
        assert_eq!(server.get(&format!("/api/v1/exposure?{exposure}&band={band}")).status, 200, "{band}");
    }
}
