//! Integration rules over the interval −1…1.

/// Legendre polynomial of degree `n` and its derivative.
fn legendre(n: usize, x: f64) -> (f64, f64) {
    let (mut before, mut value) = (1.0, x);
    for k in 1..n {
        let k = k as f64;
        (before, value) = (value, ((2.0 * k + 1.0) * x * value - k * before) / (k + 1.0));
    }
    (value, n as f64 * (x * value - before) / (x * x - 1.0))
}

/// Abscissae and weights of the Gauss–Legendre rule with `n` points, ascending; exact to degree 2n − 1.
pub fn gauss(n: usize) -> Vec<(f64, f64)> {
    if n <= 1 {
        return vec![(0.0, 2.0)];
    }
    let mut rule: Vec<(f64, f64)> = (0..n)
        .map(|i| {
            let mut x = -(std::f64::consts::PI * (i as f64 + 0.75) / (n as f64 + 0.5)).cos();
            for _ in 0..20 {
                let (p, slope) = legendre(n, x);
                x -= p / slope;
            }
            let (_, slope) = legendre(n, x);
            (x, 2.0 / ((1.0 - x * x) * slope * slope))
        })
        .collect();
    symmetrize(&mut rule);
    rule
}

/// Abscissae and weights of the Gauss–Lobatto rule with `n ≥ 3` points, which include the ends; exact to degree 2n − 3.
pub fn lobatto(n: usize) -> Vec<(f64, f64)> {
    let n = n.max(3);
    let end = 2.0 / (n * (n - 1)) as f64;
    let mut rule = vec![(-1.0, end)];
    for i in 1..n - 1 {
        // Roots of P'ₙ₋₁ lie between those of Pₙ₋₁; Newton on (1 − x²) P' with Legendre's equation.
        let mut x = -(std::f64::consts::PI * i as f64 / (n - 1) as f64).cos();
        for _ in 0..40 {
            let (p, slope) = legendre(n - 1, x);
            let m = (n - 1) as f64;
            let second = (2.0 * x * slope - m * (m + 1.0) * p) / (1.0 - x * x);
            x -= slope / second;
        }
        let (p, _) = legendre(n - 1, x);
        rule.push((x, end / (p * p)));
    }
    rule.push((1.0, end));
    symmetrize(&mut rule);
    rule
}

/// Removes round-off: the rule becomes exactly symmetric about 0.
fn symmetrize(rule: &mut [(f64, f64)]) {
    let n = rule.len();
    for i in 0..n.div_ceil(2) {
        let (a, b) = (rule[i], rule[n - 1 - i]);
        let (x, w) = (0.5 * (b.0 - a.0), 0.5 * (a.1 + b.1));
        rule[i] = (-x, w);
        rule[n - 1 - i] = (x, w);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rules_integrate_polynomials_exactly() {
        for n in 1..9_usize {
            for (rule, degree) in [(gauss(n), 2 * n - 1), (lobatto(n.max(3)), 2 * n.max(3) - 3)] {
                for power in 0..=degree as i32 {
                    let sum: f64 = rule.iter().map(|(x, w)| w * x.powi(power)).sum();
                    let exact = if power % 2 == 0 { 2.0 / f64::from(power + 1) } else { 0.0 };
                    assert!((sum - exact).abs() < 1e-14, "{n} points, power {power}: {sum} for {exact}");
                }
            }
        }
    }
}
