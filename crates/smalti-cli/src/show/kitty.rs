//! Pictures by the graphics protocol of the terminal kitty, which others speak as well:
//! <https://sw.kovidgoyal.net/kitty/graphics-protocol/>.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use super::picture::Pixels;

/// Most characters of base64 in one command, as the protocol has it.
const CHUNK: usize = 4096;

/// A picture as PNG (`f=100`) to be shown at once (`a=T`), scaled to so many columns (`c`); the terminal is not to answer
/// (`q=2`), since the shell would read it.
pub(super) fn encode(picture: &Pixels, columns: usize) -> anyhow::Result<String> {
    let text = STANDARD.encode(picture.png()?);
    let mut out = String::new();
    let mut rest = text.as_str();
    let mut control = format!("a=T,f=100,c={columns},q=2,");
    while !rest.is_empty() {
        let (chunk, after) = rest.split_at_checked(CHUNK).unwrap_or((rest, ""));
        let more = u8::from(!after.is_empty());
        out += &format!("\x1b_G{control}m={more};{chunk}\x1b\\");
        control.clear();
        rest = after;
    }
    Ok(out + "\n")
}
