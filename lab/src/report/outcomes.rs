//! A picture of outcomes: a bar for each cell, its parts the shares of right, flagged and overconfident answers.

use crate::plot::picture::{self, COLOURS, FONT, INK};
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// Shares of right, flagged and overconfident answers.
pub type Shares = [f64; 3];

const PARTS: [(&str, RGBColor); 3] =
    [("right", COLOURS[0]), ("flagged", RGBColor(196, 200, 205)), ("overconfident", COLOURS[1])];

/// Bars in rows; columns in groups.
#[derive(Clone, Debug)]
pub struct Outcomes {
    /// The name of its files.
    pub name: &'static str,
    /// What it shows.
    pub title: String,
    /// The heads of the groups.
    pub groups: Vec<String>,
    /// The heads of the columns in each group.
    pub columns: Vec<String>,
    /// The rows: what each is of, and a cell for each column of each group.
    pub rows: Vec<(String, Vec<Shares>)>,
}

/// How the picture lies on its ground; lengths in pixels.
#[derive(Clone, Copy, Debug)]
struct Layout {
    width: u32,
    /// What the rows' names take, and what is above the bars.
    names: f64,
    above: f64,
    row: f64,
    /// The sizes of text: of a row or a group, and of a column; without, columns have no heads.
    text: f64,
    column: Option<f64>,
    /// With title and legend. A page has them as text.
    alone: bool,
}

const ALONE: Layout = Layout {
    width: 960,
    names: 140.0,
    above: 104.0,
    row: 17.0,
    text: 12.0,
    column: Some(11.0),
    alone: true,
};
const WIDE: Layout =
    Layout { above: 52.0, row: 18.0, text: 14.5, column: Some(14.0), alone: false, ..ALONE };
/// For a telephone.
const NARROW: Layout = Layout {
    width: picture::NARROW.0,
    names: 110.0,
    above: 28.0,
    row: 20.0,
    text: 14.0,
    column: None,
    alone: false,
};

impl Outcomes {
    fn size(&self, layout: &Layout) -> (u32, u32) {
        let height = layout.above + layout.row * self.rows.len() as f64 + 12.0;
        (layout.width, height as u32)
    }

    /// The picture as a figure of a page, for wide and for narrow screens: title and legend are text, and its ink is the colour of
    /// the text around it.
    pub fn figure(&self) -> Result<String, String> {
        let keys: String =
            PARTS.iter().map(|&(name, colour)| picture::patch(colour, name)).collect();
        let columns = self.columns.join(", ");
        let title = picture::escape(&self.title);
        let caption = format!("{title}<br>{keys}<br>In each group from left to right: {columns}.");
        let [wide, narrow] = [&WIDE, &NARROW].map(|layout| {
            picture::svg(self.size(layout), &self.title, |root| self.draw(&root, None, layout, 1.0))
        });
        Ok(picture::figure(&caption, &wide?, &narrow?))
    }

    /// The picture as an SVG file of its own, on white, with the shares as JSON in its metadata.
    pub fn svg(&self) -> Result<String, String> {
        let svg = picture::svg(self.size(&ALONE), &self.title, |root| {
            self.draw(&root, Some(WHITE), &ALONE, 1.0)
        })?;
        let rows = self.rows.iter().map(|(name, cells)| (name.clone(), serde_json::json!(cells)));
        Ok(picture::on_paper(&svg, &serde_json::Value::Object(rows.collect()).to_string()))
    }

    /// The picture as a PNG file's bytes.
    pub fn png(&self) -> Result<Vec<u8>, String> {
        picture::png(self.size(&ALONE), |root| self.draw(&root, Some(WHITE), &ALONE, 2.0))
    }

    fn draw<DB: DrawingBackend>(
        &self,
        root: &DrawingArea<DB, Shift>,
        ground: Option<RGBColor>,
        layout: &Layout,
        scale: f64,
    ) -> Result<(), String> {
        let told = |error: DrawingAreaErrorKind<DB::ErrorType>| format!("{}: {error}", self.name);
        self.paint(root, ground, layout, scale).map_err(told)?;
        root.present().map_err(told)
    }

    fn paint<DB: DrawingBackend>(
        &self,
        root: &DrawingArea<DB, Shift>,
        ground: Option<RGBColor>,
        layout: &Layout,
        scale: f64,
    ) -> Result<(), DrawingAreaErrorKind<DB::ErrorType>> {
        if let Some(ground) = ground {
            root.fill(&ground)?;
        }
        let at = |x: f64, y: f64| ((x * scale).round() as i32, (y * scale).round() as i32);
        let text = |words: &str, x: f64, y: f64, size: f64, side: HPos| {
            let style = TextStyle::from((FONT, size * scale)).color(&INK);
            root.draw(&Text::new(
                words.to_owned(),
                at(x, y),
                style.pos(Pos::new(side, VPos::Center)),
            ))
        };
        let bar = |x: f64, y: f64, width: f64, height: f64, colour: RGBColor| {
            root.draw(&Rectangle::new([at(x, y), at(x + width, y + height)], colour.filled()))
        };
        let &Layout { names, above, row, .. } = layout;
        if layout.alone {
            text(&self.title, 16.0, 24.0, 19.0, HPos::Left)?;
            for (place, (name, colour)) in (0..).zip(PARTS) {
                let x = names + 90.0 * f64::from(place);
                bar(x, 42.0, 14.0, 12.0, colour)?;
                text(name, x + 20.0, 48.0, 13.0, HPos::Left)?;
            }
        }
        let space = layout.column.map_or(5.0, |_| 12.0);
        let group = (f64::from(layout.width) - names - 10.0) / self.groups.len() as f64;
        let column = (group - space) / self.columns.len() as f64;
        let left = |g: usize, c: usize| names + group * g as f64 + column * c as f64;
        let heads = above - layout.column.map_or(0.0, |_| 20.0);
        for (g, name) in self.groups.iter().enumerate() {
            text(name, left(g, 0), heads - 12.0, layout.text.max(13.0), HPos::Left)?;
            for (c, name) in self.columns.iter().enumerate() {
                if let Some(size) = layout.column {
                    text(name, left(g, c), above - 12.0, size, HPos::Left)?;
                }
            }
        }
        for (index, (name, cells)) in self.rows.iter().enumerate() {
            let y = above + row * index as f64;
            text(name, names - 8.0, y + row / 2.0 - 1.5, layout.text, HPos::Right)?;
            for (index, shares) in cells.iter().enumerate() {
                let mut x = left(index / self.columns.len(), index % self.columns.len());
                for (share, (_, colour)) in shares.iter().zip(PARTS) {
                    let width = share * (column - space / 4.0);
                    bar(x, y, width, row - 4.0, colour)?;
                    x += width;
                }
            }
        }
        Ok(())
    }
}
