#!/bin/sh
# FastICA of 2,000 × 93 into 5 and DTW with its path, 1,000 × 1,000: ours against scikit-learn and dtaidistance, in turns,
# on the same data and one thread.
#   learn/benches/peers/run.sh [ROUNDS]     (5)
# Needs python3 with venv and once the network (PyPI). Works in target/peers; PEERS_PYTHON names an interpreter that has
# them already.
set -eu
rounds=${1:-5}
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../../.." && pwd)
work=${CARGO_TARGET_DIR:-$root/target}/peers
mkdir -p "$work"
if [ -z "${PEERS_PYTHON:-}" ]; then
  if [ ! -x "$work/venv/bin/pip" ]; then python3 -m venv "$work/venv"; fi
  "$work/venv/bin/pip" install -q numpy==2.4.6 scikit-learn==1.9.1 dtaidistance==2.5.1
  PEERS_PYTHON=$work/venv/bin/python
fi
export OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1
ours=$(cd "$root" && cargo bench -q -p learn --bench decompose --no-run --message-format=json |
  sed -n 's/.*"executable":"\([^"]*\/decompose-[^"]*\)".*/\1/p')
"$ours" "$work" >/dev/null
: >"$work/runs.jsonl"
for _ in $(seq "$rounds"); do
  "$PEERS_PYTHON" "$here/peers.py" "$work" >>"$work/runs.jsonl"
  "$ours" "$work" >>"$work/runs.jsonl"
done
python3 - "$work/runs.jsonl" <<'PYTHON'
import json, sys
runs = [json.loads(line) for line in open(sys.argv[1])]
ours = [r for r in runs if r["engine"] == "contrapposto"]
peer = [r for r in runs if r["engine"] != "contrapposto"]
least = lambda rs, key: 1e3 * min(r[key] for r in rs)
print(f"{len(ours)} rounds; CPU time, least of all rounds, ms")
print(f"FastICA: ours {least(ours, 'ica_s'):.1f} ({ours[0]['steps']} steps), eight starts {least(ours, 'ica_8_starts_s'):.1f}; "
      f"scikit-learn {least(peer, 'ica_s'):.1f} (svd), {least(peer, 'ica_eigh_s'):.1f} (eigh), {peer[0]['steps']} steps")
a, b = least(ours, "dtw_s"), least(peer, "dtw_s")
print(f"DTW with path: ours {a:.2f}, dtaidistance {b:.2f}, ratio {a / b:.2f}; band {least(ours, 'dtw_band_s'):.2f}, waits of 2 {least(ours, 'dtw_wait_s'):.2f}")
print(f"distances {ours[0]['distance']:.12g} and {peer[0]['distance']:.12g}")
PYTHON
