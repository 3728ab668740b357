//! Distributions by arrays of a mesh file, from the model file to the displacements.
#![allow(clippy::unwrap_used)]

use std::fs;
use std::path::Path;

use tegula::analysis::{Silent, statics};
use tegula::element::Nodal;
use tegula::model::Analysis;
use tegula_io::deck::Deck;
use tegula_io::job::{self, JobOptions, Prepared, Unwatched};
use tegula_io::mesh::MeshReader as _;
use tegula_io::mesh::vtu::Vtu;

/// Plate of `tests/data/vtu.py`, clamped along x = 0 by the lines of the file; point array t = 1 + x/2 + y/4, cell array p = 1, 2, …
const MODEL: &str = r#"
[analysis]
type = "static"
linear = true
[mesh]
type = "vtu"
file = "plate.vtu"
[materials.m]
type = "isotropic"
young = 2e5
poisson = 0.3
expansion = 1e-5
[[conditions]]
type = "clamp"
on = "gmsh:physical:1"
"#;
const SECTION: &str = "[[sections]]\nmaterial = \"m\"\nthickness = 0.02\n";
const PRESSURE: &str = "[[loads]]\ntype = \"pressure\"\nvalue = 1e-4\n";

fn prepared(folder: &Path, file: &str, parts: &str) -> Result<Prepared, String> {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/vtu").join(file);
    fs::copy(data, folder.join("plate.vtu")).unwrap();
    let deck = Deck::parse(folder.join("model.toml"), format!("{MODEL}{parts}"));
    let deck = deck.map_err(|found| found.iter().map(ToString::to_string).collect::<String>())?;
    job::prepare(&deck).map_err(|error| error.to_string())
}

fn displacements(parts: &str) -> Vec<Nodal> {
    let folder = tempfile::tempdir().unwrap();
    let prepared = prepared(folder.path(), "vtk-raw-zlib.vtu", parts).unwrap();
    let Analysis::Static(options) = &prepared.model.analysis else { panic!("no static analysis") };
    statics::run(&prepared.system, options, None, &mut Silent).unwrap().state.u
}

/// Difference between a model with a field and one with the formula whose values, or means over cells, the field has.
fn compare(model: &str, tolerance: f64) {
    for (field, formula) in [("t", "1 + x/2 + y/4"), ("p", "1 + (x - 0.5) + 3*(y - 0.5)")] {
        if field == "p" && !model.contains("CELLS TOO") {
            continue;
        }
        let by_field = displacements(&model.replace("DISTRIBUTION", &format!("{{ field = \"{field}\" }}")));
        let by_formula = displacements(&model.replace("DISTRIBUTION", &format!("\"{formula}\"")));
        let plain = displacements(&model.replace("DISTRIBUTION", "\"1\""));
        let size =
            |u: &[Nodal]| u.iter().flatten().fold(0.0_f64, |a, b| if b.abs() > a { b.abs() } else { a });
        let off = |a: &[Nodal], b: &[Nodal]| -> f64 {
            let difference: Vec<Nodal> =
                a.iter().zip(b).map(|(a, b)| std::array::from_fn(|i| a[i] - b[i])).collect();
            size(&difference) / size(b)
        };
        let found = off(&by_field, &by_formula);
        println!("{field}: {found:.1e}");
        assert!(found < tolerance, "{field}: {found:.1e}\n{model}");
        assert!(off(&plain, &by_formula) > 1e-2, "{field}: the distribution does nothing\n{model}");
    }
}

#[test]
fn a_thickness_by_a_field_is_that_by_its_formula() {
    compare(&format!("{SECTION}thickness_distribution = DISTRIBUTION\n{PRESSURE}"), 1e-11);
}

#[test]
fn a_thickness_by_a_field_of_cells_is_that_of_two_sections() {
    let field = format!("{SECTION}thickness_distribution = {{ field = \"gmsh:physical\" }}\n{PRESSURE}");
    let section = |number: u8| {
        SECTION.replace("0.02", &format!("{}", 0.02 * f64::from(number)))
            + &format!("on = \"gmsh:physical:{number}\"\n")
    };
    let sections = format!("{}{}{PRESSURE}", section(1), section(2));
    assert_eq!(displacements(&field), displacements(&sections));
}

#[test]
fn a_pressure_by_a_field_is_that_by_its_formula() {
    compare(&format!("# CELLS TOO\n{SECTION}{PRESSURE}distribution = DISTRIBUTION\n"), 1e-11);
}

#[test]
fn a_temperature_by_a_field_is_that_by_its_formula() {
    let heat =
        "[[prescribed_strains]]\ntype = \"thermal\"\ntemperature = 30.0\ndistribution = DISTRIBUTION\n";
    compare(&format!("# CELLS TOO\n{SECTION}{heat}"), 1e-11);
}

#[test]
fn loads_on_nodes_and_edges_by_a_field_are_those_by_its_formula() {
    for (kind, on) in [
        ("force", "ref:5"),
        ("moment", "ref:5"),
        ("edge", "ref:5"),
        ("edge-moment", "ref:5"),
        ("traction", "gmsh:physical:2"),
    ] {
        let load = format!("[[loads]]\ntype = \"{kind}\"\non = \"{on}\"\nvalue = [1e-5, 1e-4, 0.0]\n");
        compare(&format!("{SECTION}{load}distribution = DISTRIBUTION\n"), 1e-11);
    }
}

/// A traction with a value for each cell is that of a traction on each of them.
#[test]
fn a_traction_by_a_field_of_cells_is_the_sum_over_the_cells() {
    let load = |value: f64, rest: &str| {
        format!(
            "[[loads]]\ntype = \"traction\"\non = \"gmsh:physical:1\"\nvalue = [0.0, 0.0, {value}]\n{rest}"
        )
    };
    let whole = displacements(&format!("{SECTION}{}", load(1e-4, "distribution = { field = \"p\" }\n")));
    // Cells 0 and 3 with p = 1 and 4.
    let sets = "[[sets]]\ntype = \"box\"\nname = \"low left\"\nx = [0.0, 1.0]\ny = [0.0, 1.0]\n";
    let both = displacements(&format!("{SECTION}{sets}{}{}", load(1e-4, ""), load(3e-4, "")));
    let low = displacements(&format!(
        "{SECTION}{sets}{}",
        load(3e-4, "").replace("on = \"gmsh:physical:1\"", "on = \"low left\"")
    ));
    for ((whole, both), low) in whole.iter().zip(&both).zip(&low) {
        for i in 0..3 {
            assert!(
                (whole[i] - (both[i] - low[i])).abs() < 1e-12 * (1.0 + both[i].abs()),
                "{whole:?} {both:?} {low:?}"
            );
        }
    }
}

/// The field files of a run are meshes: the points and elements of the model, with the scalar fields of the results.
#[test]
fn results_of_this_program_are_meshes() {
    let folder = tempfile::tempdir().unwrap();
    let mesh = prepared(folder.path(), "vtk-ascii.vtu", &format!("{SECTION}{PRESSURE}")).unwrap().mesh;
    let deck = Deck::parse(folder.path().join("model.toml"), format!("{MODEL}{SECTION}{PRESSURE}")).unwrap();
    let options = JobOptions { folder: folder.path().join("results"), resume: false, force: false };
    job::run(&deck, &options, &mut Unwatched).unwrap();
    let files = fs::read_dir(folder.path().join("results/fields")).unwrap();
    let mut count = 0;
    for file in files.map(|file| file.unwrap().path()).filter(|path| path.extension().unwrap() == "vtu") {
        let read = Vtu::parse(&file, &fs::read(&file).unwrap(), 1.0).unwrap();
        assert_eq!((&read.positions, &read.quads), (&mesh.positions, &mesh.quads));
        assert!(read.field("von_mises").is_ok() && read.field("energy_density").is_ok(), "{:?}", read.fields);
        count += 1;
    }
    assert!(count >= 2, "{count} files");
    // The last file as the mesh of another model, whose thickness grows with the stress of the first.
    fs::copy(folder.path().join("results/fields/0001.vtu"), folder.path().join("plate.vtu")).unwrap();
    let again = format!("{MODEL}{SECTION}{PRESSURE}").replace("gmsh:physical:1", "left")
        + "[[sets]]\ntype = \"plane\"\nname = \"left\"\nat = [0.0, 0.0, 0.0]\nnormal = [1.0, 0.0, 0.0]\n";
    let again =
        again.replace(SECTION, &format!("{SECTION}thickness_distribution = {{ field = \"von_mises\" }}\n"));
    let prepared = job::prepare(&Deck::parse(folder.path().join("model.toml"), &again).unwrap()).unwrap();
    assert!(prepared.system.sections.len() >= 3, "{} thicknesses", prepared.system.sections.len());
}

#[test]
fn fields_that_cannot_be_distributions_are_refused_with_their_key() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |parts: &str, wanted: &str| {
        let message = prepared(folder.path(), "meshio-zlib.vtu", parts).err().expect(wanted);
        assert!(message.contains(wanted), "{message}\n{wanted}");
    };
    let pressure = |distribution: &str| format!("{SECTION}{PRESSURE}distribution = {distribution}\n");
    refused(&pressure("{ field = \"q\" }"), "the mesh has no field \"q\"");
    refused(
        &pressure("{ field = \"q\" }"),
        "the mesh has, of points, \"ref\", \"t\", and of cells \"gmsh:physical\", \"p\"",
    );
    refused(&pressure("{ field = \"velocity\" }"), "the field \"velocity\" has 3 components");
    refused(&pressure("{ feld = \"t\" }"), "unknown key \"feld\"");
    refused(&pressure("3.0"), "expected a string or a table, found the number 3.0");
    let edge = "[[loads]]\ntype = \"edge\"\non = \"ref:5\"\nvalue = [0.0, 0.0, 1.0]\ndistribution = { field = \"p\" }\n";
    refused(&format!("{SECTION}{edge}"), "nodes and edges need one for each point");
    refused(
        &format!("{SECTION}thickness_distribution = {{ field = \"ref\" }}\n{PRESSURE}"),
        "the thickness must be above 0",
    );
    let plate = "mesh = { type = \"plate\", size = [1.0, 1.0], grid = { elements = [1, 1] } }";
    let text =
        MODEL.replace("[mesh]\ntype = \"vtu\"\nfile = \"plate.vtu\"", "").replace("gmsh:physical:1", "u_min");
    let deck =
        Deck::parse("model.toml", format!("{plate}\n{text}{}", pressure("{ field = \"t\" }"))).unwrap();
    let message = job::prepare(&deck).err().unwrap().to_string();
    assert!(message.contains("VTU files and views in Gmsh files bring fields along"), "{message}");
}
