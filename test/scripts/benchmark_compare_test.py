"""Two files of benchmarks, made up, and what the comparison of them says."""

import unittest

from script_run import ScriptTest


def make_row(stage="cycle", median=4.0, p99=5.0, **more):
    row = {"scene": "trunk", "dofs": 1551, "rows": 14, "contacts": 3, "threads": 1, "isa": "avx2", "stage": stage}
    row.update({"median_ms": median, "p99_ms": p99, "thesis_ms": None}, **more)
    return row


def make_file(*rows, **header):
    return {"cpu": "made up", "cores": 2, **header, "rows": list(rows)}


class BenchmarkCompareTest(ScriptTest):
    def compare(self, old, new, *options):
        paths = [self.write(name, content) for name, content in (("old.json", old), ("new.json", new))]
        return self.run_script("benchmark_compare", *paths, *options)

    def read(self, run):
        """Ratio by stage and figure."""
        rows = [dict(word.split("=", 1) for word in line.split() if "=" in word) for line in run.out.splitlines()]
        return {(row["stage"], row["figure"]): float(row["ratio"]) for row in rows if "ratio" in row}

    def test_prints_every_ratio(self):
        run = self.compare(
            make_file(make_row(), make_row("qp", 0.2, 0.4)),
            make_file(make_row("qp", 0.1, 0.42), make_row(median=4.4)),
        )
        self.assertEqual(run.code, 0, run)
        ratios = self.read(run)
        expected = {("cycle", "median_ms"): 1.1, ("cycle", "p99_ms"): 1, ("qp", "median_ms"): 0.5, ("qp", "p99_ms"): 1.05}
        self.assertEqual(set(ratios), set(expected))
        for key, ratio in expected.items():
            self.assertAlmostEqual(ratios[key], ratio, places=3)
        self.assertEqual(list(ratios.values()), sorted(ratios.values(), reverse=True))

    def test_ratio_is_the_border(self):
        old, new = make_file(make_row(median=4.0)), make_file(make_row(median=4.8))
        self.assertEqual(self.compare(old, new).code, 1)
        self.assertEqual(self.compare(old, new, "--ratio", "1.21").code, 0)
        self.assertEqual(self.compare(old, new, "--ratio", "1.19").code, 1)
        self.assertIn("1 beyond 1.15", self.compare(old, new).out)
        self.assertEqual(self.compare(new, old).code, 0)

    def test_rows_match_by_what_they_are_about(self):
        old = make_file(make_row(median=1.0), make_row(median=3.0, isa="sse4.2"), make_row(median=2.0, threads=2))
        new = make_file(make_row(median=2.0, threads=2), make_row(median=1.0, contacts=4), make_row(median=3.0, isa="sse4.2"))
        run = self.compare(old, new)
        self.assertEqual(run.code, 0, run)
        self.assertNotIn("only in", run.out)

    def test_series_over_contacts_match_by_contacts(self):
        def series(*medians):
            rows = [make_row(median=median, scene="scaling_contacts", contacts=10 * k) for k, median in enumerate(medians)]
            return make_file(*rows)

        self.assertEqual(self.compare(series(1.0, 2.0, 3.0), series(1.0, 2.0, 3.0)).code, 0)
        self.assertEqual(self.compare(series(1.0, 2.0, 3.0), series(1.0, 3.0, 3.0)).code, 1)

    def test_other_durations_count_and_sizes_do_not(self):
        compliance = {"scene": "compliance", "dofs": 1551, "mesh": "bar", "cholmod_ms": 5.0, "ours_ms": 1.0, "ratio": 0.2, "error": 1e-12}
        tight = {"scene": "qpcc", "na": 3, "nc": 10, "kind": "bar", "budget_ms": 0.2, "median_us": 40.0}
        slower = dict(compliance, ours_ms=1.3)
        self.assertEqual(self.compare(make_file(compliance, tight), make_file(slower, tight)).code, 1)
        worse = dict(compliance, ratio=0.9, error=1e-3, cholmod_ms=9.0)
        self.assertEqual(self.compare(make_file(compliance, tight), make_file(worse, tight)).code, 0)
        self.assertEqual(self.compare(make_file(tight), make_file(dict(tight, median_us=90.0))).code, 1)

    def test_missing_scenes(self):
        both, one = make_file(make_row(), make_row(scene="finger")), make_file(make_row())
        run = self.compare(both, one)
        self.assertEqual(run.code, 1)
        self.assertIn("only in old.json: scene=finger", run.out)
        self.assertEqual(self.compare(both, one, "--partial").code, 0)
        run = self.compare(one, both)
        self.assertEqual(run.code, 0)
        self.assertIn("only in new.json: scene=finger", run.out)

    def test_options_choose_figures(self):
        old, new = make_file(make_row(p99=5.0), make_row("qp", 0.01, 0.02)), make_file(make_row(p99=9.0), make_row("qp", 0.02, 0.02))
        self.assertEqual(self.compare(old, new, "--figure", "median_ms", "--least", "0.05").code, 0)
        self.assertEqual(self.compare(old, new, "--figure", "median_ms").code, 1)
        self.assertEqual(self.compare(old, new, "--least", "0.05").code, 1)

    def test_says_that_machines_differ(self):
        run = self.compare(make_file(make_row()), make_file(make_row(), cpu="another"))
        self.assertIn("cpu was made up, is another", run.out)
        self.assertNotIn("cores was", run.out)

    def test_nothing_takes_any_time(self):
        still = make_file(make_row(median=0.0, p99=0.0))
        self.assertEqual(self.compare(still, still).code, 0)
        self.assertEqual(self.compare(still, make_file(make_row(median=0.1, p99=0.0))).code, 1)

    def test_bad_files(self):
        good = make_file(make_row())
        for bad, words in (
            ("", "no JSON"),
            ("{", "no JSON"),
            ([], "'rows'"),
            ({"rows": 3}, "'rows'"),
            ({"rows": [{"stage": "cycle"}]}, "'scene'"),
            ({"rows": []}, "no rows"),
            (make_file(make_row(), make_row()), "twice the row scene=trunk"),
            (make_file(make_row(scene="other")), "no duration in common"),
        ):
            run = self.compare(good, bad)
            self.assertEqual(run.code, 2, bad)
            self.assertIn(words, run.err)
        run = self.run_script("benchmark_compare", self.write("good.json", good), self.folder / "none.json")
        self.assertEqual(run.code, 2)
        self.assertIn("No such file", run.err)

    def test_bad_arguments(self):
        good = make_file(make_row())
        self.assertEqual(self.compare(good, good, "--ratio", "0").code, 2)
        self.assertEqual(self.run_script("benchmark_compare", "one.json").code, 2)
        self.assertEqual(self.run_script("benchmark_compare", "--help").code, 0)


if __name__ == "__main__":
    unittest.main()
