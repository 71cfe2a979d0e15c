"""What the benches' scripts share: figures as people read them, tables, a progress line, and pages that are rewritten
between two markers."""
import contextlib
import os
import sys
import time


class Told(Exception):
    """What went wrong and what to do, for the person who ran the script."""


def figure(value, digits=3):
    """`digits` significant ones, no exponent where people would write none."""
    if value is None:
        return "-"
    if value == 0:
        return "0"
    if 1e-3 <= abs(value) < 1e6:
        places = max(0, digits - 1 - int(f"{abs(value):e}".partition("e")[2]))
        return f"{value:,.{places}f}"
    return f"{value:.{digits - 1}e}"


def size(count):
    """Bytes."""
    if count is None:
        return "-"
    for unit, name in ((1e9, "GB"), (1e6, "MB"), (1e3, "kB")):
        if abs(count) >= unit:
            return f"{figure(count / unit)} {name}"
    return f"{count:.0f} B"


def table(head, rows):
    """Markdown."""
    lines = ["| " + " | ".join(head) + " |", "|" + " --- |" * len(head)]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows]) + "\n"


@contextlib.contextmanager
def aside(path):
    """A file that bears its name only when it is whole; what there is of it stays beside as PATH.part."""
    part = path.with_name(path.name + ".part")
    with open(part, "w") as file:
        yield file
    os.replace(part, path)


def between(page, name, text):
    """`page` with `text` between the markers of `name`."""
    begin, end = f"<!-- {name}: begin -->", f"<!-- {name}: end -->"
    if page.count(begin) != 1 or page.count(end) != 1 or page.index(begin) > page.index(end):
        raise Told(f"no one place for it: {begin} and then {end} are needed, once each; put them where it belongs")
    before, _, rest = page.partition(begin)
    return f"{before}{begin}\n{text.strip()}\n{end}{rest.partition(end)[2]}"


def publish(path, name, text):
    changed = between(path.read_text(), name, text)
    with aside(path) as file:
        file.write(changed)


class Progress:
    """One line on a terminal, none elsewhere."""

    def __init__(self, what):
        self.what, self.began, self.on = what, time.monotonic(), sys.stderr.isatty()

    def show(self, done, total, now=""):
        """total: None where it is not known."""
        if not self.on:
            return
        seconds = time.monotonic() - self.began
        of = f" of {total}, {seconds / done * (total - done):.0f} s left" if total and done else ""
        sys.stderr.write(f"\r{self.what}: {done}{of}, {seconds:.0f} s  {now}"[:150] + "\033[K")
        sys.stderr.flush()

    def end(self):
        if self.on:
            sys.stderr.write("\r\033[K")


def main(run):
    """Exit statuses as the command's: 1 failed, 130 interrupted."""
    try:
        run()
    except Told as told:
        sys.exit(f"{os.path.basename(sys.argv[0])}: {told}")
    except KeyboardInterrupt:
        sys.stderr.write("\n")
        sys.exit(130)
