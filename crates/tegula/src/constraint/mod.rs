//! Holonomic constraints and force elements: joints, springs, bushings and elastic foundations between rigid bodies, nodes and the
//! ground; sensors of their motion.
//!
//! The points and axes that a joint connects are fixed in bodies, in the ground, or at nodes. They are linear combinations
//! of nodal vectors ([`Attachment`]), because a rigid body moves as `x(X) = r + X_i d_i`; so every constraint of the usual
//! joints is a quadratic form of nodal vectors ([`Row`]), and its gradient is exact; screws and gears add multiples of angles, and points on curves take
//! the nearest point of a spline. J. García de Jalón, E. Bayo, *Kinematic
//! and dynamic simulation of multibody systems* (1994); P. Betsch, S. Leyendecker, *The discrete null space method for the
//! energy consistent integration of constrained mechanical systems. Part II: multibody dynamics*, Int. J. Numer. Meth. Engng
//! 67 (2006) 499–552.

mod attachment;
mod bushing;
mod bushing_group;
pub mod coordinate_law;
pub mod distributing;
mod foundation;
pub mod joint;
pub mod joints;
mod on_curve;
mod quadrature;
mod rotation_vector;
mod row;
mod sensor;
mod spline;
mod spring;
mod spring_across;
mod spring_law;
mod spring_series;
mod tied_node;
mod torsion_spring;
mod turning;

pub use attachment::Attachment;
pub use bushing::{Bushing, BushingResponse, LARGEST_ROTATION};
pub use bushing_group::BushingGroup;
pub use coordinate_law::{CoordinateLaw, CoordinateMode, CoordinateState};
pub use foundation::{FoundationElement, FoundationGroup};
pub use joint::{Drive, Joint, JointGroup, Role};
pub use row::{DriveValue, Quantity, Row};
pub use sensor::{ConeVolume, MaterialLine, Measure, Sensor, StrainGauge};
pub use spline::{CurvePoint, Spline};
pub use spring::{Spring, SpringGroup};
pub use spring_across::Across;
pub use spring_law::SpringLaw;
pub use tied_node::FollowedPoint;
pub use torsion_spring::{TorsionSpring, TorsionSpringGroup};
