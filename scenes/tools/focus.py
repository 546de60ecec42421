"""The assets of the focus scene: a file of chess pieces, from near to far."""

from . import box, chess, files, solids

LINE = ("rook", "pawn", "bishop", "pawn", "queen", "pawn", "bishop", "pawn", "rook")


def make(folder, scale):
    """Writes the files. Returns the number of triangles."""
    steps = max(3, int(round(8 / scale)))
    meshes = {}
    for row, name in enumerate(("white", "black")):
        meshes[name] = box.together([
            solids.moved(chess.piece(piece, steps), (1.1 * row - 0.55, 0.0, 5 - 1.6 * i))
            for i, piece in enumerate(LINE) if (i + row) % 2 == 0])
    return files.write_plys(folder, meshes)
