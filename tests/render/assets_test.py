"""Tests of the scenes' assets: reproducible bytes, no repeated work, and a closed statue."""

import hashlib
import pathlib
import re
import struct
import subprocess
import sys
import tempfile
import unittest
import zlib

import numpy as np

SCENES = pathlib.Path(__file__).resolve().parents[2] / "scenes"
sys.path.insert(0, str(SCENES))
from tools import box, files, heap, meshing, sdf, solids, sponge  # noqa: E402

COARSE = "3"


def run(output, *arguments):
    command = [sys.executable, str(SCENES / "make_assets.py"), "--output", str(output), *arguments]
    return subprocess.run(command, check=False, capture_output=True, text=True)


def hashes(folder):
    return {str(f.relative_to(folder)): hashlib.sha256(f.read_bytes()).hexdigest()
            for f in sorted(folder.rglob("*")) if f.is_file()}


def read_ply(path):
    """Reads the vertices (n, columns) and faces of a PLY file from make_assets."""
    header, body = path.read_bytes().split(b"end_header\n", 1)
    counts = [int(line.split()[2]) for line in header.split(b"\n") if line.startswith(b"element")]
    columns = header.count(b"property float")
    split = counts[0] * columns * 4
    faces = np.frombuffer(body[split:], dtype=[("n", "u1"), ("i", "<i4", 3)])
    assert len(faces) == counts[1] and np.all(faces["n"] == 3)
    return np.frombuffer(body[:split], "<f4").reshape(counts[0], columns), faces["i"]


class Command(unittest.TestCase):
    def test_two_runs_give_the_same_bytes(self):
        with tempfile.TemporaryDirectory() as first, tempfile.TemporaryDirectory() as second:
            for folder in (first, second):
                result = run(folder, "--scale", COARSE)
                self.assertEqual(result.returncode, 0, result.stderr)
            one, two = hashes(pathlib.Path(first)), hashes(pathlib.Path(second))
            self.assertGreater(len(one), 20)
            self.assertEqual(one, two)
            self.check_that_scenes_have_their_files(one)

    def check_that_scenes_have_their_files(self, made):
        """Each scene file names all of its assets. Names that contain a parameter are skipped."""
        scenes = sorted(f.parent.name for f in SCENES.glob("*/scene.xml"))
        self.assertEqual(scenes, sorted({pathlib.Path(name).parts[0] for name in made}))
        for scene in scenes:
            text = (SCENES / scene / "scene.xml").read_text(encoding="utf-8")
            for name in re.findall(r'name="filename" value="(assets/[^"$]+)"', text):
                self.assertIn(f"{scene}/{name}", made)

    def test_only_missing_assets_are_made_again(self):
        with tempfile.TemporaryDirectory() as folder:
            run(folder, "--scale", COARSE, "grace")
            assets = pathlib.Path(folder) / "grace" / "assets"
            before = (assets / "teapot.ply").stat().st_mtime_ns
            self.assertIn("up to date", run(folder, "--scale", COARSE, "grace").stdout)
            self.assertEqual((assets / "teapot.ply").stat().st_mtime_ns, before)
            (assets / "planks.png").unlink()
            self.assertNotIn("up to date", run(folder, "--scale", COARSE, "grace").stdout)
            self.assertTrue((assets / "planks.png").is_file())
            self.assertNotIn("up to date", run(folder, "--scale", "2", "grace").stdout)

    def test_an_unknown_scene_is_refused(self):
        result = run("unused", "teapot")
        self.assertEqual(result.returncode, 2)
        self.assertIn("expected one of hebe, car, grace, box, plate, colonnade", result.stderr)


class Statue(unittest.TestCase):
    """Tests the mesh as it is rendered, not a coarse one."""

    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        result = run(cls.folder.name, "hebe")
        assert result.returncode == 0, result.stderr
        path = pathlib.Path(cls.folder.name) / "hebe" / "assets" / "statue.ply"
        cls.vertices, cls.faces = read_ply(path)

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def test_has_enough_triangles(self):
        self.assertGreaterEqual(len(self.faces), 100_000)

    def test_every_edge_belongs_to_two_triangles(self):
        # Counted independently of the script's own check.
        edges = np.sort(np.concatenate([self.faces[:, [0, 1]], self.faces[:, [1, 2]],
                                        self.faces[:, [2, 0]]]), axis=1)
        _, counts = np.unique(edges, axis=0, return_counts=True)
        self.assertTrue(np.all(counts == 2), f"{np.sum(counts != 2)} edges not in two triangles")

    def test_encloses_a_volume_and_normals_are_of_unit_length(self):
        corners = self.vertices[self.faces][:, :, :3].astype(np.float64)
        volume = np.einsum("ij,ij->i", corners[:, 0],
                           np.cross(corners[:, 1], corners[:, 2])).sum() / 6.0
        self.assertGreater(volume, 0.1)  # positive: faces are oriented outward; a body of this size
        self.assertLess(volume, 0.2)
        lengths = np.linalg.norm(self.vertices[:, 3:6], axis=1)
        self.assertLess(np.abs(lengths - 1.0).max(), 1e-5)  # a few float roundings


class Room(unittest.TestCase):
    """The box scene's room and block are closed and oriented correctly."""

    def volume(self, meshes, names):
        """Returns the volume of the polyhedron that the meshes form together; positive if its faces
        are oriented outward."""
        corners = np.concatenate([meshes[n]["positions"][meshes[n]["faces"]] for n in names])
        places, at = np.unique(np.round(corners.reshape(-1, 3), 6), axis=0, return_inverse=True)
        self.assertTrue(meshing.is_watertight(at.reshape(-1, 3)))
        return np.einsum("ij,ij->i", corners[:, 0],
                         np.cross(corners[:, 1], corners[:, 2])).sum() / 6.0

    def test_volumes_match_bevelled_boxes(self):
        size, bevel = np.array([3.0, 4.0, 5.0]), 0.25
        names = [*box.SIDES, "bevels"]
        # Each edge loses a prism, each corner five sixths of a cube.
        expected = size.prod() - 4 * (size - 2 * bevel).sum() * bevel ** 2 / 2 \
            - 8 * bevel ** 3 * 5 / 6
        outside = box.bevelled_box((1, 2, 3), (1, 2, 3) + size, bevel, inside=False)
        self.assertAlmostEqual(self.volume(outside, names), expected, places=9)
        inside = box.bevelled_box((1, 2, 3), (1, 2, 3) + size, bevel, inside=True)
        self.assertAlmostEqual(self.volume(inside, names), -expected, places=9)

    def test_normals_agree_with_the_faces(self):
        for mesh in box.bevelled_box((0, 0, 0), (1, 2, 3), 0.1, inside=True).values():
            c = mesh["positions"][mesh["faces"]]
            flat = np.cross(c[:, 1] - c[:, 0], c[:, 2] - c[:, 0])
            flat /= np.linalg.norm(flat, axis=1)[:, None]
            np.testing.assert_allclose(mesh["normals"][mesh["faces"][:, 0]], flat, atol=1e-12)


class Solids(unittest.TestCase):
    """Solids of the measured scenes are closed, of the right volume, and oriented outward."""

    def volume(self, mesh):
        corners = mesh["positions"][mesh["faces"]]
        _, at = np.unique(np.round(corners.reshape(-1, 3), 6), axis=0, return_inverse=True)
        self.assertTrue(meshing.is_watertight(at.reshape(-1, 3)))
        flat = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        ahead = np.einsum("ij,ikj->ik", flat, mesh["normals"][mesh["faces"]])
        self.assertGreater(ahead.min(), 0.0)
        return np.einsum("ij,ij->i", corners[:, 0],
                         np.cross(corners[:, 1], corners[:, 2])).sum() / 6.0

    def test_volumes(self):
        self.assertAlmostEqual(self.volume(solids.cuboid((1, 2, 3), (2, 4, 6))), 6.0, places=12)
        # Inscribed meshes: the missing volume falls with the square of the steps.
        ball = solids.star(lambda x, y, z: np.ones_like(x), 60)
        self.assertAlmostEqual(self.volume(ball) / (4 / 3 * np.pi), 1.0, delta=2e-3)
        ring = solids.torus(0.7, 0.3, 60)
        self.assertAlmostEqual(self.volume(ring) / (2 * np.pi ** 2 * 0.7 * 0.09), 1.0, delta=3e-3)

    def test_the_sponge_has_its_cells_and_faces(self):
        for level in (1, 2):
            cells = sponge.solid(level)
            self.assertEqual(cells.sum(), 20 ** level)
            mesh = sponge.skin(cells)
            self.assertEqual(len(mesh["faces"]), 2 * (2 * 20 ** level + 4 * 8 ** level))
            corners = mesh["positions"][mesh["faces"]]
            volume = np.einsum("ij,ij->i", corners[:, 0],
                               np.cross(corners[:, 1], corners[:, 2])).sum() / 6.0
            self.assertAlmostEqual(volume, 8 * (20 / 27) ** level, places=9)

    def test_bodies_of_the_heap_touch_and_do_not_meet(self):
        radii = [0.2, 0.15, 0.25, 0.18, 0.2, 0.13]
        centres = heap.places(radii)
        for i, (c, r) in enumerate(zip(centres, radii)):
            gaps = [np.linalg.norm(c - d) - r - s for d, s in zip(centres[:i], radii)]
            self.assertAlmostEqual(min([c[1] - r, *gaps]), 0.0, places=9)


class Tools(unittest.TestCase):
    def test_a_sphere_is_met_to_the_third_order(self):
        radius, spacing = 0.5, 0.04
        axes = [meshing.graded_axis(-0.7, 0.7, lambda _: spacing) for _ in range(3)]
        mesh = meshing.mesh_field(lambda x, y, z: sdf.sphere(x, y, z, (0.01, 0, 0), radius), axes)
        self.assertTrue(meshing.is_watertight(mesh["faces"]))
        distance = np.linalg.norm(mesh["positions"] - [0.01, 0, 0], axis=1)
        # Newton's method converges in one step for a true distance. The rest is the error of finite
        # differences, below step^2 / radius.
        self.assertLess(np.abs(distance - radius).max(), 5e-4 ** 2 / radius + 1e-12)

    def test_a_checkered_grid_still_gives_a_closed_mesh(self):
        values = np.ones((8, 8, 8))
        values[2:6:2, 2:6:2, 2:6:2] = -1.0
        values[3, 3, 2] = values[3, 4, 3] = -1.0  # diagonal neighbours: ambiguous faces
        axes = [np.arange(8.0)] * 3
        vertices, quads = meshing.surface_net(meshing.remove_ambiguous_faces(values), axes)
        self.assertTrue(meshing.is_watertight(meshing.split_quads(vertices, quads)))

    def test_the_watertight_check_sees_a_hole_and_a_turned_face(self):
        tetrahedron = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])
        self.assertTrue(meshing.is_watertight(tetrahedron))
        self.assertFalse(meshing.is_watertight(tetrahedron[:3]))
        turned = tetrahedron.copy()
        turned[0] = turned[0][::-1]
        self.assertFalse(meshing.is_watertight(turned))

    def test_png_header_and_rows(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "a.png"
            files.write_png(path, np.array([[0.0, 0.5, 1.0], [1.0, 0.0, 0.25]]))
            data = path.read_bytes()
        self.assertEqual(struct.unpack(">IIBB", data[16:26]), (3, 2, 8, 0))
        at = data.index(b"IDAT")
        size = struct.unpack(">I", data[at - 4:at])[0]
        self.assertEqual(zlib.decompress(data[at + 4:at + 4 + size]),
                         bytes([0, 0, 128, 255, 0, 255, 0, 64]))


if __name__ == "__main__":
    unittest.main()
