//! chain/effect
