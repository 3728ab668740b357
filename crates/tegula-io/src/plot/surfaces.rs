//! Pictures of deformed shells: one or several instants in one parallel projection.

use std::path::Path;

use super::canvas::{Anchor, Canvas, fitted_before};
use super::colour::{Rgb, viridis};
use super::colour_bar;
use super::facets::{self, Patch};
use super::labels::{self, Request};
pub use super::projection::View;
use super::projection::{Camera, Placement, Vec3};
use super::ticks::Axis;
use crate::out::OutputError;

const TITLE: f64 = 21.0;
const NOTE: f64 = 13.0;
const MARGIN: f64 = 24.0;
/// Colour of bodies beside shells.
const BODY: u32 = 0xb4bac4;
/// Opacity of bodies beside solid shells.
const SOLID_BODY: f64 = 0.3;
/// Opacity of bodies beside shells that are not solid, relative to that of the shells.
const SHADOW_BODY: f64 = 0.12;

/// The shell at one instant.
#[derive(Debug, Clone)]
pub struct Snapshot {
    /// Positions of the nodes.
    pub positions: Vec<[f64; 3]>,
    /// One value per quadrilateral that gives its colour; `None` colours by the order of the snapshots.
    pub values: Option<Vec<f64>>,
    /// One value per node that gives the colours, in place of values of quadrilaterals.
    pub nodal: Option<Vec<f64>>,
    /// Label beside the shell, for example `t = 0.4 s`; may be empty.
    pub label: String,
    /// From 0, invisible, to 1, solid.
    pub opacity: f64,
}

impl Default for Snapshot {
    fn default() -> Self {
        Self { positions: Vec::new(), values: None, nodal: None, label: String::new(), opacity: 1.0 }
    }
}

/// A picture of one mesh at several instants.
#[derive(Debug, Clone)]
pub struct SurfacePlot {
    /// Title above the picture; may be empty.
    pub title: String,
    /// End of the title, which stays whole where its beginning is cut, for example `, displacements × 200`.
    pub state: String,
    /// The instants.
    pub snapshots: Vec<Snapshot>,
    /// Corners of the quadrilaterals, as indices of nodes.
    pub quads: Vec<[u32; 4]>,
    /// Faces of bodies, which have no values.
    pub bodies: Vec<[u32; 4]>,
    /// From where to look.
    pub view: View,
    /// Quantity shown by the colours, with its unit; stands beside the colour bar.
    pub color_label: String,
    /// Whether values are averaged at the nodes and run smoothly, or each element has one colour.
    pub smooth: bool,
    /// Values at both ends of the colours; the smallest and the largest value unless given.
    pub range: Option<[f64; 2]>,
    /// Points for which there is room in the picture, too, so that the pictures of a film have one scale.
    pub room: Vec<[f64; 3]>,
    /// Width and height in pixels.
    pub size: (u32, u32),
}

impl Default for SurfacePlot {
    fn default() -> Self {
        Self {
            title: String::new(),
            state: String::new(),
            snapshots: Vec::new(),
            quads: Vec::new(),
            bodies: Vec::new(),
            view: View::default(),
            color_label: String::new(),
            smooth: true,
            range: None,
            room: Vec::new(),
            size: (1200, 800),
        }
    }
}

/// Draws the picture as a PNG file, or as an SVG file if its name ends so.
///
/// Elements with positions that are not finite are left out, and a remark says so; a picture with nothing in it
/// is refused.
pub fn surfaces(path: &Path, plot: &SurfacePlot) -> Result<(), OutputError> {
    let canvas = Canvas::for_file(path, plot.size);
    let (canvas, _) = labelled(plot, canvas).map_err(|problem| OutputError::refused(path, problem))?;
    canvas.save(path)
}

/// Width, height and pixels of the picture, three bytes each, row by row from the top.
///
/// # Errors
/// The data do not fit together, or nothing can be drawn.
pub fn pixels(plot: &SurfacePlot) -> Result<(u32, u32, Vec<u8>), String> {
    let canvas = draw(plot)?;
    let (width, height) = canvas.size();
    Ok((width as u32, height as u32, canvas.pixels()))
}

fn draw(plot: &SurfacePlot) -> Result<Canvas, String> {
    labelled(plot, Canvas::new(plot.size.0, plot.size.1)).map(|(canvas, _)| canvas)
}

/// Rectangles and leaders of the labels in a picture.
type Labels = (Vec<[[f64; 2]; 2]>, Vec<[[f64; 2]; 2]>);

/// The picture on a white sheet, and where its labels stand.
fn labelled(plot: &SurfacePlot, mut canvas: Canvas) -> Result<(Canvas, Labels), String> {
    check(plot)?;
    let (width, height) = canvas.size();
    let camera = Camera::new(plot.view);
    let seen: Vec<Vec<Vec3>> = plot
        .snapshots
        .iter()
        .map(|s| s.positions.iter().map(|&x| camera.see(&Vec3::from(x))).collect())
        .collect();

    // Only bodies have nodes without a quadrilateral, and no values.
    let mut nodes: Vec<u32> = plot.quads.iter().flatten().copied().collect();
    nodes.sort_unstable();
    nodes.dedup();
    let colouring = |s: &Snapshot| -> Vec<f64> {
        let nodal = s.nodal.iter().flat_map(|values| nodes.iter().map(|&node| values[node as usize]));
        s.values.iter().flatten().copied().chain(nodal).collect()
    };
    let values = || plot.snapshots.iter().flat_map(colouring);
    let axis = match plot.range {
        Some(range) => Axis::around(range.into_iter().filter(|_| values().next().is_some()), false, 0.0),
        None => Axis::around(without_round_off(values()), false, 0.0),
    };
    let (patches, left_out) = patches(plot, &seen, axis.as_ref());

    let top = if plot.title.is_empty() && plot.state.is_empty() { MARGIN } else { 60.0 };
    let bar = axis.as_ref().map_or(0.0, |a| colour_bar::width(a, &plot.color_label) + MARGIN);
    let labelled = plot.snapshots.iter().any(|s| !s.label.is_empty());
    let (side, border) = if labelled { (80.0, 44.0) } else { (MARGIN, MARGIN) };
    let (low, high) = ([side, top + border], [width - bar - side, height - border - MARGIN]);
    let room: Vec<Vec3> = plot.room.iter().map(|&x| camera.see(&Vec3::from(x))).collect();
    let used = patches.iter().flat_map(|p| p.corners.iter()).chain(&room);
    let placement = Placement::fit(used, low, high)
        .ok_or("nothing can be drawn: no visible element has finite positions and a size")?;

    let owners = facets::paint(&mut canvas, &placement, &patches);

    let foot = [MARGIN + 34.0, height - MARGIN - 34.0];
    colour_bar::triad(&mut canvas, &camera, foot);
    let bar_ends = [height * 0.22, height * 0.78];
    if let Some(axis) = &axis {
        colour_bar::draw(&mut canvas, axis, &plot.color_label, width - MARGIN, bar_ends);
    }
    let requests: Vec<Request<'_>> = plot
        .snapshots
        .iter()
        .zip(&seen)
        .enumerate()
        .map(|(i, (snapshot, nodes))| Request {
            text: &snapshot.label,
            owner: i as u16 + 1,
            nodes: nodes
                .iter()
                .filter(|x| x.iter().all(|c| c.is_finite()))
                .map(|x| placement.at(x))
                .collect(),
        })
        .collect();
    let taken = vec![[[0.0, height - 120.0], [120.0, height]]];
    let room = [[4.0, top], [width - bar - 4.0, height - 8.0]];
    let labels = labels::place(&mut canvas, &owners, room, taken, &requests);

    let (title, size) = fitted_before(&plot.title, &plot.state, TITLE, width - 2.0 * MARGIN);
    canvas.text([MARGIN, 38.0], Anchor::Start, size, Rgb::INK, &title);
    let remark = remarks(left_out, values().filter(|v| !v.is_finite()).count());
    canvas.text([width - MARGIN, height - 12.0], Anchor::End, NOTE, Rgb::QUIET, &remark);
    Ok((canvas, labels))
}

/// Differences of values over the largest of them below which they are one value: the round-off of results.
const ONE_VALUE: f64 = 1e-6;

/// The smallest and the largest of finite values; only one where they differ by round-off.
fn without_round_off(values: impl Iterator<Item = f64>) -> impl Iterator<Item = f64> {
    let ends = values.filter(|v| v.is_finite()).fold(None, |ends: Option<[f64; 2]>, v| {
        Some(ends.map_or([v, v], |[low, high]| [low.min(v), high.max(v)]))
    });
    let differ = |[low, high]: [f64; 2]| high - low > ONE_VALUE * low.abs().max(high.abs());
    ends.into_iter().flat_map(move |ends| if differ(ends) { ends } else { [0.5 * (ends[0] + ends[1]); 2] })
}

/// Reports data of a picture that do not fit together, in words.
fn check(plot: &SurfacePlot) -> Result<(), String> {
    if plot.snapshots.is_empty() || (plot.quads.is_empty() && plot.bodies.is_empty()) {
        return Err("the picture needs at least one snapshot and one element".into());
    }
    if plot.snapshots.len() >= usize::from(u16::MAX) {
        return Err(format!("{} snapshots are too many for one picture", plot.snapshots.len()));
    }
    let largest = plot.quads.iter().chain(&plot.bodies).flatten().copied().max().unwrap_or(0) as usize;
    for (i, snapshot) in plot.snapshots.iter().enumerate() {
        let nodes = snapshot.positions.len();
        if largest >= nodes {
            return Err(format!("an element names node {largest}, but snapshot {i} has only {nodes} nodes"));
        }
        if let Some(values) = &snapshot.values
            && values.len() != plot.quads.len()
        {
            return Err(format!(
                "snapshot {i} has {} values for {} elements",
                values.len(),
                plot.quads.len()
            ));
        }
        if let Some(values) = &snapshot.nodal
            && values.len() != nodes
        {
            return Err(format!("snapshot {i} has {} values for {nodes} nodes", values.len()));
        }
    }
    Ok(())
}

/// All elements of all snapshots that can be drawn, and the number of those that cannot.
fn patches(plot: &SurfacePlot, seen: &[Vec<Vec3>], axis: Option<&Axis>) -> (Vec<Patch>, usize) {
    let faces: Vec<[u32; 4]> = plot.quads.iter().chain(&plot.bodies).copied().collect();
    let mut edges = facets::free_sides(&plot.quads);
    edges.extend(seen.first().into_iter().flat_map(|nodes| facets::sharp_sides(&plot.bodies, nodes)));
    let mut patches = Vec::with_capacity(faces.len() * plot.snapshots.len());
    let mut left_out = 0;
    for (number, (snapshot, nodes)) in plot.snapshots.iter().zip(seen).enumerate() {
        let opacity = if snapshot.opacity.is_nan() { 1.0 } else { snapshot.opacity.clamp(0.0, 1.0) };
        if opacity == 0.0 {
            continue;
        }
        let mut colours = colours(plot, number, snapshot, axis);
        let of_bodies = if plot.quads.is_empty() { of_instant(plot, number) } else { Rgb::hex(BODY) };
        colours.resize(faces.len(), [of_bodies; 4]);
        let shade = if opacity == 1.0 { SOLID_BODY } else { SHADOW_BODY };
        for (index, quad) in faces.iter().enumerate() {
            let meshed = index < plot.quads.len();
            let corners = quad.map(|node| nodes[node as usize]);
            if corners.iter().any(|x| x.iter().any(|c| !c.is_finite())) {
                left_out += 1;
                continue;
            }
            patches.push(Patch {
                corners,
                colours: colours[index],
                opacity: if meshed || plot.quads.is_empty() { opacity } else { opacity * shade },
                owner: number as u16,
                edges: edges[index],
                meshed,
            });
        }
    }
    (patches, left_out)
}

/// Colours at the corners of each element.
fn colours(plot: &SurfacePlot, number: usize, snapshot: &Snapshot, axis: Option<&Axis>) -> Vec<[Rgb; 4]> {
    let Some(axis) = axis else {
        let without = snapshot.values.is_none() && snapshot.nodal.is_none();
        let colour = if without { of_instant(plot, number) } else { Rgb::MISSING };
        return vec![[colour; 4]; plot.quads.len()];
    };
    // Values beyond a given range have the colours of its ends.
    let colour = |value: f64| axis.place(value).map_or(Rgb::MISSING, viridis);
    if let Some(nodal) = &snapshot.nodal {
        return plot.quads.iter().map(|quad| quad.map(|node| colour(nodal[node as usize]))).collect();
    }
    let Some(values) = &snapshot.values else {
        return vec![[of_instant(plot, number); 4]; plot.quads.len()];
    };
    if !plot.smooth {
        return values.iter().map(|&v| [colour(v); 4]).collect();
    }
    let mut sums = vec![(0.0, 0.0); snapshot.positions.len()];
    for (quad, &value) in plot.quads.iter().zip(values).filter(|(_, v)| v.is_finite()) {
        for &node in quad {
            sums[node as usize].0 += value;
            sums[node as usize].1 += 1.0;
        }
    }
    let at_node = |node: u32| {
        let (sum, count) = sums[node as usize];
        colour(sum / count)
    };
    let quads = plot.quads.iter().zip(values);
    quads.map(|(quad, v)| if v.is_finite() { quad.map(at_node) } else { [Rgb::MISSING; 4] }).collect()
}

/// Colour of a snapshot without values: they run from sand to brick.
fn of_instant(plot: &SurfacePlot, number: usize) -> Rgb {
    let last = plot.snapshots.len().saturating_sub(1).max(1) as f64;
    let share = if plot.snapshots.len() == 1 { 0.5 } else { number as f64 / last };
    let (sand, terracotta, brick) = (Rgb::hex(0xf3e3cc), Rgb::hex(0xe0a06f), Rgb::hex(0xc0603a));
    if share < 0.5 { sand.mix(terracotta, 2.0 * share) } else { terracotta.mix(brick, 2.0 * share - 1.0) }
}

fn remarks(left_out: usize, odd_values: usize) -> String {
    let mut remarks = Vec::new();
    let plural = |n: usize, what: &str| if n == 1 { format!("1 {what}") } else { format!("{n} {what}s") };
    if left_out > 0 {
        remarks.push(format!("{} left out: positions not finite.", plural(left_out, "element")));
    }
    if odd_values > 0 {
        remarks.push(format!("{} not finite, in grey.", plural(odd_values, "value")));
    }
    remarks.join("  ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{FRAC_PI_2, PI};

    /// A quarter cylinder (radius 1, length 1.6) hung at one corner, turned about the corner and breathing.
    fn pendulum(n: usize, instants: usize) -> SurfacePlot {
        let (along, round) = (n, n);
        let node = |i: usize, j: usize| (i * (round + 1) + j) as u32;
        let quads: Vec<[u32; 4]> = (0..along)
            .flat_map(|i| {
                (0..round).map(move |j| [node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)])
            })
            .collect();
        let snapshots = (0..instants)
            .map(|k| {
                let share = k as f64 / (instants - 1).max(1) as f64;
                let swing = -0.15 - share * 0.85 * PI;
                let (sin, cos) = swing.sin_cos();
                let positions = (0..=along)
                    .flat_map(|i| (0..=round).map(move |j| (i, j)))
                    .map(|(i, j)| {
                        let (u, v) = (i as f64 / along as f64, j as f64 / round as f64);
                        let flap = 0.25 * (5.0 * share).sin() * u * u;
                        let angle = FRAC_PI_2 * v * (1.0 + flap);
                        let (x, y, z) = (1.6 * u, angle.sin(), 1.0 - angle.cos() - 0.1 * flap);
                        [x * cos - 0.35 * z * sin, y, x * sin + 0.9 * z * cos]
                    })
                    .collect();
                let values = quads
                    .iter()
                    .enumerate()
                    .map(|(e, _)| {
                        let (u, v) = ((e / round) as f64 / along as f64, (e % round) as f64 / round as f64);
                        40.0 * (1.0 - u) * (0.4 + (3.0 * v + 4.0 * share).sin().powi(2)) + 2.0
                    })
                    .collect();
                Snapshot {
                    positions,
                    values: Some(values),
                    label: format!("t = {:.1} s", 0.2 * k as f64),
                    ..Snapshot::default()
                }
            })
            .collect();
        SurfacePlot {
            title: "Quarter cylinder swinging from its corner".into(),
            snapshots,
            quads,
            view: View { azimuth_deg: -70.0, elevation_deg: 18.0 },
            color_label: "membrane force [N/m]".into(),
            ..SurfacePlot::default()
        }
    }

    /// Saves into the folder named by `TEGULA_PLOTS`, to be looked at, or into a temporary one.
    fn save(name: &str, plot: &SurfacePlot) -> Vec<u8> {
        let temporary = tempfile::tempdir().unwrap();
        let folder = std::env::var_os("TEGULA_PLOTS").map_or(temporary.path().to_path_buf(), Into::into);
        let path = folder.join(name);
        surfaces(&path, plot).unwrap();
        std::fs::read(&path).unwrap()
    }

    fn coloured(plot: &SurfacePlot) -> f64 {
        let pixels = draw(plot).unwrap().pixels();
        let grey = |p: &[u8]| p[0].abs_diff(p[1]) < 12 && p[1].abs_diff(p[2]) < 12;
        pixels.chunks(3).filter(|p| !grey(p)).count() as f64 / (pixels.len() / 3) as f64
    }

    #[test]
    #[ignore = "long"]
    fn a_swinging_quarter_cylinder() {
        let plot = pendulum(16, 6);
        assert!(coloured(&plot) > 0.15);
        assert_eq!(
            save("pendulum.png", &plot),
            save("pendulum.png", &plot),
            "the same model, the same picture"
        );
    }

    #[test]
    #[ignore = "long"]
    fn labels_and_their_leaders_keep_clear_of_each_other() {
        for (size, instants) in [((1200, 800), 6), ((1200, 800), 12), ((700, 500), 8)] {
            let plot = SurfacePlot { size, ..pendulum(10, instants) };
            let (_, (boxes, leaders)) = labelled(&plot, Canvas::new(plot.size.0, plot.size.1)).unwrap();
            assert!(boxes.len() >= instants - 2, "{} labels", boxes.len());
            for (i, a) in boxes.iter().enumerate() {
                let apart = |b: &[[f64; 2]; 2]| (0..2).any(|k| a[1][k] <= b[0][k] || b[1][k] <= a[0][k]);
                assert!(boxes[..i].iter().all(apart), "{size:?} {instants}");
                let inner = [[a[0][0] + 1.0, a[0][1] + 1.0], [a[1][0] - 1.0, a[1][1] - 1.0]];
                let crossed = leaders.iter().any(|l| super::super::legend::crosses(l, inner[0], inner[1]));
                assert!(!crossed, "{size:?} {instants}: a leader runs through a label");
            }
        }
    }

    #[test]
    #[ignore = "long"]
    fn without_values_and_see_through() {
        let mut plot = pendulum(12, 7);
        for snapshot in &mut plot.snapshots {
            snapshot.values = None;
            snapshot.opacity = 0.75;
        }
        assert!(coloured(&plot) > 0.15);
        save("pendulum plain.png", &plot);
    }

    #[test]
    #[ignore = "long"]
    fn one_fine_snapshot_with_a_value_per_element() {
        let mut plot = pendulum(100, 1);
        plot.snapshots[0].label.clear();
        let smooth = draw(&plot).unwrap().pixels();
        plot.smooth = false;
        assert!(coloured(&plot) > 0.1);
        assert!(draw(&plot).unwrap().pixels() != smooth, "each element has the colour of its value");
        save("one.png", &plot);
    }

    #[test]
    fn a_field_without_any_value_is_grey() {
        let mut plot = pendulum(2, 1);
        plot.snapshots[0].nodal = None;
        plot.snapshots[0].values = Some(vec![f64::NAN; plot.quads.len()]);
        assert_eq!(colours(&plot, 0, &plot.snapshots[0], None), vec![[Rgb::MISSING; 4]; plot.quads.len()]);
        plot.snapshots[0].values = None;
        assert_eq!(
            colours(&plot, 0, &plot.snapshots[0], None),
            vec![[of_instant(&plot, 0); 4]; plot.quads.len()]
        );
    }

    #[test]
    fn holes_are_left_out_and_said() {
        let mut plot = pendulum(8, 2);
        plot.snapshots[0].positions[20] = [f64::NAN; 3];
        if let Some(values) = &mut plot.snapshots[1].values {
            values[3] = f64::NAN;
        }
        let canvas = draw(&plot).unwrap();
        assert!(canvas.pixels().iter().any(|&b| b < 100));
        save("holes.png", &plot);
        assert_eq!(remarks(4, 0), "4 elements left out: positions not finite.");
    }

    #[test]
    fn what_cannot_be_drawn_is_refused() {
        let refusal = |plot: &SurfacePlot| surfaces(Path::new("never.png"), plot).unwrap_err().to_string();
        assert!(refusal(&SurfacePlot::default()).contains("at least one snapshot"));
        let mut plot = pendulum(2, 1);
        plot.quads[0][0] = 77;
        assert!(refusal(&plot).contains("node 77"));
        let mut plot = pendulum(2, 1);
        plot.snapshots[0].values = Some(vec![1.0]);
        assert!(refusal(&plot).contains("1 values for 4 elements"));
        let mut plot = pendulum(2, 1);
        for x in &mut plot.snapshots[0].positions {
            *x = [f64::INFINITY; 3];
        }
        assert!(refusal(&plot).contains("finite positions"));
        assert!(!Path::new("never.png").exists());
    }
}
