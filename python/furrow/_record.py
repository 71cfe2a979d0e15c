"""What the generated classes of single structs have in common."""
import ctypes
from typing import Any, Tuple

import numpy


class Record:
    """One struct of the library. Its arrays are views of the struct: no copies, and valid as long as they are held."""

    _structure: type
    _short: Tuple[str, ...] = ()  # names of properties that lead to members of inner structs

    def __init__(self, structure: Any = None) -> None:
        self._held = self._structure() if structure is None else structure
        # Strings belong to the library and end with the world; they are copied at once.
        self._strings = {name: (getattr(self._held, name) or b"").decode()
                         for name, kind in self._structure._fields_ if kind is ctypes.c_char_p}

    def _get(self, name: str) -> Any:
        if name in self._strings:
            return self._strings[name]
        value = getattr(self._held, name)
        return numpy.ctypeslib.as_array(value) if isinstance(value, ctypes.Array) else value

    def __repr__(self) -> str:
        names = [name for name, value in vars(type(self)).items() if isinstance(value, property) and name not in self._short]
        return f"{type(self).__name__}({', '.join(f'{name}={getattr(self, name)!r}' for name in names)})"
