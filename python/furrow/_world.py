"""A world and its bodies."""
import ctypes
import json
import math
import operator
import os
import threading
import weakref
from typing import Any, Iterable, Optional, Sequence, Tuple, Union

import numpy

from furrow import _arrays
from furrow import _declarations as declared
from furrow._declarations import Contact, Info, Layer, Pose, State, Status
from furrow._library import Error, Path, call, text, yaml
from furrow._vehicle import Vehicle

Vector = Union[Sequence[float], numpy.ndarray]

STATE = numpy.dtype(declared.furrow_state)
CONTACT = _arrays.columns(numpy.dtype(declared.furrow_contact))
POINT = _arrays.columns(numpy.dtype(declared.furrow_point))
HIT = _arrays.columns(numpy.dtype(declared.furrow_hit))
RECT = numpy.dtype(declared.furrow_rect)
METRES = (Layer.SURFACE, Layer.BASE, Layer.OFFSET, Layer.DEPOSITED, Layer.SINKAGE)
LEVEL_WITH_NO_TURN = (1.0, 0.0, 0.0, 0.0)
CHASE = (-6.0, 3.0)  # m: where render is from what it looks at: to the north, and up
LEAST_ABOVE = 1.0    # m: of that place above the ground
OVERVIEW = 0.6       # rad: how steeply render looks down on a whole terrain
UNKNOWN = (math.nan, math.nan, math.nan)  # a velocity that is to be that of the poses


def _array(values: Any, what: str, *shape: int) -> numpy.ndarray:
    """float64 rows of `shape`, one after another: `values` itself where it is that already, else a copy."""
    array = numpy.ascontiguousarray(values, dtype=numpy.float64)
    if array.shape[array.ndim - len(shape):] != shape or array.ndim < len(shape):
        raise ValueError(f"furrow: {what} has the shape {array.shape}; it must end with {shape}")
    return array


def _structs(values: Any, dtype: numpy.dtype, count: int, what: str) -> numpy.ndarray:
    array = numpy.ascontiguousarray(values, dtype=dtype)
    if array.shape != (count,):
        raise ValueError(f"furrow: {what} has the shape {array.shape}; it must be ({count},)")
    return array


def _pose(position: Vector, orientation: Vector) -> declared.furrow_pose:
    return declared.furrow_pose((ctypes.c_double * 3)(*_array(position, "position", 3)),
                                (ctypes.c_double * 4)(*_array(orientation, "orientation", 4)))


def _close(handle: int) -> None:
    """Closes a world that nobody closed, when it is collected or Python ends. There is nobody to tell of a failure."""
    try:
        call("furrow_world_close", handle)
    except Exception:  # pylint: disable=broad-except
        pass


class Body:
    """What touches the ground. World.add and World.body make it; it belongs to its world."""

    def __init__(self, world: "World", handle: int) -> None:
        self.world = world
        self.handle = handle

    def place(self, position: Vector, orientation: Vector = LEVEL_WITH_NO_TURN) -> None:
        """Puts the body somewhere without touching what is between, at rest.

        position: (3,), m, local axes. orientation: (4,), a quaternion w, x, y, z.
        """
        pose = _pose(position, orientation)
        self.world._call("furrow_place", self.handle, ctypes.byref(pose))

    def set(self, position: Vector, orientation: Vector = LEVEL_WITH_NO_TURN, linear: Optional[Vector] = None,
            angular: Optional[Vector] = None) -> None:
        """Says where the body is at the end of the next step, and how it moves there.

        position: (3,), m. orientation: (4,), a quaternion w, x, y, z. linear: (3,), m/s, of the body's origin.
        angular: (3,), rad/s. All of them in local axes: x east, y north, z up.

        Without linear or angular, the velocity is that of the poses: from the one after the last step, or from the place, to this one, in the
        time of the next step. A body that turns by more than half a turn in a step needs angular. Its slip would be wrong. Poses that do
        not turn with a wheel say that it is locked.
        """
        linear, angular = (UNKNOWN if rate is None else rate for rate in (linear, angular))
        state = declared.furrow_state(_pose(position, orientation),
                                      (ctypes.c_double * 3)(*_array(linear, "linear", 3)),
                                      (ctypes.c_double * 3)(*_array(angular, "angular", 3)))
        handle = ctypes.c_int32(self.handle)
        self.world._call("furrow_set_states", 1, ctypes.byref(handle), ctypes.byref(state))

    def run_belt(self, travel: float, speed: float) -> None:
        """Says how far the body's belt has run at the end of the next step, m, and how fast it runs, m/s: forward, as the body goes."""
        handle, belt = ctypes.c_int32(self.handle), declared.furrow_belt(travel, speed)
        self.world._call("furrow_set_belts", 1, ctypes.byref(handle), ctypes.byref(belt))

    @property
    def state(self) -> State:
        """Where the body is now, and how it moves: .position (3,), m; .orientation (4,); .velocity (3,), m/s, also .linear; .angular (3,)."""
        state, handle = declared.furrow_state(), ctypes.c_int32(self.handle)
        self.world._call("furrow_get_states", 1, ctypes.byref(handle), ctypes.byref(state))
        return State(state)

    @property
    def contact(self) -> Contact:
        """What the soil did to the body in the last step: .force (3,), N; .moment (3,), N m; .sinkage, m; .state; and more.

        Off the terrain and over holes in it there is no soil: the force is 0 and .state is ContactState.AIR, as high above the ground.
        Nothing is raised. To know which it is, ask World.points for ["nodata"] there.
        """
        contact, handle = declared.furrow_contact(), ctypes.c_int32(self.handle)
        self.world._call("furrow_get_contacts", 1, ctypes.byref(handle), ctypes.byref(contact), ctypes.sizeof(contact))
        return Contact(contact)

    def remove(self) -> None:
        """Takes the body away. Its soil is unloaded, and the body cannot be used any more."""
        self.world._call("furrow_body_remove", self.handle)

    def __repr__(self) -> str:
        return f"Body({self.handle})"


Bodies = Sequence[Union[Body, int]]


def _handles(bodies: Bodies) -> numpy.ndarray:
    if isinstance(bodies, numpy.ndarray) and bodies.dtype == numpy.int32 and bodies.flags.c_contiguous:
        return bodies
    return numpy.array([body.handle if isinstance(body, Body) else body for body in bodies], dtype=numpy.int32)


class World:
    """A terrain that is open for simulation.

    Several threads may use several worlds at once. Calls of one world from several threads wait for each other.
    """

    def __init__(self, scene: Union[dict, Path], store: Optional[Path] = None, *, overlay: Optional[Path] = None,
                 output: Optional[Path] = None, resume: bool = False, durable: bool = False,
                 keep_history: bool = False, readonly: bool = False) -> None:
        """Opens a world.

        scene: a dict, the scene's text (a str with a line break or a brace), or the path of a scene.
        store: path of the terrain; None: the scene names it. overlay: path of a file that keeps the deformation; the store is
        only read then. output: folder for run.json and objects.csv; None: neither is written. resume: go on from the store's
        last drive of this scene. durable: a commit survives a power cut. keep_history: each commit keeps what it replaces, so that
        `furrow restore` returns to any. readonly: only to look. Nothing is ever written, so files and folders without write permission
        will do; step, checkpoint, Body.place and Body.set raise.

        Until the first step no byte of store and overlay changes, whatever is added, placed, probed, asked or drawn.
        """
        given = declared.furrow_open(size=ctypes.sizeof(declared.furrow_open), store=text(store), overlay=text(overlay),
                                     output=text(output), resume=resume, durable=durable,
                                     keep_history=keep_history, readonly=readonly)
        if isinstance(scene, dict):
            given.scene = yaml({"scene": 1, **scene})
        elif isinstance(scene, str) and ("\n" in scene or "{" in scene):
            given.scene = scene.encode()
        else:
            given.scene_file = text(scene)
        handle = ctypes.c_void_p()
        call("furrow_world_open", ctypes.byref(given), ctypes.byref(handle))
        self._lock = threading.RLock()
        self._handle: Optional[int] = handle.value
        self._forgotten = weakref.finalize(self, _close, handle.value)

    def _call(self, name: str, *arguments: Any) -> Any:
        """A closed world is NULL to the library."""
        with self._lock:
            try:
                return call(name, self._handle, *arguments)
            except Error as error:
                if self._handle is None:
                    raise Error(error.status, "world: it is closed; open it again with furrow.World") from None
                raise

    # --- life ---

    def __enter__(self) -> "World":
        return self

    def __exit__(self, *_: Any) -> None:
        self.close()

    def close(self) -> None:
        """Commits the ground as it is and frees the world. A closed world is closed again without effect.

        An Error with Status.NO_GL: the world is still open; release the thread's own GL context and close it again.
        """
        with self._lock:
            handle, self._handle = self._handle, None
            self._forgotten.detach()
            if handle is None:
                return
            try:
                call("furrow_world_close", handle)
            except Error as error:
                if error.status == Status.NO_GL:
                    self._handle = handle
                    self._forgotten = weakref.finalize(self, _close, handle)
                raise

    def step(self, seconds: float = 0.0) -> None:
        """Moves time on by `seconds`; 0: by the scene's time_step. Ctrl-C is raised when the step is over."""
        self._call("furrow_step", seconds)

    @property
    def time(self) -> float:
        """Simulated seconds since the scene's start; NaN of a closed world."""
        return self._call("furrow_time")

    def checkpoint(self) -> None:
        """Commits all so far. The store then holds it, and rollback returns to it."""
        self._call("furrow_checkpoint")

    def rollback(self) -> None:
        """Goes back to the last checkpoint, or to the opening: ground, bodies, forces, time and objects.csv."""
        self._call("furrow_rollback")

    @property
    def info(self) -> Info:
        """What the world is: .spacing (m), .columns, .rows, .level, .extent (2,), m, .time_step (s), .revision, and more."""
        info = declared.furrow_info(size=ctypes.sizeof(declared.furrow_info))
        self._call("furrow_info", ctypes.byref(info))
        return Info(info)

    @property
    def stats(self) -> dict:
        """What run.json would say now."""
        found = ctypes.c_void_p()
        self._call("furrow_stats", ctypes.byref(found))
        try:
            return json.loads(ctypes.string_at(found.value))
        finally:
            call("furrow_free", found)

    # --- bodies ---

    def add(self, entry: Optional[dict] = None, **keys: Any) -> Body:
        """Adds a body: the keys of one entry of the scene's `objects`, as a dict or as arguments.

        world.add(shape={"sphere": {"radius": 0.2}}). Without a path it touches nothing until it is placed.
        """
        handle = ctypes.c_int32(-1)
        self._call("furrow_body_add", yaml({**(entry or {}), **keys}), ctypes.byref(handle))
        return Body(self, handle.value)

    def body(self, name: str) -> Body:
        """The body of that name."""
        handle = ctypes.c_int32(-1)
        self._call("furrow_body_find", text(name), ctypes.byref(handle))
        return Body(self, handle.value)

    def vehicle(self, name: Optional[str] = None) -> Vehicle:
        """The scene's vehicle of that name; None: its first one."""
        handle = ctypes.c_int32(0)
        if name is not None:
            self._call("furrow_vehicle_find", text(name), ctypes.byref(handle))
        return Vehicle(self, handle.value)

    def set_states(self, bodies: Bodies, states: numpy.ndarray) -> None:
        """Body.set for n bodies at once. states: (n,) of furrow.STATE; not copied if it is contiguous."""
        handles = _handles(bodies)
        states = _structs(states, STATE, len(handles), "states")
        self._call("furrow_set_states", len(handles), handles.ctypes.data, states.ctypes.data)

    def set_belts(self, bodies: Bodies, belts: Any) -> None:
        """Body.run_belt for n bodies at once. belts: (n, 2): travel, m, and speed, m/s."""
        handles = _handles(bodies)
        run = _array(belts, "belts", len(handles), 2)
        self._call("furrow_set_belts", len(handles), handles.ctypes.data, run.ctypes.data)

    def get_states(self, bodies: Bodies) -> numpy.ndarray:
        """Body.state of n bodies at once: (n,) of furrow.STATE. ["pose"]["position"] is (n, 3), m."""
        handles = _handles(bodies)
        states = numpy.empty(len(handles), STATE)
        self._call("furrow_get_states", len(handles), handles.ctypes.data, states.ctypes.data)
        return states

    def get_contacts(self, bodies: Bodies) -> numpy.ndarray:
        """Body.contact of n bodies at once: (n,) of furrow.CONTACT. ["force"] is (n, 3), N, and ["force_x"] its first column.

        pandas.DataFrame(contacts) has a row for each body, and a column for each number: force_x, force_y, and so on.
        """
        handles = _handles(bodies)
        contacts = numpy.empty(len(handles), CONTACT)
        self._call("furrow_get_contacts", len(handles), handles.ctypes.data, contacts.ctypes.data, CONTACT.itemsize)
        return contacts

    def probe(self, bodies: Bodies, states: numpy.ndarray) -> numpy.ndarray:
        """What the soil would do to n bodies in these states; changes nothing.

        states: (n,) of furrow.STATE. Returns (n,) of furrow.CONTACT; where ["state"] is ContactState.UNKNOWN, nothing is known, as
        off the terrain.
        """
        handles = _handles(bodies)
        states = _structs(states, STATE, len(handles), "states")
        contacts = numpy.empty(len(handles), CONTACT)
        self._call("furrow_probe", len(handles), handles.ctypes.data, states.ctypes.data, contacts.ctypes.data,
                   CONTACT.itemsize)
        return contacts

    # --- asking ---

    def points(self, xy: Any) -> numpy.ndarray:
        """The newest ground at n points.

        xy: (n, 2), or any (..., 2), m, local axes; not copied if it is contiguous float64.
        Returns (n,), or (...), of furrow.POINT: ["height"] and ["offset"] in m, ["normal"] (n, 3), ["soil"], ["nodata"].
        ["normal_x"], ["normal_y"] and ["normal_z"] are the columns of ["normal"]. So pandas.DataFrame(points) has a row for each of n points, and a
        column for each number.
        A point off the terrain or in a hole raises nothing: its ["nodata"] is True, its height, offset and normal are nan. The
        terrain goes from (0, 0) to World.info.extent.
        """
        pairs = _array(xy, "xy", 2)
        points = numpy.empty(pairs.shape[:-1], POINT)
        self._call("furrow_points", points.size, pairs.ctypes.data, points.ctypes.data)
        return points

    def rays(self, origin: Any, direction: Any) -> numpy.ndarray:
        """Where n rays first meet the newest ground.

        origin: (n, 3), m; direction: (n, 3), of any length but 0; local axes. One of either serves all of the other.
        Returns (n,) of furrow.HIT: ["position"] (n, 3), m, ["normal"] (n, 3), ["distance"], m, ["hit"]; ["position_x"] and so on are single columns,
        as pandas.DataFrame(hits) has them. A ray that misses the terrain
        raises nothing: its ["hit"] is False, its position, normal and distance are nan.
        """
        first, second = numpy.broadcast_arrays(_array(origin, "origin", 3), _array(direction, "direction", 3))
        first, second = numpy.ascontiguousarray(first), numpy.ascontiguousarray(second)
        hits = numpy.empty(first.shape[:-1], HIT)
        self._call("furrow_rays", hits.size, first.ctypes.data, second.ctypes.data, hits.ctypes.data)
        return hits

    def read(self, layer: Union[str, Layer] = "surface", *, x: Optional[float] = None, y: Optional[float] = None,
             width: Optional[float] = None, height: Optional[float] = None, column: int = 0, row: int = 0,
             columns: Optional[int] = None, rows: Optional[int] = None, level: Optional[int] = None,
             out: Optional[numpy.ndarray] = None, xarray: bool = False) -> Any:
        """Posts of a rectangle: (rows, columns) float64, row 0 the southernmost. NaN where there is no post.

        The array's .x (columns,) and .y (rows,) say where the posts are, m, local axes. A part of the array has neither.

        layer: "surface", "base", "offset", "deposited", "sinkage" (m), "shear_x", "shear_y"
            (shares of the soil's strength, -1 to 1), "disturbance", or "bent" or "torn" plants (0 to 1).
        The rectangle is x, y (m, its south-west corner), width and height (m), and holds the posts in it, its sides included; or
        column, row, columns and rows, in posts. level: None is the working level, the finest.
        Posts are at whole multiples of the spacing, World.info.spacing at the working level. So the first post is not at x, y, but is the first one
        at or beyond it, to the east and north: less than a spacing away. Posts that a millionth of the spacing keeps outside are inside.
        Post (column, row) is at (column, row) x spacing: World.points gives the same height there.
        out: (rows, columns) float64 to fill, whose rows are contiguous each; nothing is copied, and what is returned is a view of it.
        xarray: returns an xarray.DataArray, with the dimensions y and x and their places, m. ImportError: that package is not installed.
        """
        info = self.info
        level = info.level if level is None else level
        if x is not None or y is not None or width is not None or height is not None:
            if x is None or y is None or width is None or height is None:
                raise ValueError("furrow: read needs x, y, width and height together, in metres")
            spacing = _spacing(info, level)
            column, columns = _posts_between(x, width, spacing)
            row, rows = _posts_between(y, height, spacing)
        elif columns is None or rows is None:
            raise ValueError("furrow: read needs a rectangle: x, y, width and height in metres, or columns and rows in posts")
        names = [name.name.lower() for name in Layer]
        if isinstance(layer, str) and layer.lower() not in names:
            raise KeyError(f"furrow: {layer!r} is no layer; give one of {', '.join(names)}")
        wanted = Layer[layer.upper()] if isinstance(layer, str) else Layer(layer)
        column, row, columns, rows = map(operator.index, (column, row, columns, rows))
        if columns < 0 or rows < 0:
            raise ValueError(f"furrow: read was asked for {columns} columns and {rows} rows; give 0 or more")
        if out is None:
            out = numpy.empty((rows, columns))
        if out.shape != (rows, columns) or out.dtype != numpy.float64 or not out.flags.writeable:
            raise ValueError(f"furrow: out must be writable float64 of the shape {(rows, columns)}")
        if columns > 1 and out.strides[1] != out.itemsize or out.strides[0] % out.itemsize != 0 or out.strides[0] < 0:
            raise ValueError("furrow: the rows of out must be contiguous each, and follow one another")
        stride = out.strides[0] // out.itemsize if rows > 1 else columns
        self._call("furrow_read", wanted, level, column, row, columns, rows, out.ctypes.data, stride)
        spacing = _spacing(info, level)
        placed = _arrays.posts(out, spacing * numpy.arange(column, column + columns), spacing * numpy.arange(row, row + rows))
        return _arrays.data_array(placed, wanted.name.lower(), "m" if wanted in METRES else "1") if xarray else placed

    def changes(self, since: int = 0) -> Tuple[numpy.ndarray, int]:
        """Rectangles of the working level that changed since a revision, and the revision now.

        since: a revision that an earlier call told, or .info.revision; 0: since the store was made.
        Returns ((n,) of furrow.RECT: ["column"], ["row"], ["columns"], ["rows"], in posts; revision).
        """
        room = 64
        with self._lock:
            while True:
                rects, count, now = numpy.empty(room, RECT), ctypes.c_size_t(room), ctypes.c_uint64()
                try:
                    self._call("furrow_changes", since, rects.ctypes.data, ctypes.byref(count), ctypes.byref(now))
                    return rects[:count.value], now.value
                except Exception:
                    if count.value <= room:
                        raise
                    room = count.value

    # --- soil that is brought and taken ---

    def pour(self, heights: Any, *, x: Optional[float] = None, y: Optional[float] = None, column: int = 0, row: int = 0,
             soil: int = -1, loose: bool = True) -> None:
        """Changes the heights of a rectangle of posts of the working level: pours a heap, or digs a pit.

        heights: (rows, columns), m; below 0: soil is taken; 0: the post stays. Row 0 is the southernmost.
        x, y: m, a place of the south-west post; or column and row, in posts. soil: index among the scene's soils; -1: that of each post.
        loose: what comes lies as soil that a body has moved, and slides in later steps where it is too steep. Otherwise it lies as ground
        that nothing has touched. stats["volume"]["added"] counts it, m3. rollback takes it back.
        """
        array = numpy.ascontiguousarray(heights, dtype=numpy.float64)
        if array.ndim != 2:
            raise ValueError(f"furrow: heights has the shape {array.shape}; it must be (rows, columns)")
        if x is not None or y is not None:
            if x is None or y is None:
                raise ValueError("furrow: pour needs x and y together, in metres")
            spacing = self.info.spacing
            column, row = _posts_between(x, spacing, spacing)[0], _posts_between(y, spacing, spacing)[0]
        self._call("furrow_pour", operator.index(column), operator.index(row), array.shape[1], array.shape[0], array.ctypes.data, array.shape[1],
                   operator.index(soil), bool(loose))

    def pour_polygon(self, xy: Any, volume: float, *, soil: int = -1, loose: bool = True) -> None:
        """Pours a volume, m3, evenly onto all posts in a polygon; below 0: soil is taken.

        xy: (n, 2), m, local axes: its corners in turn. soil and loose: as in pour.
        """
        corners = _array(xy, "xy", 2)
        if corners.ndim != 2:
            raise ValueError(f"furrow: xy has the shape {corners.shape}; it must be (n, 2)")
        self._call("furrow_pour_polygon", len(corners), corners.ctypes.data, volume, operator.index(soil), bool(loose))

    # --- looking ---

    def render(self, position: Optional[Vector] = None, orientation: Optional[Vector] = None, *,
               look_at: Union[Body, Vector, None] = None, fovy: float = 1.0,
               size: Tuple[int, int] = (640, 480)) -> Tuple[numpy.ndarray, numpy.ndarray]:
        """Draws a picture of the newest ground. The scene's `view` says what is drawn; it may be absent, and so may its camera.

        position: (3,), m. orientation: (4,), a quaternion w, x, y, z: the camera looks along its own x, its z is up.
        look_at: a Body or a place, (3,), m, in place of an orientation. Without both the camera looks level to the east.
        Without a position it is 6 m south of look_at and 3 m above it. Without look_at, too, it looks at the scene's first body,
        or the first that was added. If that was not placed, the whole terrain is seen from the south.
        fovy: rad, the vertical angle of view. size: (width, height), pixels.
        Returns rgb, (height, width, 3) uint8, sRGB, and depth, (height, width) float32, m along the view direction, inf: sky.
        Rows come from the top.
        """
        width, height = map(operator.index, size)
        if orientation is not None and look_at is not None:
            raise ValueError("furrow: render takes an orientation or look_at, not both")
        if position is None and orientation is not None:
            raise ValueError("furrow: render needs a position with an orientation")
        target = self._target(look_at)
        if position is None and target is None:
            target = self._place_of(0)
        if position is None and not (0 < fovy < math.pi and width > 0 and height > 0):
            position = (0.0, 0.0, 0.0)  # the library says what is wrong
        if position is None:
            position, target = self._beside(target) if target is not None else self._overview(fovy, width / height)
        if orientation is None:
            orientation = LEVEL_WITH_NO_TURN if target is None else _toward(_array(position, "position", 3), target)
        camera = declared.furrow_camera(ctypes.sizeof(declared.furrow_camera), _pose(position, orientation), fovy, width, height)
        rgb = numpy.empty((height, width, 3), numpy.uint8)
        depth = numpy.empty((height, width), numpy.float32)
        self._call("furrow_render", ctypes.byref(camera), rgb.ctypes.data, depth.ctypes.data)
        return rgb, depth

    def _place_of(self, handle: int) -> Optional[numpy.ndarray]:
        """Where a body is; None: it was not placed, or there is none."""
        state = numpy.empty(1, STATE)
        try:
            self._call("furrow_get_states", 1, numpy.array([handle], numpy.int32).ctypes.data, state.ctypes.data)
        except Error as error:
            if error.status != Status.USAGE or self._handle is None:
                raise
            return None
        place = state["pose"]["position"][0]
        return place if numpy.isfinite(place).all() else None

    def _target(self, look_at: Union[Body, Vector, None]) -> Optional[numpy.ndarray]:
        if not isinstance(look_at, Body):
            return None if look_at is None else _array(look_at, "look_at", 3)
        place = self._place_of(look_at.handle)
        if place is None:
            raise ValueError(f"furrow: {look_at!r} is nowhere; place it before render looks at it")
        return place

    def _beside(self, target: numpy.ndarray) -> Tuple[numpy.ndarray, numpy.ndarray]:
        """A place from which the target is seen, above the ground, and the target."""
        eye = target + (0.0, *CHASE)
        ground = self.points(eye[:2])["height"]
        return numpy.array([eye[0], eye[1], numpy.fmax(eye[2], ground + LEAST_ABOVE)]), target

    def _overview(self, fovy: float, aspect: float) -> Tuple[numpy.ndarray, numpy.ndarray]:
        """A place from which the whole terrain is seen, and its middle."""
        info = self.info
        low, high = (info.low, info.high) if math.isfinite(info.low) else (0.0, 0.0)
        middle = numpy.array([info.extent[0] / 2, info.extent[1] / 2, (low + high) / 2])
        radius = math.hypot(info.extent[0], info.extent[1], high - low) / 2
        narrow = math.atan(math.tan(min(fovy, 3.0) / 2) * min(1.0, aspect))
        far = radius / math.sin(narrow)
        return middle + (0.0, -far * math.cos(OVERVIEW), far * math.sin(OVERVIEW)), middle


def _toward(eye: numpy.ndarray, target: numpy.ndarray) -> Tuple[float, float, float, float]:
    """The quaternion w, x, y, z of a camera that looks from one place to another, with z up; straight down, north is up."""
    east, north, up = target - eye
    level = math.hypot(east, north)
    yaw = math.atan2(north, east) / 2 if level > 1e-9 * abs(up) else math.pi / 4
    pitch = -math.atan2(up, level) / 2
    return (math.cos(yaw) * math.cos(pitch), -math.sin(yaw) * math.sin(pitch), math.cos(yaw) * math.sin(pitch), math.sin(yaw) * math.cos(pitch))


def _spacing(info: Info, level: int) -> float:
    """m between the posts of a level."""
    return info.spacing * 2.0 ** (level - info.level)


def _posts_between(start: float, length: float, spacing: float) -> Tuple[int, int]:
    """The first post and the number of posts between two places, both included; a millionth of the spacing is no distance."""
    if not (math.isfinite(start) and math.isfinite(length)):
        raise ValueError(f"furrow: {start} and {length} are no place and length; give metres")
    first = int(numpy.ceil(start / spacing - 1e-6))
    last = int(numpy.floor((start + length) / spacing + 1e-6))
    if last < first:
        raise ValueError(f"furrow: there is no post between {start} and {start + length} m; posts are {spacing} m apart")
    return first, last - first + 1
