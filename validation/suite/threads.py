"""Measures the time of a render by its number of threads, from 1 to 16. Numbers of threads that the machine
doesn't have are simulated from the recorded durations of items. threads_page.py writes the results."""
import dataclasses
import heapq
import json
import os
import statistics

from program import RenderFailed, run_kinome

from .problems import Problem, one_line

COUNTS = (1, 2, 4, 8, 16)
SIZES = ((256, 256), (1920, 1080))
SCENES = ("hebe", "room")
SAMPLES = 16
REPEATS = 3
NOT_RENDER = ("load", "write")  # stages before and after the render


@dataclasses.dataclass
class Part:
    """A loop of the scheduler, or serial work."""

    stage: str
    is_loop: bool
    items: list  # (seconds of work, seconds of commit) of each item, in order
    rest: float = 0  # seconds of the part in which no item runs


@dataclasses.dataclass
class Row:
    scene: str
    size: tuple
    threads: int
    is_measured: bool
    seconds: float  # of the render
    partly_idle: float  # part of it in which fewer than all threads work
    serial: float  # part of it outside loops


def parts_of(events):
    """Returns the parts of a trace of one thread (a list of events in Chrome's format)."""
    found, bounds = {}, {}
    for event in events:
        if event["ph"] != "X":
            continue
        index, seconds = event["args"]["part"], 1e-6 * event["dur"]
        part = found.setdefault(index, Part(event["args"]["stage"], event["cat"] == "loop", []))
        if event["name"] == "commit":
            part.items[-1] = (part.items[-1][0], seconds)
        else:
            part.items.append((seconds, 0.0))
        begin = 1e-6 * event["ts"]
        first, last, busy = bounds.get(index, (begin, begin, 0.0))
        bounds[index] = min(first, begin), max(last, begin + seconds), busy + seconds
    for index, (first, last, busy) in bounds.items():
        found[index].rest = max(0.0, last - first - busy)
    return [found[index] for index in sorted(found)]


def simulate(items, threads):
    """Returns (seconds, seconds in which fewer than `threads` threads work) of a loop. A thread that is free
    takes the next item. Only one thread at a time commits, the first that has come, and the others wait."""
    left = iter(items)
    changes, running = [], []  # running: (end, commit) of the items that threads work on

    def take(begin):
        for work, commit in left:
            heapq.heappush(running, (begin + work, commit))
            changes.extend([(begin, 1), (begin + work, -1)])
            break

    for _ in range(threads):
        take(0.0)
    film = whole = 0.0
    while running:
        end, commit = heapq.heappop(running)
        if commit > 0:
            film = end = max(film, end) + commit
        whole = max(whole, end)
        take(end)
    idle = time = 0.0
    working = 0
    for at, change in [*sorted(changes), (whole, 0)]:
        idle += (at - time) * (working < threads)
        working, time = working + change, at
    return whole, idle


def simulated(parts, threads):
    """Returns (seconds, partly idle seconds, serial seconds) of a render with these parts."""
    seconds = idle = serial = 0.0
    for part in parts:
        if part.stage in NOT_RENDER:
            continue
        if part.is_loop:
            whole, waited = simulate(part.items, threads)
        else:
            whole = sum(work for work, _ in part.items)
            waited = whole * (threads > 1)
            serial += whole
        alone = part.rest * (threads > 1)
        seconds, idle = seconds + whole + part.rest, idle + waited + alone
    return seconds, idle, serial


class Threads:
    def __init__(self, kinome, sizes, folder, log, cores=os.cpu_count()):
        self.kinome, self.sizes, self.log, self.cores = kinome, sizes, log, cores
        self.folder = folder
        folder.mkdir(parents=True, exist_ok=True)

    def scene(self, scene):
        """Returns the rows of a scene. Raises Problem."""
        rows = []
        for size in self.sizes:
            traced = []
            for threads in COUNTS:
                self.log.say(f"{scene.name} {size[0]}x{size[1]}, {threads} threads"
                             + ("" if threads <= self.cores else ", simulated"))
                if threads <= self.cores:
                    runs = [self.render(scene, size, threads) for _ in range(REPEATS)]
                    found = [(sum(s["seconds"] for s in stages), sum(s["partly_idle"] for s in stages),
                              simulated(parts, 1)[2]) for stages, parts in runs]
                    if threads == 1:
                        traced = [parts for _, parts in runs]
                else:
                    found = [simulated(parts, threads) for parts in traced]
                rows.append(Row(scene.name, size, threads, threads <= self.cores,
                                *(statistics.median(column) for column in zip(*found))))
        return rows

    def render(self, scene, size, threads):
        """Returns the statistics of the render's stages, and the parts of its trace."""
        image, trace = self.folder / "picture.exr", self.folder / "trace.json"
        try:
            stats = run_kinome(self.kinome.build, scene.path, image,
                               {"integrator": "clustered", "spp": SAMPLES, "width": size[0],
                                "height": size[1]}, 1, ("-t", str(threads), "--trace", str(trace)))
            events = json.loads(trace.read_text(encoding="utf-8"))["traceEvents"]
        except RenderFailed as reason:
            raise Problem(f"{scene.name}: " + one_line(str(reason).split("failed:\n", 1)[-1])) \
                from reason
        finally:
            image.unlink(missing_ok=True)
            trace.unlink(missing_ok=True)
        stages = [s for s in stats["stage_threads"] if s["stage"] not in NOT_RENDER]
        return stages, parts_of(events)
