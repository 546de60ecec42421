"""Images for the materials of the example scenes, made by code."""
import bpy
import numpy as np


def image(name, pixels, is_data=False):
    """Stores an array of rows from bottom to top as an image of Blender. Colours are sRGB."""
    height, width = pixels.shape[:2]
    made = bpy.data.images.new(name, width, height, is_data=is_data)
    rgba = np.ones((height, width, 4), np.float32)
    rgba[..., :3] = np.clip(pixels if pixels.ndim == 3 else pixels[..., None], 0, 1)
    made.pixels.foreach_set(rgba.ravel())
    made.pack()
    return made


def noise(size, cells, seed):
    """Returns periodic smooth noise in [0, 1]."""
    grid = np.random.default_rng(seed).random((cells, cells))
    at = np.arange(size) / size * cells
    low, t = at.astype(int), at - np.floor(at)
    t = t * t * (3 - 2 * t)
    high = (low + 1) % cells
    rows = grid[low] * (1 - t)[:, None] + grid[high] * t[:, None]
    return rows[:, low] * (1 - t) + rows[:, high] * t


def planks(size=512, count=6, seed=3):
    """Returns the colours and the roughness of a wooden floor."""
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[0:size, 0:size] / size
    plank = np.floor(y * count).astype(int) % count
    shift, tone = rng.random(count)[plank], 0.75 + 0.4 * rng.random(count)[plank]
    grain = 0.5 + 0.5 * np.sin(2 * np.pi * (y * count * 4 + 3 * noise(size, 8, seed) + shift))
    seam = (np.minimum((y * count) % 1, 1 - (y * count) % 1) < 0.03) | (np.abs((x + shift) % 1 - 0.5) < 0.003)
    color = np.array([0.62, 0.42, 0.26]) * (tone * (0.85 + 0.2 * grain))[..., None]
    color[seam] *= 0.4
    return color, np.where(seam, 0.9, 0.28 + 0.25 * grain)


def bricks(size=512, rows=10, columns=5, seed=4):
    """Returns the colours and the heights of a brick wall."""
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[0:size, 0:size] / size
    row = np.floor(y * rows).astype(int)
    across = (x * columns + 0.5 * (row % 2)) % columns
    tone = 0.8 + 0.4 * rng.random((rows, columns))[row, across.astype(int)]
    edge = np.minimum(np.minimum((y * rows) % 1, 1 - (y * rows) % 1) / rows,
                      np.minimum(across % 1, 1 - across % 1) / columns)
    height = np.clip(edge / 0.012, 0, 1)
    brick = np.array([0.60, 0.32, 0.24]) * (tone * (0.9 + 0.2 * noise(size, 64, seed)))[..., None]
    return np.where((height < 0.5)[..., None], np.array([0.66, 0.64, 0.6]), brick), height


def normals(height, strength):
    """Returns the tangent-space normal map of periodic heights."""
    dx = (np.roll(height, -1, 1) - np.roll(height, 1, 1)) * strength
    dy = (np.roll(height, -1, 0) - np.roll(height, 1, 0)) * strength
    n = np.stack([-dx, -dy, np.ones_like(height)], -1)
    return 0.5 + 0.5 * n / np.linalg.norm(n, axis=-1, keepdims=True)


def abstract(size=256, seed=9):
    """Returns a colourful painting."""
    y, x = np.mgrid[0:size, 0:size] / size
    waves = [np.sin(2 * np.pi * (f * x + g * y) + 4 * noise(size, 5, seed + i))
             for i, (f, g) in enumerate(((1, 2), (2, -1), (-1, 1)))]
    return 0.5 + 0.45 * np.stack(waves, -1)
