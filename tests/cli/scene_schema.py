"""furrow scene --schema: a JSON Schema by which editors take every scene that furrow takes, and mark mistakes of keys, types, ranges and words."""
import importlib.util
import json
import pathlib
import re
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from furrow_test import FurrowTest, main  # noqa: E402

ROOT = pathlib.Path(__file__).parents[2]
PAGE = ROOT / "src" / "scene" / "SCENE.md"
LEAST = {"scene": 1, "end_time": 1}
WHEEL = {"name": "a", "shape": {"wheel": {"radius": 0.5, "width": 0.4}}, "path": {"points": [[20, 20], [30, 20]], "speed": 5}}


def lacks(*packages):
    return [name for name in packages if importlib.util.find_spec(name) is None]


def read_yaml(text):
    """As editors read YAML 1.2: on and off are words, times are texts, and 1e-3 is a number."""
    import yaml

    class Reader(yaml.SafeLoader):
        yaml_implicit_resolvers = {}

    for tag, pattern in (("bool", r"true|false"), ("null", r"null|~|"), ("int", r"[-+]?[0-9]+"),
                         ("float", r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?")):
        Reader.add_implicit_resolver(f"tag:yaml.org,2002:{tag}", re.compile(f"^(?:{pattern})$"), None)
    Reader.add_constructor("tag:yaml.org,2002:float", lambda loader, node: float(node.value))
    Reader.add_constructor("tag:yaml.org,2002:int", lambda loader, node: int(node.value))
    return yaml.load(text, Reader)


def as_json(value):
    """Keys of JSON are texts: {1: lunar} is {"1": lunar}."""
    if isinstance(value, dict):
        return {str(key): as_json(inner) for key, inner in value.items()}
    return [as_json(inner) for inner in value] if isinstance(value, list) else value


# Mistakes that an editor is to mark; furrow refuses each as well.
WRONG = [
    {**LEAST, "gravty": 1}, {**LEAST, "gravity": 0}, {**LEAST, "gravity": "much"}, {**LEAST, "time_step": 4000}, {"scene": 1}, {"scene": 2, "end_time": 1},
    {**LEAST, "redistribute": {"model": "scum"}}, {**LEAST, "redistribute": {}}, {**LEAST, "redistribute": {"model": "box", "radius": 1.5}},
    {**LEAST, "soil": {"name": "lunar", "friction_angle": 120}}, {**LEAST, "soil": {"over": {"thickness": 1}}}, {**LEAST, "soil": {"classes": {"1": {"cohesian": 3}}}},
    {**LEAST, "objects": [{**WHEEL, "shape": {"wheel": {"radius": 0.5}}}]}, {**LEAST, "objects": [{**WHEEL, "path": {"points": [[1, 2, 3]], "speed": 5}}]},
    {**LEAST, "objects": [{**WHEEL, "shape": {"box": {"size": [1, 1]}}}]}, {**LEAST, "objects": {"template": WHEEL}},
    {**LEAST, "view": {"camera": {"chase": "a"}, "effects": ["sku"]}}, {**LEAST, "view": {"effects": []}}, {**LEAST, "attributes": ["mud"]},
    {**LEAST, "cameras": [{"name": "a", "kind": "fixed", "pose": {"at": [1, 2, 3]}}]}, {**LEAST, "stop": []}, {**LEAST, "output": {"map": "yes"}},
    {**LEAST, "vehicles": [{"name": "v", "model": "v.xml", "start": {"at": [5, 5]}, "tyres": {"wheel": {"load": 3}}}]},
    {**LEAST, "vehicles": [{"name": "v", "model": "v.xml", "start": {"at": [5, 5]}, "driver": {"hold": [{"actuator": "drive"}]}}]},
]
# Short forms and former names, each of which furrow takes.
SHORT = [
    {"attributes": ["dirt"]}, {"attributes": ["disturbance", "vegetation"]}, {"redistribute": {"model": "slippage", "undisturbed": "stands"}, "soil": {"name": "lunar"}},
    {"soil": {"name": "snow_us", "thickness": 0.1, "over": "rigid"}, "redistribute": {"model": "scm"}},
    {"objects": [{**WHEEL, "shape": {"wheel": {"radius": 0.5, "width": 0.4, "lugs": 9, "lug_height": 0.1, "lug_thickness": 0.02}}}]},
    {"objects": {"template": WHEEL, "at": {"rows": 2, "columns": 3, "step": [3, 5]}, "every": 4}}, {"objects": [{"template": [WHEEL], "at": [[0, 0], [0, 5, 90]]}]},
    {"view": {"camera": {"over": "a", "height": 9}}}, {"view": {"camera": {"eye": [1, 2, 3], "target": [4, 5, 6]}}},
]


@unittest.skipIf(lacks("jsonschema", "yaml"), "not on this machine: python3-jsonschema and python3-yaml")
class SceneSchema(FurrowTest):
    def setUp(self):
        super().setUp()
        import jsonschema
        self.schema = self.json_of("scene", "--schema")
        jsonschema.Draft202012Validator.check_schema(self.schema)
        self.validator = jsonschema.Draft202012Validator(self.schema)

    def json_of(self, *words):
        return json.loads(self.ok(*words))

    def wrong(self, scene):
        return [f"{'/'.join(map(str, error.absolute_path))}: {error.message[:200]}" for error in self.validator.iter_errors(as_json(scene))]

    def refuses(self, scene):
        path = self.folder / "scene.yaml"
        path.write_text(json.dumps(scene))
        return self.furrow("explain", path).returncode == 3

    def test_it_takes_every_scene_that_is_shipped(self):
        scenes = [path for folder in ("", "vehicles") for path in sorted((ROOT / "tools" / "scenes" / folder).glob("*.yaml"))]
        self.assertGreater(len(scenes), 15)
        for path in scenes:
            self.assertEqual(self.wrong(read_yaml(path.read_text())), [], path)

    def test_it_takes_the_examples_of_the_page(self):
        examples = [text for text in re.findall(r"```yaml\n(.*?)```", PAGE.read_text(), re.S)]
        self.assertGreater(len(examples), 10)
        for text in examples:
            self.assertEqual(self.wrong({**LEAST, **read_yaml(text)}), [], text)

    def test_it_takes_scenes_with_each_key(self):
        import scene_page
        for sample in scene_page.SAMPLES:
            self.assertEqual(self.wrong(sample), [], sample)

    def test_it_takes_short_forms_and_former_names(self):
        for short in SHORT:
            scene = {**LEAST, "objects": [WHEEL], **short}
            self.assertEqual(self.wrong(scene), [], short)
            self.assertFalse(self.refuses(scene), short)
        wheel = self.schema["properties"]["objects"]["anyOf"][0]["items"]["anyOf"][0]["properties"]["shape"]["properties"]["wheel"]["properties"]
        self.assertTrue(wheel["lugs"]["deprecated"])

    def test_it_marks_what_furrow_refuses(self):
        self.assertFalse(self.refuses({**LEAST, "objects": [WHEEL]}))
        for scene in WRONG:
            scene = {"objects": [WHEEL], **scene}
            self.assertTrue(self.refuses(scene), scene)
            self.assertNotEqual(self.wrong(scene), [], scene)

    def test_every_key_tells_what_it_does(self):
        gravity = self.schema["properties"]["gravity"]
        self.assertEqual((gravity["exclusiveMinimum"], gravity["maximum"], gravity["default"]), (0, 1000, 9.81))
        self.assertIn("Unit: m/s2", gravity["description"])
        for row in self.json("scene")["keys"]:
            place = self.schema["properties"].get(row["key"])
            self.assertTrue(place is None or "Since " + row["since"] in place["description"], row["key"])


if __name__ == "__main__":
    main()
