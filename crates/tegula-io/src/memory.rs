//! Memory limits of the process, and refusal of models that require more.
//!
//! Linux ends a process that exceeds the limit of its control group, and refuses memory beyond the limits of the
//! process, both without a message about the model. Therefore the memory of a mesh is compared with the smallest of all
//! limits before it is built.

use std::fs;
use std::path::Path;

use tegula::Issue;
use tegula::model::{Analysis, LinearSolver, Model};

/// The smallest limit of memory, and what sets it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limit {
    /// Memory that may be taken (bytes).
    pub bytes: u64,
    /// Origin of the limit, as the subject of *… has 4 GiB*.
    pub source: &'static str,
}

const MACHINE: &str = "this machine";
const CONTROL_GROUP: &str = "the control group of this process (container or job)";
const ADDRESS_SPACE: &str = "the address space of this process (`ulimit -v`)";
const DATA: &str = "the data segment of this process (`ulimit -d`)";

/// The smallest limit that this process runs under; `None` where none is known.
pub fn limit() -> Option<Limit> {
    let root = Path::new("/");
    let limits = fs::read_to_string("/proc/self/limits").unwrap_or_default();
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let of_process = |name, used, source| {
        let bytes = soft_limit(&limits, name)?.saturating_sub(status_bytes(&status, used).unwrap_or(0));
        Some(Limit { bytes, source })
    };
    [
        machine(root),
        control_group(root),
        of_process("Max address space", "VmSize:", ADDRESS_SPACE),
        of_process("Max data size", "VmData:", DATA),
    ]
    .into_iter()
    .flatten()
    .min_by_key(|limit| limit.bytes)
}

/// Memory of the machine.
fn machine(root: &Path) -> Option<Limit> {
    let text = fs::read_to_string(root.join("proc/meminfo")).ok()?;
    Some(Limit { bytes: status_bytes(&text, "MemTotal:")?, source: MACHINE })
}

/// A number of kibibytes in a table of `/proc`, in bytes.
fn status_bytes(text: &str, name: &str) -> Option<u64> {
    let line = text.lines().find_map(|line| line.strip_prefix(name))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kibibytes.saturating_mul(1024))
}

/// A soft limit of `/proc/self/limits` (bytes); `None` where it is unlimited.
fn soft_limit(text: &str, name: &str) -> Option<u64> {
    text.lines().find_map(|line| line.strip_prefix(name))?.split_whitespace().next()?.parse().ok()
}

/// The smallest limit of the control groups around this process, of version 1 and 2.
fn control_group(root: &Path) -> Option<Limit> {
    let groups = fs::read_to_string(root.join("proc/self/cgroup")).ok()?;
    let mut smallest: Option<u64> = None;
    for line in groups.lines() {
        let mut parts = line.splitn(3, ':').skip(1);
        let (Some(controllers), Some(path)) = (parts.next(), parts.next()) else { continue };
        let (mounts, file): (&[&str], _) = if controllers.is_empty() {
            (&["sys/fs/cgroup", "sys/fs/cgroup/unified"], "memory.max")
        } else if controllers.split(',').any(|c| c == "memory") {
            (&["sys/fs/cgroup/memory"], "memory.limit_in_bytes")
        } else {
            continue;
        };
        for mount in mounts {
            // Inside a container the path may be that of the machine, of which only the end is mounted.
            let mount = root.join(mount);
            let mut group = path.trim_start_matches('/');
            loop {
                let text = fs::read_to_string(mount.join(group).join(file)).unwrap_or_default();
                // Version 1 says "unlimited" by a number that no machine has, version 2 by "max".
                if let Ok(bytes) = text.trim().parse::<u64>() {
                    smallest = Some(smallest.map_or(bytes, |s| s.min(bytes)));
                }
                if group.is_empty() {
                    break;
                }
                group = group.rsplit_once('/').map_or("", |(parent, _)| parent);
            }
        }
    }
    smallest.map(|bytes| Limit { bytes, source: CONTROL_GROUP })
}

/// Least memory of an element of a large mesh (bytes). Measured needs are in the book: *How cost grows with the mesh* and
/// *Linear solvers*.
fn least_per_element(analysis: &Analysis) -> u64 {
    match analysis {
        // Its nodes and its matrices where no other element has its shape; a million elements took 4.1 kB each.
        Analysis::Transient(t) if t.scheme.is_explicit() => 4_000,
        // Its share of pieces and of the coarse matrix: 13.7 kB, and less where directors have two unknowns.
        Analysis::Static(s) if s.linear_solver == LinearSolver::Iterative => 10_000,
        // Its share of the pattern and of the factor: 22 kB at 65 000 elements, and it grows with their number.
        _ => 20_000,
    }
}

/// Refusal of elements that do not fit into the memory, before an attempt that the system would kill without a message.
pub fn too_large(model: &Model, limit: Option<Limit>) -> Option<Issue> {
    let grid = model.mesh.grid()?;
    let [u, v] = grid.elements.map(u64::from);
    let of_steps = model.steps.iter().map(|step| least_per_element(&step.analysis)).max();
    let per_element = of_steps.unwrap_or_else(|| least_per_element(&model.analysis));
    let (needed, limit) = (u.saturating_mul(v).saturating_mul(per_element), limit?);
    let gibibytes = |bytes: u64| {
        let size = bytes as f64 / f64::from(1 << 30);
        if size < 10.0 { format!("{size:.1}") } else { format!("{size:.0}") }
    };
    (needed > limit.bytes).then(|| {
        Issue::new(
            "mesh.grid.elements",
            format!(
                "{u} x {v} elements need more than {} GiB of memory, {} has {} GiB",
                gibibytes(needed),
                limit.source,
                gibibytes(limit.bytes)
            ),
            match &model.analysis {
                Analysis::Static(s) if s.linear_solver == LinearSolver::Direct => {
                    "use fewer elements, or `linear_solver = \"iterative\"`, which takes less memory"
                }
                _ => "use fewer elements",
            },
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use tegula::model::{
        ExplicitScheme, Grid, Isotropic, MeshSource, PlateMesh, Scheme, StaticAnalysis, TransientAnalysis,
    };

    #[test]
    fn meshes_that_do_not_fit_are_refused() {
        let plate = |n, analysis| {
            let mesh = MeshSource::Plate(PlateMesh {
                origin: [0.0; 3],
                u_axis: [1.0, 0.0, 0.0],
                v_axis: [0.0, 1.0, 0.0],
                size: [1.0, 1.0],
                grid: Grid::uniform(n, n),
            });
            Model::new(mesh, analysis, Isotropic::new(2.1e11, 0.3, 7850.0), 0.01)
        };
        let machine = |gibibytes: u64| Some(Limit { bytes: gibibytes << 30, source: MACHINE });
        let statics =
            |linear_solver| Analysis::Static(StaticAnalysis { linear_solver, ..Default::default() });
        let transient =
            |scheme| Analysis::Transient(TransientAnalysis { scheme, ..TransientAnalysis::new(1.0) });
        let direct = || statics(LinearSolver::Direct);
        let iterative = || statics(LinearSolver::Iterative);
        let explicit = || transient(Scheme::Explicit(ExplicitScheme::default()));
        let fits = |n, analysis, gibibytes| too_large(&plate(n, analysis), machine(gibibytes)).is_none();
        // Measured: a million elements take 14 GB with the iterative solver, and 4.1 GB with explicit steps.
        for (analysis, few, enough) in [
            (direct(), 18, 19),
            (transient(Scheme::default()), 18, 19),
            (iterative(), 9, 13),
            (explicit(), 3, 4),
        ] {
            assert!(!fits(1000, analysis.clone(), few) && fits(1000, analysis, enough));
        }
        let message = |analysis| too_large(&plate(4000, analysis), machine(24)).unwrap();
        let issue = message(direct());
        assert_eq!(
            issue.message,
            "4000 x 4000 elements need more than 298 GiB of memory, this machine has 24 GiB"
        );
        assert!(issue.help.contains("iterative"), "{}", issue.help);
        assert!(message(explicit()).message.contains("more than 60 GiB"));
        assert_eq!(message(iterative()).help, "use fewer elements");
        assert!(too_large(&plate(4000, direct()), None).is_none());
    }

    #[test]
    fn the_smallest_limit_of_nested_control_groups_counts() {
        let folder = tempfile::tempdir().unwrap();
        let root = folder.path();
        let write = |path: &str, text: &str| {
            let path = root.join(path);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, text).unwrap();
        };
        assert_eq!(control_group(root), None);
        write("proc/self/cgroup", "4:cpu,cpuacct:/x\n0::/user/job/step\n");
        write("sys/fs/cgroup/user/job/step/memory.max", "max\n");
        assert_eq!(control_group(root), None);
        write("sys/fs/cgroup/user/job/memory.max", "1048576\n");
        write("sys/fs/cgroup/user/memory.max", "2097152\n");
        assert_eq!(control_group(root), Some(Limit { bytes: 1 << 20, source: CONTROL_GROUP }));
        // Version 1; of the path inside a container nothing is mounted but its root.
        write("proc/self/cgroup", "4:memory,hugetlb:/docker/0123\n0::/\n");
        write("sys/fs/cgroup/memory/memory.limit_in_bytes", "4096\n");
        assert_eq!(control_group(root).map(|l| l.bytes), Some(4096));
    }

    #[test]
    fn limits_of_the_process_are_read() {
        let text = "Limit  Soft Limit  Hard Limit  Units\nMax data size   unlimited  unlimited  bytes\n\
                    Max address space         2048000   unlimited            bytes\n";
        assert_eq!(soft_limit(text, "Max address space"), Some(2_048_000));
        assert_eq!(soft_limit(text, "Max data size"), None);
        assert_eq!(status_bytes("VmPeak:\t 7 kB\nVmSize:\t  12 kB\n", "VmSize:"), Some(12 * 1024));
    }
}
