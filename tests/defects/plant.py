"""Writes a copy of a source file that contains all of its defects: plant.py ROOT SOURCE COPY. A
defect is inactive unless the environment's KINOME_DEFECT names it. One copy per file contains all
defects, because compiling takes most of their time.
"""
import pathlib
import re
import sys

from table import DEFECTS

# Kernels include themselves once for each instruction set, a file and its header may both have
# defects, and several copies may form one unit.
SWITCHES = """\
#ifndef KINOME_DEFECTS
#define KINOME_DEFECTS
#include <cstdlib>
#include <string_view>
namespace kinome_defects {{
inline bool is_planted(std::string_view name) {{
  const char* const planted = std::getenv("KINOME_DEFECT");
  return planted && name == planted;
}}
}}  // namespace kinome_defects
#endif
#ifndef KINOME_DEFECTS_{guard}
#define KINOME_DEFECTS_{guard}
namespace kinome_defects {{
{switches}
}}  // namespace kinome_defects
#endif
#line 1 "{source}"
"""


def planted(defects, old):
    """Returns the replacement of `old`, in which one or more defects may be planted."""
    text = old
    for defect in defects:
        switch = f"::kinome_defects::{defect.name}"
        if "DEFECT" not in defect.new:
            text = f"({switch} ? ({defect.new}) : ({text}))"
        elif len(defects) == 1:
            text = defect.new.replace("DEFECT", switch)
        else:
            sys.exit(f"{defect.name}: another defect is planted in the same place; both must be "
                     "expressions")
    return text


def main(root, source, copy):
    text = pathlib.Path(root, source).read_text(encoding="utf-8")
    own = [defect for defect in DEFECTS if defect.source == source]
    for old in dict.fromkeys(defect.old for defect in own):
        pattern = re.compile(r"\s+".join(re.escape(word) for word in old.split()))
        found = pattern.findall(text)
        if len(found) != 1:
            sys.exit(f"{source}: {old!r} occurs {len(found)} times; a defect is planted in exactly "
                     "one place")
        new = planted([defect for defect in own if defect.old == old], found[0])
        text = pattern.sub(lambda _: new, text)
    switches = "\n".join(f'inline const bool {defect.name} = is_planted("{defect.name}");'
                         for defect in own)
    head = SWITCHES.format(guard=re.sub(r"\W", "_", source).upper(), switches=switches,
                           source=source)
    copy = pathlib.Path(copy)
    copy.parent.mkdir(parents=True, exist_ok=True)
    copy.write_text(head + text, encoding="utf-8")


if __name__ == "__main__":
    main(*sys.argv[1:])
