"""The code blocks of the documentation's pages, and how a page is run.

A fenced block has one of these languages:

- `sh`: commands, run by bash in the page's folder;
- `python`: run in the page's namespace, with `>>>` as doctests;
- `toml`, `json`: must be valid; saved if a comment names a file;
- `text`: something printed, or a sketch of a command; not run.

A comment on the line above changes that:

- `<!-- not run: REASON -->`
- `<!-- in tests: OLD -> NEW; OLD -> NEW -->`: with these replacements, such as fewer objects;
- `<!-- file: NAME -->`: the block is the file NAME;
- `<!-- output -->`: the text is what the last commands printed, `...` for lines left out;
- `<!-- exit code: N -->`: of the commands;
- `<!-- about -->`: the numbers of a doctest's output depend on scans, and so a little on the machine.
"""

import doctest
import json
import os
import re
import subprocess
import sys
import tomllib
from contextlib import chdir
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from tests.docs.excerpts import shows

ROOT = Path(__file__).parents[2]
LANGUAGES = ("sh", "python", "toml", "json", "text")
FENCE = re.compile(
    r"(?P<comments>(?:^[ ]*<!-- [^\n]* -->\n)*)"
    r"^(?P<indent>[ ]*)```(?P<language>[^\n]*)\n(?P<code>.*?)^(?P=indent)```$",
    re.MULTILINE | re.DOTALL,
)
COMMENT = re.compile(r"<!-- (not run|in tests|file|output|exit code|about)(?:: (.*))? -->")


@dataclass(frozen=True)
class Block:
    """A code block: its language, text and line, and the comments above it by their kind."""

    language: str
    code: str
    line: int
    comments: dict[str, str]

    @property
    def tested_code(self) -> str:
        """The text with the replacements for tests."""
        code = self.code
        for replacement in filter(None, self.comments.get("in tests", "").split("; ")):
            old, new = replacement.split(" -> ")
            assert old in code, f"line {self.line}: {old!r} is not in the block"
            code = code.replace(old, new)
        return code

    @property
    def runs(self) -> bool:
        """Whether it is run."""
        return self.language in ("sh", "python") and "not run" not in self.comments


def blocks_of(page: Path) -> list[Block]:
    """Return the fenced blocks of a page; directives of the site, such as ```{toctree}, are none."""
    text = page.read_text()
    return [
        Block(
            fence["language"],
            re.sub(f"^{fence['indent']}", "", fence["code"], flags=re.MULTILINE),
            text.count("\n", 0, fence.start("language")) + 1,
            {match[1]: match[2] or "" for match in COMMENT.finditer(fence["comments"])},
        )
        for fence in FENCE.finditer(text)
        if not fence["language"].startswith("{")
    ]


class AboutChecker(doctest.OutputChecker):
    """Compares as `shows` does."""

    def check_output(self, want: str, got: str, optionflags: int) -> bool:
        """Whether what was printed is about what is shown."""
        return super().check_output(want, got, optionflags) or shows(want.splitlines(), got.splitlines())


@dataclass
class PageRun:
    """A page that is run from top to bottom in a folder, after the files that it shows are written."""

    page: Path
    folder: Path
    names: dict[str, Any] = field(default_factory=lambda: {"__name__": "page"})
    printed: str = ""

    def run(self) -> None:
        """Write the files and run the blocks."""
        blocks = blocks_of(self.page)
        for block in blocks:
            if "file" in block.comments:
                (self.folder / block.comments["file"]).write_text(block.tested_code)
        with chdir(self.folder):
            for block in blocks:
                self._run(block)

    def _run(self, block: Block) -> None:
        if "output" in block.comments:
            shown = block.code.strip("\n").splitlines()
            assert shows(shown, self.printed.strip("\n").splitlines()), f"printed is {self.printed}"
        elif block.language in ("toml", "json"):
            _parsed(block)
        elif block.runs and block.language == "sh":
            self.shell(block)
        elif block.runs:
            self._python(block)

    def shell(self, block: Block) -> None:
        """Run the commands of a block."""
        bin_folder = Path(sys.executable).parent
        environment = {
            **os.environ,
            "PATH": f"{bin_folder}{os.pathsep}{os.environ['PATH']}",
            "PYTHONPATH": str(ROOT),
        }
        done = subprocess.run(
            ["bash", "-e", "-c", block.tested_code],
            cwd=self.folder,
            env=environment,
            capture_output=True,
            text=True,
            stdin=subprocess.DEVNULL,
        )
        expected = int(block.comments.get("exit code", "0"))
        assert done.returncode == expected, f"{block.tested_code}\n{done.stdout}\n{done.stderr}"
        self.printed = done.stdout

    def _python(self, block: Block) -> None:
        code = block.tested_code
        if ">>>" not in code:
            exec(compile(code, f"{self.page.name}:{block.line}", "exec"), self.names)
            return
        # `globs` is copied by DocTest: what the block defines is read back.
        test = doctest.DocTestParser().get_doctest(
            code, self.names, self.page.name, str(self.page), block.line
        )
        report: list[str] = []
        checker = AboutChecker() if "about" in block.comments else None
        runner = doctest.DocTestRunner(checker, verbose=False)
        results = runner.run(test, out=report.append, clear_globs=False)
        assert results.failed == 0, "".join(report)
        self.names = test.globs


def _parsed(block: Block) -> None:
    if block.language == "toml":
        tomllib.loads(block.code)
    else:
        for line in block.code.splitlines():
            json.loads(line)
