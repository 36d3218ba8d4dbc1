"""Triangle meshes for the scenes of the gallery: built with numpy, written as compressed PLY files.

All lengths are meters, and y is up. A mesh has an outside: its faces turn counterclockwise as seen from there, and
its normals point there.
"""

import gzip

import numpy as np


class Mesh:
    """Vertices (n x 3), unit normals (n x 3), texture coordinates (n x 2) and faces (m x 3 indices)."""

    def __init__(self, points, normals, uv, faces):
        self.points = np.asarray(points, float)
        self.normals = np.asarray(normals, float)
        self.uv = np.zeros((len(self.points), 2)) if uv is None else np.asarray(uv, float)
        self.faces = np.asarray(faces, int).reshape(-1, 3)

    def moved(self, x=0, y=0, z=0):
        return Mesh(self.points + (x, y, z), self.normals, self.uv, self.faces)

    def scaled(self, x, y=None, z=None):
        """By positive factors; one alone holds for all axes."""
        factors = np.array([x, x if y is None else y, x if z is None else z], float)
        return Mesh(self.points * factors, unit(self.normals / factors), self.uv, self.faces)

    def turned(self, axis, degrees):
        """Counterclockwise around the axis (0, 1, 2), as seen from its end."""
        a, b = (axis + 1) % 3, (axis + 2) % 3
        c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
        matrix = np.eye(3)
        matrix[a, a], matrix[a, b], matrix[b, a], matrix[b, b] = c, -s, s, c
        return Mesh(self.points @ matrix.T, self.normals @ matrix.T, self.uv, self.faces)

    def inverted(self):
        """Inside out."""
        return Mesh(self.points, -self.normals, self.uv, self.faces[:, ::-1])

    def write(self, path, uv=False, normals=True):
        """Coordinates are rounded to 2 micrometers, normals to 2^-13, so that the file compresses.

        Without normals, which the renderer makes for meshes without edges, it is half as large.
        """
        columns, names = [np.round(self.points * 2.0**19) / 2.0**19], ["x", "y", "z"]
        if normals:
            columns.append(np.round(self.normals * 2.0**13) / 2.0**13)
            names += ["nx", "ny", "nz"]
        if uv:
            columns.append(np.round(self.uv * 2.0**16) / 2.0**16)
            names += ["u", "v"]
        header = ["ply", "format binary_little_endian 1.0", f"element vertex {len(self.points)}"]
        header += [f"property float {name}" for name in names]
        header += [f"element face {len(self.faces)}", "property list uchar int vertex_indices", "end_header", ""]
        faces = np.empty(len(self.faces), [("count", "u1"), ("index", "<i4", 3)])
        faces["count"], faces["index"] = 3, self.faces
        data = "\n".join(header).encode() + np.hstack(columns).astype("<f4").tobytes() + faces.tobytes()
        with open(path, "wb") as file:
            file.write(gzip.compress(data, 9, mtime=0))


def unit(vectors):
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return vectors / np.where(length > 0, length, 1)


def joined(meshes):
    meshes = list(meshes)
    starts = np.cumsum([0] + [len(m.points) for m in meshes])
    return Mesh(np.vstack([m.points for m in meshes]), np.vstack([m.normals for m in meshes]),
                np.vstack([m.uv for m in meshes]), np.vstack([m.faces + s for m, s in zip(meshes, starts)]))


# Curves

def spline(points, steps=12):
    """A smooth curve through the points (Catmull-Rom, centripetal, so that it does not overshoot)."""
    p = np.asarray(points, float)
    p = np.vstack([2 * p[0] - p[1], p, 2 * p[-1] - p[-2]])
    curve = []
    for i in range(1, len(p) - 2):
        q = p[i - 1:i + 3]
        knots = np.concatenate([[0], np.cumsum(np.sqrt(np.linalg.norm(np.diff(q, axis=0), axis=1)))])
        t = np.linspace(knots[1], knots[2], steps, endpoint=False)[:, None]

        def between(a, b, i, j):
            return (knots[j] - t) / (knots[j] - knots[i]) * a + (t - knots[i]) / (knots[j] - knots[i]) * b

        first = [between(q[k], q[k + 1], k, k + 1) for k in range(3)]
        second = [between(first[k], first[k + 1], k, k + 2) for k in range(2)]
        curve.append(between(second[0], second[1], 1, 2))
    return np.vstack(curve + [p[-2]])


def arc(center, radius, start, end, steps=8):
    """Points of a circle in the plane; angles in degrees from the first axis."""
    angles = np.radians(np.linspace(start, end, steps + 1))
    return np.stack([center[0] + radius * np.cos(angles), center[1] + radius * np.sin(angles)], 1)


def offset(curve, distance):
    """The curve in the plane, moved to the left of its course."""
    tangent = unit(np.gradient(curve, axis=0))
    return curve + distance * np.stack([-tangent[:, 1], tangent[:, 0]], 1)


# Surfaces

def lathe(profile, segments=128, crease=40):
    """(radius, height) turns around the y axis; outside is to the right of its course.

    Where the profile bends by more than `crease` degrees, the surface has an edge.
    """
    p = np.asarray(profile, float)
    keep = np.concatenate([[True], np.linalg.norm(np.diff(p, axis=0), axis=1) > 1e-9])
    p = p[keep]
    direction = unit(np.diff(p, axis=0))
    normal = np.stack([direction[:, 1], -direction[:, 0]], 1)
    rows, normals = [], []
    length = np.linalg.norm(np.diff(p, axis=0), axis=1)
    for i in range(len(p)):
        smooth = 0 < i < len(p) - 1 and direction[i - 1] @ direction[i] > np.cos(np.radians(crease))
        if smooth:  # the shorter edge tells more of the direction here
            rows.append(i)
            normals.append(unit(normal[i - 1] / length[i - 1] + normal[i] / length[i]))
        else:
            for side in ([i - 1] if i > 0 else []) + ([i] if i < len(p) - 1 else []):
                rows.append(i)
                axis = p[i, 0] < 1e-9 and abs(normal[side][1]) > 0.5
                normals.append(np.array([0, np.sign(normal[side][1])]) if axis else normal[side])
    starts = [k for k in range(len(rows) - 1) if rows[k + 1] == rows[k] + 1]
    angle = 2 * np.pi * np.arange(segments + 1) / segments
    c, s = np.cos(angle), np.sin(angle)
    r, h = p[rows, 0][:, None], p[rows, 1][:, None]
    n = np.array(normals)
    points = np.stack([r * c, np.broadcast_to(h, (len(rows), segments + 1)), r * s], 2).reshape(-1, 3)
    turned = np.stack([n[:, :1] * c, np.broadcast_to(n[:, 1:], (len(rows), segments + 1)), n[:, :1] * s], 2)
    along = np.concatenate([[0], np.cumsum(length)])[rows]
    uv = np.stack(np.broadcast_arrays(angle / (2 * np.pi), along[:, None]), 2).reshape(-1, 2)
    faces = []
    for k in starts:
        a = k * (segments + 1) + np.arange(segments)
        b = a + segments + 1
        if r[k, 0] > 1e-9:
            faces.append(np.stack([a, b, a + 1], 1))
        if r[k + 1, 0] > 1e-9:
            faces.append(np.stack([a + 1, b, b + 1], 1))
    return Mesh(points, turned.reshape(-1, 3), uv, np.vstack(faces))


def sheet(position, columns, rows, u=(0, 1), v=(0, 1)):
    """position(u, v) gives points for arrays of parameters; outside is where u is to the right and v is up."""
    a, b = np.meshgrid(np.linspace(*u, columns + 1), np.linspace(*v, rows + 1))
    e = 1e-4 * (u[1] - u[0])
    points = np.stack(np.broadcast_arrays(*position(a, b)), 2)
    du = np.stack(np.broadcast_arrays(*position(a + e, b)), 2) - np.stack(np.broadcast_arrays(*position(a - e, b)), 2)
    dv = np.stack(np.broadcast_arrays(*position(a, b + e)), 2) - np.stack(np.broadcast_arrays(*position(a, b - e)), 2)
    i, j = np.meshgrid(np.arange(columns), np.arange(rows))
    k = (j * (columns + 1) + i).ravel()
    up = k + columns + 1
    faces = np.vstack([np.stack([k, k + 1, up + 1], 1), np.stack([k, up + 1, up], 1)])
    return Mesh(points.reshape(-1, 3), unit(np.cross(du, dv)).reshape(-1, 3),
                np.stack([a, b], 2).reshape(-1, 2), faces)


def rounded_box(x, y, z, radius, steps=4):
    """A box of these lengths around the origin with round edges; its faces have uv in meters."""
    half = np.array([x, y, z]) / 2
    round_off = np.tan(np.linspace(0, np.pi / 4, steps + 1))
    meshes = []
    for axis in range(3):
        a, b = (axis + 1) % 3, (axis + 2) % 3
        lines = [np.concatenate([-(half[k] - radius) - radius * round_off[::-1], half[k] - radius + radius * round_off])
                 for k in (a, b)]
        for side in (-1, 1):
            s, t = np.meshgrid(*lines)
            q = np.empty(s.shape + (3,))
            q[..., axis], q[..., a], q[..., b] = side * half[axis], s, t
            core = np.clip(q, -(half - radius), half - radius)
            normal = unit(q - core)
            i, j = np.meshgrid(np.arange(s.shape[1] - 1), np.arange(s.shape[0] - 1))
            k = (j * s.shape[1] + i).ravel()
            up = k + s.shape[1]
            faces = np.vstack([np.stack([k, k + 1, up + 1], 1), np.stack([k, up + 1, up], 1)])
            meshes.append(Mesh((core + radius * normal).reshape(-1, 3), normal.reshape(-1, 3),
                               np.stack([s, t], 2).reshape(-1, 2), faces if side > 0 else faces[:, ::-1]))
    return joined(meshes)


def tube(path, radius, sides=24, closed=False):
    """A round tube along the points; `radius` is one number or one a point. Without caps."""
    p = np.asarray(path, float)
    count = len(p)
    r = np.broadcast_to(np.asarray(radius, float), (count,))
    if closed:
        tangent = unit(np.roll(p, -1, 0) - np.roll(p, 1, 0))
    else:
        tangent = unit(np.gradient(p, axis=0))
    frame = np.cross(tangent[0], [0.3, 0.9, 0.1])
    frames = []
    for t in tangent:  # the frame is carried along, so that the tube does not twist
        frame = unit(frame - (frame @ t) * t)
        frames.append(frame)
    first = np.array(frames)
    second = np.cross(tangent, first)
    if closed:  # what it has turned by at the end is spread over the whole
        last = unit(first[-1] - (first[-1] @ tangent[0]) * tangent[0])
        twist = np.arctan2(last @ second[0], last @ first[0])
        turn = -twist * np.arange(count)[:, None] / count
        first, second = (np.cos(turn) * first + np.sin(turn) * second, np.cos(turn) * second - np.sin(turn) * first)
    if closed:  # the seam has vertices of its own, for the texture
        p, r = np.vstack([p, p[:1]]), np.append(r, r[0])
        first, second = np.vstack([first, first[:1]]), np.vstack([second, second[:1]])
        count += 1
    angle = 2 * np.pi * np.arange(sides + 1) / sides
    normals = first[:, None] * np.cos(angle)[:, None] + second[:, None] * np.sin(angle)[:, None]
    points = p[:, None] + r[:, None, None] * normals
    uv = np.stack(np.meshgrid(angle / (2 * np.pi), np.arange(count) / (count - 1)), 2)
    i, j = np.meshgrid(np.arange(sides), np.arange(count - 1))
    a = (j * (sides + 1) + i).ravel()
    b = a + sides + 1
    faces = np.vstack([np.stack([a, a + 1, b + 1], 1), np.stack([a, b + 1, b], 1)])
    return Mesh(points.reshape(-1, 3), normals.reshape(-1, 3), uv.reshape(-1, 2), faces)


def ball(radius, segments=32):
    return lathe(arc((0, 0), radius, -90, 90, segments // 2), segments)
