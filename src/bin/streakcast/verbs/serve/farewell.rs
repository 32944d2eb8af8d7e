//! The end of a connection: who sent what cannot be read is told why before it closes, and has the time to read it.
//!
//! hyper answers a head that it cannot read with a bare status, and one that never comes or breaks off with nothing at all. `Wire`
//! keeps its bare answers back, and what stands here takes their place: a problem document, with the headers of every answer.

use std::future::poll_fn;
use std::io::{self, IoSlice};
use std::pin::Pin;
use std::task::{Context, Poll};
use std::time::Duration;

use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::net::TcpStream;
use tokio::time::timeout;

use super::door::LONGEST_TARGET;
use super::reply::Problem;
use super::server::{HEAD_TIMEOUT, LONGEST_HEAD, MOST_HEADERS};

/// How long a last word may take to be written.
const WRITTEN_WITHIN: Duration = Duration::from_secs(2);
/// How long a client may go on sending after the last answer. Closed before, what it has not read yet would be lost to it.
const HEARD_OUT: Duration = Duration::from_secs(2);
/// What is read at once of that.
const DISCARDED_BYTES: usize = 16 << 10;

/// The stream under hyper. It closes nothing: who takes it back does, when all is said.
pub struct Wire(pub TcpStream);

impl Wire {
    fn stream(self: Pin<&mut Self>) -> Pin<&mut TcpStream> {
        Pin::new(&mut self.get_mut().0)
    }
}

impl AsyncRead for Wire {
    fn poll_read(self: Pin<&mut Self>, context: &mut Context<'_>, buffer: &mut ReadBuf<'_>) -> Poll<io::Result<()>> {
        self.stream().poll_read(context, buffer)
    }
}

impl AsyncWrite for Wire {
    fn poll_write(self: Pin<&mut Self>, context: &mut Context<'_>, bytes: &[u8]) -> Poll<io::Result<usize>> {
        if is_bare_error(bytes) {
            return Poll::Ready(Ok(bytes.len()));
        }
        self.stream().poll_write(context, bytes)
    }

    fn poll_write_vectored(
        self: Pin<&mut Self>,
        context: &mut Context<'_>,
        slices: &[IoSlice<'_>],
    ) -> Poll<io::Result<usize>> {
        // A head without a body comes alone.
        if let [head] = slices
            && is_bare_error(head)
        {
            return Poll::Ready(Ok(head.len()));
        }
        self.stream().poll_write_vectored(context, slices)
    }

    fn is_write_vectored(&self) -> bool {
        self.0.is_write_vectored()
    }

    fn poll_flush(self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        self.stream().poll_flush(context)
    }

    fn poll_shutdown(self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        self.stream().poll_flush(context)
    }
}

/// An error of hyper's own: a head that says nothing of a content.
///
/// Heads of ours name its type, those that answer HEAD too. Where a write goes on after a part was taken, neither the rest of
/// a head nor that of a body is one: no body of ours ends with CR LF CR LF.
fn is_bare_error(bytes: &[u8]) -> bool {
    let is_error = bytes.starts_with(b"HTTP/1.1 4") || bytes.starts_with(b"HTTP/1.0 4");
    let name = b"\r\ncontent-type:";
    is_error && bytes.ends_with(b"\r\n\r\n") && !bytes.windows(name.len()).any(|window| window == name)
}

/// What the client is told that a connection ended on; `unread` is what had come of a head.
pub fn last_word(error: &hyper::Error, unread: &[u8]) -> Option<Problem> {
    let allowed = "allowed: HTTP/1.1 and 1.0, without TLS";
    if error.is_parse_too_large() && !unread.contains(&b'\n') {
        Some(Problem::new(414, format!("path and query are longer than {LONGEST_TARGET} bytes")))
    } else if error.is_parse_too_large() {
        let kilobytes = LONGEST_HEAD >> 10;
        Some(Problem::new(431, format!("the head of the request is above {kilobytes} kB or {MOST_HEADERS} lines")))
    } else if error.is_parse() {
        Some(Problem::new(400, format!("the head of the request cannot be read: {error}; {allowed}")))
    } else if unread.is_empty() {
        // An open connection on which nothing was asked for long, or one whose client has gone.
        None
    } else if error.is_timeout() {
        let seconds = HEAD_TIMEOUT.as_secs();
        Some(Problem::new(408, format!("the head of the request did not come within {seconds} s")))
    } else {
        error
            .is_incomplete_message()
            .then(|| Problem::new(400, format!("the head of the request breaks off; {allowed}")))
    }
}

/// Says the last word, if there is one, and that it was the last.
pub async fn say(stream: &mut TcpStream, word: Option<Problem>) -> io::Result<()> {
    let answer = word.map(|problem| problem.reply(None).last_answer()).unwrap_or_default();
    let mut rest = answer.as_slice();
    timeout(WRITTEN_WITHIN, async {
        while !rest.is_empty() {
            let written = poll_fn(|context| Pin::new(&mut *stream).poll_write(context, rest)).await?;
            rest = rest.get(written..).filter(|_| written > 0).ok_or(io::ErrorKind::WriteZero)?;
        }
        poll_fn(|context| Pin::new(&mut *stream).poll_shutdown(context)).await
    })
    .await?
}

/// Waits until the client has closed its side as well, however much it still sends, but not for long.
pub async fn hear_out(mut stream: TcpStream) {
    let mut discarded = vec![0; DISCARDED_BYTES];
    let rest = async {
        loop {
            let mut buffer = ReadBuf::new(&mut discarded);
            let read = poll_fn(|context| Pin::new(&mut stream).poll_read(context, &mut buffer)).await;
            if read.is_err() || buffer.filled().is_empty() {
                break;
            }
        }
    };
    let _ = timeout(HEARD_OUT, rest).await;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bare_errors_are_hypers_alone() {
        let bare = b"HTTP/1.1 431 Request Header Fields Too Large\r\ncontent-length: 0\r\nconnection: close\r\n\r\n";
        assert!(is_bare_error(bare) && is_bare_error(b"HTTP/1.0 400 Bad Request\r\n\r\n"));
        let ours = b"HTTP/1.1 404 Not Found\r\ncontent-type: application/problem+json\r\ncontent-length: 90\r\n\r\n";
        assert!(!is_bare_error(ours));
        // Whatever is left of any of them, and what goes before a body.
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
