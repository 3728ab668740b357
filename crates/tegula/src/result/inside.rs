//! Strains and stresses inside of one element at a state.

use std::sync::Arc;

use nalgebra::{DVector, Matrix6, Vector6};

use crate::Mat3;
use crate::analysis::State;
use crate::analysis::statics::state_kinematics;
use crate::element::geometry::cross_section_frame;
use crate::element::shell::{Condensed, Station, StationResponse, condense};
use crate::element::{Interior, Kinematics, ShellGeometry};
use crate::model::PrescribedStrain;
use crate::section::CompiledSection;
use crate::section::compiled::Layer;
use crate::system::{Shell, System};

/// Factors of the prescribed strains and places of the groups' internal variables at a state.
pub struct Snapshot<'a> {
    /// The compiled model.
    pub system: &'a System,
    /// The state.
    pub state: &'a State,
    /// Factor of each field of prescribed strain.
    factors: Vec<f64>,
    /// Internal variables of each group.
    history: Vec<&'a [f64]>,
}

impl<'a> Snapshot<'a> {
    /// Of a state.
    pub fn new(system: &'a System, state: &'a State) -> Self {
        let factors =
            system.prescribed_strains.iter().map(|f| system.amplitude(f.amplitude, state.time)).collect();
        let mut rest = state.history.as_slice();
        let history = system
            .groups
            .iter()
            .map(|g| {
                let (mine, others) = rest.split_at((g.len() * g.history_per_element()).min(rest.len()));
                rest = others;
                mine
            })
            .collect();
        Self { system, state, factors, history }
    }

    /// Motion and internal variables for a group.
    pub fn kinematics(&'a self, group: usize) -> Kinematics<'a> {
        let k = state_kinematics(self.system, &self.state.u, self.state.time);
        Kinematics { interior: Interior { history: self.history[group], factors: &self.factors }, ..k }
    }

    /// Stored energy of every element of every group.
    pub fn energies(&self) -> Vec<Vec<f64>> {
        (0..self.system.groups.len())
            .map(|g| {
                let group = &self.system.groups[g];
                let mut out = vec![0.0; group.len()];
                group.energies(&self.kinematics(g), &mut out);
                out
            })
            .collect()
    }
}

/// What elements of one shape have in common.
pub struct Shape {
    section: usize,
    number: usize,
    /// Terms of the energy, in the order of [`CompiledSection::stations`].
    pub stations: Vec<Station>,
    /// Frames of the points of the mid-surface, relative to that of the centre.
    pub frames: Vec<Mat3>,
    /// How enhanced parameters follow from the samples, where all materials are linear.
    recovery: Option<Condensed>,
}

impl Shape {
    /// `None` where the element's geometry is invalid.
    fn new(
        system: &System,
        shell: &Shell,
        geometry: &ShellGeometry,
        prescribed: &[Option<&PrescribedStrain>],
    ) -> Option<Self> {
        let of = &system.sections[shell.section];
        let (section, element) = (&of.section, of.element.as_ref());
        let stations = section.stations(element, geometry, prescribed).ok()?;
        let recovery = if element.parameters() > 0 && section.is_linear() {
            Some(condense(&stations, element.samples(), element.parameters(), prescribed.len()).ok()?)
        } else {
            None
        };
        let centre = cross_section_frame(&geometry.base(0.0, 0.0, 0.0))?;
        let frame = |point| Some(centre.tr_mul(&element.operator(geometry, point, 0.0).ok()?.frame));
        let frames = (0..element.surface_points()).map(frame).collect::<Option<_>>()?;
        Some(Self { section: shell.section, number: shell.shape, stations, frames, recovery })
    }
}

/// The inside of an element.
pub struct Inside<'a> {
    section: &'a CompiledSection,
    geometry: ShellGeometry,
    element: &'a dyn crate::element::ShellElement,
    prescribed: Vec<Option<&'a PrescribedStrain>>,
    factors: &'a [f64],
    history: &'a [f64],
    /// What it shares with others.
    pub shape: Arc<Shape>,
    samples: DVector<f64>,
    parameters: DVector<f64>,
}

/// Strain at a point.
#[derive(Debug, Clone)]
pub struct PointStrain {
    /// Strains xx, yy, 2xy, zz, 2xz, 2yz in the frame, prescribed strains taken off.
    pub strain: Vector6<f64>,
    /// Orthonormal frame.
    pub frame: Mat3,
    /// Angle from the frame to the layer's first axis.
    pub turn: f64,
}

impl<'a> Inside<'a> {
    /// `None` where the element's geometry is invalid, which a built system excludes.
    pub fn new(snapshot: &'a Snapshot<'a>, shell: &'a Shell) -> Option<Self> {
        Self::after(snapshot, shell, &mut None)
    }

    /// The same after another element, which often has the same shape.
    pub fn after(
        snapshot: &'a Snapshot<'a>,
        shell: &'a Shell,
        last: &mut Option<Arc<Shape>>,
    ) -> Option<Self> {
        let system = snapshot.system;
        let of = &system.sections[shell.section];
        let (section, element) = (&of.section, of.element.as_ref());
        let prescribed: Vec<_> = shell
            .prescribed
            .iter()
            .zip(&system.prescribed_strains)
            .map(|(acts, field)| acts.then_some(&field.strain))
            .collect();
        let factors = if prescribed.is_empty() { &[][..] } else { &snapshot.factors };
        let samples: Vec<f64> = shell
            .groups
            .clone()
            .flat_map(|g| system.groups[g].sampled_strains(shell.member, &snapshot.kinematics(g)))
            .collect();
        let samples = DVector::from_vec(samples);
        let geometry = system.geometry(shell);
        let shape = match last.take() {
            Some(shape) if (shape.section, shape.number) == (shell.section, shell.shape) => shape,
            _ => Arc::new(Shape::new(system, shell, &geometry, &prescribed)?),
        };
        *last = Some(shape.clone());
        let first = shell.groups.start;
        let n = system.groups[first].history_per_element();
        let history = snapshot.history[first].get(n * shell.member..n * (shell.member + 1)).unwrap_or(&[]);
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
        Some(Self { section, geometry, element, prescribed, factors, history, shape, samples, parameters })
    }

    /// Strain of a station, prescribed strains taken off.
    pub fn station_strain(&self, station: &Station) -> DVector<f64> {
        let mut strain = &station.samples * &self.samples + &station.enhanced * &self.parameters;
        for (factor, e0) in self.factors.iter().zip(&station.prescribed) {
            strain -= e0 * *factor;
        }
        strain
    }

    /// Stress of each station with respect to its strains.
    pub fn station_stresses(&self) -> Vec<DVector<f64>> {
        let mut at = self.parameters.len();
        self.shape
            .stations
            .iter()
            .map(|s| {
                let strain = self.station_strain(s);
                match &s.response {
                    StationResponse::Linear(c) => c * strain,
                    StationResponse::Law(law) => {
                        let law = &self.section.laws[*law];
                        let n = law.history();
                        let committed = self.history.get(at..at + n).unwrap_or(&[]);
                        at += n;
                        let mut updated = committed.to_vec();
                        law.respond(&Vector6::from_column_slice(strain.as_slice()), committed, &mut updated)
                            .map_or_else(
                                || DVector::zeros(6),
                                |r| DVector::from_column_slice(r.stress.as_slice()),
                            )
                    }
                }
            })
            .collect()
    }

    /// Internal variables of the stations that have some, with the number of the law.
    pub fn station_history(&self) -> Vec<(usize, &'a [f64])> {
        let mut at = self.parameters.len();
        self.shape
            .stations
            .iter()
            .filter_map(|s| match s.response {
                StationResponse::Linear(_) => None,
                StationResponse::Law(law) => {
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
        let total = &o.samples * &self.samples + &o.enhanced * &self.parameters;
        let mut strain = Vector6::from_column_slice(total.as_slice());
        for (factor, field) in self.factors.iter().zip(&self.prescribed) {
            if let Some(p) = field {
                let e0 = self.section.prescribed_strain(p, layer, &o.frame, z).ok()?;
                strain -= e0 * *factor;
            }
        }
        Some(PointStrain { strain, turn: self.section.layer_turn(layer, &o.frame).ok()?, frame: o.frame })
    }

    /// Stress xx, yy, xy, zz, xz, yz in the frame at the height `z` of a layer whose material remembers nothing.
    pub fn stress(&self, point: usize, z: f64, layer: &Layer) -> Option<(Vector6<f64>, PointStrain)> {
        let at = self.strain(point, z, layer)?;
        let stress = match layer.law {
            None => {
                let c: Matrix6<f64> = if self.element.is_solid() {
                    self.section.stiffness_3d(layer, at.turn)
                } else {
                    self.section.stiffness_plane(layer, at.turn, &self.geometry)
                };
                c * at.strain
            }
            Some(law) => {
                let law = &self.section.laws[law];
                if law.history() != 0 {
                    return None;
                }
                law.respond(&at.strain, &[], &mut [])?.stress
            }
        };
        Some((stress, at))
    }

    /// Stress of the station of a point that is nearest to a height, and its frame.
    pub fn stress_of_nearest_station(
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
