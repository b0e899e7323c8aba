"""Lines of benchmarks, made up, that keep their bounds or miss them, and what a run says of them."""

import unittest

from script_run import ScriptTest


def make_compliance(isa="avx512", dofs=1584, mesh="bar", rows=87, threads=1, **figures):
    values = {"cholmod_ms": 4.0, "ours_ms": 0.4, "ratio": 10.0, "assembly_percent": 20.0, "error": 2e-12, "cholmod_error": 1e-12}
    values.update(figures)
    words = " ".join(f"{name}={value}" for name, value in values.items() if value is not None)
    return f"scene=compliance dofs={dofs} rows={rows} mesh={mesh} isa={isa} threads={threads} {words}"


def make_stage(scene, median, stage="cycle", isa="avx512"):
    return f"scene={scene} dofs=1671 rows=14 contacts=77 contacts_max=80 pressing=6 threads=1 isa={isa} stage={stage} median_ms={median} p99_ms={median}"


def make_whole():
    """Lines for every bound, all kept."""
    lines = []
    for isa, ratio in (("avx512", 8.0), ("avx2", 4.0), ("plain", 1.0)):
        for mesh, dofs in (("bar", 1584), ("bar", 6480), ("bar", 14700), ("gmsh", 12696), ("trunk", 1671)):
            lines.append(make_compliance(isa, dofs, mesh, ratio=ratio))
    lines += [make_stage(scene, median) for scene, median in (("trunk_contact", 1.0), ("beam_contact", 0.3), ("finger_contact", 0.2))]
    return lines + [make_stage("trunk_self", 0.4), make_stage("trunk_self", 0.15, "detection")]


class BenchmarkBoundsTest(ScriptTest):
    def report(self, lines, *options):
        return self.run_script("benchmark_report.py", self.write("lines", "\n".join(lines)), self.folder, *options)

    def assert_misses(self, run, *texts):
        missed = [line for line in run.out.splitlines() if line.startswith("missed: ")]
        self.assertEqual(len(missed), len(texts), run.out)
        for text in texts:
            self.assertTrue(any(text in line for line in missed), (text, missed))
        self.assertEqual(run.code, 1 if texts else 0)

    def test_all_kept(self):
        self.assert_misses(self.report(make_whole(), "--check", "--whole"))

    def test_each_bound_can_be_missed(self):
        for line, text in (
            (make_compliance(ratio=7.9), "ratio=7.9 op=>= bound=8"),
            (make_compliance(dofs=6480, ratio=5.9), "ratio=5.9 op=>= bound=6"),
            (make_compliance(dofs=14700, ratio=5.9), "ratio=5.9 op=>= bound=6"),
            (make_compliance(mesh="gmsh", dofs=4563, ratio=3.9), "ratio=3.9 op=>= bound=4"),
            (make_compliance("avx2", ratio=3.9), "ratio=3.9 op=>= bound=4"),
            (make_compliance("avx2", dofs=6480, ratio=2.9), "ratio=2.9 op=>= bound=3"),
            (make_compliance("avx2", mesh="gmsh", ratio=1.9), "ratio=1.9 op=>= bound=2"),
            (make_compliance("plain", rows=12, ratio=0.9), "ratio=0.9 op=>= bound=1"),
            (make_compliance(rows=12, error=4e-12), "error/cholmod_error=4 op=<= bound=3"),
            (make_compliance(assembly_percent=25.1), "assembly_percent=25.1 op=<= bound=25"),
            (make_stage("trunk_contact", 1.01), "median_ms=1.01 op=<= bound=1"),
            (make_stage("beam_contact", 0.31), "median_ms=0.31 op=<= bound=0.3"),
            (make_stage("finger_contact", 0.21), "median_ms=0.21 op=<= bound=0.2"),
            (make_stage("trunk_self", 0.16, "detection"), "median_ms=0.16 op=<= bound=0.15"),
        ):
            self.assert_misses(self.report([line], "--check"), text)

    def test_what_no_bound_is_about(self):
        lines = [make_compliance(rows=12, ratio=1.0, assembly_percent=60.0), make_compliance(threads=2, ratio=1.0, error=None)]
        lines.append(make_compliance("avx2", assembly_percent=60.0))
        self.assert_misses(self.report(lines))

    def test_times_count_only_when_asked_for(self):
        slow = [make_stage("beam_contact", 9.0)]
        self.assert_misses(self.report(slow))
        self.assert_misses(self.report(slow, "--check"), "scene=beam_contact stage=cycle")
        self.assert_misses(self.report([make_compliance(ratio=1.0)]), "scene=compliance mesh=bar dofs=1584 rows=87 isa=avx512")

    def test_a_cycle_beside_cholmod(self):
        trunk = make_compliance(mesh="trunk", cholmod_ms=4.0)
        self.assert_misses(self.report([make_stage("trunk_contact", 1.0), trunk]))
        self.assert_misses(self.report([make_stage("trunk_contact", 1.04), trunk]), "median_ms/cholmod_ms=0.26 op=<= bound=0.25")
        # Another instruction set is another rival.
        other = make_compliance("avx2", mesh="trunk", cholmod_ms=1.0)
        self.assert_misses(self.report([make_stage("trunk_contact", 1.0), other]))

    def test_a_whole_run_measures_everything(self):
        without = [line for line in make_whole() if "scene=beam_contact" not in line]
        self.assert_misses(self.report(without, "--check"))
        self.assert_misses(self.report(without, "--check", "--whole"), "scene=beam_contact stage=cycle median_ms=nan")
        self.assert_misses(self.report([line for line in make_whole() if "mesh=gmsh isa=avx512" not in line], "--whole"), "mesh=gmsh")

    def test_a_machine_without_an_instruction_set(self):
        older = [line for line in make_whole() if "scene=compliance" not in line or "isa=avx512" not in line]
        self.assert_misses(self.report([line.replace("isa=avx512", "isa=avx2") for line in older], "--check", "--whole"))

    def test_nothing_to_check(self):
        run = self.report([make_stage("trunk", 0.4)], "--check")
        self.assertEqual(run.code, 1)
        self.assertIn("none of these scenes has a bound", run.err)
        self.assertEqual(self.report([make_stage("trunk", 0.4)]).code, 0)


if __name__ == "__main__":
    unittest.main()
