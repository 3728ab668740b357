//! Linear elasticity (St. Venant–Kirchhoff): stiffness from engineering constants.

use nalgebra::{Matrix2, Matrix3, Matrix6};

use super::{MaterialLaw, Response, Strain};

/// Law `S = C E` of the stiffness C.
impl MaterialLaw for Box<Matrix6<f64>> {
    fn respond(&self, strain: &Strain, _: &[f64], _: &mut [f64]) -> Option<Response> {
        let stress = **self * strain;
        let energy = 0.5 * stress.dot(strain);
        Some(Response { stress, tangent: **self, energy, dissipation: 0.0 })
    }
}

/// Hooke's law in three dimensions from Young's modulus and Poisson's ratio:
/// `λ = Eν/((1+ν)(1−2ν))`, `μ = E/(2(1+ν))`, `C = λ 1⊗1 + 2μ I`.
pub fn isotropic(young: f64, poisson: f64) -> Matrix6<f64> {
    let lambda = young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson));
    let mu = 0.5 * young / (1.0 + poisson);
    let mut c = Matrix6::zeros();
    for i in [0, 1, 3] {
        for j in [0, 1, 3] {
            c[(i, j)] = lambda;
        }
        c[(i, i)] += 2.0 * mu;
    }
    for i in [2, 4, 5] {
        c[(i, i)] = mu;
    }
    c
}

/// Plane-stress stiffness of an isotropic material: `E/(1−ν²) [1 ν 0; ν 1 0; 0 0 (1−ν)/2]`.
pub fn isotropic_plane_stress(young: f64, poisson: f64) -> Matrix3<f64> {
    let nu = poisson;
    Matrix3::new(1.0, nu, 0.0, nu, 1.0, 0.0, 0.0, 0.0, 0.5 * (1.0 - nu)) * (young / (1.0 - nu * nu))
}

/// Engineering constants of an orthotropic material; ν_ij = −ε_j/ε_i under a stress along i, ν_ij/E_i = ν_ji/E_j.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Orthotropy {
    /// E1, E2, E3 [force/area].
    pub young: [f64; 3],
    /// ν12, ν13, ν23.
    pub poisson: [f64; 3],
    /// G12, G13, G23 [force/area].
    pub shear: [f64; 3],
}

impl Orthotropy {
    /// Compliance of the normal components 1, 2, 3.
    fn compliance(&self) -> Matrix3<f64> {
        let [e1, e2, e3] = self.young;
        let [n12, n13, n23] = self.poisson;
        Matrix3::new(
            1.0 / e1,
            -n12 / e1,
            -n13 / e1, //
            -n12 / e1,
            1.0 / e2,
            -n23 / e2, //
            -n13 / e1,
            -n23 / e2,
            1.0 / e3,
        )
    }

    /// True if every strain stores energy: the compliance of the normal components is positive definite.
    pub fn is_stable(&self) -> bool {
        let scale = Matrix3::from_diagonal(&nalgebra::Vector3::from(self.young.map(f64::sqrt)));
        let unit = scale * self.compliance() * scale;
        self.shear.iter().all(|g| *g > 0.0) && unit.symmetric_eigenvalues().min() > 1e-9
    }

    /// Three-dimensional stiffness; zero if the compliance is singular.
    pub fn stiffness(&self) -> Matrix6<f64> {
        let mut c = Matrix6::zeros();
        let Some(normal) = self.compliance().try_inverse() else { return c };
        for (i, row) in [0, 1, 3].into_iter().enumerate() {
            for (j, column) in [0, 1, 3].into_iter().enumerate() {
                c[(row, column)] = 0.5 * (normal[(i, j)] + normal[(j, i)]);
            }
        }
        for (g, i) in self.shear.into_iter().zip([2, 4, 5]) {
            c[(i, i)] = g;
        }
        c
    }

    /// Reduced stiffness Q of plane stress.
    pub fn plane_stress(&self) -> Matrix3<f64> {
        let [e1, e2, _] = self.young;
        let n12 = self.poisson[0];
        let n21 = n12 * e2 / e1;
        let d = 1.0 - n12 * n21;
        Matrix3::new(e1 / d, n12 * e2 / d, 0.0, n12 * e2 / d, e2 / d, 0.0, 0.0, 0.0, self.shear[0])
    }

    /// Transverse shear stiffness diag(G13, G23).
    pub fn transverse_shear(&self) -> Matrix2<f64> {
        Matrix2::new(self.shear[1], 0.0, 0.0, self.shear[2])
    }
}
