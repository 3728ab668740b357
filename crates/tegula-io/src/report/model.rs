//! Report of a model: its mesh in the reference configuration with supports, loads and sets, a table, warnings and the model file.

use serde::Serialize;
use tegula::Mesh;
use tegula::model::Section;

use super::blocks::Blocks;
use super::marks::{self, word};
use super::page::{Document, Shown, model_section};
use super::scene::{Kind, Scene, SceneField, SceneMesh};
use super::{Report, shortened, tables};
use crate::deck::Deck;
use crate::job::Prepared;
use crate::out::numbers::{grouped, significant};
use crate::out::vtu::escape;

/// Digits of numbers in the table.
const DIGITS: usize = 7;

/// The model as the scripts read it.
#[derive(Debug, Serialize)]
struct ModelPart {
    name: &'static str,
    scenes: Vec<Scene>,
}

/// Report of a model. The mesh is left out where it would make the report longer than about `most` characters, named sets where it is longer
/// already.
pub(super) fn report(deck: &Deck, prepared: &Prepared, most: usize) -> Report {
    let mut blocks = Blocks::default();
    let mut omissions = Vec::new();
    let mut scene = Some(scene(prepared, &mut blocks)).filter(|scene| !scene.meshes.is_empty());
    if blocks.size > most {
        (blocks, scene) = (Blocks::default(), None);
        omissions.push("The mesh had no room in it.".into());
    }
    if let Some(scene) = &mut scene {
        let left_out;
        (scene.marks, left_out) = marks::of(prepared, &mut blocks, most);
        if left_out > 0 {
            omissions.push(format!("{left_out} named sets had no room in it."));
        }
    }
    let parts = [ModelPart { name: "", scenes: scene.into_iter().collect() }];
    let title = if deck.model.title.is_empty() { name(deck) } else { deck.model.title.clone() };
    let warnings: Vec<String> = prepared.warnings.iter().map(ToString::to_string).collect();
    let document = Document {
        title: &title,
        line: format!("Model of <code>{}</code>, tegula {}", escape(&name(deck)), env!("CARGO_PKG_VERSION")),
        before: Vec::new(),
        shown: Shown::Model,
        after: vec![
            format!(
                "<section id=\"table\">\n<h2>Contents</h2>\n<div class=\"runs\">\n<div>{}</div>\n<div>{}</div>\n</div>\n{}</section>\n",
                table(deck, prepared),
                parts_of(deck),
                tables::warnings(&warnings)
            ),
            model_section(Some(&shortened(&deck.text))),
        ],
        notes: &omissions,
    };
    let page = document.pieces(&parts, &blocks);
    Report { page, omissions }
}

/// Name of the model file.
fn name(deck: &Deck) -> String {
    deck.path.file_name().unwrap_or(deck.path.as_os_str()).to_string_lossy().into_owned()
}

/// The mesh and the outlines of bodies in the reference configuration, without marks.
fn scene(prepared: &Prepared, blocks: &mut Blocks) -> Scene {
    let Prepared { mesh, system, .. } = prepared;
    let mut meshes = Vec::new();
    if !mesh.quads.is_empty() {
        meshes.push(shells(prepared, mesh, blocks));
    }
    if !system.outline.is_empty() {
        let points = system.outline.positions(&system.coordinates.reference, &[], 1.0);
        meshes.push(SceneMesh {
            outline: true,
            points: points.len(),
            references: vec![blocks.singles(points.iter().flatten())],
            quads: blocks.indices(system.outline.quads.iter().flatten()),
            lines: blocks.indices(system.outline.lines.iter().flatten()),
            displacement: None,
            fields: Vec::new(),
        });
    }
    Scene {
        name: "Model".into(),
        kind: Kind::Model,
        parameter: "time".into(),
        values: vec![0.0],
        labels: vec!["reference configuration".into()],
        available: 1,
        meshes,
        left_out: Vec::new(),
        marks: Vec::new(),
    }
}

fn shells(prepared: &Prepared, mesh: &Mesh, blocks: &mut Blocks) -> SceneMesh {
    let mut sections = vec![f64::NAN; mesh.quads.len()];
    for shell in &prepared.system.shells {
        if let Some(section) = sections.get_mut(shell.quad as usize) {
            *section = shell.section as f64;
        }
    }
    let categories: Vec<String> = prepared.model.sections.iter().map(|s| section_name(s, mesh)).collect();
    let sections = SceneField {
        name: "section".into(),
        at_points: false,
        components: vec![(String::new(), blocks.rounded(&[sections]))],
        categories,
    };
    SceneMesh {
        outline: false,
        points: mesh.positions.len(),
        references: vec![blocks.singles(mesh.positions.iter().flat_map(|x| x.iter()))],
        quads: blocks.indices(mesh.quads.iter().flatten()),
        lines: blocks.indices(&[]),
        displacement: None,
        fields: vec![sections],
    }
}

/// Set, material and thickness of a section.
fn section_name(section: &Section, mesh: &Mesh) -> String {
    let layers = match section.layers() {
        Some((key, _)) => key.to_owned(),
        None if mesh.thickness.is_some() && section.thickness == 0.0 => section.material.clone(),
        None => format!("{}, thickness {}", section.material, significant(section.thickness, DIGITS)),
    };
    let varying = section.thickness_distribution.as_ref().map_or(String::new(), |f| format!(" × ({f})"));
    format!("{}: {layers}{varying}", section.on)
}

/// Analysis, size and mass of a model.
fn table(deck: &Deck, prepared: &Prepared) -> String {
    let (model, system) = (&deck.model, &prepared.system);
    let analyses = if model.steps.is_empty() {
        word(&model.analysis)
    } else {
        model.steps.iter().map(|step| word(&step.analysis)).collect::<Vec<_>>().join(", then ")
    };
    let mut rows = vec![
        ("Analysis", analyses),
        ("Shell elements", grouped(system.elements())),
        ("Nodes", grouped(prepared.mesh.positions.len())),
        ("Unknowns", grouped(system.unknowns())),
        ("Mass", significant(system.total_mass(), DIGITS)),
        ("Size", significant(system.length, DIGITS)),
    ];
    let counts = [
        ("Bodies", model.bodies.len()),
        ("Beams", model.beams.len()),
        ("Joints", model.joints.len()),
        ("Springs", model.springs.len() + model.torsion_springs.len() + model.bushings.len()),
    ];
    rows.extend(counts.into_iter().filter(|(_, n)| *n > 0).map(|(name, n)| (name, grouped(n))));
    let row = |(name, value): &(&str, String)| {
        format!("<tr><th scope=\"row\">{name}</th><td>{}</td></tr>\n", escape(value))
    };
    format!("<table class=\"facts\"><tbody>\n{}</tbody></table>\n", rows.iter().map(row).collect::<String>())
}

/// Tables of sections and materials.
fn parts_of(deck: &Deck) -> String {
    let sections: Vec<Vec<String>> = deck
        .model
        .sections
        .iter()
        .map(|section| {
            let (material, thickness) = match section.layers() {
                Some((key, _)) => (key.to_owned(), String::new()),
                None => (section.material.clone(), significant(section.thickness, DIGITS)),
            };
            let factor = section.thickness_distribution.as_ref().map(|f| format!(" × ({f})"));
            let thickness = format!("{thickness}{}", factor.unwrap_or_default());
            vec![section.on.clone(), word(&section.element), material, thickness]
        })
        .collect();
    let materials: Vec<Vec<String>> =
        deck.model.materials.iter().map(|(name, material)| vec![name.clone(), word(material)]).collect();
    tables::table("Sections", &["on", "element", "material", "thickness"], &sections)
        + &tables::table("Materials", &["name", "type"], &materials)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::job::prepare;
    use crate::report::blocks::tests::decoded;
    use crate::report::marks::{Mark, Subject};

    const PLATE: &str = r#"
        title = "Plate </script> & co"
        [analysis]
        type = "static"
        [mesh]
        type = "plate"
        size = [2.0, 1.0]
        [mesh.grid]
        elements = [4, 2]
        [materials.steel]
        type = "isotropic"
        young = 2e11
        poisson = 0.3
        density = 7850.0
        [[sections]]
        material = "steel"
        thickness = 0.02
        [[conditions]]
        type = "clamp"
        on = "u_min"
        [[loads]]
        type = "edge"
        on = "u_max"
        value = [0.0, 0.0, -3.0]
        [[loads]]
        type = "pressure"
        value = 5.0
        [[loads]]
        type = "pressure"
        value = -1.0
        [[loads]]
        type = "moment"
        on = "u_max"
        value = [0.0, 2.0, 0.0]
        [[loads]]
        type = "gravity"
        value = [0.0, 0.0, -9.81]
    "#;

    fn deck() -> Deck {
        Deck::parse("plate.toml", PLATE).unwrap()
    }

    fn drawn() -> (Vec<Mark>, Blocks) {
        let mut blocks = Blocks::default();
        let (marks, left_out) = marks::of(&prepare(&deck()).unwrap(), &mut blocks, 1_000_000);
        assert_eq!(left_out, 0);
        (marks, blocks)
    }

    /// Start and vector of the arrows of a mark.
    fn arrows(mark: &Mark, blocks: &Blocks) -> Vec<[f32; 6]> {
        let bytes = decoded(blocks, mark.arrows.unwrap());
        let numbers: Vec<f32> = bytes.chunks(4).map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect();
        numbers.chunks(6).map(|arrow| arrow.try_into().unwrap()).collect()
    }

    #[test]
    fn arrows_have_the_places_and_directions_of_the_loads() {
        let (marks, blocks) = drawn();
        let [edge, pressure, suction, moment, gravity] = [1, 2, 3, 4, 5].map(|i| &marks[i]);
        assert_eq!(
            [edge, pressure, suction, moment, gravity].map(|mark| (mark.name.as_str(), mark.note.as_str())),
            [
                ("edge load on u_max", "(0, 0, -3)"),
                ("pressure load on all", "5"),
                ("pressure load on all", "-1"),
                ("moment load on u_max", "(0, 2, 0)"),
                ("gravity load", "(0, 0, -9.81)"),
            ]
        );
        // An arrow has 12 % of the length of the plate, 2.
        let near = |found: Vec<[f32; 6]>, expected: &[[f32; 6]]| {
            assert_eq!(found.len(), expected.len());
            for (x, y) in found.iter().flatten().zip(expected.iter().flatten()) {
                assert!((x - y).abs() < 1e-6, "{found:?} for {expected:?}");
            }
        };
        let down = |[x, y, z]: [f32; 3]| [x, y, z, 0.0, 0.0, -0.24];
        near(arrows(edge, &blocks), &[down([2.0, 0.25, 0.0]), down([2.0, 0.75, 0.0])]);
        near(arrows(gravity, &blocks), &[down([1.0, 0.5, 0.0])]);
        // A pressure ends at the surface, a suction begins there.
        assert_eq!(arrows(pressure, &blocks).len(), 8);
        near(arrows(pressure, &blocks)[..1].to_vec(), &[down([0.25, 0.25, 0.24])]);
        near(arrows(suction, &blocks)[..1].to_vec(), &[[0.25, 0.25, 0.0, 0.0, 0.0, 0.24]]);
        assert_eq!(arrows(moment, &blocks).len(), 3);
        assert_eq!([edge, moment].map(|mark| mark.turning), [false, true]);
    }

    #[test]
    fn supports_and_sets_mark_their_nodes() {
        let (marks, blocks) = drawn();
        let nodes = |mark: &Mark| -> Vec<u32> {
            let bytes = decoded(&blocks, mark.nodes.unwrap());
            bytes.chunks(4).map(|b| u32::from_le_bytes(b.try_into().unwrap())).collect()
        };
        let mesh = prepare(&deck()).unwrap().mesh;
        assert_eq!((marks[0].subject, marks[0].note.as_str()), (Subject::Support, "3 nodes"));
        assert_eq!(nodes(&marks[0]), mesh.nodes_on("u_min").unwrap());
        let sets: Vec<&Mark> = marks.iter().filter(|mark| mark.subject == Subject::Set).collect();
        let corner = sets.iter().find(|mark| mark.name == "u_max_v_min").unwrap();
        assert_eq!(nodes(corner), mesh.nodes_on("u_max_v_min").unwrap());
        let all = mesh.node_sets.len() + mesh.edge_sets.len() + mesh.quad_sets.len();
        assert_eq!(sets.len(), all);
    }

    #[test]
    fn pages_have_text_that_is_escaped_and_a_greatest_size() {
        let report = Report::of_model(&deck(), 1_000_000).unwrap();
        let page = report.page.concat();
        assert!(report.omissions.is_empty());
        assert!(page.contains("<title>Plate &lt;/script&gt; &amp; co</title>"));
        assert!(!page.contains("Plate </script>"));
        for part in ["<td>314</td>", "<td>15</td>", "<td>static</td>", "young = 2e11", "block-0"] {
            assert!(page.contains(part), "{part}");
        }
        let small = Report::of_model(&deck(), 100).unwrap();
        assert_eq!(small.omissions, ["The mesh had no room in it."]);
        assert!(!small.page.concat().contains("block-0"));
    }

    #[test]
    fn kinds_have_the_words_of_the_model_file() {
        let model = deck().model;
        assert_eq!(
            (word(&model.analysis), word(&model.conditions[0]), word(&model.sections[0].element)),
            ("static".into(), "clamp".into(), "ems".into())
        );
    }
}
