#!/usr/bin/env python3
"""One picture by the workers of Dask: parts_dask.py SCENE.xml COUNT FOLDER [OPTION...]

renders COUNT parts into FOLDER, which all workers must see, and merges them to FOLDER/picture.exr. By
default the workers are processes of this machine; the variable DASK_SCHEDULER_ADDRESS names a scheduler
that has others. KINOME names the program if it isn't on the PATH.
"""
import os
import pathlib
import subprocess
import sys

import dask.bag

PROGRAM = os.environ.get("KINOME", "kinome")


def render(number, count, scene, folder, options):
    """Renders a part, unless it is there and whole, and returns its file's name. Run by a worker."""
    path = pathlib.Path(folder, f"part-{number}.exr")
    checkpoint = path.with_suffix(".checkpoint")  # beside it as long as it isn't whole
    if checkpoint.exists() or not path.exists():
        subprocess.run([PROGRAM, "-q", scene, "--mpi", "off", "--part", f"{number}/{count}", "-o", str(path),
                        "--checkpoint", str(checkpoint), "--resume", *options], check=True)
    return str(path)


def main(scene, count, folder, *options):
    pathlib.Path(folder).mkdir(parents=True, exist_ok=True)
    if "DASK_SCHEDULER_ADDRESS" in os.environ:
        from dask.distributed import Client
        Client(os.environ["DASK_SCHEDULER_ADDRESS"])  # from here on the bag's scheduler
    numbers = dask.bag.from_sequence(range(1, int(count) + 1), npartitions=int(count))
    files = numbers.map(render, count=int(count), scene=scene, folder=folder, options=options).compute()
    subprocess.run([PROGRAM, "merge", *files, "-o", str(pathlib.Path(folder, "picture.exr"))], check=True)


if __name__ == "__main__":
    if len(sys.argv) < 4:
        sys.exit(__doc__)
    main(*sys.argv[1:])
