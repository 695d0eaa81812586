#!/usr/bin/env python3
"""Do two builds of contrapposto write the same bytes? Run before and after a change that must not change results.

In: BEFORE and AFTER, each a `contrapposto` binary; BEFORE may instead be a folder kept by an earlier run (`--keep`), and
then is not run. Out: one line per job, `same` or `DIFFERS` with the files and the first differences, the seconds of each
group, and last `N same, N differ`.

A job is a few command lines run one after another in an empty folder of its own, in which `scenes` is the `scenes/` folder
of the program's own repository and `shared` the data folder. Every path a program is given is relative to that folder, so
that both are given the same words and no temporary path reaches a file. All that is in the folder afterwards is compared,
and the exit code, standard output and standard error of every command line:

  *.json, --json  by value: numbers must be equal (-0 is not 0, 1 is 1.0), CLOCK is left out, and an entry of a table
                  `files` may be absent on one side
  *.npz           to the byte; what differs is named by member, row-major index and value
  text            to the byte; the first different line is shown
  all other files to the byte

A job that fails in both programs with one exit code and one standard error is the same. Three things in text are not compared:
the speed in the summary of `render`, the number of a thread that panics and the source line it stood at, and the note that
a Python environment is being made. The digest `input=…` in the first line of samples.csv and sweep.csv is taken of the
debug text of internal types; where it alone differs the job is the same, and the line says so.

The clock: `realtime_factor` in reports. It was found by running one program twice; no member of an .npz is of the clock.

Exit code: 0 all the same, 1 something differs, 2 the check cannot be made. Python standard library only.
"""

import argparse
import fnmatch
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from same_bytes_compare import compare_job
from same_bytes_control import self_test
from same_bytes_jobs import Job, jobs

FILES_SHOWN = 12  # different files listed per job
TIMEOUT_S = 1200


class Unusable(Exception):
    """The check cannot be made as asked."""


class Program:
    """A binary, its repository, and the data it is given."""

    def __init__(self, binary, root, shared, place):
        binary = Path(binary).resolve()
        if root is None:
            root = next((p for p in binary.parents if (p / "scenes" / "bow.ron").is_file()), None)
        if root is None or not (Path(root) / "scenes").is_dir():
            raise Unusable(f"{binary}: no repository with a scenes/ folder found above it; give --before-root or --after-root")
        self.root, self.shared = Path(root).resolve(), shared
        # a build during the check must not change what is checked
        self.binary = place / "contrapposto"
        place.mkdir(parents=True)
        shutil.copy2(binary, self.binary)

    def scenes(self):
        top = self.root / "scenes"
        return {str(p.relative_to(top)) for p in top.rglob("*.ron")}

    def run(self, job, folder):
        """Runs a job; in `folder`, afterwards: job.json, 1.stdout, 1.stderr, …, and what was written, in work/."""
        if folder.exists():
            shutil.rmtree(folder)
        work = folder / "work"
        work.mkdir(parents=True)
        (work / "scenes").symlink_to(self.root / "scenes")
        if self.shared:
            (work / "shared").symlink_to(self.shared)
        for name, text in job.texts.items():
            (work / name).write_text(text, encoding="utf-8")
        if job.cases:
            (work / "cases").mkdir()
            for scene in (self.shared / "cases" / "scenes").glob("*.ron"):
                shutil.copy(scene, work / "cases")
            for inner in ("characters", "keyposes", "performances"):
                (work / "cases" / inner).symlink_to(self.root / "scenes" / inner)
        environment = {k: v for k, v in os.environ.items() if k != "RAYON_NUM_THREADS"}
        codes, begun = [], time.monotonic()
        for i, step in enumerate(job.steps, 1):
            with open(folder / f"{i}.stdout", "wb") as out, open(folder / f"{i}.stderr", "wb") as err:
                try:
                    done = subprocess.run([self.binary, *step], cwd=work, env=environment, stdin=subprocess.DEVNULL,
                                          stdout=out, stderr=err, timeout=TIMEOUT_S, check=False)
                    codes.append(done.returncode)
                except subprocess.TimeoutExpired:
                    codes.append(f"stopped after {TIMEOUT_S} s")
        for path in sorted(work.rglob("*")):
            if path.is_symlink():
                path.unlink()
        record = {"steps": job.steps, "codes": codes, "seconds": round(time.monotonic() - begun, 2)}
        (folder / "job.json").write_text(json.dumps(record), encoding="utf-8")


def kept(folder, job):
    """The record of a job kept, or None."""
    path = folder / job.key / "job.json"
    return json.loads(path.read_text(encoding="utf-8")) if path.is_file() else None


def names_kept(folder):
    return {str(p.parent.relative_to(folder)) for p in folder.glob("*/*/job.json")}


def chosen(job, patterns, quick, everything):
    """`scenes`, `retarget/walk-*`, `bow`; with `!` in front: not these. Slow jobs are run where they or their group are named."""
    def fits(p):
        return any(fnmatch.fnmatch(x, p) for x in (job.group, job.key, job.name))

    wanted = [p for p in patterns if not p.startswith("!")]
    return ((not quick or job.quick) and (any(map(fits, wanted)) if wanted else everything or not job.slow)
            and not any(fits(p[1:]) for p in patterns if p.startswith("!")))


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("before", metavar="BEFORE", nargs="?", help="binary, or a folder kept by an earlier run")
    parser.add_argument("after", metavar="AFTER", nargs="?", help="binary")
    parser.add_argument("--only", metavar="PATTERN", action="append", default=[],
                        help="only these jobs: GROUP, NAME or GROUP/NAME, with * and ?; `!PATTERN` leaves out; repeatable")
    parser.add_argument("--quick", action="store_true", help="a small part of the jobs that runs every command")
    parser.add_argument("--all", action="store_true",
                        help="also crosscheck/bow and crosscheck/push, which close MuJoCo's loop in Python: three minutes "
                             "of an idle machine; `--only crosscheck` runs them too")
    parser.add_argument("--keep", metavar="DIR",
                        help="keep what BEFORE wrote in DIR/before, and what AFTER wrote where it differs in DIR/after; "
                             "DIR is a BEFORE of later runs")
    parser.add_argument("--baseline", metavar="DIR",
                        help="take a job of BEFORE from DIR where it is kept there, else run it and keep it there")
    parser.add_argument("--shared", metavar="DIR",
                        help="data folder [default: `shared` beside AFTER's repository, or beside this one]")
    parser.add_argument("--before-root", metavar="DIR", help="repository of BEFORE, for its scenes [default: above the binary]")
    parser.add_argument("--after-root", metavar="DIR", help="repository of AFTER, for its scenes [default: above the binary]")
    parser.add_argument("--allow-new", metavar="NAME", action="append", default=[],
                        help="a file of this name (with * and ?) that only AFTER writes is no difference; repeatable")
    parser.add_argument("--list", action="store_true", help="print the jobs and their command lines, and run nothing")
    parser.add_argument("--self-test", action="store_true",
                        help="change bytes of made-up outputs, and of those kept in BEFORE if given, and look whether each is found")
    return parser, parser.parse_args()


def kept_folder(path):
    """The outputs in a folder given as BEFORE, or None for a binary."""
    if path is None or not Path(path).is_dir():
        return None
    path = Path(path).resolve()
    inner = path / "before"
    return inner if inner.is_dir() else path


def main():
    parser, args = arguments()
    folder = kept_folder(args.before)
    if args.self_test:
        return self_test(folder)
    if args.after is None:
        parser.error("BEFORE and AFTER are needed")
    with tempfile.TemporaryDirectory(prefix="same-bytes-") as place:
        try:
            return check(args, folder, Path(place).resolve())
        except Unusable as e:
            print(f"error: {e}", file=sys.stderr)
            return 2


def check(args, folder, place):
    for path in [args.after] + ([] if folder else [args.before]):
        if not Path(path).is_file():
            raise Unusable(f"{path} is no file")
    after = Program(args.after, args.after_root, None, place / "after-program")
    beside = [after.root.parent / "shared", Path(__file__).resolve().parents[2] / "shared"]
    shared = Path(args.shared) if args.shared else next((p for p in beside if p.is_dir()), None)
    if args.shared and not shared.is_dir():
        raise Unusable(f"--shared {shared} is no folder")
    shared = after.shared = shared.resolve() if shared else None
    before = None if folder else Program(args.before, args.before_root, shared, place / "before-program")

    # where what BEFORE wrote is found or put
    store = folder or place / "before"
    if not folder and args.baseline:
        store = Path(args.baseline).resolve()
        store = store / "before" if (store / "before").is_dir() else store
    elif not folder and args.keep:
        store = Path(args.keep).resolve() / "before"
    differing = Path(args.keep).resolve() / "after" if args.keep else None

    scenes = {"before": before.scenes() if before else None, "after": after.scenes()}
    possible = jobs(scenes["after"] | (scenes["before"] or set()), shared)
    if before is None:
        # what was kept of a scene that AFTER's repository no longer has
        for key in sorted(names_kept(store) - {j.key for j in possible}):
            steps = json.loads((store / key / "job.json").read_text(encoding="utf-8"))["steps"]
            possible.append(Job(*key.split("/"), steps))
    wanted = [j for j in possible if chosen(j, args.only, args.quick, args.all)]
    if args.list:
        for job in wanted:
            print(job.key)
            for step in job.steps:
                print("   ", " ".join(step))
        return 0
    if not wanted:
        raise Unusable("no job fits --only")
    return run_all(args, wanted, before, after, store, differing, place)


def telling(name):
    """Streams and exit codes first, then files by how much their differences say."""
    order = [".json", ".csv", ".npz", ".bvh", ".ron", ".mot", ".xml", ".glb", ".svg", ".html", ".txt", ".png"]
    suffix = Path(name).suffix
    return 0 if "`" in name else order.index(suffix) + 2 if suffix in order else 1


def run_all(args, wanted, before, after, store, differing, place):
    same, differ, skipped, seconds = 0, 0, 0, {}
    keeps = before is not None and (args.keep or args.baseline)
    for i, job in enumerate(wanted, 1):
        def tell(what):
            print(f"[{i}/{len(wanted)}] {job.key}: {what}", file=sys.stderr, flush=True)

        if job.needs_shared and after.shared is None:
            print(f"skipped   {job.key}: it needs the data folder; give --shared", flush=True)
            skipped += 1
            continue
        record = kept(store, job) if before is None or args.baseline else None
        if record is None and before is None:
            print(f"skipped   {job.key}: not among the outputs kept", flush=True)
            skipped += 1
            continue
        if record is None or (before and record["steps"] != job.steps):
            tell("before")
            before.run(job, store / job.key)
            record = kept(store, job)
        tell("after")
        mine = place / "after" / job.key
        after.run(job, mine)
        record_after = kept(place / "after", job)
        if record["steps"] != job.steps:
            found, notes = {"command lines": ["the outputs kept are of other command lines; keep them anew"]}, []
        else:
            found, notes = compare_job(job, store / job.key, mine, args.allow_new)
        took = seconds.setdefault(job.group, [0, 0.0, 0.0])
        took[0] += 1
        took[1] += record["seconds"]
        took[2] += record_after["seconds"]
        timing = f"({record['seconds']:.1f} s, {record_after['seconds']:.1f} s)"
        note = f"; {', '.join(notes)}" if notes else ""
        if found:
            differ += 1
            names = sorted(found, key=telling)
            print(f"DIFFERS   {job.key} {timing}: {len(names)} {'file or stream' if len(names) == 1 else 'files or streams'}{note}")
            for name in names[:FILES_SHOWN]:
                print(f"  {name}")
                print("".join(f"      {line}\n" for line in found[name]), end="")
            if len(names) > FILES_SHOWN:
                print(f"  and {len(names) - FILES_SHOWN} more: {', '.join(names[FILES_SHOWN:])}")
            if differing:
                target = differing / job.key
                shutil.rmtree(target, ignore_errors=True)
                shutil.copytree(mine, target)
        else:
            same += 1
            print(f"same      {job.key} {timing}{note}")
        sys.stdout.flush()
        shutil.rmtree(mine)
        if before is not None and not keeps:
            shutil.rmtree(store / job.key)
    print("\ngroup          jobs  before s   after s")
    for group, (n, x, y) in seconds.items():
        print(f"{group:<14} {n:>4} {x:>9.1f} {y:>9.1f}")
    totals = [sum(t[k] for t in seconds.values()) for k in range(3)]
    print(f"{'all':<14} {totals[0]:>4} {totals[1]:>9.1f} {totals[2]:>9.1f}\n")
    print(f"{same} same, {differ} differ" + (f", {skipped} skipped" if skipped else ""))
    return 1 if differ else 0


if __name__ == "__main__":
    sys.exit(main())
