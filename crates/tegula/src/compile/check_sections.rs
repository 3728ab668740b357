//! Checks of sections: missing values, layups, and materials that an element type cannot take.

use super::distributions::wrong_formula;
use crate::checker::Checker;
use crate::element::registry;
use crate::mesh::Mesh;
use crate::model::{Analysis, Material, Membrane, Model, PrescribedStrain, Section};

/// Issues of all sections and prescribed strains.
pub(super) fn sections(model: &Model, c: &mut Checker) {
    for (i, s) in model.sections.iter().enumerate() {
        let key = format!("sections[{i}]");
        layers(model, s, &key, c);
        for (j, k) in s.shear_correction.iter().flatten().enumerate() {
            c.positive(&format!("{key}.shear_correction[{j}]"), "the shear correction factor", *k);
        }
        c.not_negative(
            &format!("{key}.shear_stabilization"),
            "the coefficient of stabilised shear",
            s.shear_stabilization,
        );
        if let Some((problem, help)) = s.thickness_distribution.as_ref().and_then(wrong_formula) {
            c.add(format!("{key}.thickness_distribution"), problem, help);
        }
        if let Some(m) = s.total_mass {
            c.positive(&format!("{key}.total_mass"), "the total mass", m);
        }
        c.not_negative(&format!("{key}.retardation_time"), "the retardation time", s.retardation_time);
        if !matches!(s.thickness_eas, 0 | 1 | 3 | 4) {
            c.add(
                format!("{key}.thickness_eas"),
                format!("{} enhanced parameters over the thickness do not exist", s.thickness_eas),
                "give 0, 1, 3 or 4",
            );
        }
        if let Some(membrane) = s.membrane.filter(|m| !s.eas && *m != Membrane::Displacement) {
            c.add(
                format!("{key}.eas"),
                format!("`eas = false` contradicts the membrane part {membrane:?}"),
                "leave `eas` out; `membrane` alone decides",
            );
        }
        if let Some(n) = s.thickness_points
            && !(2..=20).contains(&n)
        {
            c.add(
                format!("{key}.thickness_points"),
                format!(
                    "{n} integration points over the thickness: bending needs at least 2, and 20 are plenty"
                ),
                "leave it out for 2 (plastic materials: 5)",
            );
        }
        for name in s.materials() {
            if let Some(material) = model.materials.get(&name) {
                ability(model, s, &key, &name, material, c);
            }
        }
    }
    for (i, p) in model.prescribed_strains.iter().enumerate() {
        prescribed(model, p, &format!("prescribed_strains[{i}]"), c);
    }
}

/// Elements with incompatible edges (straight or cubic between their nodes) must not share one.
pub(super) fn edges(model: &Model, mesh: &Mesh, c: &mut Checker) {
    let mut owner = vec![None; mesh.positions.len()];
    for (i, s) in model.sections.iter().enumerate() {
        let element = registry::shell(s, s.whole_thickness().max(f64::MIN_POSITIVE));
        for q in mesh.quads_on(&s.on).unwrap_or_default() {
            for node in mesh.quads[q as usize] {
                let Some(first) = owner.get_mut(node as usize) else { continue };
                let &mut (j, name, vectors) =
                    first.get_or_insert((i, element.name(), element.nodal_vectors()));
                if vectors != element.nodal_vectors() {
                    c.add(
                        format!("sections[{i}].element"),
                        format!(
                            "`{}` and the `{name}` of sections[{j}] meet at node {}, but their edges are incompatible: one is straight between its nodes, the other is a cubic",
                            element.name(),
                            mesh.node_label(node)
                        ),
                        "use one of the two elements for both sections, or let them have no node in common",
                    );
                    return;
                }
            }
        }
    }
}

/// Keys of a section without effect on its element, though they differ from the default.
pub(super) fn idle_keys(s: &Section) -> Vec<&'static str> {
    let h = s.whole_thickness().max(f64::MIN_POSITIVE);
    let made = |s: &Section| format!("{:?}", registry::shell(s, h));
    let usual = Section::new("", 0.0);
    let here = made(s);
    let mut out = Vec::new();
    let mut look = |key, given: bool, change: &dyn Fn(&mut Section)| {
        let mut other = s.clone();
        change(&mut other);
        if given && made(&other) == here {
            out.push(key);
        }
    };
    look("ans_shear", s.ans_shear != usual.ans_shear, &|o| o.ans_shear = usual.ans_shear);
    look("ans_thickness", s.ans_thickness != usual.ans_thickness, &|o| o.ans_thickness = usual.ans_thickness);
    look("eas", s.eas != usual.eas, &|o| o.eas = usual.eas);
    let other =
        if s.membrane == Some(Membrane::Displacement) { Membrane::Eas } else { Membrane::Displacement };
    look("membrane", s.membrane.is_some(), &|o| o.membrane = Some(other));
    look("thickness_eas", s.thickness_eas != usual.thickness_eas, &|o| o.thickness_eas = usual.thickness_eas);
    out
}

fn layers(model: &Model, s: &Section, key: &str, c: &mut Checker) {
    let Some((name, layers)) = s.layers() else {
        if s.material.is_empty() {
            c.add(
                key,
                "missing key \"material\"",
                "add \"material\", a text: Name of a material; or a \"layup\"",
            );
        } else if !model.materials.contains_key(&s.material) {
            c.missing(format!("{key}.material"), "material", &s.material, model.materials.keys());
        }
        if s.thickness == 0.0 {
            c.add(
                key,
                "missing key \"thickness\", or it is 0",
                "add \"thickness\", a number above 0: Thickness h (length)",
            );
        } else {
            c.positive(&format!("{key}.thickness"), "the thickness", s.thickness);
        }
        return;
    };
    let others = s.described().into_iter().skip(1).map(|(other, _)| (other, true));
    for (other, given) in
        [("material", !s.material.is_empty()), ("thickness", s.thickness != 0.0)].into_iter().chain(others)
    {
        if given {
            c.add(
                format!("{key}.{other}"),
                format!("the section has both `{name}` and `{other}`"),
                format!("the {name} says it for each ply; drop one of them"),
            );
        }
    }
    let key = format!("{key}.{name}");
    let solid = registry::shell(s, s.whole_thickness().max(f64::MIN_POSITIVE)).is_solid();
    match layers.plies(&key) {
        Err(issues) => c.issues.extend(issues),
        Ok(_) => {
            for name in s.materials() {
                if !model.materials.contains_key(&name) {
                    c.missing(key.clone(), "material", &name, model.materials.keys());
                }
            }
            if model.materials.values().all(|m| super::check_material::issues(m, "").is_empty())
                && s.materials()
                    .iter()
                    .all(|m| model.materials.get(m).is_some_and(|m| solid || m.plane_stress().is_some()))
                && s.compile(&model.materials).is_none()
            {
                c.add(
                    key.as_str(),
                    "the plies cannot be joined to a laminate",
                    "their stiffness differs by too many orders of magnitude; check units",
                );
            }
        }
    }
    if solid && layers.offset() != 0.0 {
        c.add(
            format!("{key}.offset"),
            "elements with three-dimensional stresses have their mid-surface in the middle",
            "drop `offset`, or use `ems` or `mitc4`",
        );
    }
}

/// Reports a material that the element type cannot take.
fn ability(model: &Model, s: &Section, key: &str, name: &str, material: &Material, c: &mut Checker) {
    let element = registry::shell(s, s.whole_thickness().max(f64::MIN_POSITIVE));
    let (word, kind) = (element.name(), material.kind());
    let at = format!("{key}.{}", s.layers().map_or("material", |(name, _)| name));
    if element.takes_linear_sheets_only()
        && (!material.is_linear() || s.layers().is_some() || s.thickness_points.is_some())
    {
        c.add(
            format!("{key}.element"),
            format!(
                "`{word}` computes one layer of a linear material with two points over the thickness only"
            ),
            "use another element, such as `cm`",
        );
    } else if material.plane_stress().is_none() && !element.is_solid() {
        c.add(
            at,
            format!("`{word}` works with resultants of plane stress and cannot carry the {kind} material \"{name}\""),
            "use `element = \"cm\"` or `\"solid-shell\"`, which integrate three-dimensional stresses",
        );
    } else if !material.is_linear() && s.thickness_points.is_some_and(|n| n < 3) && kind == "plastic" {
        c.add(
            format!("{key}.thickness_points"),
            format!(
                "{} integration points over the thickness do not resolve where \"{name}\" yields in bending",
                s.thickness_points.unwrap_or(0)
            ),
            "give at least 3, or leave it out for 5",
        );
    }
    if material.is_linear() {
        return;
    }
    let linear = match &model.analysis {
        Analysis::Static(a) => a.linear,
        Analysis::Transient(a) => a.linear,
        Analysis::Path(_) | Analysis::Modal(_) | Analysis::Buckling(_) => false,
    };
    if linear {
        c.add(
            "analysis.linear",
            format!("a linear analysis cannot follow the {kind} material \"{name}\""),
            "drop `linear = true`, or use an isotropic or orthotropic material",
        );
    }
    if let Analysis::Transient(t) = &model.analysis
        && t.scheme.conserves_energy()
        && material.yields()
    {
        c.add(
            "analysis.scheme",
            format!(
                "the energy-momentum scheme conserves energy, which the plastic material \"{name}\" dissipates"
            ),
            if model.is_mechanism() {
                "use `generalized-alpha` or `hht`"
            } else {
                "use `newmark`, `hht` or `generalized-alpha`"
            },
        );
    }
}

fn prescribed(model: &Model, p: &PrescribedStrain, key: &str, c: &mut Checker) {
    let values: Vec<f64> = match p {
        PrescribedStrain::Thermal(t) => vec![t.temperature, t.gradient],
        PrescribedStrain::Natural(n) => [n.strain, n.curvature].concat(),
        PrescribedStrain::Prestress(s) => [s.membrane, s.bending].concat(),
    };
    c.finite(key, "a value", &values);
    if values.iter().all(|v| *v == 0.0) {
        c.add(key, "all of its values are 0: it does nothing", "give values, or drop it");
    }
    if p.direction().is_some_and(|d| !d.iter().map(|x| x * x).sum::<f64>().is_normal()) {
        c.add(format!("{key}.direction"), "the direction vanishes", "give a vector such as [1, 0, 0]");
    }
    if let Some((problem, help)) = p.distribution().and_then(wrong_formula) {
        c.add(format!("{key}.distribution"), problem, help);
    }
    let amplitude = p.amplitude().cloned();
    c.amplitude(model, key, &amplitude);
    if matches!(p, PrescribedStrain::Thermal(_))
        && !model.materials.is_empty()
        && model.materials.values().all(|m| m.expansion() == [0.0; 3])
    {
        c.add(
            key,
            "no material expands: the change of temperature does nothing",
            "give a material its `expansion`",
        );
    }
    let heated = |name: &Option<String>| {
        let material = name.as_ref().and_then(|name| model.materials.get(name));
        material.is_some_and(|material| material.expansion() != [0.0; 3])
    };
    if let PrescribedStrain::Thermal(thermal) = p
        && thermal.on == "all"
        && let Some(beam) = model.beams.iter().find(|beam| heated(&beam.material))
    {
        c.add(
            format!("{key}.on"),
            format!("prescribed strains act on shells only: \"all\" does not heat beam \"{}\", whose material expands", beam.name),
            "let `on` name a set of shells, or give the beam a material without `expansion`",
        );
    }
    if matches!(p, PrescribedStrain::Prestress(_))
        && model.sections.iter().any(|s| {
            let solid = registry::shell(s, s.whole_thickness().max(f64::MIN_POSITIVE)).is_solid();
            let nonlinear =
                s.materials().iter().any(|m| model.materials.get(m).is_some_and(|m| !m.is_linear()));
            nonlinear && !solid
        })
    {
        c.add(
            key,
            "a prestress in resultants is not available for layers that yield",
            "use `cm` or `solid-shell`, or give a `natural` strain",
        );
    }
}
