"""What the figures of the benchmarks have to keep, and how lines are held against it."""

import collections

from benchmark_rows import pick

# `where`: values of the rows that it is about; every one of them has to keep it. `over`: a row, and its figure, by which
# the figure is divided first. `absolute` ones are times, which another machine may miss.
Bound = collections.namedtuple("Bound", "where figure op bound over absolute")
Finding = collections.namedtuple("Finding", "text ok")

CONTACT_ROWS = 87


def times_cholmod(least, isa, **where):
    """Factor and compliance of one core at least so many times as fast as CHOLMOD's."""
    return Bound({"scene": "compliance", "isa": isa, "threads": 1, **where}, "ratio", ">=", least, None, False)


def at_most(milliseconds, scene, stage="cycle"):
    return Bound({"scene": scene, "stage": stage}, "median_ms", "<=", milliseconds, None, True)


# Least ratios with AVX-512; half of that with AVX2.
RATIOS = ((8, {"mesh": "bar", "dofs": 1584}), (6, {"mesh": "bar", "dofs": 6480}), (6, {"mesh": "bar", "dofs": 14700}), (4, {"mesh": "gmsh"}))

BOUNDS = (
    *(times_cholmod(least, "avx512", rows=CONTACT_ROWS, **where) for least, where in RATIOS),
    *(times_cholmod(least / 2, "avx2", rows=CONTACT_ROWS, **where) for least, where in RATIOS),
    times_cholmod(1, "plain"),
    Bound({"scene": "compliance"}, "error", "<=", 3, ({}, "cholmod_error"), False),
    Bound({"scene": "compliance", "isa": "avx512", "threads": 1, "rows": CONTACT_ROWS}, "assembly_percent", "<=", 25, None, False),
    Bound(
        {"scene": "trunk_contact", "stage": "cycle"},
        "median_ms",
        "<=",
        0.25,
        ({"scene": "compliance", "mesh": "trunk", "rows": CONTACT_ROWS, "threads": 1}, "cholmod_ms"),
        False,
    ),
    at_most(1.0, "trunk_contact"),
    at_most(0.3, "beam_contact"),
    at_most(0.2, "finger_contact"),
    at_most(0.15, "trunk_self", "detection"),
)


def select(rows, where):
    return [row for row in pick(rows, where["scene"]) if all(row.get(name) == value for name, value in where.items())]


def describe(row):
    names = ("scene", "stage", "mesh", "dofs", "rows", "isa", "threads")
    return " ".join(f"{name}={row[name]}" for name in names if row.get(name) is not None)


def find_divisor(rows, row, over):
    """What a row's figure is divided by: None where that was not measured. A figure of the row itself where `over` names
    no scene; else that of another row with the same instruction set."""
    where, figure = over
    others = select(rows, {**where, "isa": row.get("isa")}) if where else [row]
    return others[0].get(figure) if others else None


def judge(rows, bound):
    """A finding for every row that the bound is about."""
    findings = []
    for row in select(rows, bound.where):
        divisor = find_divisor(rows, row, bound.over) if bound.over else 1
        if row.get(bound.figure) is None or not divisor:
            continue
        value = row[bound.figure] / divisor
        ok = value <= bound.bound if bound.op == "<=" else value >= bound.bound
        name = f"{bound.figure}/{bound.over[1]}" if bound.over else bound.figure
        findings.append(Finding(f"{describe(row)} {name}={value:.4g} op={bound.op} bound={bound.bound:g}", ok))
    return findings


def runs_here(rows, bound):
    """Whether this machine has the instruction set of the bound, as far as the rows tell."""
    sets = {row.get("isa") for row in pick(rows, bound.where["scene"])}
    return not sets or bound.where.get("isa") in (None, *sets)


def judge_all(rows, absolute, whole):
    """Findings of the bounds: of ratios, and of times where `absolute`. What was not measured at all counts as missed
    where the run was `whole`."""
    findings = []
    for bound in BOUNDS:
        if bound.absolute and not absolute:
            continue
        own = judge(rows, bound)
        if not own and whole and runs_here(rows, bound):
            own = [Finding(f"{describe(bound.where)} {bound.figure}=nan op={bound.op} bound={bound.bound:g}", False)]
        findings += own
    return findings
