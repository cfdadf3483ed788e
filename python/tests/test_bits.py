"""The answers are those of `picket analyze --arith target`, to the bit: PICKET_BITS is a folder with records and that command's answers."""

import json
import os
import pathlib

import numpy as np
import pytest

import picket_dsp

FOLDER = os.environ.get("PICKET_BITS")


@pytest.mark.skipif(FOLDER is None, reason="PICKET_BITS names no folder: cargo test --test python writes one")
def test_every_block_is_the_same():
    folder = pathlib.Path(FOLDER)
    cases = json.loads((folder / "cases.json").read_text())
    assert len(cases) == 28
    numbers = {name: number for number, name, *_ in picket_dsp._tables.VERDICTS}
    for case in cases:
        samples = np.fromfile(folder / f"{case['name']}.i16", "<i2")
        expected = np.fromfile(folder / f"{case['name']}.{case['arithmetic']}", "<f8").reshape(-1, 4)
        iq = case["iq"]
        pipeline = picket_dsp.Pipeline(n=case["n"], rate_hz=48e3, codes=12, iq=iq, arithmetic=case["arithmetic"])
        answers = pipeline.blocks(samples.reshape(-1, 2) if iq else samples)
        assert len(answers) == len(expected) >= 1000, case
        np.testing.assert_array_equal(answers["frequency_hz"], expected[:, 0], str(case))
        np.testing.assert_array_equal(answers["sigma_hz"], expected[:, 1], str(case))
        np.testing.assert_array_equal([numbers[name] for name in answers["verdict"]], expected[:, 2], str(case))
        beside = np.array([len(reason.split(", ")) - 1 for reason in answers["reason"]])
        np.testing.assert_array_equal(beside, expected[:, 3], str(case))


@pytest.mark.skipif(FOLDER is None, reason="PICKET_BITS names no folder: cargo test --test python writes one")
def test_every_frame_is_the_same():
    folder = pathlib.Path(FOLDER)
    expected = json.loads((folder / "chirps.json").read_text())
    scene = picket_dsp.Chirp(
        carrier_hz=77e9, bandwidth_hz=306e6, duration_s=102e-6, guard_s=2e-6, shape="sawtooth", velocity_mps=(-8, 8)
    )
    frame = picket_dsp.Frame(
        n=256, rate_hz=2.56e6, codes=16, iq=True, scene=scene, chirps=64, period_s=120e-6, calibration=picket_dsp.Calibration(),
        uncertainty=picket_dsp.Uncertainty(clock_ppm=20, carrier_ppm=1, slope_ppm=100, range_offset_m=1e-3, phase_rad=0.1),
    )
    found = frame.targets(np.load(folder / "chirps.npy"))
    assert len(found) == len(expected) >= 9
    for row, of in zip(found, expected):
        for part, before in (("target", ""), ("budget", "budget_"), ("phase", "phase_"), ("phase_budget", "phase_budget_")):
            for name, value in of[part].items():
                if name in ("candidates", "also") or (name == "ambiguity" and value == "none"):
                    continue
                # What JSON has no number for is not there.
                assert row[before + name] == value, (part, name)
            for place, candidate in enumerate(of[part].get("candidates", ()), 1):
                pairs = {"range_m": f"range_{place}_m", "velocity_mps": f"velocity_{place}_mps", "odds": f"odds_{place}"}
                for name, value in candidate.items():
                    assert row[before + pairs[name]] == value, (part, name, place)
