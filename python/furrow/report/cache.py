"""Misses over the size of the page cache, from the trace of a drive: furrow cache-sim computes them."""
import os

from furrow.report.ground import NoGround, ask
from furrow.report.run import Run

POLICIES = ("lru", "opt")
NAMES = ("LRU", "optimum")


class Cache:
    """slots, and misses for each of POLICIES; empty: there are none, and `why` is a sentence."""

    def __init__(self, run: Run) -> None:
        self.slots: "list[float]" = []
        self.misses: "list[list[float]]" = []
        self.accesses = self.tiles = 0
        self.why = self._read(run)

    def _read(self, run: Run) -> str:
        path = run.text("trace")
        if path is None:
            return "No cache curve: the drive wrote no trace; drive with --trace FILE"
        if not os.path.isfile(path):
            return f"No cache curve: {path} is not there any more"
        try:
            found = ask("cache-sim", path, "--policy", ",".join(POLICIES))
        except NoGround as error:
            return f"No cache curve: {error}"
        pinned = found["traced"]["pin"]
        if pinned["hits"] != run.number("cache.hits") or pinned["misses"] != run.number("cache.misses"):
            return f"No cache curve: {path} is the trace of another drive"
        self.accesses, self.tiles = found["accesses"], found["tiles"]
        if self.accesses == 0:
            return "No cache curve: the drive asked for no tile"
        if len(found["slots"]) == 1:
            return f"No cache curve: the drive touched {self.tiles} tile{'' if self.tiles == 1 else 's'}, fewer than the smallest cache has slots"
        self.slots, self.misses = found["slots"], [found["policies"][policy]["misses"] for policy in POLICIES]
        return ""
