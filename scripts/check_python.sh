#!/usr/bin/env bash
# Checks of an installed Python package: its tests, types and stubs, and the notebooks. Installs the packages that they need.
#
# Usage: scripts/check_python.sh [PYTHON]; the interpreter is that of the environment which has the package.
set -euo pipefail
cd "$(dirname "$0")/.."
python=${1:-python}
packages=(meshio pyvista scipy pandas mypy nbclient ipykernel matplotlib selenium)
# Gmsh has no wheel for Linux on ARM: its tests are skipped there.
[ "$(uname -sm)" = "Linux aarch64" ] || packages+=(gmsh)
"$python" -m pip install --quiet --disable-pip-version-check "${packages[@]}"
"$python" -W error::ResourceWarning -m unittest discover -s python/tests
# The tests of Linux alone, such as those of forks, are checked on all machines.
"$python" -m mypy --platform linux python/tegula python/tests
"$python" -m mypy.stubtest tegula._tegula
executed=$(mktemp -d)
trap 'rm -rf "$executed"' EXIT
for notebook in examples/python/*.ipynb; do
  # The command `jupyter` would look for its parts on the path, where those of another environment may be.
  "$python" -c "from nbclient.cli import main; main()" --output "$executed/executed.ipynb" "$notebook"
done
