"""Reads a folder of Parquet files with one program. Prints the names of the columns and the unit of one, then row after row,
all as JSON."""

import json
import math
import pathlib
import sys

program, folder = sys.argv[1:]
KEY = "smalti.schema"


def plain(value):
    if value is None or isinstance(value, (str, int)):
        return value
    if hasattr(value, "__len__"):
        return [plain(v) for v in value]
    value = float(value)
    if math.isnan(value):
        return None
    return value if math.isfinite(value) else str(value)


if program == "pandas":
    import pandas
    import pyarrow.parquet

    table = pandas.read_parquet(folder)
    assert [str(t) for t in table.dtypes[:3]] == ["int64", "int64", "float64"], table.dtypes
    assert table["delta_e"].isna().sum() == sum(i % 7 == 0 for i in range(len(table)))
    names = list(table.columns)
    rows = [[row[0].item() if hasattr(row[0], "item") else row[0], *row[1:]] for row in table.itertuples(index=False)]
    first = sorted(pathlib.Path(folder).iterdir())[0]
    schema = pyarrow.parquet.read_metadata(first).metadata[KEY.encode()].decode()
elif program == "polars":
    import polars

    table = polars.read_parquet(folder)
    assert table.schema["centers_nm"] == polars.List(polars.Float64), table.schema
    assert table["delta_e"].null_count() == sum(i % 7 == 0 for i in range(len(table)))
    names, rows = table.columns, table.rows()
    schema = polars.read_parquet_metadata(sorted(pathlib.Path(folder).iterdir())[0])[KEY]
else:
    import duckdb

    files = f"{folder}/*.parquet"
    relation = duckdb.sql(f"SELECT * FROM '{files}' ORDER BY trial")
    assert [str(t) for t in relation.types] == ["BIGINT", "BIGINT", "DOUBLE", "VARCHAR", "DOUBLE[]"], relation.types
    names, rows = relation.columns, relation.fetchall()
    pairs = duckdb.sql(f"SELECT DISTINCT key, value FROM parquet_kv_metadata('{files}')").fetchall()
    (schema,) = [value.decode() for key, value in pairs if key.decode() == KEY]

unit = next(c["unit"] for c in json.loads(schema) if c["name"] == "delta_e")
print(json.dumps({"names": names, "unit": unit}))
for row in rows:
    print(json.dumps([plain(v) for v in row]))
