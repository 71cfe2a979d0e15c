"""The soil under a model of MuJoCo that the user owns and steps: furrow.mujoco.Soil, and where the engine plugin furrow.soil is.

    import mujoco, furrow, furrow.mujoco
    soil = furrow.mujoco.Soil(world, model, data, geoms="wheel_*")
    for _ in range(1000):
        soil.apply()
        mujoco.mj_step(model, data)
        soil.commit()

Any module `mujoco` from 3.2 to 4 will do. Of Furrow itself a build with vehicles is needed. The plugin needs no loop of this kind, and MuJoCo 4.
"""
import ctypes
import os
import pathlib
import warnings
import weakref
from typing import Any, Dict, List, Optional, Sequence, Union

import numpy

try:
    import mujoco
except ImportError as missing:
    raise ImportError("furrow.mujoco: the Python package mujoco is not there; install it: pip install mujoco") from missing

from furrow import _declarations as declared
from furrow import _library
from furrow._declarations import Contact, Status
from furrow._library import Error, text
from furrow._world import World

OLDEST = (3, 2)
LONG_STEP = 0.005  # s: with a longer step legs that strike the ground may be thrown
LIMITED_MOST = 3  # times that a step is made again whose contacts reach their limits
_STATE = mujoco.mjtState.mjSTATE_INTEGRATION
_PLUGIN = "libfurrow_mujoco.so"

# What of the model and the data the library looks at, as MuJoCo calls it; others are made below.
_MODEL = ("body_parentid body_rootid body_weldid body_jntnum body_jntadr body_dofnum body_dofadr body_geomnum jnt_type jnt_qposadr jnt_dofadr "
          "dof_bodyid dof_jntid dof_parentid dof_damping dof_M0 body_mass geom_type geom_contype geom_conaffinity geom_condim geom_priority geom_bodyid geom_dataid geom_size "
          "geom_aabb geom_user mesh_vertadr mesh_vertnum mesh_faceadr mesh_facenum mesh_vert mesh_face name_bodyadr name_geomadr name_jntadr "
          "name_textadr name_numericadr names text_adr text_data numeric_adr numeric_data actuator_trntype actuator_trnid actuator_gear "
          "actuator_biastype actuator_biasprm").split()
_DATA = "qpos qvel xpos xmat xanchor xaxis geom_xpos geom_xmat subtree_com cdof cvel".split()
_SIZES = "nq nv nbody njnt ngeom ntext nnumeric nuser_geom".split()


class _Array(ctypes.Structure):
    _fields_ = [("name", ctypes.c_char_p), ("at", ctypes.c_void_p)]


class _Open(ctypes.Structure):
    _fields_ = [("size", ctypes.c_size_t), ("world", ctypes.c_void_p), ("name", ctypes.c_char_p), ("model", ctypes.c_void_p),
                ("data", ctypes.c_void_p), ("arrays", ctypes.POINTER(_Array)), ("array_count", ctypes.c_size_t), ("geoms", ctypes.c_char_p),
                ("origin", ctypes.c_double * 3), ("carry", ctypes.c_char_p), ("tyres", ctypes.c_char_p)]


def _load() -> Dict[str, Any]:
    """The functions of furrow_mujoco.h, of the library that furrow has loaded."""
    library = ctypes.CDLL(_library._find())
    pointer, numbers = ctypes.c_void_p, ctypes.c_void_p
    declarations = {
        "furrow_mujoco_version": (ctypes.c_int, []),
        "furrow_mujoco_open": (None, [ctypes.POINTER(_Open), ctypes.POINTER(pointer)]),
        "furrow_mujoco_begin": (None, [pointer, pointer, ctypes.c_double, ctypes.c_bool, numbers]),
        "furrow_mujoco_limit": (None, [pointer, numbers, ctypes.POINTER(ctypes.c_bool), numbers]),
        "furrow_mujoco_forces": (None, [pointer, numbers, numbers]),
        "furrow_mujoco_end": (None, [pointer, numbers]),
        "furrow_mujoco_touch": (None, [pointer, pointer]),
        "furrow_mujoco_reset": (None, [pointer]),
        "furrow_mujoco_count": (ctypes.c_size_t, [pointer]),
        "furrow_mujoco_geom": (None, [pointer, ctypes.c_size_t, ctypes.POINTER(ctypes.c_int), ctypes.POINTER(ctypes.c_char_p), pointer, ctypes.c_size_t]),
        "furrow_mujoco_close": (ctypes.c_void_p, [pointer]),
    }
    functions = {}
    for name, (result, parameters) in declarations.items():
        function = getattr(library, name)
        function.argtypes = parameters
        function.restype = ctypes.c_int if result is None else result
        if result is None:
            function.errcheck = _library._check
        functions[name] = function
    return functions


_functions = _load()


def plugin() -> str:
    """Returns the path of the engine plugin furrow.soil, for mujoco.mj_loadPluginLibrary and for MuJoCo's programs.

    ImportError: this build of Furrow has none, since it was built without MuJoCo 4.
    """
    library = pathlib.Path(_library._find())
    if not library.is_absolute():  # the loader has found it
        with open("/proc/self/maps", encoding="utf-8", errors="replace") as maps:
            loaded = {line.split(maxsplit=5)[5].strip() for line in maps if library.name in line}
        library = pathlib.Path(min(loaded, default=os.fspath(library)))
    for folder in (library.parent, library.resolve().parent, library.resolve().parent.parent / "plugin"):
        if (folder / _PLUGIN).exists():
            return os.fspath(folder / _PLUGIN)
    raise ImportError(f"furrow.mujoco: there is no {_PLUGIN} beside {library}; build Furrow with MuJoCo 4 (tools/packages.sh)")


def write_skin(path: Union[str, "os.PathLike[str]"], size: Sequence[float], spacing: float, centre: Sequence[float] = (0.0, 0.0)) -> None:
    """Writes a level skin of MuJoCo, which the plugin's key `skin` lets follow the ground. Viewers of all kinds show its ruts.

    path: the file to write, .skn. size: (2,), m, of the rectangle, along x and y. spacing: m, between vertices. centre: (2,), m, of the rectangle in
    MuJoCo's axes. ValueError: it has less than 2 or more than 4 million vertices.
    """
    counts = [round(length / spacing) + 1 if spacing > 0 and length >= spacing / 2 else 0 for length in size]
    if min(counts) < 2 or counts[0] * counts[1] > 4000000:
        raise ValueError(f"furrow.mujoco: a skin of {size[0]:g} x {size[1]:g} m every {spacing:g} m has {counts[0]} x {counts[1]} vertices; give a size and spacing for 2 x 2 to 4 million")
    axes = [centre[k] + spacing * (numpy.arange(counts[k]) - (counts[k] - 1) / 2) for k in range(2)]
    vertices = numpy.zeros((counts[1], counts[0], 3), dtype="<f4")
    vertices[..., 0], vertices[..., 1] = axes[0], axes[1][:, None]
    first = (numpy.arange(counts[1] - 1)[:, None] * counts[0] + numpy.arange(counts[0] - 1)).ravel()
    next_row = first + counts[0]
    faces = numpy.concatenate([numpy.stack([first, first + 1, next_row + 1], 1), numpy.stack([first, next_row + 1, next_row], 1)]).astype("<i4")
    number = counts[0] * counts[1]
    with open(path, "wb") as file:
        for part in (numpy.array([number, 0, len(faces), 1], dtype="<i4"), vertices, faces, b"world".ljust(40, b"\0"),  # its one bone, which all vertices hang on
                     numpy.array([0, 0, 0, 1, 0, 0, 0], dtype="<f4"), numpy.array([number], dtype="<i4"), numpy.arange(number, dtype="<i4"), numpy.ones(number, dtype="<f4")):
            file.write(part if isinstance(part, bytes) else part.tobytes())


def _close(handle: int, lock: Any) -> None:
    """Takes the bodies out of the world, which another thread may be stepping, unless it is closed already."""
    with lock:
        _functions["furrow_mujoco_close"](handle)


def _patterns(patterns: Union[str, Sequence[str], None]) -> Optional[bytes]:
    return None if patterns is None else text(patterns if isinstance(patterns, str) else " ".join(patterns))


class _Inertia:
    """MuJoCo's inertia as 4.0 keeps it in M: rows of a lower triangle. Before 4.0 it was in qM, which begins each row with its diagonal, and from 3.3 on in M, too."""

    def __init__(self, model: Any, data: Any) -> None:
        self._model, self._data = model, data
        if hasattr(data, "qM"):
            self._index(model)
        else:
            self.rownnz, self.rowadr, self.colind = (numpy.array(getattr(model, "M_" + name), dtype=numpy.int32) for name in ("rownnz", "rowadr", "colind"))
            self._places = {"M": numpy.arange(len(self.colind))}
        self.values = numpy.zeros(max(len(self.colind), 1))
        self.factors, self.inverse = numpy.zeros(max(len(self.colind), 1)), numpy.zeros(max(model.nv, 1))

    def _index(self, model: Any) -> None:
        """Finds where qM, and M if there is one, have what is looked at here: of a body without other joints the diagonal alone."""
        counts: List[int] = []
        columns: List[int] = []
        places: Dict[str, List[int]] = {"qM": []}
        if hasattr(self._data, "M"):
            places["M"] = []
        for row in range(model.nv):
            chain, dof = [], row
            while dof >= 0:
                chain.append(dof)
                dof = int(model.dof_parentid[dof])
            if model.dof_simplenum[row] > 0:
                chain = chain[:1]
            counts.append(len(chain))
            columns += chain[::-1]
            places["qM"] += [int(model.dof_Madr[row]) + at for at in range(len(chain))][::-1]
            if "M" in places:
                first = int(model.M_rowadr[row])
                there = [int(column) for column in model.M_colind[first:first + int(model.M_rownnz[row])]]
                places["M"] += [first + there.index(column) for column in chain[::-1]]
        self.rownnz = numpy.array(counts, dtype=numpy.int32)
        self.rowadr = numpy.concatenate(([0], numpy.cumsum(self.rownnz)[:-1])).astype(numpy.int32)
        self.colind = numpy.array(columns, dtype=numpy.int32)
        self._places = {name: numpy.array(where) for name, where in places.items()}

    def take(self) -> None:
        """Copies the inertia out of the data."""
        name = "qM" if "qM" in self._places else "M"
        self.values[:len(self.colind)] = getattr(self._data, name)[self._places[name]]

    def give(self) -> None:
        """Puts the inertia into the data, and finds its factors, and what of constraints follows from them."""
        for name, where in self._places.items():
            getattr(self._data, name)[where] = self.values[:len(self.colind)]
        mujoco.mj_factorM(self._model, self._data)
        option = self._model.opt
        if self._data.nefc > 0 and (option.solver == mujoco.mjtSolver.mjSOL_PGS or option.noslip_iterations > 0):
            mujoco.mj_projectConstraint(self._model, self._data)


class Soil:
    """The ground of a world under a model of MuJoCo. The model and the data are the user's, and so is the loop.

    The forces are implicit in all joints: they are those at the end of the step, so that the loop is stable at the model's own timestep, also with
    a stiff ground. For this apply() makes the step once on data of its own. With RK4 the forces are those of a step by Euler.
    """

    def __init__(self, world: World, model: Any, data: Any, geoms: Union[str, Sequence[str], None] = None,
                 origin: Sequence[float] = (0.0, 0.0, 0.0), carry: Union[str, Sequence[str], None] = None,
                 tyres: Optional[Dict[str, Dict[str, float]]] = None) -> None:
        """Makes bodies of the world of the model's geoms, and a checkpoint, to which reset() returns.

        world: a furrow.World that has no vehicles of its own. model, data: mujoco.MjModel and mujoco.MjData. geoms: patterns of the geoms that
        press the ground, such as "wheel_* chassis"; None: all that collide. origin: (3,), m, where MuJoCo's origin is in the terrain. carry: patterns of
        those on which soil lies, such as "bucket"; its weight is theirs. tyres: by patterns of wheels, such as {"wheel_*": {"stiffness": 5e4, "load": 981}}:
        stiffness, N/m, load, N, and perhaps pressure, Pa, damping, N s/m, and width, m, as the `tyres` of a scene's vehicle.

        furrow.Error: no geom presses the ground, or one has a shape that cannot.
        """
        version = tuple(int(part) for part in mujoco.__version__.split(".")[:2])
        if version < OLDEST:
            raise ImportError(f"furrow.mujoco: MuJoCo {mujoco.__version__} is too old; install one from {OLDEST[0]}.{OLDEST[1]} on")
        self.world, self.model, self.data = world, model, data
        self._scratch = mujoco.MjData(model)  # in the first pose
        mujoco.mj_forward(model, self._scratch)
        self._inertia = _Inertia(model, self._scratch)
        self._inertia.take()
        self._kept: List[Any] = []
        arrays = self._arrays()
        given = _Open(ctypes.sizeof(_Open), world._handle, b"mujoco", None, None, arrays, len(arrays),
                      _patterns(geoms), (ctypes.c_double * 3)(*origin), _patterns(carry),
                      None if tyres is None else text("; ".join(" ".join([name, *(f"{key} {float(value)!r}" for key, value in numbers.items())]) for name, numbers in tyres.items())))
        handle = ctypes.c_void_p()
        with world._lock:
            _functions["furrow_mujoco_open"](ctypes.byref(given), ctypes.byref(handle))
        self._handle: Optional[int] = handle.value
        self._forgotten = weakref.finalize(self, _close, handle.value, world._lock)
        self._forces = numpy.zeros(max(model.nv, 1))
        self._own: Optional[numpy.ndarray] = None  # the user's qfrc_applied while the soil's is in it
        self._begun = self._step = 0.0  # s: when that step began, and how long it is
        self._state = numpy.zeros(mujoco.mj_stateSize(model, _STATE))
        self.geoms = self._names()
        self._doubt()

    def _doubt(self) -> None:
        """Warns of what gives a motion that nobody means."""
        model, gravity = self.model, self.world.info.gravity
        if abs(-model.opt.gravity[2] - gravity) > 0.01 * gravity:
            warnings.warn(f"furrow.mujoco: the model's gravity is {-model.opt.gravity[2]:.4g} m/s2, and the scene's is {gravity:.4g}: give both the same", stacklevel=3)
        if model.opt.timestep > LONG_STEP:
            warnings.warn(f"furrow.mujoco: the model's timestep is {model.opt.timestep:.3g} s, and what strikes the ground may be thrown with one above {LONG_STEP:g} s; "
                          "give a shorter one", stacklevel=3)
        for geom in range(model.ngeom):
            if model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_PLANE and (model.geom_contype[geom] or model.geom_conaffinity[geom]):
                warnings.warn(f"furrow.mujoco: bodies also stand on the model's own plane {model.geom(geom).name or 'without a name'}, where that is higher than the ground; "
                              "let it not collide, or take it out", stacklevel=3)

    # --- the library's view of the model ---

    def _arrays(self) -> Any:
        model, scratch, inertia = self.model, self._scratch, self._inertia
        found = {f"model.{name}": getattr(model, name) for name in _MODEL}
        found.update({f"data.{name}": getattr(scratch, name) for name in _DATA})
        actuators = getattr(model, "nactuator", model.nu)
        sizes = {name: getattr(model, name) for name in _SIZES}
        sizes.update({"nactuator": actuators, "nC": len(inertia.colind), "opt.integrator": model.opt.integrator})
        found.update({f"model.{name}": numpy.array([int(size)], dtype=numpy.int64) for name, size in sizes.items()})
        found.update({"model.opt.gravity": model.opt.gravity, "model.M_rownnz": inertia.rownnz, "model.M_rowadr": inertia.rowadr,
                      "model.M_colind": inertia.colind, "data.M": inertia.values, "data.qLD": inertia.factors, "data.qLDiagInv": inertia.inverse,
                      "model.actuator_outadr": getattr(model, "actuator_outadr", numpy.arange(actuators, dtype=numpy.int32))})
        arrays = (_Array * len(found))()
        for place, (name, value) in enumerate(found.items()):
            array = numpy.frombuffer(value, dtype=numpy.uint8) if isinstance(value, bytes) else numpy.asarray(value)
            if array.size == 0:
                array = numpy.zeros(8)
            elif not array.flags.c_contiguous:
                array = numpy.ascontiguousarray(array)
            self._kept.append(array)
            arrays[place] = _Array(name.encode(), array.ctypes.data)
        return arrays

    def _names(self) -> List[str]:
        names = []
        for index in range(_functions["furrow_mujoco_count"](self._handle)):
            name = ctypes.c_char_p()
            self._call("furrow_mujoco_geom", index, None, ctypes.byref(name), None, 0)
            names.append((name.value or b"").decode().partition(".")[2])
        return names

    def _call(self, name: str, *arguments: Any) -> None:
        with self.world._lock:
            if self._handle is None:
                raise Error(Status.USAGE, "mujoco: this soil is closed; make a new Soil")
            if self.world._handle is None:
                raise Error(Status.USAGE, "mujoco: its world is closed; open it again with furrow.World, and make a new Soil")
            _functions[name](self._handle, *arguments)

    # --- a step ---

    def apply(self) -> None:
        """Adds the soil's forces of the step that follows to data.qfrc_applied. Call it when controls and other forces are set, then mj_step, then commit().
        Leave data.qfrc_applied alone until then.

        furrow.Error: a geom has left the terrain.
        """
        model, data, scratch, inertia = self.model, self.data, self._scratch, self._inertia
        self._take_back()
        own, forces = data.qfrc_applied.copy(), self._forces
        mujoco.mj_getState(model, data, self._state, _STATE)
        mujoco.mj_setState(model, scratch, self._state, _STATE)
        mujoco.mj_step1(model, scratch)
        if scratch.ctrl.size:
            scratch.ctrl[:] = data.ctrl
        inertia.take()
        self._call("furrow_mujoco_begin", None, model.opt.timestep, False, forces.ctypes.data)
        again = ctypes.c_bool(True)
        for turn in range(LIMITED_MOST + 1):
            if turn > 0:
                mujoco.mj_setState(model, scratch, self._state, _STATE)
            inertia.give()
            scratch.qfrc_applied[:] = own + forces[:model.nv]
            mujoco.mj_step2(model, scratch)
            self._call("furrow_mujoco_limit", scratch.qvel.ctypes.data, ctypes.byref(again), forces.ctypes.data)
            if not again.value:
                break
        self._call("furrow_mujoco_forces", scratch.qvel.ctypes.data, forces.ctypes.data)
        self._own, self._begun, self._step = own, data.time, model.opt.timestep
        data.qfrc_applied[:] = own + forces[:model.nv]

    def commit(self) -> None:
        """Changes the ground by the step that mj_step has made since apply(), and takes the soil's forces out of data.qfrc_applied.

        furrow.Error: not one step was made since, or data.qfrc_applied was changed.
        """
        model, data, scratch = self.model, self.data, self._scratch
        if self._own is None:
            raise Error(Status.USAGE, "mujoco: commit follows apply and a step; call soil.apply() before mj_step")
        went = data.time - self._begun
        if not abs(went - self._step) <= 1e-6 * self._step + 4 * numpy.spacing(abs(data.time)):
            raise Error(Status.USAGE, f"mujoco: data.time went on by {went:g} s since apply, and a step is {self._step:g} s; "
                        "call soil.apply() and soil.commit() around each single mj_step")
        self._take_back()
        end = numpy.ascontiguousarray(data.qvel)
        self._call("furrow_mujoco_end", end.ctypes.data)
        scratch.qpos[:], scratch.qvel[:] = data.qpos, data.qvel
        if model.nmocap > 0:
            scratch.mocap_pos[:], scratch.mocap_quat[:] = data.mocap_pos, data.mocap_quat
        mujoco.mj_kinematics(model, scratch)
        mujoco.mj_comPos(model, scratch)
        mujoco.mj_comVel(model, scratch)
        self._call("furrow_mujoco_touch", None)

    def _take_back(self, strict: bool = True) -> None:
        """Takes the soil's forces out of what is applied, where they still are: mj_resetData clears it. strict: any other change since apply() is an error."""
        if self._own is None:
            return
        own, forces, now = self._own, self._forces[:self.model.nv], self.data.qfrc_applied
        there = now == own + forces
        self._own = None
        if strict and (~there & (forces != 0) & (now != 0)).any():
            raise Error(Status.USAGE, "mujoco: data.qfrc_applied was changed while it had the soil's forces; set it before apply, or after commit")
        now[there] = own[there]

    def reset(self) -> None:
        """Goes back to the ground as it was when this Soil was made. The data are the user's to reset: mujoco.mj_resetData.

        furrow.Error: the world got another checkpoint since, and it keeps the last one alone; world.rollback() goes back to that one.
        """
        self._take_back(strict=False)
        self._call("furrow_mujoco_reset")

    def close(self) -> None:
        """Takes the geoms' bodies out of the world. A closed Soil is closed again without effect; one that nobody holds is closed, too."""
        self._take_back(strict=False)
        self._handle = None
        self._forgotten()

    # --- what the soil did ---

    def contact(self, geom: Union[str, int]) -> Contact:
        """What the soil did to a geom in the last step: .force (3,), N; .sinkage, m; .slip; and more, as Body.contact.

        geom: its name, one of `geoms`, or its place among them.
        """
        if isinstance(geom, str):
            if geom not in self.geoms:
                raise KeyError(f"furrow: no soil geom is {geom}; there are {', '.join(self.geoms)}")
            geom = self.geoms.index(geom)
        contact = declared.furrow_contact()
        self._call("furrow_mujoco_geom", geom, None, None, ctypes.addressof(contact), ctypes.sizeof(contact))
        return Contact(contact)

    def __repr__(self) -> str:
        return f"Soil({', '.join(self.geoms)})"
