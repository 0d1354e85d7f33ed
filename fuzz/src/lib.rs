//! What has to hold of whatever a reader accepts, and of whatever it refuses.

pub mod description;
pub mod recording;
pub mod robot;

pub use description::describes_itself;
pub use robot::is_sound;
