//! `streakcast fetch` with faulty servers: a valid cached file is replaced only by newer valid data, and no request is
//! sent within the waiting time of the source.

use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use assert_cmd::Command;
use serde_json::Value;
use tempfile::TempDir;

const NAME: &str = "celestrak-starlink.csv";
const NOON: &str = "2024-08-14T12:00:00Z";

fn elements(file: &str) -> Vec<u8> {
    crate::common::elements::sample(file)
}

/// Returns the CSV sample with an epoch on the day of the ephemerides.
fn elements_of_the_day() -> Vec<u8> {
    String::from_utf8(elements("sample.csv")).unwrap().replace("2026-03-20", "2024-08-14").into_bytes()
}

/// Server on a loopback address that handles each connection by the next handler and records the requests.
struct Server {
    url: String,
    requests: Arc<Mutex<Vec<String>>>,
}

type Reply = Box<dyn Fn(&mut TcpStream) + Send>;

impl Server {
    fn new(replies: Vec<Reply>) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let url = format!("http://{}", listener.local_addr().unwrap());
        let requests = Arc::new(Mutex::new(Vec::new()));
        let shared = requests.clone();
        std::thread::spawn(move || {
            for reply in replies {
                let Ok((mut stream, _)) = listener.accept() else { return };
                shared.lock().unwrap().push(request(&mut stream));
                reply(&mut stream);
            }
        });
        Self { url, requests }
    }

    fn one(reply: impl Fn(&mut TcpStream) + Send + 'static) -> Self {
        Self::new(vec![Box::new(reply)])
    }

    fn requests(&self) -> Vec<String> {
        self.requests.lock().unwrap().clone()
    }
}

/// Reads the head and, if its length is stated, the body of a request. A TLS handshake starts with byte 22 and has no
/// head; only its first bytes are read.
fn request(stream: &mut TcpStream) -> String {
    let mut bytes = Vec::new();
    let mut buffer = [0; 4096];
    loop {
        let text = String::from_utf8_lossy(&bytes).into_owned();
        if let Some((head, body)) = text.split_once("\r\n\r\n") {
            let length = head.lines().find_map(|line| {
                line.to_ascii_lowercase().strip_prefix("content-length: ").map(|n| n.parse().unwrap_or(0))
            });
            if body.len() >= length.unwrap_or(0) {
                return text;
            }
        }
        match stream.read(&mut buffer) {
            Ok(count) if count > 0 && buffer[0] == 22 => return text,
            Ok(count) if count > 0 => bytes.extend_from_slice(&buffer[..count]),
            _ => return text,
        }
    }
}

fn send(stream: &mut TcpStream, bytes: &[u8]) {
    // The client may have closed the connection.
    let _ = stream.write_all(bytes);
}

fn respond(stream: &mut TcpStream, status: &str, headers: &str, body: &[u8]) {
    send(
        stream,
        format!("HTTP/1.1 {status}\r\nConnection: close\r\n{headers}Content-Length: {}\r\n\r\n", body.len()).as_bytes(),
    );
    send(stream, body);
}

fn ok(body: Vec<u8>, headers: &'static str) -> impl Fn(&mut TcpStream) + Send + 'static {
    move |stream| respond(stream, "200 OK", headers, &body)
}

struct Cache(TempDir);

impl Cache {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn folder(&self) -> &Path {
        self.0.path()
    }

    fn file(&self) -> PathBuf {
        self.folder().join(NAME)
    }

    fn record(&self) -> Value {
        serde_json::from_slice(&std::fs::read(self.folder().join(format!("{NAME}.fetch.json"))).unwrap()).unwrap()
    }

    fn run(&self, server: &str, now: &str, more: &[&str]) -> (i32, String, String) {
        self.source(&["celestrak", "--group", "starlink"], server, now, more)
    }

    fn source(&self, source: &[&str], server: &str, now: &str, more: &[&str]) -> (i32, String, String) {
        let mut command = Command::new(env!("CARGO_BIN_EXE_streakcast"));
        command.env("STREAKCAST_NO_HOME", "1");
        // Proxies of the machine must not be used for loopback addresses.
        for name in ["http_proxy", "HTTP_PROXY", "https_proxy", "HTTPS_PROXY", "all_proxy", "ALL_PROXY"] {
            command.env_remove(name);
        }
        command.arg("fetch").args(source).args(["--cache", &self.folder().display().to_string()]);
        let output = command.args(["--base-url", server, "--now", now]).args(more).output().unwrap();
        let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
        (output.status.code().unwrap(), text(output.stdout), text(output.stderr))
    }

    /// Returns a cache with a valid file that is two days old, so that the waiting time is over.
    fn filled() -> Self {
        let cache = Self::new();
        let headers = "Content-Type: text/csv\r\nETag: \"abc\"\r\nLast-Modified: Mon, 12 Aug 2024 10:00:00 GMT\r\n";
        let server = Server::one(ok(elements("sample.csv"), headers));
        let (code, stdout, stderr) = cache.run(&server.url, "2024-08-12T12:00:00Z", &[]);
        assert_eq!(code, 0, "{stderr}");
        assert_eq!(stdout.trim_end(), cache.file().display().to_string());
        cache
    }
}

#[test]
fn a_response_is_stored_with_its_source() {
    let cache = Cache::filled();
    assert_eq!(std::fs::read(cache.file()).unwrap(), elements("sample.csv"));
    let record = cache.record();
    assert!(record["url"].as_str().unwrap().ends_with("/NORAD/elements/gp.php?GROUP=starlink&FORMAT=csv"), "{record}");
    assert_eq!((&record["fetched_utc"], &record["etag"]), (&"2024-08-12T12:00:00Z".into(), &"\"abc\"".into()));
    assert_eq!(record["sha256"].as_str().unwrap().len(), 64);
    assert_eq!((&record["records"], &record["answer"]), (&1.into(), &"200 OK".into()));
    assert_eq!(record["not_before_utc"], "2024-08-12T14:00:00Z");
}

#[test]
fn within_the_waiting_time_no_request_is_sent_and_the_cached_file_is_used() {
    let cache = Cache::filled();
    let server = Server::new(Vec::new());
    let (code, stdout, stderr) = cache.run(&server.url, "2024-08-12T13:59:00Z", &[]);
    assert_eq!((code, stdout.trim_end()), (0, cache.file().display().to_string().as_str()), "{stderr}");
    assert!(
        stderr.contains("https://celestrak.org/usage-policy.php")
            && stderr.contains("the next one is allowed in 1 min"),
        "{stderr}"
    );
    assert!(server.requests().is_empty());
    // A failed request without a cached file is an error.
    std::fs::remove_file(cache.file()).unwrap();
    let (code, stdout, stderr) = cache.run(&server.url, "2024-08-12T13:59:00Z", &[]);
    assert_eq!((code, stdout.as_str()), (2, ""), "{stderr}");
    assert!(stderr.contains("no file is cached"), "{stderr}");
}

#[test]
fn later_requests_are_conditional_and_304_keeps_the_file() {
    let cache = Cache::filled();
    let server = Server::one(|stream| respond(stream, "304 Not Modified", "", b""));
    let (code, stdout, stderr) = cache.run(&server.url, NOON, &[]);
    assert_eq!((code, stdout.trim_end()), (0, cache.file().display().to_string().as_str()), "{stderr}");
    let requests = server.requests()[0].to_ascii_lowercase();
    assert!(
        requests.contains("if-none-match: \"abc\"") && requests.contains("if-modified-since: mon, 12 aug 2024"),
        "{requests}"
    );
    let record = cache.record();
    assert_eq!((&record["fetched_utc"], &record["asked_utc"]), (&"2024-08-12T12:00:00Z".into(), &NOON.into()));
    assert_eq!(std::fs::read(cache.file()).unwrap(), elements("sample.csv"));
    // "Not modified" does not apply to a file that was changed locally.
    std::fs::write(cache.file(), elements("sample.2le")).unwrap();
    let server = Server::one(ok(elements("sample.csv"), ""));
    assert_eq!(cache.run(&server.url, "2024-08-15T12:00:00Z", &[]).0, 0);
    assert!(!server.requests()[0].to_ascii_lowercase().contains("if-none-match"));
}

#[test]
fn a_newer_file_replaces_the_old_one() {
    let cache = Cache::filled();
    let newer = crate::common::elements::gzip(&elements("sample.csv"));
    let server = Server::one(ok(newer, "Content-Encoding: gzip\r\nContent-Type: text/csv\r\n"));
    let (code, _, stderr) = cache.run(&server.url, NOON, &[]);
    assert_eq!(code, 0, "{stderr}");
    assert_eq!(std::fs::read(cache.file()).unwrap(), elements("sample.csv"));
    assert_eq!(cache.record()["fetched_utc"], NOON);
}

/// Files of earlier days are kept in a folder, the newest one and the first one of each block of four days.
#[test]
fn older_files_are_kept_by_date() {
    let cache = Cache::new();
    let folder = cache.folder().join(format!("{NAME}.days"));
    let names = || -> Vec<String> {
        let mut names: Vec<String> = std::fs::read_dir(&folder)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    };
    for day in ["2024-08-02", "2024-08-03", "2024-08-06", "2024-08-14"] {
        let server = Server::one(ok(elements("sample.csv"), ""));
        let (code, stdout, stderr) = cache.run(&server.url, &format!("{day}T12:00:00Z"), &["--with-older"]);
        assert_eq!((code, stdout.trim_end()), (0, folder.display().to_string().as_str()), "{stderr}");
        assert!(names().contains(&format!("{day}.csv")), "{day}: {:?}", names());
    }
    // 3 August is in the same block of four days as 2 August.
    assert_eq!(names(), ["2024-08-02.csv", "2024-08-06.csv", "2024-08-14.csv"]);
    // Without the flag, the path of the file is printed, and the folder is kept as well.
    let server = Server::one(ok(elements("sample.csv"), ""));
    let (_, stdout, _) = cache.run(&server.url, "2024-08-20T12:00:00Z", &[]);
    assert_eq!(stdout.trim_end(), cache.file().display().to_string());
    assert_eq!(names(), ["2024-08-06.csv", "2024-08-14.csv", "2024-08-20.csv"]);
    // A file from a cache of an earlier version is added without a request.
    std::fs::remove_dir_all(&folder).unwrap();
    let server = Server::new(Vec::new());
    let (code, _, stderr) = cache.run(&server.url, "2024-08-20T12:30:00Z", &["--with-older"]);
    assert_eq!((code, names()), (0, vec!["2024-08-20.csv".to_owned()]), "{stderr}");
}

/// After each kind of failure, the valid file is kept, the sidecar contains the reason, and the next request must wait.
#[test]
fn no_failure_replaces_a_valid_file() {
    let status = |status: &'static str, headers: &'static str, body: &'static str| -> Reply {
        Box::new(move |stream| respond(stream, status, headers, body.as_bytes()))
    };
    let good = elements("sample.csv");
    let (half, long) = (good.clone(), good.clone());
    let cases: Vec<(Reply, &[&str], &str)> = vec![
        (
            status("403 Forbidden", "", "GP data has not updated since your last successful download"),
            &[],
            "403 Forbidden; it begins: GP data has not",
        ),
        (status("404 Not Found", "", ""), &[], "404 Not Found"),
        (status("429 Too Many Requests", "Retry-After: 60\r\n", ""), &[], "429"),
        (status("500 Internal Server Error", "", "oops"), &[], "500 Internal Server Error; it begins: oops"),
        (
            status("301 Moved Permanently", "Location: http://127.0.0.1:9/\r\n", ""),
            &[],
            "to http://127.0.0.1:9/ (not followed)",
        ),
        (status("302 Found", "Location: /NORAD/elements/gp.php?GROUP=starlink&FORMAT=csv\r\n", ""), &[], "302 Found"),
        (status("206 Partial Content", "", "x"), &[], "206"),
        (
            status("200 OK", "Content-Type: text/html\r\n", "<!DOCTYPE html><html><body>Maintenance</body></html>"),
            &[],
            "no element sets (it begins: <!DOCTYPE html>",
        ),
        (status("200 OK", "", "No GP data found"), &[], "it begins: No GP data found"),
        (status("200 OK", "Content-Type: image/png\r\n", "\u{1}PNG"), &[], "no element sets"),
        (status("200 OK", "", ""), &[], "nothing"),
        (status("200 OK", "Content-Encoding: gzip\r\n", "this is not gzip"), &[], "with a truncated body"),
        // The response states more bytes than are sent.
        (
            Box::new(move |stream| {
                send(stream, format!("HTTP/1.1 200 OK\r\nContent-Length: {}\r\n\r\n", half.len()).as_bytes());
                send(stream, &half[..half.len() / 2]);
            }),
            &[],
            "with a truncated body",
        ),
        // The length of the response is not stated, and its last record is truncated.
        (
            Box::new(move |stream| {
                send(stream, b"HTTP/1.1 200 OK\r\nConnection: close\r\n\r\n");
                send(stream, &long[..long.len() - 40]);
            }),
            &[],
            "the response has no element sets",
        ),
        // The connection is closed before the last chunk.
        (
            Box::new(|stream| send(stream, b"HTTP/1.1 200 OK\r\nTransfer-Encoding: chunked\r\n\r\n5\r\nOBJEC\r\n")),
            &[],
            "with a truncated body",
        ),
        // The response is larger than the limit.
        (Box::new(ok(vec![b'1'; 5_000], "")), &["--max-bytes", "1000"], "more than the limit of 1000 bytes"),
        // The server sends single bytes at long intervals.
        (
            Box::new(|stream| {
                send(stream, b"HTTP/1.1 200 OK\r\nContent-Length: 1000000\r\n\r\n");
                // Until the client closes the connection.
                while stream.write_all(b"1").is_ok() {
                    std::thread::sleep(Duration::from_millis(50));
                }
            }),
            &["--timeout", "5s"],
            "with a truncated body",
        ),
        // The server does not respond.
        (Box::new(|stream| _ = stream.read(&mut [0])), &["--timeout", "5s"], "no response"),
        // The connection is closed at once, or the response is not HTTP.
        (Box::new(|_| {}), &[], "no response"),
        (Box::new(|stream| send(stream, b"SSH-2.0-OpenSSH_9.6\r\n")), &[], "no response"),
    ];
    for (reply, more, expected) in cases {
        let cache = Cache::filled();
        let server = Server::new(vec![reply]);
        let (code, stdout, stderr) = cache.run(&server.url, NOON, more);
        assert_eq!((code, stdout.as_str()), (2, ""), "{expected}: {stderr}");
        let error = stderr.lines().last().unwrap();
        assert!(error.starts_with("error: CelesTrak: ") && error.contains(expected), "{expected}: {stderr}");
        assert!(error.contains("is unchanged; next request allowed from 2024-08-14T14:00:00Z"), "{stderr}");
        assert_eq!(std::fs::read(cache.file()).unwrap(), elements("sample.csv"), "{expected}");
        let record = cache.record();
        assert_eq!(
            (&record["fetched_utc"], &record["asked_utc"]),
            (&"2024-08-12T12:00:00Z".into(), &NOON.into()),
            "{record}"
        );
        assert_eq!(server.requests().len(), 1, "{expected}");
        // The failure is recorded: the old file is used with a warning, and no request is sent.
        let (code, stdout, stderr) = cache.run(&server.url, "2024-08-14T13:00:00Z", &[]);
        assert_eq!((code, stdout.trim_end()), (0, cache.file().display().to_string().as_str()), "{stderr}");
        assert!(stderr.contains("warning: the last request to CelesTrak was at 2024-08-14T12:00:00Z"), "{stderr}");
        assert_eq!(server.requests().len(), 1);
        // No partial file remains.
        let left: Vec<_> = std::fs::read_dir(cache.folder())
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        assert!(left.iter().all(|name| name.starts_with(NAME)), "{left:?}");
    }
}

/// Unknown host name, closed port, failing TLS: no request is sent, so that no waiting time starts.
#[test]
fn failed_connections_start_no_waiting_time() {
    let gone = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
    let plain = Server::one(|stream| send(stream, b"HTTP/1.1 400 Bad Request\r\n\r\n"));
    for url in
        [format!("http://{gone}"), "http://no-such-host.invalid".to_owned(), plain.url.replace("http:", "https:")]
    {
        let cache = Cache::filled();
        let before = cache.record();
        let (code, stdout, stderr) = cache.run(&url, NOON, &[]);
        assert_eq!((code, stdout.as_str()), (2, ""), "{url}: {stderr}");
        let error = stderr.lines().last().unwrap();
        assert!(error.starts_with("error: CelesTrak: not reached: "), "{url}: {stderr}");
        assert!(error.contains("is unchanged; no request was sent; you may retry now"), "{url}: {stderr}");
        assert_eq!(std::fs::read(cache.file()).unwrap(), elements("sample.csv"));
        assert_eq!(cache.record(), before, "{url}");
        // A minute later the network is available.
        let server = Server::one(|stream| respond(stream, "304 Not Modified", "", b""));
        assert_eq!(cache.run(&server.url, "2024-08-14T12:01:00Z", &[]).0, 0, "{url}");
        assert_eq!(server.requests().len(), 1, "{url}");
    }
    // A first request that fails leaves no record that delays the next one.
    let cache = Cache::new();
    assert_eq!(cache.run(&format!("http://{gone}"), NOON, &[]).0, 2);
    assert!(!cache.folder().join(format!("{NAME}.fetch.json")).exists());
    let server = Server::one(ok(elements("sample.csv"), ""));
    assert_eq!(cache.run(&server.url, NOON, &[]).0, 0);
}

/// If a login does not reach the server, no waiting time starts.
#[test]
fn a_login_without_connection_starts_no_waiting_time() {
    let cache = Cache::new();
    let account = cache.folder().join("account");
    std::fs::write(&account, "me\nsecret\n").unwrap();
    let words = ["space-track", "--credentials", &account.display().to_string()];
    let gone = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
    let (code, _, stderr) = cache.source(&words, &format!("http://{gone}"), NOON, &[]);
    assert!(code == 2 && stderr.contains("no request was sent; you may retry now"), "{stderr}");
    // If the server receives the login and then disconnects, the waiting time starts.
    let server = Server::one(|_| {});
    let (code, _, stderr) = cache.source(&words, &server.url, NOON, &[]);
    assert!(
        code == 2 && stderr.contains("no response to the login") && stderr.contains("next request allowed"),
        "{stderr}"
    );
}

#[test]
fn a_cache_path_that_is_a_file_is_rejected() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a-file");
    std::fs::write(&file, "x").unwrap();
    for (cache, expected) in [
        (file.clone(), "is a file; allowed: a folder, or the name of a new one"),
        (file.join("below"), "allowed: a writable folder"),
    ] {
        let output = Command::new(env!("CARGO_BIN_EXE_streakcast"))
            .env("STREAKCAST_NO_HOME", "1")
            .args(["fetch", "celestrak", "--group", "starlink", "--cache"])
            .arg(&cache)
            .args(["--base-url", "http://127.0.0.1:9", "--now", NOON])
            .output()
            .unwrap();
        let stderr = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.code() == Some(2) && stderr.contains(expected), "{stderr}");
    }
}

#[test]
fn a_file_with_far_fewer_records_is_rejected_without_a_flag() {
    let cache = Cache::new();
    let many: String = (0..10).map(|id| crate::common::elements::pair(90_000 + id, "223.50000000")).collect();
    let tle = ["celestrak", "--group", "starlink", "--elements-format", "tle"];
    let server = Server::one(ok(many.clone().into_bytes(), ""));
    let (code, stdout, stderr) = cache.source(&tle, &server.url, "2024-08-12T12:00:00Z", &[]);
    assert_eq!(code, 0, "{stderr}");
    let few = crate::common::elements::pair(90_000, "224.50000000").into_bytes();
    let server = Server::one(ok(few.clone(), ""));
    let (code, _, stderr) = cache.source(&tle, &server.url, NOON, &[]);
    assert!(code == 2 && stderr.contains("1 record instead of 10"), "{stderr}");
    assert_eq!(std::fs::read_to_string(stdout.trim_end()).unwrap(), many);
    let server = Server::one(ok(few, ""));
    let (code, _, stderr) = cache.source(&tle, &server.url, "2024-08-16T12:00:00Z", &["--accept-fewer"]);
    assert_eq!(code, 0, "{stderr}");
}

#[test]
fn space_track_logs_in_and_out_and_the_account_is_not_stored() {
    let cache = Cache::new();
    let account = cache.folder().join("account");
    std::fs::write(&account, "me@example.org\nhunter+2&x=y\n").unwrap();
    #[cfg(unix)]
    std::fs::set_permissions(&account, std::os::unix::fs::PermissionsExt::from_mode(0o600)).unwrap();
    let server = Server::new(vec![
        Box::new(|stream| respond(stream, "200 OK", "Set-Cookie: chocolatechip=123; path=/; HttpOnly\r\n", b"\"\"")),
        Box::new(ok(elements("sample.csv"), "")),
        Box::new(|stream| respond(stream, "200 OK", "", b"\"Successfully logged out\"")),
    ]);
    let words = ["space-track", "--credentials", &account.display().to_string()];
    let (code, stdout, stderr) = cache.source(&words, &server.url, NOON, &[]);
    assert_eq!(code, 0, "{stderr}");
    let requests = server.requests();
    assert!(
        requests[0].starts_with("POST /ajaxauth/login ")
            && requests[0].ends_with("identity=me%40example.org&password=hunter%2B2%26x%3Dy"),
        "{}",
        requests[0]
    );
    assert!(
        requests[1].starts_with("GET /basicspacedata/query/class/gp/decay_date/null-val/epoch/%3Enow-30/"),
        "{}",
        requests[1]
    );
    assert!(requests[1].to_ascii_lowercase().contains("cookie: chocolatechip=123"), "{}", requests[1]);
    assert!(requests[2].starts_with("GET /ajaxauth/logout "), "{}", requests[2]);
    let record = std::fs::read_to_string(format!("{}.fetch.json", stdout.trim_end())).unwrap();
    for text in [&stdout, &stderr, &record] {
        assert!(!text.contains("hunter") && !text.contains("example.org"), "{text}");
    }
    // The status for a wrong password is also 200.
    let server =
        Server::one(|stream| respond(stream, "200 OK", "Set-Cookie: chocolatechip=1\r\n", b"{\"Login\":\"Failed\"}"));
    let (code, _, stderr) = cache.source(&words, &server.url, "2024-08-15T12:00:00Z", &[]);
    assert!(code == 2 && stderr.contains("the account was refused") && !stderr.contains("hunter"), "{stderr}");
    assert_eq!(server.requests().len(), 1);
    // User name and password are read from environment variables.
    let (code, _, stderr) = cache.source(
        &["space-track", "--identity-env", "NO_SUCH_A", "--password-env", "NO_SUCH_B"],
        &server.url,
        "2024-08-16T12:00:00Z",
        &[],
    );
    assert!(code == 2 && stderr.contains("NO_SUCH_A of --identity-env is not set"), "{stderr}");
}

#[test]
fn supgp_and_satchecker_have_separate_addresses() {
    let cache = Cache::new();
    let server = Server::one(ok(elements("sample.csv"), ""));
    let (code, _, stderr) = cache.source(&["supgp", "--file", "starlink"], &server.url, NOON, &[]);
    assert_eq!(code, 0, "{stderr}");
    assert!(server.requests()[0].starts_with("GET /NORAD/elements/supplemental/sup-gp.php?FILE=starlink&FORMAT=csv "));
    let server = Server::one(ok(elements("sample.2le"), ""));
    let (code, stdout, stderr) =
        cache.source(&["satchecker", "--epoch", "2024-08-14T00:00:00Z"], &server.url, NOON, &[]);
    assert_eq!(code, 0, "{stderr}");
    // JD 2460536.5 is 2024-08-14 00:00 UTC.
    assert!(
        server.requests()[0].starts_with("GET /tools/tles-at-epoch/?epoch=2460536.5000&format=txt "),
        "{:?}",
        server.requests()
    );
    assert!(stdout.trim_end().ends_with("satchecker-2460536.5000.tle"), "{stdout}");
}

#[test]
fn invalid_arguments_send_no_request() {
    let cache = Cache::new();
    let server = Server::new(Vec::new());
    for (words, expected) in [
        (vec!["celestrak", "--group", "../../etc"], "invalid group '../../etc'; allowed"),
        (vec!["celestrak", "--group", "a&b"], "allowed: 1 to 64 letters"),
        (vec!["satchecker", "--epoch", "yesterday"], "yesterday"),
        (vec!["celestrak", "--group", "x", "--timeout", "5"], "timeout is 5, without a unit"),
        (vec!["space-track"], "--credentials"),
        (vec!["space-track", "--credentials", "/no/such/file"], "credentials /no/such/file"),
    ] {
        let (code, stdout, stderr) = cache.source(&words, &server.url, NOON, &[]);
        assert_eq!((code, stdout.as_str()), (2, ""), "{words:?}");
        assert!(stderr.lines().last().unwrap().contains(expected), "{words:?}: {stderr}");
    }
    assert!(server.requests().is_empty());
}

/// The time of a request is recorded before the response arrives, so that it is known after a crash.
#[test]
fn a_request_without_a_response_starts_the_waiting_time() {
    let cache = Cache::filled();
    let path = cache.folder().join(format!("{NAME}.fetch.json"));
    let mut record = cache.record();
    record["asked_utc"] = NOON.into();
    record["answer"] = "no response yet".into();
    std::fs::write(&path, record.to_string()).unwrap();
    let server = Server::new(Vec::new());
    let (code, _, stderr) = cache.run(&server.url, "2024-08-14T12:30:00Z", &[]);
    assert!(code == 0 && stderr.contains("(no response yet); the next one is allowed in 90 min"), "{stderr}");
}

const EPHEMERIS: &str = "MEME_90001_INVENTED-1_2270000_Operational_1407628800_UNCLASSIFIED.txt";

/// Returns the invented ephemeris, not compressed, as published by the server.
fn ephemeris() -> Vec<u8> {
    let path = crate::common::golden_dir().join("ephemerides").join(format!("{EPHEMERIS}.gz"));
    let mut bytes = Vec::new();
    flate2::read::GzDecoder::new(std::fs::File::open(path).unwrap()).read_to_end(&mut bytes).unwrap();
    bytes
}

/// Returns a manifest with an older file of the satellite, another satellite, and names that are not ephemeris files.
fn manifest() -> Vec<u8> {
    let older = EPHEMERIS.replace("2270000", "2261600").replace("1407628800", "1407600000");
    let other = EPHEMERIS.replace("90001", "90002");
    format!("{EPHEMERIS}\n{older}\n{other}\n../MEME_90001_X_Y_Operational_9999999999_UNCLASSIFIED.txt\nREADME\n")
        .into_bytes()
}

#[test]
fn ephemerides_of_candidates_are_fetched_once_and_used() {
    let cache = Cache::new();
    let table = cache.folder().join("verdicts.csv");
    std::fs::write(&table, "# software: streakcast\nid,norad_ids\n1,90001 44713\n2,\n3,90001\n").unwrap();
    let source = ["starlink-ephemerides", "--candidates", table.to_str().unwrap()];
    let server = Server::new(vec![Box::new(ok(manifest(), "")), Box::new(ok(ephemeris(), ""))]);
    let (code, stdout, stderr) = cache.source(&source, &server.url, "2024-08-14T00:30:00Z", &[]);
    assert_eq!(code, 0, "{stderr}");
    let file = cache.folder().join(EPHEMERIS);
    assert_eq!(stdout.trim_end(), file.display().to_string());
    assert!(stderr.contains("1 of 2 satellites with ephemerides; 1 downloaded, 0 in the cache before"), "{stderr}");
    let requests = server.requests();
    assert!(requests[0].starts_with("GET /public-files/ephemerides/MANIFEST.txt "), "{requests:?}");
    assert!(requests[1].starts_with(&format!("GET /public-files/ephemerides/{EPHEMERIS} ")), "{requests:?}");

    // Within the waiting time, and with the file in the cache, no request is sent.
    let idle = Server::new(Vec::new());
    let (code, again, stderr) = cache.source(&source, &idle.url, "2024-08-14T01:00:00Z", &[]);
    assert_eq!((code, again), (0, stdout), "{stderr}");
    assert!(idle.requests().is_empty());

    // The ephemeris is used together with the element set of the same satellite; outside its time range the element set
    // is used.
    let elements = cache.folder().join("elements.csv");
    std::fs::write(&elements, elements_of_the_day()).unwrap();
    let forecast = |start: &str, end: &str| {
        let output = Command::new(env!("CARGO_BIN_EXE_streakcast"))
            .env("STREAKCAST_NO_HOME", "1")
            .args(["forecast", "--lat", "0", "--lon", "0", "--include-dark", "--format", "json", "--elements"])
            .args([&elements, &file])
            .args(["--start", start, "--end", end])
            .output()
            .unwrap();
        let answer: Value = serde_json::from_slice(&output.stdout).unwrap();
        (answer["provenance"]["ephemerides"].clone(), String::from_utf8(output.stderr).unwrap())
    };
    let (used, stderr) = forecast("2024-08-14T00:10:00Z", "2024-08-14T01:20:00Z");
    assert_eq!((&used["satellites_covered"], &used["satellites_not_covered"]), (&1.into(), &0.into()), "{used}");
    assert!(!stderr.contains("do not cover"), "{stderr}");
    let (used, stderr) = forecast("2024-08-14T00:10:00Z", "2024-08-14T05:20:00Z");
    assert_eq!((&used["satellites_covered"], &used["partly_covered"][0]), (&0.into(), &"SAMPLE & SON (90001)".into()));
    assert!(stderr.contains("the ephemerides of 1 of 1 satellite do not cover the whole time"), "{stderr}");
    let (used, _) = forecast("2024-08-15T00:10:00Z", "2024-08-15T05:20:00Z");
    assert_eq!((&used["satellites_not_covered"], &used["not_covered"][0]), (&1.into(), &"SAMPLE & SON (90001)".into()));
}

#[test]
fn a_truncated_ephemeris_is_not_stored() {
    let cache = Cache::new();
    let whole = ephemeris();
    let cut = whole[..whole.len() / 2].to_vec();
    let server = Server::new(vec![Box::new(ok(manifest(), "")), Box::new(ok(cut, ""))]);
    let source = ["starlink-ephemerides", "--norad", "90001"];
    let (code, stdout, stderr) = cache.source(&source, &server.url, "2024-08-14T00:30:00Z", &[]);
    assert!(code != 0 && stdout.is_empty(), "{stdout}");
    assert!(stderr.contains(&format!("{EPHEMERIS}:")) && stderr.contains("may be truncated"), "{stderr}");
    assert!(!cache.folder().join(EPHEMERIS).exists());
    // Errors for satellites without an ephemeris, and for too many satellites.
    let (code, _, stderr) =
        cache.source(&["starlink-ephemerides", "--norad", "44713"], &server.url, "2024-08-14T00:31:00Z", &[]);
    assert!(code != 0 && stderr.contains("none of the satellites has an ephemeris"), "{stderr}");
    let (code, _, stderr) = cache.source(&source, &server.url, "2024-08-14T00:31:00Z", &["--max-satellites", "0"]);
    assert!(code != 0 && stderr.contains("the number of satellites is 1; allowed: 1 to 0"), "{stderr}");
}

/// After a refused request, no request for any satellite is sent to the source within the waiting time.
#[test]
fn a_refused_ephemeris_starts_the_waiting_time() {
    let cache = Cache::new();
    let refuse = |stream: &mut TcpStream| respond(stream, "429 Too Many Requests", "", b"slow down");
    let server = Server::new(vec![Box::new(ok(manifest(), "")), Box::new(refuse)]);
    let source = |norad: &'static str| ["starlink-ephemerides", "--norad", norad];
    let (code, stdout, stderr) = cache.source(&source("90001"), &server.url, "2024-08-14T00:30:00Z", &[]);
    assert!(code != 0 && stdout.is_empty() && stderr.contains("429 Too Many Requests"), "{stderr}");
    assert!(stderr.contains("0 of 1 files were downloaded"), "{stderr}");
    assert_eq!(server.requests().len(), 2);
    // Request and response are recorded in the sidecars of the file and of the manifest.
    for name in [EPHEMERIS, "starlink-ephemerides.manifest.txt"] {
        let text = std::fs::read(cache.folder().join(format!("{name}.fetch.json"))).unwrap();
        let record: Value = serde_json::from_slice(&text).unwrap();
        assert_eq!(record["asked_utc"], "2024-08-14T00:30:00Z", "{record}");
        assert!(record["answer"].as_str().unwrap().contains("429 Too Many Requests"), "{record}");
        assert!(record["url"].as_str().unwrap().starts_with(&server.url), "{record}");
    }
    let idle = Server::new(Vec::new());
    for norad in ["90001", "90002"] {
        let (code, _, stderr) = cache.source(&source(norad), &idle.url, "2024-08-14T00:40:00Z", &[]);
        assert!(code != 0 && stderr.contains("the last request to Starlink ephemerides was at 2024-08-14T00:30:00Z ("));
        assert!(stderr.contains("429 Too Many Requests") && stderr.contains("the next one is allowed in "), "{stderr}");
    }
    assert!(idle.requests().is_empty());
    // After the waiting time, the manifest and the file are requested again.
    let server = Server::new(vec![Box::new(ok(manifest(), "")), Box::new(ok(ephemeris(), ""))]);
    let (code, _, stderr) = cache.source(&source("90001"), &server.url, "2024-08-14T12:00:00Z", &[]);
    assert_eq!((code, server.requests().len()), (0, 2), "{stderr}");
    let text = std::fs::read(cache.folder().join(format!("{EPHEMERIS}.fetch.json"))).unwrap();
    let record: Value = serde_json::from_slice(&text).unwrap();
    assert_eq!((&record["answer"], &record["records"]), (&"200 OK".into(), &91.into()), "{record}");
}

/// A refused manifest also starts the waiting time; an address that is not reached does not.
#[test]
fn a_refused_manifest_starts_the_waiting_time() {
    let cache = Cache::new();
    let source = ["starlink-ephemerides", "--norad", "90001"];
    let (code, _, stderr) = cache.source(&source, "http://127.0.0.1:1", "2024-08-14T00:20:00Z", &[]);
    assert!(code != 0 && stderr.contains("you may retry now"), "{stderr}");
    assert!(!cache.folder().join("starlink-ephemerides.manifest.txt.fetch.json").exists());
    let server = Server::one(|stream| respond(stream, "503 Service Unavailable", "", b""));
    let (code, _, stderr) = cache.source(&source, &server.url, "2024-08-14T00:30:00Z", &[]);
    assert!(code != 0 && stderr.contains("503 Service Unavailable"), "{stderr}");
    let idle = Server::new(Vec::new());
    let (code, _, stderr) = cache.source(&source, &idle.url, "2024-08-14T00:40:00Z", &[]);
    assert!(code != 0 && stderr.contains("the next one is allowed in "), "{stderr}");
    assert!(idle.requests().is_empty());
}

#[cfg(unix)]
#[test]
fn candidates_in_a_named_pipe_are_rejected() {
    let cache = Cache::new();
    let pipe = cache.folder().join("pipe.csv");
    assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let idle = Server::new(Vec::new());
    let source = ["starlink-ephemerides", "--candidates", pipe.to_str().unwrap()];
    let (code, _, stderr) = cache.source(&source, &idle.url, "2024-08-14T00:30:00Z", &[]);
    assert!(code != 0 && stderr.contains("pipe.csv: is a named pipe; allowed: a file"), "{stderr}");
}

/// The number of records of an ephemeris is not compared with that of the previous file.
#[test]
fn accept_fewer_is_rejected_for_ephemerides() {
    let cache = Cache::new();
    let idle = Server::new(Vec::new());
    let source = ["starlink-ephemerides", "--norad", "90001"];
    let (code, _, stderr) = cache.source(&source, &idle.url, "2024-08-14T00:30:00Z", &["--accept-fewer"]);
    assert!(code == 2 && stderr.contains("--accept-fewer"), "{stderr}");
}

/// Every output with positions states their source, and `doctor` reports the number of ephemerides.
#[test]
fn the_source_of_positions_is_stated() {
    let folder = TempDir::new().unwrap();
    let path = |name: &str, bytes: &[u8]| {
        let file = folder.path().join(name);
        std::fs::write(&file, bytes).unwrap();
        file.display().to_string()
    };
    let elements = path("gp.csv", &elements_of_the_day());
    let used = path(EPHEMERIS, &ephemeris());
    let without = path(&EPHEMERIS.replace("90001_INVENTED-1", "90002_INVENTED-2"), &ephemeris());
    let run = |words: &[&str]| {
        let output = Command::new(env!("CARGO_BIN_EXE_streakcast"))
            .env("STREAKCAST_NO_HOME", "1")
            .args(words)
            // The site is below the satellite at 00:40.
            .args(["--lat", "22", "--lon=-171", "--format", "json", "--elements", &elements, &used, &without])
            .output()
            .unwrap();
        let stderr = String::from_utf8(output.stderr).unwrap();
        let answer: Value = serde_json::from_slice(&output.stdout).unwrap_or_else(|_| panic!("{stderr}"));
        (answer, stderr)
    };
    let source = |row: &Value| row["position_source"].as_str().unwrap_or_default().to_owned();
    let of_file = format!("ephemeris {EPHEMERIS}");
    let times = ["--times", "2024-08-14T00:40:00Z", "2024-08-14T05:00:00Z"];
    let (answer, stderr) = run(&[&["ephemeris", "--norad", "90001"][..], &times].concat());
    let rows = answer["ephemeris"].as_array().unwrap();
    assert_eq!(rows.iter().map(source).collect::<Vec<_>>(), [of_file.as_str(), "element set"]);
    // The warning names the satellite without an element set.
    assert!(stderr.contains("INVENTED-2 (90002)") && stderr.contains("no element set"), "{stderr}");

    // Field at the position of the satellite.
    let [ra, dec] = ["ra_deg", "dec_deg"].map(|name| format!("{}deg", rows[0][name].as_f64().unwrap()));
    let exposure = ["--start", "2024-08-14T00:39:55Z", "--exposure", "10s", "--include-dark"];
    let (answer, _) = run(&[&["passes", "--ra", &ra, "--dec", &dec, "--fov", "5deg"][..], &exposure].concat());
    assert_eq!(source(&answer["passes"][0]), of_file, "{answer}");
    let span = ["--start", "2024-08-14T00:10:00Z", "--end", "2024-08-14T01:20:00Z", "--include-dark"];
    let (answer, _) = run(&[&["forecast"][..], &span].concat());
    let passes = answer["passes"].as_array().unwrap();
    assert!(!passes.is_empty() && passes.iter().all(|pass| source(pass) == of_file), "{answer}");

    let cache = folder.path().join("cache").display().to_string();
    let doctor = |now: &str| {
        let (answer, _) = run(&["doctor", "--now", now, "--cache", &cache]);
        let all = answer["findings"].as_array().unwrap().clone();
        all.into_iter().filter(|one| one["subject"] == "ephemerides").collect::<Vec<_>>()
    };
    let is = |one: &Value, severity: &str, text: &str| {
        one["severity"] == severity && one["finding"].as_str().unwrap().contains(text)
    };
    let found = doctor("2024-08-14T00:30:00Z");
    let expected = "2 ephemerides, 2 with a covariance, median age 0.0 days; 2 cover 2024-08-14T00:30:00Z";
    assert!(found.len() == 2 && found.iter().any(|one| is(one, "fine", expected)), "{found:?}");
    assert!(found.iter().any(|one| is(one, "warning", "INVENTED-2 (90002)")), "{found:?}");
    let found = doctor("2024-08-15T23:30:00Z");
    assert!(found.iter().any(|one| is(one, "warning", "median age 2.0 days; 0 cover")), "{found:?}");
}

/// The next request is allowed after the time that the source states, if this is longer than its usual waiting time.
#[test]
fn retry_after_is_obeyed() {
    for (header, not_before) in [
        ("Retry-After: 86400\r\n", "2024-08-15T12:00:00Z"),
        ("Retry-After: Fri, 16 Aug 2024 00:00:00 GMT\r\n", "2024-08-16T00:00:00Z"),
        ("Retry-After: 60\r\n", "2024-08-14T14:00:00Z"),
        ("Retry-After: soon\r\n", "2024-08-14T14:00:00Z"),
    ] {
        let cache = Cache::new();
        let server = Server::one(move |stream| respond(stream, "503 Service Unavailable", header, b""));
        let (code, _, stderr) = cache.run(&server.url, NOON, &[]);
        assert!(code == 2 && stderr.contains(&format!("next request allowed from {not_before}")), "{header}: {stderr}");
        assert_eq!(cache.record()["not_before_utc"], not_before, "{header}");
        let idle = Server::new(Vec::new());
        let later = if not_before == "2024-08-14T14:00:00Z" { "2024-08-14T13:59:00Z" } else { "2024-08-15T11:59:00Z" };
        let (code, _, stderr) = cache.run(&idle.url, later, &[]);
        assert!(code == 2 && stderr.contains("the next one is allowed in "), "{header}: {stderr}");
        let server = Server::one(ok(elements("sample.csv"), ""));
        assert_eq!(cache.run(&server.url, not_before, &[]).0, 0, "{header}");
    }
    // The files of a manifest have one waiting time.
    let cache = Cache::new();
    let refuse = |stream: &mut TcpStream| {
        respond(stream, "429 Too Many Requests", "Retry-After: 172800\r\n", b"");
    };
    let server = Server::new(vec![Box::new(ok(manifest(), "")), Box::new(refuse)]);
    let source = ["starlink-ephemerides", "--norad", "90001"];
    let (code, _, stderr) = cache.source(&source, &server.url, "2024-08-14T00:30:00Z", &[]);
    assert!(code != 0 && stderr.contains("next request allowed in 2880 min"), "{stderr}");
    let idle = Server::new(Vec::new());
    let (code, _, stderr) = cache.source(&source, &idle.url, "2024-08-15T12:00:00Z", &[]);
    assert!(code != 0 && stderr.contains("the next one is allowed in "), "{stderr}");
}

#[test]
fn a_changed_cached_file_is_reported_as_changed() {
    let cache = Cache::filled();
    std::fs::write(cache.file(), elements("sample.2le")).unwrap();
    let idle = Server::new(Vec::new());
    let (code, stdout, stderr) = cache.run(&idle.url, "2024-08-12T13:59:00Z", &[]);
    assert_eq!((code, stdout.as_str()), (2, ""), "{stderr}");
    assert!(stderr.contains(&format!("{} was changed after its download", cache.file().display())), "{stderr}");
    let server = Server::one(ok(elements("sample.csv"), ""));
    let (code, _, stderr) = cache.run(&server.url, NOON, &[]);
    assert!(
        code == 0 && stderr.contains("was changed after its download; a complete download replaces it"),
        "{stderr}"
    );
}

/// Another process holds the lock for ever.
#[test]
fn the_timeout_includes_the_wait_for_the_lock() {
    for (source, name) in [
        (&["celestrak", "--group", "starlink"][..], NAME),
        (&["starlink-ephemerides", "--norad", "90001"], "starlink-ephemerides.manifest.txt"),
    ] {
        let cache = Cache::new();
        let path = cache.folder().join(format!("{name}.lock"));
        let held = std::fs::File::create(&path).unwrap();
        held.lock().unwrap();
        let idle = Server::new(Vec::new());
        let (code, _, stderr) = cache.source(source, &idle.url, NOON, &["--timeout", "300ms"]);
        assert!(code == 2 && stderr.contains("locked by another process for 0.3 s (--timeout)"), "{stderr}");
        assert!(stderr.contains(&path.display().to_string()), "{stderr}");
        assert!(idle.requests().is_empty());
    }
}

/// No named pipe in the cache blocks the program, whose other end is never opened.
#[cfg(unix)]
#[test]
fn named_pipes_in_the_cache_are_rejected() {
    let manifest = "starlink-ephemerides.manifest.txt";
    for (source, name) in
        [(&["celestrak", "--group", "starlink"][..], NAME), (&["starlink-ephemerides", "--norad", "90001"], manifest)]
    {
        for end in ["", ".fetch.json", ".lock"] {
            let cache = Cache::new();
            let pipe = cache.folder().join(format!("{name}{end}"));
            assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
            let idle = Server::new(Vec::new());
            let (code, stdout, stderr) = cache.source(source, &idle.url, NOON, &[]);
            let expected = format!("cache {}: is a named pipe; allowed: a file", pipe.display());
            assert!(code == 2 && stdout.is_empty() && stderr.contains(&expected), "{stderr}");
            assert!(idle.requests().is_empty());
        }
    }
    let folder = TempDir::new().unwrap();
    let pipe = folder.path().join("cache");
    assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let (code, stderr) = {
        let output = Command::new(env!("CARGO_BIN_EXE_streakcast"))
            .env("STREAKCAST_NO_HOME", "1")
            .args(["fetch", "celestrak", "--group", "starlink", "--base-url", "http://127.0.0.1:9", "--now", NOON])
            .arg("--cache")
            .arg(&pipe)
            .output()
            .unwrap();
        (output.status.code(), String::from_utf8(output.stderr).unwrap())
    };
    assert!(code == Some(2) && stderr.contains("allowed: a folder"), "{stderr}");
}
