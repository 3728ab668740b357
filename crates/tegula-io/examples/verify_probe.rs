//! probe
use tegula_io::verify::*;
fn main() {
    let names: Vec<String> = std::env::args().skip(1).collect();
    let cases: Vec<&Case> = CASES.iter().filter(|c| names.iter().any(|n| n == c.name)).collect();
    std::fs::create_dir_all("/tmp/pics").unwrap();
    let t = std::time::Instant::now();
    println!("{}", Row::heading());
    let r = run(&cases, Some(std::path::Path::new("/tmp/pics")), &mut |row| println!("{}", row.line()));
    println!(
        "{} rows, {} missed, {:?}",
        r.rows().len(),
        r.rows().iter().filter(|r| !r.pass).count(),
        t.elapsed()
    );
}
