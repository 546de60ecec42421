"""Command line of validation/run.sh. Needs no packages, so that errors are reported before anything is
installed or built."""
import argparse
import os
import pathlib

from .schedule import duration
from .tables import (ALL_WORD, ENGINE_PARTS, GROUP_WORDS, MEDIA_SCENES, ROOT, SCENES, SMALL_MEDIA,
                     SMALL_SCENES, THREADS, named)

MODES = ("correctness", "benchmark", "report")
ENGINE, MAPS, BUDGETS, SPEEDUP, LARGE, SLOPE = "engine", "maps", "budgets", "threads", "large", "slope"
MEDIA = "media"
OTHER_MODES = (ENGINE, MAPS, BUDGETS, SPEEDUP, LARGE, SLOPE, MEDIA)  # run only if given
WORDS = (*MODES, *OTHER_MODES)
DESCRIPTION = """\
Compares Kinome with Mitsuba 3, and with Blender's Cycles where it supports the scene. Runs the modes
`correctness`, `benchmark` (error over time) and `report` (a page of both), unless one mode is given.

These modes run only if they are given:
  engine   time per sample compared with Mitsuba's llvm_ad_rgb, and other goals
  maps     error of clustered with product in each pixel
  budgets  is clustered worse than path on any scene with any budget?
  threads  time of a render by its number of threads, measured or simulated
  large    memory and speed of images of up to 3840x2160 pixels
  slope    error of clustered by time, from one sample on
  media    error by time of volpath, clustered and Mitsuba in scenes with media

Finished measurements are kept and not repeated, except by `maps`, `threads`, `large` and `slope`.

Exit status: 0 success; 1 a comparison failed; 2 something was left out, as reported, or a bad argument;
3 another run uses the same build folder; 130 or 143 interrupted."""


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
        raise argparse.ArgumentTypeError(f"size must be WxH and at least 16x16, got {word}")
    return width, height


def seconds_given(word):
    from .budgets import SECONDS
    found = tuple(second for second in SECONDS if f"{second:g}" in word.split(","))
    if len(found) != len(word.split(",")):
        raise argparse.ArgumentTypeError(f"seconds must be a selection of 1,5,30, got {word}")
    return found


def parse(arguments=None):
    parser = argparse.ArgumentParser(prog="validation/run.sh", description=DESCRIPTION,
                                     formatter_class=argparse.RawDescriptionHelpFormatter,
                                     allow_abbrev=False)
    parser.add_argument("words", nargs="*", metavar="MODE, PART or SCENE",
                        help=f"a mode ({', '.join(WORDS)}), then scenes or groups of scenes "
                             f"({', '.join(GROUP_WORDS)}; {ALL_WORD}: all {len(SCENES)}); for engine "
                             f"also parts ({', '.join(ENGINE_PARTS)}); for budgets also scene files "
                             "and folders. Default: correctness, benchmark and report, all parts, "
                             "and a selection of scenes (maps and slope: six, budgets: all, threads and "
                             "large: two)")
    parser.add_argument("--scenes", metavar="A,B", default="",
                        help="scenes, in addition to those among the words")
    parser.add_argument("--quick", action="store_true",
                        help="smaller images, fewer seeds and scenes: at most 10 minutes")
    parser.add_argument("--fresh", action="store_true",
                        help="repeat the requested measurements; those of other scenes, and of the "
                             "full or quick form that isn't requested, are kept")
    parser.add_argument("--scenes-for", type=time_given, metavar="TIME",
                        help="benchmark: measure the scenes (given ones, or all) that fit into this "
                             "time (90s, 15m, 2h). Scenes that this program has not measured come "
                             "first, then those with the oldest measurements. Repeat the command to "
                             "continue")
    parser.add_argument("--output", type=pathlib.Path, metavar="FOLDER",
                        help="folder of the page; default: validation/ and the name of the mode, or "
                             "validation/report; with --quick in out/ instead")
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build", metavar="FOLDER",
                        help="measure the program of that build folder without building it; default: "
                             "build, which is brought up to date")
    parser.add_argument("--minutes", type=float, default=10, metavar="N",
                        help="engine and budgets: begin no measurement that would end later. Repeat "
                             "the command to continue. Default: %(default)g")
    parser.add_argument("--sampler", default="ldsampler", metavar="NAME",
                        help="engine: sampler of both programs; default: %(default)s")
    parser.add_argument("--spp", type=int, metavar="N",
                        help="maps: samples per pixel; default: 16")
    parser.add_argument("--seeds", type=int, default=3, metavar="N",
                        help="budgets and media: number of seeds, at least 2; default: %(default)d")
    parser.add_argument("--threads", type=int, default=THREADS, metavar="N",
                        help="budgets: threads of each render; default: %(default)d")
    parser.add_argument("--size", type=size_given, metavar="WxH",
                        help="budgets: size of the images; default: 160x120. Other sizes get separate "
                             "rows on the page")
    parser.add_argument("--seconds", type=seconds_given, metavar="S,...", default=(1, 5),
                        help="budgets: values for --time, a selection of 1, 5 and 30; replaces the "
                             "values of the scene on the page; default: 1,5")
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
    known = {scene.name for scene in SCENES} | {path.stem for path in SMALL_SCENES + SMALL_MEDIA}
    boxes = set()
    if options.modes == (SLOPE,):
        from bounces import NAMES
        boxes = {name for name in NAMES if name.startswith("cornell")}
    known |= boxes
    if options.modes == (MEDIA,):
        known = {scene.name for scene in MEDIA_SCENES}
    for name in options.words:
        if name in WORDS:
            parser.error(f'only one mode is allowed, as the first word: "{name}" is another')
        if options.modes == (BUDGETS,) and pathlib.Path(name).exists():
            continue
        groups = set() if options.modes == (MEDIA,) else {ALL_WORD, *GROUP_WORDS}
        if name not in known | groups:
            parser.error(f'unknown mode or scene "{name}"; modes are {", ".join(WORDS)}, '
                         f'{groups_text(groups)}scenes '
                         f'{", ".join(sorted(known))}')
    options.words = named(options.words)
    timed = {scene.name for scene in SCENES}
    if options.modes == ("benchmark",) and options.words and not timed & set(options.words):
        parser.error(f'benchmark doesn\'t support {", ".join(options.words)}; scenes are '
                     f'{", ".join(sorted(timed))}')
    if options.scenes_for is not None:
        if options.modes != ("benchmark",):
            parser.error("--scenes-for is only for benchmark")
        options.words = options.words or named([ALL_WORD])
    if options.fresh and options.modes == ("report",):
        parser.error("--fresh is only for modes that measure, not for report")
    if options.spp is not None and (options.modes != (MAPS,) or options.spp < 1):
        parser.error("--spp is only for maps, and must be at least 1")
    options.spp = options.spp or 16
    if options.modes in ((MAPS,), (SPEEDUP,), (LARGE,), (SLOPE,)) and options.words \
            and not (timed | boxes) & set(options.words):
        parser.error(f'{options.modes[0]} doesn\'t support {", ".join(options.words)}; scenes are '
                     f'{", ".join(sorted(timed))}')
    if options.seeds < 2:
        parser.error(f"--seeds must be at least 2, got {options.seeds}: the error is the variance "
                     "between seeds")
    name = options.modes[0] if options.modes[0] in OTHER_MODES else "report"
    options.output = options.output or ROOT / ("out" if options.quick else "validation") / name
    if name in options.modes:
        reason = unwritable(options.output)
        if reason:
            parser.error(f"--output {options.output}: {reason}")
    return options


def groups_text(groups):
    """Returns a part of a message: the groups in the order of the help."""
    found = [word for word in (*GROUP_WORDS, ALL_WORD) if word in groups]
    return f'groups {", ".join(found)}, ' if found else ""


def unwritable(folder):
    """Returns why no file can be written to a folder, or "". Checked first because measuring may take an
    hour."""
    folder = folder.absolute()
    while not folder.exists():
        folder = folder.parent
    if not folder.is_dir():
        return f"{folder} isn't a folder"
    return "" if os.access(folder, os.W_OK | os.X_OK) else f"{folder} can't be written to"
