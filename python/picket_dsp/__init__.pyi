from collections.abc import Iterable
from dataclasses import KW_ONLY, dataclass
from os import PathLike
from types import EllipsisType
from typing import Any, Literal, TypeAlias, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pandas import DataFrame

__all__ = [
    "Accumulator", "Answers", "BurstProcessor", "Calibration", "Chirp", "Displacement", "Doppler", "Frame", "METHODS", "PhaseRanging",
    "Pipeline", "Sequence", "Tracker", "Uncertainty", "VERDICTS", "analyze", "explain", "read_recording", "read_telemetry", "simulate",
    "__version__",
]

__version__: str
VERDICTS: dict[str, str]
METHODS: dict[str, str]
_Codes: TypeAlias = int | tuple[int, int]
_Several: TypeAlias = slice | EllipsisType | list[int] | list[bool] | list[str] | NDArray[np.bool_] | NDArray[np.integer[Any]]

class Answers(np.ndarray[tuple[Any, ...], np.dtype[np.void]]):
    @overload  # type: ignore[override]
    def __getitem__(self, key: str) -> NDArray[Any]: ...
    @overload
    def __getitem__(self, key: int | np.integer[Any]) -> np.void: ...
    @overload
    def __getitem__(self, key: _Several) -> Answers: ...  # pyright: ignore[reportIncompatibleMethodOverride]
    def to_pandas(self) -> DataFrame: ...

@dataclass(frozen=True)
class Doppler:
    wavelength_m: float | None = ...
    angle_rad: float = ...
    mixing: Literal["rx-conj-tx", "tx-conj-rx"] = ...
    carrier_hz: float | None = ...
    def __post_init__(self) -> None: ...

@dataclass(frozen=True)
class Chirp:
    shape: Literal["trapezoid", "triangle", "sawtooth"] = ...
    _: KW_ONLY
    bandwidth_hz: float
    duration_s: float
    wavelength_m: float | None = ...
    guard_s: float = ...
    mixing: Literal["rx-conj-tx", "tx-conj-rx"] = ...
    sweep_curvature: float = ...
    carrier_hz: float | None = ...
    range_m: tuple[float, float] | None = ...
    velocity_mps: tuple[float, float] | None = ...
    def __post_init__(self) -> None: ...

class Pipeline:
    def __init__(
        self,
        n: int = ...,
        rate_hz: float | None = ...,
        codes: _Codes = ...,
        iq: bool = ...,
        band_hz: tuple[float, float] | None = ...,
        scene: Doppler | Chirp | None = ...,
        *,
        false_alarm: float | None = ...,
        engine: Literal["i32", "f32"] = ...,
        arithmetic: Literal["float", "fixed"] = ...,
        effort: Literal[0, 1, 2, 3] = ...,
        linewidth_hz: float = ...,
        envelope_hz: float = ...,
        method: str = ...,
    ) -> None: ...
    @property
    def n(self) -> int: ...
    @property
    def rate_hz(self) -> float: ...
    def blocks(self, samples: ArrayLike, hop: int | None = ..., *, phase: bool = ..., threads: int | None = ..., missing: ArrayLike = ...) -> Answers: ...
    def harmonics(self, samples: ArrayLike, order: int = ..., hop: int | None = ...) -> Answers: ...
    def lines(self, block: ArrayLike, most: int = ...) -> Answers: ...
    def explain(self, block: ArrayLike) -> Answers: ...

class Tracker:
    def __init__(
        self,
        n: int = ...,
        rate_hz: float | None = ...,
        codes: _Codes = ...,
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
        linewidth_hz: float = ...,
        envelope_hz: float = ...,
    ) -> None: ...
    @property
    def n(self) -> int: ...
    @property
    def rate_hz(self) -> float: ...
    def follow(self, samples: ArrayLike, hop: int | None = ...) -> tuple[Answers, Answers, Answers]: ...

class Accumulator:
    def __init__(
        self,
        n: int = ...,
        rate_hz: float | None = ...,
        codes: _Codes = ...,
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
    def sums(self, samples: ArrayLike, hop: int | None = ...) -> Answers: ...

class BurstProcessor:
    def __init__(
        self,
        n: int = ...,
        rate_hz: float | None = ...,
        codes: _Codes = ...,
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
    def bursts(self, samples: ArrayLike, *, missing: ArrayLike = ...) -> tuple[Answers, dict[str, int]]: ...

@dataclass(frozen=True)
class Uncertainty:
    clock_ppm: float = ...
    carrier_ppm: float = ...
    slope_ppm: float = ...
    angle_rad: float = ...
    range_offset_m: float = ...
    phase_rad: float = ...
    def budget(self, answers: NDArray[np.void] | np.void, *, angle_rad: float = ..., blocks: int = ...) -> Answers: ...

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
        rate_hz: float | None = ...,
        codes: _Codes = ...,
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
    def targets(self, array: ArrayLike, *, background: ArrayLike | None = ...) -> Answers: ...
    def background(self, array: ArrayLike) -> tuple[NDArray[np.complex64], float]: ...

class PhaseRanging:
    def __init__(
        self,
        n: int = ...,
        rate_hz: float | None = ...,
        codes: _Codes = ...,
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
    def ranges(self, samples: ArrayLike, hop: int | None = ..., *, missing: ArrayLike = ...) -> Answers: ...
    def calibrate(self, samples: ArrayLike, known_m: float, sigma_m: float = ..., hop: int | None = ...) -> Calibration: ...

class Displacement:
    def __init__(
        self,
        n: int = ...,
        rate_hz: float | None = ...,
        codes: _Codes = ...,
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
    def follow(self, samples: ArrayLike, hop: int | None = ..., *, missing: ArrayLike = ...) -> Answers: ...

class Sequence:
    def __init__(
        self,
        n: int = ...,
        rate_hz: float | None = ...,
        codes: _Codes = ...,
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
    def targets(self, samples: ArrayLike) -> Answers: ...

def read_recording(
    path: str | PathLike[str],
    *,
    rate_hz: float | None = ...,
    codes: _Codes = ...,
    iq: bool = ...,
    scale: float | None = ...,
    channel: int | tuple[int, int] | None = ...,
    decimal_comma: bool = ...,
    format: str | None = ...,
) -> tuple[NDArray[np.int16], float | None]: ...
def analyze(
    path: str | PathLike[str],
    n: int = ...,
    hop: int | None = ...,
    *,
    rate_hz: float | None = ...,
    codes: _Codes = ...,
    iq: bool = ...,
    scale: float | None = ...,
    channel: int | tuple[int, int] | None = ...,
    decimal_comma: bool = ...,
    format: str | None = ...,
    **options: Any,
) -> Answers: ...
def explain(block: ArrayLike, **options: Any) -> Answers: ...
def read_telemetry(source: str | PathLike[str] | bytes | bytearray | memoryview) -> Answers: ...
@overload
def simulate(scene: dict[str, Any] | str, targets: None = ..., *, n: int = ..., seed: int | None = ...) -> tuple[NDArray[np.int16], NDArray[np.void]]: ...
@overload
def simulate(
    scene: Doppler | Chirp,
    targets: Iterable[tuple[float, float, float]],
    *,
    n: int = ...,
    rate_hz: float = ...,
    blocks: int = ...,
    noise: float = ...,
    iq: bool = ...,
    codes: _Codes = ...,
    seed: int | None = ...,
    period_s: float = ...,
) -> tuple[NDArray[np.int16], NDArray[np.void]]: ...
