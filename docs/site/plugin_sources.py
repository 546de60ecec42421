"""Finds the source file of each plugin, and the example in its comment."""
import pathlib
import re

ROOT = pathlib.Path(__file__).resolve().parents[2]
LINE = re.compile(r"^kinome_add_plugin\((\w+) (\w+) (\S+\.cpp)(.*)\)", re.MULTILINE)
LOOP = re.compile(r"^foreach\(name IN ITEMS ([^)]*)\)\n  (kinome_add_plugin.*\n)endforeach\(\)",
                  re.MULTILINE)


def sources(root=ROOT):
    """Returns the source file of each (category, name), aliases included, from the CMake files."""
    found = {}
    for lists in (root / "plugins").rglob("CMakeLists.txt"):
        text = LOOP.sub(
            lambda loop: "".join(loop[2].replace("${name}", name) for name in loop[1].split()),
            lists.read_text("utf-8"))
        for category, name, file, rest in LINE.findall(text):
            aliases = re.search(r"ALIASES ((?:[a-z0-9_]+ ?)+)", rest)
            for each in [name, *(aliases.group(1).split() if aliases else ())]:
                found[category, each] = lists.parent / file
    return found


def example(source):
    """Returns the example in the comment at the top of a plugin's file, or None. It is the indented block of
    lines that begins with an XML tag."""
    lines = []
    indent = None
    for line in source.read_text("utf-8").splitlines():
        if not line.startswith("//"):
            if lines:
                break
            continue
        text = line.lstrip("/")
        if indent is None and re.match(r" {2,}<\w", text):
            indent = len(text) - len(text.lstrip())
        if indent is None:
            continue
        if not text.startswith(" " * indent):
            break
        lines.append(text[indent:])
    return "\n".join(lines) or None
