"""A table of answers: a structured array that prints as people read it."""

import math

import numpy as np

#: Rows that are printed of each end of a longer table, the widest line, and so many columns are printed whatever they say.
_END, _WIDTH, _FEW = 5, 140, 8


class Answer(np.void):
    """A row of `Answers`: printed as a table of one row, and else as numpy has it."""

    def __repr__(self):
        return "\n".join(_lines(np.asarray(self).reshape(1))[0])

    __str__ = __repr__


class Answers(np.ndarray):
    """A structured array with a row for each answer. Printed, it is a short table: each value with its standard deviation in so many digits
    as that permits, and without columns that say nothing. All columns are in `dtype.names`; a column alone is an ordinary array.
    """

    # np.concatenate and others answer with this class.
    __array_priority__ = 1.0

    def __getitem__(self, key):
        found = super().__getitem__(key)
        if isinstance(found, np.void):
            return super(Answers, self.view(np.dtype((Answer, self.dtype)))).__getitem__(key)
        return found.view(np.ndarray) if isinstance(found, Answers) and not found.dtype.names else found

    def __repr__(self):
        rows = self.view(np.ndarray)
        if self.ndim != 1 or not self.dtype.names:
            return repr(rows)
        whole = len(rows) <= 2 * _END + 1
        lines, columns = _lines(rows if whole else np.concatenate([rows[:_END], rows[-_END:]]))
        if not whole:
            lines.insert(1 + _END, "...")
        return "\n".join([*lines, f"[rows: {len(rows)}; columns: {columns} of {len(self.dtype.names)}]"])

    __str__ = __repr__

    def to_pandas(self):
        """A pandas.DataFrame with all columns."""
        try:
            import pandas
        except ImportError:
            raise ImportError("to_pandas() needs pandas: pip install pandas") from None
        return pandas.DataFrame(self.view(np.ndarray))


def table(rows, columns):
    """Answers to be filled."""
    return np.empty(rows, columns).view(Answers)


def _lines(rows):
    """The header of a table and its lines, and how many columns stand in them, with those of sigma."""
    names = rows.dtype.names
    sigmas = {_measured(name): name for name in names if _measured(name) in names}
    cells, width, columns = [], 0, 0
    for name in names:
        sigma = rows[sigmas[name]] if name in sigmas else [None] * len(rows)
        if name in sigmas.values() or len(names) > _FEW and not _tells(rows, name, name in sigmas):
            continue
        column = [name, *map(_cell, [name] * len(rows), rows[name], sigma)]
        wide = max(map(len, column))
        width += 2 + wide
        if cells and width > _WIDTH:
            break
        cells.append([cell.rjust(wide) for cell in column])
        columns += 1 + (name in sigmas)
    return ["  ".join(line).rstrip() for line in zip(*cells)], columns


def _measured(sigma):
    """The column of which this one is the standard deviation, if it is one."""
    return "frequency_hz" if sigma == "sigma_hz" else sigma.replace("sigma_", "", 1) if "sigma_" in sigma else None


def _tells(rows, name, with_sigma):
    """Whether a column says more than the others do. Candidates are for those who ask."""
    column, names = rows[name], rows.dtype.names
    if any(f"_{digit}" in name for digit in range(1, 5)):
        return False
    if name == names[0] or name.endswith("sure") or not len(rows):
        return True
    if name.endswith("usable"):
        verdict = name.replace("usable", "verdict")
        return not (column | (rows[verdict] == "" if verdict in names else False)).all()
    if name == "reason":
        return not any(other.endswith("verdict") and (rows[other] == column).all() for other in names)
    if column.dtype.kind == "U":
        return (column != "").any()
    return not np.isnan(column).all() if with_sigma else np.nan_to_num(column).any()


def _cell(name, value, sigma):
    """A value as text; two digits of its standard deviation decide its own."""
    if not isinstance(value, float):
        return str(value)
    if math.isnan(value):
        return "-"
    if sigma is None:
        return f"{value:.6g}" if name == "time_s" else f"{value:.4g}"
    if not 0 < sigma < math.inf:
        return f"{value:.6g} ± {sigma:g}"
    digits = min(max(1 - math.floor(math.log10(sigma)), 0), 12)
    return f"{value:.{digits}f} ± {sigma:.{digits}f}"
