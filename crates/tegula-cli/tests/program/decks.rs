//! Input files of Abaqus, CalculiX and Nastran: run, checked and converted.

use super::{errors, example, near, result_of, summary, tegula, text};

/// K. Y. Sze, X. H. Liu, S. H. Lo, Popular benchmark problems for geometric nonlinear analysis of shells, Finite Elements in Analysis and
/// Design 40 (2004), Table 1: the end of the cantilever at the full load. CalculiX 2.20 gives 6.698486 and −3.288555 for the same file.
#[test]
fn the_cantilever_of_sze_is_read_from_its_input_file() {
    let s = result_of("sze_cantilever.inp");
    assert_eq!((&s["status"], &s["elements"]), (&"complete".into(), &64.into()));
    let u = &s["points"]["TIP"]["displacement"];
    near(&u[2], 6.698, 2e-3);
    near(&u[0], -3.286, 2e-3);
    near(&u[2], 6.698486, 2e-3);
    near(&u[0], -3.288555, 2e-3);
    assert!(u[1].as_f64().unwrap().abs() < 1e-6, "{u}");
    near(&s["supports"]["ROOT"]["force"][2], -4.0, 1e-6);
}

#[test]
fn a_converted_input_file_gives_the_same_results() {
    let folder = tempfile::tempdir().unwrap();
    let (model, out) = (folder.path().join("model.toml"), folder.path().join("out"));
    let deck = example("sze_cantilever.inp");
    let converted = tegula(&["convert", text(&deck), text(&model)]);
    assert!(converted.status.success(), "{}", errors(&converted));
    assert!(errors(&converted).contains("without effect: *NODE FILE (line "), "{}", errors(&converted));
    let written = std::fs::read_to_string(&model).unwrap();
    assert!(written.contains("type = \"clamp\"") && written.contains(": *BOUNDARY"), "{written}");
    let again = tegula(&["convert", text(&deck), text(&model)]);
    assert!(again.status.code() == Some(1) && errors(&again).contains("not overwritten"));
    let run = tegula(&["run", text(&model), "--out", text(&out), "--quiet"]);
    assert!(run.status.success(), "{}", errors(&run));
    let direct = result_of("sze_cantilever.inp");
    assert_eq!(summary(&out)["points"], direct["points"]);
}

#[test]
fn mistakes_of_an_input_file_show_its_line() {
    let folder = tempfile::tempdir().unwrap();
    let deck = std::fs::read_to_string(example("sze_cantilever.inp")).unwrap();
    let path = folder.path().join("deck.INP");
    std::fs::write(&path, deck.replace("1.2e6, 0.", "-1.2e6, 0.")).unwrap();
    let check = tegula(&["check", text(&path)]);
    assert_eq!(check.status.code(), Some(1));
    let line = 1 + deck.lines().position(|line| line == "1.2e6, 0.").unwrap();
    let found = errors(&check);
    assert!(
        found.contains(&format!("deck.INP:{}:1", line - 1)) || found.contains(&format!("deck.INP:{line}:1")),
        "{found}"
    );
    std::fs::write(&path, deck.replace("*NODE FILE", "*VISCOELASTIC\n*PLASTIC")).unwrap();
    let check = tegula(&["check", text(&path)]);
    assert!(errors(&check).contains("these cards are not read: *PLASTIC (line "), "{}", errors(&check));
}

/// R. Bredt and R. Batho: a closed thin section twists by T ∮ds/t / (4 A² G) per length; of a square tube of one thickness this is
/// T / (G t b³), and the section does not warp. The walls' own torsion, 4 b t³/3 in the torsion constant, makes it smaller by 0.05 %.
/// CalculiX 2.20 gives 6.183300e-3 for the same mesh of S4.
#[test]
fn the_box_beam_of_a_bulk_data_file_twists_as_a_closed_thin_section() {
    let s = result_of("box_beam.bdf");
    assert_eq!((&s["status"], &s["elements"]), (&"complete".into(), &400.into()));
    let (torque, length, thickness, width) = (1000.0, 1.0, 0.002_f64, 0.1_f64);
    let shear = 2.1e11 / 2.6;
    let bredt = torque * length / (shear * thickness * width.powi(3));
    let walls = bredt / (1.0 + 4.0 / 3.0 * (thickness / width).powi(2));
    // The corners of the rigid end at y = -50 mm and y = 50 mm, both at z = -50 mm.
    for (point, side) in [("node 401", -0.5), ("node 406", 0.5)] {
        let u = &s["points"][point]["displacement"];
        let (dy, dz) = (u[1].as_f64().unwrap(), u[2].as_f64().unwrap());
        for twist in [dy / (0.5 * width), dz / (side * width)] {
            assert!((twist / bredt - 1.0).abs() < 3e-3, "{twist} {bredt}");
            assert!((twist / walls - 1.0).abs() < 2e-3, "{twist} {walls}");
            assert!((twist / 6.183300e-3 - 1.0).abs() < 2e-3, "{twist}");
        }
    }
}

#[test]
#[ignore = "long"]
fn a_converted_bulk_data_file_gives_the_same_results() {
    let folder = tempfile::tempdir().unwrap();
    let (model, out) = (folder.path().join("model.toml"), folder.path().join("out"));
    let converted = tegula(&["convert", text(&example("box_beam.bdf")), text(&model)]);
    assert!(converted.status.success(), "{}", errors(&converted));
    assert!(errors(&converted).contains("without effect: ECHO (line "), "{}", errors(&converted));
    let run = tegula(&["run", text(&model), "--out", text(&out), "--quiet"]);
    assert!(run.status.success(), "{}", errors(&run));
    assert_eq!(summary(&out)["points"], result_of("box_beam.bdf")["points"]);
}

/// Linear statics does not depend on the loads before: each subcase of one file gives what a file of its own gives.
#[test]
#[ignore = "long"]
fn subcases_of_linear_statics_are_independent() {
    const BULK: &str = "GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,2.,0.,0.\nGRID,4,,0.,1.,0.\nGRID,5,,1.,1.,0.\nGRID,6,,2.,1.,0.\n\
        CQUAD4,1,3,1,2,5,4\nCQUAD4,2,3,2,3,6,5\nPSHELL,3,4,0.1,4,,4\nMAT1,4,210.+3,,0.3,7.85-9\nSPC1,1,123456,1,4\n\
        FORCE,2,3,,-2.,0.,0.,1.\nPLOAD4,3,1,1.,,,,THRU,2\nENDDATA\n";
    let folder = tempfile::tempdir().unwrap();
    let run = |name: &str, subcases: &str| {
        let (path, out) = (folder.path().join(name).with_extension("bdf"), folder.path().join(name));
        let control = format!("SOL 101\nCEND\nSPC = 1\nSET 1 = 3\nDISP = 1\n{subcases}BEGIN BULK\n{BULK}");
        std::fs::write(&path, control).unwrap();
        let run = tegula(&["run", text(&path), "--out", text(&out), "--quiet"]);
        assert!(run.status.success(), "{}", errors(&run));
        summary(&out)["points"]["node 3"]["displacement"][2].as_f64().unwrap()
    };
    let both = run("both", "SUBCASE 1\nLOAD = 2\nSUBCASE 2\nLOAD = 3\n");
    let alone = run("alone", "LOAD = 3\n");
    assert!((both / alone - 1.0).abs() < 1e-9, "{both} {alone}");
    // The pressure acts along the normal, upwards.
    assert!(alone > 0.0);
}

/// A strip of L = 10, width 0.5, thickness 0.1 under a force F = 0.01 at its end bends by F L³ / (3 E I), where E is the modulus along it:
/// E1 = 140 000 with the fibre along the strip, E2 = 10 000 across it. Of two plies the stiffer one below has the bending stiffness
/// D - B²/A, and as it is on the side in tension the middle of the strip gets shorter.
#[test]
#[ignore = "long"]
fn axes_of_materials_and_plies_of_bulk_data_files_bend_a_strip_as_beam_theory_says() {
    let folder = tempfile::tempdir().unwrap();
    let run = |name: &str, first: usize, theta: &str, property: &str| {
        let mut bulk = String::new();
        for (row, y) in [(0, "0."), (1, ".5")] {
            for i in 0..=20 {
                bulk += &format!("GRID,{},,{:.1},{y},0.\n", 21 * row + i + 1, 0.5 * i as f64);
            }
        }
        for i in 1..=20 {
            let mut nodes = [i, i + 1, i + 22, i + 21];
            nodes.rotate_left(first);
            let [a, b, c, d] = nodes;
            bulk += &format!("CQUAD4,{i},3,{a},{b},{c},{d},{theta}\n");
        }
        let (path, out) = (folder.path().join(name).with_extension("bdf"), folder.path().join(name));
        let deck = format!(
            "SOL 101\nCEND\nSPC = 1\nLOAD = 2\nSET 1 = 21\nDISP = 1\nBEGIN BULK\n{bulk}{property}\
             MAT8,4,140.+3,10.+3,0.,5.+3,5.+3,5.+3\nSPC1,1,123456,1,22\n\
             FORCE,2,21,,.005,0.,0.,1.\nFORCE,2,42,,.005,0.,0.,1.\nENDDATA\n"
        );
        std::fs::write(&path, deck).unwrap();
        let run = tegula(&["run", text(&path), "--out", text(&out), "--quiet"]);
        assert!(run.status.success(), "{}", errors(&run));
        summary(&out)["points"]["node 21"]["displacement"].clone()
    };
    let deflection = |stiffness: f64| 0.01 * 1000.0 / (3.0 * stiffness);
    let inertia = 0.5 * 0.1_f64.powi(3) / 12.0;
    let shell = "PSHELL,3,4,.1,4,,4\n";
    near(&run("along", 0, "0.", shell)[2], deflection(140e3 * inertia), 2e-3);
    near(&run("across", 0, "90.", shell)[2], deflection(10e3 * inertia), 2e-3);
    near(&run("corner", 1, "0.", shell)[2], deflection(10e3 * inertia), 2e-3);
    near(&run("turned", 1, "90.", shell)[2], deflection(140e3 * inertia), 2e-3);
    let layers = [(140e3, -0.05_f64, -0.02_f64), (10e3, -0.02, 0.05)];
    let moment = |k: i32| -> f64 {
        layers.iter().map(|(e, from, to)| e * (to.powi(k) - from.powi(k)) / f64::from(k)).sum()
    };
    let (a, b, d) = (moment(1), moment(2), moment(3));
    let u = run("plies", 0, "", "PCOMP,3\n,4,.03,0.,,4,.07,90.\n");
    near(&u[2], deflection(0.5 * (d - b * b / a)), 2e-3);
    assert!(u[0].as_f64().unwrap() < 0.0, "{u}");
}
