//! The memory of the machine, and the memory and processor time that the process has used.

use std::fs;

/// The default memory budget in bytes: three quarters of the memory of the machine, or of the control group where that
/// is less.
pub fn default_budget() -> u64 {
    total().map_or(4 << 30, |t| t / 4 * 3)
}

fn total() -> Option<u64> {
    let machine = fs::read_to_string("/proc/meminfo").ok().and_then(|text| mem_total(&text));
    let group =
        fs::read_to_string("/sys/fs/cgroup/memory.max").ok().and_then(|text| text.trim().parse().ok());
    [machine, group].into_iter().flatten().min()
}

fn mem_total(text: &str) -> Option<u64> {
    let line = text.lines().find_map(|l| l.strip_prefix("MemTotal:"))?;
    let kib: u64 = line.split_whitespace().next()?.parse().ok()?;
    kib.checked_mul(1024)
}

/// The most bytes of memory that the process has used at once; `None` where the system does not say.
pub fn process_peak() -> Option<u64> {
    let text = fs::read_to_string("/proc/self/status").ok()?;
    let line = text.lines().find_map(|l| l.strip_prefix("VmHWM:"))?;
    line.split_whitespace().next()?.parse::<u64>().ok()?.checked_mul(1024)
}

/// The processor time of the process on all threads, in seconds; `None` where the system does not say.
pub fn process_seconds() -> Option<f64> {
    processor_seconds(&fs::read_to_string("/proc/self/stat").ok()?)
}

fn processor_seconds(stat: &str) -> Option<f64> {
    // The name of the program is in parentheses and may itself contain parentheses.
    let (_, rest) = stat.rsplit_once(')')?;
    let mut fields = rest.split_whitespace().skip(11);
    let (user, system): (u64, u64) = (fields.next()?.parse().ok()?, fields.next()?.parse().ok()?);
    Some((user + system) as f64 / TICKS)
}

/// Ticks a second in the numbers of Linux, the same on every machine (`USER_HZ`).
const TICKS: f64 = 100.0;

#[cfg(test)]
mod tests {
    #[test]
    fn reads_the_processor_time_that_linux_writes() {
        let stat = "7 (a (b) c) S 1 7 7 0 -1 4194304 9 0 0 0 150 25 3 4 20 0 2 0 100 1 2";
        assert_eq!(super::processor_seconds(stat), Some(1.75));
        assert_eq!(super::processor_seconds("7 no brackets"), None);
    }

    #[test]
    fn reads_what_linux_writes() {
        assert_eq!(super::mem_total("MemTotal:       24576 kB\nMemFree: 1 kB\n"), Some(24576 * 1024));
        assert_eq!(super::mem_total("MemTotal: lots"), None);
    }
}
