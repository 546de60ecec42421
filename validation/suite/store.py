"""Store of finished measurements, with which a rerun continues where the last run stopped."""
import hashlib
import json
import os

from compare.output import whole


class Store:
    """A file with a line of JSON, [key, values], for each measurement. Each line is written to the disk before
    the next measurement begins.

    A key is a dictionary of everything on which the values depend: scene, program, configuration, machine.
    Only one process may use the file at a time.
    """

    def __init__(self, path):
        self.path = path
        self.values = {}
        self.torn = 0  # number of lines that are incomplete because of an interruption
        path.parent.mkdir(parents=True, exist_ok=True)
        for line in self._lines():
            key, values = line
            self.values[canonical(key)] = values

    def _lines(self):
        if not self.path.exists():
            return
        kept = []
        for line in self.path.read_text(encoding="utf-8", errors="replace").splitlines():
            try:
                key, values = json.loads(line)
                kept.append(line)
                yield key, values
            except (ValueError, TypeError):
                self.torn += 1
        if self.torn:
            write_whole(self.path, "".join(line + "\n" for line in kept))

    def get(self, key):
        return self.values.get(canonical(key))

    def items(self, word):
        """Returns pairs (key, values) whose key contains the entry `word`."""
        return [(json.loads(key), values) for key, values in self.values.items()
                if f'"{word}": ' in key]

    def put(self, key, values):
        line = as_line(key, values)
        with open(self.path, "a", encoding="utf-8") as file:
            file.write(line)
            file.flush()
            os.fsync(file.fileno())
        self.values[canonical(key)] = values

    def forget(self, is_concerned):
        """Deletes measurements for whose keys is_concerned(key) is true."""
        self.values = {key: values for key, values in self.values.items()
                       if not is_concerned(json.loads(key))}
        write_whole(self.path, "".join(as_line(json.loads(key), values)
                                       for key, values in self.values.items()))

    def recall(self, key, measure):
        """Returns the values of a key. Calls measure() only if they are missing."""
        found = self.get(key)
        if found is None:
            found = measure()
            self.put(key, found)
        return found


def as_line(key, values):
    return json.dumps([key, values], allow_nan=False) + "\n"


def canonical(key):
    return json.dumps(key, sort_keys=True)


def digest(key):
    """Returns a file name for a key."""
    return hashlib.sha256(canonical(key).encode()).hexdigest()[:20]


def hash_of_files(paths, start=""):
    """Returns a hash of the names and contents of files."""
    total = hashlib.sha256(start.encode())
    for path in sorted(paths):
        total.update(path.name.encode() + b"\0" + hashlib.sha256(path.read_bytes()).digest())
    return total.hexdigest()[:16]


def write_whole(path, text):
    """Writes a file atomically: in full or not at all."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with whole(path) as file:
        file.write(text.encode())


def write_json(path, data):
    write_whole(path, json.dumps(data, indent=1, allow_nan=False) + "\n")


def read_json(path):
    """Returns the contents of a JSON file, or None if it doesn't exist."""
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        return None
