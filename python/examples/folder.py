"""Measures every recording of a folder by the workers of a Dask cluster: `python folder.py recordings 1e6 [scheduler:8786]`.

Without a scheduler the workers are processes of this machine. A worker that dies costs its files' time alone: Dask hands them to another.
"""

import sys
from pathlib import Path

import numpy as np
import picket_dsp
from dask.distributed import Client, LocalCluster


def measured(path: str | Path, rate_hz: float, n: int = 1024) -> tuple[str, picket_dsp.Answers]:
    """The blocks of a .npy file, one row each, with the file's name."""
    samples = np.load(path, mmap_mode="r")
    answers = picket_dsp.Pipeline(n=n, rate_hz=rate_hz, codes=16).blocks(samples, threads=1)
    return Path(path).name, answers


def folder(client: Client, place: str | Path, rate_hz: float) -> dict[str, picket_dsp.Answers]:
    """The answers of all files by their names."""
    paths = sorted(str(path) for path in Path(place).glob("*.npy"))
    return dict(client.gather(client.map(measured, paths, rate_hz=rate_hz)))


if __name__ == "__main__":
    place, rate_hz, *scheduler = sys.argv[1:]
    with Client(*scheduler or [LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None)]) as client:
        for name, answers in folder(client, place, float(rate_hz)).items():
            print(name, len(answers), "blocks,", np.count_nonzero(answers["usable"]), "usable")
