use std::collections::BTreeMap;

use proptest::prelude::*;

use super::*;
use crate::Vec3;
use crate::mesh::facet::Facet;
use crate::mesh::quality::check;
use crate::model::{ExtrusionMesh, MeshFile};

fn plate_source(grid: Grid) -> PlateMesh {
    PlateMesh {
        origin: [1.0, 2.0, 3.0],
        u_axis: [2.0, 0.0, 0.0],
        v_axis: [0.0, 0.0, 5.0],
        size: [4.0, 2.0],
        grid,
    }
}

fn cylinder_source(angles: [f64; 2], grid: Grid) -> CylinderMesh {
    CylinderMesh {
        center: [0.0; 3],
        axis: [0.0, 1.0, 0.0],
        start: [0.0, 0.7, 2.0],
        radius: 3.0,
        angles,
        length: 5.0,
        grid,
    }
}

fn annulus_source(angles: [f64; 2], grid: Grid) -> AnnulusMesh {
    AnnulusMesh { center: [0.0; 3], radii: [6.0, 10.0], angles, grid }
}

fn sphere_source(longitudes: [f64; 2], latitudes: [f64; 2], grid: Grid) -> SphereMesh {
    SphereMesh { center: [0.0; 3], radius: 10.0, longitudes, latitudes, grid }
}

fn extrusion_source(vertices: &[[f64; 3]], grid: Grid) -> ExtrusionMesh {
    ExtrusionMesh { vertices: vertices.to_vec(), sweep: [0.0, 0.0, 2.0], grid }
}

const L: [[f64; 3]; 3] = [[0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [3.0, 1.0, 0.0]];
const SQUARE: [[f64; 3]; 5] =
    [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 0.0]];

fn mesh(source: MeshSource) -> Mesh {
    let mesh = generate(&source).unwrap();
    assert_eq!(check(&mesh), []);
    // exact normals agree with the facets
    for (quad, normals) in mesh.quads.iter().zip(mesh.normals.as_ref().unwrap()) {
        let facet = Facet::of(&mesh, quad).unwrap();
        for normal in normals {
            assert!((normal.norm() - 1.0).abs() < 1e-14);
            assert!(facet.area_vector().dot(normal) > 0.0);
        }
    }
    mesh
}

fn area(mesh: &Mesh) -> f64 {
    mesh.quads.iter().map(|quad| Facet::of(mesh, quad).unwrap().area_vector().norm()).sum()
}

fn sizes(mesh: &Mesh) -> BTreeMap<&str, usize> {
    mesh.node_sets.iter().map(|(name, nodes)| (name.as_str(), nodes.len())).collect()
}

#[test]
fn plate_is_numbered_u_fastest() {
    let mesh = mesh(MeshSource::Plate(plate_source(Grid::uniform(2, 2))));
    assert_eq!(mesh.quads, [[0, 1, 4, 3], [1, 2, 5, 4], [3, 4, 7, 6], [4, 5, 8, 7]]);
    assert_eq!(mesh.positions[4], Vec3::new(3.0, 2.0, 4.0));
    assert_eq!(mesh.positions[8], Vec3::new(5.0, 2.0, 5.0));
    assert!((area(&mesh) - 8.0).abs() < 1e-14);
    assert!(mesh.normals.unwrap().iter().flatten().all(|&normal| normal == -Vec3::y()));
    for (name, nodes) in [
        ("u_min", vec![0, 3, 6]),
        ("u_max", vec![2, 5, 8]),
        ("v_min", vec![0, 1, 2]),
        ("v_max", vec![6, 7, 8]),
        ("u_min_v_min", vec![0]),
        ("u_max_v_min", vec![2]),
        ("u_max_v_max", vec![8]),
        ("u_min_v_max", vec![6]),
        ("middle", vec![4]),
    ] {
        assert_eq!(mesh.node_sets[name], nodes, "{name}");
    }
    assert_eq!(mesh.edge_sets["u_max"], [[2, 5], [5, 8]]);
    assert_eq!(mesh.edge_sets["v_max"], [[7, 6], [8, 7]]);
}

#[test]
fn edge_sets_are_the_boundary_in_its_own_direction() {
    let mesh = mesh(MeshSource::Sphere(sphere_source([0.0, 90.0], [0.0, 72.0], Grid::uniform(3, 4))));
    let mut named: Vec<[u32; 2]> = mesh.edge_sets.values().flatten().copied().collect();
    named.sort_by_key(|&[a, b]| (a.min(b), a.max(b)));
    assert_eq!(named, mesh.boundary_edges());
}

#[test]
fn skew_plate_is_a_parallelogram() {
    let source = PlateMesh { v_axis: [1.0, 0.0, 1.0], ..plate_source(Grid::uniform(3, 2)) };
    assert!((area(&mesh(MeshSource::Plate(source))) - 8.0 * 0.5f64.sqrt()).abs() < 1e-13);
}

#[test]
fn grading_is_the_ratio_of_last_to_first() {
    let grid = Grid { grading: [4.0, 0.5], ..Grid::uniform(5, 3) };
    let mesh = mesh(MeshSource::Plate(plate_source(grid)));
    let side = |a: usize, b: usize| (mesh.positions[b] - mesh.positions[a]).norm();
    assert!((side(4, 5) / side(0, 1) - 4.0).abs() < 1e-12);
    assert!((side(12, 18) / side(0, 6) - 0.5).abs() < 1e-12);
    // u = 0.5 lies nearest to the fifth column, v = 0.5 to the second row
    assert_eq!(mesh.node_sets["middle"], [9]);
}

#[test]
fn cylinder_follows_its_angles() {
    for (angles, sign) in [([0.0, -90.0], -1.0), ([-90.0, 0.0], 1.0), ([20.0, 300.0], 1.0)] {
        let mesh = mesh(MeshSource::Cylinder(cylinder_source(angles, Grid::uniform(8, 2))));
        for (quad, normals) in mesh.quads.iter().zip(mesh.normals.as_ref().unwrap()) {
            for (&node, normal) in quad.iter().zip(normals) {
                let mut radial = mesh.positions[node as usize];
                radial.y = 0.0;
                assert!((radial / 3.0 * sign - normal).norm() < 1e-15);
            }
        }
    }
    let mesh = mesh(MeshSource::Cylinder(cylinder_source([0.0, 90.0], Grid::uniform(2, 1))));
    // right-handed about y: from z to x
    assert_eq!(mesh.positions[0], Vec3::new(0.0, 0.0, 3.0));
    assert_eq!(mesh.positions[2], Vec3::new(3.0, 0.0, 0.0));
    assert_eq!(mesh.positions[5], Vec3::new(3.0, 5.0, 0.0));
}

#[test]
fn areas_converge_quadratically() {
    let quarter = std::f64::consts::FRAC_PI_2;
    let cap = 72f64.to_radians().sin();
    type Make = fn(Grid) -> MeshSource;
    let shapes: [(Make, f64); 4] = [
        (|grid| MeshSource::Cylinder(cylinder_source([0.0, -90.0], grid)), quarter * 3.0 * 5.0),
        (|grid| MeshSource::Cylinder(cylinder_source([0.0, 360.0], grid)), 4.0 * quarter * 3.0 * 5.0),
        (|grid| MeshSource::Annulus(annulus_source([0.0, 360.0], grid)), 2.0 * quarter * (100.0 - 36.0)),
        (|grid| MeshSource::Sphere(sphere_source([0.0, 90.0], [0.0, 72.0], grid)), quarter * 100.0 * cap),
    ];
    for (make, exact) in shapes {
        let [coarse, fine] = [8, 16].map(|n| area(&mesh(make(Grid::uniform(n, n)))) - exact);
        assert!(coarse < 0.0 && (coarse / fine - 4.0).abs() < 0.1, "{coarse} {fine}");
    }
}

#[test]
fn full_cylinder_joins_its_ends_and_annulus_keeps_a_slit() {
    let tube = mesh(MeshSource::Cylinder(cylinder_source([90.0, 450.0], Grid::uniform(6, 2))));
    assert_eq!(tube.positions.len(), 18);
    assert_eq!(tube.quads[5], [5, 0, 6, 11]);
    assert_eq!(sizes(&tube), BTreeMap::from([("v_min", 6), ("v_max", 6), ("middle", 1)]));
    assert_eq!(tube.edge_sets.len(), 2);
    assert_eq!(tube.boundary_edges().len(), 12);

    let ring = mesh(MeshSource::Annulus(annulus_source([0.0, 360.0], Grid::uniform(2, 8))));
    assert_eq!(ring.positions.len(), 27);
    assert_eq!(ring.positions[0], ring.positions[24]);
    assert_eq!((ring.node_sets["v_min"].len(), ring.node_sets["u_min"].len()), (3, 9));
    assert!(ring.normals.unwrap().iter().flatten().all(|&normal| normal == Vec3::z()));

    let belt = mesh(MeshSource::Sphere(sphere_source([0.0, -360.0], [-30.0, 40.0], Grid::uniform(5, 3))));
    assert_eq!(belt.positions.len(), 20);
}

#[test]
fn folded_sheet_has_nodes_at_vertices_and_a_normal_for_each_side() {
    let mesh = mesh(MeshSource::Extrusion(extrusion_source(&L, Grid::uniform(8, 2))));
    assert_eq!(mesh.positions[6], Vec3::new(3.0, 0.0, 0.0));
    assert_eq!(mesh.positions[8], Vec3::new(3.0, 1.0, 0.0));
    assert!((area(&mesh) - 8.0).abs() < 1e-14);
    let normals = mesh.normals.as_ref().unwrap();
    assert_eq!(normals[5], [-Vec3::y(); 4]);
    assert_eq!(normals[6], [Vec3::x(); 4]);
    assert_eq!(mesh.node_sets["middle"], [9 + 4]);
    let two = generate(&MeshSource::Extrusion(extrusion_source(&L, Grid::uniform(1, 1)))).unwrap();
    assert_eq!(two.quads.len(), 2);
}

#[test]
fn graded_polyline_is_graded_as_a_whole() {
    let straight = [[0.0; 3], [1.0, 0.0, 0.0], [3.0, 0.0, 0.0], [7.0, 0.0, 0.0]];
    // sizes 1, 2, 4 put every node on a vertex
    let grid = Grid { grading: [4.0, 1.0], ..Grid::uniform(3, 1) };
    let coarse = mesh(MeshSource::Extrusion(extrusion_source(&straight, grid)));
    assert_eq!(coarse.positions[..4], straight.map(Vec3::from));
    let grid = Grid { grading: [4.0, 1.0], ..Grid::uniform(30, 1) };
    let fine = mesh(MeshSource::Extrusion(extrusion_source(&straight, grid)));
    let steps: Vec<f64> = fine.positions[..31].windows(2).map(|ends| (ends[1] - ends[0]).norm()).collect();
    assert!((steps[29] / steps[0] / 4.0 - 1.0).abs() < 0.2, "{steps:?}");
}

#[test]
fn square_tube_is_closed() {
    let tube = mesh(MeshSource::Extrusion(extrusion_source(&SQUARE, Grid::uniform(8, 3))));
    assert_eq!(tube.positions.len(), 32);
    assert_eq!(tube.boundary_edges().len(), 16);
    assert_eq!(sizes(&tube), BTreeMap::from([("v_min", 8), ("v_max", 8), ("middle", 1)]));
    assert!((area(&tube) - 8.0).abs() < 1e-14);
}

#[test]
fn distortion_moves_inner_nodes_within_the_surface() {
    let grid = |seed| Grid { distortion: 0.4, seed, ..Grid::uniform(6, 5) };
    let source = |grid| MeshSource::Cylinder(cylinder_source([0.0, 70.0], grid));
    let [plain, one, again, other] =
        [Grid::uniform(6, 5), grid(1), grid(1), grid(2)].map(|grid| mesh(source(grid)));
    assert_eq!(one.positions, again.positions);
    assert_ne!(one.positions, other.positions);
    let boundary: Vec<u32> = one.edge_sets.values().flatten().flatten().copied().collect();
    for node in 0..plain.positions.len() {
        let moved = one.positions[node] != plain.positions[node];
        assert_eq!(moved, !boundary.contains(&(node as u32)), "node {node}");
        let x = one.positions[node];
        assert!((x.x.hypot(x.z) - 3.0).abs() < 1e-14);
    }
}

#[test]
fn distortion_keeps_folds_straight_and_tubes_closed() {
    let grid = Grid { distortion: 0.4, seed: 5, ..Grid::uniform(12, 6) };
    let tube = mesh(MeshSource::Extrusion(extrusion_source(&SQUARE, grid.clone())));
    assert!((area(&tube) - 8.0).abs() < 1e-13);
    let corners = |x: &&Vec3| (x.x == 0.0 || x.x == 1.0) && (x.y == 0.0 || x.y == 1.0);
    assert_eq!(tube.positions.iter().filter(corners).count(), 4 * 7);
    mesh(MeshSource::Cylinder(cylinder_source([0.0, 360.0], grid)));
}

#[test]
fn points_are_named() {
    let mut grid = Grid::uniform(4, 2);
    grid.points.insert("tip".into(), [5.1, 2.0, 4.9]);
    let found = mesh(MeshSource::Plate(plate_source(grid.clone())));
    assert_eq!(found.node_sets["tip"], [14]);
    grid.points.insert("nowhere".into(), [50.0, 0.0, 0.0]);
    grid.points.insert("middle".into(), [3.0, 2.0, 4.0]);
    let source = MeshSource::Plate(plate_source(grid));
    assert_eq!(keys(&source), ["mesh.grid.points.middle", "mesh.grid.points.nowhere"]);
}

/// Keys of all issues.
fn keys(source: &MeshSource) -> Vec<String> {
    match generate(source) {
        Err(Error::Model(issues)) => {
            for issue in &issues {
                assert!(!issue.message.is_empty() && !issue.help.is_empty());
            }
            issues.into_iter().map(|issue| issue.place.key).collect()
        }
        other => panic!("no model error: {other:?}"),
    }
}

#[test]
fn everything_wrong_with_a_plate_is_said_at_once() {
    let source = PlateMesh {
        origin: [0.0, f64::NAN, 0.0],
        u_axis: [0.0; 3],
        v_axis: [f64::INFINITY, 0.0, 0.0],
        size: [0.0, -1.0],
        grid: Grid { elements: [0, 3], grading: [0.0, f64::NAN], distortion: 0.5, ..Grid::uniform(1, 1) },
    };
    let expected = [
        "mesh.grid.elements",
        "mesh.grid.grading",
        "mesh.grid.grading",
        "mesh.grid.distortion",
        "mesh.origin",
        "mesh.u_axis",
        "mesh.v_axis",
        "mesh.size",
        "mesh.size",
    ];
    assert_eq!(keys(&MeshSource::Plate(source)), expected);
    let parallel = PlateMesh { v_axis: [-3.0, 0.0, 0.0], ..plate_source(Grid::uniform(1, 1)) };
    assert_eq!(keys(&MeshSource::Plate(parallel)), ["mesh.v_axis"]);
    let many = plate_source(Grid::uniform(50_001, 1000));
    assert_eq!(keys(&MeshSource::Plate(many)), ["mesh.grid.elements"]);
    let most = plate_source(Grid::uniform(u32::MAX, u32::MAX));
    assert_eq!(keys(&MeshSource::Plate(most)), ["mesh.grid.elements"]);
}

#[test]
fn wrong_curved_shapes_are_refused() {
    let one = || Grid::uniform(4, 4);
    let bad = CylinderMesh { radius: -1.0, length: f64::NAN, ..cylinder_source([30.0, 30.0], one()) };
    assert_eq!(keys(&MeshSource::Cylinder(bad)), ["mesh.radius", "mesh.length", "mesh.angles"]);
    let bad = CylinderMesh { start: [0.0, 5.0, 0.0], ..cylinder_source([0.0, 90.0], one()) };
    assert_eq!(keys(&MeshSource::Cylinder(bad)), ["mesh.start"]);
    for angles in [[0.0, 400.0], [f64::NEG_INFINITY, 0.0], [f64::NAN, 3.0]] {
        assert_eq!(keys(&MeshSource::Cylinder(cylinder_source(angles, one()))), ["mesh.angles"]);
    }
    let coarse = cylinder_source([0.0, 360.0], Grid::uniform(2, 4));
    assert_eq!(keys(&MeshSource::Cylinder(coarse)), ["mesh.grid.elements"]);
    for radii in [[2.0, 1.0], [1.0, 1.0]] {
        let bad = AnnulusMesh { radii, ..annulus_source([0.0, 90.0], one()) };
        assert_eq!(keys(&MeshSource::Annulus(bad)), ["mesh.radii"]);
    }
    let bad = AnnulusMesh { radii: [0.0, 1.0], ..annulus_source([0.0, 0.0], one()) };
    assert_eq!(keys(&MeshSource::Annulus(bad)), ["mesh.radii", "mesh.angles"]);
    let pole = sphere_source([0.0, 90.0], [0.0, 90.0], one());
    assert_eq!(keys(&MeshSource::Sphere(pole)), ["mesh.latitudes"]);
    let bad = SphereMesh { radius: 0.0, ..sphere_source([5.0, 5.0], [-91.0, 92.0], one()) };
    let expected = ["mesh.radius", "mesh.longitudes", "mesh.latitudes", "mesh.latitudes"];
    assert_eq!(keys(&MeshSource::Sphere(bad)), expected);
}

#[test]
fn wrong_polylines_are_refused() {
    let bad =
        |vertices: &[[f64; 3]]| keys(&MeshSource::Extrusion(extrusion_source(vertices, Grid::uniform(4, 2))));
    assert_eq!(bad(&[]), ["mesh.vertices"]);
    assert_eq!(bad(&L[..1]), ["mesh.vertices"]);
    assert_eq!(bad(&[L[0], [f64::NAN, 0.0, 0.0]]), ["mesh.vertices[1]"]);
    assert_eq!(bad(&[L[0], L[1], L[1], L[2]]), ["mesh.vertices[2]"]);
    assert_eq!(bad(&[L[0], L[0]]), ["mesh.vertices[1]"]);
    assert_eq!(bad(&[L[0], L[1], L[0]]), ["mesh.vertices"]);
    assert_eq!(bad(&[L[0], L[1], [1.0, 0.0, 0.0]]), ["mesh.vertices[1]"]);
    // a lollipop: its stick and its ring would not be joined
    assert_eq!(bad(&[[-1.0, 0.0, 0.0], L[0], L[1], L[2], L[0]]), ["mesh.vertices[4]"]);
    assert_eq!(bad(&[L[0], [0.0, 0.0, 1.0], L[1]]), ["mesh.sweep"]);
    // whatever the offset, only vertices that coincide are refused
    let far = L.map(|x| [x[0] + 1e12, x[1], x[2]]);
    mesh(MeshSource::Extrusion(extrusion_source(&far, Grid::uniform(4, 2))));
    let still = ExtrusionMesh { sweep: [0.0; 3], ..extrusion_source(&L, Grid::uniform(1, 0)) };
    assert_eq!(keys(&MeshSource::Extrusion(still)), ["mesh.grid.elements", "mesh.sweep"]);
    let all = ExtrusionMesh { sweep: [0.0; 3], ..extrusion_source(&[L[0], L[0]], Grid::uniform(1, 1)) };
    assert_eq!(keys(&MeshSource::Extrusion(all)), ["mesh.sweep", "mesh.vertices[1]"]);
}

#[test]
fn gmsh_files_are_read_elsewhere() {
    let source = MeshSource::Gmsh(MeshFile::new("part.msh"));
    assert_eq!(keys(&source), ["mesh.file"]);
}

proptest! {
    #[test]
    fn polylines_keep_their_vertices_and_area(
        steps in prop::collection::vec((0.1f64..3.0, -1.5f64..1.5), 1..8),
        nu in 1u32..30, ratio in 0.2f64..5.0, distortion in 0.0f64..=0.4, scale in -9i32..9,
    ) {
        let scale = 10f64.powi(scale);
        let (mut vertices, mut length) = (vec![[0.0; 3]], 0.0);
        let mut x = Vec3::zeros();
        for (step, angle) in steps {
            x += Vec3::new(angle.cos(), angle.sin(), 0.0) * step * scale;
            length += step * scale;
            vertices.push([x.x, x.y, x.z]);
        }
        let grid = Grid { grading: [ratio, 1.0], distortion, ..Grid::uniform(nu, 3) };
        let sweep = [0.0, 0.0, scale];
        let mesh = mesh(MeshSource::Extrusion(ExtrusionMesh { vertices: vertices.clone(), sweep, grid }));
        prop_assert!((area(&mesh) / (length * scale) - 1.0).abs() < 1e-10);
        for vertex in vertices {
            prop_assert!(mesh.positions.contains(&Vec3::from(vertex)));
        }
    }

    #[test]
    fn any_numbers_give_a_mesh_or_issues(
        numbers in prop::array::uniform8(prop_oneof![
            -500.0f64..500.0, Just(0.0), Just(90.0), Just(360.0), Just(f64::NAN), Just(1e300), Just(1e-300)
        ]),
        elements in prop::array::uniform2(0u32..6),
    ) {
        let [a, b, c, d, e, f, g, h] = numbers;
        let grid = Grid { grading: [a, b], distortion: c, ..Grid { elements, ..Grid::uniform(1, 1) } };
        for grid in [grid, Grid { elements, ..Grid::uniform(1, 1) }] {
            let g1 = || grid.clone();
            let cylinder =
                CylinderMesh { axis: [a, b, c], start: [c, d, e], radius: f, length: g, ..cylinder_source([a, h], g1()) };
            let vertices = [[a, b, c], [b, c, d], [e, f, g], [g, h, a]];
            for source in [
                MeshSource::Plate(PlateMesh { u_axis: [a, b, c], v_axis: [d, e, f], size: [g, h], ..plate_source(g1()) }),
                MeshSource::Cylinder(cylinder),
                MeshSource::Annulus(AnnulusMesh { radii: [a, b], ..annulus_source([c, d], g1()) }),
                MeshSource::Sphere(SphereMesh { radius: e, ..sphere_source([a, b], [c, d], g1()) }),
                MeshSource::Extrusion(ExtrusionMesh { sweep: [h, a, b], ..extrusion_source(&vertices, g1()) }),
            ] {
                if let Err(error) = generate(&source) {
                    let Error::Model(issues) = error else { panic!("{error}") };
                    prop_assert!(!issues.is_empty());
                }
            }
        }
    }
}
