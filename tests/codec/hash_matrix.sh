#!/usr/bin/env bash
# hash_matrix.sh SOURCE_DIR WORK_DIR COMPILER FLAGS...: compiles globe, codec and golden_hash.cpp with this compiler and
# these flags, and lets the program compare the golden files with their pinned hashes. Exit code 77: no such compiler.
set -euo pipefail
source_dir=$1 work_dir=$2 compiler=$3
shift 3
command -v "$compiler" >/dev/null || { echo "no $compiler here"; exit 77; }
launcher=$(command -v ccache || true)
mkdir -p "$work_dir"
cd "$work_dir"

read -ra libraries <<<"$(pkg-config --cflags --libs libxxhash geographiclib libhwy)"
# Highway 1.0 wants to be asked before it dispatches to what -march=native may make the baseline.
common=(-DHWY_WANT_AVX3_DL=1 -std=c++20 -ffp-contract=off -I"$source_dir/globe/include" -I"$source_dir/codec/include" -I"$source_dir/codec/src")
sources=("$source_dir"/globe/src/*.cpp "$source_dir"/codec/src/*.cpp "$source_dir"/tests/codec/walk.cpp
    "$source_dir"/tests/codec/golden_hash.cpp)

objects=()
running=0
for source in "${sources[@]}"; do
    object=$(basename "$(dirname "$(dirname "$source")")")_$(basename "$source" .cpp).o
    objects+=("$object")
    $launcher "$compiler" "${common[@]}" "$@" -c "$source" -o "$object" &
    if ((++running >= $(nproc))); then
        wait -n
        running=$((running - 1))
    fi
done
while ((running-- > 0)); do wait -n; done
"$compiler" "${objects[@]}" "${libraries[@]}" -lpthread -o golden_hash
./golden_hash "$source_dir/tests/codec/golden"
echo "same heights: $compiler $*"
