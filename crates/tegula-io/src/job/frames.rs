//! Instants at which field files are written.

use tegula::analysis::State;
use tegula::model::Output;

/// Default of the largest number of field files of a run, in addition to the first.
pub(super) const USUAL_FRAMES: f64 = 200.0;
/// Field files after which the size of all of them is foretold.
const ENOUGH_TO_TELL: usize = 10;
/// Size of all field files beyond which that is worth a warning (bytes).
const MANY_BYTES: f64 = 2.0 * 1024.0 * 1024.0 * 1024.0;

/// The step that has just ended.
#[derive(Debug, Clone, Copy)]
pub(super) struct Instant {
    /// Number of the step; 0 at the start.
    pub step: u64,
    /// Time (load factor).
    pub time: f64,
    /// Time (load factor) at which the analysis ends.
    pub end: f64,
    /// Whether the state is on a path, whose load factor may fall.
    pub on_path: bool,
}

/// Place of a state in the course of its analysis: the time (load factor), or the parameter of a path.
pub(super) fn place(state: &State) -> f64 {
    state.path.as_ref().map_or(state.time, |path| path.position)
}

/// Whether a field file is due at an instant behind the last one, written at the time `last`. The first and the last instant
/// of a run always have one.
pub(super) fn due(output: &Output, now: Instant, last: f64) -> bool {
    if now.on_path {
        // The length of a path is not known beforehand.
        let usual = if now.step as f64 > USUAL_FRAMES { 10 } else { 1 };
        return now.step.is_multiple_of(u64::from(output.every.unwrap_or(usual).max(1)));
    }
    if now.time >= now.end {
        return true;
    }
    let interval = match (output.interval, output.every) {
        (_, Some(every)) => return now.step.is_multiple_of(u64::from(every.max(1))),
        (Some(0.0), None) => return true,
        (Some(interval), None) => interval,
        (None, None) => now.end / USUAL_FRAMES,
    };
    let number = |t: f64| (t / interval * (1.0 + 1e-9)).floor();
    number(now.time) > number(last)
}

/// A warning if all field files of a run will take much room: `frames` files of `bytes` each have been written.
pub(super) fn too_many(frames: usize, bytes: u64, now: Instant) -> Option<String> {
    if frames < ENOUGH_TO_TELL || now.time <= 0.0 || now.on_path {
        return None;
    }
    let files = (frames as f64 * now.end / now.time).max(frames as f64);
    let all = files * bytes as f64;
    (all > MANY_BYTES).then(|| {
        format!(
            "the field files will take about {:.0} GiB ({files:.0} files of {:.1} MiB): write fewer with a larger \
             `output.interval` or `output.every`, or fewer `output.fields`",
            all / f64::from(1 << 30),
            bytes as f64 / f64::from(1 << 20)
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Times of the field files of a run of `steps` equal steps to 2.
    fn times(output: &Output, steps: u64) -> Vec<f64> {
        let (mut times, mut last) = (vec![0.0], 0.0);
        for step in 1..=steps {
            let now = Instant { step, time: 2.0 * step as f64 / steps as f64, end: 2.0, on_path: false };
            if due(output, now, last) {
                last = now.time;
                times.push(last);
            }
        }
        times
    }

    #[test]
    fn long_runs_write_two_hundred_files_and_short_ones_all() {
        let usual = Output::default();
        assert_eq!(times(&usual, 7).len(), 8);
        assert_eq!(times(&usual, 200).len(), 201);
        for steps in [201, 777, 20_000] {
            let times = times(&usual, steps);
            assert!((190..=202).contains(&times.len()), "{steps}: {}", times.len());
            assert_eq!(times.last(), Some(&2.0));
            assert!(times.windows(2).all(|w| w[1] - w[0] < 2.0 * 2.0 / 200.0));
        }
    }

    #[test]
    fn keys_choose_other_instants() {
        let every = |n| Output { every: Some(n), ..Output::default() };
        let interval = |t| Output { interval: Some(t), ..Output::default() };
        assert_eq!(times(&every(1), 1000).len(), 1001);
        assert_eq!(times(&every(300), 1000), [0.0, 0.6, 1.2, 1.8, 2.0]);
        assert_eq!(times(&interval(0.0), 1000).len(), 1001);
        assert_eq!(times(&interval(0.5), 1000), [0.0, 0.5, 1.0, 1.5, 2.0]);
    }

    #[test]
    fn much_room_is_foretold() {
        let now = Instant { step: 10, time: 0.001, end: 2.0, on_path: false };
        let warning = too_many(10, 1 << 20, now).unwrap();
        assert!(warning.contains("20 GiB (20000 files of 1.0 MiB)"), "{warning}");
        assert_eq!(too_many(9, 1 << 20, now), None);
        assert_eq!(too_many(10, 1 << 10, now), None);
    }
}
