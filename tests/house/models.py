"""No code outside of src/deform/soil names a soil model: it asks the model's row (struct soil_model) what the model does."""
import pathlib
import re
import sys
import unittest

ROOT = pathlib.Path(__file__).parents[2]
LIST = ROOT / "src" / "deform" / "deform.h"


def models():
    """{number's name: name in a scene}, of the list of models."""
    text = LIST.read_text(encoding="utf-8")
    lines = re.search(r"#define DEFORM_MODELS_EACH\(MODEL\) \\\n((?:\tMODEL\(\w+, \w+\)(?: \\)?\n)+)", text)[1]
    return dict(re.findall(r"MODEL\((\w+), (\w+)\)", lines))


class Models(unittest.TestCase):
    def test_nobody_names_a_model(self):
        named = re.compile(r"\b(?:%s)\b" % "|".join(models()))
        files = [path for folder in ("src", "tools", "shaders", "examples") for path in sorted((ROOT / folder).rglob("*.[chg]*"))]
        self.assertGreater(len(files), 100)
        found = []
        for path in files:
            if path == LIST or "src/deform/soil" in path.as_posix() or path.suffix not in (".c", ".h", ".glsl", ".frag", ".vert"):
                continue
            for number, line in enumerate(path.read_text(encoding="utf-8").split("\n"), 1):
                if named.search(line):
                    found.append("%s:%d: %s" % (path.relative_to(ROOT), number, line.strip()))
        self.assertEqual(found, [], "ask deform_model_row instead")

    def test_each_model_has_a_file_that_defines_its_row(self):
        self.assertGreater(len(models()), 4)
        for word in models().values():
            text = (ROOT / "src" / "deform" / "soil" / (word + ".c")).read_text(encoding="utf-8")
            self.assertIn("const struct soil_model deform_model_%s = {" % word, text)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
