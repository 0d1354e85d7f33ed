//! Bags of ROS 1 and ROS 2: the joint states of one topic as a table, whatever the container.
//!
//! A message of type sensor_msgs/JointState gives one row. Columns: `t`, seconds since the first
//! row by the stamp of the messages (by the time of recording where no message is stamped); `log_t`,
//! by the time of recording; `position_<joint>`, `velocity_<joint>` and `effort_<joint>` where they
//! hold numbers. Where several topics carry joint states, every name is `<topic>:` and these.

mod collect;
mod joint_state;
pub mod mcap;
pub mod ros1;
pub mod sqlite;
