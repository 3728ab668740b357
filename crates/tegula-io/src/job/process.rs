//! Processor time and memory of the process so far, as the operating system counts them.

/// Processor time of all threads, user and system (s); `None` where it is not known.
pub fn cpu_seconds() -> Option<f64> {
    // The finer count lacks threads that have ended; the coarser one never counts too much.
    [scheduled_seconds(), tick_seconds()].into_iter().flatten().reduce(f64::max)
}

/// Processor time of the threads that run, in nanoseconds' steps; `None` where the scheduler keeps no statistics.
fn scheduled_seconds() -> Option<f64> {
    let mut sum = 0.0;
    for task in std::fs::read_dir("/proc/self/task").ok()?.flatten() {
        // A thread may end meanwhile.
        let Ok(text) = std::fs::read_to_string(task.path().join("schedstat")) else { continue };
        sum += text.split_whitespace().next()?.parse::<f64>().ok()?;
    }
    (sum > 0.0).then_some(1e-9 * sum)
}

/// Processor time of all threads in hundredths of a second.
fn tick_seconds() -> Option<f64> {
    // Linux counts these in USER_HZ, which is 100 on every architecture that Rust runs on.
    const TICKS: f64 = 100.0;
    let text = std::fs::read_to_string("/proc/self/stat").ok()?;
    // The name of the program, in brackets, may hold anything; the numbers stand behind it.
    let mut fields = text.rsplit_once(')')?.1.split_whitespace().skip(11);
    let mut next = || fields.next()?.parse::<f64>().ok();
    Some((next()? + next()?) / TICKS)
}

/// Largest resident memory so far (bytes); `None` where it is not known.
pub(super) fn peak_memory_bytes() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kibibytes * 1024)
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    #[test]
    fn linux_knows_both() {
        assert!(super::tick_seconds().is_some());
        let before = super::cpu_seconds().unwrap();
        let mut x = 0.0_f64;
        while super::cpu_seconds().unwrap() < before + 0.02 {
            x += 1.0;
        }
        assert!(x > 0.0 && super::peak_memory_bytes().unwrap() > 1 << 20);
    }
}
