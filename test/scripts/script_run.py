"""What the tests of scripts share: a folder for made-up files, and how a script ran in it."""

import collections
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

SCRIPTS = pathlib.Path(__file__).resolve().parents[2] / "scripts"

Run = collections.namedtuple("Run", "code out err")


class ScriptTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def write(self, name, content):
        """The path of a file with this text, or with this as JSON."""
        path = self.folder / name
        path.write_text(content if isinstance(content, str) else json.dumps(content), encoding="utf-8")
        return str(path)

    def run_script(self, name, *arguments):
        command = [sys.executable, "-B", str(SCRIPTS / name), *map(str, arguments)]
        result = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, check=False)
        run = Run(result.returncode, result.stdout.decode(), result.stderr.decode())
        self.assertNotIn("Traceback", run.err)
        return run
