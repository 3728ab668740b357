//! Font: DejaVu Sans, compiled into the program and rasterised by `ab_glyph`.

use std::sync::OnceLock;

use ab_glyph::{Font as _, FontRef, PxScale, ScaleFont as _, point};

use super::colour::Rgb;

static DEJAVU_SANS: &[u8] = include_bytes!("../../assets/DejaVuSans.ttf");

/// The font; `None` if it cannot be read, which would show in the tests: a picture would lack its letters.
fn font() -> Option<&'static FontRef<'static>> {
    static FONT: OnceLock<Option<FontRef<'static>>> = OnceLock::new();
    FONT.get_or_init(|| FontRef::try_from_slice(DEJAVU_SANS).ok()).as_ref()
}

/// Scale of `em` samples per em: `ab_glyph` counts the height of a line, from its ascent to its descent.
fn scale(font: &FontRef, em: f64) -> PxScale {
    let line = font.height_unscaled() / font.units_per_em().unwrap_or(1.0);
    PxScale::from(em as f32 * line)
}

/// Width of `text` in ems.
pub(super) fn width(text: &str) -> f64 {
    font().map_or(0.0, |font| {
        let mut end = 0.0;
        each_glyph(font, 1.0, text, |_, advanced| end = advanced);
        f64::from(end)
    })
}

/// Calls `take` with each glyph of a text whose baseline begins at the origin, and with the end of its advance. Pairs of
/// glyphs have their kerning.
fn each_glyph(font: &FontRef, em: f64, text: &str, mut take: impl FnMut(ab_glyph::Glyph, f32)) {
    let scaled = font.as_scaled(scale(font, em));
    let (mut end, mut last) = (0.0, None);
    for letter in text.chars() {
        let id = scaled.glyph_id(letter);
        let start = end + last.map_or(0.0, |last| scaled.kern(last, id));
        end = start + scaled.h_advance(id);
        last = Some(id);
        take(id.with_scale_and_position(scaled.scale(), point(start, 0.0)), end);
    }
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
    let (columns, rows) = (i64::from(size.0), i64::from(size.1));
    let Some(font) = font().filter(|_| buffer.len() >= (columns * rows) as usize * 3) else { return };
    let (x, y) = (x.round() as i64, y.round() as i64);
    let ink = colour.bytes();
    each_glyph(font, em, text, |glyph, _| {
        let Some(outline) = font.outline_glyph(glyph) else { return };
        let corner = outline.px_bounds().min;
        outline.draw(|column, row, coverage| {
            let (right, down) = (corner.x as i64 + i64::from(column), corner.y as i64 + i64::from(row));
            // Upright text runs along −y, and its letters stand on the left of their baseline.
            let (column, row) = if upright { (x + down, y - 1 - right) } else { (x + right, y + down) };
            if (0..columns).contains(&column) && (0..rows).contains(&row) {
                let at = (row * columns + column) as usize * 3;
                for (sample, ink) in buffer[at..at + 3].iter_mut().zip(ink) {
                    let below = f32::from(*sample);
                    *sample = (below + (f32::from(ink) - below) * coverage.clamp(0.0, 1.0)).round() as u8;
                }
            }
        });
    });
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
