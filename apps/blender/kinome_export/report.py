"""Warnings of an export: one line for each thing that the exported scene can't have as in Blender."""
import sys


class Report:
    """Collects warnings and prints each of them once."""

    def __init__(self, stream=None):
        self.lines = []
        self._stream = stream

    def warn(self, owner, message):
        """Adds a warning. `owner` names the object, for example "material 'Wood'"."""
        line = f"{owner}: {message}"
        if line in self.lines:
            return
        self.lines.append(line)
        print("kinome export: warning:", line, file=self._stream or sys.stderr)
