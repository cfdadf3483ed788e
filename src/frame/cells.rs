//! The bins of a frame's chirps, in the caller's memory.

use crate::spectrum::fft::integer::Point;
use crate::spectrum::view::View;
use core::mem::MaybeUninit;

/// Cells of complex numbers, `[re, im]`, in the caller's memory: [`FramePlan::cells`](super::FramePlan::cells) of them. All share one exponent.
#[derive(Debug)]
pub enum Cells<'a> {
    /// 16 bits a part: the strongest bin has 14 or 15, so rounding lies 90 dB below it.
    Narrow(&'a mut [[i16; 2]]),
    /// 32 bits a part: as the transform gives them.
    Wide(&'a mut [[i32; 2]]),
}

/// How far a frame in progress is: what it holds beside its plan and its cells.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Filled {
    /// A cell times `2^exponent` is in codes.
    pub(super) exponent: i32,
    /// The chirps that are stored.
    pub(super) chirps: usize,
    /// Their samples that touch a rail.
    pub(super) clipped: u32,
}

impl Filled {
    /// A frame that begins.
    pub const NONE: Self = Self { exponent: 0, chirps: 0, clipped: 0 };
}

/// Bins that are read at a time.
const CHUNK: usize = 16;

/// The cells of a frame in progress. Those of a bin are neighbours, in the order of the chirps.
#[derive(Debug)]
pub(super) struct Store<'a> {
    cells: Cells<'a>,
    chirps: usize,
    bins: usize,
    pub filled: Filled,
}

impl<'a> Store<'a> {
    /// `None` if there are not enough cells.
    pub fn new(cells: Cells<'a>, chirps: usize, bins: usize) -> Option<Self> {
        let room = match &cells {
            Cells::Narrow(cells) => cells.len(),
            Cells::Wide(cells) => cells.len(),
        };
        (room >= chirps * bins).then_some(Self { cells, chirps, bins, filled: Filled::NONE })
    }

    /// Stores the bins of a chirp from `first` on, of whose samples so many touch a rail.
    pub fn push(&mut self, view: &View, first: i32, clipped: u32) {
        let narrow = matches!(self.cells, Cells::Narrow(_));
        self.fit_in(view, first, if narrow { 15 } else { 31 });
        let shift = self.filled.exponent.wrapping_sub(view.exponent).clamp(0, 31) as u32;
        let half = (1i32 << shift) >> 1;
        let (chirps, chirp) = (self.chirps, self.filled.chirps);
        let mut bin = 0;
        while bin < self.bins {
            let mut places = [const { MaybeUninit::uninit() }; CHUNK];
            for &point in view.fill(first.wrapping_add(bin as i32), &mut places) {
                let rounded = point.map(|part| part.saturating_add(half) >> shift);
                let place = bin * chirps + chirp;
                if bin < self.bins {
                    match &mut self.cells {
                        Cells::Narrow(cells) => {
                            if let Some(cell) = cells.get_mut(place) {
                                *cell = rounded.map(|part| part.clamp(-32768, 32767) as i16);
                            }
                        }
                        Cells::Wide(cells) => {
                            if let Some(cell) = cells.get_mut(place) {
                                *cell = rounded;
                            }
                        }
                    }
                }
                bin += 1;
            }
        }
        self.filled.chirps += 1;
        self.filled.clipped = self.filled.clipped.saturating_add(clipped);
    }

    /// Sets the exponent by the first chirp, with a spare bit, and raises it for a louder one.
    fn fit_in(&mut self, view: &View, first: i32, room: u32) {
        let mut all = 0;
        let mut bin = 0;
        while bin < self.bins {
            let mut places = [const { MaybeUninit::uninit() }; CHUNK];
            let read: &[Point] = view.fill(first.wrapping_add(bin as i32), &mut places);
            let beyond = self.bins - bin;
            for part in read.iter().take(beyond).flatten() {
                all |= (part ^ (part >> 31)) as u32;
            }
            bin += CHUNK;
        }
        let bits = 33 - all.leading_zeros();
        let spare = u32::from(self.filled.chirps == 0 && room < 31);
        let needed = view.exponent.wrapping_add((bits + spare).saturating_sub(room) as i32);
        if self.filled.chirps == 0 {
            self.filled.exponent = needed;
        } else if needed > self.filled.exponent {
            let more = needed.wrapping_sub(self.filled.exponent).clamp(1, 31) as u32;
            self.lower(more);
            self.filled.exponent = needed;
        }
    }

    /// Divides the stored cells by two to the power `times`, rounded.
    #[cold]
    fn lower(&mut self, times: u32) {
        let half = (1i32 << times) >> 1;
        match &mut self.cells {
            Cells::Narrow(cells) => {
                for part in cells.as_flattened_mut() {
                    *part = (i32::from(*part).saturating_add(half) >> times) as i16;
                }
            }
            Cells::Wide(cells) => {
                for part in cells.as_flattened_mut() {
                    *part = part.saturating_add(half) >> times;
                }
            }
        }
    }

    /// The cell of a bin, counted from the first one, in a chirp; 0 for a bin that is not kept.
    pub fn get(&self, bin: i32, chirp: usize) -> [f32; 2] {
        let Ok(bin) = usize::try_from(bin) else { return [0.0; 2] };
        if bin >= self.bins {
            return [0.0; 2];
        }
        let place = bin * self.chirps + chirp;
        match &self.cells {
            Cells::Narrow(cells) => cells.get(place).copied().unwrap_or_default().map(f32::from),
            Cells::Wide(cells) => {
                cells.get(place).copied().unwrap_or_default().map(|part| part as f32)
            }
        }
    }
}
