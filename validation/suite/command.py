"""Command of validation/run.sh."""
import importlib.util
import signal
import sys
import time

import numpy as np

from compare.output import whole
from compare.packages import use_packages
from program import RenderFailed, commit, machine

from . import page, summary
from .arguments import OTHER_MODES
from .correctness import FAMILY_ALPHA, Correctness, alpha_for, plan
from .kinome import Kinome
from .peers import Mitsuba
from .problems import Log, Problem
from .store import Store, read_json, write_json, write_whole
from .tables import FULL, QUICK, SCENES, SMALL_MEDIA, SMALL_SCENES, chosen
from .truth import References


class Session:
    """One run of the command."""

    def __init__(self, options, log):
        self.options, self.log = options, log
        self.effort = QUICK if options.quick else FULL
        self.folder = options.work / "validation"
        self.results = self.folder / ("quick" if options.quick else "full")
        self.python = self.folder / "mitsuba/bin/python"
        self.red = False
        self.saved = 0  # number of problems that earlier modes have saved

    def prepare(self):
        self.kinome = Kinome(self.options.build, self.folder / "renders")
        self.store = Store(self.folder / "measurements.jsonl")
        if self.store.torn:
            self.log.say("an incomplete measurement of an interrupted run is repeated")
        if self.options.fresh:
            if self.python.is_file():
                self.store.forget(self.concerned())
            else:
                self.log.problem("Mitsuba isn't installed: --fresh is ignored, and earlier measurements are "
                                 "kept")
        self.references = References(self.python, self.folder / "references", self.effort, self.log)

    def concerned(self):
        """Returns a function of a key of the store: whether this run measures it, with any program."""
        words, modes = self.options.words, self.options.modes
        checks = plan(self.effort, words) if "correctness" in modes else []
        alpha, compared = alpha_for(self.effort, checks), {check.scene for check in checks}
        sizes = {scene.name: list(self.effort.timed_size(scene))
                 for scene in chosen(words, self.effort)
                 if "benchmark" in modes}

        form = "quick" if self.options.quick else "full"

        def is_concerned(key):
            if "engine" in key:
                return ("engine" in modes and key["form"] == form
                        and key["engine"] in (self.options.parts or (key["engine"],))
                        and key["name"] in (words or (key["name"],)))
            if "check" in key:
                return key["check"] in compared and key["alpha"] == alpha
            return sizes.get(key["name"]) == list(key["size"])

        return is_concerned

    def run(self, mode):
        """Runs one mode. Saves the problems for the page, which may be made later."""
        path = self.results / "problems.json"
        getattr(self, mode)()
        if mode != "report":
            earlier = read_json(path) or {}
            words = self.options.words
            kept = [line for line in earlier.get(mode, [])
                    if words and scene_of(line) and scene_of(line) not in words]
            write_json(path, earlier | {mode: kept + self.log.problems[self.saved:]})
            self.saved = len(self.log.problems)

    def correctness(self):
        if importlib.util.find_spec("flip_evaluator") is None:
            self.log.problem("flip-evaluator isn't installed, so the column HDR-FLIP is empty")
        checks = plan(self.effort, self.options.words)
        work = Correctness(self.kinome, self.references, self.effort, self.store,
                           self.folder / "red", self.log)
        rows = work.run(checks)
        path = self.results / "correctness.json"
        kept = [row for row in (read_json(path) or {"rows": []})["rows"]
                if self.options.words and row["scene"] not in self.options.words]
        red = [f"{row['scene']} by {row['method']}" for row in rows if not row["passed"]]
        self.log.say(f"{len(rows)} comparisons, {len(red)} failed" +
                     (f": {', '.join(red)}" if red else ""))
        self.red = bool(red)
        write_json(path, {"family_alpha": FAMILY_ALPHA, "machine": machine(), "commit": commit(),
                          "program": self.kinome.program, "rows": kept + rows})

    def benchmark(self):
        from .benchmark import Benchmark
        mitsuba = Mitsuba(self.python, self.folder / "mitsuba-renders", self.log)
        work = Benchmark(self.kinome, mitsuba, self.folder / "cycles/bin/python", self.references,
                         self.effort, self.store, self.folder, self.log)
        path = self.results / "benchmark.json"

        def measure(scene):
            try:
                entry = work.scene(scene)
            except Problem as reason:
                self.log.problem(reason)
                return
            write_json(path, (read_json(path) or {}) | {scene.name: entry})

        scenes, seconds = chosen(self.options.words, self.effort), self.options.scenes_for
        try:
            if seconds is None:
                for scene in scenes:
                    measure(scene)
            else:
                work.schedule.run(scenes, self.log.started + seconds, measure, self.log)
        finally:
            mitsuba.close()

    def engine(self):
        from . import engine, engine_page
        options = self.options
        mitsuba = Mitsuba(self.python, self.folder / "mitsuba-renders", self.log)
        work = engine.Engine(self.kinome, mitsuba, options.sampler,
                             "quick" if options.quick else "full", self.store,
                             self.folder / "engine-scenes", self.log)
        wanted = engine.units(options.words, options.parts, options.quick)
        if not wanted:
            raise Problem("no part of engine has these scenes")
        try:
            rows = work.run(wanted, 60 * options.minutes - (time.monotonic() - self.log.started))
        finally:
            mitsuba.close()
        if not rows:
            raise Problem("nothing was measured")
        write_whole(options.output / "README.md",
                    engine_page.page(rows, self.log.problems, options.quick))
        write_whole(options.output / "measurements.csv", engine_page.measurements(rows))
        plot = engine_page.plot(rows)
        if plot:
            with whole(options.output / "plot.png") as file:
                file.write(plot)
        print("\n".join(summary.markdown(*engine_page.goals(rows))))
        self.log.say(f"wrote {options.output / 'README.md'}")

    def maps(self):
        from . import maps, maps_page
        options, size = self.options, self.effort.size
        work = maps.Maps(self.kinome, size if options.quick else self.effort.timed_size,
                         options.spp, self.folder / "maps", self.log)
        options.output.mkdir(parents=True, exist_ok=True)
        path = options.output / "maps.json"
        for scene in chosen(options.words or maps.SCENES, self.effort):
            try:
                one = work.scene(scene)
            except (Problem, RenderFailed) as reason:
                self.log.problem(reason)
                continue
            with whole(options.output / f"{scene.name}.png") as file:
                file.write(maps_page.figure(scene.name, one))
            found = (read_json(path) or {}) | {scene.name: maps_page.with_commit(one.figures)}
            found = {s.name: found[s.name] for s in SCENES if s.name in found}
            write_json(path, found)
            write_whole(options.output / "README.md", maps_page.page(found))
            self.log.say(f"wrote {options.output / 'README.md'}")

    def threads(self):
        from . import threads, threads_page
        sizes = threads.SIZES[:1] if self.options.quick else threads.SIZES
        work = threads.Threads(self.kinome, sizes, self.folder / "threads", self.log)
        scenes = chosen(self.options.words or threads.SCENES, self.effort)
        self.write_plot(threads_page.plot(self.measure_scenes(work, scenes, threads_page)))

    def large(self):
        from . import large, large_page
        sizes = large.SIZES[:1] if self.options.quick else large.SIZES
        work = large.Large(self.kinome, sizes, self.folder / "large", self.log)
        scenes = chosen(self.options.words or large.SCENES, self.effort)
        self.measure_scenes(work, scenes, large_page)

    def slope(self):
        from . import slope, slope_page
        work = slope.Slope(self.kinome, self.folder / "slope", self.options.quick, self.log)
        names = slope.names_of(self.options.words)
        self.write_plot(slope_page.plot(self.measure_scenes(work, names, slope_page)))

    def media(self):
        from . import media
        folder = self.folder / "media"
        mitsuba = Mitsuba(self.python, folder / "mitsuba", self.log)
        work = media.Media(self.kinome, mitsuba, Store(folder / "measurements.jsonl"), folder,
                           self.options, self.log)
        try:
            media.run(work, self.options.words, self.options.output)
        finally:
            mitsuba.close()

    def measure_scenes(self, work, scenes, page):
        """Measures scenes, and writes the page and its raw numbers. Returns the rows of the table."""
        rows = []
        for scene in scenes:
            try:
                rows += work.scene(scene)
            except Problem as reason:
                self.log.problem(reason)
        if not rows:
            raise Problem("nothing was measured")
        output = self.options.output
        write_whole(output / "README.md", page.page(rows, machine(), commit()))
        write_whole(output / "measurements.csv", page.measurements(rows))
        print("\n".join(summary.markdown(*page.table(rows))))
        self.log.say(f"wrote {output / 'README.md'}")
        return rows

    def write_plot(self, picture):
        with whole(self.options.output / "plot.png") as file:
            file.write(picture)

    def budgets(self):
        from bounces import NAMES, scene_of as bounces_scene

        from . import budget_scenes, budgets, budgets_page
        options, folder = self.options, self.folder / "budgets"
        work = budgets.Budgets(self.kinome, Store(folder / "measurements.jsonl"), folder, options,
                               self.log)
        boxes = [name for name in NAMES if name.startswith("cornell")]
        scenes = budget_scenes.scenes_of(
            options.words, lambda: [bounces_scene(name, folder / "scenes") for name in boxes])
        path = options.output / "budgets.json"
        for done, scene in enumerate(scenes):
            spent = time.monotonic() - self.log.started
            if spent * (1 + 1 / max(done, 1)) > 60 * options.minutes and done:
                self.log.say(f"{len(scenes) - done} scenes are left: repeat the command to continue")
                break
            self.log.say(f"{scene.name}: {done + 1} of {len(scenes)}")
            try:
                one = work.scene(scene)
            except Problem as reason:
                self.log.problem(f"{scene.name}: {reason}")
                continue
            size = work.size
            name = scene.name if size == budgets.SIZE else f"{scene.name} {size[0]}x{size[1]}"
            found = (read_json(path) or {"scenes": {}})["scenes"] | {name: one}
            write_json(path, {"machine": machine(), "scenes": found})
            write_whole(options.output / "README.md", budgets_page.page(machine(), found))
            write_whole(options.output / "measurements.csv", budgets_page.measurements(found))
            with whole(options.output / "plot.png") as file:
                file.write(budgets_page.plot(found))

    def report(self):
        correctness = read_json(self.results / "correctness.json")
        benchmark = read_json(self.results / "benchmark.json")
        if not correctness and not benchmark:
            raise Problem("nothing to report: run correctness or benchmark first")
        words = self.options.words
        if words:
            correctness, benchmark = only(correctness, benchmark, words)
            if not correctness and not benchmark:
                raise Problem(f"nothing to report for {', '.join(words)}: run correctness or "
                              "benchmark for it first")
        self.red = bool(correctness) and not all(r["passed"] for r in correctness["rows"])
        saved = read_json(self.results / "problems.json") or {}
        problems = [line for mode, lines in saved.items()
                    if mode not in OTHER_MODES  # these have pages of their own
                    for line in lines if not words or scene_of(line) in (None, *words)]
        problems += unmeasured(correctness, benchmark, self.effort, words)
        write_report(self.options.output, correctness, benchmark, problems,
                     self.folder / "pictures", self.options.quick)
        self.log.say(f"wrote {self.options.output / 'index.html'}")


def only(correctness, benchmark, words):
    """Returns both parts with only these scenes; None for a part without any of them."""
    rows = [row for row in (correctness or {"rows": []})["rows"] if row["scene"] in words]
    timed = {name: entry for name, entry in (benchmark or {}).items() if name in words}
    return correctness | {"rows": rows} if rows else None, timed or None


def scene_of(problem):
    """Returns the scene of a line such as "hebe: …" or "hebe, direct: …", or None."""
    name = problem.split(":")[0].split(",")[0]
    small = {path.stem for path in SMALL_SCENES + SMALL_MEDIA}
    return name if name in {scene.name for scene in SCENES} | small else None


def unmeasured(correctness, benchmark, effort, words):
    """Yields lines for the page on missing measurements of these words, or of a default run without
    words."""
    made = {(row["scene"], row["method"]) for row in (correctness or {"rows": []})["rows"]}
    wanted = [c for c in plan(effort, words) if (c.scene, c.method) not in made]
    if wanted:
        names = ", ".join(dict.fromkeys(check.scene for check in wanted))
        yield f"{len(wanted)} comparisons have not been made, of {names}"
    wanted = [scene.name for scene in chosen(words, effort)
              if scene.name not in (benchmark or {})]
    if wanted:
        yield f"not timed: {', '.join(wanted)}"


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


class Stopped(KeyboardInterrupt):
    """Raised by SIGTERM, which is handled like Ctrl-C."""


def stop(_signal, _frame):
    raise Stopped


def main(options):
    """Runs the command with the options of arguments.parse; returns the exit status."""
    signal.signal(signal.SIGTERM, stop)
    signal.signal(signal.SIGINT, signal.default_int_handler)  # the parent process may ignore it
    log = Log()
    session = Session(options, log)
    use_packages(options.work)
    try:
        if options.modes != ("report",):
            session.prepare()
        for mode in options.modes:
            session.run(mode)
    except (Problem, OSError) as reason:
        log.problem(reason)
    except KeyboardInterrupt as reason:
        print("validation: interrupted; run the same command without --fresh to continue",
              file=sys.stderr)
        return 128 + (signal.SIGTERM if isinstance(reason, Stopped) else signal.SIGINT)
    if session.red:
        print("validation: at least one comparison failed", file=sys.stderr)
        return 1
    return 2 if log.problems else 0
