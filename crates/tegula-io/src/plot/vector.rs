//! Vector graphics: lines, areas and letters of a picture as elements of SVG, over the samples of shaded surfaces.
//!
//! Surfaces hide each other sample by sample, which no order of polygons does where they cross: they are an image within the file. Everything else
//! stays sharp at any size, and letters can be searched and changed. See <https://www.w3.org/TR/SVG11/>.

use std::fmt::Write as _;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;

use super::canvas::{Point, text_width};
use super::colour::Rgb;
use crate::out::vtu::escape;

/// Fonts of the letters, with the widths of the first one.
const FONTS: &str = "'DejaVu Sans', Verdana, sans-serif";

/// Elements in the order in which they are drawn.
#[derive(Debug, Default)]
pub(super) struct Elements(String);

impl Elements {
    /// Closed area.
    pub(super) fn polygon(&mut self, corners: &[Point], colour: Rgb) {
        self.add(corners, &format!("<polygon points=\"{}\" fill=\"{}\"/>", listed(corners), code(colour)));
    }

    /// Filled circle.
    pub(super) fn circle(&mut self, [x, y]: Point, radius: f64, colour: Rgb) {
        let element = format!(
            "<circle cx=\"{}\" cy=\"{}\" r=\"{}\" fill=\"{}\"/>",
            short(x),
            short(y),
            short(radius),
            code(colour)
        );
        self.add(&[[x, y]], &element);
    }

    /// Chain of lines, with round corners and ends where it is `round`; `dash` is the length of strokes and of the gaps between them.
    pub(super) fn chain(
        &mut self,
        points: &[Point],
        (width, round): (f64, bool),
        dash: Option<(f64, f64)>,
        colour: Rgb,
    ) {
        let ends = if round { " stroke-linecap=\"round\" stroke-linejoin=\"round\"" } else { "" };
        let dashes = dash.map_or(String::new(), |(stroke, gap)| {
            format!(" stroke-dasharray=\"{} {}\"", short(stroke), short(gap))
        });
        let element = format!(
            "<polyline points=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"{}\"{ends}{dashes}/>",
            listed(points),
            code(colour),
            short(width)
        );
        self.add(points, &element);
    }

    /// Text whose baseline begins at a point, upwards where it is `upright`. It has the same width with any font.
    pub(super) fn text(&mut self, [x, y]: Point, size: f64, upright: bool, colour: Rgb, text: &str) {
        if text.trim().is_empty() {
            return;
        }
        let at = [x, y];
        let (x, y) = (short(x), short(y));
        let turned = if upright { format!(" transform=\"rotate(-90 {x} {y})\"") } else { String::new() };
        let element = format!(
            "<text x=\"{x}\" y=\"{y}\" font-size=\"{}\" textLength=\"{}\" lengthAdjust=\"spacingAndGlyphs\" fill=\"{}\"{turned}>{}</text>",
            short(size),
            short(text_width(text, size)),
            code(colour),
            escape(text)
        );
        self.add(&[at], &element);
    }

    /// Adds an element that has these points. Where they are not finite there is nothing to draw, as on a sheet of samples.
    fn add(&mut self, points: &[Point], element: &str) {
        if points.iter().flatten().all(|x| x.is_finite()) {
            self.0.push_str(element);
            self.0.push('\n');
        }
    }

    /// The file: a picture of this width and height in pixels, over an image in the format PNG.
    pub(super) fn document(&self, [width, height]: [f64; 2], image: &[u8]) -> String {
        let mut out = String::with_capacity(self.0.len() + image.len() * 4 / 3 + 1000);
        let _ = write!(
            out,
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
             <svg xmlns=\"http://www.w3.org/2000/svg\" xmlns:xlink=\"http://www.w3.org/1999/xlink\" width=\"{width}\" height=\"{height}\" \
             viewBox=\"0 0 {width} {height}\">\n<image width=\"{width}\" height=\"{height}\" xlink:href=\"data:image/png;base64,"
        );
        STANDARD.encode_string(image, &mut out);
        let _ =
            write!(out, "\"/>\n<g font-family=\"{FONTS}\" xml:space=\"preserve\">\n{}</g>\n</svg>\n", self.0);
        out
    }
}

fn listed(points: &[Point]) -> String {
    points.iter().map(|[x, y]| format!("{},{}", short(*x), short(*y))).collect::<Vec<_>>().join(" ")
}

/// Number to a thousandth of a pixel.
fn short(x: f64) -> String {
    let text = format!("{x:.3}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

fn code(colour: Rgb) -> String {
    let [r, g, b] = colour.bytes();
    format!("#{r:02x}{g:02x}{b:02x}")
}

#[cfg(test)]
mod tests {
    use super::super::canvas::{Anchor, Canvas};
    use super::*;

    fn drawn(draw: impl Fn(&mut Canvas)) -> String {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("picture.SVG");
        let mut canvas = Canvas::for_file(&file, (300, 200));
        draw(&mut canvas);
        canvas.save(&file).unwrap();
        std::fs::read_to_string(&file).unwrap()
    }

    /// Lines and letters are elements; surfaces are an image of twice the pixels.
    #[test]
    fn lines_and_letters_are_elements_over_an_image_of_surfaces() {
        let text = drawn(|canvas| {
            canvas.fill_with(&[[0.0, 0.0], [150.0, 0.0], [150.0, 200.0]], 1.0, |_| Rgb::BLACK);
            canvas.text([10.0, 20.0], Anchor::Start, 15.0, Rgb::INK, "σ < \"inf & NaN\" at 0.4 s");
            canvas.upright_text([290.0, 100.0], Anchor::Middle, 15.0, Rgb::INK, "Pa");
            canvas.line([0.0, 1.0], [2.5, 3.0], 1.5, Rgb::hex(0xff8000));
            canvas.polyline(&[[0.0, 0.0], [10.0, 0.0]], 2.0, Some((4.0, 3.0)), Rgb::BLACK);
            canvas.disc([5.0, 6.0], 3.25, Rgb::BLACK);
            canvas.rectangle([1.0, 2.0], [3.0, 4.0], Rgb::WHITE);
            canvas.line([f64::NAN, 0.0], [1.0, 1.0], 1.0, Rgb::BLACK);
        });
        let document = roxmltree::Document::parse(&text).unwrap();
        let all = |name: &'static str| document.descendants().filter(move |node| node.has_tag_name(name));
        let texts: Vec<_> = all("text").map(|node| node.text().unwrap()).collect();
        assert_eq!(texts, ["σ < \"inf & NaN\" at 0.4 s", "Pa"]);
        let width: f64 = all("text").next().unwrap().attribute("textLength").unwrap().parse().unwrap();
        assert!((width - text_width(texts[0], 15.0)).abs() < 1e-3);
        assert!(all("text").nth(1).unwrap().attribute("transform").unwrap().starts_with("rotate(-90 290 "));
        let lines: Vec<_> = all("polyline").collect();
        assert_eq!(lines.len(), 2);
        assert_eq!(lines[0].attribute("points"), Some("0,1 2.5,3"));
        assert_eq!(lines[0].attribute("stroke"), Some("#ff8000"));
        assert_eq!(lines[1].attribute("stroke-dasharray"), Some("4 3"));
        assert_eq!(all("circle").next().unwrap().attribute("r"), Some("3.25"));
        assert_eq!(all("polygon").next().unwrap().attribute("points"), Some("1,2 3,2 3,4 1,4"));
        let image = all("image").next().unwrap();
        let link = image.attribute(("http://www.w3.org/1999/xlink", "href")).unwrap();
        let png = STANDARD.decode(link.strip_prefix("data:image/png;base64,").unwrap()).unwrap();
        let number = |at: usize| u32::from_be_bytes(png[at..at + 4].try_into().unwrap());
        assert_eq!((&png[1..4], number(16), number(20)), (&b"PNG"[..], 600, 400));
    }
}
