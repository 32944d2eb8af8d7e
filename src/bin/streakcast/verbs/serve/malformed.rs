//! Problem documents for request heads that cannot be read.
//!
//! hyper answers a malformed head with a bare status, and one that is late or incomplete with nothing. `Wire` holds its bare
//! answers back; a problem document with the headers of every response takes their place.

use std::io;
use std::pin::Pin;
use std::task::{Context, Poll};
use std::time::Duration;

use hifitime::Epoch;
use hifitime::efmt::Formatter;
use hifitime::efmt::consts::RFC2822;
use tokio::io::{AsyncRead, AsyncWrite, AsyncWriteExt, ReadBuf};
use tokio::net::TcpStream;
use tokio::time::timeout;

use super::filter::MAX_TARGET_BYTES;
use super::problem::{PROBLEM_JSON, Problem, title};
use super::router::HEADERS;

/// Limit on the time in which a head arrives, also that of the next request on an open connection.
pub const HEAD_TIMEOUT: Duration = Duration::from_secs(10);
/// Limits on the size of a head.
pub const MAX_HEAD_BYTES: usize = 16 << 10;
pub const MAX_HEADERS: usize = 64;
/// Limit on the time that closing takes.
const CLOSE_TIMEOUT: Duration = Duration::from_secs(4);

/// The stream below hyper: without its bare error responses, and open until `close`.
pub struct Wire(pub TcpStream);

impl AsyncRead for Wire {
    fn poll_read(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        buffer: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        Pin::new(&mut self.0).poll_read(context, buffer)
    }
}

impl AsyncWrite for Wire {
    fn poll_write(mut self: Pin<&mut Self>, context: &mut Context<'_>, bytes: &[u8]) -> Poll<io::Result<usize>> {
        if is_bare_error(bytes) {
            return Poll::Ready(Ok(bytes.len()));
        }
        Pin::new(&mut self.0).poll_write(context, bytes)
    }

    fn poll_flush(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.0).poll_flush(context)
    }

    fn poll_shutdown(self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        self.poll_flush(context)
    }
}

/// Whether these bytes are an error response of hyper: a head without a content type. All our responses have one.
fn is_bare_error(bytes: &[u8]) -> bool {
    let is_error = bytes.starts_with(b"HTTP/1.1 4") || bytes.starts_with(b"HTTP/1.0 4");
    let name = b"\r\ncontent-type:";
    is_error && bytes.ends_with(b"\r\n\r\n") && !bytes.windows(name.len()).any(|window| window == name)
}

/// Returns the problem that ended a connection, if its client is to be informed; `unread` is the part of a head that was received.
pub fn problem_of(error: &hyper::Error, unread: &[u8]) -> Option<Problem> {
    let allowed = "allowed: HTTP/1.1 and 1.0, without TLS";
    if error.is_parse_too_large() && !unread.contains(&b'\n') {
        Some(Problem::new(414, format!("path and query are longer than {MAX_TARGET_BYTES} bytes")))
    } else if error.is_parse_too_large() {
        let kilobytes = MAX_HEAD_BYTES >> 10;
        Some(Problem::new(431, format!("the head of the request is above {kilobytes} kB or {MAX_HEADERS} lines")))
    } else if error.is_parse() {
        Some(Problem::new(400, format!("malformed head of the request: {error}; {allowed}")))
    } else if unread.is_empty() {
        // An idle connection, or one that the client has closed.
        None
    } else if error.is_timeout() {
        let seconds = HEAD_TIMEOUT.as_secs();
        Some(Problem::new(408, format!("the head of the request did not arrive within {seconds} s")))
    } else {
        error.is_incomplete_message().then(|| Problem::new(400, format!("incomplete head of the request; {allowed}")))
    }
}

/// Sends the last response, if there is one, and closes the connection after the client has closed its side.
pub async fn close(mut stream: TcpStream, problem: Option<Problem>) {
    let response = problem.map(|problem| last_response(&problem)).unwrap_or_default();
    let closed = async {
        stream.write_all(&response).await?;
        stream.shutdown().await?;
        // With unread input a close would reset the connection, and the client would lose the response.
        tokio::io::copy(&mut stream, &mut tokio::io::sink()).await
    };
    let _ = timeout(CLOSE_TIMEOUT, closed).await;
}

/// Head and body of a response without a request.
fn last_response(problem: &Problem) -> Vec<u8> {
    let body = problem.document(None);
    let mut head = format!("HTTP/1.1 {} {}\r\n", problem.status, title(problem.status));
    let length = body.len().to_string();
    let own = [("content-type", PROBLEM_JSON), ("content-length", &length), ("connection", "close")];
    for (name, value) in HEADERS.into_iter().chain(own) {
        head += &format!("{name}: {value}\r\n");
    }
    if let Ok(now) = Epoch::now() {
        head += &format!("date: {} GMT\r\n", Formatter::new(now, RFC2822));
    }
    (head + "\r\n" + &body).into_bytes()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bare_errors_are_those_of_hyper() {
        let bare = b"HTTP/1.1 431 Request Header Fields Too Large\r\ncontent-length: 0\r\nconnection: close\r\n\r\n";
        assert!(is_bare_error(bare) && is_bare_error(b"HTTP/1.0 400 Bad Request\r\n\r\n"));
        let ours = b"HTTP/1.1 404 Not Found\r\ncontent-type: application/problem+json\r\ncontent-length: 90\r\n\r\n";
        assert!(!is_bare_error(ours));
        // Any part of one that a write leaves over.
        for from in 1..bare.len() {
            assert!(!is_bare_error(&bare[from..]) && !is_bare_error(&bare[..from]), "{from}");
        }
        assert!((1..ours.len()).all(|from| !is_bare_error(&ours[from..])));
        for other in
            [&b""[..], b"HTTP/1.1 100 Continue\r\n\r\n", b"HTTP/1.1 200 OK\r\n\r\n", b"{\"detail\":\"HTTP/1.1 400\"}"]
        {
            assert!(!is_bare_error(other));
        }
    }
}
