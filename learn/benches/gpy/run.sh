#!/bin/sh
# Learning 52 key poses in 30 dimensions, 70 iterations: ours against GPy's GPLVM, in turns, on the same data.
#   learn/benches/gpy/run.sh [ROUNDS]     (10)
# Needs python3 with venv and once the network (PyPI). Works in target/gpy; GPY_PYTHON names an interpreter that has
# GPy already. Ours learns two kernels and starts from kernel CCA; GPy's one kernel over both spaces from PCA.
set -eu
rounds=${1:-10}
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../../.." && pwd)
work=${CARGO_TARGET_DIR:-$root/target}/gpy
mkdir -p "$work"
if [ -z "${GPY_PYTHON:-}" ]; then
  if [ ! -x "$work/venv/bin/pip" ]; then python3 -m venv "$work/venv"; fi
  "$work/venv/bin/pip" install -q GPy==1.15.0
  GPY_PYTHON=$work/venv/bin/python
fi
ours=$(cd "$root" && cargo bench -q -p learn --bench gplvm --no-run --message-format=json |
  sed -n 's/.*"executable":"\([^"]*\/gplvm-[^"]*\)".*/\1/p')
"$ours" "$work" >/dev/null
: >"$work/runs.jsonl"
for _ in $(seq "$rounds"); do
  "$GPY_PYTHON" "$here/gplvm.py" "$work" >>"$work/runs.jsonl"
  "$ours" "$work" >>"$work/runs.jsonl"
done
python3 - "$work/runs.jsonl" <<'PYTHON'
import json, sys
runs = [json.loads(line) for line in open(sys.argv[1])]
ours = [r for r in runs if r["engine"] == "contrapposto"]
peer = [r for r in runs if r["engine"] != "contrapposto"]
a, b = (min(r["learn_s"] for r in rs) for rs in (ours, peer))
print(f'{len(ours)} rounds against {peer[0]["engine"]}; CPU time, least of all rounds')
print(f"learning: ours {1e3 * a:.1f} ms, GPy {1e3 * b:.1f} ms, ratio {b / a:.1f}")
print(f'mapping: {1 / min(r["map_s"] for r in ours):.0f} frames/s')
PYTHON
