//! Input files that are solved in tests.

#![allow(clippy::unwrap_used)]

use tegula::Vec3;
use tegula::analysis::{Silent, statics};
use tegula::model::Analysis;

use crate::deck::Deck;
use crate::job::{Prepared, prepare};

/// Model of an input file in its equilibrium.
pub(crate) struct Solved {
    /// Mesh and compiled model.
    pub prepared: Prepared,
    /// Displacements of the nodal vectors.
    pub u: Vec<[f64; 3]>,
}

impl Solved {
    /// Equilibrium of the static analysis of an input file of Nastran, or else of Abaqus.
    pub fn new(deck: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(if deck.contains("BEGIN BULK") { "frame.bdf" } else { "frame.inp" });
        std::fs::write(&path, deck).unwrap();
        Self::of(&Deck::read(&path).unwrap_or_else(|e| panic!("{e:#?}")))
    }

    /// Equilibrium of the static analysis of a model file.
    pub fn of(deck: &Deck) -> Self {
        let prepared = prepare(deck).unwrap_or_else(|e| panic!("{e}"));
        let Analysis::Static(options) = &deck.model.analysis else { unreachable!() };
        let outcome = statics::run(&prepared.system, options, None, &mut Silent).unwrap();
        Self { prepared, u: outcome.state.u }
    }

    /// Displacement of a body.
    pub fn moved(&self, body: &str) -> Vec3 {
        let bodies = &self.prepared.system.coordinates.bodies;
        let body = bodies.iter().find(|other| other.name == body).unwrap();
        self.u[body.centre as usize].into()
    }

    /// Rotation of a body where it is small.
    pub fn turned(&self, body: &str) -> Vec3 {
        let coordinates = &self.prepared.system.coordinates;
        let body = coordinates.bodies.iter().find(|other| other.name == body).unwrap();
        let cross =
            |v: u32| Vec3::from(coordinates.reference[v as usize]).cross(&Vec3::from(self.u[v as usize]));
        body.directors.unwrap().map(cross).iter().sum::<Vec3>() * 0.5
    }

    /// Displacement of the node of the mesh at a place.
    pub fn at(&self, place: Vec3) -> Vec3 {
        let node = self.prepared.mesh.nearest_node(place).unwrap();
        self.u[self.prepared.system.coordinates.position_of[node as usize] as usize].into()
    }
}

/// Asserts that two numbers agree but for a part of the second one.
pub(crate) fn near(found: f64, expected: f64, tolerance: f64) {
    assert!((found / expected - 1.0).abs() < tolerance, "{found} {expected}");
}
