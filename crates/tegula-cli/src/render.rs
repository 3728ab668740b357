//! `tegula render`

use std::path::{Path, PathBuf};
use std::str::FromStr;

use clap::Args;
use tegula_io::plot::View;
use tegula_io::render::{self, At, Drawing, Encoding};

use crate::report::Failure;

/// Arguments of `tegula render`.
#[derive(Debug, Args)]
pub struct Arguments {
    /// Result folder of a run; of a model with steps the folder of one step
    result: PathBuf,
    /// File to write: a picture (.png, .svg), or a film of all states or of a mode (.gif; .mp4 by ffmpeg) [default: render.png in the result folder]
    #[arg(short, long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Field that gives the colours, such as `von_mises`, `displacement.z` or `stress_top.1`; `none` for one colour [default: the von Mises stress]
    #[arg(short, long, value_name = "NAME")]
    field: Option<String>,
    /// State of the picture: the one nearest to this time, load factor or position on the path [default: the last one]
    #[arg(long, value_name = "VALUE", allow_hyphen_values = true, conflicts_with = "mode")]
    at: Option<f64>,
    /// Number of the mode [default: 1]
    #[arg(long, value_name = "N")]
    mode: Option<usize>,
    /// From where to look: angle from the x axis towards the y axis, and height above the xy plane, in degrees
    #[arg(long, value_name = "AZIMUTH,ELEVATION", default_value = "-60,25", allow_hyphen_values = true)]
    view: Pair<f64>,
    /// Factor on the displacements [default: 1; modes: a tenth of the size of the model]
    #[arg(long, value_name = "FACTOR", allow_hyphen_values = true)]
    scale: Option<f64>,
    /// Values at both ends of the colours [default: the smallest and the largest]
    #[arg(long, value_name = "LOW,HIGH", allow_hyphen_values = true)]
    range: Option<Pair<f64>>,
    /// Width and height in pixels
    #[arg(long, value_name = "WIDTH,HEIGHT", default_value = "1200,800")]
    size: Pair<u32>,
    /// Frames of a film per second
    #[arg(long, value_name = "N", default_value_t = 20.0)]
    fps: f64,
}

/// Two numbers with a comma between them.
#[derive(Debug, Clone, Copy)]
struct Pair<T>(T, T);

impl<T: FromStr> FromStr for Pair<T> {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers = text.split_once(',').map(|(a, b)| (a.trim().parse(), b.trim().parse()));
        match numbers {
            Some((Ok(a), Ok(b))) => Ok(Self(a, b)),
            _ => Err("give two numbers with a comma between them".into()),
        }
    }
}

/// Draws a picture or a film.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let file = arguments.out.clone().unwrap_or_else(|| arguments.result.join("render.png"));
    let drawing = drawing(arguments)?;
    let is_picture = |file: &Path| {
        file.extension().is_some_and(|e| ["png", "svg"].iter().any(|kind| e.eq_ignore_ascii_case(kind)))
    };
    match Encoding::of(&file) {
        Some(_) if arguments.at.is_some() => {
            return Err(Failure::Usage(
                "--at chooses the state of a picture; a film shows all states".into(),
            ));
        }
        Some(encoding) => {
            let (folder, film) = (&arguments.result, (encoding, arguments.fps));
            let frames =
                render::film(folder, &drawing, film, &file).map_err(|e| Failure::File(e.to_string()))?;
            say!("{} ({frames} frames)", file.display());
        }
        None if is_picture(&file) => {
            render::still(&arguments.result, &drawing, &file).map_err(|e| Failure::File(e.to_string()))?;
            say!("{}", file.display());
        }
        None => {
            let problem = format!(
                "`{}` has no ending that names a kind of picture or film: give .png, .svg, .gif or .mp4",
                file.display()
            );
            return Err(Failure::Usage(problem));
        }
    }
    Ok(())
}

fn drawing(arguments: &Arguments) -> Result<Drawing, Failure> {
    let Arguments { field, at, mode, view, scale, range, size, .. } = arguments;
    let ([fewest, most], sides) = (tegula::model::PIXELS, [size.0, size.1]);
    if sides.iter().any(|side| !(fewest..=most).contains(side)) {
        return Err(Failure::Usage(format!("--size {},{}: give {fewest} to {most} pixels", size.0, size.1)));
    }
    if range.is_some_and(|range| !(range.0 < range.1)) {
        return Err(Failure::Usage("--range: the first value must be below the second".into()));
    }
    let numbers = [
        ("--at", *at),
        ("--scale", *scale),
        ("--view", Some(view.0)),
        ("--view", Some(view.1)),
        ("--fps", Some(arguments.fps)),
    ];
    if let Some((option, number)) =
        numbers.iter().find_map(|(option, x)| Some((option, x.filter(|x| !x.is_finite())?)))
    {
        return Err(Failure::Usage(format!("{option} {number}: give a finite number")));
    }
    if !(arguments.fps > 0.0 && arguments.fps <= 100.0) {
        return Err(Failure::Usage(format!("--fps {}: give more than 0 and 100 at most", arguments.fps)));
    }
    Ok(Drawing {
        field: field.clone(),
        at: mode.map(At::Mode).or(at.map(At::Value)).unwrap_or(At::Default),
        view: View { azimuth_deg: view.0, elevation_deg: view.1 },
        scale: *scale,
        range: range.map(|range| [range.0, range.1]),
        size: (size.0, size.1),
    })
}
