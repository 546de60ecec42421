"""Queries of a scene by rays."""
import numbers

import numpy as np

from . import _arguments as check
from ._evaluation import BSDFPtr, EmitterPtr, sample_emitters
from ._interaction import POINT, SurfaceInteraction3f, rows_of_rays
from ._vectors import Color3f

OMITTED = object()  # default of an argument that may also be positional


def _hint(coherent):
    return bool(check.instance(coherent, "coherent", (bool, np.bool_), "a bool"))


class Queries:
    """Functions of a Scene that trace rays and sample emitters, with Mitsuba's names."""

    def ray_intersect(self, ray, ray_flags=None, coherent=False, active=True):
        """Finds the nearest hit of each ray. Returns a SurfaceInteraction3f. ray_flags is ignored,
        because all fields are computed. coherent: rays are neighbours, which is only a hint. The
        second positional argument can also be `active`, as in Mitsuba."""
        if isinstance(ray_flags, bool) or not isinstance(ray_flags, (numbers.Integral, type(None))):
            active = ray_flags
        rows, rays, factors = rows_of_rays(ray, self._editor.max_coordinate(), active)
        return SurfaceInteraction3f.of(rows, self, self._editor.intersect(rays, _hint(coherent)), factors)

    def ray_test(self, ray, *flags, coherent=False, active=OMITTED):
        """Returns True for each ray that hits something up to its maxt. Positional arguments after
        `ray` are (active) or (coherent, active), as in Mitsuba."""
        flags = list(flags)
        if active is OMITTED:
            active = flags.pop() if flags else True
        if flags:
            coherent = flags.pop()
        if flags:
            raise TypeError("ray_test() takes a ray, coherent and active, got more arguments")
        rows, rays, _ = rows_of_rays(ray, self._editor.max_coordinate(), active)
        return rows.result(self._editor.occluded(rays, _hint(coherent)) != 0)

    def sample_emitter_direction(self, ref, sample, test_visibility=True, active=True):
        """Samples directions from the points ref.p to emitters, each with the same probability, with
        the random numbers `sample` (n, 2). Returns a DirectionSample3f and the radiance divided by
        the density. Both this and ds.pdf are 0 if the emitter is hidden."""
        check.instance(ref, "ref", SurfaceInteraction3f, POINT)
        rows = ref._rows(sample=(sample, 2))
        mask = rows.mask(active, random=["sample"])
        paths = self._editor.emitters()
        count = len(paths)
        if count == 0:
            raise ValueError("the scene has no emitters")
        u = rows["sample"].copy()
        if mask is not None:
            u[~mask] = 0
        indices = np.minimum((u[:, 0] * count).astype(np.int64), count - 1)
        u[:, 0] = u[:, 0] * count - indices
        if rows.count is None:
            indices, u = indices[0], u[0]
        ds, weight = sample_emitters(self._editor, indices, ref, u, active)
        ds.emitter = np.array(self._at(paths), object)[indices]
        ds.pdf, weight = ds.pdf / count, weight * count
        if test_visibility:
            is_sampled = np.logical_and(active, ds.pdf > 0)
            is_hidden = self.ray_test(ref.spawn_ray_to(ds.p), is_sampled)
            weight = np.where(np.asarray(is_hidden)[..., None], np.float32(0), weight)
            ds.pdf = np.where(is_hidden, np.float32(0), ds.pdf)[()]
        return ds, weight.view(Color3f)

    def pdf_emitter_direction(self, ref, ds, active=True):
        """Returns the density of sample_emitter_direction() for ds = DirectionSample3f(scene, si,
        ref)."""
        check.instance(ref, "ref", SurfaceInteraction3f, POINT)
        return self._emitters_of_points().pdf_direction(ref, ds, active) / max(
            1, len(self._editor.emitters()))

    def eval_emitter_direction(self, ref, ds, active=True):
        """Returns the radiance from ds = DirectionSample3f(scene, si, ref)."""
        check.instance(ref, "ref", SurfaceInteraction3f, POINT)
        return self._emitters_of_points().eval_direction(ref, ds, active)

    def _bsdfs_of_points(self):
        return BSDFPtr(self._editor)

    def _emitters_of_points(self):
        return EmitterPtr(self._editor)

    def _hit_shapes(self, held):
        """Returns the shapes that SurfaceInteraction3f has by their indices."""
        return self._at(self._editor.hit_shapes(held))
