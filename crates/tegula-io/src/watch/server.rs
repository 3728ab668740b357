//! Server of the page: one thread waits for connections, a few others answer them.

use std::io;
use std::net::{Ipv4Addr, SocketAddr, TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::thread::{Builder, JoinHandle};
use std::time::Duration;

use super::http::{self, Answer, Request, Status};
use super::page::Page;
use super::slot::{Known, Slot};

/// Largest number of connections at a time; others are closed.
const MOST_CONNECTIONS: usize = 32;
/// Stack of a thread that answers (bytes).
const STACK: usize = 256 << 10;
/// Pause after a connection that could not be accepted.
const PAUSE: Duration = Duration::from_millis(50);
/// Bytes of randomness in the address.
const SECRET: usize = 16;

/// Server that is running.
pub(super) struct Server {
    shared: Arc<Shared>,
    waiting: Option<JoinHandle<()>>,
}

/// Data that the threads share.
pub(super) struct Shared {
    address: SocketAddr,
    token: String,
    page: Page,
    /// Latest state of the run.
    pub slot: Slot,
    /// A client has asked to stop the run.
    pub stop: AtomicBool,
    connections: AtomicUsize,
    closing: AtomicBool,
}

impl Server {
    /// Listens on a free port of the loopback interface.
    pub fn start() -> io::Result<Self> {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0))?;
        let shared = Arc::new(Shared {
            address: listener.local_addr()?,
            token: secret()?,
            page: Page::new(&secret()?),
            slot: Slot::new(),
            stop: AtomicBool::new(false),
            connections: AtomicUsize::new(0),
            closing: AtomicBool::new(false),
        });
        let own = shared.clone();
        let waiting =
            Builder::new().name("page".into()).stack_size(STACK).spawn(move || wait(&listener, &own))?;
        Ok(Self { shared, waiting: Some(waiting) })
    }

    /// Address of the page.
    pub fn url(&self) -> String {
        format!("http://{}/{}/", self.shared.address, self.shared.token)
    }

    /// Data that the threads share.
    pub fn shared(&self) -> &Shared {
        &self.shared
    }

    /// Number of connections.
    pub fn connections(&self) -> usize {
        self.shared.connections.load(Ordering::Acquire)
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.shared.closing.store(true, Ordering::Release);
        // The thread waits for a connection. If it gets none, it ends with the program.
        let woken = TcpStream::connect_timeout(&self.shared.address, Duration::from_secs(1));
        if let (Ok(_), Some(waiting)) = (woken, self.waiting.take()) {
            let _ = waiting.join();
        }
    }
}

/// A random number in hexadecimal digits.
fn secret() -> io::Result<String> {
    let mut bytes = [0; SECRET];
    getrandom::fill(&mut bytes).map_err(io::Error::other)?;
    Ok(bytes.iter().map(|byte| format!("{byte:02x}")).collect())
}

/// Accepts connections until the server closes.
fn wait(listener: &TcpListener, shared: &Arc<Shared>) {
    loop {
        let accepted = listener.accept();
        if shared.closing.load(Ordering::Acquire) {
            return;
        }
        match accepted {
            Ok((stream, _)) => serve(stream, shared),
            Err(_) => std::thread::sleep(PAUSE),
        }
    }
}

/// Place of a connection among those that are allowed.
struct Place(Arc<Shared>);

impl Drop for Place {
    fn drop(&mut self) {
        self.0.connections.fetch_sub(1, Ordering::AcqRel);
    }
}

/// Answers a connection in a thread of its own, or closes it where there are too many.
fn serve(stream: TcpStream, shared: &Arc<Shared>) {
    let others = shared.connections.fetch_add(1, Ordering::AcqRel);
    let place = Place(shared.clone());
    if others < MOST_CONNECTIONS {
        // Without a thread the connection is closed.
        let _ =
            Builder::new().name("client".into()).stack_size(STACK).spawn(move || answer(stream, &place.0));
    }
}

fn answer(mut stream: TcpStream, shared: &Shared) {
    let _ = stream.set_nodelay(true);
    let empty = Answer::empty;
    let request = match http::read(&mut stream) {
        Ok(request) => request,
        Err(Some(status)) => {
            http::write(stream, &empty(status));
            return;
        }
        Err(None) => return,
    };
    let content;
    let answer = match shared.found(&request) {
        Err(status) => empty(status),
        Ok(Asked::Page) => Answer {
            status: Status::Ok,
            media: Some("text/html; charset=utf-8"),
            more: &shared.page.policy,
            body: shared.page.html.as_bytes(),
        },
        Ok(Asked::News) => {
            content = Arc::new(shared.slot.news(known(&request.query)));
            Answer { media: Some("application/json"), body: &content, ..empty(Status::Ok) }
        }
        Ok(asked @ (Asked::Mesh | Asked::Shape)) => {
            content = if asked == Asked::Mesh { shared.slot.mesh() } else { shared.slot.shape() };
            Answer { media: Some("application/octet-stream"), body: &content, ..empty(Status::Ok) }
        }
        Ok(Asked::Stop) => {
            shared.stop.store(true, Ordering::Release);
            empty(Status::NoContent)
        }
    };
    http::write(stream, &answer);
}

/// Content, or action, that a client asks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Asked {
    Page,
    News,
    Mesh,
    Shape,
    Stop,
}

impl Shared {
    /// Finds what a request asks for: it must know the token, and come from the page or from no page.
    fn found(&self, request: &Request) -> Result<Asked, Status> {
        let rest = request.path.strip_prefix('/').and_then(|path| self.behind_token(path));
        let rest = rest.ok_or(Status::NotFound)?;
        let port = self.address.port();
        let own = |host: &str| ["127.0.0.1", "localhost"].iter().any(|name| host == format!("{name}:{port}"));
        if !request.host.as_deref().is_some_and(own) {
            return Err(Status::Forbidden);
        }
        let origin = request.origin.as_deref();
        if !origin.is_none_or(|origin| origin.strip_prefix("http://").is_some_and(own)) {
            return Err(Status::Forbidden);
        }
        let (asked, method) = match rest {
            "/" => (Asked::Page, "GET"),
            "/news" => (Asked::News, "GET"),
            "/mesh" => (Asked::Mesh, "GET"),
            "/shape" => (Asked::Shape, "GET"),
            "/stop" => (Asked::Stop, "POST"),
            _ => return Err(Status::NotFound),
        };
        match (request.method == method, asked, origin) {
            (false, ..) => Err(Status::MethodNotAllowed),
            (true, Asked::Stop, None) => Err(Status::Forbidden),
            (true, ..) => Ok(asked),
        }
    }

    /// Part of a path behind the token; the time of the comparison does not depend on where they differ.
    fn behind_token<'a>(&self, path: &'a str) -> Option<&'a str> {
        let (token, rest) = path.split_at_checked(self.token.len())?;
        let differing = token.bytes().zip(self.token.bytes()).fold(0, |sum, (a, b)| sum | (a ^ b));
        (differing == 0).then_some(rest)
    }
}

/// Numbers of what a client has, from the query of its request.
fn known(query: &str) -> Known {
    let number = |name: &str| {
        let pairs = query.split('&').filter_map(|pair| pair.split_once('='));
        pairs.filter(|(key, _)| *key == name).find_map(|(_, value)| value.parse().ok()).unwrap_or(0)
    };
    let [part, row, message, shape] = ["part", "row", "message", "shape"].map(number);
    Known { part, row, message, shape }
}
