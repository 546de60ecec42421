"""The command line of validation/run.sh. Needs no package, so that a wrong word is said before
anything is installed or built."""
import argparse
import pathlib

from .tables import GROUP_WORDS, ROOT, SCENES, SMALL_SCENES, named

MODES = ("correctness", "benchmark", "report")
DESCRIPTION = """\
Compares Kinome with Mitsuba 3 (and Blender's Cycles where it can): correctness, then time against
error, then a page of both. Without a mode, all three. What was measured before is not measured
again. Exit status: 0 all well; 1 a comparison is red; 2 something was left out, as the lines say,
or a bad argument; 130 or 143 interrupted."""


def parse(arguments=None):
    parser = argparse.ArgumentParser(prog="validation/run.sh", description=DESCRIPTION,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("words", nargs="*", metavar="MODE or SCENE",
                        help=f"first a mode ({', '.join(MODES)}), then scenes or groups of them "
                             f"({', '.join(GROUP_WORDS)}); default: all modes, and all scenes but "
                             "those that are made for asking")
    parser.add_argument("--quick", action="store_true",
                        help="smaller pictures, fewer seeds and scenes: at most 10 minutes")
    parser.add_argument("--fresh", action="store_true",
                        help="measure anew what was measured before (on another day, a busier "
                             "machine); other scenes and the other form keep what they have")
    parser.add_argument("--output", type=pathlib.Path, metavar="FOLDER",
                        help="where the page goes; default: validation/report, quick: out/report")
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build",
                        help=argparse.SUPPRESS)
    parser.add_argument("--check", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args(arguments)
    options.modes = MODES
    if options.words and options.words[0] in MODES:
        options.modes = (options.words.pop(0),)
    known = {scene.name for scene in SCENES} | {path.stem for path in SMALL_SCENES}
    for name in options.words:
        if name not in known | set(GROUP_WORDS):
            parser.error(f'no mode or scene "{name}"; modes are {", ".join(MODES)}, groups '
                         f'{", ".join(GROUP_WORDS)}, scenes {", ".join(sorted(known))}')
    options.words = named(options.words)
    timed = {scene.name for scene in SCENES}
    if options.modes == ("benchmark",) and options.words and not timed & set(options.words):
        parser.error(f'no benchmark of {", ".join(options.words)}: what is timed is '
                     f'{", ".join(sorted(timed))}')
    options.output = options.output or ROOT / ("out/report" if options.quick
                                               else "validation/report")
    return options
