"""Renders the scenes of validation/scenes, and two scenes whose meshes are made first. Compares
them with Mitsuba's images of the same files. These are in validation/references, each with a note
on its making.

The false-alarm rate is one tenth of kinome-compare's default, because there are many scenes. The
seeds are fixed: a passing test keeps passing until something changes.
"""

import concurrent.futures
import hashlib
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "validation"))
from compare import compare, load  # noqa: E402

KINOME = pathlib.Path(os.environ.get("KINOME_BUILD", ROOT / "build")) / "bin/kinome"
SCENES = sorted((ROOT / "validation/scenes").glob("*.xml"))
# They are rendered as small images, with the definitions of their references.
WITH_ASSETS = [ROOT / f"scenes/{name}/scene.xml" for name in ("kitchen", "sunroom")]
REFERENCES = ROOT / "validation/references"
RENDERS = 16
SAMPLES = 16
SAMPLES_WITH_ASSETS = 64
ALPHA = 0.001


def render(scene, folder, arguments, samples):
    """Returns the estimate from RENDERS seeds, with the scene's own integrator unless the arguments
    name another."""

    def one(seed):
        command = [KINOME, "-q", "-t", "1", "--seed", str(1000 + seed), "-D", f"spp={samples}",
                   "-D", "sampler=ldsampler", *arguments, "-o", folder / f"{seed:02}.exr", scene]
        result = subprocess.run(command, check=False, capture_output=True, text=True)
        assert result.returncode == 0, result.stderr

    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        list(pool.map(one, range(RENDERS)))
    return load(folder / "*.exr")


def name_of(scene):
    return scene.parent.name if scene in WITH_ASSETS else scene.stem


def note_of(scene):
    return json.loads((REFERENCES / f"{name_of(scene)}.json").read_text(encoding="utf-8"))


class Comparison(unittest.TestCase):
    def check(self, scene, *arguments, samples=SAMPLES):
        with self.subTest(scene=name_of(scene)), tempfile.TemporaryDirectory() as folder:
            verdict = compare(render(scene, pathlib.Path(folder), arguments, samples),
                              load(REFERENCES / f"{name_of(scene)}.exr"), ALPHA)
            lines = [f"{'pass' if t.passed else 'FAIL'} {t.name}: p = {t.p:.3g}, {t.failed} of "
                     f"{t.values}, finds {t.detectable:.3%}; {t.worst}" for t in verdict.tests]
            print(name_of(scene), *arguments, *lines, *verdict.notes, sep="\n  ")
            self.assertTrue(verdict.passed, "\n".join(lines))

    def check_scenes_with_assets(self, integrator):
        """Tests daylight through panes, which no emitter sample reaches, and a thousand lamps. They
        need more samples than other scenes for a good estimate of the variance of rare light."""
        with tempfile.TemporaryDirectory() as made:
            names = [name_of(scene) for scene in WITH_ASSETS]
            subprocess.run([sys.executable, ROOT / "scenes/make_assets.py", "--output", made, *names],
                           check=True, stdout=subprocess.DEVNULL)
            for scene in WITH_ASSETS:
                defines = note_of(scene)["defines"]
                size = [f"{key}={defines[key]}" for key in ("width", "height")]
                self.check(scene, "-a", f"{made}/{name_of(scene)}", "-D", size[0], "-D", size[1],
                           "-D", f"integrator={integrator}", samples=SAMPLES_WITH_ASSETS)


class References(Comparison):
    def test_every_scene_has_a_reference_of_its_present_text(self):
        self.assertGreaterEqual(len(SCENES), 12)
        self.assertEqual(sorted(map(name_of, SCENES + WITH_ASSETS)),
                         sorted(p.stem for p in REFERENCES.glob("*.exr")))
        for scene in SCENES + WITH_ASSETS:
            note = note_of(scene)
            self.assertEqual(note["scene_sha256"], hashlib.sha256(scene.read_bytes()).hexdigest(),
                             f"{scene.name} has changed: run validation/references/make.py")
            self.assertGreaterEqual(note["seeds"], 16)

    def test_every_scene_agrees(self):
        for scene in SCENES:
            self.check(scene)

    def test_clustered_as_path_changes_no_image(self):
        """Tests all features of the scenes: glass, blends, masks, light after any number of
        bounces. With few samples, scenes with a lamp behind glass have heavy tails, and their
        variance is underestimated."""
        by_path = [s for s in SCENES if note_of(s)["integrator"] == "PathIntegrator"]
        self.assertGreaterEqual(len(by_path), 14)
        for scene in by_path:
            samples = 8 * SAMPLES if scene.stem == "cornell" else SAMPLES
            self.check(scene, "-D", "integrator=clustered", samples=samples)

    def test_scenes_with_assets_agree(self):
        self.check_scenes_with_assets("clustered")


class ReferencesOfPath(Comparison):
    """Only `run.sh --all` runs it."""

    def test_scenes_with_assets_agree(self):
        self.check_scenes_with_assets("path")


if __name__ == "__main__":
    unittest.main()
