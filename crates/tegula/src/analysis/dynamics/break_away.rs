//! Time within a step at which the friction that holds a joint reaches its limit.
//!
//! The multiplier λ of a step of length h is a mean. With the friction limit T the impulse of the excess,
//!
//! ```text
//! I(h) = h (|λ| − T) = ∫ (|λ(t)| − T(t)) dt,   I(0) = 0,
//! ```
//!
//! falls as long as the joint sticks and is least at the break-away. Its minimum is found by successive parabolic interpolation, exact in
//! the first step where λ grows linearly; the step then ends there, and the joint moves from there on.
//! R. P. Brent, *Algorithms for minimization without derivatives* (1973), Ch. 5.

/// Length over that first tried, below which the limit is exceeded from the start of the step on. In much shorter steps, errors of the
/// velocities make large forces.
const EARLIEST: f64 = 1e-2;
/// Factor of the next length while no length without excess is known.
const SHORTER: f64 = 0.25;
/// Change of the length over itself below which the minimum is found.
const CLOSE: f64 = 1e-4;
/// Most interpolations.
const MOST: u32 = 8;

/// A length of the step and the impulse I.
type Point = [f64; 2];

/// Bracket of the minimum of the impulse.
pub(super) struct BreakAway {
    /// Length first tried.
    whole: f64,
    low: Point,
    /// Least impulse so far; `None` before a length without excess.
    best: Option<Point>,
    high: Point,
    interpolations: u32,
    /// Length at which the step ends.
    end: Option<f64>,
    /// Whether the limit is exceeded from the start of the step on.
    at_start: bool,
}

impl BreakAway {
    /// Looks at a step, of the length and mean excess of the friction over its limit `step`, which the joint `leaves` or not, behind an
    /// `earlier` step. Returns the length with which the step is repeated; `None` where the step stays, or the joint moves from its
    /// start on, over the length first tried.
    pub fn look(search: &mut Option<Self>, step: [f64; 2], earlier: [f64; 2], leaves: bool) -> Option<f64> {
        let h = step[0];
        let point = [h, h * step[1]];
        let Some(search) = search else {
            let next = if leaves { SHORTER * h } else { expected(earlier, step)? };
            let (low, interpolations) = ([0.0; 2], 0);
            let (end, at_start) = (None, false);
            *search = Some(Self { whole: h, low, best: None, high: point, interpolations, end, at_start });
            return Some(next);
        };
        if search.end.is_some() || search.at_start {
            return None;
        }
        match search.best {
            None if leaves => {
                search.high = point;
                let next = SHORTER * h;
                search.at_start = next < EARLIEST * search.whole;
                return Some(if search.at_start { search.whole } else { next });
            }
            None if point[1] < search.high[1] => search.best = Some(point),
            None => {
                search.end = Some(search.high[0]);
                return search.end;
            }
            Some(best) => {
                let (lesser, other) = if point[1] < best[1] { (point, best) } else { (best, point) };
                let side = if other[0] < lesser[0] { &mut search.low } else { &mut search.high };
                (*side, search.best) = (other, Some(lesser));
            }
        }
        search.next().filter(|next| *next != h)
    }

    /// Whether a step of length `h` ends where friction reaches its limit.
    pub fn ends_at(&self, h: f64) -> bool {
        self.end == Some(h)
    }

    /// Vertex of the parabola through the three points, or the best of them where the search ends.
    fn next(&mut self) -> Option<f64> {
        let ([a, at_a], [b, at_b], [c, at_c]) = (self.low, self.best?, self.high);
        let (left, right) = ((b - a) * (at_b - at_c), (b - c) * (at_b - at_a));
        let vertex = b - 0.5 * ((b - a) * left - (b - c) * right) / (left - right);
        self.interpolations += 1;
        let goes_on =
            vertex > a && vertex < c && (vertex - b).abs() > CLOSE * b && self.interpolations < MOST;
        if goes_on {
            return Some(vertex);
        }
        self.end = Some(b);
        self.end
    }
}

/// Length at which the excess vanishes within a step, if it goes on to change as it did from the means of an earlier one.
fn expected([before, earlier]: [f64; 2], [h, excess]: [f64; 2]) -> Option<f64> {
    let slope = 2.0 * (excess - earlier) / (before + h);
    let length = 0.5 * h - excess / slope;
    (before > 0.0 && slope > 0.0 && length < h).then_some(length)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Length of the step that the search finds, and the number of trials, under an excess with this integral from the start of the
    /// step on, behind another step.
    fn found(whole: f64, earlier: [f64; 2], impulse: impl Fn(f64) -> f64) -> Option<(f64, u32)> {
        let (mut search, mut h) = (None, whole);
        for trials in 1..40 {
            let excess = impulse(h) / h;
            match BreakAway::look(&mut search, [h, excess], earlier, excess > 0.0) {
                Some(next) => h = next,
                None if excess > 0.0 => return None,
                None => {
                    assert!(search.is_none_or(|search| search.ends_at(h)));
                    return Some((h, trials));
                }
            }
        }
        panic!("no end");
    }

    #[test]
    fn a_linear_force_breaks_away_at_its_limit() {
        for limit in [0.02, 0.3, 0.51, 0.99] {
            // The excess is t − limit, also before the step.
            let (h, trials) = found(1.0, [0.5, -0.25 - limit], |h| 0.5 * h * h - limit * h).unwrap();
            assert!((h / limit - 1.0).abs() < 1e-12 && trials < 12, "{limit} {h} {trials}");
        }
    }

    #[test]
    fn a_curved_force_breaks_away_at_its_limit() {
        // The excess is sin t − sin 0.4.
        let (h, _) = found(1.2, [0.0; 2], |h| 1.0 - h.cos() - 0.4_f64.sin() * h).unwrap();
        assert!((h - 0.4).abs() < 1e-3, "{h}");
    }

    #[test]
    fn a_step_below_the_limit_stays() {
        assert_eq!(found(1.0, [1.0, -0.5], |h| -0.4 * h), Some((1.0, 1)));
    }

    #[test]
    fn an_excess_at_the_start_is_no_break_away_within_the_step() {
        assert_eq!(found(1.0, [0.0; 2], |h| 0.1 * h), None);
    }
}
