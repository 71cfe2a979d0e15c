"""What the commands of the package share: how they end, and what they say when another package is missing."""
import argparse
import importlib
import math
import os
import pathlib
import stat
import sys
from typing import Any, Callable, TextIO

from furrow.results import ResultsError


class Missing(Exception):
    """A Python package is not installed. Its text says which, and what to do."""


def need(module: str, package: str) -> Any:
    """Imports a module of another package. `package`: as pip names it. Missing: it is not there."""
    try:
        return importlib.import_module(module)
    except ImportError:
        raise Missing(f"the Python package {package} is not installed for {sys.executable}; {sys.executable} -m pip install {package}") from None


class _Parser(argparse.ArgumentParser):
    def error(self, message: str) -> Any:
        self.exit(2, f"furrow: {self.prog.split()[-1]}: {message}; see {self.prog} --help\n")


def parser(name: str, about: str) -> argparse.ArgumentParser:
    """A parser whose errors are one line, with status 2."""
    return _Parser(prog=f"furrow {name}", description=about, formatter_class=argparse.RawDescriptionHelpFormatter)


def end(name: str, work: "Callable[[], None]", whole: bool = False) -> int:
    """Runs a command's work. Returns its status: 0 done, 1 failed or a package is missing, 3 bad input, 130 interrupted. `whole`: its errors of files begin with the
    file, and not with the command's name."""
    before = "furrow: " if whole else f"furrow: {name}: "
    try:
        work()
    except Missing as error:
        print(f"furrow: {name}: {error}", file=sys.stderr)
        return 1
    except OSError as error:
        where = str(error.filename).replace(f".{os.getpid()}.", "") if error.filename else ""  # a file that is not whole yet has another name
        if where:
            print(f"{before}{where}: {error.strerror}; give a place that can be written and has room", file=sys.stderr)
        else:
            print(f"{before}stdout: cannot be written; check the disk or the pipe" if error.errno else f"{before}{error}", file=sys.stderr)
        return 1
    except ResultsError as error:
        print(f"{before}{error}", file=sys.stderr)
        return 3
    except KeyboardInterrupt:
        print(f"furrow: {name}: interrupted; nothing was written", file=sys.stderr)
        return 130
    return 0


class Whole:
    """A file that is there when it is whole, and not before: with Whole(path) as temporary: write to it."""

    def __init__(self, path: pathlib.Path) -> None:
        self.path = path
        self.beside = path.with_name(f".{os.getpid()}.{path.name}")

    def __enter__(self) -> pathlib.Path:
        if self.path.exists() and not self.path.is_file() and not self.path.is_dir():
            raise OSError(f"{self.path}: is a device or a pipe, and would be replaced; give a file")
        return self.beside

    def __exit__(self, kind: Any, value: Any, trace: Any) -> None:
        if kind is None:
            os.replace(self.beside, self.path)
        else:
            self.beside.unlink(missing_ok=True)


def opened(path: "os.PathLike[str] | str") -> TextIO:
    """Opens a text file to read. OSError: it cannot be read, or it is no file (a pipe would never end)."""
    number = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_NOCTTY | os.O_CLOEXEC)
    if stat.S_ISDIR(os.fstat(number).st_mode):
        os.close(number)
        raise OSError(21, "Is a directory", str(path))
    if not stat.S_ISREG(os.fstat(number).st_mode):
        os.close(number)
        raise OSError(22, "not a file", str(path))
    return open(number, encoding="utf-8", errors="replace", newline="\n")


def number(text: str) -> "float | None":
    """A finite number as the command reads them. None: it is none."""
    try:
        value = float(text) if "_" not in text and text == text.strip() else math.nan
    except ValueError:
        value = math.nan
    return value if math.isfinite(value) else None


def quoted(text: str) -> str:
    """A text as a message shows it: in quotes, on one line, cut after 40 bytes."""
    line = "".join(char if char >= " " and char != "\x7f" else " " for char in text)
    short = line.encode("utf-8", "replace")[:40].decode("utf-8", "ignore")
    return '"' + short + ("..." if short != line else "") + '"'


def window(text: "str | None") -> "list[float] | None":
    """Four numbers X0,Y0,X1,Y1. None: there is no text. ResultsError: they are not."""
    if text is None:
        return None
    try:
        numbers = [float(word) for word in text.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) != 4 or not (numbers[0] < numbers[2] and numbers[1] < numbers[3]):
        raise ResultsError(f"--window {text}: it is no rectangle; give west,south,east,north in metres, as 10,10,50,40")
    return numbers


def joined(arguments: "list[str]", *options: str) -> "list[str]":
    """Arguments with the value of an option in one word with it: a list that begins with a minus would be taken for an option."""
    out: "list[str]" = []
    for word in arguments:
        if out and out[-1] in options:
            out[-1] += f"={word}"
        else:
            out.append(word)
    return out
