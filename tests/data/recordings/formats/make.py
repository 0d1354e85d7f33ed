"""Writes the recordings in this folder, each as another program or setting of it leaves them.

Every file holds the same table, which the test computes again:
    t = k / 100,  position = (j + 1) k / 64,  effort = k % 7 - 3 + j / 4
for sample k = 0 .. 23 and the joints j = 0 (shoulder) and 1 (elbow).

    pip install numpy scipy pandas polars pyarrow fastavro h5py rosbags mcap mcap-ros2-support zstandard && python make.py
"""

import bz2
import csv
import gzip
import io
import shutil
import zipfile
from pathlib import Path

import h5py
import numpy as np
import pandas as pd
import polars as pl
import pyarrow as pa
import pyarrow.csv
import pyarrow.parquet as pq
import scipy.io
import zstandard
from mcap_ros2.writer import Writer as Ros2Mcap
from rosbags.rosbag1 import Writer as Bag1
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Bag2
from rosbags.typesys import Stores, get_typestore

HERE = Path(__file__).parent
SAMPLES = 24
k = np.arange(SAMPLES)[:, None]
j = np.arange(2)[None, :]
T = k[:, 0] / 100
Q = (j + 1) * k / 64
I = k % 7 - 3 + j / 4
TABLE = pd.DataFrame({"t": T, "q1": Q[:, 0], "q2": Q[:, 1], "i1": I[:, 0], "i2": I[:, 1]})
PLAIN = TABLE.to_csv(index=False)


def write(name, text, encoding="utf-8"):
    (HERE / name).write_bytes(text if isinstance(text, bytes) else text.encode(encoding))


def csv_module():
    rows = TABLE.to_numpy().tolist()
    for name, how in {
        "module_excel.csv": {"dialect": "excel"},  # CR LF
        "module_unix.csv": {"dialect": "unix"},  # every cell in quotes
        "module_tab.tsv": {"dialect": "excel-tab"},
        "module_semicolon.csv": {"delimiter": ";", "lineterminator": "\n"},
        "module_blank.txt": {"delimiter": " ", "lineterminator": "\r\n"},
    }.items():
        with open(HERE / name, "w", newline="") as file:
            writer = csv.writer(file, **how)
            writer.writerow(TABLE.columns)
            writer.writerows(rows)


def text():
    write("decimal_comma.csv", TABLE.to_csv(index=False, sep=";", decimal=","))
    write("decimal_comma_tab.tsv", TABLE.to_csv(index=False, sep="\t", decimal=","))
    write("bom_semicolon.csv", TABLE.to_csv(index=False, sep=";", decimal=",", lineterminator="\r\n"), "utf-8-sig")
    write("utf16_comma.csv", PLAIN, "utf-16")
    named = PLAIN.replace("t,q1,q2,i1,i2", "Zeit,Stärke q1,Stärke q2,Größe 1,Größe 2")
    write("latin1.csv", named, "latin-1")
    lines = PLAIN.splitlines()
    write("units_row.csv", "\n".join([lines[0], "s,rad,rad,A,A", *lines[1:]]) + "\n")
    write("units_brackets.csv", "\n".join([lines[0], "[s],[rad],[rad],[A],[A]", *lines[1:]]) + "\n")
    write("quoted_names.csv", "\n".join(['"t","q1","q2","i1","i2"', *lines[1:]]) + "\n")
    write("no_last_newline.csv", PLAIN.rstrip("\n"))
    write("trailing_comma.csv", "\n".join(line + "," for line in lines) + "\n")
    write("padded.csv", "\n".join(line.replace(",", " , ") for line in lines) + "\n")
    write("comment_head.csv", "# robot: arm2\n# operator: nobody\n" + PLAIN)
    write("exponents.csv", TABLE.to_csv(index=False, float_format="%.9e"))
    np.savetxt(HERE / "numpy_comma.csv", TABLE.to_numpy(), delimiter=",", header="t,q1,q2,i1,i2", comments="")
    np.savetxt(HERE / "numpy_headless.txt", TABLE.to_numpy(), fmt="%.8g")
    pl.from_pandas(TABLE).write_csv(HERE / "polars_tab.csv", separator="\t", quote_style="always")
    pl.from_pandas(TABLE).write_csv(HERE / "polars_scientific.csv", float_scientific=True)
    pyarrow.csv.write_csv(pa.Table.from_pandas(TABLE, preserve_index=False), HERE / "pyarrow.csv")
    extra = TABLE.assign(mode="servo", ok=True, label=[f"n{n}" for n in range(SAMPLES)])
    extra.to_csv(HERE / "text_columns.csv", index=False)


def compressed():
    (HERE / "plain.csv.gz").write_bytes(gzip.compress(PLAIN.encode(), mtime=0))
    half = PLAIN.find("\n", len(PLAIN) // 2) + 1
    parts = [gzip.compress(part.encode(), mtime=0) for part in [PLAIN[:half], PLAIN[half:]]]
    (HERE / "two_members.csv.gz").write_bytes(b"".join(parts))
    (HERE / "plain.csv.bz2").write_bytes(bz2.compress(PLAIN.encode()))
    (HERE / "plain.csv.zst").write_bytes(zstandard.compress(PLAIN.encode()))
    (HERE / "tabs.tsv.gz").write_bytes(gzip.compress(TABLE.to_csv(index=False, sep="\t").encode(), mtime=0))


def parquet():
    arrow = pa.Table.from_pandas(TABLE, preserve_index=False)
    for compression in ["snappy", "gzip", "zstd", "lz4", "brotli", "none"]:
        pq.write_table(arrow, HERE / f"arrow_{compression}.parquet", compression=compression, row_group_size=7)
    pq.write_table(arrow, HERE / "arrow_v1.parquet", version="1.0", data_page_version="1.0", use_dictionary=True)
    pq.write_table(arrow, HERE / "arrow_pages2.parquet", data_page_version="2.0", data_page_size=64)
    names = arrow.column_names
    pq.write_table(arrow, HERE / "arrow_split.parquet", use_dictionary=False, column_encoding=dict.fromkeys(names, "BYTE_STREAM_SPLIT"))
    whole = pa.table({"t": pa.array((100 * T).round().astype("i8")), **{f"q{n + 1}": pa.array((64 * Q[:, n]).astype("i4")) for n in range(2)}, **{f"i{n + 1}": pa.array((4 * I[:, n]).astype("i2")) for n in range(2)}})
    pq.write_table(whole, HERE / "integers.parquet", use_dictionary=False, column_encoding=dict.fromkeys(["t", "q1", "q2"], "DELTA_BINARY_PACKED") | dict.fromkeys(["i1", "i2"], "PLAIN"))
    pq.write_table(arrow.cast(pa.schema([(n, pa.float32() if n != "t" else pa.float64()) for n in names])), HERE / "float32.parquet")
    for zone, name in [(None, "naive"), ("UTC", "utc"), ("Europe/Berlin", "berlin")]:
        stamps = pa.array((1_700_000_000_000_000 + 10_000 * np.arange(SAMPLES)).tolist(), pa.timestamp("us", tz=zone))
        pq.write_table(arrow.set_column(0, "t", stamps), HERE / f"stamps_{name}.parquet")
    nano = pa.array((1_700_000_000_000_000_000 + 10_000_000 * np.arange(SAMPLES)).tolist(), pa.timestamp("ns"))
    pq.write_table(arrow.set_column(0, "t", nano), HERE / "stamps_ns.parquet")
    text = arrow.append_column("mode", pa.array(["servo", "hold"] * 12).dictionary_encode()).append_column("ok", pa.array([True] * SAMPLES))
    pq.write_table(text, HERE / "categories.parquet")
    indexed = TABLE.set_index(pd.Index([f"n{n}" for n in range(SAMPLES)], name="label"))
    indexed.to_parquet(HERE / "pandas_index.parquet")
    TABLE.assign(phase=pd.Categorical(["a", "b"] * 12)).to_parquet(HERE / "pandas_category.parquet", compression="zstd")
    TABLE.convert_dtypes().to_parquet(HERE / "pandas_nullable.parquet")
    pl.from_pandas(TABLE).write_parquet(HERE / "polars_zstd.parquet", compression="zstd", statistics=True)
    pl.from_pandas(TABLE).write_parquet(HERE / "polars_lz4.parquet", compression="lz4", row_group_size=10)
    states = np.column_stack([Q, I])
    episode = pa.table({
        "observation.state": pa.FixedSizeListArray.from_arrays(pa.array(states.ravel().astype("f4")), 4),
        "action": pa.FixedSizeListArray.from_arrays(pa.array(Q.ravel().astype("f4")), 2),
        "timestamp": pa.array(T.astype("f4")),
        "frame_index": pa.array(range(SAMPLES)),
        "episode_index": pa.array([0] * SAMPLES),
        "index": pa.array(range(SAMPLES)),
        "task_index": pa.array([0] * SAMPLES),
    })
    pq.write_table(episode, HERE / "lerobot_v2.parquet")  # data/chunk-000/episode_000000.parquet
    nested = pa.table({"t": pa.array(T), "state": pa.array([{"q": q.tolist(), "i": i.tolist()} for q, i in zip(Q, I)], pa.struct([("q", pa.list_(pa.float64())), ("i", pa.large_list(pa.float64()))]))})
    pq.write_table(nested, HERE / "nested.parquet")


def archives():
    np.savez(HERE / "vectors.npz", t=T, q1=Q[:, 0], q2=Q[:, 1], i1=I[:, 0], i2=I[:, 1])
    np.savez(HERE / "columns.npz", t=T[:, None], q=Q.T, i=I.T)
    np.savez_compressed(HERE / "float32.npz", t=T, q=Q.astype("f4"), i=I.astype("f4"))
    np.savez(HERE / "big_endian.npz", t=T.astype(">f8"), q=Q.astype(">f4"), i=(4 * I).astype(">i4"))
    np.savez(HERE / "objects.npz", t=T, q=Q, i=I, meta=np.array({"robot": "arm2"}, dtype=object), names=np.array(["a", "b"]))
    with zipfile.ZipFile(HERE / "python_zip.npz", "w", zipfile.ZIP_DEFLATED) as archive:  # names without .npy's folder
        for name, array in {"t": T, "q": Q, "i": I}.items():
            data = io.BytesIO()
            np.lib.format.write_array(data, array, version=(2, 0))
            archive.writestr(f"{name}.npy", data.getvalue())


def matlab():
    scipy.io.savemat(HERE / "v4.mat", {"t": T[:, None], "q": Q, "i": I}, format="4")
    scipy.io.savemat(HERE / "v5_compressed.mat", {"t": T, "q": Q, "i": I}, do_compression=True, oned_as="row")
    scipy.io.savemat(HERE / "v5_columns.mat", {n: TABLE[n].to_numpy() for n in TABLE}, oned_as="column")
    nested = {"meta": {"robot": "arm2"}, "data": {"t": T, "q": Q.astype("f4"), "i": (4 * I).astype("i2")}}
    scipy.io.savemat(HERE / "v5_nested.mat", {"log": nested}, do_compression=True)
    cells = np.empty((1, 3), dtype=object)
    cells[0] = ["servo", np.eye(2), 3]
    scipy.io.savemat(HERE / "v5_cells.mat", {"notes": cells, "t": T[:, None], "q": Q, "i": I, "flag": np.array([True])})
    scipy.io.savemat(HERE / "v5_sparse.mat", {"graph": scipy.sparse.eye(3), "t": T[:, None], "q": Q, "i": I})
    with h5py.File(HERE / "v73_by_hand.mat", "w", userblock_size=512) as file:
        file["t"], file["q"], file["i"] = T[None, :], Q.T, I.T
    head = b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(116) + bytes(8) + b"\x00\x02IM"
    with open(HERE / "v73_by_hand.mat", "r+b") as file:
        file.write(head)


def hdf5():
    with h5py.File(HERE / "lzf_free.h5", "w") as file:
        file.create_dataset("t", data=T, compression="gzip", compression_opts=9)
        file.create_dataset("q", data=Q.astype("f4"), chunks=(5, 1))
        file.create_dataset("i", data=(4 * I).astype("i4"), fletcher32=True)
    with h5py.File(HERE / "robomimic.hdf5", "w") as file:
        demo = file.create_group("data/demo_0")
        demo.attrs["num_samples"] = SAMPLES
        demo["obs/t"], demo["obs/q"], demo["obs/i"] = T, Q, I
        demo["actions"] = Q


def messages(store):
    state, header, time = (store.types[name] for name in ["sensor_msgs/msg/JointState", "std_msgs/msg/Header", "builtin_interfaces/msg/Time"])
    ros1 = "seq" in header.__dataclass_fields__
    for n in range(SAMPLES):
        stamp = time(sec=1_700_000_000, nanosec=10_000_000 * n)
        head = header(n, stamp, "") if ros1 else header(stamp, "")
        yield 1_700_000_000_000_000_000 + 10_000_000 * n, state(head, ["shoulder", "elbow"], Q[n], np.zeros(0), I[n])


def bags():
    store = get_typestore(Stores.ROS1_NOETIC)
    for name, compression in [("noetic.bag", None), ("noetic_bz2.bag", Bag1.CompressionFormat.BZ2), ("noetic_lz4.bag", Bag1.CompressionFormat.LZ4)]:
        path = HERE / name
        path.unlink(missing_ok=True)
        bag = Bag1(path)
        if compression:
            bag.set_compression(compression)
        with bag:
            topic = bag.add_connection("/joint_states", "sensor_msgs/msg/JointState", typestore=store)
            for at, message in messages(store):
                bag.write(topic, at, store.serialize_ros1(message, "sensor_msgs/msg/JointState"))
    for distribution in ["FOXY", "HUMBLE", "JAZZY"]:
        store = get_typestore(Stores[f"ROS2_{distribution}"])
        for plugin, extension in [(StoragePlugin.SQLITE3, "db3"), (StoragePlugin.MCAP, "mcap")]:
            folder = HERE / "bag"
            shutil.rmtree(folder, ignore_errors=True)
            with Bag2(folder, version=8, storage_plugin=plugin) as bag:
                topic = bag.add_connection("/joint_states", "sensor_msgs/msg/JointState", typestore=store)
                for at, message in messages(store):
                    bag.write(topic, at, store.serialize_cdr(message, "sensor_msgs/msg/JointState"))
            written = next(folder.glob(f"*.{extension}"))
            shutil.move(written, HERE / f"{distribution.lower()}.{extension}")
            shutil.rmtree(folder)
    definition = "string[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort\n"
    definition = f"std_msgs/Header header\n{definition}" + "=" * 80 + "\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n" + "=" * 80 + "\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n"
    with open(HERE / "mcap_ros2.mcap", "wb") as file:
        writer = Ros2Mcap(file)
        schema = writer.register_msgdef("sensor_msgs/msg/JointState", definition)
        for n in range(SAMPLES):
            at = 1_700_000_000_000_000_000 + 10_000_000 * n
            header = {"stamp": {"sec": 1_700_000_000, "nanosec": 10_000_000 * n}, "frame_id": ""}
            message = {"header": header, "name": ["shoulder", "elbow"], "position": Q[n].tolist(), "velocity": [], "effort": I[n].tolist()}
            writer.write_message("/joint_states", schema, message, log_time=at, publish_time=at)
        writer.finish()


for part in [csv_module, text, compressed, parquet, archives, matlab, hdf5, bags]:
    part()
