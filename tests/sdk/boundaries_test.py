"""Tests that the rooms of core/, libs/ and apps/ include each other along the arrows of ROOMS only,
that the core refers to no plugin, and that a plugin uses only the SDK and its own category's folder.
It compares include lines, names of plugin classes, and symbols of the built libraries.
"""
import os
import pathlib
import re
import subprocess
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = pathlib.Path(os.environ.get("KINOME_BUILD", ROOT / "build"))

INCLUDE = re.compile(r'^\s*#\s*include\s*(["<])([^">]+)[">]', re.MULTILINE)
DEFINITION = re.compile(r"^(?:class|struct) (\w+)(?: final)?(?: : [^{;]*)? \{", re.MULTILINE)
REGISTRATION = re.compile(r"\bKINOME_PLUGIN\((?:kinome::)?(\w+),")
NAME_PART = re.compile(r"[A-Z]?[a-z]+|[A-Z]+(?![a-z])")
NOT_CODE = re.compile(r'//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\\n])*"', re.DOTALL)

CORE, LIGHTS = "core", "libs/lights"
FILES, SPECTRA = "libs/image_files", "libs/spectra"
SAMPLING, MESHES, OUTPUT = "libs/sampling", "libs/meshes", "libs/output_files"
LIBS = {LIGHTS, FILES, SPECTRA, SAMPLING, MESHES, OUTPUT, "libs/audit", "libs/scene_xml",
        "libs/denoise", "libs/editor", "libs/session", "libs/kit"}
# Rooms whose headers each room may include, in addition to its own.
ROOMS = {
    CORE: set(),
    SAMPLING: {CORE},
    MESHES: {CORE, SAMPLING},
    LIGHTS: {CORE, SAMPLING},
    OUTPUT: {CORE},
    FILES: {CORE, OUTPUT},
    SPECTRA: {CORE},
    "libs/audit": {CORE, LIGHTS, SAMPLING},
    "libs/scene_xml": {CORE, LIGHTS, SPECTRA},
    "libs/denoise": {CORE, "libs/scene_xml"},
    "libs/editor": {CORE, FILES, OUTPUT, SPECTRA, MESHES, "libs/scene_xml"},
    "libs/session": {CORE, FILES, OUTPUT, "libs/scene_xml"},  # merged parts are written by the scene's film
    "libs/kit": {CORE, FILES, LIGHTS, SAMPLING, "libs/audit", "libs/scene_xml", "libs/session"},
    "apps/drawing": {CORE},
    "apps/kinome": {CORE, *LIBS, "apps/drawing"},
    "apps/viewer": {CORE, *LIBS, "apps/drawing", "apps/kinome"},
    "apps/python": {CORE, *LIBS},
}
# Rooms that plugins may include beside the core, by the category's folder.
ROOMS_OF_PLUGINS = {"bsdfs": [SAMPLING, SPECTRA], "emitters": [LIGHTS, SAMPLING], "films": [FILES],
                    "integrators": [FILES, LIGHTS, SAMPLING], "phases": [SAMPLING],
                    "sensors": [SAMPLING], "shapes": [MESHES, SAMPLING], "spectra": [SPECTRA],
                    "textures": [FILES, MESHES, SPECTRA]}
# Rooms in folders, in their order: each may include headers of itself and of those before it. "" means
# the files beside the folders.
PRODUCT = "plugins/integrators/clustered/product"
ORDERED = {
    PRODUCT: ["tiles", "rays", "lights", "choice", "paths", "strata", "pilot", "trial", "pass", "method"],
    "plugins/integrators/transport": ["", "blocks", "surfaces", "shadows", "camera", "direct", "paths",
                                      "light_paths", "media/bodies", "media/tracking", "media/paths"],
    "libs/scene_xml": ["nodes", "values", "objects", "legacy", ""],
    "libs/editor": ["updates", "saving", ""],
    "libs/kit": ["statistics", "", "scenes", "checks"],
}
# Folders relative to which a room's headers are included, if not those of the room and its include/.
ROOTS = {**{room: "libs" for room in LIBS}, "apps/drawing": "apps", "apps/python": "apps/python/src"}
# Rooms that name no class of a plugin and no algorithm.
NEUTRAL = [CORE, *sorted(LIBS - {LIGHTS}), "apps/drawing", "apps/kinome"]

# Files that two categories share until the SDK contains them.
EXCEPTIONS = {
    ("plugins/emitters/envmap.cpp", "../textures/stored_image.h"):
        "an environment map is read from the same image files as a bitmap",
    ("plugins/emitters/projector.cpp", "../sensors/camera.h"):
        "a projector has the geometry and the parameters of a camera",
}


# Formulas that plugins of several categories share. The SDK has them for authors of BSDFs, samplers
# and integrators. To the core, a BSDF or a sampler is an interface.
FOR_PLUGINS = {"kinome/wide/fresnel.h", "kinome/wide/microfacet.h", "kinome/wide/owen.h"}

# Words that must not be part of a name in the core: BSDF models, ways to choose among emitters,
# sampling methods.
ALGORITHMS = set("""
    phong blinn ward lambert beckmann ggx trowbridge microfacet fresnel conductor dielectric plastic
    tree cut cluster clustered vpl photon product importance strata stratum comb pilot learn
    learned caustic roulette mis
    sobol halton owen latin stratified hilbert metropolis""".split())
NAMED_IN_CORE = {
    ("core/include/kinome/bsdf_form.h", "beckmann"): "identifies the lobe of a BSDF",
    ("core/include/kinome/bsdf_form.h", "ggx"): "identifies the lobe of a BSDF",
    ("core/include/kinome/bsdf_form.h", "conductor"): "identifies the lobe of a BSDF",
    ("libs/audit/environment_audit.cpp", "clustered"): "the optional functions of libs/lights",
    ("libs/kit/checks/emission_checks.cpp", "clustered"): "the optional functions of libs/lights",
    ("core/include/kinome/inspection.h", "cluster"): "a term in the output of `kinome inspect`",
    ("core/include/kinome/inspection.h", "learned"): "a term in the output of `kinome inspect`",
    ("apps/kinome/render/inspect.cpp", "cluster"): "a term in the output of `kinome inspect`",
    ("apps/kinome/render/inspect.cpp", "learned"): "a term in the output of `kinome inspect`",
    ("apps/drawing/inspection_image.cpp", "cluster"): "a term in the output of `kinome inspect`",
    ("apps/drawing/inspection_image.cpp", "learned"): "a term in the output of `kinome inspect`",
    ("core/include/kinome/wide/functions.h", "product"): "a product of numbers",
    ("libs/kit/checks/sensor_checks.cpp", "importance"): "the importance that a sensor emits",
    ("libs/scene_xml/nodes/text_encoding.cpp", "latin"): "an encoding of text",
}


def sources(folder):
    return sorted(path for path in folder.rglob("*") if path.suffix in (".cpp", ".h", ".inc"))


def includes(path):
    """Returns (is quoted, name) of each include line."""
    return [(quote == '"', name) for quote, name in INCLUDE.findall(path.read_text("utf-8"))]


def is_within(path, folder):
    return path.is_file() and path.resolve().is_relative_to(folder.resolve())


def headers(root, room, name):
    """Files of a room that an include line may mean."""
    folder = root / room
    places = (root / ROOTS.get(room, room) / name, folder / "include" / name)
    return [place for place in places if is_within(place, folder)]


def forbidden_includes(root):
    """Returns (file, included name) of all forbidden include lines, relative to the root."""
    core, plugins = root / "core", root / "plugins"
    found = set()
    for room, uses in ROOMS.items():
        for path in sources(root / room):
            for is_quoted, name in includes(path):
                is_ours = (name.startswith(("kinome/", "plugins/")) or
                           any(is_within(f / name, plugins) for f in plugins.iterdir()))
                known = {other for other in ROOMS if headers(root, other, name)}
                if is_quoted and is_within(path.parent / name, root / room):
                    known.add(room)
                if name in FOR_PLUGINS or (known or is_quoted or is_ours) and (
                        not is_quoted or not known & {room, *uses}):
                    found.add((path, name))
    for path in sources(plugins):
        category = plugins / path.relative_to(plugins).parts[0]
        for is_quoted, name in includes(path):
            if not is_quoted:
                is_allowed = not ((plugins / name).is_file() or
                                  any(headers(root, room, name) for room in ROOMS))
            elif name.startswith("kinome/"):
                is_allowed = any(headers(root, room, name) for room in [CORE] +
                                 ROOMS_OF_PLUGINS.get(category.name, []))
            else:
                is_allowed = any(is_within(folder / name, category)
                                 for folder in (path.parent, category))
            if not is_allowed:
                found.add((path, name))
    return {(str(path.relative_to(root)), name) for path, name in found}


def upward_includes(root, base):
    """Returns (file, included name) of include lines in a folder of ORDERED from a part to a later
    one."""
    parts = [root / base / part for part in ORDERED[base]]
    found = set()
    for index, part in enumerate(parts):
        for path in (path for path in sources(root / base) if path.parent == part):
            for _, name in includes(path):
                places = [folder / name for folder in (path.parent, root / base, *(root / base).parents)]
                place = next((place for place in places if place.is_file()), None)
                if place and place.parent in parts[index + 1:]:
                    found.add((str(path.relative_to(root)), name))
    return found


def names_of_plugins(root):
    """Returns the classes of the plugins' headers and those that plugins register."""
    names = set()
    for path in sources(root / "plugins"):
        text = path.read_text("utf-8")
        names.update(REGISTRATION.findall(text))
        if path.suffix == ".h":
            names.update(DEFINITION.findall(text))
    return names


def words_of(path):
    """Returns the words of a file's code, without comments and string literals."""
    return re.findall(r"\w+", NOT_CODE.sub(" ", path.read_text("utf-8")))


def named_in_core(root):
    """Returns (file, name) of plugin classes in the core's code, without comments and string
    literals."""
    names = names_of_plugins(root)
    return {(str(path.relative_to(root)), word) for room in NEUTRAL for path in sources(root / room)
            for word in words_of(path) if word in names}


def algorithms_in_core(root):
    """Returns (file, word) of all ALGORITHMS that are part of a name in the core's code, including
    plurals."""
    found = set()
    for path in (path for room in NEUTRAL for path in sources(root / room)):
        if any(path == root / "core/include" / name for name in FOR_PLUGINS):
            continue
        parts = {part.lower() for word in words_of(path) for part in NAME_PART.findall(word)}
        found |= {(str(path.relative_to(root)), word) for word in ALGORITHMS
                  if word in parts or word + "s" in parts}
    return found


def symbols(library, *options, kinds=None):
    """Returns the demangled names of the symbols that a library defines. `nm` marks symbols that no
    other library may define as T, D, B or R; inline functions are allowed in several."""
    result = subprocess.run(["nm", "-C", "--defined-only", *options, library], check=True,
                            capture_output=True, text=True)
    lines = [line.split(" ", 2) for line in result.stdout.splitlines()]
    return {line[2] for line in lines if len(line) == 3 and (kinds is None or line[1] in kinds)}


class Boundaries(unittest.TestCase):
    def test_includes(self):
        self.assertEqual(forbidden_includes(ROOT), set(EXCEPTIONS))

    def test_folders_are_in_order(self):
        for base, parts in ORDERED.items():
            with self.subTest(base):
                folders = {str(path.parent.relative_to(ROOT / base)) for path in sources(ROOT / base)}
                folders = {name for name in folders if not name.startswith("include")}
                self.assertEqual(folders, {part or "." for part in parts})
                self.assertEqual(upward_includes(ROOT, base), set())

    def test_core_names_no_class_of_a_plugin(self):
        self.assertGreater(len(names_of_plugins(ROOT)), 50)
        self.assertEqual(named_in_core(ROOT), set())

    def test_core_names_no_algorithm(self):
        self.assertEqual(algorithms_in_core(ROOT), set(NAMED_IN_CORE))

    def test_library_has_nothing_of_a_plugin(self):
        library = symbols(BUILD / "lib/libkinome.so", "-D")
        self.assertIn("vtable for kinome::Object", library)
        names = re.compile(r"\b(" + "|".join(sorted(names_of_plugins(ROOT))) + r")\b")
        self.assertEqual([symbol for symbol in library if names.search(symbol)], [])
        parts = symbols(BUILD / "plugins/integrators/clustered/libkinome_clustered.a", kinds="TDBR")
        self.assertGreater(len(parts), 100)
        self.assertEqual(library & parts, set())

    def test_plugins_export_only_their_descriptors(self):
        plugins = sorted((BUILD / "plugins").glob("*/*.so"))
        plugins = [plugin for plugin in plugins if plugin.parent.name != "support"]
        self.assertGreater(len(plugins), 30)
        for plugin in plugins:
            with self.subTest(plugin.name):
                self.assertEqual({symbol for symbol in symbols(plugin, "-D", kinds="TDBR")
                                  if "kinome" in symbol and not symbol.startswith("__")},
                                 {"kinome_plugin", "kinome_plugin_abi_key"})


class BrokenRules(unittest.TestCase):
    """Tests that the searches find violations."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name)
        self.write("core/include/kinome/math.h", "#include <cmath>\n")
        self.write("core/include/kinome/wide/fresnel.h", '#include "kinome/math.h"\n')
        self.write("core/base/numbers.h", '#include "kinome/math.h"\n')
        self.write("core/base/numbers.cpp", '#include "base/numbers.h"\n#include <vector>\n')
        self.write("libs/scene_xml/node.h", '#include "base/numbers.h"\n')
        self.write("libs/scene_xml/include/kinome/scene_loader.h", '#include "kinome/math.h"\n')
        self.write("libs/lights/include/kinome/sky.h", '#include "kinome/math.h"\n')
        self.write("plugins/emitters/moon.cpp", '#include "kinome/sky.h"\n')
        self.write("libs/editor/edits.h", '#include "scene_xml/node.h"\n')
        self.write("apps/kinome/film/film.h", '#include "kinome/scene_loader.h"\n')
        self.write("apps/kinome/main.cpp", '#include "film/film.h"\n#include "editor/edits.h"\n')
        self.write("plugins/shapes/mesh.h", "struct Mesh final : Shape {\n};\n")
        self.write("plugins/shapes/obj.cpp", '#include "mesh.h"\n#include "kinome/math.h"\n'
                                             '#include "kinome/wide/fresnel.h"\n')
        self.write("plugins/integrators/cut/tree.h", "class Tree {\n};\nclass Mesh;\n")
        self.write("plugins/integrators/cut/cut.cpp", '#include "cut/tree.h"\n#include <map>\n')

    def write(self, path, text):
        (self.root / path).parent.mkdir(parents=True, exist_ok=True)
        (self.root / path).write_text(text, encoding="utf-8")

    def test_none_is_broken(self):
        self.assertEqual(forbidden_includes(self.root), set())
        self.assertEqual(named_in_core(self.root), set())
        self.assertEqual(names_of_plugins(self.root), {"Mesh", "Tree"})

    def test_includes(self):
        for path, line in (
                ("core/base/numbers.cpp", '#include "../../plugins/shapes/mesh.h"'),
                ("core/base/numbers.cpp", '#include "cut/tree.h"'),
                ("core/base/numbers.h", "#include <cut/tree.h>"),
                ("core/include/kinome/math.h", '  #  include "mesh.h"'),
                ("core/base/numbers.cpp", '#include "kinome/wide/fresnel.h"'),
                ("core/include/kinome/math.h", '#include "kinome/wide/owen.h"'),
                ("plugins/shapes/obj.cpp", '#include "base/numbers.h"'),
                ("plugins/shapes/obj.cpp", '#include "../../core/base/numbers.h"'),
                ("plugins/shapes/obj.cpp", '#include "../integrators/cut/tree.h"'),
                ("plugins/shapes/obj.cpp", '#include "cut/tree.h"'),
                ("plugins/shapes/obj.cpp", "#include <kinome/math.h>"),
                ("plugins/integrators/cut/cut.cpp", '#include "kinome/light_tree.h"'),
                ("plugins/integrators/cut/cut.cpp", '#include "missing.h"'),
                ("core/base/numbers.h", '#include "kinome/scene_loader.h"'),
                ("core/base/numbers.cpp", '#include "scene_xml/node.h"'),
                ("libs/scene_xml/node.h", '#include "editor/edits.h"'),
                ("libs/scene_xml/node.h", '#include "../editor/edits.h"'),
                ("libs/editor/edits.h", '#include "film/film.h"'),
                ("libs/editor/edits.h", "#include <kinome/math.h>"),
                ("core/base/numbers.h", '#include "kinome/sky.h"'),
                ("plugins/shapes/obj.cpp", '#include "kinome/sky.h"'),
                ("plugins/shapes/obj.cpp", '#include "kinome/scene_loader.h"')):
            with self.subTest(path=path, line=line):
                text = (self.root / path).read_text("utf-8")
                self.write(path, f"{text}{line}\n")
                name = re.search(r'["<](.*)[">]', line)[1]
                self.assertEqual(forbidden_includes(self.root), {(path, name)})
                self.write(path, text)

    def test_order(self):
        self.write(f"{PRODUCT}/tiles/unit.h", "")
        self.write(f"{PRODUCT}/pass/pass.h", "")
        self.write(f"{PRODUCT}/rays/comb.h", '#include "clustered/product/tiles/unit.h"\n')
        self.assertEqual(upward_includes(self.root, PRODUCT), set())
        self.write(f"{PRODUCT}/rays/comb.h", '#include "clustered/product/pass/pass.h"\n')
        self.assertEqual(upward_includes(self.root, PRODUCT),
                         {(f"{PRODUCT}/rays/comb.h", "clustered/product/pass/pass.h")})

    def test_names(self):
        self.write("core/base/numbers.cpp", '// Tree\nconst char* a = "Tree"; int b; /* Mesh\n*/')
        self.assertEqual(named_in_core(self.root), set())
        self.write("core/base/numbers.cpp", "class Tree;  // of lights")
        self.assertEqual(named_in_core(self.root), {("core/base/numbers.cpp", "Tree")})
        self.write("plugins/shapes/ball.cpp", 'KINOME_PLUGIN(kinome::Ball, Category::kShape, "b")')
        self.write("core/base/numbers.cpp", "std::shared_ptr<Ball> ball;")
        self.assertEqual(named_in_core(self.root), {("core/base/numbers.cpp", "Ball")})

    def test_algorithms(self):
        path = "core/base/numbers.cpp"
        self.write(path, '// of a tree\nint street = cute("light_tree"), stored, award;')
        self.assertEqual(algorithms_in_core(self.root), set())
        for name, word in (("light_tree", "tree"), ("LightTrees", "tree"), ("kGgx", "ggx"),
                           ("sobol_2d", "sobol"), ("GGXLobe", "ggx"), ("cuts_", "cut")):
            with self.subTest(name):
                self.write(path, f"int {name};")
                self.assertEqual(algorithms_in_core(self.root), {(path, word)})


if __name__ == "__main__":
    unittest.main()
