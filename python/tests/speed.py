"""Blocks a second and the error, beside an FFT with a parabola through the logarithms of three bins of a Hann window, by scipy.

    python speed.py [--json]

One line a length: Picket on one core and on all, scipy block by block and on the whole array at once, and the rms errors.
"""

import json
import sys
import time

import numpy as np
import scipy.fft

import picket_dsp

RATE, CYCLES, NOISE = 48e3, 0.1234567, 30.0


def parabola(rows, window):
    """The frequencies of rows of samples, Hz."""
    n = rows.shape[-1]
    power = np.log(np.abs(scipy.fft.rfft(rows.astype(np.float32) * window, axis=-1)))
    peak = power[:, 2:-2].argmax(1) + 2
    row = np.arange(len(rows))
    a, b, c = power[row, peak - 1], power[row, peak], power[row, peak + 1]
    return (peak + 0.5 * (a - c) / (a - 2 * b + c)) / n * RATE


def best(work):
    """The shortest of three times, s, and the answer."""
    times = []
    for _ in range(3):
        begin = time.perf_counter()
        answer = work()
        times.append(time.perf_counter() - begin)
    return min(times), answer


def row(n, blocks):
    index = np.arange(n * blocks)
    noise = np.random.default_rng(1).normal(0, NOISE, index.size)
    samples = np.round(1500 * np.sin(2 * np.pi * CYCLES * index + 0.3) + noise).clip(-2048, 2047).astype(np.int16)
    pipeline, rows = picket_dsp.Pipeline(n=n, rate_hz=RATE, codes=12), samples.reshape(blocks, n)
    window = np.hanning(n).astype(np.float32)
    one, answers = best(lambda: pipeline.blocks(samples, threads=1))
    every, _ = best(lambda: pipeline.blocks(samples))
    single, _ = best(lambda: [parabola(block[None], window)[0] for block in rows])
    whole, others = best(lambda: parabola(rows, window))
    rms = lambda found: float(np.sqrt(np.mean((found - CYCLES * RATE) ** 2)))
    return {
        "n": n,
        "picket_one_core": blocks / one,
        "picket_all_cores": blocks / every,
        "scipy_block_by_block": blocks / single,
        "scipy_whole_array": blocks / whole,
        "picket_rms_mhz": 1e3 * rms(answers["frequency_hz"]),
        "picket_sigma_mhz": 1e3 * float(answers["sigma_hz"].mean()),
        "scipy_rms_mhz": 1e3 * rms(others),
    }


if __name__ == "__main__":
    rows = [row(n, 2_000_000 // n) for n in (256, 1024, 4096)]
    for found in rows:
        print(json.dumps(found) if "--json" in sys.argv else "  ".join(f"{name} {value:.4g}" for name, value in found.items()))
