"""All pages are quick to read, but for the list of changes: short sentences, and a README of at most 120 lines.

A sentence has at most 25 words, and the sentences of a page have 15 words or fewer on average. Code, tables, headings and pictures are not counted.
Where a page does not pass yet, reading_allowed.txt says how many longer sentences it may have, and which average. These numbers only shrink.

    python3 tests/house/reading.py --list [PAGE...]   each sentence that is too long, as FILE:LINE: WORDS: TEXT
    python3 tests/house/reading.py --count            longer sentences and average of each page
    python3 tests/house/reading.py --lower            writes smaller numbers into reading_allowed.txt, never larger ones
"""
import os
import pathlib
import re
import sys
import unittest

HERE = pathlib.Path(__file__).resolve().parent
ROOT = pathlib.Path(os.environ.get("SOURCES", HERE.parent.parent / "src")).parent
ALLOWED = HERE / "reading_allowed.txt"
FOLDERS = ("docs", "src", "bench", "examples")
LONGEST, AVERAGE, README_LINES = 25, 15.0, 120
ITEM = re.compile(r"\s*([-*]|\d+\.)\s+")


def paragraphs(text):
    """The running text of a page as (line, text): a paragraph, or an item of a list."""
    held, start, fence, after_blank, in_list, comment = [], 0, False, True, False, False
    for number, row in enumerate(text.split("\n") + [""], 1):
        plain = row.strip()
        if plain.startswith("```"):
            fence, plain = not fence, ""
        elif fence:
            plain = ""
        elif plain.startswith("<!--") or comment:
            comment = "-->" not in plain
            plain = ""
        elif row.startswith(("    ", "\t")) and not held and not (in_list and after_blank and ITEM.match(row)):
            plain = ""  # a block of code
        elif plain.startswith(("|", "#", "![", ">")):
            plain = ""
        item = bool(plain) and ITEM.match(row)
        if held and (not plain or item):
            yield start, " ".join(held)
            held = []
        if plain:
            start = start if held else number
            held.append(ITEM.sub("", row, count=1).strip() if item else plain)
        in_list = bool(item) or (in_list and (not row.strip() or row.startswith(" ")))
        after_blank = not row.strip()


def spoken(text):
    """As it is read: a link is its text, code is one word, emphasis and marks of figures are nothing."""
    text = re.sub(r"<!--.*?-->", "", text)
    text = re.sub(r"!\[[^]]*\]\([^)]*\)", "", text)
    text = re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", text)
    return re.sub(r"\*\*?|<br>", "", re.sub(r"`[^`]*`", "code", text))


def sentences(text):
    return [part for part in re.split(r"(?<=[.!?])[)\"]*\s+", spoken(text)) if count_words(part)]


def count_words(text):
    return sum(1 for word in text.split() if re.search(r"\w", word))


def read(text):
    """The sentences of a page as (line, words, text)."""
    return [(line, count_words(sentence), sentence) for line, paragraph in paragraphs(text) for sentence in sentences(paragraph)]


def figures(text):
    """(sentences that are too long, the average rounded up to a tenth)."""
    words = [count for line, count, sentence in read(text)]
    return sum(1 for count in words if count > LONGEST), -(-10 * sum(words) // max(1, len(words))) / 10


def pages():
    """{name: text} of every page of the site but the list of changes."""
    paths = [ROOT / "README.md", ROOT / "CONTRIBUTING.md"] + [path for folder in FOLDERS for path in sorted((ROOT / folder).rglob("*.md"))]
    return {str(path.relative_to(ROOT)): path.read_text(encoding="utf-8") for path in paths}


def allowed(text):
    """{page: (sentences, average)}; a page that is not there may have none, and the usual average."""
    rows = [line.split() for line in text.splitlines() if line.strip() and not line.startswith("#")]
    return {row[0]: (int(row[1]), float(row[2])) for row in rows}


def wrong(name, text, most):
    long, average = figures(text)
    found = ["%s:%d: %d words: %s" % (name, line, count, sentence) for line, count, sentence in read(text) if count > LONGEST] if long > most[0] else []
    if average > most[1]:
        found.append("%s: %.1f words in a sentence on average, allowed are %.1f" % (name, average, most[1]))
    return found


class Reading(unittest.TestCase):
    def test_pages_are_quick_to_read(self):
        may, found = allowed(ALLOWED.read_text(encoding="utf-8")), pages()
        self.assertGreater(len(found), 30)
        for name, text in found.items():
            most = may.get(name, (0, AVERAGE))
            with self.subTest(page=name):
                self.assertGreater(len(read(text)), 2)
                self.assertEqual(wrong(name, text, most), [], "\nmake these shorter: one fact a sentence")
            if name in may and figures(text) != most:
                print("%s: less than allowed: %s, %s; run tests/house/reading.py --lower" % (name, figures(text), most))
        self.assertEqual(set(may) - set(found), set(), "reading_allowed.txt names pages that are not there")
        self.assertEqual({name for name, most in may.items() if most == (0, AVERAGE)}, set(), "these pass: take them out of reading_allowed.txt")

    def test_the_readme_is_short(self):
        self.assertLessEqual(len(pages()["README.md"].splitlines()), README_LINES)

    def test_what_is_wrong_is_seen(self):
        def words(text):
            return [count for line, count, sentence in read(text)]
        self.assertEqual(words("# One two\n\nOne two\nthree. Four!\n\n- Five six\n  seven.\n- Eight.\n"), [3, 1, 3, 1])
        self.assertEqual(words("    code is here\n\n```yaml\nmore code\n```\n| a | b |\n| --- | --- |\n\n![A picture](x.png)\n<!-- no -->\n"), [])
        self.assertEqual(words("A [link of five words](to/some where.md#x) and `code of any length`. **Bold** word."), [7, 2])
        self.assertEqual(words("- One.\n\n## Two\n\n    a: b\n      - c: d\n\nThree.\n"), [1, 1])
        self.assertEqual(words("1. One two.\n2. Three.\n\n   Four five.\n"), [2, 1, 2])
        self.assertEqual(words("It takes 2.5 m (see below). Then 3 / 4 more."), [6, 4])
        self.assertEqual(figures("%s. %s." % (" ".join(["a"] * 25), " ".join(["a"] * 26))), (1, 25.5))
        self.assertEqual(figures("One two. One two. One two three."), (0, 2.4))
        self.assertEqual(len(wrong("x", " ".join(["a"] * 26) + ". A b.", (0, 14.0))), 1)
        self.assertEqual(len(wrong("x", " ".join(["a"] * 26) + ". A b.", (1, 14.0))), 0)
        self.assertEqual(len(wrong("x", " ".join(["a"] * 26) + ". A b.", (1, 13.9))), 1)


def lower():
    """Numbers become what is there where that is less. A page that passes loses its row."""
    text = ALLOWED.read_text(encoding="utf-8") if ALLOWED.exists() else ""
    may, found = allowed(text), pages()
    rows = [line for line in text.splitlines() if line.startswith("#")]
    for name, (most, average) in may.items():
        there = figures(found[name]) if name in found else (0, 0.0)
        least = min(there[0], most), max(AVERAGE, min(there[1], average))
        if least != (0, AVERAGE):
            rows.append("%-26s %9d %8.1f" % (name, *least))
    ALLOWED.write_text("\n".join(rows) + "\n", encoding="utf-8")


if __name__ == "__main__":
    if sys.argv[1:2] == ["--list"]:
        for one, page in pages().items():
            if one in sys.argv[2:] or not sys.argv[2:]:
                print("".join("%s:%d: %d: %s\n" % (one, line, count, sentence) for line, count, sentence in read(page) if count > LONGEST), end="")
    elif sys.argv[1:2] == ["--count"]:
        for one, page in pages().items():
            print("%-26s %9d %8.1f" % (one, *figures(page)))
    elif sys.argv[1:2] == ["--lower"]:
        lower()
    else:
        unittest.main()
