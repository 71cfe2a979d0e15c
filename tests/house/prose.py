"""Comments and names of src and shaders are in plain words: short sentences, and the field's words.

A sentence of a comment has at most 25 words. Names and comments use none of the words in WORDS. Where old text does not pass yet,
prose_allowed.txt says how many findings of each kind a folder may still have. These numbers only shrink.

    python3 tests/house/prose.py --list [FOLDER...]   each finding, as FILE:LINE: KIND: TEXT
    python3 tests/house/prose.py --count              the findings of each folder
    python3 tests/house/prose.py --lower              writes smaller numbers into prose_allowed.txt, never larger ones
"""
import collections
import os
import pathlib
import re
import sys
import unittest

HERE = pathlib.Path(__file__).resolve().parent
SOURCES = pathlib.Path(os.environ.get("SOURCES", HERE.parent.parent / "src"))
SHADERS = SOURCES.parent / "shaders"
ALLOWED = HERE / "prose_allowed.txt"
KINDS = ("sentences", "words", "names")
LONGEST = 25
# What not to write, and what to write instead. All are whole words; a name is cut at its underscores.
WORDS = {
    "epoch": "commit", "wish": "prefetch request", "scout": "prefetcher", "lookout": "prefetcher", "rider": "body",
    "station": "path sample", "awake": "active", "pressed": "plastic sinkage", "heaped": "deposited thickness",
    "dirt": "disturbance", "stands": "is stable", "underside": "lower envelope", "lug": "grouser", "quantum": "fixed-point unit",
    "survey": "map raster", "carrier": "loaded body", "press": "contact", "sweep": "swept contact",
    "loose soil": "relaxing soil", "ground that slides": "relaxing soil", "what it makes and runs": "resources and passes",
}
FORMS = {"epochs": "epoch", "wishes": "wish", "wished": "wish", "scouts": "scout", "lookouts": "lookout", "riders": "rider",
         "stations": "station", "undersides": "underside", "lugs": "lug", "quanta": "quantum", "surveys": "survey",
         "carriers": "carrier", "presses": "press", "pressing": "press", "sweeps": "sweep", "swept": None}
# Names that are not ours to change.
FOREIGN = re.compile(r"(gl|GL|egl|EGL|sqlite3|SQLITE|SDL|CPL|GDAL|OGR|cJSON|yaml)_?[A-Z0-9_]")


def tokens(text):
    """The comments and the code of a file, each a list of (line, text). Strings are in neither."""
    comments, code, at = [], [], 0
    pattern = re.compile(r'/\*.*?\*/|//[^\n]*|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])*\'|^[ \t]*#[ \t]*include[^\n]*', re.S | re.M)
    for found in pattern.finditer(text):
        code.append((text.count("\n", 0, at) + 1, text[at:found.start()]))
        at = found.end()
        if found.group().startswith(("/*", "//")):
            comments.append((text.count("\n", 0, found.start()) + 1, found.group()))
    code.append((text.count("\n", 0, at) + 1, text[at:]))
    return joined(text, comments), code


def joined(text, comments):
    """Lines of // that follow each other alone on their lines are one comment."""
    out = []
    lines = text.split("\n")
    for line, comment in comments:
        alone = comment.startswith("//") and lines[line - 1].lstrip().startswith("//")
        if alone and out and out[-1][2] == line - 1:
            out[-1] = [out[-1][0], out[-1][1] + "\n" + comment, line]
        else:
            out.append([line, comment, line if alone else -1])
    return [(line, comment) for line, comment, last in out]


def paragraphs(line, comment):
    """The running text of a comment as (line, text); examples and pictures, which are indented by four and more, are not in it."""
    held, start = [], line
    body = re.sub(r"\*/$", "", comment)
    for number, row in enumerate(body.split("\n"), line):
        row = re.sub(r"^\s*(/\*+|//|\*)", "", row) if number > line else re.sub(r"^(/\*+|//)", "", row)
        plain = row.strip()
        if not plain or row.startswith("     ") or plain.startswith(("- ", "---")):
            if held:
                yield start, " ".join(held)
            held, start = [], number
        if plain and not row.startswith("     "):
            start = start if held else number
            held.append(plain)
    if held:
        yield start, " ".join(held)


def sentences(text):
    return [part for part in re.split(r"(?<=[.!?])[)\"]*\s+", text) if part]


def count_words(text):
    return sum(1 for word in text.split() if re.search(r"\w", word))


def wrong_words(text):
    """Of running text. What is quoted, and names of files and keys, belong to a format."""
    plain = re.sub(r'"[^"]*"|`[^`]*`|[\w/\[\]]+\.[\w./\[\]]*\w', " ", text).lower()
    found = [word for phrase in WORDS if " " in phrase for word in re.findall(r"\b%s\b" % phrase, plain)]
    for word in re.findall(r"\b\w+\b", plain):
        word = FORMS.get(word, word)
        if word in WORDS and word != "awake" or word == "awake" and "awake block" in plain:
            found.append(word)
    return found


def wrong_names(code, free):
    """Each name once: {name: word}."""
    found = {}
    for name in set(re.findall(r"\b[A-Za-z_]\w*", code)) - free:
        if not FOREIGN.match(name):
            for part in re.sub(r"([a-z0-9])([A-Z])", r"\1_\2", name).lower().split("_"):
                part = FORMS.get(part, part)
                if part in WORDS:
                    found[name] = part
    return found


def look(path, text, free=frozenset()):
    """Every finding in a file: (kind, line, what)."""
    comments, code = tokens(text)
    for line, comment in comments:
        for start, paragraph in paragraphs(line, comment):
            for sentence in sentences(paragraph):
                words = count_words(sentence)
                if words > LONGEST:
                    yield "sentences", start, "%d words: %s" % (words, sentence)
            for word in wrong_words(paragraph):
                yield "words", start, '"%s"; say: %s' % (word, WORDS[word])
    seen = set()
    for line, part in code:
        for number, row in enumerate(part.split("\n"), line):
            for name, word in sorted(wrong_names(row, free).items()):
                if name not in seen:
                    seen.add(name)
                    yield "names", number, '%s: "%s"; say: %s' % (name, word, WORDS[word])


def folders():
    """{folder: files}."""
    found = {path.name: path for path in sorted(SOURCES.iterdir()) if path.is_dir()}
    found["shaders"] = SHADERS
    ends = {".c", ".h", ".glsl", ".vert", ".frag", ".comp"}
    return {name: [path for path in sorted(folder.rglob("*")) if path.suffix in ends] for name, folder in found.items()}


def findings():
    """{folder: [(kind, "FILE:LINE", what)]}. A name counts once a folder."""
    contract = tokens((SOURCES / "api" / "furrow.h").read_text(encoding="utf-8"))[1]
    free = set(re.findall(r"\b[A-Za-z_]\w*", " ".join(part for line, part in contract)))
    out = collections.OrderedDict()
    for folder, files in folders().items():
        rows, names = [], set()
        for path in files:
            for kind, line, what in look(path, path.read_text(encoding="utf-8"), free):
                if kind == "names" and what in names:
                    continue
                if kind == "names":
                    names.add(what)
                rows.append((kind, "%s:%d" % (path.relative_to(SOURCES.parent), line), what))
        out[folder] = rows
    return out


def counts(rows):
    return tuple(sum(1 for row in rows if row[0] == kind) for kind in KINDS)


def allowed(text):
    """{folder: (sentences, words, names)}; a folder that is not there may have none."""
    rows = [line.split() for line in text.splitlines() if line.strip() and not line.startswith("#")]
    return {row[0]: tuple(map(int, row[1:])) for row in rows}


def too_many(folder, there, may):
    return ["%s: %d %s, allowed are %d" % (folder, n, kind, most) for kind, n, most in zip(KINDS, there, may) if n > most]


class Prose(unittest.TestCase):
    def test_no_folder_has_more_than_allowed(self):
        may = allowed(ALLOWED.read_text(encoding="utf-8"))
        found = findings()
        self.assertGreater(len(found), 10)
        for folder, rows in found.items():
            most = may.get(folder, (0, 0, 0))
            wrong = too_many(folder, counts(rows), most)
            kinds = {kind for kind, n, top in zip(KINDS, counts(rows), most) if n > top}
            self.assertEqual(wrong, [], "\nsome of these are new:\n" +
                             "\n".join("%s: %s: %s" % (at, kind, what) for kind, at, what in rows if kind in kinds))
            if counts(rows) != most:
                print("%s: fewer than allowed: %s < %s; run tests/house/prose.py --lower" % (folder, counts(rows), most))
        self.assertEqual(set(may) - set(found), set(), "prose_allowed.txt names folders that are not there")

    def test_what_is_wrong_is_seen(self):
        def kinds(text):
            return [row[0] for row in look("x.c", text)]
        self.assertEqual(kinds("/* %s. */" % " ".join(["word"] * 25)), [])
        self.assertEqual(kinds("/* %s. */" % " ".join(["word"] * 26)), ["sentences"])
        self.assertEqual(kinds("// %s\n// %s\n" % (" ".join(["a"] * 13), " ".join(["b"] * 13))), ["sentences"])
        self.assertEqual(kinds("/* %s. %s. */" % (" ".join(["a"] * 20), " ".join(["B"] * 20))), [])
        self.assertEqual(kinds("/*\n * %s\n *\n * %s\n */" % (" ".join(["a"] * 20), " ".join(["b"] * 20))), [])
        self.assertEqual(kinds("/* It moves soil. */ int soil;"), [])
        self.assertEqual(kinds("/* After two epochs the wishes go. */"), ["words", "words"])
        self.assertEqual(kinds('/* As "epoch" in epochs.log says. */'), [])
        self.assertEqual(kinds("int store_epoch;\nint store_epoch;"), ["names"])
        self.assertEqual(kinds("int PLANE_DIRT, compress, GL_PRESS;"), ["names"])
        self.assertEqual(kinds('puts("epoch /* wish */");'), [])
        self.assertEqual(too_many("x", (1, 2, 3), (1, 1, 4)), ["x: 2 words, allowed are 1"])


def lower():
    """Numbers become what is there where that is less. A folder without a row gets one only in an empty table."""
    text = ALLOWED.read_text(encoding="utf-8") if ALLOWED.exists() else ""
    may, first = allowed(text), not allowed(text)
    head = [line for line in text.splitlines() if line.startswith("#")]
    rows = []
    for folder, found in findings().items():
        there = counts(found)
        least = there if first else tuple(map(min, there, may.get(folder, (0, 0, 0))))
        rows.append("%-10s %9d %6d %6d" % ((folder,) + least))
    ALLOWED.write_text("\n".join(head + rows) + "\n", encoding="utf-8")


if __name__ == "__main__":
    if sys.argv[1:2] == ["--list"]:
        for one, list_of in findings().items():
            for row in list_of if one in sys.argv[2:] or not sys.argv[2:] else ():
                print("%s: %s: %s" % (row[1], row[0], row[2]))
    elif sys.argv[1:2] == ["--count"]:
        for one, list_of in findings().items():
            print("%-10s %9d %6d %6d" % ((one,) + counts(list_of)))
    elif sys.argv[1:2] == ["--lower"]:
        lower()
    else:
        unittest.main()
