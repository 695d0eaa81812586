#!/usr/bin/env python3
"""Everything at hand through `contrapposto`: does it ever panic, or answer with nonsense?

    python3 tests/survey.py CONTRAPPOSTO [--shared ../shared] [--only WORD] [--keep DIR]

In: the program, and the data folder: clips of mocap, bvh-zoo and cases; models of models and cases; scenes of cases and of the
repository. Out: a table with a line for every file, what the program said of it, a summary, and what is wrong; exit code 1 if
anything is. `--keep` writes what every run printed.

| file  | commands |
|---|---|
| clip  | `render --root pinned --no-plots --json`, `analyze --no-plots --json` |
| model | `inspect --json`, `convert --dynamics-only FILE out.xml`, `inspect out.xml --json` |
| scene | `render --no-plots --json`, `analyze` of its folder |

Wrong is: a panic, a signal or more than 300 s; an exit code that is not 0, or 2 with words on standard error (2 is refused for
clips of mocap); NaN or infinity in what is printed; a size, share or time that cannot be; a verdict that its own numbers deny;
`render` and `analyze` that do not agree on the same clip; a mass that `convert` changes. Python standard library only.
"""

import argparse
import json
import os
import re
import subprocess
import sys
import tempfile
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
GRADES = {"as asked", "stands, but", "in flight", "fell", "failed"}
# Sizes: not negative, and no more than this.
SIZES = {
    "_kg": 1e4, "_rms_deg": 180.0001, "rms_deg": 180.0001, "peak_deg": 180.0001, "_rms_mm": 1e8, "mm_max": 1e6, "_rms_n": 1e7,
    "_peak_n": 1e7, "_peak_nm": 1e7, "_rms_nm": 1e7, "_peak_percent_bw": 1e6, "_rms_percent_bw": 1e6, "impulse_ns": 1e8,
    "moment_impulse_nms": 1e8, "skate_mm_s": 1e6, "nm_rad": 1e6, "_noise_n": 1e7, "_noise_nm": 1e7, "jerk_rms_m_s3": 1e9,
    "duration_s": 1e5, "rate_hz": 1e5, "_s": 1e5, "frames": 1e7, "cutoff_hz": 1e5,
}
SHARES = {"share", "clamped_frames", "force_at_limit", "moment_at_limit", "outside_soles_share", "flight_share"}


class Run:
    """One command, run; `report` is its JSON, if it printed any."""

    def __init__(self, words, cwd):
        self.words = [str(w) for w in words]
        try:
            done = subprocess.run(self.words, cwd=cwd, capture_output=True, timeout=300)
            self.code = done.returncode
            self.out, self.err = (t.decode(errors="replace") for t in (done.stdout, done.stderr))
        except subprocess.TimeoutExpired:
            self.code, self.out, self.err = None, "", ""
        self.report, self.faults = None, []
        if self.code not in (0, 1, 2):
            self.faults.append("more than 300 s" if self.code is None else f"exit code {self.code}")
        if "panicked at" in self.err:
            self.faults.append(next(line for line in self.err.splitlines() if "panicked at" in line))
        if self.code in (1, 2) and not self.err.strip():
            self.faults.append(f"exit code {self.code} without a word")
        if self.code == 1 and "failed" not in self.out + self.err:
            self.faults.append("exit code 1: " + first(self.err))
        if self.code in (0, 1) and "--json" in self.words and self.out.strip():
            try:
                self.report = json.loads(self.out, parse_constant=self.constant)
            except ValueError as e:
                self.faults.append(f"no JSON: {e}")
        if self.report is not None:
            values(self.report, "", self.faults)
        # in backticks is what a file said
        for word in re.findall(r"(?<![\w./`-])-?(?:NaN|nan|inf|infinity)(?![\w./`-])", self.out + self.err):
            self.faults.append(f"`{word}` in: {first(self.err)}")

    def constant(self, word):
        self.faults.append(f"{word} in the report")


def first(text):
    return next(iter(text.strip().splitlines()), "")


def values(x, path, faults):
    """Every number of a report is one that can be."""
    if isinstance(x, dict):
        for key, value in x.items():
            values(value, f"{path}.{key}" if path else key, faults)
    elif isinstance(x, list):
        for value in x:
            values(value, path + "[]", faults)
    elif isinstance(x, (int, float)) and not isinstance(x, bool):
        key = path.split(".")[-1]
        if key.endswith("[]"):  # components of a vector have signs
            key = ""
        if key in SHARES and not 0 <= x <= 1:
            faults.append(f"{path} = {x}: a share")
        most = next((most for end, most in SIZES.items() if key.endswith(end)), None)
        if most is not None and not 0 <= x <= most:
            faults.append(f"{path} = {x}: not from 0 to {most:g}")
        if abs(x) > 1e9:
            faults.append(f"{path} = {x}")


def verdict(report):
    """The verdict of a run, and what of its numbers denies it."""
    parts = [report["dynamic"]] if report.get("dynamic") else [s["dynamic"] for s in report.get("spans") or [] if s["dynamic"]]
    faults = []
    for d in parts:
        v = d["verdict"]
        if v["grade"] not in GRADES:
            faults.append(f"grade `{v['grade']}`")
        if (v["grade"] == "fell") != d["fell"] or d["fell"] != (d["fell_at_s"] is not None):
            faults.append(f"`{v['grade']}`, but fell: {d['fell']} at {d['fell_at_s']}")
        if v["grade"] == "as asked" and (v["reasons"] or d["position_rms_mm"] > 100 or d["diverged"]):
            faults.append(f"`as asked` with {len(v['reasons'])} reasons, links {d['position_rms_mm']:.0f} mm off")
        if v["grade"] == "stands, but" and not v["reasons"]:
            faults.append("`stands, but` without a reason")
        if d["stiffness"] and d["performed_s"] > 0.1 and not d["worst_joints"]:
            faults.append("joints are driven, and none is the worst")
        if d["performed_s"] > report["duration_s"] + 0.02 and not d["fell"]:
            faults.append(f"performed {d['performed_s']} s of {report['duration_s']} s")
    if not parts:
        return "not performed", faults
    return "; ".join(dict.fromkeys(d["verdict"]["text"] for d in parts)), faults


def number(x, form="{:.1f}"):
    return "–" if x is None else form.format(x)


class Survey:
    def __init__(self, args):
        self.program, self.keep = Path(args.program).resolve(), args.keep
        self.work = Path(tempfile.mkdtemp(prefix="survey-"))

    def run(self, *words):
        run = Run([self.program, *words], self.work)
        if self.keep:
            name = re.sub(r"[^\w.-]+", "_", "_".join(run.words[1:]))[-150:]
            (self.keep / name).write_text(f"{run.words}\n{run.code}\n{run.out}\n{run.err}")
        return run

    def out(self, file, what):
        return self.work / f"{abs(hash(str(file)))}-{what}"

    def clip(self, file):
        performed = self.run("render", file, "--root", "pinned", "--no-plots", "--json", "--out", self.out(file, "render"))
        analyzed = self.run("analyze", file, "--no-plots", "--json", "--out", self.out(file, "analyze"))
        faults = performed.faults + analyzed.faults
        if performed.code != analyzed.code and not (performed.code == 2 and "slide" in performed.err):
            faults.append(f"render {performed.code}, analyze {analyzed.code}")
        row = [str(performed.code), str(analyzed.code)]
        said, a = first(performed.err), analyzed.report
        if performed.report:
            said, more = verdict(performed.report)
            faults += more
            d = performed.report.get("dynamic") or {}
            row += [number(d.get("joint_rms_deg"), "{:.2f}"), number(d.get("position_rms_mm"), "{:.0f}"),
                    number((d.get("root") or {}).get("residual_force_peak_percent_bw"), "{:.0f}")]
        else:
            row += ["–"] * 3
        if a:
            ground = a["ground"] or {}
            slip = (ground.get("feet") or {}).get("slip_mm_max")
            row += [a["plausible"], number(slip, "{:.0f}"), number(a["required"]["vertical_peak_percent_bw"], "{:.0f}"),
                    number(100 * a["flight"]["share"], "{:.0f}")]
            p = (performed.report or {}).get("plausibility")
            if performed.report and p is None:
                faults.append("render has no plausibility")
            elif p:
                for ours, theirs in [("grade", a["plausible"]), ("slip_mm_max", slip), ("flight_share", a["flight"]["share"]),
                                     ("outside_soles_share", a["support"]["share"])]:
                    if p[ours] != theirs:
                        faults.append(f"{ours}: render {p[ours]}, analyze {theirs}")
        else:
            row += ["–"] * 4
        return row, said, faults

    def model(self, file):
        seen = self.run("inspect", file, "--json")
        faults, row, said = list(seen.faults), [str(seen.code)], first(seen.err)
        written = self.out(file, "model").with_suffix(".xml")
        converted = self.run("convert", "--dynamics-only", file, written)
        faults += converted.faults
        row.append(str(converted.code))
        if seen.report:
            body = seen.report["body"]
            said = f"{len(body['links'])} links, {body['dof']} degrees of freedom, {body['mass_kg']:.3f} kg"
            if converted.code != 0:
                faults.append(f"inspect 0, convert {converted.code}: {first(converted.err)}")
            else:
                again = self.run("inspect", written, "--json")
                faults += again.faults
                if again.code != 0 or abs(again.report["body"]["mass_kg"] - body["mass_kg"]) > 1e-6 * body["mass_kg"] \
                        or again.report["body"]["dof"] != body["dof"]:
                    faults.append(f"what convert wrote is another body: {again.out[:200]} {first(again.err)}")
        return row + ["–"] * 7, said, faults

    def scene(self, file):
        folder = self.out(file, "scene")
        performed = self.run("render", file, "--no-plots", "--json", "--out", folder)
        faults, row, said = list(performed.faults), [str(performed.code)], first(performed.err)
        cells = ["–"] * 3
        grade = ["–"] * 4
        if performed.report:
            said, more = verdict(performed.report)
            faults += more
            d = performed.report.get("dynamic") or {}
            cells = [number(d.get("joint_rms_deg"), "{:.2f}"), number(d.get("position_rms_mm"), "{:.0f}"),
                     number((d.get("root") or {}).get("residual_force_peak_percent_bw"), "{:.0f}")]
        if d_exists := (folder / "trace.npz").exists():
            analyzed = self.run("analyze", folder, "--no-plots", "--json", "--out", self.out(file, "scene-analysis"))
            faults += analyzed.faults
            if analyzed.code != 0:
                faults.append(f"analyze of what render made: {analyzed.code}, {first(analyzed.err)}")
            row.append(str(analyzed.code))
            if a := analyzed.report:
                slip = ((a["ground"] or {}).get("feet") or {}).get("slip_mm_max")
                grade = [a["plausible"], number(slip, "{:.0f}"), number(a["required"]["vertical_peak_percent_bw"], "{:.0f}"),
                         number(100 * a["flight"]["share"], "{:.0f}")]
        if not d_exists:
            row.append("–")
        return row + cells + grade, said, faults


def inputs(shared, work):
    """(kind, name, file) of everything."""
    for folder in ["mocap/bvh", "mocap/cgspeed", "bvh-zoo", "bvh-zoo/synthetic", "cases/clips"]:
        for file in sorted((shared / folder).glob("*.bvh")):
            yield "clip", f"{folder}/{file.name}", file
    for folder in ["models", "cases/models"]:
        for file in sorted((shared / folder).rglob("*")):
            if file.suffix in (".xml", ".urdf") and file.parent.name != "common":
                yield "model", str(file.relative_to(shared)), file
    # scenes of cases name characters as if they lay in the repository's folder
    beside = work / "scenes"
    beside.mkdir()
    for entry in (ROOT / "scenes").iterdir():
        if entry.is_dir():
            (beside / entry.name).symlink_to(entry)
    for file in sorted((shared / "cases/scenes").glob("*.ron")):
        (beside / file.name).write_bytes(file.read_bytes())
        yield "scene", f"cases/scenes/{file.name}", beside / file.name
    for file in sorted((ROOT / "scenes").glob("*.ron")):
        yield "scene", f"scenes/{file.name}", file


def main():
    args = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    args.add_argument("program")
    args.add_argument("--shared", type=Path, default=ROOT.parent / "shared")
    args.add_argument("--only", default="", metavar="WORD", help="files whose name has this word")
    args.add_argument("--keep", type=Path, help="an empty folder for what every run printed")
    args = args.parse_args()
    if args.keep:
        args.keep = args.keep.resolve()
        args.keep.mkdir(parents=True)
    survey = Survey(args)
    jobs = [job for job in inputs(args.shared.resolve(), survey.work) if args.only in job[1]]
    if not jobs:
        sys.exit(f"nothing to survey in {args.shared}")
    with ThreadPoolExecutor(max_workers=os.cpu_count()) as pool:
        rows = list(pool.map(lambda job: getattr(survey, job[0])(job[2]), jobs))

    head = ["first", "second", "joints °", "links mm", "root % bw", "analyze", "slip mm", "peak % bw", "flight %"]
    wrong, words, codes = [], Counter(), Counter()
    print(f"{'file':<58} " + " ".join(f"{h:>10}" for h in head) + "  said")
    for (kind, name, _), (row, said, faults) in zip(jobs, rows):
        said = said.removeprefix("contrapposto: ").removeprefix("error: ")
        print(f"{name:<58} " + " ".join(f"{c:>10}" for c in row) + f"  {said[:160]}{'  WRONG' if faults else ''}")
        if name.startswith("mocap") and row[0] != "0":
            faults.append("a clip of mocap is refused")
        wrong += [(name, fault) for fault in dict.fromkeys(faults)]
        codes[kind, row[0]] += 1
        if kind != "model":
            words[kind, re.split(r"[,;:(]", said)[0][:60] if row[0] == "0" else "refused"] += 1
    print()
    for (kind, code), count in sorted(codes.items()):
        print(f"{kind:<6} exit code {code}: {count}")
    for (kind, word), count in sorted(words.items()):
        print(f"{kind:<6} {count:>3} {word}")
    print(f"\n{len(jobs)} files, {len(wrong)} wrong")
    for name, fault in wrong:
        print(f"  {name}: {fault}")
    sys.exit(1 if wrong else 0)


main()
