"""Prints tests/plugins/bsdfs/bsdf_reference.inc: values of Mitsuba 3's BSDFs at random directions.

    python3 -m venv v && v/bin/pip install mitsuba==3.9.1 numpy
    v/bin/python tests/plugins/bsdfs/make_bsdf_reference.py > tests/plugins/bsdfs/bsdf_reference.inc

Each row: index of the BSDF, wi, wo, f cos(theta_o) in R, G, B, and the density of sampling.
"""
import pathlib
import re
import tempfile

import mitsuba as mi
import numpy as np

mi.set_variant("scalar_rgb")

NORMAL = r"\{normal:(.*?)\}"
COLOR = '<rgb name="diffuse_reflectance" value="0.2 0.3 0.9"/>'
SOURCE = str(pathlib.Path(__file__).resolve().parents[2])
BUMPS = ('<texture type="bitmap"><string name="filename" value="{source}/tests/support/bumps.pfm"/>'
         '<boolean name="raw" value="true"/>%s</texture>')
GGX = '<string name="distribution" value="ggx"/>'


def checkerboard(rgb):
    """Returns a map of one normal for Kinome's test."""
    return (
        '<texture type="checkerboard" name="normalmap">'
        f'<rgb name="color0" value="{rgb}"/><rgb name="color1" value="0.5 0.5 1"/></texture>'
    )


def bitmap(rgb, folder):
    """Returns the same map for Mitsuba, whose checkerboard has no three-channel lookup."""
    texel = np.array([float(x) for x in rgb.split()], np.float32)
    path = folder + "/normals.exr"
    mi.Bitmap(np.tile(texel, (2, 2, 1))).write(path)
    return (
        f'<texture type="bitmap" name="normalmap"><string name="filename" value="{path}"/>'
        '<boolean name="raw" value="true"/></texture>'
    )


BSDFS = [
    ("diffuse", '<rgb name="reflectance" value="0.2 0.3 0.4"/>'),
    ("plastic", COLOR),
    ("plastic", COLOR + '<boolean name="nonlinear" value="true"/>'
                        '<string name="int_ior" value="water"/>'),
    ("roughplastic", COLOR),
    ("roughplastic", COLOR + GGX + '<float name="alpha" value="0.3"/>'
                                   '<boolean name="nonlinear" value="true"/>'
                                   '<float name="specular_reflectance" value="0.7"/>'
                                   '<float name="int_ior" value="1.8"/>'),
    ("roughconductor", '<string name="material" value="Au"/><float name="alpha" value="0.3"/>'),
    ("roughconductor", GGX + '<string name="material" value="W"/>'
                             '<float name="alpha_u" value="0.2"/><float name="alpha_v" value="0.6"/>'),
    ("roughconductor", '<rgb name="eta" value="1.5 1 0.2"/><rgb name="k" value="0 1 3"/>'
                       '<float name="alpha_u" value="0.7"/><float name="alpha_v" value="0.3"/>'
                       '<boolean name="sample_visible" value="false"/>'),
    ("twosided", '<bsdf type="diffuse"/><bsdf type="roughconductor">'
                 '<float name="alpha" value="0.4"/><string name="material" value="Cr"/></bsdf>'),
    ("normalmap", "{normal:0.75 0.6 0.9}"'<bsdf type="diffuse"/>'),
    ("normalmap", "{normal:0.1 0.45 0.7}" '<bsdf type="twosided"><bsdf type="roughconductor">' + GGX +
     '<float name="alpha_u" value="0.2"/><float name="alpha_v" value="0.6"/></bsdf></bsdf>'),
    ("roughdielectric", '<rgb name="specular_transmittance" value="0.9 0.6 0.3"/>'
                        '<float name="alpha" value="0.3"/>'),
    ("roughdielectric", GGX + '<float name="alpha_u" value="0.2"/><float name="alpha_v" value="0.6"/>'
                              '<rgb name="specular_reflectance" value="0.2 0.6 0.9"/>'),
    ("roughdielectric", GGX + '<boolean name="sample_visible" value="false"/>'
                              '<float name="alpha" value="0.5"/><float name="int_ior" value="1"/>'
                              '<string name="ext_ior" value="water"/>'),
    ("roughdielectric", '<boolean name="sample_visible" value="false"/>'
                        '<string name="int_ior" value="diamond"/><float name="alpha" value="0.4"/>'),
    ("bumpmap", BUMPS % "" + '<float name="scale" value="0.4"/><bsdf type="diffuse"/>'),
    ("bumpmap", BUMPS % '<transform name="to_uv"><scale x="-1.5" y="0.7"/></transform>' +
     '<float name="scale" value="-0.8"/><bsdf type="twosided"><bsdf type="roughconductor">' + GGX +
     '<float name="alpha_u" value="0.2"/><float name="alpha_v" value="0.6"/></bsdf></bsdf>'),
    ("bumpmap", BUMPS % "" + '<boolean name="use_shadowing_function" value="false"/>'
     '<bsdf type="roughplastic"><float name="alpha" value="0.3"/></bsdf>'),
    ("hair", ""),
    ("hair", '<rgb name="sigma_a" value="0.02 0.1 0.3"/><float name="scale" value="2"/>'
             '<float name="longitudinal_roughness" value="0.5"/>'
             '<float name="azimuthal_roughness" value="0.6"/>'
             '<float name="scale_tilt" value="-4"/><string name="int_ior" value="water"/>'),
    ("hair", '<float name="eumelanin" value="0.2"/><float name="pheomelanin" value="0.4"/>'
             '<float name="longitudinal_roughness" value="0.8"/>'),
]


def direction(random):
    v = random.normal(size=3)
    return [float(np.float32(x)) for x in v / np.linalg.norm(v)]


def number(x):
    text = "%.9g" % x
    return text + ("f" if any(c in text for c in ".e") else ".f")


def main():
    random = np.random.default_rng(4)
    context = mi.BSDFContext()
    print("// Made by make_bsdf_reference.py with Mitsuba %s, scalar_rgb." % mi.__version__)
    print("// clang-format off")
    print("constexpr const char* kReferenceBsdfs[] = {")
    for plugin, children in BSDFS:
        ours = re.sub(NORMAL, lambda m: checkerboard(m[1]), children)
        print('    R"(<bsdf type="%s">%s</bsdf>)",' % (plugin, ours))
    print("};")
    print("constexpr ReferenceValue kReferenceValues[] = {")
    for index, (plugin, children) in enumerate(BSDFS):
        with tempfile.TemporaryDirectory() as folder:
            theirs = re.sub(NORMAL, lambda m: bitmap(m[1], folder), children)
            theirs = theirs.replace("{source}", SOURCE)
            bsdf = mi.load_string('<bsdf version="3.0.0" type="%s">%s</bsdf>' % (plugin, theirs))
        rows = 0
        while rows < 12:
            wi, wo = direction(random), direction(random)
            # A quarter is near the mirror direction, the rest anywhere.
            if rows % 4 == 0:
                near = np.array([-wi[0], -wi[1], wi[2]]) + 0.1 * np.array(wo)
                wo = [float(np.float32(x)) for x in near / np.linalg.norm(near)]
            si = mi.SurfaceInteraction3f()
            si.wi, si.uv = wi, [0.25, 0.25]
            si.n, si.dp_du, si.dp_dv = [0, 0, 1], [1, 0, 0], [0, 1, 0]
            si.sh_frame = mi.Frame3f([1, 0, 0], [0, 1, 0], [0, 0, 1])
            f = bsdf.eval(context, si, mi.Vector3f(*wo))
            pdf = bsdf.pdf(context, si, mi.Vector3f(*wo))
            if max(f) == 0 and rows % 12 != 11:
                continue
            values = [*wi, *wo, *f, pdf]
            print("    {%d, %s}," % (index, ", ".join(number(v) for v in values)))
            rows += 1
    print("};")
    print("// clang-format on")


main()
