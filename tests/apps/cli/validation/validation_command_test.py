"""Tests of the command line of validation/run.sh: arguments, stored results, missing parts,
signals."""

import contextlib
import fcntl
import io
import json
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[4]
sys.path[:0] = [str(ROOT / "validation"), str(ROOT / "tests/support")]
from suite import arguments, command, others, tables  # noqa: E402
from suite.problems import Log  # noqa: E402
from suite.store import Store  # noqa: E402

BUILD = pathlib.Path(os.environ.get("KINOME_BUILD", ROOT / "build"))


class Command(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = pathlib.Path(temporary.name)
        # The built program, with its own store and output.
        self.build = self.folder / "build"
        self.build.mkdir()
        for name in ("bin", "plugins"):
            (self.build / name).symlink_to(BUILD / name)
        handler = signal.getsignal(signal.SIGTERM)
        self.addCleanup(signal.signal, signal.SIGTERM, handler)

    def options(self, *words):
        return ["--build", str(self.build), "--output", str(self.folder / "out"), *words]

    def run_command(self, *words):
        said = io.StringIO()
        with contextlib.redirect_stderr(said):
            try:
                status = command.main(arguments.parse(self.options(*words)))
            except SystemExit as end:
                status = end.code
        return status, said.getvalue()

    def summary(self):
        return (self.folder / "out/summary.md").read_text(encoding="utf-8")

    def test_a_small_scene_is_proven_and_reported(self):
        # FLIP's package isn't in Debian: the status is 2 if something is left out.
        status, said = self.run_command("correctness", "diffuse_area", "--quick")
        self.assertIn(status, (0, 2), said)
        self.assertIn("check 5 of 5", said)
        self.assertNotIn("failed:", said)
        status, said = self.run_command("report", "--quick")
        self.assertEqual(status, 0, said)
        self.assertIn("5 comparisons on 1 scenes, 0 failed", self.summary())
        # A partial run lists the rest.
        self.assertRegex(self.summary(), r"missing: \d+ comparisons have not been made, of .*hebe")
        self.assertIn("- missing: not timed: hebe, box, plate, blocks", self.summary())
        status, said = self.run_command("report", "diffuse_area", "--quick")
        self.assertEqual(status, 0, said)
        self.assertNotRegex(self.summary(), "have not been made|not timed")
        # A row that repeats another row's figures is marked.
        page = (self.folder / "out/index.html").read_text(encoding="utf-8")
        self.assertIn("another method, 2 in all", page)
        self.assertIn("clustered luminance =", page)
        status, said = self.run_command("report", "spot", "--quick")
        self.assertEqual(status, 2)
        self.assertIn("nothing to report for spot: run correctness or benchmark for it first", said)

        path = self.folder / "build/validation/quick/correctness.json"
        path.write_text(path.read_text("utf-8").replace('"passed": true', '"passed": false', 1))
        status, said = self.run_command("report", "--quick")
        self.assertEqual(status, 1, said)
        self.assertIn("at least one comparison failed", said)
        self.assertIn("- failed: diffuse_area, direct", self.summary())

    def test_groups_select_their_scenes(self):
        self.assertEqual(tables.named(["hebe", "plain"]),
                         ["hebe", "blocks", "mirror", "noon", "ball"])
        named = tables.chosen(["car", "tree"], tables.QUICK)
        self.assertEqual([s.name for s in named], ["car", "tree"])
        self.assertEqual(tables.chosen((), tables.QUICK)[0].name, "hebe")
        unasked = tables.chosen((), tables.FULL)
        self.assertEqual([s.name for s in unasked],
                         ["hebe", "car", "grace", "box", "plate", "blocks"])
        for scene in tables.SCENES:
            self.assertTrue(scene.path.is_file(), scene.name)
            self.assertIn(scene.group, tables.GROUP_WORDS.values())
            has_parameter = 'value="$mis_compensation"' in scene.path.read_text("utf-8")
            self.assertEqual(scene.envmap, has_parameter, scene.name)

    def test_unknown_arguments(self):
        self.assertIn('unknown mode or scene "nowhere"', self.run_command("report", "nowhere")[1])
        status, said = self.run_command("report")
        self.assertEqual(status, 2)
        self.assertIn("nothing to report: run correctness or benchmark first", said)

    def run_script(self, *words, build="none"):
        """Runs run.sh itself, with stubs that prevent installing and building."""
        stubs = self.folder / "stubs"
        stubs.mkdir(exist_ok=True)
        for name in ("apt-get", "cmake", "ninja", "pip"):
            (stubs / name).write_text("#!/bin/sh\necho must not be called >&2\nexit 9\n")
            (stubs / name).chmod(0o755)
        environment = {**os.environ, "KINOME_BUILD": str(self.folder / build),
                       "PATH": f"{stubs}:{os.environ['PATH']}"}
        return subprocess.run(["sh", ROOT / "validation/run.sh", *words], env=environment,
                              capture_output=True, text=True, check=False, timeout=3000)

    def test_nothing_is_installed_or_built_for_an_unknown_argument(self):
        a_file = self.folder / "a_file"
        a_file.touch()
        for words, message in ((["correctnes"], 'unknown mode or scene "correctnes"'),
                               (["--ouput", "x"], "--ouput"), (["--hel"], "--hel"),
                               (["benchmark", "spot"], "benchmark doesn't support spot"),
                               (["correctness", "benchmark"], "only one mode"),
                               (["report", "--fresh"], "--fresh is only for modes that measure"),
                               (["--output", str(a_file)], f"{a_file} isn't a folder")):
            result = self.run_script(*words)
            self.assertEqual(result.returncode, 2, result.stderr)
            self.assertIn(message, result.stderr)
            self.assertFalse((self.folder / "none").exists())
        result = self.run_script("correctness", "--help")
        self.assertEqual((result.returncode, result.stderr), (0, ""))
        self.assertIn("usage: validation/run.sh", result.stdout)

    def test_arguments_and_options_have_any_order(self):
        options = arguments.parse(["benchmark", "--quick", "hebe", "--output", "report"])
        self.assertEqual((options.modes, options.words), (("benchmark",), ["hebe"]))
        self.assertEqual(options.output, pathlib.Path("report"))

    def test_two_runs_do_not_share_a_folder(self):
        (self.build / "validation").mkdir()
        with open(self.build / "validation/lock", "w", encoding="utf-8") as file:
            fcntl.flock(file, fcntl.LOCK_EX)
            result = self.run_script("correctness", "spot", build="build")
        self.assertEqual((result.returncode, result.stdout), (3, ""))
        self.assertIn("another run uses", result.stderr)

    def test_problems_stay_with_their_scenes(self):
        path = self.build / "validation/quick/problems.json"
        path.parent.mkdir(parents=True)
        path.write_text(json.dumps({"correctness": ["hebe: no reference", "spot, direct: gone",
                                                    "no libllvm19"]}))
        (path.parent / "correctness.json").write_text(json.dumps(
            {"rows": [], "machine": {}, "commit": ""}))
        self.run_command("correctness", "diffuse_area", "--quick")
        lines = json.loads(path.read_text("utf-8"))["correctness"]
        self.assertEqual(lines[:2], ["hebe: no reference", "spot, direct: gone"])
        self.assertNotIn("no libllvm19", lines)
        self.run_command("report", "diffuse_area", "--quick")
        self.assertNotIn("no reference", self.summary())

    def test_measurements_are_kept_where_mitsuba_is_missing(self):
        store = Store(self.build / "validation/measurements.jsonl")
        store.put({"check": "none", "alpha": 0}, {"passed": True})
        key = {"check": "diffuse_area", "alpha": command.alpha_for(tables.QUICK, [])}
        store.put(key, {"passed": True})
        status, said = self.run_command("correctness", "diffuse_area", "--quick", "--fresh")
        self.assertEqual(status, 2)
        self.assertIn("Mitsuba isn't installed: --fresh is ignored", said)
        self.assertIsNotNone(Store(store.path).get(key))

    def test_fresh_forgets_no_more_than_it_measures(self):
        hebe = {"name": "hebe", "renderer": "Kinome direct", "seed": 1}
        keys = {"full": {**hebe, "size": tables.FULL.timed_size(tables.SCENES[0])},
                "quick": {**hebe, "size": tables.QUICK.timed_size(tables.SCENES[0])}}

        def left(*words):
            options = arguments.parse(self.options("--fresh", *words))
            store = Store(self.folder / "store.jsonl")
            for key in keys.values():
                store.put(key, {"seconds": 1})
            alpha = {}
            for name, effort in (("full", tables.FULL), ("quick", tables.QUICK)):
                alpha[name] = command.alpha_for(effort, [])
                store.put({"check": "hebe", "alpha": alpha[name]}, {"passed": True})
            store.forget(command.Session(options, Log(io.StringIO())).concerned())
            kept = [json.loads(key) for key in Store(store.path).values]
            names = {value: name for name, value in alpha.items()}
            return sorted([next(n for n, k in keys.items() if list(k["size"]) == key["size"])
                           for key in kept if "size" in key] +
                          ["check " + names[key["alpha"]] for key in kept if "check" in key])

        self.assertEqual(left(), ["check quick", "quick"])
        self.assertEqual(left("--quick"), ["check full", "full"])
        self.assertEqual(left("hebe"), ["check quick", "quick"])
        self.assertEqual(left("benchmark", "hebe"), ["check full", "check quick", "quick"])
        self.assertEqual(left("correctness"), ["check quick", "full", "quick"])
        self.assertEqual(left("car"), ["check full", "check quick", "full", "quick"])

    def test_a_signal_is_answered_and_the_rest_goes_on_later(self):
        for number, status in ((signal.SIGTERM, 143), (signal.SIGINT, 130)):
            process = subprocess.Popen(
                [sys.executable, ROOT / "validation/run.py",
                 *self.options("correctness", "diffuse_area", "spot", "--quick")],
                stderr=subprocess.PIPE, text=True)
            said = ""
            while "check 2" not in said:
                line = process.stderr.readline()
                self.assertTrue(line, said)
                said += line
            process.send_signal(number)
            said += process.communicate(timeout=600)[1]
            self.assertEqual(process.returncode, status, said)
            self.assertIn("interrupted; run the same command without --fresh to continue", said)
            self.assertNotIn("Traceback", said)
        store = Store(self.build / "validation/measurements.jsonl")
        self.assertGreaterEqual(len(store.values), 1)


class TheMachine(unittest.TestCase):
    def test_time_of_other_processes_is_separate(self):
        with tempfile.TemporaryDirectory() as name:
            proc = pathlib.Path(name)
            # user, nice, system, idle, iowait, irq, softirq, steal, guest
            (proc / "stat").write_text("cpu  500 20 80 99999 77777 3 4 5 111 0\ncpu0 1\n")
            for process, parent, spent in ((1, 0, (900, 0, 0, 0)), (40, 1, (10, 20, 30, 40)),
                                           (41, 40, (1, 2, 3, 4)), (42, 41, (50, 0, 0, 0)),
                                           (43, 1, (600, 0, 0, 0))):
                (proc / str(process)).mkdir()
                before = f"{process} (a (b) c) S {parent} 0 0 0 0 0 0 0 0 0"
                (proc / str(process) / "stat").write_text(
                    f"{before} {' '.join(map(str, spent))} 20 0\n")
            (proc / "44").mkdir()  # has ended meanwhile
            everyone, mine = others.spent(proc, 40)
            self.assertEqual(everyone * others.TICKS, 500 + 20 + 80 + 3 + 4 + 5)
            self.assertEqual(mine * others.TICKS, 100 + 10 + 50)

    def test_our_own_children_are_our_own(self):
        spin = [sys.executable, "-c", "import time\nwhile time.process_time() < 0.5: pass"]
        mine = others.spent()[1]
        subprocess.run(spin, check=True)  # it has ended
        self.assertGreater(others.spent()[1] - mine, 0.4)

    def test_their_average_and_the_text_of_the_page(self):
        runs = [{"elapsed": 1.0, "others": 0.5}, {"elapsed": 3.0, "others": 0.5}]
        self.assertAlmostEqual(others.cores_of_others(runs), 0.25)
        self.assertEqual(others.cores_of_others([]), 0)
        entry = {"machine": {"processor": "A", "cores": 2, "system": "Linux"}, "commit": "0",
                 "program": "1"}
        self.assertNotIn("Other processes", command.page.machine_text(
            [entry | {"cores_of_others": 0.05}]))
        self.assertIn("in 1 of 2 scenes, they had up to 0.5 of 2 cores", command.page.machine_text(
            [entry | {"cores_of_others": 0.05}, entry | {"cores_of_others": 0.5}]))


if __name__ == "__main__":
    unittest.main()
