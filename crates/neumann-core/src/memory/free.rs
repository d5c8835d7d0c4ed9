//! How much memory is free: what the system has, and what this process may have of it.
//!
//! On Linux the least of `MemAvailable`, of what the control groups above the process leave,
//! and of its own limit on address space. Elsewhere it is not known.

use std::fs;
use std::path::Path;

/// Memory that this process could still take, bytes; `None` where the system does not say.
#[must_use]
pub fn free_bytes() -> Option<u64> {
    let read = |path: &str| fs::read_to_string(path).unwrap_or_default();
    let available = kilobytes(&read("/proc/meminfo"), "MemAvailable:")?;
    let groups = free_in_groups(Path::new("/sys/fs/cgroup"), &read("/proc/self/cgroup"));
    let space = free_address_space(&read("/proc/self/limits"), &read("/proc/self/status"));
    [groups, space]
        .into_iter()
        .flatten()
        .chain([available])
        .min()
}

/// A line `name   number kB`, in bytes.
fn kilobytes(text: &str, name: &str) -> Option<u64> {
    let line = text.lines().find(|line| line.starts_with(name))?;
    let number: u64 = line.split_whitespace().nth(1)?.parse().ok()?;
    number.checked_mul(1024)
}

/// What `ulimit -v` leaves.
fn free_address_space(limits: &str, status: &str) -> Option<u64> {
    let line = limits
        .lines()
        .find(|line| line.starts_with("Max address space"))?;
    let limit: u64 = line.split_whitespace().nth(3)?.parse().ok()?;
    Some(limit.saturating_sub(kilobytes(status, "VmSize:")?))
}

/// What the groups of a process leave, by `/proc/self/cgroup` as `membership`: each of its lines
/// is `number:controllers:path`, without controllers for version 2.
fn free_in_groups(root: &Path, membership: &str) -> Option<u64> {
    let mut least: Option<u64> = None;
    for line in membership.lines() {
        let mut parts = line.splitn(3, ':').skip(1);
        let (Some(controllers), Some(path)) = (parts.next(), parts.next()) else {
            continue;
        };
        let (top, names) = if controllers.is_empty() {
            (root.to_owned(), ["memory.max", "memory.current"])
        } else if controllers.split(',').any(|name| name == "memory") {
            let names = ["memory.limit_in_bytes", "memory.usage_in_bytes"];
            (root.join("memory"), names)
        } else {
            continue;
        };
        // The path may be that of the host, which a container does not see: then the top is its
        // own.
        let group = top.join(path.trim_start_matches('/'));
        for folder in group.ancestors().take_while(|f| f.starts_with(&top)) {
            let number = |name: &str| {
                let text = fs::read_to_string(folder.join(name)).ok()?;
                text.trim().parse::<u64>().ok()
            };
            let [limit, used] = names.map(number);
            let (Some(limit), Some(used)) = (limit, used) else {
                continue;
            };
            let free = limit.saturating_sub(used.saturating_sub(file_cache(folder)));
            least = Some(least.map_or(free, |least| least.min(free)));
        }
    }
    least
}

/// Pages of files that the system gives up when memory is wanted, bytes.
fn file_cache(folder: &Path) -> u64 {
    let text = fs::read_to_string(folder.join("memory.stat")).unwrap_or_default();
    let line = |name: &str| {
        let rest = text.lines().find_map(|line| line.strip_prefix(name))?;
        rest.trim().parse().ok()
    };
    line("inactive_file ")
        .or_else(|| line("total_inactive_file "))
        .unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::{free_address_space, free_bytes, free_in_groups, kilobytes};

    #[test]
    #[cfg(target_os = "linux")]
    fn something_is_free() {
        assert!(free_bytes().unwrap() > 1 << 20);
    }

    #[test]
    fn lines_of_the_system_are_read() {
        let text = "MemTotal:  9 kB\nMemAvailable:   2048 kB\n";
        assert_eq!(kilobytes(text, "MemAvailable:"), Some(2 << 20));
        let limits = "Max cpu time  unlimited unlimited seconds\n\
                      Max address space         3145728  unlimited  bytes\n";
        assert_eq!(free_address_space(limits, "VmSize: 1024 kB"), Some(2 << 20));
        let unlimited = limits.replace("3145728", "unlimited");
        assert_eq!(free_address_space(&unlimited, "VmSize: 1 kB"), None);
    }

    #[test]
    fn the_tightest_group_above_the_process_counts() {
        let root = std::env::temp_dir().join(format!("neumann-groups-{}", std::process::id()));
        let inner = root.join("user/job");
        fs::create_dir_all(&inner).unwrap();
        let write = |name: &str, text: &str| fs::write(root.join(name), text).unwrap();
        write("user/memory.max", "1000\n");
        write("user/memory.current", "700\n");
        write("user/memory.stat", "anon 3\ninactive_file 200\n");
        write("user/job/memory.max", "max\n");
        write("user/job/memory.current", "700\n");
        assert_eq!(free_in_groups(&root, "0::/user/job\n"), Some(500));
        assert_eq!(free_in_groups(&root, "0::/elsewhere\n"), None);
        fs::create_dir_all(root.join("memory")).unwrap();
        write("memory/memory.limit_in_bytes", "400");
        write("memory/memory.usage_in_bytes", "100");
        assert_eq!(free_in_groups(&root, "3:cpu:/a\n4:memory:/b\n"), Some(300));
        fs::remove_dir_all(root).unwrap();
    }
}
