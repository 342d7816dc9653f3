//! What standard output can show: how wide it is, whether in colour, whether pictures.

use std::io::IsTerminal;

use clap::ValueEnum;
use smalti_report::Rgb;

/// Width where nothing says how wide: that of a terminal since there have been any.
const USUAL_COLUMNS: usize = 80;
/// Narrower, nothing can be drawn.
const LEAST_COLUMNS: usize = 20;

/// How things are drawn, as asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Graphics {
    /// The best that the terminal is known to show
    Auto,
    /// Pictures, by the protocol of the terminal kitty
    Kitty,
    /// Pictures, as sixels
    Sixel,
    /// Coloured blocks
    Blocks,
    /// Letters
    Text,
}

/// Whether to use colours.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum When {
    /// On a terminal that shows them, unless `NO_COLOR` is set
    Auto,
    /// Also when piped
    Always,
    /// Never
    Never,
}

/// How pictures get to the terminal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Protocol {
    /// Escape codes with a PNG in them.
    Kitty,
    /// Six rows at a time.
    Sixel,
}

/// Which colours there are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Depth {
    /// All of sRGB.
    True,
    /// The 6 × 6 × 6 colours and 24 greys of xterm.
    Indexed,
}

/// What standard output can show.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Screen {
    /// Columns.
    pub(crate) columns: usize,
    /// Rows, on a terminal.
    pub(crate) rows: Option<usize>,
    /// How pictures get there; `None`: not at all.
    pub(crate) protocol: Option<Protocol>,
    /// Which colours there are; `None`: none, and no control codes.
    pub(crate) depth: Option<Depth>,
}

impl Screen {
    /// Standard output.
    pub(crate) fn of_stdout(graphics: Graphics, color: When) -> Self {
        let env = |name: &str| std::env::var(name).ok();
        let (protocol, depth) = able(&env, std::io::stdout().is_terminal(), graphics, color);
        let told = env("COLUMNS").and_then(|c| c.parse().ok());
        let columns = columns().or(told).unwrap_or(USUAL_COLUMNS);
        Self { columns: columns.max(LEAST_COLUMNS), rows: size().map(|(_, rows)| rows), protocol, depth }
    }

    /// Text in a colour, as it is where there are none.
    pub(crate) fn colored(&self, color: Rgb, text: &str) -> String {
        match self.depth {
            Some(depth) => format!("\x1b[38;{}m{text}\x1b[0m", code(depth, color)),
            None => text.to_owned(),
        }
    }

    /// Text on a colour, in black or white.
    pub(crate) fn on_color(&self, color: Rgb, text: &str) -> String {
        match self.depth {
            Some(depth) => {
                format!("\x1b[38;{};48;{}m{text}\x1b[0m", code(depth, color.ink()), code(depth, color))
            }
            None => text.to_owned(),
        }
    }

    /// The control code for text in a colour on another, that of the terminal where there is none; nothing where there are no
    /// colours.
    pub(crate) fn colors(&self, ink: Rgb, ground: Option<Rgb>) -> String {
        match (self.depth, ground) {
            (Some(depth), Some(ground)) => {
                format!("\x1b[38;{};48;{}m", code(depth, ink), code(depth, ground))
            }
            (Some(depth), None) => format!("\x1b[0;38;{}m", code(depth, ink)),
            (None, _) => String::new(),
        }
    }
}

/// Columns of standard output; `None` when it is no terminal.
pub(crate) fn columns() -> Option<usize> {
    size().map(|(columns, _)| columns)
}

/// How much higher than wide a character is; about two where the terminal does not say.
pub(crate) fn cell_shape() -> f64 {
    #[cfg(unix)]
    if let Ok(size) = rustix::termios::tcgetwinsize(std::io::stdout()) {
        let [across, down, columns, rows] =
            [size.ws_xpixel, size.ws_ypixel, size.ws_col, size.ws_row].map(f64::from);
        let shape = (down * columns) / (across * rows);
        if (1.0..4.0).contains(&shape) {
            return shape;
        }
    }
    2.0
}

fn size() -> Option<(usize, usize)> {
    let (width, height) = terminal_size::terminal_size_of(std::io::stdout())?;
    // Some terminals, such as those of continuous integration, say 0.
    (width.0 > 0 && std::io::stdout().is_terminal()).then_some((width.0.into(), height.0.into()))
}

/// Pictures and colours. What is asked for holds; the terminal is never asked, since one that does not answer would hang.
fn able(
    env: &dyn Fn(&str) -> Option<String>,
    is_terminal: bool,
    graphics: Graphics,
    color: When,
) -> (Option<Protocol>, Option<Depth>) {
    let set = |name: &str| env(name).filter(|v| !v.is_empty());
    let term = set("TERM").unwrap_or_default();
    let program = set("TERM_PROGRAM").unwrap_or_default().to_lowercase();
    let known = |names: &[&str]| names.iter().any(|n| term.contains(n) || program == *n);
    let multiplexed = set("TMUX").is_some() || term.starts_with("screen") || term.starts_with("tmux");
    let speaks_kitty = known(&["kitty", "wezterm", "ghostty"]) || set("KITTY_WINDOW_ID").is_some();
    let truecolor = matches!(set("COLORTERM").as_deref(), Some("truecolor" | "24bit"))
        || set("WT_SESSION").is_some()
        || speaks_kitty
        || term.contains("direct");
    let depth = Some(if truecolor { Depth::True } else { Depth::Indexed });
    let unable = term == "dumb" || (term.is_empty() && cfg!(unix));
    let colorful = match color {
        When::Always => true,
        When::Never => false,
        When::Auto => is_terminal && !unable && set("NO_COLOR").is_none(),
    };
    match graphics {
        Graphics::Kitty => (Some(Protocol::Kitty), depth),
        Graphics::Sixel => (Some(Protocol::Sixel), depth),
        Graphics::Blocks => (None, depth),
        Graphics::Text => (None, None),
        Graphics::Auto if !colorful => (None, None),
        // Pictures are for eyes, and do not pass through a multiplexer.
        Graphics::Auto if !is_terminal || multiplexed => (None, depth),
        Graphics::Auto if speaks_kitty => (Some(Protocol::Kitty), depth),
        Graphics::Auto if known(&["sixel", "foot", "mlterm"]) => (Some(Protocol::Sixel), depth),
        Graphics::Auto => (None, depth),
    }
}

/// A colour in a control code (ITU-T T.416): itself, or the nearest of xterm's palette.
fn code(depth: Depth, Rgb(r, g, b): Rgb) -> String {
    match depth {
        Depth::True => format!("2;{r};{g};{b}"),
        Depth::Indexed => format!("5;{}", nearest_indexed([r, g, b])),
    }
}

/// The nearest of xterm's colours 16–255: a cube of 0, 95, 135, 175, 215, 255, and greys from 8 in steps of 10.
fn nearest_indexed(rgb: [u8; 3]) -> u16 {
    let level = |i: u16| if i == 0 { 0 } else { 55 + 40 * i };
    let nearest = |v: u8| (0..6).min_by_key(|&i| level(i).abs_diff(v.into())).unwrap_or(0);
    let far =
        |other: [u16; 3]| rgb.iter().zip(other).map(|(&a, b)| u32::from(b.abs_diff(a.into())).pow(2)).sum();
    let cube = rgb.map(nearest);
    let grey = (rgb.iter().map(|&v| u16::from(v)).sum::<u16>() / 3).saturating_sub(3) / 10;
    let grey = grey.min(23);
    let (in_cube, in_greys): (u32, u32) = (far(cube.map(level)), far([8 + 10 * grey; 3]));
    if in_greys < in_cube { 232 + grey } else { 16 + 36 * cube[0] + 6 * cube[1] + cube[2] }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(vars: &[(&str, &str)], is_terminal: bool) -> (Option<Protocol>, Option<Depth>) {
        asked(vars, is_terminal, Graphics::Auto, When::Auto)
    }

    fn asked(
        vars: &[(&str, &str)],
        is_terminal: bool,
        graphics: Graphics,
        color: When,
    ) -> (Option<Protocol>, Option<Depth>) {
        let env = |name: &str| vars.iter().find(|(n, _)| *n == name).map(|(_, v)| (*v).to_owned());
        able(&env, is_terminal, graphics, color)
    }

    #[test]
    fn terminals_are_known_by_what_they_say() {
        let (yes, indexed) = (Some(Depth::True), Some(Depth::Indexed));
        for (vars, expected) in [
            (&[("TERM", "xterm-256color")][..], (None, indexed)),
            (&[("TERM", "xterm-256color"), ("COLORTERM", "truecolor")], (None, yes)),
            (&[("TERM", "xterm-256color"), ("COLORTERM", "24bit")], (None, yes)),
            (&[("TERM", "xterm-kitty")], (Some(Protocol::Kitty), yes)),
            (&[("TERM", "xterm-256color"), ("KITTY_WINDOW_ID", "1")], (Some(Protocol::Kitty), yes)),
            (&[("TERM", "xterm-256color"), ("TERM_PROGRAM", "WezTerm")], (Some(Protocol::Kitty), yes)),
            (&[("TERM", "xterm-ghostty")], (Some(Protocol::Kitty), yes)),
            (&[("TERM", "tmux-256color"), ("KITTY_WINDOW_ID", "1"), ("TMUX", "x")], (None, yes)),
            (&[("TERM", "foot")], (Some(Protocol::Sixel), indexed)),
            (&[("TERM", "xterm-sixel")], (Some(Protocol::Sixel), indexed)),
            (&[("TERM", "dumb"), ("COLORTERM", "truecolor")], (None, None)),
            (&[("TERM", "xterm-kitty"), ("NO_COLOR", "1")], (None, None)),
            (&[("TERM", "xterm-kitty"), ("NO_COLOR", "")], (Some(Protocol::Kitty), yes)),
        ] {
            assert_eq!(of(vars, true), expected, "{vars:?}");
            assert_eq!(of(vars, false), (None, None), "{vars:?} piped");
        }
    }

    #[test]
    fn what_is_asked_for_holds() {
        let kitty = [("TERM", "xterm-kitty"), ("NO_COLOR", "1")];
        assert_eq!(asked(&kitty, false, Graphics::Auto, When::Always), (None, Some(Depth::True)));
        assert_eq!(asked(&kitty, true, Graphics::Blocks, When::Auto), (None, Some(Depth::True)));
        assert_eq!(asked(&kitty, true, Graphics::Text, When::Always), (None, None));
        assert_eq!(asked(&[], false, Graphics::Sixel, When::Auto).0, Some(Protocol::Sixel));
        assert_eq!(asked(&kitty[..1], true, Graphics::Auto, When::Never), (None, None));
    }

    #[test]
    fn indexed_colours_are_the_nearest() {
        for (rgb, index) in [
            ([0, 0, 0], 16),
            ([255, 255, 255], 231),
            ([255, 0, 0], 196),
            ([128, 128, 128], 244),
            ([95, 135, 175], 67),
        ] {
            assert_eq!(nearest_indexed(rgb), index, "{rgb:?}");
        }
    }
}
