"""The command line of validation/run.sh. Needs no package, so that a wrong word is said before
anything is installed or built."""
import argparse
import os
import pathlib

from .schedule import duration
from .tables import (ALL_WORD, ENGINE_PARTS, GROUP_WORDS, ROOT, SCENES, SMALL_SCENES, THREADS,
                     named)

MODES = ("correctness", "benchmark", "report")
ENGINE, MAPS, BUDGETS = "engine", "maps", "budgets"  # only if they are named
WORDS = (*MODES, ENGINE, MAPS, BUDGETS)
DESCRIPTION = """\
Compares Kinome with Mitsuba 3 (and Blender's Cycles where it can): correctness, then time against
error, then a page of both. Without a mode, all three. `engine`, only if named: nanoseconds a sample
beside Mitsuba's llvm_ad_rgb, and what else its goals name. `maps`, only if named: where the error
of clustered by product lies. `budgets`, only if named: is clustered worse than path on any scene by
any budget? What was measured before is not measured again (but for maps). Exit
status: 0 all well; 1 a comparison is red; 2 something was left out, as the lines say, or a bad
argument; 3 another run is at work in the same build folder; 130 or 143 interrupted."""


def time_given(text):
    try:
        return duration(text)
    except ValueError as reason:
        raise argparse.ArgumentTypeError(reason) from reason


def size_given(word):
    try:
        width, height = map(int, word.split("x"))
    except ValueError:
        width = height = 0
    if min(width, height) < 16:
        raise argparse.ArgumentTypeError(f"size must be WxH, at least 16x16, got {word}")
    return width, height


def seconds_given(word):
    from .budgets import SECONDS
    found = tuple(second for second in SECONDS if f"{second:g}" in word.split(","))
    if len(found) != len(word.split(",")):
        raise argparse.ArgumentTypeError(f"seconds must be some of 1,5,30, got {word}")
    return found


def parse(arguments=None):
    parser = argparse.ArgumentParser(prog="validation/run.sh", description=DESCRIPTION,
                                     formatter_class=argparse.RawDescriptionHelpFormatter,
                                     allow_abbrev=False)
    parser.add_argument("words", nargs="*", metavar="MODE, PART or SCENE",
                        help=f"first a mode ({', '.join(WORDS)}), then scenes or groups of them "
                             f"({', '.join(GROUP_WORDS)}; {ALL_WORD}: all 28), of engine also "
                             f"parts ({', '.join(ENGINE_PARTS)}), of budgets also scene files and "
                             "folders of them; default: all modes but engine, "
                             "maps and budgets, all parts, and all scenes but those that are made for "
                             "asking (maps: six, budgets: all)")
    parser.add_argument("--scenes", metavar="A,B", default="", help="the same as scenes as words")
    parser.add_argument("--quick", action="store_true",
                        help="smaller pictures, fewer seeds and scenes: at most 10 minutes")
    parser.add_argument("--fresh", action="store_true",
                        help="measure anew what was measured before (on another day, a busier "
                             "machine); other scenes and the other form keep what they have")
    parser.add_argument("--scenes-for", type=time_given, metavar="TIME",
                        help="benchmark: those scenes (of those named, or of all) that fit this "
                             "time (90s, 15m, 2h), first what this program wasn't measured on, "
                             "then what is oldest; the same command goes on")
    parser.add_argument("--output", type=pathlib.Path, metavar="FOLDER",
                        help="where the page goes; default: validation/report, engine, maps "
                             "or budgets, quick: the same in out")
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build", metavar="FOLDER",
                        help="measure the program of that build folder, as it is; default: build, "
                             "which is brought up to date")
    parser.add_argument("--minutes", type=float, default=10, metavar="N",
                        help="engine and budgets: begin no measurement that would end later; the "
                             "same command goes on; default: %(default)g")
    parser.add_argument("--sampler", default="ldsampler", metavar="NAME",
                        help="engine: of both programs; default: %(default)s")
    parser.add_argument("--spp", type=int, metavar="N",
                        help="maps: samples a pixel; default: 16")
    parser.add_argument("--seeds", type=int, default=3, metavar="N",
                        help="budgets: renders of each kind, 2 at least; default: %(default)d")
    parser.add_argument("--threads", type=int, default=THREADS, metavar="N",
                        help="budgets: of each render; default: %(default)d")
    parser.add_argument("--size", type=size_given, metavar="WxH",
                        help="budgets: of the images; default: 160x120. Scenes of other sizes have "
                             "rows of their own")
    parser.add_argument("--seconds", type=seconds_given, metavar="S,...", default=(1, 5),
                        help="budgets: by --time, of 1, 5 and 30; replaces those that the page has of "
                             "the scene; default: 1,5")
    parser.add_argument("--work", type=pathlib.Path, help=argparse.SUPPRESS)
    parser.add_argument("--check", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_intermixed_args(arguments)
    options.modes, options.parts = MODES, []
    options.work = options.work or options.build
    if options.words and options.words[0] in WORDS:
        options.modes = (options.words.pop(0),)
    options.words += [name for name in options.scenes.split(",") if name]
    if options.modes == (ENGINE,):
        options.parts = [word for word in options.words if word in ENGINE_PARTS]
        options.words = [word for word in options.words if word not in ENGINE_PARTS]
    known = {scene.name for scene in SCENES} | {path.stem for path in SMALL_SCENES}
    for name in options.words:
        if name in WORDS:
            parser.error(f'one mode at most, as the first word: "{name}" is another')
        if options.modes == (BUDGETS,) and pathlib.Path(name).exists():
            continue
        if name not in known | {ALL_WORD, *GROUP_WORDS}:
            parser.error(f'no mode or scene "{name}"; modes are {", ".join(WORDS)}, groups '
                         f'{", ".join((*GROUP_WORDS, ALL_WORD))}, scenes '
                         f'{", ".join(sorted(known))}')
    options.words = named(options.words)
    timed = {scene.name for scene in SCENES}
    if options.modes == ("benchmark",) and options.words and not timed & set(options.words):
        parser.error(f'no benchmark of {", ".join(options.words)}: what is timed is '
                     f'{", ".join(sorted(timed))}')
    if options.scenes_for is not None:
        if options.modes != ("benchmark",):
            parser.error("--scenes-for is for benchmark")
        options.words = options.words or named([ALL_WORD])
    if options.fresh and options.modes == ("report",):
        parser.error("--fresh is for what measures, and a report doesn't")
    if options.spp is not None and (options.modes != (MAPS,) or options.spp < 1):
        parser.error("--spp is for maps, and 1 at least")
    options.spp = options.spp or 16
    if options.modes == (MAPS,) and options.words and not timed & set(options.words):
        parser.error(f'no maps of {", ".join(options.words)}: there are some of '
                     f'{", ".join(sorted(timed))}')
    if options.seeds < 2:
        parser.error("--seeds must be 2 at least: error is the variance between them")
    name = options.modes[0] if options.modes[0] in (ENGINE, MAPS, BUDGETS) else "report"
    options.output = options.output or ROOT / ("out" if options.quick else "validation") / name
    if name in options.modes:
        reason = unwritable(options.output)
        if reason:
            parser.error(f"--output {options.output}: {reason}")
    return options


def unwritable(folder):
    """Why no file can be written there, or "". An hour of measuring may come first."""
    folder = folder.absolute()
    while not folder.exists():
        folder = folder.parent
    if not folder.is_dir():
        return f"{folder} isn't a folder"
    return "" if os.access(folder, os.W_OK | os.X_OK) else f"{folder} can't be written to"
