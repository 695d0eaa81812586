#!/bin/sh
# Our inverse dynamics and mass matrix against Pinocchio's, in turns, on the same tree and states.
#   dynamics/benches/pinocchio/run.sh [ROUNDS]     (20)
# Needs python3 with venv, g++, and once the network (PyPI). Builds in target/pinocchio; the first build
# of Pinocchio's templates takes minutes and 3 GB. PINOCCHIO_CXXFLAGS replaces `-march=native`.
set -eu
rounds=${1:-20}
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../../.." && pwd)
work=${CARGO_TARGET_DIR:-$root/target}/pinocchio
flags=${PINOCCHIO_CXXFLAGS--march=native}
peer=$work/pinocchio$(printf %s "$flags" | tr -c 'a-zA-Z0-9' _)
mkdir -p "$work"

if [ ! -x "$work/venv/bin/pip" ]; then python3 -m venv "$work/venv"; fi
"$work/venv/bin/pip" install -q pin==4.1.0 cmeel-eigen==3.4.1
prefix=$(echo "$work"/venv/lib/python3*/site-packages/cmeel.prefix)
if [ ! -x "$peer" ] || [ "$here/pinocchio.cc" -nt "$peer" ]; then
  # shellcheck disable=SC2086
  g++ -std=c++17 -O3 -DNDEBUG $flags -w -DFLAGS="\"$flags\"" -DBOOST_MPL_LIMIT_LIST_SIZE=30 \
    -DBOOST_MPL_CFG_NO_PREPROCESSED_HEADERS -DBOOST_FUSION_INVOKE_MAX_ARITY=10 \
    -isystem "$prefix/include" -isystem "$prefix/include/eigen3" "$here/pinocchio.cc" -o "$peer"
fi

ours=$(cd "$root" && cargo bench -q -p dynamics --bench rnea --no-run --message-format=json |
  sed -n 's/.*"executable":"\([^"]*\/rnea-[^"]*\)".*/\1/p')
"$ours" "$work" >/dev/null
: >"$work/runs.jsonl"
for _ in $(seq "$rounds"); do
  "$peer" "$work/model.txt" "$work/states.bin" >>"$work/runs.jsonl"
  "$ours" >>"$work/runs.jsonl"
done
python3 - "$work/runs.jsonl" <<'PYTHON'
import json, sys
runs = [json.loads(line) for line in open(sys.argv[1])]
ours = [r for r in runs if r["engine"] == "contrapposto"]
peer = [r for r in runs if r["engine"] != "contrapposto"]
print(f'{len(ours)} rounds against {peer[0]["engine"]}; CPU time of the thread, µs, least of all rounds')
for what, error in (("rnea", "tau_error"), ("crba", "mass_error")):
    a, b = (min(r[what + "_us"] for r in rs) for rs in (ours, peer))
    print(f"{what}: ours {a:.3f}, Pinocchio {b:.3f}, ratio {a / b:.2f}; largest difference {peer[0][error]:.1e} relative")
PYTHON
