# make demo   install what is missing, build, convert the model that the program makes itself
# make test   install what is missing, build, run every test, and those that depend on the method without CGAL
# make browser-test   the same for what a browser shows of the textures (10 models, half an hour); not part of make test
# make oracle-test   all test files against the readers of other projects, from PyPI (three minutes); not part of make test
# make quick-bench   two public cases of the quality bench, without baseline

.PHONY: all demo test browser-test oracle-test setup build quick-bench format lint clean

all: build

setup:
	@tools/setup.sh build

build: setup
	@cmake --preset release -DPOINTBAKE_TESTS=OFF > build/configure.log 2>&1 || { cat build/configure.log; exit 1; }
	@cmake --build --preset release

demo: build
	@mkdir -p demo-out
	build/release/pointbake demo demo-out/demo.glb

test:
	@tools/setup.sh test
	@cmake --preset release -DPOINTBAKE_TESTS=ON > build/configure.log 2>&1 || { cat build/configure.log; exit 1; }
	@cmake --build --preset release
	@ctest --preset release
	@cmake --preset no-cgal -DPOINTBAKE_TESTS=ON > build/configure.log 2>&1 || { cat build/configure.log; exit 1; }
	@cmake --build --preset no-cgal --target pointbake_cli cli_test without_cgal_test
	@ctest --preset no-cgal

browser-test: build
	@tools/setup.sh browser
	@node tests/browser/browser_test.mjs --pointbake build/release/pointbake --out build/browser-test \
	    --pictures build/browser-test/pictures $(BROWSER_TEST)

oracle-test: build
	@tools/setup.sh oracle
	@build/oracle/bin/python tests/independent/readers_test.py build/release/pointbake $${POINTBAKE_DATA:-../shared/data}

quick-bench: build
	@tools/quick_bench.sh

format:
	@git ls-files '*.h' '*.cpp' | xargs clang-format-19 -i

lint:
	@python3 tools/check_layers.py
	@git ls-files '*.h' '*.cpp' | xargs clang-format-19 --dry-run --Werror

clean:
	rm -rf build demo-out
