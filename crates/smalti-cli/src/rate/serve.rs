//! `smalti rate serve`: shows the pairs to observers.

use std::path::PathBuf;

use clap::Args;
use serde_json::json;
use smalti_serve::{LocalServer, rating};

use crate::args::Common;
use crate::output::note;

#[derive(Debug, Clone, Args)]
#[command(after_help = "Examples:\n  \
    smalti rate serve trial\n  \
    smalti rate serve trial --port 8080\n\n\
    The address contains a token, and the server answers only browsers on this machine. Several observers may take part at the same time, each in a \
    window of their own, or one after another: a new window asks for a new observer. Nobody can see the answers of others. Every answer is on the disk \
    before the next pair is shown. After Ctrl-C or a crash, the same command serves the same address, and open pages continue. Somebody whose window was \
    closed opens the address again and chooses to continue as the observer who began there.")]
pub(crate) struct Serve {
    /// Folder of an experiment (smalti rate init)
    pub(crate) folder: PathBuf,
    /// Port on 127.0.0.1 [default: that of the last time, else a free one]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub(crate) port: Option<u16>,
    /// Print the address as JSON
    #[arg(long)]
    pub(crate) json: bool,
}

pub(super) fn run(args: &Serve, common: &Common) -> anyhow::Result<()> {
    let experiment = rating::Experiment::open(&args.folder)?;
    let kept = experiment.kept_address();
    let server = LocalServer::bind(args.port, kept)?;
    experiment.keep_address(&server.address())?;
    let address = server.url();
    if args.json {
        crate::output::print_document(&format!("{}\n", json!({"address": address})))?;
    } else {
        crate::print(&format!("{address}\n"))?;
        note(
            "observers open this address in their browser; Ctrl-C ends the server, and no answer is lost",
            common,
        );
    }
    Ok(server.run(rating::routes(experiment))?)
}
