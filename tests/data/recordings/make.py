"""Writes the recordings in this folder with NumPy, SciPy, pyarrow, rosbags and mcap.

Every file holds the same table, which the tests compute again:
    t = k / 100,  position = (j + 1) k / 64,  velocity = (j + 1) / 2 + k / 128,  effort = k % 7 - 3 + j / 4
for sample k = 0 .. 39 and the joints j = 0 (shoulder) and 1 (elbow).

    pip install numpy scipy pyarrow rosbags mcap && python make.py
"""

import shutil
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import scipy.io
from mcap.writer import CompressionType
from mcap.writer import Writer as McapWriter
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin
from rosbags.rosbag2 import Writer as Writer2
from rosbags.typesys import Stores, get_typestore

HERE = Path(__file__).parent
SAMPLES, JOINTS = 40, ["shoulder", "elbow"]
START = 1_700_000_000_000_000_000  # ns
LATE = 2_500_000  # ns from measurement to recording
JOINT_STATE = "sensor_msgs/msg/JointState"

k = np.arange(SAMPLES)[:, None]
j = np.arange(2)[None, :]
T = k[:, 0] / 100
Q = (j + 1) * k / 64
DQ = (j + 1) / 2 + k / 128
I = k % 7 - 3 + j / 4


def arrays():
    np.savez(HERE / "plain.npz", t=T, q=Q, dq=DQ, i=I)
    np.savez_compressed(
        HERE / "deflated.npz",
        t=T.astype(">f8"),
        q=np.asfortranarray(Q.astype("f4")),
        dq=DQ.T,
        i=(4 * I).astype("i2"),
        rate=np.float64(100),
        label=np.array(["run", "1"]),
        cube=np.zeros((2, 2, 2)),
    )
    scipy.io.savemat(HERE / "plain.mat", {"t": T[:, None], "q": Q, "dq": DQ, "i": I, "rate": 100.0})
    run = {"t": T, "q": Q.astype("f4"), "dq": DQ.T, "i": (4 * I).astype("i2"), "note": "text"}
    scipy.io.savemat(HERE / "structure.mat", {"run": run, "cell": np.array([1, "a"], dtype=object)}, do_compression=True)


def tables():
    columns = {"t": T}
    for n, name in enumerate(JOINTS):
        columns |= {f"{name}_position": Q[:, n], f"dq_{name}": DQ[:, n], f"i_{name}": I[:, n]}
    plain = pa.table(columns)
    for compression in ["none", "snappy", "gzip", "lz4", "zstd", "brotli"]:
        pq.write_table(plain, HERE / f"{compression}.parquet", compression=compression)
    stamps = pa.array(START + np.arange(SAMPLES) * 10_000_000, pa.timestamp("ns"))
    typed = plain.set_column(0, "t", stamps)
    typed = typed.set_column(1, "shoulder_position", pa.array(Q[:, 0].astype("f4")))
    typed = typed.append_column("count", pa.array([*range(SAMPLES - 1), None], pa.uint32()))
    typed = typed.append_column("label", pa.array(["x"] * SAMPLES))
    typed = typed.append_column("list", pa.array([[1.0, 2.0]] * SAMPLES))
    pq.write_table(typed, HERE / "typed.parquet", row_group_size=16, use_dictionary=["label"], version="2.6")


def joint_state(store, n, names=JOINTS, order=(0, 1), stamped=True):
    types = store.types
    Header, Time = types["std_msgs/msg/Header"], types["builtin_interfaces/msg/Time"]
    stamp = START + n * 10_000_000 if stamped else 0
    header = {"stamp": Time(sec=stamp // 10**9, nanosec=stamp % 10**9), "frame_id": "base"}
    if "seq" in Header.__dataclass_fields__:
        header["seq"] = n
    pick = list(order)
    return types[JOINT_STATE](
        header=Header(**header),
        name=[names[m] for m in pick],
        position=Q[n, pick],
        velocity=DQ[n, pick],
        effort=I[n, pick].astype("f8"),
    )


def ros1(name, compression=None):
    store = get_typestore(Stores.ROS1_NOETIC)
    path = HERE / name
    path.unlink(missing_ok=True)
    writer = Writer1(path)
    if compression:
        writer.set_compression(compression)
    with writer:
        states = writer.add_connection("/joint_states", JOINT_STATE, typestore=store)
        text = writer.add_connection("/note", "std_msgs/msg/String", typestore=store)
        note = store.serialize_ros1(store.types["std_msgs/msg/String"](data="hello"), "std_msgs/msg/String")
        for n in range(SAMPLES):
            logged = START + n * 10_000_000 + LATE
            writer.write(text, logged, note)
            # The order of the joints changes from message to message.
            order = (0, 1) if n % 3 else (1, 0)
            message = joint_state(store, n, order=order)
            writer.write(states, logged, store.serialize_ros1(message, JOINT_STATE))


def ros2(name, plugin, topics=("/joint_states",), mode=None, stamped=True):
    store = get_typestore(Stores.ROS2_HUMBLE)
    folder = HERE / "bag"
    shutil.rmtree(folder, ignore_errors=True)
    writer = Writer2(folder, version=9, storage_plugin=plugin)
    if mode:
        writer.set_compression(mode, CompressionFormat.ZSTD)
    with writer:
        states = [writer.add_connection(t, JOINT_STATE, typestore=store) for t in topics]
        for n in range(SAMPLES):
            logged = START + n * 10_000_000 + LATE
            order = (0, 1) if n % 3 else (1, 0)
            message = joint_state(store, n, order=order, stamped=stamped)
            for connection in states:
                writer.write(connection, logged, store.serialize_cdr(message, JOINT_STATE))
            if n % 2:
                # A gripper sends on the topic of the arm.
                finger = joint_state(store, n, names=["finger", "thumb"], stamped=stamped)
                writer.write(states[0], logged + 1, store.serialize_cdr(finger, JOINT_STATE))
    kind = "mcap" if plugin == StoragePlugin.MCAP else "db3"
    (found,) = folder.glob(f"*.{kind}")
    found.replace(HERE / name)
    shutil.rmtree(folder)


def mcap_chunks(name, compression):
    """Small chunks, and the messages of the second half before those of the first."""
    store = get_typestore(Stores.ROS2_HUMBLE)
    with open(HERE / name, "wb") as stream:
        writer = McapWriter(stream, chunk_size=1024, compression=compression)
        writer.start(profile="ros2", library="make.py")
        definition = store.generate_msgdef(JOINT_STATE, ros_version=2)[0].encode()
        schema = writer.register_schema(JOINT_STATE, "ros2msg", definition)
        channel = writer.register_channel("/joint_states", "cdr", schema)
        for n in [*range(SAMPLES // 2, SAMPLES), *range(SAMPLES // 2)]:
            logged = START + n * 10_000_000 + LATE
            data = bytes(store.serialize_cdr(joint_state(store, n), JOINT_STATE))
            writer.add_message(channel, log_time=logged, data=data, publish_time=logged)
        writer.finish()


def main():
    arrays()
    tables()
    ros1("plain.bag")
    ros1("bz2.bag", Writer1.CompressionFormat.BZ2)
    ros1("lz4.bag", Writer1.CompressionFormat.LZ4)
    ros2("plain.db3", StoragePlugin.SQLITE3)
    ros2("messages.db3", StoragePlugin.SQLITE3, mode=CompressionMode.MESSAGE)
    ros2("plain.mcap", StoragePlugin.MCAP)
    ros2("storage.mcap", StoragePlugin.MCAP, mode=CompressionMode.STORAGE)
    mcap_chunks("lz4.mcap", CompressionType.LZ4)
    mcap_chunks("zstd.mcap", CompressionType.ZSTD)
    ros2("two_topics.mcap", StoragePlugin.MCAP, topics=("/left/joint_states", "/right/joint_states"))
    ros2("unstamped.mcap", StoragePlugin.MCAP, stamped=False)


if __name__ == "__main__":
    main()
