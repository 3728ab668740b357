//! HTTP/1.1 as far as one page needs it: requests without a body, answers that end with the connection, limits on length and time of both.

use std::io::{ErrorKind, Read as _, Write as _};
use std::net::{Shutdown, TcpStream};
use std::time::{Duration, Instant};

/// Longest head of a request (bytes).
pub(super) const LONGEST_HEAD: usize = 8192;
/// Time for the head of a request.
pub(super) const TIME_OF_REQUEST: Duration = Duration::from_secs(2);
/// Time for an answer.
const TIME_OF_ANSWER: Duration = Duration::from_secs(20);
/// Time, and number of bytes, that are still read from a client whose request is refused, so that it receives the answer.
const REST: (Duration, usize) = (Duration::from_millis(300), 1 << 17);

/// Head of a request.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Request {
    /// Method.
    pub method: String,
    /// Path.
    pub path: String,
    /// Part of the target behind the question mark.
    pub query: String,
    /// Header `Host`.
    pub host: Option<String>,
    /// Header `Origin`.
    pub origin: Option<String>,
}

/// Status of an answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Status {
    /// The content that was asked for.
    Ok,
    /// Done; there is no content.
    NoContent,
    /// The request is not HTTP/1.
    BadRequest,
    /// The request comes from the page of another site.
    Forbidden,
    /// There is no such content.
    NotFound,
    /// The content has another method.
    MethodNotAllowed,
    /// The request has a body.
    ContentTooLarge,
    /// The head of the request is too long.
    HeadTooLarge,
}

impl Status {
    /// Code and reason of the status line.
    fn line(self) -> &'static str {
        match self {
            Self::Ok => "200 OK",
            Self::NoContent => "204 No Content",
            Self::BadRequest => "400 Bad Request",
            Self::Forbidden => "403 Forbidden",
            Self::NotFound => "404 Not Found",
            Self::MethodNotAllowed => "405 Method Not Allowed",
            Self::ContentTooLarge => "413 Content Too Large",
            Self::HeadTooLarge => "431 Request Header Fields Too Large",
        }
    }
}

/// Answer to a request.
pub(super) struct Answer<'a> {
    /// Status.
    pub status: Status,
    /// Media type of the content; none where there is none.
    pub media: Option<&'static str>,
    /// Further header lines, each with its end.
    pub more: &'a str,
    /// Content.
    pub body: &'a [u8],
}

impl Answer<'_> {
    /// Answer without content.
    pub fn empty(status: Status) -> Self {
        Self { status, media: None, more: "", body: &[] }
    }
}

/// Reads the head of a request within its time. `Err(None)`: the client was silent or has gone, and gets no answer.
pub(super) fn read(stream: &mut TcpStream) -> Result<Request, Option<Status>> {
    let end = Instant::now() + TIME_OF_REQUEST;
    let (mut head, mut filled) = ([0; LONGEST_HEAD], 0);
    loop {
        let count = read_before(stream, &mut head[filled..], end).ok_or(None)?;
        let searched = filled.saturating_sub(3);
        filled += count;
        if let Some(at) = head[searched..filled].windows(4).position(|four| four == b"\r\n\r\n") {
            return parse(&head[..searched + at]).map_err(Some);
        }
        match (count, filled) {
            (0, _) => return Err(None),
            (_, LONGEST_HEAD) => return Err(Some(Status::HeadTooLarge)),
            _ => {}
        }
    }
}

/// Reads once; none where the time is over or the connection broken.
fn read_before(stream: &mut TcpStream, into: &mut [u8], end: Instant) -> Option<usize> {
    loop {
        stream.set_read_timeout(Some(left(end)?)).ok()?;
        match stream.read(into) {
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            read => return read.ok(),
        }
    }
}

/// Time that is left.
fn left(end: Instant) -> Option<Duration> {
    end.checked_duration_since(Instant::now()).filter(|left| !left.is_zero())
}

/// Parses the head of a request, without the empty line behind it.
fn parse(head: &[u8]) -> Result<Request, Status> {
    let text = std::str::from_utf8(head).map_err(|_| Status::BadRequest)?;
    let mut lines = text.split("\r\n");
    let mut words = lines.next().unwrap_or_default().split(' ');
    let (Some(method), Some(target), Some(version), None) =
        (words.next(), words.next(), words.next(), words.next())
    else {
        return Err(Status::BadRequest);
    };
    if method.is_empty() || !target.starts_with('/') || !["HTTP/1.1", "HTTP/1.0"].contains(&version) {
        return Err(Status::BadRequest);
    }
    let (path, query) = target.split_once('?').unwrap_or((target, ""));
    let mut request =
        Request { method: method.into(), path: path.into(), query: query.into(), host: None, origin: None };
    for line in lines {
        let (name, value) = line.split_once(':').ok_or(Status::BadRequest)?;
        if name.is_empty() || name.contains(|c: char| c.is_whitespace() || c.is_control()) {
            return Err(Status::BadRequest);
        }
        let value = value.trim();
        match name.to_ascii_lowercase().as_str() {
            "host" => once(&mut request.host, value)?,
            "origin" => once(&mut request.origin, value)?,
            "content-length" if value != "0" => return Err(Status::ContentTooLarge),
            "transfer-encoding" => return Err(Status::ContentTooLarge),
            _ => {}
        }
    }
    Ok(request)
}

fn once(place: &mut Option<String>, value: &str) -> Result<(), Status> {
    place.replace(value.to_ascii_lowercase()).map_or(Ok(()), |_| Err(Status::BadRequest))
}

/// Writes an answer within its time and ends the connection; true if the whole answer was taken.
pub(super) fn write(mut stream: TcpStream, answer: &Answer<'_>) -> bool {
    let end = Instant::now() + TIME_OF_ANSWER;
    let media = answer.media.map_or(String::new(), |media| format!("Content-Type: {media}\r\n"));
    let length = match answer.status {
        Status::NoContent => String::new(),
        _ => format!("Content-Length: {}\r\n", answer.body.len()),
    };
    let head = format!(
        "HTTP/1.1 {}\r\n{media}{length}{}Cache-Control: no-store\r\nX-Content-Type-Options: nosniff\r\n\
         Referrer-Policy: same-origin\r\nCross-Origin-Resource-Policy: same-origin\r\nConnection: close\r\n\r\n",
        answer.status.line(),
        answer.more
    );
    let written = write_before(&mut stream, head.as_bytes(), end)
        .and_then(|()| write_before(&mut stream, answer.body, end))
        .is_some();
    // A connection that is closed with unread bytes would be reset, and the client lose the answer.
    let _ = stream.shutdown(Shutdown::Write);
    let (end, mut rest, mut sink) = (Instant::now() + REST.0, REST.1, [0; 4096]);
    while let Some(count @ 1..) = read_before(&mut stream, &mut sink, end).filter(|_| rest > 0) {
        rest = rest.saturating_sub(count);
    }
    written
}

/// Writes all bytes; none where the time is over or the connection broken.
fn write_before(stream: &mut TcpStream, mut bytes: &[u8], end: Instant) -> Option<()> {
    while !bytes.is_empty() {
        stream.set_write_timeout(Some(left(end)?)).ok()?;
        match stream.write(bytes) {
            Ok(0) => return None,
            Ok(count) => bytes = bytes.get(count..).unwrap_or_default(),
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            Err(_) => return None,
        }
    }
    Some(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heads_are_parsed_or_refused() {
        let request =
            parse(b"GET /a/state?row=3 HTTP/1.1\r\nHOST: LocalHost:80\r\nOrigin:http://a\r\nAccept: */*")
                .unwrap();
        assert_eq!(
            request,
            Request {
                method: "GET".into(),
                path: "/a/state".into(),
                query: "row=3".into(),
                host: Some("localhost:80".into()),
                origin: Some("http://a".into()),
            }
        );
        for bad in [
            "",
            "GET",
            "GET /",
            "GET  / HTTP/1.1",
            "GET / HTTP/1.1 x",
            "GET / HTTP/2",
            "GET http://a/ HTTP/1.1",
            " / HTTP/1.1",
            "GET / HTTP/1.1\r\nHost",
            "GET / HTTP/1.1\r\nHost : a",
            "GET / HTTP/1.1\r\n folded: a",
            "GET / HTTP/1.1\r\n: a",
            "GET / HTTP/1.1\r\nHost: a\r\nhost: b",
            "GET / HTTP/1.1\r\nOrigin: a\r\nOrigin: a",
        ] {
            assert_eq!(parse(bad.as_bytes()), Err(Status::BadRequest), "{bad}");
        }
        assert_eq!(parse(b"GET /\xff HTTP/1.1"), Err(Status::BadRequest));
        for body in ["Content-Length: 1", "content-length: x", "Transfer-Encoding: chunked"] {
            let head = format!("POST / HTTP/1.1\r\n{body}");
            assert_eq!(parse(head.as_bytes()), Err(Status::ContentTooLarge), "{body}");
        }
        assert!(parse(b"POST / HTTP/1.1\r\nContent-Length: 0").is_ok());
    }
}
