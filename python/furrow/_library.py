"""The shared library: where it is, how it is called, how its failures become exceptions, its log and its import."""
import atexit
import ctypes
import json
import os
import pathlib
import re
import threading
from typing import Any, Callable, Iterable, Optional, Union

from furrow import _declarations
from furrow._declarations import Status

Path = Union[str, "os.PathLike[str]"]


class Error(Exception):
    """A call of the library failed. Its text says what failed, why, and what to do.

    status: a furrow.Status, such as furrow.Status.INPUT.
    """

    def __init__(self, status: Status, message: str) -> None:
        super().__init__(message)
        self.status = status


def _find() -> str:
    """The library of this installation; FURROW_LIBRARY names another, for one that is not installed."""
    named = os.environ.get("FURROW_LIBRARY")
    if named:
        return named
    beside = pathlib.Path(__file__).resolve().parent / _declarations.LIBRARY
    return os.path.normpath(beside) if beside.exists() else beside.name


def _check(status: int, function: Any, arguments: Any) -> int:
    """Called by ctypes after each function that returns a status, on the thread of the call."""
    if status != Status.OK:
        raise Error(Status(status), _functions["furrow_last_error"]().decode(errors="replace"))
    return status


def _load() -> "dict[str, Any]":
    try:
        library = ctypes.CDLL(_find())
    except OSError as error:
        raise ImportError(f"furrow: the library cannot be loaded: {error}; install libfurrow, or set FURROW_LIBRARY to "
                          "the path of libfurrow.so.0") from error
    functions = {}
    for name, (checked, result, parameters) in _declarations.FUNCTIONS.items():
        function = getattr(library, name)
        function.restype = result
        function.argtypes = parameters
        if checked:
            function.errcheck = _check
        functions[name] = function
    return functions


class _Functions(dict):
    """The library's functions by their names. The library is loaded when the first is called, so furrow.results works where there is none."""

    def __missing__(self, name: str) -> Any:
        functions = _load()
        self.update(functions)
        return functions[name]


_functions = _Functions()
_log_type = _declarations.FUNCTIONS["furrow_set_log"][2][0]
_progress_type = _declarations.FUNCTIONS["furrow_import"][2][4]
_log_lock = threading.Lock()
_log_held: Any = None  # ctypes frees a callback that nobody holds


def call(name: str, *arguments: Any) -> Any:
    """Calls a function of the library without Python's lock, so that other threads go on."""
    return _functions[name](*arguments)


def text(value: Optional[Path]) -> Optional[bytes]:
    """A path or text for the library."""
    return None if value is None else os.fsencode(value)


# Control characters, separators of lines and paragraphs, the byte order mark, and what is no character. The library refuses each where it is
# escaped. Otherwise YAML makes a space of some.
_ESCAPED = re.compile("[\x7f-\x9f\u2028\u2029\ufeff\ufffe\uffff]")


def yaml(value: Any) -> bytes:
    """A dict or list as the library reads it. JSON is YAML, but for pairs of surrogates; numbers and arrays of numpy are taken as well."""
    try:
        json_text = json.dumps(value, allow_nan=False, ensure_ascii=False, default=lambda other: other.tolist())
    except AttributeError:
        raise TypeError(f"furrow: {value!r} holds what is no dict, list, text, number or bool") from None
    return _ESCAPED.sub(lambda found: f"\\u{ord(found[0]):04x}", json_text).encode(errors="surrogateescape")


def version() -> str:
    """The library's version, such as "0.2.0"."""
    return call("furrow_version").decode()


def set_log(log: Optional[Callable[[int, str], None]]) -> None:
    """Sets who gets the library's notes: log(level, message). None: nobody, as at the start.

    level: 0 is a note. The function may be called from any thread; it must not call furrow.
    """
    global _log_held
    with _log_lock:
        new = _log_type() if log is None else _log_type(
            lambda level, message, user: log(level, message.decode(errors="replace")))
        call("furrow_set_log", new, None)
        _log_held = new


@atexit.register
def _end_log() -> None:
    """A thread of the library must not call into an interpreter that has ended."""
    if _log_held is not None:
        set_log(None)


def import_dem(sources: Union[Path, Iterable[Path]], store: Path, *, progress: Optional[Callable[[float], Any]] = None,
               **options: Any) -> None:
    """Makes a store of elevation data, as the command `furrow import` does.

    sources: one path or several, of rasters, folders, or "@list.txt". store: path of the file to make.
    progress: gets the share that is done, 0 to 1, and returns False to stop; None goes on. An exception stops it, too.
    imagery=["ortho.tif"] puts colours over the terrain, too; with no sources ([]) into the store that exists.
    options: the command's long names with _ for -, such as max_error=0.01 (m), spacing=1 (m), overwrite=True.

    furrow.Error with Status.INTERRUPTED: progress stopped it. A call with resume=True goes on.
    """
    paths = [sources] if isinstance(sources, (str, os.PathLike)) else list(sources)
    array = (ctypes.c_char_p * len(paths))(*map(text, paths))
    raised: "list[BaseException]" = []

    def ask(share: float, user: Any) -> bool:
        try:
            return progress is None or progress(share) is not False
        except BaseException as error:  # Ctrl-C as well: it stops the import and is raised again below
            raised.append(error)
            return False

    try:
        call("furrow_import", array, len(paths), text(store), yaml(options) if options else None, _progress_type(ask), None)
    except Error:
        if raised:
            raise raised[0] from None
        raise
