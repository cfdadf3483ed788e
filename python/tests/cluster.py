"""A folder of recordings by a Dask cluster: the same rows as by one process, also if a worker dies on the way. Run by host-tests."""

import os
import signal
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent.parent / "examples"))
from folder import folder, measured  # noqa: E402

RATE_HZ = 1e6


def recording(number):
    """A tone in noise, another in each file."""
    random = np.random.default_rng(number)
    n = np.arange(400_000)
    tone = 9000 * np.sin(2 * np.pi * (0.01 + 0.013 * number) * n)
    return np.round(tone + random.normal(0, 300, n.size)).astype(np.int16)


def same(answers, expected):
    """Equal to the bit, NaN included."""
    return answers.dtype == expected.dtype and answers.tobytes() == expected.tobytes()


def main():
    from dask.distributed import Client, LocalCluster

    with tempfile.TemporaryDirectory() as place:
        for number in range(24):
            np.save(Path(place) / f"{number:02}.npy", recording(number))
        alone = dict(measured(path, RATE_HZ) for path in sorted(Path(place).glob("*.npy")))
        cluster = LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None)
        with Client(cluster) as client:
            together = folder(client, place, RATE_HZ)
            assert all(same(together[name], answers) for name, answers in alone.items()), "a row differs"
            client.run(lambda: None)
            pids = list(client.run(os.getpid).values())
            futures = client.map(measured, [str(path) for path in sorted(Path(place).glob("*.npy"))], rate_hz=RATE_HZ, pure=False)
            time.sleep(0.2)
            os.kill(pids[0], signal.SIGKILL)
            after = dict(client.gather(futures))
            assert len(after) == 24 and all(same(after[name], answers) for name, answers in alone.items()), "lost"
            again = set(client.run(os.getpid).values())
            assert pids[0] not in again, "the worker did not die"
        print(f"24 files, {sum(map(len, alone.values()))} blocks: the same rows by one process, by two workers, and with one of them killed")


if __name__ == "__main__":
    main()
