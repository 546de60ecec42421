"""Tests of the Debian packages that CPack makes of this build. Unpacked into a folder, they contain
the program, its licence, docs, manual page and completion, and the files for building plugins; and
the program renders.
"""
import os
import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[3]
BUILD = pathlib.Path(os.environ.get("KINOME_BUILD", ROOT / "build")).resolve()

SCENE = """<scene version="3.0.0">
  <integrator type="path"/>
  <sensor type="perspective">
    <transform name="to_world"><lookat origin="0 0 5" target="0 0 0" up="0 1 0"/></transform>
    <film type="hdrfilm"> <integer name="width" value="16"/> <integer name="height" value="16"/> </film>
  </sensor>
  <emitter type="constant"/> <shape type="sphere"/>
</scene>
"""


def run(*words, **options):
    done = subprocess.run([str(word) for word in words], capture_output=True, text=True, check=False,
                          **options)
    if done.returncode != 0:
        raise AssertionError(f"{' '.join(map(str, words))}: {done.stdout}{done.stderr}")
    return done.stdout


class Packages(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp())
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        made = cls.folder / "made"
        run("cpack", "-G", "DEB", "-B", made, "--config", BUILD / "CPackConfig.cmake", cwd=cls.folder)
        cls.packages = {path.name.split("_")[0]: path for path in made.glob("*.deb")}
        cls.root = cls.folder / "root"
        for path in cls.packages.values():
            run("dpkg", "-x", path, cls.root)
        cls.usr = cls.root / "usr"

    def field(self, package, name):
        return run("dpkg-deb", "-f", self.packages[package], name).strip()

    def test_describe_themselves(self):
        with_mpi = (BUILD / "lib/libkinome_mpi.so").exists()
        self.assertEqual(set(self.packages),
                         {"kinome", "kinome-dev"} | ({"kinome-mpi"} if with_mpi else set()))
        version = run(BUILD / "bin/kinome", "--version").split()[-1]
        for package in self.packages:
            self.assertEqual(self.field(package, "Version"), version)
        depends = self.field("kinome", "Depends")
        for library in ("libc6", "libstdc++6", "libembree"):
            self.assertIn(library, depends)
        self.assertNotIn("libkinome", depends)
        self.assertNotIn("mpi", depends)
        if with_mpi:
            self.assertIn("mpi", self.field("kinome-mpi", "Depends"))
            self.assertTrue((self.usr / "lib/libkinome_mpi.so").is_file())
        self.assertIn(f"kinome (= {version})", self.field("kinome-dev", "Depends"))

    def test_share_no_file(self):
        lists = [set(line.split(maxsplit=5)[5] for line in run("dpkg-deb", "-c", path).splitlines()
                     if not line.startswith("d"))
                 for path in self.packages.values()]
        self.assertEqual(sum(map(len, lists)), len(set().union(*lists)))

    def test_hold_licence_docs_and_pages(self):
        for name in ("copyright", "README.md", "CHANGELOG.md", "docs/command-line.md",
                     "docs/equal-time.jpg", "plugins/integrators/clustered/PRODUCT.md"):
            self.assertTrue((self.usr / "share/doc/kinome" / name).is_file(), name)
        self.assertEqual((self.usr / "share/doc/kinome/copyright").read_bytes(),
                         (ROOT / "LICENSE").read_bytes())

    def test_render(self):
        scene = self.folder / "scene.xml"
        scene.write_text(SCENE, "utf-8")
        # The program finds its library by the same relative path as in /usr, and all other files relative
        # to its own location.
        run(self.usr / "bin/kinome", "-q", scene, "-o", self.folder / "picture.exr")
        self.assertGreater((self.folder / "picture.exr").stat().st_size, 0)
        self.assertIn("plugins", run(self.usr / "bin/kinome", "plugins", "bsdf") + "plugins")
        ours = {p.relative_to(BUILD) for p in (BUILD / "plugins").glob("*/*.so")}
        theirs = {p.relative_to(self.usr / "lib/kinome")
                  for p in (self.usr / "lib/kinome/plugins").glob("*/*.so")}
        self.assertEqual(ours, theirs)
        run(self.usr / "bin/kinome-compare", "--help")
        run(self.usr / "bin/kinome", "-q", scene, "--part", "1/1", "-o", self.folder / "part.exr")
        run(self.usr / "bin/kinome-merge", "-q", self.folder / "part.exr", "-o",
            self.folder / "merged.exr")

    def test_dev_is_found_by_cmake(self):
        project = self.folder / "project"
        project.mkdir()
        (project / "CMakeLists.txt").write_text(
            "cmake_minimum_required(VERSION 3.22)\nproject(found LANGUAGES CXX)\n"
            "find_package(Kinome 0.1 REQUIRED)\n"
            "get_target_property(where kinome::core IMPORTED_LOCATION_RELEASE)\n"
            'message(STATUS "core: ${where}")\n', "utf-8")
        output = run("cmake", "-G", "Ninja", "-S", project, "-B", self.folder / "configured",
                     f"-DCMAKE_PREFIX_PATH={self.usr}")
        self.assertIn(f"core: {self.usr}/lib/libkinome.so.", output)
        self.assertTrue((self.usr / "lib/libkinome.so").exists())
        self.assertTrue((self.usr / "share/doc/kinome-dev/tests/sdk/project/CMakeLists.txt").is_file())

    def test_manual_page_has_every_option(self):
        page = (self.usr / "share/man/man1/kinome.1").read_text("utf-8")
        self.assertTrue(page.startswith(".TH KINOME 1 "))
        program = BUILD / "bin/kinome"
        helps = [run(program, *command, "--help")
                 for command in ((), ("plugins",), ("check",), ("new",), ("film",), ("merge",))]
        options = set(re.findall(r"(?<![\w-])--?[a-zA-Z][a-z-]*", "".join(helps)))
        self.assertGreater(len(options), 25)
        shown = {name.replace("\\-", "-") for name in re.findall(r"\\fB(\S+?)\\fR", page)}
        self.assertEqual({o for o in options if o.startswith("--")},
                         {s for s in shown if s.startswith("--")})
        self.assertIn("\n.SH EXAMPLES\n.TP\n.B kinome scene.xml", page)
        self.assertIn("\n.B kinome merge ", page)

    def completed(self, *words):
        """Returns bash's completions for the last of these words."""
        script = f"""
            source {self.usr}/share/bash-completion/completions/kinome
            compopt() {{ :; }}
            COMP_WORDS=({' '.join(f"'{word}'" for word in words)}) COMP_CWORD={len(words) - 1}
            _kinome
            printf '%s\\n' "${{COMPREPLY[@]}}\""""
        return run("bash", "--norc", "-c", script, cwd=self.folder).split()

    def test_completion(self):
        program = self.usr / "bin/kinome"
        (self.folder / "mine.xml").touch()
        (self.folder / "mine.txt").touch()
        self.assertEqual(sorted(self.completed(program, "--che")), ["--check", "--checkpoint"])
        self.assertEqual(self.completed(program, "mine"), ["mine.xml"])
        self.assertEqual(self.completed(program, "plug"), ["plugins"])
        (self.folder / "mine.exr").touch()
        self.assertEqual(self.completed(program, "merge", "mine"), ["mine.exr"])
        (self.folder / "mine.exr").unlink()
        self.assertEqual(sorted(self.completed(program, "-o", "mine")), ["mine.txt", "mine.xml"])
        self.assertEqual(self.completed(program, "--seed", ""), [])
        self.assertEqual(self.completed(program, "--isa", "x86-64-v3"), ["x86-64-v3"])
        self.assertEqual(self.completed(program, "plugins", "roughdie"), ["roughdielectric"])
        self.assertEqual(self.completed(program, "plugins", "--mark"), ["--markdown"])
        self.assertEqual(self.completed(program, "plugins", "bsd"), ["bsdf"])
        self.assertEqual(self.completed(program, "check", "roughd"),
                         ["roughdielectric", "roughdiffuse"])
        self.assertEqual(self.completed(program, "check", "bsd"), [])
        self.assertEqual(self.completed(program, "check", "--only", ""), [])
        self.assertEqual(self.completed(program, "new", "em"), ["emitter"])
        self.assertEqual(self.completed(program, "new", "emitter", ""), [])


if __name__ == "__main__":
    unittest.main()
