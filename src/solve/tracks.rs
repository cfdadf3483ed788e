//! All the tones that are followed, and the assignment of measurements to tracks.
//!
//! Pairs of tracks and tones are made by nearest neighbours: held tracks before tentative ones, and the pair with the smallest distance in
//! gates first. A tone without a track starts one; a track without a tone goes on by its rate, see [`super::track`].

use super::track::{State, Track, Tracking, tells};
use crate::acquire::sample::Stamp;
use crate::list::{first, remove};
use crate::tone::lines::MOST;
use crate::tone::{Tone, Usable};
use heapless::Vec;

/// The largest number of tracks: the held ones, and an equal number of tentative ones.
const SLOTS: usize = 2 * MOST;

/// The distance, in bins, below which two tones cannot be separated (see [`crate::tone::lines`]).
pub const APART: f32 = 2.0;

/// A set of tracks, oldest first.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tracks {
    tracks: Vec<Track, SLOTS>,
    started: u32,
    last: Option<u32>,
}

/// A block, as a set of tracks needs it.
#[derive(Debug)]
pub struct TrackerBlock<'a, F> {
    /// Where and when the block was taken.
    pub stamp: &'a Stamp,
    /// One block in `every` belongs to this set: the number of segments of a chirp, or 1.
    pub every: u32,
    /// One bin in cycles per sample.
    pub bin: f32,
    /// The tones found in the whole band.
    pub tones: &'a [Tone],
    /// Looks for a tone within a half gate, in cycles per sample, of the given tone. Says, too, whether the tone passes the threshold of the
    /// whole band.
    pub find: F,
}

impl Tracks {
    /// No tracks.
    pub const fn new() -> Self {
        Self { tracks: Vec::new(), started: 0, last: None }
    }

    /// Every track, oldest first, including the tracks lost in this block.
    pub fn all(&self) -> &[Track] {
        &self.tracks
    }

    /// The tracks that are held.
    pub fn held(&self) -> impl Iterator<Item = &Track> {
        self.tracks.iter().filter(|track| track.state == State::Held)
    }

    /// The tone of the only track, if the last block measured it well.
    pub fn only(&self) -> Option<&Tone> {
        self.lone().map(|track| &track.tone)
    }

    /// The predicted frequency of the only track in the block after the last one, cycles per
    /// sample; `None` for any other block.
    pub fn expected(&self, stamp: &Stamp, every: u32) -> Option<f32> {
        let next = self.last?.wrapping_add(every.max(1)) == stamp.sequence && !stamp.gap;
        let track = self.lone()?;
        next.then(|| track.tone.frequency.cycles_f32() + track.rate())
    }

    fn lone(&self) -> Option<&Track> {
        let [track] = self.tracks.as_slice() else {
            return None;
        };
        let well = track.state == State::Held && track.tone.verdict.usable() == Usable::Yes;
        well.then_some(track)
    }

    /// Updates the only track by its tone in the block after the last one, like [`Tracks::step`]. Returns false and changes nothing if the
    /// tone is outside the gate.
    // Compiled once for all kinds and lengths of records, as both halves of a step are.
    #[inline(never)]
    pub fn lead(&mut self, stamp: &Stamp, tone: &Tone, tracking: &Tracking) -> bool {
        let [track] = self.tracks.as_mut_slice() else {
            return false;
        };
        let before = *track;
        track.predict(1, false, tracking);
        if track.distance(tone, tracking).is_none() {
            *track = before;
            return false;
        }
        track.update(tone, tone.snr > tracking.evident, tracking);
        self.last = Some(stamp.sequence);
        true
    }

    /// Takes a block.
    ///
    /// Every track advances by its rate. Tones and tracks are then paired: held tracks before
    /// tentative ones, and the nearest pair first, with distances in half gates. So two tracks that
    /// cross keep their tones as long as there are two tones. If fewer tones than tracks are left
    /// within two bins, the tracks there coast. A held track without a tone looks for one in its
    /// gate, with the lower threshold. The remaining tones start new tracks.
    pub fn step(
        &mut self,
        sight: TrackerBlock<impl FnMut(&Tone, f32) -> Option<(Tone, bool)>>,
        tracking: &Tracking,
    ) {
        let TrackerBlock { stamp, every, bin, tones, mut find } = sight;
        let all = tones;
        let (mut tones, mut seen) = self.paired(stamp, every, bin, tones, tracking);
        self.look(&mut seen, all, bin, tracking, &mut find);
        self.settle(&mut tones, &mut seen, bin, tracking);
    }

    /// Advances the tracks and gives each its tone. Returns the tones left over, and the tracks that have one.
    #[inline(never)]
    fn paired(
        &mut self,
        stamp: &Stamp,
        every: u32,
        bin: f32,
        tones: &[Tone],
        tracking: &Tracking,
    ) -> (Vec<Tone, MOST>, [bool; SLOTS]) {
        let blocks = self.elapsed(stamp.sequence, every);
        self.tracks.retain(|track| track.state != State::Lost);
        self.tracks.iter_mut().for_each(|track| track.predict(blocks, stamp.gap, tracking));
        let seen_well =
            tones.iter().filter(|tone| tone.verdict.usable() < Usable::No && tells(tone)).copied();
        let mut tones: Vec<Tone, MOST> = first(seen_well);
        let mut seen = [false; SLOTS];
        self.merge(&mut tones, &mut seen, bin);
        for state in [State::Held, State::Tentative] {
            self.pair(&mut tones, &mut seen, state, tracking);
        }
        (tones, seen)
    }

    /// Counts a miss for the tracks without a tone, and starts new tracks at the tones left over.
    #[inline(never)]
    fn settle(
        &mut self,
        tones: &mut Vec<Tone, MOST>,
        seen: &mut [bool; SLOTS],
        bin: f32,
        tracking: &Tracking,
    ) {
        for (track, seen) in self.tracks.iter_mut().zip(seen) {
            let apart = |tone: &Tone| track.innovation(tone);
            let nearest = tones.iter().map(apart).min_by(|a, b| a.abs().total_cmp(&b.abs()));
            match (*seen, nearest) {
                (true, _) => {}
                (false, Some(innovation)) => track.reject(innovation),
                (false, None) => track.miss(),
            }
        }
        self.crowd(tracking.most);
        for tone in tones.iter() {
            // A new line near a held track is a part of that track, or cannot be separated from it.
            if self.held().any(|track| track.innovation(tone).abs() < APART * bin) {
                continue;
            }
            let track = Track::start(self.started, tone, tracking);
            // If no slot is free, the tone waits for the next block.
            if self.tracks.push(track).is_ok() {
                self.started = self.started.wrapping_add(1);
            }
        }
    }

    /// Blocks of this set since the last one.
    fn elapsed(&mut self, sequence: u32, every: u32) -> u32 {
        let last = self.last.replace(sequence);
        let blocks = last.map_or(1, |last| sequence.wrapping_sub(last) / every.max(1));
        // If the sequence steps back or stands still, the device has restarted.
        if blocks > u32::MAX / 8 { 1 } else { blocks.max(1) }
    }

    /// Lets tracks coast where fewer tones than tracks are left, and drops those tones.
    fn merge(&mut self, tones: &mut Vec<Tone, MOST>, seen: &mut [bool; SLOTS], bin: f32) {
        let mut mixed = [false; MOST];
        for (tone, mixed) in tones.iter().zip(&mut mixed) {
            let near = |other: &Track| other.innovation(tone).abs() < APART * bin;
            let tracks = self.held().filter(|track| near(track)).count();
            let near = |other: &&Tone| tone.frequency.beyond(other.frequency).abs() < APART * bin;
            let here = tones.iter().filter(near).count();
            *mixed = tracks > here;
        }
        for (track, seen) in self.tracks.iter_mut().zip(seen) {
            let mut mixture = tones.iter().zip(mixed).filter(|(_, mixed)| *mixed);
            if mixture.any(|(tone, _)| track.innovation(tone).abs() < APART * bin) {
                track.coast();
                *seen = true;
            }
        }
        let mut index = 0;
        tones.retain(|_| {
            let keep = mixed.get(index).is_none_or(|mixed| !mixed);
            index += 1;
            keep
        });
    }

    /// Pairs tracks in one state with tones, nearest first.
    fn pair(
        &mut self,
        tones: &mut Vec<Tone, MOST>,
        seen: &mut [bool; SLOTS],
        state: State,
        tracking: &Tracking,
    ) {
        for _ in 0..MOST {
            let mut best: Option<(f32, usize, usize)> = None;
            for (index, track) in self.tracks.iter().enumerate() {
                if track.state != state || seen.get(index).is_none_or(|seen| *seen) {
                    continue;
                }
                for (number, tone) in tones.iter().enumerate() {
                    let Some(distance) = track.distance(tone, tracking) else {
                        continue;
                    };
                    if best.is_none_or(|(least, _, _)| distance < least) {
                        best = Some((distance, index, number));
                    }
                }
            }
            let Some((_, index, number)) = best else {
                return;
            };
            if let (Some(track), Some(tone)) = (self.tracks.get_mut(index), tones.get(number)) {
                track.update(tone, true, tracking);
            }
            if let Some(seen) = seen.get_mut(index) {
                *seen = true;
            }
            remove(tones, number);
        }
    }

    /// Lets held tracks without a tone look for one where they expect it.
    fn look(
        &mut self,
        seen: &mut [bool; SLOTS],
        tones: &[Tone],
        bin: f32,
        tracking: &Tracking,
        find: &mut impl FnMut(&Tone, f32) -> Option<(Tone, bool)>,
    ) {
        for index in 0..self.tracks.len() {
            let Some(&track) = self.tracks.get(index) else {
                return;
            };
            if track.state != State::Held || seen.get(index).is_none_or(|seen| *seen) {
                continue;
            }
            let Some((tone, alone)) = find(&track.tone, track.gate(tracking)) else {
                continue;
            };
            if track.distance(&tone, tracking).is_none() {
                continue;
            }
            // The skirt of a stronger line is no tone: `d` bins beside a line of amplitude `A` it is `A / (pi d)`.
            let skirt = |other: &Tone| {
                let apart = tone.frequency.beyond(other.frequency).abs();
                tone.amplitude * apart < other.amplitude * bin && apart > 0.5 * bin
            };
            if tones.iter().any(skirt) {
                continue;
            }
            // A tone that another track has taken is not taken twice.
            let taken = self.tracks.iter().zip(&*seen).any(|(other, seen)| {
                *seen && other.number != track.number && other.innovation(&tone).abs() < bin
            });
            if let Some(track) = self.tracks.get_mut(index) {
                if taken { track.coast() } else { track.update(&tone, alone, tracking) }
            }
            if let Some(seen) = seen.get_mut(index) {
                *seen = true;
            }
        }
    }

    /// Drops held tracks beyond `most`: first the track missed most often; between equals, the youngest.
    fn crowd(&mut self, most: usize) {
        for _ in 0..SLOTS {
            if self.held().count() <= most.clamp(1, MOST) {
                return;
            }
            let worst = self.held().map(|track| (track.misses, track.number)).max();
            self.tracks.retain(|track| Some((track.misses, track.number)) != worst);
        }
    }
}
