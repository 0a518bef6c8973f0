//! The messages of ROS 2 that the peer sends and receives, in the order of their definitions' fields.

#![expect(clippy::struct_field_names, reason = "the names are those of the definitions")]

use std::time::{SystemTime, UNIX_EPOCH};

use ros2_client::Message;
use serde::{Deserialize, Serialize};

/// Declares messages.
macro_rules! messages {
    ($($(#[$doc:meta])* $name:ident { $($field:ident: $kind:ty),* $(,)? })*) => {$(
        $(#[$doc])*
        #[derive(Clone, Debug, Default, Serialize, Deserialize)]
        pub struct $name { $(pub $field: $kind),* }
        impl Message for $name {}
    )*};
}

messages! {
    /// `builtin_interfaces/Time`.
    Time { sec: i32, nanosec: u32 }
    /// `builtin_interfaces/Duration`.
    Duration { sec: i32, nanosec: u32 }
    /// `std_msgs/Header`.
    Header { stamp: Time, frame_id: String }
    /// `std_msgs/Bool`.
    Bool { data: bool }
    /// `std_msgs/Int32`.
    Int32 { data: i32 }
    /// `std_msgs/Empty`; DDS knows no type without a member.
    Empty { structure_needs_at_least_one_member: u8 }
    /// `sensor_msgs/JointState`.
    JointState { header: Header, name: Vec<String>, position: Vec<f64>, velocity: Vec<f64>, effort: Vec<f64> }
    /// `sensor_msgs/Image`.
    Image {
        header: Header, height: u32, width: u32, encoding: String, is_bigendian: u8, step: u32, data: Vec<u8>,
    }
    /// `sensor_msgs/RegionOfInterest`.
    RegionOfInterest { x_offset: u32, y_offset: u32, height: u32, width: u32, do_rectify: bool }
    /// `sensor_msgs/CameraInfo`.
    CameraInfo {
        header: Header, height: u32, width: u32, distortion_model: String, d: Vec<f64>, k: [f64; 9], r: [f64; 9],
        p: [f64; 12], binning_x: u32, binning_y: u32, roi: RegionOfInterest,
    }
    /// `diagnostic_msgs/KeyValue`.
    KeyValue { key: String, value: String }
    /// `diagnostic_msgs/DiagnosticStatus`.
    DiagnosticStatus {
        level: u8, name: String, message: String, hardware_id: String, values: Vec<KeyValue>,
    }
    /// `diagnostic_msgs/DiagnosticArray`.
    DiagnosticArray { header: Header, status: Vec<DiagnosticStatus> }
    /// `trajectory_msgs/JointTrajectoryPoint`.
    JointTrajectoryPoint {
        positions: Vec<f64>, velocities: Vec<f64>, accelerations: Vec<f64>, effort: Vec<f64>,
        time_from_start: Duration,
    }
    /// `trajectory_msgs/JointTrajectory`.
    JointTrajectory { header: Header, joint_names: Vec<String>, points: Vec<JointTrajectoryPoint> }
    /// `trajectory_msgs/MultiDOFJointTrajectoryPoint`; transforms are translation and quaternion.
    MultiDofPoint {
        transforms: Vec<[f64; 7]>, velocities: Vec<[f64; 6]>, accelerations: Vec<[f64; 6]>,
        time_from_start: Duration,
    }
    /// `trajectory_msgs/MultiDOFJointTrajectory`.
    MultiDofTrajectory { header: Header, joint_names: Vec<String>, points: Vec<MultiDofPoint> }
    /// `control_msgs/JointTolerance`.
    JointTolerance { name: String, position: f64, velocity: f64, acceleration: f64 }
    /// `control_msgs/JointComponentTolerance`.
    ComponentTolerance { joint_name: String, component: u16, position: f64, velocity: f64, acceleration: f64 }
    /// The goal of `control_msgs/FollowJointTrajectory`.
    Goal {
        trajectory: JointTrajectory, multi_dof_trajectory: MultiDofTrajectory, path_tolerance: Vec<JointTolerance>,
        component_path_tolerance: Vec<ComponentTolerance>, goal_tolerance: Vec<JointTolerance>,
        component_goal_tolerance: Vec<ComponentTolerance>, goal_time_tolerance: Duration,
    }
    /// Its result.
    Outcome { error_code: i32, error_string: String }
    /// Its feedback.
    Feedback {
        header: Header, joint_names: Vec<String>, desired: JointTrajectoryPoint, actual: JointTrajectoryPoint,
        error: JointTrajectoryPoint, multi_dof_joint_names: Vec<String>, multi_dof_desired: MultiDofPoint,
        multi_dof_actual: MultiDofPoint, multi_dof_error: MultiDofPoint,
    }
}

impl Header {
    /// A header with the time of now.
    pub fn now(frame_id: &str) -> Self {
        let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        let sec = i32::try_from(since.as_secs()).unwrap_or(i32::MAX);
        Self { stamp: Time { sec, nanosec: since.subsec_nanos() }, frame_id: frame_id.to_owned() }
    }
}
