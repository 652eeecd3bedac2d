# make demo   install what is missing, build, convert the model that the program makes itself
# make test   install what is missing, build, run every test, and those that depend on the method without CGAL
# make fuzz   a million executions of each fuzz target (hours); not part of make test
# make browser-test   the same for what a browser shows of the textures (10 models, half an hour); not part of make test
# make oracle-test   all test files against the readers of other projects, from PyPI (three minutes); not part of make test
# make quick-bench   two public cases of the quality bench, without baseline

.PHONY: all demo test fuzz browser-test oracle-test setup build quick-bench format lint clean

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

FUZZ = ply ply_mesh pcd text ptx las laz e57 obj off stl gltf splat spz gzip zstd image options
fuzz:
	@tools/setup.sh fuzz
	@cmake --preset fuzz > build/configure.log 2>&1 || { cat build/configure.log; exit 1; }
	@cmake --build --preset fuzz --target $(FUZZ:%=fuzz_%)
	@for t in $(FUZZ); do \
	    mkdir -p build/fuzz/corpus/$$t; echo "fuzz: $$t"; \
	    build/fuzz/fuzz/fuzz_$$t -runs=1000000 -max_len=4096 -rss_limit_mb=2048 -malloc_limit_mb=4096 -timeout=60 -print_final_stats=1 \
	        -artifact_prefix=build/fuzz/corpus/$$t- build/fuzz/corpus/$$t fuzz/corpus/$$t > build/fuzz/$$t.log 2>&1 || \
	        { tail -n 40 build/fuzz/$$t.log; exit 1; }; done

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
