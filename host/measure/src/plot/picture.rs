//! How a drawing becomes a picture: SVG for the page, PNG for everything else.
//!
//! Fonts come with the program (DejaVu Sans), so a machine without any draws the same picture.

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::{FontStyle, register_font};
use std::sync::Once;

/// Colours that people with any colour vision can distinguish (Okabe and Ito 2008), on light and dark ground.
pub const COLOURS: [RGBColor; 8] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(140, 140, 140),
    RGBColor(150, 110, 60),
];

/// Stands for the ink of the page, which is dark on paper and light on a dark screen.
pub const INK: RGBColor = RGBColor(1, 2, 3);
const INK_TEXT: &str = "#010203";
/// Lines of the grid.
pub const GRID: RGBColor = RGBColor(160, 160, 160);

/// The family of all text: DejaVu Sans, which comes with the program.
pub const FONT: &str = "sans-serif";

fn fonts() {
    static FONTS: Once = Once::new();
    FONTS.call_once(|| {
        // It is a font: nothing can go wrong that a test would not see.
        let _ = register_font(FONT, FontStyle::Normal, dejavu::sans::regular());
    });
}

/// A drawing of this size in pixels as SVG, its ink not yet chosen: see [`figure`] and [`on_paper`].
pub fn svg(
    size: (u32, u32),
    title: &str,
    draw: impl FnOnce(DrawingArea<SVGBackend<'_>, Shift>) -> Result<(), String>,
) -> Result<String, String> {
    fonts();
    let mut text = String::new();
    draw(SVGBackend::with_string(&mut text, size).into_drawing_area())?;
    // A width of its own would not follow the page's.
    let (width, height) = size;
    Ok(text.replacen(
        &format!("<svg width=\"{width}\" height=\"{height}\""),
        &format!("<svg role=\"img\" aria-label=\"{}\"", escape(title)),
        1,
    ))
}

/// Width and height of a picture on a narrow screen.
pub const NARROW: (u32, u32) = (344, 320);

/// A figure of a page: the picture for wide screens and for narrow ones, its ink the colour of the text around it.
pub fn figure(caption: &str, wide: &str, narrow: &str) -> String {
    let inline = |svg: &str, class: &str| {
        let svg = svg.replace(INK_TEXT, "currentColor");
        svg.replacen("<svg ", &format!("<svg class=\"{class}\" "), 1)
    };
    format!(
        "<figure><figcaption>{caption}</figcaption><div class=\"picture\" tabindex=\"0\">{}{}</div></figure>\n",
        inline(wide, "wide"),
        inline(narrow, "narrow")
    )
}

/// A line of a figure's legend: a line, broken or not, a dot, and what they stand for.
pub fn key(colour: RGBColor, broken: Option<bool>, dot: bool, label: &str) -> String {
    let RGBColor(r, g, b) = colour;
    let dashes = if broken == Some(true) { " stroke-dasharray=\"7 5\"" } else { "" };
    let line =
        format!("<path d=\"M0 6H32\" stroke=\"rgb({r},{g},{b})\" stroke-width=\"2\"{dashes}/>");
    let mut sign = broken.map_or_else(String::new, |_| line);
    if dot {
        sign += &format!("<circle cx=\"16\" cy=\"6\" r=\"3.5\" fill=\"rgb({r},{g},{b})\"/>");
    }
    let svg = format!("<svg class=\"key\" viewBox=\"0 0 32 12\" aria-hidden=\"true\">{sign}</svg>");
    format!("<span>{svg} {}</span> ", escape(label))
}

/// The entry of a key for an area of a colour.
pub fn patch(colour: RGBColor, label: &str) -> String {
    let RGBColor(r, g, b) = colour;
    let sign = format!("<rect width=\"16\" height=\"12\" fill=\"rgb({r},{g},{b})\"/>");
    let svg = format!("<svg class=\"key\" viewBox=\"0 0 16 12\" aria-hidden=\"true\">{sign}</svg>");
    format!("<span>{svg} {}</span> ", escape(label))
}

/// An SVG as a file of its own, with its values as JSON in its metadata.
pub fn on_paper(svg: &str, values: &str) -> String {
    let metadata = format!(">\n<metadata>{}</metadata>\n", escape(values));
    svg.replace(INK_TEXT, "#202020").replacen(">\n", &metadata, 1)
}

/// A drawing as a PNG file's bytes, with twice the points a side.
pub fn png(
    size: (u32, u32),
    draw: impl FnOnce(DrawingArea<BitMapBackend<'_>, Shift>) -> Result<(), String>,
) -> Result<Vec<u8>, String> {
    fonts();
    let (width, height) = (2 * size.0, 2 * size.1);
    let mut pixels = vec![0; 3 * width as usize * height as usize];
    draw(BitMapBackend::with_buffer(&mut pixels, (width, height)).into_drawing_area())?;
    let mut bytes = Vec::new();
    let mut write = || -> Result<(), png::EncodingError> {
        let mut encoder = png::Encoder::new(&mut bytes, width, height);
        encoder.set_color(png::ColorType::Rgb);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&pixels)?;
        writer.finish()
    };
    write().map_err(|error| error.to_string())?;
    Ok(bytes)
}

/// Text as it may stand in HTML and SVG.
pub fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
