"""The negative control of same_bytes.py: one thing is changed at a time, and must be found, or must not count.

In: made-up outputs of every kind, and outputs kept of a real run where there are any. Out: one line per control, and whether all
were right.
"""

import json
import re
import shutil
import struct
import tempfile
import zipfile
from pathlib import Path

from same_bytes_compare import CLOCK, compare_job
from same_bytes_jobs import Job


def npy(kind, shape, body):
    head = f"{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}"
    head += " " * (-(10 + len(head) + 1) % 64) + "\n"
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(head)) + head.encode() + body


def sample(folder):
    """Writes an output of every kind."""
    work = folder / "work"
    (work / "plots").mkdir(parents=True)
    with zipfile.ZipFile(work / "trace.npz", "w") as archive:
        archive.writestr(zipfile.ZipInfo("q.npy"), npy("<f8", (2, 2), struct.pack("<4d", 0.1, 0.2, 0.3, 0.4)))
        archive.writestr(zipfile.ZipInfo("name.npy"), npy("<U2", (1,), "ab".encode("utf-32-le")))
    report = {"realtime_factor": 9.5, "fell": False, "rms": [0.0, 0.1, 0.2], "files": {"a": "a.bvh", "b": "b.bvh"}}
    (work / "report.json").write_text(json.dumps(report))
    (work / "samples.csv").write_text("# contrapposto tune of x: seed=1 input=0123456789abcdef\nindex,cost\n0,0.5\n")
    for name in ("dynamic.bvh", "contacts.ron", "plots/a.svg", "torques.mot", "human.xml", "tune.html"):
        (work / name).write_text("one 1.0\ntwo 2.0\n")
    for name in ("dynamic.glb", "plots/a.png"):
        (work / name).write_bytes(bytes(range(256)))
    (folder / "1.stdout").write_text("bow: performed\n  240 Hz, 9.7 × real time\n")
    (folder / "1.stderr").write_text("error: none\n")
    (folder / "job.json").write_text(json.dumps({"steps": [["render"]], "codes": [2], "seconds": 1}))


def self_test(real):
    """Changes one thing at a time and looks whether it is found. `real`: a folder with kept outputs, or None."""
    failed, tried = [], 0

    def control(name, source, change, expected, job):
        nonlocal tried
        with tempfile.TemporaryDirectory() as place:
            copy = Path(place) / "after"
            shutil.copytree(source, copy)
            change(copy)
            found, _ = compare_job(job, source, copy)
        tried += 1
        right = bool(found) == expected
        if not right:
            failed.append(name)
        print(f"{'ok    ' if right else 'FAILED'} {name}: {'found' if found else 'the same'}")
        for what, lines in list(found.items())[:1]:
            print(f"         {what}: {' '.join(lines)}")

    def edit(name, old, new):
        def change(folder):
            data = (folder / name).read_bytes()
            assert old in data, name
            (folder / name).write_bytes(data.replace(old, new, 1))
        return change

    def flip(name):
        """The last bit of a byte in the middle; in JSON the first digit of a value that is not of the clock."""
        def change(folder):
            path = folder / name
            data = bytearray(path.read_bytes())
            if path.suffix == ".json":
                text = data.decode()
                free = [m for m in re.finditer(r'"(\w+)": -?(\d)', text) if m[1] not in CLOCK]
                at = free[len(free) // 2].start(2)
                path.write_text(text[:at] + str(int(text[at]) % 9 + 1) + text[at + 1:])
                return
            data[len(data) // 2] ^= 1
            path.write_bytes(data)
        return change

    with tempfile.TemporaryDirectory() as place:
        made, job = Path(place) / "made", Job("control", "made", [["render"]])
        sample(made)
        control("nothing changed", made, lambda f: None, False, job)
        for path in sorted(p for p in (made / "work").rglob("*") if p.is_file() and p.suffix != ".json"):
            name = str(path.relative_to(made))
            control(f"a bit of {name}", made, flip(name), True, job)
        report = "work/report.json"
        control("realtime_factor", made, edit(report, b"9.5", b"8.5"), False, job)
        control("a name of a file left out", made, edit(report, b', "b": "b.bvh"', b""), False, job)
        control("another name of a file", made, edit(report, b'"b.bvh"', b'"c.bvh"'), True, job)
        control("the last digit of a value", made, edit(report, b"0.2]", b"0.20000000000000004]"), True, job)
        control("1 for true", made, edit(report, b"false", b"0"), True, job)
        control("a sign of zero", made, edit(report, b"[0.0,", b"[-0.0,"), True, job)
        control("a space", made, edit(report, b"0.1,", b"0.1 ,"), False, job)
        control("a value left out", made, edit(report, b'"fell": false, ', b""), True, job)
        control("the digest of the input", made, edit("work/samples.csv", b"0123", b"0124"), False, job)
        control("a cost", made, edit("work/samples.csv", b"0.5", b"0.6"), True, job)
        control("the speed said", made, edit("1.stdout", b"9.7", b"9.8"), False, job)
        control("a word said", made, edit("1.stdout", b"performed", b"performs"), True, job)
        control("a word of an error", made, edit("1.stderr", b"none", b"some"), True, job)
        control("an exit code", made, edit("job.json", b"[2]", b"[1]"), True, job)
        control("a file less", made, lambda f: (f / "work/dynamic.bvh").unlink(), True, job)
        control("a file more", made, lambda f: (f / "work/new.bvh").write_text("x"), True, job)
    if real:
        for key in ("scenes/bow", "retarget/walk-penguin", "tune/stand", "analyze/clip", "convert/body"):
            if not (real / key / "job.json").is_file():
                continue
            job = Job(*key.split("/"), json.loads((real / key / "job.json").read_text())["steps"])
            control(f"{key}, nothing changed", real / key, lambda f: None, False, job)
            for path in sorted(p for p in (real / key / "work").rglob("*") if p.is_file()):
                name = str(path.relative_to(real / key))
                control(f"{key}, a bit of {name}", real / key, flip(name), True, job)
    print(f"{tried - len(failed)} controls right, {len(failed)} wrong")
    return 1 if failed else 0
