"""What went wrong, in one line each; the rest goes on."""
import sys
import time


class Problem(Exception):
    """One line for people: what is left out, and why."""


class Log:
    """Progress on stderr, and all problems, which decide the exit status."""

    def __init__(self, stream=None):
        self.stream = stream or sys.stderr
        self.started = time.monotonic()
        self.problems = []

    def say(self, text):
        print(f"{time.monotonic() - self.started:7.1f} s  {text}", file=self.stream, flush=True)

    def problem(self, reason):
        """Says it once, however often it comes."""
        line = one_line(reason)
        if line not in self.problems:
            self.problems.append(line)
            print(f"validation: {line}", file=self.stream, flush=True)


def one_line(reason):
    return " ".join(str(reason).split())
