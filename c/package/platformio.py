"""Tells PlatformIO which archive to link: that of the board's core and of the floats' ABI in its flags."""

import os

Import("env")  # noqa: F821

flags = " ".join(str(flag) for name in ("CCFLAGS", "LINKFLAGS", "ASFLAGS") for flag in env.get(name, []))  # noqa: F821
core = next((word[6:] for word in flags.split() if word.startswith("-mcpu=")), None)
core = core or env.BoardConfig().get("build.cpu", "")  # noqa: F821
places = [core]
if "-mfloat-abi=hard" in flags:
    places = [os.path.join(core, unit + "-hard") for unit in ("fpv5-d16", "fpv4-sp-d16", "fpv5-sp-d16")]
here = os.path.dirname(os.path.realpath("library.json"))
folders = [os.path.join(here, "src", place) for place in places]
found = [folder for folder in folders if os.path.isfile(os.path.join(folder, "libpicket.a"))]
if not found:
    raise SystemExit("picket: there is no archive for %s: cargo picket c --core CORE writes it" % (core or "this board"))
env.Append(LIBPATH=found[:1], LIBS=["picket"])  # noqa: F821
