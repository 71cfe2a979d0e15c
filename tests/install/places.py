"""Where an installation puts things: manual pages, completions, pages, scenes and examples; and that nothing of the build's folders is named."""
import pathlib
import re
import shutil
import subprocess
import unittest

import prefix

SHARE = prefix.prefix / "share"
DOC = SHARE / "doc" / "furrow"
COMMANDS = re.findall(r"^  ([a-z-]+) +\S", prefix.run("furrow", "--help", env=prefix.environment).stdout.split("\n\n")[2], re.M)
MARKDOWN = {path.relative_to(prefix.ROOT) for path in prefix.ROOT.rglob("*.md")
            if not path.relative_to(prefix.ROOT).parts[0].startswith(("build", "demo", "mujoco-", ".")) and "tests" not in path.parts}


class PlacesTest(unittest.TestCase):
    def test_each_command_has_its_manual_page(self):
        self.assertGreater(len(COMMANDS), 20)
        pages = {path.name for path in (SHARE / "man").rglob("*.[1-9]")}
        self.assertEqual(pages, {"furrow.1", "furrow.3", "scene.5", "store.5"} | {f"furrow-{command}.1" for command in COMMANDS})
        for path in (SHARE / "man").rglob("*.[1-9]"):
            self.assertEqual(path.parent.name, "man" + path.suffix[1:])

    def test_manual_pages_are_clean(self):
        paths = sorted((SHARE / "man").rglob("*.[35]"))
        self.assertEqual(len(paths), 3)
        for path in paths:
            with self.subTest(path.name):
                result = prefix.run("groff", "-mandoc", "-ww", "-Tutf8", "-P-c", "-rLL=80n", path)
                self.assertEqual(result.stderr, "")
                for line in re.sub(".\b", "", result.stdout).splitlines():
                    self.assertLessEqual(len(line), 80, line)
                if shutil.which("mandoc") is not None:
                    told = subprocess.run(["mandoc", "-Tlint", "-Wwarning", path], capture_output=True, text=True).stdout
                    self.assertEqual(told, "")

    def test_pages_of_formats_have_every_key(self):
        for name, source in (("scene.5", "src/scene/SCENE.md"), ("store.5", "src/store/FORMAT.md")):
            page = prefix.run("groff", "-mandoc", "-Tutf8", "-P-c", "-rLL=400n", SHARE / "man" / "man5" / name).stdout
            words = "".join(re.sub(".\b", "", page).split())
            markdown, made = (prefix.ROOT / source).read_text(), (SHARE / "man" / "man5" / name).read_text()
            self.assertEqual(made.count(".Bl -enum"), len(re.findall(r"^1\. ", markdown, re.M)))
            keys = re.findall(r"^\| (`[^|]*`) \|", markdown, re.M)
            self.assertGreater(len(keys), 20)
            for key in keys:
                self.assertIn("".join(key.replace("`", "").split()), words)

    def test_the_manual_page_of_the_library_has_every_declaration(self):
        def letters(text):
            return re.sub(r"[\s`\u2010-]", "", text)

        page = prefix.run("groff", "-mandoc", "-Tutf8", "-P-c", "-rLL=80n", SHARE / "man" / "man3" / "furrow.3").stdout
        page = letters(re.sub(".\b", "", page))
        header = (prefix.prefix / "include" / "furrow.h").read_text()
        body = header[header.index('extern "C" {'):header.rindex("#ifdef __cplusplus")]
        declared = re.findall(r"^FURROW_API [^;]+;|^(?:typedef |struct |enum )[^;{]*(?:\{.*?^\})?[^;]*;", body, re.M | re.S)
        self.assertGreater(len(declared), 40)
        comments = [re.sub(r"^/\*|\*/$|^ \*(?!/)", "", comment, flags=re.M) for comment in re.findall(r"^/\*.*?\*/", body, re.M | re.S)]
        self.assertGreater(len(comments), 40)
        for text in declared + [comment for comment in comments if not comment.strip().startswith("---")]:
            self.assertTrue(letters(text.replace("FURROW_API ", "")) in page, text)

    def test_completions_are_where_shells_look(self):
        for place in ("bash-completion/completions/furrow", "zsh/site-functions/_furrow", "fish/vendor_completions.d/furrow.fish"):
            self.assertIn("furrow", (SHARE / place).read_text())

    def test_pages_scenes_and_examples_are_there(self):
        self.assertEqual({path.relative_to(DOC) for path in DOC.rglob("*.md")}, MARKDOWN)
        for folder in ("examples", "tools/scenes"):
            wanted = {path.name for path in (prefix.ROOT / folder).iterdir()}
            self.assertEqual({path.name for path in (DOC / folder).iterdir()}, wanted)
        for page in DOC.rglob("*.md"):
            for target in re.findall(r"!\[[^\]]*\]\(([^)#]+)\)", page.read_text()):
                self.assertTrue((page.parent / target).exists(), f"{page.name}: {target}")

    def test_everybody_can_read_what_somebody_with_a_narrow_umask_installed(self):
        paths = [prefix.prefix, *prefix.prefix.rglob("*")]
        self.assertGreater(len(paths), 150)
        for path in paths:
            mode = path.stat().st_mode
            self.assertEqual(mode & 0o444, 0o444, path)
            if path.is_dir() or path.parent == prefix.prefix / "bin":
                self.assertEqual(mode & 0o111, 0o111, path)

    def test_no_path_of_the_build_is_installed(self):
        seen = 0
        for path in prefix.prefix.rglob("*"):
            if path.is_file() and path.suffix in (".1", ".3", ".5", ".pc", ".h", ".fish", ".py") or path.name in ("furrow", "_furrow") and path.is_file():
                if path.parent.name != "bin":
                    self.assertNotIn(str(prefix.BUILD), path.read_text(encoding="utf-8"), path)
                    seen += 1
        self.assertGreater(seen, 30)


if __name__ == "__main__":
    unittest.main()
