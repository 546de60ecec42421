"""Checks that several processes render the same bits as one process, also if processes are killed.
Writes validation/scaling/bits.md.

    sh scenes/render.sh                                  # builds
    /usr/bin/python3 validation/group_bits.py [--build build] [--kills 50]

Each integrator renders a small scene with different numbers of processes and threads, more than the
machine has processors. The files are compared byte for byte. Then renders with 2 to 4 processes are
started, and one of the processes is killed at a random time. The render is resumed from its checkpoint
until the image is complete, which must be the same file. Takes about 5 minutes.
"""
import argparse
import os
import pathlib
import random
import signal
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from program import ROOT, commit, machine  # noqa: E402

CORNELL = "validation/scenes/cornell.xml"
RENDERS = {
    "path": [CORNELL], "direct": [CORNELL, "-Dintegrator=direct"],
    "ptracer": [CORNELL, "-Dintegrator=ptracer"], "depth": [CORNELL, "-Dintegrator=depth"],
    "clustered": [CORNELL, "-Dintegrator=clustered"],
    "clustered, --variance": [CORNELL, "-Dintegrator=clustered", "--variance"],
    "path, --error 0.05": [CORNELL, "--error", "0.05"],
    "moment (path within)": ["validation/scenes/moment.xml"],
    "irradiance meter": ["validation/scenes/irradiancemeter.xml"],
    "path, --part 2/3": [CORNELL, "--part", "2/3"],
}
GROUPS = ((2, 1), (3, 2), (8, 1))
KILLED = [CORNELL, "-Dspp=512"]
MPI = os.environ | {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}


class Renders:
    def __init__(self, program, folder):
        self.program, self.folder = program, folder

    def command(self, arguments, processes, output):
        launcher = ["mpirun", "--oversubscribe", "-n", str(processes)] if processes else []
        return [*launcher, self.program, str(ROOT / arguments[0]), *arguments[1:], "-q", "-o",
                str(output)]

    def picture(self, arguments, processes=0):
        output = self.folder / "picture.exr"
        subprocess.run(self.command(arguments, processes, output), check=True, env=MPI)
        return output.read_bytes()

    def equal_bits(self, arguments):
        """Returns for each of GROUPS whether its file is equal to that of one process."""
        alone = self.picture(arguments)
        return [self.picture([*arguments, "-t", str(threads)], processes) == alone
                for processes, threads in GROUPS]

    def kill(self, kills, seed=7):
        """Returns the numbers of killed processes, of finished images, and of finished images with the
        right bits."""
        rng = random.Random(seed)
        alone = self.picture(KILLED)
        kept, output = self.folder / "kept", self.folder / "out.exr"
        hits = pictures = right = 0
        while hits < kills:
            command = self.command([*KILLED, "-t1", "--checkpoint", str(kept), "--every", "0.1",
                                    "--resume"], rng.choice((2, 3, 4)), output)
            with subprocess.Popen(command, stderr=subprocess.DEVNULL, env=MPI) as job:
                time.sleep(rng.uniform(0.3, 4))
                found = subprocess.run(["pgrep", "-f", f"^{self.program}.*{kept}"], text=True,
                                       capture_output=True, check=False).stdout.split()
                if found and job.poll() is None:
                    os.kill(int(rng.choice(found)), signal.SIGKILL)
                    hits += 1
            if output.exists():
                pictures += 1
                right += output.read_bytes() == alone
                output.unlink()
                kept.unlink(missing_ok=True)
        return hits, pictures, right


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build")
    parser.add_argument("--kills", type=int, default=50)
    options = parser.parse_args()
    lines = ["# Several processes, the same bits", "",
             f"Written by `validation/group_bits.py` at {commit()[:9]}, on {machine()['processor']}, "
             f"{machine()['cores']} cores. There are more processes than cores.", "",
             "| | " + " | ".join(f"{n} processes of {t}" for n, t in GROUPS) + " |",
             "|---|" + "---|" * len(GROUPS)]
    with tempfile.TemporaryDirectory() as folder:
        renders = Renders(str(options.build.resolve() / "bin/kinome"), pathlib.Path(folder))
        for name, arguments in RENDERS.items():
            found = renders.equal_bits(arguments)
            lines.append(f"| {name} | " + " | ".join("same" if same else "**other**"
                                                     for same in found) + " |")
            print(lines[-1], file=sys.stderr)
        hits, pictures, right = renders.kill(options.kills)
    lines += ["", "The table compares the file of one process, byte for byte, with the files of several processes "
              "with the given number of threads each.", "",
              f"In renders with 2 to 4 processes, {hits} processes were killed by SIGKILL at random times. Each "
              f"render was resumed from its checkpoint with 2 to 4 processes. {pictures} images were finished, "
              f"and {right} of them were the same file as that of one process without interruption.", ""]
    (ROOT / "validation/scaling/bits.md").write_text("\n".join(lines), encoding="utf-8")


if __name__ == "__main__":
    main()
