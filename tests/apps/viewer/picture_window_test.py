#!/usr/bin/python3
"""Tests of the image window of kinome-view: false colours, a reference beside the image, and the
paths of a pixel's samples. It uses the Viewer of window_test.py.
"""
import pathlib
import tempfile
import unittest

import numpy as np

from scenes import write_scene
from window_test import Viewer, click, places, xdotool

# Positions of the headings of panels at first, and of controls in an open panel.
TONE, COMPARE = (960, 359), (960, 384)
FALSE_COLOUR, KEEP = (1075, 384), (1030, 434)
# Colours of the line between image and reference, and of the marker of the inspected point.
LINE, POINT = (255, 200, 60), (50, 255, 80)


class PictureWindowTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.viewer = Viewer(self, write_scene(self.folder, 160, 120))
        self.viewer.wait_for("pass (?!1 )")

    def open_panel(self, x, y):
        """Opens a panel and returns the screenshot from before."""
        before = self.viewer.screenshot()
        click(x, y)
        self.viewer.see(lambda s: np.mean(abs(s - before)[y + 14:y + 32, 905:1260] > 12) > 0.05)
        return before

    def test_false_colours_have_a_legend(self):
        plain = self.open_panel(*TONE)
        shot = self.viewer.see(lambda s: np.mean(abs(s - plain)[200:600, 100:800] > 12) > 0.5,
                        lambda: click(*FALSE_COLOUR))
        # The bar goes from black to white, along a line at the lower edge.
        bar = shot[763, 29:386]
        self.assertLess(bar[:4].mean(), 30)
        self.assertGreater(bar[-4:].mean(), 225)
        brightness = bar @ [0.3, 0.59, 0.11]
        self.assertGreater(np.mean(np.diff(brightness) > -3), 0.98)

    def test_a_reference_is_beside_the_picture(self):
        self.open_panel(*COMPARE)
        shot = self.viewer.see(lambda s: len(places(s, LINE)) > 500, lambda: click(*KEEP))
        self.assertAlmostEqual(np.median(places(shot, LINE)[:, 0]), 450, delta=2)
        xdotool("mousemove", 450, 250, "sleep", 0.5, "mousedown", 1)
        for x in (430, 400, 350):
            xdotool("sleep", 0.5, "mousemove", x, 250)
        xdotool("sleep", 0.5, "mouseup", 1)
        moved = self.viewer.see(lambda s: abs(np.median(places(s, LINE)[:, 0]) - 350) < 3)
        # The camera has not moved.
        np.testing.assert_allclose(moved[380:420, 500:540].mean(axis=(0, 1)),
                                   shot[380:420, 500:540].mean(axis=(0, 1)), atol=12)

    def test_samples_of_a_pixel_are_shown(self):
        before = self.viewer.screenshot()
        self.assertEqual(len(places(before, POINT)), 0)

        def inspect():
            xdotool("mousemove", 600, 620, "sleep", 0.3, "keydown", "alt", "sleep", 0.5,
                    "mousedown", 1, "sleep", 0.5, "mouseup", 1, "sleep", 0.5, "keyup", "alt")
        shot = self.viewer.see(lambda s: len(places(s, POINT)) > 20, inspect)
        # The reconstruction filter may extend beyond the pixel.
        np.testing.assert_allclose(np.median(places(shot, POINT), axis=0), (600, 620), atol=15)
        # Samples are red, in the scene and on the sphere in the inspector's window.
        is_red = (shot[..., 0] > 150) & (shot[..., 0] > 2 * shot[..., 1])
        self.assertGreater(np.sum(is_red[520:620, 540:660] & (before[520:620, 540:660, 1] > 90)), 20)
        self.assertGreater(np.sum(is_red[400:780, 20:400]), 20)
        # The same pixel is inspected again after a camera movement.
        self.viewer.drag(640, 180, 0, 60)
        self.viewer.see(lambda s: abs(s - shot)[100:250, 500:840].mean() > 3 and
                 len(places(s, POINT)) > 20)


if __name__ == "__main__":
    unittest.main()
