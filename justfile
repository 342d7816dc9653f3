# `just` lists the recipes.
default:
    @just --list

# Runs the tests.
test:
    cargo test --workspace

# Runs everything that must pass before a change lands.
ci:
    .ci/run

# Tests the HTML pages in headless Chromium.
pages:
    cargo build -p smalti-cli
    tools/page/run

# Runs all benchmarks, or one: `just bench optics`.
bench name="":
    cargo bench --workspace {{ if name == "" { "" } else { "--bench " + name } }}

# Compares Bayer demosaicking and L³ rendering with OpenCV in one run.
bench-opencv:
    python3 tools/bench_opencv.py

# Makes ISETCam's reference values again with Octave and compares them, all or some: `just isetcam ../isetcam out scene optics`.
isetcam checkout out *groups:
    octave-cli -q tools/isetcam/make_reference.m {{checkout}} crates/smalti/tests/data/isetcam {{out}} {{groups}}
    python3 tools/isetcam/compare.py crates/smalti/tests/data/isetcam {{out}} {{ if groups == "" { "" } else { "--some" } }}

# Kills a sweep a hundred times and checks that its results equal those of an uninterrupted run.
kills:
    cargo test --release -p smalti-cli --test cli a_hundred_kills -- --ignored

# Compares rankings of cameras with learned pipelines under two infrared-cut filters.
rankings:
    cargo test --release -p smalti-cli --test cli another_infrared_cut -- --include-ignored

# Compares the rank of 504 designs by the closed form with that by learned pipelines.
screening:
    cargo test --release -p smalti-io --test screening -- --ignored --nocapture

# Compares the figures of 150 designs by pipelines from statistics of light with those by pipelines from patches.
learned-statistics:
    cargo test --release -p smalti-io --test learned_statistics -- --ignored --nocapture

# Checks the licences, sources, versions and known faults of all dependencies with cargo-deny, which needs a network for the last.
deny:
    command -v cargo-deny >/dev/null || cargo install --locked cargo-deny
    cargo deny check

# Fuzzes all parsers, or some, for a minute each on all cores: `just fuzz`, `just fuzz 600 exr dng`.
fuzz *args:
    tools/fuzz {{args}}

# Measures the share of mutants of what Smalti computes that the tests notice, in a sample: `just mutants --seed 3`.
mutants *args:
    command -v cargo-mutants >/dev/null || cargo install --locked cargo-mutants
    tools/mutants {{args}}

# Runs the tests of the crates with unsafe code under the address sanitizer, all or some: `just sanitize l3::render`.
sanitize *filters:
    tools/sanitize {{filters}}

# Runs tests of the unsafe code under Miri, or those that filters name: `just miri numeric::fft`.
miri *filters:
    tools/miri {{filters}}

# Compares what processors with and without AVX and arm64 compute.
portable:
    tools/portable

# Regenerates the tables of published data.
tables:
    python3 tools/generate_tables.py
    python3 tools/generate_cameras.py
    python3 tools/generate_curves.py
    cargo fmt --all

# Makes the pictures of the documentation with the commands that it names. This takes some minutes.
pictures:
    cargo build --release --locked -p smalti-cli
    cd tools/page && npm ci --silent
    python3 tools/make_pictures.py target/release/smalti

# Builds the documentation as a book in target/book, with the studio as a live page.
book:
    command -v mdbook >/dev/null || cargo install --locked mdbook
    mdbook build
    cargo run --release --locked -p smalti-cli -- studio rgbw --export target/book/studio --quiet

# Generates the pages of docs/reference from the code.
reference:
    cargo build --locked -p smalti-cli
    mkdir -p docs/reference
    for what in scenes cfas cameras illuminants filters metrics studies designs camera-keys study-keys design-keys; do \
        target/debug/smalti list $what --markdown > docs/reference/$what.md; \
    done
    mkdir -p docs/reference/cfas
    for name in $(target/debug/smalti list cfas --json | grep -o '"name": "[^"]*"' | cut -d'"' -f4); do \
        target/debug/smalti show $name --as cfa -o docs/reference/cfas/$name.svg; \
    done

# Prints the lines of source per crate, without tests and generated tables: `just lines`, `just lines HEAD~10`.
lines commit="HEAD":
    python3 tools/lines.py {{commit}}

# Makes the simulator that pages embed, after a change of what draws their pictures. Needs wasm-opt (Debian's binaryen).
wasm:
    tools/wasm/build
