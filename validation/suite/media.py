"""Measures relMSE by processor time of `volpath`, `clustered` and Mitsuba's fastest configuration in scenes with
media. media_page.py writes the results."""
import bounces
from compare.output import whole
from program import machine

from . import media_page, others
from .problems import Problem
from .store import read_json, write_json, write_whole
from .tables import MEDIA_SCENES

OURS, THEIRS = (4, 16, 64), (16, 64, 256)
QUICK_OURS, QUICK_THEIRS, QUICK_SIZE = (4, 16), (16, 64), (48, 36)
BUDGET = 8.0  # processor time in seconds above a quarter of which larger sample counts are skipped


class Media(bounces.Bounces):
    # Without ldsampler, which took more than 100 times as long as the others in the endless haze.
    samplers = ("multijitter", "independent")
    min_error = 1e-5

    def __init__(self, kinome, mitsuba, store, folder, options, log):
        options.budget = BUDGET
        super().__init__(kinome, mitsuba, store, folder, options, log)
        self.is_quick = options.quick
        self.size = QUICK_SIZE if options.quick else MEDIA_SCENES[0].size

    def sides(self, scene, fastest):
        ours, theirs = (QUICK_OURS, QUICK_THEIRS) if self.is_quick else (OURS, THEIRS)
        return {"volpath": (*self.ours(scene, "volpath"), ours),
                "clustered": (*self.ours(scene, "clustered"), ours),
                "peer": (*self.theirs(scene, fastest), theirs)}

    def differences(self, means):
        return {"differences": {side: bounces.difference_of(means[side], means["peer"])
                                for side in ("volpath", "clustered")},
                "size": self.size}


def run(work, words, output):
    """Measures scenes and updates the page after each of them."""
    path = output / "media.json"
    for scene in MEDIA_SCENES:
        if words and scene.name not in words:
            continue
        other = others.Others()
        try:
            one = work.scene(scene)
        except Problem as reason:
            work.log.problem(f"{scene.name}: {reason}")
            continue
        one["cores_of_others"] = others.cores_of_others([other.taken()])
        found = (read_json(path) or {"scenes": {}})["scenes"] | {scene.name: one}
        found = {s.name: found[s.name] for s in MEDIA_SCENES if s.name in found}
        write_json(path, {"machine": machine(), "scenes": found})
        write_whole(output / "README.md", media_page.page(machine(), found, work.options.seeds))
        write_whole(output / "measurements.csv", media_page.measurements(found))
        with whole(output / "plot.png") as file:
            file.write(media_page.plot(found))
        work.log.say(f"{scene.name}: wrote {output / 'README.md'}")
