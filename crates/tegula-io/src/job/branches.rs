//! Paths that cross at the bifurcations of a path, each with results in a folder of its own, and all in one picture.

use tegula::Model;
use tegula::analysis::path::CriticalKind;
use tegula::model::{Analysis, PathAnalysis};

use super::run::run_one;
use super::{BranchResult, JobError, JobObserver, JobOptions, Prepared, Status, Summary, pictures};
use crate::deck::Deck;

/// Whether some branches of a complete path are not complete.
pub(super) fn are_left(analysis: &Analysis, path: &Summary) -> bool {
    let wanted = |options: &PathAnalysis| {
        options.branches.is_some_and(|_| path.branches.len() < number(options, path))
    };
    matches!(analysis, Analysis::Path(options) if wanted(options))
        || path
            .branches
            .iter()
            .any(|branch| !matches!(branch.status, Some(Status::Complete | Status::Failed)))
}

/// Number of branches of a path, on both sides of its bifurcations.
fn number(options: &PathAnalysis, path: &Summary) -> usize {
    let bifurcations =
        path.critical_points.iter().flatten().filter(|point| point.kind == CriticalKind::Bifurcation);
    let found = bifurcations.count();
    2 * options.branches.map_or(0, |branches| branches.among(found))
}

/// Follows the paths that cross at the bifurcations of a complete path, on both sides. One that cannot be followed to its end is a warning.
pub(super) fn run(
    (deck, options): (&Deck, &PathAnalysis),
    prepared: &Prepared,
    job: &JobOptions,
    (mut primary, watch): (Summary, &mut dyn JobObserver),
) -> Result<Summary, JobError> {
    let all = number(options, &primary);
    if all == 0 {
        let message = "the path has passed no bifurcation: there are no branches to follow (`branches`)";
        watch.on_warning(message);
        primary.add_warning(message);
        primary.write(&job.folder)?;
        return Ok(primary);
    }
    let known = std::mem::take(&mut primary.branches);
    let sides = (1..=all as i32 / 2).flat_map(|number| [number, -number]);
    primary.branches = sides
        .map(|bifurcation| BranchResult {
            bifurcation,
            folder: folder(bifurcation),
            status: None,
            load_factor: None,
        })
        .collect();
    if known.len() == all {
        primary.branches = known;
    }
    for i in 0..all {
        let BranchResult { bifurcation, folder, status, .. } = primary.branches[i].clone();
        if matches!(status, Some(Status::Complete | Status::Failed)) {
            continue;
        }
        primary.branches[i].status = Some(Status::Running);
        primary.write(&job.folder)?;
        let options =
            PathAnalysis { switch_at: vec![bifurcation], branches: None, end_at: None, ..options.clone() };
        let title = format!(
            "branch at bifurcation {}{}",
            bifurcation.abs(),
            if bifurcation < 0 { ", other side" } else { "" }
        );
        let title =
            if deck.model.title.is_empty() { title } else { format!("{}: {title}", deck.model.title) };
        let model = Model { title, analysis: Analysis::Path(options), ..deck.model.clone() };
        let branch = deck.leading_to(model);
        let place = job.folder.join(&folder);
        let resume = job.resume && place.join("checkpoint.bin").exists() && Summary::read(&place).is_ok();
        let own = JobOptions { folder: place.clone(), resume, force: true };
        let outcome = run_one(&branch, (prepared, &[]), &own, watch);
        let reached = Summary::read(&place).ok();
        primary.branches[i].status = reached.as_ref().map(|summary| summary.status);
        primary.branches[i].load_factor = reached.as_ref().map(|summary| summary.time);
        for message in reached.iter().flat_map(|summary| &summary.warnings) {
            primary.add_warning(message);
        }
        primary.write(&job.folder)?;
        match outcome {
            Ok(_) => {}
            Err(JobError::Analysis { error, .. }) => {
                let message = format!("the branch in {folder} could not be followed to its end: {error}");
                watch.on_warning(&message);
                primary.add_warning(&message);
                primary.write(&job.folder)?;
            }
            Err(JobError::Interrupted { resumable, .. }) => {
                return Err(JobError::Interrupted { folder: job.folder.clone(), resumable });
            }
            Err(error) => return Err(error),
        }
    }
    let drawn = || pictures::with_branches((&deck.model, prepared), (&primary, &job.folder));
    if deck.model.output.pictures
        && let Err(problem) = drawn()
    {
        watch.on_event(&format!("a picture is missing: {problem}"));
    }
    Ok(primary)
}

fn folder(bifurcation: i32) -> String {
    let side = if bifurcation < 0 { "-other-side" } else { "" };
    format!("branch-{}{side}", bifurcation.abs())
}

/// Parameter of the primary path at the bifurcation at which a branch begins.
pub(super) fn start_of(primary: &Summary, bifurcation: i32) -> f64 {
    let points = primary.critical_points.iter().flatten();
    let mut bifurcations = points.filter(|point| point.kind == CriticalKind::Bifurcation);
    let number = bifurcation.unsigned_abs() as usize;
    bifurcations.nth(number.saturating_sub(1)).map_or(f64::NAN, |point| point.position)
}
