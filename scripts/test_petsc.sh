#!/usr/bin/env bash
# Tests of runs on several processes: factorisations by MUMPS, results beside those of a single process, faults. PETSc and MPI are those of the machine.
#
# Usage: scripts/test_petsc.sh [--all]; with `--all` the longer models too, ranks that are killed, and a part of `tegula verify`
set -euo pipefail
cd "$(dirname "$0")/.."
# Open MPI refuses the administrator, as whom containers run, and more ranks than cores.
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMPI_MCA_rmaps_base_oversubscribe=1 OMP_NUM_THREADS=1
out=$(mktemp -d)
# The ordinary program comes back to its place at the end.
trap 'rm -rf "$out"; cargo build --release --quiet -p tegula-cli' EXIT
tests=$(cargo test -p tegula-petsc --features link --no-run --message-format=json 2>"$out/errors" |
  python3 -c 'import json, sys
for line in sys.stdin:
    part = json.loads(line)
    if part.get("executable") and part["target"]["name"] == "mumps":
        print(part["executable"])') || { cat "$out/errors" >&2; exit 1; }
for ranks in 1 2 3 4; do
  timeout 120 mpirun -n "$ranks" "$tests" --quiet >"$out/log" 2>&1 || { cat "$out/log" >&2; exit 1; }
done
echo "factorisations on 1 to 4 ranks are those of the program"
cargo build --release -p tegula-cli --features petsc
cp "${CARGO_TARGET_DIR:-target}/release/tegula" "$out/tegula"
if [ "${1:-}" != --all ]; then
  python3 scripts/test_ranks.py "$out/tegula" verification/models/quarter_cylinder.toml \
    examples/quarter_cylinder_static.toml:iterative examples/free_plate_modes.toml \
    examples/plate_buckling.toml examples/stress_wave.toml examples/yielding_strip.toml
  python3 scripts/test_rank_faults.py "$out/tegula" 0
  exit
fi
python3 scripts/test_ranks.py "$out/tegula"
python3 scripts/test_rank_faults.py "$out/tegula" 3
timeout 300 mpirun -n 2 "$out/tegula" verify quarter-cylinder frequencies >"$out/log" 2>&1 || { cat "$out/log" >&2; exit 1; }
tail -n 3 "$out/log"
