//! Sect. 5.4 of the paper.
mod common;
use tegula::analysis::{Observer, Step, dynamics};
use tegula::model::*;
struct Watch {
    node: usize,
    rows: Vec<(f64, [f64; 3])>,
    worst: f64,
    kmax: f64,
}
impl Observer for Watch {
    fn on_step(&mut self, s: &Step) -> tegula::Result<()> {
        self.rows.push((s.state.time, s.state.u[self.node]));
        self.worst = self.worst.max(s.balance.total.abs());
        self.kmax = self.kmax.max(s.balance.kinetic);
        if s.state.step % 50 == 0 {
            println!(
                "{} t={:.5} dt={:.2e} it={} total={:.3e} K={:.3} {:?}",
                s.state.step,
                s.state.time,
                s.state.next_step,
                s.iterations,
                s.balance.total,
                s.balance.kinetic,
                s.state.u[self.node]
            );
        }
        Ok(())
    }
    fn on_iteration(&mut self, i: u32, e: f64, d: f64) {
        if std::env::var("IT").is_ok() {
            println!("   {i} {e:.1e} {d:.1e}");
        }
    }
    fn on_event(&mut self, m: &str) {
        println!("{m}");
    }
}
#[test]
fn pendulum() {
    let n: u32 = std::env::var("N").ok().and_then(|s| s.parse().ok()).unwrap_or(8);
    let mut m = common::quarter_cylinder(n, 2.1e7);
    m.conditions = vec![Condition::Spherical(OnSet { on: "u_min_v_min".into() })];
    m.sections[0].total_mass = Some(5.0);
    m.loads = vec![Load::Gravity(GravityLoad { value: [0.0, 0.0, -9.81], amplitude: None })];
    let scheme = match std::env::var("S").as_deref() {
        Ok("em") => Scheme::EnergyMomentum(EnergyMomentumScheme {}),
        Ok("hht") => Scheme::Hht(HhtScheme { alpha: -0.05 }),
        _ => Scheme::default(),
    };
    let t = TransientAnalysis {
        end_time: 1.0,
        scheme,
        tolerance: std::env::var("TOL").ok().and_then(|s| s.parse().ok()).unwrap_or(1e-5),
        time_step: std::env::var("DT").ok().and_then(|s| s.parse().ok()),
        initial_step: None,
        max_step: None,
        max_iterations: 20,
        linear: false,
    };
    m.analysis = Analysis::Transient(t.clone());
    let mesh = tegula::mesh::generators::generate(&m.mesh).unwrap();
    let s = build::build(&m, &mesh).unwrap();
    println!("mass {}", s.total_mass());
    let c = mesh.nodes_on("u_max_v_max").unwrap()[0];
    let mut w = Watch { node: s.position_of[c as usize] as usize, rows: vec![], worst: 0.0, kmax: 0.0 };
    let t0 = std::time::Instant::now();
    let o = dynamics::run(&s, &t, None, &mut w);
    match o {
        Ok(o) => {
            println!("{:?} {:?} energy {:.2e} of {:.3}", o.statistics, o.state.u[w.node], w.worst, w.kmax)
        }
        Err(e) => println!("{e}"),
    }
    println!("{:?}", t0.elapsed());
    let text: String =
        w.rows.iter().map(|(t, u)| format!("{t},{},{},{}\n", u[0] + 1.0, u[1] + 1.0, u[2] + 1.0)).collect();
    std::fs::write("/tmp/pendulum.csv", text).unwrap();
}
