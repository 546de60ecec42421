"""Measures memory and speed of large images. large_page.py writes the results."""
import dataclasses
import statistics

from program import RenderFailed, run_kinome

from .problems import Problem, one_line

SIZES = ((512, 512), (1920, 1080), (3840, 2160))
BASE = (32, 32)  # its memory and time are mostly those of the scene
SCENES = ("hebe", "room")
SAMPLES = 4
REPEATS = 3
MAX_REPEATED = 60  # processor seconds above which a render isn't repeated
WAYS = {"path": {"integrator": "path"},
        "product": {"integrator": "clustered", "trial": "false"},
        "clustered": {"integrator": "clustered"}}
FILM_BYTES = 4 * 8  # per pixel: sums of R, G, B and the weight


@dataclasses.dataclass
class Row:
    scene: str
    way: str
    size: tuple
    rays: int
    light_rays: int
    seconds: float  # processor time without that of the base
    light_seconds: float  # busy time of the threads in the stage `points`, without that of the base
    peak: int  # bytes
    base: int  # bytes of the base's peak

    @property
    def pixels(self):
        return self.size[0] * self.size[1]

    @property
    def bytes_per_pixel(self):
        """Memory in addition to scene and film."""
        return (self.peak - self.base) / self.pixels - FILM_BYTES

    @property
    def rays_per_second(self):
        return self.rays / self.seconds

    @property
    def image_rays_per_second(self):
        """The same without light rays and the stage that traces them."""
        return (self.rays - self.light_rays) / (self.seconds - self.light_seconds)


class Large:
    def __init__(self, kinome, sizes, folder, log):
        self.kinome, self.sizes, self.log, self.folder = kinome, sizes, log, folder
        folder.mkdir(parents=True, exist_ok=True)

    def scene(self, scene):
        """Returns the rows of a scene. Raises Problem."""
        rows = []
        for way in WAYS:
            base = self.render(scene, way, BASE)
            for size in self.sizes:
                self.log.say(f"{scene.name} by {way}, {size[0]}x{size[1]}")
                found = self.render(scene, way, size)
                rows.append(Row(scene.name, way, size, found["rays"], found["light_rays"],
                                found["seconds"] - base["seconds"],
                                found["light_seconds"] - base["light_seconds"],
                                found["peak"], base["peak"]))
        return rows

    def render(self, scene, way, size):
        """Returns rays, times and peak memory; medians if a render is short."""
        image, runs = self.folder / "picture.exr", []
        try:
            while len(runs) < REPEATS and (not runs or runs[0]["processor_seconds"] < MAX_REPEATED):
                runs.append(run_kinome(self.kinome.build, scene.path, image,
                                       WAYS[way] | {"spp": SAMPLES, "width": size[0], "height": size[1]}, 1))
        except RenderFailed as reason:
            raise Problem(f"{scene.name}: " + one_line(str(reason).split("failed:\n", 1)[-1])) \
                from reason
        finally:
            image.unlink(missing_ok=True)
        return {"rays": sum(runs[0]["rays"].values()),
                "light_rays": runs[0]["rays"]["light"],
                "light_seconds": statistics.median(light_seconds(run) for run in runs),
                "seconds": statistics.median(run["processor_seconds"] for run in runs),
                "peak": statistics.median_high(run["peak_memory_bytes"] for run in runs)}


def light_seconds(run):
    return sum(sum(stage["busy"]) for stage in run["stage_threads"] if stage["stage"] == "points")
