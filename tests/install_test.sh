#!/bin/sh
# Installs into a fresh folder, builds the consumer against it, runs it on the cloud that the demo makes.
# usage: install_test.sh BUILD_DIR SOURCE_DIR
set -eu
build=$1 source=$2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cmake --install "$build" --prefix "$work/installed" >/dev/null
"$work/installed/bin/pointbake" --version
cmake -S "$source/examples/consumer" -B "$work/build" -G Ninja -DCMAKE_BUILD_TYPE=Release \
    -DCMAKE_PREFIX_PATH="$work/installed" >/dev/null
cmake --build "$work/build"
cat > "$work/tetrahedron.ply" <<'PLY'
ply
format ascii 1.0
element vertex 6
property float x
property float y
property float z
property uchar red
property uchar green
property uchar blue
end_header
1 0 0 255 0 0
-1 0 0 0 255 0
0 1 0 0 0 255
0 -1 0 255 255 0
0 0 1 0 255 255
0 0 -1 255 0 255
PLY
"$work/build/consumer" "$work/tetrahedron.ply" "$work/out.glb"
test -s "$work/out.glb"
