"""Passes where a test succeeds as it is, and fails (does not crash) with a defect planted.

Arguments: VARIABLE=VALUE that plants the defect, test program, GoogleTest filter.
"""
import os
import subprocess
import sys

variable, program, test_filter = sys.argv[1:]
name, value = variable.split("=", 1)
command = [program, f"--gtest_filter={test_filter}"]


def run(environment):
    return subprocess.run(command, env=environment, capture_output=True, text=True, check=False)


sound = run(dict(os.environ))
if sound.returncode != 0 or "[  PASSED  ] 0 tests" in sound.stdout:
    sys.exit(f"{' '.join(command)} does not pass without the defect:\n{sound.stdout}{sound.stderr}")
planted = run({**os.environ, name: value})
if planted.returncode == 0:
    sys.exit(f"{' '.join(command)} passes with {variable}: the defect goes unnoticed")
if planted.returncode != 1 or "[  FAILED  ]" not in planted.stdout:
    sys.exit(f"{' '.join(command)} does not fail as a test does with {variable}:\n"
             f"{planted.stdout}{planted.stderr}")
print(f"caught by {test_filter}")
