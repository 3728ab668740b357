//! The structured grid behind the generators: graded lines of parameters,
//! random distortion, numbering, named edges.
//!
//! Nodes are numbered u fastest, n(i, j) = j (nᵤ + 1) + i; quads likewise. Shapes
//! that close on themselves have no column i = nᵤ: it is the column 0 again.

use super::Mesh;
use super::surfaces::Surface;

/// Sizes in geometric progression: t in 0…1 ↦ (e^{λt} − 1)/(e^λ − 1).
///
/// With n elements q = ratio^{1/(n−1)} is the quotient of neighbours and λ = n ln q.
#[derive(Debug, Clone, Copy)]
pub(super) struct Progression {
    /// λ; 0 for equal sizes.
    exponent: f64,
}

impl Progression {
    /// The progression over `elements` elements, the last `ratio` times as long as the first.
    pub fn new(elements: usize, ratio: f64) -> Self {
        if elements < 2 {
            return Self { exponent: 0.0 };
        }
        Self { exponent: elements as f64 * ratio.ln() / (elements as f64 - 1.0) }
    }

    /// Place of the part `t` of all elements, 0…1.
    pub fn at(self, t: f64) -> f64 {
        if self.exponent == 0.0 { t } else { (t * self.exponent).exp_m1() / self.exponent.exp_m1() }
    }

    /// The part of all elements that lies before the place `s`: the inverse of [`Self::at`].
    pub fn inverse(self, s: f64) -> f64 {
        if self.exponent == 0.0 { s } else { (s * self.exponent.exp_m1()).ln_1p() / self.exponent }
    }

    /// Progression between the parts `a` and `b` of all elements, again over 0…1.
    pub fn piece(self, a: f64, b: f64) -> Self {
        Self { exponent: self.exponent * (b - a) }
    }

    /// The lines between `elements` elements, 0 and 1 included.
    pub fn lines(self, elements: usize) -> Vec<f64> {
        (0..=elements)
            .map(|k| if k == elements { 1.0 } else { self.at(k as f64 / elements as f64) })
            .collect()
    }
}

/// The lines of a grid in parameter space.
pub(super) struct Lines {
    /// u of each column, ascending.
    pub u: Vec<f64>,
    /// v of each row, ascending.
    pub v: Vec<f64>,
    /// Columns (folds, seams) whose nodes must not move along u.
    pub straight: Vec<bool>,
    /// Whether the last column is the first one again.
    pub joined: bool,
    /// Column and row nearest to the middle.
    pub middle: [usize; 2],
}

impl Lines {
    /// Graded lines over the unit square.
    pub fn graded(elements: [u32; 2], grading: [f64; 2], joined: bool) -> Self {
        let [nu, nv] = elements.map(|n| n as usize);
        let u = Progression::new(nu, grading[0]).lines(nu);
        let v = Progression::new(nv, grading[1]).lines(nv);
        let middle = [nearest_line(&u), nearest_line(&v)];
        let mut straight = vec![false; u.len()];
        straight[0] = true;
        Self { u, v, straight, joined, middle }
    }

    fn elements(&self) -> [usize; 2] {
        [self.u.len().saturating_sub(1), self.v.len().saturating_sub(1)]
    }

    fn columns(&self) -> usize {
        self.u.len() - usize::from(self.joined)
    }

    /// Number of the node at column i and row j. Generators bound the number of elements, so it fits.
    fn node(&self, i: usize, j: usize) -> u32 {
        let columns = self.columns();
        (j * columns + if i == columns { 0 } else { i }) as u32
    }

    fn quad(&self, i: usize, j: usize) -> [u32; 4] {
        [self.node(i, j), self.node(i + 1, j), self.node(i + 1, j + 1), self.node(i, j + 1)]
    }
}

/// The line nearest to 0.5, the lower one of two equally near.
pub(super) fn nearest_line(lines: &[f64]) -> usize {
    let mut best = (0, f64::INFINITY);
    for (k, &line) in lines.iter().enumerate() {
        let distance = (line - 0.5).abs();
        // two lines half an element off either way differ by rounding only
        if distance < best.1 - 1e-9 * (1.0 + distance) || best.1.is_infinite() {
            best = (k, distance);
        }
    }
    best.0
}

/// Meshes a surface along the lines, inner nodes shifted by up to the part
/// `distortion` of the element size along u and v, and names edges, corners and middle.
pub(super) fn build(surface: &impl Surface, lines: &Lines, distortion: f64, seed: u64) -> Mesh {
    let parameters = distorted(lines, distortion, seed);
    let positions = parameters.iter().map(|&[u, v]| surface.position(u, v)).collect();
    let [nu, nv] = lines.elements();
    let mut quads = Vec::with_capacity(nu * nv);
    let mut normals = Vec::with_capacity(nu * nv);
    for j in 0..nv {
        for i in 0..nu {
            let quad = lines.quad(i, j);
            let side = 0.5 * (lines.u[i] + lines.u[i + 1]);
            quads.push(quad);
            normals.push(quad.map(|node| {
                let [u, v] = parameters[node as usize];
                surface.normal(u, v, side)
            }));
        }
    }
    let mut mesh = Mesh { positions, quads, normals: Some(normals), ..Mesh::default() };
    name_parts(&mut mesh, lines);
    mesh
}

/// Names the edges (in the direction in which their quads run), corners and the middle.
fn name_parts(mesh: &mut Mesh, lines: &Lines) {
    let [nu, nv] = lines.elements();
    let node = |i, j| lines.node(i, j);
    let mut edges = vec![
        ("v_min", (0..nu).map(|i| [node(i, 0), node(i + 1, 0)]).collect::<Vec<_>>()),
        ("v_max", (0..nu).map(|i| [node(i + 1, nv), node(i, nv)]).collect()),
    ];
    if !lines.joined {
        edges.push(("u_min", (0..nv).map(|j| [node(0, j + 1), node(0, j)]).collect()));
        edges.push(("u_max", (0..nv).map(|j| [node(nu, j), node(nu, j + 1)]).collect()));
        for (name, corner) in [
            ("u_min_v_min", node(0, 0)),
            ("u_max_v_min", node(nu, 0)),
            ("u_max_v_max", node(nu, nv)),
            ("u_min_v_max", node(0, nv)),
        ] {
            mesh.node_sets.insert(name.to_owned(), vec![corner]);
        }
    }
    for (name, edges) in edges {
        let mut nodes: Vec<u32> = edges.iter().flatten().copied().collect();
        nodes.sort_unstable();
        nodes.dedup();
        mesh.node_sets.insert(name.to_owned(), nodes);
        mesh.edge_sets.insert(name.to_owned(), edges);
    }
    mesh.node_sets.insert("middle".to_owned(), vec![node(lines.middle[0], lines.middle[1])]);
}

/// Parameters (u, v) of all nodes, the inner ones shifted at random.
///
/// Shifts up to a quarter of an element keep every quad convex in parameter
/// space; beyond, the nodes of the few quads that would not be are shifted half as far.
fn distorted(lines: &Lines, distortion: f64, seed: u64) -> Vec<[f64; 2]> {
    let [nu, nv] = lines.elements();
    let columns = lines.columns();
    let mut shifts = vec![[0.0; 2]; columns * (nv + 1)];
    if distortion > 0.0 {
        let mut random = Random(seed);
        for j in 1..nv {
            let row = smaller_step(&lines.v, j, j - 1);
            for i in usize::from(!lines.joined)..nu {
                let shift = [random.symmetric(), random.symmetric()];
                let along_u =
                    if lines.straight[i] { 0.0 } else { smaller_step(&lines.u, i, i.saturating_sub(1)) };
                shifts[j * columns + i] = [distortion * along_u * shift[0], distortion * row * shift[1]];
            }
        }
        halve_where_concave(lines, &mut shifts);
    }
    let mut parameters = shifts;
    for (number, shifted) in parameters.iter_mut().enumerate() {
        shifted[0] += lines.u[number % columns];
        shifted[1] += lines.v[number / columns];
    }
    parameters
}

/// The shorter one of the steps that begin at the lines `after` and `before`.
fn smaller_step(lines: &[f64], after: usize, before: usize) -> f64 {
    (lines[after + 1] - lines[after]).min(lines[before + 1] - lines[before])
}

/// Halves, once per node, the shifts of quads with a corner Jacobian below a tenth
/// of the undistorted one. Halved shifts are at most 0.2 elements, which leaves at
/// least 1 − 4·0.2 = 0.2 of it: so this ends.
fn halve_where_concave(lines: &Lines, shifts: &mut [[f64; 2]]) {
    const LEAST_JACOBIAN: f64 = 0.1;
    let [nu, nv] = lines.elements();
    let mut halved = vec![false; shifts.len()];
    loop {
        let mut again = false;
        for j in 0..nv {
            for i in 0..nu {
                let size = [lines.u[i + 1] - lines.u[i], lines.v[j + 1] - lines.v[j]];
                let quad = lines.quad(i, j).map(|node| node as usize);
                let corner = |k: usize| {
                    let unit = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]][k];
                    [0, 1].map(|c| unit[c] + shifts[quad[k]][c] / size[c])
                };
                let corners = [0, 1, 2, 3].map(corner);
                let concave = (0..4).any(|k| {
                    let [here, next, previous] = [corners[k], corners[(k + 1) % 4], corners[(k + 3) % 4]];
                    let [a, b] = [next, previous].map(|to| [to[0] - here[0], to[1] - here[1]]);
                    a[0] * b[1] - a[1] * b[0] < LEAST_JACOBIAN
                });
                if concave {
                    for node in quad {
                        if !halved[node] {
                            halved[node] = true;
                            again = true;
                            shifts[node] = shifts[node].map(|shift| 0.5 * shift);
                        }
                    }
                }
            }
        }
        if !again {
            return;
        }
    }
}

/// SplitMix64 (Steele, Lea & Flood, OOPSLA 2014): a few lines, the same numbers on every machine.
pub(crate) struct Random(pub u64);

impl Random {
    /// Uniform in −1…1.
    pub fn symmetric(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^= z >> 31;
        (z >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn splitmix_gives_its_reference_numbers() {
        // first output for the seed 0 is 0xE220A8397B1DCDAF
        let expected = (0xE220_A839_7B1D_CDAF_u64 >> 11) as f64 / 2f64.powi(52) - 1.0;
        assert_eq!(Random(0).symmetric(), expected);
    }

    #[test]
    fn middle_is_the_lower_of_two_equally_near_lines() {
        assert_eq!(nearest_line(&Progression::new(3, 1.0).lines(3)), 1);
        assert_eq!(nearest_line(&Progression::new(4, 1.0).lines(4)), 2);
        assert_eq!(nearest_line(&Progression::new(1, 1.0).lines(1)), 0);
    }

    proptest! {
        #[test]
        fn sizes_are_a_geometric_progression(n in 2usize..40, log in -3.0f64..3.0) {
            let ratio = 10f64.powf(log);
            let lines = Progression::new(n, ratio).lines(n);
            let sizes: Vec<f64> = lines.windows(2).map(|w| w[1] - w[0]).collect();
            prop_assert!((sizes[n - 1] / sizes[0] / ratio - 1.0).abs() < 1e-8);
            let q = sizes[1] / sizes[0];
            for w in sizes.windows(2) {
                prop_assert!((w[1] / w[0] / q - 1.0).abs() < 1e-7);
            }
        }

        #[test]
        fn inverse_undoes_the_progression(n in 1usize..40, log in -3.0f64..3.0, t in 0.0f64..1.0) {
            let progression = Progression::new(n, 10f64.powf(log));
            prop_assert!((progression.inverse(progression.at(t)) - t).abs() < 1e-9);
        }

        #[test]
        fn distorted_quads_stay_convex(
            nu in 1u32..20, nv in 1u32..20, ratio in prop_oneof![Just(1.0), 0.2f64..5.0],
            distortion in prop_oneof![Just(0.4), 0.0f64..=0.4],
            seed: u64, joined: bool,
        ) {
            let lines = Lines::graded([nu, nv], [ratio, 1.0 / ratio], joined);
            let parameters = distorted(&lines, distortion, seed);
            for j in 0..nv as usize {
                for i in 0..nu as usize {
                    let mut quad = lines.quad(i, j).map(|node| parameters[node as usize]);
                    if joined && i + 1 == nu as usize {
                        quad[1][0] += 1.0;
                        quad[2][0] += 1.0;
                    }
                    for k in 0..4 {
                        let [here, next, previous] = [quad[k], quad[(k + 1) % 4], quad[(k + 3) % 4]];
                        let cross = (next[0] - here[0]) * (previous[1] - here[1])
                            - (next[1] - here[1]) * (previous[0] - here[0]);
                        prop_assert!(cross > 0.0);
                    }
                }
            }
        }
    }
}
