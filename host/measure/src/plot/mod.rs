//! Plots as SVG and PNG.

pub mod axis;
pub mod chart;
pub mod field;
pub mod picture;
