# `just` lists the recipes.
default:
    @just --list

# The tests.
test:
    cargo test --workspace

# Everything that must hold before a change lands.
ci:
    .ci/run

# The HTML pages in headless Chromium.
pages:
    cargo build -p smalti-cli
    tools/page/run

# All benchmarks; `just bench optics` runs one.
bench name="":
    cargo bench --workspace {{ if name == "" { "" } else { "--bench " + name } }}

# Bayer demosaicking against OpenCV, in one run.
bench-opencv:
    python3 tools/bench_opencv.py

# Kills a sweep a hundred times; its results must be those of one that was left alone.
kills:
    cargo test --release -p smalti-cli --test cli a_hundred_kills -- --ignored

# Fuzzes one parser for a minute, or all in turn: `just fuzz exr`, `just fuzz all 600`.
fuzz target="all" seconds="60":
    fuzz/run {{target}} {{seconds}}

# The fuzz targets compile.
check-fuzz:
    cargo check --manifest-path fuzz/Cargo.toml --locked

# Regenerates the tables of published figures.
tables:
    python3 tools/generate_tables.py
    python3 tools/generate_cameras.py
    cargo fmt --all

# The pictures of the documentation, by the commands that it names; some minutes.
pictures:
    cargo build --release --locked -p smalti-cli
    cd tools/page && npm ci --silent
    python3 tools/make_pictures.py target/release/smalti

# The documentation as a book, in target/book.
book:
    command -v mdbook >/dev/null || cargo install --locked mdbook
    mdbook build

# The pages of docs/reference, from the code
reference:
    cargo build --locked -p smalti-cli
    mkdir -p docs/reference
    for what in scenes cfas cameras illuminants filters metrics studies camera-keys study-keys; do \
        target/debug/smalti list $what --markdown > docs/reference/$what.md; \
    done
    mkdir -p docs/reference/cfas
    for name in $(target/debug/smalti list cfas --json | grep -o '"name": "[^"]*"' | cut -d'"' -f4); do \
        target/debug/smalti show $name --as cfa -o docs/reference/cfas/$name.svg; \
    done
