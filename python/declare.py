"""Writes furrow/_declarations.py: what furrow.h declares, for ctypes.

    declare.py HEADER OUTPUT LIBRARY PACKAGE

LIBRARY: path of the installed shared library; PACKAGE: folder of the installed Python package. The module keeps the way from
one to the other, so that an installation can be moved as a whole.

It reads the C that the header is written in, and no more: one declaration at a time, comments before a declaration or behind
a member. What it does not know is an error, so that the module never lacks a part of the header.
"""
import os
import re
import sys

SCALARS = {
    "void": "None", "bool": "ctypes.c_bool", "double": "ctypes.c_double", "float": "ctypes.c_float", "int": "ctypes.c_int",
    "int32_t": "ctypes.c_int32", "int64_t": "ctypes.c_int64", "uint8_t": "ctypes.c_uint8", "uint32_t": "ctypes.c_uint32",
    "uint64_t": "ctypes.c_uint64", "size_t": "ctypes.c_size_t",
}
# Of these Python makes objects; the others are handed over as arrays of structs.
RECORDS = ("furrow_info", "furrow_pose", "furrow_state", "furrow_contact", "furrow_vehicle_state")
# Members with a second name.
SAME = {"linear": "velocity"}
HINTS = {"bool": "bool", "double": "float", "float": "float"}
DTYPES = {"double": "float64", "float": "float32"}


class HeaderError(Exception):
    pass


def join_comment(text):
    """The words of a comment, without its stars."""
    lines = [line.strip().lstrip("*").strip() for line in text.strip().removeprefix("/*").removesuffix("*/").split("\n")]
    return "\n".join(lines).strip()


class Header:
    """The declarations of a header, in its order."""

    def __init__(self, text):
        self.typedefs = {}  # name -> C type
        self.enums = {}     # name -> [(enumerator, value)]
        self.structs = {}   # name -> (comment, [(name, C type, pointers, lengths, comment)])
        self.functions = {}  # name -> (comment, returned C type, [parameter])
        text = re.sub(r"^[ \t]*#(?:[^\n]*\\\n)*[^\n]*$", "", text, flags=re.M)
        text = re.sub(r'extern "C" \{', "", text)
        text = re.sub(r"^\}\s*$", "", text, flags=re.M)
        self._read(text)

    def _read(self, text):
        comment = ""
        while text.strip():
            text = text.lstrip()
            if text.startswith("/*"):
                end = text.index("*/") + 2
                comment, text = join_comment(text[:end]), text[end:]
                continue
            end, depth = 0, 0
            while end < len(text) and (depth > 0 or text[end] != ";"):
                if text.startswith("/*", end):
                    end = text.index("*/", end)
                depth += {"{": 1, "}": -1}.get(text[end], 0)
                end += 1
            if end == len(text):
                raise HeaderError(f"no declaration ends in: {text[:80]!r}")
            self._declaration(text[:end], comment)
            # A comment behind a declaration, on its line, is its own.
            comment, text = "", re.sub(r"\A[ \t]*/\*(?:(?!\*/)[^\n])*\*/", "", text[end + 1:])

    def _declaration(self, text, comment):
        plain = " ".join(re.sub(r"/\*.*?\*/", " ", text, flags=re.S).split())
        if match := re.fullmatch(r"typedef enum \{(.*)\} (\w+)", plain):
            self.enums[match[2]] = self._enumerators(match[1])
        elif match := re.fullmatch(r"enum (\w+) \{(.*)\}", plain):
            self.enums[match[1]] = self._enumerators(match[2])
        elif match := re.fullmatch(r"typedef (\w+) (\w+)", plain):
            self.typedefs[match[2]] = match[1]
        elif re.fullmatch(r"struct \w+", plain):
            pass
        elif match := re.fullmatch(r"struct (\w+) \{.*\}", plain):
            self.structs[match[1]] = (comment, self._members(text[text.index("{") + 1:text.rindex("}")]))
        elif match := re.fullmatch(r"FURROW_API (.*?)(\**)\b(\w+)\((.*)\)", plain):
            parameters = self._split(match[4]) if match[4] != "void" else []
            self.functions[match[3]] = (comment, (match[1].strip() + match[2]).strip(), parameters)
        else:
            raise HeaderError(f"not understood: {plain!r}")

    @staticmethod
    def _enumerators(text):
        found, value = [], 0
        for part in filter(None, (part.strip() for part in text.split(","))):
            name, _, given = part.partition("=")
            value = int(given, 0) if given else value
            found.append((name.strip(), value))
            value += 1
        return found

    @staticmethod
    def _members(text):
        """`type a, *b[3]; comment` one after another; a comment belongs to the members before it on its line."""
        members = []
        for match in re.finditer(r"([^;/]+);[ \t]*(/\*.*?\*/)?|/\*.*?\*/", text, flags=re.S):
            if match[1] is None:
                continue
            words = " ".join(match[1].replace("const ", "").split())
            kind, _, names = words.removeprefix("struct ").removeprefix("enum ").partition(" ")
            comment = join_comment(match[2]) if match[2] else ""
            for name in names.split(","):
                parts = re.fullmatch(r"(\**)(\w+)((?:\[\d+\])*)", name.strip())
                if parts is None:
                    raise HeaderError(f"member not understood: {words!r}")
                lengths = [int(length) for length in re.findall(r"\d+", parts[3])]
                members.append((parts[2], kind, len(parts[1]), lengths, comment))
        return members

    @staticmethod
    def _split(text):
        parts, depth = [""], 0
        for letter in text:
            depth += {"(": 1, ")": -1}.get(letter, 0)
            if letter == "," and depth == 0:
                parts.append("")
            else:
                parts[-1] += letter
        return [part.strip() for part in parts]

    def scalar(self, kind):
        """The ctypes type of a C type that is no pointer."""
        kind = kind.removeprefix("enum ").removeprefix("struct ")
        kind = self.typedefs.get(kind, kind)
        if kind in SCALARS:
            return SCALARS[kind]
        if kind in self.enums:
            return "ctypes.c_int"
        if kind in self.structs:
            return kind
        raise HeaderError(f"type not known: {kind!r}")

    def parameter(self, text):
        """The ctypes type of a parameter: pointers to strings and functions are told apart, all others are addresses."""
        text = " ".join(text.replace("const", " ").split())
        if match := re.fullmatch(r"(\w+) \(\*\w+\)\((.*)\)", text):
            arguments = [self.parameter(part) for part in self._split(match[2])]
            return f"ctypes.CFUNCTYPE({', '.join([self.scalar(match[1]), *arguments])})"
        if re.fullmatch(r"char \*\w+", text):
            return "ctypes.c_char_p"
        if "*" in text:
            return "ctypes.c_void_p"
        return self.scalar(text.rsplit(" ", 1)[0])

    def returned(self, text):
        text = " ".join(text.replace("const", " ").split())
        return "ctypes.c_char_p" if text == "char*" or text == "char *" else self.scalar(text)


def camel(name):
    return "".join(part.capitalize() for part in name.removeprefix("furrow_").split("_"))


def enumeration(name, entries):
    """Enumerators lose what all of them begin with."""
    prefix = "FURROW_"
    lines = [f"class {camel(name)}(enum.IntEnum):"]
    return lines + [f"    {entry.removeprefix(prefix)} = {value}" for entry, value in entries]


def structure(header, name, members):
    lines = [f"class {name}(ctypes.Structure):", "    _fields_ = ["]
    for member, kind, pointers, lengths, _ in members:
        if pointers > 0:
            of = "ctypes.c_char_p" if kind == "char" and pointers == 1 else "ctypes.c_void_p"
        else:
            of = header.scalar(kind)
        for length in reversed(lengths):
            of = f"{of} * {length}" if " * " not in of else f"({of}) * {length}"
        lines.append(f'        ("{member}", {of}),')
    return lines + ["    ]"]


def inner(header, members):
    """The members of structs inside a struct, at any depth: [(name, the struct's own name, C type, lengths, comment)]."""
    found = []
    for member, kind, *_ in members:
        if kind in header.structs:
            within = header.structs[kind][1]
            found += [(name, member, of, lengths, said) for name, of, _, lengths, said in within]
            found += [(name, member, of, lengths, said) for name, _, of, lengths, said in inner(header, within)]
    return found


def record(header, name, comment, members):
    """A class of Python with a property for each member, but for the size, and for each one of structs inside it."""
    lines = [f"class {camel(name)}(Record):", f'    """{comment}"""', f"    _structure = {name}"]
    short = inner(header, members)
    short += [(SAME[part], *rest) for part, *rest in short if part in SAME]
    short += [(SAME[member], "", kind, lengths, said) for member, kind, _, lengths, said in members if member in SAME]
    if short:
        lines.append(f"    _short = {tuple(part for part, *_ in short)!r}")
    for member, kind, pointers, lengths, said in members:
        if member in ("size", "reserved") and kind == "size_t":
            continue
        kind = header.typedefs.get(kind, kind)
        of = ""
        if pointers > 0:
            hint = "str"
        elif lengths:
            hint = "numpy.ndarray"
            of = f" {DTYPES.get(kind, kind.removesuffix('_t'))}, shape {tuple(lengths)}."
        elif kind in header.structs:
            hint = f'"{camel(kind)}"'
        elif kind in header.enums:
            hint = camel(kind)
        else:
            hint = HINTS.get(kind, "int")
        text = " ".join(said.split())
        if not text:
            raise HeaderError(f"{name}.{member} has no comment")
        text = text.removesuffix(".") + "." + of
        lines += ["", "    @property", f"    def {member}(self) -> {hint}:", f'        """{text}"""']
        got = f'self._get("{member}")'
        lines.append(f"        return {camel(kind)}({got})" if kind in header.structs or kind in header.enums
                     else f"        return {got}")
    same = {other: part for part, other in SAME.items()}
    for part, member, kind, lengths, said in short:
        hint = f'"{camel(kind)}"' if kind in header.structs else "numpy.ndarray" if lengths else HINTS.get(kind, "int")
        text = " ".join(said.split()).removesuffix(".") + "."
        of = f" {DTYPES.get(kind, kind)}, shape {tuple(lengths)}." if lengths else ""
        path = ".".join(filter(None, (member, same.get(part, part))))
        lines += ["", "    @property", f"    def {part}(self) -> {hint}:", f'        """{text}{of} The same as .{path}."""', f"        return self.{path}"]
    return lines


def write_module(header, library):
    lines = ['"""What furrow.h declares. Generated by declare.py at build time; changes here are lost."""',
             "import ctypes", "import enum", "", "import numpy", "", "from furrow._record import Record", "",
             f"LIBRARY = {library!r}  # from this folder", ""]
    for name, entries in header.enums.items():
        lines += ["", *enumeration(name, entries), ""]
    for name, (_, members) in header.structs.items():
        lines += ["", *structure(header, name, members), ""]
    for name in RECORDS:
        lines += ["", *record(header, name, *header.structs[name]), ""]
    lines += ["", "FUNCTIONS = {  # name: (returns a status, result, parameters)"]
    for name, (_, result, parameters) in header.functions.items():
        types = ", ".join(header.parameter(part) for part in parameters)
        checked = result == "furrow_status"
        lines.append(f'    "{name}": ({checked}, {header.returned(result)}, [{types}]),')
    return "\n".join(lines + ["}", ""])


def main(header, output, library, package):
    with open(header, encoding="utf-8") as file:
        module = write_module(Header(file.read()), os.path.relpath(library, package))
    with open(output, "w", encoding="utf-8") as file:
        file.write(module)


if __name__ == "__main__":
    if len(sys.argv) != 5:
        sys.exit("usage: declare.py HEADER OUTPUT LIBRARY PACKAGE")
    try:
        main(*sys.argv[1:])
    except HeaderError as error:
        sys.exit(f"declare.py: {sys.argv[1]}: {error}")
