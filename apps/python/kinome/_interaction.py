"""Rays, and the points and directions that queries return, with Mitsuba's names."""
import enum
import operator

import numpy as np

from . import _arguments as check
from . import _kinome
from ._rows import Rows
from ._vectors import BoundingBox3f, Frame3f, Normal3f, Point3f, Vector3f

NO_SHAPE = np.uint32(2 ** 32 - 1)
POINT = "a SurfaceInteraction3f"  # in messages
MODERATE_EXPONENT = 20  # of the length of directions that are traced as they are


class Ray3f:
    """Rays with the origins o and directions d, up to the distances maxt in units of d. Each is a
    single one, or an array with a row per ray."""

    def __init__(self, o=(0, 0, 0), d=(0, 0, 1), *rest, maxt=np.inf, time=0, wavelengths=()):
        """Ray3f(ray) copies a ray. Positional arguments after d are (time, wavelengths) or (maxt,
        time, wavelengths), as in Mitsuba. Wavelengths are ignored."""
        if isinstance(o, Ray3f):
            self.o, self.d, self.maxt, self.time = o.o, o.d, o.maxt, o.time
            return
        if len(rest) == 3:
            maxt, time, _ = rest
        elif rest:
            time = rest[0]
        rows = Rows(o=(o, 3), d=(d, 3), maxt=(maxt, 1), time=(time, 1))
        self.o = rows.result(rows["o"], Point3f)
        self.d = rows.result(rows["d"], Vector3f)
        self.maxt, self.time = rows.result(rows["maxt"]), rows.result(rows["time"])

    def __call__(self, t):
        """Returns the points at the distances t."""
        rows = Rows(o=(self.o, 3), d=(self.d, 3), t=(t, 1))
        return rows.result(rows["o"] + rows["t"][:, None] * rows["d"], Point3f)

    def __repr__(self):
        if self.o.ndim == 2:
            return f"Ray3f[{len(self.o)} rays]"
        return f"Ray3f[o={self.o.tolist()}, d={self.d.tolist()}, maxt={self.maxt}]"


def rows_of_rays(ray, max_coordinate, active=True):
    """Returns Rows, the rays in the compiled module's form, and the factors by which their distances must
    be multiplied. Inactive rays have an empty range. `max_coordinate` is the largest one of origins."""
    check.instance(ray, "ray", Ray3f, "a Ray3f")
    rows = Rows(o=(ray.o, 3), d=(ray.d, 3), maxt=(ray.maxt, 1))
    rays = np.zeros((rows.size, 8), np.float32)
    mask = rows.mask(active, endless=["maxt"])
    rows.check_range("o", -max_coordinate, max_coordinate,
                     f"coordinates up to {max_coordinate:.3g}, the range of the ray tracer", mask)
    d, maxt, factors = _of_moderate_length(rows["d"], rows["maxt"])
    rays[:, :3], rays[:, 4:7], rays[:, 7] = rows["o"], d, maxt
    if mask is not None:
        rays[~mask, 7] = -1
    return rows, rays, factors


def _of_moderate_length(d, maxt):
    """Scales very long and very short directions. Returns directions, maxima of t, and the factors by
    which t must be multiplied. The factors are powers of two, so that nothing is rounded."""
    length = np.abs(d).max(axis=1)
    exponents = np.frexp(length)[1]
    exponents = np.where((np.abs(exponents) > MODERATE_EXPONENT) & np.isfinite(length), exponents, 0)
    if not exponents.any():
        return d, maxt, np.float32(1)
    with np.errstate(over="ignore", under="ignore"):
        return (np.ldexp(d, -exponents[:, None]), np.ldexp(maxt, exponents),
                np.ldexp(np.float32(1), -exponents))


def rays_from(rows, rays):
    """Returns the Ray3f of rays in the compiled module's form. Rays begin at their minimum t."""
    rays = rays.reshape(-1, 8)
    near = rays[:, 3]
    ray = Ray3f.__new__(Ray3f)
    ray.o = rows.result(rays[:, :3] + near[:, None] * rays[:, 4:7], Point3f)
    ray.d = rows.result(np.ascontiguousarray(rays[:, 4:7]), Vector3f)
    with np.errstate(invalid="ignore"):  # of inactive rows
        ray.maxt = rows.result(rays[:, 7] - near)
    ray.time = rows.result(np.zeros(len(rays), np.float32))
    return ray


class SurfaceInteraction3f:
    """Points of surfaces, seen along rays. Without arguments: one point that is on no shape, whose
    fields can be set, each to a single value or to an array with a row per point."""

    def __init__(self):
        self.t, self.time, self.wavelengths = np.inf, 0., ()
        self.p, self.n = Point3f(0), Normal3f(0, 0, 1)
        self.sh_frame = Frame3f([1, 0, 0], [0, 1, 0], [0, 0, 1])
        self.dp_du, self.dp_dv = Vector3f(1, 0, 0), Vector3f(0, 1, 0)
        self.wi, self.uv = Vector3f(0), np.zeros(2)
        self._error, self._primitive, self._index = 0., np.zeros(1, np.uint32), NO_SHAPE[None]
        self._scene = self._held = None

    @classmethod
    def of(cls, rows, scene, fields, factors):
        """Returns the result of a query of a Scene, from the compiled module's arrays. `factors` are those
        of rows_of_rays()."""
        si = cls.__new__(cls)
        si._scene, si.wavelengths = scene, ()
        si._held, t, p, n, s, tangent, normal, dp_du, dp_dv, wi, uv, error, primitive, index = fields
        with np.errstate(over="ignore", under="ignore"):
            si.t = rows.result(np.asarray(t) * factors)
        si._error = rows.result(error)
        si.time = rows.result(np.zeros(rows.size, np.float32))
        si.p, si.n = rows.result(p, Point3f), rows.result(n, Normal3f)
        si.sh_frame = Frame3f.of(rows.result(s, Vector3f), rows.result(tangent, Vector3f),
                                 rows.result(normal, Normal3f))
        si.dp_du, si.dp_dv = rows.result(dp_du, Vector3f), rows.result(dp_dv, Vector3f)
        si.wi = rows.result(wi, Vector3f)
        si.uv = uv if rows.count is None else uv.reshape(-1, 2)
        si._primitive, si._index = primitive, index
        return si

    def is_valid(self):
        """Returns True where a ray hit a surface."""
        valid = np.isfinite(self.t)
        return bool(valid) if np.ndim(valid) == 0 else valid

    @property
    def prim_index(self):
        """Index of the triangle or other part of the shape."""
        return int(self._primitive[0]) if np.ndim(self.t) == 0 else self._primitive

    @property
    def shape(self):
        """The shape, or None; an array of them if there are several points."""
        if self._scene is None:
            return None
        shapes = np.array([*self._scene._hit_shapes(self._held), None], object)
        found = shapes[np.minimum(self._index, len(shapes) - 1)]
        return found[0] if np.ndim(self.t) == 0 else found

    def to_world(self, v):
        """Converts directions from the shading frame to the world."""
        return self.sh_frame.to_world(v)

    def to_local(self, v):
        """Converts directions from the world to the shading frame."""
        return self.sh_frame.to_local(v)

    def _rows(self, **others):
        """Returns Rows of this object's fields and of other arguments."""
        frame = self.sh_frame
        return Rows(p=(self.p, 3), n=(self.n, 3), sh_s=(frame.s, 3), sh_t=(frame.t, 3),
                    sh_n=(frame.n, 3), dp_du=(self.dp_du, 3), dp_dv=(self.dp_dv, 3),
                    wi=(self.wi, 3), uv=(self.uv, 2), error=(self._error, 1), **others)

    def _points(self, rows):
        """Returns the points in the compiled module's form."""
        names = ("p", "n", "sh_s", "sh_t", "sh_n", "dp_du", "dp_dv", "wi", "uv", "error")
        indices = (np.ascontiguousarray(np.broadcast_to(index, rows.size))
                   for index in (self._primitive, self._index))
        return (self._held, *(rows[name] for name in names), *indices)

    def spawn_ray(self, d):
        """Returns rays that leave the points toward d, with origins off the surface."""
        rows = self._rows(d=(d, 3))
        o = _kinome.spawn_origins(rows["p"], rows["n"], rows["error"], rows["d"])
        return Ray3f(rows.result(o, Point3f), rows.result(rows["d"], Vector3f))

    def spawn_ray_to(self, to):
        """Returns rays that leave the points and end just before others. They have unit directions."""
        rows = self._rows(to=(to, 3))
        return rays_from(rows, _kinome.shadow_rays(rows["p"], rows["n"], rows["error"], rows["to"]))

    def bsdf(self, ray=None):
        """Returns the BSDFs of the points, as one object that evaluates each point's own."""
        if self._scene is None:
            raise ValueError("this point is on no shape; call the functions of a BSDF")
        return self._scene._bsdfs_of_points()

    def emitter(self, scene, active=True):
        """Returns the emitters at the points, as one object that evaluates each point's own: that of
        its shape, or the environment without a shape."""
        return check.scene(scene, "scene")._emitters_of_points()

    def __repr__(self):
        if np.ndim(self.t) > 0:
            return f"SurfaceInteraction3f[{len(self.t)} points, {np.sum(self.is_valid())} valid]"
        return (f"SurfaceInteraction3f[t={self.t:.6g}, p={self.p.tolist()}, n={self.n.tolist()}, "
                f"uv={self.uv.tolist()}, shape={self.shape and self.shape.id()!r}]")


class TransportMode(enum.Enum):
    """Quantity that paths carry. Kinome's BSDFs are those of radiance."""
    Radiance = 0
    Importance = 1


class BSDFFlags(enum.IntFlag):
    """Kinds of reflection and transmission, with Mitsuba's values."""
    Empty = 0
    Null = 0x1
    DiffuseReflection = 0x2
    DiffuseTransmission = 0x4
    GlossyReflection = 0x8
    GlossyTransmission = 0x10
    DeltaReflection = 0x20
    DeltaTransmission = 0x40
    Diffuse = 0x6
    Glossy = 0x18
    Smooth = 0x1e
    Delta = 0x61
    All = 0x7f


class BSDFContext:
    """Restricts BSDFs to some kinds of reflection and transmission. type_mask is a sum of
    BSDFFlags.Diffuse, Glossy and Delta. mode and component have Mitsuba's defaults, and can't be
    changed."""

    __slots__ = ("mode", "type_mask", "component")

    def __init__(self, mode=TransportMode.Radiance, type_mask=BSDFFlags.All, component=-1):
        self.mode, self.type_mask, self.component = mode, type_mask, component

    def lobes(self):
        """Returns the bits of the compiled module. The fields can be set, so this checks them."""
        if self.mode is not TransportMode.Radiance:
            raise check.fault(ValueError, "mode", "TransportMode.Radiance", self.mode)
        if self.component not in (-1, 2 ** 32 - 1):
            raise check.fault(ValueError, "component", "-1, which is all components", self.component)
        takes = "a sum of BSDFFlags.Diffuse, Glossy and Delta"
        try:
            mask = operator.index(self.type_mask) & int(BSDFFlags.All)
        except TypeError:
            raise check.fault(TypeError, "type_mask", takes, self.type_mask) from None
        lobes = 0
        for bit, kind in ((1, BSDFFlags.Diffuse), (2, BSDFFlags.Glossy), (4, BSDFFlags.Delta)):
            if mask & int(kind) == int(kind):
                lobes |= bit
            elif mask & int(kind):
                raise check.fault(ValueError, "type_mask", takes, self.type_mask)
        return lobes

    def __repr__(self):
        return f"BSDFContext[type_mask={self.type_mask!r}]"


class BSDFSample3f:
    """Directions that a BSDF sampled: wo in the shading frame, pdf per solid angle (1 for BSDFFlags.
    Delta), eta, and sampled_type."""

    def __init__(self, wo, pdf, eta, sampled_type):
        self.wo, self.pdf, self.eta, self.sampled_type = wo, pdf, eta, sampled_type
        self.sampled_component = 0

    def __repr__(self):
        if np.ndim(self.pdf) > 0:
            return f"BSDFSample3f[{len(self.pdf)} samples]"
        return f"BSDFSample3f[wo={self.wo.tolist()}, pdf={self.pdf:.6g}, eta={self.eta:.6g}]"


def far(editor):
    """Returns the distance that stands for infinity, as in Mitsuba: the scene's diameter."""
    box = BoundingBox3f.of(editor.bounds(""))
    return np.linalg.norm(box.extents()) if box.valid() else 1.


class DirectionSample3f:
    """Directions d from reference points to points p of emitters, at the distances dist.
    DirectionSample3f(scene, si, ref) has those of surface points that rays from `ref` hit, or of the
    environment if they hit nothing."""

    def __init__(self, scene, si, ref):
        self._si = si
        check.scene(scene, "scene")
        check.instance(si, "si", SurfaceInteraction3f, POINT)
        check.instance(ref, "ref", SurfaceInteraction3f, POINT)
        rows = si._rows(ref=(ref.p, 3), t=(si.t, 1), world=(si.to_world(si.wi), 3))
        valid = np.isfinite(rows["t"])
        apart = np.where(valid[:, None], rows["p"] - rows["ref"], -rows["world"])
        length = np.linalg.norm(apart, axis=1)
        d = (apart / np.where(length > 0, length, 1)[:, None]).astype(np.float32)
        dist = np.where(valid, length, far(scene._editor)).astype(np.float32)
        self.d, self.dist = rows.result(d, Vector3f), rows.result(dist)
        self.p = rows.result(rows["ref"] + dist[:, None] * d, Point3f)
        self.pdf = rows.result(np.zeros(rows.size, np.float32))
        self.delta = rows.result(np.zeros(rows.size, bool))
        self.emitter = scene._emitters_of_points()

    def __repr__(self):
        if np.ndim(self.pdf) > 0:
            return f"DirectionSample3f[{len(self.pdf)} directions]"
        return (f"DirectionSample3f[d={self.d.tolist()}, p={self.p.tolist()}, dist={self.dist:.6g}, "
                f"pdf={self.pdf:.6g}]")

