"""Arrays that other packages can read: structs with a column for each number, and posts that know where they are."""
import itertools
from typing import Any

import numpy

AXES = "xyz"


def _parts(name: str, dtype: numpy.dtype, offset: int) -> "dict[str, tuple[numpy.dtype, int]]":
    """The numbers of a field: normal_x, normal_y and normal_z of one of three, stiffness_0_0 and so on of one of 6 x 6."""
    if dtype.subdtype is None:
        return {name: (dtype, offset)}
    base, shape = dtype, ()
    while base.subdtype is not None:  # C's array of arrays
        base, more = base.subdtype
        shape += more
    places = AXES if shape == (len(AXES),) else itertools.product(*map(range, shape))
    return {"_".join([name, *map(str, place)]): (base, offset + i * base.itemsize) for i, place in enumerate(places)}


def columns(dtype: numpy.dtype) -> numpy.dtype:
    """A dtype of the same bytes whose names are those of single numbers. What was a field of several is one still: ["normal"] is (n, 3).

    pandas.DataFrame takes no field of several numbers, and makes a column of each of dtype.names. numpy looks fields up in dtype.fields, which may have
    more of them: so it does with the titles of fields. The state that numpy itself pickles is the way to say both.
    """
    make, arguments, state = dtype.__reduce__()
    several = {name: dtype.fields[name][:2] for name in dtype.names}
    single = {part: place for name, (of, offset) in several.items() for part, place in _parts(name, of, offset).items()}
    made = make(*arguments)
    version, order, subarray, _, _, *rest = state
    made.__setstate__((version, order, subarray, tuple(single), {**several, **single}, *rest))
    return made


class Posts(numpy.ndarray):
    """What World.read returns: (rows, columns) float64.

    x: (columns,), m, where each column is, local axes; y: (rows,), m, where each row is. Only this array has them. Parts of it would have other
    ones, so they have none, and what is computed from it is a plain array.
    """

    x: numpy.ndarray
    y: numpy.ndarray

    def __getattr__(self, name: str) -> Any:
        if name in ("x", "y"):
            raise AttributeError(f"furrow: only the array that World.read returned has {name}, no part or copy of it; take the same part of its {name}, "
                                 "or read with xarray=True")
        raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")

    def __array_wrap__(self, array: Any, context: Any = None, return_scalar: bool = False) -> Any:
        plain = numpy.asarray(array)
        return plain if plain.ndim > 0 else plain[()]


def posts(values: numpy.ndarray, x: numpy.ndarray, y: numpy.ndarray) -> Posts:
    """`values` with its places, not copied."""
    placed = values.view(Posts)
    placed.x, placed.y = x, y
    return placed


def data_array(placed: Posts, name: str, units: str) -> Any:
    """The same as an xarray.DataArray with the dimensions y and x; not copied. ImportError: xarray is not installed."""
    from furrow import _command  # pylint: disable=import-outside-toplevel
    try:
        package = _command.need("xarray", "xarray")
    except _command.Missing as missing:
        raise ImportError(f"furrow: read with xarray=True: {missing}") from None
    where = {"x": ("x", placed.x, {"units": "m", "long_name": "east of the store's south-west post"}),
             "y": ("y", placed.y, {"units": "m", "long_name": "north of the store's south-west post"})}
    return package.DataArray(numpy.asarray(placed), where, ("y", "x"), name, {"units": units})
