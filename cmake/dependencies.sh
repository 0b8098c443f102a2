# What the build needs on Debian 12; read by ./dev and by docker/Dockerfile, so that there is one list.
build_packages=(build-essential cmake ninja-build pkg-config git ca-certificates
    libdraco-dev libtinygltf-dev nlohmann-json3-dev libspdlog-dev libcli11-dev doctest-dev
    libtbb-dev libeigen3-dev libexpected-dev libssl-dev zlib1g-dev
    libzstd-dev libsqlite3-dev prometheus-cpp-dev)
httplib_version=0.53.1

# check_httplib FOLDER: whether it has upstream's files.
check_httplib() {
    sha256sum --check --status - 2>/dev/null <<SUMS
b36e352ed5c39eabd26540f2089c83aafbcb29c5f36feb48a63575c63451ed7d  $1/httplib.h
8b1de0a587d68006d1c3cb3e056e0b80363b93f12d0ad3a26a9c83a236515f40  $1/httplib.cpp
SUMS
}

# fetch_httplib FOLDER: the split files of upstream's release, which no Debian 12 package has; in a
# subshell, so that its trap is its own.
fetch_httplib() (
    set -euo pipefail
    folder=package/cpp/llama.cpp/vendor/cpp-httplib
    mkdir -p "${1%/*}"
    work="$(mktemp -d "${1%/*}/fetch.XXXXXX")"
    trap 'rm -rf "$work"' EXIT
    npm pack @novastera-oss/llamarn@0.10.5 --pack-destination "$work"
    tar -xzf "$work"/novastera-oss-llamarn-0.10.5.tgz -C "$work" "$folder"
    if ! check_httplib "$work/$folder"; then
        echo 'the fetched cpp-httplib does not have the expected sha256 sums' >&2
        return 1
    fi
    rm -rf "$1"
    mv "$work/$folder" "$1"
)
