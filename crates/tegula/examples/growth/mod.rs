//! Functions and models shared by the examples that measure growth.
#![allow(dead_code, clippy::unwrap_used)]

/// Slope of the least-squares line.
pub fn slope(points: &[(f64, f64)]) -> f64 {
    let n = points.len() as f64;
    let (x, y) = (points.iter().map(|p| p.0).sum::<f64>() / n, points.iter().map(|p| p.1).sum::<f64>() / n);
    let sum = |f: &dyn Fn(&(f64, f64)) -> f64| points.iter().map(f).sum::<f64>();
    sum(&|p| (p.0 - x) * (p.1 - y)) / sum(&|p| (p.0 - x).powi(2))
}

/// Processor time of all threads, user and system (s).
pub fn cpu_seconds() -> f64 {
    cpu_parts().iter().sum()
}

/// Processor time of all threads in the program and in the system (s): `/proc/self/stat`, in hundredths of a second.
pub fn cpu_parts() -> [f64; 2] {
    let text = std::fs::read_to_string("/proc/self/stat").unwrap();
    let after_name = text.rsplit(')').next().unwrap();
    let mut seconds = after_name.split_whitespace().skip(11).map(|t| t.parse::<f64>().unwrap() / 100.0);
    std::array::from_fn(|_| seconds.next().unwrap())
}

/// Largest memory of the process (bytes).
pub fn peak_memory() -> f64 {
    let text = std::fs::read_to_string("/proc/self/status").unwrap();
    let line = text.lines().find(|l| l.starts_with("VmHWM")).unwrap();
    1024.0 * line.split_whitespace().nth(1).unwrap().parse::<f64>().unwrap()
}

/// Numbers that a process of its own prints, one for each mesh; it is started with `--child` and the arguments.
pub fn child<const N: usize>(arguments: &[&str], threads: Option<u32>) -> [f64; N] {
    let mut command = std::process::Command::new(std::env::current_exe().unwrap());
    command.arg("--child").args(arguments);
    if let Some(threads) = threads {
        command.env("RAYON_NUM_THREADS", threads.to_string());
    }
    let output = command.output().unwrap();
    let text = String::from_utf8_lossy(&output.stdout);
    let found: Vec<f64> = text.split_whitespace().filter_map(|word| word.parse().ok()).collect();
    found.try_into().unwrap_or_else(|_| {
        refuse(&format!("{}: {}", arguments.join(" "), String::from_utf8_lossy(&output.stderr)))
    })
}

/// Ends the program with a message.
pub fn refuse(message: &str) -> ! {
    eprintln!("{message}");
    std::process::exit(1);
}
