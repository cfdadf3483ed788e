"""What the module promises. The answers themselves are the library's, and tested with it."""

import copy
import doctest
import json
import pathlib
import pickle
import re
import threading
import time

import numpy as np
import pytest

import picket_dsp
from picket_dsp import Chirp, Doppler, Pipeline, Tracker

ROOT = pathlib.Path(__file__).resolve().parents[2]
C = 299_792_458.0
LENGTHS = [64, 128, 256, 512, 1024, 2048, 4096]


def same(rows, others):
    """Whether two tables are the same, to the bit; a NaN is one, too."""
    return rows.dtype == others.dtype and rows.tobytes() == others.tobytes()


def tone(samples=48_000, hz=1000.3, amplitude=900.0, noise=9.0, rate=48e3, seed=1):
    n = np.arange(samples)
    return np.round(amplitude * np.sin(2 * np.pi * hz / rate * n) + np.random.default_rng(seed).normal(0, noise, samples)).astype(np.int16)


def pairs(samples=48_000, hz=-1000.3, amplitude=900.0, noise=9.0, rate=48e3):
    random = np.random.default_rng(2)
    z = amplitude * np.exp(2j * np.pi * hz / rate * np.arange(samples))
    return np.round(z + random.normal(0, noise, samples) + 1j * random.normal(0, noise, samples))


@pytest.mark.parametrize("n", LENGTHS)
@pytest.mark.parametrize("engine", ["i32", "f32"])
def test_every_length_and_engine_measures(n, engine):
    for samples, iq, hz in [(tone(hz=7003.1), False, 7003.1), (pairs(hz=-7003.1), True, -7003.1)]:
        answers = Pipeline(n=n, rate_hz=48e3, codes=12, iq=iq, engine=engine).blocks(samples)
        assert len(answers) == 48_000 // n
        good = answers[answers["verdict"] == "good"]
        # Short records confuse noise with change now and then.
        assert len(good) > 0.85 * len(answers), np.unique(answers["verdict"], return_counts=True)
        errors = (good["frequency_hz"] - hz) / good["sigma_hz"]
        assert np.sqrt(np.mean(errors**2)) < 1.5 and np.abs(errors).max() < 6
        lines = Pipeline(n=n, rate_hz=48e3, codes=12, iq=iq, engine=engine).lines(samples[:n], 2)
        assert abs(lines[0]["frequency_hz"] - hz) < 6 * lines[0]["sigma_hz"]


def test_every_method_measures():
    for samples, iq, hz in [(tone(hz=7003.1), False, 7003.1), (pairs(hz=-7003.1), True, -7003.1)]:
        usual = Pipeline(rate_hz=48e3, codes=12, iq=iq).blocks(samples)
        refused = set()
        for method in picket_dsp.METHODS:
            try:
                answers = Pipeline(rate_hz=48e3, codes=12, iq=iq, method=method).blocks(samples)
            except ValueError:
                refused.add(method)
                continue
            # Either name of least squares is its form for these samples; any other has answers of its own, with its bias in sigma.
            assert same(answers, usual) == method.startswith("least-squares")
            errors = (answers["frequency_hz"] - hz) / answers["sigma_hz"]
            assert np.abs(errors).max() < 6 and answers["sigma_hz"].max() < 48e3 / 1024 / 2, method
        assert refused == (set() if iq else {"autocorrelation", "improved-autocorrelation", "fesa", "fesa-corrected"})


def test_kinds_of_arrays_give_the_same_answers():
    samples = tone()
    answers = Pipeline(rate_hz=48e3, codes=12).blocks(samples)
    for other in [samples.astype(np.float32), samples.astype(float), samples.astype(np.int64), samples.tolist(), samples[: 46 * 1024].reshape(-1, 1024)]:
        assert same(Pipeline(rate_hz=48e3, codes=12).blocks(other), answers)
    assert same(Pipeline(rate_hz=48e3, codes=(-2048, 2047)).blocks(samples), answers)
    # From 0 on, as a microcontroller's converter counts; 16 bits count from the middle.
    above = (samples.astype(int) + 2048).astype(np.uint16)
    shifted = Pipeline(rate_hz=48e3, codes=12).blocks(above)
    assert (shifted["verdict"] == "good").all()
    np.testing.assert_allclose(shifted["frequency_hz"], answers["frequency_hz"], atol=1e-3)
    wide = Pipeline(rate_hz=48e3, codes=16).blocks(samples)
    assert same(Pipeline(rate_hz=48e3, codes=16).blocks((samples.astype(int) + 32768).astype(np.uint16)), wide)
    # A view that is not contiguous.
    twice = np.repeat(samples, 2)
    assert same(Pipeline(rate_hz=48e3, codes=12).blocks(twice[::2]), answers)
    z = pairs()
    both = np.stack([z.real, z.imag], -1).astype(np.int16)
    iq = Pipeline(rate_hz=48e3, codes=12, iq=True)
    expected = iq.blocks(z)
    assert expected["frequency_hz"][0] == pytest.approx(-1000.3, abs=1)
    for other in [z.astype(np.complex64), both, both[: 46 * 1024].reshape(-1, 1024, 2)]:
        assert same(iq.blocks(other), expected)


def test_hop_threads_phase_and_time():
    samples = tone(200_000)
    pipeline = Pipeline(rate_hz=48e3, n=256)
    answers = pipeline.blocks(samples, hop=100, threads=1)
    assert len(answers) == (200_000 - 256) // 100 + 1
    assert same(pipeline.blocks(samples, hop=100, threads=7), answers)
    assert answers["time_s"][3] == pytest.approx((300 + 128) / 48e3)
    gaps = pipeline.blocks(samples, hop=100, missing=[1000, 199_999])
    assert set(gaps["block"][gaps["verdict"] == "gap"]) == {block for block in range(len(gaps)) if 100 * block <= 1000 < 100 * block + 256}
    assert np.isnan(answers["phase"]).all()
    phased = pipeline.blocks(samples, hop=100, phase=True)
    assert (phased["frequency_hz"] == answers["frequency_hz"]).all()
    expected = 2 * np.pi * 1000.3 * phased["time_s"] - np.pi / 2
    turns = np.angle(np.exp(1j * (phased["phase"] - expected))) / phased["sigma_phase"]
    assert 0.8 < np.sqrt(np.mean(turns**2)) < 1.3
    gaps = pipeline.blocks(samples, hop=5000)
    assert len(gaps) == (200_000 - 256) // 5000 + 1


def test_verdicts_are_told():
    quiet = np.random.default_rng(3).normal(0, 9, 1024)
    loud = 3000 * np.sin(0.5 * np.arange(1024))
    for samples, verdict, usable in [
        (np.round(quiet), "weak", False),
        (np.zeros(1024, np.int16), "no-signal", False),
        (np.round(np.clip(0.75 * loud + quiet, -2048, 2047)), "clipped", True),
    ]:
        row = Pipeline(rate_hz=48e3, codes=12).blocks(samples)[0]
        assert (row["verdict"], bool(row["usable"])) == (verdict, usable)
        assert row["reason"].startswith(verdict)
    assert list(picket_dsp.VERDICTS)[0] == "good" and "rails" in picket_dsp.VERDICTS["wrong-codes"]
    two = 900 * np.sin(0.8 * np.arange(1024)) + 500 * np.sin(1.6 * np.arange(1024)) + quiet
    lines = Pipeline(rate_hz=48e3).lines(np.round(two))
    np.testing.assert_allclose(lines["frequency_hz"][:2] / 48e3 * 2 * np.pi, [0.8, 1.6], atol=1e-4)
    assert lines["amplitude"][:2] == pytest.approx([900, 500], rel=0.02)


@pytest.mark.parametrize(
    "options, samples, words",
    [
        ({"n": 1000}, None, "choose 512 or 1024"),
        ({"rate_hz": -1}, None, "sample rate must lie between"),
        ({"rate_hz": float("nan")}, None, "sample rate"),
        ({"band_hz": (9, 3)}, None, "band must lie between"),
        ({"codes": 7}, None, "8 to 16 bits"),
        ({"codes": (0, 100)}, None, "at least 256"),
        ({"codes": (0, 70000)}, None, "16 bits"),
        ({"engine": "i64"}, None, "i32 or f32"),
        ({"method": "fft"}, None, "method='fft': choose rife, z-rife"),
        ({"method": "fesa"}, None, "method='fesa': it is for I/Q samples alone"),
        ({"arithmetic": "f64"}, None, "float or fixed"),
        ({"effort": 4}, None, "0 to 3"),
        ({"false_alarm": 2.0}, None, "false-alarm probability"),
        ({"linewidth_hz": -1.0}, None, "linewidth and envelope"),
        ({"scene": "radar"}, None, "Doppler or a Chirp"),
        ({"scene": Chirp(bandwidth_hz=1e8, duration_s=1e-6, carrier_hz=24e9)}, None, "duration_s=.*ramp must last"),
        ({"n": -4}, None, "n=-4: a block has 64"),
        ({"n": "1024"}, None, "n='1024'"),
        ({"rate_hz": "48k"}, None, "rate_hz='48k'"),
        ({"rate_hz": -1}, None, "rate_hz=-1: "),
        ({"codes": 12.7}, None, "codes=12.7"),
        ({"codes": (1, 2, 3)}, None, r"codes=\(1, 2, 3\): give \(low, high\)"),
        ({"codes": None}, None, "codes=None"),
        ({"band_hz": 5}, None, r"band_hz=5: give \(low, high\)"),
        ({"band_hz": (9, 3)}, None, r"band_hz=\(9, 3\)"),
        ({"iq": "no"}, None, "iq='no'"),
        ({"engine": 32}, None, "engine=32"),
        ({"effort": 7}, None, "effort=7"),
        ({"false_alarm": "x"}, None, "false_alarm='x'"),
        ({"linewidth_hz": None}, None, "linewidth_hz=None"),
        ({"scene": Doppler}, None, "scene=.*give a Doppler"),
        ({}, [], "0 samples are fewer"),
        ({}, np.zeros(100, np.int16), "100 samples are fewer"),
        ({}, np.zeros((4, 100), np.int16), "a row has 100 samples"),
        ({}, np.zeros((2, 2, 1024), np.int16), "one array"),
        ({}, np.full(1024, 0.3), "too small for integers"),
        ({}, np.full(1024, np.nan), "not a number"),
        ({"rate_hz": None}, None, "rate_hz is not given"),
        ({}, np.full(1024, 5000.0), r"a sample is 5000, .*give codes=\(0, 8191\)"),
        ({}, np.full(1024, 4095, np.int16), r"a sample is 4095, .*give codes=\(0, 4095\)"),
        ({}, np.full(1024, -4095, np.int16), r"a sample is -4095, .*give codes=13"),
        ({}, np.full(1024, 1 << 20), "wider than 16 bits"),
        ({}, np.zeros(1024, complex), "iq=True"),
        ({"iq": True}, np.zeros(2048, np.int16), "needs complex samples"),
        ({}, np.array(["a"] * 1024), "integers, floats or complex"),
    ],
)
def test_errors_are_values_with_a_cure(options, samples, words):
    with pytest.raises(ValueError, match=words) as error:
        Pipeline(**{"rate_hz": 48e3} | options).blocks(samples)
    assert "\n" not in str(error.value)


RAMPS = dict(bandwidth_hz=1e8, duration_s=1e-3, carrier_hz=24e9)


@pytest.mark.parametrize(
    "make, options, words",
    [
        (Doppler, {}, "carrier_hz=None: give one of them"),
        (Doppler, {"carrier_hz": 24e9, "wavelength_m": 1e-6}, "give one of them"),
        (Doppler, {"carrier_hz": -1}, "carrier_hz=-1: .*above 0"),
        (Doppler, {"carrier_hz": "24e9"}, "carrier_hz='24e9'"),
        (Doppler, {"carrier_hz": float("nan")}, "carrier_hz=nan"),
        (Doppler, {"wavelength_m": -1}, "wavelength_m=-1"),
        (Doppler, {"wavelength_m": 24.125e9}, "or carrier_hz"),
        (Doppler, {"wavelength_m": 1, "mixing": "iq"}, "mixing='iq': choose rx-conj-tx or tx-conj-rx"),
        (Doppler, {"wavelength_m": 1, "angle_rad": 2}, "angle_rad=2"),
        (Chirp, {**RAMPS, "bandwidth_hz": "sawtooth"}, "bandwidth_hz='sawtooth'"),
        (Chirp, {**RAMPS, "bandwidth_hz": 0}, "bandwidth_hz=0"),
        (Chirp, {**RAMPS, "duration_s": float("inf")}, "duration_s=inf"),
        (Chirp, {**RAMPS, "guard_s": 1}, "guard_s=1: .*less than duration_s"),
        (Chirp, {**RAMPS, "sweep_curvature": 5}, "sweep_curvature=5"),
        (Chirp, {**RAMPS, "shape": "saw"}, "shape='saw': choose trapezoid, triangle or sawtooth"),
        (Chirp, {**RAMPS, "shape": None}, "shape=None"),
        (Chirp, {**RAMPS, "range_m": 5}, r"range_m=5: give \(low, high\)"),
        (Chirp, {**RAMPS, "velocity_mps": (8, -8)}, "velocity_mps=.*low one first"),
        (picket_dsp.Uncertainty, {"clock_ppm": "a"}, "clock_ppm='a'"),
        (picket_dsp.Calibration, {"sigma_phase_rad": -1}, "sigma_phase_rad=-1"),
    ],
)
def test_what_is_written_is_checked_there(make, options, words):
    with pytest.raises(ValueError, match=words) as error:
        make(**options)
    assert "\n" not in str(error.value)


def test_other_errors():
    for call in [
        lambda: Pipeline(rate_hz=48e3).lines(np.zeros(2048, np.int16)),
        lambda: Pipeline(rate_hz=48e3).lines(np.zeros(1024, np.int16), 9),
        lambda: Pipeline(rate_hz=48e3).blocks(np.zeros(4096, np.int16), hop=0),
        lambda: Pipeline(rate_hz=48e3).blocks(np.zeros((4, 1024), np.int16), hop=4),
        lambda: Pipeline(rate_hz=48e3).blocks(np.zeros(4096, np.int16), hop=2.5),
        lambda: Pipeline(rate_hz=48e3).blocks(np.zeros(4096, np.int16), threads=0),
        lambda: Pipeline(rate_hz=48e3).blocks(np.zeros(4096, np.int16), missing=np.zeros(4096, bool)),
        lambda: Tracker(rate_hz=48e3, rate_bins="fast"),
        lambda: picket_dsp.simulate(Doppler(carrier_hz=1e9), (20.0, 3.0, 900.0)),
        lambda: picket_dsp.simulate(Doppler(carrier_hz=1e9), [(20.0, 3.0, 900.0)], seed=-1),
        lambda: Tracker(rate_hz=48e3, most=5),
        lambda: picket_dsp.read_telemetry(b"nothing"),
        lambda: picket_dsp.simulate(None, [(1, 1, 1)]),
        lambda: picket_dsp.simulate(Doppler(carrier_hz=1e9), []),
        lambda: picket_dsp.analyze(__file__),
        # Each of them checks the codes.
        lambda: Tracker(rate_hz=48e3).follow(np.full(4096, 4000, np.int16)),
        lambda: picket_dsp.Accumulator(rate_hz=48e3).sums(np.full(102_400, 4000, np.int16)),
        lambda: picket_dsp.BurstProcessor(rate_hz=48e3).bursts(np.full(4096, 4000, np.int16)),
    ]:
        with pytest.raises(ValueError):
            call()
    with pytest.raises((ValueError, OSError)):
        picket_dsp.analyze("there-is-no-such-file.wav")


def test_a_doppler_radar_of_the_simulator():
    scene = Doppler(carrier_hz=24e9, mixing="rx-conj-tx")
    samples, truth = picket_dsp.simulate(scene, [(20.0, 3.0, 900.0)], n=1024, rate_hz=48e3, blocks=40, noise=30.0, iq=True, seed=4)
    assert samples.shape == (40, 1024, 2) and samples.dtype == np.int16 and len(truth) == 40
    again, _ = picket_dsp.simulate(scene, [(20.0, 3.0, 900.0)], n=1024, rate_hz=48e3, blocks=40, noise=30.0, iq=True, seed=4)
    assert (samples == again).all()
    np.testing.assert_allclose(truth["beat_hz"], 2 * 3.0 * 24e9 / C, rtol=1e-3)
    answers = Pipeline(n=1024, rate_hz=48e3, iq=True, scene=scene).blocks(samples)
    assert answers["usable"].all() and answers["target_usable"].all()
    errors = (answers["velocity_mps"] - 3.0) / answers["sigma_velocity_mps"]
    assert 0.6 < np.sqrt(np.mean(errors**2)) < 1.5
    backwards, _ = picket_dsp.simulate(scene, [(20.0, -3.0, 900.0)], rate_hz=48e3, blocks=4, noise=30.0, iq=True)
    assert (Pipeline(rate_hz=48e3, iq=True, scene=scene).blocks(backwards)["velocity_mps"] < -2.9).all()


@pytest.mark.parametrize("shape, every", [("trapezoid", 3), ("triangle", 2), ("sawtooth", 1)])
def test_a_chirp_radar_of_the_simulator(shape, every):
    scene = Chirp(shape, bandwidth_hz=200e6, duration_s=1.1e-3, guard_s=20e-6, carrier_hz=24e9)
    velocity = 0.0 if shape == "sawtooth" else 5.0
    blocks = 400 * every
    samples, truth = picket_dsp.simulate(scene, [(30.0, velocity, 900.0)], blocks=blocks, noise=30.0, iq=True, seed=5)
    answers = Pipeline(rate_hz=1e6, iq=True, scene=scene).blocks(samples)
    whole = answers[np.isfinite(answers["range_m"])]
    assert len(whole) == 400 and set(whole["block"] % every) == {every - 1}
    errors = (whole["range_m"] - truth["range_m"][every - 1 :: every]) / whole["sigma_range_m"]
    assert 0.8 < np.sqrt(np.mean(errors**2)) < 1.25, errors
    assert (whole["ambiguity"] == ("coupled" if shape == "sawtooth" else "")).all()
    assert (whole["target_verdict"] == "ambiguous").all() == (shape == "sawtooth")
    assert np.isnan(whole["velocity_mps"]).all() == (shape == "sawtooth")
    if velocity:
        errors = (whole["velocity_mps"] - velocity) / whole["sigma_velocity_mps"]
        assert 0.8 < np.sqrt(np.mean(errors**2)) < 1.25
    assert (Pipeline(rate_hz=1e6, iq=True, scene=scene).blocks(samples, threads=1)["range_m"][whole["block"]] == whole["range_m"]).all()
    _, tracks, targets = Tracker(rate_hz=1e6, iq=True, scene=scene, most=2).follow(samples)
    assert (tracks["state"] == "held").mean() > 0.9 and len(targets) > 350
    assert np.abs(targets["range_m"][-1] - truth["range_m"][-1]) < 1


CAR = {
    "rate_hz": 20e3,
    "seconds": 4,
    "waveform": {"carrier_hz": 24.125e9},
    "sources": [{"target": {"range_m": 90, "velocity_mps": [[0, 20], [2, 20], [4, 10]], "amplitude": 400}}],
    "receiver": {"iq": True, "mixing": "rx-conj-tx", "noise": {"rms": 20}},
}


def test_a_whole_scene():
    samples, truth = picket_dsp.simulate(CAR, n=512, seed=3)
    assert samples.shape == (156, 512, 2) and samples.dtype == np.int16 and len(truth) == 156
    again, _ = picket_dsp.simulate(json.dumps({**CAR, "seed": 3}), n=512)
    assert (samples == again).all() and (samples != picket_dsp.simulate(CAR, n=512)[0]).any()
    np.testing.assert_allclose(truth["frequency_hz"], 2 * truth["velocity_mps"] * 24.125e9 / C, atol=3)
    scene = Doppler(carrier_hz=24.125e9, mixing="rx-conj-tx")
    answers = Pipeline(n=512, rate_hz=20e3, iq=True, scene=scene).blocks(samples)
    early = truth["time_s"] < 1.9
    errors = (answers["velocity_mps"] - truth["velocity_mps"])[early] / answers["sigma_velocity_mps"][early]
    assert answers["usable"][early].all() and 0.7 < np.sqrt(np.mean(errors**2)) < 1.3


def test_particles_and_records_of_a_whole_scene():
    flow = {"particles": {"amplitude": 300, "velocity_mps": 0.1, "per_m": 1000}}
    samples, truth = picket_dsp.simulate({"rate_hz": 200e3, "seconds": 1, "sources": [flow]}, n=1000)
    assert samples.shape == (200, 1000) and 60 < len(truth) < 140
    assert (truth["block"] == np.floor(truth["time_s"] * 200)).all() and np.isnan(truth["range_m"]).all()
    np.testing.assert_allclose(truth["frequency_hz"], truth["velocity_mps"] / 4e-6)
    ramps = {"shape": "sawtooth", "bandwidth_hz": 200e6, "ramp_s": 1e-3, "guard_s": 1e-4, "samples": 256}
    target = {"target": {"range_m": 30, "amplitude": 500}}
    samples, truth = picket_dsp.simulate({"rate_hz": 400e3, "seconds": 0.02, "waveform": ramps, "sources": [target]})
    assert samples.shape == (20, 256) and (truth["range_m"] == 30).all()
    np.testing.assert_allclose(truth["frequency_hz"], 2e11 * 60 / C, rtol=1e-6)


@pytest.mark.parametrize(
    "scene, targets, said",
    [
        (CAR, [(1, 1, 1)], "leave targets out"),
        ({**CAR, "echoes": []}, None, "unknown field `echoes`"),
        ({**CAR, "seconds": 0.01}, None, "give more seconds"),
        ("{", None, "EOF"),
    ],
)
def test_what_is_no_whole_scene(scene, targets, said):
    with pytest.raises(ValueError, match=said):
        picket_dsp.simulate(scene, targets)


def test_a_tracker_follows():
    rate, n = 48e3, 1024
    t = np.arange(100 * n) / rate
    samples = np.round(900 * np.sin(2 * np.pi * (3000 * t + 100 * t**2)) + np.random.default_rng(6).normal(0, 30, t.size))
    blocks, tracks, targets = Tracker(n=n, rate_hz=rate, scene=Doppler(carrier_hz=24e9)).follow(samples)
    assert len(blocks) == 100 and len(np.unique(tracks["track"][tracks["state"] == "held"])) == 1
    held = tracks[tracks["state"] == "held"][10:]
    assert np.abs(held["frequency_hz"] - (3000 + 200 * held["time_s"])).max() < 3
    assert held["rate_hz_per_block"].mean() == pytest.approx(200 * n / rate, rel=0.05)
    assert targets["velocity_mps"][-1] == pytest.approx(held["frequency_hz"][-1] * C / 24e9 / 2, rel=1e-6)


def test_an_accumulator_finds_what_no_block_shows():
    random, index = np.random.default_rng(8), np.arange(1024)
    phases = random.uniform(0, 2 * np.pi, 300)
    # -18 dB a sample.
    rows = 200 * random.normal(size=(300, 1024)) + 200 * np.sqrt(2) * 10**-0.9 * np.sin(0.7 * index + phases[:, None])
    rows = np.round(rows).astype(np.int16)
    single = picket_dsp.Pipeline(rate_hz=48e3).blocks(rows)
    assert (single["verdict"] == "weak").mean() > 0.5
    sums = picket_dsp.Accumulator(rate_hz=48e3, blocks=100).sums(rows)
    assert len(sums) == 3 and (sums["verdict"] == "good").all() and (sums["blocks"] == 100).all() and (sums["ln_chance"] < -14).all()
    assert np.abs((sums["frequency_hz"] - 0.7 / 2 / np.pi * 48e3) / sums["sigma_hz"]).max() < 5
    assert sums["time_s"].tolist() == pytest.approx([0, 102400 / 48e3, 204800 / 48e3])
    for options in [{"blocks": 0}, {"drift_bins": np.inf}, {"segment": "up"}, {"false_alarm": 0.0}]:
        with pytest.raises(ValueError):
            picket_dsp.Accumulator(rate_hz=48e3, **options)


@pytest.mark.parametrize("iq", [False, True])
def test_a_burst_processor_finds_particles(iq):
    rate, n, deviation, random = 1e6, 1024, 150.0, np.random.default_rng(9)
    arrivals = 3000.0 * np.arange(1, 101) + random.uniform(-600, 600, 100)
    index = np.arange(306_000)
    z = random.normal(0, 20, index.size) + 1j * random.normal(0, 20, index.size)
    for arrival in arrivals:
        near = slice(int(arrival) - 900, int(arrival) + 900)
        t = index[near] - arrival
        z[near] += 600 * np.exp(-(t**2) / 2 / deviation**2 + 2j * np.pi * 0.1234 * t)
    samples = np.round(z if iq else z.real)
    scene = Doppler(wavelength_m=10e-6, mixing="rx-conj-tx")
    processor = picket_dsp.BurstProcessor(n=n, rate_hz=rate, codes=12, iq=iq, scene=scene)
    bursts, counts = processor.bursts(samples)
    assert counts["samples"] == index.size and counts["lost"] == 0 and 0 < counts["dead"] < index.size
    valid = bursts[bursts["validation"] == "valid"]
    assert len(valid) >= 97 and (valid["verdict"] == "good").all() and valid["usable"].all()
    nearest = np.abs(valid["time_s"][:, None] * rate - arrivals).argmin(1)
    assert len(set(nearest)) == len(valid) and np.abs(valid["time_s"] * rate - arrivals[nearest]).max() < 20
    errors = (valid["frequency_hz"] - 0.1234 * rate) / valid["sigma_hz"]
    assert 0.8 < np.sqrt(np.mean(errors**2)) < 1.25 and np.abs(errors).max() < 5
    assert np.median(valid["transit_s"]) * rate == pytest.approx(np.sqrt(8) * deviation, rel=0.02)
    np.testing.assert_allclose(valid["velocity_mps"], valid["frequency_hz"] * 5e-6, rtol=1e-6)
    # The record around a missing sample is lost, and what is left of its burst is a shorter one. The others stay.
    without, counts = processor.bursts(samples, missing=[int(arrivals[50])])
    assert counts["lost"] == 1
    away = without["time_s"] * rate - arrivals[50]
    rest = without[np.abs(away) < 400]
    assert (away[np.abs(away) < 400] > 0).all() and (rest["transit_s"] * rate < 2 * deviation).all()
    assert (np.abs(rest["frequency_hz"] - 0.1234 * rate) < 5 * rest["sigma_hz"]).all()
    others = without[(np.abs(away) > 400) & (without["validation"] == "valid")]
    assert len(set(np.abs(others["time_s"][:, None] * rate - arrivals).argmin(1)) - {50}) >= 96
    for options in [{"ratio": 1.0}, {"hold_off": -1}, {"scene": Chirp(bandwidth_hz=1e8, duration_s=1, carrier_hz=24e9)}]:
        with pytest.raises(ValueError):
            picket_dsp.BurstProcessor(rate_hz=48e3, **options)
    with pytest.raises(ValueError, match="one long array"):
        processor.bursts(np.zeros((4, n, 2) if iq else (4, n), np.int16))


@pytest.mark.parametrize("engine", ["i32", "f32"])
def test_explain_says_why(engine):
    samples = tone(1024, noise=300.0)
    tests = Pipeline(rate_hz=48e3, engine=engine).explain(samples)
    assert {"floor", "line"} <= set(tests["test"])
    rules = tests[tests["fit"] == "verdict"]
    assert (rules["outcome"] == "does not apply").all()
    clipped = picket_dsp.explain(np.clip(3000 * np.sin(0.5 * np.arange(1024)), -2048, 2047), rate_hz=48e3, codes=12, engine=engine)
    applies = clipped[(clipped["fit"] == "verdict") & (clipped["outcome"] == "applies")]
    assert "clipped" in applies["test"]


def test_a_fundamental_is_found_by_its_harmonics():
    n = np.arange(20 * 1024)
    turns = 2 * np.pi * 441.3 / 48e3 * n
    samples = np.round(sum(level * np.sin(k * turns + k) for k, level in [(2, 500), (3, 700), (5, 200)]) + np.random.default_rng(6).normal(0, 5, n.size))
    pipeline = Pipeline(rate_hz=48e3, codes=12, band_hz=(300, 5000))
    found = pipeline.harmonics(samples, 8)
    assert len(found) == 20 and (found["orders"] == 0b10110).all() and (found["amplitude"] == 0).all()
    assert np.abs((found["frequency_hz"] - 441.3) / found["sigma_hz"]).max() < 5
    silence = pipeline.harmonics(np.zeros(2048), 8)
    assert (silence["verdict"] == "no-signal").all() and (silence["orders"] == 0).all()
    with pytest.raises(ValueError, match="order=40"):
        pipeline.harmonics(samples, 40)


def test_more_effort_resolves_more():
    n = np.arange(50 * 1024)
    bins = 1024 / (2 * np.pi)
    noise = np.random.default_rng(5).normal(0, 10, n.size)
    samples = np.round(900 * np.sin(100.3 / bins * n) + 500 * np.sin(105.1 / bins * n) + noise)
    rows = {effort: Pipeline(rate_hz=1024, effort=effort).blocks(samples) for effort in range(4)}
    resolved = {effort: (found["verdict"] != "unresolved").mean() for effort, found in rows.items()}
    assert resolved[0] < 0.5 and resolved[3] == 1.0 and resolved[0] <= resolved[1] <= resolved[2] <= resolved[3]
    found = rows[3]
    errors = (found["frequency_hz"] - 100.3) / found["sigma_hz"]
    assert np.abs(errors).max() < 5 and 0.7 < np.sqrt((errors**2).mean()) < 1.3
    causes = Pipeline(rate_hz=48e3, effort=3).explain(samples[:1024])
    joint = causes[causes["fit"] == "joint"]
    assert (joint["outcome"] == "joined the fit").any()
    assert list(joint["outcome"][joint["test"] == "line"])[-1] == "steady"
    assert same(Pipeline(rate_hz=48e3, effort=3).blocks(tone(4096)), Pipeline(rate_hz=48e3).blocks(tone(4096)))


def test_a_stated_width_is_in_sigma():
    samples = tone(64 * 1024)
    alone = Pipeline(rate_hz=48e3).blocks(samples)["sigma_hz"]
    block_s = 1024 / 48e3
    for terms, variance in [({"linewidth_hz": 100.0}, 0.191 * 100 / block_s), ({"envelope_hz": 2.0}, (0.6006 * 2.0) ** 2)]:
        wide = Pipeline(rate_hz=48e3, **terms).blocks(samples)["sigma_hz"]
        assert np.allclose(wide**2 - alone**2, variance, rtol=0.01)
    followed = [Tracker(rate_hz=48e3, envelope_hz=hz).follow(samples)[1]["sigma_hz"][20:] for hz in [2.0, 0.0]]
    assert followed[0].min() > followed[1].max()


def test_telemetry_of_a_board():
    rows = picket_dsp.read_telemetry(ROOT / "docs/session.bin")
    assert len(rows) > 2 and (np.diff(rows["sequence"]) > 0).all()
    assert (rows["verdict"] != "").all() and np.isfinite(rows["frequency_hz"]).all()
    assert same(picket_dsp.read_telemetry((ROOT / "docs/session.bin").read_bytes()), rows)


def test_recordings(tmp_path):
    import wave

    samples = tone()
    path = tmp_path / "tone.wav"
    with wave.open(str(path), "wb") as file:
        file.setnchannels(1)
        file.setsampwidth(2)
        file.setframerate(48_000)
        file.writeframes(samples.astype("<i2").tobytes())
    read, rate = picket_dsp.read_recording(path)
    assert rate == 48_000 and (read == samples).all()
    assert same(picket_dsp.analyze(path, n=512, hop=256), Pipeline(rate_hz=48e3, n=512, codes=16).blocks(samples, hop=256))
    np.save(tmp_path / "tone.npy", samples)
    assert same(picket_dsp.analyze(tmp_path / "tone.npy", rate_hz=48e3), picket_dsp.analyze(path))
    assert picket_dsp.read_recording(tmp_path / "tone.npy")[1] is None
    with pytest.raises(ValueError, match="has no sample rate"):
        picket_dsp.analyze(tmp_path / "tone.npy")
    with pytest.raises(ValueError, match="exceed"):
        picket_dsp.analyze(path, codes=8)


def test_other_threads_run_meanwhile():
    samples, turns, done = tone(3_000_000), [0], threading.Event()

    def spin():
        while not done.is_set():
            turns[0] += 1
            time.sleep(0)

    thread = threading.Thread(target=spin)
    thread.start()
    before = turns[0]
    Pipeline(rate_hz=48e3).blocks(samples, threads=1)
    during = turns[0] - before
    done.set()
    thread.join()
    # Held all the while, the lock would let it turn once or twice.
    assert during > 20


def test_pandas_takes_it():
    answers = Pipeline(rate_hz=48e3).blocks(tone())
    try:
        import pandas
    except ImportError:
        with pytest.raises(ImportError, match="pip install pandas"):
            answers.to_pandas()
        return
    for table in [pandas.DataFrame(answers), answers.to_pandas(), answers[answers["usable"]].to_pandas()]:
        assert table["usable"].all() and table["frequency_hz"].mean() == pytest.approx(1000.3, abs=0.1)
        assert tuple(table.columns) == answers.dtype.names


def test_answers_are_printed_as_a_table():
    answers = Pipeline(rate_hz=48e3).blocks(tone())
    header, line = repr(answers[7]).splitlines()
    assert header.split()[:3] == ["block", "time_s", "frequency_hz"] and not {"phase", "gap", "sigma_hz"} & set(header.split())
    value, sigma = re.search(r"(\S+) ± (\S+)", line).groups()
    last = 10.0 ** -len(value.split(".")[1])
    assert abs(float(value) - answers[7]["frequency_hz"]) <= 0.51 * last and abs(float(sigma) - answers[7]["sigma_hz"]) <= 0.51 * last
    assert 1e1 <= round(float(sigma) / last) <= 1e2
    assert line.endswith("good") and str(answers[7]) == repr(answers[7])
    lines = str(answers).splitlines()
    assert len(lines) < 16 and lines[0].split() == header.split() and lines[-2].split()[0] == "45" and "46" in lines[-1]
    # What went wrong is told, and what a user chose is shown.
    gap = str(Pipeline(rate_hz=48e3).blocks(tone(), missing=[9], phase=True)[:2])
    assert "gap" in gap.splitlines()[0] and "phase" in gap.splitlines()[0]
    weak = str(Pipeline(rate_hz=48e3).blocks(np.round(np.random.default_rng(3).normal(0, 9, 1024))))
    assert "usable" in weak and "False" in weak
    assert str(answers[["gap", "usable", "reason", "phase"]][:1]).split()[:4] == ["gap", "usable", "reason", "phase"]
    assert str(answers[:0]).startswith("block")
    assert "31" in str(framed().targets(chirps([{"range_m": 18, "amplitude": 60}])))


def test_the_modules_example_prints_what_it_says():
    failed, tried = doctest.testmod(picket_dsp)
    assert failed == 0 < tried


def test_answers_stay_arrays():
    answers = Pipeline(rate_hz=48e3).blocks(tone())
    tables = [answers[3:5], answers[answers["usable"]], answers[[1, 2]], np.concatenate([answers, answers]), np.sort(answers, order="sigma_hz")]
    for table in [*tables, answers[["block", "sigma_hz"]], pickle.loads(pickle.dumps(answers)), copy.deepcopy(answers)]:
        assert isinstance(table, picket_dsp.Answers) and type(table["sigma_hz"]) is np.ndarray
        assert [type(row) for row in table] == [type(answers[0])] * len(table) and isinstance(table[0], np.void)
    assert same(pickle.loads(pickle.dumps(answers)), answers) and same(np.concatenate([answers[:9], answers[9:]]), answers)
    assert pickle.loads(pickle.dumps(answers[4])).tobytes() == answers[4].tobytes() == np.asarray(answers)[4].tobytes()
    changed = answers.copy()
    changed[4]["amplitude"] = 0
    assert changed["amplitude"][4] == 0
    assert repr(np.stack([answers, answers])).startswith("array(")


def test_types_are_stated():
    package = pathlib.Path(picket_dsp.__file__).parent
    assert (package / "py.typed").exists()
    stubs = (package / "__init__.pyi").read_text()
    assert all(f"{name}" in stubs for name in picket_dsp.__all__)


# A radar at 77 GHz: 300 MHz in a record of 100 us, a chirp each 120 us.
RADAR = dict(bandwidth_hz=306e6, duration_s=102e-6, guard_s=2e-6, carrier_hz=77e9, shape="sawtooth")


def chirps(sources, count=64, snr_db=10.0, iq=True):
    waveform = {
        "shape": "sawtooth", "carrier_hz": 77e9, "bandwidth_hz": 306e6, "ramp_s": 102e-6, "guard_s": 2e-6, "period_s": 120e-6, "samples": 256,
    }
    sources = [{"target": {"phase_turns": 0, **source}} for source in sources]
    scene = {
        "seed": 62, "rate_hz": 2.56e6, "seconds": (count + 1) * 120e-6, "waveform": waveform, "sources": sources,
        "receiver": {"iq": iq, "noise": {"snr_db": snr_db}},
    }
    return picket_dsp.simulate(scene, n=256)[0][:count]


def framed(iq=True, **options):
    options = {"chirps": 64, "period_s": 120e-6, **options}
    return picket_dsp.Frame(n=256, rate_hz=2.56e6, iq=iq, scene=Chirp(**RADAR, velocity_mps=(-8, 8)), **options)


@pytest.mark.parametrize("iq", [True, False])
def test_targets_of_frames(iq):
    sources = [{"range_m": 18, "velocity_mps": 3, "amplitude": 60}, {"range_m": 24, "velocity_mps": -5, "amplitude": 30}]
    records = chirps(sources, snr_db=-8, iq=iq)
    frame = framed(iq)
    found = frame.targets(records)
    # The middle of the frame.
    middle = 31.5 * 120e-6 + 52e-6
    assert len(found) == 2 and (found["verdict"] == "good").all() and found["usable"].all()
    for row, source in zip(found, sources):
        assert abs(row["range_m"] - source["range_m"] + source["velocity_mps"] * middle) < 5 * row["sigma_range_m"]
        assert abs(row["velocity_mps"] - source["velocity_mps"]) < 5 * row["sigma_velocity_mps"]
    assert abs(found["snr_db"] + [8, 14]).max() < 2 and frame.alias_mps == pytest.approx(16.19, abs=0.01)
    # Frames, and receivers.
    three = frame.targets(np.concatenate([records] * 3))
    assert same(frame.targets(np.stack([records] * 3)), three)
    assert three["frame"].tolist() == [0, 0, 1, 1, 2, 2] and (three["receiver"] == 0).all()
    cube = np.stack([np.stack([records, np.zeros_like(records)], axis=1)] * 3)
    both = frame.targets(cube)
    assert same(both, three)
    if iq:
        assert same(frame.targets(records[..., 0] + 1j * records[..., 1]), found)
    still, share = frame.background(records)
    assert still.shape == (127,) and 0 < share < 0.1 and len(frame.targets(records, background=still)) == 2
    loose = picket_dsp.Frame(n=256, rate_hz=2.56e6, iq=iq, scene=Chirp(**RADAR), period_s=120e-6, bins=(1, 100)).targets(records)
    assert set(loose["ambiguity"]) <= {"", "several"} and len(loose) == 2


def test_ranges_by_phase_and_what_they_rest_on():
    chirp = Chirp(**RADAR)
    by_phase = picket_dsp.PhaseRanging(n=256, rate_hz=2.56e6, iq=True, scene=chirp)
    known = by_phase.calibrate(chirps([{"range_m": 1.0, "amplitude": 300, "phase_turns": 0.3}], snr_db=25), 1.0, 1e-6)
    assert abs(known.phase_rad / 2 / np.pi - 0.3) < 5 * known.sigma_phase_rad / 2 / np.pi
    plate = chirps([{"range_m": 2.345678, "amplitude": 300, "phase_turns": 0.3}], snr_db=25)
    budget = picket_dsp.Uncertainty(slope_ppm=100, carrier_ppm=1, range_offset_m=1e-3)
    row = framed(uncertainty=budget, calibration=known).targets(plate)[0]
    assert row["phase_sure"] and abs(row["phase_range_m"] - 2.345678) < 5 * row["phase_uncertainty_range_m"] < 1e-4
    assert row["budget_slope_range_m"] == pytest.approx(2.345678e-4, rel=1e-3)
    ranges = picket_dsp.PhaseRanging(n=256, rate_hz=2.56e6, iq=True, scene=chirp, calibration=known).ranges(plate)
    assert len(ranges) == 64 and abs(ranges["range_1_m"] - 2.345678).min() < 1e-4
    parts = budget.budget(ranges, blocks=4)
    assert parts["slope_range_m"][~ranges["sure"]] == pytest.approx(2.345678e-4, rel=1e-2)
    assert parts["noise_range_m"] == pytest.approx(ranges["sigma_range_m"] / 2, rel=1e-5)
    total = np.sqrt(sum(parts[name].astype(float) ** 2 for name in parts.dtype.names[2:] if name.endswith("range_m")))
    assert parts["uncertainty_range_m"] == pytest.approx(total, rel=1e-5)
    # Kept in a file, and read again.
    place = pathlib.Path("radar.json")
    known.save(place)
    assert picket_dsp.Calibration.load(place) == known
    place.unlink()


def test_ways_and_sequences():
    swing = {"range_m": 6, "amplitude": 300, "vibration": [{"amplitude_m": 20e-6, "frequency_hz": 100}]}
    records = chirps([swing], count=512)
    way = picket_dsp.Displacement(n=256, rate_hz=2.56e6, iq=True, scene=Chirp(**RADAR)).follow(records)
    assert len(way) == 512 and (way["start"] == 0).all() and way["usable"].all()
    time_s = np.arange(512) * 120e-6 + 52e-6
    truth = 20e-6 * (np.sin(2 * np.pi * 100 * time_s) - np.sin(2 * np.pi * 100 * time_s[0]))
    error = (way["displacement_m"] - truth) / way["sigma_displacement_m"]
    assert 0.85 < np.std(error) < 1.15 and abs(np.mean(error)) < 5
    records = chirps([{"range_m": 18, "velocity_mps": 2, "amplitude": 300}], snr_db=20)
    sequence = picket_dsp.Sequence(n=256, rate_hz=2.56e6, iq=True, scene=Chirp(**RADAR, velocity_mps=(-8, 8)), period=307)
    last = sequence.targets(records)[-1]
    # A period of 307 samples is .07 % short of the true one.
    assert last["block"] == 63 and abs(last["velocity_mps"] - 2) < 5 * last["sigma_velocity_mps"] + 2e-3


@pytest.mark.parametrize(
    "act, words",
    [
        (lambda: framed(chirps=12), "8, 16, ... 256"),
        (lambda: framed(period_s=1e-6), "period"),
        (lambda: framed(bins=(5, 500)), "band"),
        (lambda: framed(bins=5), "bins=5"),
        (lambda: framed(chirps=64.5), "chirps=64.5"),
        (lambda: framed(uncertainty=5), "uncertainty=5"),
        (lambda: framed(calibration={}), "calibration={}"),
        (lambda: framed().targets(np.zeros((64, 256, 2), np.int16), background=[1j]), "background"),
        (lambda: framed(iq=False).targets(np.zeros((64, 256), complex)), "iq=True"),
        (lambda: framed().targets(np.zeros((64, 256), np.int16)), "give .chirps, samples"),
        (lambda: picket_dsp.Sequence(n=256, rate_hz=2.56e6, scene=Chirp(**RADAR), period=10), "period=10"),
        (lambda: framed(false_alarm=2.0), "false-alarm"),
        (lambda: framed(uncertainty=picket_dsp.Uncertainty(clock_ppm=-1)), "standard deviation"),
        (lambda: framed().targets(np.zeros((60, 256, 2), np.int16)), "the array has 60 chirps"),
        (lambda: framed().targets(np.zeros(256, np.int16)), "give .chirps, samples"),
        (lambda: picket_dsp.Frame(rate_hz=1e6, scene=Doppler(carrier_hz=24e9)), "sawtooth"),
        (lambda: picket_dsp.Displacement(rate_hz=1e6), "Doppler, or of a Chirp"),
        (lambda: picket_dsp.PhaseRanging(rate_hz=1e6, scene=Doppler(carrier_hz=24e9)), "of a Chirp"),
        (lambda: picket_dsp.Uncertainty(slope_ppm=1).budget(np.zeros(3)), "no range_m"),
        (lambda: picket_dsp.Calibration.load(ROOT / "docs/schema.json"), "no calibration"),
    ],
)
def test_what_frames_refuse(act, words):
    with pytest.raises(ValueError, match=words):
        act()
