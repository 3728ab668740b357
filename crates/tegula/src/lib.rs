//! Flexible multibody dynamics with thin and moderately thick shells.
//!
//! A model is plain data; it is compiled on its mesh, and the compiled system is analysed:
//!
//! ```text
//! Model ──┐
//!         ├─ compile ─→ System ─→ statics, modal analysis, dynamics ─→ State ─→ results
//! Mesh  ──┘
//! ```
//!
//! | to | begin with |
//! |---|---|
//! | describe a model | [`Model`], [`model`] |
//! | make or read its mesh | [`mesh::generators`]; readers of files are in the crate `tegula-io` |
//! | compile it, check it | [`compile::build`], [`compile::check`], [`compile::Compiler`] for several analysis steps |
//! | find equilibria | [`analysis::statics`] |
//! | find natural frequencies | [`analysis::modal`] |
//! | integrate motions | [`analysis::dynamics`] |
//! | have residual, tangent and mass of a state | [`analysis::equilibrium`] |
//! | act between steps, as controllers do | [`analysis::Stepper`], [`load::Signal`] |
//! | recover displacements, reactions, stresses | [`result`] |
//!
//! A cantilever of length 10 under a force at its end, in five load steps:
//!
//! ```
//! use tegula::analysis::{Silent, State, statics};
//! use tegula::mesh::generators::generate;
//! use tegula::model::*;
//! use tegula::result::ReactionFinder;
//! use tegula::{Model, Vec3, compile};
//!
//! let mesh = MeshSource::Plate(PlateMesh::new([10.0, 1.0], [20, 2]));
//! let options = StaticAnalysis { load_steps: 5, ..StaticAnalysis::default() };
//! let steel = Isotropic::new(2.1e11, 0.0, 7850.0);
//! let mut model = Model::new(mesh, Analysis::Static(options.clone()), steel, 0.1);
//! model.conditions = vec![Condition::Clamp(OnSet::new("u_min"))];
//! model.loads = vec![Load::Edge(VectorLoad::new("u_max", [0.0, 0.0, -1e4]))];
//!
//! let mesh = generate(&model.mesh)?;
//! let system = compile::build(&model, &mesh)?;
//! let mut steps = statics::steps(&system, &options, None)?;
//! steps.begin(&mut Silent)?;
//! while steps.state().time < steps.end() {
//!     steps.advance(&mut Silent)?;
//! }
//!
//! let state: &State = steps.state();
//! let tip = mesh.nodes_on("u_max").unwrap_or_default()[0];
//! let displacement = state.u[system.coordinates.position_of[tip as usize] as usize];
//! let found = ReactionFinder::new(&system, None).find(&system, None, state);
//! // Beam theory: F L³ / (3 E I), with F = 1e4 and I = 0.1³/12.
//! assert!((displacement[2] / (-1e4 * 1e3 / (3.0 * 2.1e11 * 1e-3 / 12.0)) - 1.0).abs() < 0.01);
//! assert!((found.supports[0].force - Vec3::new(0.0, 0.0, 1e4)).norm() < 1e-6);
//! assert!(found.force_error < 1e-12 && found.moment_error < 1e-9); // residual over the forces
//! # Ok::<(), tegula::Error>(())
//! ```
//!
//! `examples/` has programs for modes and for a controller. `ARCHITECTURE.md` describes the structure of the library.

pub mod analysis;
pub mod bddc;
mod checker;
pub mod compile;
pub mod constraint;
pub mod element;
pub mod error;
mod lists;
pub mod load;
pub mod material;
pub mod mesh;
pub mod model;
pub mod result;
pub mod section;
pub mod system;

pub use error::{Error, Issue, Place, Result};
pub use mesh::Mesh;
pub use model::Model;
pub use system::System;
pub use tegula_sparse::norm;

/// A vector of three-dimensional space.
pub type Vec3 = nalgebra::Vector3<f64>;
/// A 3×3 matrix.
pub type Mat3 = nalgebra::Matrix3<f64>;

/// Fragments of code on the developer page about elements, compiled as tests of the documentation. The files of new kinds on the
/// developer pages are compiled by `scripts/adding_things.py`.
#[cfg(doctest)]
#[doc = include_str!("../../../book/src/developers/element.md")]
pub struct ElementPage;
