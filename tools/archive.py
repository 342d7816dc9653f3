"""Packs a folder so that equal files give equal archives on every system, or prints SHA-256 sums.

    python3 tools/archive.py FOLDER ARCHIVE.tar.gz    the time of all files is SOURCE_DATE_EPOCH
    python3 tools/archive.py --sums FILE...           as sha256sum prints them
"""

import gzip
import hashlib
import os
import pathlib
import sys
import tarfile


def pack(folder: pathlib.Path, archive: pathlib.Path) -> None:
    time = int(os.environ["SOURCE_DATE_EPOCH"])
    unfinished = archive.with_suffix(".part")
    with (
        open(unfinished, "wb") as raw,
        gzip.GzipFile(filename="", mode="wb", fileobj=raw, mtime=time) as packed,
        tarfile.open(fileobj=packed, mode="w", format=tarfile.PAX_FORMAT) as tar,
    ):
        for path in [folder, *sorted(folder.rglob("*"))]:
            info = tar.gettarinfo(path, str(pathlib.PurePosixPath(folder.name, *path.relative_to(folder).parts)))
            runs = info.isdir() or path.name in ("smalti", "smalti.exe")
            info.uid, info.gid, info.uname, info.gname, info.mtime, info.mode = 0, 0, "", "", time, 0o755 if runs else 0o644
            if info.isfile():
                with open(path, "rb") as content:
                    tar.addfile(info, content)
            else:
                tar.addfile(info)
    unfinished.replace(archive)


def main() -> None:
    match sys.argv[1:]:
        case ["--sums", *files] if files:
            for file in files:
                print(f"{hashlib.sha256(pathlib.Path(file).read_bytes()).hexdigest()}  {file}")
        case [folder, archive]:
            pack(pathlib.Path(folder), pathlib.Path(archive))
        case _:
            sys.exit(__doc__)


if __name__ == "__main__":
    main()
