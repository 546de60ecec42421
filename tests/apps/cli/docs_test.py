"""Tests that links of all Markdown files point to a file or folder of the repository, and to an
existing heading. Also tests the site's pages that docs/site collects; MkDocs isn't needed.
"""
import pathlib
import re
import sys
import tempfile
import unittest
import xml.etree.ElementTree
from unittest import mock

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path[:0] = [str(ROOT / "docs/site"), str(ROOT / "docs")]
import collect  # noqa: E402
import picture_store  # noqa: E402
import plugin_pictures  # noqa: E402
import plugin_sources  # noqa: E402
import rooms  # noqa: E402
from links import dead_links  # noqa: E402


class Links(unittest.TestCase):
    def test_none_is_dead(self):
        dead, alive = dead_links(ROOT)
        self.assertEqual(dead, [])
        self.assertGreater(alive, 150)

    def test_dead_ones_are_found(self):
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder).resolve()
            (root / "other.md").write_text("# One: `two`, three\n## Twice\n## Twice\n", "utf-8")
            (root / "page.md").write_text(
                "[a](other.md#one-two-three) [b](other.md#twice-1) `[c](gone.md)`\n"
                "[d](gone.md) [e](other.md#gone) ![f](gone.png) [g](#gone) [h](../other.md)\n"
                "[two\nlines](gone-too.md) [x [1]](other.md) [far](https://example.org/gone)\n"
                "```\n[i](gone.md)\n```\n", "utf-8")
            dead, alive = dead_links(root)
        self.assertEqual(alive, 3)
        self.assertEqual([line.split(": ")[1] for line in dead],
                         ["gone.md", "other.md#gone", "gone.png", "#gone", "../other.md",
                          "gone-too.md"])


class Rooms(unittest.TestCase):
    def test_diagram_is_up_to_date(self):
        text = rooms.PAGE.read_text("utf-8")
        self.assertTrue(text == rooms.with_diagram(text, ROOT), "run docs/rooms.py --write")

    def test_arrows_match_the_allowed_ones(self):
        found = rooms.arrows(ROOT)
        self.assertNotIn("core", {a for a, _ in found})
        for a, b in found:
            self.assertFalse(b.startswith("apps/") and not a.startswith("apps/"), (a, b))
            self.assertFalse(a.endswith("transport") and
                             b not in ("core", "libs/lights", "libs/sampling"), (a, b))


class Site(unittest.TestCase):
    def test_its_pages_link_each_other(self):
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder).resolve() / "pages"
            collect.Collection(root).add_all()
            dead, alive = dead_links(root)
            self.assertEqual(dead, [])
            self.assertGreater(alive, 150)
            source = root / "source/core/include/kinome/wide/numbers.h.md"
            self.assertIn("\n```cpp\n", source.read_text("utf-8"))
            navigation = (ROOT / "docs/mkdocs.yml").read_text("utf-8")
            named = re.findall(r": (\S+\.md)$", navigation, re.MULTILINE)
            self.assertEqual([name for name in named if not (root / name).is_file()], [])
            # The site contains every page about Kinome.
            ours = {f"docs/{path.name}" for path in (ROOT / "docs").glob("*.md")}
            self.assertEqual(ours - set(named), set())

    def test_overview_links_every_plugin(self):
        text = collect.linked_overview((ROOT / "docs/plugins.md").read_text("utf-8"))
        self.assertIn("\n| shape | [`glb`](reference/shape/glb.md), [`gltf`](reference/shape/gltf.md) | ", text)
        linked = set(re.findall(r"\]\(reference/(\w+/\w+)\.md\)", text))
        self.assertLessEqual({f"{c}/{n}" for c, n in plugin_sources.sources()}, linked)

    def test_images_are_kept_until_a_file_changes(self):
        with tempfile.TemporaryDirectory() as name:
            build = pathlib.Path(name)
            for path in ("bin/kinome", "lib/libkinome.so", "plugins/bsdf/a.so", "plugins/bsdf/b.so"):
                (build / path).parent.mkdir(parents=True, exist_ok=True)
                (build / path).write_text(path, "utf-8")
            rendered = []

            def render(program, files, category, plugin, scene, exposure, picture):
                rendered.append(plugin)
                picture.write_text(scene, "utf-8")
                return [f"{category}/{plugin}"]

            def build_both(example="<x/>"):
                rendered.clear()
                store = picture_store.PictureStore(build, build / "pictures")
                for plugin in "ab":
                    self.assertTrue(store.put("bsdf", plugin, example, build / "target.png"))
                return list(rendered)

            with mock.patch.multiple(plugin_pictures, render=render,
                                     make_files=lambda folder: folder.mkdir(parents=True, exist_ok=True)):
                self.assertEqual(build_both(), ["a", "b"])
                self.assertEqual(build_both(), [])
                (build / "plugins/bsdf/b.so").write_text("other", "utf-8")
                self.assertEqual(build_both(), ["b"])
                (build / "lib/libkinome.so").write_text("other", "utf-8")
                self.assertEqual(build_both(), ["a", "b"])
                self.assertEqual(build_both("<y/>"), ["a", "b"])
                self.assertEqual(build_both("<y/>"), [])

    def test_every_plugin_has_an_example_and_an_image(self):
        found = plugin_sources.sources()
        self.assertGreater(len(found), 80)
        for (category, name), source in found.items():
            with self.subTest(plugin=f"{category}/{name}"):
                example = plugin_sources.example(source)
                self.assertIsNotNone(example, "no XML in the comment at the top of its file")
                xml.etree.ElementTree.fromstring(f"<scene>{example}</scene>")
                scene = plugin_pictures.scene_of(category, name, example)
                self.assertEqual(scene is None, (category, name) in plugin_pictures.WITHOUT)
                if scene:
                    xml.etree.ElementTree.fromstring(scene)


if __name__ == "__main__":
    unittest.main()
