"""How much of the machine others took while something was timed, by /proc's counters: other
processes, and on a virtual machine, other machines."""
import os
import pathlib
import time

BUSY = 0.05  # share of all cores; what others take beyond it is told
TICKS = os.sysconf("SC_CLK_TCK")
PROC = pathlib.Path("/proc")


def spent(proc=PROC, this=None):
    """Processor seconds (of all processes, of this one and all that descend from it)."""
    user, nice, system, _, _, interrupts, soft, stolen = map(
        int, (proc / "stat").read_text("ascii").split("\n", 1)[0].split()[1:9])
    children, own = {}, {}
    for folder in proc.glob("[0-9]*"):
        try:
            # The name, in brackets, may hold anything.
            words = (folder / "stat").read_text("ascii", "replace").rpartition(")")[2].split()
        except OSError:
            continue  # has ended
        children.setdefault(int(words[1]), []).append(int(folder.name))
        # With those of its children that have ended and were waited for.
        own[int(folder.name)] = sum(map(int, words[11:15]))
    mine, waiting = 0, [this or os.getpid()]
    while waiting:
        process = waiting.pop()
        mine += own.get(process, 0)
        waiting += children.get(process, [])
    return (user + nice + system + interrupts + soft + stolen) / TICKS, mine / TICKS


class Others:
    """What others take from now on."""

    def __init__(self):
        self.started, self.before = time.perf_counter(), spent()

    def taken(self):
        """{"elapsed": seconds, "others": their processor seconds}; the counters tick a hundred
        times a second, so that only sums over many renders mean something."""
        everyone, mine = (b - a for a, b in zip(self.before, spent()))
        elapsed = time.perf_counter() - self.started
        # More would mean that a process has left the family, with all that it had taken.
        return {"elapsed": elapsed, "others": min(everyone - mine, os.cpu_count() * elapsed)}


def cores_of_others(runs):
    """How many cores they had on average while these runs were made."""
    elapsed = sum(run["elapsed"] for run in runs)
    return max(sum(run["others"] for run in runs) / elapsed, 0.0) if elapsed > 0 else 0.0
