//! A material of one's own: Yeoh's rubber, in a strip under tension.
//!
//! `cargo run --release -p tegula --example own_material`
//!
//! ```text
//! ψ = c₁ x + c₂ x² + c₃ x³ + κ/2 (J − 1)²      x = J^(−2/3) I₁ − 3
//! ```
//!
//! Incompressible in uniaxial tension, the nominal stress is `2 (λ − λ⁻²) (c₁ + 2 c₂ x + 3 c₃ x²)` with `x = λ² + 2/λ − 3`.
//! O. H. Yeoh, *Some forms of the strain energy function for rubber*, Rubber Chem. Technol. 66 (1993) 754–771.

use std::collections::BTreeMap;
use std::sync::Arc;

use tegula::analysis::{Silent, statics};
use tegula::compile::Compiler;
use tegula::material::{Hyperelastic, MaterialLaw, NeoHookeanForm, Response, Strain};
use tegula::mesh::generators::generate;
use tegula::model::{
    Analysis, Axis, Condition, ElementKind, FixComponents, Isotropic, Material, MeshSource, Model,
    NeoHookean, NodalVector, PlateMesh, PrescribeComponent, StaticAnalysis, SymmetryPlane,
};
use tegula::result::ReactionFinder;

/// Yeoh's rubber.
#[derive(Debug)]
struct Yeoh {
    c: [f64; 3],
    bulk: f64,
}

impl MaterialLaw for Yeoh {
    fn respond(&self, strain: &Strain, _: &[f64], _: &mut [f64]) -> Option<Response> {
        // The law with c10 = 1 gives x, its first and its second derivative.
        let first = Hyperelastic::Split { c10: 1.0, c01: 0.0, bulk: 0.0 }.respond(strain)?;
        let volume = Hyperelastic::Split { c10: 0.0, c01: 0.0, bulk: self.bulk }.respond(strain)?;
        let ([c1, c2, c3], x) = (self.c, first.energy);
        let (slope, curvature) = (c1 + x * (2.0 * c2 + 3.0 * c3 * x), 2.0 * c2 + 6.0 * c3 * x);
        Some(Response {
            stress: first.stress * slope + volume.stress,
            tangent: first.tangent * slope
                + first.stress * first.stress.transpose() * curvature
                + volume.tangent,
            energy: x * (c1 + x * (c2 + c3 * x)) + volume.energy,
            dissipation: 0.0,
        })
    }
}

fn main() -> tegula::Result<()> {
    let law = Yeoh { c: [0.2, -0.005, 0.0005], bulk: 400.0 };
    let [c1, c2, c3] = law.c;
    let stretch: f64 = 3.0;
    let (length, width, thickness) = (2.0, 1.0, 0.1);

    let options = StaticAnalysis { load_steps: 8, ..StaticAnalysis::default() };
    let mesh = MeshSource::Plate(PlateMesh::new([length, width], [4, 2]));
    let mut model =
        Model::new(mesh, Analysis::Static(options.clone()), Isotropic::new(1.0, 0.3, 0.0), thickness);
    // Density, and the stiffness at zero strain for estimates; the law takes its place.
    let form = NeoHookeanForm::Split;
    let like = NeoHookean { shear: 2.0 * c1, bulk: law.bulk, density: 0.0, form };
    model.materials.insert("m".into(), Material::NeoHookean(like));
    model.sections[0].element = ElementKind::Cm;
    let plane = |on: &str, normal| Condition::Symmetry(SymmetryPlane { on: on.into(), normal });
    let flat = FixComponents { on: "all".into(), position: vec![Axis::Z], director: vec![] };
    model.conditions = vec![
        plane("u_min", [1.0, 0.0, 0.0]),
        plane("v_min", [0.0, 1.0, 0.0]),
        Condition::Fix(flat),
        Condition::Prescribe(PrescribeComponent {
            on: "u_max".into(),
            of: NodalVector::Position,
            component: Axis::X,
            value: (stretch - 1.0) * length,
            amplitude: None,
        }),
    ];

    let mesh = generate(&model.mesh)?;
    let laws: BTreeMap<String, Arc<dyn MaterialLaw>> = BTreeMap::from([("m".to_owned(), Arc::new(law) as _)]);
    let system = Compiler::with_laws(&model, &mesh, &laws)?.system(0, None)?;
    let state = statics::run(&system, &options, None, &mut Silent)?.state;
    let found = ReactionFinder::new(&system, None).find(&system, None, &state);
    let pull = found.supports.iter().map(|s| s.force.x).fold(0.0, tegula::norm::larger) / (width * thickness);

    let x = stretch * stretch + 2.0 / stretch - 3.0;
    let exact = 2.0 * (stretch - stretch.powi(-2)) * (c1 + 2.0 * c2 * x + 3.0 * c3 * x * x);
    println!("stretch {stretch}: nominal stress {pull:.5}, incompressible {exact:.5}");
    assert!((pull / exact - 1.0).abs() < 5e-3);
    Ok(())
}
