"""Rows of numbers from the native half as structured arrays."""

import numpy as np

from . import _picket
from ._answers import table

VERDICTS = _picket.verdicts()
_MOST = max(number for number, *_ in VERDICTS) + 1
_NAMES = np.zeros(_MOST, "U11")
_USABLE = np.zeros(_MOST, "?")
for _number, _name, _level, *_ in VERDICTS:
    _NAMES[_number] = _name
    _USABLE[_number] = _level <= 1
# Every reason that may apply in addition to a verdict, the most severe first; the set has seven bits.
_ALSO = np.array([", ".join(_picket.verdicts_in(bits)) for bits in range(128)])


def _list(name):
    """The names of the numbers from 0 on, "" in place of none."""
    return np.array(["" if known == "none" else known for known in _picket.names(name)])


_AMBIGUITY, _SEGMENT, _VALIDATION, _STATE = map(_list, ("ambiguity", "segment", "validation", "state"))
_CANDIDATES = [(f"range_{i}_m", f"velocity_{i}_mps", f"odds_{i}") for i in range(1, 5)]
_REASON = f"U{_NAMES.itemsize // 4 + 2 + _ALSO.itemsize // 4}"

#: The numbers of a tone, as the native half gives them.
_NUMBERS = _picket.columns()
#: The columns that are made of a tone's verdict and of its further reasons.
_WORDS = {"verdict": [("verdict", "U11"), ("usable", "?"), ("reason", _REASON)], "also": []}
TONE = [column for name in _NUMBERS for column in _WORDS.get(name, [(name, "f8")])]
PHASE = [("phase", "f8"), ("sigma_phase", "f8")]
VELOCITY = [("velocity_mps", "f8"), ("sigma_velocity_mps", "f8"), ("target_verdict", "U11"), ("target_usable", "?")]
RANGE = [
    ("range_m", "f8"),
    ("sigma_range_m", "f8"),
    ("ambiguity", _AMBIGUITY.dtype),
    *((name, "f8") for names in _CANDIDATES for name in names),
]


def _parts(rows, head):
    """The first columns of rows, those of a tone, and the others."""
    return rows[:, :head], rows[:, head:head + len(_NUMBERS)], rows[:, head + len(_NUMBERS):]


def _put_tone(out, rows):
    """Fills the columns of TONE."""
    numbers = dict(zip(_NUMBERS, rows.T))
    for name in _NUMBERS:
        if name not in _WORDS:
            out[name] = numbers[name]
    verdict, also = numbers["verdict"].astype(np.intp), numbers["also"].astype(np.intp)
    out["verdict"] = _NAMES[verdict]
    out["usable"] = _USABLE[verdict]
    some = np.flatnonzero(also)
    out["reason"] = _NAMES[verdict]
    if some.size:
        both = np.char.add(np.char.add(_NAMES[verdict[some]], ", "), _ALSO[also[some]])
        out["reason"][some] = both


def _put_target(out, rows):
    """Fills the columns of VELOCITY, and of RANGE where they are."""
    known = np.isfinite(rows[:, 0])
    verdict = np.where(known, rows[:, 0], 0).astype(np.intp)
    out["velocity_mps"], out["sigma_velocity_mps"] = rows[:, 3], rows[:, 5]
    out["target_verdict"] = np.where(known, _NAMES[verdict], "")
    out["target_usable"] = known & _USABLE[verdict]
    if "range_m" in out.dtype.names:
        out["range_m"], out["sigma_range_m"] = rows[:, 2], rows[:, 4]
        for column, name in enumerate(name for names in _CANDIDATES for name in names):
            out[name] = rows[:, 6 + column]
        out["ambiguity"] = _AMBIGUITY[np.where(known, rows[:, 1], 0).astype(np.intp)]


def _scene_columns(kind):
    return {"tone": [], "doppler": VELOCITY, "chirp": RANGE + VELOCITY}[kind]


def blocks(rows, n, rate_hz, kind):
    """The strongest tone of every block."""
    head = [("block", "i8"), ("time_s", "f8"), ("gap", "?"), ("clipped", "i8")]
    segment = [("segment", "U4")] if kind == "chirp" else []
    out = table(len(rows), head + segment + TONE + PHASE + _scene_columns(kind))
    out["block"] = np.arange(len(rows))
    out["time_s"] = (rows[:, 0] + n / 2) / rate_hz
    out["gap"], out["clipped"] = rows[:, 1] != 0, rows[:, 3]
    if segment:
        out["segment"] = _SEGMENT[rows[:, 2].astype(np.intp)]
    _, tone, rest = _parts(rows, 4)
    _put_tone(out, tone)
    out["phase"], out["sigma_phase"] = rest[:, 0], rest[:, 1]
    if kind != "tone":
        _put_target(out, rest[:, 2:])
    return out


def harmonics(rows, n, rate_hz):
    """The fundamental of every block."""
    out = table(len(rows), [("block", "i8"), ("time_s", "f8")] + TONE + [("orders", "u4")])
    out["block"] = np.arange(len(rows))
    out["time_s"], out["orders"] = (rows[:, 0] + n / 2) / rate_hz, rows[:, 1]
    _put_tone(out, _parts(rows, 2)[1])
    return out


def lines(rows):
    """All tones of one block, the strongest first."""
    out = table(len(rows), TONE + PHASE)
    _, tone, phase = _parts(rows, 0)
    _put_tone(out, tone)
    out["phase"], out["sigma_phase"] = phase.T
    return out


def tracks(rows, n, rate_hz):
    """Every track after every block."""
    head = [("time_s", "f8"), ("track", "i8"), ("state", "U9"), ("age", "i8"), ("misses", "i8"), ("rate_hz_per_block", "f8")]
    out = table(len(rows), head + TONE)
    out["time_s"] = (rows[:, 0] + n / 2) / rate_hz
    out["track"], out["age"], out["misses"], out["rate_hz_per_block"] = rows[:, 1], rows[:, 3], rows[:, 4], rows[:, 5]
    out["state"] = _STATE[rows[:, 2].astype(np.intp)]
    _put_tone(out, rows[:, 6:])
    return out


def targets(rows, n, rate_hz, kind):
    """What the held tracks amount to."""
    out = table(len(rows), [("time_s", "f8"), ("track", "i8")] + _scene_columns(kind))
    out["time_s"] = (rows[:, 0] + n / 2) / rate_hz
    out["track"] = rows[:, 1]
    if kind != "tone":
        _put_target(out, rows[:, 2:])
    return out


def sums(rows, rate_hz):
    """Sums of many blocks."""
    out = table(len(rows), [("time_s", "f8"), ("blocks", "i8"), ("ln_chance", "f8")] + TONE)
    out["time_s"], out["blocks"], out["ln_chance"] = rows[:, 0] / rate_hz, rows[:, 1], rows[:, 2]
    _put_tone(out, rows[:, 3:])
    return out


def bursts(rows, rate_hz, kind):
    """Bursts of a stream."""
    head = [("time_s", "f8"), ("transit_s", "f8"), ("validation", _VALIDATION.dtype)]
    out = table(len(rows), head + TONE + _scene_columns(kind))
    out["time_s"], out["transit_s"] = rows[:, 0] / rate_hz, np.sqrt(8) * rows[:, 1] / rate_hz
    out["validation"] = _VALIDATION[rows[:, 2].astype(np.intp)]
    _, tone, target = _parts(rows, 3)
    _put_tone(out, tone)
    if kind != "tone":
        _put_target(out, target)
    return out


def telemetry(rows):
    """What a board has sent."""
    head = [("sequence", "i8"), ("clock", "i8"), ("gap", "?"), ("segment", "U4"), ("clipped", "i8"), ("lost", "i8"), ("faults", "i8")]
    out = table(len(rows), head + TONE + RANGE + VELOCITY)
    out["sequence"], out["lost"], out["faults"], out["clock"] = rows[:, :4].T
    out["gap"], out["segment"], out["clipped"] = rows[:, 4] != 0, _SEGMENT[rows[:, 5].astype(np.intp)], rows[:, 6]
    _, tone, rest = _parts(rows, 7)
    _put_tone(out, tone)
    _put_target(out, rest[:, 2:])
    return out


#: The columns of views that are not numbers, by the ends of their names.
_VIEWED = {"verdict": "U11", "ambiguity": _AMBIGUITY.dtype, "sure": "?", "start": "i8", "block": "i8", "frame": "i8", "receiver": "i8"}


def _viewed(name):
    """The columns that are made of a view's column, with their types."""
    if name == "verdict" or name.endswith("phase_verdict"):
        return [(name, "U11"), (name.replace("verdict", "usable"), "?")]
    if name == "also":
        return [("reason", _REASON)]
    ends = [kind for end, kind in _VIEWED.items() if name == end or name.endswith("_" + end)]
    return [(name, ends[0] if ends else "f8")]


def view(rows, names):
    """Rows whose columns are those of the library's one description of an answer."""
    out = table(len(rows), [column for name in names for column in _viewed(name)])
    numbers = dict(zip(names, rows.T))
    for name in names:
        column = numbers[name]
        if name == "also":
            verdict, also = numbers["tone_verdict"].astype(np.intp), column.astype(np.intp)
            out["reason"] = np.where(also > 0, np.char.add(np.char.add(_NAMES[verdict], ", "), _ALSO[also]), _NAMES[verdict])
        elif name.endswith("verdict"):
            out[name] = _NAMES[column.astype(np.intp)]
            if (usable := name.replace("verdict", "usable")) in out.dtype.names:
                out[usable] = _USABLE[column.astype(np.intp)]
        elif name == "ambiguity":
            out[name] = _AMBIGUITY[column.astype(np.intp)]
        else:
            out[name] = column
    return out


def frames(rows, names, frames):
    """Targets of frames, of one receiver after the other."""
    names = [names[0], "receiver", *names[1:]]
    number = rows[:, :1]
    return view(np.concatenate([number % frames, number // frames, rows[:, 1:]], axis=1), names)


def tests(rows):
    """Every test behind a verdict."""
    out = table(len(rows), [("fit", "U16"), ("test", "U24"), ("value", "f8"), ("limit", "f8"), ("outcome", "U24")])
    for place, row in zip(out, rows):
        for name, value in zip(out.dtype.names, row):
            place[name] = value
    return out
