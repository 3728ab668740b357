//! A load of one's own: springs to the ground under the end of a cantilever.
//!
//! `cargo run --release -p tegula --example own_load`
//!
//! The end deflects by `F/(3 E I/L³ + k)`, k the stiffness of all springs together.

use std::sync::Arc;

use tegula::analysis::{Silent, statics};
use tegula::compile::Compiler;
use tegula::element::Nodal;
use tegula::load::NodalLoad;
use tegula::load::follower::LoadStiffness;
use tegula::mesh::generators::generate;
use tegula::model::{
    Analysis, Condition, Isotropic, Load, MeshSource, Model, OnSet, PlateMesh, StaticAnalysis, VectorLoad,
};
use tegula::{Mat3, Vec3};

/// Spring along z between a point of the shell and the ground.
#[derive(Debug)]
struct Spring {
    position: [u32; 1],
    rest: f64,
    stiffness: f64,
}

impl NodalLoad for Spring {
    fn vectors(&self) -> &[u32] {
        &self.position
    }

    fn forces(&self, x: &[Vec3], out: &mut [Nodal]) {
        out[0] = [0.0, 0.0, self.stiffness * (self.rest - x[0].z)];
    }

    fn stiffness(&self, _: &[Vec3]) -> LoadStiffness {
        let mut k = [[Mat3::zeros(); 4]; 4];
        k[0][0][(2, 2)] = self.stiffness;
        k
    }
}

fn main() -> tegula::Result<()> {
    let (length, width, thickness, young, force, spring) = (1.0, 0.1, 0.01, 2.1e11, 20.0, 2e3);
    // The stiffness of the springs does not grow with the load: nothing acts at the reference.
    let options = StaticAnalysis::default();
    let mesh = MeshSource::Plate(PlateMesh::new([length, width], [20, 2]));
    let mut model =
        Model::new(mesh, Analysis::Static(options.clone()), Isotropic::new(young, 0.0, 7850.0), thickness);
    model.conditions = vec![Condition::Clamp(OnSet::new("u_min"))];
    model.loads = vec![Load::Edge(VectorLoad::new("u_max", [0.0, 0.0, force / width]))];

    let mesh = generate(&model.mesh)?;
    let mut compiler = Compiler::new(&model, &mesh)?;
    let end = mesh.nodes_on("u_max").unwrap_or_default();
    for &node in &end {
        let Some([position, _]) = compiler.vectors_of(node) else { continue };
        let rest = mesh.positions[node as usize].z;
        let stiffness = spring / end.len() as f64;
        compiler.add_load("springs", Arc::new(Spring { position: [position], rest, stiffness }));
    }
    let system = compiler.system(0, None)?;
    let state = statics::run(&system, &options, None, &mut Silent)?.state;

    let tip = state.u[system.coordinates.position_of[end[1] as usize] as usize][2];
    let beam = 3.0 * young * width * thickness.powi(3) / 12.0 / length.powi(3);
    let exact = force / (beam + spring);
    println!("deflection {:.4} mm, beam theory {:.4} mm", 1e3 * tip, 1e3 * exact);
    assert!((tip / exact - 1.0).abs() < 5e-3);
    Ok(())
}
