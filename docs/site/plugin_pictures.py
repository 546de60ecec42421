"""Renders a small image for the page of each plugin: the example on the page, in a scene for its category.
INSTEAD has scenes for plugins whose examples can't be rendered like this. WITHOUT lists the plugins without an
image."""
import json
import math
import pathlib
import re
import shutil
import struct
import subprocess

# Photographs of Debian's package blender-data.
PHOTOGRAPHS = pathlib.Path("/usr/share/blender/datafiles/studiolights/world")
WIDTH, HEIGHT = 256, 192

SKY = """<emitter type="envmap"> <string name="filename" value="city.exr"/> <float name="scale" value="0.5"/>
  <transform name="to_world"> <rotate x="1" angle="90"/> <rotate z="1" angle="200"/> </transform> </emitter>"""
DIM = '<emitter type="constant"> <rgb name="radiance" value="0.03, 0.035, 0.05"/> </emitter>'
FLOOR = """<shape type="rectangle"> <transform name="to_world"> <scale value="12"/> </transform>
  <bsdf type="diffuse"> <texture type="checkerboard" name="reflectance">
    <rgb name="color0" value="0.55, 0.53, 0.5"/> <rgb name="color1" value="0.28, 0.29, 0.31"/>
    <transform name="to_uv"> <scale value="12"/> </transform> </texture> </bsdf> </shape>"""
WIDE_FLOOR = FLOOR.replace('value="12"', 'value="24"')
BALL = '<shape type="sphere"> <point name="center" x="0" y="0" z="1"/> %s </shape>'
CLAY = '<bsdf type="roughplastic"> <rgb name="diffuse_reflectance" value="0.6, 0.3, 0.15"/> </bsdf>'
GROUP = """<shape type="sphere"> <point name="center" x="-0.9" y="0.6" z="0.8"/> <float name="radius" value="0.8"/>
    <bsdf type="roughconductor"> <string name="material" value="Au"/> </bsdf> </shape>
  <shape type="cube"> <transform name="to_world"> <scale value="0.5"/> <rotate z="1" angle="30"/>
    <translate x="0.8" y="0" z="0.5"/> </transform> <bsdf type="diffuse">
    <rgb name="reflectance" value="0.15, 0.35, 0.4"/> </bsdf> </shape>
  <shape type="sphere"> <point name="center" x="0" y="-1.2" z="0.4"/> <float name="radius" value="0.4"/>
    <bsdf type="dielectric"/> </shape>"""
CAMERA = """<transform name="to_world"> <lookat origin="0, -6.5, 3.2" target="0, 0, 0.75" up="0, 0, 1"/> </transform>
  <float name="fov" value="32"/>"""


def scene(shapes, light=SKY, integrator='<integrator type="clustered"/>', sensor="perspective",
          camera=CAMERA, spp=64, width=WIDTH, sampler="multijitter", rfilter='<rfilter type="gaussian"/>'):
    return f"""<scene version="3.0.0">
{integrator}
<sensor type="{sensor}"> {camera}
  <sampler type="{sampler}"> <integer name="sample_count" value="{spp}"/> </sampler>
  <film type="hdrfilm"> <integer name="width" value="{width}"/>
    <integer name="height" value="{width * HEIGHT // WIDTH}"/> {rfilter} </film> </sensor>
{light}
{shapes}
</scene>
"""


def standing(shape, z=0.0, scale=1.0, angle=0, axis="x"):
    """Returns the XML of a shape, rotated, scaled and moved up, with a BSDF."""
    move = (f'<transform name="to_world"> <rotate {axis}="1" angle="{angle}"/> <scale value="{scale}"/> '
            f'<translate z="{z}"/> </transform>')
    return shape.replace(">", f"> {move} {CLAY}", 1) if not shape.endswith("/>") else \
        shape[:-2] + f"> {move} {CLAY} </shape>"


def filled(medium):
    """Returns a scene with a ball of the medium in front of the group, under the sky."""
    return scene(FLOOR + GROUP + BALL % f'<bsdf type="null"/> {medium}', spp=256)


def medium_of(content="", kind="heterogeneous"):
    return f'<medium type="{kind}" name="interior"> {content} </medium>'


def grid(name, file):
    return f"""<volume type="gridvolume" name="{name}"> <string name="filename" value="{file}"/>
      <transform name="to_world"> <translate x="-0.5" y="-0.5" z="-0.5"/> <scale value="2"/>
      <translate z="1"/> </transform> </volume>"""


FOG = medium_of("""<rgb name="albedo" value="0.99, 0.9, 0.96"/> <float name="sigma_t" value="2"/>
  <phase type="hg"> <float name="g" value="0.7"/> </phase>""", "homogeneous")
SMOKE = grid("sigma_t", "smoke.vol") + '<float name="scale" value="8"/>'


def file_shape(plugin, file):
    return standing(f'<shape type="{plugin}"> <string name="filename" value="{file}"/> </shape>', 0.05)


# Replacements for the examples of the pages.
INSTEAD = {
    ("bsdf", "subsurface"): scene(FLOOR + BALL % """<bsdf type="subsurface">
      <rgb name="color" value="0.9, 0.75, 0.5"/> <rgb name="radius" value="0.1, 0.05, 0.02"/>
      <float name="alpha" value="0.3"/> </bsdf>""", spp=256),
    ("bsdf", "hair"): scene(FLOOR + """<shape type="bsplinecurve"> <string name="filename" value="hair.txt"/>
      <bsdf type="hair"> <float name="eumelanin" value="0.2"/> </bsdf> </shape>"""),
    ("emitter", "area"): scene(FLOOR + GROUP + """<shape type="rectangle"> <transform name="to_world">
      <scale value="0.8"/> <lookat origin="-2, -1, 3" target="0, 0, 0" up="0, 0, 1"/> </transform>
      <emitter type="area"> <rgb name="radiance" value="15, 12, 9"/> </emitter> </shape>""", DIM),
    ("emitter", "directionalarea"): scene(FLOOR + GROUP + """<shape type="disk"> <transform name="to_world">
      <scale value="1.2"/> <lookat origin="-2, -1, 3" target="0, 0, 0.5" up="0, 0, 1"/> </transform>
      <emitter type="directionalarea"> <rgb name="radiance" value="5, 4, 3"/> </emitter> </shape>""", DIM,
                                          '<integrator type="ptracer"/>', spp=64),
    ("emitter", "point"): scene(FLOOR + GROUP, DIM + """<emitter type="point">
      <point name="position" x="1" y="-2" z="3"/> <rgb name="intensity" value="20, 18, 16"/> </emitter>"""),
    ("emitter", "spot"): scene(FLOOR + GROUP, DIM + """<emitter type="spot"> <transform name="to_world">
      <lookat origin="-1.5, -2, 4" target="0, 0, 0" up="0, 0, 1"/> </transform>
      <float name="intensity" value="60"/> <float name="cutoff_angle" value="24"/> </emitter>"""),
    ("emitter", "projector"): scene(FLOOR + GROUP, DIM + """<emitter type="projector"> <transform name="to_world">
      <lookat origin="-1, -3, 5" target="0, 0, 0" up="0, 1, 0"/> </transform> <float name="fov" value="40"/>
      <texture type="bitmap" name="irradiance"> <string name="filename" value="wood.png"/> </texture>
      <float name="scale" value="40"/> </emitter>"""),
    ("emitter", "directional"): scene(FLOOR + GROUP, DIM + """<emitter type="directional">
      <vector name="direction" x="1" y="1" z="-1.5"/> <rgb name="irradiance" value="3, 2.9, 2.5"/> </emitter>"""),
    # Their sky is black below the horizon: the floor fills the image.
    ("emitter", "sunsky"): scene(WIDE_FLOOR + GROUP, """<emitter type="sunsky"> <float name="hour" value="15"/>
      <float name="turbidity" value="4"/> </emitter>"""),
    ("emitter", "timed_sunsky"): scene(WIDE_FLOOR + GROUP, """<emitter type="timed_sunsky">
      <float name="window_start_time" value="9"/> </emitter>"""),
    ("emitter", "vpl"): scene(FLOOR + GROUP + """<shape type="rectangle"> <transform name="to_world">
      <rotate x="1" angle="90"/> <scale value="4"/> <translate y="2.5"/> </transform> <bsdf type="diffuse">
      <rgb name="reflectance" value="0.7, 0.3, 0.2"/> </bsdf> </shape>""", """<emitter type="vpl">
      <string name="placement" value="traced"/> <emitter type="spot"> <transform name="to_world">
      <lookat origin="-1, -2, 4" target="0, 2.5, 1.5" up="0, 0, 1"/> </transform>
      <float name="intensity" value="120"/> <float name="cutoff_angle" value="30"/> </emitter> </emitter>""",
                               """<integrator type="clustered"> <string name="importance" value="joint"/>
      <integer name="max_depth" value="3"/> </integrator>""", spp=4),
    ("shape", "cube"): scene(FLOOR + standing('<shape type="cube"/>', 0.8, 0.8, 35, "z")),
    ("shape", "cylinder"): scene(FLOOR + standing("""<shape type="cylinder"> <point name="p0" value="0, 0, -1"/>
      <point name="p1" value="0, 0, 1"/> <float name="radius" value="0.6"/> </shape>""", 1)),
    ("shape", "disk"): scene(FLOOR + standing('<shape type="disk"/>', 1.1, 1, 60)),
    ("shape", "rectangle"): scene(FLOOR + standing('<shape type="rectangle"/>', 1.1, 0.9, 70)),
    ("shape", "sphere"): scene(FLOOR + BALL % CLAY),
    ("shape", "merge"): scene(FLOOR + """<shape type="merge"> <shape type="cube"> <transform name="to_world">
      <scale value="0.6"/> <translate x="-0.9" z="0.6"/> </transform> </shape> <shape type="sphere">
      <point name="center" x="0.9" y="0" z="0.8"/> <float name="radius" value="0.8"/> </shape> </shape>"""),
    ("shape", "ply"): scene(FLOOR + file_shape("ply", "knot.ply")),
    ("shape", "bsplinecurve"): scene(FLOOR + f"""<shape type="bsplinecurve">
      <string name="filename" value="hair.txt"/> {CLAY} </shape>"""),
    ("shape", "linearcurve"): scene(FLOOR + f"""<shape type="linearcurve">
      <string name="filename" value="twigs.txt"/> {CLAY} </shape>"""),
    ("texture", "mesh_attribute"): scene(FLOOR + """<shape type="ply"> <string name="filename" value="knot.ply"/>
      <transform name="to_world"> <translate z="0.05"/> </transform> <bsdf type="diffuse">
      <texture type="mesh_attribute" name="reflectance"> <string name="name" value="vertex_color"/> </texture>
      </bsdf> </shape>"""),
    ("texture", "rawconstant"): scene(FLOOR + BALL % """<bsdf type="roughconductor"> <texture type="rawconstant"
      name="alpha"> <float name="value" value="0.3"/> </texture> </bsdf>"""),
    ("medium", "heterogeneous"): filled(medium_of(SMOKE + '<float name="albedo" value="0.9"/>')),
    ("volume", "gridvolume"): filled(medium_of(SMOKE + '<rgb name="albedo" value="0.95, 0.8, 0.6"/>')),
    ("volume", "constvolume"): filled(medium_of(SMOKE + """<volume type="constvolume" name="albedo">
      <rgb name="value" value="0.9, 0.8, 0.7"/> </volume>""")),
    ("phase", "sggx"): filled(medium_of(SMOKE + '<float name="albedo" value="0.9"/> <phase type="sggx">' +
                                        grid("S", "flakes.vol") + "</phase>")),
    ("integrator", "volpath"): filled(FOG).replace('"clustered"', '"volpath"'),
    ("integrator", "volpathmis"): filled(FOG).replace('"clustered"', '"volpathmis"'),
    ("integrator", "depth"): scene(FLOOR + GROUP, SKY, '<integrator type="depth"/>', spp=16),
    ("sensor", "thinlens"): scene(FLOOR + GROUP, sensor="thinlens", camera=CAMERA + """
      <float name="aperture_radius" value="0.25"/> <float name="focus_distance" value="6.7"/>"""),
    ("sensor", "perspective"): scene(FLOOR + GROUP),
    ("sensor", "orthographic"): scene(FLOOR + GROUP, sensor="orthographic", camera="""<transform name="to_world">
      <scale value="2.2"/> <lookat origin="0, -6.5, 5" target="0, 0, 0.5" up="0, 0, 1"/> </transform>"""),
    # Twice as wide as high, as all maps of directions.
    ("sensor", "spherical"): scene(FLOOR + GROUP, sensor="spherical", camera="""<transform name="to_world">
      <lookat origin="0.2, -1.2, 1.5" target="0, 0, 1.2" up="0, 0, 1"/> </transform>""").replace(
          f'name="height" value="{HEIGHT}"', f'name="height" value="{WIDTH // 2}"'),
}
INSTEAD["shape", "instance"] = INSTEAD["shape", "shapegroup"] = scene(FLOOR + f"""
  <shape type="shapegroup" id="tree"> <shape type="ply"> <string name="filename" value="knot.ply"/>
    <transform name="to_world"> <scale value="0.3"/> </transform> {CLAY} </shape> </shape>""" + "".join(
        f'<shape type="instance"> <ref id="tree"/> <transform name="to_world"> <rotate z="1" angle="{37 * i}"/> '
        f'<translate x="{1.1 * (i % 4) - 1.6}" y="{1.5 * (i // 4) - 1}" z="0.05"/> </transform> </shape>'
        for i in range(8)))

WITHOUT = {
    ("bsdf", "null"), ("film", "hdrfilm"), ("integrator", "aov"), ("integrator", "groundtruth"),
    ("integrator", "moment"), ("shape", "gltf"), ("shape", "glb"), ("shape", "obj"), ("shape", "serialized"),
    ("sensor", "batch"), ("sensor", "distant"), ("sensor", "irradiancemeter"), ("sensor", "radiancemeter"),
    ("texture", "volume"),
}


def scene_of(category, name, example):
    """Returns the scene for a plugin's image, or None if it has no image."""
    if (category, name) in WITHOUT or example is None:
        return None
    if (category, name) in INSTEAD:
        return INSTEAD[category, name]
    if category == "bsdf":
        return scene(FLOOR + BALL % example)
    if category == "medium":
        return filled(example)
    if category == "phase":
        return filled(medium_of(f'<float name="sigma_t" value="2"/> <float name="albedo" value="0.95"/> {example}',
                                "homogeneous"))
    if category == "emitter":
        return scene(FLOOR + GROUP, example)
    if category == "texture":
        if 'name="radiance"' in example:
            return scene(FLOOR + BALL % f'<emitter type="area"> {example} </emitter>', DIM)
        kind = "plastic" if "diffuse_reflectance" in example else "diffuse"
        return scene(FLOOR + BALL % f'<bsdf type="{kind}"> {example} </bsdf>')
    if category == "integrator":
        return scene(FLOOR + GROUP, integrator=example, spp=64)
    # Differences between filters or samplers are visible in single pixels.
    if category == "rfilter":
        return scene(FLOOR + GROUP, spp=64, width=WIDTH // 4, rfilter=example)
    if category == "sampler":
        light = """<shape type="rectangle"> <transform name="to_world"> <scale value="0.8"/>
          <lookat origin="-2, -1, 3" target="0, 0, 0" up="0, 0, 1"/> </transform> <emitter type="area">
          <rgb name="radiance" value="15, 12, 9"/> </emitter> </shape>"""
        return scene(FLOOR + BALL % CLAY + light, DIM, '<integrator type="direct"/>', spp=4,
                     width=WIDTH // 4, sampler=name, rfilter='<rfilter type="box"/>')
    return None


def knot(folder):
    """Writes a trefoil knot of triangles, whose colour varies along the knot."""
    def place(t):
        return (0.5 * (math.sin(t) + 2 * math.sin(2 * t)), 0.5 * (math.cos(t) - 2 * math.cos(2 * t)),
                0.7 + 0.45 * -math.sin(3 * t))

    def cross(a, b):
        return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])

    def unit(a):
        length = math.sqrt(sum(x * x for x in a))
        return tuple(x / length for x in a)

    along, around, radius = 240, 24, 0.24
    vertices, faces = [], []
    for i in range(along):
        t = 2 * math.pi * i / along
        p, q = place(t), place(t + 1e-3)
        tangent = unit(tuple(b - a for a, b in zip(p, q)))
        side = unit(cross(tangent, (0, 0, 1)))
        up = cross(side, tangent)
        for j in range(around):
            a = 2 * math.pi * j / around
            n = [math.cos(a) * s + math.sin(a) * u for s, u in zip(side, up)]
            color = [0.45 + 0.35 * math.cos(t - phase) for phase in (0, 2.1, 4.2)]
            vertices.append([*(x + radius * d for x, d in zip(p, n)), *n, *color])
            k, m = (i + 1) % along, (j + 1) % around
            faces.append((i * around + j, k * around + j, k * around + m))
            faces.append((i * around + j, k * around + m, i * around + m))
    header = "".join(f"property float {name}\n" for name in "x y z nx ny nz r g b".split())
    (folder / "knot.ply").write_text(
        f"ply\nformat ascii 1.0\nelement vertex {len(vertices)}\n{header}element face {len(faces)}\n"
        "property list uchar int vertex_indices\nend_header\n"
        + "".join(" ".join(f"{x:.5f}" for x in v) + "\n" for v in vertices)
        + "".join("3 {} {} {}\n".format(*f) for f in faces), "utf-8")


def curves(folder):
    """Writes a tuft of hair, and some twigs."""
    hairs, twigs = [], []
    for i in range(900):
        a, r = 2.39996 * i, 0.55 * math.sqrt(i / 900)
        x, y = r * math.cos(a), r * math.sin(a)
        points = []
        for k in range(-1, 9):
            s = k / 7
            wide = 1 + 1.1 * max(s, 0) ** 1.5
            points.append(f"{x * wide:.4f} {y * wide + 0.05 * math.sin(7 * s + i):.4f} "
                          f"{2 * s - 0.7 * s * s * r - 0.2:.4f} {0.012 * (1.3 - s):.5f}")
        hairs.append("\n".join(points))
    for i in range(40):
        a = 2.39996 * i
        twigs.append("\n".join(f"{s * math.cos(a + 0.3 * k):.4f} {s * math.sin(a + 0.3 * k):.4f} "
                               f"{0.05 + 0.35 * k * (0.6 + 0.4 * math.sin(i)):.4f} {0.04 / (k + 1):.4f}"
                               for k, s in enumerate((0.05, 0.3, 0.7, 1.0, 1.5))))
    (folder / "hair.txt").write_text("\n\n".join(hairs) + "\n", "utf-8")
    (folder / "twigs.txt").write_text("\n\n".join(twigs) + "\n", "utf-8")


def images(folder):
    """Writes the maps that examples name."""
    import numpy as np
    from PIL import Image
    size = 512
    v, u = np.mgrid[0:size, 0:size] / size

    def save(name, values):
        pixels = np.clip(np.broadcast_to(values, (size, size, 3)) * 255 + 0.5, 0, 255).astype(np.uint8)
        Image.fromarray(pixels).save(folder / name)

    heights = 0.5 + 0.25 * np.sin(40 * np.pi * u) + 0.25 * np.sin(20 * np.pi * v)
    save("heights.png", heights[:, :, None])
    slope = [np.cos(40 * np.pi * u), np.cos(20 * np.pi * v)]
    normal = np.stack([0.4 * slope[0], 0.4 * slope[1], np.ones_like(u)], axis=2)
    save("normals.png", 0.5 + 0.5 * normal / np.linalg.norm(normal, axis=2, keepdims=True))
    save("dust.png", (0.5 + 0.5 * np.sin(10 * np.pi * v + 3 * np.sin(12 * np.pi * u)))[:, :, None])
    save("leaf.png", ((u * 16 % 1 - 0.5) ** 2 + (v * 8 % 1 - 0.5) ** 2 < 0.14).astype(float)[:, :, None])
    rings = 0.5 + 0.5 * np.sin(60 * np.pi * (u + 0.05 * np.sin(6 * np.pi * v)))
    wood = np.stack([0.45 + 0.25 * rings, 0.25 + 0.18 * rings, 0.12 + 0.1 * rings], axis=2)
    save("wood.png", wood)
    save("wood.jpg", wood)
    shutil.copy(PHOTOGRAPHS / "city.exr", folder)


def grids(folder):
    """Writes a grid of smoke that thins out toward its border, and a grid of flat microflakes."""
    import numpy as np

    def save(name, values):
        z, y, x, channels = values.shape
        header = b"VOL\3" + struct.pack("<5i6f", 1, x, y, z, channels, 0, 0, 0, 1, 1, 1)
        (folder / name).write_bytes(header + values.astype("<f4").tobytes())

    z, y, x = np.meshgrid(*[(np.arange(48) + 0.5) / 24 - 1] * 3, indexing="ij")
    waves = np.sin(7 * x + 3 * np.sin(5 * z)) * np.sin(6 * y + 2 * np.sin(8 * x)) * np.sin(8 * z + 2 * y)
    save("smoke.vol", np.clip(0.9 - np.sqrt(x * x + y * y + z * z) + 0.5 * waves, 0, 1)[..., None])
    save("flakes.vol", np.broadcast_to(np.array([0.05, 0.05, 1, 0, 0, 0]), (2, 2, 2, 6)))


def make_files(folder):
    """Writes all files that the scenes name."""
    folder.mkdir(parents=True, exist_ok=True)
    knot(folder)
    curves(folder)
    images(folder)
    grids(folder)


# Exposures in stops, for images that would be too bright or too dark.
EXPOSURE = {"blackbody": -14, "d65": -1.5, "depth": -3, "sunsky": 1.5,
            "timed_sunsky": 1.5}


def render(program, files, category, name, text, exposure, picture):
    """Renders the scene `text` to `picture`, a PNG. Returns the loaded plugins. Raises RuntimeError with the
    program's message if that fails."""
    file = files / f"{category}-{name}.xml"
    file.write_text(re.sub(r"\s+", " ", text), "utf-8")
    done = subprocess.run([program, "-q", "--stats=json", file, "-o", file.with_suffix(".exr"), "--png",
                           "--exposure", str(exposure)], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise RuntimeError(f"the image of {category}/{name}: {done.stderr.strip()}")
    file.with_suffix(".exr").unlink()
    if category in ("rfilter", "sampler"):
        from PIL import Image
        small = Image.open(file.with_suffix(".png"))
        small.resize((small.width * 4, small.height * 4), Image.NEAREST).save(picture)
        file.with_suffix(".png").unlink()
    else:
        shutil.move(file.with_suffix(".png"), picture)
    return json.loads(done.stdout)["plugins"]
