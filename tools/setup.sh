#!/bin/sh
# Installs what is missing on Debian 12 to build (setup.sh build), to build and test (setup.sh test), to fuzz (setup.sh fuzz), to build and look
# at the results in a browser (setup.sh browser), or to hold the readers against others (setup.sh oracle).
set -eu
cd "$(dirname "$0")/.."
mkdir -p build

packages="g++ cmake ninja-build ccache pkg-config libcgal-dev libtbb-dev libeigen3-dev libnanoflann-dev
          libdeflate-dev libspng-dev libpugixml-dev libproj-dev zlib1g-dev libzstd-dev libturbojpeg0-dev libjpeg62-turbo-dev libwebp-dev libmeshoptimizer-dev libdraco-dev libfmt-dev libcli11-dev nlohmann-json3-dev"
[ "${1:-build}" = test ] && packages="$packages libgtest-dev libgmock-dev python3"
[ "${1:-build}" = fuzz ] && packages="$packages libgtest-dev libgmock-dev python3 clang-19 libclang-rt-19-dev"
[ "${1:-build}" = oracle ] && packages="$packages python3-venv libusb-1.0-0 libgl1 libgomp1 libegl1"  # for open3d
if [ "${1:-build}" = browser ]; then  # other sources of these will do
    command -v chromium >/dev/null 2>&1 || packages="$packages chromium"
    command -v node >/dev/null 2>&1 || packages="$packages nodejs"
    command -v npm >/dev/null 2>&1 || packages="$packages npm"
fi

missing=""
for package in $packages; do
    dpkg-query -W -f '${Status}' "$package" 2>/dev/null | grep -q 'install ok installed' || missing="$missing $package"
done
if [ -n "$missing" ]; then
    if [ "$(id -u)" = 0 ]; then
        as_root=""
    elif command -v sudo >/dev/null 2>&1; then
        as_root="sudo"
    else
        echo "setup: these packages are missing, and there is neither root nor sudo to install them:$missing" >&2
        echo "setup: ask your administrator for: apt-get install --no-install-recommends$missing" >&2
        exit 1
    fi
    echo "setup: installing$missing"
    log=build/setup.log
    export DEBIAN_FRONTEND=noninteractive
    if ! { $as_root apt-get update && $as_root apt-get install -y --no-install-recommends $missing; } >"$log" 2>&1; then
        tail -n 20 "$log" >&2
        echo "setup: installing failed; the whole log is in $log" >&2
        exit 1
    fi
fi

# The glTF validator runs where there is Node; without it its tests say that they were skipped.
if [ "${1:-build}" = test ] && command -v npm >/dev/null 2>&1 && [ ! -d tests/support/node_modules/gltf-validator ]; then
    echo "setup: installing the glTF validator"
    (cd tests/support && npm ci --no-audit --no-fund) >build/npm.log 2>&1 ||
        echo "setup: the glTF validator could not be installed (build/npm.log); its tests will be skipped" >&2
fi

# Again when the versions that are asked for have changed.
if [ "${1:-build}" = browser ] &&
    ! [ tests/browser/node_modules/.package-lock.json -nt tests/browser/package-lock.json ]; then
    echo "setup: installing three.js and puppeteer"
    if ! (cd tests/browser && npm ci --no-audit --no-fund) >build/npm.log 2>&1; then
        tail -n 20 build/npm.log >&2
        echo "setup: installing failed; the whole log is in build/npm.log" >&2
        exit 1
    fi
fi

if [ "${1:-build}" = oracle ] && [ ! -e build/oracle/complete ]; then
    echo "setup: installing the readers of other projects into build/oracle"
    if ! { python3 -m venv build/oracle && build/oracle/bin/pip install --quiet numpy 'laspy[lazrs]' pye57 plyfile open3d; } \
        >build/pip.log 2>&1; then
        tail -n 20 build/pip.log >&2
        echo "setup: installing failed; the whole log is in build/pip.log" >&2
        exit 1
    fi
    touch build/oracle/complete
fi
