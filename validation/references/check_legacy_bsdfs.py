"""Checks legacy_bsdfs.py with Mitsuba's own chi² test, and compares values with the formulas.

    python3 -m venv v && v/bin/pip install mitsuba==3.9.1 numpy
    v/bin/python validation/references/check_legacy_bsdfs.py

Takes about a minute. Needs Debian's libllvm19. The exit status is 0 if all checks pass.
"""
import math
import sys

import environment

if not environment.use_llvm():
    sys.exit("check_legacy_bsdfs.py: libLLVM 19 not found: apt-get install libllvm19")
import drjit as dr  # noqa: E402
import mitsuba as mi  # noqa: E402
import numpy as np  # noqa: E402

mi.set_variant("llvm_ad_rgb")
import legacy_bsdfs  # noqa: E402

ALPHA = 0.01  # false-alarm rate of all chi² tests together: Mitsuba's tool applies Šidák's rule
INCIDENT = [(0, 0, 1), (0.6, 0.1, 0.7), (-0.8, 0.5, 0.3)]
# First only the lobe, because a diffuse base would hide its errors; then two mixtures.
LOBE = {"diffuse_reflectance": 0.0}
CASES = [("phong", LOBE | {"exponent": n}) for n in (1.0, 30.0, 300.0)] + [
    ("ward", LOBE | {"variant": v, "alpha_u": au, "alpha_v": av})
    for v in legacy_bsdfs.VARIANTS for au, av in ((0.15, 0.15), (0.1, 0.4))] + [
    ("phong", {"exponent": 12.0}), ("ward", {"alpha": 0.3})]


def incident(x, y, z):
    return dr.normalize(mi.ScalarVector3f(x, y, z))


def chi2(kind, parameters, wi, count):
    # A narrow lobe needs this fine grid: with 101 rows, the integral over a cell is too coarse.
    xml = "".join(f'<{"string" if isinstance(v, str) else "float"} name="{k}" value="{v}"/>'
                  for k, v in parameters.items())
    sample, pdf = mi.chi2.BSDFAdapter(kind, xml, wi=wi)
    test = mi.chi2.ChiSquareTest(domain=mi.chi2.SphericalDomain(), sample_func=sample, pdf_func=pdf,
                                 sample_dim=3, res=201, ires=16, sample_count=1000000)
    passed = test.run(1 - (1 - ALPHA) ** (1 / count), quiet=True)
    return passed, test.p_value


def value(kind, parameters, wi, wo):
    bsdf = mi.load_dict({"type": kind, **parameters})
    si = dr.zeros(mi.SurfaceInteraction3f)
    si.wi = mi.Vector3f(wi)
    return np.array(bsdf.eval(mi.BSDFContext(), si, mi.Vector3f(wo))).ravel()


def by_hand():
    """Yields (name, value by Mitsuba, value by the formula), for one pair of directions each."""
    wi, wo = incident(0.3, 0.2, 0.8), incident(-0.1, -0.25, 0.9)
    h = [a + b for a, b in zip(wi, wo)]
    h2 = sum(x * x for x in h)
    mirrored = -wi[0] * wo[0] - wi[1] * wo[1] + wi[2] * wo[2]
    yield "phong", value("phong", {"exponent": 30.0}, wi, wo)[0], \
        wo[2] * (0.5 / math.pi + 0.2 * 32 / (2 * math.pi) * mirrored ** 30)
    gauss = math.exp(-((h[0] / 0.1) ** 2 + (h[1] / 0.4) ** 2) / h[2] ** 2)
    factors = {"balanced": h2 / (math.pi * 0.04 * h[2] ** 4),
               "ward": 1 / (4 * math.pi * 0.04 * math.sqrt(wi[2] * wo[2])),
               "ward-duer": 1 / (4 * math.pi * 0.04 * wi[2] * wo[2])}
    for variant, c in factors.items():
        parameters = {"variant": variant, "alpha_u": 0.1, "alpha_v": 0.4}
        yield variant, value("ward", parameters, wi, wo)[0], \
            wo[2] * (0.5 / math.pi + 0.2 * c * gauss)
    bright = {"diffuse_reflectance": 0.9, "specular_reflectance": 0.6, "exponent": 30.0}
    yield "phong, scaled", value("phong", bright, wi, wo)[0], \
        0.66 * wo[2] * (0.9 / math.pi + 0.6 * 32 / (2 * math.pi) * mirrored ** 30)
    yield "from behind", value("phong", {}, [0, 0, -1], wo)[0], 0.0
    yield "to behind", value("ward", {}, wi, [0, 0.6, -0.8])[0], 0.0


def main():
    legacy_bsdfs.register()
    failures = 0
    count = len(CASES) * len(INCIDENT)
    for kind, parameters in CASES:
        for direction in INCIDENT:
            passed, p = chi2(kind, parameters, incident(*direction), count)
            failures += not passed
            print(f"{'pass' if passed else 'FAIL'}  chi² {kind} {parameters} wi {direction}: "
                  f"p = {p:.3g}", flush=True)
    for name, got, expected in by_hand():
        passed = abs(got - expected) <= 2e-5 * abs(expected)  # single precision, exponents of 30
        failures += not passed
        print(f"{'pass' if passed else 'FAIL'}  {name}: {got:.7g}, by hand {expected:.7g}")
    print(f"{failures} failed")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
