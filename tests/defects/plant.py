"""Writes a copy of a source file with one defect: FROM, which must occur exactly once, becomes TO."""
import pathlib
import re
import sys

source, copy, old, new = sys.argv[1:]
text = pathlib.Path(source).read_text()
# White space is as the formatter left it: any run of it matches any other.
pattern = r"\s+".join(re.escape(word) for word in old.split())
found = re.findall(pattern, text)
if len(found) != 1:
    sys.exit(f"{source}: {old!r} occurs {len(found)} times; a defect is planted in exactly one place")
pathlib.Path(copy).parent.mkdir(parents=True, exist_ok=True)
pathlib.Path(copy).write_text(re.sub(pattern, lambda _: new, text))
