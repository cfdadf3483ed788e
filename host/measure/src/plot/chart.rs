//! A chart: lines over two axes.

pub use super::axis::Axis;
use super::field::Field;
use super::picture::{self, COLOURS, FONT, GRID, INK};
use crate::output::Output;
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use std::path::Path;

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
    /// The standard error of each y; empty where nothing is random.
    pub errors: Vec<f64>,
}

impl Series {
    /// A series.
    pub fn new(
        label: impl Into<String>,
        style: Style,
        colour: usize,
        points: impl IntoIterator<Item = (f64, f64)>,
    ) -> Self {
        let points = points.into_iter().collect();
        Series { label: label.into(), style, colour, points, errors: Vec::new() }
    }

    /// This series with the standard error of each point.
    pub fn with_errors(self, errors: impl IntoIterator<Item = f64>) -> Self {
        Series { errors: errors.into_iter().collect(), ..self }
    }

    /// What the legend beside a text shows of it.
    fn key(&self) -> String {
        let colour = COLOURS[self.colour % COLOURS.len()];
        let line = match self.style {
            Style::Points => None,
            Style::Dashed => Some(true),
            _ => Some(false),
        };
        picture::key(colour, line, matches!(self.style, Style::Marked | Style::Points), &self.label)
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

/// How a chart lies on its ground; lengths in pixels.
#[derive(Clone, Copy, Debug)]
struct Layout {
    size: (u32, u32),
    /// With its title above and its legend beside. A page has them as text.
    alone: bool,
    /// The size of an axis' name, and of its labels.
    name: f64,
    label: f64,
    /// What the labels of both axes take.
    below: f64,
    left: f64,
    /// Labels of each axis, or so.
    ticks: usize,
}

const ALONE: Layout =
    Layout { size: SIZE, alone: true, name: 15.0, label: 13.0, below: 50.0, left: 78.0, ticks: 8 };
const WIDE: Layout = Layout { size: (960, 440), alone: false, name: 16.0, label: 14.5, ..ALONE };
/// For a telephone.
const NARROW: Layout = Layout { size: picture::NARROW, left: 66.0, below: 46.0, ticks: 5, ..WIDE };

impl Chart {
    /// The chart as a figure of a page, for wide and for narrow screens: title and legend are text, and its ink is the colour of the
    /// text around it.
    pub fn figure(&self) -> Result<String, String> {
        let keys: String = self.series.iter().map(Series::key).collect();
        let caption = format!("{}<br>{keys}", picture::escape(&self.title));
        let [wide, narrow] = [&WIDE, &NARROW].map(|layout| self.svg_in(None, None, layout));
        Ok(picture::figure(&caption, &wide?, &narrow?))
    }

    /// The chart as an SVG file of its own, on white, with the points' values as JSON in its metadata.
    pub fn svg(&self) -> Result<String, String> {
        self.svg_over(None)
    }

    fn svg_over(&self, field: Option<&Field>) -> Result<String, String> {
        let points = self.series.iter().map(|s| (s.label.clone(), serde_json::json!(s.points)));
        let values = serde_json::Value::Object(points.collect()).to_string();
        Ok(picture::on_paper(&self.svg_in(Some(WHITE), field, &ALONE)?, &values))
    }

    fn svg_in(
        &self,
        ground: Option<RGBColor>,
        field: Option<&Field>,
        layout: &Layout,
    ) -> Result<String, String> {
        picture::svg(layout.size, &self.title, |root| self.draw(root, ground, field, layout, 1.0))
    }

    /// The chart as a PNG file's bytes, with twice the points a side.
    pub fn png(&self) -> Result<Vec<u8>, String> {
        self.png_over(None)
    }

    fn png_over(&self, field: Option<&Field>) -> Result<Vec<u8>, String> {
        picture::png(SIZE, |root| self.draw(root, Some(WHITE), field, &ALONE, 2.0))
    }

    /// The chart as a file: SVG or PNG, by its name.
    pub fn save(&self, file: &Path, output: Output) -> Result<(), String> {
        self.save_over(None, file, output)
    }

    /// Saves the chart with a field behind the lines.
    pub fn save_over(
        &self,
        field: Option<&Field>,
        file: &Path,
        output: Output,
    ) -> Result<(), String> {
        let bytes = match file.extension().and_then(|suffix| suffix.to_str()) {
            Some("svg") => self.svg_over(field)?.into_bytes(),
            Some("png") => self.png_over(field)?,
            _ => return Err(format!("{}: name it .svg or .png", file.display())),
        };
        output.write(file, &bytes)
    }

    fn draw<DB: DrawingBackend>(
        &self,
        root: DrawingArea<DB, Shift>,
        ground: Option<RGBColor>,
        field: Option<&Field>,
        layout: &Layout,
        scale: f64,
    ) -> Result<(), String> {
        let told = |error: DrawingAreaErrorKind<DB::ErrorType>| format!("{}: {error}", self.name);
        if let Some(ground) = ground {
            root.fill(&ground).map_err(told)?;
        }
        let pen = Pen { scale };
        match layout.alone {
            true => self.with_words(&root, field, layout, &pen),
            false => self.plot(&root, field, layout, &pen),
        }
        .map_err(told)?;
        root.present().map_err(told)
    }

    /// With the title above and the legend beside.
    fn with_words<DB: DrawingBackend>(
        &self,
        root: &DrawingArea<DB, Shift>,
        field: Option<&Field>,
        layout: &Layout,
        pen: &Pen,
    ) -> Drawn<(), DB> {
        let (head, body) = root.split_vertically(pen.pixels(44.0));
        let title = pen.font(19.0).pos(Pos::new(HPos::Left, VPos::Center));
        head.draw(&Text::new(self.title.as_str(), (pen.pixels(16.0), pen.pixels(26.0)), title))?;
        let longest = self.series.iter().map(|s| s.label.chars().count()).max().unwrap_or(0);
        let legend = pen.pixels(60.0 + 7.6 * longest as f64);
        let width = body.dim_in_pixel().0 as i32;
        let (area, side) = body.split_horizontally(width - legend);
        self.plot(&area, field, layout, pen)?;
        let explain = |(row, series): (i32, &Series)| {
            series.explain(&side, pen.pixels(24.0 + 22.0 * f64::from(row)), pen)
        };
        (0..).zip(&self.series).try_for_each(explain)
    }

    fn plot<DB: DrawingBackend>(
        &self,
        area: &DrawingArea<DB, Shift>,
        field: Option<&Field>,
        layout: &Layout,
        pen: &Pen,
    ) -> Drawn<(), DB> {
        let mut chart = ChartBuilder::on(area)
            .margin(pen.pixels(10.0))
            .margin_right(pen.pixels(18.0))
            .x_label_area_size(pen.pixels(layout.below))
            .y_label_area_size(pen.pixels(layout.left))
            .build_cartesian_2d(self.x.clone(), self.y.clone())?;
        let patches = field.map(Field::patches).unwrap_or_default();
        chart.draw_series(
            patches.into_iter().map(|(corners, c)| Rectangle::new(corners, c.filled())),
        )?;
        chart
            .configure_mesh()
            .x_labels(layout.ticks)
            .y_labels(layout.ticks)
            .x_desc(self.x.label)
            .y_desc(self.y.label)
            .axis_desc_style(pen.font(layout.name))
            .label_style(pen.font(layout.label))
            .axis_style(INK.stroke_width(pen.pixels(1.0) as u32))
            .bold_line_style(GRID.mix(0.35))
            .light_line_style(TRANSPARENT)
            .draw()?;
        for series in &self.series {
            self.line(&mut chart, series, pen)?;
        }
        Ok(())
    }

    fn line<DB: DrawingBackend>(
        &self,
        chart: &mut Plot<'_, DB>,
        series: &Series,
        pen: &Pen,
    ) -> Drawn<(), DB> {
        let colour = COLOURS[series.colour % COLOURS.len()];
        let inside = |&&(x, y): &&(f64, f64)| self.x.holds(x) && self.y.holds(y);
        let place = |&(x, y): &(f64, f64)| (self.x.place(x), self.y.place(y));
        let points: Vec<(f64, f64)> = series.points.iter().filter(inside).map(place).collect();
        let stroke = colour.stroke_width(pen.pixels(2.0) as u32);
        match series.style {
            Style::Dashed => {
                let (dash, space) = (pen.pixels(7.0), pen.pixels(5.0));
                chart.draw_series(DashedLineSeries::new(points, dash, space, stroke))?;
            }
            Style::Points => {
                let dot = |&at: &(f64, f64)| Circle::new(at, pen.pixels(4.0), colour.filled());
                chart.draw_series(points.iter().map(dot))?;
            }
            _ => {
                chart.draw_series(LineSeries::new(points.iter().copied(), stroke))?;
                if series.style == Style::Marked {
                    let dot = |&at: &(f64, f64)| Circle::new(at, pen.pixels(3.0), colour.filled());
                    chart.draw_series(points.iter().map(dot))?;
                }
            }
        }
        // An error that its marker hides is not drawn.
        let height = f64::from(chart.plotting_area().dim_in_pixel().1);
        let (low, high) = (self.y.place(self.y.range.0), self.y.place(self.y.range.1));
        let hidden = f64::from(pen.pixels(4.0)) / height * (high - low);
        let bars = series.points.iter().zip(&series.errors).filter(|(point, _)| inside(point));
        let bars = bars.filter_map(|(&(x, y), error)| {
            let end = |y: f64| self.y.place(y.clamp(self.y.range.0, self.y.range.1));
            let (below, above) = (end(y - error), end(y + error));
            let seen = above - self.y.place(y) > hidden;
            let ends = vec![(self.x.place(x), below), (self.x.place(x), above)];
            seen.then(|| PathElement::new(ends, colour.stroke_width(pen.pixels(1.0) as u32)))
        });
        chart.draw_series(bars).map(drop)
    }
}

impl Series {
    /// Draws its line of the legend.
    fn explain<DB: DrawingBackend>(
        &self,
        side: &DrawingArea<DB, Shift>,
        y: i32,
        pen: &Pen,
    ) -> Drawn<(), DB> {
        let colour = COLOURS[self.colour % COLOURS.len()];
        let (left, right) = (pen.pixels(4.0), pen.pixels(34.0));
        let stroke = colour.stroke_width(pen.pixels(2.0) as u32);
        match self.style {
            Style::Points => {}
            Style::Dashed => {
                for from in [left, left + pen.pixels(12.0), left + pen.pixels(24.0)] {
                    let ends = vec![(from, y), (from + pen.pixels(7.0), y)];
                    side.draw(&PathElement::new(ends, stroke))?;
                }
            }
            _ => side.draw(&PathElement::new(vec![(left, y), (right, y)], stroke))?,
        }
        if matches!(self.style, Style::Marked | Style::Points) {
            let dot = ((left + right) / 2, y);
            side.draw(&Circle::new(dot, pen.pixels(3.5), colour.filled()))?;
        }
        let style = pen.font(13.0).pos(Pos::new(HPos::Left, VPos::Center));
        side.draw(&Text::new(self.label.as_str(), (pen.pixels(42.0), y), style))
    }
}

type Drawn<T, DB> = Result<T, DrawingAreaErrorKind<<DB as DrawingBackend>::ErrorType>>;
type Plot<'a, DB> = ChartContext<'a, DB, Cartesian2d<Axis, Axis>>;

/// What sizes are in the points of a picture.
struct Pen {
    scale: f64,
}

impl Pen {
    fn pixels(&self, size: f64) -> i32 {
        (size * self.scale).round() as i32
    }

    fn font(&self, size: f64) -> TextStyle<'static> {
        TextStyle::from((FONT, size * self.scale)).color(&INK)
    }
}
