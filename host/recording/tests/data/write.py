"""Writes the recordings of this folder by the programs that people use: NumPy, SciPy, libsndfile, h5py, the SigMF library.

    pip install numpy scipy soundfile sigmf h5py
    python write.py

Each has one tone of 987.6 Hz at 8000 samples a second and 1024 samples; pairs of I and Q turn backwards.
"""

import json
import os

import h5py
import numpy as np
import scipy.io
import sigmf
import soundfile
from sigmf import SigMFFile

os.chdir(os.path.dirname(os.path.abspath(__file__)))
rate, tone, n = 8000, 987.6, 1024
t = np.arange(n) / rate
x = 0.7 * np.cos(2 * np.pi * tone * t + 0.3)
z = 0.7 * np.exp(-2j * np.pi * tone * t + 0.3j)
rng = np.random.default_rng(1)
x += 0.002 * rng.standard_normal(n)
z += 0.002 * (rng.standard_normal(n) + 1j * rng.standard_normal(n))
pairs = np.stack([z.real, z.imag], axis=1)

np.save("double.npy", 2.5 + 0.01 * x)
np.save("complex.npy", z.astype(np.complex64))
np.save("big-endian.npy", x.astype(">f4"))
np.save("rows.npy", np.stack([0 * x, x, 0 * x]))
np.save("fortran.npy", np.asfortranarray(np.stack([x, 0 * x, 0 * x], axis=1)))
np.savez("stored.npz", fs=rate, x=x)
np.savez_compressed("compressed.npz", t=t, volts=0.3 * x, name=np.array("probe"))
scipy.io.savemat("real.mat", {"Fs": float(rate), "y": x[:, None]})
scipy.io.savemat("compressed.mat", {"t": t, "ch1": 0.3 * x, "ch2": 0 * x}, do_compression=True)
scipy.io.savemat("complex.mat", {"iq": z, "fs": float(rate)})
with h5py.File("real.h5", "w") as file:
    file.create_dataset("adc/volts", data=x.astype("<f4")).attrs["fs"] = float(rate)
with h5py.File("times.h5", "w") as file:
    file["t"], file["y"] = t, x
with h5py.File("complex.h5", "w") as file:
    chunked = dict(chunks=(256,), compression="gzip", shuffle=True, fletcher32=True)
    file.create_dataset("iq", data=z.astype(np.complex64), **chunked)
    file.attrs["sample_rate"] = rate
with h5py.File("latest.h5", "w", libver="latest") as file:
    file.create_dataset("x", data=np.round(2000 * x).astype("<i2"), chunks=(100,), maxshape=(None,))
with h5py.File("chirps.h5", "w") as file:
    file["radar"] = z.astype(np.complex64).reshape(16, 64)
soundfile.write("double.wav", x, rate, subtype="DOUBLE")
soundfile.write("24-bit.wav", 0.01 * x, rate, subtype="PCM_24")
soundfile.write("rf64.wav", x, rate, format="RF64", subtype="PCM_16")
soundfile.write("extensible.wav", pairs, rate, format="WAVEX", subtype="FLOAT")
soundfile.write("16-bit.flac", x, rate, subtype="PCM_16")
soundfile.write("24-bit.flac", pairs, rate, subtype="PCM_24")
pairs.astype("<f4").tofile("pairs.cf32")
pairs.astype("<f4").tofile("unnamed.raw")
pairs.astype("<f8").tofile("pairs.cf64")
(32767 * pairs).round().astype("<i2").tofile("pairs.cs16")
(127 * pairs).round().astype("i1").tofile("pairs.cs8")
(127.5 + 127 * pairs).round().astype("u1").tofile("pairs.cu8")
x.astype("<f8").tofile("real.f64")

(32767 * pairs).round().astype("<i2").tofile("pairs.sigmf-data")
meta = SigMFFile(
    data_file="pairs.sigmf-data",
    global_info={SigMFFile.DATATYPE_KEY: "ci16_le", SigMFFile.SAMPLE_RATE_KEY: rate, SigMFFile.VERSION_KEY: sigmf.__version__},
)
meta.add_capture(0, metadata={})
meta.tofile("pairs.sigmf-meta")
meta.archive("archive.sigmf", overwrite=True)

# Audacity's "Sample Data Export", all of its header, on a linear scale.
with open("audacity.txt", "w") as file:
    file.write(f"tone.txt   1 channel (mono)\nSample Rate: {rate} Hz. Sample values on linear scale.\n")
    file.write(f"Length processed: {n} samples, {n / rate:.5f} seconds.\n\n")
    file.writelines(f"{v:.5f}\n" for v in x)
# A spreadsheet's "Unicode text", with one cell that has no number.
with open("unicode.txt", "w", encoding="utf-16") as file:
    file.write("Time (ms)\tVoltage (µV)\r\n")
    file.writelines(f"{1e3 * a:.4f}\t{'' if k == 700 else f'{40 * v:.3f}'}\r\n" for k, (a, v) in enumerate(zip(t, x)))
# An oscilloscope of 8 bits, in volts.
code = np.clip(np.round(100 * x), -128, 127)
with open("scope.csv", "w") as file:
    file.write("Source,CH1\nSecond,Volt\n")
    file.writelines(f"{a:.9f},{1.2 + 0.0008 * c:.5f}\n" for a, c in zip(t, code))
