# shellcheck shell=bash
# Sourced by the scripts of this folder: where the source tree is, how it is built, how a step is announced.
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
cores=$(nproc)
export CCACHE_BASEDIR=$root

die() {
    echo "$(basename "$0"): $*" >&2
    exit 1
}

# step WORDS -- COMMAND...: says what begins, runs it, says how long it took. Ends the script when it fails.
step() {
    local words=()
    while [[ $1 != -- ]]; do
        words+=("$1")
        shift
    done
    shift
    echo "== ${words[*]}"
    local start=$SECONDS
    "$@" || die "failed: ${words[*]} (exit code $?)"
    echo "   took $((SECONDS - start)) s"
}

# build PRESET [TARGET...]: configures and builds into build/PRESET. The configuration's words are shown only if it fails.
build() {
    local preset=$1 log
    shift
    cd "$root" || return 1
    mkdir -p build
    log=build/configure-$preset.log
    cmake --preset "$preset" >"$log" 2>&1 || { cat "$log" >&2; return 1; }
    local targets=()
    (($# == 0)) || targets=(--target "$@")
    cmake --build "build/$preset" -j "$cores" "${targets[@]}"
}
