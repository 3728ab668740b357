#!/usr/bin/env bash
# Builds a static program for Linux on x86-64, which runs on any distribution, and packs it with completions, manual pages, README and licences
# as `target/tegula-VERSION-x86_64-linux-musl.tar.gz`. Needs rustup and tar.
set -euo pipefail
cd "$(dirname "$0")/.."
triple=x86_64-unknown-linux-musl
rustup target add "$triple"
cargo build --release --locked --package tegula-cli --target "$triple"
program=${CARGO_TARGET_DIR:-target}/$triple/release/tegula
# A static program has no interpreter.
if readelf --program-headers "$program" | grep -q INTERP; then
  echo "error: $program is linked dynamically" >&2
  exit 1
fi
version=$("$program" --version | cut -d' ' -f2)
name=tegula-$version-x86_64-linux-musl
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir -p "$work/$name/completions"
cp "$program" README.md CHANGELOG.md CITATION.cff LICENSE-MIT LICENSE-APACHE "$work/$name"
cp -r examples "$work/$name"
for shell in bash zsh fish; do
  "$program" completions "$shell" >"$work/$name/completions/tegula.$shell"
done
"$program" man "$work/$name/man/man1" >/dev/null
# The same files give the same archive.
mkdir -p target
tar --sort=name --owner=0 --group=0 --numeric-owner --mtime="@$(git log -1 --format=%ct)" -C "$work" -c "$name" | gzip -n9 >"target/$name.tar.gz"
ls -l "target/$name.tar.gz"
