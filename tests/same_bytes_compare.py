"""The comparison of same_bytes.py: what two programs wrote for one job. See there for what counts as the same.

In: two folders as same_bytes.py leaves them: job.json (command lines, exit codes, seconds), 1.stdout, 1.stderr, 2.stdout, …, and
work/, the folder the command lines were run in. Out: differences, as lines a person reads.
"""

import ast
import fnmatch
import json
import math
import os
import re
import struct
import zipfile
from io import BytesIO
from pathlib import Path

CLOCK = {"realtime_factor"}  # keys of JSON objects that hold a time
SHOWN = 5  # differences listed per file
TEXT = {".bvh", ".svg", ".ron", ".csv", ".mot", ".xml", ".html", ".txt"}


def short(value):
    text = value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)
    return text if len(text) <= 100 else text[:97] + "…"


def json_differences(a, b, path="$"):
    """Yields `path: a, b` of every value that differs."""
    def number(x):
        return isinstance(x, (int, float)) and not isinstance(x, bool)

    if isinstance(a, dict) and isinstance(b, dict):
        for key in [*a, *(k for k in b if k not in a)]:
            at = f"{path}.{key}"
            if key in CLOCK:
                continue
            if key in a and key in b:
                yield from json_differences(a[key], b[key], at)
            elif not path.endswith(".files"):
                yield f"{at}: only {'before' if key in a else 'after'}, {short(a[key] if key in a else b[key])}"
    elif isinstance(a, list) and isinstance(b, list):
        if len(a) != len(b):
            yield f"{path}: {len(a)} entries, {len(b)} entries"
        for i, (x, y) in enumerate(zip(a, b)):
            yield from json_differences(x, y, f"{path}[{i}]")
    elif number(a) and number(b):
        both_nan = a != a and b != b
        if not both_nan and (a != b or math.copysign(1, a) != math.copysign(1, b)):
            yield f"{path}: {short(a)}, {short(b)}"
    elif type(a) is not type(b) or a != b:
        yield f"{path}: {short(a)}, {short(b)}"


def compare_json(a, b):
    try:
        found = list(json_differences(json.loads(a), json.loads(b)))
    except ValueError:  # not JSON on one side at least
        return compare_text(a, b)
    more = [f"and {len(found) - SHOWN} more values"] if len(found) > SHOWN else []
    return found[:SHOWN] + more


def compare_text(a, b):
    if a == b:
        return []
    one, other = (x.decode("utf-8", "replace").splitlines(keepends=True) for x in (a, b))
    line = next((i for i, (x, y) in enumerate(zip(one, other)) if x != y), min(len(one), len(other)))
    x, y = (repr(l[line]) if line < len(l) else "no line" for l in (one, other))
    if len(x) > 160 or len(y) > 160:
        at = max(next((i for i, (p, q) in enumerate(zip(x, y)) if p != q), min(len(x), len(y))) - 40, 0)
        x, y = ("…" * (at > 0) + s[at:at + 120] + "…" * (len(s) > at + 120) for s in (x, y))
    return [f"line {line + 1}:", f"  before {x}", f"  after  {y}"]


def compare_bytes(a, b):
    if a == b:
        return []
    at = next((i for i, (x, y) in enumerate(zip(a, b)) if x != y), min(len(a), len(b)))
    return [f"first different byte {at}; {len(a)} and {len(b)} bytes"]


def read_npy(data):
    """(shape, type, values) of a .npy array of f8, i8 or text."""
    (size,) = struct.unpack_from("<H" if data[6] == 1 else "<I", data, 8)
    start = 10 if data[6] == 1 else 12
    header = ast.literal_eval(data[start:start + size].decode("latin1"))
    body, kind = data[start + size:], header["descr"]
    if kind in ("<f8", "<i8"):
        return header["shape"], kind, struct.unpack(f"<{len(body) // 8}{'d' if kind == '<f8' else 'q'}", body)
    width = 4 * int(kind[2:])
    return header["shape"], kind, [body[i:i + width].decode("utf-32-le").rstrip("\0") for i in range(0, len(body), width)]


def compare_array(name, a, b):
    try:
        (shape_a, kind_a, x), (shape_b, kind_b, y) = read_npy(a), read_npy(b)
    except (ValueError, KeyError, IndexError, struct.error):
        return f"{name}: {compare_bytes(a, b)[0]}"
    if (shape_a, kind_a) != (shape_b, kind_b):
        return f"{name}: {kind_a} {shape_a}, {kind_b} {shape_b}"
    different = [i for i, (p, q) in enumerate(zip(x, y)) if p != q and not (p != p and q != q)]
    if not different:
        return f"{name}: equal values, other bytes (sign of zero, NaN or header)"
    first, most = different[0], ""
    if kind_a == "<f8":
        most = f", by {max(abs(x[i] - y[i]) for i in different):.3g} at most"
    return f"{name}: {len(different)} of {len(x)} values{most}; first at {first}: {x[first]!r}, {y[first]!r}"


def compare_npz(a, b):
    if a == b:
        return []
    try:
        with zipfile.ZipFile(BytesIO(a)) as one, zipfile.ZipFile(BytesIO(b)) as other:
            names, others = one.namelist(), other.namelist()
            found = [f"{n}: only before" for n in names if n not in others]
            found += [f"{n}: only after" for n in others if n not in names]
            for n in (n for n in names if n in others):
                p, q = one.read(n), other.read(n)
                if p != q:
                    found.append(compare_array(n.removesuffix(".npy"), p, q))
    except zipfile.BadZipFile:
        return compare_bytes(a, b)
    more = [f"and {len(found) - SHOWN} more members"] if len(found) > SHOWN else []
    return found[:SHOWN] + more or ["equal members; their order or the headers of the archive differ"]


def compare_file(name, a, b):
    """Differences of two files, as lines; none if they are the same."""
    suffix = Path(name).suffix.lower()
    if suffix == ".json":
        return compare_json(a, b)
    if suffix == ".npz":
        return compare_npz(a, b)
    return compare_text(a, b) if suffix in TEXT else compare_bytes(a, b)


DIGEST = re.compile(rb"(# contrapposto (?:tune|sweep) of [^\n]*) input=[0-9a-f]{16}")
# What is left out of standard output and standard error.
SPEECH = [
    re.compile(rb"[0-9.]+ (?=\xc3\x97 real time)"),
    re.compile(rb"(?<=') \(\d+\)(?= (?:panicked|has overflowed))"),
    re.compile(rb"(?<=panicked at )\S+:\d+:\d+"),
    re.compile(rb"making a Python environment [^\n]*\n"),
]


def said(data, work):
    for pattern in SPEECH:
        data = pattern.sub(b"", data)
    return data.replace(os.fsencode(work), b"WORK")


def files(folder):
    return {str(p.relative_to(folder)): p for p in sorted(folder.rglob("*")) if p.is_file()}


def compare_job(job, before, after, allow_new=()):
    """({what: lines}, notes) of the outputs of a job in two folders."""
    found, notes = {}, []
    records = [json.loads((f / "job.json").read_text(encoding="utf-8")) for f in (before, after)]
    for i, (step, x, y) in enumerate(zip(job.steps, *(r["codes"] for r in records)), 1):
        called = f"`{short(' '.join(step))}`"
        if x != y:
            found[f"exit code of {called}"] = [f"{x}, {y}"]
        elif x != 0:
            notes.append(f"exit {x} in both" + (f" of {called}" if len(job.steps) > 1 else ""))
        for stream in ("stdout", "stderr"):
            p, q = ((f / f"{i}.{stream}").read_bytes() for f in (before, after))
            p, q = said(p, before / "work"), said(q, after / "work")
            by_value = stream == "stdout" and "--json" in step and step[0] != "inspect"
            lines = compare_json(p, q) if by_value else compare_text(p, q)
            if lines:
                found[f"{stream} of {called}"] = lines
    one, other = (files(f / "work") for f in (before, after))
    for name in sorted({*one, *other}):
        if name not in other:
            found[name] = ["only before"]
        elif name not in one:
            if not any(fnmatch.fnmatch(Path(name).name, pattern) for pattern in allow_new):
                found[name] = ["only after"]
        else:
            a, b = one[name].read_bytes(), other[name].read_bytes()
            lines = [] if a == b else compare_file(name, a, b)
            if lines and name.endswith(".csv") and DIGEST.sub(rb"\1", a, 1) == DIGEST.sub(rb"\1", b, 1):
                notes.append(f"another digest of the input in {name}")
            elif lines:
                found[name] = lines
    if len(notes) > 2:
        notes = [notes[0], f"{len(notes) - 1} more such"]
    return found, notes
