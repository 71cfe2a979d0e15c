"""The command of a wheel: it lies in the folder of the Python package, which is not loaded for it."""
import importlib.util
import os
import sys


def main() -> None:
    package = importlib.util.find_spec("furrow")
    command = os.path.join(package.submodule_search_locations[0], "furrow")
    os.environ.setdefault("FURROW_PYTHON", sys.executable)
    try:
        os.execv(command, ["furrow", *sys.argv[1:]])
    except OSError as error:
        sys.exit(f"furrow: {command}: {error.strerror}; install the Python package furrow again")
