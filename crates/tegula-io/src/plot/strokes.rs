//! Style of the lines and markers of a series.

use super::canvas::{Canvas, Point, regular};
use super::colour::{Rgb, palette};
use super::lines::{Series, Style};

/// Width of a line in pixels.
const LINE: f64 = 1.9;

/// Draws a series with colour and marker of this number, given as chains of points on the sheet.
pub(super) fn series(canvas: &mut Canvas, index: usize, series: &Series, chains: &[Vec<Point>]) {
    let colour = palette(index);
    for chain in chains {
        // A point between two that cannot be shown has no line; it must not vanish.
        if chain.len() == 1 && !series.style.has_markers() {
            canvas.disc(chain[0], 3.0, colour);
        }
        line(canvas, &thinned(chain), series.style, colour);
    }
    if series.style.has_markers() {
        for &place in &thinned(&chains.concat()) {
            marker(canvas, place, index, colour);
        }
    }
}

/// The chain without the points that lie within a tenth of a pixel of the one before.
fn thinned(chain: &[Point]) -> Vec<Point> {
    let mut kept: Vec<Point> = Vec::with_capacity(chain.len());
    for &point in chain {
        if kept.last().is_none_or(|last| (point[0] - last[0]).hypot(point[1] - last[1]) > 0.1) {
            kept.push(point);
        }
    }
    kept
}

/// A chain in the style of its series; nothing for markers alone.
pub(super) fn line(canvas: &mut Canvas, chain: &[Point], style: Style, colour: Rgb) {
    match style {
        Style::Line | Style::LineLike(_) | Style::Both => canvas.polyline(chain, LINE, None, colour),
        Style::Dashed | Style::DashedLike(_) => canvas.polyline(chain, LINE, Some((7.0, 4.5)), colour),
        Style::Markers => {}
    }
}

/// The marker of the series number `index`, with a thin white rim.
pub(super) fn marker(canvas: &mut Canvas, place: Point, index: usize, colour: Rgb) {
    let shape = |radius: f64| match index % 5 {
        0 => regular(place, radius, 24, 0.0),
        1 => regular(place, 1.2 * radius, 4, std::f64::consts::FRAC_PI_4),
        2 => regular(place, 1.3 * radius, 3, 0.0),
        3 => regular(place, 1.25 * radius, 4, 0.0),
        _ => regular(place, 1.3 * radius, 3, std::f64::consts::PI),
    };
    canvas.fill(&shape(5.4), Rgb::WHITE);
    canvas.fill(&shape(4.3), colour);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thinning_keeps_what_can_be_seen() {
        let chain: Vec<Point> =
            (0..100_000).map(|i| [f64::from(i) * 1e-3, (f64::from(i) * 0.01).sin()]).collect();
        let kept = thinned(&chain);
        assert!(kept.len() < 20_000);
        let missed = |p: &Point| kept.iter().all(|k| (k[0] - p[0]).hypot(k[1] - p[1]) > 0.1);
        assert!(!chain.iter().step_by(997).any(missed));
    }

    #[test]
    fn every_marker_has_ink_in_its_own_colour() {
        for index in 0..7 {
            let mut canvas = Canvas::new(20, 20);
            marker(&mut canvas, [10.0, 10.0], index, palette(index));
            let wanted = palette(index).bytes();
            assert!(canvas.pixels().chunks(3).filter(|p| *p == wanted).count() > 15, "{index}");
        }
    }
}
