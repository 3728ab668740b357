//! Floating-point operations of the kernel per element: exact, whatever the compiler and the instruction set.
//!
//! Additions and multiplications of [`Lanes`](crate::element::lanes::Lanes) are counted, a fused one as two. Instructions
//! (`scripts/count_instructions.py`) also depend on the compiler and on the inlining of code that has nothing to do with
//! the kernel, and are not seen by valgrind with AVX-512. A count that grows is a slower kernel: give the reason with the
//! new number.

use pulp::Arch;

use crate::compile::build;
use crate::element::lanes::operations;
use crate::element::{TangentRequest, TangentWeights};
use crate::mesh::generators::generate;
use crate::model::{
    Analysis, Condition, CylinderMesh, ElementKind, GravityLoad, Grid, Isotropic, Load, MeshSource, Model,
    OnSet, PlateMesh, StaticAnalysis,
};
use crate::system::EvaluationPoint;

/// Number of elements: whole batches.
const ELEMENTS: usize = 64;

fn plate() -> MeshSource {
    MeshSource::Plate(PlateMesh {
        origin: [0.0; 3],
        u_axis: [1.0, 0.0, 0.0],
        v_axis: [0.0, 1.0, 0.0],
        size: [1.0, 1.0],
        grid: Grid::uniform(8, 8),
    })
}

fn cylinder() -> MeshSource {
    MeshSource::Cylinder(CylinderMesh {
        center: [0.0; 3],
        axis: [0.0, 1.0, 0.0],
        start: [0.0, 0.0, 1.0],
        radius: 1.0,
        angles: [0.0, 90.0],
        length: 1.0,
        grid: Grid::uniform(8, 8),
    })
}

/// Operations per element of the forces, and of forces with tangent, with a given instruction set or the machine's own.
fn counted(mesh: MeshSource, element: ElementKind, arch: Option<Arch>) -> [f64; 2] {
    let analysis = Analysis::Static(StaticAnalysis::default());
    let mut model = Model::new(mesh, analysis, Isotropic::new(1e6, 0.3, 1.0), 0.01);
    model.sections[0].element = element;
    model.conditions = vec![Condition::Clamp(OnSet { on: "u_min".into() })];
    model.loads = vec![Load::Gravity(GravityLoad { value: [0.0, 0.0, -1.0], amplitude: None })];
    let system = build(&model, &generate(&model.mesh).unwrap()).unwrap();
    let group = &system.groups[0];
    assert_eq!(group.len(), ELEMENTS);
    let u = vec![[1e-3; 3]; system.vectors()];
    let k = EvaluationPoint::at_rest(&system, &u, 0.0, &[]).of_group(&system, 0, &[]);
    let vectors = group.vectors_per_element();
    let mut forces = vec![0.0; ELEMENTS * 3 * vectors];
    let mut blocks = vec![0.0; ELEMENTS * 9 * vectors * (vectors + 1) / 2];
    let weights = TangentWeights::STATIC;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    pool.install(|| {
        let force = operations::of(arch, || group.evaluate(&k, 0, &mut forces, None));
        let request = TangentRequest { weights, stress: None, prescribed: None, blocks: &mut blocks };
        let both = operations::of(arch, || group.evaluate(&k, 0, &mut forces, Some(request)));
        [force, both].map(|n| n as f64 / ELEMENTS as f64)
    })
}

#[test]
fn operations_per_element_are_those_that_are_known() {
    use ElementKind::{Cm, Ems, Mitc4};
    let known = [
        ("plate", Ems, [978.0, 6660.0]),
        ("plate", Cm, [1212.0, 8706.0]),
        ("plate", Mitc4, [970.0, 5947.0]),
        ("cylinder", Ems, [1006.0, 7444.0]),
        ("cylinder", Cm, [1462.0, 11350.0]),
        ("cylinder", Mitc4, [974.0, 6023.0]),
    ];
    let mesh = |name: &str| if name == "plate" { plate() } else { cylinder() };
    let found = known.map(|(name, element, _)| (name, element, counted(mesh(name), element, None)));
    assert_eq!(found, known);
}

/// Registers of one lane need as many operations per element as those of eight lanes.
#[test]
fn operations_do_not_depend_on_the_instruction_set() {
    for element in [ElementKind::Ems, ElementKind::Cm, ElementKind::Mitc4] {
        let [here, scalar] = [None, Some(Arch::Scalar)].map(|arch| counted(cylinder(), element, arch));
        assert_eq!(here, scalar, "{element:?}");
    }
}
