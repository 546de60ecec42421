"""Runs a test program with the copies that contain the defects, instead of the originals:

  expect_failure.py CORE PLUGINS PROGRAM NAME...

CORE: the library of the core's copies. It is preloaded, so that its functions replace the core's.
PLUGINS: folder of the plugins' copies, which are found before the real ones. With the name of a
defect, the defect is planted, and the tests that must notice it must fail (not crash). Without a
name, the tests of the program's first defect must pass, which shows that the copies work. The other
tests pass with the originals, which are the same code.

The first assertion that fails ends the program, by SIGTRAP: later ones prove no more. Until then, tests
are repeated up to REPEATS times: a process that happens to do all the work hides some defects.
"""
import os
import resource
import signal
import subprocess
import sys

from table import DEFECTS

REPEATS = 5


def run(core, plugins, program, pattern, defect):
    environment = {**os.environ, "LD_PRELOAD": core, "KINOME_PLUGIN_PATH": plugins,
                   "KINOME_DEFECT": defect}
    return subprocess.run([program, f"--gtest_filter={pattern}",
                           "--gtest_break_on_failure",
                           f"--gtest_repeat={REPEATS if defect else 1}"],
                          env=environment, capture_output=True, text=True, check=False)


def main(core, plugins, program, name=""):
    test = os.path.basename(program).removeprefix("test_")
    patterns = dict.fromkeys(d.pattern for d in DEFECTS if d.test == test and name in ("", d.name))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    if not name:
        patterns = list(patterns)[:1]
    result = run(core, plugins, program, ":".join(patterns), name)
    output = f"\n{result.stdout}{result.stderr}"
    if not name:
        if result.returncode != 0 or "[  PASSED  ] 0 tests" in result.stdout:
            sys.exit(f"{test}: fails, or runs no test, while no defect is planted:{output}")
    elif result.returncode == 0:
        sys.exit(f"{name}: goes unnoticed by {' '.join(patterns)}{output}")
    elif result.returncode != -signal.SIGTRAP or ": Failure\n" not in result.stdout:
        sys.exit(f"{name}: {test} does not fail as a test does:{output}")
    print("passes" if not name else "caught by " + " ".join(patterns))


if __name__ == "__main__":
    main(*sys.argv[1:])
