"""validation/large/: a table of memory and speed by the size of images."""
import csv
import io

from . import large
from .summary import markdown

GOAL_BYTES = 40


def table(rows):
    first = {(row.scene, row.way): row for row in reversed(rows)}  # the smallest size
    lines = []
    for row in rows:
        base = first[row.scene, row.way]
        speed = row.rays_per_second / base.rays_per_second
        image_speed = row.image_rays_per_second / base.image_rays_per_second
        lines.append([row.scene, row.way, f"{row.size[0]}x{row.size[1]}", f"{row.peak / 1e6:.0f}",
                      f"{row.bytes_per_pixel:.0f}", f"{row.rays_per_second / 1e6:.2f}", f"{speed:.2f}",
                      f"{row.image_rays_per_second / 1e6:.2f}", f"{image_speed:.2f}"])
    return ["scene", "method", "image", "peak memory, MB", "bytes per pixel besides scene and film",
            "million rays per second of processor time", "relative", "without light rays", "relative"], lines


def page(rows, where, commit):
    return "\n".join([
        "# Large images", "",
        f"Written by `sh validation/run.sh large` at {commit[:10]}, on {where['processor']}, "
        f"{where['cores']} cores, with {large.SAMPLES} samples per pixel. `product` is `clustered` with "
        "`trial` = false; `clustered` may choose `path` instead, by the number of its rays. Times are "
        f"medians of {large.REPEATS} renders, or of one if it takes more than {large.MAX_REPEATED} s.", "",
        *markdown(*table(rows)),
        f"The memory of scene and program is that of an image of {large.BASE[0]}x{large.BASE[1]} pixels, "
        f"and that of the film is {large.FILM_BYTES} bytes per pixel: double-precision sums of three "
        "channels and a weight. The rest includes the image (12 bytes per pixel) and its half floats for "
        "the file (6), which exist only after the render. Memory that doesn't grow with the image, such "
        "as light points, counts more per pixel in small images. Processor time excludes that of an image "
        f"of {large.BASE[0]}x{large.BASE[1]} pixels.", "",
        "The number of light rays hardly depends on the size of the image, and each of them takes less time "
        "than the other rays. Their share of all rays is therefore larger in small images, which raises "
        "the rays per second there. The last two columns exclude light rays and the time of the stage "
        "that traces them.", "",
        f"The goals are at most {GOAL_BYTES} bytes per pixel at 3840x2160, and at least as many rays per "
        "second as at 512x512.", ""])


def measurements(rows):
    text = io.StringIO()
    writer = csv.writer(text)
    writer.writerow(["scene", "method", "size", "rays", "processor_seconds", "peak_bytes", "base_bytes",
                     "light_rays", "light_seconds"])
    for row in rows:
        writer.writerow([row.scene, row.way, "x".join(map(str, row.size)), row.rays,
                         f"{row.seconds:.3f}", row.peak, row.base, row.light_rays,
                         f"{row.light_seconds:.3f}"])
    return text.getvalue()
