//! A chart: lines over two axes.

use super::field::Field;
use super::picture::{self, COLOURS, FONT, GRID, INK};
use plotters::coord::Shift;
use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, ValueFormatter};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// A quantity along one side of a chart.
#[derive(Clone, Debug)]
pub struct Axis {
    /// What it is, and its unit.
    pub label: &'static str,
    /// The ends.
    pub range: (f64, f64),
    /// Whether equal steps are equal ratios.
    pub log: bool,
}

impl Axis {
    /// An axis with equal differences at equal distances.
    pub const fn linear(label: &'static str, from: f64, to: f64) -> Self {
        Axis { label, range: (from, to), log: false }
    }

    /// An axis with equal ratios at equal distances.
    pub const fn log(label: &'static str, from: f64, to: f64) -> Self {
        Axis { label, range: (from, to), log: true }
    }

    /// Where a value lies.
    fn place(&self, value: f64) -> f64 {
        if self.log { value.log10() } else { value }
    }

    /// Whether a value lies on it. Another, or none, is not drawn.
    fn holds(&self, value: f64) -> bool {
        (self.range.0..=self.range.1).contains(&value)
    }

    /// Values worth a label: eight or so.
    fn ticks(&self) -> Vec<f64> {
        let (low, high) = self.range;
        if self.log {
            let (from, to) = (low.log10().floor() as i32, high.log10().ceil() as i32);
            let every = ((to - from) / 7).max(1);
            let steps: &[f64] = if to - from <= 3 { &[1.0, 2.0, 5.0] } else { &[1.0] };
            let decades = (from..=to).filter(|decade| decade % every == 0);
            let all = decades.flat_map(|d| steps.iter().map(move |s| s * 10f64.powi(d)));
            return all.filter(|x| *x >= low * 0.999 && *x <= high * 1.001).collect();
        }
        let rough = (high - low) / 8.0;
        let unit = 10f64.powf(rough.log10().floor());
        let step = unit
            * [1.0, 2.0, 2.5, 5.0, 10.0].into_iter().find(|s| s * unit >= rough).unwrap_or(10.0);
        let (from, to) = ((low / step - 1e-9).ceil() as i64, (high / step + 1e-9).floor() as i64);
        (from..=to).map(|k| k as f64 * step).collect()
    }
}

/// Plotters asks where values lie, in places from `Axis::place`, and for the ticks.
impl Ranged for Axis {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, place: &f64, pixels: (i32, i32)) -> i32 {
        let (low, high) = (self.place(self.range.0), self.place(self.range.1));
        let share = (place - low) / (high - low);
        pixels.0 + (share * f64::from(pixels.1 - pixels.0)).round() as i32
    }

    fn key_points<H: KeyPointHint>(&self, _: H) -> Vec<f64> {
        self.ticks().into_iter().map(|value| self.place(value)).collect()
    }

    fn range(&self) -> std::ops::Range<f64> {
        self.place(self.range.0)..self.place(self.range.1)
    }
}

impl ValueFormatter<f64> for Axis {
    fn format_ext(&self, place: &f64) -> String {
        label(*place, self)
    }
}

/// How a series is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Style {
    /// A line with its points marked: something measured.
    Marked,
    /// A line: a formula.
    Line,
    /// A broken line: a limit, or something on other terms than the rest.
    Dashed,
    /// Points alone.
    Points,
}

/// Values over values.
#[derive(Clone, Debug)]
pub struct Series {
    /// What the legend calls it.
    pub label: String,
    /// How it is drawn.
    pub style: Style,
    /// The index of its colour; series that belong together share one.
    pub colour: usize,
    /// x and y.
    pub points: Vec<(f64, f64)>,
}

impl Series {
    /// A series.
    pub fn new(
        label: impl Into<String>,
        style: Style,
        colour: usize,
        points: impl IntoIterator<Item = (f64, f64)>,
    ) -> Self {
        Series { label: label.into(), style, colour, points: points.into_iter().collect() }
    }
}

/// A chart.
#[derive(Clone, Debug)]
pub struct Chart {
    /// The name of its files.
    pub name: &'static str,
    /// What it shows.
    pub title: String,
    /// The lower side.
    pub x: Axis,
    /// The left side.
    pub y: Axis,
    /// What is drawn, in the order of the legend.
    pub series: Vec<Series>,
}

/// Width and height in pixels.
pub const SIZE: (u32, u32) = (960, 520);

impl Chart {
    /// The chart as SVG without a background, its ink the colour of the text around it.
    pub fn inline_svg(&self) -> Result<String, String> {
        Ok(picture::inline(&self.svg_in(None, None)?))
    }

    /// The chart as an SVG file of its own, on white, with the points' values as JSON in its metadata.
    pub fn svg(&self) -> Result<String, String> {
        self.svg_over(None)
    }

    fn svg_over(&self, field: Option<&Field>) -> Result<String, String> {
        let points = self.series.iter().map(|s| (s.label.clone(), serde_json::json!(s.points)));
        let values = serde_json::Value::Object(points.collect()).to_string();
        Ok(picture::on_paper(&self.svg_in(Some(WHITE), field)?, &values))
    }

    fn svg_in(&self, ground: Option<RGBColor>, field: Option<&Field>) -> Result<String, String> {
        picture::svg(SIZE, &self.title, |root| self.draw(root, ground, field, 1.0))
    }

    /// The chart as a PNG file, with twice the points a side.
    pub fn png(&self, file: &std::path::Path) -> Result<(), String> {
        self.png_over(None, file)
    }

    fn png_over(&self, field: Option<&Field>, file: &std::path::Path) -> Result<(), String> {
        picture::png(SIZE, file, |root| self.draw(root, Some(WHITE), field, 2.0))
    }

    /// The chart as a file: SVG or PNG, by its name.
    pub fn save(&self, file: &std::path::Path) -> Result<(), String> {
        self.save_over(None, file)
    }

    /// The same with a field behind the lines.
    pub fn save_over(&self, field: Option<&Field>, file: &std::path::Path) -> Result<(), String> {
        match file.extension().and_then(|suffix| suffix.to_str()) {
            Some("svg") => std::fs::write(file, self.svg_over(field)?)
                .map_err(|error| format!("{}: {error}", file.display())),
            Some("png") => self.png_over(field, file),
            _ => Err(format!("{}: name it .svg or .png", file.display())),
        }
    }

    fn draw<DB: DrawingBackend>(
        &self,
        root: DrawingArea<DB, Shift>,
        ground: Option<RGBColor>,
        field: Option<&Field>,
        scale: f64,
    ) -> Result<(), String> {
        self.plot(&root, ground, field, scale)
            .map_err(|error| format!("{}: {error}", self.name))?;
        root.present().map_err(|error| format!("{}: {error}", self.name))
    }

    fn plot<DB: DrawingBackend>(
        &self,
        root: &DrawingArea<DB, Shift>,
        ground: Option<RGBColor>,
        field: Option<&Field>,
        scale: f64,
    ) -> Result<(), DrawingAreaErrorKind<DB::ErrorType>> {
        if let Some(ground) = ground {
            root.fill(&ground)?;
        }
        let pixels = |size: f64| (size * scale).round() as i32;
        let font = |size: f64| TextStyle::from((FONT, size * scale)).color(&INK);
        let (head, body) = root.split_vertically(pixels(44.0));
        let title = font(19.0).pos(Pos::new(HPos::Left, VPos::Center));
        head.draw(&Text::new(self.title.as_str(), (pixels(16.0), pixels(26.0)), title))?;
        let longest = self.series.iter().map(|s| s.label.chars().count()).max().unwrap_or(0);
        let legend = pixels(60.0 + 7.6 * longest as f64);
        let width = body.dim_in_pixel().0 as i32;
        let (area, side) = body.split_horizontally(width - legend);

        let mut chart = ChartBuilder::on(&area)
            .margin(pixels(10.0))
            .margin_right(pixels(18.0))
            .x_label_area_size(pixels(50.0))
            .y_label_area_size(pixels(78.0))
            .build_cartesian_2d(self.x.clone(), self.y.clone())?;
        let patches = field.map(Field::patches).unwrap_or_default();
        chart.draw_series(
            patches.into_iter().map(|(corners, c)| Rectangle::new(corners, c.filled())),
        )?;
        chart
            .configure_mesh()
            .x_desc(self.x.label)
            .y_desc(self.y.label)
            .axis_desc_style(font(15.0))
            .label_style(font(13.0))
            .axis_style(INK.stroke_width(pixels(1.0) as u32))
            .bold_line_style(GRID.mix(0.35))
            .light_line_style(TRANSPARENT)
            .draw()?;
        for series in &self.series {
            let colour = COLOURS[series.colour % COLOURS.len()];
            let inside = series.points.iter().filter(|(x, y)| self.x.holds(*x) && self.y.holds(*y));
            let points: Vec<(f64, f64)> =
                inside.map(|&(x, y)| (self.x.place(x), self.y.place(y))).collect();
            let stroke = colour.stroke_width(pixels(2.0) as u32);
            match series.style {
                Style::Dashed => {
                    chart.draw_series(DashedLineSeries::new(
                        points,
                        pixels(7.0),
                        pixels(5.0),
                        stroke,
                    ))?;
                }
                Style::Points => {
                    chart.draw_series(
                        points.iter().map(|&at| Circle::new(at, pixels(4.0), colour.filled())),
                    )?;
                }
                _ => {
                    chart.draw_series(LineSeries::new(points.iter().copied(), stroke))?;
                    if series.style == Style::Marked {
                        let dot = |&at: &(f64, f64)| Circle::new(at, pixels(3.0), colour.filled());
                        chart.draw_series(points.iter().map(dot))?;
                    }
                }
            }
        }
        for (row, series) in (0..).zip(&self.series) {
            let colour = COLOURS[series.colour % COLOURS.len()];
            let y = pixels(24.0 + 22.0 * f64::from(row));
            let (left, right) = (pixels(4.0), pixels(34.0));
            let stroke = colour.stroke_width(pixels(2.0) as u32);
            match series.style {
                Style::Points => {}
                Style::Dashed => {
                    for from in [left, left + pixels(12.0), left + pixels(24.0)] {
                        side.draw(&PathElement::new(
                            vec![(from, y), (from + pixels(7.0), y)],
                            stroke,
                        ))?;
                    }
                }
                _ => side.draw(&PathElement::new(vec![(left, y), (right, y)], stroke))?,
            }
            if matches!(series.style, Style::Marked | Style::Points) {
                side.draw(&Circle::new(((left + right) / 2, y), pixels(3.5), colour.filled()))?;
            }
            let style = font(13.0).pos(Pos::new(HPos::Left, VPos::Center));
            side.draw(&Text::new(series.label.as_str(), (pixels(42.0), y), style))?;
        }
        Ok(())
    }
}

/// A tick's label, from its place on the axis.
fn label(place: f64, axis: &Axis) -> String {
    let value = if axis.log { 10f64.powf(place) } else { place };
    let size = value.abs();
    if !axis.log && size < 1e-12 {
        "0".into()
    } else if (1e-3..1e5).contains(&size) {
        let digits = (3 - size.log10().floor() as i32).clamp(0, 6) as usize;
        let text = format!("{value:.digits$}");
        if text.contains('.') {
            text.trim_end_matches('0').trim_end_matches('.').into()
        } else {
            text
        }
    } else {
        format!("{value:.0e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_inside() {
        assert_eq!(
            Axis::linear("", -10.0, 60.0).ticks(),
            [-10.0, 0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0]
        );
        assert_eq!(Axis::linear("", -0.5, 0.5).ticks().len(), 5);
        assert_eq!(Axis::log("", 0.9, 30.0).ticks(), [1.0, 2.0, 5.0, 10.0, 20.0]);
        let decades = Axis::log("", 1e-6, 1.0).ticks();
        assert_eq!(decades.len(), 7);
        assert!(decades.iter().all(|x| (1e-6..=1.001).contains(x)));
    }

    #[test]
    fn labels_are_short() {
        let (linear, log) = (Axis::linear("", 0.0, 1.0), Axis::log("", 0.1, 1.0));
        assert_eq!(label(0.25, &linear), "0.25");
        assert_eq!(label(-20.0, &linear), "-20");
        assert_eq!(label(-6.0, &log), "1e-6");
        assert_eq!(label(3.0, &log), "1000");
    }
}
