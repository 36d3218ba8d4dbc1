"""Meshes as binary PLY files, one for each of a mesh's materials."""

import os
from dataclasses import dataclass

import numpy as np

from .. import compat


@dataclass
class Part:
    """The faces of a mesh with one material."""

    slot: int
    file: str
    is_closed: bool
    reversed_file: str = ""  # the same faces seen from behind, a little further in


def write_ply(path, vertices, faces):
    """`vertices`: a structured array of float32 fields with the names of PLY's properties; `faces`: shape (n, 3)."""
    lines = ["ply", "format binary_little_endian 1.0", f"element vertex {len(vertices)}"]
    lines += [f"property float {name}" for name in vertices.dtype.names]
    lines += [f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header", ""]
    table = np.empty(len(faces), np.dtype([("n", "u1"), ("v", "<i4", 3)]))
    table["n"], table["v"] = 3, faces
    with open(path, "wb") as file:
        file.write("\n".join(lines).encode())
        file.write(vertices.tobytes())
        file.write(table.tobytes())


def _unique(rows):
    """The different rows of a matrix of float32, and the number of each row's among them."""
    rows = np.ascontiguousarray(rows + 0.0)  # no negative zeros
    keys = rows.view(np.dtype((np.void, rows.dtype.itemsize * rows.shape[1]))).reshape(-1)
    _, first, inverse = np.unique(keys, return_index=True, return_inverse=True)
    return rows[first], inverse.reshape(-1)


def _is_closed(triangles, positions):
    """Whether the faces close a volume with their outside outward: each edge twice, once in each direction."""
    _, vertex = _unique(positions)
    t = vertex[triangles]
    edges = np.concatenate([t[:, [0, 1]], t[:, [1, 2]], t[:, [2, 0]]]).astype(np.int64)
    count = int(vertex.max()) + 1
    forward, backward = edges[:, 0] * count + edges[:, 1], edges[:, 1] * count + edges[:, 0]
    if len(np.unique(forward)) != len(forward) or not np.array_equal(np.sort(forward), np.sort(backward)):
        return False
    p = positions[triangles].astype(np.float64)
    return float(np.einsum("ij,ij->i", p[:, 0], np.cross(p[:, 1], p[:, 2])).sum()) > 0


class Meshes:
    """Writes meshes on demand into `folder`/meshes; files that are the same are written once."""

    def __init__(self, folder, problems):
        self._folder, self._problems, self._count = folder, problems, 0

    def write(self, mesh, name, material_of):
        """The parts of a mesh of Blender. `material_of(slot)` gives the Material of a slot."""
        mesh.calc_loop_triangles()
        count = len(mesh.loop_triangles)
        if count == 0:
            return []
        corners = np.empty(3 * count, np.int32)
        mesh.loop_triangles.foreach_get("loops", corners)
        corners = corners.reshape(-1, 3)
        slots = np.empty(count, np.int32)
        mesh.loop_triangles.foreach_get("material_index", slots)
        positions = np.empty(3 * len(mesh.vertices), np.float32)
        mesh.vertices.foreach_get("co", positions)
        positions = positions.reshape(-1, 3)[compat.corner_vertices(mesh)]
        if not np.all(np.isfinite(positions)):
            self._problems.add(name, "the mesh has points that are not finite; it is left out")
            return []
        normals = compat.corner_normals(mesh)
        return [
            self._write_part(mesh, name, int(slot), material_of(int(slot)), corners[slots == slot], positions, normals)
            for slot in np.unique(slots)
        ]

    def _write_part(self, mesh, name, slot, material, corners, positions, normals):
        columns, names = [positions, normals], ["x", "y", "z", "nx", "ny", "nz"]
        if material.uv_map is not None:
            uvs = compat.corner_uvs(mesh, material.uv_map)
            if uvs is None:
                self._problems.add(name, f"the mesh has no UV map {material.uv_map!r}, which a picture needs".replace(" ''", ""))
                uvs = np.zeros((len(positions), 2), np.float32)
            # Mitsuba's pictures begin at the top.
            columns.append(np.stack([uvs[:, 0], 1 - uvs[:, 1]], axis=1))
            names += ["u", "v"]
        if material.mesh_color is not None:
            colors = compat.corner_colors(mesh, material.mesh_color)
            if colors is None:
                self._problems.add(name, f"the mesh has no color attribute {material.mesh_color!r}; it is black there")
                colors = np.zeros((len(positions), 3), np.float32)
            columns.append(np.clip(colors, 0, None))
            names += ["r", "g", "b"]
        used = corners.reshape(-1)
        rows, faces = _unique(np.concatenate([column[used] for column in columns], axis=1).astype(np.float32))
        faces = faces.reshape(-1, 3)
        part = Part(slot, self._store(rows, names, faces), _is_closed(corners, positions))
        if material.emits and not (part.is_closed and material.is_opaque):
            part.reversed_file = self._store(_behind(rows), names, faces[:, ::-1])
        return part

    def _store(self, rows, names, faces):
        os.makedirs(os.path.join(self._folder, "meshes"), exist_ok=True)
        file = f"meshes/{self._count}.ply"
        self._count += 1
        vertices = rows.astype("<f4").view(np.dtype([(name, "<f4") for name in names])).reshape(-1)
        write_ply(os.path.join(self._folder, file), vertices, faces)
        return file


def _behind(rows):
    """The back of an open mesh: moved by a hundred-thousandth of its size, so that rays from each side meet their own."""
    result = rows.copy()
    size = float(np.linalg.norm(np.ptp(rows[:, :3], axis=0)))
    result[:, :3] -= rows[:, 3:6] * max(size, 1e-6) * 1e-5
    result[:, 3:6] *= -1
    return result
