//! Font: DejaVu Sans, compiled into the program and drawn by `plotters`.

use std::sync::OnceLock;

use plotters::backend::{BitMapBackend, DrawingBackend};
use plotters::style::{FontDesc, FontFamily, FontStyle, FontTransform, RGBColor, TextStyle, register_font};

use super::colour::Rgb;

const FAMILY: &str = "tegula";
static DEJAVU_SANS: &[u8] = include_bytes!("../../assets/DejaVuSans.ttf");
/// Height of the font's line over its em: (ascent 1901 + descent 483) / 2048. `plotters` sizes by the line.
const LINE_PER_EM: f64 = 2384.0 / 2048.0;

/// The font at `em` samples per em.
fn font(em: f64) -> FontDesc<'static> {
    static REGISTERED: OnceLock<()> = OnceLock::new();
    // A font that cannot be read would show in the tests; at run time the picture would lack its letters.
    REGISTERED.get_or_init(|| register_font(FAMILY, FontStyle::Normal, DEJAVU_SANS).unwrap_or(()));
    FontDesc::new(FontFamily::Name(FAMILY), em * LINE_PER_EM, FontStyle::Normal)
}

/// Width of `text` in ems.
pub(super) fn width(text: &str) -> f64 {
    // Measured large, because the backend rounds to whole pixels.
    const MEASURE: f64 = 200.0;
    font(MEASURE).layout_box(text).map_or(0.0, |((x0, _), (x1, _))| f64::from(x1 - x0) / MEASURE)
}

/// Draws `text` with its baseline beginning at `(x, y)`, upwards if `upright`, into a buffer of RGB samples.
pub(super) fn draw(
    buffer: &mut [u8],
    size: (u32, u32),
    text: &str,
    em: f64,
    (x, y): (f64, f64),
    upright: bool,
    colour: Rgb,
) {
    if buffer.len() < size.0 as usize * size.1 as usize * 3 {
        return;
    }
    let [r, g, b] = colour.bytes();
    // The backend puts the baseline half a line below the position it is given.
    let drop = em * LINE_PER_EM / 2.0;
    let (transform, x, y) =
        if upright { (FontTransform::Rotate270, x - drop, y) } else { (FontTransform::None, x, y - drop) };
    let colour = RGBColor(r, g, b);
    let style = TextStyle::from(font(em).transform(transform)).color(&colour);
    let mut backend = BitMapBackend::with_buffer(buffer, size);
    let _ = backend.draw_text(text, &style, (x.round() as i32, y.round() as i32));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn letters_have_width_and_ink_where_asked() {
        assert!((width("0000") / width("0") - 4.0).abs() < 0.05);
        assert!((0.4..0.8).contains(&width("0")), "{}", width("0"));
        let size = (200, 100);
        for upright in [false, true] {
            let mut buffer = vec![255; 200 * 100 * 3];
            draw(&mut buffer, size, "H", 40.0, (100.0, 60.0), upright, Rgb::BLACK);
            let ink: Vec<(usize, usize)> =
                (0..200 * 100).filter(|i| buffer[3 * i] < 128).map(|i| (i % 200, i / 200)).collect();
            let range = |values: Vec<usize>| (*values.iter().min().unwrap(), *values.iter().max().unwrap());
            let (x0, x1) = range(ink.iter().map(|p| p.0).collect());
            let (y0, y1) = range(ink.iter().map(|p| p.1).collect());
            // A capital is 0.73 em high and stands on the baseline.
            let expected = if upright { ((70, 100), (34, 58)) } else { ((102, 126), (30, 60)) };
            for (found, wanted) in
                [(x0, expected.0.0), (x1, expected.0.1), (y0, expected.1.0), (y1, expected.1.1)]
            {
                assert!(found.abs_diff(wanted) <= 4, "{upright}: {x0}..{x1}, {y0}..{y1}");
            }
        }
    }
}
