"""The command behind validation/run.sh."""
import argparse
import importlib.util
import os
import pathlib
import sys

import numpy as np

from compare.packages import use_packages
from program import commit, machine

from . import page, summary
from .correctness import FAMILY_ALPHA, Correctness, plan
from .kinome import Kinome
from .peers import Mitsuba
from .problems import Log, Problem
from .store import Store, read_json, write_json, write_whole
from .tables import FULL, GROUP_WORDS, QUICK, ROOT, SCENES, SMALL_SCENES, chosen, named
from .truth import References

MODES = ("correctness", "benchmark", "report")
DESCRIPTION = """\
Compares Kinome with Mitsuba 3 (and Blender's Cycles where it can): correctness, then time against
error, then a page of both. Without a mode, all three. What was measured before is not measured
again. Exit status: 0 all well; 1 a comparison is red; 2 something was left out, as the lines say;
130 interrupted."""


def parse(arguments):
    parser = argparse.ArgumentParser(prog="validation/run.sh", description=DESCRIPTION,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("words", nargs="*", metavar="MODE or SCENE",
                        help=f"first a mode ({', '.join(MODES)}), then scenes or groups of them "
                             f"({', '.join(GROUP_WORDS)}); default: all modes, and all scenes but "
                             "those that are made for asking")
    parser.add_argument("--quick", action="store_true",
                        help="smaller pictures, fewer seeds and scenes: at most 10 minutes")
    parser.add_argument("--fresh", action="store_true",
                        help="forget what was measured before (on another day, a busier machine)")
    parser.add_argument("--output", type=pathlib.Path, metavar="FOLDER",
                        help="where the page goes; default: validation/report, quick: out/report")
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build",
                        help=argparse.SUPPRESS)
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


class Session:
    """One run of the command."""

    def __init__(self, options, log):
        self.options, self.log = options, log
        self.effort = QUICK if options.quick else FULL
        self.folder = options.build / "validation"
        self.results = self.folder / ("quick" if options.quick else "full")
        self.python = self.folder / "mitsuba/bin/python"
        self.red = False
        self.told = 0  # problems that an earlier mode has written down

    def prepare(self):
        path = self.folder / "measurements.jsonl"
        if self.options.fresh:
            path.unlink(missing_ok=True)
        self.store = Store(path)
        if self.store.torn:
            self.log.say("a measurement that an interruption cut off is made again")
        self.kinome = Kinome(self.options.build, self.folder / "renders")
        self.references = References(self.python, self.folder / "references", self.effort, self.log)

    def run(self, mode):
        """One mode; what was left out is written down for the page, which may be made later."""
        path = self.results / "problems.json"
        getattr(self, mode)()
        if mode != "report":
            write_json(path, (read_json(path) or {}) | {mode: self.log.problems[self.told:]})
            self.told = len(self.log.problems)

    def correctness(self):
        if importlib.util.find_spec("flip_evaluator") is None:
            self.log.problem("flip-evaluator isn't installed: the column HDR-FLIP is empty")
        checks = plan(self.effort, self.options.words)
        work = Correctness(self.kinome, self.references, self.effort, self.store,
                           self.folder / "red", self.log)
        rows = work.run(checks)
        path = self.results / "correctness.json"
        kept = [row for row in (read_json(path) or {"rows": []})["rows"]
                if self.options.words and row["scene"] not in self.options.words]
        red = [f"{row['scene']} by {row['method']}" for row in rows if not row["passed"]]
        self.log.say(f"{len(rows)} comparisons, {len(red)} red" +
                     (f": {', '.join(red)}" if red else ""))
        self.red = not all(row["passed"] for row in kept + rows)
        write_json(path, {"family_alpha": FAMILY_ALPHA, "machine": machine(), "commit": commit(),
                          "program": self.kinome.program, "rows": kept + rows})

    def benchmark(self):
        from .benchmark import Benchmark
        load, cores = os.getloadavg()[0], os.cpu_count()
        if load > cores / 2:
            self.log.say(f"the machine has been busy (load {load:.1f} on {cores} cores): what else "
                         "runs spoils the times")
        mitsuba = Mitsuba(self.python, self.folder / "mitsuba-renders", self.log)
        work = Benchmark(self.kinome, mitsuba, self.folder / "cycles/bin/python", self.references,
                         self.effort, self.store, self.folder, self.log)
        path = self.results / "benchmark.json"
        try:
            for scene in chosen(self.options.words):
                try:
                    entry = work.scene(scene)
                except Problem as reason:
                    self.log.problem(reason)
                    continue
                write_json(path, (read_json(path) or {}) | {scene.name: entry})
        finally:
            mitsuba.close()

    def report(self):
        correctness = read_json(self.results / "correctness.json")
        benchmark = read_json(self.results / "benchmark.json")
        if not correctness and not benchmark:
            raise Problem("nothing to report: run correctness or benchmark first")
        self.red = bool(correctness) and not all(r["passed"] for r in correctness["rows"])
        problems = [line for lines in (read_json(self.results / "problems.json") or {}).values()
                    for line in lines]
        write_report(self.options.output, correctness, benchmark, problems,
                     self.folder / "pictures", self.options.quick)
        self.log.say(f"wrote {self.options.output / 'index.html'}")


def write_report(output, correctness, benchmark, problems, pictures, quick):
    def load_picture(name):
        path = pictures / f"{name}.npy"
        return np.load(path).astype(np.float64) if path.is_file() else None

    write_whole(output / "index.html",
                page.page(correctness, benchmark, problems, load_picture, quick))
    write_whole(output / "summary.md", summary.summary(correctness, benchmark, problems, quick))
    if benchmark:
        write_whole(output / "measurements.csv", summary.measurements(benchmark))
        write_whole(output / "configurations.csv", summary.configurations(benchmark))


def main(arguments=None):
    options = parse(arguments)
    log = Log()
    session = Session(options, log)
    use_packages(options.build)
    try:
        if options.modes != ("report",):
            session.prepare()
        for mode in options.modes:
            session.run(mode)
    except Problem as reason:
        log.problem(reason)
    except KeyboardInterrupt:
        print("validation: interrupted; the same command goes on from here", file=sys.stderr)
        return 130
    if session.red:
        print("validation: at least one comparison is red", file=sys.stderr)
        return 1
    return 2 if log.problems else 0
