//! A picture of outcomes: a bar for each cell, its parts the shares of right, flagged and lie.

use super::picture::{self, COLOURS, FONT, INK};
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use std::path::Path;

/// Shares of right, flagged and lie.
pub type Shares = [f64; 3];

const PARTS: [(&str, RGBColor); 3] =
    [("right", COLOURS[0]), ("flagged", RGBColor(196, 200, 205)), ("lie", COLOURS[1])];

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

const WIDTH: u32 = 960;
const LABELS: f64 = 140.0;
const HEAD: f64 = 104.0;
const ROW: f64 = 17.0;

impl Outcomes {
    fn size(&self) -> (u32, u32) {
        (WIDTH, (HEAD + ROW * self.rows.len() as f64 + 12.0) as u32)
    }

    /// The picture as SVG without a background, its ink the colour of the text around it.
    pub fn inline_svg(&self) -> Result<String, String> {
        let svg = picture::svg(self.size(), &self.title, |root| self.draw(&root, None, 1.0))?;
        Ok(picture::inline(&svg))
    }

    /// The picture as an SVG file of its own, on white, with the shares as JSON in its metadata.
    pub fn svg(&self) -> Result<String, String> {
        let svg =
            picture::svg(self.size(), &self.title, |root| self.draw(&root, Some(WHITE), 1.0))?;
        let rows = self.rows.iter().map(|(name, cells)| (name.clone(), serde_json::json!(cells)));
        Ok(picture::on_paper(&svg, &serde_json::Value::Object(rows.collect()).to_string()))
    }

    /// The picture as a PNG file.
    pub fn png(&self, file: &Path) -> Result<(), String> {
        picture::png(self.size(), file, |root| self.draw(&root, Some(WHITE), 2.0))
    }

    fn draw<DB: DrawingBackend>(
        &self,
        root: &DrawingArea<DB, Shift>,
        ground: Option<RGBColor>,
        scale: f64,
    ) -> Result<(), String> {
        let told = |error: DrawingAreaErrorKind<DB::ErrorType>| format!("{}: {error}", self.name);
        self.paint(root, ground, scale).map_err(told)?;
        root.present().map_err(told)
    }

    fn paint<DB: DrawingBackend>(
        &self,
        root: &DrawingArea<DB, Shift>,
        ground: Option<RGBColor>,
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
        text(&self.title, 16.0, 24.0, 19.0, HPos::Left)?;
        for (place, (name, colour)) in (0..).zip(PARTS) {
            let x = LABELS + 90.0 * f64::from(place);
            bar(x, 42.0, 14.0, 12.0, colour)?;
            text(name, x + 20.0, 48.0, 13.0, HPos::Left)?;
        }
        let group = (f64::from(WIDTH) - LABELS - 10.0) / self.groups.len() as f64;
        let column = (group - 12.0) / self.columns.len() as f64;
        let left = |g: usize, c: usize| LABELS + group * g as f64 + column * c as f64;
        for (g, name) in self.groups.iter().enumerate() {
            text(name, left(g, 0), 72.0, 13.0, HPos::Left)?;
            for (c, name) in self.columns.iter().enumerate() {
                text(name, left(g, c), 92.0, 11.0, HPos::Left)?;
            }
        }
        for (row, (name, cells)) in self.rows.iter().enumerate() {
            let y = HEAD + ROW * row as f64;
            text(name, LABELS - 8.0, y + 7.0, 12.0, HPos::Right)?;
            for (index, shares) in cells.iter().enumerate() {
                let mut x = left(index / self.columns.len(), index % self.columns.len());
                for (share, (_, colour)) in shares.iter().zip(PARTS) {
                    let width = share * (column - 3.0);
                    bar(x, y, width, ROW - 4.0, colour)?;
                    x += width;
                }
            }
        }
        Ok(())
    }
}
