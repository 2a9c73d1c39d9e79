"""One storey of an exported map folder: where a robot can be, how it gets from place to place, what can be seen from there.

Places are in cells from the lower left corner of the grid, lengths too unless their names end in `_m`. The grid is what of the
files is near free cells, with a ring of unknown cells around it, so that nothing leaves it.
"""
import math

import numpy as np
from PIL import Image

from check_world import elevation

FREE, OCCUPIED, UNKNOWN = 254, 0, 205
# Names of the values of classes.png.
CLASSES = ("none", "wall", "column", "door", "window", "stair", "ramp", "railing", "furniture", "curtain_wall", "slab", "beam", "mep", "other")
# The sides of a cell: which way they look.
SIDES = np.array([(1, 0), (-1, 0), (0, 1), (0, -1)])
# A line that cuts this little of a cell's corner does not run through it.
CORNER = 1e-6
# Files have four decimals: a millimetre is none.
ROUNDED_M = 0.001
# Site plans are larger than what Pillow takes for an attack.
Image.MAX_IMAGE_PIXELS = None


class Storey:
    """The grids of a storey, and the parts of it in which a robot can get around."""

    def __init__(self, out, entry, resolution_m, radius_m):
        self.floor_z_m, self.resolution_m = entry["floor_z_m"], resolution_m
        folder = out / entry["directory"]
        planning = image(folder / "planning.pgm", entry)
        # What is more than two cells off the free ones has no say in anything.
        ends = [np.flatnonzero((planning == FREE).any(axis)) for axis in (0, 1)]
        low, high = ([max(0, e[0] - 2) if len(e) else 0 for e in ends], [e[-1] + 3 if len(e) else 1 for e in ends])
        cut = np.s_[low[1]:high[1], low[0]:high[0]]
        self.origin_m = np.array(entry["origin_m"][:2]) + np.array(low) * resolution_m
        planning = np.pad(planning[cut], 1, constant_values=UNKNOWN)
        self.size = planning.shape[1] - 2, planning.shape[0] - 2
        self.free, self.occupied = planning == FREE, planning == OCCUPIED
        self.is_outdoors, self.height_m = entry["floor"] == "ground", None
        if (folder / "elevation.yaml").exists():
            there, height_m, _, _ = elevation(folder)
            self.height_m = np.pad(np.where(there, height_m, np.nan)[cut], 1, constant_values=np.nan)
        self.keep_out = np.pad(image(folder / "keepout.pgm", entry)[cut], 1) == 0
        classes = np.pad(image(folder / "classes.png", entry)[cut], 1)
        self.classes = np.where(self.occupied, classes, 0)
        # Treads on which the robot drives.
        self.stairs = self.free & (classes == CLASSES.index("stair"))
        # Distance of the map's free cells to what is not free; the ring counts for lines only.
        limit = max(16, math.ceil(radius_m / resolution_m) + 1)
        clear = np.pad(distances(self.free[1:-1, 1:-1], limit), 1)
        self.leap = distances(self.free, 16)
        self.stands = self.free & ~self.keep_out & (clear * resolution_m >= radius_m - 1e-4)
        self.part, self.n_cells = parts(self.stands)
        near_free = grown(self.free, SIDES) & ~self.free
        near_free[[0, -1]] = near_free[:, [0, -1]] = False
        self.borders = np.argwhere(near_free)[:, ::-1] + 0.5

    def places(self, points_m):
        """Points in `map` as places."""
        return (np.asarray(points_m, float).reshape(-1, 2) - self.origin_m) / self.resolution_m + 1

    def points_m(self, places):
        """The other way."""
        return (places - 1) * self.resolution_m + self.origin_m

    def z_m(self, points_m):
        """Height of the ground at points: nan in a doorway without floor."""
        if self.height_m is None:
            return np.full(len(np.reshape(points_m, (-1, 2))), self.floor_z_m)
        columns, rows = np.floor(self.places(points_m) + 1e-9).astype(int).T
        return self.height_m[rows, columns]

    def normal(self, point_m, radius_m):
        """Normal of the plane that fits the heights of the free cells under a robot best."""
        if self.height_m is None:
            return np.array([0.0, 0.0, 1.0])
        reach_m = max(radius_m, 1.5 * self.resolution_m)
        rows, columns = self.cells_around(np.add(point_m, [[-reach_m], [reach_m]]))
        off_m = self.points_m(np.stack([columns, rows], 1) + 0.5) - point_m
        height_m = self.height_m[rows, columns]
        near = (np.hypot(*off_m.T) <= reach_m + 1e-6) & self.free[rows, columns] & ~np.isnan(height_m)
        plane = np.column_stack([off_m[near], np.ones(near.sum())])
        gradient = np.linalg.lstsq(plane, height_m[near], rcond=None)[0][:2]
        return np.array([*-gradient, 1.0]) / math.sqrt(1 + gradient @ gradient)

    def cells_around(self, points_m):
        """(rows, columns) of all cells in the box around points."""
        low, high = (self.places(points_m).min(0), self.places(points_m).max(0))
        low, high = np.maximum(low, 1).astype(int), np.minimum(high + 1, np.array(self.size) + 1).astype(int)
        columns, rows = np.meshgrid(np.arange(low[0], high[0]), np.arange(low[1], high[1]))
        return rows.ravel(), columns.ravel()

    def cell(self, place):
        """(row, column); None outside of the map."""
        column, row = (int(c) for c in np.floor(place + 1e-9))
        return (row, column) if 1 <= column <= self.size[0] and 1 <= row <= self.size[1] else None

    def clearance_m(self, places):
        """The least distance of any of the places to the middle of a cell that is not free; 0 on one that is not."""
        cells = [self.cell(p) for p in places]
        if not all(c and self.free[c] for c in cells):
            return 0.0
        # Of all borders only what can be nearest: not farther than the nearest one of the first place allows.
        first = np.hypot(*(self.borders - places[0]).T).min(initial=math.inf)
        low, high = places.min(0) - first, places.max(0) + first
        near = self.borders[((self.borders >= low) & (self.borders <= high)).all(1)]
        far = np.hypot(near[:, 0] - places[:, :1], near[:, 1] - places[:, 1:])
        return float(far.min(initial=first)) * self.resolution_m

    def part_at(self, place):
        """The part at a place, or that of a cell beside it, because a place between the middles of cells may be clear although
        that of its own cell is not; 0 for none."""
        cell = self.cell(place)
        if cell is None:
            return 0
        row, column = cell
        around = self.part[row - 1:row + 2, column - 1:column + 2]
        return int(self.part[cell] or around.max())

    def way_m(self, start, end, limit_m):
        """Length of the shortest way on which the robot can be, in steps to the eight cells around; infinite above a limit."""
        width = self.stands.shape[1]
        stands = self.stands.ravel()
        start, end = (self._standing_near(p) for p in (start, end))
        length = np.full(stands.size, np.inf)
        length[start] = 0
        steps = np.array([1, -1, width, -width])
        corners = np.array([(1, width), (1, -width), (-1, width), (-1, -width)])
        front = np.array([start])
        limit = limit_m / self.resolution_m
        while len(front):
            sides = [(front, front + s, 1.0) for s in steps]
            # No way squeezes between two cells that meet at a corner.
            diagonals = [(front, front + a + b, math.sqrt(2)) for a, b in corners]
            passes = [stands[front + s] for s in steps] + [stands[front + a] & stands[front + b] for a, b in corners]
            reached = []
            for (at, to, step), can_pass in zip(sides + diagonals, passes):
                further = length[at] + step
                rest = np.hypot(to % width - end % width, to // width - end // width)
                better = can_pass & stands[to] & (further < length[to]) & (further + rest <= limit)
                # No two cells of the front step to the same one in one direction.
                length[to[better]] = further[better]
                reached.append(to[better])
            front = np.unique(np.concatenate(reached))
        return float(length[end]) * self.resolution_m

    def _standing_near(self, place):
        row, column = self.cell(place)
        around = [(row + r, column + c) for r in (-1, 0, 1) for c in (-1, 0, 1) if self.stands[row + r, column + c]]
        nearest = min(around, key=lambda c: math.hypot(c[1] + 0.5 - place[0], c[0] + 0.5 - place[1]))
        return nearest[0] * self.stands.shape[1] + nearest[1]


def image(path, entry):
    """The pixels of a storey's file, the lowest row first."""
    pixels = np.asarray(Image.open(path))
    if pixels.shape != tuple(entry["size_cells"][::-1]):
        raise ValueError(f"{path}: {pixels.shape} is not a grey image of {entry['size_cells']} cells")
    return np.flipud(pixels)


def distances(is_open, limit):
    """Distance in cells from the middle of each cell to that of the nearest one that is not open, at most `limit`."""
    along = np.where(is_open, np.float32(limit), np.float32(0))
    for row in range(1, len(along)):
        np.minimum(along[row], along[row - 1] + 1, out=along[row])
    for row in range(len(along) - 2, -1, -1):
        np.minimum(along[row], along[row + 1] + 1, out=along[row])
    along *= along
    squared = along.copy()
    for k in range(1, min(limit, is_open.shape[1])):
        np.minimum(squared[:, k:], along[:, :-k] + k * k, out=squared[:, k:])
        np.minimum(squared[:, :-k], along[:, k:] + k * k, out=squared[:, :-k])
    return np.sqrt(squared).clip(max=limit)


def grown(cells, directions):
    """The cells and those beside them in the directions (x, y); the outermost ring stays as it is."""
    more = cells.copy()
    rows, columns = cells.shape
    for x, y in directions:
        more[1:-1, 1:-1] |= cells[1 - y:rows - 1 - y, 1 - x:columns - 1 - x]
    return more


def parts(stands):
    """(number of the part of each cell, from 1; number of cells of each part, from part 0, which has none). Cells that meet
    along a side are one part."""
    part = np.zeros(stands.shape, np.int32)
    n_cells = [0]
    flat, waiting = part.ravel(), np.flatnonzero(stands)
    while len(waiting):
        flood(stands, waiting[:1], flat, len(n_cells), SIDES)
        rest = waiting[flat[waiting] == 0]
        n_cells.append(len(waiting) - len(rest))
        waiting = rest
    return part, np.array(n_cells)


def flood(is_open, front, marks, mark, directions):
    """Marks what can be got to from the cells of `front` through open cells that have no mark yet."""
    steps = directions @ [1, is_open.shape[1]]
    is_open = is_open.ravel()
    marks[front] = mark
    while len(front):
        near = np.unique((front[:, None] + steps).ravel())
        front = near[is_open[near] & (marks[near] == 0)]
        marks[front] = mark


def are_clear(leap, starts, ends):
    """Whether each straight line runs through open cells only: those that are not 0 in `leap`, which is how far from the middle
    of a cell all is open, or 1."""
    last = np.array(leap.shape[::-1]) - 1
    way = ends - starts
    length = np.hypot(way[:, 0], way[:, 1])
    direction = way / np.maximum(length, 1e-12)[:, None]
    clear = np.ones(len(starts), bool)
    gone, line = np.zeros(len(starts)), np.arange(len(starts))
    while len(line):
        at = starts[line] + direction[line] * gone[:, None]
        # What is outside of the grid is like its ring.
        cell = np.clip(np.floor(at), 0, last).astype(np.int64)
        free = leap[cell[:, 1], cell[:, 0]]
        clear[line[free == 0]] = False
        # To the border of the cell, or as far as what is not open must be away.
        ahead = np.where(direction[line] > 0, cell + 1 - at, at - cell) / np.maximum(np.abs(direction[line]), 1e-12)
        gone = gone + np.where(free >= 2.5, free - 1.5, ahead.min(1) + CORNER)
        on = (free > 0) & (gone < length[line])
        line, gone = line[on], gone[on]
    return clear


class Faces:
    """The sides of elements of some classes that look at free cells: middles, normals, and which way the sides look."""

    def __init__(self, storey, classes):
        is_target = np.isin(storey.classes, [CLASSES.index(name) for name in classes])
        middles, sides, fronts = [], [], []
        for x, y in SIDES:
            rows, columns = np.nonzero(is_target & np.roll(storey.free, (-y, -x), (0, 1)))
            cells = np.stack([columns, rows], 1)
            middles.append(cells + 0.5 + 0.5 * np.array([x, y]))
            sides.append(np.broadcast_to((x, y), cells.shape))
            fronts.append(cells + (x, y))
        self.middles, self.sides, self.fronts = (np.concatenate(a) for a in (middles, sides, fronts))
        self.normals = normals(storey.occupied, self.fronts, self.sides)


def normals(occupied, fronts, sides):
    """Away from the occupied cells of the 5 x 5 window around each front that hang together with the side's own cell."""
    offsets = np.arange(-2, 3)
    rows, columns = fronts[:, 1, None, None] + 2 + offsets[:, None], fronts[:, 0, None, None] + 2 + offsets
    window = np.pad(occupied, 2)[rows, columns]
    surface = np.zeros(window.shape, bool)
    surface[np.arange(len(fronts)), 2 - sides[:, 1], 2 - sides[:, 0]] = True
    while True:
        more = np.pad(surface, ((0, 0), (1, 1), (1, 1)))
        more = more[:, :-2] | more[:, 1:-1] | more[:, 2:]
        more = (more[:, :, :-2] | more[:, :, 1:-1] | more[:, :, 2:]) & window
        if (more == surface).all():
            break
        surface = more
    away = -np.stack([(surface * offsets).sum((1, 2)), (surface * offsets[:, None]).sum((1, 2))], 1).astype(float)
    is_level = (away == 0).all(1)
    away[is_level] = sides[is_level]
    return away / np.hypot(away[:, 0], away[:, 1])[:, None]


def depth_m(polygon, points_m):
    """How far points lie inside of a MultiPolygon; negative outside."""
    points = np.asarray(points_m, float).reshape(-1, 2)
    is_odd, nearest = np.zeros(len(points), bool), np.full(len(points), np.inf)
    for ring in (ring for rings in polygon for ring in rings):
        for a, b in zip(np.array(ring)[:-1], np.array(ring)[1:]):
            side, to = b - a, points - a
            along = np.clip(to @ side / max(side @ side, 1e-30), 0, 1)
            nearest = np.minimum(nearest, np.hypot(*(to - along[:, None] * side).T))
            crosses = (a[1] > points[:, 1]) != (b[1] > points[:, 1])
            if side[1] != 0:
                is_odd ^= crosses & (to[:, 0] < side[0] * to[:, 1] / side[1])
    return np.where(is_odd, nearest, -nearest)
