#!/bin/sh
# run_checks.sh (gltf | browser) WRITE_FIXTURES FOLDER: writes the fixtures into FOLDER and runs the
# Node.js tests of that folder on them. Exit code 77 if what they need is not installed.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
if ! command -v node > /dev/null; then
    echo "skipped: Node.js is not installed"
    exit 77
fi
if [ ! -d "$here/node_modules" ]; then
    echo "skipped: run npm ci in tests/gltf"
    exit 77
fi
if [ "$1" = browser ] && ! command -v "${CHROMIUM:-/usr/bin/chromium}" > /dev/null; then
    echo "skipped: Chromium is not installed"
    exit 77
fi
"$2" "$3"
cd "$here/../$1"
RIVAGE_FIXTURES=$3 exec node --test
