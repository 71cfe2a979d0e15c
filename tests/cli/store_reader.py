"""A reader of stores, written from src/store/FORMAT.md alone: what it gets wrong, the page says wrong, or does not say.

It shares no code with the program but SQLite and, where they are, the system's libxxhash and libzstd; LZ4 is its own.
It checks as it reads what the page promises, and raises WrongStore where that does not hold.
"""
import ctypes
import functools
import math
import pathlib
import sqlite3
import struct

HOLE = -2**31
WORD = 2**32 - 1
PINS_SCHEMA = {
    "pinned": "pinned(revision INTEGER PRIMARY KEY, hash INTEGER NOT NULL, scene_hash TEXT, step INTEGER, time REAL, state TEXT, made INTEGER, "
              "who TEXT, what TEXT, working INTEGER, compacted INTEGER NOT NULL, relief TEXT)",
    "replaced": "replaced(plane INTEGER NOT NULL, key INTEGER NOT NULL, pinned INTEGER NOT NULL, low REAL, high REAL, below INTEGER, "
                "above INTEGER, codec INTEGER, revision INTEGER, hash INTEGER, blob BLOB, PRIMARY KEY(plane, key, pinned)) WITHOUT ROWID",
}
SCHEMA = {
    "meta": "meta(key TEXT PRIMARY KEY, value) WITHOUT ROWID",
    "base": "base(key INTEGER PRIMARY KEY, low REAL, high REAL, error REAL NOT NULL, codec INTEGER NOT NULL, "
            "revision INTEGER NOT NULL, hash INTEGER NOT NULL, blob BLOB NOT NULL)",
    "offset": '"offset"(key INTEGER PRIMARY KEY, low REAL, high REAL, below INTEGER NOT NULL, above INTEGER NOT NULL, '
              "codec INTEGER NOT NULL, revision INTEGER NOT NULL, hash INTEGER NOT NULL, blob BLOB NOT NULL)",
    **{plane: plane + "(key INTEGER PRIMARY KEY, low REAL, high REAL, codec INTEGER NOT NULL, revision INTEGER NOT NULL, "
              "hash INTEGER NOT NULL, blob BLOB NOT NULL)" for plane in ("dirt", "heaped", "pressed", "shear", "dug", "settled", "loose", "floor", "density", "slope", "healed", "risen", "grown")},
    "run": "run(id INTEGER PRIMARY KEY CHECK (id = 1), epoch INTEGER NOT NULL, scene_hash TEXT NOT NULL, "
           "step INTEGER NOT NULL, time REAL NOT NULL, state TEXT NOT NULL, made INTEGER NOT NULL, who TEXT NOT NULL, "
           "what TEXT NOT NULL)",
    "history": "history(plane INTEGER NOT NULL, key INTEGER NOT NULL, revision INTEGER NOT NULL, form INTEGER NOT NULL, "
               "codec INTEGER NOT NULL, hash INTEGER NOT NULL, blob BLOB NOT NULL, PRIMARY KEY(plane, key, revision)) WITHOUT ROWID",
    "revision": "revision(revision INTEGER PRIMARY KEY, scene_hash TEXT NOT NULL, step INTEGER NOT NULL, time REAL NOT NULL, "
                "state TEXT NOT NULL, made INTEGER NOT NULL, who TEXT NOT NULL, what TEXT NOT NULL, working INTEGER, "
                "compacted INTEGER NOT NULL)",
    "snapshot": "snapshot(name TEXT PRIMARY KEY, revision INTEGER NOT NULL, made INTEGER NOT NULL, who TEXT NOT NULL) WITHOUT ROWID",
}
TABLES = ("base", "offset", "dirt", "heaped", "pressed", "shear", "dug", "settled", "loose", "floor", "density", "slope", "healed", "risen", "grown")  # by the number that is hashed
META = {int: ("width", "height", "cells", "pack", "base_hash"),
        float: ("spacing", "step", "max_error", "origin_x", "origin_y"),
        str: ("srs", "vertical", "sources")}
SAME_IN_AN_OVERLAY = ("base_hash", "width", "height", "cells", "spacing", "step", "origin_x", "origin_y", "low", "high",
                      "srs", "vertical")


class WrongStore(Exception):
    pass


class NoLibrary(Exception):
    pass


def need(true, *what):
    if not true:
        raise WrongStore(" ".join(map(str, what)))


@functools.cache
def library(name):
    try:
        return ctypes.CDLL(name)
    except OSError as error:
        raise NoLibrary(str(error)) from error


def xxh3(data, seed=0):
    function = library("libxxhash.so.0").XXH3_64bits_withSeed
    function.restype = ctypes.c_uint64
    return function(bytes(data), ctypes.c_size_t(len(data)), ctypes.c_uint64(seed))


def zstd(frame, size):
    function = library("libzstd.so.1").ZSTD_decompress
    function.restype = ctypes.c_size_t
    out = ctypes.create_string_buffer(size + 1)
    done = function(out, ctypes.c_size_t(size + 1), bytes(frame), ctypes.c_size_t(len(frame)))
    need(done == size, "a zstd frame of", done, "bytes, not", size)
    return out.raw[:size]


def lz4(block, size=None):
    """One LZ4 block, which has `size` bytes unpacked if that is known; and how many bytes of `block` it is: all."""
    out, at = bytearray(), 0

    def length(nibble):
        nonlocal at
        total, more = nibble, nibble == 15
        while more:
            total += block[at]
            more = block[at] == 255
            at += 1
        return total

    while True:
        token = block[at]
        at += 1
        literals = length(token >> 4)
        need(at + literals <= len(block), "an LZ4 block ends in its literals")
        out += block[at:at + literals]
        at += literals
        if at == len(block):
            break
        back = block[at] | block[at + 1] << 8
        at += 2
        need(0 < back <= len(out), "an LZ4 match before the beginning")
        for _ in range(length(token & 15) + 4):
            out.append(out[-back])
    need(size is None or len(out) == size, "an LZ4 block of", len(out), "bytes, not", size)
    return bytes(out)


def signed(word, bits=32):
    return (word & 2**bits - 1) - ((word >> bits - 1 & 1) << bits)


class Cursor:
    def __init__(self, data):
        self.data, self.at = data, 0

    def take(self, size):
        need(self.at + size <= len(self.data), "a blob ends early")
        self.at += size
        return self.data[self.at - size:self.at]

    def u32(self):
        return int.from_bytes(self.take(4), "little")

    def rest(self):
        return self.take(len(self.data) - self.at)


def head(cursor, n, codec):
    flags = cursor.take(1)[0]
    known = {1: 1 | 2 | 4 | 8, 2: 1 | 2 | 4 | 8, 3: 1 | 4 | 8, 4: 1 | 8 | 16 | 32 | 64}
    need(flags & ~known[codec] == 0, "flags", flags)
    first = cursor.u32()
    scale = cursor.take(1)[0] if flags & 8 else 0
    need(not flags & 8 or 1 <= scale <= 31, "a scale of", scale)
    holes = None
    if flags & 1:
        bits = lz4(cursor.take(cursor.u32()), -(-n // 8))
        holes = [bits[i // 8] >> i % 8 & 1 for i in range(n)]
    return flags, first, scale, holes


def packed_residuals(cursor, n, byte_widths):
    blocks = -(-n // 16)
    if byte_widths:
        widths = list(cursor.take(blocks))
    else:
        widths = [byte >> shift & 15 for byte in cursor.take(-(-blocks // 2)) for shift in (0, 4)][:blocks]
    residuals = []
    for width in widths:
        need(width <= 32, "a width of", width)
        bits = int.from_bytes(cursor.take(2 * width), "little")
        residuals += [bits >> i * width & 2**width - 1 for i in range(16)]
    need(not any(residuals[n:]), "the last block is not filled up with zeros")
    need(cursor.at == len(cursor.data), "something follows the blocks")
    return residuals[:n]


def zstd_residuals(cursor, n):
    k = cursor.take(1)[0]
    need(1 <= k <= 4, "k is", k)
    data = zstd(cursor.rest(), k * n)
    return [sum(data[byte * n + i] << 8 * byte for byte in range(k)) for i in range(n)]


def undo_prediction(residuals, side, flags, first, scale, holes):
    above = [first] * side
    posts = []
    for row in range(side):
        rise = step = 0
        for x in range(side):
            z = residuals[row * side + x]
            r = (z >> 1 ^ -(z & 1)) << scale
            step = r + (step if flags & 4 and x > 1 else 0)
            rise += step
            above[x] = rise + above[x] & WORD
        posts += map(signed, above)
    if holes:
        need(not any(z for z, hole in zip(residuals, holes) if hole), "a hole's residual is not 0")
        posts = [HOLE if hole else post for post, hole in zip(posts, holes)]
    return posts


def read_code(cursor):
    """{(bits, code): symbol}"""
    k = cursor.take(1)[0]
    need(2 <= k <= 65, "a code of", k, "symbols")
    lengths = [byte >> shift & 15 for byte in cursor.take(-(-k // 2)) for shift in (0, 4)][:k]
    need(max(lengths) <= 8, "a code of", max(lengths), "bits")
    code, value, before = {}, -1, 0
    for bits, symbol in sorted((bits, symbol) for symbol, bits in enumerate(lengths) if bits):
        value = (value + 1) << bits - before
        before = bits
        code[bits, value] = symbol
    need(value == 2**before - 1, "a code that does not end in ones")
    return code


def read_stream(data, count, code):
    symbols, value, bits, at = [], 0, 0, 0
    while len(symbols) < count:
        need(at < 8 * len(data), "a stream ends early")
        value, bits, at = value << 1 | data[at // 8] >> at % 8 & 1, bits + 1, at + 1
        if (bits, value) in code:
            symbols.append(code[bits, value])
            value = bits = 0
    need(at > 8 * (len(data) - 1), "a stream has more")
    return symbols


def bands_of(c):
    return [(1, 11)] if c == 8 else [(c // 2 + 1, c // 16), (c // 2, c // 8), (1, c // 16)]


def read_part(cursor, grids, code, short):
    """The residuals of each grid's bands, as rows: {cells: [band]}"""
    data = cursor.take(cursor.u32())
    data = lz4(data) if short else data
    count = sum(rows * blocks for c in grids for rows, blocks in bands_of(c))
    at, symbols = 6, []
    for stream in range(4):
        size = int.from_bytes(data[2 * stream:2 * stream + 2], "little") if stream < 3 else len(data) - at
        symbols += read_stream(data[at:at + size], -(-count // 4) if stream < 3 else count - 3 * -(-count // 4), code)
        at += size
    symbols = iter(symbols)
    widths = {}
    for c in grids:
        for band, (rows, blocks) in enumerate(bands_of(c)):
            before = [0] * blocks
            for row in range(rows):
                before = widths[c, band, row] = [width + (s // 2 if s % 2 == 0 else -(s + 1) // 2)
                                                 for width, s in zip(before, symbols)]
    found = {}
    for (c, band, row), some in widths.items():
        residuals = []
        for width in some:
            need(0 <= width <= 32, "a width of", width)
            bits = int.from_bytes(cursor.take(width), "little")
            residuals += [signed(bits >> i * width, width) if width else 0 for i in range(8)]
        found.setdefault(c, []).append((band, row, residuals))
    return {c: [[r for b, _, r in rows if b == band] for band in range(3)] for c, rows in found.items()}


def predict(values, i, cubic):
    """Between the i-th value of a row or a column of even ones and the next."""
    a, b = values[i], values[i + 1]
    if not cubic:
        return signed(a + b + 1) >> 1
    before = values[i - 1] if i > 0 else 3 * (values[0] - values[1]) + values[2]
    after = values[i + 2] if i + 2 < len(values) else 3 * (values[-1] - values[-2]) + values[-3]
    return signed(9 * (a + b) - (before + after) + 8) >> 4


def finer_grid(coarse, bands, c, cubic):
    """Rows of c + 1 values from those of c / 2 + 1."""
    rows = [None] * (c + 1)
    for y, (row, residuals) in enumerate(zip(coarse, bands[0])):
        odd = [signed(predict(row, i, cubic) + residuals[i]) for i in range(c // 2)]
        rows[2 * y] = [value for pair in zip(row, odd) for value in pair] + row[-1:]
    columns = list(zip(*rows[::2]))
    for y, residuals in enumerate(bands[1]):
        rows[2 * y + 1] = [signed(predict(column, y, cubic) + r) for column, r in zip(columns, residuals + [bands[2][0][y]])]
    return rows


def levels(cursor, side):
    n, cells = side * side, side - 1
    flags, first, scale, holes = head(cursor, n, 4)
    code = read_code(cursor)
    grids = [8 << i for i in range(8) if 8 << i <= cells]
    bands = {}
    for part in ([grids[:-1], grids[-1:]] if cells > 8 else [grids]):
        bands.update(read_part(cursor, part, code, flags & 64))
    need(cursor.at == len(cursor.data), "something follows the blocks")
    relative = flags & (32 | 8)
    top = bands[8][0][0]
    need(not any(top[81:]), "the last block is not filled up with zeros")
    rows, above = [], [0 if relative else first] * 9
    for y in range(9):
        rise = 0
        for x in range(9):
            rise += top[9 * y + x]
            above[x] = signed(above[x] + rise)
        rows.append(list(above))
    for c in grids[1:]:
        rows = finer_grid(rows, bands[c], c, flags & 16)
    posts = [signed(first + (value << scale)) if relative else value for row in rows for value in row]
    if holes:
        posts = [HOLE if hole else post for post, hole in zip(posts, holes)]
    return posts, flags


def decode(codec, blob, side):
    """The side x side int32 posts of a plane, and the flags of its head (None where there is no head)."""
    n = side * side
    if codec == 0:
        need(len(blob) == 4, "a constant of", len(blob), "bytes")
        return [struct.unpack("<i", blob)[0]] * n, None
    need(codec in (1, 2, 3, 4), "codec", codec)
    cursor = Cursor(blob)
    if codec == 4:
        return levels(cursor, side)
    if codec == 2:
        size = cursor.u32()
        cursor = Cursor(lz4(cursor.rest(), size))
    flags, first, scale, holes = head(cursor, n, codec)
    residuals = zstd_residuals(cursor, n) if codec == 3 else packed_residuals(cursor, n, flags & 2)
    return undo_prediction(residuals, side, flags, first, scale, holes), flags


def key_of(level, x, y):
    morton = sum((x >> i & 1) << 2 * i | (y >> i & 1) << 2 * i + 1 for i in range(28))
    return level + 32 << 56 | morton


def unmorton(bits):
    return sum((bits >> 2 * i & 1) << i for i in range(28))


def bits_of(value):
    return struct.pack("<d", value or 0.0) if isinstance(value, (float, type(None))) else struct.pack("<q", value)


def half_away(value):
    return int(math.copysign(math.floor(abs(value) + 0.5), value))


def interpolated(posts, width, wide, high, k):
    """wide x high posts (None: a hole), 2^k times as fine as `posts`, which are rows of `width`; all on one integer lattice."""
    s = 2**k
    weights = [[[(step, weight) for step, weight in ((0, (s - fx) * (s - fy)), (1, fx * (s - fy)), (width, (s - fx) * fy),
                                                     (width + 1, fx * fy)) if weight] for fx in range(s)] for fy in range(s)]
    fine = []
    for y in range(high):
        for x in range(wide):
            at = y // s * width + x // s
            total = 2**(2 * k - 1)
            for step, weight in weights[y % s][x % s]:
                if posts[at + step] is None:
                    fine.append(None)
                    break
                total += posts[at + step] * weight
            else:
                fine.append(total >> 2 * k)
    return fine


class Row:
    """One row of base, or of a plane: a field for each column; its posts are decoded when asked for."""

    def __init__(self, record, side, table):
        self.__dict__.update(dict(record))
        self.side, self.table = side, TABLES.index(table)
        self.level, self.x, self.y = (self.key >> 56) - 32, unmorton(self.key), unmorton(self.key >> 1)
        need(key_of(self.level, self.x, self.y) == self.key, "key", self.key)

    @functools.cached_property
    def decoded(self):
        if self.codec == 5:
            return self.every_second(), None
        return decode(self.codec, self.blob, self.side)

    def every_second(self):
        """A base tile of an odd level, from the tiles below it, which are stored otherwise."""
        need(self.table == 0 and self.level > 0 and self.level % 2 == 1, "codec 5 at level", self.level)
        half, posts, children = self.side // 2, [HOLE] * self.side**2, 0
        for i in range(4):
            below = self.base.get(key_of(self.level - 1, 2 * self.x + i % 2, 2 * self.y + i // 2))
            if below:
                need(below.codec != 5, "codec 5 below codec 5")
                children |= 1 << i
                for y in range(half + 1):
                    at = (i // 2 * half + y) * self.side + i % 2 * half
                    posts[at:at + half + 1] = below.posts[2 * y * self.side:(2 * y + 1) * self.side:2]
        need(self.blob == bytes([children]), "tiles below", self.blob, "not", children)
        return posts

    @property
    def posts(self):
        return self.decoded[0]

    @property
    def flags(self):
        return self.decoded[1]

    def expected_hash(self):
        words = [getattr(self, name, 0) for name in ("key", "codec")]
        words += [getattr(self, name, None) for name in ("low", "high", "error")]
        words += [getattr(self, name, 0) for name in ("below", "above", "table")]
        return signed(xxh3(self.blob, xxh3(b"".join(map(bits_of, words)))), 64)


class Store:
    def __init__(self, path, depended_on=None):
        """`depended_on`: the hash of a state that an overlay names; shows that, if it is pinned."""
        path = pathlib.Path(path)
        db = sqlite3.connect(f"file:{path}?mode=ro", uri=True)
        db.row_factory = sqlite3.Row
        try:
            self.check_file(db)
            self.meta = {key: value for key, value in db.execute("SELECT key, value FROM meta")}
            self.check_meta()
            self.rows = {table: {record["key"]: Row(record, self.cells + 1, table)
                                 for record in db.execute(f'SELECT * FROM "{table}" ORDER BY key')}
                         for table in TABLES}
            for row in self.rows["base"].values():
                row.base = self.rows["base"]
            self.run = db.execute("SELECT * FROM run").fetchall()
            self.history = db.execute("SELECT * FROM history ORDER BY revision DESC").fetchall()
            if depended_on is not None:
                self.show_pinned(db, depended_on)
        finally:
            db.close()
        self.base_store = None
        if "base_path" in self.meta:
            self.base_store = Store(path.parent / self.meta["base_path"], self.meta.get("parent_hash"))
            need("base_path" not in self.base_store.meta or "parent_hash" in self.meta, "an overlay of an overlay without its hash")
            need(not self.rows["base"], "an overlay with base rows")
            if "parent_hash" in self.meta:
                need(self.meta["parent_hash"] == self.base_store.state_hash(), "parent_hash")
                self.inherit()
            for name in SAME_IN_AN_OVERLAY:
                need(self.meta[name] == self.base_store.meta[name], name, "is not the base's")
            self.rows["base"] = self.base_store.rows["base"]

    def show_pinned(self, db, depended_on):
        for pinned in db.execute("SELECT * FROM pinned WHERE hash = ?", (depended_on,)).fetchall():
            self.working, self.compacted = pinned["working"], pinned["compacted"]
            for number, table in enumerate(TABLES[1:], 1):
                columns = "key, low, high, " + ("below, above, " if table == "offset" else "") + "codec, revision, hash, blob"
                kept = db.execute(f"SELECT {columns} FROM replaced WHERE plane = ? AND pinned >= ? ORDER BY pinned DESC", (number, pinned["revision"]))
                for record in kept.fetchall():  # the least number comes last
                    self.rows[table].pop(record["key"], None)
                    if record["codec"] is not None:
                        self.rows[table][record["key"]] = Row(record, self.cells + 1, table)
                self.rows[table] = dict(sorted(self.rows[table].items()))

    def posts_then(self, table, key, revision):
        """A tile's posts at a revision that is kept."""
        row, side = self.rows[table].get(key), self.cells + 1
        posts = list(row.posts) if row else [0] * side**2
        for record in self.history:
            if (record["plane"], record["key"]) != (TABLES.index(table), key) or record["revision"] < revision:
                continue
            words = [record[name] for name in ("plane", "key", "revision", "form", "codec")]
            need(record["hash"] == signed(xxh3(record["blob"], xxh3(b"".join(map(bits_of, words)))), 64), "a hash in the history")
            change = decode(record["codec"], record["blob"], side)[0]
            need(record["form"] in (0, 1), "a form of", record["form"])
            posts = [signed((post if record["form"] else 0) + more & WORD) for post, more in zip(posts, change)]
        return posts

    def inherit(self):
        """The rows that count: its own, and those of its parent for which it has none; one from 0 to 0 says that there is none."""
        for table in TABLES[1:]:
            own, under = self.rows[table], self.base_store.rows[table]
            for key, row in own.items():
                need((row.low, row.high) != (0, 0) or (key in under and not any(row.posts)), "a row of zeros over nothing", table, key)
                need(key not in under or under[key].hash != row.hash, "the parent's row again", table, key)
            rows = {**under, **own}
            self.rows[table] = {key: rows[key] for key in sorted(rows) if (rows[key].low, rows[key].high) != (0, 0)}

    def state_hash(self):
        words = [self.meta["base_hash"], int(self.working is not None), self.working or 0, self.compacted]
        for number, table in enumerate(TABLES):
            if number > 0:
                for key, row in self.rows[table].items():
                    words += [number, key, row.hash]
        return signed(xxh3(b"".join(map(bits_of, words))), 64)

    def check_file(self, db):
        for name, value in (("application_id", 0x46757277), ("page_size", 8192), ("auto_vacuum", 2)):
            found = db.execute(f"PRAGMA {name}").fetchone()[0]
            need(found == value, name, found)
        self.version = db.execute("PRAGMA user_version").fetchone()[0]
        need(self.version == 8, "user_version", self.version)
        schema = {**SCHEMA, **PINS_SCHEMA}
        found = sorted(sql for sql, in db.execute("SELECT sql FROM sqlite_schema WHERE name NOT LIKE 'sqlite_%'"))
        need(found == sorted("CREATE TABLE " + words for words in schema.values()), "tables", found)

    def check_meta(self):
        for kind, names in META.items():
            for name in names:
                need(type(self.meta.get(name)) is kind, name, repr(self.meta.get(name)))
        for name in ("low", "high"):
            need(type(self.meta[name]) in (float, type(None)), name)
        self.width, self.height, self.cells = (self.meta[name] for name in ("width", "height", "cells"))
        self.step = self.meta["step"]
        self.working = self.meta.get("working")
        self.compacted = self.meta.get("compacted", 0)
        need(type(self.compacted) is int and abs(self.compacted) < 2**61, "compacted", repr(self.compacted))
        need(self.cells in [2**i for i in range(3, 11)], "cells", self.cells)
        self.coarsest = 0
        while self.tiles(self.coarsest) != (1, 1):
            self.coarsest += 1
        need(self.working is None or -14 <= self.working <= self.coarsest, "working", self.working)

    def tiles(self, level):
        if level <= 0:
            return tuple(max(1, -(-((posts - 1) << -level) // self.cells)) for posts in (self.width, self.height))
        return tuple(-(-count // 2) for count in self.tiles(level - 1))

    def size(self, level):
        """Posts of the whole terrain."""
        if level <= 0:
            return (self.width - 1 << -level) + 1, (self.height - 1 << -level) + 1
        return (self.width - 1 >> level) + 1, (self.height - 1 >> level) + 1

    def plane(self, table, level, beyond):
        """All posts of a level in rows from the south; `beyond`: what posts beyond the terrain must be."""
        wide, high = self.size(level)
        across, up = self.tiles(level)
        plane = [None] * (wide * high)
        side = self.cells + 1
        for y in range(up):
            for x in range(across):
                row = self.rows[table].get(key_of(level, x, y))
                need(row or table != "base" or level < 0, "no base row of level", level, "tile", x, y)
                posts = row.posts if row else [HOLE if table == "base" else 0] * side**2
                for j in range(side):
                    for i in range(side):
                        px, py, post = x * self.cells + i, y * self.cells + j, posts[j * side + i]
                        if px >= wide or py >= high:
                            need(post == beyond, table, "post", px, py, "beyond the terrain is", post)
                            continue
                        at = py * wide + px
                        need(plane[at] in (None, post), table, "post", px, py, "differs between tiles")
                        plane[at] = post
        return plane

    def height_of(self, code):
        if code == HOLE:
            return None
        if self.step:
            return code * self.step
        return struct.unpack("<f", struct.pack("<I", code if code >= 0 else 2**31 - (code + 1) & WORD))[0]

    @functools.cache
    def base(self, level):
        """Metres, None in a hole."""
        if level >= 0:
            return [self.height_of(code) for code in self.plane("base", level, HOLE)]
        if self.meta["low"] is None:
            wide, high = self.size(level)
            return [None] * (wide * high)
        middle = 1024 * half_away((self.meta["low"] + self.meta["high"]) / 2 / 1024)
        found = [self.height_of(code) for code in self.plane("base", level, HOLE)]
        for above in range(level + 1, 1):
            lattice = [None if post is None else half_away(2**18 * post) - 2**18 * middle
                       for post in map(self.height_of, self.plane("base", above, HOLE))]
            if above == 0 or any(post is not None for post in lattice):
                fine = interpolated(lattice, self.size(above)[0], *self.size(level), above - level)
                found = [old if old is not None or new is None else middle + new / 2**18 for old, new in zip(found, fine)]
        return found

    @functools.cache
    def offset(self, level):
        """2^-20 m."""
        wide, high = self.size(level)
        if self.working is None:
            return [0] * (wide * high)
        if level >= self.working:
            return self.plane("offset", level, 0)
        width, height = self.size(self.working)
        plane = self.plane("offset", self.working, 0)
        # A working level above 0 may end before the terrain does: what is beyond it is 0.
        padded = [post for y in range(height) for post in plane[y * width:(y + 1) * width] + [0]] + [0] * (width + 1)
        fine = interpolated(padded, width + 1, wide, high, self.working - level)
        return [0 if base is None else post for base, post in zip(self.base(level), fine)]

    def dirt(self, level):
        return self.plane("dirt", level, 0)

    def expected_base_hash(self):
        data = b"".join(bits_of(self.meta[name]) for name in
                        ("width", "height", "cells", "spacing", "step", "origin_x", "origin_y", "low", "high"))
        for name in ("srs", "vertical"):
            text = self.meta[name].encode()
            data += struct.pack("<Q", len(text)) + text
        for key in sorted(self.rows["base"]):
            data += struct.pack("<qq", key, self.rows["base"][key].hash)
        return signed(xxh3(data), 64)
