//! Checks of a model: all mistakes are reported at once, in sentences for the user.

use std::collections::BTreeMap;

pub use super::check_material::issues as material;
use super::distributions::wrong_formula;
use super::{amplitudes, check_material, steps};
use crate::checker::Checker;
use crate::mesh::Mesh;
use crate::mesh::middle_surface::MiddleSurface;
use crate::model::loads::LoadedPart;
use crate::model::{
    AddedMass, Analysis, InitialVelocity, Joint, LinearSolver, Load, MeshSet, Model, StopCondition,
};
use crate::system::System;
use crate::{Issue, Vec3};

/// Longest name of a point (characters). It becomes part of file names, which most systems limit to 255 bytes.
const LONGEST_NAME: usize = 60;

/// Largest number of time steps that an analysis can be meant to take.
const MOST_STEPS: f64 = 1e12;

/// Longest name of a unit (characters): it is appended to the labels of pictures.
const LONGEST_UNIT: usize = 20;

/// Values and names that are wrong whatever the mesh.
pub fn keys(model: &Model) -> Vec<Issue> {
    let mut found = steps::issues(model);
    found.extend(super::cuts::keys(model));
    for step in steps::steps(model) {
        let mut of_step = keys_of(&step.model, &model.joints, step.starts_from.is_some());
        of_step.extend(super::step_joints::laws(&step));
        let of_step = step.located(of_step);
        let new: Vec<Issue> = of_step.into_iter().filter(|issue| !found.contains(issue)).collect();
        found.extend(new);
    }
    found
}

/// Mistakes of a model with one analysis, which may start where another one has ended, and in which some of `joints` may not act.
fn keys_of(model: &Model, joints: &[Joint], continues: bool) -> Vec<Issue> {
    let mut c = Checker::default();
    for (name, material) in &model.materials {
        c.issues.extend(check_material::issues(material, &format!("materials.{name}")));
    }
    let fold_angle = model.mesh.fold_angle();
    // Directors that are parallel within a degree have no angle to constrain.
    if !(1.0..=180.0).contains(&fold_angle) {
        c.add(
            "mesh.fold_angle",
            format!("the fold angle is {fold_angle:?} degrees"),
            "give an angle between 1 and 180 degrees, or leave it out for 20",
        );
    }
    super::bodies::keys(model, &mut c);
    super::beams::keys(model, &mut c);
    super::sensors::keys(model, joints, &mut c);
    if model.sections.is_empty() && model.bodies.is_empty() && model.beams.is_empty() {
        c.add(
            "sections",
            "no section: no part of the mesh has elements",
            "add a [[sections]] entry with material and thickness",
        );
    }
    super::check_sections::sections(model, &mut c);
    c.not_negative("damping.mass", "the damping factor", model.damping.mass);
    c.not_negative("damping.stiffness", "the damping factor", model.damping.stiffness);
    for (i, condition) in model.conditions.iter().enumerate() {
        let key = format!("conditions[{i}]");
        condition.check(&key, &mut c);
        if let Some(motion) = condition.motion() {
            c.amplitude(model, &key, motion.amplitude);
        }
    }
    for (i, load) in model.loads.iter().enumerate() {
        let key = format!("loads[{i}]");
        c.finite(&format!("{key}.value"), "the load", load.values());
        if let Some((problem, help)) = load.distribution().and_then(wrong_formula) {
            c.add(format!("{key}.distribution"), problem, help);
        }
        c.amplitude(model, &key, load.amplitude());
    }
    for (i, m) in model.masses.iter().enumerate() {
        let (AddedMass::Point(m) | AddedMass::Edge(m) | AddedMass::Area(m)) = m;
        c.not_negative(&format!("masses[{i}].value"), "the mass", m.value);
    }
    super::imperfections::keys(model, &mut c);
    super::foundations::keys(model, &mut c);
    super::ties::keys(model, &mut c);
    for (i, v) in model.initial_velocities.iter().enumerate() {
        let key = format!("initial_velocities[{i}]");
        c.finite(&format!("{key}.velocity"), "the velocity", &v.velocity);
        c.finite(&format!("{key}.angular_velocity"), "the angular velocity", &v.angular_velocity);
    }
    c.analysis(model, continues);
    c.issues.extend(amplitudes::amplitudes(model));
    names_of_points(model, &mut c);
    super::stills::keys(model, &mut c);
    for (key, name) in model.output.units.named() {
        if name.is_empty() || name.chars().count() > LONGEST_UNIT || name.chars().any(char::is_control) {
            c.add(
                format!("output.units.{key}"),
                format!("{name:?} cannot name a unit"),
                format!("give a short name such as \"mm\", of at most {LONGEST_UNIT} characters"),
            );
        }
    }
    if let Some(interval) = model.output.interval {
        c.not_negative("output.interval", "the interval", interval);
        if model.output.every.is_some() {
            c.add("output.every", "`interval` and `every` are both given", "keep one of them");
        }
    }
    c.wanted_times(model);
    c.issues
}

/// Names of points, and whether each has a place.
fn names_of_points(model: &Model, c: &mut Checker) {
    for (i, p) in model.output.points.iter().enumerate() {
        let key = format!("output.points[{i}]");
        if p.on.is_some() == p.at.is_some() {
            c.add(
                key.as_str(),
                format!(
                    "point \"{}\" needs either `on` or `at`",
                    p.name.chars().take(LONGEST_NAME).collect::<String>()
                ),
                "give the name of a set with one node, or a position",
            );
        }
        let letters = p.name.chars().count();
        if letters > LONGEST_NAME {
            c.add(
                format!("{key}.name"),
                format!("the name of the point has {letters} characters; at most {LONGEST_NAME} are taken"),
                "give a shorter name: it becomes part of file names",
            );
        } else if p.name.is_empty() || !p.name.chars().all(|ch| ch.is_alphanumeric() || "_-. ".contains(ch)) {
            c.add(
                format!("{key}.name"),
                format!("\"{}\" cannot name a point", p.name),
                "use letters, digits, blanks, '_', '-' and '.'",
            );
        }
        if model.output.points[..i].iter().any(|q| q.name == p.name) {
            c.add(
                format!("{key}.name"),
                format!("two points are named \"{}\"", p.name),
                "give each point its own name",
            );
        }
    }
}

/// Names of sets that the mesh does not have, loads and sections on nothing.
pub fn sets(model: &Model, mesh: &Mesh) -> Vec<Issue> {
    let model = &super::beams::with_nodes(model);
    let mut found: Vec<Issue> = Vec::new();
    for step in steps::steps(model) {
        let of_step = step.located(sets_of(&step.model, mesh));
        let new: Vec<Issue> = of_step.into_iter().filter(|issue| !found.contains(issue)).collect();
        found.extend(new);
    }
    found
}

fn sets_of(model: &Model, mesh: &Mesh) -> Vec<Issue> {
    let mut c = Checker::default();
    let undefined = |set: &&MeshSet| mesh.nodes_on(set.name()).is_none();
    if let Some(set) = model.sets.iter().find(undefined) {
        c.add(
            "sets",
            format!("the mesh lacks the set \"{}\" of the model", set.name()),
            "add the sets of the model to the mesh with `compile::define_sets` before it is used",
        );
    }
    sections_of(model, mesh, &mut c);
    super::check_sections::edges(model, mesh, &mut c);
    for (i, condition) in model.conditions.iter().enumerate() {
        let key = format!("conditions[{i}].on");
        let nodes = c.set(mesh, key.clone(), condition.on(), "nodes", Mesh::nodes_on);
        if !nodes.is_empty() {
            let positions: Vec<Vec3> = nodes.iter().map(|&n| mesh.positions[n as usize]).collect();
            condition.check_nodes(&key, &positions, mesh.extent(), &mut c);
        }
    }
    for (i, body) in model.bodies.iter().enumerate() {
        for (k, set) in body.attached.iter().enumerate() {
            c.set(mesh, format!("bodies[{i}].attached[{k}]"), set, "nodes", Mesh::nodes_on);
        }
        for (k, set) in body.distributed.iter().enumerate() {
            c.set(mesh, format!("bodies[{i}].distributed[{k}]"), set, "nodes", Mesh::nodes_on);
        }
    }
    super::beams::sets(model, mesh, &mut c);
    loads_of(model, mesh, &mut c);
    for (i, p) in model.prescribed_strains.iter().enumerate() {
        drop(c.set(mesh, format!("prescribed_strains[{i}].on"), p.on(), "quads", Mesh::quads_on));
        if let Some(distribution) = p.distribution() {
            let key = format!("prescribed_strains[{i}].distribution");
            c.distribution(mesh, &key, (distribution, p.on(), LoadedPart::Quads));
        }
    }
    for (i, mass) in model.masses.iter().enumerate() {
        let key = format!("masses[{i}].on");
        match mass {
            AddedMass::Point(m) => drop(c.set(mesh, key, &m.on, "nodes", Mesh::nodes_on)),
            AddedMass::Edge(m) => drop(c.set(mesh, key, &m.on, "edges", Mesh::edges_on)),
            AddedMass::Area(m) => drop(c.set(mesh, key, &m.on, "quads", Mesh::quads_on)),
        }
    }
    super::foundations::sets(model, mesh, &mut c);
    super::ties::sets(model, mesh, &mut c);
    for (i, v) in model.initial_velocities.iter().enumerate().filter(|(_, v)| !of_bodies(model, mesh, v)) {
        drop(c.set(mesh, format!("initial_velocities[{i}].on"), &v.on, "nodes", Mesh::nodes_on));
    }
    points_of(model, mesh, &mut c);
    super::cuts::sets(model, mesh, &mut c);
    c.issues.extend(orphan_nodes(model, mesh));
    c.issues
}

/// Elements with two sections or without one.
fn sections_of(model: &Model, mesh: &Mesh, c: &mut Checker) {
    let mut section_of: BTreeMap<u32, usize> = BTreeMap::new();
    let surface = MiddleSurface::of(mesh);
    for (i, s) in model.sections.iter().enumerate() {
        let key = format!("sections[{i}].on");
        let quads = c.set(mesh, key.clone(), &s.on, "quads", Mesh::quads_on);
        if let Some(distribution) = &s.thickness_distribution {
            c.thickness_distribution(mesh, (i, s, distribution), &quads);
        }
        if let Some(surface) = &surface {
            super::layers::check(surface, (i, s), &quads, c);
        }
        for q in quads {
            if let Some(other) = section_of.insert(q, i) {
                c.add(
                    key.as_str(),
                    format!(
                        "element {} belongs to sections[{other}] and sections[{i}]",
                        mesh.quad_label(q as usize)
                    ),
                    "let the sets of the sections be disjoint",
                );
                break;
            }
        }
    }
    if section_of.len() < mesh.quads.len()
        && let Some(q) = (0..mesh.quads.len() as u32).find(|q| !section_of.contains_key(q))
        && !model.sections.is_empty()
    {
        c.add(
            "sections",
            format!(
                "{} of {} elements have no section, the first is element {}",
                mesh.quads.len() - section_of.len(),
                mesh.quads.len(),
                mesh.quad_label(q as usize)
            ),
            "add a section for them, or use on = \"all\"",
        );
    }
}

/// Sets and distributions of loads.
fn loads_of(model: &Model, mesh: &Mesh, c: &mut Checker) {
    for (i, load) in model.loads.iter().enumerate() {
        let key = format!("loads[{i}].on");
        match load.part() {
            LoadedPart::Nodes if model.bodies.iter().any(|body| body.name == load.on()) => {
                super::bodies::load_on_body(model, load, &format!("loads[{i}].on"), mesh, c);
            }
            LoadedPart::Nodes if mesh.quads.is_empty() && !model.bodies.is_empty() => {
                c.missing(key, "body", load.on(), model.bodies.iter().map(|body| &body.name));
            }
            LoadedPart::Nodes => drop(c.set(mesh, key, load.on(), "nodes", Mesh::nodes_on)),
            LoadedPart::Edges => drop(c.set(mesh, key, load.on(), "edges", Mesh::edges_on)),
            LoadedPart::Quads => drop(c.set(mesh, key, load.on(), "quads", Mesh::quads_on)),
            LoadedPart::Model => {}
        }
        let Some(distribution) = load.distribution() else { continue };
        let key = format!("loads[{i}].distribution");
        if model.bodies.iter().any(|body| body.name == load.on()) {
            c.add(key, "a load on a body acts in one point", "leave the distribution out");
        } else {
            c.distribution(mesh, &key, (distribution, load.on(), load.part()));
        }
    }
}

/// Places and sets of recorded points.
fn points_of(model: &Model, mesh: &Mesh, c: &mut Checker) {
    for (i, p) in model.output.points.iter().enumerate() {
        if let (None, Some(at)) = (&p.on, p.at)
            && let Err((message, help)) = mesh.node_near(&p.name, Vec3::from(at))
        {
            c.add(format!("output.points[{i}].at"), message, help);
        }
        if let Some(on) = &p.on {
            let key = format!("output.points[{i}].on");
            let nodes = c.set(mesh, key.clone(), on, "nodes", Mesh::nodes_on);
            if nodes.len() > 1 {
                c.add(
                    key,
                    format!("set \"{on}\" has {} nodes, a point needs one", nodes.len()),
                    "name a set with one node, or give a position with `at`",
                );
            }
        }
    }
}

/// Whether initial velocities are those of a body, of a beam or of the whole model, in place of a set.
fn of_bodies(model: &Model, mesh: &Mesh, initial: &InitialVelocity) -> bool {
    let named = |name: &String| *name == initial.on;
    super::actions::moves_model(initial, mesh)
        || model.bodies.iter().map(|body| &body.name).any(named)
        || model.beams.iter().map(|beam| &beam.name).any(named)
}

/// Sets in use that hold orphan nodes: these have no degrees of freedom to support, load or record.
fn orphan_nodes(model: &Model, mesh: &Mesh) -> Vec<Issue> {
    let part_of = mesh.parts();
    let mut names: Vec<(String, &str)> = Vec::new();
    for (i, c) in model.conditions.iter().enumerate() {
        names.push((format!("conditions[{i}].on"), c.on()));
    }
    for (i, load) in model.loads.iter().enumerate() {
        if matches!(load.part(), LoadedPart::Nodes | LoadedPart::Edges) {
            names.push((format!("loads[{i}].on"), load.on()));
        }
    }
    for (i, mass) in model.masses.iter().enumerate() {
        if let AddedMass::Point(m) | AddedMass::Edge(m) = mass {
            names.push((format!("masses[{i}].on"), &m.on));
        }
    }
    for (i, foundation) in model.foundations.iter().enumerate() {
        names.push((format!("foundations[{i}].on"), foundation.on()));
    }
    for (i, v) in model.initial_velocities.iter().enumerate().filter(|(_, v)| !of_bodies(model, mesh, v)) {
        names.push((format!("initial_velocities[{i}].on"), &v.on));
    }
    for (i, p) in model.output.points.iter().enumerate() {
        if let Some(on) = &p.on {
            names.push((format!("output.points[{i}].on"), on));
        }
    }
    for (i, cut) in model.output.cuts.iter().enumerate() {
        names.push((format!("output.cuts[{i}].on"), &cut.on));
    }
    let loose = |name: &str| {
        mesh.nodes_on(name).unwrap_or_default().into_iter().find(|&n| part_of[n as usize] == u32::MAX)
    };
    names
        .into_iter()
        .filter_map(|(key, name)| {
            let node = loose(name)?;
            Some(Issue::new(
                key,
                format!("set \"{name}\" holds node {}, which belongs to no element", mesh.node_label(node)),
                "take the node out of the set, or out of the mesh",
            ))
        })
        .collect()
}

/// Masses that an analysis needs and the model does not have.
pub fn masses(model: &Model, system: &System) -> Vec<Issue> {
    let mut c = Checker::default();
    let needed = match &model.analysis {
        Analysis::Modal(_) => Some("a modal analysis"),
        Analysis::Transient(_) => Some("a transient analysis"),
        Analysis::Static(_) | Analysis::Path(_) | Analysis::Buckling(_) => {
            model.loads.iter().find(|load| load.needs_mass()).map(Load::kind)
        }
    };
    if let Some(what) = needed {
        for (i, s) in model.sections.iter().enumerate() {
            let at_rest =
                model.analysis.seeks_equilibria() || matches!(model.analysis, Analysis::Buckling(_));
            if s.total_mass.is_some() || at_rest && system.total_mass() != 0.0 {
                continue;
            }
            for name in s.materials() {
                if model.materials.get(&name).is_some_and(|m| m.density() == 0.0) {
                    c.add(
                        format!("materials.{name}.density"),
                        format!("the density is 0, but {what} needs the mass of sections[{i}]"),
                        "give the density, or `total_mass` in the section",
                    );
                }
            }
        }
        super::beams::masses(model, system, what, &mut c);
    }
    if let Analysis::Modal(m) = &model.analysis
        && m.modes as usize > system.unknowns()
    {
        c.add(
            "analysis.modes",
            format!("{} modes wanted, but the model has only {} unknowns", m.modes, system.unknowns()),
            "ask for fewer modes or refine the mesh",
        );
    }
    c.issues
}

impl Checker {
    /// Reports an amplitude that the model does not define.
    pub(super) fn amplitude(&mut self, model: &Model, key: &str, name: &Option<String>) {
        if let Some(name) = name
            && !model.amplitudes.contains_key(name)
        {
            self.missing(format!("{key}.amplitude"), "amplitude", name, model.amplitudes.keys());
        }
    }

    /// Members of a set; an issue if it does not exist or is empty.
    pub(super) fn set<T>(
        &mut self,
        mesh: &Mesh,
        key: String,
        name: &str,
        kind: &str,
        get: impl Fn(&Mesh, &str) -> Option<Vec<T>>,
    ) -> Vec<T> {
        match get(mesh, name) {
            Some(list) if !list.is_empty() => list,
            Some(_) => {
                self.add(
                    key,
                    format!("set \"{name}\" holds no {kind}: it would act on nothing"),
                    "choose a set that has some",
                );
                Vec::new()
            }
            None => {
                let help = match mesh.closest_name(name).filter(|close| close != name) {
                    Some(close) => {
                        format!("did you mean \"{close}\"? The mesh has: {}", mesh.set_names().join(", "))
                    }
                    None => format!("the mesh has: {}", mesh.set_names().join(", ")),
                };
                self.add(key, format!("the mesh has no set \"{name}\" with {kind}"), help);
                Vec::new()
            }
        }
    }

    /// Times of `output.at`: after the start and not after the end.
    fn wanted_times(&mut self, model: &Model) {
        let (end, what) = match &model.analysis {
            Analysis::Static(_) => (1.0, "load factors above 0 and up to 1"),
            // The path may pass any load factor.
            Analysis::Path(_) => return,
            Analysis::Transient(t) => (t.end_time, "times after 0 and up to `end_time`"),
            Analysis::Modal(_) | Analysis::Buckling(_) => {
                if !model.output.at.is_empty() {
                    self.add("output.at", "modal and buckling analyses have no steps", "leave `at` out");
                }
                return;
            }
        };
        for (i, &t) in model.output.at.iter().enumerate() {
            if !(t > 0.0 && t <= end) {
                self.add(
                    format!("output.at[{i}]"),
                    format!("{t} is not in the course of the analysis"),
                    format!("give {what}"),
                );
            }
        }
    }

    /// Stop conditions, whose columns must tell something of the model.
    fn stop_conditions(&mut self, conditions: &[StopCondition]) {
        for (i, condition) in conditions.iter().enumerate() {
            let key = format!("analysis.stop[{i}]");
            self.finite(&format!("{key}.value"), "the value", &[condition.value]);
            let column = condition.column.as_str();
            if ["iterations", "step_size"].contains(&column) || column.starts_with("balance.") {
                self.add(
                    format!("{key}.column"),
                    format!("the column `{column}` is a number of the computation, not of the model"),
                    "name a column with a motion, a force or an energy",
                );
            }
        }
    }

    /// Loads, motions or strains without which a search for equilibria has nothing to do.
    fn something_acts(&mut self, model: &Model, continues: bool) {
        if !continues
            && model.loads.is_empty()
            && model.prescribed_strains.is_empty()
            && !model.conditions.iter().any(|c| c.motion().is_some())
            && !model.joints.iter().any(|joint| joint.common().drive().is_some())
            && !model.has_preloaded_springs()
            && !(model.has_springs()
                && model.joints.iter().any(|joint| joint.common().second_side().is_given()))
        {
            self.add("loads", super::own_parts::NOTHING_ACTS, "add a [[loads]] entry");
        }
    }

    fn analysis(&mut self, model: &Model, continues: bool) {
        self.stop_conditions(model.analysis.stop_conditions());
        match &model.analysis {
            Analysis::Static(s) => {
                for (key, value) in [("load_steps", s.load_steps), ("max_iterations", s.max_iterations)] {
                    if value == 0 {
                        self.add(format!("analysis.{key}"), format!("`{key}` is 0"), "give at least 1");
                    }
                }
                if s.linear_solver == LinearSolver::Iterative && s.allow_unstable {
                    self.add(
                        "analysis.allow_unstable",
                        "the iterative linear solver finds stable equilibria only",
                        "set linear_solver = \"direct\", or leave `allow_unstable` out",
                    );
                }
                super::check_path::continued(s, self);
                self.something_acts(model, continues);
            }
            Analysis::Path(path) => {
                self.something_acts(model, continues);
                super::check_path::path(model, path, self);
            }
            Analysis::Modal(modal) => super::check_modal::modal(model, modal, self),
            Analysis::Buckling(buckling) => super::check_buckling::buckling(model, buckling, self),
            Analysis::Transient(t) => {
                self.positive("analysis.end_time", "the end time", t.end_time);
                self.positive("analysis.tolerance", "the tolerance", t.tolerance);
                for (key, value) in
                    [("time_step", t.time_step), ("initial_step", t.initial_step), ("max_step", t.max_step)]
                {
                    if let Some(value) = value {
                        self.positive(&format!("analysis.{key}"), "the step", value);
                    }
                }
                for (key, value) in [("time_step", t.time_step), ("initial_step", t.initial_step)] {
                    if let Some(value) = value.filter(|&value| value > t.end_time && t.end_time > 0.0) {
                        self.add(
                            format!("analysis.{key}"),
                            format!("the step {value} is longer than the whole analysis of {}", t.end_time),
                            "give a step below the end time",
                        );
                    }
                }
                if let Some(step) = t.time_step.filter(|&step| step > 0.0 && t.end_time / step > MOST_STEPS) {
                    self.add(
                        "analysis.time_step",
                        format!(
                            "the analysis of {} would take {:.1e} steps of {step}",
                            t.end_time,
                            t.end_time / step
                        ),
                        "give a larger step or an earlier end",
                    );
                }
                if t.max_iterations == 0 {
                    self.add("analysis.max_iterations", "`max_iterations` is 0", "give at least 1");
                }
                t.scheme.check("analysis.scheme", self);
                t.scheme.check_model("analysis.scheme", model, t, self);
            }
        }
    }
}
