"""The assets of the chess scene: an endgame of turned pieces, and the map of the table."""

from . import box, files, grace, solids, stone

FOOT = [(0.33, 0.0), (0.34, 0.07), (0.28, 0.10)]
# Profiles above the foot: (radius, height) of smooth curves.
PIECES = {
    "pawn": [(0.27, 0.12), (0.14, 0.30), (0.11, 0.50), (0.19, 0.53), (0.13, 0.56), (0.185, 0.68),
             (0.13, 0.80), (0.0, 0.83)],
    "bishop": [(0.29, 0.12), (0.15, 0.34), (0.11, 0.70), (0.21, 0.74), (0.13, 0.78), (0.195, 0.92),
               (0.10, 1.10), (0.04, 1.14), (0.06, 1.18), (0.0, 1.22)],
    "rook": [(0.29, 0.12), (0.19, 0.30), (0.17, 0.62), (0.25, 0.68), (0.26, 0.86), (0.20, 0.87),
             (0.19, 0.78), (0.0, 0.77)],
    "queen": [(0.30, 0.12), (0.17, 0.38), (0.12, 0.92), (0.24, 0.97), (0.14, 1.02), (0.25, 1.32),
              (0.19, 1.33), (0.16, 1.28), (0.06, 1.34), (0.07, 1.40), (0.0, 1.45)]}
# (piece, file, rank); the corners of the board are (0, 0) and (8, 8).
WHITE = (("queen", 3, 2), ("rook", 6, 0), ("bishop", 4, 4), ("pawn", 0, 1), ("pawn", 1, 2),
         ("pawn", 5, 1), ("pawn", 6, 3), ("pawn", 7, 1))
BLACK = (("queen", 5, 5), ("rook", 0, 7), ("rook", 2, 6), ("bishop", 6, 5), ("pawn", 1, 5),
         ("pawn", 3, 5), ("pawn", 7, 5))


def piece(name, steps):
    return stone.lathe(FOOT + solids.curve(PIECES[name], steps), 8 * steps)


def side(places, steps):
    """Returns one player's pieces. The board is centred, squares have width 1, and ranks go backwards."""
    pieces = {name: piece(name, steps) for name in PIECES}
    return box.together([solids.moved(pieces[name], (x - 3.5, 0.0, 3.5 - y))
                         for name, x, y in places])


def make(folder, scale):
    """Writes the files. Returns the number of triangles."""
    steps = max(3, int(round(8 / scale)))
    files.write_png(folder / "planks.png", grace.planks(512, 512))
    frame = solids.cuboid((-4.5, -0.4, -4.5), (4.5, -0.002, 4.5))
    return files.write_plys(folder, {"white": side(WHITE, steps), "black": side(BLACK, steps),
                                     "frame": frame})
