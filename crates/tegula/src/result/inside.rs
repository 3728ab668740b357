//! Strains and stresses inside one element at a state, and their changes with a small motion about it.

use std::borrow::Cow;
use std::sync::Arc;

use nalgebra::{DMatrix, DVector, Matrix6, Vector3, Vector6};

use crate::Mat3;
use crate::analysis::State;
use crate::element::curved_strain::CurvedStrain;
use crate::element::geometry::cross_section_frame;
use crate::element::shell::{Condensed, IntegrationPoint, PointResponse, condense};
use crate::element::{GroupPoint, Motion, Nodal, ShellGeometry};
use crate::material::Response;
use crate::model::{PrescribedStrain, acting_strains};
use crate::section::CompiledSection;
use crate::section::compiled::Layer;
use crate::system::{EvaluationPoint, Shell, System};

/// Snapshot for the recovery of stresses: state of a model, or a small motion about that state.
///
/// Strains of a small motion φ about the state q are the linear ones, δs = B(q) φ, and stresses their product with the
/// material's tangent at q: a rigid motion has no stress, whatever its amplitude.
pub struct Snapshot<'a> {
    /// The compiled model.
    pub system: &'a System,
    /// The state.
    pub state: &'a State,
    /// Small motion about the state.
    small: Option<&'a [Nodal]>,
    /// Factor of each field of prescribed strain.
    factors: Vec<f64>,
}

impl<'a> Snapshot<'a> {
    /// Snapshot of a state of a model.
    pub fn new(system: &'a System, state: &'a State) -> Self {
        let factors =
            system.prescribed_strains.iter().map(|f| system.factor(&f.factor, state.time)).collect();
        Self { system, state, small: None, factors }
    }

    /// Snapshot of a small motion `shape` about a state, such as a mode.
    pub fn of_small_motion(system: &'a System, state: &'a State, shape: &'a [Nodal]) -> Self {
        Self { small: Some(shape), ..Self::new(system, state) }
    }

    /// Evaluation point of a group.
    pub fn point(&'a self, group: usize) -> GroupPoint<'a> {
        let motion = Motion::State { u: &self.state.u, velocity: self.small };
        let Self { system, state, factors, .. } = self;
        EvaluationPoint::new(system, motion, state.time, &state.history).of_group(system, group, factors)
    }

    /// Strain rates of an element of a group at the state, times the retardation time of its material: what they add to the strains from
    /// which stresses follow. `None` where they add nothing.
    fn retarded(&self, shell: &Shell, group: usize) -> Option<Vec<f64>> {
        let Self { system, state, factors, .. } = self;
        let elements = &system.groups[group];
        let (tau, linear) = (elements.retardation_time(), system.sections[shell.section].section.is_linear());
        // A static step behind a motion begins with its velocities, which act no more.
        let moves = system.moves() && !state.v.is_empty();
        if tau == 0.0 || !moves || self.small.is_some() || !linear {
            return None;
        }
        let motion = Motion::State { u: &state.u, velocity: Some(&state.v) };
        let point = EvaluationPoint::new(system, motion, state.time, &state.history);
        let mut rates = elements.strain_rates(shell.member, &point.of_group(system, group, factors));
        rates.iter_mut().for_each(|rate| *rate *= tau);
        Some(rates)
    }

    /// Sampled strains of a shell from which stresses follow: at the state, and their changes with the small motion.
    fn samples(&self, shell: &Shell) -> (DVector<f64>, Option<DVector<f64>>) {
        let of_groups = |f: &dyn Fn(usize) -> Vec<f64>| {
            DVector::from_vec(shell.groups.clone().flat_map(f).collect::<Vec<f64>>())
        };
        let groups = &self.system.groups;
        let at_state = of_groups(&|g| {
            let mut strains = groups[g].sampled_strains(shell.member, &self.point(g));
            if let Some(retarded) = self.retarded(shell, g) {
                strains.iter_mut().zip(retarded).for_each(|(strain, retarded)| *strain += retarded);
            }
            strains
        });
        let change = self.small.map(|_| of_groups(&|g| groups[g].strain_rates(shell.member, &self.point(g))));
        (at_state, change)
    }

    /// Stored energy of every element of every group at the state.
    fn energies(&self) -> Vec<Vec<f64>> {
        (0..self.system.groups.len())
            .map(|g| {
                let group = &self.system.groups[g];
                let mut out = vec![0.0; group.len()];
                group.energies(&self.point(g), &mut out);
                out
            })
            .collect()
    }

    /// Stored energies of all elements, by group, for the shells of [`System::shells`]; `None` for a small motion, whose
    /// energy is computed element by element.
    pub(super) fn stored_energies(&self) -> Option<Vec<Vec<f64>>> {
        self.small.is_none().then(|| self.energies())
    }
}

/// Data common to congruent elements. They are made from the first of the elements, so that results do not depend on
/// the order of the threads.
pub struct Shape {
    section: usize,
    number: usize,
    /// Terms of the energy (integration points), in the order in which [`CompiledSection`] lists them.
    pub integration_points: Vec<IntegrationPoint>,
    /// Number of terms that stand for points of the element; the last term may hold enhanced parameters.
    points: usize,
    /// Frames of the points of the mid-surface, relative to that of the centre.
    pub frames: Vec<Mat3>,
    /// Recovery of the enhanced parameters from the sampled strains, where all materials are linear (static
    /// condensation).
    recovery: Option<Condensed>,
    /// Part of each prescribed strain that is due to curvature, over each point of the mid-surface.
    curved: Vec<Vec<CurvedStrain>>,
}

impl Shape {
    /// `None` where the element's geometry is invalid.
    fn new(system: &System, shell: &Shell, prescribed: &[Option<&PrescribedStrain>]) -> Option<Self> {
        let of = &system.sections[shell.section];
        let (section, element) = (&of.section, of.element.as_ref());
        let geometry = &system.geometry(&Shell { member: shell.shape, ..shell.clone() });
        let integration_points = section.integration_points(element, geometry, prescribed).ok()?;
        let points =
            integration_points.len() - usize::from(!element.parameter_stiffness(geometry).is_empty());
        let recovery = if element.parameters() > 0 && section.is_linear() {
            Some(
                condense(&integration_points, element.samples(), element.parameters(), prescribed.len())
                    .ok()?,
            )
        } else {
            None
        };
        let centre = cross_section_frame(&geometry.base(0.0, 0.0, 0.0))?;
        let frame = |point| Some(centre.tr_mul(&element.operator(geometry, point, 0.0).ok()?.frame));
        let frames = (0..element.surface_points()).map(frame).collect::<Option<_>>()?;
        let curved = |point| {
            let frame = element.operator(geometry, point, 0.0).ok()?.frame;
            section.curved_strains(element, geometry, (point, &frame), prescribed).ok()
        };
        let curved = (0..element.surface_points()).map(curved).collect::<Option<_>>()?;
        Some(Self {
            section: shell.section,
            number: shell.shape,
            integration_points,
            points,
            frames,
            recovery,
            curved,
        })
    }
}

/// Sampled strains and enhanced parameters: of a state, or their changes.
#[derive(Debug, Clone)]
struct Generalised {
    samples: DVector<f64>,
    parameters: DVector<f64>,
}

impl Generalised {
    /// Strain from the rows of a strain operator.
    fn strain(&self, samples: &DMatrix<f64>, enhanced: &DMatrix<f64>) -> DVector<f64> {
        samples * &self.samples + enhanced * &self.parameters
    }
}

/// Evaluation of strains and stresses inside an element, from its state and history variables.
pub struct Inside<'a> {
    section: &'a CompiledSection,
    geometry: ShellGeometry,
    element: &'a dyn crate::element::ShellElement,
    prescribed: Vec<Option<Cow<'a, PrescribedStrain>>>,
    factors: &'a [f64],
    history: &'a [f64],
    /// Data shared with congruent elements.
    pub shape: Arc<Shape>,
    state: Generalised,
    /// Change with the small motion whose strains and stresses are recovered.
    change: Option<Generalised>,
    /// Thickness stress `σ_zz = p + q z` over each point of the mid-surface, where layers have thickness strains of their
    /// own; else empty.
    thickness_stress: Vec<[f64; 2]>,
}

/// Strain at a point.
#[derive(Debug, Clone)]
pub struct PointStrain {
    /// Strains xx, yy, 2xy, zz, 2xz, 2yz in the frame, minus the prescribed strains; for a small motion, the strains of
    /// the motion alone.
    pub strain: Vector6<f64>,
    /// Strain of the state about which a small motion is superposed.
    about: Option<Vector6<f64>>,
    /// Orthonormal frame.
    pub frame: Mat3,
    /// Angle from the frame to the layer's first axis.
    pub turn: f64,
}

impl<'a> Inside<'a> {
    /// Evaluation inside an element; `None` where the element's geometry is invalid, which a built system excludes.
    pub fn new(snapshot: &'a Snapshot<'a>, shell: &'a Shell) -> Option<Self> {
        Self::after(snapshot, shell, &mut None)
    }

    /// Evaluation inside an element after another one, which is often congruent.
    pub fn after(
        snapshot: &'a Snapshot<'a>,
        shell: &'a Shell,
        last: &mut Option<Arc<Shape>>,
    ) -> Option<Self> {
        let system = snapshot.system;
        let of = &system.sections[shell.section];
        let (section, element) = (&of.section, of.element.as_ref());
        let fields = system.prescribed_strains.iter().map(|field| &field.strain);
        let prescribed = acting_strains(fields, &shell.prescribed);
        let factors = if prescribed.is_empty() { &[][..] } else { &snapshot.factors };
        let shape = match last.take() {
            Some(shape) if (shape.section, shape.number) == (shell.section, shell.shape) => shape,
            _ => {
                let prescribed: Vec<_> = prescribed.iter().map(Option::as_deref).collect();
                Arc::new(Shape::new(system, shell, &prescribed)?)
            }
        };
        *last = Some(shape.clone());
        let first = shell.groups.start;
        let n = system.groups[first].history_per_element();
        let start = system.offsets[first].history.start + n * shell.member;
        let history = &snapshot.state.history[start..start + n];
        let (samples, change) = snapshot.samples(shell);
        let parameters = if element.parameters() == 0 {
            DVector::zeros(0)
        } else if let Some(c) = &shape.recovery {
            let mut alpha = &c.recovery * &samples;
            for (factor, field) in factors.iter().zip(&c.prescribed_parameters) {
                alpha += field * *factor;
            }
            alpha
        } else {
            DVector::from_column_slice(history.get(..element.parameters())?)
        };
        let state = Generalised { samples, parameters };
        let geometry = system.geometry(shell);
        let mut inside = Self {
            section,
            geometry,
            element,
            prescribed,
            factors,
            history,
            shape,
            state,
            change: None,
            thickness_stress: Vec::new(),
        };
        if let Some(samples) = change {
            inside.change = Some(inside.changed(samples)?);
        }
        if element.is_solid() && section.has_thickness_strain_of_layers() {
            let stresses = inside.all_point_stresses();
            let per_point = inside.shape.points / element.surface_points();
            let of_points = stresses[..inside.shape.points].chunks(per_point);
            inside.thickness_stress = of_points.map(|of| [of[0][0], of[0][1]]).collect();
        }
        Some(inside)
    }

    /// Change of the enhanced parameters with that of the sampled strains: `δα = −K_αα⁻¹ K_αs δs` with the tangents at
    /// the state.
    fn changed(&self, samples: DVector<f64>) -> Option<Generalised> {
        let count = self.element.parameters();
        let parameters = if count == 0 {
            DVector::zeros(0)
        } else if let Some(c) = &self.shape.recovery {
            &c.recovery * &samples
        } else {
            let (mut k, mut right) = (DMatrix::zeros(count, count), DVector::zeros(count));
            for (s, answer) in self.shape.integration_points.iter().zip(self.answers()) {
                let tangent = match (&s.response, answer) {
                    (PointResponse::Linear(c), _) => c.clone(),
                    (_, Some(r)) => DMatrix::from_column_slice(6, 6, r.tangent.as_slice()),
                    (_, None) => return None,
                };
                let weighted = s.enhanced.transpose() * tangent * s.weight;
                k += &weighted * &s.enhanced;
                right -= weighted * (&s.samples * &samples);
            }
            k.cholesky()?.solve(&right)
        };
        Some(Generalised { samples, parameters })
    }

    /// Response of the law of each integration point that has one, at the state; `None` where the law cannot be
    /// evaluated.
    fn answers(&self) -> Vec<Option<Response>> {
        let mut at = self.state.parameters.len();
        let mut answer = |s: &IntegrationPoint| match &s.response {
            PointResponse::Linear(_) => None,
            PointResponse::Law(law) => {
                let law = &self.section.laws[*law];
                let n = law.history();
                let committed = self.history.get(at..at + n).unwrap_or(&[]);
                at += n;
                let strain = self.strain_of_state(s);
                let mut updated = committed.to_vec();
                law.respond(&Vector6::from_column_slice(strain.as_slice()), committed, &mut updated)
            }
        };
        self.shape.integration_points.iter().map(&mut answer).collect()
    }

    /// Strain of an integration point at the state, minus the prescribed strains.
    fn strain_of_state(&self, integration_point: &IntegrationPoint) -> DVector<f64> {
        let mut strain = self.state.strain(&integration_point.samples, &integration_point.enhanced);
        for (factor, e0) in self.factors.iter().zip(&integration_point.prescribed) {
            strain -= e0 * *factor;
        }
        strain
    }

    /// Strain of an integration point, minus the prescribed strains; for a small motion, the strain of the motion
    /// alone.
    pub fn point_strain(&self, integration_point: &IntegrationPoint) -> DVector<f64> {
        match &self.change {
            None => self.strain_of_state(integration_point),
            Some(change) => change.strain(&integration_point.samples, &integration_point.enhanced),
        }
    }

    /// Stress of each integration point, conjugate to its strains; for a small motion, the stress of the motion alone.
    pub fn point_stresses(&self) -> Vec<DVector<f64>> {
        let mut stresses = self.all_point_stresses();
        stresses.truncate(self.shape.points);
        if self.thickness_stress.is_empty() {
            return stresses;
        }
        // The first point of each group holds the thickness stress, which the others lack.
        let heights = || self.section.layers.iter().flat_map(|l| l.points.iter().map(move |p| (l, p.0)));
        let per_point = self.shape.points / self.element.surface_points();
        let whole = |(point, of): (usize, &[DVector<f64>])| {
            let add = |((layer, z), stress): ((&Layer, f64), &DVector<f64>)| {
                let frame = self.element.operator(&self.geometry, point, z).map(|o| o.frame);
                let turn = frame.and_then(|frame| self.section.layer_turn(layer, &frame)).unwrap_or(f64::NAN);
                let missing = self.of_thickness_stress(&self.section.stiffness_3d(layer, turn), point, z);
                stress + DVector::from_column_slice(missing.as_slice())
            };
            heights().zip(&of[1..]).map(add).collect::<Vec<_>>()
        };
        stresses.chunks(per_point).enumerate().flat_map(whole).collect()
    }

    /// Stress that the thickness stress σ_zz over a point of the mid-surface adds to that of the condensed stiffness of a
    /// layer of stiffness C: `C e σ_zz/C₃₃`.
    fn of_thickness_stress(&self, c: &Matrix6<f64>, point: usize, z: f64) -> Vector6<f64> {
        let [p, q] = self.thickness_stress[point];
        c.column(3) * ((p + q * z) / c[(3, 3)])
    }

    fn all_point_stresses(&self) -> Vec<DVector<f64>> {
        let stress = |(s, answer): (&IntegrationPoint, Option<Response>)| match (&s.response, answer) {
            (PointResponse::Linear(c), _) => c * self.point_strain(s),
            (_, None) => DVector::zeros(6),
            (_, Some(r)) if self.change.is_none() => DVector::from_column_slice(r.stress.as_slice()),
            (_, Some(r)) => {
                let strain = Vector6::from_column_slice(self.point_strain(s).as_slice());
                DVector::from_column_slice((r.tangent * strain).as_slice())
            }
        };
        self.shape.integration_points.iter().zip(self.answers()).map(stress).collect()
    }

    /// Energy ½ δε·C δε of a small motion.
    pub(super) fn small_energy(&self) -> f64 {
        let integration_points = self.shape.integration_points.iter().zip(self.all_point_stresses());
        integration_points.map(|(s, stress)| 0.5 * s.weight * stress.dot(&self.point_strain(s))).sum()
    }

    /// Internal variables of the integration points that have a law, with the number of the law.
    pub fn point_history(&self) -> Vec<(usize, &'a [f64])> {
        let mut at = self.state.parameters.len();
        self.shape
            .integration_points
            .iter()
            .filter_map(|s| match s.response {
                PointResponse::Linear(_) => None,
                PointResponse::Law(law) => {
                    let n = self.section.laws[law].history();
                    let mine = self.history.get(at..at + n).unwrap_or(&[]);
                    at += n;
                    Some((law, mine))
                }
            })
            .collect()
    }

    /// Strain at the height `z` over a point of the mid-surface.
    pub fn strain(&self, point: usize, z: f64, layer: &Layer) -> Option<PointStrain> {
        let o = self.element.operator(&self.geometry, point, z).ok()?;
        let six = |g: &Generalised| Vector6::from_column_slice(g.strain(&o.samples, &o.enhanced).as_slice());
        let mut strain = six(&self.state);
        for ((factor, field), curved) in
            self.factors.iter().zip(&self.prescribed).zip(&self.shape.curved[point])
        {
            if let Some(p) = field {
                let mut e0 = self.section.prescribed_strain(p, layer, &o.frame, z).ok()?;
                e0 += curved.added(Vector3::new(e0[0], e0[1], e0[2]), z);
                if self.element.unit_directors() {
                    e0[3] = 0.0;
                }
                strain -= e0 * *factor;
            }
        }
        let turn = self.section.layer_turn(layer, &o.frame).ok()?;
        Some(match &self.change {
            None => PointStrain { strain, about: None, turn, frame: o.frame },
            Some(change) => PointStrain { strain: six(change), about: Some(strain), turn, frame: o.frame },
        })
    }

    /// Stress xx, yy, xy, zz, xz, yz in the frame at the height `z` of a layer whose material has no history; for a
    /// small motion, the stress of the motion alone.
    pub fn stress(&self, point: usize, z: f64, layer: &Layer) -> Option<(Vector6<f64>, PointStrain)> {
        let at = self.strain(point, z, layer)?;
        let stress = match layer.law {
            None => {
                let c: Matrix6<f64> = if self.element.is_solid() {
                    self.section.stiffness_3d(layer, at.turn)
                } else {
                    self.section.stiffness_plane(layer, at.turn, &self.geometry)
                };
                if self.thickness_stress.is_empty() {
                    c * at.strain
                } else {
                    let column = c.column(3);
                    let condensed = c - column * column.transpose() / c[(3, 3)];
                    condensed * at.strain + self.of_thickness_stress(&c, point, z)
                }
            }
            Some(law) => {
                let law = &self.section.laws[law];
                if law.history() != 0 {
                    return None;
                }
                match &at.about {
                    None => law.respond(&at.strain, &[], &mut [])?.stress,
                    Some(about) => law.respond(about, &[], &mut [])?.tangent * at.strain,
                }
            }
        };
        Some((stress, at))
    }

    /// Stress of the integration point over a point of the mid-surface that is nearest to a height, and its frame.
    pub fn stress_of_nearest_point(
        &self,
        point: usize,
        z: f64,
        points: usize,
        stresses: &[DVector<f64>],
    ) -> Option<(Vector6<f64>, Mat3)> {
        let heights: Vec<f64> =
            self.section.layers.iter().flat_map(|l| l.points.iter().map(|p| p.0)).collect();
        let per_point = stresses.len() / points;
        let first = point * per_point + usize::from(!self.element.is_solid());
        let nearest =
            (0..heights.len()).min_by(|&a, &b| (heights[a] - z).abs().total_cmp(&(heights[b] - z).abs()))?;
        let stress = stresses.get(first + nearest)?;
        let frame = self.element.operator(&self.geometry, point, heights[nearest]).ok()?.frame;
        Some((Vector6::from_column_slice(stress.as_slice()), frame))
    }
}
