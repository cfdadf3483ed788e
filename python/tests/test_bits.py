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
