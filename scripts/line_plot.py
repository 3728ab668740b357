"""Line plots as SVG: series differ in colour, marker and dashes, so that they can be told apart in black and white."""

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from xml.sax.saxutils import escape

# M. Okabe and K. Ito, Color Universal Design, 2008, without its yellow, which is too light for lines on white.
COLOURS = ["#0072b2", "#d55e00", "#009e73", "#000000", "#cc79a7", "#56b4e9"]
DASHES = ["", "7 4", "2 3", "9 3 2 3", "4 2", "12 4"]
# The first one is large and open, so that a marker of another series on the same point stays visible.
MARKERS = ["ring", "square", "triangle", "diamond", "cross", "circle"]
FONT = "DejaVu Sans, Helvetica, Arial, sans-serif"


@dataclass
class Series:
    """One series of a plot; `marked` is False for closed forms, which are drawn thin and grey.

    Curves of many points are drawn without `markers`, points of a reference without a `line`.
    """

    name: str
    x: Sequence[float]
    y: Sequence[float]
    marked: bool = True
    line: bool = True
    markers: bool = True


@dataclass
class Plot:
    """Plot with its labels; ranges and ticks are given, so that figures beside each other agree."""

    title: str
    x_label: str
    y_label: str
    x_ticks: dict[float, str]
    y_ticks: dict[float, str]
    series: list[Series] = field(default_factory=list)
    x_log: bool = False
    y_log: bool = False

    def numbers(self) -> dict[str, list[list[float]]]:
        """Coordinates of the marked series by name, as the figure keeps them."""
        return {s.name: [[float(f"{v:.6g}") for v in s.x], [float(f"{v:.6g}") for v in s.y]] for s in self.series if s.marked}


def marker(kind: str, x: float, y: float, colour: str) -> str:
    """Marker of a point."""
    r = 4.5
    if kind == "circle":
        return f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{r - 0.5}" fill="{colour}"/>'
    if kind == "ring":
        return f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{r + 2}" fill="none" stroke="{colour}" stroke-width="1.8"/>'
    if kind == "cross":
        d = f"M{x - r:.1f} {y - r:.1f}l{2 * r} {2 * r}m0 {-2 * r}l{-2 * r} {2 * r}"
        return f'<path d="{d}" stroke="{colour}" stroke-width="2" fill="none"/>'
    points = {
        "square": [(-3.2, -3.2), (3.2, -3.2), (3.2, 3.2), (-3.2, 3.2)],
        "triangle": [(0, -5.5), (5, 4), (-5, 4)],
        "diamond": [(0, -6), (5, 0), (0, 6), (-5, 0)],
    }[kind]
    text = " ".join(f"{x + a:.1f},{y + b:.1f}" for a, b in points)
    inside = colour if kind == "square" else "none"
    return f'<polygon points="{text}" fill="{inside}" stroke="{colour}" stroke-width="1.8"/>'


def axis(ticks: dict[float, str], log: bool, low: float, high: float):
    """Map of values to pixels; the outermost ticks are the ends of the axis."""
    scale = math.log10 if log else float
    first, last = scale(min(ticks)), scale(max(ticks))
    return lambda v: low + (high - low) * (scale(v) - first) / (last - first)


def svg(plot: Plot, source: str) -> str:
    """Text of the figure; `source` names what computed it."""
    width, height, top, legend = 400, 230, 34, 270
    left = max(62, 30 + 8 * max(map(len, plot.y_ticks.values())))
    x = axis(plot.x_ticks, plot.x_log, left, left + width)
    y = axis(plot.y_ticks, plot.y_log, top + height, top)
    full = (left + width + legend, top + height + 52)
    out = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {full[0]} {full[1]}" width="{full[0]}" height="{full[1]}" font-family="{FONT}" font-size="13" role="img">',
        f"<title>{escape(plot.title)}</title>",
        f"<desc>{escape(json.dumps({'computed by': source, 'values': plot.numbers()}))}</desc>",
        f'<rect width="{full[0]}" height="{full[1]}" fill="white"/>',
        f'<text x="{left}" y="20" font-weight="bold">{escape(plot.title)}</text>',
    ]
    for value, label in plot.y_ticks.items():
        out.append(f'<path d="M{left} {y(value):.1f}h{width}" stroke="#ddd"/>')
        out.append(f'<text x="{left - 11}" y="{y(value) + 4:.1f}" text-anchor="end">{escape(label)}</text>')
    for value, label in plot.x_ticks.items():
        out.append(f'<path d="M{x(value):.1f} {top}v{height}" stroke="#ddd"/>')
        out.append(f'<text x="{x(value):.1f}" y="{top + height + 17}" text-anchor="middle">{escape(label)}</text>')
    out.append(f'<rect x="{left}" y="{top}" width="{width}" height="{height}" fill="none" stroke="#444"/>')
    out.append(f'<text x="{left + width / 2}" y="{top + height + 40}" text-anchor="middle">{escape(plot.x_label)}</text>')
    middle = top + height / 2
    out.append(f'<text x="13" y="{middle}" text-anchor="middle" transform="rotate(-90 13 {middle})">{escape(plot.y_label)}</text>')
    out.append(f'<clipPath id="inside"><rect x="{left - 7}" y="{top - 7}" width="{width + 14}" height="{height + 14}"/></clipPath>')
    style = 0
    for row, s in enumerate(plot.series):
        colour, dash, kind = "#333", "1.5 2.5", None
        if s.marked:
            colour, dash, kind = COLOURS[style], DASHES[style], MARKERS[style]
            style += 1
        pixels = [(x(a), y(b)) for a, b in zip(s.x, s.y, strict=True) if not (plot.y_log and b <= 0)]
        line = " ".join(f"{a:.1f},{b:.1f}" for a, b in pixels)
        look = f'fill="none" stroke="{colour}" stroke-width="{2 if s.marked else 1.4}" stroke-dasharray="{dash or "none"}"'
        if s.line:
            out.append(f'<polyline points="{line}" {look} clip-path="url(#inside)"/>')
        at, down = left + width + 14, top + 10 + 22 * row
        if s.line:
            out.append(f'<path d="M{at} {down}h34" {look}/>')
        if kind and s.markers:
            out.append('<g clip-path="url(#inside)">' + "".join(marker(kind, a, b, colour) for a, b in pixels) + "</g>")
            out.append(marker(kind, at + 17, down, colour))
        out.append(f'<text x="{at + 42}" y="{down + 4.5}">{escape(s.name)}</text>')
    out.append("</svg>")
    return "\n".join(out) + "\n"


def numbers_of(text: str) -> dict[str, list[list[float]]]:
    """Numbers of the series of a figure, by name."""
    text = text[text.index("<desc>") + 6 : text.index("</desc>")]
    for entity, letter in [("&lt;", "<"), ("&gt;", ">"), ("&amp;", "&")]:
        text = text.replace(entity, letter)
    return json.loads(text)["values"]


def kept(path: Path) -> dict[str, list[list[float]]]:
    """Numbers of the series of a figure that was written before."""
    return numbers_of(path.read_text(encoding="utf-8"))
