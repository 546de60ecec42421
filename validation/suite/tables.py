"""Data of all comparisons: scenes, our integrators, Mitsuba's configurations. Another one is one line."""
import dataclasses
import pathlib

ROOT = pathlib.Path(__file__).resolve().parents[2]
THREADS = 2  # of each renderer

ENVIRONMENT = "environment"
BOUNCE = "one bounce"
PLAIN = "nothing to learn"
HARD = "hard"
AREA = "area lights"
TOGETHER = "sky and lamps"
DEEP = "any number of bounces"
# Words of the command line for groups of scenes.
GROUP_WORDS = {"environment": ENVIRONMENT, "hard": HARD, "bounce": BOUNCE, "plain": PLAIN,
               "area": AREA, "together": TOGETHER, "deep": DEEP}
ALL_WORD = "all"  # all scenes of SCENES


@dataclasses.dataclass(frozen=True)
class Scene:
    """A scene with a variable size.

    truth: integrator of Mitsuba's reference. peers: Mitsuba's integrators that are timed.
    truth_factor: factor of the number of renders of the reference, if Mitsuba hardly finds the light.
    timed_share: share of the samples of that reference that suffices for timed images.

    With these values, the relMSE of the reference itself is one of these: at most about 1e-5, the error to
    which slopes are measured; 2e-5 to 1e-4; or 4e-4 to 2e-3, if 1e-4 would take most of an hour. Errors can be
    distinguished down to half of it.
    """

    name: str
    file: str
    group: str
    size: tuple
    truth: str
    peers: tuple
    envmap: bool = False  # has the parameter $mis_compensation
    cycles: bool = False  # Cycles supports all its materials
    asked: bool = False  # used only if the scene or its group is given
    truth_factor: int = 1
    truth_compensated: bool = False  # renders the reference with mis_compensation, for less noise
    timed_share: float = 1 / 2
    max_depth: int | None = None  # of measured paths; None: that of the file

    @property
    def path(self):
        return ROOT / self.file

    def depth(self, integrator):
        """Returns the parameter that limits the depth. `direct` has no such parameter."""
        limited = self.max_depth is not None and integrator != "direct"
        return {"max_depth": self.max_depth} if limited else {}


SCENES = (
    Scene("hebe", "scenes/hebe/scene.xml", ENVIRONMENT, (128, 128), "direct", ("direct", "path"),
          envmap=True, max_depth=2),
    Scene("car", "scenes/car/scene.xml", ENVIRONMENT, (160, 90), "direct", ("direct", "path"),
          envmap=True, max_depth=2),
    Scene("grace", "scenes/grace/scene.xml", ENVIRONMENT, (128, 96), "direct", ("direct", "path"),
          envmap=True, timed_share=1 / 4, max_depth=2),
    Scene("box", "scenes/box/scene.xml", BOUNCE, (96, 72), "path", ("path", "ptracer"),
          max_depth=3),
    Scene("plate", "scenes/plate/scene.xml", BOUNCE, (96, 72), "path", ("path", "ptracer"),
          timed_share=1, max_depth=3),
    Scene("blocks", "validation/scenes/benchmark/blocks.xml", PLAIN, (128, 96), "direct",
          ("direct", "path"), cycles=True, timed_share=1 / 8),
    *(Scene(name, f"scenes/{name}/scene.xml", group, size, "direct", ("direct", "path"),
            envmap=True, asked=True, truth_factor=4 if name == "room" else 1,
            truth_compensated=compensated, timed_share=share, max_depth=2)
      for name, group, size, compensated, share in (
          ("colonnade", ENVIRONMENT, (96, 72), False, 1 / 2),
          ("heap", ENVIRONMENT, (96, 72), True, 1 / 2),
          ("room", ENVIRONMENT, (96, 72), True, 1 / 2),
          ("vases", ENVIRONMENT, (96, 72), True, 1 / 2),
          ("chess", ENVIRONMENT, (96, 72), True, 1 / 2),
          ("cobbles", ENVIRONMENT, (96, 72), True, 1 / 2),
          ("reeds", HARD, (96, 72), False, 1 / 2), ("sponge", HARD, (96, 72), True, 1 / 4),
          ("tree", HARD, (96, 96), True, 1 / 2), ("focus", HARD, (96, 72), False, 1 / 2),
          ("hammered", HARD, (96, 72), True, 1 / 2), ("mirror", PLAIN, (96, 72), False, 1 / 16),
          ("noon", PLAIN, (96, 72), True, 1 / 16))),
    Scene("ball", "validation/scenes/benchmark/ball.xml", PLAIN, (96, 72), "direct",
          ("direct", "path"), asked=True, timed_share=1 / 8),
    *(Scene(name, f"validation/scenes/benchmark/{name}.xml", BOUNCE, (96, 72), "path",
            ("path", "ptracer"), asked=True, truth_factor=factor, timed_share=share)
      for name, factor, share in (("corridor", 1, 1), ("stage", 4, 1 / 2), ("attic", 4, 1 / 2))),
    Scene("penumbra", "validation/scenes/benchmark/penumbra.xml", AREA, (96, 72), "direct",
          ("direct", "path"), asked=True),
    Scene("lamps", "scenes/lamps/scene.xml", AREA, (96, 72), "direct", ("direct", "path"),
          asked=True, max_depth=2),
    Scene("evening", "validation/scenes/benchmark/evening.xml", TOGETHER, (96, 72), "path",
          ("path", "ptracer"), asked=True),
    Scene("sunroom", "scenes/sunroom/scene.xml", DEEP, (96, 72), "path", ("path",), envmap=True,
          asked=True, timed_share=1),
    Scene("kitchen", "scenes/kitchen/scene.xml", DEEP, (96, 72), "path", ("path",), asked=True,
          timed_share=1),
)


# Scenes of `media`, with the goal for Mitsuba's time divided by that of `clustered` to equal error.
MEDIA_GOALS = {"mist": 5, "haze": 5, "beam": 5, "lanterns": 20, "cloud": 3, "wax": 5, "smoke": None,
               "milk": None}
MEDIA_SCENES = tuple(Scene(name, f"scenes/{name}/scene.xml", "media", (96, 72), "volpath",
                           ("volpath", "volpathmis")) for name in MEDIA_GOALS)


def explanation(row):
    """Returns the known cause of a failed comparison, or "" if there is none or the comparison passed."""
    cause = EXPLAINED.get((row["scene"], row["method"]))
    if row["passed"] or not cause:
        return ""
    red = [test for test in row["tests"].values() if not test["passed"]]
    known = all(abs(test["t"]) <= cause.tests.get(test["name"], 0) for test in red)
    return cause.text if known and red else ""


def chosen(names, effort):
    """Returns the big scenes of these names; without names, the default scenes of the effort."""
    return [s for s in SCENES if s.name in (names or effort.big_scenes)]


def named(words):
    """Returns the names of scenes for words of the command line. Replaces groups by their scenes."""
    return list(dict.fromkeys(name for word in words for name in (
        [s.name for s in SCENES if word == ALL_WORD or s.group == GROUP_WORDS[word]]
        if word in (ALL_WORD, *GROUP_WORDS) else [word])))


# The other small scenes contain a fixed integrator. Only the test `references` uses them.
SMALL_SCENES = tuple(path for path in sorted((ROOT / "validation/scenes").glob("*.xml"))
                     if '<integrator type="$integrator"/>' in path.read_text(encoding="utf-8"))
# Small scenes with media, which give parameters to their integrator. They are compared, but not timed.
SMALL_MEDIA = tuple(sorted((ROOT / "validation/scenes").glob("media_*.xml")))
MEDIA_INTEGRATORS = ("volpath", "clustered")

# Parts of the engine's benchmark, which are words of the command line, and their scenes.
ENGINE_PARTS = ("product", "threads", "memory", "short", "isa", "plugin", "watertight", "direct",
                "path")
HEBE = "hebe"
PLUGIN_SCENE = "sponge"  # has only diffuse surfaces
SHORT_SCENES = ("blocks", "noon", "ball", "mirror")
ISA_SCENES = ("hebe", "sponge", "ball", "penumbra")
WATERTIGHT_SCENES = ("hebe", "tree", "room", "attic")
ISAS = ("x86-64-v4", "x86-64-v3", "x86-64-v2")  # AVX-512, AVX2, and the baseline SSE4.2
WITHOUT_PEER = ("phong", "ward_balanced", "ward_duer")  # Mitsuba 3 lacks these BSDFs


@dataclasses.dataclass(frozen=True)
class Method:
    """One of our integrators.

    truth: the reference, "mitsuba" or "groundtruth" (with the same light points).
    samples: timed sample counts per pixel.
    any_light: also compared in small scenes whose reference is direct light.
    check_factor: factor of the number of samples for comparisons. It must be large enough that each tile
    gets some of the rare bright paths.
    """

    name: str
    defines: dict
    truth: str
    groups: tuple
    samples: tuple
    any_light: bool = False
    check_factor: int = 1
    claimed: bool = False  # claimed to be fast, so its renders may take as long as a peer's

    def serves(self, scene):
        """Returns whether the method applies to a Scene. MIS compensation needs an environment map."""
        return scene.group in self.groups and (
            scene.envmap or "mis_compensation" not in self.defines)


# ldsampler, of Kinome and of Mitsuba, rounds up to a power of 4, at least 4. halton supports any count.
FAST = (4, 16, 64, 256, 1024, 4096)
SLOW = (1, 2, 4, 8, 16, 32)  # each sample has 128 light samples
ALL = (ENVIRONMENT, BOUNCE, PLAIN)

CLUSTERED = {"integrator": "clustered", "sampler": "halton"}

METHODS = (
    Method("direct", {"integrator": "direct"}, "mitsuba", (ENVIRONMENT, HARD, PLAIN, AREA), FAST),
    Method("direct, compensated", {"integrator": "direct", "mis_compensation": "true"}, "mitsuba",
           (ENVIRONMENT, HARD, PLAIN), FAST),
    Method("path", {"integrator": "path"}, "mitsuba", (*ALL, HARD, AREA, TOGETHER, DEEP), FAST),
    Method("ptracer", {"integrator": "ptracer"}, "mitsuba", (BOUNCE, TOGETHER), FAST,
           check_factor=4),
    Method("clustered joint", CLUSTERED | {"importance": "joint"}, "groundtruth", ALL, SLOW),
    Method("clustered luminance", CLUSTERED | {"importance": "luminance"}, "groundtruth", ALL,
           SLOW),
    Method("clustered brdf", CLUSTERED | {"importance": "brdf"}, "groundtruth", ALL, SLOW),
    Method("clustered product", {"integrator": "clustered", "importance": "product"}, "mitsuba",
           (*ALL, HARD, AREA, TOGETHER, DEEP), FAST[:-1], any_light=True, claimed=True),
)

@dataclasses.dataclass(frozen=True)
class Cause:
    """Known cause of a failed comparison with Mitsuba's reference. The evidence is in references/README.md. The
    comparison still fails. `tests` has the explained tests with the maximum |t|, about 1.5 times the observed
    one."""

    tests: dict
    text: str


VISIBLE_NORMALS = (
    "the sampling of visible normals of Mitsuba's Beckmann lobes is biased by up to 0.26 % against the "
    "quadrature of its own BSDF, with which Kinome agrees")
ROUNDED = ("rounding changes single pixels of the directly visible photograph by 2e-5; Mitsuba's own "
           "variants differ by half as much")
RARE_LIGHT_OF_PATH = (
    "Mitsuba's path hardly ever finds some of the light on the dish, which its variance doesn't include; "
    "light tracing agrees with Kinome")
RAY_OFFSET = (
    "Mitsuba's rays start at a distance of an eighth of a ridge's flank, so light leaks into the ridges: "
    "its tiles are up to 1.5 % brighter, and more in smaller copies of the scene, unlike Kinome's")
RARE_LIGHT_OF_PTRACER = (
    "light tracing hardly ever finds the light of two dark pixels, which its variance doesn't include; "
    "product agrees with the reference there")
EXPLAINED = {
    ("hebe", "direct"): Cause({"tiles": 15}, VISIBLE_NORMALS),
    ("hebe", "direct, compensated"): Cause({"tiles": 15}, VISIBLE_NORMALS),
    ("hebe", "path"): Cause({"tiles": 15}, VISIBLE_NORMALS),
    ("hebe", "clustered product"): Cause({"image": 13, "tiles": 29, "pixels": 10},
                                         VISIBLE_NORMALS),
    ("car", "direct"): Cause({"pixels": 19}, ROUNDED),
    ("car", "direct, compensated"): Cause({"pixels": 19}, ROUNDED),
    ("car", "path"): Cause({"pixels": 19}, ROUNDED),
    ("plate", "clustered product"): Cause({"tiles": 13, "pixels": 16}, RARE_LIGHT_OF_PATH),
    ("reeds", "direct"): Cause({"image": 21, "tiles": 21}, RAY_OFFSET),
    ("reeds", "direct, compensated"): Cause({"image": 21, "tiles": 21}, RAY_OFFSET),
    ("reeds", "path"): Cause({"image": 21, "tiles": 21}, RAY_OFFSET),
    ("reeds", "clustered product"): Cause({"image": 33, "tiles": 34}, RAY_OFFSET),
    ("focus", "clustered product"): Cause({"image": 9, "tiles": 11}, VISIBLE_NORMALS),
    ("corridor", "ptracer"): Cause({"pixels": 20}, RARE_LIGHT_OF_PTRACER),
}

VARIANTS = ("llvm_ad_rgb", "scalar_rgb")
SAMPLERS = ("multijitter", "ldsampler", "independent")  # usually in this order, best first
BIASED_SAMPLERS = ("ldsampler",)  # Mitsuba's, after a bounce: see references/README.md
PEER_SAMPLES = FAST


@dataclasses.dataclass(frozen=True)
class Effort:
    """Extent of the measurements."""

    shrink: int  # divisor of the width of compared images
    widen: int  # width of timed images, relative to that of compared ones
    seeds: int  # number of seeds of each timed render
    budget: float  # maximum seconds of a render by peers, and by methods that are claimed to be fast
    budget_of_others: float  # the same for our other methods
    max_samples: int
    search_samples: tuple  # sample counts for trying Mitsuba's configurations
    search_seeds: int
    truth_seeds: int
    truth_samples: int  # samples for each of these seeds
    check_samples: int  # samples of each of our 16 compared renders
    small_scenes: tuple
    big_scenes: tuple  # default scenes

    def size(self, scene):
        return tuple(max(16, n // self.shrink) for n in scene.size)

    def timed_size(self, scene):
        return tuple(self.widen * n for n in self.size(scene))


RENDERS = 16  # minimum number of renders for a variance with stratified samplers
# Number of light points that clustered and groundtruth share. It is small because groundtruth uses each once.
POINTS = {"light_samples": 512}
CUT = {"cut_size": 96}

FULL = Effort(shrink=1, widen=2, seeds=5, budget=3.0, budget_of_others=1.0,
              max_samples=4096, search_samples=(16, 256),
              search_seeds=2, truth_seeds=32, truth_samples=512, check_samples=256,
              small_scenes=SMALL_SCENES + SMALL_MEDIA,
              big_scenes=tuple(scene.name for scene in SCENES if not scene.asked))
QUICK = Effort(shrink=2, widen=1, seeds=3, budget=1.0, budget_of_others=1.0,
               max_samples=64, search_samples=(16,),
               search_seeds=1, truth_seeds=16, truth_samples=256, check_samples=64,
               small_scenes=SMALL_SCENES[::5] + SMALL_MEDIA[:1], big_scenes=("hebe", "box", "plate", "blocks"))
