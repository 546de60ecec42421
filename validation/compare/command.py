"""The command kinome-compare: arguments, report, exit status."""
import argparse
import contextlib
import dataclasses
import json
import os
import pathlib
import sys

from .errors import Errors, flip
from .images import BadInput, load
from .output import check, whole
from .packages import use_packages
from .verdict import compare

ROOT = pathlib.Path(__file__).resolve().parents[2]
NO_FLIP = ("HDR-FLIP: needs flip-evaluator, which Debian hasn't got: `sh validation/run.sh "
           "correctness spot` installs it where it is found")

DESCRIPTION = """\
Do two renderings of a scene have the same expectation? Each of A and B is several renders of
different seeds, or a file of a mean with its variance (channels R, G, B, variance.R, variance.G,
variance.B, and perhaps mask; a JSON file beside it says under "seeds" how many renders made it).
Several renders: a quoted pattern ('out/seed*.exr'), or names with commas between.
B is the reference.
Exit status: 0 the same as far as can be seen, 1 different, 2 bad input."""


def parse(arguments):
    parser = argparse.ArgumentParser(prog="kinome-compare", description=DESCRIPTION,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("a", metavar="A")
    parser.add_argument("b", metavar="B")
    parser.add_argument("--alpha", type=float, default=0.01,
                        help="how often two correct renderings may fail; default: 0.01")
    parser.add_argument("--renders-a", type=int, metavar="N",
                        help="how many renders the variance in A comes from")
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
    return options


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
    for path in (options.json, options.picture):
        if path is not None:
            with writing(path):
                check(path)


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


def report(result):
    """Lines for people."""
    a, b = result["a"], result["b"]
    yield f"A: {a['name']}, {a['renders']} renders; B: {b['name']}, {b['renders']} renders"
    for test in result["tests"].values():
        size = test["detectable"]
        power = "no light to be biased" if size is None else f"would find a bias of {size:.3%}"
        yield (f"{'pass' if test['passed'] else 'FAIL'}  {test['name']:<7} p = {test['p']:.3g} "
               f"({test['failed']} of {test['values']} fail; {power})")
        yield f"      worst: {test['worst']}"
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
        a, b = load(options.a, options.renders_a), load(options.b, options.renders_b)
        verdict = compare(a, b, options.alpha)
        result = figures(a, b, verdict)
        write_outputs(options, a, b, verdict, result)
    except (BadInput, OSError) as reason:
        print(f"kinome-compare: {reason}", file=sys.stderr)
        return 2
    if not options.quiet:
        print("\n".join(report(result)))
    broken = a.nans + a.infinities
    print("pass" if verdict.passed else "FAIL: " + ", ".join(
        [test.name for test in verdict.tests if not test.passed] +
        ([f"{broken} values are NaN or Inf"] if broken else [])))
    return 0 if verdict.passed else 1
