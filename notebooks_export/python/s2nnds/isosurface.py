# SPDX-License-Identifier: BSD-3-Clause
"""The surface {level = 0} of samples on a 3-D grid, as triangles, by marching tetrahedra."""

import numpy as np

# Each cell is cut into six tetrahedra around its diagonal 0-7; bit 2 of a corner's number steps along axis 0,
# bit 1 along axis 1, bit 0 along axis 2.
_TETRAHEDRA = np.array([(0, 1, 3, 7), (0, 1, 5, 7), (0, 2, 3, 7), (0, 2, 6, 7), (0, 4, 5, 7), (0, 4, 6, 7)])
_CORNERS = np.array([(i, j, k) for i in (0, 1) for j in (0, 1) for k in (0, 1)])

# Vertices sorted by level: the edges that the surface cuts depend only on how many of the four are inside.
_EDGES = {
    1: [((0, 1), (0, 2), (0, 3))],
    2: [((0, 2), (0, 3), (1, 3)), ((0, 2), (1, 3), (1, 2))],
    3: [((3, 0), (3, 1), (3, 2))],
}


def isosurface(axes, level):
    """Triangles [T, 3, 3] of {level = 0}, of arbitrary orientation.

    `level` [N0, N1, N2] is sampled on axes[0] x axes[1] x axes[2]; inside is <= 0.
    """
    level = np.asarray(level, dtype=float)
    cells = np.stack(np.meshgrid(*(np.arange(size - 1) for size in level.shape), indexing="ij"), -1).reshape(
        -1, 3
    )
    corners = cells[:, None, :] + _CORNERS  # [cells, 8, 3]
    values = level[tuple(np.moveaxis(corners, -1, 0))]
    crossed = np.isfinite(values).all(axis=1) & (values.min(axis=1) <= 0.0) & (values.max(axis=1) > 0.0)
    corners, values = corners[crossed], values[crossed]
    points = np.stack([np.asarray(axes[k])[corners[..., k]] for k in range(3)], -1)

    values = values[:, _TETRAHEDRA].reshape(-1, 4)
    points = points[:, _TETRAHEDRA].reshape(-1, 4, 3)
    order = np.argsort(values, axis=1)
    values = np.take_along_axis(values, order, axis=1)
    points = np.take_along_axis(points, order[..., None], axis=1)
    inside = np.sum(values <= 0.0, axis=1)

    triangles = []
    for count, faces in _EDGES.items():
        v, p = values[inside == count], points[inside == count]
        for face in faces:
            cuts = []
            for a, b in face:
                share = (v[:, a] / (v[:, a] - v[:, b]))[:, None]
                cuts.append(p[:, a] + share * (p[:, b] - p[:, a]))
            triangles.append(np.stack(cuts, axis=1))
    return np.concatenate(triangles)
