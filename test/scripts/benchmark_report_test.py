"""Lines of benchmarks, made up: the table, the file, and the page and pictures made of it."""

import json
import unittest

from script_run import ScriptTest

STAGES = "assembly factor detection compliance qp advance cycle".split()


def make_lines(scene, medians, dofs=1671, contacts=77, thesis="nan"):
    lines = []
    for stage, median in zip(STAGES, medians):
        lines.append(
            f"scene={scene} dofs={dofs} rows=14 contacts={contacts} contacts_max={contacts + 5} pressing=6 threads=1 isa=sse4.2"
            f" stage={stage} median_ms={median:.3f} p99_ms={2 * median:.3f} max_ms={3 * median:.3f}"
            f" thesis_ms={thesis if stage == 'cycle' else 'nan'}"
        )
    return lines


class BenchmarkReportTest(ScriptTest):
    def report(self, lines):
        path = self.folder / "rows.json"
        run = self.run_script("benchmark_report.py", self.write("lines", "\n".join(lines)), self.folder, "--json", path)
        return run, json.loads(path.read_text(encoding="utf-8")) if run.code == 0 else None

    def test_a_row_a_line(self):
        lines = make_lines("trunk_contact", [0.6, 3.3, 0.2, 3.4, 1.1, 0.1, 8.8], thesis="34.52")
        lines += ["scene=qpcc_reduced na=3 nc=50 ratio=7.25", "== building", ""]
        run, content = self.report(lines)
        self.assertEqual(run.code, 0, run)
        self.assertEqual(len(content["rows"]), 8)
        self.assertEqual(content["rows"][1]["median_ms"], 3.3)
        self.assertEqual(content["rows"][1]["dofs"], 1671)
        self.assertIsNone(content["rows"][1]["thesis_ms"])
        self.assertEqual(content["rows"][7], {"scene": "qpcc_reduced", "na": 3, "nc": 50, "ratio": 7.25})
        for name in ("date", "machine", "cpu", "cores", "compiler", "flags", "commit"):
            self.assertIn(name, content)

    def test_a_scene_is_one_aligned_line(self):
        lines = make_lines("trunk", [1, 2, 0, 4, 5, 6, 18], contacts=0) + make_lines("a_longer_name", [1, 2, 3, 4, 5, 6, 21])
        run, _ = self.report(lines)
        table = run.out.strip().splitlines()
        self.assertEqual(len(table), 3)
        self.assertEqual(len({len(line) for line in table}), 1)
        columns = table[0].replace("median ms", "scene").split()
        trunk = dict(zip(columns, table[1].split()))
        self.assertEqual((trunk["scene"], trunk["contacts"], trunk["factor"], trunk["cycle"]), ("trunk", "0", "2.00", "18.00"))

    def test_thesis_over_ours(self):
        run, _ = self.report(make_lines("trunk_contact", [0, 0, 0, 0, 0, 0, 10.0], thesis="34.52"))
        self.assertEqual(run.out.split()[-1], "3.5")

    def test_nothing_measured(self):
        run, _ = self.report(["no line of a benchmark"])
        self.assertNotEqual(run.code, 0)
        self.assertIn("nothing was measured", run.err)

    def test_page(self):
        lines = make_lines("trunk_contact", [0.6, 3.3, 0.2, 3.4, 1.1, 0.1, 8.63], thesis="34.52")
        lines += make_lines("trunk", [0.5, 2.5, 0, 0.3, 0.1, 0.1, 3.5], contacts=0)
        lines += ["scene=compliance dofs=1551 rows=14 mesh=bar isa=avx2 threads=1 cholmod_ms=3.1 ours_ms=0.775 ratio=0.25 error=1e-13"]
        self.report(lines)
        page = self.folder / "page.md"
        run = self.run_script("write_performance", self.folder / "rows.json", "--out", page)
        self.assertEqual(run.code, 0, run)
        text = page.read_text(encoding="utf-8")
        self.assertIn("1671 / 1665", text)
        self.assertIn("| 4.0 |", text)  # 34.52 / 8.63
        self.assertIn("0.775", text)
        self.assertNotIn("beam_contact", text)
        for line in text.splitlines():
            if line.startswith("| trunk"):
                self.assertEqual(line.count("|"), text.splitlines()[text.splitlines().index(line) - 1].count("|"))

    def test_pictures(self):
        lines = []
        for dofs, cycle in ((600, 1.0), (1500, 4.0), (15000, 300.0)):
            lines += make_lines("scaling_dofs", [cycle / 7] * 6 + [cycle], dofs=dofs, contacts=0)
        for contacts, cycle in ((0, 4.0), (10, 5.0), (150, 30.0)):
            lines += make_lines("scaling_contacts", [cycle / 7] * 6 + [cycle], contacts=contacts)
        self.report(lines)
        run = self.run_script("plot_benchmark", self.folder / "rows.json", "--out", self.folder)
        if "install python3-matplotlib" in run.err:
            self.skipTest(run.err)
        self.assertEqual(run.code, 0, run)
        for name in ("scaling_dofs.png", "scaling_contacts.png"):
            self.assertEqual((self.folder / name).read_bytes()[1:4], b"PNG")

    def test_bad_input(self):
        for script in ("plot_benchmark", "write_performance"):
            run = self.run_script(script, self.write("bad.json", "[]"))
            self.assertNotEqual(run.code, 0)
            self.assertIn("'rows'", run.err)
            self.assertEqual(self.run_script(script, "--help").code, 0)
        run = self.run_script("plot_benchmark", self.write("other.json", {"rows": [{"scene": "trunk"}]}))
        self.assertIn("no scene scaling_dofs or scaling_contacts", run.err)


if __name__ == "__main__":
    unittest.main()
