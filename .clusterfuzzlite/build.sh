#!/bin/bash
# SPDX-License-Identifier: MIT
# Builds the fuzz targets as ClusterFuzzLite and OSS-Fuzz want it: called in the source tree, with
# CC, CXX, CFLAGS, CXXFLAGS, LIB_FUZZING_ENGINE and WORK set; leaves in OUT each target with
# TARGET_seed_corpus.zip and TARGET.dict, and the libraries they need in OUT/lib.
set -eu
: "${CC:?}" "${CXX:?}" "${CFLAGS:?}" "${CXXFLAGS?}" "${LIB_FUZZING_ENGINE:?}" "${WORK:?}" "${OUT:?}"

# The flags are the caller's alone; his compiler may know warnings that this tree does not.
# shellcheck disable=SC2016 # the loader knows what $ORIGIN is
cmake -G Ninja -S . -B "$WORK/drehgeber" -D CMAKE_BUILD_TYPE=None -D CMAKE_C_COMPILER="$CC" \
    -D CMAKE_C_FLAGS="$CFLAGS" -D CMAKE_COMPILE_WARNING_AS_ERROR=OFF -D DREHGEBER_FUZZ=ON \
    -D DREHGEBER_FUZZ_ENGINE="$LIB_FUZZING_ENGINE" -D CMAKE_EXE_LINKER_FLAGS='-Wl,-rpath,$ORIGIN/lib'
cmake --build "$WORK/drehgeber"

# Where the targets run there is nothing but a C library.
libraries() {
    ldd "$1" | sed -nE 's/^\s+lib(systemd|modbus|gpiod|cap|gcrypt|gpg-error|lzma|lz4|zstd|cmocka)\S* => (\S+) .*/\2/p'
}

mkdir -p "$OUT/lib"
for source in tests/fuzz/fuzz_*.c; do
    name=$(basename "$source" .c)
    cp "$WORK/drehgeber/tests/fuzz/$name" "$OUT/"
    cp "tests/fuzz/$name.dict" "$OUT/"
    (cd "tests/fuzz/corpus/$name" && cmake -E tar cf "$OUT/${name}_seed_corpus.zip" --format=zip -- *)
    for library in $(libraries "$OUT/$name"); do
        cp -u "$library" "$OUT/lib/"
    done
done
