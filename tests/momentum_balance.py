#!/usr/bin/env python3
"""Does the body in a trace.npz move by the forces it recorded, and by no others?

Recomputes d(momentum)/dt - m g - sum of contact forces - root wrench - pushes from the file alone, by two roads:

  positions   momentum = sum of m_i (x_i[k] - x_i[k-1]) * rate, from the recorded centres of mass of the
              links. Nothing the simulation says about velocity or momentum enters.
  recorded    momentum as the run recorded it.

Forces of row k act during the step that ends at row k. The recorded momentum changes by exactly
F[k] / rate. The mean velocity of a step of S semi-implicit substeps h,
(x[k] - x[k-1]) / (S h) = mean of v over the ends of the substeps, so that its change from step k to k+1 is
h * (w F[k] + (1 - w) F[k+1]) * S with w = (S - 1) / (2 S), for forces even within a step: w = 0 for
one substep. Row 0 has no forces, so rows 1.. are compared.

Masses carried count from their first row to their last, with their own centres. A mass is handed over at the velocity of
its link: the momentum it brings is among the wrenches recorded. By positions a step with a mass cannot be compared with a
step without; those rows are left out and counted.

`impulse` is the mean over the run of the residual (by positions): free of differencing noise.
Percent are of body weight. Python standard library only; shares no code with what wrote the file.
Exit code: 0 within the thresholds, 1 beyond one, 2 for a file that cannot be judged.
"""

import argparse
import ast
import json
import math
import struct
import sys
import zipfile


def read_npy(data, name):
    """Returns (shape, flat list) of one .npy array: float64, int64 or text."""
    if data[:6] != b"\x93NUMPY":
        raise ValueError(f"{name}: not a .npy array")
    if data[6] == 1:
        (size,), start = struct.unpack_from("<H", data, 8), 10
    else:
        (size,), start = struct.unpack_from("<I", data, 8), 12
    header = ast.literal_eval(data[start:start + size].decode("latin1"))
    shape, kind = header["shape"], header["descr"]
    if header["fortran_order"] and len(shape) > 1:
        raise ValueError(f"{name}: column-major arrays are not read")
    count, body = math.prod(shape), data[start + size:]
    if kind in ("<f8", "<i8"):
        return shape, list(struct.unpack(f"<{count}{'d' if kind == '<f8' else 'q'}", body))
    if kind.startswith("<U"):
        width = 4 * int(kind[2:])
        text = [body[i * width:(i + 1) * width].decode("utf-32-le").rstrip("\0") for i in range(count)]
        return shape, text
    raise ValueError(f"{name}: type {kind} is not read")


def read_npz(path, names, optional):
    with zipfile.ZipFile(path) as archive:
        names = names + [n for n in optional if n + ".npy" in archive.namelist()]
        return {n: read_npy(archive.read(n + ".npy"), n) for n in names}


def statistics(residuals, weight):
    sizes = [math.sqrt(sum(x * x for x in r)) for r in residuals]
    rms = math.sqrt(sum(s * s for s in sizes) / len(sizes))
    peak = max(range(len(sizes)), key=sizes.__getitem__)
    mean = math.sqrt(sum((sum(r[a] for r in residuals) / len(residuals)) ** 2 for a in range(3)))
    return {
        "rms_n": rms, "rms_percent": 100 * rms / weight,
        "peak_n": sizes[peak], "peak_percent": 100 * sizes[peak] / weight, "peak_row": peak + 1,
        "mean_n": mean, "mean_percent": 100 * mean / weight,
    }


def judge(path, still_s):
    names = ["rate_hz", "substeps", "gravity", "root_mode", "link_mass", "link_com", "momentum", "com",
             "contact_row", "contact_force", "contact_point", "root_wrench", "q"]
    a = read_npz(path, names, ["disturbed_wrench", "carried_mass", "carried_rows", "carried_com"])
    rate, substeps, g = a["rate_hz"][1][0], a["substeps"][1][0], a["gravity"][1]
    masses, at = a["link_mass"][1], a["link_com"][1]
    rows, links = a["momentum"][0][0], len(masses)
    if a["link_com"][0] != (rows, 3 * links):
        raise ValueError(f"link_com has shape {a['link_com'][0]}, expected {(rows, 3 * links)}")
    if rows < 4:
        raise ValueError(f"{rows} rows; at least 4 are needed")
    if not all(map(math.isfinite, at + a["momentum"][1] + a["contact_force"][1] + a["root_wrench"][1])):
        raise ValueError("a number is not finite")
    mass = sum(masses)
    loads = a["carried_mass"][1] if "carried_mass" in a else []
    spans = a["carried_rows"][1] if loads else []
    load_at = a["carried_com"][1] if loads else []
    carried = [[m if spans[2 * i] <= j < spans[2 * i + 1] else 0.0 for i, m in enumerate(loads)] for j in range(rows)]
    disturbed = a["disturbed_wrench"][1] if "disturbed_wrench" in a else [0.0] * (6 * rows)
    weight = mass * math.sqrt(sum(x * x for x in g)) or float("nan")

    wrench = a["root_wrench"][1]
    contact = [[0.0] * 3 for _ in range(rows)]
    contact_moment = [[0.0] * 3 for _ in range(rows)]
    com = a["com"][1]
    for i, row in enumerate(a["contact_row"][1]):
        f = a["contact_force"][1][3 * i:3 * i + 3]
        r = [a["contact_point"][1][3 * i + k] - com[3 * row + k] for k in range(3)]
        for k in range(3):
            contact[row][k] += f[k]
            contact_moment[row][k] += r[(k + 1) % 3] * f[(k + 2) % 3] - r[(k + 2) % 3] * f[(k + 1) % 3]
    wrench = [w + d for w, d in zip(wrench, disturbed)]
    force = [[(mass + sum(carried[j])) * g[k] + contact[j][k] + wrench[6 * j + k] for k in range(3)] for j in range(rows)]

    # Momentum of step j (rows j-1 to j) from positions.
    step = [None] + [
        [rate * (sum(m * (at[3 * links * j + 3 * i + k] - at[3 * links * (j - 1) + 3 * i + k])
                     for i, m in enumerate(masses))
                 + sum(m * (load_at[3 * len(loads) * j + 3 * i + k] - load_at[3 * len(loads) * (j - 1) + 3 * i + k])
                       for i, m in enumerate(carried[j]))) for k in range(3)]
        for j in range(1, rows)
    ]
    same = [j for j in range(1, rows - 1) if carried[j] == carried[j + 1]]
    w = (substeps - 1) / (2 * substeps)
    by_positions = [
        [rate * (step[j + 1][k] - step[j][k]) - (w * force[j][k] + (1 - w) * force[j + 1][k])
         for k in range(3)]
        for j in same
    ]
    p = a["momentum"][1]
    recorded = [[rate * (p[6 * j + k] - p[6 * (j - 1) + k]) - force[j][k] for k in range(3)]
                for j in range(1, rows)]

    # Angular momentum about the centre of mass; the root's origin is the first three numbers of q.
    nq = a["q"][0][1]
    angular = []
    for j in range(1, rows):
        r = [a["q"][1][nq * j + k] - com[3 * j + k] for k in range(3)]
        f, m = wrench[6 * j:6 * j + 3], wrench[6 * j + 3:6 * j + 6]
        size = 0.0
        for k in range(3):
            about_com = m[k] + r[(k + 1) % 3] * f[(k + 2) % 3] - r[(k + 2) % 3] * f[(k + 1) % 3]
            rate_of_change = rate * (p[6 * j + 3 + k] - p[6 * (j - 1) + 3 + k])
            size += (rate_of_change - contact_moment[j][k] - about_com) ** 2
        angular.append(math.sqrt(size))

    # Mean vertical contact force over the last `still_s` seconds.
    tail = max(1, min(rows - 1, round(still_s * rate)))
    vertical = sum(c[1] for c in contact[-tail:]) / tail
    root = [math.sqrt(sum(a["root_wrench"][1][6 * j + k] ** 2 for k in range(3))) for j in range(rows)]
    # what stands still weighs what it carries
    end_weight = (mass + sum(carried[-1])) * weight / mass
    return {
        "file": path, "rows": rows, "rate_hz": rate, "substeps": substeps,
        "root_mode": a["root_mode"][1][0], "mass_kg": mass, "weight_n": weight,
        "positions": statistics(by_positions, weight),
        "recorded": statistics(recorded, weight),
        "angular_rms_nm": math.sqrt(sum(x * x for x in angular) / len(angular)),
        "root_force_peak_n": max(root),
        "still": {"seconds": tail / rate, "vertical_mean_n": vertical,
                  "vertical_mean_percent": 100 * vertical / end_weight},
        "handed_rows": rows - 2 - len(same),
    }


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("trace", help="trace.npz")
    parser.add_argument("--max-rms", type=float, metavar="PERCENT", help="largest RMS residual by positions")
    parser.add_argument("--max-recorded-rms", type=float, metavar="PERCENT",
                        help="largest RMS residual of the recorded momentum")
    parser.add_argument("--max-mean", type=float, metavar="PERCENT",
                        help="largest mean residual by positions over the run")
    parser.add_argument("--still", type=float, default=0.5, metavar="SECONDS",
                        help="length of the still end (default 0.5)")
    parser.add_argument("--max-weight-error", type=float, metavar="PERCENT",
                        help="largest |mean vertical contact force - body weight| over the still end")
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    args = parser.parse_args()
    try:
        result = judge(args.trace, args.still)
    except (OSError, KeyError, ValueError, SyntaxError, struct.error, zipfile.BadZipFile) as error:
        print(f"{args.trace}: {error}", file=sys.stderr)
        return 2

    checks = [
        ("RMS by positions", result["positions"]["rms_percent"], args.max_rms),
        ("RMS of recorded momentum", result["recorded"]["rms_percent"], args.max_recorded_rms),
        ("mean by positions", result["positions"]["mean_percent"], args.max_mean),
        ("weight at the still end", abs(result["still"]["vertical_mean_percent"] - 100), args.max_weight_error),
    ]
    # `not <=` rather than `>`: NaN must fail.
    failed = [f"{name}: {found:.4g} % of body weight, at most {limit:g} % allowed"
              for name, found, limit in checks if limit is not None and not found <= limit]
    result["failed"] = failed
    if args.json:
        print(json.dumps(result, indent=2, allow_nan=True))
    else:
        print(f"{args.trace}: {result['rows']} rows at {result['rate_hz']:g} Hz x {result['substeps']}, "
              f"{result['mass_kg']:.2f} kg, root {result['root_mode']}")
        print("residual d(momentum)/dt - m g - contacts - root wrench, N (% of body weight)")
        for key in ("positions", "recorded"):
            s = result[key]
            print(f"  {key:<10} RMS {s['rms_n']:.4g} ({s['rms_percent']:.4g} %)   "
                  f"peak {s['peak_n']:.4g} ({s['peak_percent']:.4g} %) at row {s['peak_row']}   "
                  f"mean {s['mean_n']:.4g} ({s['mean_percent']:.4g} %)")
        print(f"  angular    RMS {result['angular_rms_nm']:.4g} N·m (recorded momentum)")
        print(f"root force, peak {result['root_force_peak_n']:.4g} N")
        s = result["still"]
        print(f"vertical contact force, mean of the last {s['seconds']:.3g} s: {s['vertical_mean_n']:.6g} N "
              f"({s['vertical_mean_percent']:.5g} % of body weight)")
        for line in failed:
            print(f"FAILED {line}")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
