"""The command of a wheel, and how MuJoCo finds the engine plugin of a wheel. Both lie in the folder of the Python package, which is not loaded for them."""
import ctypes
import importlib.util
import os
import sys


def installed(name: str) -> str:
    """The path of a file in the folder of the Python package."""
    return os.path.join(importlib.util.find_spec("furrow").submodule_search_locations[0], name)


def load_plugin() -> None:
    """Loads the engine plugin. MuJoCo 4 calls this when it is imported, so that its viewer and all its programs in Python know furrow.soil. Another version is left alone."""
    mujoco, plugin = sys.modules.get("mujoco"), installed("libfurrow_mujoco.so")
    if os.path.exists(plugin) and getattr(mujoco, "__version__", "") == "@MUJOCO_VERSION@":
        ctypes.CDLL(plugin)


def main() -> None:
    command = installed("furrow")
    os.environ.setdefault("FURROW_PYTHON", sys.executable)
    try:
        os.execv(command, ["furrow", *sys.argv[1:]])
    except OSError as error:
        sys.exit(f"furrow: {command}: {error.strerror}; install the Python package furrow again")
