//! Signals that interrupt a run: Ctrl-C, termination, and the end of the terminal.
//!
//! The first signal stops the run after its last finished step, the second one ends the program at once.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};

use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;

static INTERRUPTED: OnceLock<Arc<AtomicBool>> = OnceLock::new();
/// Exit code of a program that is ended at once.
const AT_ONCE: i32 = 130;

/// Begins to listen. Where that is not possible a signal ends the program as usual.
pub fn listen() {
    let stop = INTERRUPTED.get_or_init(Arc::default);
    for signal in signals() {
        // In this order: the first signal finds the flag unset and sets it.
        let _ = flag::register_conditional_shutdown(signal, AT_ONCE, stop.clone());
        let _ = flag::register(signal, stop.clone());
    }
}

/// Asks to stop, as a signal does.
pub fn request() {
    if let Some(stop) = INTERRUPTED.get() {
        stop.store(true, Ordering::Relaxed);
    }
}

/// Whether the user has asked to stop.
pub fn requested() -> bool {
    INTERRUPTED.get().is_some_and(|stop| stop.load(Ordering::Relaxed))
}

fn signals() -> Vec<i32> {
    #[cfg_attr(not(target_os = "linux"), allow(unused_mut))]
    let mut signals = vec![SIGINT, SIGTERM];
    #[cfg(target_os = "linux")]
    if !hang_up_is_ignored() {
        signals.push(signal_hook::consts::SIGHUP);
    }
    signals
}

/// True under `nohup`, where a run outlives its terminal.
#[cfg(target_os = "linux")]
fn hang_up_is_ignored() -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    // Signal 1 is the lowest bit.
    mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).is_some_and(|mask| mask & 1 == 1)
}
