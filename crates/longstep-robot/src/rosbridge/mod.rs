//! The protocol of rosbridge: JSON over a WebSocket, between Longstep and a bridge to ROS 2.
//!
//! A [`Connection`] sends and reads messages, and nothing in it waits but its opening. Everything that is read has a bound.
//! [`crate::ros2`] moves robots over it; a server publishes what its robots do.

mod address;
mod connection;
pub(crate) mod message;

pub use address::Address;
pub use connection::{Connection, Lost, Read, wait_for};
pub use message::{GoalStatus, Incoming, advertise, advertise_service, publish, read, respond, subscribe};
