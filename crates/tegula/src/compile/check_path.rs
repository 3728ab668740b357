//! Checks of the keys of a path.

use crate::checker::Checker;
use crate::model::{Branches, LinearSolver, Model, PathAnalysis, StaticAnalysis};

/// Mistakes in the keys of a static analysis that goes on along a path.
pub(super) fn continued(options: &StaticAnalysis, c: &mut Checker) {
    let excluded = [
        (options.linear, "linear", "without the terms of large displacements there are no limit points"),
        (
            options.linear_solver == LinearSolver::Iterative,
            "linear_solver",
            "the iterative linear solver finds stable equilibria only",
        ),
        (
            options.inertia_relief,
            "inertia_relief",
            "inertia relief chooses its supports anew in each load step",
        ),
    ];
    for (_, key, reason) in
        excluded.into_iter().filter(|(given, ..)| *given && options.continuation.is_some())
    {
        c.add(
            "analysis.continue",
            format!("a static analysis with `{key}` does not go on along a path: {reason}"),
            format!("leave `continue` or `{key}` out"),
        );
    }
}

/// Mistakes in the keys of a path.
pub(super) fn path(model: &Model, path: &PathAnalysis, c: &mut Checker) {
    if model.output.interval.is_some_and(|interval| interval > 0.0) {
        c.add(
            "output.interval",
            "the points of a path have no times, and its load factors may fall: there are no intervals between field files",
            "give `every`, a number of points, or list load factors in `output.at`",
        );
    }
    if !path.end_load.is_finite() || path.end_load == 0.0 {
        c.add(
            "analysis.end_load",
            format!("the path cannot end at load factor {}, where it begins", path.end_load),
            "give the load factor at which it ends, a negative one for loads that fall from the start",
        );
    }
    c.positive("analysis.tolerance", "the tolerance", path.tolerance);
    for (key, value) in [("max_steps", path.max_steps), ("points", path.points)] {
        if value == 0 {
            c.add(format!("analysis.{key}"), format!("`{key}` is 0"), "give at least 1");
        }
    }
    if path.switch_at.contains(&0) {
        c.add(
            "analysis.switch_at",
            "there is no bifurcation number 0",
            "count bifurcations from 1 along the path; a negative number means the other side of the crossing path",
        );
    }
    if path.branches == Some(Branches::First(0)) {
        c.add(
            "analysis.branches",
            "no branch is followed",
            "give the number of bifurcations, or leave `branches` out",
        );
    }
    if path.branches.is_some() && !path.switch_at.is_empty() {
        c.add(
            "analysis.branches",
            "`branches` follows the crossing paths beside the primary one, and with `switch_at` the path itself is a crossing one",
            "leave one of both keys out",
        );
    }
    let mut numbers: Vec<u32> = path.switch_at.iter().map(|number| number.unsigned_abs()).collect();
    numbers.sort_unstable();
    if let Some(twice) = numbers.windows(2).find(|pair| pair[0] == pair[1]) {
        c.add(
            "analysis.switch_at",
            format!("bifurcation {} is named twice: the path can go over to one side of it only", twice[0]),
            "name each bifurcation once, with the sign of the side",
        );
    }
    if !(5..=60).contains(&path.order) {
        c.add(
            "analysis.order",
            format!("power series of order {} are of no use", path.order),
            "give 5 to 60, or leave it out for 20",
        );
    }
}
