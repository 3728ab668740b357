use proptest::prelude::*;

use super::*;
use crate::mesh::generators::generate;
use crate::model::{CylinderMesh, ExtrusionMesh, Grid, MeshSource, SphereMesh};

fn directors(mesh: &Mesh) -> Directors {
    Directors::of(mesh, FOLD_ANGLE_DEGREES).unwrap()
}

fn tied(directors: &Directors) -> Vec<[u32; 2]> {
    directors.ties.iter().map(|tie| tie.directors).collect()
}

fn issues(mesh: &Mesh) -> Vec<Issue> {
    match Directors::of(mesh, FOLD_ANGLE_DEGREES) {
        Err(Error::Model(issues)) => issues,
        other => panic!("no model error: {other:?}"),
    }
}

fn from(positions: &[[f64; 3]], quads: &[[u32; 4]]) -> Mesh {
    Mesh {
        positions: positions.iter().map(|&x| Vec3::from(x)).collect(),
        quads: quads.to_vec(),
        ..Mesh::default()
    }
}

fn cylinder(angles: [f64; 2], nu: u32) -> Mesh {
    let source = CylinderMesh {
        center: [0.0; 3],
        axis: [0.0, 0.0, 1.0],
        start: [1.0, 0.0, 0.0],
        radius: 2.0,
        angles,
        length: 1.0,
        grid: Grid::uniform(nu, 3),
    };
    generate(&MeshSource::Cylinder(source)).unwrap()
}

fn extrusion(vertices: &[[f64; 3]], nu: u32) -> Mesh {
    let source =
        ExtrusionMesh { vertices: vertices.to_vec(), sweep: [0.0, 0.0, 2.0], grid: Grid::uniform(nu, 2) };
    generate(&MeshSource::Extrusion(source)).unwrap()
}

/// Both sheets of the plane stand on the edge 0–1, the web goes up (all y from 0 to 1):
/// ```text
///          5
///          |
///   2------0------4
/// ```
fn tee(left: [u32; 4], right: [u32; 4]) -> Mesh {
    let x = [
        [0.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [-1.0, 0.0, 0.0],
        [-1.0, 1.0, 0.0],
        [1.0, 0.0, 0.0],
        [0.0, 0.0, 1.0],
        [0.0, 1.0, 1.0],
        [1.0, 1.0, 0.0],
    ];
    from(&x, &[left, right, [0, 1, 6, 5]])
}

#[test]
fn exact_normals_become_directors() {
    for mesh in [cylinder([0.0, 90.0], 4), cylinder([0.0, -360.0], 20)] {
        let directors = directors(&mesh);
        assert!(directors.ties.is_empty());
        assert_eq!(directors.corners, mesh.quads);
        let nodes: Vec<u32> = (0..mesh.positions.len() as u32).collect();
        assert_eq!((&directors.node, &directors.first), (&nodes, &nodes));
        let sign = mesh.normals.as_ref().unwrap()[0][0].x.signum();
        for (director, x) in directors.values.iter().zip(&mesh.positions) {
            assert!((director - Vec3::new(x.x, x.y, 0.0) * (sign / 2.0)).norm() < 1e-15);
        }
    }
}

#[test]
fn coarse_facets_are_smooth_and_second_order() {
    let mut errors = Vec::new();
    for n in [8, 16] {
        let mut mesh = cylinder([0.0, 90.0], n);
        let exact = directors(&mesh);
        mesh.normals = None;
        let directors = directors(&mesh);
        assert_eq!(directors.corners, exact.corners);
        // inside, averaging is exact by symmetry; on the edge it is off by half a facet's angle
        let off = |node: usize| (directors.values[node] - exact.values[node]).norm();
        assert!(off(n as usize / 2) < 1e-14);
        errors.push(off(0));
    }
    assert!((errors[0] / errors[1] - 2.0).abs() < 0.01);

    let source = SphereMesh {
        center: [0.0; 3],
        radius: 1.0,
        longitudes: [0.0, 360.0],
        latitudes: [-60.0, 60.0],
        grid: Grid { distortion: 0.2, ..Grid::uniform(60, 21) },
    };
    let mut mesh = generate(&MeshSource::Sphere(source)).unwrap();
    mesh.normals = None;
    let directors = directors(&mesh);
    assert!(directors.ties.is_empty());
    for (director, x) in directors.values.iter().zip(&mesh.positions) {
        assert!(director.dot(x) > 0.998);
    }
}

#[test]
fn fold_has_two_tied_directors() {
    let mut mesh = extrusion(&[[0.0; 3], [3.0, 0.0, 0.0], [3.0, 1.0, 0.0]], 4);
    for _ in 0..2 {
        let directors = directors(&mesh);
        // nodes 3, 8, 13 lie on the fold
        assert_eq!(directors.values.len(), 15 + 3);
        assert_eq!(tied(&directors), [[3, 4], [9, 10], [15, 16]]);
        // The fold is two long and has two elements along it.
        assert_eq!(directors.ties.iter().map(|tie| tie.length).collect::<Vec<_>>(), [0.5, 1.0, 0.5]);
        assert_eq!(directors.first[..5], [0, 1, 2, 3, 5]);
        assert_eq!(directors.node[3..6], [3, 3, 4]);
        assert!((directors.values[3] + Vec3::y()).norm() < 1e-15);
        assert!((directors.values[4] - Vec3::x()).norm() < 1e-15);
        assert_eq!(directors.corners[2], [2, 3, 9, 8]);
        assert_eq!(directors.corners[3], [4, 5, 11, 10]);
        mesh.normals = None;
    }
    // a large enough fold angle makes it smooth
    let smooth = Directors::of(&mesh, 91.0).unwrap();
    assert!(smooth.ties.is_empty());
    assert!((smooth.values[3] - Vec3::new(1.0, -1.0, 0.0).normalize()).norm() < 1e-15);
}

#[test]
fn square_tube_is_tied_at_its_four_edges() {
    let corners = [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0], [0.0; 3]];
    let mesh = extrusion(&corners, 8);
    let directors = directors(&mesh);
    assert_eq!(directors.values.len(), 24 + 12);
    assert_eq!(directors.ties.len(), 12);
    for [a, b] in &tied(&directors) {
        assert_eq!(directors.node[*a as usize], directors.node[*b as usize]);
        assert!(directors.values[*a as usize].dot(&directors.values[*b as usize]).abs() < 1e-15);
    }
}

#[test]
fn junction_joins_the_flange_and_ties_the_web() {
    let mesh = tee([2, 0, 1, 3], [0, 4, 7, 1]);
    let directors = directors(&mesh);
    assert_eq!(tied(&directors), [[0, 1], [2, 3]]);
    assert_eq!(directors.values.len(), 10);
    assert_eq!(directors.corners[0][1], directors.corners[1][0]);
    assert!((directors.values[0] - Vec3::z()).norm() < 1e-15);
    assert!((directors.values[1] - Vec3::x()).norm() < 1e-15);
    // halves of the flange may face opposite sides: then each is tied to the web
    let directors = self::directors(&tee([2, 0, 1, 3], [0, 1, 7, 4]));
    assert_eq!(tied(&directors), [[0, 2], [1, 2], [3, 5], [4, 5]]);
}

#[test]
fn sheets_that_touch_at_a_node_share_a_director_if_parallel() {
    let mut x = [
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [1.0, 1.0, 0.0],
        [0.0, 1.0, 0.0],
        [2.0, 1.0, 0.0],
        [2.0, 2.0, 0.0],
        [1.0, 2.0, 0.0],
    ];
    let quads = [[0, 1, 2, 3], [2, 4, 5, 6]];
    assert!(directors(&from(&x, &quads)).ties.is_empty());
    (x[5][2], x[6][2]) = (1.0, 1.0);
    assert_eq!(tied(&directors(&from(&x, &quads))), [[2, 3]]);
}

#[test]
fn unused_nodes_have_no_director() {
    let x = [[5.0; 3], [0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    let directors = directors(&from(&x, &[[1, 2, 3, 4]]));
    assert_eq!(directors.first, [u32::MAX, 0, 1, 2, 3]);
    assert_eq!(directors.corners, [[0, 1, 2, 3]]);
}

#[test]
fn faults_are_errors() {
    let mut mesh = cylinder([0.0, 90.0], 4);
    mesh.quads[0].reverse();
    let found = issues(&mesh);
    assert_eq!(found.len(), 2, "{found:#?}");
    assert!(
        found[0].message.contains("elements 0 at") && found[0].message.contains("and 1 at"),
        "{}",
        found[0]
    );
    assert!(found[0].help.contains("flip"));

    let mut mesh = cylinder([0.0, 90.0], 2);
    if let Some(normals) = &mut mesh.normals {
        normals[1][2] = Vec3::zeros();
    }
    assert!(issues(&mesh)[0].message.contains("element 1 has no normal at node 5"));

    // a full turn of normals about a node, each within the angle of the next
    let n = 24;
    let ring = (0..2 * n).map(|k| {
        let angle = f64::from(k) * std::f64::consts::PI / f64::from(n);
        [angle.cos(), angle.sin(), 0.0]
    });
    let x: Vec<[f64; 3]> = [[0.0; 3]].into_iter().chain(ring).collect();
    let quads: Vec<[u32; 4]> = (0..n).map(|k| [0, 2 * k + 1, 2 * k + 2, (2 * k + 2) % (2 * n) + 1]).collect();
    let mut fan = from(&x, &quads);
    let outward = |quad: &[u32; 4]| [Vec3::from(x[quad[2] as usize]); 4];
    fan.normals = Some(quads.iter().map(outward).collect());
    let found = issues(&fan);
    assert_eq!(found.len(), 1);
    assert!(found[0].message.contains("node 0 at (0.0, 0.0, 0.0) cancel"), "{}", found[0]);

    assert!(issues(&Mesh::default())[0].message.contains("no quadrilaterals"));
    assert!(issues(&from(&[[0.0; 3]], &[[0, 1, 2, 3]]))[0].message.contains("element 0 has a node 3"));
    for angle in [0.0, -5.0, 200.0, f64::NAN] {
        assert!(Directors::of(&cylinder([0.0, 90.0], 2), angle).is_err());
    }
}

proptest! {
    #[test]
    fn order_and_orientation_of_quads_do_not_matter(seed in 0usize..1000, flip: bool, turn in 0usize..4) {
        let mut mesh = extrusion(&[[0.0; 3], [3.0, 0.0, 0.0], [3.0, 1.0, 0.0], [4.0, 1.2, 0.0]], 7);
        mesh.normals = None;
        let before = directors(&mesh);
        let shift = seed % mesh.quads.len();
        mesh.quads.rotate_left(shift);
        for quad in &mut mesh.quads {
            quad.rotate_left(turn);
            if flip {
                quad.reverse();
            }
        }
        let after = directors(&mesh);
        prop_assert_eq!(before.values.len(), after.values.len());
        let sign = if flip { -1.0 } else { 1.0 };
        let count = mesh.quads.len();
        for (e, quad) in mesh.quads.iter().enumerate() {
            let original = before.corners[(e + shift) % count];
            for (corner, &node) in quad.iter().enumerate() {
                let old = original.iter().find(|&&director| before.node[director as usize] == node).unwrap();
                let new = after.corners[e][corner] as usize;
                prop_assert_eq!(after.node[new], node);
                prop_assert!((after.values[new] - before.values[*old as usize] * sign).norm() < 1e-14);
            }
        }
    }

    #[test]
    fn any_mesh_has_directors_or_issues(
        positions in prop::collection::vec(prop::array::uniform3(prop_oneof![
            -2.0f64..2.0, Just(0.0), Just(1e300), Just(f64::NAN)
        ]), 0..7),
        quads in prop::collection::vec(prop::array::uniform4(0u32..7), 0..6),
    ) {
        if let Ok(directors) = Directors::of(&from(&positions, &quads), FOLD_ANGLE_DEGREES) {
            for value in &directors.values {
                prop_assert!((value.norm() - 1.0).abs() < 1e-12);
            }
            for (corners, quad) in directors.corners.iter().zip(&quads) {
                for (&director, &node) in corners.iter().zip(quad) {
                    prop_assert_eq!(directors.node[director as usize], node);
                }
            }
        }
    }
}

/// Two sheets that lie on one another at the edge of a third: the one upside down could turn about the edge freely.
#[test]
fn sheets_that_lie_on_one_another_are_refused() {
    let x = |lift: f64| {
        [
            [0.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [-1.0, 0.0, 0.0],
            [-1.0, 1.0, 0.0],
            [1.0, 0.0, 0.0],
            [1.0, 1.0, 0.0],
            [1.0, 0.0, lift],
            [1.0, 1.0, lift],
        ]
    };
    let quads = [[2, 0, 1, 3], [0, 4, 5, 1], [0, 1, 7, 6]];
    let found = issues(&from(&x(0.0), &quads));
    assert_eq!(found.len(), 2, "{found:#?}");
    assert!(
        found[0].message.contains("at node 0 at (0.0, 0.0, 0.0) the surface is folded back"),
        "{}",
        found[0]
    );
    assert_eq!(directors(&from(&x(0.5), &quads)).ties.len(), 2);
}
