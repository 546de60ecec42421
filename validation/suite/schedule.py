"""Selects the scenes of the benchmark that fit into a given time, by the times of earlier runs."""
import re
import statistics
import time

from .tables import THREADS

# Assumed seconds of a scene's parts, if no scene was measured yet.
DEFAULT_SECONDS = {"reference": 120, "search": 60, "turns": 90, "startup": 15}
MIN_SECONDS = 2.0  # parts with fewer seconds were in the store, so their times are ignored
UNITS = {"s": 1, "m": 60, "h": 3600}


def duration(text):
    """Returns the seconds of "90s", "15m", "2h" or "1.5h". Raises ValueError."""
    found = re.fullmatch(r"(\d+(?:\.\d+)?)([smh])", text)
    if not found or float(found[1]) == 0:
        raise ValueError(f'"{text}" is not a time such as 90s, 15m or 2h')
    return float(found[1]) * UNITS[found[2]]


class Clock:
    """Measures the seconds of consecutive parts."""

    def __init__(self):
        self.last, self.laps = time.monotonic(), {}

    def lap(self, part):
        now = time.monotonic()
        self.laps[part], self.last = now - self.last, now


class Schedule:
    """Estimates the times of scenes. The store has a line for each scene and program: {"ended", "seconds": by
    part}. The times of parts that were already in the store are ignored."""

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
        measured = {part: spent for part, spent in laps.items() if spent >= MIN_SECONDS}
        if "turns" in measured or not self.is_measured(scene):
            self.store.put(self.key(scene), {"ended": time.time(),
                                             "seconds": self.seconds(scene) | measured})

    def history(self, scene):
        """Returns the times of all programs for this scene, latest last."""
        wanted = self.of_scene(scene).items()
        return sorted((values for key, values in self.store.items("taken")
                       if all(key[name] == value for name, value in wanted)),
                      key=lambda values: values["ended"])

    def seconds(self, scene):
        """Returns the latest seconds by part; {} for a scene that was never measured."""
        history = self.history(scene)
        return history[-1]["seconds"] if history else {}

    def is_measured(self, scene):
        return self.store.get(self.key(scene)) is not None

    def ordered(self, scenes):
        """Returns scenes that this program has not measured, followed by the others. Both are sorted by age,
        oldest measurement first."""
        return sorted(scenes, key=lambda scene: (self.is_measured(scene), self.age(scene)))

    def age(self, scene):
        history = self.history(scene)
        return history[-1]["ended"] if history else 0

    def estimate(self, scene, scenes):
        """Returns the estimated seconds of a scene. Sums the latest times of its missing parts. For a part that
        was never measured, uses the mean over `scenes`."""
        known, others = self.seconds(scene), [self.seconds(other) for other in scenes]
        return sum(known.get(part) or mean([o[part] for o in others if part in o], usual)
                   for part, usual in DEFAULT_SECONDS.items() if not self.is_there(scene, part))

    def is_there(self, scene, part):
        """Returns whether that part of the scene is in the store. The result of the search doesn't depend on our
        program."""
        if part == "reference":
            return self.references.is_there(scene, self.effort.timed_size(scene), timed=True)
        return part != "turns" and bool(self.history(scene))

    def is_begun(self, scene):
        """Returns whether this program has taken some turns on the scene, but not all."""
        return not self.is_measured(scene) and any(
            self.is_turn(key, scene) and key.get("program") == self.program
            for key, _ in self.store.items("renderer"))

    def is_turn(self, key, scene):
        return (key.get("name") == scene.name and "renderer" in key and "part" not in key
                and list(key["size"]) == list(self.effort.timed_size(scene)))

    def forget_turns(self, scene):
        """Deletes the turns of a scene, so that all renderers take their turns on the same day. Keeps the
        reference and the search."""
        self.store.forget(lambda key: self.is_turn(key, scene))

    def run(self, scenes, end, measure, log):
        """Calls measure(scene) for scenes that will end before time.monotonic() is `end`, by the estimate. Skips
        scenes that don't fit. Reports and returns the measured and the remaining scenes."""
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
        log.say(f"measured in {time.monotonic() - begun:.0f} s: {', '.join(taken) or 'none'}")
        if left:
            log.say("remaining scenes: " + ", ".join(
                f"{scene.name} (about {needs:.0f} s)" for scene, needs in left))
        return taken, left


def mean(values, otherwise):
    return statistics.fmean(values) if values else otherwise
