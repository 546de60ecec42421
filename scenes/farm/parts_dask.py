#!/usr/bin/env python3
"""Renders one image by the workers of Dask: parts_dask.py SCENE.xml COUNT FOLDER [OPTION...]

Renders COUNT parts into FOLDER, which all workers must be able to access, and merges them to
FOLDER/picture.exr. By default, the workers are processes of this machine. The environment variable
DASK_SCHEDULER_ADDRESS names a scheduler with other workers. Set KINOME to the path of the program if it
isn't on the PATH.
"""
import os
import pathlib
import subprocess
import sys

import dask.bag

PROGRAM = os.environ.get("KINOME", "kinome")


def render(number, count, scene, folder, options):
    """Renders a part unless its file is complete. Returns the name of the file. Runs on a worker."""
    path = pathlib.Path(folder, f"part-{number}.exr")
    checkpoint = path.with_suffix(".checkpoint")  # exists as long as the part is incomplete
    if checkpoint.exists() or not path.exists():
        subprocess.run([PROGRAM, "-q", scene, "--mpi", "off", "--part", f"{number}/{count}", "-o", str(path),
                        "--checkpoint", str(checkpoint), "--resume", *options], check=True)
    return str(path)


def main(scene, count, folder, *options):
    pathlib.Path(folder).mkdir(parents=True, exist_ok=True)
    if "DASK_SCHEDULER_ADDRESS" in os.environ:
        from dask.distributed import Client
        Client(os.environ["DASK_SCHEDULER_ADDRESS"])  # becomes the scheduler of the bag
    numbers = dask.bag.from_sequence(range(1, int(count) + 1), npartitions=int(count))
    files = numbers.map(render, count=int(count), scene=scene, folder=folder, options=options).compute()
    subprocess.run([PROGRAM, "merge", *files, "-o", str(pathlib.Path(folder, "picture.exr"))], check=True)


if __name__ == "__main__":
    if len(sys.argv) < 4:
        sys.exit(__doc__)
    main(*sys.argv[1:])
