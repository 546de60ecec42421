"""The clothes of the hebe scene's statue, her base, and the whole figure.

Folds are displacements by `fold` of a phase that winds around the body and drifts with height;
where the body presses from within (the bent right leg, the bust) they fade.
"""

import numpy as np

from .sdf import (chain, cone, disc, ellipsoid, fold, intersect, smoothstep, sphere, torus, union)
from .statue_body import arms, cup, head, jug, torso

# For each section of the skirt: height, centre x and z, radius x and z.
SKIRT = np.array([
    [-0.10, 0.005, -0.015, 0.262, 0.215],
    [0.02, 0.005, -0.015, 0.250, 0.205],
    [0.15, 0.008, -0.010, 0.215, 0.172],
    [0.50, 0.016, -0.004, 0.186, 0.142],
    [0.80, 0.022, -0.004, 0.182, 0.134],
    [0.95, 0.022, -0.004, 0.172, 0.124],
    [1.06, 0.012, 0.000, 0.128, 0.102],
    [1.14, 0.006, 0.000, 0.118, 0.098],
    [1.40, 0.000, 0.000, 0.118, 0.090]])


def section(x, y, z):
    """Returns distance to the smooth skirt, and angle around it (0 in front, > 0 on her left)."""
    cx, cz, rx, rz = (np.interp(y, SKIRT[:, 0], SKIRT[:, i]) for i in range(1, 5))
    px, pz = x - cx, z - cz
    r = np.sqrt((px / rx) ** 2 + (pz / rz) ** 2)
    scale = np.sqrt(px * px + pz * pz) / np.maximum(r, 1e-6)
    return (r - 1.0) * scale * 0.92, np.arctan2(px, pz)


def free_leg(x, y, z):
    """Returns the bent right leg, from hip to ankle, as visible through the cloth."""
    return chain(x, y, z, [(-0.070, 0.930, 0.020), (-0.104, 0.530, 0.120), (-0.135, 0.080, -0.010)],
                 [0.098, 0.074, 0.050], 0.05)


def skirt(x, y, z):
    tube, angle = section(x, y, z)
    leg = free_leg(x, y, z)
    slack = smoothstep(0.0, 0.075, leg) * 0.80 + 0.20  # no deep folds where the leg presses
    depth = slack * (0.010 + 0.036 * smoothstep(1.0, 0.05, y))
    bend = angle + 0.16 * np.sin(2.0 * angle + 0.8) + 0.06 * np.sin(5.0 * angle - 2.1 + 2.6 * y)
    pull = 0.42 * (y - 0.55) * np.cos(angle)  # folds run from the standing hip to the free foot
    large = fold(6.5 * bend + 2.0 * pull, 0.05)
    small = fold(13.0 * bend + 4.5 * pull + 1.1 * np.sin(4.0 * y + 3.0 * angle), 0.05)
    d = tube - depth * (large - 0.55) - 0.36 * depth * (small - 0.6)
    d = union(d, leg - 0.004 - 0.003 * fold(16.0 * y + 34.0 * x + 10.0 * z), 0.07)
    hem = 0.018 + 0.010 * np.sin(9.0 * bend) - y
    return intersect(d, np.maximum(hem, y - 1.10), 0.012)


def overfold(x, y, z):
    """Returns the upper layer of the peplos, from belt to hips, with a zigzag hem."""
    tube, angle = section(x, y, z)
    bend = angle + 0.14 * np.sin(2.0 * angle - 0.6) + 0.07 * np.sin(5.0 * angle + 1.0)
    drop = smoothstep(1.13, 0.86, y)
    phase = 6.0 * bend + 0.8 * np.sin(6.0 * y + 2.0 * angle)
    large = fold(phase, 0.05)
    small = fold(2.0 * phase + 1.0 + 4.0 * y, 0.08)
    d = tube - 0.017 - drop * (0.026 * (large - 0.55) + 0.009 * (small - 0.6))
    hem = 0.860 + 0.050 * np.cos(2.0 * angle) - 0.030 * large - y
    return intersect(intersect(d, hem * 0.8, 0.010), y - 1.125, 0.02)


def bodice(x, y, z):
    """Returns the cloth over the bust: folds hang between the shoulder clasps; a belt is below."""
    body = torso(x, y, z)
    ax = np.abs(x + 0.004 * np.sin(30.0 * y))
    sag = y - 2.6 * ax * ax + 0.12 * x
    hang = fold(88.0 * sag + 0.7 * np.sin(33.0 * x + 20.0 * y), 0.08)
    gather = fold(70.0 * x + 14.0 * x * (y - 1.1) + 0.8 * np.sin(25.0 * y), 0.06)
    low = smoothstep(1.215, 1.15, y)
    bust = smoothstep(0.0, 0.035, union(sphere(x, y, z, (0.071, 1.262, 0.080), 0.046),
                                        sphere(x, y, z, (-0.071, 1.262, 0.080), 0.046), 0.03))
    front = smoothstep(-0.06, 0.02, z)
    ripple = (1.0 - low) * (0.0030 + 0.0040 * bust) * hang * front + low * 0.0095 * gather
    back = (1.0 - front) * 0.006 * fold(16.0 * np.arctan2(x, -z - 0.2) + 8.0 * y)
    d = body - 0.008 - ripple - back
    neckline = y - 1.318 - 1.5 * np.maximum(ax - 0.05, 0.0) ** 1.3 * smoothstep(0.2, 0.1, ax)
    d = intersect(d, neckline * 0.85, 0.008)
    d = intersect(d, 1.085 - y, 0.02)
    strap = chain(ax, y, z, [(0.098, 1.315, 0.080), (0.128, 1.400, 0.035), (0.136, 1.424, -0.020),
                             (0.115, 1.340, -0.105)], [0.026, 0.015, 0.015, 0.028], 0.02)
    strap = strap - 0.004 * fold(120.0 * (ax - 0.25 * y), 0.05)
    d = union(d, np.maximum(strap, body - 0.020), 0.010)
    return union(d, sphere(ax, y, z, (0.132, 1.424, 0.005), 0.0135), 0.004)


def belt(x, y, z):
    tube, _ = section(x, y, z)
    ring = np.sqrt((tube - 0.012) ** 2 + (y - 1.128) ** 2 * 0.55) - 0.0145
    return union(ring, ellipsoid(x, y, z, (0.004, 1.130, 0.118), (0.020, 0.018, 0.014)), 0.01)


def mantle(x, y, z):
    """Returns a cloth over the left forearm that falls to the knee in pleats."""
    lean = 0.050 * (1.08 - y)
    along = z - 0.070 + 0.03 * (1.08 - y)
    spread = 0.70 + 0.30 * smoothstep(1.08, 0.55, y)
    across = along / spread
    pleat = 0.017 * smoothstep(1.12, 0.85, y) * np.sin(62.0 * across + 1.2 * np.sin(4.0 * y))
    sheet = np.abs(x - 0.250 - lean - pleat) - 0.0175
    wide = np.abs(along) - 0.105 * spread - 0.010 * np.sin(12.0 * y)
    hem = 0.425 - 0.70 * along - 0.020 * np.cos(62.0 * across) - y
    d = intersect(intersect(sheet, wide, 0.024), np.maximum(hem * 0.7, y - 1.10), 0.018) * 0.6
    wrap = cone(x, y, z, (0.249, 1.100, -0.010), (0.216, 1.098, 0.140), 0.052, 0.047)
    wrap = wrap - 0.009 * fold(58.0 * z + 9.0 * (x + y), 0.05)
    wrap = intersect(wrap, np.maximum(z - 0.150 - 0.2 * (y - 1.09), -0.045 - z), 0.010)
    return union(d, wrap, 0.022)


def feet_and_base(x, y, z):
    base = disc(x, y, z, (0.0, -0.045, 0.0), 0.315, 0.045, 0.010)
    d = ellipsoid(x, y, z, (-0.150, 0.022, 0.180), (0.040, 0.032, 0.085))
    d = union(d, ellipsoid(x, y, z, (0.100, 0.022, 0.165), (0.040, 0.032, 0.085)), 0.01)
    for i in range(4):
        s = 0.0170 if i == 0 else 0.0135 - 0.0008 * i
        right = (-0.128 - 0.0170 * i, 0.016, 0.262 - 0.006 * i * i * 0.6)
        left = (0.078 + 0.0170 * i, 0.016, 0.247 - 0.006 * i * i * 0.6)
        d = union(d, ellipsoid(x, y, z, right, (s * 0.85, s, s * 1.6)), 0.006)
        d = union(d, ellipsoid(x, y, z, left, (s * 0.85, s, s * 1.6)), 0.006)
    return union(d, base, 0.006)


def figure(x, y, z):
    """Returns the whole statue with its round base."""
    d = union(torso(x, y, z), arms(x, y, z), 0.022)
    d = union(d, head(x, y, z), 0.018)
    dress = union(skirt(x, y, z), overfold(x, y, z), 0.008)
    dress = union(dress, bodice(x, y, z), 0.010)
    dress = union(dress, belt(x, y, z), 0.006)
    d = union(d, dress, 0.004)
    d = union(d, mantle(x, y, z), 0.008)
    d = union(d, union(jug(x, y, z), cup(x, y, z), 0.004), 0.004)
    return union(d, feet_and_base(x, y, z), 0.008)


def axes(scale):
    """Returns grid planes in x, y and z: fine around head and hands, coarser in the skirt."""
    from .meshing import graded_axis
    return [graded_axis(-0.56, 0.42, lambda x: scale * (0.0062 if abs(x) < 0.10 else 0.0085)),
            graded_axis(-0.13, 1.90, lambda y: scale * (0.0095 if y < 1.05 else
                                                        0.0078 if y < 1.44 else 0.0058)),
            graded_axis(-0.40, 0.42, lambda z: scale * 0.0080)]
