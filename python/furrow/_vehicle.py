"""A vehicle of the scene."""
import ctypes
import math
from typing import Any, Dict, Optional, Sequence, Tuple, TYPE_CHECKING

import numpy

from furrow import _declarations as declared
from furrow._declarations import Part, VehicleState

if TYPE_CHECKING:
    from furrow._world import Body, World


class Vehicle:
    """A vehicle of the scene: MuJoCo computes its motion, the soil carries it. World.vehicle makes it; World.step moves it.

    It follows the scene's `driver`, if it has one; `set` takes actuators over.
    """

    def __init__(self, world: "World", handle: int) -> None:
        self.world = world
        self.handle = handle
        state = self.state  # there is such a vehicle
        self.joint_names = self._names(Part.JOINT, state.joints)
        self.actuator_names = self._names(Part.ACTUATOR, state.actuators)
        self.model_body_names = self._all_names(Part.MODEL_BODY)
        self._controls = numpy.full(state.actuators, math.nan)
        self._soil_geoms: Optional[numpy.ndarray] = None  # handles

    def _names(self, part: Part, count: int) -> Tuple[str, ...]:
        return tuple(self.world._call("furrow_vehicle_part", self.handle, part, index).decode() for index in range(count))

    def _all_names(self, part: Part) -> Tuple[str, ...]:
        names = []
        while (name := self.world._call("furrow_vehicle_part", self.handle, part, len(names))) is not None:
            names.append(name.decode())
        return tuple(names)

    @property
    def state(self) -> VehicleState:
        """Where it is, and what it has done: .position (3,), m; .orientation (4,), a quaternion; .velocity (3,), m/s; .angular (3,), rad/s;
        .distance, m; .work, J; and more."""
        state = declared.furrow_vehicle_state(size=ctypes.sizeof(declared.furrow_vehicle_state))
        self.world._call("furrow_vehicle_get", self.handle, ctypes.byref(state))
        return VehicleState(state)

    @property
    def bodies(self) -> "Dict[str, Body]":
        """Its soil geoms by their names in the model: their .contact tells slip, sinkage and force of each wheel."""
        names = self._names(Part.SOIL_GEOM, self.state.soil_geoms)
        return {name.partition(".")[2]: self.world.body(name) for name in names}

    def _values(self, function: str, count: int) -> Tuple[numpy.ndarray, numpy.ndarray]:
        first, second = numpy.empty(count), numpy.empty(count)
        self.world._call(function, self.handle, count, first.ctypes.data, second.ctypes.data)
        return first, second

    @property
    def joints(self) -> Dict[str, Tuple[float, float]]:
        """Its hinges and slides: (angle in rad or way in m, rate in rad/s or m/s), by name."""
        values, rates = self._values("furrow_get_joints", len(self.joint_names))
        return {name: (value, rate) for name, value, rate in zip(self.joint_names, values.tolist(), rates.tolist())}

    @property
    def actuators(self) -> Dict[str, Tuple[float, float]]:
        """Its actuators in the last step: (control, force in N or N m before gear), by name."""
        controls, forces = self._values("furrow_get_actuators", len(self.actuator_names))
        return {name: (control, force) for name, control, force in zip(self.actuator_names, controls.tolist(), forces.tolist())}

    def set(self, controls: Optional[Dict[str, Optional[float]]] = None, **more: Optional[float]) -> None:
        """Sets controls by the names of actuators, for all steps from now on: set(steer=0.1, drive_fl=2.5).

        None gives an actuator back to the scene's driver. Actuators that are not named keep what was set before.
        """
        for name, value in {**(controls or {}), **more}.items():
            if name not in self.actuator_names:
                raise ValueError(f"furrow: {name} is no actuator; there are: {', '.join(self.actuator_names)}")
            self._controls[self.actuator_names.index(name)] = math.nan if value is None else value
        self.world._call("furrow_set_controls", self.handle, self._controls.size, self._controls.ctypes.data)

    def set_controls(self, controls: Any) -> None:
        """Sets all controls, for all steps from now on: (actuators,), in the order of actuator_names; NaN gives one back to the scene's driver."""
        values = numpy.ascontiguousarray(controls, dtype=numpy.float64)
        if values.shape != self._controls.shape:
            raise ValueError(f"furrow: controls has the shape {values.shape}; it must be {self._controls.shape}")
        self.world._call("furrow_set_controls", self.handle, values.size, values.ctypes.data)
        self._controls[:] = values

    def get_joints(self) -> Tuple[numpy.ndarray, numpy.ndarray]:
        """Its hinges and slides in the order of joint_names: angles in rad or ways in m, and their rates in rad/s or m/s; each (joints,)."""
        return self._values("furrow_get_joints", len(self.joint_names))

    def get_contacts(self) -> numpy.ndarray:
        """What the soil did in the last step to each of its soil geoms: (geoms,) of furrow.CONTACT, in the order of `bodies`."""
        if self._soil_geoms is None:
            self._soil_geoms = numpy.array([body.handle for body in self.bodies.values()], numpy.int32)
        return self.world.get_contacts(self._soil_geoms)

    def push(self, body: str, force: Sequence[float] = (0, 0, 0), torque: Sequence[float] = (0, 0, 0)) -> None:
        """Pushes a body of its model for all steps from now on: force in N, torque in N m, along east, north and up, at its centre of mass.

        push("chassis") ends it. It adds to the scene's `pushes`.
        """
        if body not in self.model_body_names:
            raise ValueError(f"furrow: {body} is no body of the model; there are: {', '.join(self.model_body_names)}")
        both = numpy.ascontiguousarray([force, torque], dtype=float)
        if both.shape != (2, 3):
            raise ValueError("furrow: force and torque have 3 numbers each")
        self.world._call("furrow_set_force", self.handle, self.model_body_names.index(body), both[0].ctypes.data, both[1].ctypes.data)

    def __repr__(self) -> str:
        return f"Vehicle({self.handle})"
