//! Figures that a document states, held against what was measured.

/// A stated figure is rounded, or of another compiler of the same language: so far it may be off.
const ROUNDING: f64 = 0.02;

/// A document that states figures.
pub struct Document {
    name: &'static str,
    /// Its words, one space apart, however its lines are broken.
    text: String,
}

impl Document {
    /// The README.
    pub fn readme() -> Self {
        Self::new("README.md", include_str!("../../README.md"))
    }

    /// The page on speed and size.
    pub fn performance() -> Self {
        Self::new("docs/performance.md", include_str!("../../docs/performance.md"))
    }

    /// The page on precision.
    pub fn precision() -> Self {
        Self::new("docs/precision.md", include_str!("../../docs/precision.md"))
    }

    /// The instructions for the board.
    pub fn board() -> Self {
        Self::new("docs/board.md", include_str!("../../docs/board.md"))
    }

    /// The programs for boards of one's own.
    pub fn own_board() -> Self {
        Self::new("docs/own-board.md", include_str!("../../docs/own-board.md"))
    }

    /// The instructions for the Pico.
    pub fn pico() -> Self {
        Self::new("docs/pico.md", include_str!("../../docs/pico.md"))
    }

    /// The instructions for another board.
    pub fn porting() -> Self {
        Self::new("docs/porting.md", include_str!("../../docs/porting.md"))
    }

    /// The page on Python.
    pub fn python() -> Self {
        Self::new("docs/python.md", include_str!("../../docs/python.md"))
    }

    fn new(name: &'static str, text: &str) -> Self {
        Self { name, text: text.split_whitespace().collect::<Vec<_>>().join(" ") }
    }

    /// Panics unless the document has this phrase with these figures, one for each `#`.
    pub fn assert_states(&self, phrase: &str, figures: &[f64]) {
        let stated = self.figures(phrase);
        println!("{}, {phrase}: {stated:?}, measured {figures:?}", self.name);
        let right = |(stated, figure): (&f64, &f64)| (stated / figure - 1.0).abs() <= ROUNDING;
        let all = stated.len() == figures.len() && stated.iter().zip(figures).all(right);
        assert!(all, "{} must say: {phrase} with {figures:?}, and says {stated:?}", self.name);
    }

    /// The figures at the signs `#` of the phrase where it stands first; none where it does not stand.
    fn figures(&self, phrase: &str) -> Vec<f64> {
        let parts: Vec<&str> = phrase.split('#').collect();
        let starts = self.text.match_indices(parts[0]).map(|(start, _)| start);
        starts.filter_map(|start| figures(&self.text[start..], &parts)).next().unwrap_or_default()
    }
}

fn figures(text: &str, parts: &[&str]) -> Option<Vec<f64>> {
    let (first, others) = parts.split_first()?;
    let mut rest = text.strip_prefix(first)?;
    let mut figures = Vec::new();
    for part in others {
        let end = rest.find(|c: char| !matches!(c, '0'..='9' | ',' | '.')).unwrap_or(rest.len());
        let (figure, tail) = rest.split_at(end);
        // A comma or a full stop after the figure belongs to the sentence.
        let trimmed = figure.trim_end_matches([',', '.']);
        figures.push(trimmed.replace(',', "").parse().ok()?);
        rest = rest.get(trimmed.len()..).filter(|_| !tail.is_empty() || part.is_empty())?;
        rest = rest.strip_prefix(part)?;
    }
    Some(figures)
}
