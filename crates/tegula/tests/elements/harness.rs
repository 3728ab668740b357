//! One element of any type, section and material, through the interface that the program itself uses, and its energy in
//! any scalar, for derivatives by dual numbers.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector};
use tegula::Vec3;
use tegula::element::scalar::Scalar;
use tegula::element::shell::{GroupSetup, IntegrationPoint, Member, ShellElement, condense};
use tegula::element::{
    ElementGroup, GroupPoint, InternalVariables, Motion, Nodal, ShellGeometry, TangentRequest,
    TangentWeights, registry,
};
use tegula::material::NeoHookeanForm;
use tegula::model::*;
use tegula::system::VectorKind;

use crate::common::{Random, ply, strains};

/// Materials by their names.
pub type Materials = BTreeMap<String, Material>;

/// Thickness of layups.
pub const H: f64 = 0.08;
/// Young's modulus of `m` and `metal`.
pub const YOUNG: f64 = 1e3;

/// Materials of every kind: `m`, `ply`, `rubber` and `metal`.
pub fn materials() -> Materials {
    let isotropic = Material::Isotropic(Isotropic { expansion: 1e-3, ..Isotropic::new(YOUNG, 0.3, 2.0) });
    let rubber = Material::NeoHookean(NeoHookean {
        shear: 400.0,
        bulk: 4e3,
        density: 2.0,
        form: NeoHookeanForm::Split,
    });
    let metal = Material::Plastic(Plastic {
        young: YOUNG,
        poisson: 0.3,
        yield_stress: 8.0,
        hardening: 50.0,
        saturation: Some(12.0),
        saturation_rate: 10.0,
        kinematic: 30.0,
        density: 2.0,
        expansion: 1e-3,
    });
    let list = [("m", isotropic), ("ply", ply()), ("rubber", rubber), ("metal", metal)];
    BTreeMap::from(list.map(|(name, material)| (name.to_string(), material)))
}

/// A layup of plies: material, angle, part of the thickness.
pub fn layup(plies: &[(&str, f64, f64)]) -> Layup {
    let ply = |&(material, angle, part): &(&str, f64, f64)| LayupPly {
        material: Some(material.into()),
        angle,
        thickness: Some(part * H),
    };
    Layup { plies: plies.iter().map(ply).collect(), direction: [1.0, 0.3, 0.2], ..Layup::default() }
}

/// An element with nodal vectors of its own.
pub struct Element {
    pub shell: Box<dyn ShellElement>,
    pub groups: Vec<Box<dyn ElementGroup>>,
    pub kinds: Vec<VectorKind>,
    pub reference: Vec<Nodal>,
    pub points: Vec<IntegrationPoint>,
    /// Longest distance of two corners.
    pub size: f64,
    /// Whether all materials are linear.
    pub linear: bool,
    factors: Vec<f64>,
}

impl Element {
    /// An element without prescribed strains.
    pub fn new(section: &Section, materials: &Materials, geometry: &ShellGeometry) -> Self {
        Self::with_fields(section, materials, geometry, false)
    }

    /// An element on which a prescribed strain of each kind acts if there are `fields`.
    pub fn with_fields(
        section: &Section,
        materials: &Materials,
        geometry: &ShellGeometry,
        fields: bool,
    ) -> Self {
        let linear = section.compile(materials).unwrap().laws.is_empty();
        // A prestress in resultants is not available for layers that yield: `check` refuses it.
        let solid = registry::shell(section, H).is_solid();
        let count = match (fields, linear || solid) {
            (false, _) => 0,
            (true, true) => 3,
            (true, false) => 2,
        };
        Self::with_strains(section, materials, geometry, &strains()[..count])
    }

    /// An element on which prescribed strains act.
    pub fn with_strains(
        section: &Section,
        materials: &Materials,
        geometry: &ShellGeometry,
        strains: &[PrescribedStrain],
    ) -> Self {
        let compiled = section.compile(materials).unwrap();
        let shell = registry::shell(section, compiled.thickness);
        let (mut kinds, mut reference) = (Vec::new(), Vec::<Nodal>::new());
        for (i, kind) in shell.nodal_vectors().iter().enumerate() {
            for a in 0..4 {
                kinds.push(*kind);
                reference.push(match kind {
                    VectorKind::Position => geometry.positions[a].into(),
                    VectorKind::Director => geometry.directors[a].into(),
                    VectorKind::Gradient => geometry.tangents[a][i - 2].into(),
                });
            }
        }
        let linear = compiled.laws.is_empty();
        let prescribed: Vec<_> = strains.iter().map(Some).collect();
        let vectors: Vec<u32> = (0..reference.len() as u32).collect();
        let setup =
            GroupSetup { laws: compiled.laws.clone(), fields: prescribed.len(), ..GroupSetup::default() };
        let mut builder = shell.builder(setup);
        let points = compiled.integration_points(shell.as_ref(), geometry, &prescribed).unwrap();
        let mass = shell.mass(geometry, &compiled.inertia);
        builder
            .push(Member { vectors: &vectors, geometry, integration_points: points.clone(), mass })
            .unwrap();
        let factors = [0.9, 0.4, 0.7][..prescribed.len()].to_vec();
        let p = &geometry.positions;
        let size = (p[2] - p[0]).norm() + (p[3] - p[1]).norm();
        let groups = builder.finish();
        Self { shell, groups, kinds, reference, points, size, linear, factors }
    }

    fn with<R>(&self, u: &[Nodal], g: &dyn ElementGroup, f: impl FnOnce(&GroupPoint) -> R) -> R {
        let history = vec![0.0; g.history_per_element()];
        f(&GroupPoint {
            reference: &self.reference,
            motion: Motion::State { u, velocity: None },
            linear: false,
            interior: InternalVariables { history: &history, factors: &self.factors },
            inextensible: &[],
            multipliers: &[],
            time: 0.0,
            drives: &[],
            preload: 1.0,
        })
    }

    /// Stored energy, and what is dissipated on the way from the reference: the work of the forces.
    pub fn energy(&self, u: &[Nodal]) -> f64 {
        let one = |g: &dyn ElementGroup| {
            let mut e = [0.0];
            self.with(u, g, |k| g.energies(k, &mut e));
            let mut history = vec![0.0; g.history_per_element()];
            e[0] + self.with(u, g, |k| g.update_history(k, &mut history))
        };
        self.groups.iter().map(|g| one(g.as_ref())).sum()
    }

    /// Internal force.
    pub fn force(&self, u: &[Nodal]) -> DVector<f64> {
        let mut sum = DVector::zeros(3 * u.len());
        for g in &self.groups {
            let mut f = vec![0.0; 3 * u.len()];
            self.with(u, g.as_ref(), |k| g.evaluate(k, 0, &mut f, None));
            sum += DVector::from_vec(f);
        }
        sum
    }

    /// Static tangent.
    pub fn tangent(&self, u: &[Nodal]) -> DMatrix<f64> {
        self.groups.iter().map(|g| self.stiffness_of(g.as_ref(), u, TangentWeights::STATIC)).sum()
    }

    /// Forces of the stresses of the motion, and the geometric stiffness times the present nodal vectors, of each group that has the former.
    pub fn forces_of_stresses(&self, u: &[Nodal]) -> Vec<[DVector<f64>; 2]> {
        let present = DVector::from_iterator(
            3 * u.len(),
            self.reference.as_flattened().iter().zip(u.as_flattened()).map(|(x, u)| x + u),
        );
        let one = |g: &dyn ElementGroup| {
            let mut f = vec![0.0; 3 * u.len()];
            let found = self.with(u, g, |k| g.forces_of_stresses(k, 0, None, &mut f));
            let geometric = self.stiffness_of(g, u, TangentWeights::GEOMETRIC);
            found.then(|| [DVector::from_vec(f), geometric * &present])
        };
        self.groups.iter().filter_map(|g| one(g.as_ref())).collect()
    }

    /// Tangent of these weights of a group.
    fn stiffness_of(&self, g: &dyn ElementGroup, u: &[Nodal], weights: TangentWeights) -> DMatrix<f64> {
        let m = u.len();
        let mut k = DMatrix::zeros(3 * m, 3 * m);
        let (mut f, mut blocks) = (vec![0.0; 3 * m], vec![0.0; 9 * m * (m + 1) / 2]);
        let request = TangentRequest { weights, stress: None, prescribed: None, blocks: &mut blocks };
        self.with(u, g, |k| g.evaluate(k, 0, &mut f, Some(request)));
        let mut block = blocks.chunks_exact(9);
        for a in 0..m {
            for b in 0..=a {
                for (i, value) in block.next().unwrap().iter().enumerate() {
                    k[(3 * a + i / 3, 3 * b + i % 3)] += value;
                    if a != b {
                        k[(3 * b + i % 3, 3 * a + i / 3)] += value;
                    }
                }
            }
        }
        k
    }

    /// Units of the coordinates: the size of the element for positions, 1 for directors and gradients.
    pub fn units(&self) -> Vec<f64> {
        let unit = |kind: &VectorKind| if *kind == VectorKind::Position { self.size } else { 1.0 };
        self.kinds.iter().flat_map(|k| [unit(k); 3]).collect()
    }

    /// A random displacement of `part` of the units.
    pub fn displacement(&self, part: f64, random: &mut Random) -> Vec<Nodal> {
        let units = self.units();
        (0..self.kinds.len()).map(|v| (random.vector() * (part * units[3 * v])).into()).collect()
    }

    /// The displacements `u` followed by a rigid motion.
    pub fn moved(&self, u: &[Nodal], q: &nalgebra::Rotation3<f64>, shift: Vec3) -> Vec<Nodal> {
        let one = |v: usize| {
            let x0 = Vec3::from(self.reference[v]);
            let shift = if self.kinds[v] == VectorKind::Position { shift } else { Vec3::zeros() };
            (q * (x0 + Vec3::from(u[v])) + shift - x0).into()
        };
        (0..u.len()).map(one).collect()
    }

    /// Energy of linear materials as a function over any scalar, apart from the kernels: the sampled strains are quadratic
    /// forms, found from their values at few displacements, and the integration points give `½ s·Hs − n·s`.
    pub fn polynomial(&self) -> Polynomial {
        let units = self.units();
        let count = units.len();
        let (samples, parameters) = (self.shell.samples(), self.shell.parameters());
        let c = condense(&self.points, samples, parameters, self.factors.len()).unwrap();
        let (mut terms, mut first) = (Vec::new(), 0);
        for group in &self.groups {
            let at = |places: &[(usize, f64)]| {
                let mut u = vec![[0.0; 3]; self.kinds.len()];
                for &(i, value) in places {
                    u[i / 3][i % 3] += value * units[i];
                }
                self.with(&u, group.as_ref(), |k| group.sampled_strains(0, k))
            };
            let ones: Vec<_> = (0..count).map(|i| at(&[(i, 1.0)])).collect();
            // The groups of an element share its sampled strains among them.
            let samples = ones[0].len();
            let stiffness = c.stiffness.view((first, first), (samples, samples)).into_owned();
            let mut constant = DVector::zeros(samples);
            for (n, factor) in c.prescribed.iter().zip(&self.factors) {
                constant += n.rows(first, samples) * *factor;
            }
            first += samples;
            let mut linear = DMatrix::zeros(samples, count);
            let mut quadratic = vec![DMatrix::zeros(count, count); samples];
            for i in 0..count {
                let minus = at(&[(i, -1.0)]);
                for s in 0..samples {
                    linear[(s, i)] = 0.5 * (ones[i][s] - minus[s]);
                    quadratic[s][(i, i)] = 0.5 * (ones[i][s] + minus[s]);
                }
            }
            for i in 0..count {
                for j in 0..i {
                    let both = at(&[(i, 1.0), (j, 1.0)]);
                    for s in 0..samples {
                        let value = 0.5 * (both[s] - ones[i][s] - ones[j][s]);
                        quadratic[s][(i, j)] = value;
                        quadratic[s][(j, i)] = value;
                    }
                }
            }
            terms.push(Term { stiffness, constant, linear, quadratic });
        }
        Polynomial(terms)
    }
}

struct Term {
    stiffness: DMatrix<f64>,
    constant: DVector<f64>,
    linear: DMatrix<f64>,
    quadratic: Vec<DMatrix<f64>>,
}

/// Energy as a polynomial of the coordinates in their units.
pub struct Polynomial(Vec<Term>);

impl Polynomial {
    /// Energy and its gradient at the coordinates `y`.
    pub fn energy_and_force<T: Scalar>(&self, y: &[T]) -> (T, Vec<T>) {
        let zero = T::from(0.0);
        let (mut energy, mut force) = (zero, vec![zero; y.len()]);
        for term in &self.0 {
            let samples = term.stiffness.nrows();
            let (mut s, mut b) = (vec![zero; samples], vec![vec![zero; y.len()]; samples]);
            for k in 0..samples {
                let (form, linear) = (&term.quadratic[k], term.linear.row(k));
                for i in 0..y.len() {
                    let mut product = zero;
                    for (q, y) in form.column(i).iter().zip(y) {
                        if *q != 0.0 {
                            product += T::from(*q) * *y;
                        }
                    }
                    s[k] += y[i] * (T::from(linear[i]) + product);
                    b[k][i] = T::from(linear[i]) + T::from(2.0) * product;
                }
            }
            for k in 0..samples {
                let mut stress = zero;
                for (h, s) in term.stiffness.column(k).iter().zip(&s) {
                    stress += T::from(*h) * *s;
                }
                let constant = T::from(term.constant[k]);
                energy += s[k] * (T::from(0.5) * stress - constant);
                for (f, b) in force.iter_mut().zip(&b[k]) {
                    *f += (stress - constant) * *b;
                }
            }
        }
        (energy, force)
    }
}
