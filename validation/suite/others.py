"""Measures the processor time of other processes during a measurement, by the counters of /proc. On a virtual
machine, this includes other virtual machines."""
import os
import pathlib
import time

BUSY = 0.05  # share of all cores above which the time of other processes is reported
TICKS = os.sysconf("SC_CLK_TCK")
PROC = pathlib.Path("/proc")


def spent(proc=PROC, this=None):
    """Returns the processor seconds of all processes, and of this one with all its descendants."""
    user, nice, system, _, _, interrupts, soft, stolen = map(
        int, (proc / "stat").read_text("ascii").split("\n", 1)[0].split()[1:9])
    children, own = {}, {}
    for folder in proc.glob("[0-9]*"):
        try:
            # The name, in parentheses, may contain any characters.
            words = (folder / "stat").read_text("ascii", "replace").rpartition(")")[2].split()
        except OSError:
            continue  # the process has ended
        children.setdefault(int(words[1]), []).append(int(folder.name))
        # Includes children that have ended and were waited for.
        own[int(folder.name)] = sum(map(int, words[11:15]))
    mine, waiting = 0, [this or os.getpid()]
    while waiting:
        process = waiting.pop()
        mine += own.get(process, 0)
        waiting += children.get(process, [])
    return (user + nice + system + interrupts + soft + stolen) / TICKS, mine / TICKS


class Others:
    """Measures the processor time of other processes since its construction."""

    def __init__(self):
        self.started, self.before = time.perf_counter(), spent()

    def taken(self):
        """Returns {"elapsed": seconds, "others": processor seconds of other processes}. The counters tick a
        hundred times per second, so only sums over many renders are meaningful."""
        everyone, mine = (b - a for a, b in zip(self.before, spent()))
        elapsed = time.perf_counter() - self.started
        # The limit corrects for descendants that are no longer counted, because their parent has ended.
        return {"elapsed": elapsed, "others": min(everyone - mine, os.cpu_count() * elapsed)}


def cores_of_others(runs):
    """Returns the average number of cores that other processes used during these runs."""
    elapsed = sum(run["elapsed"] for run in runs)
    return max(sum(run["others"] for run in runs) / elapsed, 0.0) if elapsed > 0 else 0.0
