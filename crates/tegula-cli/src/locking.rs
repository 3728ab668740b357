//! `tegula locking`: what each remedy of each element is for.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Args;
use tegula::model::ElementKind;
use tegula_io::out::write_whole;
use tegula_verify::locking::{Example, Remedy, Study, csv, markdown, picture};

use crate::terminal;

/// Show what each remedy against locking does: elements × remedies × slenderness × meshes, a table and a picture
#[derive(Debug, Args)]
pub struct Locking {
    /// Problems, of: plate, arch, beam
    #[arg(long, value_delimiter = ',', default_value = "plate,arch,beam")]
    examples: Vec<String>,
    /// Elements, of: ems, cm, mitc4, solid-shell, ancf-full
    #[arg(long, value_delimiter = ',', default_value = "ems,mitc4,cm,solid-shell")]
    elements: Vec<String>,
    /// Remedies that are switched off, one at a time: nothing, ans-shear, ans-thickness, eas, thickness-eas
    #[arg(long, value_delimiter = ',', default_value = "nothing,ans-shear,ans-thickness,eas,thickness-eas")]
    without: Vec<String>,
    /// Length or radius over thickness (beam: over depth)
    #[arg(long, value_delimiter = ',', default_value = "10,100,1000", value_parser = clap::value_parser!(u32).range(2..=1_000_000))]
    slenderness: Vec<u32>,
    /// Elements along a side
    #[arg(long, value_delimiter = ',', default_value = "2,4,8,16,32", value_parser = clap::value_parser!(u32).range(1..=1024))]
    meshes: Vec<u32>,
    /// The mesh that the picture shows; the middle one unless given
    #[arg(long)]
    picture_mesh: Option<u32>,
    /// Folder for locking.csv, locking.md and locking.png
    #[arg(long, value_name = "DIR", default_value = "locking")]
    out: PathBuf,
}

impl Locking {
    /// Runs the subcommand.
    pub fn run(&self) -> ExitCode {
        match self.study().and_then(|(study, shown)| self.write(&study, shown)) {
            Ok(()) => ExitCode::SUCCESS,
            Err((message, code)) => {
                terminal::report("error", &message);
                ExitCode::from(code)
            }
        }
    }

    fn study(&self) -> Result<(Study, u32), (String, u8)> {
        let wrong = |message: String| (message, 2);
        let examples = chosen(&self.examples, "example", &Example::EVERY, |e| e.name()).map_err(wrong)?;
        let elements =
            chosen(&self.elements, "element", ElementKind::ALL, ElementKind::name).map_err(wrong)?;
        let without = chosen(&self.without, "remedy", &Remedy::EVERY, |r| r.name()).map_err(wrong)?;
        for example in &examples {
            let Some(known) = example.known() else { continue };
            if let Some(s) = self.slenderness.iter().find(|s| !known.contains(s)) {
                return Err(wrong(format!(
                    "the exact deflection of the {} is known for a slenderness of {}, not {s}; leave it out with --examples arch,beam",
                    example.name(),
                    known.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ")
                )));
            }
        }
        let mut meshes = self.meshes.clone();
        meshes.sort_unstable();
        meshes.dedup();
        let shown = self.picture_mesh.unwrap_or(meshes[meshes.len() / 2]);
        if !meshes.contains(&shown) {
            return Err(wrong(format!("the mesh {shown} of the picture is none of --meshes")));
        }
        Ok((Study { examples, elements, without, slenderness: self.slenderness.clone(), meshes }, shown))
    }

    fn write(&self, study: &Study, shown: u32) -> Result<(), (String, u8)> {
        let out = &self.out;
        std::fs::create_dir_all(out)
            .map_err(|e| (format!("the folder {} cannot be made: {e}", out.display()), 1))?;
        let rows = study.run(&mut |_| {}).map_err(|e| (e.to_string(), 3))?;
        let tables = markdown(&rows);
        save(&out.join("locking.csv"), &csv(&rows))?;
        save(&out.join("locking.md"), &tables)?;
        picture(&out.join("locking.png"), &rows, shown).map_err(|e| (e.to_string(), 1))?;
        say!("{tables}\nlocking.csv, locking.md and locking.png are in {}", out.display());
        Ok(())
    }
}

fn save(path: &Path, text: &str) -> Result<(), (String, u8)> {
    write_whole(path, |w| w.write_all(text.as_bytes())).map_err(|e| (e.to_string(), 1))
}

fn chosen<T: Copy>(
    names: &[String],
    what: &str,
    all: &[T],
    name_of: impl Fn(T) -> &'static str,
) -> Result<Vec<T>, String> {
    let find = |name: &String| {
        all.iter().copied().find(|x| name_of(*x) == name).ok_or_else(|| {
            let known: Vec<&str> = all.iter().map(|x| name_of(*x)).collect();
            format!("there is no {what} \"{name}\"; there are: {}", known.join(", "))
        })
    };
    names.iter().map(find).collect()
}
