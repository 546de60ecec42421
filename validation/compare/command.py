"""Command kinome-compare: arguments, report, exit status."""
import argparse
import contextlib
import dataclasses
import json
import os
import pathlib
import sys

import OpenImageIO  # noqa: F401: a missing module must be reported before anything else

from .errors import Errors, flip
from .images import MIN_RENDERS, BadInput, files_of, has_variance, load
from .output import check, whole
from .packages import use_packages
from .verdict import compare

ROOT = pathlib.Path(__file__).resolve().parents[2]
NO_FLIP = ("HDR-FLIP: not measured, because the Python package flip-evaluator is missing. It isn't "
           "part of Debian: pip install flip-evaluator. In Kinome's source tree, `sh validation/run.sh "
           "correctness spot` installs it for this command")
FLIP_OF_BLACK = "HDR-FLIP: not measured, because B is black"

USAGE = """\
kinome-compare [OPTION...] A B
       kinome-compare [OPTION...] A... B
       kinome-compare [OPTION...] A... --reference B..."""

DESCRIPTION = """\
Tests whether two renders of a scene have the same expected value. A is compared with the reference B.
Each of the two is given as one of these:

  - an image rendered with `kinome --variance`, or another EXR file with the channels R, G, B of the
    mean and variance.R, variance.G, variance.B of the variance of the mean. The number of renders may
    be in a JSON file beside it, under "seeds". A channel `mask` may mark pixels without a value;
  - at least 4 (better 16) renders with different seeds: file names (m-*.exr, which the shell
    expands), a pattern in quotes ('out/m-*.exr'), or names separated by commas.

Without --reference, only the last name is B.
Exit status: 0 no difference found, 1 a difference, 2 invalid input.

  kinome-compare new.exr old.exr
  kinome-compare m-*.exr reference.exr
  kinome-compare m-*.exr --reference n-*.exr
"""


def parse(arguments):
    parser = argparse.ArgumentParser(prog="kinome-compare", usage=USAGE, description=DESCRIPTION,
                                     formatter_class=argparse.RawDescriptionHelpFormatter,
                                     allow_abbrev=False)
    parser.add_argument("names", metavar="A", nargs="*", help="images to compare, and the reference")
    parser.add_argument("-r", "--reference", metavar="B", nargs="+", default=[],
                        help="the files of the reference: all names after this option")
    parser.add_argument("--alpha", type=float, default=0.01,
                        help="rate of false alarms for correct renders; default: 0.01")
    parser.add_argument("--renders-a", type=int, metavar="N",
                        help="number of independent renders from which A's variance was computed; "
                             "overrides the number in the file")
    parser.add_argument("--renders-b", type=int, metavar="N", help="the same number for B")
    parser.add_argument("--json", metavar="FILE", help="also write all results as JSON")
    parser.add_argument("--picture", metavar="FILE", help="also write a PNG of the difference")
    parser.add_argument("-q", "--quiet", action="store_true", help="print only the last line")
    options = parser.parse_args(arguments)
    if not 0 < options.alpha < 1:
        parser.error(f"--alpha must be between 0 and 1, got {options.alpha:g}")
    if None not in (options.json, options.picture) and (
            os.path.realpath(options.json) == os.path.realpath(options.picture)):
        parser.error(f"--json and --picture are the same file, {options.json}")
    options.a, options.b = options.names, options.reference
    if not options.b:
        options.a, options.b = options.names[:-1], options.names[-1:]
    if not options.a:
        parser.error("expected two images to compare, A and B; the files of A come first, before "
                     "--reference" if options.reference or options.names else
                     "expected two images to compare, A and B")
    return options


def check_ambiguity(options):
    """Raises BadInput if the files of A and B can't be told apart. The shell expands m-*.exr n-*.exr into
    one list of names."""
    if options.reference or len(options.a) < 2:
        return
    first, last = files_of(options.a), files_of(options.b)
    is_pattern = len(last) >= MIN_RENDERS
    is_alone = len(last) == 1 and has_variance(last[0]) and not any(map(has_variance, first))
    if not is_pattern and not is_alone:
        raise BadInput(f"{len(first) + len(last)} files, and it is ambiguous which of them are the "
                       "reference B. Without --reference, the last file is B only if it has a variance "
                       "and no other file has one. Put --reference before the files of B: "
                       f"kinome-compare {options.a[0]} ... --reference ...")


def notes_on_shared(options):
    """Returns a note if A and B share a file. Their noise is then not independent, so the probabilities
    of the tests are wrong."""
    reference = files_of(options.b)
    shared = [name for name in files_of(options.a)
              if any(os.path.samefile(name, other) for other in reference)]
    return [f"{name} is both in A and in B, so all results here are meaningless: the noise of A and B "
            "must be independent" for name in shared[:1]]


@contextlib.contextmanager
def writing(path):
    """Raises BadInput with the name of the file for each OSError."""
    try:
        yield
    except OSError as reason:
        raise BadInput(f"{path}: can't be written: {reason.strerror or reason}") from reason


def check_outputs(options):
    """Raises BadInput if an output can't be written. Called before A and B are read, which may take long."""
    if options.picture is not None:
        # A user who gives another extension expects another format.
        ending = pathlib.Path(options.picture).suffix
        if ending.lower() not in ("", ".png"):
            raise BadInput(f"{options.picture}: --picture writes a PNG, not {ending}")
    paths = [path for path in (options.json, options.picture) if path is not None]
    for path in paths:
        with writing(path):
            check(path)
    for path in filter(os.path.isfile, paths):
        if any(os.path.samefile(path, name) for name in files_of([*options.a, *options.b])):
            raise BadInput(f"{path}: is one of the compared images, which are never overwritten")


def write_outputs(options, a, b, verdict, result):
    if options.json is not None:
        with writing(options.json), whole(options.json) as file:
            file.write((json.dumps(result, indent=2) + "\n").encode())
    if options.picture is not None:
        from . import picture  # imported late because matplotlib takes a second to load
        with writing(options.picture), whole(options.picture) as file:
            picture.write(file, a, b, verdict)


def figures(a, b, verdict):
    """Returns all results in the form of --json."""
    masked = a.masked | b.masked
    result = {"passed": verdict.passed, "alpha": verdict.alpha,
              "a": {"name": a.name, "renders": a.renders, "nan": a.nans, "inf": a.infinities},
              "b": {"name": b.name, "renders": b.renders, "masked": int(b.masked.sum()),
                    "black": not bool((b.mean[~masked] > 0).any())},
              "pixels": int(a.masked.size), "masked": verdict.masked, "notes": verdict.notes,
              "tests": {test.name: dataclasses.asdict(test) for test in verdict.tests},
              "missed_by_b": dataclasses.asdict(verdict.missed) if verdict.missed else None,
              "relmse": dataclasses.asdict(Errors.of(a.mean, b, masked)),
              "relmse_of_one_render": None,
              "flip": flip(a.mean, b.mean, masked)}
    if a.stack is not None:
        each = [Errors.of(image, b, masked) for image in a.stack]
        result["relmse_of_one_render"] = {
            key: float(sum(getattr(e, key) for e in each) / len(each))
            for key in ("relmse", "trimmed", "maximum")}
    return result


def error_figure(value):
    """Formats a relMSE. A negative value is an error below the reference's noise, which is subtracted."""
    return f"below the reference's noise ({value:.4g})" if value < 0 else f"{value:.4g}"


VALUES = {"image": "the mean of the whole image, in each channel",
          "tiles": "the means of 16x16 pixels", "pixels": "every pixel"}


def count(number, what):
    return f"{number} {what}" if number == 1 else f"{number} {what}s"


def report(result):
    """Yields the lines of the human-readable report."""
    a, b = result["a"], result["b"]
    yield f"A: {a['name']}, {count(a['renders'], 'render')}"
    yield f"B: {b['name']}, {count(b['renders'], 'render')}"
    for test in result["tests"].values():
        size = test["detectable"]
        power = "no light to test" if size is None else f"would find a bias of {size:.3%}"
        yield (f"{'pass' if test['passed'] else 'FAIL'}  {test['name']:<7} "
               f"{VALUES[test['name']]}: p = {test['p']:.3g}, {test['failed']} of "
               f"{test['values']} wrong; {power}")
        yield f"      worst: {test['worst']}"
    for label, key in (("A's mean", "relmse"), ("one render of A", "relmse_of_one_render")):
        if result[key] is not None:
            mean, trimmed, maximum = (error_figure(result[key][name])
                                      for name in ("relmse", "trimmed", "maximum"))
            yield (f"relMSE of {label}: {mean}, without the worst 0.1 %: {trimmed}, "
                   f"maximum {maximum}")
    if result["flip"] is not None:
        yield f"HDR-FLIP of A's mean: {result['flip']:.4g}"
    else:
        yield FLIP_OF_BLACK if b["black"] else NO_FLIP
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
        check_ambiguity(options)
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
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # target of Python's last flush at exit
        print(f"kinome-compare: stdout can't be written: {reason.strerror}", file=sys.stderr)
        return 2
    return 0 if verdict.passed else 1
