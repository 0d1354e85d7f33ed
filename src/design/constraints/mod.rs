//! Constraints of a motion: limits of joints, torques and closed loops, half-spaces, speeds and clearances in the workspace.

pub mod collision_shapes;
pub mod joint_limits;
pub mod loop_limits;
pub mod torque_limits;
pub mod workspace;
