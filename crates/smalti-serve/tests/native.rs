//! The connection for heavy work: what is asked for comes, what is cancelled ends, and what is none of the page is refused.
#![allow(clippy::unwrap_used, clippy::panic)]

use std::net::TcpStream;
use std::path::Path;
use std::sync::OnceLock;
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use smalti_io::cache::Cache;
use smalti_io::dng;
use smalti_serve::LocalServer;
use smalti_serve::studio::native::MOST_MESSAGE_BYTES;
use smalti_serve::studio::{LateFiles, Native, Opening, files, routes};
use tungstenite::client::IntoClientRequest;
use tungstenite::protocol::frame::coding::CloseCode;
use tungstenite::{Message, WebSocket, client};

/// A design of the page on a small sensor.
fn design() -> Value {
    json!({
        "name": "small",
        "sensor": {
            "rows": 48,
            "cols": 64,
            "cfa": {
                "pattern": ["RG", "GB"],
                "filters": {
                    "R": {"gaussian": {"center_nm": 610, "sigma_nm": 40}},
                    "G": {"gaussian": {"center_nm": 540, "sigma_nm": 40}},
                    "B": {"gaussian": {"center_nm": 460, "sigma_nm": 35}},
                },
            },
        },
        "exposure": {"time_ms": 20},
    })
}

/// The address of a server that all tests share.
fn server() -> &'static str {
    static ADDRESS: OnceLock<String> = OnceLock::new();
    ADDRESS.get_or_init(|| {
        let server = LocalServer::bind(None, None).unwrap();
        let address = server.url();
        let opening = Opening { camera: "name = \"x\"".into(), ..Opening::default() };
        let pages =
            routes(files(&opening, Vec::new(), true), LateFiles::default(), Native::new(Cache::disabled()));
        std::thread::spawn(move || server.run(pages).unwrap());
        address
    })
}

type Socket = WebSocket<TcpStream>;

/// Connects as a page of an origin; the status of the answer when it is refused.
fn connect_to(address: &str, origin: Option<&str>) -> Result<Socket, u16> {
    let (_, rest) = address.split_once("//").unwrap();
    let mut request = format!("ws://{rest}native").into_client_request().unwrap();
    if let Some(origin) = origin {
        request.headers_mut().insert("origin", origin.parse().unwrap());
    }
    let stream = TcpStream::connect(rest.split_once('/').unwrap().0).unwrap();
    stream.set_read_timeout(Some(Duration::from_secs(120))).unwrap();
    match client(request, stream) {
        Ok((socket, _)) => Ok(socket),
        Err(tungstenite::HandshakeError::Failure(tungstenite::Error::Http(response))) => {
            Err(response.status().as_u16())
        }
        Err(error) => panic!("{error}"),
    }
}

fn origin() -> String {
    server().splitn(4, '/').take(3).collect::<Vec<_>>().join("/")
}

fn connect() -> Socket {
    connect_to(server(), Some(&origin())).unwrap()
}

fn send(socket: &mut Socket, message: &Value) {
    socket.send(Message::text(message.to_string())).unwrap();
}

/// The next answer but progress.
fn answer(socket: &mut Socket) -> Value {
    loop {
        let Message::Text(text) = socket.read().unwrap() else { continue };
        let said: Value = serde_json::from_str(text.as_str()).unwrap();
        if said.get("progress").is_none() {
            return said;
        }
    }
}

fn file(socket: &mut Socket) -> Vec<u8> {
    let Message::Binary(bytes) = socket.read().unwrap() else { panic!("a file follows") };
    bytes.to_vec()
}

#[test]
fn a_capture_is_that_of_the_command() {
    let mut socket = connect();
    let capture = json!({"design": design(), "scene": "colorchecker", "luminance_cd_m2": 40});
    send(&mut socket, &json!({"start": {"id": 7, "job": {"capture": capture}}}));
    let said = answer(&mut socket);
    assert_eq!(said["result"]["id"], 7, "{said}");
    let raw = file(&mut socket);
    assert_eq!(said["result"]["files"], json!([{"kind": "raw", "bytes": raw.len()}]));
    assert_eq!(said["result"]["said"]["cpsnr_db"], Value::Null, "no pipeline was asked for");
    let read = dng::from_bytes(&raw, Path::new("raw.dng")).unwrap();
    let size = [said["result"]["said"]["rows"].as_u64(), said["result"]["said"]["cols"].as_u64()];
    assert_eq!(size, [read.raw.rows(), read.raw.cols()].map(|n| Some(n as u64)));
    assert!(read.raw.cols() > 32, "{}", read.raw.cols());
    // The connection stays for the next job.
    let dark = json!({"design": design(), "scene": "colorchecker", "luminance_cd_m2": 0.0});
    send(&mut socket, &json!({"start": {"id": 8, "job": {"capture": dark}}}));
    let said = answer(&mut socket);
    assert!(said["failed"]["message"].as_str().unwrap().contains("a luminance of 0 cd/m²"), "{said}");
}

#[test]
fn one_job_of_a_page_is_at_work_and_cancelling_ends_it_soon() {
    let mut socket = connect();
    let table = json!({"table": {"design": design()}});
    send(&mut socket, &json!({"start": {"id": 1, "job": table}}));
    // It tells how far it is.
    let Message::Text(text) = socket.read().unwrap() else { panic!("expected progress") };
    let said: Value = serde_json::from_str(text.as_str()).unwrap();
    assert_eq!(said["progress"]["id"], 1, "{said}");
    send(&mut socket, &json!({"start": {"id": 2, "job": table}}));
    let said = answer(&mut socket);
    assert_eq!(said["failed"]["id"], 2);
    assert_eq!(said["failed"]["message"], "another job of this page is at work; expected one at a time");
    // That of another page waits, and can be cancelled while it does.
    let mut other = connect();
    send(&mut other, &json!({"start": {"id": 1, "job": table}}));
    let Message::Text(text) = other.read().unwrap() else { panic!("expected progress") };
    assert!(text.as_str().contains("waiting for the job of another page"), "{text}");
    send(&mut other, &json!({"cancel": {"id": 9}}));
    send(&mut other, &json!({"cancel": {"id": 1}}));
    assert_eq!(answer(&mut other), json!({"cancelled": {"id": 1}}));
    let begun = Instant::now();
    send(&mut socket, &json!({"cancel": {"id": 1}}));
    assert_eq!(answer(&mut socket), json!({"cancelled": {"id": 1}}));
    // A training scene takes less.
    assert!(begun.elapsed() < Duration::from_secs(20), "{:?}", begun.elapsed());
}

/// A sweep learns, tells how far it is, and is cancelled.
#[test]
fn a_sweep_can_be_cancelled() {
    let mut socket = connect();
    let sweep = json!({"design": design(), "set": "charts", "luminances_cd_m2": [1, 10]});
    send(&mut socket, &json!({"start": {"id": 4, "job": {"sweep": sweep}}}));
    loop {
        let Message::Text(text) = socket.read().unwrap() else { panic!("expected progress") };
        let said: Value = serde_json::from_str(text.as_str()).unwrap();
        // Five kinds of filters at two luminances on each chart, and the training.
        if said["progress"]["of"].as_u64().unwrap() > 10 {
            break;
        }
    }
    send(&mut socket, &json!({"cancel": {"id": 4}}));
    assert_eq!(answer(&mut socket), json!({"cancelled": {"id": 4}}));
}

#[test]
fn a_page_that_is_gone_leaves_no_work_behind() {
    let mut socket = connect();
    send(&mut socket, &json!({"start": {"id": 1, "job": {"table": {"design": design()}}}}));
    let _ = socket.read().unwrap();
    drop(socket);
    let mut next = connect();
    let capture = json!({"design": design(), "scene": "colorchecker", "luminance_cd_m2": 40});
    send(&mut next, &json!({"start": {"id": 1, "job": {"capture": capture}}}));
    assert_eq!(answer(&mut next)["result"]["id"], 1);
}

#[test]
fn a_search_keeps_what_is_locked_and_finds_something_better() {
    let mut socket = connect();
    let search = json!({"design": design(), "filters": ["B"], "mosaic": true, "luminances_cd_m2": [20], "family": "dichroic"});
    send(&mut socket, &json!({"start": {"id": 1, "job": {"search": search}}}));
    let said = answer(&mut socket);
    let said = &said["result"]["said"];
    assert_eq!(said["mosaics"], 1, "{said}");
    assert_eq!(said["is_better"], true);
    let cfa = &said["design"]["sensor"]["cfa"];
    assert_eq!(cfa["pattern"], json!(["RG", "GB"]));
    assert_eq!(cfa["filters"]["B"], json!({"gaussian": {"center_nm": 460.0, "sigma_nm": 35.0, "peak": 1.0}}));
    // Each letter still names the filter of its colour.
    let center = |letter: &str| {
        let samples = &cfa["filters"][letter]["samples"];
        let values: Vec<f64> = serde_json::from_value(samples["values"].clone()).unwrap();
        let start = samples["start_nm"].as_f64().unwrap();
        let nm = |i: usize| start + i as f64 * samples["step_nm"].as_f64().unwrap();
        let moment: f64 = values.iter().enumerate().map(|(i, v)| v * nm(i)).sum();
        moment / values.iter().sum::<f64>()
    };
    assert!(center("R") > center("G"), "{} and {}", center("R"), center("G"));
    // A unit of ΔE2000 counts as two decibels.
    let [own, found] = ["own_expected", "expected"].map(|key| {
        let figure = |name: &str| said[key][0][name].as_f64().unwrap();
        figure("cpsnr_db") - 2.0 * figure("delta_e_2000")
    });
    assert!(found > own, "{own} and {found}");
    // Free cells: the mosaics of the tile are searched.
    let search =
        json!({"design": design(), "cells": [[0, 0]], "luminances_cd_m2": [20], "family": "dichroic"});
    send(&mut socket, &json!({"start": {"id": 2, "job": {"search": search}}}));
    let said = answer(&mut socket);
    assert!(said["result"]["said"]["mosaics"].as_u64().unwrap() > 1, "{said}");
    let found = said["result"]["said"]["design"]["sensor"]["cfa"]["pattern"][0].as_str().unwrap().to_owned();
    assert!(found.starts_with('R'), "{found}");
}

#[test]
fn a_search_keeps_filters_without_cells() {
    let mut socket = connect();
    let mut design = design();
    design["sensor"]["cfa"]["filters"]["C"] = json!({"flat": 0.9});
    let search = json!({"design": design, "filters": ["C", "G"], "mosaic": true, "luminances_cd_m2": [20], "family": "dichroic"});
    send(&mut socket, &json!({"start": {"id": 1, "job": {"search": search}}}));
    let said = answer(&mut socket);
    let filters = &said["result"]["said"]["design"]["sensor"]["cfa"]["filters"];
    assert_eq!(filters["C"], json!({"flat": 0.9}), "{said}");
    assert!(filters["G"]["gaussian"].is_object() && filters["R"]["samples"].is_object(), "{filters}");
    assert_eq!(filters.as_object().unwrap().len(), 4);
}

#[test]
fn designs_and_scenes_that_are_none_have_no_result() {
    let mut socket = connect();
    let mut path = design();
    path["sensor"]["cfa"]["filters"]["R"] = json!({"file": "/etc/passwd"});
    let search = |key: &str, value: Value| {
        let mut search = json!({"design": design(), "luminances_cd_m2": [10]});
        search[key] = value;
        json!({"search": search})
    };
    let mut many = design();
    let letters: Vec<String> = ('A'..='Z').chain(['a']).map(String::from).collect();
    many["sensor"]["cfa"]["pattern"] = letters.chunks(9).map(|line| line.concat()).collect();
    many["sensor"]["cfa"]["filters"] =
        letters.iter().map(|letter| (letter.clone(), json!({"flat": 0.5}))).collect();
    let capture = |design: &Value, scene: &str| json!({"capture": {"design": design, "scene": scene, "luminance_cd_m2": 5}});
    for (id, (job, expected)) in [
        (capture(&path, "spices"), "file"),
        (capture(&design(), "../../etc/passwd"), "there is no scene \"../../etc/passwd\" in the studio"),
        (capture(&design(), "photo-spices"), "there is no scene"),
        (capture(&json!({"sensor": {"rows": "many"}}), "spices"), "rows"),
        (json!({"table": {"design": []}}), "expected"),
        (
            json!({"sweep": {"design": design(), "set": "../scenes", "luminances_cd_m2": [1]}}),
            "there is no set of scenes \"../scenes\"; expected charts, natural, all",
        ),
        (
            json!({"sweep": {"design": design(), "set": "charts", "luminances_cd_m2": [0]}}),
            "a luminance of 0 cd/m²",
        ),
        (search("design", many), "the mosaic has 27 filters; a search takes at most 26"),
        (search("filters", json!(["X"])), "the array has no filter \"X\""),
        (search("cells", json!([[2, 0]])), "the cell 2, 0 is not in the tile of 2 × 2"),
        (search("luminances_cd_m2", json!([])), "0 luminances; expected 1 to 8"),
        (
            json!({"report": {"design": design(), "scene": "x", "luminances_cd_m2": [1]}}),
            "there is no scene \"x\"",
        ),
    ]
    .into_iter()
    .enumerate()
    {
        send(&mut socket, &json!({"start": {"id": id, "job": job}}));
        let said = answer(&mut socket);
        assert_eq!(said["failed"]["id"], id, "{job}: {said}");
        let message = said["failed"]["message"].as_str().unwrap();
        assert!(message.contains(expected), "{job}: {message}");
    }
}

#[test]
fn what_is_no_message_of_the_page_ends_the_connection() {
    let refused = |message: Message, code: CloseCode, expected: &str| {
        let mut socket = connect();
        // A connection that is closed while a long message is sent may refuse the rest of it.
        let _ = socket.send(message);
        let mut said = Vec::new();
        loop {
            match socket.read() {
                Ok(Message::Text(text)) => said.push(text.to_string()),
                Ok(Message::Close(frame)) => {
                    assert_eq!(frame.map(|f| f.code), Some(code));
                    break;
                }
                Ok(other) => panic!("{other}"),
                Err(_) => break,
            }
        }
        assert!(said.iter().any(|text| text.contains(expected)), "{expected}: {said:?}");
    };
    for text in ["", "x", "[]", "{\"start\": {}}", "{\"cancel\": {\"id\": 1, \"path\": \"../x\"}}"] {
        refused(Message::text(text), CloseCode::Policy, "the message is no request");
    }
    let deep =
        format!("{{\"start\": {{\"id\": 1, \"job\": {{\"table\": {{\"design\": {}", "[".repeat(100_000));
    refused(Message::text(deep), CloseCode::Policy, "recursion limit exceeded");
    refused(Message::binary(vec![0; 16]), CloseCode::Unsupported, "a binary message; expected text");
    refused(Message::text(" ".repeat(MOST_MESSAGE_BYTES + 1)), CloseCode::Size, "too long");
}

#[test]
fn the_token_and_the_origin_are_those_of_the_page() {
    let own = origin();
    assert!(connect_to(server(), Some(&own)).is_ok());
    assert_eq!(connect_to(server(), None).err(), Some(403));
    assert_eq!(connect_to(server(), Some("http://evil.example")).err(), Some(403));
    assert_eq!(connect_to(server(), Some("null")).err(), Some(403));
    assert_eq!(connect_to(&format!("{own}/"), Some(&own)).err(), Some(403), "without a token");
    let token = server().trim_end_matches('/').rsplit('/').next().unwrap();
    let wrong = server().replace(token, &"0".repeat(32));
    assert_eq!(connect_to(&wrong, Some(&own)).err(), Some(403));
}
