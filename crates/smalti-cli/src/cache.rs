//! `smalti cache`: shows and empties the cache.

use clap::Args;
use serde_json::json;
use smalti_io::cache::Cache;

use crate::output::{print, print_json};
use crate::table;

#[derive(Debug, Clone, Args)]
#[command(after_help = "Examples:\n  \
    smalti cache\n  \
    smalti cache --clear\n  \
    SMALTI_CACHE_GB=20 smalti compare bayer rgbw\n\n\
    evaluate, compare, sweep, design and studio keep optical images, training statistics, pipelines, scores and light in the folder\n\
    SMALTI_CACHE_DIR, by default smalti in the user's cache folder. SMALTI_CACHE_GB is its largest size in units of 10⁹ bytes [default: 2];\n\
    the entries not used for longest are removed first. Entries not used for SMALTI_CACHE_DAYS days [default: 90] are removed too.\n\
    An entry that is damaged, cut short or belongs to something else is never used but computed again.")]
pub(crate) struct CacheArgs {
    /// Remove all entries; other files in the folder stay
    #[arg(long)]
    pub(crate) clear: bool,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}

pub(crate) fn run(args: &CacheArgs) -> anyhow::Result<()> {
    let cache = Cache::open(None)?;
    let removed = if args.clear { Some(cache.clear()?) } else { None };
    let content = cache.content()?;
    let total: u64 = content.iter().map(|u| u.bytes).sum();
    let days = |duration: std::time::Duration| duration.as_secs_f64() / 86400.0;
    let age = |used: Option<std::time::SystemTime>| used.map(|t| days(t.elapsed().unwrap_or_default()));
    let limits = cache.limits();
    if args.json {
        let kinds = content.iter().map(|u| {
            json!({ "kind": u.kind.plural(), "entries": u.entries, "bytes": u.bytes, "oldest_use_days": age(u.oldest_use) })
        });
        return print_json(&json!({
            "folder": cache.folder(),
            "bytes": total,
            "limit_bytes": limits.bytes,
            "limit_days": days(limits.unused),
            "removed_bytes": removed,
            "kinds": kinds.collect::<Vec<_>>(),
        }));
    }
    let megabytes = |bytes: u64| format!("{:.1}", bytes as f64 / 1e6);
    let Some(folder) = cache.folder() else {
        return print("There is no cache: neither SMALTI_CACHE_DIR nor a home folder is set.\n");
    };
    if let Some(bytes) = removed {
        return print(&format!("Removed {} MB from {}.\n", megabytes(bytes), folder.display()));
    }
    let rows: Vec<Vec<String>> = content
        .iter()
        .map(|u| {
            let age = age(u.oldest_use).map_or_else(|| "–".to_owned(), |d| format!("{d:.0}"));
            vec![u.kind.plural().to_owned(), u.entries.to_string(), megabytes(u.bytes), age]
        })
        .collect();
    print(&format!(
        "{}\n{} of at most {} MB; entries not used for {:.0} days are removed\n\n{}",
        folder.display(),
        megabytes(total),
        megabytes(limits.bytes),
        days(limits.unused),
        table::render(&["", "entries", "MB", "oldest use, days ago"], &rows)
    ))
}
