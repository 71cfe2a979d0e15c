"""Started by the command furrow, as a file: python3 .../furrow/_start.py NAME ARGUMENT... Another numpy than that of this interpreter is not looked for."""
import importlib
import os
import signal
import sys


def main() -> int:
    """Runs furrow.NAME's main. Returns its status."""
    signal.signal(signal.SIGPIPE, signal.SIG_DFL)  # as any command: it ends with its reader
    sys.path[0] = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
    name = {"fit-soil": "fit"}.get(sys.argv[1], sys.argv[1])
    try:
        module = importlib.import_module(f"furrow.{name}")
    except ImportError as error:
        what = error.name if error.name else str(error)
        print(f"furrow: {name}: {sys.executable} cannot import {what}; {sys.executable} -m pip install {what}, or name another Python in FURROW_PYTHON", file=sys.stderr)
        return 127 if name in ("plot", "studies") else 1  # parts of commands, which do the rest without them
    return module.main(sys.argv[2:])


if __name__ == "__main__":
    sys.exit(main())
