"""Scenes and points for tests of queries in the Python module, which must be importable."""
import kinome as mi

CTX = mi.BSDFContext()
SUN = [0.6, 0, 0.8]


def scene_of(**parts):
    return mi.load_dict({"type": "scene", **parts})


def interaction(wi):
    si = mi.SurfaceInteraction3f()
    si.wi = wi
    return si
