"""Medians and ratios out of the lines that neumann's example `rays` and `embree` printed: `table.py FILE`."""

import json
import statistics
import sys

lines = [json.loads(line) for line in open(sys.argv[1])]
ours = [line for line in lines if line["program"] == "neumann"]
theirs = [line for line in lines if line["program"] == "embree"]
if [line["hits"] for line in ours] != [line["hits"] for line in theirs]:
    print("the programs do not hit the same rays", file=sys.stderr)


def row(what, a, b, ratios, unit):
    print(f"| {what} | {statistics.median(a):.3g} {unit} | {statistics.median(b):.3g} {unit} | {statistics.median(ratios):.2f} |")


print(f"\n| {ours[0]['triangles']} triangles, one thread, watertight | neumann | Embree 3 | neumann's advantage |\n|---|---|---|---|")
for kind in ["primary", "bounce", "shadow"]:
    a, b = [line[kind] for line in ours], [line[kind] for line in theirs]
    row(f"{kind} rays", a, b, [x / y for x, y in zip(a, b)], "Mrays/s")
build = [line["build_s"] for line in ours]
for what, key in [("building, against its high quality", "build_s"), ("the same, against its robust mode", "build_robust_s")]:
    b = [line[key] for line in theirs]
    row(what, build, b, [y / x for x, y in zip(build, b)], "s")
