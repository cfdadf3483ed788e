from dataclasses import dataclass
from os import PathLike
from typing import Any, Literal, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

__version__: str
VERDICTS: dict[str, str]
Codes = int | tuple[int, int]
Rows = NDArray[np.void]

@dataclass(frozen=True)
class Doppler:
    wavelength_m: float | None = ...
    angle_rad: float = ...
    mixing: Literal["rx-conj-tx", "tx-conj-rx"] = ...
    carrier_hz: float | None = ...

@dataclass(frozen=True)
class Chirp:
    bandwidth_hz: float
    duration_s: float
    wavelength_m: float | None = ...
    shape: Literal["trapezoid", "triangle", "sawtooth"] = ...
    guard_s: float = ...
    mixing: Literal["rx-conj-tx", "tx-conj-rx"] = ...
    sweep_curvature: float = ...
    carrier_hz: float | None = ...
    range_m: tuple[float, float] | None = ...
    velocity_mps: tuple[float, float] | None = ...

class Pipeline:
    def __init__(
        self,
        n: int = ...,
        rate_hz: float = ...,
        codes: Codes = ...,
        iq: bool = ...,
        band_hz: tuple[float, float] | None = ...,
        scene: Doppler | Chirp | None = ...,
        *,
        false_alarm: float | None = ...,
        engine: Literal["i32", "f32"] = ...,
        arithmetic: Literal["float", "fixed"] = ...,
        effort: Literal[0, 1, 2, 3] = ...,
    ) -> None: ...
    @property
    def n(self) -> int: ...
    @property
    def rate_hz(self) -> float: ...
    def blocks(self, samples: ArrayLike, hop: int | None = ..., *, phase: bool = ..., threads: int | None = ..., missing: ArrayLike = ...) -> Rows: ...
    def lines(self, block: ArrayLike, most: int = ...) -> Rows: ...
    def explain(self, block: ArrayLike) -> Rows: ...

class Tracker:
    def __init__(
        self,
        n: int = ...,
        rate_hz: float = ...,
        codes: Codes = ...,
        iq: bool = ...,
        band_hz: tuple[float, float] | None = ...,
        scene: Doppler | Chirp | None = ...,
        *,
        most: int = ...,
        rate_bins: float = ...,
        refresh: int = ...,
        false_alarm: float | None = ...,
        arithmetic: Literal["float", "fixed"] = ...,
        effort: Literal[0, 1, 2, 3] = ...,
    ) -> None: ...
    @property
    def n(self) -> int: ...
    @property
    def rate_hz(self) -> float: ...
    def follow(self, samples: ArrayLike, hop: int | None = ...) -> tuple[Rows, Rows, Rows]: ...

class Accumulator:
    def __init__(
        self,
        n: int = ...,
        rate_hz: float = ...,
        codes: Codes = ...,
        iq: bool = ...,
        band_hz: tuple[float, float] | None = ...,
        scene: Doppler | Chirp | None = ...,
        *,
        blocks: int = ...,
        segment: Literal["up", "flat", "down"] | None = ...,
        drift_bins: float = ...,
        false_alarm: float | None = ...,
        arithmetic: Literal["float", "fixed"] = ...,
    ) -> None: ...
    @property
    def n(self) -> int: ...
    @property
    def rate_hz(self) -> float: ...
    def sums(self, samples: ArrayLike, hop: int | None = ...) -> Rows: ...

class BurstProcessor:
    def __init__(
        self,
        n: int = ...,
        rate_hz: float = ...,
        codes: Codes = ...,
        iq: bool = ...,
        band_hz: tuple[float, float] | None = ...,
        scene: Doppler | None = ...,
        *,
        ratio: float | None = ...,
        hold_off: int = ...,
        least: int = ...,
        false_alarm: float | None = ...,
        arithmetic: Literal["float", "fixed"] = ...,
    ) -> None: ...
    @property
    def n(self) -> int: ...
    @property
    def rate_hz(self) -> float: ...
    def bursts(self, samples: ArrayLike, *, missing: ArrayLike = ...) -> tuple[Rows, dict[str, int]]: ...

@dataclass(frozen=True)
class Uncertainty:
    clock_ppm: float = ...
    carrier_ppm: float = ...
    slope_ppm: float = ...
    angle_rad: float = ...
    range_offset_m: float = ...
    phase_rad: float = ...
    def budget(self, answers: Rows, *, angle_rad: float = ..., blocks: int = ...) -> Rows: ...

@dataclass(frozen=True)
class Calibration:
    phase_rad: float = ...
    sigma_phase_rad: float = ...
    offset_m: float = ...
    sigma_offset_m: float = ...
    slope_ppm: float = ...
    sigma_slope_ppm: float = ...
    @classmethod
    def load(cls, path: str | PathLike[str]) -> Calibration: ...
    def save(self, path: str | PathLike[str]) -> None: ...

class Frame:
    def __init__(
        self,
        n: int = ...,
        rate_hz: float = ...,
        codes: Codes = ...,
        iq: bool = ...,
        scene: Chirp | None = ...,
        *,
        chirps: int = ...,
        period_s: float | None = ...,
        bins: tuple[int, int] | None = ...,
        false_alarm: float | None = ...,
        uncertainty: Uncertainty | None = ...,
        calibration: Calibration | None = ...,
    ) -> None: ...
    @property
    def n(self) -> int: ...
    @property
    def rate_hz(self) -> float: ...
    @property
    def chirps(self) -> int: ...
    @property
    def alias_mps(self) -> float: ...
    def targets(self, array: ArrayLike, *, background: ArrayLike | None = ...) -> Rows: ...
    def background(self, array: ArrayLike) -> tuple[NDArray[np.complex64], float]: ...

class PhaseRanging:
    def __init__(
        self,
        n: int = ...,
        rate_hz: float = ...,
        codes: Codes = ...,
        iq: bool = ...,
        scene: Chirp | None = ...,
        *,
        calibration: Calibration | None = ...,
        band_hz: tuple[float, float] | None = ...,
    ) -> None: ...
    @property
    def n(self) -> int: ...
    @property
    def rate_hz(self) -> float: ...
    def ranges(self, samples: ArrayLike, hop: int | None = ..., *, missing: ArrayLike = ...) -> Rows: ...
    def calibrate(self, samples: ArrayLike, known_m: float, sigma_m: float = ..., hop: int | None = ...) -> Calibration: ...

class Displacement:
    def __init__(
        self,
        n: int = ...,
        rate_hz: float = ...,
        codes: Codes = ...,
        iq: bool = ...,
        scene: Doppler | Chirp | None = ...,
        *,
        most_turns: float = ...,
        band_hz: tuple[float, float] | None = ...,
    ) -> None: ...
    @property
    def n(self) -> int: ...
    @property
    def rate_hz(self) -> float: ...
    def follow(self, samples: ArrayLike, hop: int | None = ..., *, missing: ArrayLike = ...) -> Rows: ...

class Sequence:
    def __init__(
        self,
        n: int = ...,
        rate_hz: float = ...,
        codes: Codes = ...,
        iq: bool = ...,
        scene: Chirp | None = ...,
        *,
        period: int | None = ...,
        band_hz: tuple[float, float] | None = ...,
    ) -> None: ...
    @property
    def n(self) -> int: ...
    @property
    def rate_hz(self) -> float: ...
    def targets(self, samples: ArrayLike) -> Rows: ...

def read_recording(
    path: str | PathLike[str],
    *,
    rate_hz: float | None = ...,
    codes: Codes = ...,
    iq: bool = ...,
    scale: float | None = ...,
    channel: int | tuple[int, int] | None = ...,
    decimal_comma: bool = ...,
    format: str | None = ...,
) -> tuple[NDArray[np.int16], float]: ...
def analyze(
    path: str | PathLike[str],
    n: int = ...,
    hop: int | None = ...,
    *,
    rate_hz: float | None = ...,
    codes: Codes = ...,
    iq: bool = ...,
    scale: float | None = ...,
    channel: int | tuple[int, int] | None = ...,
    decimal_comma: bool = ...,
    format: str | None = ...,
    **options: Any,
) -> Rows: ...
def explain(block: ArrayLike, **options: Any) -> Rows: ...
def read_telemetry(source: str | PathLike[str] | bytes | bytearray | memoryview) -> Rows: ...
@overload
def simulate(scene: dict[str, Any] | str, *, n: int = ..., seed: int | None = ...) -> tuple[NDArray[np.int16], Rows]: ...
@overload
def simulate(
    scene: Doppler | Chirp,
    targets: list[tuple[float, float, float]],
    *,
    n: int = ...,
    rate_hz: float = ...,
    blocks: int = ...,
    noise: float = ...,
    iq: bool = ...,
    codes: Codes = ...,
    seed: int | None = ...,
    period_s: float = ...,
) -> tuple[NDArray[np.int16], Rows]: ...
