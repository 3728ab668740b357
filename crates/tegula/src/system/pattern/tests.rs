use super::*;
use crate::Vec3;
use crate::system::supports::Support;

/// Reproducible numbers in −1…1.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(0x1405_7b7e_f767_814f);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}

/// Nodal vectors of the elements of a square of `n × n` nodes, numbered crosswise so that blocks are to be transposed.
fn quads(n: u32) -> Vec<[u32; 4]> {
    let node = |i: u32, j: u32| (i * n + j) * 37 % (n * n);
    let quad = |q: u32| {
        let (i, j) = (q / (n - 1), q % (n - 1));
        [node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)]
    };
    (0..(n - 1) * (n - 1)).map(quad).collect()
}

/// Vectors in turn free, wholly constrained, constrained along an axis and along an inclined direction.
fn frames(vectors: usize) -> LocalFrames {
    let support = |vector, direction| Support { vector, direction, motion: None, key: String::new() };
    let supports = [
        support(0, Vec3::x()),
        support(0, Vec3::y()),
        support(0, Vec3::z()),
        support(5, Vec3::y()),
        support(90, Vec3::new(0.6, 0.0, 0.8)),
    ];
    LocalFrames::new(&supports, &Default::default(), (&[], &[]), &vec![[0.0; 3]; vectors]).unwrap()
}

/// Sums elements in two batches, and compares with the dense matrix of the global degrees of freedom, rotated to the
/// local frames.
fn compare(with_mass: bool) {
    let n = 16;
    let vectors = (n * n) as usize;
    let elements = quads(n);
    let frames = frames(vectors);
    let mut random = Random(1);
    let mass: Vec<f64> = (0..10).map(|_| if with_mass { random.next() } else { 0.0 }).collect();
    let factor = 0.7;
    let mut builder = PatternBuilder::new(true);
    let halves = elements.split_at(elements.len() / 2);
    for half in [halves.0, halves.1] {
        half.iter().for_each(|vectors| builder.element(vectors, &mass));
        builder.end_batch();
    }
    let lonely = (3, 100, if with_mass { 2.5 } else { 0.0 });
    builder.mass(lonely.0, lonely.1, lonely.2);
    let pattern = builder.build(vectors, &frames).unwrap();
    assert_eq!(pattern.mass.is_empty(), !with_mass);
    assert_eq!(pattern.alone.len(), usize::from(with_mass));
    assert!(pattern.batches.iter().any(|p| p.tasks.len() > 1));

    let mut dense = vec![0.0; 9 * vectors * vectors];
    let mut masses = vec![0.0; vectors * vectors];
    let mut values = vec![f64::NAN; pattern.values()];
    let mut add_mass = |i: u32, j: u32, m: f64| {
        masses[i as usize * vectors + j as usize] += m;
        if i != j {
            masses[j as usize * vectors + i as usize] += m;
        }
    };
    add_mass(lonely.0, lonely.1, lonely.2);
    pattern.begin(factor, &frames, &mut values);
    for (batch, half) in [halves.0, halves.1].into_iter().enumerate() {
        let mut buffer = Vec::new();
        for element in half {
            let mut pair = 0;
            for a in 0..4 {
                for b in 0..=a {
                    let mut block: [f64; 9] = std::array::from_fn(|_| random.next());
                    if a == b {
                        (block[3], block[6], block[7]) = (block[1], block[2], block[5]);
                    }
                    let (i, j) = (3 * element[a] as usize, 3 * element[b] as usize);
                    for (at, k) in block.into_iter().enumerate() {
                        let (r, c) = (at / 3, at % 3);
                        dense[(i + r) * 3 * vectors + j + c] += k;
                        if a != b {
                            dense[(j + c) * 3 * vectors + i + r] += k;
                        }
                    }
                    buffer.extend(block);
                    add_mass(element[a], element[b], mass[pair]);
                    pair += 1;
                }
            }
        }
        pattern.add(batch, &buffer, factor, &frames, &mut values);
    }
    let mut mass_values = vec![f64::NAN; pattern.values()];
    pattern.mass_values(&frames, &mut mass_values);

    compare_products(
        &pattern.compressed(&frames),
        &frames,
        [&values, &mass_values],
        (factor, [&dense, &masses]),
    );
}

/// Compares products with unit vectors with those of the dense matrices of stiffness and mass, whose multiple `factor` is part of the values.
fn compare_products(
    compressed: &SymmetricPattern,
    frames: &LocalFrames,
    [values, mass_values]: [&[f64]; 2],
    (factor, [dense, masses]): (f64, [&[f64]; 2]),
) {
    let vectors = masses.len().isqrt();
    let unit = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let free: Vec<(usize, Nodal)> = (0..vectors)
        .flat_map(|v| (0..3).map(move |c| (v, c)))
        .filter(|&(v, c)| frames.of(v)[c] != CONSTRAINED)
        .map(|(v, c)| (v, frames.to_global(v, unit[c])))
        .collect();
    for (q, &(w, d)) in free.iter().enumerate() {
        let mut x = vec![0.0; free.len()];
        x[q] = 1.0;
        let (mut sparse, mut sparse_mass) = (vec![0.0; free.len()], vec![0.0; free.len()]);
        compressed.add_product(values, &x, &mut sparse);
        compressed.add_product(mass_values, &x, &mut sparse_mass);
        for (p, &(v, e)) in free.iter().enumerate() {
            let m = masses[v * vectors + w] * (0..3).map(|c| e[c] * d[c]).sum::<f64>();
            let entry = |at: usize| dense[(3 * v + at / 3) * 3 * vectors + 3 * w + at % 3];
            let k: f64 = (0..9).map(|at| e[at / 3] * entry(at) * d[at % 3]).sum();
            // Sums of few numbers up to 1.
            assert!((sparse[p] - k - factor * m).abs() <= 50.0 * f64::EPSILON, "{p} {q}: {} {k}", sparse[p]);
            assert!((sparse_mass[p] - m).abs() <= 50.0 * f64::EPSILON, "{p} {q}: {} {m}", sparse_mass[p]);
        }
    }
}

#[test]
fn the_sum_is_that_of_the_dense_matrix() {
    compare(true);
}

#[test]
fn without_mass_none_is_kept() {
    compare(false);
}

#[test]
fn mass_may_be_given_where_there_was_none() {
    let frames = LocalFrames::new(&[], &Default::default(), (&[], &[]), &[[0.0; 3]; 2]).unwrap();
    let mut pattern = PatternBuilder::new(false).build(2, &frames).unwrap();
    let mut out = [[0.0; 3]; 2];
    pattern.add_mass_product(1.0, &[[1.0; 3]; 2], &mut out);
    pattern.for_each_mass(|i, j, m| panic!("{i} {j} {m}"));
    assert_eq!(out, [[0.0; 3]; 2]);
    pattern.set_mass(|i, j| (1 + i + j) as f64);
    pattern.add_mass_product(1.0, &[[1.0; 3]; 2], &mut out);
    assert_eq!(out, [[1.0; 3], [3.0; 3]]);
}
