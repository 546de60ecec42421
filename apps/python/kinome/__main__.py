"""python -m kinome …: the program."""
import os
import pathlib
import sys

HERE = pathlib.Path(__file__).absolute().parent
# In a wheel, a build folder, and where `cmake --install` puts it.
PROGRAMS = [HERE / "bin/kinome", HERE.parents[1] / "bin/kinome", HERE.parents[3] / "bin/kinome"]

if __name__ == "__main__":
    program = next((path for path in PROGRAMS if path.is_file()), None)
    if program is None:
        sys.exit(f"python -m kinome: there is no program at {PROGRAMS[0]}")
    os.execv(program, [str(program), *sys.argv[1:]])
