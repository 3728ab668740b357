//! Factor of a load over an analysis step.

use super::TimeFunction;

/// Independent variable of the loads of an analysis step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum LoadParameter {
    /// Load factor λ of statics: loads without amplitude grow from λ = 0 to 1.
    #[default]
    LoadFactor,
    /// Load factor λ of an equilibrium path, which may leave the range from 0 to 1: loads are affine functions of it.
    PathFactor,
    /// Time: loads without amplitude are constant.
    Time,
}

/// Factor of a load over an analysis step: it follows an amplitude, or grows with the load factor, from where the step
/// before has left it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LoadFactor {
    /// Index of the amplitude; `None`: grows with the load factor in statics, constant in transients.
    pub amplitude: Option<usize>,
    /// Factor at the start of the step; 0 for loads that the step before did not have.
    pub start: f64,
    /// Whether the step does not have this load any more: its factor falls to 0 over a static step,
    /// and is 0 in a transient one.
    pub released: bool,
    /// Whether the load stays at `start` throughout the step.
    pub held: bool,
}

impl LoadFactor {
    /// Factor of a load that begins in this step.
    pub fn new(amplitude: Option<usize>) -> Self {
        Self { amplitude, start: 0.0, released: false, held: false }
    }

    /// Factor at a time or load factor.
    ///
    /// Below load factor 0 a static step begins at −1, where amplitudes do not continue the step before: there the factor
    /// is the start, and at 0 the amplitude's `f(0)`.
    pub fn value(&self, amplitudes: &[TimeFunction], parameter: LoadParameter, at: f64) -> f64 {
        if self.held {
            return self.start;
        }
        match (self.amplitude, parameter) {
            (_, LoadParameter::LoadFactor) if self.released => self.start * (1.0 - f64::clamp(at, 0.0, 1.0)),
            (_, LoadParameter::PathFactor) if self.released => self.start * (1.0 - at),
            (_, LoadParameter::Time) if self.released => 0.0,
            (Some(i), LoadParameter::LoadFactor) if at < 0.0 => {
                self.start + (1.0 + at) * (amplitudes[i].value(0.0) - self.start)
            }
            (Some(i), _) => amplitudes[i].value(at),
            (None, LoadParameter::LoadFactor) => self.start + f64::max(at, 0.0) * (1.0 - self.start),
            (None, LoadParameter::PathFactor) => self.start + at * (1.0 - self.start),
            (None, LoadParameter::Time) => 1.0,
        }
    }

    /// Whether the amplitude, where there is one, begins at another factor than the load has at the start of the step.
    pub fn jumps(&self, amplitudes: &[TimeFunction]) -> bool {
        let follows = |i: usize| amplitudes.get(i).is_some_and(|a| a.value(0.0) != self.start);
        !self.released && !self.held && self.amplitude.is_some_and(follows)
    }

    /// Key by which loads with the same factor can be grouped.
    pub fn key(&self) -> (Option<usize>, u64, [bool; 2]) {
        (self.amplitude, self.start.to_bits(), [self.released, self.held])
    }

    /// Index of the amplitude that the factor follows in this step.
    pub fn used_amplitude(&self) -> Option<usize> {
        self.amplitude.filter(|_| !self.released && !self.held)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn factors_continue_where_the_step_before_has_left_them() {
        let amplitudes = [TimeFunction::Constant(0.4)];
        let at = |f: &LoadFactor, x: f64| f.value(&amplitudes, LoadParameter::LoadFactor, x);
        let new = LoadFactor::new(None);
        assert_eq!([at(&new, -1.0), at(&new, 0.0), at(&new, 0.3), at(&new, 1.0)], [0.0, 0.0, 0.3, 1.0]);
        let kept = LoadFactor { start: 1.0, ..new };
        assert_eq!([at(&kept, 0.0), at(&kept, 0.3), at(&kept, 1.0)], [1.0; 3]);
        let released = LoadFactor { start: 0.8, released: true, ..new };
        assert_eq!([at(&released, -0.5), at(&released, 0.0), at(&released, 1.0)], [0.8, 0.8, 0.0]);
        let driven = LoadFactor { amplitude: Some(0), start: 0.2, ..new };
        assert_eq!([at(&driven, -1.0), at(&driven, 0.0), at(&driven, 1.0)], [0.2, 0.4, 0.4]);
        assert!((at(&driven, -0.5) - 0.3).abs() < 1e-15);
        assert!(driven.jumps(&amplitudes) && !kept.jumps(&amplitudes) && !released.jumps(&amplitudes));
        assert_eq!(kept.value(&amplitudes, LoadParameter::Time, 0.0), 1.0);
        let held = LoadFactor { held: true, ..driven };
        assert_eq!([at(&held, -1.0), at(&held, 0.5), at(&held, 1.0)], [0.2; 3]);
        assert!(!held.jumps(&amplitudes));
    }
}
