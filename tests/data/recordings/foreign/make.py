"""Writes the recordings in this folder with pandas, polars, NumPy, SciPy, pyarrow, h5py, hdf5storage and mcap.

Every file holds the same table, which the tests compute again:
    t = k / 100,  position = (j + 1) k / 64,  effort = k % 7 - 3 + j / 4
for sample k = 0 .. 39 and the joints j = 0 and 1; files with holes lack the cells that their function names.

    pip install numpy scipy pandas polars pyarrow h5py hdf5storage && python make.py
"""

import struct
from datetime import timedelta
from pathlib import Path

import h5py
import hdf5storage
import numpy as np
import pandas as pd
import polars as pl
import pyarrow as pa
import pyarrow.parquet as pq
import scipy.io

HERE = Path(__file__).parent
k = np.arange(40)[:, None]
j = np.arange(2)[None, :]
T = k[:, 0] / 100
Q = (j + 1) * k / 64
I = k % 7 - 3 + j / 4
TABLE = pd.DataFrame({"t": T, "q1": Q[:, 0], "q2": Q[:, 1], "i1": I[:, 0], "i2": I[:, 1]})


def write(name, text, encoding="utf-8"):
    (HERE / name).write_bytes(text.encode(encoding))


def texts():
    rows = np.column_stack([T, Q, I])
    np.savetxt(HERE / "savetxt.csv", rows, header="t q1 q2 i1 i2")  # NumPy: blanks, the names in a comment
    np.savetxt(HERE / "percent.csv", rows, header="t, q1, q2, i1, i2", comments="% ", delimiter=",")
    units = "made by a controller\nt q1 q2 i1 i2\ns rad rad A A"
    np.savetxt(HERE / "matlab.csv", rows, header=units, comments="% ", delimiter="\t")
    lines = TABLE.to_csv(index=False).splitlines()
    lines[5:5] = ["# the brake was released here", "// and this is said twice"]
    write("comments.csv", "// a log\n//\n" + "\n".join(lines) + "\n# end\n")
    write("excel_unicode.csv", TABLE.to_csv(index=False, sep="\t"), "utf-16")  # with a byte-order mark
    write("utf16_big.csv", "\ufeff" + TABLE.to_csv(index=False, sep=";", decimal=","), "utf-16-be")
    write("utf8_mark.csv", TABLE.to_csv(index=False), "utf-8-sig")
    pl.from_pandas(TABLE).write_csv(HERE / "polars.csv")
    TABLE.to_csv(HERE / "index.csv", index_label="row")
    TABLE.to_csv(HERE / "quoted.csv", index=False, quoting=2)
    TABLE.to_csv(HERE / "blanks.csv", index=False, sep=" ")


def holes():
    """Cell q1 of row 7, i2 of rows 11 and 12."""
    holed = TABLE.copy()
    holed.loc[7, "q1"] = np.nan
    holed.loc[[11, 12], "i2"] = np.nan
    holed.to_csv(HERE / "empty_cells.csv", index=False)
    holed.to_csv(HERE / "na.csv", index=False, na_rep="NA")
    holed.to_csv(HERE / "spreadsheet.csv", index=False, sep=";", decimal=",", na_rep="#N/A")
    text = holed.to_csv(index=False) + ",,,,\n" * 3  # rows that a spreadsheet keeps
    write("empty_end.csv", text)
    pl.from_pandas(holed).write_csv(HERE / "polars_null.csv", null_value="null")
    pl.from_pandas(holed).write_parquet(HERE / "polars_null.parquet")
    pq.write_table(pa.Table.from_pandas(holed), HERE / "pandas_null.parquet")
    np.savez(HERE / "nan.npz", **{name: holed[name].to_numpy() for name in holed})
    scipy.io.savemat(HERE / "nan.mat", {name: holed[name].to_numpy() for name in holed})


def tables():
    lists = {"timestamp": pa.array(T.astype("f4")), "frame_index": pa.array(range(40))}
    state = np.column_stack([Q, I]).astype("f4").tolist()
    lists["observation.state"] = pa.array(state, pa.list_(pa.float32()))
    lists["action"] = pa.array(Q.tolist(), pa.list_(pa.float32(), 2))
    lists["next.done"] = pa.array([False] * 40)
    pq.write_table(pa.table(lists), HERE / "lerobot.parquet")
    fixed = {"time": pa.array([timedelta(milliseconds=10 * n) for n in range(40)], pa.duration("us"))}
    fixed |= {name: pa.array(TABLE[name]) for name in ["q1", "q2", "i1", "i2"]}
    pq.write_table(pa.table(fixed), HERE / "duration.parquet")
    holed = [None if n == 7 else row for n, row in enumerate(state)]
    holed = {"t": pa.array(T), "s": pa.array(holed, pa.list_(pa.float32()))}
    pq.write_table(pa.table(holed), HERE / "null_list.parquet", row_group_size=16)


def arrays():
    """MATLAB keeps arrays column by column, HDF5 row by row: hdf5storage writes as `save -v7.3` does."""
    data = {"t": T[:, None], "q": Q, "i": I, "label": "run", "run": {"q": Q, "i": (4 * I).astype("i2")}}
    hdf5storage.savemat(str(HERE / "v73.mat"), data, format="7.3", store_python_metadata=False)
    with h5py.File(HERE / "groups.h5", "w") as file:
        file["t"] = T
        arm = file.create_group("arm")
        arm.create_dataset("q", data=Q, chunks=(16, 2), compression="gzip", shuffle=True)
        arm.create_dataset("i", data=I.astype(">f4"), chunks=(8, 1), fletcher32=True)
        file["names"] = ["a", "b"]
    with h5py.File(HERE / "latest.hdf5", "w", libver="latest") as file:
        file.create_dataset("t", data=T, maxshape=(None,), chunks=(16,))
        file["q"], file["i"] = Q.T, I
    scipy.io.savemat(HERE / "object.mat", {"t": T[:, None], "q": Q, "i": I})
    with open(HERE / "object.mat", "ab") as file:
        file.write(opaque("log", "datetime"))


def opaque(name, kind):
    """An object as MATLAB writes it: flags, name, system, class, and an array that refers to its content."""

    def element(tag, data):
        return struct.pack("<II", tag, len(data)) + data + bytes(-len(data) % 8)

    def text(word):
        return element(1, word.encode())

    flags = element(6, struct.pack("<II", 13, 0))
    content = flags + element(5, struct.pack("<ii", 6, 1)) + text("") + element(6, struct.pack("<6I", 0xDD000000, 2, 1, 1, 1, 1))
    inner = element(6, struct.pack("<II", 17, 0)) + text(name) + text("MCOS") + text(kind) + element(14, content)
    return element(14, inner)


texts()
holes()
tables()
arrays()
