//! Pictures by the graphics protocol of the terminal kitty, which other terminals support as well:
//! <https://sw.kovidgoyal.net/kitty/graphics-protocol/>.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use super::picture::Pixels;
use crate::terminal;

/// The protocol's limit of base64 characters in one command.
const CHUNK: usize = 4096;

/// Encodes a picture as PNG (`f=100`) that is displayed at once (`a=T`), scaled to `columns` (`c`) and to the rows (`r`) that keep
/// its aspect ratio, which kitty before 0.27 does not compute. The terminal must not reply (`q=2`): the shell would read it.
pub(super) fn encode(picture: &Pixels, columns: usize) -> anyhow::Result<String> {
    let height = columns as f64 * picture.height as f64 / picture.width.max(1) as f64;
    let rows = (height / terminal::cell_shape()).round().max(1.0);
    let text = STANDARD.encode(picture.png()?);
    let mut out = String::new();
    let mut rest = text.as_str();
    let mut control = format!("a=T,f=100,c={columns},r={rows},q=2,");
    while !rest.is_empty() {
        let (chunk, after) = rest.split_at_checked(CHUNK).unwrap_or((rest, ""));
        let more = u8::from(!after.is_empty());
        out += &format!("\x1b_G{control}m={more};{chunk}\x1b\\");
        control.clear();
        rest = after;
    }
    Ok(out + "\n")
}
