//! A request for a file of the studio that is still being gathered waits; all others are answered at once.
#![allow(clippy::unwrap_used, clippy::panic)]

use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::Duration;

use smalti_io::cache::Cache;
use smalti_io::studio::StudioAsset;
use smalti_serve::LocalServer;
use smalti_serve::studio::{LateFiles, Native, Opening, files, routes};

/// A request for a file of the page.
fn request(address: &str, path: &str) -> TcpStream {
    let (host, token) = address.strip_prefix("http://").unwrap().split_once('/').unwrap();
    let mut stream = TcpStream::connect(host).unwrap();
    write!(stream, "GET /{token}{path} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n").unwrap();
    stream
}

/// The status and the body of the answer.
fn answer(mut stream: TcpStream) -> (u16, Vec<u8>) {
    stream.set_read_timeout(Some(Duration::from_secs(30))).unwrap();
    let mut all = Vec::new();
    stream.read_to_end(&mut all).unwrap();
    let end = all.windows(4).position(|w| w == b"\r\n\r\n").unwrap();
    let head = String::from_utf8(all[..end].to_vec()).unwrap();
    (head.split(' ').nth(1).unwrap().parse().unwrap(), all[end + 4..].to_vec())
}

fn asset(name: &str, content: &[u8]) -> StudioAsset {
    StudioAsset { name: name.into(), bytes: content.to_vec() }
}

/// The address of a server with these files in the folder of the simulator.
fn serve(there: Vec<StudioAsset>, late: &LateFiles) -> String {
    let server = LocalServer::bind(None, None).unwrap();
    let address = server.url();
    let opening = Opening { camera: "name = \"x\"".into(), ..Opening::default() };
    let pages = routes(files(&opening, there, true), late.clone(), Native::new(Cache::disabled()));
    std::thread::spawn(move || server.run(pages).unwrap());
    address
}

#[test]
fn a_file_that_is_still_being_gathered_is_waited_for() {
    let late = LateFiles::default();
    let address = serve(vec![asset("manifest.json", b"{}")], &late);
    let [training, missing] =
        ["training.bin", "missing.bin"].map(|name| request(&address, &format!("engine/{name}")));
    assert_eq!(answer(request(&address, "engine/manifest.json")), (200, b"{}".to_vec()));
    assert_eq!(answer(request(&address, "start.toml")), (200, b"name = \"x\"".to_vec()));
    assert_eq!(answer(request(&address, "missing.toml")).0, 404);
    training.set_nonblocking(true).unwrap();
    assert!(training.peek(&mut [0]).is_err(), "an answer before the file is gathered");
    training.set_nonblocking(false).unwrap();

    late.set(Ok(vec![asset("training.bin", b"light")]));
    assert_eq!(answer(training), (200, b"light".to_vec()));
    assert_eq!(answer(missing).0, 404);
    assert_eq!(answer(request(&address, "engine/training.bin")), (200, b"light".to_vec()));
}

#[test]
fn kept_light_is_there_at_once() {
    let late = LateFiles::default();
    late.set(Ok(vec![asset("manifest.json", b"{}"), asset("training.bin", b"light")]));
    let address = serve(Vec::new(), &late);
    assert_eq!(answer(request(&address, "engine/manifest.json")), (200, b"{}".to_vec()));
    assert_eq!(answer(request(&address, "engine/training.bin")), (200, b"light".to_vec()));
}

#[test]
fn the_page_hears_why_light_could_not_be_gathered() {
    let late = LateFiles::default();
    let address = serve(Vec::new(), &late);
    let training = request(&address, "engine/training.bin");
    late.set(Err("the lens has no image".into()));
    assert_eq!(answer(training), (500, b"the lens has no image".to_vec()));
    assert_eq!(answer(request(&address, "start.toml")).0, 200);
}
