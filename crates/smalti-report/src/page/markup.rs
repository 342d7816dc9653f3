//! HTML that cannot hold unescaped text: [`Markup`] is made of elements and of text, and text is escaped on its way in.

use serde_json::Value;

use crate::Figure;
use crate::text::{clean, escape};

/// A piece of HTML. Whatever text is in it was escaped when it was put there; there is no way to put any in as it is.
///
/// ```
/// use smalti_report::page::{Markup, el};
/// let name: Markup = el("p").class("name").child("<script>").into();
/// assert_eq!(name.as_str(), "<p class=\"name\">&lt;script&gt;</p>");
/// ```
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Markup(String);

impl Markup {
    /// Nothing.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// The HTML.
    #[must_use]
    pub fn as_str(&self) -> &str {
        &self.0
    }

    /// Adds what follows.
    #[must_use]
    pub fn and(mut self, more: impl Into<Self>) -> Self {
        self.0.push_str(&more.into().0);
        self
    }

    /// Text of several lines, for `pre`: line ends stay.
    #[must_use]
    pub fn lines(text: &str) -> Self {
        Self(text.lines().map(escape).collect::<Vec<_>>().join("\n"))
    }

    /// Of the crate's own making: a constant, or what was escaped before.
    pub(super) fn trusted(html: String) -> Self {
        Self(html)
    }
}

impl<T: AsRef<str>> From<T> for Markup {
    /// Escaped. Controls, and marks that turn the direction of what follows, become `�`.
    fn from(text: T) -> Self {
        Self(escape(text.as_ref()))
    }
}

impl From<&Figure> for Markup {
    /// The figure's SVG in the page, with its title and description. The page's own sheet of styles gives it the colours of
    /// the page and keeps enlarged pixels square: its policy allows no style in an element.
    fn from(figure: &Figure) -> Self {
        Self(figure.svg().replace(" style=\"image-rendering:pixelated\"", ""))
    }
}

impl<T: Into<Markup>> FromIterator<T> for Markup {
    fn from_iter<I: IntoIterator<Item = T>>(parts: I) -> Self {
        parts.into_iter().fold(Self::new(), Self::and)
    }
}

/// Elements without content.
const VOID: [&str; 5] = ["br", "hr", "img", "input", "meta"];

/// An element in the making. Names of elements and attributes are words of the program; values are text.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Element {
    name: &'static str,
    attributes: String,
    content: Markup,
}

/// An element of a name: `el("p").class("lead").child("text")`.
#[must_use]
pub fn el(name: &'static str) -> Element {
    Element { name, attributes: String::new(), content: Markup::new() }
}

impl Element {
    /// An attribute; its value is escaped.
    #[must_use]
    pub fn attr(mut self, name: &'static str, value: impl AsRef<str>) -> Self {
        self.attributes.push_str(&format!(" {name}=\"{}\"", escape(value.as_ref())));
        self
    }

    /// An attribute without a value.
    #[must_use]
    pub fn flag(mut self, name: &'static str) -> Self {
        self.attributes.push_str(&format!(" {name}"));
        self
    }

    /// The classes, apart by spaces.
    #[must_use]
    pub fn class(self, classes: &str) -> Self {
        self.attr("class", classes)
    }

    /// The id.
    #[must_use]
    pub fn id(self, id: &str) -> Self {
        self.attr("id", id)
    }

    /// Adds content: text, which is escaped, or markup.
    #[must_use]
    pub fn child(mut self, content: impl Into<Markup>) -> Self {
        self.content = self.content.and(content);
        self
    }

    /// Adds one after the other.
    #[must_use]
    pub fn children<T: Into<Markup>>(self, parts: impl IntoIterator<Item = T>) -> Self {
        let parts: Markup = parts.into_iter().collect();
        self.child(parts)
    }
}

impl From<Element> for Markup {
    fn from(Element { name, attributes, content }: Element) -> Self {
        if VOID.contains(&name) {
            return Self(format!("<{name}{attributes}>"));
        }
        Self(format!("<{name}{attributes}>{}</{name}>", content.0))
    }
}

/// JSON as the content of a `script` element that is no program. `<` and `&` and the two line ends that JSON allows and old
/// scripts do not are written as `\u` escapes, so that no value ends the element; in texts, what [`clean`] takes from
/// labels is taken here too.
pub(super) fn json(value: &Value) -> String {
    let joined = |parts: Vec<String>| parts.join(",");
    match value {
        Value::String(text) => json_text(text),
        Value::Array(values) => format!("[{}]", joined(values.iter().map(json).collect())),
        Value::Object(map) => {
            let pair = |(key, value): (&String, &Value)| format!("{}:{}", json_text(key), json(value));
            format!("{{{}}}", joined(map.iter().map(pair).collect()))
        }
        other => other.to_string(),
    }
}

fn json_text(text: &str) -> String {
    // Line ends stay: a text may be a command of several lines.
    let lines: Vec<String> = text.split('\n').map(clean).collect();
    let mut json = Value::from(lines.join("\n")).to_string();
    for c in ['<', '>', '&', '\u{2028}', '\u{2029}'] {
        json = json.replace(c, &format!("\\u{:04x}", u32::from(c)));
    }
    json
}
