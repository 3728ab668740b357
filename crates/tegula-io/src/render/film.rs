//! Films: GIF by a library, MP4 by the program `ffmpeg`.

use std::io::Write as _;
use std::path::Path;
use std::process::{Command, Stdio};

use crate::out::file::temporary_in;
use crate::out::{Destination, OutputError, write_whole};
use crate::plot::{SurfacePlot, surfaces::pixels};

/// Speed of the choice of 256 colours, from 1, best, to 30.
const SPEED: i32 = 10;

/// Kind of a film.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Encoding {
    /// Animated GIF of 256 colours a frame, repeated without end.
    Gif,
    /// H.264 in MP4, by `ffmpeg`.
    Mp4,
}

impl Encoding {
    /// Encoding by the ending of a file name; `None` for others.
    pub fn of(file: &Path) -> Option<Self> {
        match file.extension()?.to_str()?.to_lowercase().as_str() {
            "gif" => Some(Self::Gif),
            "mp4" => Some(Self::Mp4),
            _ => None,
        }
    }
}

/// Writes a film of `count` frames at a rate of frames per second; returns their number.
pub(super) fn write(
    file: &Path,
    (encoding, rate): (Encoding, f64),
    count: usize,
    frame: impl Fn(usize) -> Result<SurfacePlot, OutputError>,
) -> Result<usize, OutputError> {
    if !(rate > 0.0 && rate <= 100.0) {
        return Err(OutputError::refused(
            file,
            format!("a film of {rate} frames per second: give 100 at most, and more than 0"),
        ));
    }
    let drawn = |number: usize| -> Result<Drawn, OutputError> {
        pixels(&frame(number)?).map_err(|problem| OutputError::refused(file, problem))
    };
    match encoding {
        Encoding::Gif => gif(file, rate, count, drawn)?,
        Encoding::Mp4 => mp4(file, rate, count, drawn)?,
    }
    Ok(count)
}

type Drawn = (u32, u32, Vec<u8>);

fn gif(
    file: &Path,
    rate: f64,
    count: usize,
    drawn: impl Fn(usize) -> Result<Drawn, OutputError>,
) -> Result<(), OutputError> {
    // Hundredths of a second; a frame each is told by the sum up to it, so that the film has its length.
    let delay = |number: usize| {
        ((number as f64 + 1.0) * 100.0 / rate).round() - (number as f64 * 100.0 / rate).round()
    };
    let (width, height, first) = drawn(0)?;
    let [w, h] = [width, height].map(|n| u16::try_from(n).unwrap_or(u16::MAX));
    if u32::from(w) != width || u32::from(h) != height {
        return Err(OutputError::refused(file, "a GIF has at most 65535 × 65535 pixels"));
    }
    let failed = |error: gif::EncodingError| std::io::Error::other(error);
    let mut problem = None;
    let written = write_whole(file, |out| {
        let mut encoder = gif::Encoder::new(out, w, h, &[]).map_err(failed)?;
        encoder.set_repeat(gif::Repeat::Infinite).map_err(failed)?;
        for number in 0..count {
            let pixels = if number == 0 {
                first.clone()
            } else {
                match drawn(number) {
                    Ok((.., pixels)) => pixels,
                    Err(error) => {
                        problem = Some(error);
                        return Err(std::io::Error::other("a frame could not be drawn"));
                    }
                }
            };
            let mut frame = gif::Frame::from_rgb_speed(w, h, &pixels, SPEED);
            frame.delay = delay(number) as u16;
            encoder.write_frame(&frame).map_err(failed)?;
        }
        Ok(())
    });
    problem.map_or(written, Err)
}

fn mp4(
    file: &Path,
    rate: f64,
    count: usize,
    drawn: impl Fn(usize) -> Result<Drawn, OutputError>,
) -> Result<(), OutputError> {
    let refused = |problem: String| OutputError::refused(file, problem);
    let (width, height, first) = drawn(0)?;
    if width % 2 == 1 || height % 2 == 1 {
        return Err(refused(format!("an MP4 film has even numbers of pixels, not {width} × {height}")));
    }
    let Ok(Destination::File(target)) = Destination::of(file) else {
        return Err(refused("an MP4 film goes into a file, not into a folder, device or pipe".into()));
    };
    let folder = target.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let kept = temporary_in(folder);
    let kept = kept.map_err(|error| refused(format!("it cannot be written: {error}")))?.into_temp_path();
    let mut command = Command::new("ffmpeg");
    command.args(["-y", "-loglevel", "error", "-f", "rawvideo", "-pix_fmt", "rgb24"]);
    command.args(["-s", &format!("{width}x{height}"), "-r", &rate.to_string(), "-i", "-", "-an"]);
    command
        .args(["-c:v", "libx264", "-pix_fmt", "yuv420p", "-movflags", "+faststart", "-f", "mp4"])
        .arg(&kept);
    let child = command.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::piped()).spawn();
    let mut child = child.map_err(|error| {
        refused(format!("the program `ffmpeg` cannot be started ({error}): install it, or write a film that ends with .gif"))
    })?;
    let mut input = child.stdin.take();
    let mut feed = |pixels: &[u8]| input.as_mut().map_or(Ok(()), |input| input.write_all(pixels));
    let mut fed = feed(&first);
    let mut problem = None;
    for number in 1..count {
        match drawn(number) {
            Ok((.., pixels)) if fed.is_ok() => fed = feed(&pixels),
            Ok(_) => break,
            Err(error) => {
                problem = Some(error);
                break;
            }
        }
    }
    drop(input);
    let output = child.wait_with_output().map_err(|error| refused(format!("`ffmpeg` was lost: {error}")))?;
    if let Some(error) = problem {
        return Err(error);
    }
    if !output.status.success() || fed.is_err() {
        let said = String::from_utf8_lossy(&output.stderr);
        return Err(refused(format!(
            "`ffmpeg` failed: {}",
            said.lines().last().unwrap_or("it said nothing")
        )));
    }
    kept.persist(&target).map_err(|error| refused(format!("it cannot be written: {error}")))
}
