"""Frames of chirps, ranges by phase, ways, and the whole error of an answer."""

import json
import os
from dataclasses import asdict, make_dataclass

import numpy as np

from . import Chirp, _Front, _kind, _numbers, _picket, _tables
from ._checks import maybe, not_negative, number, pair, whole, wrong


def _checked(told):
    for name, value in asdict(told).items():
        if name.startswith("sigma_") or isinstance(told, Uncertainty):
            not_negative(name, value, "a standard deviation is 0 or more")
        else:
            number(name, value)


def _told(name, doc):
    """A class of numbers with the names that the library has for them, all 0 unless they are given."""
    fields = [(field, float, 0.0) for field in _picket.view_columns(name)]
    told = make_dataclass(name.capitalize(), fields, frozen=True, namespace={"__post_init__": _checked})
    told.__doc__, told.__module__ = doc, "picket_dsp"
    return told


def _pairs(name, told, kind):
    """Names and numbers for the native half."""
    if not isinstance(told, (kind, type(None))):
        raise wrong(name, told, f"give {kind.__name__}(...)")
    return None if told is None else [(name, float(value)) for name, value in asdict(told).items()]


class Uncertainty(_told("uncertainty", "")):
    """What is not known of a sensor, each as one standard deviation.

    clock_ppm: of the sample clock; carrier_ppm: of the carrier; slope_ppm: of the sweep's slope; angle_rad: of the angle between beam and
    motion; range_offset_m: of the range's offset; phase_rad: of the phase of a target at 0 m, for ranges by phase.
    """

    def budget(self, answers, *, angle_rad=0.0, blocks=1):
        """What each source makes of the answers' errors, and all of them together, a row for each answer.

        answers: rows with range_m or velocity_mps and their sigmas, as of Pipeline.blocks or Frame.targets; or of PhaseRanging.ranges,
            whose range depends on the carrier and the phase where it is sure.
        angle_rad: the angle for which velocities were solved. blocks: of the mean of so many blocks, which lessens the noise's part alone.

        Columns: uncertainty_range_m, uncertainty_velocity_mps (one standard deviation of all, k = 1, by JCGM 100), and those of noise, clock,
        carrier, slope, angle, range_offset, phase.
        """
        blocks, angle_rad = whole("blocks", blocks, 1, (1 << 32) - 1), number("angle_rad", angle_rad)
        answers = np.atleast_1d(answers)
        names = answers.dtype.names or ()
        if not {"range_m", "velocity_mps"} & set(names):
            raise ValueError("answers have no range_m and no velocity_mps: give rows of a scene")
        columns = ("range_m", "velocity_mps", "sigma_range_m", "sigma_velocity_mps")
        none = np.full(len(answers), np.nan)
        rows = [answers[name] if name in names else none for name in columns]
        rows = [np.nan_to_num(row) if name.startswith("sigma") else row for name, row in zip(columns, rows)]
        rows.append(np.where(answers["sure"], answers["spacing_m"], np.nan) if "sure" in names else none)
        table = _picket.budgets(np.stack(rows, -1).tolist(), _pairs("uncertainty", self, Uncertainty), angle_rad, blocks)
        return _tables.view(table, _picket.view_columns("budget"))


class Calibration(_told("calibration", "")):
    """What a measurement at a known distance tells of a sensor; all 0 is a perfect one.

    phase_rad, sigma_phase_rad: the phase of a target at 0 m on the rising ramp. offset_m, sigma_offset_m: what the frequency shows of it.
    slope_ppm, sigma_slope_ppm: the sweep's true slope over the stated one less 1, parts per million.
    """

    @classmethod
    def load(cls, path):
        """What picket analyze --known-m --save, or save(), wrote."""
        with open(path, encoding="utf-8") as file:
            try:
                told = json.load(file)
            except ValueError:
                told = None
        if not isinstance(told, dict) or "phase_rad" not in told:
            raise ValueError(f"{os.fspath(path)} is no calibration: picket analyze --known-m --save writes one")
        return cls(**{name: told[name] for name in asdict(cls()) if name in told})

    def save(self, path):
        """Writes it as JSON, for load() and picket analyze --calibration."""
        with open(path, "w", encoding="utf-8") as file:
            json.dump(asdict(self), file)


class Frame(_Front):
    """Finds the targets of frames of sawtooth chirps: several in each, also those that no single chirp shows.

    n: samples of a chirp. chirps: of a frame, 8, 16, ... 256. period_s: from one chirp to the next.
    scene: a Chirp with the shape "sawtooth". Its velocity_mps decides between the aliases of a velocity, which are half a wavelength a
        period apart (alias_mps); without bounds a target is "ambiguous" and lists them, unless it walks through cells.
    bins: (first, last), those that are kept of each chirp; all that have a range where it is not given.
    false_alarm: probability for each frame that noise alone shows a target; 1e-6 where it is not given.
    uncertainty: an Uncertainty; rows then have budgets. calibration: a Calibration; rows then have ranges by phase.
    The rest is as for Pipeline.
    """

    def __init__(
        self, n=256, rate_hz=None, codes=12, iq=False, scene=None, *, chirps=64, period_s=None, bins=None, false_alarm=None, uncertainty=None,
        calibration=None,
    ):
        if not isinstance(scene, Chirp) or scene.shape != "sawtooth":
            raise ValueError('a frame is of sawtooth chirps: scene=Chirp("sawtooth", ...)')
        super().__init__(n, rate_hz, codes, iq, None, scene, None, "i32", "float")
        least = scene.duration_s
        period = least if period_s is None else number("period_s", period_s, f"give at least a ramp's {least} s", lambda x: x >= least)
        bins = maybe(pair, "bins", bins, lambda name, bin: whole(name, bin, -4096, 4096))
        false_alarm = maybe(number, "false_alarm", false_alarm, "give a false-alarm probability, above 0, at most 0.5", lambda x: 0 < x <= 0.5)
        self._chirps = int(number("chirps", chirps, "a frame has 8, 16, ... 256 chirps", lambda x: x in (8, 16, 32, 64, 128, 256)))
        known = _pairs("uncertainty", uncertainty, Uncertainty), _pairs("calibration", calibration, Calibration)
        self._terms = (self._chirps, period, bins, false_alarm, *known)
        self._alias, self._bins = self._native(*self._rails(False)).framing(self._terms)

    @property
    def chirps(self):
        """Chirps of a frame."""
        return self._chirps

    @property
    def alias_mps(self):
        """From one alias of a velocity to the next, m/s."""
        return self._alias

    def _frames(self, array):
        """The chirps of each frame of one receiver after the other, and the number of receivers."""
        array = np.asarray(array)
        pairs = self._iq and array.dtype.kind != "c"
        sides = array.ndim - (1 if pairs else 0)
        if not 2 <= sides <= 4:
            raise ValueError("give (chirps, samples), (frames, chirps, samples) or (frames, chirps, receivers, samples)")
        receivers = 1
        if sides == 4:
            receivers = array.shape[2]
            array = np.moveaxis(array, 2, 0)
        axis = sides - 2
        there = array.shape[axis]
        if there < self._chirps or there % self._chirps and (sides > 2 or there != self._chirps):
            raise ValueError(f"the array has {there} chirps a frame, and chirps={self._chirps}: cut it, or give another number")
        return array.reshape((-1, *array.shape[axis + 1:])), receivers

    def targets(self, array, *, background=None):
        """The targets of each frame, the strongest first, as a structured array with a row for each.

        array: (chirps, samples), which may be several frames behind each other; (frames, chirps, samples); or (frames, chirps, receivers,
            samples), each receiver by itself. Complex numbers, or integers with a last side of 2, for I/Q; else real numbers.
        background: what background() gave; it is subtracted.

        Columns: frame, receiver, range_m, velocity_mps (in the middle of the frame), sigma_range_m, sigma_velocity_mps, covariance (m^2/s),
        verdict, usable, ambiguity, the candidates range_1_m, velocity_1_mps, odds_1 and so on (the aliases of the velocity); frequency_hz, sigma_hz,
        snr_db (per sample), amplitude, phase_rad, sigma_phase_rad of the beat in the middle of the frame, tone_verdict (without the
        aliases), reason, ln_chance. With an uncertainty budget_..., as Uncertainty.budget has them; with a calibration phase_..., as
        PhaseRanging.ranges has them.
        """
        chirps, receivers = self._frames(array)
        words, native, _ = self._words(chirps)
        still = [] if background is None else np.ravel(background)
        if len(still) not in (0, self._bins):
            raise ValueError(f"background has {len(still)} numbers for {self._bins} bins: take that of this frame's background()")
        still = [(float(x.real), float(x.imag)) for x in still]
        columns, rows = native.frames(words, self._terms, still)
        return _tables.frames(rows, columns, max(1, len(chirps) // self._chirps // receivers))

    def background(self, array):
        """What stands still in a frame without targets: a number for each kept bin, and its share of the power, 0 to 1."""
        chirps, _ = self._frames(array)
        words, native, _ = self._words(chirps)
        still, share = native.background(words, self._terms)
        return np.array(still, np.float32).view(np.complex64)[:, 0], share


class _Phases(_Front):
    """What the phases of blocks tell."""

    def _rows(self, samples, hop, missing, name, calibration=None, numbers=(0.0, 0.0)):
        words, native, rows = self._words(samples)
        asked = (name, _pairs("calibration", calibration, Calibration) or [], list(numbers))
        columns, table = native.phases(words, self._hop(hop, rows), asked, _numbers(missing))
        return _tables.view(table, columns)


class PhaseRanging(_Phases):
    """Ranges by the phase of a chirp's beats: micrometres, where the frequency shows a millimetre.

    scene: a Chirp. A sawtooth's targets are taken as at rest; a triangle or a trapezoid gives those that move as well.
    calibration: a Calibration, as calibrate() gives it.
    The rest is as for Pipeline.
    """

    def __init__(self, n=1024, rate_hz=None, codes=12, iq=False, scene=None, *, calibration=None, band_hz=None):
        if _kind(scene) != "chirp":
            raise ValueError("ranges by phase are of a Chirp")
        super().__init__(n, rate_hz, codes, iq, band_hz, scene, None, "i32", "float")
        _pairs("calibration", calibration, Calibration)
        self._calibration = Calibration() if calibration is None else calibration

    def ranges(self, samples, hop=None, *, missing=()):
        """The range of the strongest target of each chirp; samples, hop and missing are as for Pipeline.blocks.

        Columns: block (the chirp's last), range_m (by the phase if `sure`, else by the frequency), sigma_range_m, uncertainty_range_m (with the
        calibration's), velocity_mps, sigma_velocity_mps, by_frequency_m, sigma_by_frequency_m, sigma_by_phase_m, spacing_m (half a
        wavelength), turn_odds (of the cycle against all others; sure from 10,000 on), sure, verdict, usable, and four candidates range_1_m, odds_1
        and so on.
        """
        return self._rows(samples, hop, missing, "ranges", self._calibration)

    def calibrate(self, samples, known_m, sigma_m=0.0, hop=None):
        """The Calibration by a target at rest at a known distance, with one standard deviation of that: the mean over the chirps.

        The distance should be known to a tenth of a wavelength if ranges are to be absolute.
        """
        known = not_negative("known_m", known_m), not_negative("sigma_m", sigma_m)
        rows = self._rows(samples, hop, (), "calibration", None, known)
        if not len(rows):
            raise ValueError("no chirp has a tone that may be used")
        return Calibration(**{name: float(rows[0][name]) for name in asdict(Calibration())})


class Displacement(_Phases):
    """Follows the way of a target by the phase of its tone: micrometres, where a frequency shows millimetres.

    scene: a Doppler, whose blocks follow one another; or a Chirp with the shape "sawtooth" and a target that is slow: from chirp to chirp it
        turns the phase by less than most_turns of a turn (half a wavelength a turn), at most 0.25.
    The rest is as for Pipeline.
    """

    def __init__(self, n=1024, rate_hz=None, codes=12, iq=False, scene=None, *, most_turns=0.25, band_hz=None):
        if _kind(scene) == "tone" or isinstance(scene, Chirp) and scene.shape != "sawtooth":
            raise ValueError('ways are of a Doppler, or of a Chirp("sawtooth", ...)')
        super().__init__(n, rate_hz, codes, iq, band_hz, scene, None, "i32", "float")
        self._most = number("most_turns", most_turns, "give more than 0, at most 0.25", lambda x: 0 < x <= 0.25)

    def follow(self, samples, hop=None, *, missing=()):
        """The way of the strongest target, a row for each block with a tone; samples, hop and missing are as for Pipeline.blocks.

        Columns: block, displacement_m (since the start, positive when the target went away), sigma_displacement_m, start (displacements of
        different starts do not belong together), verdict, usable.
        """
        return self._rows(samples, hop, missing, "way", None, (self._most, 0.0))


class Sequence(_Phases):
    """Range and velocity of one target from sawtooth chirps that follow one another, by the phase of its beat from chirp to chirp.

    period: samples from one chirp's start to the next; n where it is not given. For several targets, or weak ones, take Frame.
    The rest is as for Pipeline.
    """

    def __init__(self, n=1024, rate_hz=None, codes=12, iq=False, scene=None, *, period=None, band_hz=None):
        if not isinstance(scene, Chirp) or scene.shape != "sawtooth":
            raise ValueError('a sequence is of sawtooth chirps: scene=Chirp("sawtooth", ...)')
        super().__init__(n, rate_hz, codes, iq, band_hz, scene, None, "i32", "float")
        self._period = self._n if period is None else whole("period", period, self._n, (1 << 32) - 1)

    def targets(self, samples):
        """What the chirps so far agree with, from the third on: a row for each target that they allow, the one nearest to the range's movement first.

        samples: (chirps, n), or (chirps, n, 2) for integers of I and Q; or one long array, of which a chirp's record begins each period.

        Columns: block (the chirp), range_m, velocity_mps, sigma_range_m, sigma_velocity_mps, verdict, usable, ambiguity and the candidates as of
        Frame.targets.
        """
        rows = np.asarray(samples)
        pairs = self._iq and rows.dtype.kind != "c"
        hop = None if rows.ndim - (1 if pairs else 0) == 2 else self._period
        return self._rows(samples, hop, (), "sequence", None, (float(self._period), 0.0))
