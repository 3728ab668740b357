//! temporary
use nalgebra::{Matrix6, Vector6};
pub type Strain = Vector6<f64>;
pub type Stress = Vector6<f64>;
#[derive(Debug, Clone)]
pub struct Response {
    pub stress: Stress,
    pub tangent: Matrix6<f64>,
    pub energy: f64,
    pub dissipation: f64,
}
#[derive(Debug, Clone)]
pub enum Law {
    Linear(Matrix6<f64>),
}
impl Law {
    pub fn history(&self) -> usize {
        0
    }
    pub fn is_linear(&self) -> bool {
        true
    }
    pub fn respond(&self, strain: &Strain, _c: &[f64], _u: &mut [f64]) -> Option<Response> {
        let Self::Linear(c) = self;
        let s = c * strain;
        Some(Response { energy: 0.5 * s.dot(strain), stress: s, tangent: *c, dissipation: 0.0 })
    }
}
