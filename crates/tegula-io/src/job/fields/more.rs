//! Derived fields: principal stresses, means at the nodes, axes, numbers.

use tegula::model::Field;
use tegula::result::ShellResult;
use tegula::{Mesh, System};

use super::by_quad;
use crate::out::DataArray;

const PRINCIPAL: [&str; 3] = ["1", "2", "angle"];
const SPACE: [&str; 6] = ["XX", "YY", "ZZ", "XY", "YZ", "XZ"];

/// Adds the wanted ones of these fields.
pub(super) fn add<'a>(
    mesh: &Mesh,
    system: &System,
    wanted: &[Field],
    results: &[ShellResult],
    points: &mut Vec<DataArray<'a>>,
    cells: &mut Vec<DataArray<'a>>,
) {
    if wanted.contains(&Field::PrincipalStress) {
        let field = |name: &'static str, stress: fn(&ShellResult) -> [f64; 3]| {
            let values = by_quad(mesh, system, results, |r| principal(stress(r)));
            DataArray::new(name, 3, values).with_component_names(&PRINCIPAL)
        };
        cells.push(field("principal_top", |r| r.stress_top));
        cells.push(field("principal_bottom", |r| r.stress_bottom));
    }
    if wanted.contains(&Field::NodalMeans) {
        let mean = |value: fn(&ShellResult) -> [f64; 6]| nodal_mean(mesh, system, results, value);
        points.push(DataArray::new(
            "von_mises_nodal",
            1,
            nodal_mean(mesh, system, results, |r| [r.von_mises]),
        ));
        let top = mean(|r| in_space(&r.current_axes, r.stress_top));
        points.push(DataArray::new("stress_top_nodal", 6, top).with_component_names(&SPACE));
        let bottom = mean(|r| in_space(&r.current_axes, r.stress_bottom));
        points.push(DataArray::new("stress_bottom_nodal", 6, bottom).with_component_names(&SPACE));
    }
    if wanted.contains(&Field::Axes) {
        cells.push(DataArray::new("axis_x", 3, by_quad(mesh, system, results, |r| r.axes[0])));
        cells.push(DataArray::new("axis_y", 3, by_quad(mesh, system, results, |r| r.axes[1])));
        cells.push(DataArray::new("axis_z", 3, by_quad(mesh, system, results, |r| r.axes[2])));
    }
    if wanted.contains(&Field::Numbers) {
        numbers(mesh, system, points, cells);
    }
}

/// Principal stresses of σ_xx, σ_yy, σ_xy, the greater one first, and the angle from x to its direction in degrees.
fn principal([xx, yy, xy]: [f64; 3]) -> [f64; 3] {
    let (middle, half) = (0.5 * (xx + yy), 0.5 * (xx - yy));
    let radius = half.hypot(xy);
    [middle + radius, middle - radius, 0.5 * xy.atan2(half).to_degrees()]
}

/// Stresses in the plane of the first two axes as components in space, in VTK's order.
fn in_space(axes: &[[f64; 3]; 3], [xx, yy, xy]: [f64; 3]) -> [f64; 6] {
    let [x, y, _] = axes;
    let part = |i: usize, j: usize| xx * x[i] * x[j] + yy * y[i] * y[j] + xy * (x[i] * y[j] + y[i] * x[j]);
    [part(0, 0), part(1, 1), part(2, 2), part(0, 1), part(1, 2), part(0, 2)]
}

/// Means over the elements at each node, weighted by area; NaN at nodes without elements.
fn nodal_mean<const N: usize>(
    mesh: &Mesh,
    system: &System,
    results: &[ShellResult],
    value: impl Fn(&ShellResult) -> [f64; N],
) -> Vec<f64> {
    let mut sums = vec![[0.0; N]; mesh.positions.len()];
    let mut areas = vec![0.0; mesh.positions.len()];
    for (shell, result) in system.shells.iter().zip(results) {
        let value = value(result);
        for &node in &mesh.quads[shell.quad as usize] {
            areas[node as usize] += result.area;
            for (sum, value) in sums[node as usize].iter_mut().zip(value) {
                *sum += result.area * value;
            }
        }
    }
    sums.iter().zip(areas).flat_map(|(sum, area)| sum.map(|s| s / area)).collect()
}

fn numbers<'a>(
    mesh: &Mesh,
    system: &System,
    points: &mut Vec<DataArray<'a>>,
    cells: &mut Vec<DataArray<'a>>,
) {
    let node = |node: usize| mesh.node_label(node as u32) as f64;
    points.push(DataArray::new("node", 1, (0..mesh.positions.len()).map(node).collect::<Vec<_>>()));
    let element = |quad: usize| mesh.quad_label(quad) as f64;
    cells.push(DataArray::new("element", 1, (0..mesh.quads.len()).map(element).collect::<Vec<_>>()));
    let mut sections = vec![f64::NAN; mesh.quads.len()];
    for shell in &system.shells {
        sections[shell.quad as usize] = (shell.section + 1) as f64;
    }
    cells.push(DataArray::new("section", 1, sections));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn principal_stresses_are_those_of_mohr_s_circle() {
        assert_eq!(principal([3.0, 1.0, 0.0]), [3.0, 1.0, 0.0]);
        assert_eq!(principal([1.0, 3.0, 0.0]), [3.0, 1.0, 90.0]);
        assert_eq!(principal([0.0, 0.0, 2.0]), [2.0, -2.0, 45.0]);
        // σ = R diag(5, −1) Rᵀ turned by 30°.
        let (s, c) = 30.0_f64.to_radians().sin_cos();
        let [a, b, angle] = principal([5.0 * c * c - s * s, 5.0 * s * s - c * c, 6.0 * s * c]);
        assert!((a - 5.0).abs() < 1e-14 && (b + 1.0).abs() < 1e-14 && (angle - 30.0).abs() < 1e-13);
    }

    #[test]
    fn stresses_in_space_keep_their_invariants() {
        // Axes x → z, y → x.
        let axes = [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        assert_eq!(in_space(&axes, [5.0, 7.0, 2.0]), [7.0, 0.0, 5.0, 0.0, 0.0, 2.0]);
    }
}
