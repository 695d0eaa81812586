#!/bin/sh
# Learning two models of 1,100 mirrored examples (180 to 62) and predicting 1,000 frames: ours against numpy and LAPACK, in
# turns, on the same data, one core.
#   learn/benches/lapack/run.sh [ROUNDS]     (3)
# Needs python3 with venv, once the network (PyPI), and ../shared/bench. Works in target/lapack; LAPACK_PYTHON names an
# interpreter that has numpy and scipy already.
set -eu
rounds=${1:-3}
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../../.." && pwd)
work=${CARGO_TARGET_DIR:-$root/target}/lapack
script=$root/../shared/bench/b4_gp_lapack.py
mkdir -p "$work"
if [ -z "${LAPACK_PYTHON:-}" ]; then
  if [ ! -x "$work/venv/bin/pip" ]; then python3 -m venv "$work/venv"; fi
  "$work/venv/bin/pip" install -q numpy==2.4.6 scipy==1.17.1
  LAPACK_PYTHON=$work/venv/bin/python
fi
ours=$(cd "$root" && cargo bench -q -p learn --bench examples --no-run --message-format=json |
  sed -n 's/.*"executable":"\([^"]*\/examples-[^"]*\)".*/\1/p')
"$ours" "$work" >/dev/null
"$LAPACK_PYTHON" - "$work" <<'PYTHON'
import sys
import numpy as np
work = sys.argv[1]
for i in (0, 1):
    x, y, f = (np.fromfile(f"{work}/{name}{i}.f64", "<f8") for name in "XYF")
    f = f.reshape(1000, -1)
    # the script also prints an error against targets of the frames, which says nothing here
    np.savez(f"{work}/gp{i}.npz", X=x.reshape(1100, -1), Y=y.reshape(1100, -1), Xs=f, Ys=np.zeros((1000, 62)))
PYTHON
: >"$work/runs.jsonl"
for _ in $(seq "$rounds"); do
  for i in 0 1; do "$LAPACK_PYTHON" "$script" "$work/gp$i.npz" >>"$work/runs.jsonl"; done
  "$ours" "$work" >>"$work/runs.jsonl"
done
python3 - "$work/runs.jsonl" <<'PYTHON'
import json, sys
runs = [json.loads(line) for line in open(sys.argv[1])]
ours = [r["models"] for r in runs if r.get("engine") == "contrapposto"]
peer = [[r for r in runs if r.get("input") == f"gp{i}.npz"] for i in (0, 1)]
print(f"{len(ours)} rounds; CPU time, least of all rounds")
def line(what, a, b, unit):
    print(f"{what}: ours {a:.2f} {unit}, LAPACK {b:.2f} {unit}, ratio {a / b:.2f}")
line("learning both", sum(min(r[i]["fit_s"] for r in ours) for i in (0, 1)),
     sum(min(r["fit"]["cpu_min_s"] for r in peer[i]) for i in (0, 1)), "s")
for i in (0, 1):
    a, b = ours[0][i], peer[i][0]
    print(f"model {i}: likelihood {a['lml']:.4f} and {b['lml']:.4f}, relative {abs(a['lml'] / b['lml'] - 1):.1e}; "
          f"evaluations {a['evaluations']} and {b['nfev']}; theta {a['theta']} and {b['theta']}; diameter {a['diameter']}")
    line(f"model {i}, 1,000 frames", 1e3 * min(r[i]["batch_s"] for r in ours),
         1e3 * min(r["pred1000_meanvar_cpu_s"] for r in peer[i]), "ms")
    line(f"model {i}, one frame", 1e3 * min(r[i]["one_s"] for r in ours),
         min(r["one_frame_meanvar_cpu_ms"] for r in peer[i]), "ms")
PYTHON
