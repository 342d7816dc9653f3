//! Text: the fonts of the crate, the width of text, and the escaping of text from outside.

use skrifa::MetadataProvider;
use skrifa::instance::{LocationRef, Size};

/// Inter, [OFL 1.1](https://openfontlicense.org), in `fonts/`.
pub(crate) const REGULAR: &[u8] = include_bytes!("../fonts/Inter-Regular.otf");
pub(crate) const SEMI_BOLD: &[u8] = include_bytes!("../fonts/Inter-SemiBold.otf");

/// The font of the PNG, then fonts of similar width.
pub(crate) const FAMILY: &str = "Inter, 'Helvetica Neue', Arial, 'Liberation Sans', sans-serif";

/// Size and weight of text.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Font {
    pub(crate) size: f64,
    pub(crate) bold: bool,
}

pub(crate) const fn plain(size: f64) -> Font {
    Font { size, bold: false }
}

pub(crate) const fn bold(size: f64) -> Font {
    Font { size, bold: true }
}

/// Labels of ticks, and names in a legend.
pub(crate) const TICK: Font = plain(17.0);
/// Labels of axes.
pub(crate) const LABEL: Font = plain(19.0);

/// Width of a text in pixels, without kerning.
pub(crate) fn width(text: &str, font: Font) -> f64 {
    let data = if font.bold { SEMI_BOLD } else { REGULAR };
    let Ok(face) = skrifa::FontRef::new(data) else { return text.chars().count() as f64 * font.size * 0.6 };
    let metrics = face.glyph_metrics(Size::unscaled(), LocationRef::default());
    let units = f64::from(face.metrics(Size::unscaled(), LocationRef::default()).units_per_em).max(1.0);
    let map = face.charmap();
    // A character that the font lacks is counted as one em.
    let advance =
        |c: char| map.map(c).and_then(|g| metrics.advance_width(g)).map_or(1.0, |w| f64::from(w) / units);
    text.chars().map(advance).sum::<f64>() * font.size
}

/// Replaces control characters, which XML forbids, and bidirectional marks, which reverse the direction of text, by `�`. Line ends
/// and tabs become spaces.
pub(crate) fn clean(text: &str) -> String {
    smalti::names::in_one_line(text).into_owned()
}

/// Escapes a label for XML text or attributes.
pub(crate) fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in clean(text).chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            c => out.push(c),
        }
    }
    out
}

/// The text, truncated with an ellipsis where it is wider than `limit` pixels.
pub(crate) fn fit(text: &str, font: Font, limit: f64) -> String {
    if width(text, font) <= limit {
        return text.to_owned();
    }
    let room = limit - width("…", font);
    let mut out = String::new();
    let mut used = 0.0;
    for c in text.chars() {
        used += width(c.encode_utf8(&mut [0; 4]), font);
        if used > room {
            break;
        }
        out.push(c);
    }
    out.truncate(out.trim_end().len());
    out.push('…');
    out
}

/// The text in lines of at most `limit` pixels, wrapped at line ends and spaces; text beyond `lines` lines is truncated.
pub(crate) fn wrap(text: &str, font: Font, limit: f64, lines: usize) -> Vec<String> {
    let mut out: Vec<String> = Vec::new();
    for paragraph in text.split('\n') {
        let mut fresh = true;
        for word in clean(paragraph).split(' ').filter(|w| !w.is_empty()) {
            let full = out.len() == lines;
            match out.last_mut() {
                Some(line) if full || (!fresh && width(&format!("{line} {word}"), font) <= limit) => {
                    line.push(' ');
                    line.push_str(word);
                }
                _ => out.push(word.to_owned()),
            }
            fresh = false;
        }
    }
    out.iter().map(|line| fit(line, font, limit)).collect()
}
