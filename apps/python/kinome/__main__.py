"""Runs the program: python -m kinome …"""
import os
import pathlib
import sys

HERE = pathlib.Path(__file__).absolute().parent
# Locations in a wheel, in a build folder, and after `cmake --install`.
PROGRAMS = [HERE / "bin/kinome", HERE.parents[1] / "bin/kinome", HERE.parents[3] / "bin/kinome"]

if __name__ == "__main__":
    program = next((path for path in PROGRAMS if path.is_file()), None)
    if program is None:
        sys.exit(f"python -m kinome: missing program {PROGRAMS[0]}")
    os.execv(program, [str(program), *sys.argv[1:]])
