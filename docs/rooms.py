#!/usr/bin/env python3
"""Draws the rooms of the source tree and the arrows between them, as the include lines define them.

    docs/rooms.py           prints the diagram of docs/development.md
    docs/rooms.py --write   replaces the diagram in that page

A room is a folder whose headers other rooms may use. An arrow A -> B means that a file of A includes
a header of B. The test `docs` fails if the diagram is out of date.
"""
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs/development.md"
BEGIN, END = "<!-- docs/rooms.py -->\n", "<!-- end -->\n"
INCLUDE = re.compile(r'^\s*#\s*include\s*"([^"]+)"', re.MULTILINE)

INTEGRATORS = "plugins/integrators"
# Room: folders relative to which its headers are included. A file belongs to the longest room name
# that its path begins with.
ROOMS = {
    "core": ["core", "core/include"],
    "libs/output_files": ["libs", "libs/output_files/include"],
    "libs/image_files": ["libs", "libs/image_files/include"],
    "libs/spectra": ["libs", "libs/spectra/include"],
    "libs/sampling": ["libs", "libs/sampling/include"],
    "libs/meshes": ["libs", "libs/meshes/include"],
    "libs/lights": ["libs", "libs/lights/include"],
    "libs/audit": ["libs", "libs/audit/include"],
    "libs/scene_xml": ["libs", "libs/scene_xml/include"],
    "libs/editor": ["libs", "libs/editor/include"],
    "libs/denoise": ["libs", "libs/denoise/include"],
    "libs/session": ["libs", "libs/session/include"],
    "libs/kit": ["libs"],
    "plugins": [],
    INTEGRATORS: [INTEGRATORS],
    f"{INTEGRATORS}/transport": [INTEGRATORS],
    f"{INTEGRATORS}/clustered": [INTEGRATORS],
    "apps/drawing": ["apps"],
    "apps/kinome": ["apps/kinome"],
    "apps/viewer": ["apps/viewer"],
    "apps/python": ["apps/python/src"],
}
TITLES = {"plugins": "other plugins", INTEGRATORS: "other integrators",
          f"{INTEGRATORS}/transport": "integrators/transport",
          f"{INTEGRATORS}/clustered": "integrators/clustered"}


def room_of(path):
    """Returns the room of a path relative to the root, or None."""
    found = [room for room in ROOMS if path == room or path.startswith(room + "/")]
    return max(found, key=len, default=None)


def sources(root):
    folders = {room.split("/")[0] for room in ROOMS}
    return sorted(path for folder in folders for path in (root / folder).rglob("*")
                  if path.suffix in (".cpp", ".h", ".inc"))


def arrows(root):
    """Returns the set of pairs (room, included room)."""
    found = set()
    for path in sources(root):
        room = room_of(str(path.relative_to(root)))
        for name in INCLUDE.findall(path.read_text("utf-8")):
            places = [path.parent / name]
            places += [root / folder / name for folders in ROOMS.values() for folder in folders]
            for place in places:
                if place.is_file():
                    other = room_of(str(place.resolve().relative_to(root)))
                    if other and room and other != room:
                        found.add((room, other))
                    break
    return found


def reduced(pairs):
    """Removes the arrows that others imply: A -> C if there are A -> B and B -> C."""
    def reaches(a, c, left):
        return any(x == a and (y == c or reaches(y, c, left - {(x, y)})) for x, y in left)
    kept = set(pairs)
    for pair in sorted(pairs):
        if reaches(*pair, kept - {pair}):
            kept.discard(pair)
    return kept


def diagram(root):
    names = {room: f"r{index}" for index, room in enumerate(ROOMS)}
    lines = ["```mermaid", "graph TD"]
    for group in ("apps", "libs", "plugins", "core"):
        lines.append(f"  subgraph {group}")
        lines += [f'    {name}["{TITLES.get(room, room)}"]' for room, name in names.items()
                  if room.split("/")[0] == group]
        lines.append("  end")
    lines += [f"  {names[a]} --> {names[b]}" for a, b in sorted(reduced(arrows(root)))]
    return "\n".join([*lines, "```", ""])


def with_diagram(text, root):
    begin, end = text.index(BEGIN) + len(BEGIN), text.index(END)
    return text[:begin] + diagram(root) + text[end:]


if __name__ == "__main__":
    if sys.argv[1:] == ["--write"]:
        PAGE.write_text(with_diagram(PAGE.read_text("utf-8"), ROOT), "utf-8")
    elif not sys.argv[1:]:
        print(diagram(ROOT), end="")
    else:
        sys.exit(__doc__)
