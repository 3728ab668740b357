//! Pictures of results as PNG or SVG files: histories and convergence ([`lines()`]), deformed shells ([`surfaces()`]).
//!
//! Both draw on a [`canvas`] of several samples a pixel, so that lines, areas and letters are smooth. The font
//! is part of the program (DejaVu Sans, see `assets/`): no picture depends on what a machine has installed.

// Tests may unwrap; the code they test may not.
#![cfg_attr(test, allow(clippy::unwrap_used))]

pub mod canvas;
pub mod colour;
mod colour_bar;
mod facets;
mod font;
mod heat_map;
mod labels;
mod legend;
pub mod lines;
mod png;
mod projection;
mod strokes;
pub mod surfaces;
pub mod ticks;
mod vector;

pub use heat_map::{Group, HeatMap, heat_map};
pub use lines::{LinePlot, Series, Style, lines};
pub use surfaces::{Snapshot, SurfacePlot, View, surfaces};
