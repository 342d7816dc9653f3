//! The capabilities of standard output: width, colours, graphics.

use std::io::IsTerminal;

use clap::ValueEnum;
use smalti_report::Rgb;

/// Width where it is unknown.
const USUAL_COLUMNS: usize = 80;
/// The least width for drawings.
const MIN_COLUMNS: usize = 20;

/// The graphics of drawings, as an option.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum GraphicsChoice {
    /// The best graphics that the terminal is known to support
    Auto,
    /// Pictures by the protocol of the terminal kitty
    Kitty,
    /// Pictures as sixels
    Sixel,
    /// Coloured blocks
    Blocks,
    /// Letters
    Text,
}

/// The use of colours, as an option.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum ColorChoice {
    /// On a terminal with colours, unless `NO_COLOR` is set
    Auto,
    /// Always, also when piped
    Always,
    /// Never
    Never,
}

/// A graphics protocol.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Protocol {
    /// Escape codes that contain a PNG.
    Kitty,
    /// Bands of six rows of pixels.
    Sixel,
}

/// The colours of a terminal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Depth {
    /// All of sRGB.
    True,
    /// The 6 × 6 × 6 colours and 24 greys of xterm.
    Indexed,
}

/// The capabilities of standard output.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Screen {
    /// Width in characters.
    pub(crate) columns: usize,
    /// Height in characters, on a terminal.
    pub(crate) rows: Option<usize>,
    /// The protocol for pictures; `None`: pictures are drawn as characters.
    pub(crate) protocol: Option<Protocol>,
    /// The colours; `None`: no colours and no control codes.
    pub(crate) depth: Option<Depth>,
}

impl Screen {
    /// Detects the capabilities of standard output.
    pub(crate) fn of_stdout(graphics: GraphicsChoice, color: ColorChoice) -> Self {
        let env = |name: &str| std::env::var(name).ok();
        let (protocol, depth) = capabilities(&env, std::io::stdout().is_terminal(), graphics, color);
        let stated = env("COLUMNS").and_then(|c| c.parse().ok());
        let columns = columns().or(stated).unwrap_or(USUAL_COLUMNS);
        Self { columns: columns.max(MIN_COLUMNS), rows: size().map(|(_, rows)| rows), protocol, depth }
    }

    /// Text in a colour; unchanged where there are no colours.
    pub(crate) fn colored(&self, color: Rgb, text: &str) -> String {
        match self.depth {
            Some(depth) => format!("\x1b[38;{}m{text}\x1b[0m", code(depth, color)),
            None => text.to_owned(),
        }
    }

    /// Text on a coloured ground, in black or white.
    pub(crate) fn on_color(&self, color: Rgb, text: &str) -> String {
        match self.depth {
            Some(_) => format!("{}{text}\x1b[0m", self.colors(color.ink(), Some(color))),
            None => text.to_owned(),
        }
    }

    /// The control code for text in the colour `ink` on `ground`, or on the ground of the terminal; empty where there are no colours.
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

/// Width of standard output in characters; `None` when it is no terminal.
pub(crate) fn columns() -> Option<usize> {
    size().map(|(columns, _)| columns)
}

/// Height of the terminal of standard error in rows; `None` when it is no terminal.
pub(crate) fn rows_of_errors() -> Option<usize> {
    let (_, height) = terminal_size::terminal_size_of(std::io::stderr())?;
    (height.0 > 0).then_some(height.0.into())
}

/// Ratio of height to width of a character; 2 where the terminal does not report it.
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
    // Some terminals, such as those of continuous integration, report 0.
    (width.0 > 0 && std::io::stdout().is_terminal()).then_some((width.0.into(), height.0.into()))
}

/// The protocol and the colours from the options and the environment. The terminal is not queried: without an answer the program
/// would hang.
fn capabilities(
    env: &dyn Fn(&str) -> Option<String>,
    is_terminal: bool,
    graphics: GraphicsChoice,
    color: ColorChoice,
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
        ColorChoice::Always => true,
        ColorChoice::Never => false,
        ColorChoice::Auto => is_terminal && !unable && set("NO_COLOR").is_none(),
    };
    match graphics {
        GraphicsChoice::Kitty => (Some(Protocol::Kitty), depth),
        GraphicsChoice::Sixel => (Some(Protocol::Sixel), depth),
        GraphicsChoice::Blocks => (None, depth),
        GraphicsChoice::Text => (None, None),
        GraphicsChoice::Auto if !colorful => (None, None),
        // Multiplexers do not pass pictures on.
        GraphicsChoice::Auto if !is_terminal || multiplexed => (None, depth),
        GraphicsChoice::Auto if speaks_kitty => (Some(Protocol::Kitty), depth),
        GraphicsChoice::Auto if known(&["sixel", "foot", "mlterm"]) => (Some(Protocol::Sixel), depth),
        GraphicsChoice::Auto => (None, depth),
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
        asked(vars, is_terminal, GraphicsChoice::Auto, ColorChoice::Auto)
    }

    fn asked(
        vars: &[(&str, &str)],
        is_terminal: bool,
        graphics: GraphicsChoice,
        color: ColorChoice,
    ) -> (Option<Protocol>, Option<Depth>) {
        let env = |name: &str| vars.iter().find(|(n, _)| *n == name).map(|(_, v)| (*v).to_owned());
        capabilities(&env, is_terminal, graphics, color)
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
        assert_eq!(
            asked(&kitty, false, GraphicsChoice::Auto, ColorChoice::Always),
            (None, Some(Depth::True))
        );
        assert_eq!(asked(&kitty, true, GraphicsChoice::Blocks, ColorChoice::Auto), (None, Some(Depth::True)));
        assert_eq!(asked(&kitty, true, GraphicsChoice::Text, ColorChoice::Always), (None, None));
        assert_eq!(asked(&[], false, GraphicsChoice::Sixel, ColorChoice::Auto).0, Some(Protocol::Sixel));
        assert_eq!(asked(&kitty[..1], true, GraphicsChoice::Auto, ColorChoice::Never), (None, None));
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
