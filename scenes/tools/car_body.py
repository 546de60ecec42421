"""The body of the car scene, a small coupe of the sixties, as signed distance fields.

Metres; x forwards, y up; every part is symmetric in z. The wheels are in car.py.
"""

import numpy as np

from .sdf import box, chain, cone, ellipsoid, intersect, smoothstep, subtract, union

WHEEL_X = (-1.22, 1.27)
WHEEL_Y, WHEEL_Z = 0.31, 0.70
LAMP_AT = (1.900, 0.655, 0.575)

# Along x: underside, shoulder height, half width, each smoothed by cubic interpolation.
STATIONS = np.array([
    [-2.30, 0.42, 0.66, 0.60],
    [-2.05, 0.33, 0.755, 0.715],
    [-1.60, 0.25, 0.83, 0.790],
    [-1.10, 0.20, 0.865, 0.815],
    [-0.40, 0.18, 0.845, 0.820],
    [0.40, 0.18, 0.835, 0.820],
    [1.00, 0.20, 0.815, 0.810],
    [1.50, 0.24, 0.765, 0.780],
    [1.90, 0.31, 0.690, 0.690],
    [2.20, 0.39, 0.60, 0.56]])


def along(x, column):
    """Catmull-Rom interpolation of a column of STATIONS."""
    knots, values = STATIONS[:, 0], STATIONS[:, column]
    slopes = np.gradient(values, knots)
    i = np.clip(np.searchsorted(knots, x) - 1, 0, len(knots) - 2)
    h = knots[i + 1] - knots[i]
    t = np.clip((x - knots[i]) / h, 0.0, 1.0)
    t2, t3 = t * t, t * t * t
    return ((2 * t3 - 3 * t2 + 1) * values[i] + (t3 - 2 * t2 + t) * h * slopes[i]
            + (3 * t2 - 2 * t3) * values[i + 1] + (t3 - t2) * h * slopes[i + 1])


def hull(x, y, z):
    """Returns the lower body: superelliptic sections of varying height and width."""
    low, high, half = along(x, 1), along(x, 2), along(x, 3)
    middle, tall = 0.5 * (low + high), 0.5 * (high - low)
    u = np.abs((x + 0.045) / 2.10)
    v = np.abs(y - middle) / tall
    w = np.abs(z) / (half - 0.05 * smoothstep(0.0, 1.1, v))
    section = (v ** 3.2 + w ** 3.6 + 1e-9) ** (1.0 / 3.4)
    r = (section ** 5.0 + u ** 5.0) ** 0.2
    size = np.minimum(np.minimum(tall, half), 0.45)
    return (r - 1.0) * size


def fenders(x, y, z):
    """Adds the fenders over the wheels, and the nacelles of the headlamps."""
    az = np.abs(z)
    front = ellipsoid(x, y, az, (WHEEL_X[1] + 0.05, 0.50, 0.60), (0.62, 0.285, 0.235))
    rear = ellipsoid(x, y, az, (WHEEL_X[0] - 0.02, 0.55, 0.60), (0.66, 0.305, 0.250))
    lamp = cone(x, y, az, (1.30, 0.665, 0.560), (1.90, 0.654, 0.574), 0.150, 0.112)
    lamp = intersect(lamp, x - LAMP_AT[0], 0.02)  # cut flat for the lens
    return union(union(front, rear, 0.08), lamp, 0.06)


def cabin(x, y, z):
    """Returns roof and windows: narrower towards the top, with a fastback."""
    lift = np.clip((y - 0.78) / 0.46, -0.3, 1.2)
    ahead = 0.78 - 0.62 * lift - 0.05 * lift * lift
    behind = -1.72 + 0.78 * lift + 0.10 * lift * lift
    centre, half = 0.5 * (ahead + behind), 0.5 * (ahead - behind)
    u = np.abs(x - centre) / half
    w = np.abs(z) / (0.690 - 0.150 * lift - 0.06 * smoothstep(-0.2, -1.6, x))
    v = np.abs(y - 0.70) / (0.545 - 0.035 * ((x + 0.35) / 0.9) ** 2 * (np.abs(x + 0.35) < 2.0))
    return ((u ** 4.5 + w ** 4.0 + v ** 4.5 + 1e-9) ** (1.0 / 4.4) - 1.0) * 0.42


def shell(x, y, z):
    """Returns the outer surface before the wheel arches are cut; glass and trim are on this surface."""
    d = union(hull(x, y, z), fenders(x, y, z), 0.10)
    return union(d, cabin(x, y, z), 0.11)


def body(x, y, z):
    d = shell(x, y, z)
    az = np.abs(z)
    for centre in WHEEL_X:
        arch = np.sqrt((x - centre) ** 2 + (y - WHEEL_Y) ** 2) - 0.372
        d = subtract(d, np.maximum(arch, 0.42 - az), 0.040)
    grille = box(x, y, z, (2.05, 0.475, 0.0), (0.16, 0.072, 0.36), 0.06)
    d = subtract(d, grille, 0.03)
    sill = np.sqrt((y - 0.315) ** 2 + (az - 0.835) ** 2) - 0.022
    return subtract(d, np.maximum(sill, np.abs(x - 0.02) - 0.80), 0.02)


def panes(x, y, z):
    """Returns the outlines of the windows: negative inside a window."""
    az = np.abs(z)
    lift = (y - 0.78) / 0.46
    front_edge, rear_edge = 0.78 - 0.62 * lift, -1.72 + 0.78 * lift
    pillar_b = np.abs(x + 0.42 - 0.10 * lift) - 0.030
    side = np.maximum(np.maximum(0.895 - y, y - 1.150), np.maximum(x - front_edge + 0.20,
                                                                  rear_edge + 0.34 - x))
    side = intersect(side, -pillar_b, 0.03)
    side = intersect(side, 0.30 - az, 0.03)
    screen = np.maximum(np.maximum(0.890 - y, y - 1.158), az - (0.580 - 0.115 * lift))
    front = intersect(screen, front_edge - 0.135 - x, 0.05)
    back = intersect(np.maximum(screen, y - 1.120), x - rear_edge - 0.27, 0.05)
    return np.minimum(side, np.minimum(front, back))


def glass(x, y, z):
    """Returns panes that are 5 mm outside the shell and reach 45 mm into it, to avoid thin sheets."""
    outside = shell(x, y, z)
    return intersect(np.maximum(outside - 0.005, -0.045 - outside), panes(x, y, z), 0.010)


def chrome(x, y, z):
    """Returns bumpers, grille bars, lamp rings, mirrors and handles."""
    az = np.abs(z)
    d = chain(x, y, az, [(2.135, 0.395, 0.0), (2.105, 0.395, 0.30), (1.985, 0.400, 0.58),
                         (1.72, 0.415, 0.775)], [0.045, 0.045, 0.043, 0.030], 0.05)
    d = union(d, chain(x, y, az, [(-2.215, 0.46, 0.0), (-2.185, 0.46, 0.34), (-2.07, 0.46, 0.60),
                                  (-1.80, 0.46, 0.785)], [0.045, 0.045, 0.042, 0.030], 0.05), 0.01)
    for height in (0.445, 0.478, 0.511):
        bar = cone(x, y, az, (2.015, height, 0.0), (1.975, height, 0.36), 0.009, 0.009)
        d = union(d, bar, 0.004)
    ring = np.sqrt((y - LAMP_AT[1]) ** 2 + (az - LAMP_AT[2]) ** 2) - 0.104
    d = union(d, np.sqrt(ring * ring + (x - LAMP_AT[0]) ** 2) - 0.017, 0.005)
    d = union(d, ellipsoid(x, y, az, (0.52, 0.945, 0.770), (0.050, 0.038, 0.058)), 0.01)
    d = union(d, cone(x, y, az, (0.50, 0.80, 0.690), (0.52, 0.935, 0.760), 0.013, 0.011), 0.02)
    handle = chain(x, y, az, [(-0.36, 0.735, 0.824), (-0.33, 0.738, 0.842), (-0.20, 0.738, 0.842)],
                   [0.010, 0.011, 0.010], 0.01)
    return union(d, handle, 0.004)


def tail_lamps(x, y, z):
    az = np.abs(z)
    lamps = ellipsoid(x, y, az, (-2.035, 0.655, 0.520), (0.070, 0.062, 0.095))
    turn = ellipsoid(x, y, az, (2.015, 0.560, 0.530), (0.045, 0.028, 0.045))
    return np.minimum(lamps, turn)
