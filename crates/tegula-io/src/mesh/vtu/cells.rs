//! Types of cells.

/// Cell that a mesh can have, by indices of points.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Cell {
    Quad([u32; 4]),
    /// Line through these points, two or more.
    Line(Vec<u32>),
    Vertices(Vec<u32>),
}

/// Cell of a type of VTK on these points; `None` where it cannot be computed.
pub(super) fn cell(kind: i64, points: &[u32]) -> Option<Cell> {
    Some(match (kind, points) {
        (7 | 9, &[a, b, c, d]) => Cell::Quad([a, b, c, d]),
        // A pixel has its points in the order of rows.
        (8, &[a, b, c, d]) => Cell::Quad([a, b, d, c]),
        (3, [_, _]) | (4, [_, _, ..]) => Cell::Line(points.to_vec()),
        (1, [_]) | (2, _) => Cell::Vertices(points.to_vec()),
        _ => return None,
    })
}

/// Name of a type of cells.
pub(super) fn name(kind: i64) -> Option<&'static str> {
    Some(match kind {
        0 => "cell without points",
        1 => "vertex",
        2 => "poly-vertex",
        3 => "line",
        4 => "polyline",
        5 => "triangle",
        6 => "triangle strip",
        7 => "polygon",
        8 => "pixel",
        9 => "quadrilateral",
        10 => "tetrahedron",
        11 => "voxel",
        12 => "hexahedron",
        13 => "wedge",
        14 => "pyramid",
        15 => "pentagonal prism",
        16 => "hexagonal prism",
        21 => "quadratic edge",
        22 => "quadratic triangle",
        23 => "quadratic quadrilateral",
        24 => "quadratic tetrahedron",
        25 => "quadratic hexahedron",
        26 => "quadratic wedge",
        27 => "quadratic pyramid",
        28 => "biquadratic quadrilateral",
        29 => "triquadratic hexahedron",
        30 => "quadratic-linear quadrilateral",
        31 => "quadratic-linear wedge",
        32 => "biquadratic-quadratic wedge",
        33 => "biquadratic-quadratic hexahedron",
        34 => "biquadratic triangle",
        35 => "cubic line",
        36 => "quadratic polygon",
        37 => "triquadratic pyramid",
        41 => "convex point set",
        42 => "polyhedron",
        68 => "Lagrange curve",
        69 => "Lagrange triangle",
        70 => "Lagrange quadrilateral",
        71 => "Lagrange tetrahedron",
        72 => "Lagrange hexahedron",
        73 => "Lagrange wedge",
        74 => "Lagrange pyramid",
        75 => "Bézier curve",
        76 => "Bézier triangle",
        77 => "Bézier quadrilateral",
        78 => "Bézier tetrahedron",
        79 => "Bézier hexahedron",
        80 => "Bézier wedge",
        81 => "Bézier pyramid",
        _ => return None,
    })
}

/// Remedy for a type of cells that cannot be computed.
pub(super) fn remedy(kind: i64) -> &'static str {
    match kind {
        5 | 6 | 7 | 69 | 76 => "mesh the surface with quadrilaterals of 4 points",
        21 | 22 | 23 | 28 | 30 | 34 | 35 | 36 | 68 | 70 | 75 | 77 => "use elements of first order",
        _ => "give the middle surface as quadrilaterals of 4 points",
    }
}
