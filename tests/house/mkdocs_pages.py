"""The site that mkdocs makes of the pages: every page is in its navigation, no link is dead, nothing comes from the network."""
import collections
import html.parser
import importlib.util
import json
import os
import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest
import urllib.parse

ROOT = pathlib.Path(os.environ["SOURCES"]).parent
SPEC = importlib.util.spec_from_file_location("site_of_pages", ROOT / "docs" / "mkdocs_pages.py")
site = importlib.util.module_from_spec(SPEC)
SPEC.loader.exec_module(site)


class Page(html.parser.HTMLParser):
    """What a page names: links, what a browser loads by itself, and its own ids. How many of each tag it has."""

    def __init__(self, text):
        super().__init__()
        self.links, self.loads, self.ids, self.tags = set(), set(), set(), collections.Counter()
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        of = dict(attrs)
        self.tags[tag] += 1
        self.ids |= {of[name] for name in ("id", "name") if of.get(name)}
        if tag == "a" and of.get("href"):
            self.links.add(of["href"])
        elif tag in ("script", "img", "iframe") and of.get("src"):
            self.loads.add(of["src"])
        elif tag == "link" and of.get("rel") in ("stylesheet", "icon", "shortcut icon") and of.get("href"):
            self.loads.add(of["href"])


def dead(folder):
    """Links of the site in `folder` that lead nowhere, and what it loads from elsewhere: [(page, link)]."""
    found = {path: Page(path.read_text(encoding="utf-8")) for path in sorted(folder.rglob("*.html"))}
    wrong = []
    for path, page in found.items():
        if path.name == "404.html":  # its links are of the server's root
            continue
        for link in sorted(page.links | page.loads):
            parts = urllib.parse.urlsplit(link)
            if parts.scheme or parts.netloc:
                if link in page.loads:
                    wrong.append((path.name, link))
                continue
            to = pathlib.Path(os.path.normpath(path.parent / urllib.parse.unquote(parts.path))) if parts.path else path
            to = to / "index.html" if to.is_dir() else to
            anchor = urllib.parse.unquote(parts.fragment)
            if not to.is_file() or anchor and anchor not in found[to].ids:
                wrong.append((str(path.relative_to(folder)), link))
    return wrong


class Site(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="furrow-site-"))
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)

    def test_every_page_is_in_the_navigation_once(self):
        named = re.findall(r"^ +- [^:]+: (\S+\.md)$", (ROOT / "mkdocs.yml").read_text(encoding="utf-8"), re.MULTILINE)
        self.assertEqual(sorted(named), sorted(site.pages()))

    def test_its_style_is_there_and_lets_wide_tables_scroll(self):
        named = re.search(r"^extra_css: \[(.*)\]$", (ROOT / "mkdocs.yml").read_text(encoding="utf-8"), re.MULTILINE)[1]
        self.assertEqual(named.split(", "), site.STYLES)
        self.assertRegex((ROOT / site.STYLES[0]).read_text(encoding="utf-8"), r"table \{[^}]*overflow-x: auto;")

    def test_a_page_is_written_as_mkdocs_reads_it(self):
        self.assertEqual(site.for_mkdocs("Two:\n- a\n- b\n  more\n  - c\n\n```\nx:\n- y\n```\n", "docs/X.md"),
                         "Two:\n\n- a\n- b\n  more\n    - c\n\n```\nx:\n- y\n```\n")
        self.assertEqual(site.for_mkdocs("[s](../tools/scenes) [d](DESIGN.md#words)\n", "docs/X.md"),
                         "[s](../tools/scenes/index.md) [d](DESIGN.md#words)\n")
        self.assertEqual(site.links("[a](b.md#c) [d](#e) [f](https://g.h)\n```\n[i](j)\n```\n![k](l.svg)"), {"b.md", "l.svg"})

    def test_what_is_dead_is_seen(self):
        (self.folder / "a.html").write_text('<a href="b.html#here"></a><a href="b.html#gone"></a><a href="c.html"></a><a href="https://x.org">'
                                            '</a><script src="https://x.org/s.js"></script>')
        (self.folder / "b.html").write_text('<h2 id="here">Here</h2><img src="p.png">')
        self.assertEqual(dead(self.folder), [("a.html", "b.html#gone"), ("a.html", "c.html"), ("a.html", "https://x.org/s.js"), ("b.html", "p.png")])

    @unittest.skipUnless(shutil.which("mkdocs"), "there is no mkdocs")
    def test_it_is_made_without_a_warning_or_a_dead_link(self):
        out = self.folder / "site"
        done = subprocess.run(["mkdocs", "build", "--strict", "--site-dir", out], cwd=ROOT, capture_output=True, text=True, timeout=300)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertNotIn("WARNING", done.stderr)
        self.assertEqual(dead(out), [])
        self.assertTrue((out / site.STYLES[0]).is_file())
        of_theme = Page((out / "404.html").read_text(encoding="utf-8")).tags["table"]
        for page in site.pages():
            made = out / (page[:-len("README.md")] + "index.html" if page.endswith("README.md") else page[:-3] + ".html")
            text = (ROOT / page).read_text(encoding="utf-8")
            tables = len(re.findall(r"^\| ?---", text, re.MULTILINE))
            self.assertEqual(Page(made.read_text(encoding="utf-8")).tags["table"] - of_theme, tables, page)
        known = {entry["location"].partition("#")[0] for entry in json.loads((out / "search" / "search_index.json").read_text())["docs"]}
        self.assertGreaterEqual(len(known), len(site.pages()))


if __name__ == "__main__":
    unittest.main()
