"""Prints tests/plugins/bsdfs/principled_reference.inc: values of Mitsuba 3's principled BSDFs with random
parameters, at random directions.

    python3 -m venv v && v/bin/pip install mitsuba==3.9.1 numpy
    v/bin/python tests/plugins/bsdfs/make_principled_reference.py > tests/plugins/bsdfs/principled_reference.inc

Each row: index of the BSDF, wi, wo, f cos(theta_o) in R, G, B, and the density of sampling.
"""
import mitsuba as mi
import numpy as np

mi.set_variant("scalar_rgb")

SHARES = ["roughness", "anisotropic", "spec_trans", "spec_tint", "sheen", "sheen_tint", "flatness"]
SOLID = [*SHARES, "metallic", "clearcoat", "clearcoat_gloss"]
SOLID_RATES = ["diffuse_reflectance_sampling_rate", "main_specular_sampling_rate",
               "clearcoat_sampling_rate"]
THIN_RATES = ["diffuse_reflectance_sampling_rate", "diffuse_transmittance_sampling_rate",
              "specular_reflectance_sampling_rate", "specular_transmittance_sampling_rate"]
BSDFS = 40
DIRECTIONS = 8


def random_float(random, name, low, high):
    return '<float name="%s" value="%.3g"/>' % (name, random.uniform(low, high))


def random_bsdf(random, number):
    """Returns a plugin name and its parameters. Half of the BSDFs have most parameters, the others few, as in
    scenes. A tenth of the values are limits of the range."""
    plugin = "principled" if number % 2 else "principledthin"
    names = SOLID if plugin == "principled" else [*SHARES, "diff_trans"]
    has_most = random.uniform() < 0.5
    text = '<rgb name="base_color" value="%.3g %.3g %.3g"/>' % tuple(random.uniform(0, 1, 3))
    for name in names:
        if random.uniform() < (0.9 if has_most else 0.3):
            maximum = 2 if name == "diff_trans" else 1
            end = random.uniform() < 0.1
            value = maximum * (random.integers(2) if end else random.uniform())
            # Rounding errors dominate narrower lobes.
            if name == "roughness":
                value = max(value, 0.15)
            text += '<float name="%s" value="%.3g"/>' % (name, value)
    if plugin == "principledthin":
        if random.uniform() < 0.7:
            text += random_float(random, "eta", 0.7, 2.5)
    elif random.uniform() < 0.5:
        text += random_float(random, "eta", 0.6, 2.5)
    elif random.uniform() < 0.7:
        text += random_float(random, "specular", 0, 1)
    for name in SOLID_RATES if plugin == "principled" else THIN_RATES:
        if random.uniform() < 0.3:
            text += random_float(random, name, 0.2, 3)
    return plugin, text


def direction(random):
    v = random.normal(size=3)
    return [float(np.float32(x)) for x in v / np.linalg.norm(v)]


def number(x):
    text = "%.9g" % x
    return text + ("f" if any(c in text for c in ".e") else ".f")


def main():
    random = np.random.default_rng(11)
    context = mi.BSDFContext()
    bsdfs = [random_bsdf(random, i) for i in range(BSDFS)]
    print("// Made by make_principled_reference.py with Mitsuba %s, scalar_rgb." % mi.__version__)
    print("// clang-format off")
    print("constexpr const char* kPrincipledBsdfs[] = {")
    for plugin, children in bsdfs:
        print('    R"(<bsdf type="%s">%s</bsdf>)",' % (plugin, children))
    print("};")
    print("constexpr PrincipledValue kPrincipledValues[] = {")
    for index, (plugin, children) in enumerate(bsdfs):
        bsdf = mi.load_string('<bsdf version="3.0.0" type="%s">%s</bsdf>' % (plugin, children))
        for row in range(DIRECTIONS):
            wi, wo = direction(random), direction(random)
            # Most are seen from the front. A quarter of wo is near the mirror direction, and a quarter near the
            # direction straight through.
            if row % 4:
                wi[2] = abs(wi[2])
            if row % 4 < 2:
                side = 1 if row % 4 == 0 else -1
                near = np.array([-wi[0], -wi[1], side * wi[2]]) + 0.2 * np.array(wo)
                wo = [float(np.float32(x)) for x in near / np.linalg.norm(near)]
            si = mi.SurfaceInteraction3f()
            si.wi, si.uv = wi, [0.25, 0.25]
            si.n, si.dp_du, si.dp_dv = [0, 0, 1], [1, 0, 0], [0, 1, 0]
            si.sh_frame = mi.Frame3f([1, 0, 0], [0, 1, 0], [0, 0, 1])
            f = bsdf.eval(context, si, mi.Vector3f(*wo))
            pdf = bsdf.pdf(context, si, mi.Vector3f(*wo))
            print("    {%d, %s}," % (index, ", ".join(number(v) for v in [*wi, *wo, *f, pdf])))
    print("};")
    print("// clang-format on")


main()
