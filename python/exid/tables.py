"""The tables of a problem, key by key. Written by `python/tables` from the schema of problem files."""

from __future__ import annotations

from typing import Any, Literal, TypedDict, Union

__all__ = [
    "ControllerTable",
    "DesignTable",
    "DiagnoseTable",
    "DriveTable",
    "FitTable",
    "RecordingsTable",
    "RobotTable",
    "SimulateTable",
]


class RobotH4Table(TypedDict, total=False):
    """Lengths of the parallel robot H4. Default: none."""

    lever: float
    """Length of a lever, l. Unit: m. Required."""
    rod: float
    """Length of a rod, L. Unit: m. Required."""
    half_bar: float
    """Half of the bar between two rods, h. Unit: m. Required."""
    half_width: float
    """Half of the platform's width, d. Unit: m. Required."""
    radius: float
    """From where the levers would meet the platform at rest to the motors, R. Unit: m. Required."""


class RobotClosedTable(TypedDict, total=False):
    """Keys of the table."""

    frames: list[str]
    """Links or fixed frames on both sides of the cut; their origins are the joint's centres. Required."""
    joint: Literal["hinge", "ball", "rod"]
    """Kind of joint: one axis, a ball, or a massless rod with a ball at both ends. Default: "hinge"."""
    axis: list[float]
    """Axis of a hinge, in both frames. Default: [0.0, 0.0, 1.0]."""
    length: float
    """Length of a rod. Unit: m. Default: none; required for a rod."""


class RobotTable(TypedDict, total=False):
    """The kinematics, what is known of it, and what is to be estimated. Required."""

    urdf: str
    """Robot description (URDF). Default: one of urdf, mjcf, mdh and mechanism is required."""
    mdh: str
    """Table of modified Denavit-Hartenberg parameters (TOML). Default: one of urdf, mjcf, mdh and mechanism is required."""
    mjcf: str
    """Model of MuJoCo (MJCF), with what it says of gravity and drives. Default: one of urdf, mjcf, mdh and mechanism is required."""
    mechanism: Literal["h4"]
    """A mechanism whose kinematics is built in, with its lengths in a table of its name. Default: one of urdf, mjcf, mdh and mechanism is required."""
    gravity: list[float]
    """Gravity in the base frame. Unit: m/s². Default: that of the robot file, or [0.0, 0.0, -9.81]."""
    joints: list[str]
    """Order of the joints in every list with one value per joint. Default: the order of the robot file."""
    locked: dict[str, float]
    """Joints that do not move, and where they stand. Unit: rad (m). Default: none."""
    inertials: Literal["estimate", "known"]
    """Whether link parameters are unknown, or taken from the robot file. Default: "estimate"."""
    zero: list[str]
    """Parameters that are zero by construction and not estimated. Default: none."""
    parameters: str
    """Result of an earlier fit: its values, with its covariance as prior. Default: none."""
    payload: str
    """Ten unknown parameters of a load, on the last moving link ("last") or on a named link or fixed frame. Default: no load."""
    h4: RobotH4Table
    """Lengths of the parallel robot H4. Default: none."""
    passive: dict[str, float]
    """Joints without a motor, which closed joints hold, and positions near which the loops close. Unit: rad (m). Default: none."""
    closed: list[RobotClosedTable]
    """A joint that closes a loop of the robot file's tree. Default: none."""


class DriveSharedTable(TypedDict, total=False):
    """Keys of the table."""

    joints: list[str]
    """Two joints or more whose motors are of one type. Required."""
    effects: list[Union[Literal["coulomb_friction", "viscous_friction", "asymmetric_friction", "stribeck_friction", "viscous_nonlinearity", "sigmoid_friction", "presliding_hysteresis", "position_dependent_friction", "transmission_efficiency", "load_dependent_friction", "torque_current_nonlinearity", "drive_gain", "torque_offset", "rotor_inertia", "kinematic_coupling", "joint_elasticity", "backlash", "torque_ripple", "joint_spring", "unmodelled_payload", "base_tilt", "encoder_offset", "time_delay", "channel_crosstalk", "thermal_drift", "external_contact"], str]]
    """Effects whose parameters are one unknown for all of the joints; the recordings are asked whether they refuse that. Default: none: every joint has its own parameters, and what could be shared is proposed."""
    separate: list[str]
    """Parameters of these effects that every joint has for itself. Default: none."""


class DriveRotorsTable(TypedDict, total=False):
    """Keys of the table."""

    link: str
    """Link or fixed frame that carries the motor. Required."""
    axis: list[float]
    """Axis about which it spins where the motor turns forwards, in that frame. Required."""
    inertia: float
    """Its own inertia about its axis, at the motor side. Unit: kg·m². Required."""


class DriveTable(TypedDict, total=False):
    """The motors, what is known of them, and the physics between motor and joint; lists have one value per joint and belong to the motor with that joint's index. Default: a rigid body without losses."""

    torque_constant: Union[float, list[float]]
    """Torque constant at the joint side: motor constant times ratio. Unit: N·m/A (N/A). Default: none, as for signals that are torques."""
    torque_constant_std: Union[float, list[float]]
    """Relative standard deviations of the torque constants, or of the torques that the polynomials give; part of every interval. Default: none: the constants are certain."""
    current_polynomial: list[list[float]]
    """Instead of torque_constant: torque at the joint side in powers of the current, sign(i)·(c0 + c1·|i| + c2·i² + c3·|i|³). Unit: N·m/A^k (N/A^k). Default: none."""
    rotor_inertia: Union[float, list[float]]
    """Inertia of rotor and gear, reflected to the joint. Unit: kg·m² (kg). Default: none; estimated if "rotor_inertia" is among the effects."""
    ratio: Union[float, list[float]]
    """Motor turns per joint turn, signed. Default: none."""
    offset: Union[float, list[float]]
    """Joint position where the motor stands at zero: q = V·(q_enc / ratio) + offset. Unit: rad (m). Default: none."""
    coupling: list[list[float]]
    """V, a square matrix by rows: joint speeds = V·(motor speeds / ratio). Default: the identity."""
    effects: list[Union[Literal["coulomb_friction", "viscous_friction", "asymmetric_friction", "stribeck_friction", "viscous_nonlinearity", "sigmoid_friction", "presliding_hysteresis", "position_dependent_friction", "transmission_efficiency", "load_dependent_friction", "torque_current_nonlinearity", "drive_gain", "torque_offset", "rotor_inertia", "kinematic_coupling", "joint_elasticity", "backlash", "torque_ripple", "joint_spring", "unmodelled_payload", "base_tilt", "encoder_offset", "time_delay", "channel_crosstalk", "thermal_drift", "external_contact"], str]]
    """Physics in the model, for all joints; `exid effects` lists it. Default: none."""
    effects_of: dict[str, list[Union[Literal["coulomb_friction", "viscous_friction", "asymmetric_friction", "stribeck_friction", "viscous_nonlinearity", "sigmoid_friction", "presliding_hysteresis", "position_dependent_friction", "transmission_efficiency", "load_dependent_friction", "torque_current_nonlinearity", "drive_gain", "torque_offset", "rotor_inertia", "kinematic_coupling", "joint_elasticity", "backlash", "torque_ripple", "joint_spring", "unmodelled_payload", "base_tilt", "encoder_offset", "time_delay", "channel_crosstalk", "thermal_drift", "external_contact"], str]]]
    """What replaces the list of effects on single joints. Default: none."""
    values: dict[str, float]
    """Parameters of the model with known values. Unit: each parameter's own. Default: none."""
    shared: list[DriveSharedTable]
    """Joints with motors of one type, and the effects whose parameters are the same on all of them. Default: none."""
    rotors: dict[str, DriveRotorsTable]
    """Spinning part of a joint's motor, which a base wrench feels. Default: none."""


class RecordingsTrainFilesColumnsTimeTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Literal["s", "ms", "us", "ns", "min"]
    """Unit of the stamps. Default: SI."""


class RecordingsTrainFilesColumnsPositionTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Union[Literal["rad", "mrad", "deg", "rev", "m", "cm", "mm", "um", "count"], list[Literal["rad", "mrad", "deg", "rev", "m", "cm", "mm", "um", "count"]]]
    """One for all joints, or one for each. Default: SI."""
    per_turn: float
    """Counts in a turn, for the unit "count". Default: none."""


class RecordingsTrainFilesColumnsVelocityTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Union[Literal["rad/s", "deg/s", "rev/s", "rpm", "m/s", "mm/s"], list[Literal["rad/s", "deg/s", "rev/s", "rpm", "m/s", "mm/s"]]]
    """One for all joints, or one for each. Default: SI."""


class RecordingsTrainFilesColumnsAccelerationTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Union[Literal["rad/s^2", "deg/s^2", "rev/s^2", "m/s^2", "mm/s^2"], list[Literal["rad/s^2", "deg/s^2", "rev/s^2", "m/s^2", "mm/s^2"]]]
    """One for all joints, or one for each. Default: SI."""


class RecordingsTrainFilesColumnsCurrentTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Union[Literal["A", "mA", "kA"], list[Literal["A", "mA", "kA"]]]
    """One for all joints, or one for each. Default: SI."""


class RecordingsTrainFilesColumnsTorqueTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Union[Literal["Nm", "mNm", "Ncm", "kNm", "N", "mN", "kN"], list[Literal["Nm", "mNm", "Ncm", "kNm", "N", "mN", "kN"]]]
    """One for all joints, or one for each. Default: SI."""


class RecordingsTrainFilesColumnsCommandTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Union[Literal["rad", "mrad", "deg", "rev", "m", "cm", "mm", "um", "count"], list[Literal["rad", "mrad", "deg", "rev", "m", "cm", "mm", "um", "count"]]]
    """One for all joints, or one for each. Default: SI."""
    per_turn: float
    """Counts in a turn, for the unit "count". Default: none."""


class RecordingsTrainFilesColumnsVelocityCommandTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Union[Literal["rad/s", "deg/s", "rev/s", "rpm", "m/s", "mm/s"], list[Literal["rad/s", "deg/s", "rev/s", "rpm", "m/s", "mm/s"]]]
    """One for all joints, or one for each. Default: SI."""


class RecordingsTrainFilesColumnsFeedForwardTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Union[Literal["Nm", "mNm", "Ncm", "kNm", "N", "mN", "kN"], list[Literal["Nm", "mNm", "Ncm", "kNm", "N", "mN", "kN"]]]
    """One for all joints, or one for each. Default: SI."""


class RecordingsTrainFilesColumnsTemperatureTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, a number from 1, or a list of either, one for each joint. Required."""


class RecordingsTrainFilesColumnsMaskTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, a number from 1, or a list of either, one for each joint. Required."""


class RecordingsTrainFilesColumnsTable(TypedDict, total=False):
    """What its columns are called. Default: those of the recording."""

    time: Union[str, RecordingsTrainFilesColumnsTimeTable]
    """Time stamps. Unit: s. Default: "t" or "time"."""
    position: Union[str, RecordingsTrainFilesColumnsPositionTable]
    """Positions, or the motor's turns where position_side is "motor". Unit: rad (m). Default: the usual names."""
    velocity: Union[str, RecordingsTrainFilesColumnsVelocityTable]
    """Velocities of the joints, by sensors or by the controller. Unit: rad/s (m/s). Default: the usual names, if there."""
    acceleration: Union[str, RecordingsTrainFilesColumnsAccelerationTable]
    """Accelerations of the joints. Unit: rad/s² (m/s²). Default: the usual names, if there."""
    current: Union[str, RecordingsTrainFilesColumnsCurrentTable]
    """Motor currents. Unit: A. Default: the usual names."""
    torque: Union[str, RecordingsTrainFilesColumnsTorqueTable]
    """Torques, on the side of the gear that recordings.signal says. Unit: N·m (N). Default: the usual names."""
    command: Union[str, RecordingsTrainFilesColumnsCommandTable]
    """Commanded positions, for the signal "position_command". Unit: rad (m). Default: the usual names."""
    velocity_command: Union[str, RecordingsTrainFilesColumnsVelocityCommandTable]
    """Commanded speeds. Unit: rad/s (m/s). Default: the usual names, if there; otherwise the controller damps the speed itself."""
    feed_forward: Union[str, RecordingsTrainFilesColumnsFeedForwardTable]
    """Torques at the joint side that the controller adds. Unit: N·m (N). Default: the usual names, if there."""
    wrench: list[str]
    """Forces along x, y, z, then moments. Unit: N, N·m. Default: fx, fy, fz, mx, my and mz."""
    temperature: Union[str, RecordingsTrainFilesColumnsTemperatureTable]
    """Temperatures of the drives. Unit: °C. Default: the usual names, if there."""
    mask: Union[str, RecordingsTrainFilesColumnsMaskTable]
    """Samples with 0 are left out. Default: every sample counts."""


class RecordingsTrainFilesTable(TypedDict, total=False):
    """Keys of the table."""

    file: str
    """One of the files. Required."""
    columns: RecordingsTrainFilesColumnsTable
    """What its columns are called. Default: those of the recording."""


class RecordingsTrainColumnsTimeTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Literal["s", "ms", "us", "ns", "min"]
    """Unit of the stamps. Default: SI."""


class RecordingsTrainColumnsPositionTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Union[Literal["rad", "mrad", "deg", "rev", "m", "cm", "mm", "um", "count"], list[Literal["rad", "mrad", "deg", "rev", "m", "cm", "mm", "um", "count"]]]
    """One for all joints, or one for each. Default: SI."""
    per_turn: float
    """Counts in a turn, for the unit "count". Default: none."""


class RecordingsTrainColumnsVelocityTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Union[Literal["rad/s", "deg/s", "rev/s", "rpm", "m/s", "mm/s"], list[Literal["rad/s", "deg/s", "rev/s", "rpm", "m/s", "mm/s"]]]
    """One for all joints, or one for each. Default: SI."""


class RecordingsTrainColumnsAccelerationTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Union[Literal["rad/s^2", "deg/s^2", "rev/s^2", "m/s^2", "mm/s^2"], list[Literal["rad/s^2", "deg/s^2", "rev/s^2", "m/s^2", "mm/s^2"]]]
    """One for all joints, or one for each. Default: SI."""


class RecordingsTrainColumnsCurrentTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Union[Literal["A", "mA", "kA"], list[Literal["A", "mA", "kA"]]]
    """One for all joints, or one for each. Default: SI."""


class RecordingsTrainColumnsTorqueTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Union[Literal["Nm", "mNm", "Ncm", "kNm", "N", "mN", "kN"], list[Literal["Nm", "mNm", "Ncm", "kNm", "N", "mN", "kN"]]]
    """One for all joints, or one for each. Default: SI."""


class RecordingsTrainColumnsCommandTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Union[Literal["rad", "mrad", "deg", "rev", "m", "cm", "mm", "um", "count"], list[Literal["rad", "mrad", "deg", "rev", "m", "cm", "mm", "um", "count"]]]
    """One for all joints, or one for each. Default: SI."""
    per_turn: float
    """Counts in a turn, for the unit "count". Default: none."""


class RecordingsTrainColumnsVelocityCommandTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Union[Literal["rad/s", "deg/s", "rev/s", "rpm", "m/s", "mm/s"], list[Literal["rad/s", "deg/s", "rev/s", "rpm", "m/s", "mm/s"]]]
    """One for all joints, or one for each. Default: SI."""


class RecordingsTrainColumnsFeedForwardTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Union[Literal["Nm", "mNm", "Ncm", "kNm", "N", "mN", "kN"], list[Literal["Nm", "mNm", "Ncm", "kNm", "N", "mN", "kN"]]]
    """One for all joints, or one for each. Default: SI."""


class RecordingsTrainColumnsTemperatureTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, a number from 1, or a list of either, one for each joint. Required."""


class RecordingsTrainColumnsMaskTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, a number from 1, or a list of either, one for each joint. Required."""


class RecordingsTrainColumnsTable(TypedDict, total=False):
    """What its columns are called. Default: those of recordings.columns."""

    time: Union[str, RecordingsTrainColumnsTimeTable]
    """Time stamps. Unit: s. Default: "t" or "time"."""
    position: Union[str, RecordingsTrainColumnsPositionTable]
    """Positions, or the motor's turns where position_side is "motor". Unit: rad (m). Default: the usual names."""
    velocity: Union[str, RecordingsTrainColumnsVelocityTable]
    """Velocities of the joints, by sensors or by the controller. Unit: rad/s (m/s). Default: the usual names, if there."""
    acceleration: Union[str, RecordingsTrainColumnsAccelerationTable]
    """Accelerations of the joints. Unit: rad/s² (m/s²). Default: the usual names, if there."""
    current: Union[str, RecordingsTrainColumnsCurrentTable]
    """Motor currents. Unit: A. Default: the usual names."""
    torque: Union[str, RecordingsTrainColumnsTorqueTable]
    """Torques, on the side of the gear that recordings.signal says. Unit: N·m (N). Default: the usual names."""
    command: Union[str, RecordingsTrainColumnsCommandTable]
    """Commanded positions, for the signal "position_command". Unit: rad (m). Default: the usual names."""
    velocity_command: Union[str, RecordingsTrainColumnsVelocityCommandTable]
    """Commanded speeds. Unit: rad/s (m/s). Default: the usual names, if there; otherwise the controller damps the speed itself."""
    feed_forward: Union[str, RecordingsTrainColumnsFeedForwardTable]
    """Torques at the joint side that the controller adds. Unit: N·m (N). Default: the usual names, if there."""
    wrench: list[str]
    """Forces along x, y, z, then moments. Unit: N, N·m. Default: fx, fy, fz, mx, my and mz."""
    temperature: Union[str, RecordingsTrainColumnsTemperatureTable]
    """Temperatures of the drives. Unit: °C. Default: the usual names, if there."""
    mask: Union[str, RecordingsTrainColumnsMaskTable]
    """Samples with 0 are left out. Default: every sample counts."""


class RecordingsTrainTable(TypedDict, total=False):
    """Keys of the table."""

    file: str
    """The file of the recording. Default: none; this or files is required."""
    files: list[Union[str, RecordingsTrainFilesTable]]
    """Files that are joined by their time stamps, on the clock of the first. Default: none; this or file is required."""
    columns: RecordingsTrainColumnsTable
    """What its columns are called. Default: those of recordings.columns."""


class RecordingsValidationFilesColumnsTimeTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Literal["s", "ms", "us", "ns", "min"]
    """Unit of the stamps. Default: SI."""


class RecordingsValidationFilesColumnsPositionTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Union[Literal["rad", "mrad", "deg", "rev", "m", "cm", "mm", "um", "count"], list[Literal["rad", "mrad", "deg", "rev", "m", "cm", "mm", "um", "count"]]]
    """One for all joints, or one for each. Default: SI."""
    per_turn: float
    """Counts in a turn, for the unit "count". Default: none."""


class RecordingsValidationFilesColumnsVelocityTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Union[Literal["rad/s", "deg/s", "rev/s", "rpm", "m/s", "mm/s"], list[Literal["rad/s", "deg/s", "rev/s", "rpm", "m/s", "mm/s"]]]
    """One for all joints, or one for each. Default: SI."""


class RecordingsValidationFilesColumnsAccelerationTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Union[Literal["rad/s^2", "deg/s^2", "rev/s^2", "m/s^2", "mm/s^2"], list[Literal["rad/s^2", "deg/s^2", "rev/s^2", "m/s^2", "mm/s^2"]]]
    """One for all joints, or one for each. Default: SI."""


class RecordingsValidationFilesColumnsCurrentTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Union[Literal["A", "mA", "kA"], list[Literal["A", "mA", "kA"]]]
    """One for all joints, or one for each. Default: SI."""


class RecordingsValidationFilesColumnsTorqueTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Union[Literal["Nm", "mNm", "Ncm", "kNm", "N", "mN", "kN"], list[Literal["Nm", "mNm", "Ncm", "kNm", "N", "mN", "kN"]]]
    """One for all joints, or one for each. Default: SI."""


class RecordingsValidationFilesColumnsCommandTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Union[Literal["rad", "mrad", "deg", "rev", "m", "cm", "mm", "um", "count"], list[Literal["rad", "mrad", "deg", "rev", "m", "cm", "mm", "um", "count"]]]
    """One for all joints, or one for each. Default: SI."""
    per_turn: float
    """Counts in a turn, for the unit "count". Default: none."""


class RecordingsValidationFilesColumnsVelocityCommandTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Union[Literal["rad/s", "deg/s", "rev/s", "rpm", "m/s", "mm/s"], list[Literal["rad/s", "deg/s", "rev/s", "rpm", "m/s", "mm/s"]]]
    """One for all joints, or one for each. Default: SI."""


class RecordingsValidationFilesColumnsFeedForwardTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Union[Literal["Nm", "mNm", "Ncm", "kNm", "N", "mN", "kN"], list[Literal["Nm", "mNm", "Ncm", "kNm", "N", "mN", "kN"]]]
    """One for all joints, or one for each. Default: SI."""


class RecordingsValidationFilesColumnsTemperatureTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, a number from 1, or a list of either, one for each joint. Required."""


class RecordingsValidationFilesColumnsMaskTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, a number from 1, or a list of either, one for each joint. Required."""


class RecordingsValidationFilesColumnsTable(TypedDict, total=False):
    """What its columns are called. Default: those of the recording."""

    time: Union[str, RecordingsValidationFilesColumnsTimeTable]
    """Time stamps. Unit: s. Default: "t" or "time"."""
    position: Union[str, RecordingsValidationFilesColumnsPositionTable]
    """Positions, or the motor's turns where position_side is "motor". Unit: rad (m). Default: the usual names."""
    velocity: Union[str, RecordingsValidationFilesColumnsVelocityTable]
    """Velocities of the joints, by sensors or by the controller. Unit: rad/s (m/s). Default: the usual names, if there."""
    acceleration: Union[str, RecordingsValidationFilesColumnsAccelerationTable]
    """Accelerations of the joints. Unit: rad/s² (m/s²). Default: the usual names, if there."""
    current: Union[str, RecordingsValidationFilesColumnsCurrentTable]
    """Motor currents. Unit: A. Default: the usual names."""
    torque: Union[str, RecordingsValidationFilesColumnsTorqueTable]
    """Torques, on the side of the gear that recordings.signal says. Unit: N·m (N). Default: the usual names."""
    command: Union[str, RecordingsValidationFilesColumnsCommandTable]
    """Commanded positions, for the signal "position_command". Unit: rad (m). Default: the usual names."""
    velocity_command: Union[str, RecordingsValidationFilesColumnsVelocityCommandTable]
    """Commanded speeds. Unit: rad/s (m/s). Default: the usual names, if there; otherwise the controller damps the speed itself."""
    feed_forward: Union[str, RecordingsValidationFilesColumnsFeedForwardTable]
    """Torques at the joint side that the controller adds. Unit: N·m (N). Default: the usual names, if there."""
    wrench: list[str]
    """Forces along x, y, z, then moments. Unit: N, N·m. Default: fx, fy, fz, mx, my and mz."""
    temperature: Union[str, RecordingsValidationFilesColumnsTemperatureTable]
    """Temperatures of the drives. Unit: °C. Default: the usual names, if there."""
    mask: Union[str, RecordingsValidationFilesColumnsMaskTable]
    """Samples with 0 are left out. Default: every sample counts."""


class RecordingsValidationFilesTable(TypedDict, total=False):
    """Keys of the table."""

    file: str
    """One of the files. Required."""
    columns: RecordingsValidationFilesColumnsTable
    """What its columns are called. Default: those of the recording."""


class RecordingsValidationColumnsTimeTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Literal["s", "ms", "us", "ns", "min"]
    """Unit of the stamps. Default: SI."""


class RecordingsValidationColumnsPositionTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Union[Literal["rad", "mrad", "deg", "rev", "m", "cm", "mm", "um", "count"], list[Literal["rad", "mrad", "deg", "rev", "m", "cm", "mm", "um", "count"]]]
    """One for all joints, or one for each. Default: SI."""
    per_turn: float
    """Counts in a turn, for the unit "count". Default: none."""


class RecordingsValidationColumnsVelocityTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Union[Literal["rad/s", "deg/s", "rev/s", "rpm", "m/s", "mm/s"], list[Literal["rad/s", "deg/s", "rev/s", "rpm", "m/s", "mm/s"]]]
    """One for all joints, or one for each. Default: SI."""


class RecordingsValidationColumnsAccelerationTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Union[Literal["rad/s^2", "deg/s^2", "rev/s^2", "m/s^2", "mm/s^2"], list[Literal["rad/s^2", "deg/s^2", "rev/s^2", "m/s^2", "mm/s^2"]]]
    """One for all joints, or one for each. Default: SI."""


class RecordingsValidationColumnsCurrentTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Union[Literal["A", "mA", "kA"], list[Literal["A", "mA", "kA"]]]
    """One for all joints, or one for each. Default: SI."""


class RecordingsValidationColumnsTorqueTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Union[Literal["Nm", "mNm", "Ncm", "kNm", "N", "mN", "kN"], list[Literal["Nm", "mNm", "Ncm", "kNm", "N", "mN", "kN"]]]
    """One for all joints, or one for each. Default: SI."""


class RecordingsValidationColumnsCommandTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Union[Literal["rad", "mrad", "deg", "rev", "m", "cm", "mm", "um", "count"], list[Literal["rad", "mrad", "deg", "rev", "m", "cm", "mm", "um", "count"]]]
    """One for all joints, or one for each. Default: SI."""
    per_turn: float
    """Counts in a turn, for the unit "count". Default: none."""


class RecordingsValidationColumnsVelocityCommandTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Union[Literal["rad/s", "deg/s", "rev/s", "rpm", "m/s", "mm/s"], list[Literal["rad/s", "deg/s", "rev/s", "rpm", "m/s", "mm/s"]]]
    """One for all joints, or one for each. Default: SI."""


class RecordingsValidationColumnsFeedForwardTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Union[Literal["Nm", "mNm", "Ncm", "kNm", "N", "mN", "kN"], list[Literal["Nm", "mNm", "Ncm", "kNm", "N", "mN", "kN"]]]
    """One for all joints, or one for each. Default: SI."""


class RecordingsValidationColumnsTemperatureTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, a number from 1, or a list of either, one for each joint. Required."""


class RecordingsValidationColumnsMaskTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, a number from 1, or a list of either, one for each joint. Required."""


class RecordingsValidationColumnsTable(TypedDict, total=False):
    """What its columns are called. Default: those of recordings.columns."""

    time: Union[str, RecordingsValidationColumnsTimeTable]
    """Time stamps. Unit: s. Default: "t" or "time"."""
    position: Union[str, RecordingsValidationColumnsPositionTable]
    """Positions, or the motor's turns where position_side is "motor". Unit: rad (m). Default: the usual names."""
    velocity: Union[str, RecordingsValidationColumnsVelocityTable]
    """Velocities of the joints, by sensors or by the controller. Unit: rad/s (m/s). Default: the usual names, if there."""
    acceleration: Union[str, RecordingsValidationColumnsAccelerationTable]
    """Accelerations of the joints. Unit: rad/s² (m/s²). Default: the usual names, if there."""
    current: Union[str, RecordingsValidationColumnsCurrentTable]
    """Motor currents. Unit: A. Default: the usual names."""
    torque: Union[str, RecordingsValidationColumnsTorqueTable]
    """Torques, on the side of the gear that recordings.signal says. Unit: N·m (N). Default: the usual names."""
    command: Union[str, RecordingsValidationColumnsCommandTable]
    """Commanded positions, for the signal "position_command". Unit: rad (m). Default: the usual names."""
    velocity_command: Union[str, RecordingsValidationColumnsVelocityCommandTable]
    """Commanded speeds. Unit: rad/s (m/s). Default: the usual names, if there; otherwise the controller damps the speed itself."""
    feed_forward: Union[str, RecordingsValidationColumnsFeedForwardTable]
    """Torques at the joint side that the controller adds. Unit: N·m (N). Default: the usual names, if there."""
    wrench: list[str]
    """Forces along x, y, z, then moments. Unit: N, N·m. Default: fx, fy, fz, mx, my and mz."""
    temperature: Union[str, RecordingsValidationColumnsTemperatureTable]
    """Temperatures of the drives. Unit: °C. Default: the usual names, if there."""
    mask: Union[str, RecordingsValidationColumnsMaskTable]
    """Samples with 0 are left out. Default: every sample counts."""


class RecordingsValidationTable(TypedDict, total=False):
    """Keys of the table."""

    file: str
    """The file of the recording. Default: none; this or files is required."""
    files: list[Union[str, RecordingsValidationFilesTable]]
    """Files that are joined by their time stamps, on the clock of the first. Default: none; this or file is required."""
    columns: RecordingsValidationColumnsTable
    """What its columns are called. Default: those of recordings.columns."""


class RecordingsLoadedFilesColumnsTimeTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Literal["s", "ms", "us", "ns", "min"]
    """Unit of the stamps. Default: SI."""


class RecordingsLoadedFilesColumnsPositionTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Union[Literal["rad", "mrad", "deg", "rev", "m", "cm", "mm", "um", "count"], list[Literal["rad", "mrad", "deg", "rev", "m", "cm", "mm", "um", "count"]]]
    """One for all joints, or one for each. Default: SI."""
    per_turn: float
    """Counts in a turn, for the unit "count". Default: none."""


class RecordingsLoadedFilesColumnsVelocityTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Union[Literal["rad/s", "deg/s", "rev/s", "rpm", "m/s", "mm/s"], list[Literal["rad/s", "deg/s", "rev/s", "rpm", "m/s", "mm/s"]]]
    """One for all joints, or one for each. Default: SI."""


class RecordingsLoadedFilesColumnsAccelerationTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Union[Literal["rad/s^2", "deg/s^2", "rev/s^2", "m/s^2", "mm/s^2"], list[Literal["rad/s^2", "deg/s^2", "rev/s^2", "m/s^2", "mm/s^2"]]]
    """One for all joints, or one for each. Default: SI."""


class RecordingsLoadedFilesColumnsCurrentTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Union[Literal["A", "mA", "kA"], list[Literal["A", "mA", "kA"]]]
    """One for all joints, or one for each. Default: SI."""


class RecordingsLoadedFilesColumnsTorqueTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Union[Literal["Nm", "mNm", "Ncm", "kNm", "N", "mN", "kN"], list[Literal["Nm", "mNm", "Ncm", "kNm", "N", "mN", "kN"]]]
    """One for all joints, or one for each. Default: SI."""


class RecordingsLoadedFilesColumnsCommandTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Union[Literal["rad", "mrad", "deg", "rev", "m", "cm", "mm", "um", "count"], list[Literal["rad", "mrad", "deg", "rev", "m", "cm", "mm", "um", "count"]]]
    """One for all joints, or one for each. Default: SI."""
    per_turn: float
    """Counts in a turn, for the unit "count". Default: none."""


class RecordingsLoadedFilesColumnsVelocityCommandTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Union[Literal["rad/s", "deg/s", "rev/s", "rpm", "m/s", "mm/s"], list[Literal["rad/s", "deg/s", "rev/s", "rpm", "m/s", "mm/s"]]]
    """One for all joints, or one for each. Default: SI."""


class RecordingsLoadedFilesColumnsFeedForwardTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Union[Literal["Nm", "mNm", "Ncm", "kNm", "N", "mN", "kN"], list[Literal["Nm", "mNm", "Ncm", "kNm", "N", "mN", "kN"]]]
    """One for all joints, or one for each. Default: SI."""


class RecordingsLoadedFilesColumnsTemperatureTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, a number from 1, or a list of either, one for each joint. Required."""


class RecordingsLoadedFilesColumnsMaskTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, a number from 1, or a list of either, one for each joint. Required."""


class RecordingsLoadedFilesColumnsTable(TypedDict, total=False):
    """What its columns are called. Default: those of the recording."""

    time: Union[str, RecordingsLoadedFilesColumnsTimeTable]
    """Time stamps. Unit: s. Default: "t" or "time"."""
    position: Union[str, RecordingsLoadedFilesColumnsPositionTable]
    """Positions, or the motor's turns where position_side is "motor". Unit: rad (m). Default: the usual names."""
    velocity: Union[str, RecordingsLoadedFilesColumnsVelocityTable]
    """Velocities of the joints, by sensors or by the controller. Unit: rad/s (m/s). Default: the usual names, if there."""
    acceleration: Union[str, RecordingsLoadedFilesColumnsAccelerationTable]
    """Accelerations of the joints. Unit: rad/s² (m/s²). Default: the usual names, if there."""
    current: Union[str, RecordingsLoadedFilesColumnsCurrentTable]
    """Motor currents. Unit: A. Default: the usual names."""
    torque: Union[str, RecordingsLoadedFilesColumnsTorqueTable]
    """Torques, on the side of the gear that recordings.signal says. Unit: N·m (N). Default: the usual names."""
    command: Union[str, RecordingsLoadedFilesColumnsCommandTable]
    """Commanded positions, for the signal "position_command". Unit: rad (m). Default: the usual names."""
    velocity_command: Union[str, RecordingsLoadedFilesColumnsVelocityCommandTable]
    """Commanded speeds. Unit: rad/s (m/s). Default: the usual names, if there; otherwise the controller damps the speed itself."""
    feed_forward: Union[str, RecordingsLoadedFilesColumnsFeedForwardTable]
    """Torques at the joint side that the controller adds. Unit: N·m (N). Default: the usual names, if there."""
    wrench: list[str]
    """Forces along x, y, z, then moments. Unit: N, N·m. Default: fx, fy, fz, mx, my and mz."""
    temperature: Union[str, RecordingsLoadedFilesColumnsTemperatureTable]
    """Temperatures of the drives. Unit: °C. Default: the usual names, if there."""
    mask: Union[str, RecordingsLoadedFilesColumnsMaskTable]
    """Samples with 0 are left out. Default: every sample counts."""


class RecordingsLoadedFilesTable(TypedDict, total=False):
    """Keys of the table."""

    file: str
    """One of the files. Required."""
    columns: RecordingsLoadedFilesColumnsTable
    """What its columns are called. Default: those of the recording."""


class RecordingsLoadedColumnsTimeTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Literal["s", "ms", "us", "ns", "min"]
    """Unit of the stamps. Default: SI."""


class RecordingsLoadedColumnsPositionTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Union[Literal["rad", "mrad", "deg", "rev", "m", "cm", "mm", "um", "count"], list[Literal["rad", "mrad", "deg", "rev", "m", "cm", "mm", "um", "count"]]]
    """One for all joints, or one for each. Default: SI."""
    per_turn: float
    """Counts in a turn, for the unit "count". Default: none."""


class RecordingsLoadedColumnsVelocityTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Union[Literal["rad/s", "deg/s", "rev/s", "rpm", "m/s", "mm/s"], list[Literal["rad/s", "deg/s", "rev/s", "rpm", "m/s", "mm/s"]]]
    """One for all joints, or one for each. Default: SI."""


class RecordingsLoadedColumnsAccelerationTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Union[Literal["rad/s^2", "deg/s^2", "rev/s^2", "m/s^2", "mm/s^2"], list[Literal["rad/s^2", "deg/s^2", "rev/s^2", "m/s^2", "mm/s^2"]]]
    """One for all joints, or one for each. Default: SI."""


class RecordingsLoadedColumnsCurrentTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Union[Literal["A", "mA", "kA"], list[Literal["A", "mA", "kA"]]]
    """One for all joints, or one for each. Default: SI."""


class RecordingsLoadedColumnsTorqueTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Union[Literal["Nm", "mNm", "Ncm", "kNm", "N", "mN", "kN"], list[Literal["Nm", "mNm", "Ncm", "kNm", "N", "mN", "kN"]]]
    """One for all joints, or one for each. Default: SI."""


class RecordingsLoadedColumnsCommandTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Union[Literal["rad", "mrad", "deg", "rev", "m", "cm", "mm", "um", "count"], list[Literal["rad", "mrad", "deg", "rev", "m", "cm", "mm", "um", "count"]]]
    """One for all joints, or one for each. Default: SI."""
    per_turn: float
    """Counts in a turn, for the unit "count". Default: none."""


class RecordingsLoadedColumnsVelocityCommandTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Union[Literal["rad/s", "deg/s", "rev/s", "rpm", "m/s", "mm/s"], list[Literal["rad/s", "deg/s", "rev/s", "rpm", "m/s", "mm/s"]]]
    """One for all joints, or one for each. Default: SI."""


class RecordingsLoadedColumnsFeedForwardTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Union[Literal["Nm", "mNm", "Ncm", "kNm", "N", "mN", "kN"], list[Literal["Nm", "mNm", "Ncm", "kNm", "N", "mN", "kN"]]]
    """One for all joints, or one for each. Default: SI."""


class RecordingsLoadedColumnsTemperatureTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, a number from 1, or a list of either, one for each joint. Required."""


class RecordingsLoadedColumnsMaskTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, a number from 1, or a list of either, one for each joint. Required."""


class RecordingsLoadedColumnsTable(TypedDict, total=False):
    """What its columns are called. Default: those of recordings.columns."""

    time: Union[str, RecordingsLoadedColumnsTimeTable]
    """Time stamps. Unit: s. Default: "t" or "time"."""
    position: Union[str, RecordingsLoadedColumnsPositionTable]
    """Positions, or the motor's turns where position_side is "motor". Unit: rad (m). Default: the usual names."""
    velocity: Union[str, RecordingsLoadedColumnsVelocityTable]
    """Velocities of the joints, by sensors or by the controller. Unit: rad/s (m/s). Default: the usual names, if there."""
    acceleration: Union[str, RecordingsLoadedColumnsAccelerationTable]
    """Accelerations of the joints. Unit: rad/s² (m/s²). Default: the usual names, if there."""
    current: Union[str, RecordingsLoadedColumnsCurrentTable]
    """Motor currents. Unit: A. Default: the usual names."""
    torque: Union[str, RecordingsLoadedColumnsTorqueTable]
    """Torques, on the side of the gear that recordings.signal says. Unit: N·m (N). Default: the usual names."""
    command: Union[str, RecordingsLoadedColumnsCommandTable]
    """Commanded positions, for the signal "position_command". Unit: rad (m). Default: the usual names."""
    velocity_command: Union[str, RecordingsLoadedColumnsVelocityCommandTable]
    """Commanded speeds. Unit: rad/s (m/s). Default: the usual names, if there; otherwise the controller damps the speed itself."""
    feed_forward: Union[str, RecordingsLoadedColumnsFeedForwardTable]
    """Torques at the joint side that the controller adds. Unit: N·m (N). Default: the usual names, if there."""
    wrench: list[str]
    """Forces along x, y, z, then moments. Unit: N, N·m. Default: fx, fy, fz, mx, my and mz."""
    temperature: Union[str, RecordingsLoadedColumnsTemperatureTable]
    """Temperatures of the drives. Unit: °C. Default: the usual names, if there."""
    mask: Union[str, RecordingsLoadedColumnsMaskTable]
    """Samples with 0 are left out. Default: every sample counts."""


class RecordingsLoadedTable(TypedDict, total=False):
    """Keys of the table."""

    file: str
    """The file of the recording. Default: none; this or files is required."""
    files: list[Union[str, RecordingsLoadedFilesTable]]
    """Files that are joined by their time stamps, on the clock of the first. Default: none; this or file is required."""
    columns: RecordingsLoadedColumnsTable
    """What its columns are called. Default: those of recordings.columns."""


class RecordingsSimulatedFilesColumnsTimeTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Literal["s", "ms", "us", "ns", "min"]
    """Unit of the stamps. Default: SI."""


class RecordingsSimulatedFilesColumnsPositionTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Union[Literal["rad", "mrad", "deg", "rev", "m", "cm", "mm", "um", "count"], list[Literal["rad", "mrad", "deg", "rev", "m", "cm", "mm", "um", "count"]]]
    """One for all joints, or one for each. Default: SI."""
    per_turn: float
    """Counts in a turn, for the unit "count". Default: none."""


class RecordingsSimulatedFilesColumnsVelocityTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Union[Literal["rad/s", "deg/s", "rev/s", "rpm", "m/s", "mm/s"], list[Literal["rad/s", "deg/s", "rev/s", "rpm", "m/s", "mm/s"]]]
    """One for all joints, or one for each. Default: SI."""


class RecordingsSimulatedFilesColumnsAccelerationTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Union[Literal["rad/s^2", "deg/s^2", "rev/s^2", "m/s^2", "mm/s^2"], list[Literal["rad/s^2", "deg/s^2", "rev/s^2", "m/s^2", "mm/s^2"]]]
    """One for all joints, or one for each. Default: SI."""


class RecordingsSimulatedFilesColumnsCurrentTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Union[Literal["A", "mA", "kA"], list[Literal["A", "mA", "kA"]]]
    """One for all joints, or one for each. Default: SI."""


class RecordingsSimulatedFilesColumnsTorqueTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Union[Literal["Nm", "mNm", "Ncm", "kNm", "N", "mN", "kN"], list[Literal["Nm", "mNm", "Ncm", "kNm", "N", "mN", "kN"]]]
    """One for all joints, or one for each. Default: SI."""


class RecordingsSimulatedFilesColumnsCommandTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Union[Literal["rad", "mrad", "deg", "rev", "m", "cm", "mm", "um", "count"], list[Literal["rad", "mrad", "deg", "rev", "m", "cm", "mm", "um", "count"]]]
    """One for all joints, or one for each. Default: SI."""
    per_turn: float
    """Counts in a turn, for the unit "count". Default: none."""


class RecordingsSimulatedFilesColumnsVelocityCommandTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Union[Literal["rad/s", "deg/s", "rev/s", "rpm", "m/s", "mm/s"], list[Literal["rad/s", "deg/s", "rev/s", "rpm", "m/s", "mm/s"]]]
    """One for all joints, or one for each. Default: SI."""


class RecordingsSimulatedFilesColumnsFeedForwardTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Union[Literal["Nm", "mNm", "Ncm", "kNm", "N", "mN", "kN"], list[Literal["Nm", "mNm", "Ncm", "kNm", "N", "mN", "kN"]]]
    """One for all joints, or one for each. Default: SI."""


class RecordingsSimulatedFilesColumnsTemperatureTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, a number from 1, or a list of either, one for each joint. Required."""


class RecordingsSimulatedFilesColumnsMaskTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, a number from 1, or a list of either, one for each joint. Required."""


class RecordingsSimulatedFilesColumnsTable(TypedDict, total=False):
    """What its columns are called. Default: those of the recording."""

    time: Union[str, RecordingsSimulatedFilesColumnsTimeTable]
    """Time stamps. Unit: s. Default: "t" or "time"."""
    position: Union[str, RecordingsSimulatedFilesColumnsPositionTable]
    """Positions, or the motor's turns where position_side is "motor". Unit: rad (m). Default: the usual names."""
    velocity: Union[str, RecordingsSimulatedFilesColumnsVelocityTable]
    """Velocities of the joints, by sensors or by the controller. Unit: rad/s (m/s). Default: the usual names, if there."""
    acceleration: Union[str, RecordingsSimulatedFilesColumnsAccelerationTable]
    """Accelerations of the joints. Unit: rad/s² (m/s²). Default: the usual names, if there."""
    current: Union[str, RecordingsSimulatedFilesColumnsCurrentTable]
    """Motor currents. Unit: A. Default: the usual names."""
    torque: Union[str, RecordingsSimulatedFilesColumnsTorqueTable]
    """Torques, on the side of the gear that recordings.signal says. Unit: N·m (N). Default: the usual names."""
    command: Union[str, RecordingsSimulatedFilesColumnsCommandTable]
    """Commanded positions, for the signal "position_command". Unit: rad (m). Default: the usual names."""
    velocity_command: Union[str, RecordingsSimulatedFilesColumnsVelocityCommandTable]
    """Commanded speeds. Unit: rad/s (m/s). Default: the usual names, if there; otherwise the controller damps the speed itself."""
    feed_forward: Union[str, RecordingsSimulatedFilesColumnsFeedForwardTable]
    """Torques at the joint side that the controller adds. Unit: N·m (N). Default: the usual names, if there."""
    wrench: list[str]
    """Forces along x, y, z, then moments. Unit: N, N·m. Default: fx, fy, fz, mx, my and mz."""
    temperature: Union[str, RecordingsSimulatedFilesColumnsTemperatureTable]
    """Temperatures of the drives. Unit: °C. Default: the usual names, if there."""
    mask: Union[str, RecordingsSimulatedFilesColumnsMaskTable]
    """Samples with 0 are left out. Default: every sample counts."""


class RecordingsSimulatedFilesTable(TypedDict, total=False):
    """Keys of the table."""

    file: str
    """One of the files. Required."""
    columns: RecordingsSimulatedFilesColumnsTable
    """What its columns are called. Default: those of the recording."""


class RecordingsSimulatedColumnsTimeTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Literal["s", "ms", "us", "ns", "min"]
    """Unit of the stamps. Default: SI."""


class RecordingsSimulatedColumnsPositionTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Union[Literal["rad", "mrad", "deg", "rev", "m", "cm", "mm", "um", "count"], list[Literal["rad", "mrad", "deg", "rev", "m", "cm", "mm", "um", "count"]]]
    """One for all joints, or one for each. Default: SI."""
    per_turn: float
    """Counts in a turn, for the unit "count". Default: none."""


class RecordingsSimulatedColumnsVelocityTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Union[Literal["rad/s", "deg/s", "rev/s", "rpm", "m/s", "mm/s"], list[Literal["rad/s", "deg/s", "rev/s", "rpm", "m/s", "mm/s"]]]
    """One for all joints, or one for each. Default: SI."""


class RecordingsSimulatedColumnsAccelerationTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Union[Literal["rad/s^2", "deg/s^2", "rev/s^2", "m/s^2", "mm/s^2"], list[Literal["rad/s^2", "deg/s^2", "rev/s^2", "m/s^2", "mm/s^2"]]]
    """One for all joints, or one for each. Default: SI."""


class RecordingsSimulatedColumnsCurrentTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Union[Literal["A", "mA", "kA"], list[Literal["A", "mA", "kA"]]]
    """One for all joints, or one for each. Default: SI."""


class RecordingsSimulatedColumnsTorqueTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Union[Literal["Nm", "mNm", "Ncm", "kNm", "N", "mN", "kN"], list[Literal["Nm", "mNm", "Ncm", "kNm", "N", "mN", "kN"]]]
    """One for all joints, or one for each. Default: SI."""


class RecordingsSimulatedColumnsCommandTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Union[Literal["rad", "mrad", "deg", "rev", "m", "cm", "mm", "um", "count"], list[Literal["rad", "mrad", "deg", "rev", "m", "cm", "mm", "um", "count"]]]
    """One for all joints, or one for each. Default: SI."""
    per_turn: float
    """Counts in a turn, for the unit "count". Default: none."""


class RecordingsSimulatedColumnsVelocityCommandTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Union[Literal["rad/s", "deg/s", "rev/s", "rpm", "m/s", "mm/s"], list[Literal["rad/s", "deg/s", "rev/s", "rpm", "m/s", "mm/s"]]]
    """One for all joints, or one for each. Default: SI."""


class RecordingsSimulatedColumnsFeedForwardTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Union[Literal["Nm", "mNm", "Ncm", "kNm", "N", "mN", "kN"], list[Literal["Nm", "mNm", "Ncm", "kNm", "N", "mN", "kN"]]]
    """One for all joints, or one for each. Default: SI."""


class RecordingsSimulatedColumnsTemperatureTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, a number from 1, or a list of either, one for each joint. Required."""


class RecordingsSimulatedColumnsMaskTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, a number from 1, or a list of either, one for each joint. Required."""


class RecordingsSimulatedColumnsTable(TypedDict, total=False):
    """What its columns are called. Default: those of recordings.columns."""

    time: Union[str, RecordingsSimulatedColumnsTimeTable]
    """Time stamps. Unit: s. Default: "t" or "time"."""
    position: Union[str, RecordingsSimulatedColumnsPositionTable]
    """Positions, or the motor's turns where position_side is "motor". Unit: rad (m). Default: the usual names."""
    velocity: Union[str, RecordingsSimulatedColumnsVelocityTable]
    """Velocities of the joints, by sensors or by the controller. Unit: rad/s (m/s). Default: the usual names, if there."""
    acceleration: Union[str, RecordingsSimulatedColumnsAccelerationTable]
    """Accelerations of the joints. Unit: rad/s² (m/s²). Default: the usual names, if there."""
    current: Union[str, RecordingsSimulatedColumnsCurrentTable]
    """Motor currents. Unit: A. Default: the usual names."""
    torque: Union[str, RecordingsSimulatedColumnsTorqueTable]
    """Torques, on the side of the gear that recordings.signal says. Unit: N·m (N). Default: the usual names."""
    command: Union[str, RecordingsSimulatedColumnsCommandTable]
    """Commanded positions, for the signal "position_command". Unit: rad (m). Default: the usual names."""
    velocity_command: Union[str, RecordingsSimulatedColumnsVelocityCommandTable]
    """Commanded speeds. Unit: rad/s (m/s). Default: the usual names, if there; otherwise the controller damps the speed itself."""
    feed_forward: Union[str, RecordingsSimulatedColumnsFeedForwardTable]
    """Torques at the joint side that the controller adds. Unit: N·m (N). Default: the usual names, if there."""
    wrench: list[str]
    """Forces along x, y, z, then moments. Unit: N, N·m. Default: fx, fy, fz, mx, my and mz."""
    temperature: Union[str, RecordingsSimulatedColumnsTemperatureTable]
    """Temperatures of the drives. Unit: °C. Default: the usual names, if there."""
    mask: Union[str, RecordingsSimulatedColumnsMaskTable]
    """Samples with 0 are left out. Default: every sample counts."""


class RecordingsSimulatedTable(TypedDict, total=False):
    """Keys of the table."""

    file: str
    """The file of the recording. Default: none; this or files is required."""
    files: list[Union[str, RecordingsSimulatedFilesTable]]
    """Files that are joined by their time stamps, on the clock of the first. Default: none; this or file is required."""
    columns: RecordingsSimulatedColumnsTable
    """What its columns are called. Default: those of recordings.columns."""


class RecordingsColumnsTimeTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Literal["s", "ms", "us", "ns", "min"]
    """Unit of the stamps. Default: SI."""


class RecordingsColumnsPositionTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Union[Literal["rad", "mrad", "deg", "rev", "m", "cm", "mm", "um", "count"], list[Literal["rad", "mrad", "deg", "rev", "m", "cm", "mm", "um", "count"]]]
    """One for all joints, or one for each. Default: SI."""
    per_turn: float
    """Counts in a turn, for the unit "count". Default: none."""


class RecordingsColumnsVelocityTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Union[Literal["rad/s", "deg/s", "rev/s", "rpm", "m/s", "mm/s"], list[Literal["rad/s", "deg/s", "rev/s", "rpm", "m/s", "mm/s"]]]
    """One for all joints, or one for each. Default: SI."""


class RecordingsColumnsAccelerationTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Union[Literal["rad/s^2", "deg/s^2", "rev/s^2", "m/s^2", "mm/s^2"], list[Literal["rad/s^2", "deg/s^2", "rev/s^2", "m/s^2", "mm/s^2"]]]
    """One for all joints, or one for each. Default: SI."""


class RecordingsColumnsCurrentTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Union[Literal["A", "mA", "kA"], list[Literal["A", "mA", "kA"]]]
    """One for all joints, or one for each. Default: SI."""


class RecordingsColumnsTorqueTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Union[Literal["Nm", "mNm", "Ncm", "kNm", "N", "mN", "kN"], list[Literal["Nm", "mNm", "Ncm", "kNm", "N", "mN", "kN"]]]
    """One for all joints, or one for each. Default: SI."""


class RecordingsColumnsCommandTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Union[Literal["rad", "mrad", "deg", "rev", "m", "cm", "mm", "um", "count"], list[Literal["rad", "mrad", "deg", "rev", "m", "cm", "mm", "um", "count"]]]
    """One for all joints, or one for each. Default: SI."""
    per_turn: float
    """Counts in a turn, for the unit "count". Default: none."""


class RecordingsColumnsVelocityCommandTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Union[Literal["rad/s", "deg/s", "rev/s", "rpm", "m/s", "mm/s"], list[Literal["rad/s", "deg/s", "rev/s", "rpm", "m/s", "mm/s"]]]
    """One for all joints, or one for each. Default: SI."""


class RecordingsColumnsFeedForwardTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint. Required."""
    unit: Union[Literal["Nm", "mNm", "Ncm", "kNm", "N", "mN", "kN"], list[Literal["Nm", "mNm", "Ncm", "kNm", "N", "mN", "kN"]]]
    """One for all joints, or one for each. Default: SI."""


class RecordingsColumnsTemperatureTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, a number from 1, or a list of either, one for each joint. Required."""


class RecordingsColumnsMaskTable(TypedDict, total=False):
    """Keys of the table."""

    column: Union[str, int, list[str], list[int]]
    """A name, a number from 1, or a list of either, one for each joint. Required."""


class RecordingsColumnsTable(TypedDict, total=False):
    """Names of columns, in which {joint} stands for the joint's name and {n} for its number from 1, or tables with column and unit. Default: the usual names."""

    time: Union[str, RecordingsColumnsTimeTable]
    """Time stamps. Unit: s. Default: "t" or "time"."""
    position: Union[str, RecordingsColumnsPositionTable]
    """Positions, or the motor's turns where position_side is "motor". Unit: rad (m). Default: the usual names."""
    velocity: Union[str, RecordingsColumnsVelocityTable]
    """Velocities of the joints, by sensors or by the controller. Unit: rad/s (m/s). Default: the usual names, if there."""
    acceleration: Union[str, RecordingsColumnsAccelerationTable]
    """Accelerations of the joints. Unit: rad/s² (m/s²). Default: the usual names, if there."""
    current: Union[str, RecordingsColumnsCurrentTable]
    """Motor currents. Unit: A. Default: the usual names."""
    torque: Union[str, RecordingsColumnsTorqueTable]
    """Torques, on the side of the gear that recordings.signal says. Unit: N·m (N). Default: the usual names."""
    command: Union[str, RecordingsColumnsCommandTable]
    """Commanded positions, for the signal "position_command". Unit: rad (m). Default: the usual names."""
    velocity_command: Union[str, RecordingsColumnsVelocityCommandTable]
    """Commanded speeds. Unit: rad/s (m/s). Default: the usual names, if there; otherwise the controller damps the speed itself."""
    feed_forward: Union[str, RecordingsColumnsFeedForwardTable]
    """Torques at the joint side that the controller adds. Unit: N·m (N). Default: the usual names, if there."""
    wrench: list[str]
    """Forces along x, y, z, then moments. Unit: N, N·m. Default: fx, fy, fz, mx, my and mz."""
    temperature: Union[str, RecordingsColumnsTemperatureTable]
    """Temperatures of the drives. Unit: °C. Default: the usual names, if there."""
    mask: Union[str, RecordingsColumnsMaskTable]
    """Samples with 0 are left out. Default: every sample counts."""


class RecordingsDifferentiationTable(TypedDict, total=False):
    """How positions give velocities and accelerations. Default: the keys' own defaults."""

    method: Literal["fourier", "smoother", "lowpass"]
    """Fourier series of a periodic motion; a fixed-interval smoother; or a zero-phase Butterworth low-pass of fourth order. Default: "fourier" where the motion repeats, else "smoother"."""
    cutoff_hz: float
    """Cut-off frequency of the motion. Unit: Hz. Default: chosen from the data."""
    parallel_hz: float
    """Cut-off of a low-pass on the signal and on every column of the model alike. Unit: Hz. Default: none."""


class RecordingsPlatformTable(TypedDict, total=False):
    """The sensor of a base wrench. Default: it reads in the base frame."""

    translation: list[float]
    """Origin of the sensor's frame in the base frame. Unit: m. Default: [0.0, 0.0, 0.0]."""
    rotation: list[float]
    """Roll, pitch and yaw of the sensor's axes in the base frame. Unit: rad. Default: [0.0, 0.0, 0.0]."""
    accuracy: float
    """Standard deviation of a sample as share of its channel's root mean square: weights of ordinary least squares. Default: none."""
    tare: bool
    """What the platform reads without the robot is not known: six more unknowns. Default: false."""


class RecordingsSensorsTable(TypedDict, total=False):
    """Keys of the table."""

    position: str
    """Column of a position, differentiated twice. Unit: rad (m). Default: one of position, acceleration and force is required."""
    acceleration: str
    """Column of an acceleration. Unit: rad/s² (m/s²). Default: one of position, acceleration and force is required."""
    force: str
    """Column of what the surroundings exert on the joint's link along the joint. Unit: N·m (N). Default: one of position, acceleration and force is required."""


class RecordingsTable(TypedDict, total=False):
    """The files, what they hold, and how positions give velocities and accelerations. Default: nothing is read."""

    train: list[Union[str, RecordingsTrainTable]]
    """Recordings that are fitted. Default: required, unless there are loaded ones."""
    validation: list[Union[str, RecordingsValidationTable]]
    """Recordings that are held out; without them held-out figures are null. Default: []."""
    loaded: list[Union[str, RecordingsLoadedTable]]
    """Recordings that are fitted with the load on; the others are then without it. Needs robot.payload; where none is listed, every recording carries the load. Default: []."""
    simulated: list[Union[str, RecordingsSimulatedTable]]
    """Recordings of a simulator of the robot, of the same or other motions, with time stamps: it is identified first, and what differs from the robot is reported. Default: []."""
    signal: Literal["current", "torque", "motor_torque", "link_torque", "base_wrench", "both", "position_command"]
    """What the recordings hold: motor currents, motor torques at the joint side or at the motor side, torques of sensors behind the gears, the force and moment under the base, torques and those, or what a position controller is told, from whose error and gains the torque follows. Default: "current"."""
    position_side: Literal["joint", "motor", "link"]
    """Where the encoder sits: on the motor in joint units, on the motor in its own turns, or behind the gear. Default: "joint"."""
    rate: float
    """Samples per second. Unit: Hz. Default: from the time stamps."""
    period: float
    """The motion repeats after this time; recordings are averaged over periods of a whole number of samples, and take their noise from others. Unit: s. Default: found in the motion, where it repeats."""
    columns: RecordingsColumnsTable
    """Names of columns, in which {joint} stands for the joint's name and {n} for its number from 1, or tables with column and unit. Default: the usual names."""
    differentiation: RecordingsDifferentiationTable
    """How positions give velocities and accelerations. Default: the keys' own defaults."""
    platform: RecordingsPlatformTable
    """The sensor of a base wrench. Default: it reads in the base frame."""
    sensors: dict[str, RecordingsSensorsTable]
    """What is measured at a joint without a motor: one of these. Default: their motion follows from the motors."""
    positions: dict[str, str]
    """Files with the positions of a sensor of its own, by recording, with time stamps of the same clock. Default: positions are in the recordings."""
    max_rows: int
    """Rows of a file beyond which it is refused. Default: ten million."""


class ControllerKpTable(TypedDict, total=False):
    """Keys of the table."""

    value: float
    """The gain expected. Unit: the gain's own. Required."""
    std_dev: float
    """How far to trust it: its standard deviation. Unit: the gain's own. Required."""


class ControllerKdTable(TypedDict, total=False):
    """Keys of the table."""

    value: float
    """The gain expected. Unit: the gain's own. Required."""
    std_dev: float
    """How far to trust it: its standard deviation. Unit: the gain's own. Required."""


class ControllerTable(TypedDict, total=False):
    """The position controllers, where recordings.signal is "position_command": torque = kp·(command − position) + kd·(velocity_command − velocity) + feed_forward. Default: the keys' own defaults."""

    kp: Union[float, Literal["estimate"], ControllerKpTable, list[Union[float, Literal["estimate"], ControllerKpTable]]]
    """Proportional gains at the joint side, one for all joints or one for each: known, known up to a standard deviation, or estimated. Unit: N·m/rad (N/m). Default: the robot file's, or else "estimate"."""
    kd: Union[float, Literal["estimate"], ControllerKdTable, list[Union[float, Literal["estimate"], ControllerKdTable]]]
    """Derivative gains, in the same forms. Unit: N·m·s/rad (N·s/m). Default: the robot file's, or else "estimate"."""


class FitPriorValuesTable(TypedDict, total=False):
    """Keys of the table."""

    value: float
    """Value expected. Unit: the parameter's own. Required."""
    std_dev: float
    """How far to trust it: its standard deviation. Unit: the parameter's own. Required."""


class FitPriorTable(TypedDict, total=False):
    """What is known before the data. Default: none."""

    kind: Literal["euclidean", "entropic", "pullback", "lasso"]
    """Distance from the robot file's bodies that a feasible estimate penalises, or the absolute values of all linear parameters ("lasso"). Default: no prior on the inertials."""
    strength: Union[Literal["held_out", "noise"], float]
    """How far the prior is trusted: by held-out error, by the noise, or a factor of the distance. Default: "held_out"."""
    values: dict[str, FitPriorValuesTable]
    """Single parameters by name, for any estimator. Default: none."""


class FitCompareTable(TypedDict, total=False):
    """Keys of the table."""

    name: str
    """Name of the comparison. Required."""
    effects: list[Union[Literal["coulomb_friction", "viscous_friction", "asymmetric_friction", "stribeck_friction", "viscous_nonlinearity", "sigmoid_friction", "presliding_hysteresis", "position_dependent_friction", "transmission_efficiency", "load_dependent_friction", "torque_current_nonlinearity", "drive_gain", "torque_offset", "rotor_inertia", "kinematic_coupling", "joint_elasticity", "backlash", "torque_ripple", "joint_spring", "unmodelled_payload", "base_tilt", "encoder_offset", "time_delay", "channel_crosstalk", "thermal_drift", "external_contact"], str]]
    """What replaces drive.effects. Required."""


class FitConstantVelocityTable(TypedDict, total=False):
    """For the estimator constant_velocity. Default: the keys' own defaults."""

    least_speed: float
    """A slower joint stands. Unit: rad/s (m/s). Default: 0.02."""
    torque_constant: dict[str, float]
    """Torque constants at the joint side that are known. Unit: N·m/A. Default: none."""
    same_type: list[list[str]]
    """Lists of joints with motors of one type. Default: none."""


class FitTable(TypedDict, total=False):
    """The estimator, what is known before the data, and fits to compare with. Default: the keys' own defaults."""

    estimator: Literal["ols", "wls", "irls", "maximum_likelihood", "feasible", "feasible_maximum_likelihood", "constant_velocity"]
    """How parameters follow from recordings: ordinary, weighted or robust least squares, maximum likelihood, these over bodies that can exist, or motor constants from constant speed. Default: "maximum_likelihood"."""
    feasible_by: Literal["cones", "log_cholesky"]
    """How a feasible estimate keeps bodies possible. Default: "cones"."""
    load: Literal["together", "difference"]
    """How the load follows from recordings with it and without it: one estimate of all, or the difference of two fits of the link that carries it. Default: "together"."""
    motion: Literal["exact", "noisy"]
    """Whether joint angles are noisy, so that the motion is estimated beside the parameters; for maximum_likelihood. Default: "exact"."""
    prior: FitPriorTable
    """What is known before the data. Default: none."""
    bounds: dict[str, list[Any]]
    """Lower and upper bound of parameters by name, and of total_mass, the sum of all masses in kg. Unit: each parameter's own. Default: none."""
    compare: list[FitCompareTable]
    """The same fit with other effects, side by side in the result. Default: none."""
    constant_velocity: FitConstantVelocityTable
    """For the estimator constant_velocity. Default: the keys' own defaults."""


class DesignRivalTable(TypedDict, total=False):
    """Keys of the table."""

    name: str
    """Name of the rival. Required."""
    effects: list[Union[Literal["coulomb_friction", "viscous_friction", "asymmetric_friction", "stribeck_friction", "viscous_nonlinearity", "sigmoid_friction", "presliding_hysteresis", "position_dependent_friction", "transmission_efficiency", "load_dependent_friction", "torque_current_nonlinearity", "drive_gain", "torque_offset", "rotor_inertia", "kinematic_coupling", "joint_elasticity", "backlash", "torque_ripple", "joint_spring", "unmodelled_payload", "base_tilt", "encoder_offset", "time_delay", "channel_crosstalk", "thermal_drift", "external_contact"], str]]
    """What replaces drive.effects. Default: the problem file's."""
    effects_of: dict[str, list[Union[Literal["coulomb_friction", "viscous_friction", "asymmetric_friction", "stribeck_friction", "viscous_nonlinearity", "sigmoid_friction", "presliding_hysteresis", "position_dependent_friction", "transmission_efficiency", "load_dependent_friction", "torque_current_nonlinearity", "drive_gain", "torque_offset", "rotor_inertia", "kinematic_coupling", "joint_elasticity", "backlash", "torque_ripple", "joint_spring", "unmodelled_payload", "base_tilt", "encoder_offset", "time_delay", "channel_crosstalk", "thermal_drift", "external_contact"], str]]]
    """What replaces the effects of single joints. Default: none."""
    parameters: str
    """Result of a fit of this model: its values. Default: the problem file's values."""
    values: dict[str, float]
    """Values of single parameters. Unit: each parameter's own. Default: none."""


class DesignLimitsTable(TypedDict, total=False):
    """Limits of the joints. Default: those of the robot file."""

    position_lower: Union[float, list[float]]
    """Lowest position. Unit: rad (m). Default: the robot file's."""
    position_upper: Union[float, list[float]]
    """Highest position. Unit: rad (m). Default: the robot file's."""
    velocity: Union[float, list[float]]
    """Largest speed. Unit: rad/s (m/s). Default: the robot file's."""
    acceleration: Union[float, list[float]]
    """Largest acceleration. Unit: rad/s² (m/s²). Default: none."""
    jerk: Union[float, list[float]]
    """Largest jerk. Unit: rad/s³ (m/s³). Default: none."""
    torque: Union[float, list[float]]
    """Largest torque. Unit: N·m (N). Default: the robot file's."""


class DesignWorkspaceHalfspaceTable(TypedDict, total=False):
    """Keys of the table."""

    frame: str
    """Link or frame of the robot file. Required."""
    normal: list[float]
    """Normal of the plane, into the space that is allowed. Required."""
    offset: float
    """Distance of the plane from the base, along a normal of unit length. Unit: m. Required."""


class DesignWorkspaceBoxTable(TypedDict, total=False):
    """Keys of the table."""

    frame: str
    """Link or frame of the robot file. Required."""
    lower: list[Any]
    """Lowest x, y and z; -inf where there is no limit. Unit: m. Required."""
    upper: list[Any]
    """Highest x, y and z; inf where there is no limit. Unit: m. Required."""


class DesignWorkspaceSpeedTable(TypedDict, total=False):
    """Keys of the table."""

    frame: str
    """Link or frame of the robot file. Required."""
    limit: float
    """Largest speed of its origin in the base frame. Unit: m/s. Required."""


class DesignWorkspaceClearanceTable(TypedDict, total=False):
    """Keys of the table."""

    links: list[str]
    """The two links. Required."""
    distance: float
    """Least distance between their shapes. Unit: m. Required."""


class DesignWorkspaceShapeTable(TypedDict, total=False):
    """Keys of the table."""

    link: str
    """Link of the robot file, or its base. Required."""
    ends: list[list[float]]
    """The centre of a sphere, or both ends of a capsule, in the frame of the link. Unit: m. Required."""
    radius: float
    """Radius of the capsule. Unit: m. Required."""


class DesignWorkspaceTable(TypedDict, total=False):
    """Limits in space. Default: none."""

    halfspace: list[DesignWorkspaceHalfspaceTable]
    """normal·p >= offset for the origin p of a link or frame, in the base frame. Default: none."""
    box: list[DesignWorkspaceBoxTable]
    """lower <= p <= upper for the origin p of a link or frame, in the base frame. Default: none."""
    speed: list[DesignWorkspaceSpeedTable]
    """Largest speed of the origin of a link or frame. Default: none."""
    clearance: list[DesignWorkspaceClearanceTable]
    """Least distance between the collision shapes of two links. Default: none."""
    shape: list[DesignWorkspaceShapeTable]
    """A sphere or capsule on a link, beside the shapes of the robot file. Default: those of the robot file."""


class DesignTable(TypedDict, total=False):
    """The motions among which an excitation is sought, what makes one good, and its limits. Default: the keys' own defaults."""

    kind: Literal["fourier", "constant_velocity"]
    """Family of motions: Fourier series, or strokes at constant velocity. Default: "fourier"."""
    harmonics: Union[int, list[int]]
    """Harmonics of the series, of all joints or of each. Default: 5."""
    period: float
    """Period of the motion. Unit: s. Default: 10.0."""
    criterion: Literal["condition", "d_optimal", "a_optimal", "e_optimal", "discriminate"]
    """What makes a motion good: condition number, determinant, trace or least eigenvalue of the information, or the distance between rival models. Default: "d_optimal"."""
    scaling: Literal["columns", "none", "whitened"]
    """How the regressor is scaled before the criterion: columns by their norms, rows by the noise, or not. Default: "columns"."""
    parameters: Union[Literal["all", "inertial", "payload", "friction"], list[str]]
    """Parameters whose accuracy counts; the rest are nuisance parameters. Default: "all"."""
    samples: int
    """Samples per period of the criterion and of the constraints while optimising. Default: 200."""
    noise: Union[float, list[float]]
    """Standard deviation of the signal. Unit: the signal's. Default: none."""
    rest_to_rest: bool
    """Start and stop at rest. Default: true."""
    trajectories: int
    """Motions designed together. Default: 1."""
    budget_s: float
    """Time for the search, after which the best motion is taken. Unit: s. Default: none."""
    starts: int
    """Starts of the search, which make the run repeatable to the bit. Default: none."""
    start_from: str
    """Coefficients or result of an earlier design to go on from. Default: none."""
    reference: str
    """Coefficients or result of a motion to compare with. Default: none."""
    rest_position: Union[float, list[float]]
    """Where the ramps of a motion begin and end. Unit: rad (m). Default: the middle of the ranges."""
    speeds: int
    """Speeds of each joint in a plan of constant velocities. Default: 8."""
    rival: list[DesignRivalTable]
    """A model that the motion is to tell from the others. Default: none."""
    values: dict[str, float]
    """Values with which torques are predicted. Unit: each parameter's own. Default: those of the robot file or of an earlier fit."""
    limits: DesignLimitsTable
    """Limits of the joints. Default: those of the robot file."""
    workspace: DesignWorkspaceTable
    """Limits in space. Default: none."""


class SimulateTable(TypedDict, total=False):
    """The trajectory, how it is recorded, and the truth behind it. Default: the keys' own defaults."""

    trajectory: str
    """"random", a feasible Fourier series; "tones", "moves" or "sweeps", which do not repeat; or a file with columns t, q_<joint>, dq_<joint>, ddq_<joint>. Default: "random"."""
    mode: Literal["inverse", "closed_loop"]
    """The motion is the trajectory and the signal what it takes, or forward dynamics under a PD controller with feed-forward. Default: "inverse"."""
    periods: int
    """Periods that are recorded. Default: 6."""
    warmup_periods: int
    """Periods before the recording. Default: 1."""
    rate: float
    """Samples per second. Unit: Hz. Default: recordings.rate."""
    noise: Union[float, list[float]]
    """Standard deviation of the signal. Unit: the signal's. Default: none."""
    noise_correlation: float
    """Correlation of the noise of neighbouring samples. Default: 0.0."""
    encoder_counts: Union[float, list[float]]
    """Counts of the encoders. Unit: 1 per turn (1/m). Default: no quantisation."""
    values: dict[str, float]
    """The truth: values of parameters by name. Unit: each parameter's own. Default: what the robot file has."""


class DiagnoseTable(TypedDict, total=False):
    """The physics to look for, and how sure a finding has to be. Default: the keys' own defaults."""

    effects: Union[Literal["all"], list[Union[Literal["coulomb_friction", "viscous_friction", "asymmetric_friction", "stribeck_friction", "viscous_nonlinearity", "sigmoid_friction", "presliding_hysteresis", "position_dependent_friction", "transmission_efficiency", "load_dependent_friction", "torque_current_nonlinearity", "drive_gain", "torque_offset", "rotor_inertia", "kinematic_coupling", "joint_elasticity", "backlash", "torque_ripple", "joint_spring", "unmodelled_payload", "base_tilt", "encoder_offset", "time_delay", "channel_crosstalk", "thermal_drift", "external_contact"], str]]]
    """The physics to look for. Default: "all"."""
    significance: float
    """Probability of a false finding, after correction for the number of hypotheses tried. Default: 0.001."""
