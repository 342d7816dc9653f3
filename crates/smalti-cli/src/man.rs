//! Manual pages, from the texts of `--help`.

use std::path::Path;

use clap::Command;
use clap_mangen::Man;
use clap_mangen::roff::{Roff, roman};
use smalti_io::write;

/// Writes smalti.1 and a page for each command, and returns the names of the files.
pub(crate) fn write_pages(command: Command, dir: &Path) -> anyhow::Result<String> {
    write::begin_folder(dir, &[])?;
    let mut names = String::new();
    for (name, page) in pages(command)? {
        let path = dir.join(&name);
        write::bytes(&path, &page)?;
        names += &format!("{}\n", path.display());
    }
    Ok(names)
}

/// Names and contents.
fn pages(command: Command) -> std::io::Result<Vec<(String, Vec<u8>)>> {
    let mut root = command.disable_help_subcommand(true);
    root.build();
    let mut out = vec![page("smalti", root.clone())?];
    let mut open: Vec<(String, &Command)> = vec![("smalti".into(), &root)];
    while let Some((title, command)) = open.pop() {
        for sub in command.get_subcommands().filter(|s| !s.is_hide_set()) {
            let title = format!("{title}-{}", sub.get_name());
            out.push(page(&title, sub.clone())?);
            open.push((title, sub));
        }
    }
    Ok(out)
}

fn page(title: &str, command: Command) -> std::io::Result<(String, Vec<u8>)> {
    let after = command.get_after_help().map(ToString::to_string).unwrap_or_default();
    let options = command.get_arguments().any(|a| !a.is_hide_set());
    let commands = command.has_subcommands();
    let (name, synopsis) = (title.to_owned(), title.replace('-', " "));
    let source = concat!("smalti ", env!("CARGO_PKG_VERSION"));
    // The pages have no date, so that equal versions give equal pages.
    let man = Man::new(command.display_name(name).bin_name(synopsis)).title(title).source(source);
    let mut page = Vec::new();
    man.render_title(&mut page)?;
    man.render_name_section(&mut page)?;
    man.render_synopsis_section(&mut page)?;
    man.render_description_section(&mut page)?;
    if options {
        man.render_options_section(&mut page)?;
    }
    if commands {
        man.render_subcommands_section(&mut page)?;
    }
    examples(&after).to_writer(&mut page)?;
    Ok((format!("{title}.1"), page))
}

/// The text after the options in `--help`: indented lines are verbatim examples, other lines are paragraphs.
fn examples(after: &str) -> Roff {
    let mut roff = Roff::default();
    let mut lines = after.lines().peekable();
    while let Some(line) = lines.next() {
        match line {
            "" => {
                roff.control("PP", []);
            }
            "Examples:" => {
                roff.control("SH", ["EXAMPLES"]);
            }
            line if line.starts_with(' ') => {
                roff.control("nf", []).text([roman(line)]);
                while let Some(next) = lines.next_if(|l| l.starts_with(' ')) {
                    roff.text([roman(next)]);
                }
                roff.control("fi", []);
            }
            line => {
                roff.text([roman(line)]);
            }
        }
    }
    roff
}
