//! Examples and runs of equilibrium paths: branches, steps behind paths, statics that go on along a path.

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;

use super::{errors, example, results_of, summary, tegula, text};

/// Columns of a history.
fn rows(folder: &Path, columns: &[&str]) -> Vec<Vec<f64>> {
    let history = fs::read_to_string(folder.join("history.csv")).unwrap();
    let mut lines = history.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let head = lines.next().unwrap();
    let columns: Vec<usize> =
        columns.iter().map(|name| head.iter().position(|c| c == name).unwrap()).collect();
    lines.map(|line| columns.iter().map(|&c| line[c].parse().unwrap()).collect()).collect()
}

/// Folder of results of a model, whose run succeeds.
fn completed(folder: &Path, name: &str, model: &str) -> PathBuf {
    let (file, out) = (folder.join(format!("{name}.toml")), folder.join(name));
    fs::write(&file, model).unwrap();
    let run = tegula(&["run", text(&file), "--out", text(&out), "--quiet"]);
    assert!(run.status.success(), "{name}: {}", errors(&run));
    out
}

/// Displacement along z of a point at the end of a run.
fn deflection(out: &Path, point: &str) -> f64 {
    summary(out)["points"][point]["displacement"][2].as_f64().unwrap()
}

/// Bifurcations and limit point of Pi, Bradford and Uy; the branches connect both bifurcations, where the asymmetric shapes begin and end.
#[test]
#[ignore = "long"]
fn branches_of_the_arch_connect_its_bifurcations() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let run = |more: &[&str]| {
        let file = example("arch_branches.toml");
        let arguments = [&["run", text(&file), "--out", text(&out), "--quiet"], more].concat();
        let run = tegula(&arguments);
        assert!(run.status.success(), "{}", errors(&run));
        errors(&run)
    };
    assert_eq!(run(&[]), "");
    let s = summary(&out);
    let loads: Vec<f64> =
        s["critical_points"].as_array().unwrap().iter().map(|p| p["load_factor"].as_f64().unwrap()).collect();
    for (i, exact) in [(0, 1.21066), (1, 1.98173), (3, -0.52881)] {
        assert!((3.0 * loads[i] / exact - 1.0).abs() < 5e-3, "{loads:?} {exact}");
    }
    let branches = s["branches"].as_array().unwrap();
    let numbers: Vec<i64> = branches.iter().map(|b| b["bifurcation"].as_i64().unwrap()).collect();
    assert_eq!(numbers, [1, -1, 2, -2]);
    let mut sides = Vec::new();
    for branch in branches {
        assert_eq!(branch["status"], "complete");
        let end = branch["load_factor"].as_f64().unwrap();
        let own = if branch["bifurcation"].as_i64().unwrap().abs() == 1 { 0 } else { 3 };
        // It is closed: at one of the bifurcations it ends.
        assert!([0, 3].iter().any(|&i| (end / loads[i] - 1.0).abs() < 1e-6), "{branch}");
        // Behind the bifurcation the top leaves the plane of symmetry, unstable but at the bifurcations, and no load is above.
        let place = out.join(branch["folder"].as_str().unwrap());
        let start = s["critical_points"][own]["position"].as_f64().unwrap();
        let rows = rows(&place, &["path.position", "time", "top.ux", "path.negative_eigenvalues"]);
        let behind: Vec<&Vec<f64>> = rows.iter().filter(|row| row[0] > start * (1.0 + 1e-9)).collect();
        assert!(behind.len() > 10);
        assert!(behind.iter().all(|row| row[1] < loads[0] + 1e-6 && row[1] > loads[3] - 1e-6), "{branch}");
        let unstable = behind.iter().filter(|row| row[3] == 1.0).count();
        assert!(unstable * 10 > behind.len() * 8, "{unstable} of {}", behind.len());
        sides.push(behind[..5].iter().map(|row| row[2]).sum::<f64>());
        let sideways = behind.iter().map(|row| row[2].abs()).fold(0.0, tegula::norm::larger);
        assert!(sideways > 5e-4, "{sideways}");
    }
    for pair in sides.chunks(2) {
        assert!(pair[0] * pair[1] < 0.0 && (pair[0] + pair[1]).abs() < 0.1 * pair[0].abs(), "{sides:?}");
    }
    let picture = fs::metadata(out.join("load_displacement.png")).unwrap().len();
    assert!(picture > 10_000, "{picture}");
    // A branch is resumed with its path only.
    let alone = tegula(&[
        "run",
        text(&example("arch_branches.toml")),
        "--out",
        text(&out.join("branch-1")),
        "--resume",
    ]);
    assert!(!alone.status.success() && errors(&alone).contains("branch of the run"), "{}", errors(&alone));
    // A run that was interrupted in a branch goes on there.
    let mut left = s.clone();
    left["branches"][2]["status"] = Value::from("running");
    left["branches"][3]["status"] = Value::Null;
    fs::write(out.join("summary.json"), left.to_string()).unwrap();
    fs::remove_dir_all(out.join("branch-2-other-side")).unwrap();
    fs::remove_file(out.join("branch-2/summary.json")).unwrap();
    run(&["--resume"]);
    let again = summary(&out);
    assert_eq!(again["branches"], s["branches"]);
    let complete = tegula(&["run", text(&example("arch_branches.toml")), "--out", text(&out), "--resume"]);
    assert!(errors(&complete).contains("nothing to resume"), "{}", errors(&complete));
    // A new run clears those of the one before.
    let fewer = fs::read_to_string(example("arch_branches.toml"))
        .unwrap()
        .replace("branches = \"all\"", "branches = 1");
    let file = folder.path().join("fewer.toml");
    fs::write(&file, fewer).unwrap();
    let run = tegula(&["run", text(&file), "--out", text(&out), "--quiet", "--force"]);
    assert!(run.status.success(), "{}", errors(&run));
    assert_eq!(summary(&out)["branches"].as_array().unwrap().len(), 2);
    assert!(out.join("branch-1").exists() && !out.join("branch-2").exists());
    // Words other than "all" are refused.
    let wrong = fs::read_to_string(&file).unwrap().replace("branches = 1", "branches = \"every\"");
    fs::write(&file, wrong).unwrap();
    let run = tegula(&["check", text(&file)]);
    assert!(errors(&run).contains("analysis.branches: unknown value \"every\""), "{}", errors(&run));
}

/// The limit point of Pi, Bradford and Uy; the motion under 101 % of its load ends where statics along the path end under this load.
#[test]
#[ignore = "long"]
fn the_arch_snaps_to_the_equilibrium_beyond_its_limit_point() {
    let (folder, out) = results_of("arch_snap.toml");
    let path = rows(&out.join("1-to_the_limit_point"), &["time", "top.uz"]);
    let [limit, before] = path.last().unwrap()[..] else { unreachable!() };
    assert!((10.0 * limit / 7.38452 - 1.0).abs() < 5e-3, "{limit}");
    let motion = rows(&out.join("2-snap"), &["time", "top.uz", "load.traction.all.fz"]);
    assert!((motion[0][1] / before - 1.0).abs() < 1e-12 && motion.last().unwrap()[0] == 60.0);
    // Load of the limit point on the area of the arch.
    let force = -10.0 * limit * 0.4;
    assert!(motion.iter().all(|row| (row[2] / force - 1.0).abs() < 1e-2), "{force} {:?}", motion[0]);
    let rest = motion.last().unwrap()[1];
    assert!(rest < -0.1, "{rest}");

    let steps = fs::read_to_string(example("arch_snap.toml")).unwrap();
    let (head, tail) = (steps.find("[[steps]]").unwrap(), steps.find("[output]").unwrap());
    let load = format!("{:.17}]", -(10.0 * limit + 0.0738));
    let full = steps[..head].replace("-10.0]", &load);
    let statics = format!("{full}[analysis]\ntype = \"static\"\ncontinue = \"path\"\n{}", &steps[tail..]);
    let file = folder.path().join("statics.toml");
    fs::write(&file, &statics).unwrap();
    let out = folder.path().join("statics");
    let run = tegula(&["run", text(&file), "--out", text(&out), "--quiet"]);
    assert!(run.status.success() && run.stderr.is_empty(), "{}", errors(&run));
    let s = summary(&out);
    let along = s["points"]["top"]["displacement"][2].as_f64().unwrap();
    assert!((rest / along - 1.0).abs() < 2e-4, "{rest} {along}");
    assert_eq!(s["time"], 1.0);
    assert_eq!(s["critical_points"].as_array().unwrap().len(), 2);
    assert!(out.join("load_displacement.png").exists() && out.join("critical_modes.pvd").exists());
    let positions = rows(&out, &["path.position", "time"]);
    assert!(positions.windows(2).all(|pair| pair[0][0] < pair[1][0]));
    assert!(positions.windows(2).any(|pair| pair[0][1] > pair[1][1] + 0.01), "the load has not fallen");
    let log = fs::read_to_string(out.join("log.txt")).unwrap();
    assert!(log.contains("goes on along the equilibrium path"), "{log}");

    // Without the key it is an error that names the limit point and the key.
    fs::write(&file, statics.replace("continue = \"path\"\n", "")).unwrap();
    let run = tegula(&["run", text(&file), "--out", text(&out), "--quiet", "--force"]);
    let message = errors(&run);
    assert!(!run.status.success() && message.contains("limit point"), "{message}");
    assert!(message.contains("continue = \"path\""), "{message}");
}

/// The truss of the example under 1.2 times its limit load: statics end beyond the snap, `2 k (L₀/L − 1) z = P`.
#[test]
fn statics_of_the_truss_go_on_to_the_full_load() {
    let model = fs::read_to_string(example("von_mises_truss.toml")).unwrap();
    let model = model.replace("type = \"path\"\nend_load = 1.5", "type = \"static\"\ncontinue = \"path\"");
    assert!(model.contains("continue"));
    let folder = tempfile::tempdir().unwrap();
    let (file, out) = (folder.path().join("truss.toml"), folder.path().join("out"));
    fs::write(&file, model.replace("-3.4999", "-4.1999")).unwrap();
    let run = tegula(&["run", text(&file), "--out", text(&out), "--quiet"]);
    assert!(run.status.success(), "{}", errors(&run));
    let last = rows(&out, &["time", "body.apex.z"]).pop().unwrap();
    let (b, k, z) = (2.0_f64, 300.0, last[1]);
    let load = 2.0 * k * (b.hypot(0.5) / b.hypot(z) - 1.0) * z;
    let wanted = fs::read_to_string(&file).unwrap();
    let value = wanted
        .split("value = [0.0, 0.0, -")
        .nth(1)
        .unwrap()
        .split(']')
        .next()
        .unwrap()
        .parse::<f64>()
        .unwrap();
    assert!(last[0] == 1.0 && z < -0.5 && (load / value - 1.0).abs() < 1e-9, "{last:?} {load} {value}");
}

/// Plate under a force along it, pressure, and a temperature that bends it: an imperfect bifurcation near half of the loads, behind which there
/// are stable shapes on the other side, too. Whatever the first load step and the method, the analysis ends where the path ends.
#[test]
#[ignore = "long"]
fn statics_stay_on_the_path_of_an_imperfect_plate() {
    let folder = tempfile::tempdir().unwrap();
    let end = |name: &str, analysis: &str, force: [f64; 3], pressure: f64, temperature: [f64; 2]| {
        let model = format!(
            r#"
            [analysis]
            {analysis}
            [mesh]
            type = "plate"
            size = [1.0, 0.2]
            grid = {{ elements = [6, 2] }}
            [materials.m]
            type = "isotropic"
            young = 1e7
            poisson = 0.3
            expansion = 1e-3
            [[sections]]
            material = "m"
            thickness = 0.02
            [[conditions]]
            type = "clamp"
            on = "u_min"
            [[conditions]]
            type = "prescribe"
            on = "u_max"
            component = "y"
            value = 0.000685
            [[loads]]
            type = "edge"
            on = "u_max"
            value = {force:?}
            [[loads]]
            type = "pressure"
            on = "all"
            value = {pressure}
            [[prescribed_strains]]
            type = "thermal"
            temperature = {}
            gradient = {}
            [output]
            points = [{{ name = "left", on = "u_max_v_min" }}, {{ name = "right", on = "u_max_v_max" }}]
            pictures = false
            "#,
            temperature[0], temperature[1]
        );
        let out = completed(folder.path(), name, &model);
        ["left", "right"].map(|point| deflection(&out, point))
    };
    let first = ([0.0685, 0.3425, 1.37], -3.425, [2.055, 205.5]);
    let second = ([0.497906, -0.988418, 3.63076], 5.50415, [2.50841, -183.594]);
    // Hardly any imperfection beside the heat: trials of the path pass the fold of the nearly crossing one.
    let third = ([-0.318707, -0.220034, -0.338754], 8.90691, [154.713, 179.032]);
    let fourth = ([-38.6186, -0.673665, 1.95318], 10.1073, [286.75, 386.725]);
    for (case, (force, pressure, temperature)) in [first, second, third, fourth].into_iter().enumerate() {
        let statics = [1, 2, 10].map(|steps| format!("type = \"static\"\nload_steps = {steps}"));
        let analyses = std::iter::once("type = \"path\"".to_owned()).chain(statics);
        let ends: Vec<[f64; 2]> = analyses
            .enumerate()
            .map(|(k, analysis)| end(&format!("{case}-{k}"), &analysis, force, pressure, temperature))
            .collect();
        let path = summary(&folder.path().join(format!("{case}-0")));
        assert_eq!(path["critical_points"].as_array().unwrap().len(), 0, "{case}");
        let size = tegula::norm::larger(ends[0][0].abs(), ends[0][1].abs());
        // On one side of the bifurcation the plate is twisted.
        assert!((ends[0][0] - ends[0][1]).abs() > 0.02 * size, "{ends:?}");
        for other in &ends[1..] {
            let apart = (0..2).map(|i| (other[i] - ends[0][i]).abs()).fold(0.0, tegula::norm::larger);
            assert!(apart < 1e-6 * size, "{case} {ends:?}");
        }
    }
}

/// Strip between hinges with an imperfection of 1 % of its thickness that a natural strain of many times the critical one, π²h²/(12 L²), bends up or
/// down: static analyses end on the side to which the path bends, although their first steps pass the bifurcation.
#[test]
#[ignore = "long"]
fn strained_strips_bend_to_the_side_of_their_imperfection() {
    let folder = tempfile::tempdir().unwrap();
    let strip = imperfect_strip(1e-4, "hinge", "[[conditions]]\ntype = \"hinge\"\non = \"u_max\"\n");
    let middle = |name: &str, analysis: &str, strain: f64| {
        let strained = format!("[[prescribed_strains]]\ntype = \"natural\"\nstrain = [{strain}, 0.0, 0.0]\n");
        let model = format!("[analysis]\n{analysis}\n{strip}{strained}");
        deflection(&completed(folder.path(), name, &model), "middle")
    };
    for (times, load_steps) in [(50.0, [1, 5].as_slice()), (300.0, &[20])] {
        let strain = times * std::f64::consts::PI.powi(2) * 1e-4 / 12.0;
        let path = middle(&format!("path-{times}"), "type = \"path\"", strain);
        // An inextensible strip of the length (1 + ε) L between the hinges rises by about 2/π √ε L.
        assert!((path.abs() / (2.0 / std::f64::consts::PI * strain.sqrt()) - 1.0).abs() < 0.05, "{path}");
        for steps in load_steps {
            let analysis = format!("type = \"static\"\nload_steps = {steps}");
            let end = middle(&format!("static-{times}-{steps}"), &analysis, strain);
            assert!((end / path - 1.0).abs() < 1e-6, "{steps}: {end} {path}");
        }
    }
}

/// Strip of 1 × 0.1 × 0.01 with a random imperfection of an amplitude, or straight, and supports at both ends: a model without its analysis and loads.
fn imperfect_strip(amplitude: f64, first: &str, last: &str) -> String {
    format!(
        r#"
        [mesh]
        type = "plate"
        size = [1.0, 0.1]
        grid = {{ elements = [20, 1] }}
        [materials.m]
        type = "isotropic"
        young = 1e9
        poisson = 0.0
        [[sections]]
        material = "m"
        thickness = 0.01
        {}
        [[conditions]]
        type = "{first}"
        on = "u_min"
        {last}
        [output]
        points = [{{ name = "middle", at = [0.5, 0.0, 0.0] }}]
        pictures = false
        "#,
        if amplitude == 0.0 { String::new() } else { imperfection(amplitude) }
    )
}

/// Random imperfection of an amplitude.
fn imperfection(amplitude: f64) -> String {
    format!(
        "[[imperfections]]\ntype = \"random\"\namplitude = {amplitude}\ncorrelation_length = 0.2\nseed = 3\n"
    )
}

/// Force on the right end of the strip per length, in Euler loads of the strip between hinges.
fn thrust(times: f64) -> String {
    let value = -times * std::f64::consts::PI.powi(2) * 1e3 / 12.0;
    format!("type = \"edge\"\non = \"u_max\"\nvalue = [{value}, 0.0, 0.0]\n")
}

/// Strip with an imperfection of 1e-5 of its thickness that is bent by 1.3 and 1.6 times the Euler load, and then pulled: its path turns next to the
/// bifurcation back to the straight shape, in which the same pull on the unloaded strip ends.
#[test]
#[ignore = "long"]
fn a_buckled_strip_straightens_again() {
    let folder = tempfile::tempdir().unwrap();
    let hinge = "[[conditions]]\ntype = \"fix\"\non = \"u_max\"\nposition = [\"y\", \"z\"]\n";
    let strip = imperfect_strip(1e-7, "hinge", hinge);
    for times in [1.3, 1.6] {
        let statics = format!("[analysis]\ntype = \"static\"\n{strip}[[loads]]\n{}", thrust(-times));
        let straight = deflection(&completed(folder.path(), &format!("pulled-{times}"), &statics), "middle");
        assert!(straight.abs() < 1e-8 && straight != 0.0, "{straight}");
        for method in ["series", "arc-length"] {
            let analysis = if method == "series" { "" } else { ", method = \"arc-length\"" };
            let step = |name: &str, load: f64| {
                format!(
                    "[[steps]]\nname = \"{name}\"\nanalysis = {{ type = \"path\"{analysis} }}\n[[steps.loads]]\n{}",
                    thrust(load)
                )
            };
            let model = format!("{strip}{}{}", step("buckled", times), step("pulled", -times));
            let out = completed(folder.path(), &format!("{method}-{times}"), &model);
            let [bent, back] = ["1-buckled", "2-pulled"].map(|step| deflection(&out.join(step), "middle"));
            assert!(bent.abs() > 0.3, "{bent}");
            assert!((back / straight - 1.0).abs() < 1e-6, "{method} {times}: {back} {straight}");
            let found = &summary(&out.join("2-pulled"))["critical_points"];
            assert_eq!(found.as_array().unwrap().len(), 0, "{method} {times}");
        }
    }
}

/// Clamped strip with imperfections of 1e-4 and 1e-5 of its thickness, 0.3 % above its buckling load, next to which displacements change much with the load:
/// power series, the arc-length method and static steps end in one equilibrium.
#[test]
#[ignore = "long"]
fn strips_next_to_their_buckling_load_end_in_one_equilibrium() {
    let folder = tempfile::tempdir().unwrap();
    // The Euler load of a cantilever, less its shear flexibility; G A = 5/12 E A.
    let euler = std::f64::consts::PI.powi(2) * 1e3 / 48.0;
    let times = 0.25 * 1.003 / (1.0 + euler / (5.0 / 12.0 * 1e7));
    for amplitude in [1e-6, 1e-7] {
        let strip = imperfect_strip(amplitude, "clamp", "");
        let load = thrust(times);
        let analyses = [
            ("series", "path", ""),
            ("arc-length", "path", "method = \"arc-length\""),
            ("1", "static", ""),
            ("3", "static", "load_steps = 3"),
        ];
        let ends = analyses.map(|(name, analysis, more)| {
            let model = format!("[analysis]\ntype = \"{analysis}\"\n{more}\n{strip}[[loads]]\n{load}");
            deflection(&completed(folder.path(), &format!("{name}-{amplitude}"), &model), "middle")
        });
        assert!(ends[1].abs() > 0.023, "{ends:?}");
        assert!(ends.iter().all(|end| (end / ends[1] - 1.0).abs() < 1e-6), "{amplitude}: {ends:?}");
    }
}

/// A straight clamped strip goes over to its crossing path by a jump of its deflection, and a stop condition within the jump ends the path behind it.
#[test]
fn stop_conditions_within_the_jump_to_a_crossing_path_end_behind_it() {
    let folder = tempfile::tempdir().unwrap();
    let strip = imperfect_strip(0.0, "clamp", "");
    for (method, value) in [("series", 2e-4), ("arc-length", 2e-4), ("arc-length", 1e-4)] {
        let analysis = format!(
            "[analysis]\ntype = \"path\"\nmethod = \"{method}\"\nend_load = 1.2\nswitch_at = [1]\n\
             stop = [{{ column = \"middle.uz\", value = {value} }}]\n"
        );
        let out = completed(
            folder.path(),
            &format!("{method}-{value}"),
            &format!("{analysis}{strip}[[loads]]\n{}", thrust(0.25)),
        );
        let s = summary(&out);
        let (reached, end) = (s["stop"]["reached"].as_f64().unwrap(), s["time"].as_f64().unwrap());
        assert!(reached > value && reached < 1e-3, "{method} {value}: {reached}");
        // The buckling load of a clamped strip is a quarter of the Euler load, less its shear flexibility.
        assert!((end - 1.0).abs() < 2e-3, "{end}");
    }
}

/// Plate of 1 × 0.5 × 0.003 between hinges with random imperfections of 0.017 of its thickness, under twice its critical load in three steps: the
/// first one passes the bifurcation, so that the path is followed from the unloaded plate.
#[test]
fn statics_of_an_unloaded_plate_end_where_its_path_ends() {
    let folder = tempfile::tempdir().unwrap();
    let [path, statics] = ["path", "static"].map(|analysis| {
        let steps = if analysis == "static" { "load_steps = 3" } else { "" };
        let hinges = ["u_max", "v_min", "v_max"]
            .map(|edge| format!("[[conditions]]\ntype = \"fix\"\non = \"{edge}\"\nposition = [\"z\"]\n"))
            .concat();
        let model = format!(
            r#"
            [analysis]
            type = "{analysis}"
            {steps}
            [mesh]
            type = "plate"
            size = [1.0, 0.5]
            grid = {{ elements = [12, 6] }}
            [materials.m]
            type = "isotropic"
            young = 1e9
            poisson = 0.3
            [[sections]]
            element = "mitc4"
            material = "m"
            thickness = 0.003
            [[imperfections]]
            type = "random"
            amplitude = 5.185e-5
            correlation_length = 0.2
            seed = 87
            [[conditions]]
            type = "fix"
            on = "u_min"
            position = ["x", "z"]
            {hinges}
            [[conditions]]
            type = "fix"
            on = "u_min_v_min"
            position = ["y"]
            [[loads]]
            type = "edge"
            on = "u_max"
            value = [-3904.5, 0.0, 0.0]
            [output]
            points = [{{ name = "middle", at = [0.5, 0.25, 0.0] }}, {{ name = "quarter", at = [0.25, 0.25, 0.0] }}]
            pictures = false
            "#
        );
        let out = completed(folder.path(), analysis, &model);
        ["middle", "quarter"].map(|point| deflection(&out, point))
    });
    let log = fs::read_to_string(folder.path().join("static/log.txt")).unwrap();
    assert!(log.contains("arc-length steps lead to its equilibrium"), "{log}");
    for (a, b) in path.iter().zip(&statics) {
        assert!(a.abs() > 0.003 && (a - b).abs() < 1e-6 * a.abs(), "{path:?} {statics:?}");
    }
}

/// Trusses of two springs side by side, with their rises and stiffnesses, springs between neighbours, and loads: a model without its analysis.
fn trusses(of: &[[f64; 2]], between: &[f64], loads: &[(usize, f64)]) -> String {
    let spring = |name: String, ends: [String; 2], [a, b]: [[f64; 3]; 2], stiffness: f64| {
        format!(
            "[[springs]]\nname = {name:?}\nbetween = {ends:?}\npoints = [{a:?}, {b:?}]\nstiffness = {stiffness}\n"
        )
    };
    let body = |k: usize| format!("b{k}");
    let top = |k: usize| [0.0, k as f64, of[k][0]];
    let mut model = String::from("[output]\npictures = false\n");
    for (k, [_, stiffness]) in of.iter().enumerate() {
        let (at, y) = (top(k), k as f64);
        model += &format!(
            "[[bodies]]\nname = \"b{k}\"\nat = {at:?}\nmass = 1.0\ninertia = [0.01, 0.01, 0.01]\n\
             [[joints]]\ntype = \"prismatic\"\nname = \"s{k}\"\nbetween = [\"ground\", \"b{k}\"]\nat = {at:?}\n\
             axis = [0.0, 0.0, 1.0]\n"
        );
        for (side, x) in [("left", -2.0), ("right", 2.0)] {
            model += &spring(format!("{side}{k}"), ["ground".into(), body(k)], [[x, y, 0.0], at], *stiffness);
        }
    }
    for (k, stiffness) in between.iter().enumerate() {
        model += &spring(format!("c{k}"), [body(k), body(k + 1)], [top(k), top(k + 1)], *stiffness);
    }
    for (k, force) in loads {
        model += &format!("[[loads]]\ntype = \"force\"\non = \"b{k}\"\nvalue = [0.0, 0.0, {force}]\n");
    }
    model
}

/// Of coupled trusses the softest one snaps at 0.1 % of the loads, or the pair at 97 %. One load step does not pass the limit point, and the refusal
/// tells its load factor, which is that of the path.
#[test]
fn one_load_step_does_not_pass_a_limit_point() {
    let folder = tempfile::tempdir().unwrap();
    let early = trusses(
        &[[0.109, 157.29], [0.463, 476.82], [0.769, 87.24]],
        &[1.14, 2.51],
        &[(0, -25.611), (2, -5.382)],
    );
    let late = trusses(&[[0.356, 24.6], [0.67, 44.5]], &[2.71], &[(0, -5.0)]);
    for (name, model, expected) in [("early", early, 1.1e-3), ("late", late, 0.973)] {
        let run = |analysis: &str| {
            let (file, out) =
                (folder.path().join(format!("{name}-{analysis}.toml")), folder.path().join(analysis));
            fs::write(&file, format!("[analysis]\ntype = \"{analysis}\"\n{model}")).unwrap();
            (tegula(&["run", text(&file), "--out", text(&out), "--quiet", "--force"]), out)
        };
        let (path, out) = run("path");
        assert!(path.status.success(), "{}", errors(&path));
        let limit = summary(&out)["critical_points"][0]["load_factor"].as_f64().unwrap();
        assert!((limit - expected).abs() < 0.05 * expected, "{name}: {limit}");
        let (refused, _) = run("static");
        let message = errors(&refused);
        assert!(!refused.status.success(), "{name}: the limit point is passed in silence");
        assert!(message.contains("limit point"), "{message}");
        let last = message.split("The last equilibrium was at load factor ").nth(1).unwrap();
        let last: f64 = last.split(". ").next().unwrap().parse().unwrap();
        assert!(last <= limit && last > 0.9 * limit, "{name}: {last} {limit}");
    }
}
