"""Problems, each reported in one line. The rest of a run continues."""
import sys
import time


class Problem(Exception):
    """A message of one line for the user: what is left out, and why."""


class Log:
    """Prints progress on stderr, and collects problems, which decide the exit status."""

    def __init__(self, stream=None):
        self.stream = stream or sys.stderr
        self.started = time.monotonic()
        self.problems = []

    def say(self, text):
        print(f"{time.monotonic() - self.started:7.1f} s  {text}", file=self.stream, flush=True)

    def problem(self, reason):
        """Reports a problem, unless the same line was already reported."""
        line = one_line(reason)
        if line not in self.problems:
            self.problems.append(line)
            print(f"validation: {line}", file=self.stream, flush=True)


def one_line(reason):
    return " ".join(str(reason).split())
