#!/usr/bin/python3
"""Tests of the tools in the image of kinome-view: outline and handles of the selected shape, the region
to render, tabs and the file dialog. It uses the Viewer of window_test.py.
"""
import pathlib
import tempfile
import time
import unittest

import numpy as np

from scenes import write_scene
from window_test import PATIENCE, Viewer, click, places, xdotool

# Colours of the outline, of the arrow of the x axis and of a region's border.
OUTLINE, ARROW, REGION = (255, 165, 50), (235, 77, 75), (120, 220, 255)


class ToolsTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.viewer = Viewer(self, write_scene(self.folder, 160, 120))
        self.viewer.wait_for("pass (?!1 )")

    def press_until(self, key, pattern, after):
        """Presses a key until a line contains the pattern. A busy window may miss a short press."""
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            xdotool("keydown", key, "sleep", 0.5, "keyup", key)
            try:
                return self.viewer.wait_for(pattern, after, 10)
            except AssertionError:
                pass
        raise AssertionError(f"no '{pattern}'")

    def test_the_selected_shape_has_an_outline_and_handles(self):
        before = len(self.viewer.lines)
        click(450, 400)
        self.viewer.wait_for("selected red$", before)
        outline = places(self.viewer.see(lambda s: len(places(s, OUTLINE)) > 300), OUTLINE)
        # The ball is round, and in the middle of the image.
        middle = (outline.min(axis=0) + outline.max(axis=0)) / 2
        np.testing.assert_allclose(middle, (450, 400), atol=12)
        radius = np.hypot(*(outline - middle).T)
        self.assertLess(radius.max() - radius.min(), 14)
        # The arrow to the right moves the ball.
        shot = self.viewer.see(lambda s: len(places(s, ARROW)) > 60, lambda: xdotool("key", "m"))
        arrow = places(shot, ARROW)
        tip = arrow[arrow[:, 0] > arrow[:, 0].max() - 25].mean(axis=0)
        np.testing.assert_allclose(tip[1], 400, atol=12)
        before = len(self.viewer.lines)
        self.viewer.drag(*tip.astype(int), 100, 0)
        self.viewer.wait_for_change(before)

        def moves_by(shot):
            """Returns how far the outline is from where it was, or -1 if there is none."""
            now = places(shot, OUTLINE)
            return abs(now[:, 0].min() - outline[:, 0].min()) if len(now) > 300 else -1
        moved = places(self.viewer.see(lambda s: moves_by(s) > 60), OUTLINE)
        np.testing.assert_allclose(moved.min(axis=0) - outline.min(axis=0), (100, 0), atol=15)
        before = len(self.viewer.lines)
        xdotool("key", "ctrl+z")
        self.viewer.wait_for_change(before)
        back = places(self.viewer.see(lambda s: 0 <= moves_by(s) < 20), OUTLINE)
        np.testing.assert_allclose(back.min(axis=0), outline.min(axis=0), atol=3)

    def test_a_region_is_dragged(self):
        def drag():
            xdotool("keydown", "ctrl", "keydown", "shift", "mousemove", 200, 200, "sleep", 0.3,
                    "mousedown", 1)
            for step in (240, 280, 320):
                xdotool("sleep", 0.2, "mousemove", step, step)
            xdotool("sleep", 0.3, "mouseup", 1, "keyup", "shift", "keyup", "ctrl")
        border = places(self.viewer.see(lambda s: len(places(s, REGION)) > 300, drag), REGION)
        np.testing.assert_allclose(border.min(axis=0), (200, 200), atol=8)
        np.testing.assert_allclose(border.max(axis=0), (320, 320), atol=8)
        self.viewer.see(lambda s: len(places(s, REGION)) == 0, lambda: xdotool("key", "Escape"))

    def test_tabs_keep_pictures_and_scenes_are_chosen(self):
        xdotool("key", "ctrl+k")
        # A tab moves the image down.
        kept = self.viewer.see(lambda s: s[2:20, 8:80].max() > 120, lambda: xdotool("key", "2"))
        self.viewer.see(lambda s: np.array_equal(s[60:760, 20:860], kept[60:760, 20:860]))
        text = (self.folder / "scene.xml").read_text()
        (self.folder / "green.xml").write_text(text.replace("0.7, 0.05, 0.05", "0.05, 0.7, 0.05"))
        before = len(self.viewer.lines)
        # The colour of a dialog's title.
        self.viewer.see(lambda s: abs(s[181, 700] - (41, 74, 122)).max() < 12,
                 lambda: xdotool("key", "ctrl+o"))
        xdotool("type", "--delay", 150, "GREE")
        self.press_until("Return", r"note loaded .*/green\.xml", before)
        # The kept image is still that of the first scene.
        red = self.viewer.screenshot()[390:410, 440:460].mean(axis=(0, 1))
        self.assertGreater(red[0], 2 * red[1])
        self.viewer.see(lambda s: np.dot(s[390:410, 440:460].mean(axis=(0, 1)), [-2, 1, 0]) > 0,
                 lambda: xdotool("key", "1"))


if __name__ == "__main__":
    unittest.main()
