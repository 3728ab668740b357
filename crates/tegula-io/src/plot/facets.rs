//! Shells as facets: each quadrilateral is cut into small pieces of its bilinear surface, shaded by their
//! normals.
//!
//! Cutting makes warped elements look smooth. Facets are sorted by their depths sample by sample (the A-buffer of
//! L. Carpenter, *The A-buffer, an antialiased hidden surface method*, SIGGRAPH 1984), so that sheets that cross meet in one
//! line, also where they are transparent.
//! Mesh lines are shaded into the facets instead of being drawn over them: each element carries half of the line,
//! so a line is hidden exactly where its element is.

use std::collections::HashMap;

use super::canvas::{Canvas, Point};
use super::colour::Rgb;
use super::projection::{Placement, Vec3};

/// Sides of a facet, pixels; smaller elements are not cut.
const FACET: f64 = 7.0;
/// Facets of a picture, about; many elements need no cutting anyway.
const MOST: usize = 600_000;
/// Rows of samples that are painted at a time.
const BAND: usize = 128;
/// Elements smaller than this many pixels get no mesh lines.
const SMALLEST_WITH_LINES: f64 = 6.0;

/// Cosine of the angle between faces of bodies from which their common side is an edge.
const SHARP: f64 = 0.8;

/// Part of the depth of a facet within which two snapshots count as one surface.
const COPLANAR: f64 = 0.1;

/// One quadrilateral to be painted.
pub(super) struct Patch {
    /// Corners as seen: to the right, up, towards the viewer.
    pub(super) corners: [Vec3; 4],
    /// Colours of the corners before shading.
    pub(super) colours: [Rgb; 4],
    pub(super) opacity: f64,
    /// Number of the snapshot it belongs to.
    pub(super) owner: u16,
    /// Whether each side, from corner i to corner i + 1, is an edge: it has no neighbour, or one at an angle.
    pub(super) edges: [bool; 4],
    /// Whether it is an element, with mesh lines.
    pub(super) meshed: bool,
}

/// Which snapshot is seen at each pixel: its number plus one, 0 for none.
pub(super) struct Owners {
    width: usize,
    height: usize,
    numbers: Vec<u16>,
}

impl Owners {
    pub(super) fn at(&self, [x, y]: Point) -> u16 {
        if x < 0.0 || y < 0.0 || x >= self.width as f64 || y >= self.height as f64 {
            return 0;
        }
        self.numbers[y as usize * self.width + x as usize]
    }
}

/// A piece of a patch.
struct Facet {
    patch: u32,
    corners: [Point; 4],
    /// Corners as seen.
    seen: [Vec3; 4],
    light: f64,
    colour: Rgb,
    /// Whether it touches a side of its patch.
    outer: bool,
}

/// Side of a quadrilateral, from corner i to corner i + 1.
fn side(quad: &[u32; 4], i: usize) -> (u32, u32) {
    let (a, b) = (quad[i], quad[(i + 1) % 4]);
    (a.min(b), a.max(b))
}

/// Which sides of which quadrilaterals belong to no other, or to one at an angle.
pub(super) fn sharp_sides(quads: &[[u32; 4]], nodes: &[Vec3]) -> Vec<[bool; 4]> {
    let normal = |quad: &[u32; 4]| {
        let [a, b, c, d] = quad.map(|node| nodes[node as usize]);
        (c - a).cross(&(d - b)).normalize()
    };
    let mut normals: HashMap<(u32, u32), Vec<Vec3>> = HashMap::with_capacity(2 * quads.len());
    for quad in quads {
        for i in 0..4 {
            normals.entry(side(quad, i)).or_default().push(normal(quad));
        }
    }
    let sharp = |sides: &Vec<Vec3>| match sides[..] {
        [a, b] => a.dot(&b).abs() < SHARP,
        _ => true,
    };
    // A triangle has its last corner twice, and no side between the two.
    let is_side = |quad: &[u32; 4], i: usize| quad[i] != quad[(i + 1) % 4];
    let edge = |quad: &[u32; 4], i: usize| is_side(quad, i) && normals.get(&side(quad, i)).is_none_or(sharp);
    quads.iter().map(|quad| std::array::from_fn(|i| edge(quad, i))).collect()
}

/// Which sides of which quadrilaterals belong to no other.
pub(super) fn free_sides(quads: &[[u32; 4]]) -> Vec<[bool; 4]> {
    let mut count: HashMap<(u32, u32), u32> = HashMap::with_capacity(2 * quads.len());
    for quad in quads {
        for i in 0..4 {
            *count.entry(side(quad, i)).or_default() += 1;
        }
    }
    quads.iter().map(|quad| std::array::from_fn(|i| count.get(&side(quad, i)) == Some(&1))).collect()
}

/// Paints all patches and says which snapshot is seen where.
pub(super) fn paint(canvas: &mut Canvas, placement: &Placement, patches: &[Patch]) -> Owners {
    let length = |p: &Patch, i: usize| {
        let d = p.corners[(i + 1) % 4] - p.corners[i];
        d.x.hypot(d.y) * placement.scale
    };
    let mut lengths: Vec<f64> =
        patches.iter().filter(|patch| patch.meshed).flat_map(|p| (0..4).map(|i| length(p, i))).collect();
    lengths.sort_by(f64::total_cmp);
    let typical = lengths.get(lengths.len() / 2).copied().unwrap_or(0.0);
    let longest = patches.iter().flat_map(|p| (0..4).map(|i| length(p, i))).fold(0.0, tegula::norm::larger);
    let affordable = (MOST / patches.len().max(1)).isqrt().clamp(1, 24);
    let cuts = ((longest / FACET).ceil() as usize).clamp(1, affordable);

    let mut facets: Vec<Facet> = Vec::with_capacity(patches.len() * cuts * cuts);
    for (index, patch) in patches.iter().enumerate() {
        cut(index as u32, patch, cuts, placement, &mut facets);
    }
    let surface = Shading::new(patches, placement, typical);
    let bias = coplanar_bias(patches, cuts);
    // Depths count from here, so that single precision serves models far from the origin.
    let zero = patches.first().map_or(0.0, |p| p.corners[0].z);
    let (width, height) = canvas.size();
    let (width, height) = (width as usize, height as usize);
    let mut owners = Owners { width, height, numbers: vec![0; width * height] };
    let grid = canvas.grid();
    let mut layers = Layers::default();
    for first in (0..grid.rows).step_by(BAND) {
        let rows = first..grid.rows.min(first + BAND as u32);
        let before = first as usize * grid.columns as usize;
        let seen = |facet: &Facet| {
            let y = facet.corners.map(|c| c[1] * f64::from(grid.scale));
            y.iter().any(|y| *y >= f64::from(rows.start)) && y.iter().any(|y| *y <= f64::from(rows.end))
        };
        for (number, facet) in (0_u32..).zip(&facets).filter(|(_, facet)| seen(facet)) {
            let patch = &patches[facet.patch as usize];
            let nearer = bias * f64::from(patch.owner) - zero;
            for [a, b, c] in [[0, 1, 2], [2, 3, 0]] {
                let plane = Plane::through([facet.seen[a], facet.seen[b], facet.seen[c]], placement);
                let corners = [facet.corners[a], facet.corners[b], facet.corners[c]];
                grid.each_within(&corners, rows.clone(), |at, sample| {
                    layers.push(Fragment {
                        sample: (sample - before) as u32,
                        depth: (plane.depth(at) + nearer) as f32,
                        facet: number,
                    });
                });
            }
        }
        let opacity = |fragment: &Fragment| patches[facets[fragment.facet as usize].patch as usize].opacity;
        let covers = |fragment: &Fragment| opacity(fragment) == 1.0;
        layers.each_from_the_back(covers, |fragment| {
            let facet = &facets[fragment.facet as usize];
            let sample = before + fragment.sample as usize;
            let (row, column) = (sample / grid.columns as usize, sample % grid.columns as usize);
            let scale = grid.scale as usize;
            let at = [column, row].map(|n| (n as f64 + 0.5) / scale as f64);
            canvas.blend(sample, surface.colour(facet, at), opacity(fragment));
            owners.numbers[row / scale * width + column / scale] = patches[facet.patch as usize].owner + 1;
        });
    }
    owners
}

/// How mesh lines and light colour a facet.
struct Shading<'a> {
    patches: &'a [Patch],
    /// Sides of the patches on the sheet.
    sides: Vec<[Point; 4]>,
    /// Half the width of a mesh line, if there are any.
    half: Option<f64>,
    ink: f64,
}

impl<'a> Shading<'a> {
    /// For patches whose sides have a `typical` length in pixels.
    fn new(patches: &'a [Patch], placement: &Placement, typical: f64) -> Self {
        let half = (typical >= SMALLEST_WITH_LINES).then_some((typical / 40.0).clamp(0.3, 0.5));
        // Fine meshes would turn dark under full lines.
        let ink = 0.45 * ((typical - SMALLEST_WITH_LINES / 2.0) / 14.0).clamp(0.0, 1.0);
        let sides = patches.iter().map(|patch| patch.corners.map(|c| placement.at(&c))).collect();
        Self { patches, sides, half, ink }
    }

    fn colour(&self, facet: &Facet, at: Point) -> Rgb {
        let (patch, sides) = (&self.patches[facet.patch as usize], &self.sides[facet.patch as usize]);
        let mut colour = facet.colour;
        if facet.outer {
            let distance = |i: usize| distance_to_segment(at, sides[i], sides[(i + 1) % 4]);
            if (0..4).any(|i| patch.edges[i] && distance(i) < 1.1) {
                colour = colour.mix(Rgb::BLACK, 0.62);
            } else if patch.meshed && self.half.is_some_and(|half| (0..4).any(|i| distance(i) < half)) {
                colour = colour.mix(Rgb::BLACK, self.ink);
            }
        }
        lit(colour, facet.light)
    }
}

/// Contribution of one facet to a sample.
#[derive(Clone, Copy)]
struct Fragment {
    /// Number of the sample in its band.
    sample: u32,
    depth: f32,
    /// Number of the facet.
    facet: u32,
}

/// Fragments of a band of the sheet.
#[derive(Default)]
struct Layers {
    fragments: Vec<Fragment>,
    /// Fragments by sample, and where those of each sample begin.
    order: Vec<u32>,
    starts: Vec<u32>,
}

impl Layers {
    fn push(&mut self, fragment: Fragment) {
        self.fragments.push(fragment);
    }

    /// Hands over the fragments of all samples, sample by sample from the back to the front, and forgets them. Those behind a
    /// fragment that `covers` them are left out.
    fn each_from_the_back(&mut self, covers: impl Fn(&Fragment) -> bool, mut take: impl FnMut(&Fragment)) {
        let Self { fragments, order, starts } = self;
        // Most sheets are white where they are not crossed by the shell.
        let samples = || fragments.iter().map(|fragment| fragment.sample);
        let (Some(first), Some(last)) = (samples().min(), samples().max()) else { return };
        let place = |fragment: &Fragment| (fragment.sample - first) as usize;
        // Counting sort. The fragments of place i begin at `starts[i]` once those before it have been put in order.
        starts.clear();
        starts.resize((last - first) as usize + 3, 0);
        fragments.iter().for_each(|fragment| starts[place(fragment) + 2] += 1);
        for i in 2..starts.len() {
            starts[i] += starts[i - 1];
        }
        order.clear();
        order.resize(fragments.len(), 0);
        for (number, fragment) in (0_u32..).zip(fragments.iter()) {
            let next = &mut starts[place(fragment) + 1];
            order[*next as usize] = number;
            *next += 1;
        }
        for ends in starts.windows(2).filter(|ends| ends[0] < ends[1]) {
            let here = &mut order[ends[0] as usize..ends[1] as usize];
            // The sort is stable and the order of the facets fixed: the same model gives the same picture.
            here.sort_by(|&a, &b| fragments[a as usize].depth.total_cmp(&fragments[b as usize].depth));
            let first = here.iter().rposition(|&number| covers(&fragments[number as usize])).unwrap_or(0);
            here[first..].iter().for_each(|&number| take(&fragments[number as usize]));
        }
        fragments.clear();
    }
}

/// Depth of a triangle over the sheet, from `base` at `from` on with a `slope` along both axes of the sheet.
struct Plane {
    from: Point,
    base: f64,
    slope: [f64; 2],
    range: [f64; 2],
}

impl Plane {
    fn through([a, b, c]: [Vec3; 3], placement: &Placement) -> Self {
        let [from, pb, pc] = [a, b, c].map(|x| placement.exactly_at(&x));
        let (u, v) = ([pb[0] - from[0], pb[1] - from[1]], [pc[0] - from[0], pc[1] - from[1]]);
        let (du, dv) = (b.z - a.z, c.z - a.z);
        let area = u[0] * v[1] - u[1] * v[0];
        let slope = [(du * v[1] - dv * u[1]) / area, (dv * u[0] - du * v[0]) / area];
        let range = [a.z.min(b.z).min(c.z), a.z.max(b.z).max(c.z)];
        Self { from, base: a.z, slope, range }
    }

    /// Never beyond the depths of the corners, also where the triangle is seen from its edge.
    fn depth(&self, at: Point) -> f64 {
        let depth =
            self.base + self.slope[0] * (at[0] - self.from[0]) + self.slope[1] * (at[1] - self.from[1]);
        if depth.is_nan() { self.range[1] } else { depth.clamp(self.range[0], self.range[1]) }
    }
}

/// Depth by which each snapshot is brought nearer than the one before, so that of two in one plane, or on one curved surface
/// whose elements are its chords, the later is seen: a small part of the depth of a facet.
fn coplanar_bias(patches: &[Patch], cuts: usize) -> f64 {
    let depth = |p: &Patch| {
        let z = p.corners.map(|x| x.z);
        z.into_iter().fold(f64::NEG_INFINITY, f64::max) - z.into_iter().fold(f64::INFINITY, f64::min)
    };
    let deepest = patches.iter().map(depth).filter(|d| d.is_finite()).fold(0.0, tegula::norm::larger);
    COPLANAR * deepest / cuts as f64
}

/// Cuts a patch into `n` times `n` facets.
fn cut(index: u32, patch: &Patch, n: usize, placement: &Placement, facets: &mut Vec<Facet>) {
    let [a, b, c, d] = patch.corners;
    let weights = |s: f64, t: f64| [(1.0 - s) * (1.0 - t), s * (1.0 - t), s * t, (1.0 - s) * t];
    let point = |i: usize, j: usize| {
        let [wa, wb, wc, wd] = weights(i as f64 / n as f64, j as f64 / n as f64);
        a * wa + b * wb + c * wc + d * wd
    };
    for j in 0..n {
        for i in 0..n {
            let (s, t) = ((i as f64 + 0.5) / n as f64, (j as f64 + 0.5) / n as f64);
            let along_s = (b - a) * (1.0 - t) + (c - d) * t;
            let along_t = (d - a) * (1.0 - s) + (c - b) * s;
            let corners = [point(i, j), point(i + 1, j), point(i + 1, j + 1), point(i, j + 1)];
            let w = weights(s, t);
            let channel = |k: usize| (0..4).map(|m| w[m] * patch.colours[m].0[k]).sum::<f64>();
            facets.push(Facet {
                patch: index,
                corners: corners.map(|x| placement.at(&x)),
                seen: corners,
                light: light(along_s.cross(&along_t)),
                colour: Rgb([channel(0), channel(1), channel(2)]),
                outer: i == 0 || j == 0 || i == n - 1 || j == n - 1,
            });
        }
    }
}

/// Brightness of a facet with this normal, the same on both sides. The light comes over the viewer's left shoulder.
fn light(normal: Vec3) -> f64 {
    let length = normal.norm();
    if !(length > 0.0 && length.is_finite()) {
        return 1.0;
    }
    let normal = normal * (normal.z.signum() / length);
    let towards_light = Vec3::new(-0.45, 0.62, 0.64).normalize();
    // Half of the cosine's range is used below zero too, so that nothing is lost in the dark.
    let wrapped = 0.5 + 0.5 * normal.dot(&towards_light);
    0.64 + 0.46 * wrapped.powf(1.3)
}

/// The colour under this light; light above one whitens.
fn lit(colour: Rgb, light: f64) -> Rgb {
    if light > 1.0 { colour.mix(Rgb::WHITE, 1.5 * (light - 1.0)) } else { colour.scaled(light) }
}

fn distance_to_segment(p: Point, a: Point, b: Point) -> f64 {
    let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
    let squared = dx * dx + dy * dy;
    let along = if squared > 0.0 { ((p[0] - a[0]) * dx + (p[1] - a[1]) * dy) / squared } else { 0.0 };
    let along = along.clamp(0.0, 1.0);
    // For every pixel of every edge: pixels need no care against overflow.
    let (x, y) = (p[0] - a[0] - along * dx, p[1] - a[1] - along * dy);
    (x * x + y * y).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sides_of_a_strip() {
        let free = free_sides(&[[0, 1, 4, 3], [1, 2, 5, 4]]);
        assert_eq!(free, [[true, false, true, true], [true, true, true, false]]);
    }

    #[test]
    fn light_is_two_sided_and_bounded() {
        for normal in [Vec3::x(), Vec3::new(0.3, -0.8, 0.4), Vec3::zeros(), Vec3::new(f64::NAN, 0.0, 0.0)] {
            let brightness = light(normal);
            assert!((0.4..1.1).contains(&brightness), "{brightness}");
            if normal.z != 0.0 {
                assert_eq!(brightness, light(-normal));
            }
        }
        assert!(light(Vec3::new(-0.5, 0.6, 0.6)) > light(Vec3::new(0.5, -0.6, 0.6)));
    }

    #[test]
    fn of_two_snapshots_in_one_plane_the_later_is_seen_throughout() {
        // An inclined sheet of 6 by 6 elements that slides within its plane by part of an element.
        let sheet = |shift: f64, owner: u16| {
            let corner = move |i: usize, j: usize| {
                let [x, y] = [i as f64 + shift, j as f64 + 0.6 * shift];
                Vec3::new(x, y, 0.8 * x - 0.5 * y)
            };
            (0..36).map(move |k| {
                let (i, j) = (k / 6, k % 6);
                let corners = [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
                Patch {
                    corners,
                    colours: [Rgb::grey(0.5); 4],
                    opacity: 1.0,
                    owner,
                    edges: [false; 4],
                    meshed: true,
                }
            })
        };
        for shift in [0.0, 0.37, -0.61] {
            let patches: Vec<Patch> = sheet(0.0, 0).chain(sheet(shift, 1)).collect();
            let seen: Vec<Vec3> = patches.iter().flat_map(|p| p.corners).collect();
            let placement = Placement::fit(seen.iter(), [10.0, 10.0], [190.0, 190.0]).unwrap();
            let mut canvas = Canvas::new(200, 200);
            let owners = paint(&mut canvas, &placement, &patches);
            for k in 0..400 {
                let (x, y) = (1.0 + f64::from(k / 20) * 0.2, 1.0 + f64::from(k % 20) * 0.2);
                assert_eq!(owners.at(placement.at(&Vec3::new(x, y, 0.0))), 2, "{shift}: {x} {y}");
            }
        }
    }

    /// Two inclined sheets of 6 by 6 elements cross along a line at `angle`, their elements shifted against each other.
    #[test]
    #[ignore = "long"]
    fn sheets_that_cross_at_a_small_angle_change_places_along_one_line() {
        let sheet = |angle: f64, shift: f64, owner: u16, opacity: f64| {
            let corner = move |i: usize, j: usize| {
                let [x, y] = [i as f64 + shift, j as f64 + 0.6 * shift];
                Vec3::new(x, y, 0.8 * x - 0.5 * y + angle * (x - 3.0))
            };
            (0..36).map(move |k| {
                let (i, j) = (k / 6, k % 6);
                let corners = [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
                Patch {
                    corners,
                    colours: [Rgb::grey(0.5); 4],
                    opacity,
                    owner,
                    edges: [false; 4],
                    meshed: true,
                }
            })
        };
        for (angle, opacity) in [(0.3, 1.0), (0.1, 0.6), (0.03, 1.0), (0.03, 0.6)] {
            let patches: Vec<Patch> =
                sheet(angle, 0.0, 0, opacity).chain(sheet(0.0, 0.37, 1, opacity)).collect();
            let seen: Vec<Vec3> = patches.iter().flat_map(|p| p.corners).collect();
            let placement = Placement::fit(seen.iter(), [10.0, 10.0], [590.0, 590.0]).unwrap();
            let mut canvas = Canvas::new(600, 600);
            let owners = paint(&mut canvas, &placement, &patches);
            for row in 0..40 {
                let y = 0.5 + f64::from(row) * 0.12;
                let along = |k: u32| owners.at(placement.at(&Vec3::new(0.5 + f64::from(k) * 0.005, y, 0.0)));
                let changes = (1..1000).filter(|&k| along(k) != along(k - 1)).count();
                assert_eq!((along(0), changes, along(999)), (2, 1, 1), "{angle}: {y}");
            }
        }
    }

    #[test]
    fn the_nearer_patch_is_seen() {
        let square = |z: f64, owner: u16| Patch {
            corners: [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|[x, y]| Vec3::new(x, y, z)),
            colours: [Rgb::grey(0.5); 4],
            opacity: 1.0,
            owner,
            edges: [true; 4],
            meshed: true,
        };
        let patches = [square(1.0, 0), square(0.0, 1)];
        let seen: Vec<Vec3> = patches[0].corners.to_vec();
        let placement = Placement::fit(seen.iter(), [10.0, 10.0], [90.0, 90.0]).unwrap();
        let mut canvas = Canvas::new(100, 100);
        let owners = paint(&mut canvas, &placement, &patches);
        assert_eq!(owners.at([50.0, 50.0]), 1);
        assert_eq!(owners.at([5.0, 5.0]), 0);
        assert_eq!(owners.at([-5.0, 500.0]), 0);
    }
}
