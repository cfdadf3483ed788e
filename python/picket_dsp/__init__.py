"""Picket: the frequency of a tone in ADC samples, with the standard deviation of its error and a verdict.

    >>> import numpy as np, picket_dsp
    >>> samples = np.round(900 * np.sin(0.131 * np.arange(4096))).astype(np.int16)
    >>> answers = picket_dsp.Pipeline(n=1024, rate_hz=48e3, codes=12).blocks(samples)
    >>> answers["verdict"].tolist()
    ['good', 'good', 'good', 'good']
    >>> answers[["frequency_hz", "sigma_hz", "verdict"]][:2]
            frequency_hz  verdict
    1000.76696 ± 0.00050     good
    1000.76570 ± 0.00047     good
    [rows: 2; columns: 3 of 3]

Every answer has `sigma_hz`, one standard deviation of its frequency, a `verdict`, and `usable`: whether the verdict says that the
error is within sigma. `VERDICTS` says in a sentence what each verdict means.
"""

import json
import math
import os
import warnings
from dataclasses import KW_ONLY, dataclass

import numpy as np

from . import _picket, _tables
from ._answers import Answers
from ._checks import maybe, not_negative, number, one_of, pair, positive, whole, wrong
from ._picket import __version__

__all__ = [
    "Accumulator", "Answers", "BurstProcessor", "Calibration", "Chirp", "Displacement", "Doppler", "Frame", "METHODS", "PhaseRanging",
    "Pipeline", "Sequence", "Tracker", "Uncertainty", "VERDICTS", "analyze", "explain", "read_recording", "read_telemetry", "simulate", "__version__",
]

#: What each verdict means, from best to worst: its name, and a sentence.
VERDICTS = {name: sentence for _, name, _, _, sentence in _tables.VERDICTS}

_METHODS = _picket.methods()

#: What each method of estimation does: its name, and a sentence.
METHODS = {name: sentence for name, _, sentence in _METHODS}
_KINDS = {name: kind for name, kind, _ in _METHODS}

_SPEED_OF_LIGHT = 299_792_458.0


_MIXINGS, _SHAPES = ("rx-conj-tx", "tx-conj-rx"), ("trapezoid", "triangle", "sawtooth")


def _wavelength(wavelength_m, carrier_hz):
    if (wavelength_m is None) == (carrier_hz is None):
        raise ValueError(f"wavelength_m={wavelength_m}, carrier_hz={carrier_hz}: give one of them")
    if wavelength_m is None:
        return _SPEED_OF_LIGHT / positive("carrier_hz", carrier_hz)
    # Longer ones are of below 300 Hz: a carrier that was taken for a wavelength.
    return number("wavelength_m", wavelength_m, "give metres above 0, or carrier_hz", lambda x: 0 < x < 1e6)


def _bound(name, bound):
    low, high = pair(name, bound)
    if low > high:
        raise wrong(name, bound, "the low one first")
    return low, high


@dataclass(frozen=True)
class Doppler:
    """Light, radio or sound scattered by a moving target: answers have a velocity.

    wavelength_m or carrier_hz: of the wave; for sound give the wavelength.
    angle_rad: between beam and motion, below a right angle.
    mixing: for I/Q samples, "rx-conj-tx" if an approaching target's shift is positive, "tx-conj-rx" if it is negative.
    """

    wavelength_m: float | None = None
    angle_rad: float = 0.0
    mixing: str = "rx-conj-tx"
    carrier_hz: float | None = None

    def __post_init__(self):
        self._terms()

    def _terms(self):
        wavelength = _wavelength(self.wavelength_m, self.carrier_hz)
        angle = number("angle_rad", self.angle_rad, "give less than a right angle, rad", lambda x: abs(x) < math.pi / 2)
        return ("doppler", wavelength, angle, 0.0, 0.0, 0.0, 0.0, "trapezoid", one_of("mixing", self.mixing, _MIXINGS), [None, None])


@dataclass(frozen=True)
class Chirp:
    """A frequency-modulated continuous wave: answers have a range and a velocity. One block is one segment, in order.

    shape: "trapezoid" (up, flat, down), "triangle" (up, down) or "sawtooth" (up), the one argument without a name: Chirp("sawtooth", ...).
    wavelength_m or carrier_hz: at the bottom of a ramp.
    bandwidth_hz: how far a ramp rises.
    duration_s: of each segment.
    guard_s: from a segment's start to the first sample of its block.
    mixing: as for Doppler.
    sweep_curvature: how far the middle of a ramp lies above a straight one, as a share of the bandwidth.
    range_m, velocity_mps: (low, high), what a target may have, where that is known. A bound decides where the waveform leaves several
        targets: without one a sawtooth's range is "ambiguous", and so is a first triangle of real samples.
    """

    shape: str = "trapezoid"
    _: KW_ONLY
    bandwidth_hz: float
    duration_s: float
    wavelength_m: float | None = None
    guard_s: float = 0.0
    mixing: str = "tx-conj-rx"
    sweep_curvature: float = 0.0
    carrier_hz: float | None = None
    range_m: tuple[float, float] | None = None
    velocity_mps: tuple[float, float] | None = None

    def __post_init__(self):
        self._terms()

    def _terms(self):
        numbers = (
            positive("bandwidth_hz", self.bandwidth_hz),
            positive("duration_s", self.duration_s),
            number("guard_s", self.guard_s, "give 0 or more, less than duration_s", lambda x: 0 <= x < self.duration_s),
            number("sweep_curvature", self.sweep_curvature, "give less than 1/4", lambda x: abs(x) < 0.25),
        )
        words = (one_of("shape", self.shape, _SHAPES), one_of("mixing", self.mixing, _MIXINGS))
        bounds = [maybe(_bound, name, getattr(self, name)) for name in ("range_m", "velocity_mps")]
        return ("chirp", _wavelength(self.wavelength_m, self.carrier_hz), 0.0, *numbers, *words, bounds)


def _numbers(missing):
    """The numbers of missing samples, in order."""
    array = np.atleast_1d(missing)
    if array.size and (array.dtype.kind not in "iu" or array.min() < 0):
        raise wrong("missing", missing, "give the numbers of samples, from 0 on: np.flatnonzero(mask)")
    return np.unique(array.astype(np.int64)).tolist()


def _kind(scene):
    if scene is None:
        return "tone"
    if isinstance(scene, (Doppler, Chirp)):
        return scene._terms()[0]
    raise wrong("scene", scene, "give a Doppler or a Chirp")


class _Front:
    """What a pipeline and a tracker have in common: a configuration, and how samples become the converter's codes."""

    def __init__(
        self, n, rate_hz, codes, iq, band_hz, scene, false_alarm, engine, arithmetic, effort=3, following=None, carrier=(0.0, 0.0),
        method="least-squares",
    ):
        if rate_hz is None:
            raise ValueError("rate_hz is not given: add the converter's samples per second")
        self._n = whole("n", n, 0, 1 << 32, "a block has 64, 128, ... 4096 samples")
        self._rate_hz = number("rate_hz", rate_hz, "give the sample rate in Hz")
        self._iq, self._scene_kind = bool(number("iq", iq, "give True or False", lambda x: x in (0, 1))), _kind(scene)
        self._codes = codes
        terms = scene._terms() if scene is not None else None
        band = maybe(pair, "band_hz", band_hz)
        false_alarm = maybe(number, "false_alarm", false_alarm, "give a probability, 0 to 0.5")
        one_of("engine", engine, ("i32", "f32"))
        one_of("arithmetic", arithmetic, ("float", "fixed"))
        effort = whole("effort", effort, 0, 3, "give the most rounds, 0 to 3")
        one_of("method", method, list(METHODS))
        # Least squares has a form for either kind, and either name stands for both.
        if not method.startswith("least-squares") and _KINDS[method] not in ("both", "iq" if self._iq else "real"):
            raise wrong("method", method, f"it is for {'real' if self._iq else 'I/Q'} samples alone")

        def make(low, high):
            return _picket.Native(
                self._n, self._rate_hz, low, high, self._iq, engine, arithmetic, effort, band, false_alarm, terms, following, carrier, method
            )

        self._make, self._natives = make, {}
        self._native(*self._rails(False))

    @property
    def n(self):
        """Samples in a block."""
        return self._n

    @property
    def rate_hz(self):
        """Samples per second."""
        return self._rate_hz

    def __repr__(self):
        iq = ", iq=True" if self._iq else ""
        return f"{type(self).__name__}(n={self._n}, rate_hz={self._rate_hz:g}, codes={self._codes}{iq})"

    def _rails(self, unsigned):
        """The lowest and the highest code."""
        if isinstance(self._codes, (tuple, list)):
            cure = "give the low one first, both within 16 bits"
            low, high = pair("codes", self._codes, lambda name, code: whole(name, code, -32768, 32767, cure))
            if not low < high:
                raise wrong("codes", self._codes, cure)
            return low, high
        bits = whole("codes", self._codes, 8, 16, "a converter has 8 to 16 bits, or give (low, high)")
        if unsigned and bits < 16:
            return 0, (1 << bits) - 1
        return -(1 << (bits - 1)), (1 << (bits - 1)) - 1

    def _native(self, low, high):
        if (low, high) not in self._natives:
            self._natives[low, high] = self._make(low, high)
        return self._natives[low, high]

    def _words(self, samples):
        """The words of an array, I and Q in turn, with the native half for their codes; and whether each row is a block."""
        array = np.asarray(samples)
        if array.dtype.kind == "c":
            if not self._iq:
                raise ValueError("the samples are complex: give iq=True, or take their real part")
            array = np.stack([array.real, array.imag], axis=-1)
        elif self._iq and (array.ndim < 2 or array.shape[-1] != 2):
            raise ValueError("iq=True needs complex samples, or integers of the shape (samples, 2)")
        parts = 2 if self._iq else 1
        rows = array.ndim - (1 if self._iq else 0) == 2
        if array.ndim - (1 if self._iq else 0) > 2 or array.ndim == 0:
            raise ValueError("samples are one array, or one row a block")
        if rows and array.shape[1] != self._n:
            raise ValueError(f"a row has {array.shape[1]} samples, and a block {self._n}: give n={array.shape[1]}, or one long array")
        unsigned = array.dtype.kind == "u"
        low, high = self._rails(unsigned)
        if array.dtype.kind == "f":
            if not np.isfinite(array).all():
                raise ValueError("a sample is not a number: remove it and its block")
            largest = np.abs(array).max(initial=0.0)
            if 0 < largest < 1.5:
                raise ValueError("samples are too small for integers: multiply them by the codes of full scale, such as 2**15")
            array = np.rint(array)
        elif array.dtype.kind not in "iu":
            raise ValueError(f"samples are integers, floats or complex numbers, not {array.dtype}")
        elif unsigned and not isinstance(self._codes, (tuple, list)) and int(self._codes) == 16:
            # Codes of 16 bits from 0 on count from the middle, as the library's framer has them.
            if array.size and array.max() > 0xFFFF:
                raise ValueError("samples exceed 0..65535: they are wider than 16 bits")
            array = array.astype(np.int64) - 0x8000
        if array.size and (array.min() < low or array.max() > high):
            raise ValueError(self._beyond(int(array.min()), int(array.max()), low, high))
        words = np.ascontiguousarray(array, dtype=np.int16).reshape(-1)
        if words.size // parts < self._n:
            raise ValueError(f"{words.size // parts} samples are fewer than a block's {self._n}: give a smaller n")
        return words, self._native(low, high), rows

    def _beyond(self, least, most, low, high):
        """The error of samples from `least` to `most` with codes from `low` to `high`, and its cure."""
        bits = next((bits for bits in range(8, 17) if -(1 << (bits - 1)) <= least and most < 1 << (bits - 1)), None)
        if least >= 0 and (up := max(8, most.bit_length())) <= 15:
            cure = f"for a converter that counts from 0 give codes=(0, {(1 << up) - 1})"
        elif bits is not None:
            cure = f"give codes={bits}"
        else:
            cure = "they are wider than 16 bits: divide them, or take their upper bits"
        largest = most if most > high else least
        return f"a sample is {largest}, but codes={self._codes} of this array are {low} to {high}: {cure}"

    def _hop(self, hop, rows):
        if hop is None:
            return self._n
        if rows:
            raise ValueError("one row a block has no hop: give one long array")
        return whole("hop", hop, 1, (1 << 32) - 1)


class Pipeline(_Front):
    """Measures the strongest tone of every block of samples.

    n: samples in a block: 64, 128, 256, 512, 1024, 2048 or 4096.
    rate_hz: samples per second.
    codes: bits of the converter, 8 to 16, or its (lowest, highest) code. Bits count from 0 for unsigned arrays.
    iq: the samples are I and Q: complex numbers, or integers of the shape (samples, 2).
    band_hz: (low, high), the band that is searched; I/Q bands may be negative.
    scene: a Doppler or a Chirp; answers then have velocities or ranges.
    false_alarm: probability that a block of noise passes for a tone.
    engine: the transform: "i32" or "f32".
    arithmetic: "float", or "fixed" as on a core without a floating-point unit.
    effort: the most rounds of the joint fit for a line that is no steady tone, 0 to 3: each joins one cause. Fewer blocks are unresolved with more.
        A board has 2 unless told otherwise. `lines` is the same at every effort.
    linewidth_hz: the laser's linewidth, full width at half maximum; envelope_hz: the bandwidth of the echo's envelope, as of speckle,
        likewise. Sigma covers both.
    method: the method of estimation, one of `METHODS`. The others are for comparisons with least squares: their sigma covers their bias.

    Floats are in codes and are rounded. A configuration that cannot work is a ValueError that says why.
    """

    def __init__(
        self, n=1024, rate_hz=None, codes=12, iq=False, band_hz=None, scene=None, *, false_alarm=None, engine="i32", arithmetic="float",
        effort=3, linewidth_hz=0.0, envelope_hz=0.0, method="least-squares",
    ):
        carrier = (number("linewidth_hz", linewidth_hz), number("envelope_hz", envelope_hz))
        super().__init__(n, rate_hz, codes, iq, band_hz, scene, false_alarm, engine, arithmetic, effort, carrier=carrier, method=method)

    def blocks(self, samples, hop=None, *, phase=False, threads=None, missing=()):
        """The strongest tone of every block, as a structured array with a row for each.

        samples: a long array, cut into blocks; or one row a block, of the shape (blocks, n), (blocks, n, 2) for integers of I and Q.
        hop: samples from one block's start to the next; n where it is not given.
        phase: whether `phase` and `sigma_phase` are measured (radians, at sample n/2); NaN otherwise.
        threads: 1 for this thread alone; all cores where it is not given. The answers are the same.
        missing: the numbers of samples that stand for missing ones; a block with one of them has the verdict "gap".

        Columns: block, time_s (the block's middle), gap, clipped (samples at a rail), frequency_hz, sigma_hz, snr_db, amplitude
        (codes), verdict, usable, reason (all that applies, the worst first), phase, sigma_phase; with a scene velocity_mps,
        sigma_velocity_mps, target_verdict, target_usable; with a Chirp segment, range_m, sigma_range_m, ambiguity and four candidates,
        the most probable first (range_1_m, velocity_1_mps, odds_1 and so on), too, in the row of a chirp's last block. `answers.to_pandas()` is a DataFrame.
        """
        words, native, rows = self._words(samples)
        threads = (os.cpu_count() or 1) if threads is None else whole("threads", threads, 1, 1 << 16)
        table = native.blocks(words, self._hop(hop, rows), bool(phase), threads, _numbers(missing))
        return _tables.blocks(table, self._n, self._rate_hz, self._scene_kind)

    def harmonics(self, samples, order=10, hop=None):
        """The fundamental of every block's harmonics up to `order`, at most 32, as a structured array with a row for each.

        samples, hop: as for `blocks`.

        Columns: block, time_s (the block's middle), frequency_hz, sigma_hz, snr_db (of all lines together), amplitude (of order 1; 0 if it is
        not seen), verdict, usable, reason, orders (those seen: bit 0 is the fundamental itself).
        """
        words, native, rows = self._words(samples)
        order = whole("order", order, 1, 32)
        return _tables.harmonics(native.harmonics(words, self._hop(hop, rows), order), self._n, self._rate_hz)

    def lines(self, block, most=4):
        """All tones of one block, at most `most` and 4, the strongest first, each with its phase at sample n/2.

        Columns: frequency_hz, sigma_hz, snr_db, amplitude, verdict, usable, reason, phase, sigma_phase.
        """
        most = whole("most", most, 1, 4)
        words, native = self._one(block)
        return _tables.lines(native.lines(words, most))

    def explain(self, block):
        """Every test behind the verdict on one block, in the order in which they are made.

        Columns: fit (which one is judged), test, value, limit, outcome. The rows whose fit is "verdict" say which verdicts apply.
        """
        words, native = self._one(block)
        return _tables.tests(native.explain(words)[1])

    def _one(self, block):
        words, native, _ = self._words(block)
        samples = words.size // (2 if self._iq else 1)
        if samples != self._n:
            raise ValueError(f"a block has {self._n} samples, not {samples}: blocks() takes longer arrays")
        return words, native


class Tracker(_Front):
    """Follows tones from block to block.

    most: tones followed at once, 1 to 4.
    rate_bins: sigma of a new target's rate, bins per block.
    refresh: one block in `refresh` is searched whole while one tone is locked; 0 searches every block.
    The rest is as for Pipeline.
    """

    def __init__(
        self, n=1024, rate_hz=None, codes=12, iq=False, band_hz=None, scene=None, *, most=1, rate_bins=2.0, refresh=0,
        false_alarm=None, arithmetic="float", effort=3, linewidth_hz=0.0, envelope_hz=0.0,
    ):
        following = (number("rate_bins", rate_bins), whole("most", most, 1, 4), whole("refresh", refresh, 0, 255))
        super().__init__(
            n, rate_hz, codes, iq, band_hz, scene, false_alarm, "i32", arithmetic, effort, following,
            (number("linewidth_hz", linewidth_hz), number("envelope_hz", envelope_hz)),
        )

    def follow(self, samples, hop=None):
        """Follows the tones of a recording from its start.

        Returns (blocks, tracks, targets): every block as Pipeline.blocks has it, every track after every block, and what the held
        tracks amount to in the scene (after the last block of each chirp).

        Columns of tracks: time_s, track (its number), state ("tentative", "held", "lost"), age, misses, rate_hz_per_block, and those
        of a tone, filtered. Of targets: time_s, track, and those of the scene.
        """
        words, native, rows = self._words(samples)
        blocks, tracks, targets = native.track(words, self._hop(hop, rows))
        return (
            _tables.blocks(blocks, self._n, self._rate_hz, self._scene_kind),
            _tables.tracks(tracks, self._n, self._rate_hz),
            _tables.targets(targets, self._n, self._rate_hz, self._scene_kind),
        )


class Accumulator(_Front):
    """Adds the spectra of many blocks, without their phases, for echoes too weak for one block.

    blocks: of a sum, 1 to 65536. A line is found 5 dB weaker for each ten times as many.
    segment: with a Chirp the segment whose blocks are added, "up", "flat" or "down".
    drift_bins: bins by which the line moves from one block to the next.
    false_alarm: probability for each sum that noise passes for a tone; 1e-6 where it is not given.
    The rest is as for Pipeline.
    """

    def __init__(
        self, n=1024, rate_hz=None, codes=12, iq=False, band_hz=None, scene=None, *, blocks=100, segment=None, drift_bins=0.0,
        false_alarm=None, arithmetic="float",
    ):
        if segment not in (None, "up", "flat", "down") or (segment is None) != (_kind(scene) != "chirp"):
            raise wrong("segment", segment, "give up, flat or down with a Chirp, and None without")
        super().__init__(n, rate_hz, codes, iq, band_hz, scene, None, "i32", arithmetic)
        false_alarm = maybe(number, "false_alarm", false_alarm, "give a probability, above 0, at most 0.5", lambda x: 0 < x <= 0.5)
        place = (None, "up", "flat", "down").index(segment)
        self._terms = (whole("blocks", blocks, 1, 65536), place, number("drift_bins", drift_bins), false_alarm)

    def sums(self, samples, hop=None):
        """One row for each complete sum of blocks; samples and hop are as for Pipeline.blocks.

        Columns: time_s (the first block's first sample), blocks, ln_chance (natural logarithm of the probability that noise alone has
        such a line), and those of a tone.
        """
        words, native, rows = self._words(samples)
        return _tables.sums(native.sums(words, self._hop(hop, rows), *self._terms), self._rate_hz)


class BurstProcessor(_Front):
    """Finds bursts in a stream and measures each: particles in a laser-Doppler velocimeter, pulses.

    n: samples of the record around a burst; 3 to 20 times the standard deviation of its Gaussian envelope is right.
    scene: None, or a Doppler, whose answers have velocities.
    ratio: energy of an eighth of a record over that of the noise at which a burst begins; chosen by the noise's scatter where it is None.
    hold_off: samples after a record in which no burst begins.
    least: the least energy per sample of a burst, squared codes, however quiet the noise is.
    The rest is as for Pipeline.
    """

    def __init__(
        self, n=1024, rate_hz=None, codes=12, iq=False, band_hz=None, scene=None, *, ratio=None, hold_off=0, least=0, false_alarm=None,
        arithmetic="float",
    ):
        if _kind(scene) == "chirp":
            raise ValueError("bursts have no Chirp: scene is a Doppler or None")
        super().__init__(n, rate_hz, codes, iq, band_hz, scene, false_alarm, "i32", arithmetic)
        ratio = maybe(number, "ratio", ratio, "give more than 1, at most 1e6", lambda x: 1 < x <= 1e6)
        self._trigger = (ratio, whole("hold_off", hold_off, 0, (1 << 32) - 1), whole("least", least, 0, (1 << 32) - 1))

    def bursts(self, samples, *, missing=()):
        """Every burst of a stream from its start, and what was counted.

        samples: one long array. missing: as for Pipeline.blocks; a record with a missing sample is lost, and what is left of its burst may be
        found as a shorter one.

        Returns (bursts, counts). Columns of bursts: time_s (the middle of the envelope), transit_s (between the points at which the
        power is down by exp(-2): 2 sqrt(2) standard deviations of the envelope), validation ("valid", or what is known against it),
        and those of a tone, whose amplitude and signal-to-noise ratio are those at the top; with a Doppler those of a velocity. A valid
        burst's tone is "good". The counts are a dict: samples; bursts that were cut out; lost, that ended while another was cut out; long,
        signals longer than a burst can be; dead, samples in which no burst could begin.
        """
        words, native, rows = self._words(samples)
        if rows:
            raise ValueError("bursts are found in a stream: give one long array")
        table, counts = native.bursts(words, *self._trigger, _numbers(missing))
        counts = dict(zip(("samples", "bursts", "lost", "long", "dead"), counts))
        return _tables.bursts(table, self._rate_hz, self._scene_kind), counts


def read_recording(path, *, rate_hz=None, codes=16, iq=False, scale=None, channel=None, decimal_comma=False, format=None):
    """The samples of a recording as int16 codes, (samples,) or (samples, 2) for I/Q, and its rate in Hz.

    What `picket analyze` reads: wav, FLAC, headerless numbers, SigMF, csv, npy, npz, mat. The options are that command's: `channel` is a
    number from 1 on, or two for I and Q; `scale` is a factor to the usual codes of the format, chosen by the data where it is not
    given. The rate is None if the file does not state it.
    """
    samples, rate, missing = _recording(path, rate_hz, codes, iq, scale, channel, decimal_comma, format)
    if missing:
        warnings.warn(f"{len(missing)} samples have no number: each has the value of the one before it", stacklevel=2)
    return samples, rate


def _recording(path, rate_hz, codes, iq, scale, channel, decimal_comma, format):
    """The samples of a recording, its rate, and the numbers of those that are missing."""
    low, high = _rails_of(codes)
    if channel is not None:
        def from_one(name, value):
            return whole(name, value, 1, 1 << 16)

        channel = (from_one("channel", channel), None) if np.isscalar(channel) else pair("channel", channel, from_one)
    scale, rate_hz = maybe(number, "scale", scale), maybe(positive, "rate_hz", rate_hz)
    words, rate, pairs, missing = _picket.recording(
        os.fspath(path), low, high, format, rate_hz, bool(iq), scale, channel, bool(decimal_comma)
    )
    return (words.reshape(-1, 2) if pairs else words), rate, missing


def _rails_of(codes):
    front = object.__new__(_Front)
    front._codes = codes
    return front._rails(False)


def analyze(path, n=1024, hop=None, *, rate_hz=None, codes=16, iq=False, scale=None, channel=None, decimal_comma=False, format=None, **options):
    """The strongest tone of every block of a recording: the answers of `picket analyze PATH --arith target`.

    n, hop: as for Pipeline; `options` are others of Pipeline, as band_hz or scene. The rest is as for read_recording.
    """
    samples, rate, missing = _recording(path, rate_hz, codes, iq, scale, channel, decimal_comma, format)
    if rate is None:
        raise ValueError(f"{os.fspath(path)} has no sample rate: give rate_hz, samples per second")
    pipeline = Pipeline(n=n, rate_hz=rate, codes=_rails_of(codes), iq=samples.ndim == 2, **options)
    return pipeline.blocks(samples, hop, missing=missing)


def explain(block, **options):
    """Every test behind the verdict on one block; its length is n, and `options` are Pipeline's. See Pipeline.explain."""
    array = np.asarray(block)
    return Pipeline(**{"n": array.shape[0] if array.ndim else 0, **options}).explain(array)


def read_telemetry(source):
    """The measurements in a recording of `picket watch --record`, or in other bytes of a board: a path, or bytes.

    Columns: sequence (the block's number), clock (samples), gap, segment, clipped, lost, faults, those of a tone, range_m,
    sigma_range_m, velocity_mps and the others of a target. Frequencies are 0 if the board did not report its rate. Damaged frames
    are left out, as on a port; bytes in which there is no measurement at all are a ValueError.
    """
    if isinstance(source, (bytes, bytearray, memoryview)):
        data = bytes(source)
    else:
        with open(os.fspath(source), "rb") as file:
            data = file.read()
    rows, bad = _picket.telemetry(data)
    if len(rows) == 0:
        what = f"{bad} damaged frames and " if bad else ""
        raise ValueError(f"{what}no measurement: was it written by picket watch --record?")
    return _tables.telemetry(rows)


def simulate(scene, targets=None, *, n=1024, rate_hz=1e6, blocks=30, noise=0.0, iq=False, codes=12, seed=None, period_s=0.0):
    """Samples of a radar, a lidar or a velocimeter from its physics, with the truth.

    scene: a Doppler or a Chirp; or a whole scene as a dict or as JSON text (docs/scenes.md), see below.
    targets: tuples (range_m, velocity_mps, amplitude in codes); a positive velocity approaches.
    noise: standard deviation of each converter's noise, codes.
    period_s: from one chirp to the next; without a pause where it is less.

    Returns (samples, truth). The samples are int16 of the shape (blocks, n), or (blocks, n, 2) for I/Q. The truth has a row for each
    block and target: block, target, beat_hz (as an ideal I/Q receiver shows it), range_m (at the middle of the block's chirp),
    velocity_mps. The same seed (0 unless it is given) gives the same samples on every machine.

    A whole scene has its own rate, targets, noise and converter: give n and seed at most. Returns all records of n samples that fit into
    it, or those of its waveform's segments where that has a guard_s. The truth has a row for each block and source, and for each particle: block, source,
    time_s, frequency_hz, amplitude, range_m and velocity_mps (NaN where there is none).
    """
    if isinstance(scene, (dict, str)):
        if targets is not None:
            raise ValueError("a whole scene has its own sources: leave targets out")
        return _whole(scene, n, seed)
    seed = 0 if seed is None else whole("seed", seed, 0, (1 << 64) - 1)
    if scene is None or _kind(scene) == "tone":
        raise wrong("scene", scene, "give a Doppler, a Chirp, or a whole scene as a dict")
    n, blocks = whole("n", n, 1, 1 << 32), whole("blocks", blocks, 1, 1 << 32)
    rate_hz, period_s = positive("rate_hz", rate_hz), number("period_s", period_s)
    noise = not_negative("noise", noise)
    try:
        told = [tuple(map(float, target)) for target in targets]
    except (TypeError, ValueError):
        told = []
    if not told or any(len(target) != 3 for target in told):
        raise wrong("targets", targets, "give tuples (range_m, velocity_mps, amplitude)")
    low, high = _rails_of(codes)
    words, rows = _picket.simulate(
        scene._terms(), n, rate_hz, blocks, told, noise, bool(iq), low, high, seed, period_s
    )
    truth = np.empty(len(rows), [("block", "i8"), ("target", "i8"), ("beat_hz", "f8"), ("range_m", "f8"), ("velocity_mps", "f8")])
    truth["block"], truth["target"], truth["beat_hz"], truth["range_m"] = rows.T
    truth["velocity_mps"] = np.array([velocity for _, velocity, _ in told])[truth["target"]]
    return words.reshape((blocks, n, 2) if iq else (blocks, n)), truth


def _whole(scene, n, seed):
    """The records of a scene that is a dict or JSON, and their truth."""
    text = scene if isinstance(scene, str) else json.dumps(scene)
    n, seed = whole("n", n, 1, 1 << 32), maybe(whole, "seed", seed, 0, (1 << 64) - 1)
    words, iq, n, rows = _picket.whole(text, n, seed)
    names = ("time_s", "frequency_hz", "amplitude", "range_m", "velocity_mps")
    truth = np.empty(len(rows), [("block", "i8"), ("source", "i8"), *((name, "f8") for name in names)])
    for column, name in enumerate(truth.dtype.names):
        truth[name] = rows[:, column]
    return words.reshape((-1, n, 2) if iq else (-1, n)), truth


# They are made of what stands above.
from ._frames import Calibration, Displacement, Frame, PhaseRanging, Sequence, Uncertainty  # noqa: E402
