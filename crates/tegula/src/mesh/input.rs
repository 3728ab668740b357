//! Checks of the user's input to a generator: all mistakes are collected, nothing is guessed.

use crate::model::Grid;
use crate::{Issue, Vec3};

/// Most elements of a generated mesh: node numbers then fit 32 bits with room to spare.
pub(super) const MOST_ELEMENTS: u64 = 50_000_000;

/// Limit of coordinates, 10^±60: products of five, which angles and volumes of elements take, overflow at 10^±61.
const HUGE: f64 = 1e60;

/// Relative difference below which directions and lengths count as equal.
pub(super) const TINY: f64 = 1e-9;

/// Collector of the issues of a generator's input.
#[derive(Default)]
pub(super) struct Input {
    /// Issues found so far.
    pub issues: Vec<Issue>,
}

impl Input {
    /// Adds an issue.
    pub fn wrong(&mut self, key: &str, message: impl Into<String>, help: impl Into<String>) {
        self.issues.push(Issue::new(key, message, help));
    }

    /// Checks a size, which has to be positive.
    pub fn size(&mut self, key: &str, name: &str, value: f64) {
        if value > 1.0 / HUGE && value < HUGE {
            return;
        }
        let help = if value > 0.0 && value.is_finite() {
            "give a number between 1e-60 and 1e60: beyond it areas and angles cannot be computed; change the unit of length"
        } else {
            "give a positive number"
        };
        self.wrong(key, format!("{name} is {value:?}"), help);
    }

    /// Checks a position.
    pub fn point(&mut self, key: &str, name: &str, value: [f64; 3]) -> Option<Vec3> {
        if value.iter().all(|x| x.abs() < HUGE) {
            return Some(Vec3::from(value));
        }
        let help = if value.iter().all(|x| x.is_finite()) {
            "give coordinates below 1e60 in size, or change the unit of length"
        } else {
            "give three finite numbers"
        };
        self.wrong(key, format!("{name} is {value:?}"), help);
        None
    }

    /// Checks a direction and returns it as a unit vector.
    pub fn direction(&mut self, key: &str, name: &str, value: [f64; 3]) -> Option<Vec3> {
        let vector = self.point(key, name, value)?;
        // Scaled first, so that the norm of short directions does not vanish.
        let unit = (vector / vector.amax()).try_normalize(0.0);
        let unit = unit.filter(|unit| unit.iter().all(|x| x.is_finite()));
        if unit.is_none() {
            self.wrong(
                key,
                format!("{name} is {value:?}, which has no direction"),
                "give a vector that is not zero",
            );
        }
        unit
    }

    /// Checks the first and last angle (degrees): different, at most a turn apart. Returns whether they are a full
    /// turn.
    pub fn angles(&mut self, key: &str, name: &str, [first, last]: [f64; 2]) -> bool {
        let span = (last - first).abs();
        if !(first.abs() < HUGE && last.abs() < HUGE) {
            self.wrong(
                key,
                format!("{name} are {first:?} and {last:?}"),
                "give two finite numbers of degrees",
            );
        } else if span <= TINY * first.abs().max(last.abs()) {
            self.wrong(
                key,
                format!("{name} are both {first:?} degrees"),
                "give different first and last values",
            );
        } else if span > 360.0 * (1.0 + TINY) {
            self.wrong(
                key,
                format!("{name} span {span:?} degrees, so the surface would lie on itself"),
                "let them span at most 360 degrees",
            );
        } else {
            return span >= 360.0 * (1.0 - TINY);
        }
        false
    }

    /// Checks that no element spans half a turn: its nodes would not distinguish its two sides.
    pub fn element_span(&mut self, name: &str, [first, last]: [f64; 2], lines: &[f64]) {
        let widest = lines.windows(2).map(|line| line[1] - line[0]).fold(0.0, crate::norm::larger);
        let span = (last - first).abs() * widest;
        if span >= 180.0 * (1.0 - TINY) {
            self.wrong(
                "mesh.grid.elements",
                format!("an element spans {span:.1} degrees of the {name}"),
                format!("use at least {} elements along the {name}", 2 * lines.len()),
            );
        }
    }

    /// Checks the numbers of the grid itself.
    pub fn grid(&mut self, grid: &Grid) {
        let [nu, nv] = grid.elements;
        if nu == 0 || nv == 0 {
            self.wrong(
                "mesh.grid.elements",
                format!("the grid has {nu} by {nv} elements"),
                "use at least 1 along u and 1 along v",
            );
        }
        self.element_count(u64::from(nu) * u64::from(nv));
        for (ratio, along) in grid.grading.into_iter().zip(["u", "v"]) {
            if !(1e-6..=1e6).contains(&ratio) {
                self.wrong(
                    "mesh.grid.grading",
                    format!("the grading along {along} is {ratio:?}"),
                    "give the ratio of the last to the first element's length, 1e-6 to 1e6 (1: all equal)",
                );
            }
        }
        if !(0.0..=0.4).contains(&grid.distortion) {
            self.wrong(
                "mesh.grid.distortion",
                format!("the distortion is {:?}", grid.distortion),
                "give a part of the element size between 0 and 0.4",
            );
        }
    }

    /// Checks the total number of elements.
    pub fn element_count(&mut self, count: u64) {
        if count > MOST_ELEMENTS {
            self.wrong(
                "mesh.grid.elements",
                format!("the grid has {count} elements"),
                format!("use at most {MOST_ELEMENTS}"),
            );
        }
    }
}
