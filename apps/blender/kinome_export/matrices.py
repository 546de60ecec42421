"""Transforms between the frames of Blender and Mitsuba."""
import numpy as np


def scaling(x, y, z):
    return np.diag([x, y, z, 1.0])


# Both turn by 180 degrees. Blender's cameras look along their -z axis with +x to the right, Mitsuba's
# along +z with +x to the left. Blender's lights shine along -z, Mitsuba's along +z.
TURN_Y = scaling(-1, 1, -1)
TURN_X = scaling(1, -1, -1)

# Maps the directions of Mitsuba's latitude-longitude images to those of Blender's: the centre column
# from +z to +x, the column to its left by a quarter from +x to +y, the top row from +y to +z.
ENVIRONMENT = np.array([[0, 0, 1, 0], [1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 1]], dtype=float)


def without_scale(matrix):
    """Returns the transform with axes of length 1."""
    result = np.array(matrix, dtype=float)
    result[:3, :3] /= np.linalg.norm(result[:3, :3], axis=0)
    return result


def scales(matrix):
    """Returns the lengths of the three axes."""
    return np.linalg.norm(np.asarray(matrix, dtype=float)[:3, :3], axis=0)


def euler_xyz(angles):
    """Returns the rotation of Blender's Euler angles [rad]: about x first, then y, then z."""
    (cx, cy, cz), (sx, sy, sz) = np.cos(angles), np.sin(angles)
    x = np.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]])
    y = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
    z = np.array([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]])
    return z @ y @ x


def homogeneous(linear, offset=(0, 0, 0)):
    result = np.eye(4)
    result[:3, :3] = linear
    result[:3, 3] = offset
    return result
