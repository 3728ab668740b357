//! Warnings: models that can be computed but are most likely not intended.

use std::collections::BTreeSet;

use super::{StepModel, procedure, uncorrected_shear};
use crate::analysis::dynamics::{PassedOver, passed_over};
use crate::element::{ShellGeometry, registry};
use crate::load::LoadFactor;
use crate::mesh::directors::FOLD_ANGLE_DEGREES;
use crate::mesh::{Mesh, show};
use crate::model::supports::PrescribedMotion;
use crate::model::{Analysis, Load, Model, NodalVector, PrescribedStrain};
use crate::norm::max_norm;
use crate::system::dof_map::Prescribed;
use crate::system::lumped_body::LumpedBody;
use crate::system::{Procedure, Shell, ShellSection, System, VectorKind};
use crate::{Issue, Vec3};

/// Thickness over the size of the largest element, above which units are most likely mixed up.
const THICK: f64 = 10.0;

/// Distance of two displacements over the size of the model below which they are the same place: equilibria are found up to
/// this accuracy.
const SAME_PLACE: f64 = 1e-8;

/// Distance of a model from the origin over its size, above which positions have less than ten digits within it.
const FAR: f64 = 1e6;

/// Seams that are written out, and nodes of each.
const SHOWN: usize = 10;
const NODES: usize = 4;

/// Input that has no effect, or a geometry that no shell has. The model is computed all the same.
pub fn warnings(model: &Model, mesh: &Mesh, system: &System) -> Vec<Issue> {
    let mut found = unused(model, system);
    found.extend(unused_velocities(model));
    found.extend(jumping_supports(model, system));
    found.extend(shortened_directors(model, system));
    found.extend(independent_of_the_start(model, mesh, system));
    found.extend(uncorrected_shear::warnings(model, system));
    found
}

/// Beams one of whose cross-sections carries two corners of a shell element, which it makes rigid across the beam.
fn wide_stiffeners(model: &Model, mesh: &Mesh, system: &System) -> Vec<Issue> {
    let carrier = |node: &u32| {
        let position = system.coordinates.position_of.get(*node as usize).filter(|v| **v != u32::MAX)?;
        Some(system.dofs().carried(*position as usize)?.triad)
    };
    let mut found = Vec::new();
    for (i, beam) in model.beams.iter().enumerate().filter(|(_, beam)| !beam.attached.is_empty()) {
        let Some(line) = system.beams.iter().find(|line| line.name == beam.name) else { continue };
        let first =
            system.coordinates.bodies[..line.bodies.start].iter().filter(|b| b.directors.is_some()).count();
        let triads = first as u32..(first + line.bodies.len()) as u32;
        let wide = mesh.quads.iter().position(|quad| {
            let of_beam: Vec<u32> = quad.iter().filter_map(carrier).filter(|t| triads.contains(t)).collect();
            of_beam.iter().enumerate().any(|(k, triad)| of_beam[..k].contains(triad))
        });
        let Some(quad) = wide else { continue };
        found.push(Issue::new(
            format!("beams[{i}].attached"),
            format!(
                "two corners of element {} are attached to one cross-section of beam \"{}\", and it makes the shell rigid there",
                mesh.quad_label(quad),
                beam.name
            ),
            "name a set with the nodes of one line of the mesh",
        ));
    }
    found
}

/// A model whose distance from the origin takes the digits that the positions within it need.
fn far_from_the_origin(system: &System) -> Option<Issue> {
    let coordinates = &system.coordinates;
    let positions = coordinates.reference.iter().zip(&coordinates.kinds);
    let positions = positions.filter(|(_, kind)| **kind == VectorKind::Position);
    let distance = max_norm(positions.flat_map(|(x, _)| x.iter().copied()));
    (distance > FAR * system.length).then(|| {
        Issue::new(
            "",
            format!(
                "the model has the size {:.3e} and lies {distance:.3e} from the origin: positions within it are known to {:.0e} of its size",
                system.length,
                f64::EPSILON * distance / system.length
            ),
            "give coordinates near the origin",
        )
    })
}

/// Warnings of an analysis step whose start is not known yet, at the keys of the model file.
pub fn warnings_before_start(step: &StepModel, mesh: &Mesh, system: &System) -> Vec<Issue> {
    let mut found = Vec::new();
    if step.starts_from.is_none() && !matches!(step.model.analysis, Analysis::Modal(_)) {
        found.extend(jumping_supports(&step.model, system));
        found.extend(shortened_directors(&step.model, system));
    }
    if step.starts_from.is_some() && system.linear && matches!(step.model.analysis, Analysis::Modal(_)) {
        found.push(Issue::new(
            "analysis",
            "the steps are linear: loads do not change the stiffness, and these are the modes of the unloaded structure",
            "leave `linear` out of all steps to find the modes of the preloaded one",
        ));
    }
    found.extend(independent_of_the_start(&step.model, mesh, system));
    step.located(found)
}

/// Ratio of the moment of inertia of a body with lumped masses to the exact one above which a warning tells of it.
const RAISED: f64 = 1.05;

/// Bodies that the lumped masses of attached shells make turn more slowly in explicit steps.
fn raised_inertia(model: &Model, system: &System) -> Vec<Issue> {
    if procedure(&model.analysis) != Procedure::Explicit {
        return Vec::new();
    }
    let raised = LumpedBody::raised_moments(system).into_iter().filter(|(_, ratio)| !(*ratio <= RAISED));
    let issue = |(body, ratio): (usize, f64)| {
        let name = &system.coordinates.bodies[body].name;
        Issue::new(
            "analysis.scheme",
            format!(
                "the moment of inertia of body \"{name}\" is up to {ratio:.3} times the exact one: explicit steps lump the masses of the shells that \
                 are attached to it at their nodes"
            ),
            "refine the mesh of the attached shells, or use `energy-momentum`, which has their exact inertia",
        )
    };
    raised.map(issue).collect()
}

/// Folds of a model some of whose steps are explicit and others not: all of them have the softer constraint.
pub fn soft_folds(steps: &[StepModel], system: &System) -> Option<Issue> {
    let explicit = |step: &StepModel| procedure(&step.model.analysis) == Procedure::Explicit;
    let mixed = steps.iter().any(explicit) && !steps.iter().all(explicit);
    (mixed && !system.folds.lines.is_empty()).then(|| {
        Issue::new(
            "steps",
            "a step is explicit, so that all steps have the softer constraint of explicit analyses at folds: their \
             results differ a little from those of a model without the explicit step",
            "compare with the model without that step, or use an implicit scheme",
        )
    })
}

/// Warnings of an analysis step that starts where another one has ended, at the keys of the model file.
pub fn warnings_at_start(step: &StepModel, system: &System) -> Vec<Issue> {
    let mut found = jumping_supports(&step.model, system);
    found.retain(|issue| !step.stays(&issue.place.key));
    step.located(found)
}

fn independent_of_the_start(model: &Model, mesh: &Mesh, system: &System) -> Vec<Issue> {
    let mut found = zero_loads(model);
    found.extend(zero_distributions(model, system));
    found.extend(super::cuts::idle(model, mesh, system));
    found.extend(super::cuts::beside_beams(model, mesh, system));
    found.extend(wide_stiffeners(model, mesh, system));
    found.extend(idle_switches(model));
    found.extend(super::guided_axes::wheels_beside_carriers(model));
    found.extend(seams(model, mesh));
    found.extend(prism(model, mesh, system));
    found.extend(coarse_steps(model, system));
    found.extend(raised_inertia(model, system));
    found.extend(far_from_the_origin(system));
    found.extend(shared_thickness_strains(model, system));
    for i in 0..model.sections.len() {
        let of = |shell: &Shell| &system.sections[shell.section];
        let shells = || system.shells.iter().filter(|shell| of(shell).of_model == i);
        let worst = shells()
            .map(|shell| (curvature(&system.geometry(shell)), shell))
            .max_by(|a, b| a.0.total_cmp(&b.0));
        let Some((curvature, shell)) = worst else { continue };
        let key = format!("sections[{i}].thickness");
        let largest = shells().map(|shell| size(&system.geometry(shell))).fold(0.0, crate::norm::larger);
        let h = of(shell).section.thickness;
        if h * curvature > 1.0 {
            found.push(Issue::new(
                &key,
                format!(
                    "the thickness {h} is larger than the radius of curvature {:.3e} at element {}",
                    1.0 / curvature,
                    mesh.quad_label(shell.quad as usize)
                ),
                "a shell is thin compared with its radius: check the units of mesh and thickness",
            ));
        } else if h > THICK * largest {
            found.push(Issue::new(
                &key,
                format!(
                    "the thickness {h} is {:.0} times the size {largest:.3e} of the largest element",
                    h / largest
                ),
                "a shell is thin compared with its length: check the units of mesh and thickness",
            ));
        }
    }
    found
}

/// Sheets that touch without being connected.
fn seams(model: &Model, mesh: &Mesh) -> Vec<Issue> {
    if model.mesh.merge_coincident() == Some(false) {
        return Vec::new();
    }
    let parts = mesh.parts();
    let place = |x: &Vec3| show(*x);
    let mut found = Vec::new();
    let seams = mesh.seams();
    for seam in seams.iter().take(SHOWN) {
        let mut nodes = Vec::new();
        let mut what = Vec::new();
        if !seam.coincident.is_empty() {
            let n = seam.coincident.len();
            what.push(format!(
                "{n} {} of nodes {}",
                plural(n, "pair"),
                if n == 1 { "coincides" } else { "coincide" }
            ));
            nodes.extend(seam.coincident.iter().map(|pair| {
                let [a, b] = pair.map(|n| mesh.node_label(n));
                format!("{a} and {b}")
            }));
        }
        if !seam.hanging.is_empty() {
            let n = seam.hanging.len();
            what.push(format!(
                "{n} hanging {} across the seam",
                if n == 1 { "node lies on an element" } else { "nodes lie on elements" }
            ));
            nodes.extend(seam.hanging.iter().map(|h| {
                format!("{} on element {}", mesh.node_label(h.node), mesh.quad_label(h.quad as usize))
            }));
        }
        let sides = seam.coincident.iter().flatten().copied();
        let sides = sides.chain(seam.hanging.iter().flat_map(|h| [h.node, mesh.quads[h.quad as usize][0]]));
        let touching: BTreeSet<u32> = sides.map(|n| parts[n as usize]).collect();
        let who = if touching.len() > 1 {
            format!("{} parts of the mesh touch without being connected", touching.len())
        } else {
            "the mesh touches itself without being connected, as along a slit".to_string()
        };
        let more = nodes.len().saturating_sub(NODES);
        nodes.truncate(NODES);
        let more = if more > 0 { format!(", and {more} more") } else { String::new() };
        let [low, high] = &seam.extent;
        found.push(Issue::new(
            "mesh",
            format!(
                "{who}: {} between {} and {}: {}{more}",
                what.join(" and "),
                place(low),
                place(high),
                nodes.join(", ")
            ),
            if seam.coincident.is_empty() {
                "mesh both sides with the same nodes along the seam; if they are to move apart, say `merge_coincident = \
                 false`"
            } else if seam.hanging.is_empty() {
                "`merge_coincident = true` connects them; if they are to move apart, say `merge_coincident = false`"
            } else {
                "mesh both sides with the same nodes along the seam: `merge_coincident = true` connects the pairs only; if \
                 they are to move apart, say `merge_coincident = false`"
            },
        ));
    }
    if seams.len() > SHOWN {
        found.push(Issue::new(
            "mesh",
            format!(
                "and {} more seams along which sheets touch without being connected",
                seams.len() - SHOWN
            ),
            "see those written out above",
        ));
    }
    found.iter_mut().for_each(|issue| issue.place.key = model.mesh.merge_key().into());
    found
}

fn plural(n: usize, word: &str) -> String {
    if n == 1 { word.into() } else { format!("{word}s") }
}

/// Coarse curved surfaces that are taken for folds.
fn prism(model: &Model, mesh: &Mesh, system: &System) -> Option<Issue> {
    if model.mesh.grid().is_some() || model.mesh.given_fold_angle().is_some() {
        return None;
    }
    let prism = system.folds.prism.as_ref()?;
    let n = prism.quads.len();
    let [low, high] = prism.angles;
    let label = mesh.quad_label(prism.quads[0] as usize);
    let angles = if high - low < 0.05 { format!("{high:.1}") } else { format!("{low:.1} to {high:.1}") };
    Some(Issue::new(
        if model.mesh.file().is_some() { "mesh.file" } else { "mesh.quads" },
        format!(
            "{n} {} between two folds of {angles} degrees in the same sense, element {label} first: a curved \
             surface would be computed as a prism of flat strips",
            if n == 1 { "element lies" } else { "elements lie" }
        ),
        format!(
            "if it is curved, refine it until neighbours meet at less than {FOLD_ANGLE_DEGREES} degrees, or give a \
             `fold_angle` above {high:.1}; if flat strips are intended, set `fold_angle = {FOLD_ANGLE_DEGREES}`"
        ),
    ))
}

/// Loads that do not act, and an equilibrium without loads.
fn unused(model: &Model, system: &System) -> Vec<Issue> {
    let Analysis::Modal(modal) = &model.analysis else { return Vec::new() };
    let prescribed = model.conditions.iter().any(|c| c.motion().is_some_and(|m| m.value != 0.0));
    // Strains without an amplitude grow with the load factor: they are not there at the reference.
    let growing = |p: &&PrescribedStrain| modal.prestressed || p.amplitude().is_none();
    if let Some(i) = model.prescribed_strains.iter().position(|p| growing(&p)) {
        if modal.prestressed {
            return Vec::new();
        }
        return vec![Issue::new(
            format!("prescribed_strains[{i}]"),
            "it has no effect on this modal analysis, which is about the reference configuration",
            "give `prestressed = true` to vibrate about the equilibrium under it, or leave it out",
        )];
    }
    let of_caller = modal.prestressed && !system.load_sets.is_empty();
    let acts = !model.loads.is_empty() || prescribed || of_caller;
    // The preload of springs acts in the reference configuration, too.
    match (modal.prestressed, acts || modal.prestressed && model.has_preloaded_springs()) {
        (false, true) => vec![Issue::new(
            if model.loads.is_empty() { "conditions" } else { "loads" },
            "loads and prescribed values have no effect on this modal analysis: it is about the reference configuration",
            "give `prestressed = true` to vibrate about the equilibrium under them, or leave them out",
        )],
        (true, false) => vec![Issue::new(
            "analysis.prestressed",
            "the model has no loads and prescribed values: the equilibrium is the reference configuration",
            "add the loads, or leave `prestressed` out",
        )],
        _ => Vec::new(),
    }
}

/// Velocities at the start of an analysis that does not move.
fn unused_velocities(model: &Model) -> Option<Issue> {
    if matches!(model.analysis, Analysis::Transient(_)) {
        return None;
    }
    // Those of bodies and beams may be meant for a later step.
    let given = |velocity: [f64; 3], turning: [f64; 3]| {
        model.steps.is_empty() && [velocity, turning].iter().flatten().any(|x| *x != 0.0)
    };
    let key = if !model.initial_velocities.is_empty() {
        "initial_velocities[0]".into()
    } else if let Some(i) = model.bodies.iter().position(|b| given(b.velocity, b.angular_velocity)) {
        format!("bodies[{i}].velocity")
    } else {
        let i = model.beams.iter().position(|b| given(b.velocity, b.angular_velocity))?;
        format!("beams[{i}].velocity")
    };
    Some(Issue::new(
        key,
        "velocities at the start have no effect on this analysis: only transient analyses have velocities",
        "give `type = \"transient\"`, or leave them out",
    ))
}

/// Prescribed motions of a transient analysis that are elsewhere at time 0 than the model at its start.
fn jumping_supports(model: &Model, system: &System) -> Vec<Issue> {
    if !matches!(model.analysis, Analysis::Transient(_)) {
        return Vec::new();
    }
    let mut found = Vec::new();
    for (i, condition) in model.conditions.iter().enumerate() {
        let Some(p) = condition.motion() else { continue };
        let first = first_value(&p, system);
        let key = format!("conditions[{i}]");
        let vectors: BTreeSet<u32> =
            system.supports.iter().filter(|s| s.key == key).map(|s| s.vector).collect();
        let own = |q: &&Prescribed| q.value == p.value && vectors.contains(&(q.dof / 3));
        let away = |q: &Prescribed| (first - q.start).abs();
        let farthest = system.dofs().prescribed.iter().filter(own).max_by(|a, b| away(a).total_cmp(&away(b)));
        let start = farthest.map_or(0.0, |q| q.start);
        let size = if p.of == NodalVector::Position { system.length } else { 1.0 };
        if (first - start).abs() > SAME_PLACE * size {
            found.push(Issue::new(
                format!("conditions[{i}]"),
                format!(
                    "the prescribed component is {first} at time 0, where the model starts at {start}: the motion is discontinuous"
                ),
                "give an `amplitude` that begins there, if that is not meant",
            ));
        }
    }
    found
}

/// Value of a prescribed component at time or load factor 0.
fn first_value(p: &PrescribedMotion, system: &System) -> f64 {
    let named = |name: &String| (0..system.amplitudes.len()).find(|&a| system.amplitude_name(a) == name);
    p.value * system.factor(&LoadFactor::new(p.amplitude.as_ref().and_then(named)), 0.0)
}

/// Change of a director component at load factor 0 above which the straight way to it shortens the director noticeably.
const NOTICEABLE: f64 = 0.05;

/// Prescribed directors that are not at their reference at load factor 0 of a static analysis: they go there in a straight
/// line, which shortens them.
fn shortened_directors(model: &Model, system: &System) -> Vec<Issue> {
    if !model.analysis.seeks_equilibria() {
        return Vec::new();
    }
    let mut found = Vec::new();
    for (i, condition) in model.conditions.iter().enumerate() {
        let Some(p) = condition.motion() else { continue };
        let first = first_value(&p, system);
        if p.of == NodalVector::Director && first.abs() > NOTICEABLE {
            found.push(Issue::new(
                format!("conditions[{i}]"),
                format!(
                    "the prescribed component of the director is {first} at load factor 0: the director goes there in a \
                     straight line from the reference and is shorter on the way"
                ),
                "give an `amplitude` that begins at 0, such as 1 - cos(t) and sin(t) of a rotation",
            ));
        }
    }
    found
}

/// Sections of solid elements whose unlike layers are not linear, and share one thickness strain.
fn shared_thickness_strains(model: &Model, system: &System) -> Vec<Issue> {
    let shares = |of: &ShellSection| {
        let first = of.section.layers.first();
        let unlike =
            of.section.layers.iter().any(|layer| first.is_some_and(|f| f.material != layer.material));
        of.element.is_solid() && !of.section.is_linear() && unlike
    };
    let issue = |i: usize| {
        Issue::new(
            format!("sections[{i}].element"),
            "its layers are of different materials, not all linear, and share one thickness strain: layers that contract or \
             expand differently hold each other across the thickness, and their stresses may be too large",
            "use `ems` or `mitc4`, where every layer is in plane stress",
        )
    };
    let sharing = |i: &usize| system.sections.iter().any(|of| of.of_model == *i && shares(of));
    (0..model.sections.len()).filter(sharing).map(issue).collect()
}

/// Keys of sections without effect on their element types.
fn idle_switches(model: &Model) -> Vec<Issue> {
    let mut found = Vec::new();
    for (i, s) in model.sections.iter().enumerate() {
        let element = registry::shell(s, s.whole_thickness());
        for key in super::check_sections::idle_keys(s) {
            found.push(Issue::new(
                format!("sections[{i}].{key}"),
                format!("`{}` has no such remedy to switch off: the key has no effect", element.name()),
                "leave it out, or use an element that has it (the book's page on elements lists them)",
            ));
        }
        let rubber = |m: &String| model.materials.get(m).is_some_and(|m| m.law_3d().is_hyperelastic());
        if s.membrane.is_some_and(|m| m.parameters() > 0) && s.materials().iter().any(rubber) {
            found.push(Issue::new(
                format!("sections[{i}].membrane"),
                "enhanced strains give rubber spurious instabilities in tension, from stretches of about 1.4 on",
                "give \"assumed-shear\" or \"displacement\"",
            ));
        }
        if s.shear_stabilization != 0.0 && element.is_solid() {
            found.push(Issue::new(
                format!("sections[{i}].shear_stabilization"),
                format!("`{}` has three-dimensional stresses: the key has no effect", element.name()),
                "leave it out, or use `ems` or `mitc4`",
            ));
        }
        let linear = s.materials().iter().all(|m| model.materials.get(m).is_none_or(|m| m.is_linear()));
        if s.thickness_points.is_some() && linear && !element.is_solid() {
            found.push(Issue::new(
                format!("sections[{i}].thickness_points"),
                "the key has no effect: the stiffness of linear layers is integrated over the thickness in closed form",
                "leave it out",
            ));
        }
    }
    found
}

/// Formulas whose change within constant time steps is not resolved.
fn coarse_steps(model: &Model, system: &System) -> Vec<Issue> {
    let Analysis::Transient(options) = &model.analysis else { return Vec::new() };
    let issue = |found: &PassedOver| {
        let name = system.amplitude_name(found.amplitude);
        Issue::new(format!("amplitudes.{name}"), format!("the formula {}", found.message()), found.help())
    };
    passed_over(system, options).iter().map(issue).collect()
}

fn zero_loads(model: &Model) -> Vec<Issue> {
    let zero = |load: &Load| load.values().iter().all(|v| *v == 0.0);
    let list = model.loads.iter().enumerate().filter(|(_, load)| zero(load));
    list.map(|(i, load)| {
        let times = if load.amplitude().is_some() { ", whatever its amplitude" } else { "" };
        Issue::new(
            format!("loads[{i}].value"),
            format!("the load is zero{times}"),
            "give its value, or leave it out",
        )
    })
    .collect()
}

/// Loads and prescribed strains of a value whose distribution is 0 everywhere on their set.
fn zero_distributions(model: &Model, system: &System) -> Vec<Issue> {
    let numbered = |numbers: &[usize], number: usize| {
        let of: Vec<usize> =
            numbers.iter().enumerate().filter(|(_, n)| **n == number).map(|(k, _)| k).collect();
        of.into_iter()
    };
    let is_zero = |number: usize| {
        let dead = numbered(&system.load_of_dead, number)
            .all(|k| system.dead_loads[k].force.iter().all(|force| *force == [0.0; 3]));
        let followers = numbered(&system.load_of_follower, number).all(|k| system.followers[k].is_zero());
        dead && followers
    };
    let with_value = |load: &Load| load.distribution().is_some() && load.values().iter().any(|v| *v != 0.0);
    let loads = model.loads.iter().enumerate().filter(|(i, load)| with_value(load) && is_zero(*i));
    let loads = loads.map(|(i, load)| (format!("loads[{i}]"), load.on(), "load"));
    let does_nothing = |strain: &PrescribedStrain| {
        let bare = strain.without_amplitude();
        let field = system.prescribed_strains.iter().position(|field| field.strain == bare);
        let acts = |k: usize| system.shells.iter().any(|s| s.prescribed.get(k).is_some_and(|f| *f != 0.0));
        strain.distribution().is_some() && field.is_some_and(|k| !acts(k))
    };
    let strains = model.prescribed_strains.iter().enumerate().filter(|(_, strain)| does_nothing(strain));
    let strains =
        strains.map(|(i, strain)| (format!("prescribed_strains[{i}]"), strain.on(), "prescribed strain"));
    let issue = |(key, on, what): (String, &str, &str)| {
        Issue::new(
            format!("{key}.distribution"),
            format!("the distribution is 0 everywhere on set \"{on}\": the {what} is zero"),
            format!("look at its coordinates and their unit, or leave the {what} out"),
        )
    };
    loads.chain(strains).map(issue).collect()
}

/// Largest curvature along the sides of an element [1/length]: change of the director over the length of the side.
fn curvature(g: &ShellGeometry) -> f64 {
    let (x, d) = (&g.positions, &g.directors);
    let along = |a: usize, b: usize| -> f64 { Vec3::norm(&(d[a] - d[b])) / Vec3::norm(&(x[a] - x[b])) };
    (0..4).map(|a| along(a, (a + 1) % 4)).fold(0.0, crate::norm::larger)
}

/// Longer diagonal of an element (length).
fn size(g: &ShellGeometry) -> f64 {
    let x = &g.positions;
    (x[2] - x[0]).norm().max((x[3] - x[1]).norm())
}
