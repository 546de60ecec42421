"""Evaluation of BSDFs and emitters at surface points, and rays of sensors."""
import numpy as np

from . import _arguments as check
from ._interaction import (POINT, BSDFContext, BSDFFlags, BSDFSample3f, DirectionSample3f,
                           SurfaceInteraction3f, far, rays_from)
from ._rows import Rows
from ._vectors import Color3f, Point3f, Vector3f

NULL_SAMPLE = 2  # kNullSample of the compiled module


class _Bsdf:
    """Functions of BSDFs. `_editor` and `_path` are those of the BSDF; without a path, each point's own
    BSDF is used."""

    def _shade(self, ctx, si, active, u1=None, u2=None, wo=None):
        check.instance(ctx, "ctx", BSDFContext, "a BSDFContext()")
        check.instance(si, "si", SurfaceInteraction3f, POINT)
        arguments = {"wo": (wo, 3), "sample1": (u1, 1), "sample2": (u2, 2)}
        given = {name: pair for name, pair in arguments.items() if pair[0] is not None}
        rows = si._rows(**given)
        mask = rows.mask(active, random=["sample1", "sample2"])
        values = (rows[name] if name in given else None for name in arguments)
        result = self._editor.shade(self._path, si._points(rows), *values, ctx.lobes())
        return rows, mask, result

    def eval(self, ctx, si, wo, active=True):
        """Returns the BSDF times the cosine of wo. si.wi and wo are in the shading frame."""
        rows, mask, (f, *_) = self._shade(ctx, si, active, wo=wo)
        return rows.result(f, Color3f, mask)

    def pdf(self, ctx, si, wo, active=True):
        """Returns the density of sample() for wo, per solid angle."""
        rows, mask, (_, pdf, *_) = self._shade(ctx, si, active, wo=wo)
        return rows.result(pdf, mask=mask)

    def eval_pdf(self, ctx, si, wo, active=True):
        """Returns the values of eval() and pdf()."""
        rows, mask, (f, pdf, *_) = self._shade(ctx, si, active, wo=wo)
        return rows.result(f, Color3f, mask), rows.result(pdf, mask=mask)

    def sample(self, ctx, si, sample1, sample2, active=True):
        """Samples directions with the random numbers sample1 (n) and sample2 (n, 2). Returns a
        BSDFSample3f and the weights: BSDF times cosine, divided by the density."""
        rows, mask, (_, _, wo, weight, pdf, is_delta, eta) = self._shade(ctx, si, active, sample1,
                                                                         sample2)
        is_through = wo.reshape(-1, 3)[:, 2] * rows["wi"][:, 2] < 0
        kinds = np.where(is_through, BSDFFlags.DiffuseTransmission | BSDFFlags.GlossyTransmission,
                         BSDFFlags.DiffuseReflection | BSDFFlags.GlossyReflection)
        kinds = np.where(is_delta > 0, np.where(is_through, BSDFFlags.DeltaTransmission,
                                                BSDFFlags.DeltaReflection), kinds)
        kinds = np.where(is_delta == NULL_SAMPLE, BSDFFlags.Null, kinds)
        kinds = np.where(pdf > 0, kinds, 0).astype(np.uint32)
        sample = BSDFSample3f(rows.result(wo, Vector3f, mask), rows.result(pdf, mask=mask),
                              rows.result(eta, mask=mask), rows.result(kinds, mask=mask))
        return sample, rows.result(weight, Color3f, mask)

    def eval_diffuse_reflectance(self, si, active=True):
        """Returns the colour of the diffuse part, as the layer `albedo` of the integrator `aov`."""
        rows = check.instance(si, "si", SurfaceInteraction3f, POINT)._rows()
        mask = rows.mask(active)
        return rows.result(self._editor.albedo(self._path, si._points(rows)), Color3f, mask)


class _Emitter:
    """Functions of emitters. `_editor` and `_path` are those of the emitter; without a path, each
    point's own emitter is used, or the environment for points on no shape."""

    def _evaluate(self, si, it, active):
        check.instance(si, "si", SurfaceInteraction3f, POINT)
        check.instance(it, "it", SurfaceInteraction3f, POINT)
        rows = si._rows(it=(it.p, 3))
        mask = rows.mask(active)
        return rows, mask, self._editor.emission(self._path, si._points(rows), rows["it"])

    def eval(self, si, active=True):
        """Returns the radiance that leaves the points along si.wi, or that of the environment along
        -si.wi. Emitters at a point or of a single direction have none."""
        rows, mask, (radiance, _) = self._evaluate(si, si, active)
        return rows.result(radiance, Color3f, mask)

    def pdf_direction(self, it, ds, active=True):
        """Returns the density of sample_direction() per solid angle at it.p, for ds =
        DirectionSample3f(scene, si, it)."""
        rows, mask, (_, pdf) = self._evaluate(_point_of(ds), it, active)
        return rows.result(pdf, mask=mask)

    def eval_direction(self, it, ds, active=True):
        """Returns the radiance from the direction ds = DirectionSample3f(scene, si, it)."""
        check.instance(it, "it", SurfaceInteraction3f, POINT)
        return self.eval(_point_of(ds), active)


def _point_of(ds):
    check.instance(ds, "ds", DirectionSample3f, "a DirectionSample3f")
    if ds._si is None:
        raise ValueError("ds takes a DirectionSample3f(scene, si, ref); of sampled directions, "
                         "pdf is known already")
    return ds._si


class BSDFPtr(_Bsdf):
    """BSDFs of several points: evaluates each point's own."""

    def __init__(self, editor):
        self._editor, self._path = editor, ""

    def __repr__(self):
        return "BSDFPtr[each point's own BSDF]"


class EmitterPtr(_Emitter):
    """Emitters of several points: evaluates each point's own, or the environment."""

    def __init__(self, editor):
        self._editor, self._path = editor, ""

    def __repr__(self):
        return "EmitterPtr[each point's own emitter]"


def sample_emitters(editor, indices, it, u, active):
    """Samples directions from points to emitters. `indices` has that of each point's emitter in
    `editor.emitters()`. Returns a DirectionSample3f and the radiance divided by the density."""
    check.instance(it, "it", SurfaceInteraction3f, POINT)
    rows = Rows(p=(it.p, 3), sample=(u, 2))
    mask = rows.mask(active, random=["sample"])
    d, dist, pdf, radiance, is_delta = editor.sample_emitters(
        np.ascontiguousarray(np.broadcast_to(indices, rows.size), np.uint32), rows["p"],
        rows["sample"])
    ds = DirectionSample3f.__new__(DirectionSample3f)
    ds._si = None
    dist = np.where(np.isfinite(dist), dist, np.float32(far(editor)))
    ds.d, ds.dist, ds.pdf = rows.result(d, Vector3f), rows.result(dist), rows.result(pdf)
    ds.p = rows.result(rows["p"] + dist[:, None] * d.reshape(-1, 3), Point3f)
    ds.delta = rows.result(is_delta > 0)
    weight = radiance.reshape(-1, 3) / np.where(pdf > 0, pdf, 1)[:, None]
    return ds, rows.result(weight, Color3f, mask)


class Evaluated(_Bsdf, _Emitter):
    """Functions of objects that are BSDFs, emitters or sensors. Those of other kinds raise TypeError."""

    def _require(self, category, names):
        if self.category != category:
            raise TypeError(f"only {category}s have {names}; '{self._path}' is a {self.category}")

    def _shade(self, *arguments, **others):
        self._require("bsdf", "pdf(), eval_pdf() and sample()")
        return super()._shade(*arguments, **others)

    def _evaluate(self, *arguments):
        self._require("emitter", "pdf_direction() and eval_direction()")
        return super()._evaluate(*arguments)

    def eval(self, *arguments, **others):
        """Evaluates a BSDF, eval(ctx, si, wo, active=True), or an emitter, eval(si, active=True)."""
        if self.category not in ("bsdf", "emitter"):
            raise TypeError(f"only bsdfs and emitters have eval(); '{self._path}' is a "
                            f"{self.category}")
        kind = _Bsdf if self.category == "bsdf" else _Emitter
        return kind.eval(self, *arguments, **others)

    def eval_diffuse_reflectance(self, si, active=True):
        """Returns the colour of the diffuse part of a BSDF, as the layer `albedo` of `aov`."""
        self._require("bsdf", "eval_diffuse_reflectance()")
        return super().eval_diffuse_reflectance(si, active)

    def sample_direction(self, it, sample, active=True):
        """Samples directions from the points it.p to an emitter of a scene, with the random numbers
        `sample` (n, 2). Returns a DirectionSample3f and the radiance divided by its density."""
        self._require("emitter", "sample_direction()")
        paths = self._editor.emitters()
        if self._path not in paths:
            raise ValueError(f"'{self._path}' can't be sampled: it represents light of other emitters")
        ds, weight = sample_emitters(self._editor, paths.index(self._path), it, sample, active)
        ds.emitter = self
        return ds, weight

    def sample_ray(self, time=0, sample1=0, sample2=(0.5, 0.5), sample3=(0.5, 0.5), active=True):
        """Samples rays of a sensor through the positions sample2 (n, 2) in the crop window, from 0 to
        1, and the points sample3 (n, 2) of the lens. Returns a Ray3f and weights, which are 1."""
        self._require("sensor", "sample_ray()")
        rows = Rows(sample1=(sample1, 1), sample2=(sample2, 2), sample3=(sample3, 2), time=(time, 1))
        mask = rows.mask(active, random=["sample1", "sample3"])
        rays = self._editor.sample_rays(self._path, rows["sample2"], rows["sample3"])
        numbers = rays.reshape(-1, 8)[:, :7]
        has_none = ~np.isfinite(numbers).all(axis=1) | ~numbers[:, 4:7].any(axis=1)
        rows.refuse("sample2", has_none,
                    "positions that the sensor can see, from 0 to 1 in the crop window", mask)
        ray = rays_from(rows, rays)
        ray.time = rows.result(rows["time"])
        return ray, rows.result(np.ones(3 * rows.size, np.float32), Color3f, mask)
