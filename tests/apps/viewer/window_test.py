#!/usr/bin/python3
"""Tests of kinome-view's window with clicks, drags and keys. Run it on an X display without a
window manager (xvfb-run). KINOME_BUILD is the build folder.
"""
import ctypes
import os
import pathlib
import re
import subprocess
import tempfile
import threading
import time
import unittest

import numpy as np
from PIL import Image

from scenes import PROGRAM, write_scene

# Timeout in seconds, long enough for a busy machine.
PATIENCE = 600
# Maximum processor time in seconds from the request to close the window to the end of the program.
# An interrupted render takes less than a second. The rest of a pass takes more.
CLOSED = 2


def xdotool(*arguments):
    subprocess.run(["xdotool", *map(str, arguments)], check=True, timeout=PATIENCE)


def click(x, y):
    """Clicks slowly enough for a busy window to notice."""
    xdotool("mousemove", x, y, "sleep", 0.5, "mousedown", 1, "sleep", 0.5, "mouseup", 1)


def places(shot, colour):
    """Returns (x, y) of the pixels of a colour in the image, without dots, which noise may cause."""
    mask = (abs(shot[:, :890] - colour) < 12).all(axis=2)
    height, width = mask.shape
    padded = np.pad(mask, 2).astype(int)
    near = sum(padded[y:y + height, x:x + width] for y in range(5) for x in range(5))
    ys, xs = np.nonzero(mask & (near > 3))
    return np.stack([xs, ys], axis=1)


class Viewer:
    """A running viewer and the lines of its trace."""

    def __init__(self, test, *arguments):
        self.folder = test.folder
        self.shot = self.folder / "shot.png"
        self.process = subprocess.Popen(
            [PROGRAM, *map(str, arguments), "-t", "2", "--trace", "--screenshot", self.shot],
            cwd=self.folder, stdout=subprocess.PIPE, text=True)
        test.addCleanup(self.end)
        self.lines = []
        self.reader = threading.Thread(target=self.read, daemon=True)
        self.reader.start()

    def read(self):
        for line in self.process.stdout:
            self.lines.append(line.rstrip("\n"))

    def end(self):
        self.process.kill()
        self.process.wait()
        self.reader.join()
        self.process.stdout.close()

    def wait_for(self, pattern, after=0, patience=PATIENCE):
        """Returns the match in the first line, from line `after` on, that contains the pattern."""
        end = time.monotonic() + patience
        while time.monotonic() < end:
            for line in self.lines[after:]:
                found = re.search(pattern, line)
                if found:
                    return found
            if self.process.poll() is not None:
                break
            time.sleep(0.01)
        raise AssertionError(f"no '{pattern}' in {self.lines[after:]}")

    def edition(self, end=None):
        """Returns the latest edition in the lines before `end`, or -1."""
        shown = re.findall(r" edition (\d+) ", "\n".join(self.lines[:end]))
        return int(shown[-1]) if shown else -1

    def wait_for_change(self, after, patience=PATIENCE):
        """Waits for a pass of a later edition than in the lines before `after`. It accepts no
        preview, because a busy window may show only the passes that follow it."""
        old = self.edition(after)
        end = time.monotonic() + patience
        while time.monotonic() < end and self.process.poll() is None:
            passes = re.findall(r" edition (\d+) \S+ (?:pass (?!1 )|final)", "\n".join(self.lines[after:]))
            if passes and int(passes[-1]) > old and int(passes[-1]) == self.edition():
                return
            time.sleep(0.01)
        raise AssertionError(f"no pass after edition {old} in {self.lines[after:]}")

    def screenshot(self):
        before = len(self.lines)
        xdotool("key", "F12")
        self.wait_for("note wrote", before)
        return np.asarray(Image.open(self.shot).convert("RGB")).astype(float)

    def see(self, condition, act=lambda: None):
        """Returns the first screenshot that meets the condition, after calling act(). A busy window
        may miss keys and clicks, so that act() is repeated."""
        end = time.monotonic() + PATIENCE
        again = 0
        while time.monotonic() < end:
            if time.monotonic() > again:
                act()
                again = time.monotonic() + 10
            shot = self.screenshot()
            if condition(shot):
                return shot
        raise AssertionError("not seen")

    def drag(self, x, y, dx, dy, steps=10, button=1):
        xdotool("mousemove", x, y, "mousedown", button)
        for _ in range(steps):
            xdotool("mousemove_relative", "--", dx // steps, dy // steps)
            time.sleep(0.03)
        xdotool("mouseup", button)

    def close(self):
        """Requests that the window be closed, as a window manager does. Returns the seconds of
        processor time until the program has ended."""
        window = int(subprocess.run(["xdotool", "search", "--name", "kinome-view"], check=True,
                                    capture_output=True, text=True).stdout.split()[0])
        ask_to_close(window)
        start = processor_seconds(self.process.pid)
        # Its times can be read until poll() is called.
        end = time.monotonic() + PATIENCE
        has_ended = os.WEXITED | os.WNOWAIT | os.WNOHANG
        while time.monotonic() < end and not os.waitid(os.P_PID, self.process.pid, has_ended):
            time.sleep(0.01)
        seconds = processor_seconds(self.process.pid) - start
        self.process.wait(timeout=1)
        return seconds


def processor_seconds(pid):
    fields = pathlib.Path(f"/proc/{pid}/stat").read_text(encoding="ascii").rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def ask_to_close(window):
    """Sends WM_DELETE_WINDOW."""
    class ClientMessage(ctypes.Structure):
        _fields_ = [("type", ctypes.c_int), ("serial", ctypes.c_ulong), ("send_event", ctypes.c_int),
                    ("display", ctypes.c_void_p), ("window", ctypes.c_ulong),
                    ("message_type", ctypes.c_ulong), ("format", ctypes.c_int),
                    ("data", ctypes.c_long * 5), ("padding", ctypes.c_long * 24)]
    x11 = ctypes.CDLL("libX11.so.6")
    x11.XOpenDisplay.restype = ctypes.c_void_p
    x11.XInternAtom.restype = ctypes.c_ulong
    display = ctypes.c_void_p(x11.XOpenDisplay(None))
    protocols = x11.XInternAtom(display, b"WM_PROTOCOLS", 0)
    delete = x11.XInternAtom(display, b"WM_DELETE_WINDOW", 0)
    event = ClientMessage(type=33, window=window, message_type=protocols, format=32)
    event.data[0] = delete
    x11.XSendEvent(display, ctypes.c_ulong(window), 0, ctypes.c_long(0), ctypes.byref(event))
    x11.XFlush(display)
    x11.XCloseDisplay(display)


class WindowTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def open(self, width=160, height=120, *arguments):
        scene = write_scene(self.folder, width, height)
        viewer = Viewer(self, scene, *arguments)
        viewer.wait_for("pass (?!1 )")
        return viewer

    def middle(self, shot):
        return shot[380:420, 430:470].reshape(-1, 3).mean(axis=0)

    def test_a_surface_is_clicked_on_and_edited(self):
        viewer = self.open()
        shot = viewer.screenshot()
        red, green, _ = self.middle(shot)
        self.assertGreater(red, 2 * green)
        before = len(viewer.lines)
        click(450, 400)
        viewer.wait_for("selected red$", before)
        # The side bar shows the colour, and to its left the values of red, green and blue, which a
        # drag changes.
        side = viewer.screenshot()[:, 900:]
        ys, xs = np.nonzero((abs(side - [178, 13, 13]) < 8).all(axis=2))
        self.assertGreater(len(xs), 50)
        x, y = 900 + int(np.median(xs)) - 150, int(np.median(ys))
        before = len(viewer.lines)
        # A busy window doesn't notice a drag between two frames. Drag again in that case.
        for patience in (10, 10, 20, 40, PATIENCE):
            try:
                viewer.drag(x, y, -300, 0)
                viewer.wait_for_change(before, patience)
                break
            except AssertionError:
                if patience == PATIENCE:
                    raise
        red, green, _ = self.middle(viewer.screenshot())
        self.assertLess(red, 1.5 * green)
        # "Undo" reverts the whole drag.
        before = len(viewer.lines)
        xdotool("key", "ctrl+z")
        viewer.wait_for_change(before)
        np.testing.assert_allclose(self.middle(viewer.screenshot()), self.middle(shot), atol=12)
        # The menu at the left end of the row replaces the colour by a checkerboard.
        # A busy window may miss a click, too.
        before = len(viewer.lines)
        for patience in (10, 10, 20, 40, PATIENCE):
            for place in ((921, y), (960, y + 31)):
                click(*place)
            try:
                viewer.wait_for_change(before, patience)
                break
            except AssertionError:
                if patience == PATIENCE:
                    raise
        red, green, _ = self.middle(viewer.screenshot())
        self.assertLess(red, 1.5 * green)

    def test_the_camera_is_dragged_and_flown(self):
        viewer = self.open()
        picture = viewer.screenshot()[100:700, 50:850]
        before = len(viewer.lines)
        viewer.drag(200, 200, 100, 50)
        viewer.wait_for_change(before)
        orbited = viewer.screenshot()[100:700, 50:850]
        self.assertGreater(np.mean(abs(picture - orbited) > 12), 0.2)
        # The camera orbits the ball, which stays in the middle.
        np.testing.assert_allclose(orbited[280:320, 380:420].mean(axis=(0, 1))[0],
                                   picture[280:320, 380:420].mean(axis=(0, 1))[0], atol=60)
        for move in (["keydown", "w", "sleep", 0.3, "keyup", "w"], ["click", 4]):
            before = len(viewer.lines)
            xdotool(*move)
            viewer.wait_for_change(before)
        nearer = viewer.screenshot()[100:700, 50:850]
        is_red = [np.mean(p[..., 0] > 2 * p[..., 1]) for p in (orbited, nearer)]
        self.assertGreater(is_red[1], 1.05 * is_red[0])
        viewer.close()

    def test_closing_ends_a_render(self):
        """Closing cancels the render at once, but still saves pending edits."""
        viewer = self.open(1200, 900)
        # Request all samples at once, which takes minutes. The button is in the row of the number.
        before = len(viewer.lines)
        xdotool("mousemove", 930, 221, "click", "--repeat", 2, 1, "key", "ctrl+a", "type", "100000\n")
        click(1103, 221)
        time.sleep(0.5)
        # A pending save must be completed.
        xdotool("key", "ctrl+s")
        self.assertLess(viewer.close(), CLOSED)
        self.assertEqual(viewer.process.returncode, 0)
        self.assertFalse([line for line in viewer.lines[before:] if "error" in line])
        self.assertEqual((self.folder / "scene-edited.xml").read_text(),
                         (self.folder / "scene.xml").read_text())

    def test_the_first_picture_has_few_samples(self):
        """A window on an idle machine shows a preview. A busy one may show a later pass."""
        viewer = self.open(640, 480)
        self.assertLess(int(viewer.wait_for(r" picture .* (?:preview|part|pass|final) (\d+) samples")[1]), 4000)

    def test_errors_are_shown_and_survived(self):
        scene = write_scene(self.folder)
        scene.write_text(scene.read_text().replace("sky.pfm", "nowhere.pfm"))
        viewer = Viewer(self, scene)
        viewer.wait_for("error .*scene.xml:.*nowhere.pfm")
        shot = viewer.screenshot()
        self.assertGreater(np.mean(shot[:60, :850, 0] > 200), 0.002, "no text in red")
        # The file is repaired, and reloaded.
        write_scene(self.folder)
        scene.write_text(scene.read_text().replace(
            '<film type="hdrfilm">', '<film type="hdrfilm"><boolean name="compensate" value="true"/>'))
        before = len(viewer.lines)
        xdotool("key", "ctrl+r")
        viewer.wait_for("pass (?!1 )", before)
        viewer.wait_for("note warning: .*'compensate' is ignored", before)
        viewer.close()


if __name__ == "__main__":
    unittest.main()
