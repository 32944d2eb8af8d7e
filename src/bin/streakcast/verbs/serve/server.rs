//! Connections of the server: limits on their number, their age and the size of request heads; error responses to
//! malformed heads; and a shutdown that completes open requests.
//! hyper responds to a malformed head with a status and no body, and closes the connection without a response if a head
//! is late or incomplete. `Wire` suppresses the responses without a body, and `close` sends a problem document instead.

use std::future::Future;
use std::io;
use std::net::{SocketAddr, TcpListener};
use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll};
use std::time::Duration;

use axum::Router;
use axum::http::Request;
use hifitime::Epoch;
use hifitime::efmt::Formatter;
use hifitime::efmt::consts::RFC2822;
use hyper::body::Incoming;
use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper_util::rt::{TokioIo, TokioTimer};
use tokio::io::{AsyncRead, AsyncWrite, AsyncWriteExt, ReadBuf};
use tokio::net::TcpStream;
use tokio::sync::{OwnedSemaphorePermit, Semaphore, watch};
use tokio::time::{sleep, timeout};
use tower::ServiceExt;

use super::filter::MAX_TARGET_BYTES;
use super::problem::{PROBLEM_JSON, Problem, title};
use super::router::{ClientAddress, HEADERS};

/// Largest number of open connections. Further connections wait in the queue of the operating system.
const MAX_CONNECTIONS: u32 = 512;
/// Age at which a connection is closed, after the current response.
const MAX_AGE: Duration = Duration::from_secs(600);
/// Largest time after the start of a shutdown in which open requests can complete.
const SHUTDOWN_TIMEOUT: Duration = Duration::from_secs(10);
/// Pause after a failed accept, for example because of too many open files.
const ACCEPT_PAUSE: Duration = Duration::from_millis(100);

/// Serves until SIGINT or SIGTERM. `workers` is the number of blocking threads, without that of the slow lane.
pub fn serve(listener: TcpListener, router: Router, workers: usize) -> anyhow::Result<()> {
    listener.set_nonblocking(true)?;
    let runtime =
        tokio::runtime::Builder::new_current_thread().enable_all().max_blocking_threads(workers + 2).build()?;
    runtime.block_on(accept(listener, router))?;
    // Computations that are still running are abandoned.
    runtime.shutdown_background();
    Ok(())
}

async fn accept(listener: TcpListener, router: Router) -> anyhow::Result<()> {
    let listener = tokio::net::TcpListener::from_std(listener)?;
    let permits = Arc::new(Semaphore::new(MAX_CONNECTIONS as usize));
    // The connections stop when the sender is dropped.
    let (running, stop) = watch::channel(());
    let mut signal = Box::pin(stop_signal()?);
    loop {
        let next = async { (Arc::clone(&permits).acquire_owned().await, listener.accept().await) };
        tokio::select! {
            biased;
            () = &mut signal => break,
            accepted = next => match accepted {
                (Ok(permit), Ok((stream, from))) => {
                    tokio::spawn(serve_connection(stream, from, router.clone(), stop.clone(), permit));
                }
                _ => sleep(ACCEPT_PAUSE).await,
            },
        }
    }
    drop((listener, running));
    // A second signal ends the shutdown at once.
    tokio::select! {
        _ = timeout(SHUTDOWN_TIMEOUT, permits.acquire_many(MAX_CONNECTIONS)) => {}
        () = stop_signal()? => {}
    }
    Ok(())
}

/// Serves one connection until it is closed. Errors of one connection do not affect others.
async fn serve_connection(
    stream: TcpStream,
    from: SocketAddr,
    router: Router,
    stop: watch::Receiver<()>,
    _permit: OwnedSemaphorePermit,
) {
    let _ = stream.set_nodelay(true);
    let service = service_fn(|mut request: Request<Incoming>| {
        request.extensions_mut().insert(ClientAddress(from.ip()));
        router.clone().oneshot(request)
    });
    let mut connection = http1::Builder::new()
        .timer(TokioTimer::new())
        .header_read_timeout(HEAD_TIMEOUT)
        .max_buf_size(MAX_HEAD_BYTES)
        .max_headers(MAX_HEADERS)
        .serve_connection(TokioIo::new(Wire(stream)), service);
    let ended = tokio::select! {
        ended = &mut connection => ended,
        _ = timeout(MAX_AGE, stopped(stop.clone())) => {
            std::pin::Pin::new(&mut connection).graceful_shutdown();
            let Ok(ended) = timeout(SHUTDOWN_TIMEOUT, &mut connection).await else { return };
            ended
        }
    };
    let parts = connection.into_parts();
    let problem = ended.err().and_then(|error| problem_of(&error, &parts.read_buf));
    tokio::select! {
        () = close(parts.io.into_inner().0, problem) => {}
        () = stopped(stop) => {}
    }
}

async fn stopped(mut stop: watch::Receiver<()>) {
    while stop.changed().await.is_ok() {}
}

/// Returns a future that completes on SIGINT or SIGTERM (on Ctrl-C on other systems).
fn stop_signal() -> anyhow::Result<impl Future<Output = ()>> {
    #[cfg(unix)]
    {
        use tokio::signal::unix::{SignalKind, signal};
        let (mut interrupt, mut terminate) = (signal(SignalKind::interrupt())?, signal(SignalKind::terminate())?);
        Ok(async move {
            tokio::select! {
                _ = interrupt.recv() => {}
                _ = terminate.recv() => {}
            }
        })
    }
    #[cfg(not(unix))]
    Ok(async {
        let _ = tokio::signal::ctrl_c().await;
    })
}

/// Largest time for the arrival of a request head, also for the next request of an open connection.
pub const HEAD_TIMEOUT: Duration = Duration::from_secs(10);
/// Limit on the size of a request head, bytes.
pub const MAX_HEAD_BYTES: usize = 16 << 10;
pub const MAX_HEADERS: usize = 64;
/// Largest time for closing a connection.
const CLOSE_TIMEOUT: Duration = Duration::from_secs(4);

/// Connection stream that drops hyper's own error responses and ignores its shutdown; `close` ends the connection.
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

/// Returns true if these bytes are an error response of hyper: a head without a content type. All responses of this
/// server have one.
fn is_bare_error(bytes: &[u8]) -> bool {
    let is_error = bytes.starts_with(b"HTTP/1.1 4") || bytes.starts_with(b"HTTP/1.0 4");
    let name = b"\r\ncontent-type:";
    is_error && bytes.ends_with(b"\r\n\r\n") && !bytes.windows(name.len()).any(|window| window == name)
}

/// Returns the error response for a failed connection; `None` if none is sent. `unread` is the received part of a head.
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
        // The connection was idle, or was closed by the client.
        None
    } else if error.is_timeout() {
        let seconds = HEAD_TIMEOUT.as_secs();
        Some(Problem::new(408, format!("the head of the request did not arrive within {seconds} s")))
    } else {
        error.is_incomplete_message().then(|| Problem::new(400, format!("incomplete head of the request; {allowed}")))
    }
}

/// Sends a last response, if there is one, and closes the connection after the client has closed its side.
pub async fn close(mut stream: TcpStream, problem: Option<Problem>) {
    let response = problem.map(|problem| last_response(&problem)).unwrap_or_default();
    let closed = async {
        stream.write_all(&response).await?;
        stream.shutdown().await?;
        // If input were unread at the time of closing, the connection would be reset before the client reads the
        // response.
        tokio::io::copy(&mut stream, &mut tokio::io::sink()).await
    };
    let _ = timeout(CLOSE_TIMEOUT, closed).await;
}

/// Returns head and body of a response that is not written by hyper.
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
        let problem = b"HTTP/1.1 404 Not Found\r\ncontent-type: application/problem+json\r\ncontent-length: 90\r\n\r\n";
        assert!(!is_bare_error(problem));
        // Remaining bytes of such a response after a partial write.
        for from in 1..bare.len() {
            assert!(!is_bare_error(&bare[from..]) && !is_bare_error(&bare[..from]), "{from}");
        }
        assert!((1..problem.len()).all(|from| !is_bare_error(&problem[from..])));
        for other in
            [&b""[..], b"HTTP/1.1 100 Continue\r\n\r\n", b"HTTP/1.1 200 OK\r\n\r\n", b"{\"detail\":\"HTTP/1.1 400\"}"]
        {
            assert!(!is_bare_error(other));
        }
    }
}
