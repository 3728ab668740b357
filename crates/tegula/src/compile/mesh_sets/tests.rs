use super::*;
use crate::mesh::generators::generate;
use crate::model::{CylinderMesh, Grid, MeshSource};

/// ```text
/// 10--11--12--13--14      y = 1
///  | 4 | 5 | 6 | 7 |
///  5---6---7---8---9
///  | 0 | 1 | 2 | 3 |
///  0---1---2---3---4      y = 0, x = 0 … 2
/// ```
fn plate() -> Mesh {
    let node = |n: u32| Vec3::new(0.5 * f64::from(n % 5), 0.5 * f64::from(n / 5), 0.0);
    let quad = |q: u32| {
        let first = q % 4 + 5 * (q / 4);
        [first, first + 1, first + 6, first + 5]
    };
    Mesh { positions: (0..15).map(node).collect(), quads: (0..8).map(quad).collect(), ..Mesh::default() }
}

fn everything() -> String {
    "all".into()
}

fn boxed(name: &str, x: [f64; 2], y: Option<[f64; 2]>) -> MeshSet {
    MeshSet::Box(BoxSet { name: name.into(), x: Some(x), y, z: None, within: everything(), tolerance: None })
}

fn formula(name: &str, condition: &str, within: &str) -> MeshSet {
    let keys =
        FormulaSet { name: name.into(), condition: condition.into(), within: within.into(), tolerance: None };
    MeshSet::Formula(keys)
}

fn plane(name: &str, at: [f64; 3], normal: [f64; 3]) -> MeshSet {
    MeshSet::Plane(PlaneSet { name: name.into(), at, normal, within: everything(), tolerance: None })
}

fn of(name: &str, of: &[&str]) -> CombinedSet {
    CombinedSet { name: name.into(), of: of.iter().map(|name| (*name).into()).collect() }
}

/// Nodes, elements and number of edges of a set.
fn parts(mesh: &Mesh, name: &str) -> (Vec<u32>, Vec<u32>, usize) {
    (
        mesh.nodes_on(name).unwrap(),
        mesh.quads_on(name).unwrap_or_default(),
        mesh.edges_on(name).unwrap_or_default().len(),
    )
}

#[test]
fn a_box_holds_nodes_elements_by_their_centre_and_edges_of_the_boundary() {
    let mut mesh = plate();
    let sets = [
        boxed("left", [0.0, 1.0 - 1e-12], None),
        boxed("corner", [1.4, 2.0], Some([0.4, 1.0])),
        boxed("element", [0.2, 0.3], Some([0.2, 0.3])),
    ];
    assert!(define_sets(&sets, &mut mesh).is_empty());
    assert_eq!(parts(&mesh, "left"), (vec![0, 1, 2, 5, 6, 7, 10, 11, 12], vec![0, 1, 4, 5], 6));
    assert_eq!(parts(&mesh, "corner"), (vec![8, 9, 13, 14], vec![7], 2));
    // A box inside an element holds the element, which has its centre there, and no node.
    assert_eq!(parts(&mesh, "element"), (vec![], vec![0], 0));
}

#[test]
fn a_plane_holds_the_edges_in_which_it_cuts_the_mesh() {
    let mut mesh = plate();
    let sets = [
        plane("line", [1.0, 7.0, 3.0], [2.0, 0.0, 0.0]),
        plane("side", [2.0, 0.0, 0.0], [-1.0, 0.0, 0.0]),
        plane("all of it", [0.0; 3], [0.0, 0.0, 1.0]),
    ];
    assert!(define_sets(&sets, &mut mesh).is_empty());
    assert_eq!(parts(&mesh, "line"), (vec![2, 7, 12], vec![], 2));
    assert_eq!(parts(&mesh, "side"), (vec![4, 9, 14], vec![], 2));
    // Edges of the boundary run with their element.
    assert_eq!(mesh.edges_on("side"), Some(vec![[4, 9], [9, 14]]));
    assert_eq!(parts(&mesh, "all of it"), ((0..15).collect(), (0..8).collect(), 12));
}

#[test]
fn formulas_and_their_complements_divide_the_mesh() {
    let mut mesh = plate();
    let sets = [
        formula("a", "x > 1 or y < 0.1", "all"),
        MeshSet::Difference(of("others", &["all", "a"])),
        MeshSet::Union(of("both", &["a", "others"])),
        MeshSet::Intersection(of("none", &["a", "others"])),
        formula("upper", "y >= 1", "a"),
        MeshSet::Difference(of("neither", &["all", "upper", "others"])),
    ];
    let issues = define_sets(&sets, &mut mesh);
    assert_eq!(issues.len(), 1, "{issues:?}");
    assert!(issues[0].message.contains("\"none\" holds no node"), "{issues:?}");
    assert_eq!(parts(&mesh, "a"), (vec![0, 1, 2, 3, 4, 8, 9, 13, 14], vec![2, 3, 6, 7], 7));
    assert_eq!(parts(&mesh, "others"), (vec![5, 6, 7, 10, 11, 12], vec![0, 1, 4, 5], 5));
    assert_eq!(parts(&mesh, "both"), ((0..15).collect(), (0..8).collect(), 12));
    assert_eq!(parts(&mesh, "upper"), (vec![13, 14], vec![], 1));
    assert_eq!(parts(&mesh, "neither").0, [0, 1, 2, 3, 4, 8, 9]);
}

#[test]
fn spheres_and_cylinders_hold_what_lies_between_their_radii() {
    let mut mesh = plate();
    let sphere = |name: &str, [inner_radius, radius]: [f64; 2]| {
        let (at, within) = ([1.0, 0.5, 0.0], everything());
        MeshSet::Sphere(SphereSet { name: name.into(), at, radius, inner_radius, within, tolerance: None })
    };
    let cylinder = MeshSet::Cylinder(CylinderSet {
        name: "tube".into(),
        at: [0.0, 0.5, 0.0],
        axis: [2.0, 0.0, 0.0],
        radius: 0.3,
        inner_radius: 0.1,
        within: everything(),
        tolerance: None,
    });
    let sets = [sphere("ball", [0.0, 0.5]), sphere("rim", [0.5, 0.5]), cylinder];
    assert!(define_sets(&sets, &mut mesh).is_empty());
    assert_eq!(parts(&mesh, "ball"), (vec![2, 6, 7, 8, 12], vec![1, 2, 5, 6], 0));
    assert_eq!(parts(&mesh, "rim"), (vec![2, 6, 8, 12], vec![], 0));
    // The nodes on the axis and on both sides are not between the radii; all centres are at the distance 0.25.
    assert_eq!(parts(&mesh, "tube"), (vec![], (0..8).collect(), 0));
}

#[test]
fn a_tolerance_of_the_model_replaces_that_of_the_size() {
    let mut mesh = plate();
    let near = |name: &str, tolerance| {
        let keys = PlaneSet {
            name: name.into(),
            at: [0.98, 0.0, 0.0],
            normal: [1.0, 0.0, 0.0],
            within: everything(),
            tolerance,
        };
        MeshSet::Plane(keys)
    };
    let issues = define_sets(&[near("far", None), near("near", Some(0.03))], &mut mesh);
    assert_eq!(issues.len(), 1);
    assert_eq!(parts(&mesh, "near"), (vec![2, 7, 12], vec![], 2));
}

/// A quarter of a cylinder about the x axis with 6 elements of 15° around.
#[test]
fn elements_are_found_by_their_normal() {
    let source = MeshSource::Cylinder(CylinderMesh {
        center: [0.0; 3],
        axis: [1.0, 0.0, 0.0],
        start: [0.0, 0.0, 1.0],
        radius: 1.0,
        angles: [0.0, 90.0],
        length: 2.0,
        grid: Grid::uniform(6, 1),
    });
    let mut mesh = generate(&source).unwrap();
    let first = mesh.normal(0).unwrap();
    let normal = |name: &str, angle| {
        MeshSet::Normal(NormalSet {
            name: name.into(),
            direction: (first * 3.0).into(),
            angle,
            within: everything(),
        })
    };
    assert!(define_sets(&[normal("one", 1.0), normal("three", 31.0)], &mut mesh).is_empty());
    assert_eq!(mesh.quads_on("one").unwrap(), [0]);
    let (nodes, quads, edges) = parts(&mesh, "three");
    // Edges of the boundary of the mesh: three on each side and one at the end.
    assert_eq!((nodes.len(), quads.len(), edges), (8, 3, 7));
}

#[test]
fn the_rim_of_a_hole_is_the_line_of_the_boundary_nearest_to_a_point() {
    let node = |n: u32| Vec3::new(f64::from(n % 4), f64::from(n / 4), 0.0);
    let quads = (0..9).filter(|q| *q != 4).map(|q| {
        let first = q % 3 + 4 * (q / 3);
        [first, first + 1, first + 5, first + 4]
    });
    let mut mesh = Mesh { positions: (0..16).map(node).collect(), quads: quads.collect(), ..Mesh::default() };
    let boundary = |name: &str, near, within: &str| {
        MeshSet::Boundary(BoundarySet { name: name.into(), near, within: within.into() })
    };
    let sets = [
        boundary("both", None, "all"),
        boundary("hole", Some([1.5, 1.4, 0.0]), "all"),
        boundary("outside", Some([0.0, 2.0, 0.0]), "all"),
        formula("row", "y < 1", "all"),
        boundary("of the row", None, "row"),
    ];
    assert!(define_sets(&sets, &mut mesh).is_empty());
    assert_eq!(parts(&mesh, "both"), ((0..16).collect(), vec![], 16));
    assert_eq!(parts(&mesh, "hole"), (vec![5, 6, 9, 10], vec![], 4));
    assert_eq!(parts(&mesh, "outside").2, 12);
    assert_eq!(parts(&mesh, "of the row"), ((0..8).collect(), vec![], 8));
}

#[test]
fn mistakes_are_named_by_set_and_key() {
    let open = f64::INFINITY;
    let of_place = |x, y| boxed("b", x, y);
    for (set, key, message) in [
        (boxed("all", [0.0, 1.0], None), "sets[0].name", "called \"all\""),
        (boxed("ground", [0.0, 1.0], None), "sets[0].name", "not the name of a set"),
        (boxed("known", [0.0, 1.0], None), "sets[0].name", "already has a set"),
        (boxed("", [0.0, 1.0], None), "sets[0].name", "no name"),
        (of_place([0.0, open], None), "sets[0].x", "not a finite number"),
        (of_place([0.0, 1.0], Some([1.0, 0.0])), "sets[0].y", "ends below its beginning"),
        (of_place([5.0, 6.0], None), "sets[0]", "holds no node"),
        (formula("f", "sqrt(x - 1) < 5", "all"), "sets[0].where", "has no value at ("),
        (plane("p", [0.0; 3], [0.0; 3]), "sets[0].normal", "no length"),
        (plane("p", [open, 0.0, 0.0], [1.0, 0.0, 0.0]), "sets[0].at", "the point"),
        (formula("f", "x < t", "all"), "sets[0].where", "unknown variable"),
        (formula("f", "x < 1", "knwon"), "sets[0].within", "there is no set \"knwon\""),
        (MeshSet::Union(of("u", &["all", "later"])), "sets[0].of[1]", "there is no set \"later\" yet"),
        (MeshSet::Union(of("u", &[])), "sets[0].of", "empty"),
    ] {
        let mut mesh = plate();
        mesh.node_sets.insert("known".into(), vec![1]);
        let issues = define_sets(&[set], &mut mesh);
        assert_eq!(issues.len(), 1, "{message}: {issues:?}");
        assert_eq!(issues[0].place.key, key, "{issues:?}");
        assert!(issues[0].message.contains(message), "{issues:?}");
    }
}

/// Edges of a set of elements alone are those of the boundary between its nodes, also where it is combined.
#[test]
fn sets_of_elements_bring_the_boundary_between_their_nodes() {
    let mut mesh = plate();
    mesh.quad_sets.insert("Q".into(), vec![0, 1]);
    mesh.node_sets.insert("N".into(), vec![0, 5]);
    let sets = [
        MeshSet::Union(of("one", &["Q"])),
        MeshSet::Union(of("two", &["Q", "N"])),
        MeshSet::Difference(of("rest", &["all", "Q"])),
    ];
    assert!(define_sets(&sets, &mut mesh).is_empty());
    assert_eq!(parts(&mesh, "one"), (vec![0, 1, 2, 5, 6, 7], vec![0, 1], 3));
    assert_eq!(parts(&mesh, "two"), (vec![0, 1, 2, 5, 6, 7], vec![0, 1], 3));
    assert_eq!(parts(&mesh, "rest"), (vec![3, 4, 8, 9, 10, 11, 12, 13, 14], vec![2, 3, 4, 5, 6, 7], 9));
}

/// An edge between two parts of a set is no part of it; the chords of a circle are.
#[test]
fn edges_lie_in_their_sets() {
    let node = |n: u32| Vec3::new(f64::from(n / 2), f64::from(n % 2), 0.0);
    let quads = (0..3).map(|q| [2 * q, 2 * q + 2, 2 * q + 3, 2 * q + 1]);
    let mut mesh = Mesh { positions: (0..8).map(node).collect(), quads: quads.collect(), ..Mesh::default() };
    let sets = [
        formula("sides", "y < 0.1 or y > 0.9", "all"),
        formula("begin", "x < 0.6", "all"),
        MeshSet::Plane(PlaneSet {
            name: "outside".into(),
            at: [1.0, 0.0, 0.0],
            normal: [1.0, 0.0, 0.0],
            within: "begin".into(),
            tolerance: None,
        }),
    ];
    let issues = define_sets(&sets, &mut mesh);
    assert!(issues.len() == 1 && issues[0].place.key == "sets[2]", "{issues:?}");
    assert_eq!(parts(&mesh, "sides").2, 6);
    // Twelve nodes on a circle, and as many on a smaller one.
    let ring = |n: u32| {
        let (angle, radius) =
            (std::f64::consts::TAU / 12.0 * f64::from(n % 12), if n < 12 { 1.0 } else { 2.0 });
        Vec3::new(radius * angle.cos(), radius * angle.sin(), 0.0)
    };
    let quads = (0..12).map(|q| [q, q + 12, (q + 1) % 12 + 12, (q + 1) % 12]);
    let mut mesh = Mesh { positions: (0..24).map(ring).collect(), quads: quads.collect(), ..Mesh::default() };
    let rim = SphereSet {
        name: "rim".into(),
        at: [0.0; 3],
        radius: 1.0,
        inner_radius: 1.0,
        within: everything(),
        tolerance: None,
    };
    assert!(define_sets(&[MeshSet::Sphere(rim)], &mut mesh).is_empty());
    assert_eq!(parts(&mesh, "rim"), ((0..12).collect(), vec![], 12));
}
