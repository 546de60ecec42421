"""Runs Kinome: returns its images and times."""
import concurrent.futures
import dataclasses
import re
import time

import numpy as np

from compare import BadInput, Estimate
from compare.images import colour, read
from program import RenderFailed, run_kinome

from .problems import Problem, one_line
from .store import hash_of_files
from .tables import RENDERS, ROOT, THREADS


@dataclasses.dataclass
class Render:
    image: np.ndarray
    seconds: float  # rendering: light points, tree and samples
    wall: float  # wall time of the whole process
    embree_share: float
    samples: int  # actual number per pixel; some samplers round up
    stats: dict = dataclasses.field(default_factory=dict)  # all statistics of the program


class Kinome:
    def __init__(self, build, folder):
        self.build, self.folder = build, folder
        folder.mkdir(parents=True, exist_ok=True)
        program = build / "bin/kinome"
        if not program.is_file():
            raise Problem(f"{program} not found: run validation/run.sh, which builds it")
        self.program = hash_of_files([program, *(build / "plugins").rglob("*.so"),
                                      *(build / "lib").glob("*.so*")])

    def render(self, scene, defines, seed, options=("-t", str(THREADS)), name="picture"):
        output = self.folder / f"{name}.{'pfm' if defines.get('file_format') == 'pfm' else 'exr'}"
        start = time.perf_counter()
        try:
            stats = run_kinome(self.build, scene, output, defines, seed, options)
        except RenderFailed as reason:
            raise Problem(one_line(str(reason).split("failed:\n", 1)[-1])) from reason
        wall = time.perf_counter() - start
        try:
            image = colour(output, read(output).channels)
        except BadInput as reason:
            raise Problem(reason) from reason
        finally:
            output.unlink(missing_ok=True)
        return Render(image, stats["seconds"]["render"], wall, stats["embree_share"],
                      stats["samples"], stats)

    def estimate(self, name, scene, defines, first_seed, options=()):
        """Returns the mean and variance of RENDERS seeds, with one thread each."""

        def one(seed):
            return self.render(scene, defines, seed, ("-t", "1", *options), f"{name}-{seed}").image

        with concurrent.futures.ThreadPoolExecutor(THREADS) as pool:
            return Estimate.from_renders(
                name, list(pool.map(one, range(first_seed, first_seed + RENDERS))))


def sized(scene, size):
    """Returns the parameters for the size of a scene of tables.SCENES, and for a file with 32-bit floats."""
    return {"width": size[0], "height": size[1], "file_format": "pfm"}


def with_parameters(scene, folder):
    """Writes a copy of a small scene whose integrator accepts parameters by -D, as in big scenes. It must be
    rendered with `-a` and the folder of the original."""
    text = scene.read_text(encoding="utf-8")
    include = f'<include filename="{ROOT}/scenes/integrators/$integrator.xml"/>'
    changed, count = re.subn(r'<integrator type="\$integrator"/>', include, text)
    if count != 1:
        raise Problem(f'{scene.name}: has no <integrator type="$integrator"/>')
    folder.mkdir(parents=True, exist_ok=True)
    copy = folder / scene.name
    copy.write_text(changed, encoding="utf-8")
    return copy


def scene_hash(scene):
    """Returns a hash of the file, its includes and its assets."""
    files = [scene, *(ROOT / "scenes/integrators").glob("*.xml")]
    for folder in ("assets", "materials", "maps", "../maps"):
        files += [f for f in (scene.parent / folder).glob("*") if f.is_file()]
    return hash_of_files(files)
