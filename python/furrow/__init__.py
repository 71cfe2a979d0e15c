"""Furrow: terrain that is larger than memory and that changes under what drives on it.

    import furrow
    with furrow.World({"redistribute": {"model": "box"}}, store="site.furrow", overlay="run1.furrow") as world:
        ball = world.add(shape={"sphere": {"radius": 0.5}})
        ball.place(position=(60, 60, 100))
        ball.set(position=(60, 60, 99.9))
        world.step(0.02)
        print(world.points([(60, 60)])["height"])

Metres, seconds, newtons and radians; local axes are x east, y north, z up, from the store's south-west post. Failures raise
furrow.Error, whose .status is a furrow.Status. The first call loads libfurrow; furrow.results needs none.
"""
import importlib
from typing import Any

from furrow._declarations import Contact, ContactState, Info, Layer, Pose, State, Status, VehicleState
from furrow._library import Error, import_dem, set_log, version
from furrow._world import CONTACT, HIT, POINT, RECT, STATE, Body, World
from furrow._vehicle import Vehicle
from furrow.fit import fit_soil
from furrow.studies import study
from furrow.tables import Tables, load

__all__ = ["Body", "CONTACT", "Contact", "ContactState", "Error", "HIT", "Info", "Layer", "POINT", "Pose", "RECT", "STATE", "State",
           "Status", "Tables", "Vehicle", "VehicleState", "World", "fit_soil", "import_dem", "load", "report", "set_log", "study", "version"]


def __getattr__(name: str) -> Any:
    """__version__ is the library's, which is loaded when something of it is first asked. report is loaded when it is first asked for, too."""
    if name == "__version__":
        return version()
    if name == "report":
        return importlib.import_module("furrow.report")
    raise AttributeError(f"module 'furrow' has no attribute {name!r}")
