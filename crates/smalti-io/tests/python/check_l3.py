"""Opens a learned table (safetensors), its .npz and statistics and prints what is in them as JSON: one object per file."""

import json
import struct
import sys

import numpy as np
from blake3 import blake3
from safetensors import safe_open


def shown(arrays):
    return {
        name: {"dtype": str(a.dtype), "shape": list(a.shape), "values": np.where(np.isinf(a), 0, a).ravel().tolist()}
        for name, a in arrays.items()
    }


def parsed(text):
    try:
        return json.loads(text)
    except ValueError:
        return text


def hash_of(metadata, arrays):
    """As docs/formats-l3.md defines it."""
    h = blake3()

    def put(piece):
        h.update(struct.pack("<Q", len(piece)))
        h.update(piece)

    for key in sorted(metadata):
        if key != "blake3":
            put(key.encode())
            put(metadata[key].encode())
    for name in sorted(arrays):
        a = arrays[name]
        put(name.encode())
        put((a.dtype.kind.upper() + str(8 * a.itemsize)).encode())
        put(b"".join(struct.pack("<Q", n) for n in a.shape))
        put(a.tobytes())
    return h.hexdigest()


for path in sys.argv[1:]:
    if path.endswith(".npz"):
        with np.load(path) as z:
            arrays = {name: z[name] for name in z.files if name != "metadata"}
            seen = {"arrays": shown(arrays), "metadata": json.loads(str(z["metadata"]))}
    else:
        with safe_open(path, framework="np") as f:
            arrays = {name: f.get_tensor(name) for name in f.keys()}
            metadata = f.metadata()
        seen = {
            "arrays": shown(arrays),
            "metadata": {key: parsed(value) for key, value in metadata.items()},
            "hash_is_right": hash_of(metadata, arrays) == metadata["blake3"],
        }
    print(json.dumps(seen))
