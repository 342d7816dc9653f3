//! The available memory.

use std::fs;
use std::path::Path;

use crate::IoError;

/// What takes less is not compared with the available memory.
const SMALL_BYTES: u64 = 64 << 20;

/// Bytes that are available without swapping, by the system, by the limit of the container and by those of the process (`ulimit -v` and
/// `-d`); `None` on systems other than Linux.
#[must_use]
pub fn available_bytes() -> Option<u64> {
    let system = of_meminfo(&fs::read_to_string("/proc/meminfo").ok()?)?;
    let number = |path: &str| fs::read_to_string(path).ok()?.trim().parse::<u64>().ok();
    let container =
        number("/sys/fs/cgroup/memory.max").or_else(|| number("/sys/fs/cgroup/memory/memory.limit_in_bytes"));
    let read = |path: &str| fs::read_to_string(path).unwrap_or_default();
    let process = of_process(&read("/proc/self/limits"), &read("/proc/self/status"));
    Some([container, process].into_iter().flatten().fold(system, u64::min))
}

/// Refuses what takes more memory than is available, an eighth of it left to everything else: without room, an allocation ends the
/// program.
pub(crate) fn ensure_available(path: &Path, what: &'static str, bytes: u64) -> Result<(), IoError> {
    if bytes < SMALL_BYTES {
        return Ok(());
    }
    match available_bytes().map(|available| available / 8 * 7) {
        Some(available) if bytes > available => {
            Err(IoError::Memory { path: path.to_owned(), what, bytes, available })
        }
        _ => Ok(()),
    }
}

/// The bytes of a line of `/proc/meminfo` or `/proc/self/status`.
fn line_of(text: &str, name: &str) -> Option<u64> {
    let line = text.lines().find_map(|l| l.strip_prefix(name)?.strip_prefix(':'))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()?.checked_mul(1024)
}

fn of_meminfo(text: &str) -> Option<u64> {
    line_of(text, "MemAvailable")
}

/// What the limits of the process leave; `None` where there are none.
fn of_process(limits: &str, status: &str) -> Option<u64> {
    let left = |limit: &str, used: &str| {
        let line = limits.lines().find_map(|l| l.strip_prefix(limit))?;
        // The soft limit comes first; it may be \"unlimited\".
        let limit = line.split_whitespace().next()?.parse::<u64>().ok()?;
        Some(limit.saturating_sub(line_of(status, used)?))
    };
    [left("Max address space", "VmSize"), left("Max data size", "VmData")].into_iter().flatten().min()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_line_of_available_memory_is_found() {
        assert_eq!(of_meminfo("MemTotal:  9 kB\nMemAvailable:   2048 kB\n"), Some(2 << 20));
        assert_eq!(of_meminfo("MemAvailable: many kB\n"), None);
        assert_eq!(of_meminfo(""), None);
    }

    #[test]
    fn the_limits_of_the_process_count() {
        let status = "VmPeak:\t  900 kB\nVmSize:\t  800 kB\nVmData:\t  300 kB\n";
        let limits = |data: &str, space: &str| {
            format!(
                "Limit                     Soft Limit           Hard Limit           Units\n\
                 Max data size             {data}               unlimited            bytes\n\
                 Max address space         {space}              unlimited            bytes\n"
            )
        };
        let left = |data, space| of_process(&limits(data, space), status);
        assert_eq!(left("unlimited", "unlimited"), None);
        assert_eq!(left("1024000", "unlimited"), Some(1_024_000 - 300 * 1024));
        assert_eq!(left("unlimited", "1024000"), Some(1_024_000 - 800 * 1024));
        assert_eq!(left("1024000", "1024000"), Some(1_024_000 - 800 * 1024));
        assert_eq!(left("1", "unlimited"), Some(0));
        assert_eq!(of_process("", status), None);
    }

    #[test]
    fn more_than_there_is_is_refused() {
        let ensure = |bytes| ensure_available(Path::new("a.exr"), "the image", bytes);
        ensure(1 << 20).unwrap();
        if let Some(available) = available_bytes() {
            let error = ensure(available.max(SMALL_BYTES) * 2).unwrap_err().to_string();
            assert!(error.starts_with("a.exr: the image takes "), "{error}");
        }
    }
}
