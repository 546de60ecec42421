"""The body of the hebe scene's statue, a cup-bearer, as a signed distance field.

Heights in metres, y up, facing +z; her left is +x. She stands on her left leg. The right arm
lifts a jug, the left holds a cup. The clothes are in statue_dress.py.
"""

import numpy as np

from .sdf import (chain, cone, disc, ellipsoid, fold, intersect, local, rotation, smoothstep,
                  sphere, subtract, torus, union)

HEAD_AT = (-0.006, 1.585, 0.022)
HEAD_TURN = rotation(yaw=-24.0, pitch=7.0, roll=4.0)

JUG_AT = (-0.268, 1.648, 0.205)
JUG_TURN = rotation(yaw=-12.0, pitch=0.0, roll=-34.0)

SHOULDER_R, ELBOW_R = (-0.168, 1.375, -0.012), (-0.405, 1.435, 0.055)
SHOULDER_L, ELBOW_L = (0.168, 1.362, -0.012), (0.248, 1.100, -0.030)
WRIST_R, WRIST_L = (-0.362, 1.660, 0.125), (0.190, 1.085, 0.195)


def face(x, y, z):
    """Returns skull, jaw and features in the head's frame; the profile is straight, as in Greek statues."""
    ax = np.abs(x)
    d = union(ellipsoid(x, y, z, (0, 0.035, -0.012), (0.073, 0.083, 0.090)),
              ellipsoid(x, y, z, (0, -0.028, 0.028), (0.057, 0.086, 0.062)), 0.05)
    d = union(d, sphere(ax, y, z, (0.030, -0.030, 0.062), 0.024), 0.03)
    d = union(d, ellipsoid(x, y, z, (0, -0.099, 0.066), (0.020, 0.018, 0.019)), 0.030)
    d = union(d, cone(ax, y, z, (0.012, 0.021, 0.086), (0.043, 0.022, 0.068), 0.008, 0.008), 0.012)
    d = subtract(d, ellipsoid(ax, y, z, (0.031, 0.003, 0.096), (0.019, 0.013, 0.022)), 0.014)
    d = union(d, sphere(ax, y, z, (0.030, 0.002, 0.0715), 0.0135), 0.003)
    d = union(d, chain(ax, y, z, [(0.016, 0.004, 0.083), (0.029, 0.0105, 0.086),
                                  (0.045, 0.003, 0.075)], [0.0032, 0.0035, 0.003], 0.003), 0.004)
    d = union(d, cone(x, y, z, (0, 0.026, 0.087), (0, -0.033, 0.109), 0.0085, 0.0095), 0.012)
    d = union(d, sphere(ax, y, z, (0.0105, -0.037, 0.097), 0.0068), 0.006)
    upper_lip = chain(ax, y, z, [(0.0, -0.0625, 0.0925), (0.007, -0.0615, 0.0915),
                                 (0.0215, -0.0660, 0.0810)], [0.0052, 0.0054, 0.0035], 0.004)
    d = union(d, upper_lip, 0.009)
    d = union(d, ellipsoid(x, y, z, (0, -0.0755, 0.0885), (0.0165, 0.0066, 0.0075)), 0.009)
    parting = y + 0.0690 - 1.5 * ax * ax + 0.0012 * np.cos(300.0 * x)
    d = d + 0.0022 * np.exp(-(parting / 0.0024) ** 2) * smoothstep(0.026, 0.016, ax) * (z > 0.06)
    return d + 0.0022 * np.exp(-(((y + 0.0870) / 0.005) ** 2 + (x / 0.014) ** 2)) * (z > 0.06)


def hair(x, y, z):
    """Returns hair in waves from a centre parting back to a bun, with a diadem, in the head's frame."""
    cap = ellipsoid(x, y, z, (0, 0.042, -0.016), (0.0815, 0.0865, 0.0985))
    around = np.arctan2(np.abs(x), y + 0.01)  # constant along a strand
    wave = fold(14.0 * around + 1.2 * np.sin(46.0 * z + 4.0 * around), 0.10)
    polar = smoothstep(0.012, 0.045, np.sqrt(x * x + (y + 0.01) ** 2))
    d = cap - 0.0085 * wave * polar + 0.004 * np.exp(-(x / 0.007) ** 2) * smoothstep(0.0, 0.05, y)
    front = 0.83 * (z - 0.068) - 0.55 * (y - 0.070) + 0.004 * np.sin(90.0 * around)
    d = intersect(d, front, 0.012)
    nape = ellipsoid(x, y, z, (0, -0.015, -0.078), (0.052, 0.060, 0.045))
    d = union(d, nape - 0.006 * fold(13.0 * np.arctan2(x, y + 0.06)), 0.02)
    bx, by, bz = x, y - 0.045, z + 0.128
    spiral = np.arctan2(by, bx) * 2.0 + 150.0 * np.sqrt(bx * bx + by * by + 1e-8)
    bun = ellipsoid(bx, by, bz, (0, 0, 0), (0.047, 0.045, 0.040)) - 0.007 * fold(spiral)
    d = union(d, bun, 0.012)
    band = np.abs(0.50 * (z - 0.038) - 0.86 * (y - 0.105)) - 0.0075
    return union(d, intersect(cap - 0.0145, band, 0.004), 0.003)


def head(x, y, z):
    lx, ly, lz = local(x, y, z, HEAD_AT, HEAD_TURN)
    ear = ellipsoid(np.abs(lx), ly, lz, (0.069, -0.018, -0.002), (0.010, 0.026, 0.017))
    skin = union(face(lx, ly, lz), ear, 0.006)
    return union(skin, hair(lx, ly, lz), 0.003)


def torso(x, y, z):
    """Returns the body under the cloth, from neck to hips."""
    ax = np.abs(x)
    d = ellipsoid(x, y, z, (0.0, 1.245, -0.008), (0.142, 0.170, 0.098))
    d = union(d, ellipsoid(x, y, z, (0.012, 1.060, 0.000), (0.112, 0.130, 0.088)), 0.07)
    d = union(d, ellipsoid(x, y, z, (0.024, 0.945, -0.004), (0.165, 0.130, 0.118)), 0.08)
    for side in (-0.071, 0.071):
        d = union(d, sphere(x, y, z, (side, 1.258, 0.074), 0.056), 0.035)
    d = union(d, cone(ax, y, z, (0.020, 1.418, -0.028), (0.158, 1.378, -0.014), 0.040, 0.045), 0.05)
    d = union(d, cone(ax, y, z, (0.018, 1.392, 0.052), (0.140, 1.400, 0.010), 0.010, 0.012), 0.025)
    neck = cone(x, y, z, (0.0, 1.375, -0.014), (-0.004, 1.545, 0.006), 0.052, 0.044)
    return union(d, neck, 0.045)


def hand(x, y, z, wrist, palm, knuckles, tips, thumb):
    """Returns a palm, four fingers with two joints each, and a thumb.

    knuckles and tips give the first and the last finger; tips: both middle joints, both ends.
    """
    d = cone(x, y, z, wrist, palm, 0.024, 0.027)
    for i in range(4):
        t = i / 3.0
        base = [(1 - t) * a + t * b for a, b in zip(knuckles[0], knuckles[1])]
        middle = [(1 - t) * a + t * b for a, b in zip(tips[0], tips[1])]
        tip = [(1 - t) * a + t * b for a, b in zip(tips[2], tips[3])]
        finger = chain(x, y, z, [palm, base, middle, tip], [0.016, 0.0105, 0.0095, 0.0075], 0.006)
        d = union(d, finger, 0.007)
    thumb = chain(x, y, z, [wrist, thumb[0], thumb[1]], [0.016, 0.012, 0.008], 0.008)
    return union(d, thumb, 0.012)


def arm(x, y, z, shoulder, elbow, wrist):
    belly = [0.65 * e + 0.35 * w for e, w in zip(elbow, wrist)]
    upper = [0.55 * s + 0.45 * e for s, e in zip(shoulder, elbow)]
    d = chain(x, y, z, [shoulder, upper, elbow], [0.055, 0.046, 0.036], 0.03)
    return union(d, chain(x, y, z, [elbow, belly, wrist], [0.036, 0.039, 0.024], 0.03), 0.02)


def jug(x, y, z):
    """Returns the lifted jug, tilted towards the cup."""
    lx, ly, lz = local(x, y, z, JUG_AT, JUG_TURN)
    r = np.sqrt(lx * lx + lz * lz)
    d = ellipsoid(lx, ly, lz, (0, -0.010, 0), (0.062, 0.070, 0.062))
    d = d - 0.0022 * smoothstep(0.02, -0.05, ly) * fold(8.0 * np.arctan2(lz, lx))
    d = union(d, cone(lx, ly, lz, (0, 0.035, 0), (0, 0.120, 0), 0.032, 0.024), 0.035)
    d = union(d, torus(lx, ly, lz, (0, 0.138, 0), 0.027, 0.008), 0.014)
    d = union(d, cone(lx, ly, lz, (0.02, 0.138, 0), (0.048, 0.150, 0), 0.014, 0.008), 0.014)
    d = union(d, disc(lx, ly, lz, (0, -0.086, 0), 0.034, 0.009, 0.004), 0.014)
    d = subtract(d, np.maximum(r - 0.013, 0.10 - ly), 0.006)
    grip = np.sqrt(((lx + 0.050) / 0.85) ** 2 + ((ly - 0.070) / 1.15) ** 2) - 0.058
    handle = np.sqrt(grip * grip + lz * lz) - 0.0085
    return union(d, np.where(lx < 0.01, handle, 1.0), 0.008)


def cup(x, y, z):
    """Returns a shallow footed bowl."""
    lx, ly, lz = x - 0.150, y - 1.165, z - 0.300
    bowl = ellipsoid(lx, ly, lz, (0, 0.020, 0), (0.080, 0.048, 0.080))
    bowl = intersect(bowl, ly - 0.020, 0.008)
    bowl = subtract(bowl, ellipsoid(lx, ly, lz, (0, 0.030, 0), (0.064, 0.036, 0.064)), 0.006)
    stem = cone(lx, ly, lz, (0, -0.022, 0), (0, -0.062, 0), 0.011, 0.010)
    foot = disc(lx, ly, lz, (0, -0.064, 0), 0.034, 0.007, 0.004)
    return union(union(bowl, stem, 0.018), foot, 0.01)


def arms(x, y, z):
    right = union(arm(x, y, z, SHOULDER_R, ELBOW_R, WRIST_R),
                  hand(x, y, z, WRIST_R, (-0.352, 1.715, 0.158),
                       [(-0.358, 1.762, 0.172), (-0.364, 1.712, 0.200)],
                       [(-0.332, 1.778, 0.198), (-0.338, 1.716, 0.228),
                        (-0.306, 1.764, 0.200), (-0.314, 1.706, 0.226)],
                       [(-0.326, 1.730, 0.150), (-0.302, 1.748, 0.176)]), 0.012)
    left = union(arm(x, y, z, SHOULDER_L, ELBOW_L, WRIST_L),
                 hand(x, y, z, WRIST_L, (0.172, 1.092, 0.252),
                      [(0.182, 1.108, 0.292), (0.142, 1.096, 0.284)],
                      [(0.186, 1.126, 0.326), (0.128, 1.112, 0.322),
                       (0.166, 1.144, 0.340), (0.124, 1.130, 0.338)],
                      [(0.140, 1.105, 0.226), (0.118, 1.128, 0.258)]), 0.012)
    return union(right, left, 0.01)
