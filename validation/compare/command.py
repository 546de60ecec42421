"""The command kinome-compare: arguments, report, exit status."""
import argparse
import contextlib
import dataclasses
import json
import os
import pathlib
import sys

import OpenImageIO  # noqa: F401: that there is none is told before anything else

from .errors import Errors, flip
from .images import FEWEST, BadInput, files_of, has_variance, load
from .output import check, whole
from .packages import use_packages
from .verdict import compare

ROOT = pathlib.Path(__file__).resolve().parents[2]
NO_FLIP = ("HDR-FLIP: not measured, for want of the Python package flip-evaluator, which Debian "
           "hasn't got (pip install flip-evaluator; in Kinome's source, `sh validation/run.sh "
           "correctness spot` installs it for this command)")

USAGE = """\
kinome-compare [OPTION...] A B
       kinome-compare [OPTION...] A... B
       kinome-compare [OPTION...] A... --reference B..."""

DESCRIPTION = """\
Do two renderings of a scene have the same expectation? B is the reference, A is what is doubted.
Each of both is one of

  - a picture by `kinome --variance`, or another EXR file with channels R, G, B and variance.R,
    variance.G, variance.B of its mean (a JSON file beside it may say under "seeds" how many renders
    made it, a channel `mask` where it has no value);
  - 4 renders or more of different seeds, 16 if possible: their names (m-*.exr, which the shell
    spells out), a pattern in quotes ('out/m-*.exr'), or names with commas between.

Without --reference, the last name alone is B, and all before it are A.
Exit status: 0 the same as far as can be seen, 1 different, 2 bad input.

  kinome-compare new.exr old.exr
  kinome-compare m-*.exr reference.exr
  kinome-compare m-*.exr --reference n-*.exr
"""


def parse(arguments):
    parser = argparse.ArgumentParser(prog="kinome-compare", usage=USAGE, description=DESCRIPTION,
                                     formatter_class=argparse.RawDescriptionHelpFormatter,
                                     allow_abbrev=False)
    parser.add_argument("names", metavar="A", nargs="*", help="what is compared, and the reference")
    parser.add_argument("-r", "--reference", metavar="B", nargs="+", default=[],
                        help="the reference, where it is several files: all names after this")
    parser.add_argument("--alpha", type=float, default=0.01,
                        help="how often two correct renderings may fail; default: 0.01")
    parser.add_argument("--renders-a", type=int, metavar="N",
                        help="how many independent renders A's variance comes from, where the file "
                             "doesn't say so, or is wrong")
    parser.add_argument("--renders-b", type=int, metavar="N", help="the same of B")
    parser.add_argument("--json", metavar="FILE", help="also write all figures as JSON")
    parser.add_argument("--picture", metavar="FILE", help="also write a PNG of the difference")
    parser.add_argument("-q", "--quiet", action="store_true", help="print only the last line")
    options = parser.parse_args(arguments)
    if not 0 < options.alpha < 1:
        parser.error(f"--alpha must lie between 0 and 1, got {options.alpha:g}")
    if None not in (options.json, options.picture) and (
            os.path.realpath(options.json) == os.path.realpath(options.picture)):
        parser.error(f"--json and --picture are the same file, {options.json}")
    options.a, options.b = options.names, options.reference
    if not options.b:
        options.a, options.b = options.names[:-1], options.names[-1:]
    if not options.a:
        parser.error("expected two pictures to compare, A and B; the files of A come first, before "
                     "--reference" if options.reference or options.names else
                     "expected two pictures to compare, A and B")
    return options


def refuse_doubt(options):
    """m-*.exr n-*.exr are but names to us: where the first set ends, nobody says."""
    if options.reference or len(options.a) < 2:
        return
    first, last = files_of(options.a), files_of(options.b)
    is_pattern = len(last) >= FEWEST
    is_alone = len(last) == 1 and has_variance(last[0]) and not any(map(has_variance, first))
    if not is_pattern and not is_alone:
        raise BadInput(f"{len(first) + len(last)} files, and it isn't plain which of them are B, "
                       "the reference: the last one is, without a word, only where it has a variance "
                       "and no other has. Put --reference before the files of B: "
                       f"kinome-compare {options.a[0]} ... --reference ...")


def notes_on_shared(options):
    """A picture's noise is its own: compared with itself, there is no difference that noise could
    explain, and what is said of chance doesn't hold."""
    reference = files_of(options.b)
    shared = [name for name in files_of(options.a)
              if any(os.path.samefile(name, other) for other in reference)]
    return [f"{name} is both in A and in B: a picture tells nothing about itself, whatever else is "
            "said here" for name in shared[:1]]


@contextlib.contextmanager
def writing(path):
    """What goes wrong here goes wrong with that file."""
    try:
        yield
    except OSError as reason:
        raise BadInput(f"{path}: can't be written: {reason.strerror or reason}") from reason


def check_outputs(options):
    """Before the files of A and B are read, which may take long."""
    if options.picture is not None:
        # Whoever names another format expects that format.
        ending = pathlib.Path(options.picture).suffix
        if ending.lower() not in ("", ".png"):
            raise BadInput(f"{options.picture}: --picture writes a PNG, not {ending}")
    paths = [path for path in (options.json, options.picture) if path is not None]
    for path in paths:
        with writing(path):
            check(path)
    for path in filter(os.path.isfile, paths):
        if any(os.path.samefile(path, name) for name in files_of([*options.a, *options.b])):
            raise BadInput(f"{path}: is one of the compared pictures, which are never overwritten")


def write_outputs(options, a, b, verdict, result):
    if options.json is not None:
        with writing(options.json), whole(options.json) as file:
            file.write((json.dumps(result, indent=2) + "\n").encode())
    if options.picture is not None:
        from . import picture  # matplotlib takes a second to load: only where it is asked for
        with writing(options.picture), whole(options.picture) as file:
            picture.write(file, a, b, verdict)


def figures(a, b, verdict):
    """Everything that is printed, as JSON has it."""
    result = {"passed": verdict.passed, "alpha": verdict.alpha,
              "a": {"name": a.name, "renders": a.renders, "nan": a.nans, "inf": a.infinities},
              "b": {"name": b.name, "renders": b.renders, "masked": int(b.masked.sum())},
              "pixels": int(a.masked.size), "masked": verdict.masked, "notes": verdict.notes,
              "tests": {test.name: dataclasses.asdict(test) for test in verdict.tests},
              "missed_by_b": dataclasses.asdict(verdict.missed) if verdict.missed else None,
              "relmse": dataclasses.asdict(Errors.of(a.mean, b, a.masked | b.masked)),
              "relmse_of_one_render": None,
              "flip": flip(a.mean, b.mean, a.masked | b.masked)}
    if a.stack is not None:
        each = [Errors.of(image, b, a.masked | b.masked) for image in a.stack]
        result["relmse_of_one_render"] = {
            key: float(sum(getattr(e, key) for e in each) / len(each))
            for key in ("relmse", "trimmed", "maximum")}
    return result


def error_figure(value):
    """The reference's noise is subtracted: what is negative is an error too small to be seen."""
    return f"below the reference's noise ({value:.4g})" if value < 0 else f"{value:.4g}"


VALUES = {"image": "the mean of the whole picture, in each channel",
          "tiles": "the means of 16x16 pixels", "pixels": "every pixel"}


def count(number, what):
    return f"{number} {what}" if number == 1 else f"{number} {what}s"


def report(result):
    """Lines for people."""
    a, b = result["a"], result["b"]
    yield f"A: {a['name']}, {count(a['renders'], 'render')}"
    yield f"B: {b['name']}, {count(b['renders'], 'render')}"
    for test in result["tests"].values():
        size = test["detectable"]
        power = "no light to be wrong" if size is None else f"would find a bias of {size:.3%}"
        yield (f"{'pass' if test['passed'] else 'FAIL'}  {test['name']:<7} "
               f"{VALUES[test['name']]}: p = {test['p']:.3g}, {test['failed']} of "
               f"{test['values']} wrong; {power}")
        yield f"      least likely: {test['worst']}"
    for label, key in (("A's mean", "relmse"), ("one render of A", "relmse_of_one_render")):
        if result[key] is not None:
            mean, trimmed, maximum = (error_figure(result[key][name])
                                      for name in ("relmse", "trimmed", "maximum"))
            yield (f"relMSE of {label}: {mean}, without the worst 0.1 %: {trimmed}, "
                   f"maximum {maximum}")
    yield (NO_FLIP if result["flip"] is None else f"HDR-FLIP of A's mean: {result['flip']:.4g}")
    if result["masked"] or a["nan"] or a["inf"]:
        yield (f"NaN in A: {a['nan']}, Inf in A: {a['inf']}; {result['masked']} of "
               f"{result['pixels']} pixels masked, {b['masked']} of them in the reference")
    for note in result["notes"]:
        yield f"note: {note}"


def main(arguments=None):
    options = parse(arguments)
    try:
        check_outputs(options)
        use_packages(pathlib.Path(os.environ.get("KINOME_BUILD") or ROOT / "build"))
        refuse_doubt(options)
        a, b = load(options.a, options.renders_a), load(options.b, options.renders_b)
        verdict = compare(a, b, options.alpha)
        verdict.notes[:0] = notes_on_shared(options)
        result = figures(a, b, verdict)
        write_outputs(options, a, b, verdict, result)
    except (BadInput, OSError) as reason:
        print(f"kinome-compare: {reason}", file=sys.stderr)
        return 2
    broken = a.nans + a.infinities
    try:
        if not options.quiet:
            print("\n".join(report(result)))
        print("pass" if verdict.passed else "FAIL: " + ", ".join(
            [test.name for test in verdict.tests if not test.passed] +
            ([f"{broken} values are NaN or Inf"] if broken else [])), flush=True)
    except OSError as reason:
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # where Python flushes once more at its end
        print(f"kinome-compare: stdout can't be written: {reason.strerror}", file=sys.stderr)
        return 2
    return 0 if verdict.passed else 1
