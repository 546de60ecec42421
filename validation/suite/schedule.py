"""Which scenes of the benchmark fit a given time, by what scenes have taken so far."""
import re
import statistics
import time

from .tables import THREADS

# Seconds of a scene's parts, as far as nothing is known of any scene.
USUAL = {"reference": 120, "search": 60, "turns": 90, "startup": 15}
NOTHING = 2.0  # seconds that a scene takes of which all is in the store; that tells nothing
UNITS = {"s": 1, "m": 60, "h": 3600}


def duration(text):
    """Seconds of "90s", "15m", "2h" or "1.5h". Raises ValueError."""
    found = re.fullmatch(r"(\d+(?:\.\d+)?)([smh])", text)
    if not found or float(found[1]) == 0:
        raise ValueError(f'"{text}" is no time: 90s, 15m, 2h')
    return float(found[1]) * UNITS[found[2]]


class Clock:
    """Seconds by part, one after the other."""

    def __init__(self):
        self.last, self.laps = time.monotonic(), {}

    def lap(self, part):
        now = time.monotonic()
        self.laps[part], self.last = now - self.last, now


class Schedule:
    """What each scene took is a line of the store, for each program: {"ended", "seconds": by part}.
    A part that was there already takes next to nothing, which is not learned from."""

    def __init__(self, store, references, effort, program, machine):
        self.store, self.references, self.effort = store, references, effort
        self.program = program
        self.common = {"processor": machine["processor"], "cores": machine["cores"],
                       "threads": THREADS}

    def of_scene(self, scene):
        return {"name": scene.name, "size": list(self.effort.timed_size(scene)), **self.common}

    def key(self, scene):
        return {"taken": scene.name, "program": self.program, **self.of_scene(scene)}

    def note(self, scene, laps):
        told = {part: spent for part, spent in laps.items() if spent >= NOTHING}
        if "turns" in told or not self.is_measured(scene):
            self.store.put(self.key(scene), {"ended": time.time(),
                                             "seconds": self.seconds(scene) | told})

    def history(self, scene):
        """What any program took for this scene, the latest last."""
        wanted = self.of_scene(scene).items()
        return sorted((values for key, values in self.store.items("taken")
                       if all(key[name] == value for name, value in wanted)),
                      key=lambda values: values["ended"])

    def seconds(self, scene):
        """By part, as it was the last time; {} of a scene that was never measured."""
        history = self.history(scene)
        return history[-1]["seconds"] if history else {}

    def is_measured(self, scene):
        return self.store.get(self.key(scene)) is not None

    def ordered(self, scenes):
        """Those first that have not been measured by this program; of each kind, those first whose
        measurement is the oldest."""
        return sorted(scenes, key=lambda scene: (self.is_measured(scene), self.age(scene)))

    def age(self, scene):
        history = self.history(scene)
        return history[-1]["ended"] if history else 0

    def estimate(self, scene, scenes):
        """Seconds that the scene will take: each part that isn't there yet as it was the last time;
        where there was none, as the mean of `scenes`."""
        known, others = self.seconds(scene), [self.seconds(other) for other in scenes]
        return sum(known.get(part) or mean([o[part] for o in others if part in o], usual)
                   for part, usual in USUAL.items() if not self.is_there(scene, part))

    def is_there(self, scene, part):
        """Is that part of the scene kept from earlier, so that it needn't be made? (What a search
        found doesn't depend on our program.)"""
        if part == "reference":
            return self.references.is_there(scene, self.effort.timed_size(scene), timed=True)
        return part != "turns" and bool(self.history(scene))

    def is_begun(self, scene):
        """Has this program taken turns there, and not all of them?"""
        return not self.is_measured(scene) and any(
            self.is_turn(key, scene) and key.get("program") == self.program
            for key, _ in self.store.items("renderer"))

    def is_turn(self, key, scene):
        return (key.get("name") == scene.name and "renderer" in key and "part" not in key
                and list(key["size"]) == list(self.effort.timed_size(scene)))

    def forget_turns(self, scene):
        """So that all renderers take theirs on one day; reference and search are as good as they
        were."""
        self.store.forget(lambda key: self.is_turn(key, scene))

    def run(self, scenes, end, measure, log):
        """Calls measure(scene) for those that end before time.monotonic() is `end`, by the
        estimate; what doesn't fit is passed over. Says what was taken, and what is left."""
        taken, left, begun = [], [], time.monotonic()
        for scene in self.ordered(scenes):
            needs = self.estimate(scene, scenes)
            start = time.monotonic()
            if start + needs > end:
                left.append((scene, needs))
                continue
            log.say(f"{scene.name}: will take about {needs:.0f} s of {end - start:.0f} s")
            if not self.is_begun(scene):
                self.forget_turns(scene)
            measure(scene)
            taken.append(f"{scene.name} {time.monotonic() - start:.0f} s")
        log.say(f"taken in {time.monotonic() - begun:.0f} s: {', '.join(taken) or 'none'}")
        if left:
            log.say("left for the next time: " + ", ".join(
                f"{scene.name} (about {needs:.0f} s)" for scene, needs in left))
        return taken, left


def mean(values, otherwise):
    return statistics.fmean(values) if values else otherwise
