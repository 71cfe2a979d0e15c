"""--help, the manual pages and the completions of bash, zsh and fish name the same options, and the parser takes exactly those."""
import re
import shutil
import subprocess
import unittest

from furrow_test import FURROW, FurrowTest, long, main

KINDS = ("bash", "zsh", "fish")


def in_help(text):
    """The options of --help, each with the name of its value or "", as (those listed, those of the usage)."""
    rows = re.search(r"\noptions:\n(.*?)(\n\n|\Z)", text, re.S)
    listed = re.findall(r"^  (--?[a-z][a-z-]*)(?: (\S+))?", rows.group(1), re.M) if rows else []
    usage = re.search(r"^usage: .*?\n\n", text, re.S | re.M).group()
    named = re.findall(r"(?<=[ \[(])(--?[a-z][a-z-]*)(?: ([^\s\])|]+))?", usage)
    return dict(listed), dict(named)


def in_manual(source):
    found = re.findall(r"^\.It Fl (\S+)(?: Ar (.*))?$", source, re.M)
    return {"-" + name.replace("\\-", "-"): plain(value) for name, value in found}


def plain(text):
    return text.replace("\\-", "-").replace("\\(aq", "'").replace("\\&", "").replace("\\%", "")


def in_zsh(script, command):
    block = re.search(rf"^\t\t\({command}\)\n(.*?);;", script, re.S | re.M).group(1)
    return {name: value for name, value in re.findall(r"^\t\t\t'(?:\([^)]*\))?\*?(--?[a-z][a-z-]*)=?\[.*?(?<!\\)\](?::((?:\\.|[^:])*):.*)?' \\$", block, re.M)}


def in_fish(script, command):
    lines = [line for line in script.splitlines() if f"'__fish_seen_subcommand_from {command}' -" in line]
    found = [re.search(r"' -([sl]) ([a-z-]+)( -[xr])?", line) for line in lines]
    return {("-" if one.group(1) == "s" else "--") + one.group(2): bool(one.group(3)) for one in found if one}


class Help(FurrowTest):
    @classmethod
    def setUpClass(cls):
        def out(*arguments):
            return subprocess.run([FURROW, *arguments], capture_output=True, text=True, check=True).stdout
        cls.overview = out("--help")
        cls.commands = re.findall(r"^  ([a-z-]+) +\S", cls.overview.split("\n\n")[2], re.M)
        cls.help = {command: out(command, "--help") for command in cls.commands}
        cls.options = {command: in_help(text)[0] for command, text in cls.help.items()}
        cls.manual = {command: out("--print", "man", command) for command in cls.commands} | {"": out("--print", "man")}
        cls.scripts = {kind: out("--print", kind) for kind in KINDS}

    def complete(self, *words, cwd=None):
        """What bash offers for the last word."""
        script = self.folder / "furrow.bash"
        script.write_text(self.scripts["bash"])
        program = 'source "$0"; COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); _furrow; ((${#COMPREPLY[@]})) && printf "%s\\n" "${COMPREPLY[@]}"; exit 0'
        result = subprocess.run(["bash", "--norc", "-c", program, script, *words], capture_output=True, text=True, cwd=cwd or self.folder)
        self.assertEqual((result.returncode, result.stderr), (0, ""))
        return sorted(result.stdout.splitlines())

    def test_help_and_version_are_found_by_the_words_that_people_try(self):
        for name in ("drive", "study"):
            self.assertEqual(self.ok("help", name), self.ok(name, "--help"))
            self.assertEqual(self.ok(name, "-h"), self.ok(name, "--help"))
        for words in (["-h"], ["help"], ["help", "help"], ["help", "-h"]):
            self.assertEqual(self.ok(*words), self.ok("--help"))
        for words in (["-V"], ["version"]):
            self.assertEqual(self.ok(*words), self.ok("--version"))
        self.assertIn("did you mean drive?", self.refused(2, "help", "drvie"))

    def test_all_are_found(self):
        self.assertGreater(len(self.commands), 21)
        self.assertGreater(len(self.options["import"]), 20)
        self.assertEqual(self.options["snapshot"], {})

    def test_the_usage_names_what_is_listed(self):
        for command, text in self.help.items():
            with self.subTest(command):
                self.assertEqual(*in_help(text))

    @long
    def test_the_parser_takes_what_is_listed(self):
        for command, options in self.options.items():
            for name, value in options.items():
                with self.subTest(f"{command} {name}"):
                    told = self.refused(2, command, name) if value else self.refused(2, command, name + "=1")
                    self.assertIn(f"{name} needs a value; give {value}" if value else "takes no value", told)
            self.assertIn("is not an option", self.refused(2, command, "--nonsense"))

    def test_manual_pages_agree(self):
        for command, options in self.options.items():
            with self.subTest(command):
                self.assertEqual(in_manual(self.manual[command]), options)
                arguments = re.findall(r"^  (\S+(?: Y)?)  ", "".join(re.findall(r"\narguments:\n(.*?)\n\n", self.help[command] + "\n\n", re.S)), re.M)
                self.assertEqual([plain(name).replace(" Ar ", " ") for name in re.findall(r"^\.It Ar (.*)$", self.manual[command], re.M)], arguments)
                # The same words, whatever the lines.
                words = re.sub(r"\s+", " ", re.sub(r"^\..*$", "", plain(self.manual[command]), flags=re.M))
                for text in re.findall(r"^  --?\S+(?: \S+)?\s+(\S.*?)(?=\n  \S|\n\n|\Z)", self.help[command].partition("\noptions:\n")[2].partition("\n\n")[0], re.M | re.S):
                    begin = re.sub(r"\s+", " ", text).split(" (")[0][:60]
                    self.assertIn(begin, words.replace("\\(dq", '"').replace("\\(ha", "^").replace("\\e", "\\"))
        self.assertEqual(re.findall(r"^\.It Xr furrow-(\S+) 1$", self.manual[""], re.M), self.commands)

    def test_completions_agree(self):
        for command, options in self.options.items():
            with self.subTest(command):
                self.assertEqual(set(self.complete("furrow", command, "-")), set(options) | {"--help"})
                self.assertEqual(in_zsh(self.scripts["zsh"], command), options)
                self.assertEqual(in_fish(self.scripts["fish"], command), {name: bool(value) for name, value in options.items()})
        self.assertEqual(set(self.complete("furrow", "")), {*self.commands, "--help", "--version", "--print"})
        self.assertEqual(re.findall(r"-n __fish_use_subcommand -a (\S+)", self.scripts["fish"]), self.commands)
        self.assertEqual(re.findall(r"^\t\t'([a-z-]+):.*'$", self.scripts["zsh"], re.M), self.commands)

    def test_one_that_is_missing_is_seen(self):
        for name in ("--steps", "-o", "--set"):
            dash = name[1:].replace("-", "\\-")
            self.assertNotIn(name, in_manual(re.sub(rf"^\.It Fl {re.escape(dash)} .*\n", "", self.manual["drive"].replace("It Fl -", "It Fl \\-"), flags=re.M)
                                             .replace("It Fl \\-", "It Fl -")))
            self.assertNotIn(name, in_help(re.sub(rf"^  {name} .*\n", "", self.help["drive"], flags=re.M))[0])
            self.assertNotIn(name, in_zsh(re.sub(rf"^\t\t\t'\*?{name}\W.*\n", "", self.scripts["zsh"], flags=re.M), "drive"))
        self.assertNotIn("--steps", in_fish(re.sub(r"^.*-l steps .*\n", "", self.scripts["fish"], flags=re.M), "drive"))
        self.assertNotIn("--steps", in_help(self.help["drive"].replace("[--steps N]", ""))[1])

    def test_bash_completes_names_values_and_files(self):
        for name in ("a.yaml", "b.furrow", "c d.furrow", "e.tif", "f.txt"):
            (self.folder / name).touch()
        (self.folder / "sub").mkdir()
        for words, offered in (
                (("dr",), ["drive"]), (("re",), ["relink", "report", "reset", "restore"]),
                (("--print", "b"), ["bash"]),
                (("drive", ""), ["a.yaml", "sub"]), (("drive", "a.yaml", "--st"), ["--stage", "--steps", "--store"]),
                (("drive", "a.yaml", "--store", ""), ["b.furrow", "c d.furrow", "sub"]),
                (("drive", "a.yaml", "--store", "c"), ["c d.furrow"]),
                (("drive", "a.yaml", "-o", ""), ["sub"]), (("drive", "a.yaml", "--steps", ""), []),
                (("drive", "a.yaml", "--trace", "f"), ["f.txt", "furrow.bash"]),
                (("drive", "a.yaml", "--durable", ""), ["full", "normal"]),
                (("drive", "a.yaml", "--durable", "=", "f"), ["full"]), (("drive", "a.yaml", "--durable", "="), ["full", "normal"]),
                (("import", ""), ["e.tif", "f.txt", "sub"]), (("import", "e.tif", "-r", "c"), ["cubic"]),
                (("cache-sim", "t", "--policy", "lru,cl"), ["lru,clock"]), (("study", "c"), ["collect"]),
                (("query", "b.furrow", "--srs", ""), []),
                (("drive", "a.yaml", "--set", "cache.s"), ["cache.slots="]), (("explain", "a.yaml", "--set", "redistribute.fa"), ["redistribute.faces="]),
                (("drive", "a.yaml", "--set", "redistribute.faces", "="), ["off", "on"]), (("drive", "a.yaml", "--set", "output.map", "=", "t"), ["true"]),
                (("scene", "objects.shape.box.s"), ["objects.shape.box.size"]), (("scene", "soil.coh"), ["soil.cohesion"])):
            with self.subTest(words):
                self.assertEqual(self.complete("furrow", *words), offered)

    def test_choices_are_completed_and_no_others_are_taken(self):
        found = 0
        for command, text in self.help.items():
            for name, choices in re.findall(r"^  (--?\S+)(?:(?!^  \S).)*?\(([a-z0-9_, \n]+\sor\s+[a-z0-9_]+)[;)]", text, re.M | re.S):
                with self.subTest(f"{command} {name}"):
                    words = re.split(r",\s+|\s+or\s+", choices)
                    self.assertEqual(self.complete("furrow", command, name, ""), sorted(words))
                    self.assertIn("(" + " ".join(words) + ")", self.scripts["zsh"])
                    self.assertIn("'" + " ".join(words) + "'", self.scripts["fish"])
                    found += 1
        self.assertGreaterEqual(found, 7)

    def test_the_shells_read_their_scripts(self):
        for kind, options in (("bash", ["-n"]), ("zsh", ["-n"]), ("fish", ["--no-execute"])):
            script = self.folder / f"furrow.{kind}"
            script.write_text(self.scripts[kind])
            with self.subTest(kind):
                if shutil.which(kind) is None:
                    self.skipTest(f"there is no {kind}")
                result = subprocess.run([kind, *options, script], capture_output=True, text=True)
                self.assertEqual((result.returncode, result.stderr), (0, ""))

    def test_fish_offers_them(self):
        if shutil.which("fish") is None:
            self.skipTest("there is no fish")
        (self.folder / "furrow.fish").write_text(self.scripts["fish"])
        (self.folder / "b.furrow").touch()

        def offered(line):
            result = subprocess.run(["fish", "--no-config", "-c", f"source furrow.fish; complete -C '{line}'"], capture_output=True, text=True,
                                    cwd=self.folder)
            return {one.split("\t")[0] for one in result.stdout.splitlines()}
        self.assertEqual(offered("furrow drive --"), {name for name in self.options["drive"] if name.startswith("--")} | {"--help"})
        self.assertEqual(offered("furrow synth --kind "), {"ridged", "dunes", "plain"})
        self.assertIn("b.furrow", offered("furrow info "))
        self.assertIn("cache-sim", offered("furrow ca"))
        self.assertIn("cache.slots=", offered("furrow drive --set cache."))
        self.assertIn("redistribute.faces=off", offered("furrow drive --set redistribute.fa"))
        self.assertIn("soil.cohesion", offered("furrow scene soil."))

    def test_zsh_offers_them(self):
        if shutil.which("zsh") is None:
            self.skipTest("there is no zsh")
        (self.folder / "_furrow").write_text(self.scripts["zsh"])
        # A pseudo-terminal of zsh itself, in a shell without settings: what Tab does with $1, until it shows $2.
        (self.folder / "ask").write_text("""
zmodload zsh/zpty
zpty z zsh -f -i
zpty -w z "PS1=; fpath=($PWD $fpath); autoload -Uz compinit; compinit -u -D; setopt no_beep no_list_ambiguous; LISTMAX=1000; COLUMNS=200; echo ready"
zpty -r z out '*ready*ready*'
zpty -w -n z "$1"$'\\t'
zpty -r z out "*$2*"
print -r -- "$out"
zpty -d z
""")

        def offered(line, until):
            return subprocess.run(["zsh", "-f", "ask", line, until], capture_output=True, text=True, cwd=self.folder, timeout=250).stdout
        told = offered("furrow drive --", "--trace")
        for name in self.options["drive"]:
            if name.startswith("--"):
                self.assertIn(name, told)
        self.assertIn("collect", offered("furrow study col", "collect"))
        self.assertIn("dunes", offered("furrow synth --kind d", "dunes"))
        self.assertIn("cache.slots=", offered("furrow drive --set cache.sl", "cache.slots="))
        self.assertIn("redistribute.thrown=off", offered("furrow drive --set redistribute.thrown=of", "thrown=off"))
        self.assertIn("soil.cohesion", offered("furrow scene soil.coh", "cohesion"))

    def test_lines_are_short_and_manual_pages_are_clean(self):
        for command, text in {**self.help, "": self.overview}.items():
            for line in text.splitlines():
                self.assertLessEqual(len(line), 80, f"{command}: {line}")
        for command, source in self.manual.items():
            page = self.folder / f"furrow-{command}.1"
            page.write_text(source)
            with self.subTest(command):
                if shutil.which("groff") is not None:
                    result = subprocess.run(["groff", "-mandoc", "-ww", "-Tutf8", "-P-c", "-rLL=80n", page], capture_output=True, text=True)
                    self.assertEqual(result.stderr, "")
                    for line in re.sub(".\b", "", result.stdout).splitlines():
                        self.assertLessEqual(len(line), 82, line)
                if shutil.which("mandoc") is not None:
                    result = subprocess.run(["mandoc", "-Tlint", "-Wstyle", page], capture_output=True, text=True)
                    self.assertEqual([line for line in result.stdout.splitlines() if "referenced manual not found" not in line], [])

    def test_examples_and_pages_that_are_named_are_there(self):
        examples = 0
        for command, text in self.help.items():
            for line in "".join(re.findall(r"\nexamples:\n(.*?)(?:\n\n|\Z)", text, re.S)).splitlines():
                words = line.split()
                self.assertEqual(words[0], "furrow")
                self.assertLessEqual({word for word in words[2:] if re.match(r"--?[a-z]", word)}, set(self.options[words[1]]), line)
                examples += 1
            for page in "".join(re.findall(r"\nsee also: (.*)", text)).split(", "):
                self.assertIn(page, {"", "scene(5)", "store(5)", "furrow(3)"} | {f"furrow-{name}(1)" for name in self.commands})
        self.assertGreater(examples, 15)

    def test_what_is_not_printed_is_refused(self):
        for arguments in ([], ["tcsh"], ["man", "nonsense"], ["bash", "drive"], ["man", "drive", "view"]):
            with self.subTest(arguments):
                self.assertIn("--print", self.refused(2, "--print", *arguments))


if __name__ == "__main__":
    main()
