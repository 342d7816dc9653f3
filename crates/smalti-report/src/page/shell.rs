//! The document around the sections of a page.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::Value;
use sha2::{Digest, Sha256};

use super::markup::{Markup, el, json};
use super::{Piece, SHELL, SIMULATOR};

/// A page in the making.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Page {
    title: String,
    lead: Markup,
    sections: Vec<(String, String, Markup)>,
    pieces: Vec<Piece>,
    data: Vec<(String, Value)>,
    foot: Markup,
    simulates: bool,
}

impl Page {
    /// An empty page. The title is its heading and that of the window.
    #[must_use]
    pub fn new(title: impl Into<String>) -> Self {
        Self { title: title.into(), ..Self::default() }
    }

    /// What stands below the heading.
    #[must_use]
    pub fn lead(mut self, content: impl Into<Markup>) -> Self {
        self.lead = self.lead.and(content);
        self
    }

    /// Adds a section; the navigation leads to it. Ids are words of ASCII letters, digits and hyphens, each used once.
    #[must_use]
    pub fn section(mut self, id: &str, title: impl Into<String>, content: impl Into<Markup>) -> Self {
        self.sections.push((id.to_owned(), title.into(), content.into()));
        self
    }

    /// Adds programs and styles, in their order.
    #[must_use]
    pub fn with(mut self, pieces: &[Piece]) -> Self {
        self.pieces.extend_from_slice(pieces);
        self
    }

    /// Adds data for a program, which finds it by its id.
    #[must_use]
    pub fn data(mut self, id: &str, value: Value) -> Self {
        self.data.push((id.to_owned(), value));
        self
    }

    /// Embeds the simulator, and lets the page's own script run it as WebAssembly in a worker.
    #[must_use]
    pub fn simulator(mut self) -> Self {
        self.simulates = true;
        self.data("simulator", STANDARD.encode(SIMULATOR).into())
    }

    /// The end of the page.
    #[must_use]
    pub fn foot(mut self, content: impl Into<Markup>) -> Self {
        self.foot = self.foot.and(content);
        self
    }

    /// The document. Equal pages give equal bytes.
    #[must_use]
    pub fn html(&self) -> String {
        let pieces = || std::iter::once(&SHELL).chain(&self.pieces);
        let css: String = pieces().map(|p| p.css).collect();
        // One function around all: pieces see each other, the window sees none of them.
        let js =
            format!("(() => {{\n\"use strict\";\n{}}})();\n", pieces().map(|p| p.js).collect::<String>());
        let simulator = if self.simulates { " 'wasm-unsafe-eval'; worker-src blob:" } else { "" };
        let policy = format!(
            "default-src 'none'; script-src {}{simulator}; style-src {}; img-src data:; base-uri 'none'; form-action 'none'",
            source(&js),
            source(&css)
        );
        let meta = |name: &str, content: &str| el("meta").attr("name", name).attr("content", content);
        let head = el("head")
            .child(el("meta").attr("charset", "utf-8"))
            .child(el("meta").attr("http-equiv", "Content-Security-Policy").attr("content", policy))
            .child(meta("viewport", "width=device-width, initial-scale=1"))
            .child(meta("referrer", "no-referrer"))
            .child(meta("generator", concat!("Smalti ", env!("CARGO_PKG_VERSION"))))
            .child(el("title").child(&self.title))
            .child(el("style").child(Markup::trusted(css)));
        let links = self
            .sections
            .iter()
            .map(|(id, title, _)| el("li").child(el("a").attr("href", format!("#{id}")).child(title)));
        let bar = el("header")
            .class("bar")
            .child(el("a").class("skip").attr("href", "#content").child("Skip to the content"))
            .child(el("span").class("brand").attr("aria-hidden", "true").child(mark()).child("Smalti"))
            .child(el("nav").attr("aria-label", "Sections").child(el("ul").children(links)))
            .child(el("button").id("theme").attr("type", "button").flag("hidden").child("Dark"));
        let sections = self.sections.iter().map(|(id, title, content)| {
            let heading = format!("{id}-title");
            el("section")
                .id(id)
                .attr("aria-labelledby", &heading)
                .child(el("h2").id(&heading).child(title))
                .child(content.clone())
        });
        let main = el("main")
            .id("content")
            .attr("tabindex", "-1")
            .child(el("div").class("lead").child(el("h1").child(&self.title)).child(self.lead.clone()))
            .children(sections);
        let data = self.data.iter().map(|(id, value)| {
            el("script").attr("type", "application/json").id(id).child(Markup::trusted(json(value)))
        });
        let credits = pieces().filter(|p| !p.credit.is_empty()).map(|p| el("p").child(p.credit));
        let body = el("body")
            .child(bar)
            .child(main)
            .child(el("footer").child(self.foot.clone()).children(credits))
            .children(data)
            .child(el("script").child(Markup::trusted(js)));
        let document = Markup::from(el("html").attr("lang", "en").child(head).child(body));
        format!("<!doctype html>\n{}\n", document.as_str())
    }
}

/// Four tiles, the mark of the program.
fn mark() -> Markup {
    Markup::trusted(
        "<svg class=\"mark\" viewBox=\"0 0 20 20\" width=\"20\" height=\"20\"><rect width=\"9.3\" height=\"9.3\" rx=\"2\" fill=\"#0072b2\"/>\
         <rect x=\"10.7\" width=\"9.3\" height=\"9.3\" rx=\"2\" fill=\"#009e73\"/>\
         <rect y=\"10.7\" width=\"9.3\" height=\"9.3\" rx=\"2\" fill=\"#e69f00\"/>\
         <rect x=\"10.7\" y=\"10.7\" width=\"9.3\" height=\"9.3\" rx=\"2\" fill=\"#d55e00\"/></svg>"
            .to_owned(),
    )
}

/// The source of a content security policy that allows one text.
pub(super) fn source(text: &str) -> String {
    format!("'sha256-{}'", STANDARD.encode(Sha256::digest(text)))
}
